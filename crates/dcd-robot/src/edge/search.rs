//! The search through a path's intervals.

mod bounds;
mod distances;
mod movers;
mod near;
mod planes;
mod slices;
#[cfg(test)]
mod tests;

use super::groups::{Group, Groups};
use super::path::JointPath;
use super::place::PlaceOnPath;
use super::{Before, Edge, EdgeAnswer, EdgeChecker, EdgePair, EdgeReason, ROUNDED_UP};
use crate::RobotError;
use dcd_exec::Par;
use glam::DVec3;
use movers::Mover;
use slices::{Slices, Spheres};
use std::ops::Range;
use std::sync::Arc;

/// An interval is not halved below this length. No unit. Smaller: more intervals where shapes graze each
/// other. Larger: gaps below a micrometre stay undecided.
const SHORTEST: f64 = 1.0 / (1u64 << 40) as f64;

/// The length of an interval that is left as it is if it ends less than that before a hit: so the path is proved free to
/// within twice that of what touches. No unit. Smaller: more intervals before each hit (at 2⁻¹² twice as many). Larger:
/// `free_until` ends earlier.
const BEFORE_A_HIT: f64 = 1.0 / (1u64 << 8) as f64;

/// The states of a path that are looked at before any interval: in sixteenths, all at once.
const SAMPLES: [u8; 16] = [0, 16, 8, 4, 12, 2, 6, 10, 14, 1, 3, 5, 7, 9, 11, 13];

/// By how much a distance may exceed the gap along a direction that is not the nearest one's. No unit. Larger:
/// more distances that prove too little. Smaller: shorter intervals than need be.
const BETTER: f64 = 1.5;

/// How much less two links may move for a group of pairs to stay whole until they do, two halvings of the interval, if there
/// will be so many. No unit. Larger: more intervals. Smaller: more pairs are looked at one by one.
const SOON: f64 = 0.75;

pub(super) struct EdgeSearch<'a> {
    checker: &'a EdgeChecker,
    path: &'a JointPath,
    budget: usize,
    before: Before,
    /// The pairs that are searched: all, or those that are not proved far from each other before.
    pairs: Arc<[EdgePair]>,
    groups: Arc<Groups>,
    /// For each object that moves what bounds its motion.
    movers: Vec<Mover>,
    /// The same of obstacles.
    still: Mover,
    /// For each pair the direction in which its gap was last found, in the frame of the joints that carry both;
    /// zero before.
    directions: Vec<DVec3>,
    /// A distance that some pair has somewhere on the path: what comes no nearer than half of it is proved.
    nearest: f64,
    clearance: f64,
    nodes: usize,
    hit: Option<(f64, [u32; 2])>,
    /// The first interval that is left, with a pair of it.
    left: Option<([f64; 2], [u32; 2], EdgeReason)>,
    at: PlaceOnPath,
    /// Of the node: half its length, and [`EdgeSearch::shortest_of`].
    half: f64,
    shortest: f64,
    /// The pairs of all nodes on the stack; groups of pairs by numbers behind those of all pairs.
    open: Vec<u32>,
    slices: Slices,
    /// What the slices are to be computed from, if it is known.
    spheres: Option<Spheres>,
    is_even: bool,
}

struct Node {
    from: f64,
    to: f64,
    pairs: Range<usize>,
}

/// How far a group of pairs is.
enum Reach {
    /// Proved: none of them comes near in the interval.
    Beyond,
    /// Far at the interval's middle, so that it will be on a shorter one.
    Moves,
    Near,
}

/// What a direction proves of a pair.
struct Gaps {
    /// The pair comes no nearer than that in the interval; below 0 where nothing is proved.
    proved: f64,
    /// At most the gap in the interval's middle.
    middle: f64,
}

/// What the spheres of a pair prove.
struct BySpheres {
    /// The pair comes no nearer than that in the interval.
    margin: f64,
    /// At the interval's middle it is no farther than that; infinite where that is not known.
    upper: f64,
    /// From one to the other where they are nearest.
    direction: DVec3,
}

