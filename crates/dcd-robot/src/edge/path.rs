//! Paths in joint space.

use crate::kinematics::quaternion;
use crate::{Motion, Robot, RobotError};
use glam::{DQuat, DVec3};

/// Half the distance of 1 to the next f64.
pub(super) const U: f64 = f64::EPSILON / 2.0;

/// A path of the joint values, t from 0 to 1. The truth is the one of real numbers between the given f64
/// values; revolute and continuous joints turn as the numbers say, never the short way round.
#[derive(Clone, Debug, PartialEq)]
pub enum JointPath {
    /// From one state straight to the other.
    Straight([Vec<f64>; 2]),
    /// A cubic Bézier curve by its control points; it begins at the first and ends at the last.
    Bezier([Vec<f64>; 4]),
}

/// How near to opposite two quaternions may be: the length of their sum. No unit. Smaller: the way between
/// them is off by more than [`reach`](super::reach) allows for.
const OPPOSITE: f64 = 1e-3;

/// Where in a state the robot's quaternions begin.
fn quaternions(robot: &Robot) -> impl Iterator<Item = usize> {
    robot.joints().iter().filter_map(|joint| match joint.motion {
        Motion::Orients { first } => Some(first),
        _ => None,
    })
}

/// The way from one unit quaternion to another on the great circle, at constant speed: the way that their
/// numbers go, which may be the longer one of the rotations.
struct Slerp {
    from: DQuat,
    /// A unit quaternion at right angles to the first, on the way.
    across: DQuat,
    /// Between the two, rad: half of what the rotation turns by.
    angle: f64,
}

impl Slerp {
    fn new(from: DQuat, to: DQuat) -> Self {
        let angle = 2.0 * libm::atan2((to - from).length(), (to + from).length());
        let across = to - from * from.dot(to);
        let length = across.length();
        let across = if length > 0.0 { across / length } else { from * 0.0 };
        Self { from, across, angle }
    }

    fn at(&self, t: f64) -> DQuat {
        let (sin, cos) = libm::sincos(t * self.angle);
        (self.from * cos + self.across * sin).normalize()
    }
}

/// What bounds the values of a path, one of each for each value of a state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Extents {
    /// The largest |q|.
    pub(crate) size: Vec<f64>,
    /// The largest |dq/dt|.
    pub(crate) rate: Vec<f64>,
    /// The largest |d²q/dt²|.
    pub(super) change: Vec<f64>,
}

impl Extents {
    /// Of so many values that are 0 and stay so.
    pub(crate) fn still(values: usize) -> Self {
        let none = vec![0.0; values];
        Self { size: none.clone(), rate: none.clone(), change: none }
    }
}

impl JointPath {
    /// Two of a straight path, four of a curve; a value for each of [`Robot::variables`] in each.
    pub fn control_points(&self) -> &[Vec<f64>] {
        match self {
            Self::Straight(ends) => ends,
            Self::Bezier(points) => points,
        }
    }

    /// That each control point is a state of the robot; that its quaternions have one way between them.
    pub(super) fn check(&self, robot: &Robot) -> Result<(), RobotError> {
        let points = self.control_points();
        points.iter().try_for_each(|point| robot.check_state(point))?;
        for first in quaternions(robot) {
            let user = format!("value {:?}", robot.variables()[first]);
            let refused =
                |why: &str| Err(RobotError::Refused { user: user.clone(), why: why.to_owned() });
            let same = |point: &Vec<f64>| point[first..first + 4] == points[0][first..first + 4];
            match self {
                Self::Straight([from, to]) => {
                    let [from, to] = [from, to].map(|state| quaternion(state, first).normalize());
                    if (from + to).length() < OPPOSITE {
                        return refused("between opposite quaternions there is no one way");
                    }
                }
                Self::Bezier(_) if points.iter().all(same) => {}
                Self::Bezier(_) => return refused("a curve of quaternions is not supported"),
            }
        }
        Ok(())
    }

