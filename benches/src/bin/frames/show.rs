//! The table of the walks.

use anyhow::Result;
use dcd_benches::{Cell, Column, Header, Report, Table};

use crate::course::{FRAMES, Outcome};

/// What a reader of the table must know.
const NOTES: [&str; 4] = [
    "One thread; whole steps, interleaved in one process; a course is 60 frames. σ is the standard deviation \
     of a step along (metres) and about (rad) each axis; objects are about a metre. The pile has fallen for \
     three seconds and is coming to rest. \"Default\": the pipeline that remembers nothing. \"Remembers\": \
     `Coherent`; \"first\" is its first frame, \"later\" the median of those from the third on. Both means are \
     over all 60 frames, the first included: below 100 % it pays to remember.",
    "The first frame of the one that remembers also makes and fills its memory, and looks for proofs \
     that last. Where most objects move too far in a frame, new proofs would not last until they have paid for \
     themselves: nothing more is kept then, and nothing is looked up (\"remembered\" is 0) once too little \
     would be found.",
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
        Column::new("σ"),
        Column::new("default, mean").unit("ms").decimals(2),
        Column::new("remembers, mean").unit("ms").decimals(2),
        Column::new("of default").unit("%").decimals(0),
        Column::new("first").unit("ms").decimals(2),
        Column::new("later").unit("ms").decimals(2),
        Column::new("remembered, second").unit("%").decimals(1),
        Column::new("remembered, last").unit("%").decimals(1),
        Column::new("Parry refit").unit("ms").decimals(1),
        Column::new("Parry by default").unit("×").decimals(1),
        Column::new("Parry differs"),
    ];
    let mut table = Table::new("walks", "Whole steps", columns);
    for outcome in outcomes {
        let ms = |time: std::time::Duration| time.as_secs_f64() * 1e3;
        let mean = |time| ms(time) / FRAMES as f64;
        let [plain, coherent] = [outcome.plain, outcome.coherent].map(mean);
        let [first, later, parry] = [outcome.first, outcome.later, outcome.parry_second].map(ms);
        let sigma = outcome.sigma.map_or("pile".to_owned(), |sigma| format!("{sigma:.4}"));
        table.push([
            Cell::from(outcome.scene.as_str()),
            outcome.objects.into(),
            sigma.as_str().into(),
            plain.into(),
            coherent.into(),
            (100.0 * coherent / plain).into(),
            first.into(),
            later.into(),
            (100.0 * outcome.remembered[0]).into(),
            (100.0 * outcome.remembered[1]).into(),
            parry.into(),
            (parry / plain).into(),
            outcome.parry_differs.into(),
        ])?;
    }
    report.table(table);
    NOTES.into_iter().for_each(|note| report.note(note));
    Ok(report)
}
