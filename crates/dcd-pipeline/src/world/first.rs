//! The first hit of each configuration of a row.

use super::desk::Desk;
use super::probe::{Finding, Probe};
use super::set::{Marks, Members, ROW, Set};
use dcd_geom::{Pair, Pose};
use dcd_gjk::{NarrowPhase, Verdict};
use std::ops::Range;

/// How far the search of each configuration has come: each goes its own way through its links and
/// what these are near of, in order, and all are asked together.
#[derive(Default)]
pub(super) struct Search {
    /// For each link, and for none after the last, the configurations in which it is the next.
    next: Vec<Set>,
    /// For each link the configurations that have come to it last, where it is near something.
    here: Vec<Set>,
    /// The pairs found near, link by link and configuration by configuration.
    near: Vec<Pair>,
    /// For each configuration those that are still to be asked for, in the order of the answer:
    /// obstacles ascend, and links come after them.
    waiting: Vec<Range<usize>>,
    /// For each object of a link where its pairs end among those of the link.
    ends: Vec<usize>,
}

/// How many pairs are settled at once, if there are as many. Larger: more are settled in vain, behind
/// one that touches. Smaller: lanes stay idle.
const ENOUGH: usize = 256;

impl<N: NarrowPhase> Desk<N> {
    /// Finds the first hit of each configuration taken up, and writes it. The index of the first
    /// pose that was refused, if any.
    pub(super) fn find_first(
        &mut self,
        probe: &Probe<'_, N>,
        poses: &[Pose],
        found: &mut [Option<Finding<N::Answer>>],
    ) -> Option<usize> {
        let Search { next, here, near, waiting, .. } = &mut self.search;
        here.resize(probe.linkage.len(), Set::default());
        next.clear();
        next.resize(probe.linkage.len() + 1, Set::default());
        next[0] = self.open;
        near.clear();
        waiting.clear();
        waiting.resize(ROW, 0..0);
        let mut refused: Option<usize> = None;
        while !self.open.is_empty() {
            if self.advance(probe, poses) {
                let new = self.place(probe, poses);
                refused = refused.into_iter().chain(new).min();
                self.gather(probe);
            }
            self.take_turns();
            self.decide(probe);
            self.keep_first(probe, found);
        }
        refused
    }

    /// Goes on, in every configuration that waits for nothing, to the next link near something.
    /// Whether there is any.
    fn advance(&mut self, probe: &Probe<'_, N>, poses: &[Pose]) -> bool {
        let links = probe.linkage.len();
        let row = &poses[self.start * links..];
        let Search { next, here, waiting, .. } = &mut self.search;
        let mut idle = Marks::default();
        for own in Members::of(self.open) {
            idle.mark(own, waiting[own].is_empty());
        }
        let idle = idle.set();
        let (mut passing, mut found) = (Set::default(), Set::default());
        for link in 0..links {
            let look = (next[link] | passing) & idle & !found;
            next[link] &= !look;
            here[link] = match look.is_empty() {
                true => look,
                false => self.outlook.look(probe, link, look, row),
            };
            passing = look & !here[link];
            next[link + 1] |= here[link];
            found |= here[link];
        }
        // They have no link left.
        self.open &= !(idle & !found);
        !found.is_empty()
    }

    /// Lists what the links come to are near of, in each configuration in order.
    fn gather(&mut self, probe: &Probe<'_, N>) {
        for link in 0..probe.linkage.len() {
            let new = self.fresh[link].clone();
            self.pairs.clear();
            self.append_pairs(probe, link);
            let Search { near, waiting, ends, here, .. } = &mut self.search;
            // Where the pairs of each object end, if it has any.
            ends.clear();
            ends.resize(new.len(), 0);
            for (pair, end) in self.pairs.iter().zip(1..) {
                ends[pair.j as usize - new.start] = end;
            }
            let base = near.len();
            near.extend_from_slice(&self.pairs);
            let mut start = 0;
            for (slot, &end) in new.zip(&*ends) {
                let own = self.owners[slot - probe.world.obstacles.len()] as usize;
                let end = start.max(end);
                waiting[own] = base + start..base + end;
                start = end;
            }
            if !probe.linkage.own_pairs_of(link).is_empty() {
                let here = here[link] & self.posed[link];
                Members::of(here).for_each(|own| self.gather_links(probe, link, own));
            }
        }
    }

    /// Lists the other links that a link is near of after what it is near of already.
    fn gather_links(&mut self, probe: &Probe<'_, N>, link: usize, own: usize) {
        let with_obstacles = self.search.waiting[own].clone();
        let first = self.search.near.len();
        self.search.near.extend_from_within(with_obstacles);
        for pair in probe.linkage.own_pairs_of(link) {
            if self.outlook.met(pair).has(own) {
                let (k, l) = probe.linkage.own_pairs[pair];
                let met = self.own_pair(own, [k, l]);
                self.search.near.extend(met);
            }
        }
        self.search.waiting[own] = first..self.search.near.len();
    }

    /// Takes the next pairs of every configuration, few of many or many of few.
    fn take_turns(&mut self) {
        let Search { near, waiting, .. } = &mut self.search;
        let each = (ENOUGH / self.open.len().max(1)).max(1);
        self.pairs.clear();
        for own in Members::of(self.open) {
            let Range { start, end } = &mut waiting[own];
            let next = *start..(*start + each).min(*end);
            *start = next.end;
            match next.len() {
                1 => self.pairs.push(near[next.start]),
                _ => self.pairs.extend_from_slice(&near[next]),
            }
        }
    }

    /// Writes the first finding of each configuration, and closes those that touch.
    fn keep_first(&mut self, probe: &Probe<'_, N>, found: &mut [Option<Finding<N::Answer>>]) {
        for contact in &self.contacts {
            let verdict = Verdict::Touching(contact.answer);
            let (own, finding) = self.finding(probe, contact.pair, verdict);
            if !found[own].as_ref().is_some_and(Finding::touches) {
                found[own] = Some(finding);
            }
            self.open.remove(own);
        }
        for undecided in self.report.undecided() {
            let verdict = Verdict::Undecided(undecided.reason);
            let (own, finding) = self.finding(probe, undecided.pair, verdict);
            found[own].get_or_insert(finding);
        }
    }
}
