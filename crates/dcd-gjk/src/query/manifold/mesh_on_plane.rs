//! A mesh on a half-space: its vertices below the plane, each once.
//!
//! Every triangle that is below meets the plane along one normal: there is one manifold, and no pair of parts is looked
//! at.

use super::clip::different;
use super::reduce::{self, Spot};
use super::{Feature, Manifold, ManifoldPoint, ManifoldSet, SAME, bound_of};
use crate::epa::{self, Depth};
use crate::mesh::PartIndex;
use crate::query::{Accuracy, depths};
use crate::{PosedShape, Verdict};
use dcd_geom::glam::{DVec2, DVec3};
use dcd_geom::{Mesh, Shape};
use dcd_simd::HeightsAlong;

/// Up to how many vertices are compared with each other, for those at one place. More are so many that the four that
/// stand for all are at four places.
const FEW: usize = 32;

/// A vertex below the plane.
#[derive(Clone, Copy, Debug)]
struct Below {
    vertex: u32,
    /// The first triangle that has it, and as which of its corners.
    triangle: u32,
    corner: u32,
    /// Seen along the normal.
    at: DVec2,
    depth: f64,
}

impl Spot for Below {
    fn at(&self) -> DVec2 {
        self.at
    }

    fn depth(&self) -> f64 {
        self.depth
    }
}

/// What a thread reuses from pair to pair.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    below: Vec<Below>,
    /// For each vertex the last round that met it, and where it is in the list then.
    met: Vec<[u32; 2]>,
    round: u32,
}

/// The manifold of a mesh and a half-space, in that order; `None` of others, and where f64 leaves open whether they
/// touch.
pub(super) fn measure(
    at: Accuracy,
    sides: [PosedShape<'_>; 2],
    (scratch, memory): (&mut Scratch, &mut epa::Scratch),
) -> Option<ManifoldSet> {
    let (Shape::Mesh(mesh), Shape::HalfSpace(_)) = (sides[0].shape, sides[1].shape) else {
        return None;
    };
    // The other vertices are as deep as f64 has it, whatever is asked for of the deepest.
    let [mesh_side, plane] = sides;
    let (depth, in_f64) = match at {
        Accuracy::Certified => {
            let in_f64 = depths::by_frame(Accuracy::F64, mesh_side, plane)?;
            let certified = depths::of_touching(at, mesh_side, plane, memory);
            let Verdict::Touching(depth) = certified else { return None };
            (depth, in_f64)
        }
        _ => {
            let depth = depths::by_frame(at, mesh_side, plane)?;
            (depth, depth)
        }
    };
    let resting = RestingMesh::of(mesh, sides, &depth);
    scratch.list(&resting)?;
    let below = &mut scratch.below;
    // Of vertices above each other the deepest is the first.
    below.sort_unstable_by(|a, b| b.depth.total_cmp(&a.depth).then(a.vertex.cmp(&b.vertex)));
    if below.len() <= FEW {
        let count = different(below, resting.size);
        below.truncate(count);
    }
    let (kept, count) = reduce::to_four(below, SAME * resting.size)?;
    let mut found = Manifold { normal: depth.normal, ..Manifold::default() };
    found.points.extend(kept[..count].iter().map(|&k| resting.point(&below[k], &depth)));
    found.points[0].depth = depth.depth;
    found.parts = found.points[0].parts;
    // What is lost of a depth, once more of the other vertices'.
    let error_bound = bound_of(&depth, 0.0, sides) + in_f64.error_bound;
    let inside = kept[..count].iter().map(|&k| resting.inside(&below[k], &depth));
    found.error_bound = (error_bound + inside.fold(0.0, f64::max)).min(f64::MAX);
    Some(found.into())
}

/// A mesh and the plane below it.
struct RestingMesh<'a> {
    mesh: &'a Mesh,
    side: PosedShape<'a>,
    /// Into the half-space, of unit length: in the world, and in the mesh's frame.
    towards: DVec3,
    local: DVec3,
    /// How far the mesh's origin, and what is swept round the mesh, is below the plane.
    base: f64,
    /// Square to the normal, in the mesh's frame.
    axes: (DVec3, DVec3),
    size: f64,
}

impl<'a> RestingMesh<'a> {
    fn of(mesh: &'a Mesh, [side, _]: [PosedShape<'a>; 2], depth: &Depth) -> Self {
        let towards = depth.normal;
        let local = side.pose.rotation().transpose() * towards;
        let base = towards.dot(side.pose.translation() - depth.point_b) + mesh.swept_radius();
        let axes = local.any_orthonormal_pair();
        Self { mesh, side, towards, local, base, axes, size: 2.0 * mesh.reach() }
    }

    /// A vertex, if it is not above the plane.
    #[inline]
    fn below(&self, vertex: u32) -> Option<(DVec2, f64)> {
        let point = self.mesh.vertices()[vertex as usize];
        let depth = self.local.dot(point) + self.base;
        let at = || DVec2::new(self.axes.0.dot(point), self.axes.1.dot(point));
        (depth >= 0.0).then(|| (at(), depth))
    }

    /// How far inside a swept surface a vertex may be that is swept along the normal: no more than what it is less deep.
    #[inline]
    fn inside(&self, below: &Below, most: &Depth) -> f64 {
        (most.depth - below.depth).clamp(0.0, self.mesh.swept_radius())
    }

    fn point(&self, below: &Below, most: &Depth) -> ManifoldPoint {
        let vertex = self.mesh.vertices()[below.vertex as usize];
        let point_a = self.side.pose.apply(vertex) + self.towards * self.mesh.swept_radius();
        ManifoldPoint {
            point_a,
            point_b: point_a - self.towards * below.depth,
            depth: below.depth.clamp(0.0, most.depth),
            features: [Feature::Vertex(below.corner), Feature::Surface],
            parts: [Some(PartIndex::Triangle(below.triangle)), None],
        }
    }
}

impl Scratch {
    /// Lists the vertices below the plane; `None` where lengths leave the range of f32.
    fn list(&mut self, resting: &RestingMesh<'_>) -> Option<()> {
        let Self { below, met, round } = self;
        let RestingMesh { mesh, local, base, .. } = resting;
        below.clear();
        if *round == u32::MAX || met.len() < mesh.vertices().len() {
            met.clear();
            met.resize(mesh.vertices().len(), [0; 2]);
            *round = 0;
        }
        *round += 1;
        let test = HeightsAlong::new(-*local, &mesh.tree().aabb())?;
        let limit = test.key_of(*base);
        mesh.tree().visit_within(&test, limit, &mut |triangle| {
            let corners = mesh.triangles().get(triangle as usize).copied().unwrap_or_default();
            for (corner, vertex) in (0..).zip(corners) {
                let slot = &mut met[vertex as usize];
                if slot[0] == *round {
                    // Not below, or in the list: the first triangle names it.
                    if let Some(known) = below.get_mut(slot[1] as usize)
                        && triangle < known.triangle
                    {
                        (known.triangle, known.corner) = (triangle, corner);
                    }
                    continue;
                }
                let Some((at, depth)) = resting.below(vertex) else {
                    *slot = [*round, u32::MAX];
                    continue;
                };
                *slot = [*round, below.len() as u32];
                below.push(Below { vertex, triangle, corner, at, depth });
            }
            true
        });
        Some(())
    }
}

#[cfg(test)]
mod tests;
