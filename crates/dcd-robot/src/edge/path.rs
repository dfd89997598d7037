//! Paths in joint space.

use crate::{Robot, RobotError};

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
    /// Two of a straight path, four of a curve; a value for each of [`Robot::moved_joints`] in each.
    pub fn control_points(&self) -> &[Vec<f64>] {
        match self {
            Self::Straight(ends) => ends,
            Self::Bezier(points) => points,
        }
    }

    /// That each control point is a state of the robot.
    pub(super) fn check(&self, robot: &Robot) -> Result<(), RobotError> {
        self.control_points().iter().try_for_each(|point| robot.check_state(point))
    }

    /// The values at t, within 16u of the largest control value each (docs/numerics.md, "edges"); those
    /// given, at the ends.
    pub fn at(&self, t: f64, state: &mut Vec<f64>) {
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

    pub(super) fn extents(&self) -> Extents {
        let points = self.control_points();
        let values = points.first().map_or(0, Vec::len);
        let degree = (points.len() - 1) as f64;
        // A Bézier curve stays among its control points, and so do its derivatives.
        let most = |k: usize, of: &dyn Fn(&[f64]) -> f64, width: usize| {
            let column: Vec<f64> = points.iter().map(|point| point[k]).collect();
            column.windows(width).map(of).fold(0.0, f64::max)
        };
        let room = 1.0 + 16.0 * U;
        Extents {
            size: (0..values).map(|k| most(k, &|w| w[0].abs(), 1)).collect(),
            rate: (0..values)
                .map(|k| degree * room * most(k, &|w| (w[1] - w[0]).abs(), 2))
                .collect(),
            change: (0..values)
                .map(|k| {
                    // Second differences lose what first ones are rounded by.
                    let second = |w: &[f64]| {
                        let rounding = 8.0 * U * (w[0].abs() + 2.0 * w[1].abs() + w[2].abs());
                        ((w[2] - w[1]) - (w[1] - w[0])).abs() + rounding
                    };
                    let factor = degree * (degree - 1.0) * room;
                    if factor > 0.0 { factor * most(k, &second, 3) } else { 0.0 }
                })
                .collect(),
        }
    }
}
