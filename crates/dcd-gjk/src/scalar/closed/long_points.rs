//! Two points that are the nearest of two cores but for rounding: how far apart the cores are, in double-double.
//!
//! The points prove it from above. From below the direction between them does, without what of it is along the edges on which
//! they are: a part so small that its square is nothing (docs/numerics/proofs.md, "closed forms").

use super::segments::PosedCore;
use super::{SIZES, UNIT};
use crate::double_double::{DoubleDouble, EPSILON, Sum, two_sum};
use crate::simplex::{Scalar, Triple};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Pose};

/// How far the length of the points' difference may be off. Unit: [`EPSILON`]·m. Derived: 28.
const PADDING: f64 = 64.0;

/// How much of a distance the bounds may differ by, no unit: below an f64's last bit.
const CLOSED: f64 = f64::EPSILON / 16.0;

/// The largest deviation of a pose: its columns are of unit length and square to each other but for that.
const TURNED: f64 = 1e-6;

/// The largest cosine between the direction and an edge on which a point is. No unit. Larger: false bounds, from a seventh of
/// [`OUTWARD`] on. Smaller: more pairs that need the search.
const LEVEL: f64 = 1e-9;

/// The least cosine between the direction and an edge at whose end a point is. No unit.
const OUTWARD: f64 = 1e-7;

/// The largest cosine of two edges, one of each core, on which the points are. No unit: one less the least eigenvalue of their
/// products. Larger: see [`LEVEL`].
const CROSSING: f64 = 0.9;

/// What a cosine may be off by. Unit: u, and the deviation.
const COSINE: f64 = 16.0;

