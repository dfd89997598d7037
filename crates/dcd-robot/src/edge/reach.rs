//! How far the points of a robot's parts can move while its joints do.

use super::ROUNDED_UP;
use super::bounding_volumes::as_ball;
use super::path::{Extents, U};
use crate::model::Drive;
use crate::{Motion, Part, Robot};
use dcd_geom::Shape;

/// What an f64 pose may be off by for each joint of its chain: units of 2⁻⁵³ of the chain's length. A
/// joint's frame is turned by roll, pitch and yaw (three rotations of 48u, two products of 9u), by its own
/// angle (48u), and multiplied twice (9u each): 228u (docs/numerics/proofs.md, "edges").
const POSE: f64 = 264.0;

/// What the way between two quaternions may be off by, beside that: units of 2⁻⁵³ rad, of the chain's length. A
/// quaternion at right angles to the first loses some 8u over the sine of the angle between the two, which is
/// 1e-3 at the least where it counts (docs/numerics/proofs.md, "edges").
const SLERP: f64 = 65536.0;

/// The joints between the root and what moves with a part: the part, or its padded shape.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    /// Those that move, the root's first.
    pub(crate) joints: Vec<u32>,
    /// How many joints there are, fixed ones too.
    depth: usize,
    /// What has to be added up for [`Lengths`], from the link to the root.
    steps: Vec<Step>,
    /// How far a point of the shape is from the link's frame; of a sphere its centre, which moves as all of it does.
    extent: f64,
    /// What the shape reaches farther than that.
    rest: f64,
    base: f64,
    /// Whether some joint turns by a quaternion.
    orients: bool,
}

#[derive(Clone, Copy, Debug)]
struct Step {
    /// Its number among the chain's joints, if it moves, and what moves it.
    moving: Option<(usize, Drive, bool)>,
    /// How far its frame is from its parent's.
    offset: f64,
}

/// A chain's lengths on one path.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lengths {
    /// For each moving joint how fast it moves any point of the shape, metres a unit of t.
    pub(crate) speed: Vec<f64>,
    /// For each moving joint how fast it turns, rad a unit of t; 0 where it slides.
    pub(crate) turn: Vec<f64>,
    /// For each moving joint what its own change of speed adds to a point's acceleration.
    pub(crate) change: Vec<f64>,
    /// How far an f64 pose at the rounded state may put a point from where it is.
    pub(crate) deviation: f64,
    /// By how much the axes of its joints may be turned from where they are there, rad.
    pub(crate) turned: f64,
    /// How far from the robot's base any point of it is, and the base from the origin, together.
    pub(crate) length: f64,
}

impl Chain {
    /// Of a shape that moves as the part does.
    pub(crate) fn of(
        robot: &Robot,
        (part, shape): (&Part, &Shape),
        above: &[Option<usize>],
    ) -> Self {
        let (extent, rest) = match as_ball(shape) {
            Some(ball) => (ball.reach(), ball.swept_radius()),
            None => (shape.reach(), 0.0),
        };
        let mut chain = Self {
            joints: Vec::new(),
            depth: 0,
            steps: Vec::new(),
            extent: part.origin.translation.length() + extent * (1.0 + 1e-9),
            rest,
            base: robot.base.translation.length(),
            orients: false,
        };
        let mut link = part.link;
        while let Some(index) = above[link] {
            let joint = &robot.joints()[index];
            let by = match joint.motion {
                // Of a quaternion the first number stands for all.
                Motion::Orients { first } => Some(Drive { value: first, factor: 1.0, offset: 0.0 }),
                _ => joint.motion.drive(),
            };
            let moving = by.map(|by| {
                chain.joints.push(index as u32);
                let slides = matches!(joint.motion, Motion::Slides { .. });
                chain.orients |= matches!(joint.motion, Motion::Orients { .. });
                (chain.joints.len() - 1, by, slides)
            });
            chain.steps.push(Step { moving, offset: joint.origin.translation.length() });
            chain.depth += 1;
            link = joint.parent;
        }
        // Counted from the link until here.
        chain.joints.reverse();
        let count = chain.joints.len();
        for step in &mut chain.steps {
            if let Some((number, ..)) = &mut step.moving {
                *number = count - 1 - *number;
            }
        }
        chain
    }

    /// How far any point of the shape is from the link's frame.
    pub(super) fn reach(&self) -> f64 {
        self.extent + self.rest
    }

    /// How far from the link's frame what moves by [`Lengths::speed`] at most may be.
    pub(super) fn extent(&self) -> f64 {
        self.extent
    }

    /// The chain of what is that far from the link's frame.
    pub(super) fn with_extent(&self, extent: f64) -> Self {
        Self { extent, rest: 0.0, ..self.clone() }
    }

    pub(crate) fn lengths(&self, path: &Extents) -> Lengths {
        let none = vec![0.0; self.joints.len()];
        let (speed, turn) = (none.clone(), none.clone());
        let mut lengths = Lengths { speed, turn, change: none, ..Lengths::default() };
        let mut reach = self.extent;
        let mut off = 0.0;
        for step in &self.steps {
            if let Some((number, by, slides)) = step.moving {
                let factor = by.factor.abs();
                let size = factor * path.size[by.value] + by.offset.abs();
                let rate = factor * path.rate[by.value] * ROUNDED_UP;
                let change = factor * path.change[by.value] * ROUNDED_UP;
                // A slide moves every point alike, a turn by its distance from the axis.
                let arm = if slides { 1.0 } else { reach };
                lengths.speed[number] = rate * arm;
                lengths.turn[number] = if slides { 0.0 } else { rate };
                lengths.change[number] = change * arm;
                // The value's rounding on the path, times the factor, plus the offset.
                off += 20.0 * U * size * arm;
                if slides {
                    reach += size;
                }
            }
            reach += step.offset;
        }
        let length = (reach + self.rest + self.base) * ROUNDED_UP;
        let of_quaternions = if self.orients { SLERP } else { 0.0 };
        let of_poses = POSE * (self.depth + 2) as f64 + of_quaternions;
        lengths.length = length;
        lengths.turned = of_poses * U;
        lengths.deviation = off * ROUNDED_UP + lengths.turned * length;
        lengths
    }
}

impl Lengths {
    /// How large the acceleration of any point is at most, against the frames of the joints: an entry for each joint, what comes
    /// from that one and those behind it, and 0.
    pub(super) fn accelerations(&self) -> Vec<f64> {
        let mut accelerations = vec![0.0; self.speed.len() + 1];
        let mut behind = 0.0;
        for k in (0..self.speed.len()).rev() {
            let change = self.change[k] + (self.speed[k] + 2.0 * behind) * self.turn[k];
            accelerations[k] = accelerations[k + 1] + change;
            behind += self.speed[k];
        }
        accelerations
    }

    /// How fast any point moves against the frame that the joints before the `first` leave where it is.
    pub(crate) fn speed_from(&self, first: usize) -> f64 {
        self.speed[first..].iter().sum()
    }
}
