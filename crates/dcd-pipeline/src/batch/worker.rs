//! A thread's work on a few configurations.

use super::checker::{BatchChecker, Hit, Other};
use super::culling::Culling;
use super::decisions::{Against, Decisions};
use super::first_hits::FirstHitSearch;
use super::posed_links::PosedLinks;
use super::set::{Members, ROW, Set};
use dcd_geom::{Pair, Pose};
use dcd_gjk::{NarrowPhase, Verdict};
use std::ops::Range;

/// The memory of a thread, phase by phase: which configurations there are, which of their links are near
/// anything, those that are posed, and the pairs to be decided.
pub(super) struct WorkerScratch<N: NarrowPhase> {
    /// The configurations of the task, by their numbers in the batch.
    pub(super) taken: Range<usize>,
    pub(super) culling: Culling,
    /// For each link the configurations in which it is wanted next, counted from the first taken up.
    pub(super) due: Vec<Set>,
    pub(super) posed: PosedLinks<N>,
    pub(super) decisions: Decisions<N>,
    /// For queries of first hits.
    pub(super) search: FirstHitSearch,
    /// For queries of all hits.
    sorting: Sorting<N::Answer>,
}

impl<N: NarrowPhase> Default for WorkerScratch<N> {
    fn default() -> Self {
        Self {
            taken: 0..0,
            culling: Culling::default(),
            due: Vec::new(),
            posed: PosedLinks::default(),
            decisions: Decisions::default(),
            search: FirstHitSearch::default(),
            sorting: Sorting::default(),
        }
    }
}

/// Hits to be put in the order of their configurations.
struct Sorting<A> {
    hits: Vec<Hit<A>>,
    /// Where those of each configuration begin.
    starts: [usize; ROW + 1],
}

impl<A> Default for Sorting<A> {
    fn default() -> Self {
        Self { hits: Vec::new(), starts: [0; ROW + 1] }
    }
}

impl<N: NarrowPhase> WorkerScratch<N> {
    /// Starts a task of these configurations, at most a row.
    pub(super) fn open(&mut self, checker: &BatchChecker<N>, taken: Range<usize>) {
        self.posed.clear(&checker.world, &checker.rows);
        self.due.clear();
        self.due.resize(checker.rows.link_set.len(), Set::default());
        self.taken = taken;
    }

    /// The poses of the task's configurations, out of those of the batch.
    pub(super) fn poses_of<'p>(&self, checker: &BatchChecker<N>, poses: &'p [Pose]) -> &'p [Pose] {
        let links = checker.rows.link_set.len();
        &poses[self.taken.start * links..self.taken.end * links]
    }

    /// Decides all pairs of the task's configurations. Returns the index in the batch of the first refused pose,
    /// if any.
    pub(super) fn find_all(&mut self, checker: &BatchChecker<N>, poses: &[Pose]) -> Option<usize> {
        let self_pairs = &checker.rows.link_set.self_pairs;
        let row = self.poses_of(checker, poses);
        self.culling.look(checker, (row, self.taken.len()), |_, _, _| false);
        for (link, due) in self.due.iter_mut().enumerate() {
            *due = self.culling.near(link);
        }
        for (pair, &(k, l)) in self_pairs.iter().enumerate() {
            self.due[k as usize] |= self.culling.met(pair);
            self.due[l as usize] |= self.culling.met(pair);
        }
        let refused = self.place(checker, poses);
        let Self { culling, posed, decisions, .. } = self;
        decisions.clear();
        let pairs = decisions.pairs_mut(Against::Obstacles);
        for link in 0..checker.rows.link_set.len() {
            posed.append_pairs(checker, culling, link, pairs);
        }
        let pairs = decisions.pairs_mut(Against::Links);
        for (pair, &links) in self_pairs.iter().enumerate() {
            for config in Members::of(culling.met(pair)) {
                pairs.extend(posed.self_pair(config, links));
            }
        }
        decisions.decide(&checker.world, posed);
        refused
    }

    /// Poses and prepares what is due. Returns the index in the batch of the first refused pose.
    pub(super) fn place(&mut self, checker: &BatchChecker<N>, poses: &[Pose]) -> Option<usize> {
        let links = checker.rows.link_set.len();
        let first = self.taken.start * links;
        let row = self.poses_of(checker, poses);
        let pose = |config, link| row[config * links + link];
        self.posed
            .place(&checker.world.narrow, &checker.rows, &self.due, pose)
            .map(|(pose, _)| first + pose)
    }

    /// Appends all hits, configuration by configuration.
    pub(super) fn append_all(&mut self, checker: &BatchChecker<N>, out: &mut Vec<Hit<N::Answer>>) {
        let mut sorting = std::mem::take(&mut self.sorting);
        sorting.hits.clear();
        sorting.starts = [0; ROW + 1];
        for (against, pair, verdict) in self.decisions.hits() {
            let (config, hit) = self.hit(checker, (against, pair), verdict);
            sorting.starts[config + 1] += 1;
            sorting.hits.push(hit);
        }
        for config in 0..ROW {
            sorting.starts[config + 1] += sorting.starts[config];
        }
        let end = out.len();
        out.extend_from_slice(&sorting.hits);
        for hit in &sorting.hits {
            let place = &mut sorting.starts[hit.configuration as usize - self.taken.start];
            out[end + *place] = hit.clone();
            *place += 1;
        }
        self.sorting = sorting;
    }

    /// A pair as a hit, and its configuration counted from the first.
    pub(super) fn hit(
        &self,
        checker: &BatchChecker<N>,
        (against, Pair { i, j }): (Against, Pair),
        verdict: Verdict<N::Answer>,
    ) -> (usize, Hit<N::Answer>) {
        let link = |object: u32| (object as usize / checker.rows.row) as u32;
        let other = match against {
            Against::Obstacles => Other::Obstacle(checker.world.names[i as usize]),
            Against::Links => Other::Link(link(i)),
        };
        let config = self.posed.configuration(j);
        let configuration = (self.taken.start + config) as u32;
        (config, Hit { configuration, link: link(j), other, verdict })
    }
}
