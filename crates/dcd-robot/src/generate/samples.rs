//! States drawn within the limits, and which pairs touch in them.

use super::PairReason;
use crate::{Motion, Robot, RobotError};
use dcd_geom::{Pose, SphereBounds};
use dcd_gjk::{PosedShape, Verdict, certified};
use glam::DQuat;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::PI;

/// The least and the largest value that each value of a state may have.
pub(super) struct Ranges {
    pub(super) values: Vec<[f64; 2]>,
    /// Whether all that the value may be is within them, or repeats what is.
    pub(super) is_whole: Vec<bool>,
    /// Whether it may be what no sample has: without limits, and nothing repeats.
    is_endless: Vec<bool>,
    /// Where quaternions begin.
    quaternions: Vec<usize>,
}

/// What a joint without limits is sampled in, if it slides: metres. Nothing is concluded of what it moves.
const SLIDE: f64 = 1.0;

/// A little more than half a turn, so that the ends of a full turn overlap.
const HALF_TURN: f64 = PI * (1.0 + 1e-9);

impl Ranges {
    pub(super) fn of(robot: &Robot) -> Result<Self, RobotError> {
        let count = robot.variables().len();
        let mut ranges = Self {
            values: vec![[0.0; 2]; count],
            is_whole: vec![true; count],
            is_endless: vec![false; count],
            quaternions: Vec::new(),
        };
        let mut is_limited = vec![false; count];
        for joint in robot.joints() {
            if let Motion::Orients { first } = joint.motion {
                ranges.quaternions.push(first);
                ranges.is_whole[first] = false;
            }
            let Some(by) = joint.motion.drive() else { continue };
            let turns = matches!(joint.motion, Motion::Turns { .. });
            let leads = robot.variables()[by.value] == joint.name;
            match joint.limits {
                Some([lower, upper]) if leads && lower > upper => {
                    let user = format!("joint {:?}", joint.name);
                    let why = format!("its limits are {lower:e} to {upper:e}");
                    return Err(RobotError::Refused { user, why });
                }
                Some(limits) if leads => {
                    (ranges.values[by.value], is_limited[by.value]) = (limits, true);
                }
                None if leads && turns => ranges.values[by.value] = [-HALF_TURN, HALF_TURN],
                None if leads => ranges.values[by.value] = [-SLIDE, SLIDE],
                _ => {}
            }
        }
        // What follows a joint without limits repeats with it only if it turns as often, or a whole
        // number of times.
        for joint in robot.joints() {
            let Some(by) = joint.motion.drive() else { continue };
            let is_limited = is_limited[by.value];
            let turns = matches!(joint.motion, Motion::Turns { .. });
            let repeats = turns && by.factor.fract() == 0.0;
            if !(is_limited || repeats) {
                ranges.is_whole[by.value] = false;
                ranges.is_endless[by.value] = true;
            }
        }
        Ok(ranges)
    }

    /// Whether any of these values may be what no sample has.
    pub(super) fn are_endless(&self, values: &[usize]) -> bool {
        values.iter().any(|&value| self.is_endless[value])
    }

    /// The state nearest to zero.
    fn rest(&self) -> Vec<f64> {
        let values = self.values.iter();
        let mut rest: Vec<f64> = values.map(|&[lower, upper]| 0f64.clamp(lower, upper)).collect();
        self.quaternions.iter().for_each(|first| rest[first + 3] = 1.0);
        rest
    }

    fn draw(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let mut state: Vec<f64> =
            self.values.iter().map(|range| between_ends(range, unit(random))).collect();
        for &first in &self.quaternions {
            // In the unit ball of quaternions, not too near to its middle.
            let mut drawn = DQuat::IDENTITY * 0.0;
            while !(1e-3..=1.0).contains(&drawn.length_squared()) {
                drawn = DQuat::from_array([(); 4].map(|()| 2.0 * unit(random) - 1.0));
            }
            state[first..first + 4].copy_from_slice(&drawn.normalize().to_array());
        }
        state
    }
}

