//! A narrow phase over all pairs, without a broad phase: what the paper compares with.

use std::ops::Range;

use dcd_benches::Agreement;
use dcd_exec::{Exec, PerThread, Segments};
use dcd_geom::{Aabb, Pair, Scene};
use dcd_gjk::{Contact, ContactSink, NarrowPhase, Prepared, Report, Sides};

use crate::case::Case;

/// Pairs handed to the narrow phase at once: a list in the nearest cache, instead of the 400 MB of
/// all pairs of 10,000 objects.
const PAIRS_AT_ONCE: usize = 1024;

/// Pairs that make a task worth its overhead; one row of the triangle of pairs at least.
const PAIRS_PER_TASK: usize = 4096;

/// A narrow phase that decides all pairs, and its buffers, kept from run to run.
pub(crate) struct EveryPair<'n, N: NarrowPhase<Answer = ()>> {
    narrow: &'n N,
    frame: N::Frame,
    aabbs: Vec<Aabb>,
    contacts: Segments<Contact<()>>,
    scratch: PerThread<N::Scratch>,
    reports: PerThread<Report>,
    report: Report,
}

impl<'n, N: NarrowPhase<Answer = ()>> EveryPair<'n, N> {
    pub(crate) fn new(narrow: &'n N) -> Self {
        Self {
            narrow,
            frame: N::Frame::default(),
            aabbs: Vec::new(),
            contacts: Segments::default(),
            scratch: PerThread::default(),
            reports: PerThread::default(),
            report: Report::default(),
        }
    }

    /// Decides every pair of the scene. The preparation of the objects is part of it, as the trait
    /// demands: their AABBs too, which nobody reads here.
    pub(crate) fn run(&mut self, scene: &Scene, exec: Exec) {
        self.aabbs.resize(scene.len(), Aabb::default());
        let part = self.narrow.layout(scene, Sides::One, &mut self.frame);
        let narrow = self.narrow;
        exec.divide((part, &mut self.aabbs[..]), 256, |first, (part, aabbs)| {
            narrow.prepare(scene, first, part, aabbs);
        });
        let Self { frame, contacts, scratch, reports, report, .. } = self;
        let side = Prepared { scene, frame: &*frame };
        let tasks = tasks(scene.len());
        contacts.fill(exec, tasks.len(), |k, contacts| {
            scratch.with(|scratch| {
                reports.with(|report| {
                    for_each_slice(&tasks[k], scene.len(), |pairs| {
                        let sink = &mut ContactSink { contacts: &mut *contacts, report };
                        narrow.decide(side, side, pairs, scratch, sink);
                    });
                });
            });
        });
        report.clear();
        reports.iter_mut().for_each(|part| report.absorb(part));
        report.sort();
    }

    /// How the contacts of the last run stand to those of the case, whose scene it was run on.
    pub(crate) fn agreement(&self, case: &Case) -> Agreement {
        let contacts = self.contacts.iter().flatten().map(|contact| contact.pair);
        case.agreement(contacts, self.report.undecided())
    }
}

/// The rows of each task: row i holds the pairs (i, j), i < j.
fn tasks(objects: usize) -> Vec<Range<usize>> {
    let mut tasks = Vec::new();
    let (mut first, mut pairs) = (0, 0);
    for row in 0..objects {
        pairs += objects - 1 - row;
        if pairs >= PAIRS_PER_TASK || row + 1 == objects {
            tasks.push(first..row + 1);
            (first, pairs) = (row + 1, 0);
        }
    }
    tasks
}

fn for_each_slice(rows: &Range<usize>, objects: usize, mut decide: impl FnMut(&[Pair])) {
    let mut slice = [Pair::default(); PAIRS_AT_ONCE];
    let mut len = 0;
    for i in rows.clone() {
        for j in i + 1..objects {
            slice[len] = Pair { i: i as u32, j: j as u32 };
            len += 1;
            if len == PAIRS_AT_ONCE {
                decide(&slice);
                len = 0;
            }
        }
    }
    decide(&slice[..len]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_is_listed_once_in_order() {
        for objects in [0, 1, 2, 50, 91, 92, 1500] {
            let mut pairs_seen = Vec::new();
            for rows in tasks(objects) {
                for_each_slice(&rows, objects, |pairs| pairs_seen.extend_from_slice(pairs));
            }
            assert_eq!(pairs_seen.len(), objects * objects.saturating_sub(1) / 2, "{objects}");
            assert!(pairs_seen.is_sorted() && pairs_seen.iter().all(|pair| pair.i < pair.j));
        }
    }
}
