//! How deep a convex part is pressed into the face of a triangle: a formula with its proof, where the part's deepest
//! point is under the triangle and far enough from its edges (docs/numerics/proofs.md, "pressed into a triangle").

use super::reach::Couple;
use super::side::Part;
use crate::epa::Depth;
use dcd_geom::SupportMap;
use dcd_geom::glam::DVec3;

/// By how much a certificate's inequalities must hold, relative to the pair's size: room for all rounding.
const CLEAR: f64 = 1e-9;

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
        let mut normal = (q - p).cross(r - p).try_normalize()?;
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
            let Some(side) = (to - from).cross(axis).try_normalize() else { return false };
            let inside = side.dot(through - from) * side.dot(opposite - from).signum();
            inside >= beside + clear
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