/// A number from 0 up to 1.
pub(super) fn unit(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// That part of the way from the least value to the largest.
pub(super) fn between_ends(&[lower, upper]: &[f64; 2], part: f64) -> f64 {
    (lower + (upper - lower) * part).min(upper)
}

/// What samples find of pairs of links.
pub(super) struct Sampled {
    /// The pairs that may touch, and why: they touch always, or at rest.
    pub(super) reasons: Vec<([usize; 2], PairReason)>,
    /// Those that touch in no sample.
    pub(super) apart: Vec<[usize; 2]>,
}

/// A pair that is still sampled.
struct Open {
    links: [usize; 2],
    touches_at_rest: bool,
    /// How often it touched.
    touched: usize,
}

/// `parts` are those of each link.
pub(super) fn of(
    robot: &Robot,
    ranges: &Ranges,
    parts: &[Vec<usize>],
    pairs: Vec<[usize; 2]>,
    (samples, seed): (usize, u64),
) -> Result<Sampled, RobotError> {
    let mut place = Place::new(robot, parts);
    place.go_to(&ranges.rest())?;
    let mut open: Vec<Open> = pairs
        .into_iter()
        .map(|links| {
            let touches_at_rest = place.touches(links);
            Open { links, touches_at_rest, touched: usize::from(touches_at_rest) }
        })
        .collect();
    let mut reasons = Vec::new();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for sample in 1..=samples {
        place.go_to(&ranges.draw(&mut random))?;
        open.retain_mut(|pair| {
            pair.touched += usize::from(place.touches(pair.links));
            // It touches in some and not in others: a pair to be checked.
            let changes = pair.touched != 0 && pair.touched != sample + 1;
            if changes && pair.touches_at_rest {
                reasons.push((pair.links, PairReason::Default));
            }
            !changes
        });
    }
    let (always, apart): (Vec<Open>, Vec<Open>) = open.into_iter().partition(|p| p.touched > 0);
    // Rest alone is no "always".
    let reason = if samples > 0 { PairReason::Always } else { PairReason::Default };
    reasons.extend(always.into_iter().map(|pair| (pair.links, reason)));
    Ok(Sampled { reasons, apart: apart.into_iter().map(|pair| pair.links).collect() })
}

/// The robot in a state.
struct Place<'a> {
    robot: &'a Robot,
    parts: &'a [Vec<usize>],
    spheres: Vec<Option<SphereBounds>>,
    poses: Vec<Pose>,
}

impl<'a> Place<'a> {
    fn new(robot: &'a Robot, parts: &'a [Vec<usize>]) -> Self {
        let spheres = robot.parts().iter().map(|part| SphereBounds::of(&part.shape)).collect();
        Self { robot, parts, spheres, poses: Vec::new() }
    }

    fn go_to(&mut self, state: &[f64]) -> Result<(), RobotError> {
        self.robot.place(state, &mut self.poses)
    }

    /// Whether two links are not proved apart.
    fn touches(&self, [a, b]: [usize; 2]) -> bool {
        self.parts[a].iter().any(|&i| self.parts[b].iter().any(|&j| self.parts_touch(i, j)))
    }

    fn parts_touch(&self, i: usize, j: usize) -> bool {
        let [a, b] = [i, j].map(|k| {
            let (shape, pose) = (&self.robot.parts()[k].shape, &self.poses[k]);
            PosedShape { shape, pose }
        });
        if let (Some(in_a), Some(in_b)) = (&self.spheres[i], &self.spheres[j]) {
            let (in_a, in_b) = (in_a.sphere(a.pose), in_b.sphere(b.pose));
            let between = in_a.centre.as_dvec3().distance(in_b.centre.as_dvec3()) * (1.0 - 1e-12);
            if between > f64::from(in_a.radius) + f64::from(in_b.radius) {
                return false;
            }
        }
        certified::overlap_of(a, b).0 != Verdict::Apart
    }
}
