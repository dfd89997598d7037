//! How far a polytope is above a plane, in double-double: nearly as many digits as the exact gap has, at a tenth of the time.

use super::super::SIZES;
use super::{GAP, Gap, Plane, UNIT, numbers};
use crate::double_double::{DoubleDouble, EPSILON};
use crate::simplex::{Scalar, dot, minus};
use dcd_geom::{Polytope, Pose, Vector};

/// How much of the gap double-double may lose. Unit: u of the gap: of the 16u that are stated of an exact one a few are lost by
/// the quotient. Larger: gaps outside their bound. Smaller: more that are taken exactly.
const LOST: f64 = 8.0;

/// The gap of which f64 knows that much, metres, negative for an overlap; as good as an exact one, or `None`.
pub(super) fn of(
    known: &Gap,
    plane: Plane<'_>,
    (polytope, pose): (&Polytope, &Pose),
) -> Option<f64> {
    // Every operation is that of f64, with this unit for u.
    let lost = known.error * (EPSILON / UNIT);
    let lengths = [plane.half_space.normal().norm1(), known.error / (GAP * UNIT)];
    // False for NaN.
    if !lengths.iter().all(|length| SIZES.contains(length)) {
        return None;
    }
    let (normal, offset) = plane.in_numbers::<DoubleDouble>();
    let axes = [pose.rotation().x_axis, pose.rotation().y_axis, pose.rotation().z_axis];
    let along = axes.map(|axis| dot(&normal, &numbers(axis)));
    // What is not among the lowest in f64 is not the lowest.
    let in_f64 = pose.rotation().transpose() * known.normal;
    let most = in_f64.dot(known.lowest) + 2.0 * known.error;
    let near = polytope.vertices().iter().filter(|vertex| in_f64.dot(**vertex) <= most);
    let heights = near.map(|&vertex| dot(&along, &numbers(vertex)));
    let lowest = heights.reduce(|a, b| if b.minus(&a).is_negative() { b } else { a })?;
    let delta = minus(&numbers(pose.translation()), &numbers(plane.pose.translation()));
    let above = lowest.plus(&dot(&normal, &delta).minus(&offset));
    let length = dot(&normal, &normal).sqrt();
    let radius = DoubleDouble::from(plane.half_space.swept_radius())
        .plus(&DoubleDouble::from(polytope.swept_radius()));
    let gap = above.minus(&radius.times(&length));
    let is_known = lost <= LOST * UNIT * gap.to_f64().abs();
    is_known.then(|| gap.divided_by(length).to_f64())
}

#[cfg(test)]
mod tests;
