//! A hit of each configuration of a row.

use super::checker::{BatchChecker, Hit, Other};
use super::decisions::Against;
use super::set::{Members, ROW, Set};
use super::worker::WorkerScratch;
use dcd_geom::{Pair, Pose};
use dcd_gjk::{NarrowPhase, Verdict};
use std::ops::Range;

/// How far the search of each configuration has come. Configurations test their links in order of
/// clearance; the pairs of all of them form one batch.
#[derive(Default)]
pub(super) struct FirstHitSearch {
    /// For each configuration and link how far it is from a contact of inner spheres: see
    /// [`short_of`](dcd_geom::InscribedSphere::short_of).
    distances: Vec<f32>,
    /// For each configuration the links that are near an obstacle and not yet tested, unordered, in slices of
    /// one entry per link; and how many there are.
    links: Vec<Rank>,
    left: Vec<u32>,
    /// The configurations that have no hit yet and untested pairs left.
    open: Set,
    /// Those whose links are not yet tested against each other.
    folded: Set,
    /// Those in which links are being tested against each other.
    unfolding: Set,
    /// Those in which that has begun: all their pending pairs are pairs of links.
    unfolded: Set,
    /// The pairs found near, link by link and configuration by configuration.
    near: Vec<Pair>,
    /// For each configuration the pairs still to be decided, in the order of the answer.
    waiting: Vec<Range<usize>>,
    /// For each object of a link where its pairs end among those of the link.
    ends: Vec<usize>,
}

/// A link and its distance from a contact, as one number: the least is tested first.
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

/// How many pairs are decided at once, if there are as many. Larger: more are decided in vain, behind one
/// that touches. Smaller: lanes stay idle.
const ENOUGH: usize = 256;

impl<N: NarrowPhase> WorkerScratch<N> {
    /// Finds and writes a hit of each configuration of the task. Returns the index of the first pose that
    /// was refused, if any.
    ///
    /// What is found, and that a pose is refused, depends on the configuration alone: inner spheres are
    /// tested first, link by link, then the links that are near something, the one with the nearest inner
    /// sphere first, then the links against each other.
    pub(super) fn find_first(
        &mut self,
        checker: &BatchChecker<N>,
        poses: &[Pose],
        found: &mut [Option<Hit<N::Answer>>],
    ) -> Option<usize> {
        self.look_for_contacts(checker, poses, found);
        self.rank_links(checker.rows.link_set.len());
        let FirstHitSearch { folded, unfolded, near, waiting, .. } = &mut self.search;
        let meet = |all: Set, pair| all | self.culling.met(pair);
        *folded = (0..checker.rows.link_set.self_pairs.len()).fold(Set::default(), meet);
        *unfolded = Set::default();
        near.clear();
        waiting.clear();
        waiting.resize(ROW, 0..0);
        let mut refused: Option<usize> = None;
        while !self.search.open.is_empty() {
            if self.advance(checker) {
                let new = self.place(checker, poses);
                refused = refused.into_iter().chain(new).min();
                self.gather(checker);
            }
            self.take_turns();
            self.decisions.decide(&checker.world, &self.posed);
            self.keep_first(checker, found);
        }
        refused
    }

    /// Culls all links, and closes the configurations in which inner spheres prove a hit.
    fn look_for_contacts(
        &mut self,
        checker: &BatchChecker<N>,
        poses: &[Pose],
        found: &mut [Option<Hit<N::Answer>>],
    ) {
        let row = self.poses_of(checker, poses);
        let Self { culling, taken, search: FirstHitSearch { distances, .. }, .. } = self;
        let links = checker.rows.link_set.len();
        let constant_answer = checker.world.narrow.constant_answer();
        distances.resize(links * ROW, f32::INFINITY);
        let row = (row, taken.len());
        self.search.open = culling.look(checker, row, |[config, link], sphere, noted| {
            let inner = checker.bounds.concentric(link, sphere);
            let distance = checker.obstacle_grid.short_of(noted, &inner);
            distances[config * links + link] = distance;
            let obstacle = noted.likeliest;
            let Some(answer) = constant_answer.as_ref().filter(|_| distance <= 0.0) else {
                return false;
            };
            let touches = checker.allows(link, obstacle);
            if touches {
                found[config] = Some(Hit {
                    configuration: (taken.start + config) as u32,
                    link: link as u32,
                    other: Other::Obstacle(checker.world.names[obstacle as usize]),
                    verdict: Verdict::Touching(answer.clone()),
                });
            }
            touches
        });
    }

