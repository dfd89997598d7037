//! What it costs that the results come in one order at any number of threads.

use std::ops::Range;
use std::time::Duration;

use anyhow::{Result, ensure};
use dcd_benches::{Cell, Column, Options, Report, Sample, Table, Units, timing};
use dcd_exec::{Exec, PerThread, Segments};
use dcd_geom::{Pair, Scene};
use dcd_pipeline::{Par, Pipeline};
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::runner::{Case, on_threads};

/// Pairs that a task writes. The tasks of a step write as many or more.
const PAIRS_PER_TASK: usize = 512;

/// A step's lists written in a fixed order and in any, and the step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Seen {
    threads: usize,
    /// Candidates and contacts written in task order and cut for the next stage.
    ordered: Sample,
    /// The same, each thread's to a list of its own.
    unordered: Sample,
    /// The contacts copied to one list, for a caller who wants one.
    joined: Sample,
    step: Sample,
}

fn key(case: &Case) -> String {
    format!("order/{}", case.key())
}

/// The units of all cases.
pub(crate) fn plan(cases: &[Case]) -> Vec<String> {
    cases.iter().map(key).collect()
}

/// Measures a case on one thread and on two.
pub(crate) fn measure(case: &Case, options: &Options, units: &mut Units) -> Result<()> {
    let rounds = super::rounds(options);
    units.run(&key(case), || {
        let scene = case.scene()?;
        let one = see(scene, Par::Serial, rounds)?;
        let two = on_threads(2, || see(scene, Par::WarmPool, rounds))?;
        Ok(vec![Seen { threads: 1, ..one }, Seen { threads: 2, ..two }])
    })?;
    Ok(())
}

/// What a step found, to be written again.
struct Lists {
    lists: [Vec<Pair>; 2],
}

impl Lists {
    /// The part of a list that a task writes.
    fn part(&self, list: usize, task: usize) -> &[Pair] {
        let range: Range<usize> =
            task * PAIRS_PER_TASK..self.lists[list].len().min((task + 1) * PAIRS_PER_TASK);
        &self.lists[list][range]
    }

    fn tasks(&self, list: usize) -> usize {
        self.lists[list].len().div_ceil(PAIRS_PER_TASK)
    }
}

fn see(scene: &Scene, par: Par, rounds: u32) -> Result<Seen> {
    let mut pipeline = Pipeline::new();
    let lists = {
        let step = pipeline.step(scene, par);
        let contacts = step.contacts().map(|(i, j)| Pair { i, j }).collect();
        Lists { lists: [step.candidates().collect(), contacts] }
    };
    let exec = Exec::from(par);
    let (mut segments, mut cuts) = ([Segments::default(), Segments::default()], Vec::new());
    let mut write_in_order = || {
        for (list, segments) in segments.iter_mut().enumerate() {
            segments.fill(exec, lists.tasks(list), |task, out| {
                out.extend_from_slice(lists.part(list, task));
            });
            segments.cut(PAIRS_PER_TASK, &mut cuts);
        }
    };
    let mut heaps = [PerThread::<Vec<Pair>>::default(), PerThread::default()];
    let mut write_in_any = || {
        for (list, heap) in heaps.iter_mut().enumerate() {
            heap.iter_mut().for_each(Vec::clear);
            let heap = &*heap;
            exec.tasks(lists.tasks(list), |task| {
                heap.with(|out| out.extend_from_slice(lists.part(list, task)));
            });
        }
    };
    let time = |work: &mut dyn FnMut()| -> [Duration; 1] { [timing::time(work).0] };
    let [written] =
        timing::pairs_of(rounds, || time(&mut write_in_order), || time(&mut write_in_any));

    let mut one_list = Vec::new();
    let [shared] = timing::pairs_of(
        rounds,
        || [timing::time(|| segments[1].join_into(exec, &mut one_list)).0],
        || [timing::time(|| pipeline.step(scene, par).contact_count()).0],
    );
    ensure!(one_list == lists.lists[1], "the joined list is not the list");
    Ok(Seen {
        threads: 0,
        ordered: written.a,
        unordered: written.b,
        joined: shared.a,
        step: shared.b,
    })
}

impl Seen {
    /// What the order costs, milliseconds: at least nothing.
    fn cost(&self) -> f64 {
        (self.ordered.median.as_secs_f64() - self.unordered.median.as_secs_f64()).max(0.0) * 1e3
    }

    /// In percent of the step: the order alone, and with the contacts in one list.
    fn shares(&self) -> [f64; 2] {
        let step = self.step.median.as_secs_f64() * 1e3;
        let joined = self.joined.median.as_secs_f64() * 1e3;
        [self.cost(), self.cost() + joined].map(|ms| 100.0 * ms / step)
    }
}

/// Draws what is there.
pub(crate) fn show(cases: &[Case], units: &Units, report: &mut Report) -> Result<()> {
    report.heading("Fixed order");
    report.note(format!(
        "The step's own candidates and contacts, written again by tasks of {PAIRS_PER_TASK}: as \
         ordered segments, cut for the next stage, and interleaved with that to a list for each \
         thread. The difference is what the order costs. A step leaves its contacts in segments, \
         which are read in order; who wants them in one list pays for a copy.",
    ));
    let ms = |name: &str| Column::new(name).unit("ms");
    let mut columns = ["scene", "N", "threads"].map(Column::new).to_vec();
    columns.extend(["in order", "in any", "contacts in one list", "step"].map(ms));
    columns.push(Column::new("order").unit("% of the step").decimals(2));
    columns.push(Column::new("with one list").unit("% of the step").decimals(2));
    let mut table = Table::new("order", "What the fixed order costs", columns);
    let mut values = Vec::new();
    for case in cases {
        for seen in units.get::<Vec<Seen>>(&key(case)).unwrap_or_default() {
            let mut row = vec![Cell::from(case.name()), case.objects().into(), seen.threads.into()];
            let times = [seen.ordered, seen.unordered, seen.joined, seen.step];
            row.extend(times.map(|sample| Cell::from(sample.median)));
            row.extend(seen.shares().map(Cell::from));
            table.push(row)?;
            let [order, with_one_list] = seen.shares();
            values.push(json!({
                "scene": case.name(), "objects": case.objects(), "threads": seen.threads,
                "percent_of_step": order, "percent_with_one_list": with_one_list,
            }));
        }
    }
    report.table(table);
    report.attach("order", values.into());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_of_writing_are_timed_and_the_list_is_whole() {
        let case = Case::new("paper", 300, 1).unwrap();
        let seen = see(case.scene().unwrap(), Par::Serial, 3).unwrap();
        assert!(seen.shares().iter().all(|share| share.is_finite() && *share >= 0.0));
        assert!(seen.step.median > seen.joined.median);
    }
}