impl<'a> EdgeSearch<'a> {
    pub(super) fn new(
        checker: &'a EdgeChecker,
        path: &'a JointPath,
        (budget, before): (usize, Before),
    ) -> Self {
        let extents = path.extents(checker.robot());
        let is_even = matches!(path, JointPath::Straight(_));
        let obstacles = checker.cell.obstacles();
        let (before_them, behind_them) =
            (&checker.movers[..obstacles.start], &checker.movers[obstacles.end..]);
        let movers = before_them.iter().chain(behind_them).map(|mover| {
            let Some((_, chain)) = mover else { return Mover::default() };
            let lengths = chain.lengths(&extents);
            let (mut turns, mut changes) = (0.0, 0.0);
            let before = lengths.turn.iter().map(|&turn| {
                let before = [turns, changes];
                changes += turn * turns * ROUNDED_UP;
                turns += turn * ROUNDED_UP;
                before
            });
            let before = before.collect();
            // Of the chain, of the place, and of the points in the shape's own frame.
            let length = 3.0 * lengths.length;
            Mover { before, length, turns, lengths, ..Mover::default() }
        });
        let movers: Vec<Mover> = movers.collect();
        Self {
            movers,
            still: Mover::default(),
            pairs: checker.pairs.clone(),
            groups: checker.groups.clone(),
            checker,
            path,
            budget,
            before,
            directions: Vec::new(),
            nearest: f64::INFINITY,
            clearance: f64::INFINITY,
            nodes: 0,
            hit: None,
            left: None,
            at: PlaceOnPath::default(),
            half: 0.0,
            shortest: SHORTEST,
            open: Vec::new(),
            slices: Slices::default(),
            spheres: None,
            is_even,
        }
    }

    pub(super) fn run(mut self) -> Result<Edge, RobotError> {
        self.sample()?;
        if self.hit.is_some() && self.before == Before::Anything {
            return Ok(self.edge());
        }
        let end = self.hit.map_or(1.0, |(t, _)| t);
        if end > 0.0 && self.budget > 0 {
            self.keep_near_pairs(end)?;
        }
        self.begin_directions();
        let pairs = self.pairs.len() as u32;
        self.open.extend((pairs..).take(self.groups.groups.len()));
        self.open.extend(&self.groups.single);
        let mut stack = Vec::new();
        if end > 0.0 {
            if self.hit.is_some() {
                self.slices = self.slice(end, 0.0).unwrap_or_default();
            }
            stack.push(Node { from: 0.0, to: end, pairs: 0..self.open.len() });
        }
        while let Some(node) = stack.pop() {
            // What is beyond a hit does not matter, nor is anything left to find before it.
            if let Some((t, _)) = self.hit
                && (node.from >= t || self.left.is_some() || self.before == Before::Anything)
            {
                continue;
            }
            if let Some(reason) = self.ends(&node) {
                self.leave(&node, reason);
                continue;
            }
            self.nodes += 1;
            let middle = 0.5 * (node.from + node.to);
            self.at.go_to(self.checker, self.path, middle)?;
            self.half = 0.5 * (node.to - node.from) * ROUNDED_UP;
            self.shortest = self.shortest_of(&node);
            self.open.truncate(node.pairs.end);
            let pairs = self.unproved(&node);
            if !pairs.is_empty() {
                stack.push(Node { from: middle, to: node.to, pairs: pairs.clone() });
                stack.push(Node { from: node.from, to: middle, pairs });
            }
        }
        Ok(self.edge())
    }

    /// Nothing is known yet of the pairs.
    fn begin_directions(&mut self) {
        self.directions.resize(self.pairs.len(), DVec3::ZERO);
    }

    /// Looks for a hit at a few states.
    fn sample(&mut self) -> Result<(), RobotError> {
        let Some(states) = &self.checker.states else { return Ok(()) };
        let sample = |k: u8| {
            let mut state = Vec::new();
            self.path.state_at(self.checker.robot(), f64::from(k) / 16.0, &mut state);
            state
        };
        let sampled = SAMPLES.map(sample);
        let found = states.first(&sampled, Par::Serial)?;
        let touching = SAMPLES.iter().zip(&found).filter_map(|(&k, found)| {
            let hit = found.as_ref().filter(|hit| hit.touches())?;
            Some((k, hit.pair))
        });
        if let Some((k, pair)) = touching.min_by_key(|&(k, _)| k) {
            self.hit = Some((f64::from(k) / 16.0, self.checker.in_order([pair.i, pair.j])));
        }
        Ok(())
    }

