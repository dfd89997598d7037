//! The triangles of a mesh that touch a polytope, at the accuracy of f32: no more of them are measured than may be the
//! deepest.

use super::{Accuracy, depths};
use crate::epa::{self, Depth};
use crate::mesh::{self, AS_DEEP, TouchingTriangle};
use crate::{PosedShape, PosedSupport, Verdict, expanding};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Shape, SupportMap};

/// The bound of a triangle's depth that is good enough, relative to the pair's size.
pub(super) const OF_SIZE: f64 = 1e-6;

/// The triangles that touch, of which some are still looked at.
pub(super) struct OpenTriangles<'a> {
    /// The mesh and the body.
    pub(super) sides: [PosedShape<'a>; 2],
    pub(super) body: &'a Polytope,
    pub(super) triangles: &'a mut [TouchingTriangle],
    pub(super) memory: &'a mut epa::Scratch,
}

/// How deep a mesh and a polytope overlap of which these parts touch; `None` of other shapes, and where a triangle cannot
/// be measured.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(super) fn depth(
    [a, b]: [PosedShape<'_>; 2],
    touching: &[[u32; 2]],
    memory: &mut epa::Scratch,
) -> Option<Depth> {
    let (sides, mesh) = match (a.shape, b.shape) {
        (Shape::Mesh(_), _) => ([a, b], 0),
        _ => ([b, a], 1),
    };
    let Shape::Polytope(body) = sides[1].shape else { return None };
    let mut triangles = Vec::with_capacity(touching.len());
    let touching = touching.iter().map(|pair| pair[mesh]);
    mesh::touching_triangles(sides, OF_SIZE, touching, &mut triangles)?;
    let triangles = &mut triangles[..];
    let (_, found) = OpenTriangles { sides, body, triangles, memory }.deepest()?;
    Some(if mesh == 0 { found } else { found.mirrored() })
}

impl OpenTriangles<'_> {
    /// How far the body reaches against a normal, from the mesh's origin, the radii of both counted.
    pub(super) fn below(&self, normal: DVec3) -> f64 {
        let [mesh, body] = self.sides;
        let local = body.pose.rotation().transpose() * -normal;
        let delta = body.pose.translation() - mesh.pose.translation();
        let core =
            local.dot(SupportMap::<f64>::support(self.body, local).point) - normal.dot(delta);
        core + (mesh.shape.radius() + body.shape.radius())
    }

    /// The deepest of the open triangles, and its depth with a bound that counts the others; `None` of none, and where one
    /// cannot be measured.
    pub(super) fn deepest(&mut self) -> Option<(usize, Depth)> {
        self.open().next()?;
        loop {
            match self.deepest_known() {
                Ok(found) => return Some(found),
                Err(k) => self.measure_one(k)?,
            }
        }
    }

    /// The same from what is known; a triangle that may be deeper is an error.
    fn deepest_known(&self) -> Result<(usize, Depth), usize> {
        let mut lead: Option<(usize, Depth)> = None;
        let (mut upper, mut unknown) = (0.0f64, (f64::NEG_INFINITY, 0));
        for (k, triangle) in self.open() {
            match triangle.depth {
                Some(depth) => {
                    upper = upper.max(depth.depth + depth.error_bound);
                    if lead.is_none_or(|(_, most)| depth.depth > most.depth) {
                        lead = Some((k, depth));
                    }
                }
                None if triangle.at_most > unknown.0 => unknown = (triangle.at_most, k),
                None => {}
            }
        }
        let (k, most) = lead.ok_or(unknown.1)?;
        if unknown.0 > f64::NEG_INFINITY {
            upper = upper.max(self.most_of_unknown(&most)?);
        }
        let above = (upper - most.depth).next_up().min(f64::MAX);
        Ok((k, Depth { error_bound: most.error_bound.max(above), ..most }))
    }

    /// At least how deep each triangle is that is not measured, if none may be deeper than that; such a one is an error.
    fn most_of_unknown(&self, most: &Depth) -> Result<f64, usize> {
        let below = self.below(most.normal);
        let mut upper = 0.0f64;
        for (k, triangle) in self.open().filter(|(_, triangle)| triangle.depth.is_none()) {
            let along = reach(triangle, most.normal, below) + triangle.slack;
            let at_most = triangle.at_most.min(along);
            // Written so that NaN is deeper.
            if !(at_most <= most.depth * (1.0 + AS_DEEP)) {
                return Err(k);
            }
            upper = upper.max(at_most);
        }
        Ok(upper)
    }

    /// By a search, which no formula replaces.
    fn measure_one(&mut self, k: usize) -> Option<()> {
        let [mesh, body] = self.sides;
        let Shape::Mesh(of_mesh) = mesh.shape else { return None };
        let corners = of_mesh.corners(self.triangles[k].triangle as usize)?;
        let triangle =
            Polytope::mesh_triangle(corners).ok()?.rounded(of_mesh.swept_radius()).ok()?;
        // No formula is left to try of a hull.
        if self.body.kind() == Kind::Hull {
            let sides = [
                PosedSupport::polytope(&triangle, mesh.pose),
                PosedSupport::polytope(self.body, body.pose),
            ];
            let found =
                expanding::depth_of_polytopes(sides, Accuracy::F32, &mut self.memory.surface);
            if let Some(depth) = found {
                self.triangles[k].depth = Some(depth);
                return Some(());
            }
        }
        let shape = Shape::from(triangle);
        let placed = PosedShape { shape: &shape, pose: mesh.pose };
        match depths::of_touching(Accuracy::F32, placed, body, self.memory) {
            Verdict::Touching(depth) => {
                self.triangles[k].depth = Some(depth);
                Some(())
            }
            _ => None,
        }
    }

    pub(super) fn open(&self) -> impl Iterator<Item = (usize, &TouchingTriangle)> {
        self.triangles.iter().enumerate().filter(|(_, triangle)| triangle.is_open)
    }
}

/// How far a triangle and a body reach past each other along a normal, rounded.
pub(super) fn reach(triangle: &TouchingTriangle, normal: DVec3, below: f64) -> f64 {
    let [p, q, r] = triangle.corners;
    normal.dot(p).max(normal.dot(q)).max(normal.dot(r)) + below
}
