//! A point beside a hull or a triangle: by the planes of the faces, or the nearest point of the highest face.
//!
//! What is proposed is proved by the vertices, as any point and any direction are: no vertex is nearer along it by more
//! than is stated.

use super::Beside;
use crate::closed::nearest_of_triangle;
use crate::query::point::Heights;
use dcd_geom::Polytope;
use dcd_geom::glam::DVec3;

/// How far the two bounds of a distance may be apart, relative to the sizes: far within the accuracy of f32. Larger: wider
/// bounds. Smaller: more pairs that need a search.
const CLOSE: f64 = 1e-9;

/// What a height over a plane loses. Unit: u of the sizes. Three products, two sums, a normal of unit length but for 4u.
const HEIGHT: f64 = 16.0;

/// Beside a hull; `None` where neither a face nor its edges hold what is nearest.
pub(super) fn beside_hull(polytope: &Polytope, point: DVec3) -> Option<Beside> {
    let planes = polytope.planes();
    let size = polytope.reach() + point.length();
    if !(planes.has_inside() && planes.thickness() <= CLOSE * polytope.reach()) {
        return None;
    }
    let margin = HEIGHT * super::UNIT * size;
    let Heights { highest, face, is_below_inner } = Heights::of(point, planes, margin);
    if is_below_inner {
        // The sphere up to the nearest inner plane is inside, and beyond the outer one is nothing.
        let unsure = planes.thickness() + margin;
        return Some(Beside { distance: highest, outward: planes.normal(face), unsure });
    }
    if !(highest > 0.0) {
        return None;
    }
    let facets = polytope.facets();
    let vertices = polytope.vertices();
    let &[p, q, r] = facets.corners(facets.facets().get(face)?) else { return None };
    let corners = [p, q, r].map(|k| vertices[k as usize]);
    beside_proposed(vertices, point, nearest_of_triangle(corners, point), size)
}

/// Beside a triangle.
pub(super) fn beside_triangle(corners: &[DVec3], point: DVec3, reach: f64) -> Option<Beside> {
    let &[p, q, r] = corners else { return None };
    let nearest = nearest_of_triangle([p, q, r], point);
    beside_proposed(corners, point, nearest, reach + point.length())
}

/// Beside the hull of vertices of which a point is perhaps the nearest.
fn beside_proposed(vertices: &[DVec3], point: DVec3, nearest: DVec3, size: f64) -> Option<Beside> {
    let Beside { distance, outward, .. } = super::outside(point - nearest)?;
    let along = |v: &DVec3| outward.dot(*v);
    let farthest = vertices
        .iter()
        .map(along)
        .fold(f64::NEG_INFINITY, |most, x| if x > most { x } else { most });
    // At most and, along the direction, at least that far.
    let unsure = (distance - (outward.dot(point) - farthest)).max(0.0);
    (unsure <= CLOSE * size).then_some(Beside { distance, outward, unsure })
}
