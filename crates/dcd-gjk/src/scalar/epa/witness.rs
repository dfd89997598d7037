//! The points of the two bodies that a direction of depth or distance belongs to.

use super::hull::{Face, Hull};
use super::lattice::{
    LatticeDifference, Normal, POINT_BITS, Point, Vertex, as_normal, cross, dot, minus, rounded,
    shortened,
};
use super::wide::Wide;
use dcd_geom::glam::DVec3;

/// A vertex of the difference and its weight in a convex combination; the weights need not sum
/// to 1.
pub(super) type Weighted = (Vertex, f64);

/// The corners of the face through which the ray from the origin along `normal` leaves the hull,
/// weighted so that their mean is on that ray.
///
/// Begins at the face that looks along the ray most and crosses any edge that the ray passes on
/// the outside of: coplanar triangles share the nearest plane, and the first one need not be hit.
pub(super) fn where_ray_leaves(hull: &Hull, normal: &Normal) -> [Weighted; 3] {
    // 80 bits and twice 83 of the vertices are a determinant of 249.
    let ray = shortened(normal, POINT_BITS as u32 - 2);
    let mut face = hull.facing(rounded(normal));
    let mut passes = sides(hull, face, ray);
    for _ in 0..hull.faces() {
        let Some(k) = (0..3).filter(|&k| passes[k] < Wide::ZERO).min_by_key(|&k| passes[k]) else {
            break;
        };
        let next = hull.face(face.neighbours[k]);
        if dot(&next.normal, ray) <= Wide::ZERO {
            break;
        }
        face = next;
        passes = sides(hull, face, ray);
    }
    // The weight of a corner is the determinant of the edge across from it.
    [0, 1, 2].map(|k| {
        let weight = passes[(k + 1) % 3].to_f64().max(0.0);
        (*hull.vertex(face.vertices[k]), weight)
    })
}

/// On which side of each edge of the face the ray passes, positive inside, exactly.
fn sides(hull: &Hull, face: &Face, ray: Point) -> [Wide; 3] {
    let w = face.vertices.map(|k| hull.vertex(k).w);
    [0, 1, 2].map(|k| dot(&cross(w[k], w[(k + 1) % 3]), ray))
}

impl LatticeDifference<'_> {
    /// The points of A and of B that the weights give, world frame, lattice units.
    pub(super) fn witnesses(&self, weighted: &[Weighted]) -> [DVec3; 2] {
        // An apex has no weight where the origin is in the difference, but for rounding.
        let real = || weighted.iter().filter(|(vertex, _)| !vertex.is_apex());
        let total: f64 = real().map(|(_, weight)| weight).sum();
        let Some((first, _)) = real().next() else {
            return [DVec3::ZERO; 2];
        };
        let base = self.corners(first);
        let mut means = base.map(as_vector);
        for (vertex, weight) in real() {
            let share = weight / total;
            if share > 0.0 {
                for ((mean, corner), base) in means.iter_mut().zip(self.corners(vertex)).zip(base) {
                    *mean += as_vector(minus(corner, base)) * share;
                }
            }
        }
        means
    }
}

fn as_vector(p: Point) -> DVec3 {
    rounded(&as_normal(p))
}
