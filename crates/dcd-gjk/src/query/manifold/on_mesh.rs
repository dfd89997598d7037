//! The manifolds of a mesh and one convex polytope where f32's accuracy suffices: as those of any parts, in one pass over
//! the triangles that touch, none of which becomes a shape.

use super::corners::Corners;
use super::feature::{Placed, View};
use super::parts::{ALIKE, NEAR};
use super::{Feature, Manifold, ManifoldSet};
use crate::epa::{self, Depth};
use crate::mesh::{self, AS_DEEP, PartIndex, TouchingTriangle};
use crate::query::{Accuracy, depths};
use crate::{PosedShape, Verdict};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Shape, SupportMap};

/// The bound of a triangle's depth that is good enough, relative to the pair's size.
const TOLERANCE: f64 = 1e-6;

/// What a thread reuses from pair to pair.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pairs: Vec<[u32; 2]>,
    triangles: Vec<TouchingTriangle>,
    open: Vec<bool>,
}

/// The manifolds of a mesh and a polytope that touch, in that order; `None` where the general way is needed: for other
/// shapes, and where a triangle cannot be measured.
pub(super) fn measure(
    sides: [PosedShape<'_>; 2],
    touching: Option<&[[u32; 2]]>,
    (scratch, parts, corners): (&mut Scratch, &mut mesh::Scratch, &mut Corners),
    memory: &mut epa::Scratch,
) -> Option<ManifoldSet> {
    let (Shape::Mesh(_), Shape::Polytope(body)) = (sides[0].shape, sides[1].shape) else {
        return None;
    };
    let Scratch { pairs, triangles, open } = scratch;
    triangles.clear();
    // Of spheres the depths tell which triangles touch.
    if body.kind() != Kind::Point || mesh::triangles_in_sphere(sides, triangles).is_none() {
        triangles.clear();
        let touching = touching.unwrap_or_else(|| {
            pairs.clear();
            // What is undecided is not in the list, and counts as apart.
            let _ = mesh::touching(sides[0], sides[1], parts, pairs);
            pairs
        });
        let touching = touching.iter().map(|&[triangle, _]| triangle);
        mesh::touching_triangles(sides, TOLERANCE, touching, triangles)?;
    }
    open.clear();
    open.resize(triangles.len(), true);
    let mut patches = Patches { sides, body, triangles, open, corners, memory };
    let mut found = ManifoldSet::default();
    while patches.open.contains(&true) {
        let (lead, depth, below) = patches.deepest()?;
        found.push(patches.patch(lead, &depth, below)?);
    }
    (!found.is_empty()).then_some(found)
}

/// The triangles that touch, and those that belong to no manifold yet.
struct Patches<'a> {
    sides: [PosedShape<'a>; 2],
    body: &'a Polytope,
    triangles: &'a mut [TouchingTriangle],
    open: &'a mut [bool],
    corners: &'a mut Corners,
    memory: &'a mut epa::Scratch,
}

impl Patches<'_> {
    /// How far the body reaches against a normal, from the mesh's origin, the radii of both counted.
    fn below(&self, normal: DVec3) -> f64 {
        let [mesh, body] = self.sides;
        let local = body.pose.rotation().transpose() * -normal;
        let delta = body.pose.translation() - mesh.pose.translation();
        let core =
            local.dot(SupportMap::<f64>::support(self.body, local).point) - normal.dot(delta);
        core + (mesh.shape.radius() + body.shape.radius())
    }

    /// The deepest of the open triangles, its depth with a bound that counts the others, and how far the body reaches
    /// against its normal; `None` where one cannot be measured.
    fn deepest(&mut self) -> Option<(usize, Depth, f64)> {
        loop {
            match self.deepest_known() {
                Ok(found) => return Some(found),
                Err(k) => self.measure_one(k)?,
            }
        }
    }

    /// The same from what is known; a triangle that may be deeper is an error.
    fn deepest_known(&self) -> Result<(usize, Depth, f64), usize> {
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
        let below = self.below(most.normal);
        for (k, triangle) in self.open().filter(|(_, triangle)| triangle.depth.is_none()) {
            let along = reach(triangle, most.normal, below) + triangle.slack;
            let at_most = triangle.at_most.min(along);
            // Written so that NaN is deeper.
            if !(at_most <= most.depth * (1.0 + AS_DEEP)) {
                return Err(k);
            }
            upper = upper.max(at_most);
        }
        let above = (upper - most.depth).next_up().min(f64::MAX);
        Ok((k, Depth { error_bound: most.error_bound.max(above), ..most }, below))
    }

    /// By a search, which no formula replaces.
    fn measure_one(&mut self, k: usize) -> Option<()> {
        let [mesh, body] = self.sides;
        let Shape::Mesh(of_mesh) = mesh.shape else { return None };
        let corners = of_mesh.corners(self.triangles[k].triangle as usize)?;
        let triangle =
            Polytope::mesh_triangle(corners).ok()?.rounded(of_mesh.swept_radius()).ok()?;
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

    fn open(&self) -> impl Iterator<Item = (usize, &TouchingTriangle)> {
        self.triangles.iter().enumerate().filter(|&(k, _)| self.open[k])
    }

    /// The manifold of the deepest open triangle, with all open ones that belong to it: none of these is open then.
    fn patch(&mut self, lead: usize, depth: &Depth, below: f64) -> Option<Manifold> {
        let view = View::along(depth.normal);
        let [mesh, body] = self.sides;
        let delta = body.pose.translation() - mesh.pose.translation();
        let placed = Placed { rotation: body.pose.rotation(), place: delta, sense: -1.0 };
        self.corners.clear();
        let facing = Corners::facing(&view, self.body, placed);
        let radii = [mesh.shape.radius(), body.shape.radius()];
        let (mut features, mut rest) = ([Feature::Surface; 2], 0.0f64);
        for (k, triangle) in self.triangles.iter().enumerate() {
            if !self.open[k] {
                continue;
            }
            let own = triangle.depth.filter(|own| own.normal.dot(depth.normal) >= ALIKE);
            let more = reach(triangle, depth.normal, below) - triangle.slack - depth.depth;
            let is_separated = more <= NEAR * triangle.diameters;
            if !is_separated && own.is_none() {
                continue;
            }
            self.open[k] = false;
            if is_separated && k != lead {
                rest = rest.max(more);
            }
            let before = self.corners.len();
            if k == lead || !facing.is_round() {
                let whole =
                    self.corners.add_triangle(&view, (depth, radii), &triangle.corners, &facing)?;
                features = if k == lead { whole } else { features };
            }
            let own = if k == lead { Some(*depth) } else { own };
            if let Some(own) = own.filter(|_| self.corners.len() == before) {
                self.corners.add_witness(&view, &own, mesh.pose.translation());
            }
            self.corners.are_of(k as u32, before);
        }
        let mut manifold = Manifold::default();
        let of_points = self.corners.write(&view, depth, self.sides, features, &mut manifold);
        manifold.error_bound = (manifold.error_bound + rest).min(f64::MAX);
        let part = |k: usize| Some(PartIndex::Triangle(self.triangles[k].triangle));
        manifold.parts = [part(lead), None];
        let count = usize::from(manifold.count);
        for (point, pair) in manifold.points[..count].iter_mut().zip(of_points) {
            point.parts = [part(pair.map_or(lead, |pair| pair as usize)), None];
        }
        Some(manifold)
    }
}

/// How far a triangle and a body reach past each other along a normal, rounded.
fn reach(triangle: &TouchingTriangle, normal: DVec3, below: f64) -> f64 {
    let [p, q, r] = triangle.corners;
    normal.dot(p).max(normal.dot(q)).max(normal.dot(r)) + below
}