    /// Lists for each configuration the links that are near an obstacle.
    fn rank_links(&mut self, count: usize) {
        let FirstHitSearch { distances, links, left, .. } = &mut self.search;
        links.resize(count * ROW, 0);
        left.clear();
        left.resize(ROW, 0);
        for link in 0..count {
            for config in Members::of(self.culling.near(link)) {
                links[config * count + left[config] as usize] =
                    rank(link, distances[config * count + link]);
                left[config] += 1;
            }
        }
    }

    /// Advances every configuration without pending pairs to its next link, or to its links against each other.
    /// Returns whether there is any.
    fn advance(&mut self, checker: &BatchChecker<N>) -> bool {
        let FirstHitSearch { links, left, open, folded, unfolding, waiting, .. } = &mut self.search;
        let count = checker.rows.link_set.len();
        self.due.fill(Set::default());
        *unfolding = Set::default();
        let mut is_any = false;
        for config in Members::of(*open) {
            if !waiting[config].is_empty() {
                continue;
            }
            let links = &mut links[config * count..][..left[config] as usize];
            if let Some(link) = take_least(links) {
                left[config] -= 1;
                self.due[link_of(link)].add(config);
                is_any = true;
            } else if folded.has(config) {
                folded.remove(config);
                unfolding.add(config);
                is_any = true;
            } else {
                open.remove(config);
            }
        }
        for (pair, &(k, l)) in checker.rows.link_set.self_pairs.iter().enumerate() {
            let met = self.culling.met(pair) & *unfolding;
            self.due[k as usize] |= met;
            self.due[l as usize] |= met;
        }
        is_any
    }

    /// Lists the pairs of each configuration's current link, in order.
    fn gather(&mut self, checker: &BatchChecker<N>) {
        let FirstHitSearch { near, waiting, ends, .. } = &mut self.search;
        for link in 0..checker.rows.link_set.len() {
            let new = self.posed.fresh(link);
            if new.is_empty() {
                continue;
            }
            let base = near.len();
            self.posed.append_pairs(checker, &self.culling, link, near);
            // Where the pairs of each object end, if it has any.
            ends.clear();
            ends.resize(new.len(), base);
            for (pair, end) in near[base..].iter().zip(base + 1..) {
                ends[pair.j as usize - new.start] = end;
            }
            let mut start = base;
            for (object, &end) in new.zip(&*ends) {
                let config = self.posed.configuration(object as u32);
                let end = start.max(end);
                waiting[config] = start..end;
                start = end;
            }
        }
        Members::of(self.search.unfolding).for_each(|config| self.gather_links(checker, config));
        self.search.unfolded |= self.search.unfolding;
    }

    /// Lists the links of a configuration that are near each other.
    fn gather_links(&mut self, checker: &BatchChecker<N>, config: usize) {
        let first = self.search.near.len();
        for (pair, &links) in checker.rows.link_set.self_pairs.iter().enumerate() {
            if self.culling.met(pair).has(config) {
                self.search.near.extend(self.posed.self_pair(config, links));
            }
        }
        self.search.waiting[config] = first..self.search.near.len();
    }

    /// Takes the next pairs of every configuration: few each of many configurations, or many each of few.
    fn take_turns(&mut self) {
        let FirstHitSearch { near, waiting, open, unfolded, .. } = &mut self.search;
        let each = (ENOUGH / open.len().max(1)).max(1);
        self.decisions.clear();
        for config in Members::of(*open) {
            let Range { start, end } = &mut waiting[config];
            let next = *start..(*start + each).min(*end);
            *start = next.end;
            let against = if unfolded.has(config) { Against::Links } else { Against::Obstacles };
            let pairs = self.decisions.pairs_mut(against);
            match next.len() {
                1 => pairs.push(near[next.start]),
                _ => pairs.extend_from_slice(&near[next]),
            }
        }
    }

    /// Writes the first hit of each configuration, and closes those that touch.
    fn keep_first(&mut self, checker: &BatchChecker<N>, found: &mut [Option<Hit<N::Answer>>]) {
        let mut open = self.search.open;
        for (against, pair, verdict) in self.decisions.hits() {
            let (config, hit) = self.hit(checker, (against, pair), verdict);
            if !hit.touches() {
                found[config].get_or_insert(hit);
                continue;
            }
            if !found[config].as_ref().is_some_and(Hit::touches) {
                found[config] = Some(hit);
            }
            open.remove(config);
        }
        self.search.open = open;
    }
}

/// Removes the least; the last takes its place.
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