    /// The length at which the node is not halved any more. What comes near long before a hit and does not touch is told
    /// from a hit as if there were none.
    fn shortest_of(&self, node: &Node) -> f64 {
        match self.hit {
            Some((t, _)) if t - node.from <= 2.0 * BEFORE_A_HIT => BEFORE_A_HIT,
            _ => SHORTEST,
        }
    }

    /// Why the node is not looked at any more.
    fn ends(&self, node: &Node) -> Option<EdgeReason> {
        let length = node.to - node.from;
        if length <= self.shortest_of(node) {
            Some(EdgeReason::Short)
        } else if self.nodes >= self.budget {
            Some(EdgeReason::Budget)
        } else {
            None
        }
    }

    fn leave(&mut self, node: &Node, reason: EdgeReason) {
        let open = self.open.get(node.pairs.start);
        let first = |group: &Group| self.groups.members_of(group)[0];
        let pair = open.map(|&open| self.group(open).map_or(open, first));
        let pair = pair.map(|pair| self.pairs[pair as usize].objects);
        // The stack gives them in the order of t.
        if let (None, Some(pair)) = (&self.left, pair) {
            self.left = Some(([node.from, node.to], pair, reason));
        }
    }

    fn edge(self) -> Edge {
        let nodes = self.nodes;
        let left_from = self.left.map_or(1.0, |([from, _], ..)| from);
        let (answer, free_until) = match (self.hit, self.left) {
            (Some((t, pair)), _) if self.before == Before::Anything => {
                (EdgeAnswer::Hit { t, pair }, 0.0)
            }
            (Some((t, pair)), _) => (EdgeAnswer::Hit { t, pair }, left_from.min(t)),
            (None, Some((t, pair, reason))) => (EdgeAnswer::Undecided { t, pair, reason }, t[0]),
            (None, None) => (EdgeAnswer::Free { clearance: self.clearance }, 1.0),
        };
        Edge { answer, free_until, nodes }
    }

    /// The node's pairs that are not proved apart on all of it, from where the robot is now, its middle: where they
    /// are among all open ones.
    fn unproved(&mut self, node: &Node) -> Range<usize> {
        let from = self.open.len();
        // Some distance first: it proves that most others are far.
        if self.nearest == f64::INFINITY && self.hit.is_none() {
            let far = |&k: &usize| self.far(self.open[k]);
            let nearest = node.pairs.clone().min_by(|j, k| far(j).total_cmp(&far(k)));
            if let Some(k) = nearest {
                self.open.swap(node.pairs.start, k);
            }
        }
        let mut slices = self.slices.of(node);
        for k in node.pairs.clone() {
            self.take_up(self.open[k], slices);
            if k == 0 && self.nodes == 1 && self.hit.is_none() {
                self.slice_all();
                slices = self.slices.of(node);
            }
            if self.hit.is_some_and(|(t, _)| t < node.to && t > node.from) {
                // Only what is before it matters, and all of that is searched again.
                self.open.truncate(from);
                return node.pairs.clone();
            }
        }
        from..self.open.len()
    }

    /// Finds what spheres prove on all of the path, where some distance is known.
    fn slice_all(&mut self) {
        if self.nearest > 0.0
            && self.nearest.is_finite()
            && let Some(slices) = self.slice(1.0, self.nearest)
        {
            self.slices = slices;
            self.note(self.nearest);
        }
    }

    /// The group that is open by that number, if it is none of a pair.
    fn group(&self, open: u32) -> Option<&Group> {
        let number = (open as usize).checked_sub(self.pairs.len())?;
        self.groups.groups.get(number)
    }

    /// Adds to what is open what of a pair or a group is not proved.
    fn take_up(&mut self, open: u32, slices: u16) {
        if self.slices.prove(open, slices) {
            return;
        }
        let Some(group) = self.group(open).cloned() else { return self.take_up_pair(open) };
        match self.reach_of(&group) {
            Reach::Beyond => {}
            Reach::Moves => self.open.push(open),
            Reach::Near => {
                for member in group.members {
                    let pair = self.groups.members[member];
                    if !self.slices.prove(pair, slices) {
                        self.take_up_pair(pair);
                    }
                }
            }
        }
    }

    fn take_up_pair(&mut self, pair: u32) {
        if !self.is_proved(pair) {
            self.open.push(pair);
        }
    }

