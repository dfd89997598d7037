//! A point beside a hull, a triangle or a mesh: by the planes of the faces, or the nearest point of the highest face.
//!
//! What is proposed is proved by the vertices, as any point and any direction are: no vertex is nearer along it by more
//! than is stated.

use super::Beside;
use crate::closed::nearest_of_triangle;
use crate::query::point::Heights;
use dcd_geom::glam::DVec3;
use dcd_geom::{Mesh, Polytope};
use dcd_simd::PointDistance;

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
#[inline]
pub(super) fn beside_triangle(corners: &[DVec3], point: DVec3, reach: f64) -> Option<Beside> {
    let &[p, q, r] = corners else { return None };
    let nearest = nearest_of_triangle([p, q, r], point);
    beside_proposed(corners, point, nearest, reach + point.length())
}

/// Beside the nearest triangle of a mesh: of equals the one with the smallest index; `None` where the point is on one.
///
/// Only boxes of triangles are left out that are farther than the point of a triangle that was seen.
#[inline(never)]
pub(super) fn beside_mesh(mesh: &Mesh, point: DVec3) -> Option<Beside> {
    let test = PointDistance::new(point);
    let mut best: Option<(Beside, u32)> = None;
    let (mut lower, mut is_known) = (f64::INFINITY, true);
    mesh.tree().visit(&test, f32::MAX, &mut |triangle, _| {
        let found = mesh.corners(triangle as usize).and_then(|corners| {
            let away = point - nearest_of_triangle(corners, point);
            proved(&corners, point, away)
        });
        let Some(found) = found else {
            is_known = false;
            return -1.0;
        };
        lower = lower.min(found.distance - found.unsure);
        let nearer = |&(known, number): &(Beside, u32)| {
            found.distance < known.distance || found.distance == known.distance && triangle < number
        };
        if best.as_ref().is_none_or(nearer) {
            best = Some((found, triangle));
        }
        best.map_or(f32::MAX, |(nearest, _)| test.key_of(nearest.distance))
    });
    let (nearest, _) = best.filter(|_| is_known)?;
    // Another may be nearer than the nearest by what it is off by.
    let unsure = (nearest.distance - lower).max(nearest.unsure);
    (unsure <= CLOSE * (mesh.reach() + point.length())).then_some(Beside { unsure, ..nearest })
}

/// Calls `meet` for each triangle of a mesh whose box is within a distance of a point, with where the point is beside it,
/// if that is known; to the first `None`, which is the answer then.
pub(super) fn triangles_within(
    mesh: &Mesh,
    (point, distance): (DVec3, f64),
    mut meet: impl FnMut(u32, &[DVec3; 3], Option<Beside>) -> Option<()>,
) -> Option<()> {
    let test = PointDistance::new(point);
    let limit = test.key_of(distance);
    let size = mesh.reach() + point.length();
    let mut all = Some(());
    mesh.tree().visit_within(&test, limit, &mut |triangle| {
        let Some(corners) = mesh.corners(triangle as usize) else { return true };
        let nearest = nearest_of_triangle(corners, point);
        all = meet(triangle, &corners, beside_proposed(&corners, point, nearest, size));
        all.is_some()
    });
    all
}

/// The same of these triangles of a mesh.
pub(super) fn triangles_of(
    mesh: &Mesh,
    point: DVec3,
    mut triangles: impl Iterator<Item = u32>,
    mut meet: impl FnMut(u32, &[DVec3; 3], Option<Beside>) -> Option<()>,
) -> Option<()> {
    let size = mesh.reach() + point.length();
    triangles.try_for_each(|triangle| {
        let corners = mesh.corners(triangle as usize)?;
        let nearest = nearest_of_triangle(corners, point);
        meet(triangle, &corners, beside_proposed(&corners, point, nearest, size))
    })
}

/// Beside the hull of vertices of which a point is perhaps the nearest.
#[inline(always)]
fn beside_proposed(vertices: &[DVec3], point: DVec3, nearest: DVec3, size: f64) -> Option<Beside> {
    proved(vertices, point, point - nearest).filter(|found| found.unsure <= CLOSE * size)
}

/// Beside the hull of vertices, given the point less one of the hull that is perhaps the nearest.
#[inline(always)]
fn proved(vertices: &[DVec3], point: DVec3, away: DVec3) -> Option<Beside> {
    let Beside { distance, outward, .. } = super::outside(away)?;
    let along = |v: &DVec3| outward.dot(*v);
    let farthest = vertices
        .iter()
        .map(along)
        .fold(f64::NEG_INFINITY, |most, x| if x > most { x } else { most });
    // At most and, along the direction, at least that far.
    let unsure = (distance - (outward.dot(point) - farthest)).max(0.0);
    Some(Beside { distance, outward, unsure })
}
