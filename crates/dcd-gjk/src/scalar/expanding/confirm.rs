//! The depth at the end of a search in f32, measured in f64.

use super::surface::clearance;
use super::{Search, Tolerance};
use crate::certificate::Bounds;
use crate::epa::Depth;
use crate::gjk::unit;
use crate::query::{Accuracy, CERTIFIED};
use crate::{Difference, PosedSupport, Vertex};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Support};

/// What a search in f32 ended with: a closed surface of triangles between points of A − B.
pub(crate) struct Ending<'a> {
    /// Of the faces that may be the nearest the vertices of a and of b that make their corners.
    pub(crate) faces: &'a [[[u32; 2]; 3]],
    /// If the surface of the true points surely winds round the origin: at most the distance of the other
    /// faces, as a length of the difference.
    pub(crate) others: Option<f64>,
}

/// The depth of polytopes that are known to touch, if it is confirmed as well as the accuracy asks for.
pub(crate) fn confirmed_depth(
    difference: Difference<'_, f64, Polytope, Polytope>,
    bodies: [PosedSupport<'_, Polytope>; 2],
    accuracy: Accuracy,
    ending: &Ending<'_>,
) -> Option<Depth> {
    let search = Search { difference, bodies, tolerance: Tolerance::of(accuracy) };
    let bounds = Bounds::of(&search.difference);
    let mut nearest = (f64::INFINITY, DVec3::ZERO);
    let mut inner = ending.others.unwrap_or(0.0);
    for &face in ending.faces {
        let corners = search.corners(face).map(|vertex| vertex.w);
        let [p, q, r] = corners;
        let normal = (q - p).cross(r - p).try_normalize()?;
        let distance = normal.dot(p);
        inner = inner.min(clearance(normal, corners));
        if distance < nearest.0 {
            nearest = (distance, normal);
        }
    }
    let direction = unit::<f64>(nearest.1.to_array())?;
    let (_, separation) = search.difference.lowest(-direction);
    let along = (-separation / direction.length()).max(0.0);
    let upper = -bounds.lower_bound(-direction, separation);
    let lower = if ending.others.is_some() { bounds.least_reach(inner) } else { 0.0 };
    let error = (upper - along).max(along - lower);
    let found = search.told(along, error, search.leaving(ending.faces, direction), direction)?;
    let is_good = accuracy != Accuracy::Certified || found.error_bound <= CERTIFIED * found.depth;
    is_good.then_some(found)
}

impl Search<'_, Polytope> {
    fn corners(&self, face: [[u32; 2]; 3]) -> [Vertex<f64>; 3] {
        face.map(|pair| {
            let [a, b] = [0, 1].map(|side| {
                let vertices = self.bodies[side].map.vertices();
                // The last block is filled up with the last vertex.
                let feature = pair[side].min(vertices.len() as u32 - 1);
                Support { point: vertices[feature as usize], feature }
            });
            Vertex { w: self.difference.world(a.point, b.point), a, b }
        })
    }

    /// The points of the two cores where a direction from the origin leaves the faces: by the one that it passes by
    /// the least.
    fn leaving(&self, faces: &[[[u32; 2]; 3]], direction: DVec3) -> [DVec3; 2] {
        let mut best = (f64::NEG_INFINITY, [1.0, 0.0, 0.0], None);
        for &face in faces {
            let corners = self.corners(face);
            let [p, q, r] = corners.map(|vertex| vertex.w);
            let volumes = [q.cross(r), r.cross(p), p.cross(q)].map(|n| n.dot(direction));
            let total: f64 = volumes.iter().sum();
            let weights = volumes.map(|volume| volume / total);
            let least = weights[0].min(weights[1]).min(weights[2]);
            if best.2.is_none() || (total > 0.0 && least > best.0) {
                best = (if total > 0.0 { least } else { f64::NEG_INFINITY }, weights, Some(corners));
            }
        }
        let (_, weights, Some(corners)) = best else { return [DVec3::NAN; 2] };
        let weights = weights.map(|weight| weight.max(0.0));
        let total: f64 = weights.iter().sum();
        let mean = |point: fn(&Vertex<f64>) -> DVec3| -> DVec3 {
            let terms = corners.iter().zip(weights);
            terms.map(|(vertex, weight)| point(vertex) * (weight / total)).sum()
        };
        let [a, b] = self.bodies;
        [a.pose.apply(mean(|vertex| vertex.a.point)), b.pose.apply(mean(|vertex| vertex.b.point))]
    }
}
