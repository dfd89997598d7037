//! How deep a convex part is pressed into the face of a triangle: a formula with its proof, where the part's deepest
//! point is under the triangle and far enough from its edges (docs/numerics/proofs.md, "pressed into a triangle").

use super::reach::Couple;
use super::side::Part;
use crate::epa::Depth;
use dcd_geom::SupportMap;
use dcd_geom::glam::DVec3;

/// By how much a certificate's inequalities must hold, relative to the pair's size: more than all rounding.
const CLEAR: f64 = 1e-9;

/// Products of two lengths, metres², whose squares are clear of underflow. Smaller: directions that are rounding.
const SHORTEST: f64 = 1e-150;

impl Couple<'_> {
    /// The depth along the normal of the one triangle, from the first to the second; `None` where it is not proved to
    /// be the least.
    pub(super) fn pressed(&self) -> Option<Depth> {
        let triangle = match self.parts() {
            [Part::Triangle { .. }, Part::Triangle { .. }] => return None,
            [Part::Triangle { .. }, _] => 0,
            [_, Part::Triangle { .. }] => 1,
            _ => return None,
        };
        let (Part::Triangle { corners, radius: swept, .. }, Part::Shape(other)) =
            (&self.parts()[triangle], &self.parts()[1 - triangle])
        else {
            return None;
        };
        if !other.centre_is_inside() {
            return None;
        }
        // World axes, from the triangle's origin.
        let sense = if triangle == 0 { 1.0 } else { -1.0 };
        let turn = *self.poses()[triangle].rotation();
        let corners = corners.map(|corner| turn * corner);
        let to_other = self.delta() * sense;
        let turn_other = *self.poses()[1 - triangle].rotation();
        let centre = turn_other * other.inner().centre + to_other;
        let [p, q, r] = corners;
        let product = (q - p).cross(r - p);
        let area = product.length();
        // Written so that NaN is no triangle.
        if !(area > SHORTEST) {
            return None;
        }
        let mut normal = product / area;
        if normal.dot(centre - p) < 0.0 {
            normal = -normal;
        }
        let deepest = turn_other * other.support(turn_other.transpose() * -normal).point + to_other;
        let heights = corners.map(|corner| normal.dot(corner - deepest));
        let low = heights[0].min(heights[1]).min(heights[2]);
        let high = heights[0].max(heights[1]).max(heights[2]);
        let other_radius = other.radius();
        let radius = swept + other_radius;
        let clear = CLEAR * self.size();
        // How far the core's middle and the edges must be.
        let (above, beside) =
            if low >= 0.0 { (high, high) } else { (high + radius, high + 2.0 * radius) };
        let height = normal.dot(centre - p);
        if !(low + radius > 0.0 && height >= above + clear) {
            return None;
        }
        // The line from the deepest point to the middle, and where it goes through the plane.
        let axis = centre - deepest;
        let through = deepest + axis * (high / (high + height));
        let is_clear = |from: DVec3, to: DVec3, opposite: DVec3| {
            let side = (to - from).cross(axis);
            let length = side.length();
            // On which side of an edge the triangle is would be rounding where its corners are in a line.
            let width = side.dot(opposite - from);
            let inside = side.dot(through - from) * width.signum();
            // Written so that NaN is not clear.
            length > SHORTEST
                && width.abs() >= clear * length
                && inside >= (beside + clear) * length
        };
        if !(is_clear(p, q, r) && is_clear(q, r, p) && is_clear(r, p, q)) {
            return None;
        }
        let depth = high + radius;
        let error_bound = (high - low) + 2.0 * self.slack();
        let origin = self.poses()[triangle].translation();
        let point_other = origin + (deepest - normal * other_radius);
        let point_triangle = point_other + normal * depth;
        let (point_a, point_b) = if triangle == 0 {
            (point_triangle, point_other)
        } else {
            (point_other, point_triangle)
        };
        (depth > 0.0 && depth.is_finite()).then_some(Depth {
            depth,
            normal: normal * sense,
            point_a,
            point_b,
            error_bound,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::reach::tests::vector;
    use crate::{Depths, PairSolver, PosedShape, Verdict};
    use dcd_geom::glam::DQuat;
    use dcd_geom::{Polytope, Pose, Shape};

    #[test]
    fn what_is_pressed_is_as_deep_as_the_search_finds() {
        let hull = |state: &mut u64| (0..12).map(|_| vector(state) * 0.4).collect();
        let mut state = 11;
        let bodies = [
            Shape::capsule(0.3, 0.1).unwrap(),
            Shape::cuboid(DVec3::new(0.3, 0.2, 0.4)).unwrap(),
            Shape::cuboid(DVec3::new(0.3, 0.2, 0.2)).unwrap().swept(0.1).unwrap(),
            Shape::hull(hull(&mut state)).unwrap(),
            Shape::cylinder(0.3, 0.2).unwrap(),
            Shape::cone(0.3, 0.2).unwrap(),
        ];
        let (mut found, mut shallow) = ([0; 6], 0);
        for round in 0..6000 {
            let body = &bodies[round % 6];
            let size = [1.0, 0.3, 3.0, 1e-2][round / 6 % 4];
            let corners = [0; 3].map(|_| vector(&mut state) * size);
            let far = if round % 5 == 0 { vector(&mut state) * 1e4 } else { DVec3::ZERO };
            let turn = DQuat::from_scaled_axis(vector(&mut state) * 3.0);
            let swept = if round % 7 == 0 { 0.05 } else { 0.0 };
            let on = corners[0].lerp(corners[1], 0.4).lerp(corners[2], 0.3);
            let pose = Pose::new(turn, far).unwrap();
            let offset = vector(&mut state).normalize_or(DVec3::X) * 0.25;
            let turn = DQuat::from_scaled_axis(vector(&mut state) * 3.0);
            let body_pose = Pose::new(turn, far + *pose.rotation() * on + offset).unwrap();
            let triangle =
                Shape::from(Polytope::mesh_triangle(corners).unwrap().rounded(swept).unwrap());
            let part = Part::Triangle { corners, reach: 4.0 * size, radius: swept };
            let parts = [part, Part::Shape(body)];
            let poses = [&pose, &body_pose];
            let of = |order: [usize; 2]| {
                Couple::of(order.map(|k| parts[k]), order.map(|k| poses[k])).unwrap().pressed()
            };
            let Some(pressed) = of([0, 1]) else {
                assert!(of([1, 0]).is_none(), "{round}");
                continue;
            };
            let back = of([1, 0]).unwrap();
            assert!(back.normal.distance(-pressed.normal) < 1e-12, "{round}");
            let (a, b) = (
                PosedShape { shape: &triangle, pose: &pose },
                PosedShape { shape: body, pose: &body_pose },
            );
            let Verdict::Touching(due) = Depths.solve(a, b, &mut Default::default()) else {
                // What just touches is not known to.
                assert!(pressed.depth <= pressed.error_bound, "{round}: {pressed:?}");
                shallow += 1;
                continue;
            };
            let off = (due.depth - pressed.depth).abs();
            let slack = 1e-13 * (1.0 + far.length());
            let bound = due.error_bound + pressed.error_bound + slack;
            assert!(off <= bound, "{round}: {off} {pressed:?} {due:?}");
            let between = pressed.point_a - pressed.point_b - pressed.normal * pressed.depth;
            assert!(between.length() <= 1e-12 * (1.0 + far.length()), "{round}: {pressed:?}");
            found[round % 6] += 1;
        }
        assert!(found.iter().all(|&count| count > 20) && shallow < 10, "{found:?}, {shallow}");
    }
}