/// How far apart two cores are less their radii, and what that may be off by, given a point of each in its own frame and the
/// pair's size m; `None` where it is not known to the last bit of an f64, or the points are not the nearest.
pub(super) fn gap(cores: [PosedCore<'_>; 2], points: [DVec3; 2], size: f64) -> Option<(f64, f64)> {
    let w = difference(cores.map(|core| core.pose), points);
    let length = DoubleDouble::sum_of_products(&w, &w).sqrt();
    let high = length.to_f64();
    // False for NaN.
    if !(SIZES.contains(&high) && cores.iter().all(|core| core.pose.deviation() <= TURNED)) {
        return None;
    }
    let direction = DVec3::from_array(w.map(DoubleDouble::to_f64)) / high;
    let tilt = squared_tilt(cores, points, direction)?;
    let [of_a, of_b] = cores.map(|core| core.radius);
    let radius = two_sum(of_a, of_b);
    let value = length.minus(&radius).to_f64();
    let lost = tilt * high + EPSILON * (PADDING * size + 10.0 * high + 3.0 * radius.to_f64());
    let error_bound = crate::distance::rounded_up(value.abs() * (CLOSED + f64::EPSILON));
    // Of cores that all but meet the direction is not known.
    (lost <= CLOSED * value.abs().min(high)).then_some((value, error_bound))
}

/// The difference of two points, each in the frame of its pose, in world axes: exactly but for [`PADDING`].
pub(super) fn difference([a, b]: [&Pose; 2], [in_a, in_b]: [DVec3; 2]) -> Triple<DoubleDouble> {
    let (turn_a, turn_b) = (a.rotation().to_cols_array_2d(), b.rotation().to_cols_array_2d());
    let (from_a, from_b) = (a.translation().to_array(), b.translation().to_array());
    let (has_a, has_b) = (in_a != DVec3::ZERO, in_b != DVec3::ZERO);
    let (in_a, in_b) = (in_a.to_array(), in_b.to_array());
    [0, 1, 2].map(|c| {
        let mut sum = Sum::default();
        sum.add(from_a[c]);
        sum.add(-from_b[c]);
        for k in 0..3 {
            if has_a {
                sum.add_product(turn_a[k][c], in_a[k]);
            }
            if has_b {
                sum.add_product(-turn_b[k][c], in_b[k]);
            }
        }
        sum.total()
    })
}

/// At least the square of the part of a direction, from b's point to a's, that is along the edges on which the points are; `None`
/// where another point of a core may be nearer, or that part is not small.
fn squared_tilt(cores: [PosedCore<'_>; 2], points: [DVec3; 2], direction: DVec3) -> Option<f64> {
    let mut free = [(0, DVec3::ZERO); 2];
    let mut sum = 0.0;
    for side in 0..2 {
        let [low, high] = extent(cores[side])?.map(|corner| corner.to_array());
        let point = points[side].to_array();
        let sense = if side == 0 { 1.0 } else { -1.0 };
        let unsure = COSINE * UNIT + cores[side].pose.deviation();
        for k in (0..3).filter(|&k| low[k] < high[k]) {
            let axis = cores[side].pose.rotation().col(k);
            // How fast the points part where that one moves along the axis.
            let cosine = sense * axis.dot(direction);
            let outward = match point[k] {
                x if x == low[k] => cosine,
                x if x == high[k] => -cosine,
                x if low[k] < x && x < high[k] => {
                    let along = cosine.abs() + COSINE * UNIT;
                    free[side] = (free[side].0 + 1, axis);
                    sum += along * along;
                    continue;
                }
                _ => return None,
            };
            if !(outward - unsure >= OUTWARD) {
                return None;
            }
        }
    }
    let [(of_a, edge_a), (of_b, edge_b)] = free;
    let is_level = sum <= LEVEL * LEVEL;
    let are_apart = match of_a.min(of_b) {
        0 => true,
        _ => of_a.max(of_b) == 1 && edge_a.dot(edge_b).abs() <= CROSSING,
    };
    // Of edges that are all but square to each other the part is their sum, of two that cross at most that by the least eigenvalue.
    let share = if of_a.min(of_b) == 0 { 1.1 } else { 1.1 / (1.0 - CROSSING) };
    (is_level && are_apart).then_some(sum * share)
}

/// The two corners of the box along its frame's axes that a core is; `None` of others.
fn extent(core: PosedCore<'_>) -> Option<[DVec3; 2]> {
    match (core.kind, core.vertices) {
        (Kind::Cuboid { half_extents }, _) => Some([-half_extents, half_extents]),
        (_, &[point]) => Some([point, point]),
        (_, &[p, q]) if p.x == q.x && p.y == q.y => Some([p.min(q), p.max(q)]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::{Polytope, glam::DQuat};

    /// The gap of two shapes by a point of each.
    fn of(shapes: [&Polytope; 2], poses: [&Pose; 2], points: [DVec3; 2]) -> Option<(f64, f64)> {
        gap([0, 1].map(|k| PosedCore::polytope(shapes[k], poses[k])), points, 8.0)
    }

    fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose::from_translation(DVec3::new(x, y, z)).unwrap()
    }

    #[test]
    fn the_gap_of_nearest_points_is_known_to_the_last_bit_and_that_of_others_is_not() {
        let (cube, ball) = (Polytope::cuboid(DVec3::ONE).unwrap(), Polytope::sphere(0.5).unwrap());
        let here = at(1e6, 0.0, 0.0);
        let by =
            |there: &Pose, point: DVec3| of([&cube, &ball], [&here, there], [point, DVec3::ZERO]);
        // Before a face, an edge and a corner.
        let face = at(1e6 + 3.0, 0.5, 0.25);
        assert_eq!(by(&face, DVec3::new(1.0, 0.5, 0.25)).map(|found| found.0), Some(1.5));
        let edge = at(1e6 + 4.0, 5.0, 0.25);
        assert_eq!(by(&edge, DVec3::new(1.0, 1.0, 0.25)).map(|found| found.0), Some(4.5));
        let corner = at(1e6 + 2.0, 3.0, -3.0);
        assert_eq!(by(&corner, DVec3::new(1.0, 1.0, -1.0)).map(|found| found.0), Some(2.5));
        // Beside the nearest, at another end, outside, inside.
        for point in
            [(1.0, 0.5, 0.25 + 1e-6), (-1.0, 0.5, 0.25), (1.5, 0.5, 0.25), (0.0, 0.5, 0.25)]
        {
            assert_eq!(by(&face, point.into()), None, "{point:?}");
        }
        // Level with the edge of a face, where rounding says on which side.
        let level = at(1e6 + 3.0, 1.0, 0.25);
        assert_eq!(by(&level, DVec3::new(1.0, 1.0, 0.25)), None);
    }

    #[test]
    fn edges_that_cross_have_a_gap_and_those_that_are_nearly_parallel_none() {
        let bar = Polytope::capsule(1.0, 0.25).unwrap();
        let turned =
            |angle: f64, x: f64| Pose::new(DQuat::from_rotation_x(angle), DVec3::X * x).unwrap();
        let by = |angle: f64, x: f64| {
            of([&bar, &bar], [&at(0.0, 0.0, 0.0), &turned(angle, x)], [DVec3::ZERO; 2])
        };
        let (apart, bound) = by(1.0, 2.0).unwrap();
        assert!(apart == 1.5 && bound < 4e-16, "{apart} {bound}");
        assert_eq!(by(1.0, 0.125).map(|found| found.0), Some(-0.375));
        assert_eq!(by(0.25, 2.0), None);
        // Cores that meet.
        assert_eq!(by(1.0, 0.0), None);
        assert_eq!(by(1.0, 1e-16), None);
    }
}
