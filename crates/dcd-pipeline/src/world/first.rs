//! A hit of each configuration of a row.

use super::desk::Desk;
use super::probe::{Finding, Other, Probe};
use super::set::{Members, ROW, Set};
use dcd_geom::{Pair, Pose};
use dcd_gjk::{NarrowPhase, Verdict};
use std::ops::Range;

/// How far the search of each configuration has come: each goes its own way through its links and
/// what these are near of, in an order of its own, and all are asked together.
#[derive(Default)]
pub(super) struct Search {
    /// For each configuration and link how far it is from a contact of inner balls: see
    /// [`SnugBall::short_of`].
    distances: Vec<f32>,
    /// For each configuration, one after the other, the links that are near an obstacle and not yet
    /// asked for, in no order, and room for as many as there are; and how many there are.
    links: Vec<Rank>,
    left: Vec<u32>,
    /// The configurations whose links are not yet asked for against each other.
    folded: Set,
    /// Those in which they are asked for now.
    unfolding: Set,
    /// The pairs found near, link by link and configuration by configuration.
    near: Vec<Pair>,
    /// For each configuration those that are still to be asked for, in the order of the answer.
    waiting: Vec<Range<usize>>,
    /// For each object of a link where its pairs end among those of the link.
    ends: Vec<usize>,
}

/// A link and how far it is from a contact, as one number: the least is asked first.
type Rank = i64;

/// The rank of a link at that distance.
#[inline]
fn rank(link: usize, distance: f32) -> Rank {
    // A NaN is far. The bits of numbers below 0 fall where those above rise.
    let bits = distance.min(f32::MAX).to_bits() as i32;
    let ordered = bits ^ ((bits >> 31) as u32 >> 1) as i32;
    Rank::from(ordered) << 32 | link as Rank
}

/// The link that such a rank is of.
#[inline]
fn link_of(rank: Rank) -> usize {
    rank as u32 as usize
}

/// How many pairs are settled at once, if there are as many. Larger: more are settled in vain, behind
/// one that touches. Smaller: lanes stay idle.
const ENOUGH: usize = 256;

impl<N: NarrowPhase> Desk<N> {
    /// Finds a hit of each configuration taken up, and writes it. The index of the first pose that
    /// was refused, if any.
    ///
    /// What is found, and that a pose is refused, depends on the configuration alone: first inner
    /// balls are asked, link by link, then the links that are near something, the one with the
    /// nearest inner ball first, then the links against each other.
    pub(super) fn find_first(
        &mut self,
        probe: &Probe<'_, N>,
        poses: &[Pose],
        found: &mut [Option<Finding<N::Answer>>],
    ) -> Option<usize> {
        self.look_for_contacts(probe, poses, found);
        self.rank_links(probe.linkage.len());
        let Search { folded, near, waiting, .. } = &mut self.search;
        let meet = |all: Set, pair| all | self.outlook.met(pair);
        *folded = (0..probe.linkage.own_pairs.len()).fold(Set::default(), meet);
        near.clear();
        waiting.clear();
        waiting.resize(ROW, 0..0);
        let mut refused: Option<usize> = None;
        while !self.open.is_empty() {
            if self.advance(probe) {
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

    /// Looks where all links are, and closes the configurations of which inner balls prove a hit.
    fn look_for_contacts(
        &mut self,
        probe: &Probe<'_, N>,
        poses: &[Pose],
        found: &mut [Option<Finding<N::Answer>>],
    ) {
        let Self { outlook, start, search: Search { distances, .. }, .. } = self;
        let links = probe.linkage.len();
        let sole_answer = probe.world.narrow.sole_answer();
        distances.resize(links * ROW, f32::INFINITY);
        let row = (&poses[*start * links..], found.len());
        self.open = outlook.look(probe, row, |[own, link], ball, noted| {
            let inner = probe.bounds.concentric(link, ball);
            let distance = probe.vicinity.short_of(noted, &inner);
            distances[own * links + link] = distance;
            let obstacle = noted.likeliest;
            let Some(answer) = sole_answer.filter(|_| distance <= 0.0) else { return false };
            let touches = probe.allows(link, obstacle);
            if touches {
                found[own] = Some(Finding {
                    configuration: (*start + own) as u32,
                    link: link as u32,
                    other: Other::Obstacle(probe.world.names[obstacle as usize]),
                    verdict: Verdict::Touching(answer),
                });
            }
            touches
        });
    }

    /// Lists for each configuration the links that are near an obstacle.
    fn rank_links(&mut self, count: usize) {
        let Search { distances, links, left, .. } = &mut self.search;
        links.resize(count * ROW, 0);
        left.clear();
        left.resize(ROW, 0);
        for link in 0..count {
            for own in Members::of(self.outlook.near(link)) {
                links[own * count + left[own] as usize] = rank(link, distances[own * count + link]);
                left[own] += 1;
            }
        }
    }

    /// Goes on, in every configuration that waits for nothing, to the next link, or to its links
    /// against each other. Whether there is any.
    fn advance(&mut self, probe: &Probe<'_, N>) -> bool {
        let Search { links, left, folded, unfolding, waiting, .. } = &mut self.search;
        let count = probe.linkage.len();
        self.due.fill(Set::default());
        *unfolding = Set::default();
        let mut is_any = false;
        for own in Members::of(self.open) {
            if !waiting[own].is_empty() {
                continue;
            }
            let links = &mut links[own * count..][..left[own] as usize];
            if let Some(link) = take_least(links) {
                left[own] -= 1;
                self.due[link_of(link)].add(own);
                is_any = true;
            } else if folded.has(own) {
                folded.remove(own);
                unfolding.add(own);
                is_any = true;
            } else {
                self.open.remove(own);
            }
        }
        for (pair, &(k, l)) in probe.linkage.own_pairs.iter().enumerate() {
            let met = self.outlook.met(pair) & *unfolding;
            self.due[k as usize] |= met;
            self.due[l as usize] |= met;
        }
        is_any
    }

    /// Lists what the links come to are near of, in each configuration in order.
    fn gather(&mut self, probe: &Probe<'_, N>) {
        for link in 0..probe.linkage.len() {
            let new = self.fresh[link].clone();
            if new.is_empty() {
                continue;
            }
            self.pairs.clear();
            self.append_pairs(probe, link);
            let Search { near, waiting, ends, .. } = &mut self.search;
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
        }
        Members::of(self.search.unfolding).for_each(|own| self.gather_links(probe, own));
    }

    /// Lists the links of a configuration that are near each other.
    fn gather_links(&mut self, probe: &Probe<'_, N>, own: usize) {
        let first = self.search.near.len();
        for (pair, &(k, l)) in probe.linkage.own_pairs.iter().enumerate() {
            if self.outlook.met(pair).has(own) {
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

/// The least, the last in its place.
#[inline]
fn take_least(ranks: &mut [Rank]) -> Option<Rank> {
    let last = ranks.len().checked_sub(1)?;
    let mut least = last;
    for k in 0..last {
        least = if ranks[k] < ranks[least] { k } else { least };
    }
    ranks.swap(least, last);
    Some(ranks[last])
}
