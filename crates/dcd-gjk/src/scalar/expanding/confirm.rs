//! The depth at the end of a search in f32, measured in f64.

use super::shallow::MOST;
use super::surface::clearance;
use super::{ExpandingSearch, Tolerance};
use crate::certificate::Bounds;
use crate::epa::Depth;
use crate::gjk::unit;
use crate::query::{Accuracy, CERTIFIED, FoundDepth};
use crate::{Difference, PosedSupport, Vertex};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Support};
use dcd_simd::ArrayVec;

/// A face that may be the nearest.
#[derive(Clone, Copy)]
pub(super) struct NearFace {
    /// At most its distance from the origin, for corners as f64 has them.
    pub(super) clearance: f64,
    pub(super) corners: [Vertex<f64>; 3],
}

/// What a search in f32 ended with: a closed surface of triangles between points of A − B.
pub(crate) struct Ending<'a> {
    /// Of the faces that may be the nearest the vertices of a and of b that make their corners.
    pub(crate) faces: &'a [[[u32; 2]; 3]],
    /// If the surface of the true points surely winds round the origin: at most the distance of the other
    /// faces, as a length of the difference.
    pub(crate) others: Option<f64>,
}

/// The least cosine between the normal of a depth and that of a face by which it may leave the surface; that of the nearest
/// face is 1. Larger: no face for a normal that rounding has turned. Smaller: witnesses by a face that is seen edge on.
pub(crate) const FACING: f64 = 0.5;

/// How far the points of a depth may be from differing by it along its normal. Unit: lengths of a difference, which is no larger
/// than 1. Larger: points beside the objects. Smaller: more pairs that are searched in f64.
const BESIDE: f64 = 1e-9;

/// The depth of polytopes that are known to touch, if it is confirmed as well as the accuracy requires; and their vertices
/// farthest along its normal. Of swept ones the search was of the cores: `None` where these are not proved to overlap.
pub(crate) fn confirmed_depth(
    difference: Difference<'_, f64, Polytope, Polytope>,
    bodies: [PosedSupport<'_, Polytope>; 2],
    accuracy: Accuracy,
    ending: &Ending<'_>,
) -> Option<FoundDepth> {
    let search = ExpandingSearch { difference, bodies, tolerance: Tolerance::of(accuracy) };
    let bounds = Bounds::of(&search.difference);
    let mut nearest = (f64::INFINITY, DVec3::ZERO);
    let mut inner = ending.others.unwrap_or(0.0);
    if ending.faces.len() > MOST {
        return None;
    }
    let mut faces = ArrayVec::<NearFace, MOST>::new();
    for &corners in ending.faces {
        let corners = corners.map(|vertices| search.vertex(vertices));
        let [p, q, r] = corners.each_ref().map(|corner| corner.w);
        let normal = (q - p).cross(r - p).try_normalize()?;
        let distance = normal.dot(p);
        let clearance = clearance(normal, [p, q, r]);
        faces.push(NearFace { clearance, corners });
        inner = inner.min(clearance);
        if distance < nearest.0 {
            nearest = (distance, normal);
        }
    }
    let direction = unit::<f64>(nearest.1.to_array())?;
    let (farthest, separation) = search.difference.lowest(-direction);
    let along = (-separation / direction.length()).max(0.0);
    let upper = -bounds.lower_bound(-direction, separation);
    let lower = if ending.others.is_some() { bounds.least_reach(inner) } else { 0.0 };
    let radius = bounds.radius();
    // Of cores that may be apart the radii overlap less than their sum.
    if radius > 0.0 && !(lower > 0.0) {
        return None;
    }
    let error = (upper - along).max(along - lower) + (bounds.swept_upper() - radius);
    let depth = along + radius;
    // What is not good enough needs no witnesses.
    let points = || search.leaving(&faces, direction, along);
    let points = search.tolerance.is_met(depth, error).then(points).flatten();
    let found = points.and_then(|points| search.depth_of(depth, error, points, direction));
    let farthest = Some([farthest.a.feature, farthest.b.feature]);
    let found = found.map(|depth| FoundDepth { depth, farthest });
    if accuracy != Accuracy::Certified {
        return found;
    }
    let found = found.filter(|found| is_certified(&found.depth));
    // Faces alone say nothing of what is swept.
    if found.is_some() || radius > 0.0 {
        return found;
    }
    search.depth_by_faces(&bounds, &faces, ending.others?)
}

/// Whether the bound is what is promised of a certified depth.
pub(super) fn is_certified(found: &Depth) -> bool {
    found.error_bound <= CERTIFIED * found.depth
}

impl ExpandingSearch<'_, Polytope> {
    fn vertex(&self, [a, b]: [u32; 2]) -> Vertex<f64> {
        let support = |vertices: &[DVec3], feature: u32| {
            // The last block is filled up with the last vertex.
            let feature = feature.min(vertices.len() as u32 - 1);
            Support { point: vertices[feature as usize], feature }
        };
        let [in_a, in_b] = &self.bodies;
        let (a, b) = (support(in_a.map.vertices(), a), support(in_b.map.vertices(), b));
        Vertex { w: self.difference.world(a.point, b.point), a, b }
    }

    /// The points of the two cores where a direction from the origin leaves the faces, which is so far away: by the one that
    /// it passes by the least. `None` where that is none of these faces.
    pub(super) fn leaving(
        &self,
        faces: &[NearFace],
        direction: DVec3,
        reach: f64,
    ) -> Option<[DVec3; 2]> {
        let mut best = f64::NEG_INFINITY;
        let (mut points, mut way) = ([DVec3::NAN; 2], DVec3::NAN);
        for NearFace { corners: [p, q, r], .. } in faces {
            let area = (q.w - p.w).cross(r.w - p.w);
            // Seen edge on, the weights are rounding.
            if !(area.dot(direction) > FACING * area.length() * direction.length()) {
                continue;
            }
            let weights = DVec3::new(
                q.w.cross(r.w).dot(direction),
                r.w.cross(p.w).dot(direction),
                p.w.cross(q.w).dot(direction),
            );
            let least = weights.min_element() / weights.element_sum();
            // Of one face alone there is nothing to compare.
            if faces.len() == 1 || least > best {
                best = least;
                let weights = weights.max(DVec3::ZERO);
                let weights = weights / weights.element_sum();
                let mean =
                    |p: DVec3, q: DVec3, r: DVec3| p * weights.x + q * weights.y + r * weights.z;
                points =
                    [mean(p.a.point, q.a.point, r.a.point), mean(p.b.point, q.b.point, r.b.point)];
                way = mean(p.w, q.w, r.w);
            }
        }
        let missed = (way - direction * (reach / direction.length())).length();
        let [a, b] = &self.bodies;
        // False for NaN.
        (missed <= BESIDE).then(|| [a.pose.apply(points[0]), b.pose.apply(points[1])])
    }
}
