//! How far a frame that is computed in f32 may be from the one of [`Robot::place`](crate::Robot::place)
//! (docs/numerics/proofs.md, "states in lanes").

use super::{FARTHEST, Moves};
use crate::kinematics::JointFrame;
use glam::{DMat3, DVec3};

/// What rounding to f32 loses of a number.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// What the sine and the cosine of an angle up to [`super::MOST_TURNED`] may be off, the angle's rounding included.
const SINE_ERROR: f64 = 8.0 * ROUNDING;

/// What a computed rotation may be off for the rest of the bounds to hold.
const MOST_OFF: f64 = 1e-3;

/// The largest norm of anything that stands for a rotation, true or computed.
const NORM: f64 = 1.01;

/// Entries of a matrix below that are left out.
pub(super) const NOTHING: f64 = 1.0 / (1u64 << 36) as f64;

/// What a rotated and shifted vector loses: six roundings of each coordinate, √3 times that for the three.
const SUMS: f64 = 11.0 * ROUNDING;

/// How far a computed frame may be from the one of [`Robot::place`](crate::Robot::place): a point p of the link is off by
/// `turn`·|p| + `shift` + `per_slid`·(what the joints slide in all), metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in super::super) struct FrameError {
    pub(in super::super) turn: f64,
    pub(in super::super) shift: f64,
    pub(in super::super) per_slid: f64,
    /// How far the link's origin may be from the world's, with what the joints slide left out, metres.
    reach: f64,
}

impl FrameError {
    pub(super) fn of_base(base: &JointFrame) -> Self {
        let at = base.translation;
        Self {
            turn: lost(&base.rotation),
            shift: at.distance(at.as_vec3().as_dvec3()),
            per_slid: 0.0,
            reach: at.length(),
        }
    }

    pub(super) fn is_bounded(&self) -> bool {
        self.turn <= MOST_OFF && self.shift <= FARTHEST && self.reach <= FARTHEST
    }

    /// Of a joint's frame at rest: where it is turned, three products of an entry lose 3u of 1 each, all nine 9u;
    /// where it is shifted, a coordinate loses at most six times u of what is summed, which is below the two
    /// lengths.
    pub(super) fn at_rest(mut self, origin: &JointFrame, (is_turned, lost): (bool, f64)) -> Self {
        let by = origin.translation;
        if by != DVec3::ZERO {
            let far = by.length();
            let rounded = by.distance(by.as_vec3().as_dvec3());
            self.shift += NORM * (self.turn * far + rounded);
            self.shift += SUMS * (far + self.reach);
            self.per_slid += SUMS;
            self.reach += NORM * far;
        }
        if is_turned {
            self.turn = NORM * (self.turn + lost + 12.0 * ROUNDING);
        } else {
            // Entries so small that they were left out.
            self.turn += NORM * lost;
        }
        self
    }

    /// After what moves the joint.
    pub(super) fn moved(mut self, moves: &Moves) -> Self {
        match moves {
            Moves::Never => {}
            // Four entries are off; six are sums of two products.
            Moves::About(..) => {
                self.turn = NORM * (self.turn + 2.0 * SINE_ERROR + 6.0 * ROUNDING);
            }
            // Nine entries are off by two sines and eight roundings each; nine are sums of three products.
            Moves::Turns(..) => {
                self.turn = NORM * (self.turn + 6.0 * SINE_ERROR + 36.0 * ROUNDING);
            }
            Moves::Orients(_) => self.turn = NORM * (self.turn + 14.0 * ROUNDING),
            Moves::Slides(..) => {
                self.shift += SUMS * self.reach;
                self.per_slid += NORM * (self.turn + 4.0 * ROUNDING) + 2.0 * SUMS;
            }
        }
        self
    }

    /// What a comparison of anything within `size` of the link's origin may be off, metres, without what slides; and
    /// that for each metre that joints slide.
    pub(in super::super) fn of_size(&self, size: f32) -> [f32; 2] {
        let sum = NORM * (self.shift + self.turn * f64::from(size));
        [sum as f32 + f32::MIN_POSITIVE, (NORM * self.per_slid) as f32]
    }
}

/// What rounding to f32 takes off a rotation: the root of the sum of the squares, and what is left out as nothing.
pub(super) fn lost(rotation: &DMat3) -> f64 {
    let off = |x: f64| if x.abs() < NOTHING { x } else { x - f64::from(x as f32) };
    let squares = rotation.to_cols_array().map(|x| off(x) * off(x));
    squares.iter().sum::<f64>().sqrt()
}