    /// How far a quaternion turns, rad, and about which axis of its parent's frame: no more than a turn, on
    /// a straight path.
    pub(super) fn turn(&self, first: usize) -> DVec3 {
        match self {
            Self::Straight([from, to]) => {
                let [from, to] = [from, to].map(|state| quaternion(state, first).normalize());
                let by = to * from.conjugate();
                let axis = DVec3::new(by.x, by.y, by.z).normalize_or_zero();
                axis * (2.0 * Slerp::new(from, to).angle)
            }
            Self::Bezier(_) => DVec3::ZERO,
        }
    }

    /// The values at t: of a quaternion by slerp, the way that its numbers go; of all others within 16u of
    /// the largest control value each (docs/numerics/proofs.md, "edges"); those given, at the ends.
    pub fn state_at(&self, robot: &Robot, t: f64, state: &mut Vec<f64>) {
        self.linear_at(t, state);
        if let (Self::Straight([from, to]), true) = (self, t > 0.0 && t < 1.0) {
            for first in quaternions(robot) {
                let [from, to] = [from, to].map(|state| quaternion(state, first).normalize());
                let between = Slerp::new(from, to).at(t);
                state[first..first + 4].copy_from_slice(&between.to_array());
            }
        }
    }

    /// The same, with quaternions taken for what they are not: four numbers.
    fn linear_at(&self, t: f64, state: &mut Vec<f64>) {
        let points = self.control_points();
        state.clear();
        if t <= 0.0 || t >= 1.0 {
            let end = if t <= 0.0 { points.first() } else { points.last() };
            state.extend(end.into_iter().flatten());
            return;
        }
        let between = |a: f64, b: f64| a + t * (b - a);
        match self {
            Self::Straight([from, to]) => {
                state.extend(from.iter().zip(to).map(|(&a, &b)| between(a, b)));
            }
            Self::Bezier([p0, p1, p2, p3]) => state.extend((0..p0.len()).map(|k| {
                let (a, b, c) =
                    (between(p0[k], p1[k]), between(p1[k], p2[k]), between(p2[k], p3[k]));
                between(between(a, b), between(b, c))
            })),
        }
    }

    /// dq/dt at t, for each value.
    pub(super) fn rates_at(&self, t: f64, rates: &mut Vec<f64>) {
        rates.clear();
        match self {
            Self::Straight([from, to]) => rates.extend(from.iter().zip(to).map(|(a, b)| b - a)),
            Self::Bezier([p0, p1, p2, p3]) => rates.extend((0..p0.len()).map(|k| {
                let (a, b, c) = (p1[k] - p0[k], p2[k] - p1[k], p3[k] - p2[k]);
                let s = 1.0 - t;
                3.0 * (s * s * a + 2.0 * s * t * b + t * t * c)
            })),
        }
    }

    pub(super) fn extents(&self, robot: &Robot) -> Extents {
        let mut extents = self.linear_extents();
        for first in quaternions(robot) {
            // The angle is off by some u of itself.
            extents.rate[first] = self.turn(first).length() * (1.0 + 1e-12);
            extents.change[first] = 0.0;
        }
        extents
    }

    fn linear_extents(&self) -> Extents {
        let points = self.control_points();
        let values = points.first().map_or(0, Vec::len);
        let degree = (points.len() - 1) as f64;
        // A Bézier curve stays among its control points, and so do its derivatives.
        let most = |k: usize, of: &dyn Fn(&[f64]) -> f64, width: usize| {
            let column: Vec<f64> = points.iter().map(|point| point[k]).collect();
            column.windows(width).map(of).fold(0.0, f64::max)
        };
        let rounded_up = 1.0 + 16.0 * U;
        Extents {
            size: (0..values).map(|k| most(k, &|w| w[0].abs(), 1)).collect(),
            rate: (0..values)
                .map(|k| degree * rounded_up * most(k, &|w| (w[1] - w[0]).abs(), 2))
                .collect(),
            change: (0..values)
                .map(|k| {
                    // Second differences lose what first ones are rounded by.
                    let second = |w: &[f64]| {
                        let rounding = 8.0 * U * (w[0].abs() + 2.0 * w[1].abs() + w[2].abs());
                        ((w[2] - w[1]) - (w[1] - w[0])).abs() + rounding
                    };
                    let factor = degree * (degree - 1.0) * rounded_up;
                    if factor > 0.0 { factor * most(k, &second, 3) } else { 0.0 }
                })
                .collect(),
        }
    }
}
