//! Tables of what was found.

use anyhow::Result;
use dcd_benches::{Cell, Column, Header, Report, Table};

use crate::clearance::{self, LEAST};
use crate::{edges, grazing, states, worlds};

/// What a reader of the tables must know.
const NOTES: [&str; 6] = [
    "The Panda among the obstacles of MotionBenchMaker's problems (C. Chamzas et al., 2022), 100 states on the straight line \
     between start and goal of each. UR10 and PR2 have no problems in the data.",
    "States: one pass over the problems a round, ours and Parry's problem by problem; medians of the rounds, with the least and \
     the most ratio. A check contains the kinematics; preparation is apart: the next problem's obstacles taken by \
     `StateChecker::set_obstacles`, the robot once: the mean, and the mean of each problem's median of the rounds, which leaves out \
     what it waits for in few of them. Every batch begins with the obstacles taken anew, and batches of all sizes take turns \
     behind Parry, where caches are cold. \
     Batches of 10,000 are finer lines between the same ends. Parry: `parry3d` in f64 on one thread, its check alone: \
     AABBs, tree, `query::intersection_test`, poses made outside of the timer.",
    "Edges: from start to goal, one thread; each edge's time is the median of its rounds. Samples are at most 1e-3 rad from \
     each other in every joint, 128 at once, up to the first that touches: they prove nothing of what is between them.",
    "`hit, and free before it` proves the path before the hit as far as it is free; `hit alone` (`check_any`) ends at a hit.",
    "Grazing: an obstacle is moved until samples, refined by golden sections, find the gap. Hits there are contacts that \
     those samples miss.",
    "Certificates: separating planes for every pair, replayed by `dcd-judge` in interval arithmetic.",
];

/// The mean, and the numbers below which so many of a hundred are.
fn mean_and<const N: usize>(numbers: &[f64], parts: [usize; N]) -> (f64, [f64; N]) {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
    let at = |part: usize| {
        // The least that so many of a hundred do not exceed.
        let rank = (sorted.len() * part).div_ceil(100).max(1);
        sorted.get(rank - 1).copied().unwrap_or(f64::NAN)
    };
    (mean, parts.map(at))
}

pub(crate) fn states(report: &mut Report, outcomes: &[states::Outcome]) -> Result<()> {
    let columns = [
        Column::new("links"),
        Column::new("threads"),
        Column::new("problems"),
        Column::new("contacts"),
        Column::new("undecided"),
        Column::new("differs from Parry"),
        Column::new("kinematics").unit("ns a state").decimals(0),
        Column::new("preparation").unit("µs a problem").decimals(1),
        Column::new("preparation, medians").unit("µs a problem").decimals(1),
    ];
    let mut found = Table::new("robot-answers", "What touches, and what comes before", columns);
    let columns = [
        Column::new("links"),
        Column::new("threads"),
        Column::new("hits"),
        Column::new("states at once"),
        Column::new("ours").unit("ns a state").decimals(0),
        Column::new("Parry f64").unit("ns a state").decimals(0),
        Column::new("ratio").unit("×").decimals(2),
        Column::new("least").unit("×").decimals(2),
        Column::new("most").unit("×").decimals(2),
    ];
    let mut times = Table::new("robot-states", "States, and Parry's times by ours", columns);
    for outcome in outcomes {
        let name = outcome.geometry.as_str();
        let counts = [outcome.problems, outcome.contacts, outcome.undecided, outcome.differences];
        let names = [Cell::from(name), Cell::from(outcome.threads)];
        let [mean, of_medians] = outcome.preparation.map(|spent| spent * 1e-3);
        let numbers = [outcome.kinematics, mean, of_medians].map(Cell::from);
        found.push(names.into_iter().chain(counts.map(Cell::from)).chain(numbers))?;
        for row in &outcome.rows {
            let names = [
                Cell::from(name),
                Cell::from(outcome.threads),
                Cell::from(row.until.as_str()),
                Cell::from(row.batch),
            ];
            let [ratio, least, most] = row.ratio;
            let numbers = [row.ours, row.parry, ratio, least, most];
            times.push(names.into_iter().chain(numbers.map(Cell::from)))?;
        }
    }
    report.table(found);
    report.table(times);
    Ok(())
}

