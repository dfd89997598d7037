//! Tables of queries and times.

use anyhow::Result;
use dcd_benches::{Cell, Column, Header, Report, Table};

use crate::contest::Outcome;

/// What a reader of the tables must know.
const NOTES: [&str; 3] = [
    "Yes or no, one thread, the two interleaved in one process; the median of the rounds with the least \
     and the most. Meshes, trees and Parry's poses are made outside of the timer; nothing learnt \
     from one pose serves the next. Parry walks the first mesh's tree with the second's AABB, so \
     it runs in both orders.",
    "A pose on which we, Parry in f64 and Parry in f32 do not all agree is judged by exact integers \
     on the vertices R·v + t of every two triangles whose AABBs come near; `wrong` counts against \
     that.",
    "Translations are uniform in the AABB of the surroundings, rotations are the paper's.",
];

pub(crate) fn report(header: Header, outcome: &Outcome) -> Result<Report> {
    let mut report = Report::new("meshes", "Triangle meshes beside Parry's", header);
    let [fixed, moving] = outcome.triangles;
    report.note(format!(
        "`env.obj` ({fixed} triangles) against `rob.obj` ({moving}) in {} seeded poses; {} of them \
         were judged exactly.",
        outcome.poses, outcome.judged
    ));
    let columns = ["by", "touching", "wrong", "undecided"].map(Column::new);
    let mut answers = Table::new("answers", "Answers", columns);
    for (name, account) in
        [("ours", outcome.ours), ("Parry f32", outcome.parry_f32), ("Parry f64", outcome.parry_f64)]
    {
        let counts = [account.touching, account.wrong, account.undecided];
        answers.push([Cell::from(name)].into_iter().chain(counts.map(Cell::from)))?;
    }
    report.table(answers);

    let columns = ["rival", "poses", "count"].map(Column::new).into_iter().chain([
        Column::new("ours").unit("µs a pose").decimals(3),
        Column::new("rival").unit("µs a pose").decimals(3),
        Column::new("ratio").unit("×").decimals(2),
        Column::new("least").unit("×").decimals(2),
        Column::new("most").unit("×").decimals(2),
    ]);
    // Of wrong answers no time is shown.
    if outcome.ours.wrong == 0 {
        let title = "Times, and the rival's by ours";
        let mut times = Table::new("mesh-times", title, columns);
        for beside in &outcome.times {
            let each = |time: std::time::Duration| time.as_secs_f64() * 1e6 / beside.count as f64;
            let pair = &beside.pair;
            let names = [Cell::from(beside.rival.as_str()), beside.poses.as_str().into()];
            let numbers =
                [each(pair.a.median), each(pair.b.median), pair.ratio, pair.least, pair.most];
            let row = names.into_iter().chain([Cell::from(beside.count)]);
            times.push(row.chain(numbers.map(Cell::from)))?;
        }
        report.table(times);
    }
    NOTES.into_iter().for_each(|note| report.note(note));
    Ok(report)
}
