//! Branch and bound over the joints between two links.

use super::samples::{Ranges, between_ends, unit};
use crate::edge::{Chain, Extents};
use crate::kinematics::{JointFrame, moved};
use crate::{Motion, Robot, RobotError};
use dcd_gjk::distance::{DistanceResult, distance_at};
use dcd_gjk::{Accuracy, PosedShape};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// From how many random states a search looks for where to go downhill, and from how many of them, the nearest,
/// it does. Fewer: more pairs that touch in few states are taken for pairs that never do.
const STARTS: usize = 1024;
const DESCENTS: usize = 24;

/// The first step of a value, relative to its range, and the one at which a descent ends.
const FIRST_STEP: f64 = 0.1;
const LAST_STEP: f64 = 1e-3;

/// What is known of a pair in the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Proved: nowhere within the limits do they touch.
    Free,
    /// Somewhere they touch, or are not proved apart.
    Touches,
    /// Neither was found.
    Open,
}

/// A robot's joints and their ranges.
pub(super) struct Joints<'a> {
    robot: &'a Robot,
    ranges: &'a Ranges,
    /// For each link the joint that moves it.
    above: Vec<Option<usize>>,
}

/// A box of values, those between the two links alone.
struct Node {
    /// At most the least distance in it, metres.
    lower: f64,
    middle: Vec<f64>,
    half: Vec<f64>,
    /// Which value brings the two nearest.
    widest: usize,
}

impl PartialEq for Node {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Node {}

impl PartialOrd for Node {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Node {
    /// The box that may hold the nearest state is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.lower.total_cmp(&self.lower)
    }
}

/// Two parts of the two links, and how they move.
struct PartPair {
    parts: [usize; 2],
    chains: [Chain; 2],
    /// How many moving joints carry both.
    common: usize,
}

/// What is between two links.
struct Between {
    /// The joints from the last link that carries both to each, fixed ones too.
    paths: [Vec<usize>; 2],
    /// The values that move them.
    values: Vec<usize>,
    pairs: Vec<PartPair>,
}

impl<'a> Joints<'a> {
    pub(super) fn of(robot: &'a Robot, ranges: &'a Ranges) -> Self {
        let mut above = vec![None; robot.links().len()];
        for (index, joint) in robot.joints().iter().enumerate() {
            above[joint.child] = Some(index);
        }
        Self { robot, ranges, above }
    }

    /// Whether two links touch somewhere, in at most `nodes` boxes, then downhill from states drawn from `seed`;
    /// `parts` are those of each link.
    pub(super) fn search(
        &self,
        links: [usize; 2],
        parts: &[Vec<usize>],
        (nodes, seed): (usize, u64),
    ) -> Result<Outcome, RobotError> {
        let between = self.between(links, parts);
        let orients =
            |&joint: &usize| matches!(self.robot.joints()[joint].motion, Motion::Orients { .. });
        if between.paths.iter().flatten().any(orients) {
            return Ok(Outcome::Open);
        }
        let range = |&value: &usize| self.ranges.values[value];
        let middle = between.values.iter().map(range).map(|[a, b]| 0.5 * a + 0.5 * b).collect();
        // A little more: the middle is rounded.
        let half = between
            .values
            .iter()
            .map(range)
            .map(|[a, b]| (0.5 * b - 0.5 * a) * (1.0 + 1e-12) + 1e-12 * (a.abs() + b.abs()));
        let Some(first) = self.node(&between, middle, half.collect())? else {
            return Ok(Outcome::Touches);
        };
        let mut open = BinaryHeap::from([first]);
        let mut looked_at = 1;
        while let Some(node) = open.pop() {
            if node.lower > 0.0 {
                // No other is nearer.
                let is_whole = between.values.iter().all(|&value| self.ranges.is_whole[value]);
                return Ok(if is_whole { Outcome::Free } else { Outcome::Open });
            }
            if between.values.is_empty() {
                // Nothing moves: apart, by less than the bound of their distance.
                return Ok(Outcome::Open);
            }
            if looked_at >= nodes {
                return self.downhill(&between, seed);
            }
            for side in [-0.5, 0.5] {
                let (mut middle, mut half) = (node.middle.clone(), node.half.clone());
                middle[node.widest] += side * half[node.widest];
                half[node.widest] *= 0.5 * (1.0 + 1e-12);
                // The middle is rounded.
                half[node.widest] += f64::EPSILON * middle[node.widest].abs();
                let Some(part) = self.node(&between, middle, half)? else {
                    return Ok(Outcome::Touches);
                };
                looked_at += 1;
                open.push(part);
            }
        }
        Ok(Outcome::Open)
    }