pub(crate) fn edges(report: &mut Report, outcomes: &[edges::Outcome]) -> Result<()> {
    let us = |name: &str| Column::new(name).unit("µs").decimals(1);
    let columns = [
        Column::new("links"),
        Column::new("answer"),
        Column::new("edges"),
        us("mean"),
        us("95 %"),
        Column::new("nodes").decimals(1),
        us("samples, mean"),
        us("samples, 95 %"),
        Column::new("samples call free"),
    ];
    let mut times = Table::new("robot-edges", "Straight edges, proved and sampled", columns);
    let columns = [
        Column::new("links"),
        Column::new("free edges"),
        Column::new("accepted"),
        Column::new("written, mean").unit("ms").decimals(2),
        Column::new("written, 95 %").unit("ms").decimals(2),
        Column::new("replayed, mean").unit("ms").decimals(1),
        Column::new("replayed, 95 %").unit("ms").decimals(1),
        Column::new("planes").decimals(0),
        Column::new("size").unit("kB").decimals(0),
    ];
    let mut proofs = Table::new("robot-certificates", "Certificates of the free edges", columns);
    for outcome in outcomes {
        let name = outcome.geometry.as_str();
        for group in outcome.groups.iter().filter(|group| !group.times.is_empty()) {
            let (mean, [p95]) = mean_and(&group.times, [95]);
            let (sampled, [sampled_p95]) = mean_and(&group.sampled, [95]);
            let (nodes, []) = mean_and(&group.nodes, []);
            let names = [Cell::from(name), Cell::from(group.name.as_str())];
            let numbers = [mean, p95, nodes, sampled, sampled_p95].map(Cell::from);
            let names = names.into_iter().chain([Cell::from(group.times.len())]);
            times.push(names.chain(numbers).chain([Cell::from(group.samples_free)]))?;
        }
        let all = &outcome.certificates;
        let (written, [written_p95]) = mean_and(&all.written, [95]);
        let (replayed, [replayed_p95]) = mean_and(&all.replayed, [95]);
        let ((planes, []), (bytes, [])) = (mean_and(&all.planes, []), mean_and(&all.bytes, []));
        let counts = [all.accepted + all.refused.len(), all.accepted].map(Cell::from);
        let numbers = [written, written_p95, replayed, replayed_p95, planes, bytes * 1e-3];
        proofs.push([Cell::from(name)].into_iter().chain(counts).chain(numbers.map(Cell::from)))?;
    }
    report.table(times);
    report.table(proofs);
    Ok(())
}

pub(crate) fn grazing(report: &mut Report, groups: &[grazing::Group]) -> Result<()> {
    let columns = [
        Column::new("gap").unit("m").decimals(8),
        Column::new("edges"),
        Column::new("free"),
        Column::new("hit"),
        Column::new("undecided"),
        Column::new("decided within 10 ms").unit("%").decimals(0),
        Column::new("mean").unit("µs").decimals(1),
        Column::new("95 %").unit("µs").decimals(1),
        Column::new("nodes").decimals(1),
        Column::new("clearance by gap, median").decimals(3),
    ];
    let mut table =
        Table::new("robot-grazing", "Edges that graze an obstacle, links as hulls", columns);
    for group in groups {
        let count = group.times.len();
        let (mean, [p95]) = mean_and(&group.times, [95]);
        let ((nodes, []), (_, [clearance])) =
            (mean_and(&group.nodes, []), mean_and(&group.clearances, [50]));
        let counts = [count, group.free, group.hits, group.undecided].map(Cell::from);
        let share = 100.0 * group.in_time as f64 / count as f64;
        let numbers = [share, mean, p95, nodes, clearance].map(Cell::from);
        table.push([Cell::from(group.gap)].into_iter().chain(counts).chain(numbers))?;
    }
    report.table(table);
    Ok(())
}

pub(crate) fn clearance(report: &mut Report, outcome: &clearance::Outcome) -> Result<()> {
    let columns = [
        Column::new("free edges"),
        Column::new("samples of each"),
        Column::new("least").decimals(3),
        Column::new("median").decimals(3),
        Column::new("mean").decimals(3),
        Column::new("most").decimals(3),
    ];
    let title = "Reported clearance over the least distance of samples, links as hulls";
    let mut table = Table::new("robot-clearance", title, columns);
    let (mean, [least, median, most]) = mean_and(&outcome.ratios, [0, 50, 100]);
    let counts = [outcome.ratios.len(), outcome.samples].map(Cell::from);
    let numbers = [least, median, mean, most].map(Cell::from);
    table.push(counts.into_iter().chain(numbers))?;
    report.note(format!(
        "The clearance ratio is of free edges that come no nearer than {LEAST} m; {} come nearer.",
        outcome.nearer
    ));
    report.table(table);
    Ok(())
}

pub(crate) fn worlds(report: &mut Report, outcome: &worlds::Outcome) -> Result<()> {
    let us = |name: &str| Column::new(name).unit("µs").decimals(2);
    let columns = [
        Column::new("obstacles"),
        us("one moved"),
        us("one added"),
        us("one removed"),
        us("all exchanged"),
        us("cell and checker made"),
        us("16 states"),
        us("16 states after changes"),
    ];
    let title = "A world that changes, and all pairs of 16 states of a robot of hulls";
    let mut table = Table::new("robot-worlds", title, columns);
    for world in &outcome.worlds {
        let changes = [world.moved, world.added, world.removed, world.exchanged, world.made];
        let numbers = changes.into_iter().chain([world.checked, world.checked_after]);
        table.push([Cell::from(world.obstacles)].into_iter().chain(numbers.map(Cell::from)))?;
    }
    report.table(table);
    let columns = [
        Column::new("points"),
        Column::new("replaced").unit("ms").decimals(2),
        Column::new("a state").unit("µs").decimals(2),
        Column::new("states free").unit("of 1000"),
    ];
    let mut table = Table::new("robot-sensed", "Sensed points, and a robot of hulls", columns);
    let sensed = &outcome.sensed;
    let numbers = [sensed.replaced * 1e-3, sensed.state].map(Cell::from);
    let count = [Cell::from(worlds::POINTS)].into_iter().chain(numbers);
    table.push(count.chain([Cell::from(sensed.free)]))?;
    report.table(table);
    Ok(())
}

pub(crate) fn report(header: Header, problems: usize) -> Report {
    let title = "The Panda's states and edges, beside Parry and samples";
    let mut report = Report::new("robots", title, header);
    report.note(format!("{problems} problems."));
    NOTES.into_iter().for_each(|note| report.note(note));
    report
}