    /// Whether two links' spheres are so far from each other that no pair of theirs counts.
    fn reach_of(&mut self, Group { pair, .. }: &Group) -> Reach {
        pair.objects.into_iter().for_each(|object| self.update(object));
        let margin = self.by_spheres(pair).margin;
        let is_far =
            |margin: f64| self.suffices(margin) && (self.hit.is_some() || margin >= self.nearest);
        if is_far(margin) {
            self.note(margin);
            Reach::Beyond
        } else if is_far(margin + SOON * self.moved(pair)) && self.half > 2.0 * self.shortest {
            Reach::Moves
        } else {
            Reach::Near
        }
    }

    /// About how far two objects are, for an order.
    fn far(&self, open: u32) -> f64 {
        let pair = self.group(open).map_or_else(|| self.pairs[open as usize], |g| g.pair);
        self.far_pair(&pair)
    }

    fn far_pair(&self, pair: &EdgePair) -> f64 {
        let [a, b] = pair.objects;
        let [in_a, in_b] = [a, b].map(|object| {
            let whole = &self.checker.volumes[object as usize].whole;
            (self.pose(object).apply(whole.centre), whole.outer)
        });
        if self.checker.movers[b as usize].is_some() {
            return in_a.0.distance(in_b.0) - in_a.1 - in_b.1;
        }
        let local = self.local(b, in_a.0);
        self.checker.volumes[b as usize].solid.nearest(local).0 - in_a.1
    }

    /// A point in an object's own frame.
    fn local(&self, object: u32, point: DVec3) -> DVec3 {
        let pose = self.pose(object);
        pose.rotation().transpose() * (point - pose.translation())
    }

    /// Whether a clearance is so large that a larger one would not count: half of the nearest distance; none
    /// counts before a hit.
    fn suffices(&self, clearance: f64) -> bool {
        clearance > 0.0 && (self.hit.is_some() || clearance >= 0.5 * self.nearest)
    }

    fn note(&mut self, clearance: f64) -> bool {
        self.clearance = self.clearance.min(clearance);
        true
    }

    /// Whether the pair is proved apart for half of the node to either side of where the robot is now, by as much as a
    /// clearance needs.
    fn is_proved(&mut self, pair: u32) -> bool {
        let edge_pair = self.pairs[pair as usize];
        let [a, b] = edge_pair.objects;
        self.update(a);
        self.update(b);
        let found = self.by_spheres(&edge_pair);
        let suffices = self.suffices(found.margin);
        // What spheres prove is loose: a clearance is to come from directions.
        if suffices && (self.hit.is_some() || found.margin >= self.nearest) {
            return self.note(found.margin);
        }
        if self.hit.is_none() {
            self.nearest = self.nearest.min(found.upper);
        }
        // Along no direction the gap is larger than the distance, and it counts less what accelerations may do.
        let change = 0.5 * self.half * self.half * self.change(&edge_pair);
        let most = found.upper - change;
        let can_be_proved = most > 0.0 && (self.suffices(most) || most >= 0.5 * found.upper);
        if !suffices
            && !can_be_proved
            && found.upper > self.off(&edge_pair) + self.slack(&edge_pair)
        {
            return false;
        }
        let carried = self.common(&edge_pair).map(|link| *self.at.rotation(link));
        let last = self.directions[pair as usize];
        let last = carried.map_or(last, |rotation| rotation * last);
        for direction in [last, found.direction] {
            let Some(gaps) = self.along(&edge_pair, direction) else { continue };
            let proved = gaps.proved.max(found.margin);
            if self.suffices(gaps.proved) {
                self.keep(pair, carried, direction);
            }
            if self.suffices(proved) {
                return self.note(proved);
            }
            // Apart at the middle, and by enough if the interval were shorter: another direction may have a larger gap there,
            // of the distance at most, but hardly one that closes less.
            let closed = gaps.middle - gaps.proved;
            let hoped = (BETTER * gaps.middle).min(found.upper) - closed;
            if gaps.middle > 0.0 && self.suffices(gaps.middle) && !self.suffices(hoped) {
                return false;
            }
        }
        self.is_proved_by_distance(pair, carried)
    }

    fn keep(&mut self, pair: u32, carried: Option<glam::DMat3>, direction: DVec3) {
        let own = carried.map_or(direction, |rotation| rotation.transpose() * direction);
        self.directions[pair as usize] = own;
    }
}
