//! The table of the walks.

use anyhow::Result;
use dcd_benches::{Cell, Column, Header, Report, Table};

use crate::course::Outcome;

/// What a reader of the table must know.
const NOTES: [&str; 4] = [
    "One thread; whole steps, interleaved in one process. σ is the standard deviation of a step along \
     (metres) and about (rad) each axis; objects are about a metre. \"Default\": the pipeline that \
     remembers nothing, the median of all frames but the first. \"First\", \"second\", \"later\": \
     the pipeline that remembers (`Coherent`), the medians of its first frame, of its second, of \
     those from the third on.",
    "The first frame of the one that remembers also makes and fills its memory, and looks for proofs \
     that last. Where most objects move by more than 1/40 of their radius in a frame (1/128 in sparse \
     scenes), new proofs would not last until they have paid for themselves: nothing more is kept \
     then, and nothing is looked up (\"remembered\" is 0) once too little would be found, which in \
     sparse scenes is at once.",
    "Parry: `parry3d` in f32, its tree refitted and improved (`refit`, `optimize_incremental`), its \
     GJK called directly for each pair, the second frame.",
    "The contacts of both of ours are equal in every frame, order included. \"Parry differs\": \
     contacts of the first three frames that are only ours or only Parry's.",
];

pub(crate) fn report(header: Header, outcomes: &[Outcome]) -> Result<Report> {
    let mut report = Report::new("frames", "Frames that barely differ", header);
    let columns = [
        Column::new("scene"),
        Column::new("objects"),
        Column::new("σ").decimals(4),
        Column::new("default").unit("ms").decimals(2),
        Column::new("first").unit("ms").decimals(2),
        Column::new("second").unit("ms").decimals(2),
        Column::new("later").unit("ms").decimals(2),
        Column::new("second of default").unit("%").decimals(0),
        Column::new("second of first").unit("%").decimals(0),
        Column::new("remembered, second").unit("%").decimals(1),
        Column::new("remembered, last").unit("%").decimals(1),
        Column::new("Parry refit").unit("ms").decimals(1),
        Column::new("Parry by second").unit("×").decimals(1),
        Column::new("Parry differs"),
    ];
    let mut table = Table::new("walks", "Whole steps", columns);
    for outcome in outcomes {
        let ms = |time: std::time::Duration| time.as_secs_f64() * 1e3;
        let [plain, first, second, later, parry] =
            [outcome.plain, outcome.first, outcome.second, outcome.later, outcome.parry_second]
                .map(ms);
        table.push([
            Cell::from(outcome.scene.as_str()),
            outcome.objects.into(),
            outcome.sigma.into(),
            plain.into(),
            first.into(),
            second.into(),
            later.into(),
            (100.0 * second / plain).into(),
            (100.0 * second / first).into(),
            (100.0 * outcome.remembered[0]).into(),
            (100.0 * outcome.remembered[1]).into(),
            parry.into(),
            (parry / second).into(),
            outcome.parry_differs.into(),
        ])?;
    }
    report.table(table);
    NOTES.into_iter().for_each(|note| report.note(note));
    Ok(report)
}
