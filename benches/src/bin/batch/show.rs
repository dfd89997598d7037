//! The table of queries and times.

use anyhow::Result;
use dcd_benches::{Cell, Column, Header, Report, Table};
use dcd_parry::Until;

use crate::Case;
use crate::setting::{LINKS, Outcome};

/// What a reader of the table must know.
const NOTES: [&str; 3] = [
    "Yes or no, the two interleaved in one process; the median of the rounds with the least and the most. \
     Shapes, the obstacles' trees and Parry's poses are made outside of the timer; ours takes the \
     poses as the caller has them.",
    "Parry: `parry3d` in f32, its tree over the obstacles queried with each link's AABB, its GJK called \
     directly for each pair. In first-hit mode it stops at the first hit of a configuration.",
    "A hit that only one of us reports is judged by exact integers; `wrong` counts against that. Of \
     first hits it is whether a configuration has one.",
];

pub(crate) fn report(
    header: Header,
    configurations: usize,
    outcomes: &[(Case, Outcome)],
) -> Result<Report> {
    let mut report = Report::new("batch", "One against many, beside Parry", header);
    report.note(format!(
        "{configurations} configurations of {LINKS} of the paper's hulls, each half a metre from the \
         one before, against obstacles of the same kind, uniform in a cube."
    ));
    let columns = [
        Column::new("obstacles"),
        Column::new("half-width").unit("m").decimals(1),
        Column::new("query"),
        Column::new("threads"),
        Column::new("hits"),
        Column::new("ours").unit("ns a link").decimals(1),
        Column::new("Parry f32").unit("ns a link").decimals(1),
        Column::new("ratio").unit("×").decimals(1),
        Column::new("least").unit("×").decimals(1),
        Column::new("most").unit("×").decimals(1),
        Column::new("ours wrong"),
        Column::new("Parry f32 wrong"),
    ];
    let mut table = Table::new("rooms", "Times, and Parry's by ours", columns);
    // Of wrong answers no time is shown.
    for (case, outcome) in outcomes.iter().filter(|(_, outcome)| outcome.ours_wrong == 0) {
        let links = (configurations * LINKS) as f64;
        let each = |time: std::time::Duration| Cell::from(time.as_secs_f64() * 1e9 / links);
        let question = if case.until == Until::First { "first hit" } else { "all hits" };
        let pair = &outcome.pair;
        table.push([
            case.size.obstacles.into(),
            case.size.half_width.into(),
            question.into(),
            case.threads.into(),
            outcome.hits.into(),
            each(pair.a.median),
            each(pair.b.median),
            pair.ratio.into(),
            pair.least.into(),
            pair.most.into(),
            outcome.ours_wrong.into(),
            outcome.parry_wrong.into(),
        ])?;
    }
    report.table(table);
    NOTES.into_iter().for_each(|note| report.note(note));
    Ok(report)
}