    /// Looks for a touching state from the nearest of many random ones downhill, value by value, by steps that
    /// are halved where none brings the two nearer.
    fn downhill(&self, between: &Between, seed: u64) -> Result<Outcome, RobotError> {
        let ranges: Vec<[f64; 2]> =
            between.values.iter().map(|&value| self.ranges.values[value]).collect();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let still = vec![0.0; ranges.len()];
        let mut starts = Vec::with_capacity(STARTS);
        for _ in 0..STARTS {
            let drawn = ranges.iter().map(|range| between_ends(range, unit(&mut random))).collect();
            match self.node(between, drawn, still.clone())? {
                Some(node) => starts.push(node),
                None => return Ok(Outcome::Touches),
            }
        }
        starts.sort_by(|a, b| a.lower.total_cmp(&b.lower));
        for mut at in starts.into_iter().take(DESCENTS) {
            let mut step = FIRST_STEP;
            while step > LAST_STEP {
                let mut is_nearer = false;
                for (value, &[lower, upper]) in ranges.iter().enumerate() {
                    for side in [-step, step] {
                        let mut state = at.middle.clone();
                        state[value] = (state[value] + side * (upper - lower)).clamp(lower, upper);
                        match self.node(between, state, still.clone())? {
                            None => return Ok(Outcome::Touches),
                            Some(next) if next.lower < at.lower => (at, is_nearer) = (next, true),
                            Some(_) => {}
                        }
                    }
                }
                if !is_nearer {
                    step *= 0.5;
                }
            }
        }
        Ok(Outcome::Open)
    }

    /// The box with its bound; none where the links are not proved apart at its middle.
    fn node(
        &self,
        between: &Between,
        middle: Vec<f64>,
        half: Vec<f64>,
    ) -> Result<Option<Node>, RobotError> {
        let mut state = vec![0.0; self.robot.variables().len()];
        let mut extents = Extents::still(state.len());
        for ((&value, &at), &half) in between.values.iter().zip(&middle).zip(&half) {
            state[value] = at;
            extents.size[value] = at.abs() + half;
            extents.rate[value] = half;
        }
        let frames = between.paths.each_ref().map(|path| self.frame(path, &state));
        let mut lower = f64::INFINITY;
        let mut moves = vec![0.0; state.len()];
        for PartPair { parts, chains, common } in &between.pairs {
            let mut poses = Vec::with_capacity(2);
            for (frame, &part) in frames.iter().zip(parts) {
                let pose = frame.then(&self.robot.parts()[part].origin).pose();
                let user = || format!("part {part} of robot {:?}", self.robot.name);
                poses.push(pose.map_err(|error| RobotError::Pose { user: user(), error })?);
            }
            let posed = |k: usize| {
                let shape = &self.robot.parts()[parts[k]].shape;
                PosedShape { shape, pose: &poses[k] }
            };
            let found = match distance_at(Accuracy::F32, posed(0), posed(1)).0 {
                DistanceResult::Apart(found) => found.lower(),
                _ => return Ok(None),
            };
            let mut closing = 0.0;
            for chain in chains {
                let lengths = chain.lengths(&extents);
                // Once where the distance is taken, once where it is relied on.
                closing += lengths.speed_from(*common) + 2.0 * lengths.deviation;
                for (&joint, &speed) in chain.joints.iter().zip(&lengths.speed).skip(*common) {
                    if let Some(by) = self.robot.joints()[joint as usize].motion.drive() {
                        moves[by.value] += speed;
                    }
                }
            }
            lower = lower.min(found - closing * (1.0 + 1e-9));
        }
        let moved = |k: &usize| moves[between.values[*k]];
        let widest = (0..middle.len()).max_by(|j, k| moved(j).total_cmp(&moved(k))).unwrap_or(0);
        Ok(Some(Node { lower, middle, half, widest }))
    }

    /// A link's frame in that of the last link that carries both.
    fn frame(&self, path: &[usize], state: &[f64]) -> JointFrame {
        let joints = path.iter().map(|&joint| &self.robot.joints()[joint]);
        joints.fold(JointFrame::IDENTITY, |frame, joint| {
            moved(&frame.then(&joint.origin), joint, state)
        })
    }

    /// The values that move one of two links against the other.
    pub(super) fn values_between(&self, links: [usize; 2]) -> Vec<usize> {
        self.values_of(&self.paths(links).0)
    }

    /// The joints from the last link that carries both to each, and how many moving ones carry both.
    fn paths(&self, links: [usize; 2]) -> ([Vec<usize>; 2], usize) {
        let [mut path_a, mut path_b] = links.map(|link| {
            let first = self.above[link];
            let next = |&joint: &usize| self.above[self.robot.joints()[joint].parent];
            let mut path: Vec<usize> = std::iter::successors(first, next).collect();
            path.reverse();
            path
        });
        let shared = path_a.iter().zip(&path_b).take_while(|(a, b)| a == b).count();
        // As many as a chain counts.
        let moves = |&&joint: &&usize| self.robot.joints()[joint].motion != Motion::Fixed;
        let common = path_a[..shared].iter().filter(moves).count();
        path_a.drain(..shared);
        path_b.drain(..shared);
        ([path_a, path_b], common)
    }

    fn values_of(&self, paths: &[Vec<usize>; 2]) -> Vec<usize> {
        let drive = |&joint: &usize| self.robot.joints()[joint].motion.drive();
        let mut values: Vec<usize> =
            paths.iter().flatten().filter_map(drive).map(|by| by.value).collect();
        values.sort_unstable();
        values.dedup();
        values
    }

    fn between(&self, links: [usize; 2], parts: &[Vec<usize>]) -> Between {
        let (paths, common) = self.paths(links);
        let values = self.values_of(&paths);
        let mut pairs = Vec::new();
        for &i in &parts[links[0]] {
            for &j in &parts[links[1]] {
                let chains = [i, j].map(|k| {
                    let part = &self.robot.parts()[k];
                    Chain::of(self.robot, (part, &part.shape), &self.above)
                });
                pairs.push(PartPair { parts: [i, j], chains, common });
            }
        }
        Between { paths, values, pairs }
    }
}
