//! Tables of the queries.

use anyhow::Result;
use dcd_benches::{Cell, Column, Header, Report, Table};

use crate::contest::Outcome;

/// What a reader of the tables must know.
const NOTES: [&str; 3] = [
    "One thread, interleaved in one process; the median of the rounds' ratios with the least and the most. \
     Trees, shapes and poses are made outside of the timer.",
    "`differs` counts answers of Parry's outside of our bracket by more than 1e-4 of the time or distance. `wrong` \
     counts hits of Parry's in f64 sooner than ours that a point of the ray inside of the shape confirms.",
    "A shape cast and a time of impact end within 1e-6 of the pair's size here, at Parry's own tolerance there.",
];

pub(crate) fn report(header: Header, outcome: &Outcome) -> Result<Report> {
    let mut report = Report::new("rays", "Rays and moving shapes beside Parry's", header);
    report.note(format!(
        "{} hulls of the paper's scene; a mesh of {} triangles.",
        outcome.objects, outcome.triangles
    ));
    let columns = ["question", "queries", "met", "wrong", "f32 differs", "f64 differs"];
    let mut answers = Table::new("ray-answers", "Answers", columns.map(Column::new));
    for row in &outcome.rows {
        let counts = [row.count, row.met, row.wrong, row.differs[0], row.differs[1]];
        answers
            .push([Cell::from(row.question.as_str())].into_iter().chain(counts.map(Cell::from)))?;
    }
    report.table(answers);
    let columns = ["question", "rival"].map(Column::new).into_iter().chain([
        Column::new("ours").unit("µs each").decimals(3),
        Column::new("rival").unit("µs each").decimals(3),
        Column::new("ratio").unit("×").decimals(2),
        Column::new("least").unit("×").decimals(2),
        Column::new("most").unit("×").decimals(2),
    ]);
    let mut times = Table::new("ray-times", "Times, and the rival's by ours", columns);
    // Of wrong answers no time is shown.
    for row in outcome.rows.iter().filter(|row| row.wrong == 0) {
        for (rival, pair) in ["Parry f32", "Parry f64"].into_iter().zip(&row.times) {
            let each = |time: std::time::Duration| time.as_secs_f64() * 1e6 / row.count as f64;
            let numbers =
                [each(pair.a.median), each(pair.b.median), pair.ratio, pair.least, pair.most];
            let names = [Cell::from(row.question.as_str()), Cell::from(rival)];
            times.push(names.into_iter().chain(numbers.map(Cell::from)))?;
        }
    }
    report.table(times);
    NOTES.into_iter().for_each(|note| report.note(note));
    Ok(report)
}
