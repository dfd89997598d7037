//! The manifolds of a mesh and one convex polytope where f32's accuracy suffices: as those of any parts, in one pass over
//! the triangles that touch, none of which becomes a shape.

use super::corners::{Corners, size_with_triangle};
use super::facing::Part;
use super::feature::{Placed, View};
use super::parts::{ALIKE, NEAR};
use super::{Feature, Manifold, ManifoldSet, SAME, bound_of, missed, write_one_point};
use crate::epa::{self, Depth};
use crate::mesh::{self, AS_DEEP, PartIndex, TouchingTriangle};
use crate::query::{Accuracy, depths};
use crate::{PosedShape, PosedSupport, Verdict, expanding};
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

/// Writes the manifolds of a mesh and a polytope that touch, in that order, over a set of one empty manifold; `None`, and
/// anything written, where the general way is needed: for other shapes, and where a triangle cannot be measured.
pub(super) fn write(
    sides: [PosedShape<'_>; 2],
    touching: Option<&[[u32; 2]]>,
    (scratch, parts, corners, memory): (
        &mut Scratch,
        &mut mesh::Scratch,
        &mut Corners,
        &mut epa::Scratch,
    ),
    set: &mut ManifoldSet,
) -> Option<()> {
    let (Shape::Mesh(_), Shape::Polytope(body)) = (sides[0].shape, sides[1].shape) else {
        return None;
    };
    let Scratch { pairs, triangles, open } = scratch;
    triangles.clear();
    // Of spheres the depths tell which triangles touch.
    let of_sphere = body.kind() == Kind::Point;
    if !of_sphere || mesh::triangles_in_sphere(sides, touching, triangles).is_none() {
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
    if patches.open.is_empty() {
        return None;
    }
    let (lead, depth, below) = patches.deepest()?;
    patches.write(lead, &depth, below, set.only_mut()?)?;
    while patches.open.contains(&true) {
        let (lead, depth, below) = patches.deepest()?;
        let mut manifold = Manifold::default();
        patches.write(lead, &depth, below, &mut manifold)?;
        set.push(manifold);
    }
    Some(())
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

    fn open(&self) -> impl Iterator<Item = (usize, &TouchingTriangle)> {
        self.triangles.iter().enumerate().filter(|&(k, _)| self.open[k])
    }

    /// Writes the manifold of a triangle and a vertex, which share no corner: the witnesses of the depth. False, and nothing
    /// written, where they are not known well enough to stand for it.
    ///
    /// The body's is moved by what the two miss of the depth, so that one is above the other; the bound counts that twice,
    /// once for the way and once for what the mesh's may be off by as much.
    fn write_witness(&self, lead: usize, depth: &Depth, manifold: &mut Manifold) -> bool {
        let TouchingTriangle { corners, triangle, .. } = &self.triangles[lead];
        let size = size_with_triangle(corners, self.body);
        let missed = missed(depth);
        // Written so that NaN is missed.
        if !(missed <= SAME * size) {
            return false;
        }
        write_one_point(depth, [Feature::Surface; 2], manifold);
        manifold.error_bound = (bound_of(depth, size, self.sides) + 2.0 * missed).min(f64::MAX);
        manifold.parts = [Some(PartIndex::Triangle(*triangle)), None];
        let point = &mut manifold.points[0];
        point.parts = manifold.parts;
        point.point_b = point.point_a - depth.normal * depth.depth;
        true
    }

    /// Writes the manifold of the deepest open triangle over an empty one, with all open ones that belong to it: none of
    /// these is open then.
    fn write(
        &mut self,
        lead: usize,
        depth: &Depth,
        below: f64,
        manifold: &mut Manifold,
    ) -> Option<()> {
        let [mesh, body] = self.sides;
        let direction = body.pose.rotation().transpose() * -depth.normal;
        let part = Part::facing(self.body, direction);
        let is_alone =
            !self.open().any(|(k, other)| k != lead && Member::of(other, depth, below).is_some());
        if is_alone && matches!(part, Part::Vertex(_)) && self.write_witness(lead, depth, manifold)
        {
            self.open[lead] = false;
            return Some(());
        }
        let view = View::along(depth.normal);
        let delta = body.pose.translation() - mesh.pose.translation();
        let placed = Placed { rotation: body.pose.rotation(), place: delta, sense: -1.0 };
        self.corners.clear();
        let facing = Corners::facing(&view, part, self.body, placed);
        let radii = [mesh.shape.radius(), body.shape.radius()];
        let (mut features, mut rest) = ([Feature::Surface; 2], 0.0f64);
        for (k, triangle) in self.triangles.iter().enumerate() {
            let member = match self.open[k] {
                true if k == lead => Some(Member { own: Some(*depth), rest: 0.0 }),
                true => Member::of(triangle, depth, below),
                false => None,
            };
            let Some(member) = member else { continue };
            self.open[k] = false;
            rest = rest.max(member.rest);
            let before = self.corners.len();
            if k == lead || !facing.is_round() {
                let whole =
                    self.corners.add_triangle(&view, (depth, radii), &triangle.corners, &facing)?;
                features = if k == lead { whole } else { features };
            }
            if let Some(own) = member.own.filter(|_| self.corners.len() == before) {
                self.corners.add_witness(&view, &own, mesh.pose.translation());
            }
            self.corners.are_of(k as u32, before);
        }
        let of_points = self.corners.write(&view, depth, self.sides, features, manifold);
        manifold.error_bound = (manifold.error_bound + rest).min(f64::MAX);
        let part = |k: usize| Some(PartIndex::Triangle(self.triangles[k].triangle));
        manifold.parts = [part(lead), None];
        let count = usize::from(manifold.count);
        for (point, pair) in manifold.points[..count].iter_mut().zip(of_points) {
            point.parts = [part(pair.map_or(lead, |pair| pair as usize)), None];
        }
        Some(())
    }
}

/// How a triangle belongs to the manifold of another.
struct Member {
    /// Its depth, if its normal agrees.
    own: Option<Depth>,
    /// How much more than the manifold's depth separates it along the normal, metres.
    rest: f64,
}

impl Member {
    /// `None` of one that does not: neither agrees its normal, nor does the manifold's depth separate it.
    #[inline(always)]
    fn of(triangle: &TouchingTriangle, depth: &Depth, below: f64) -> Option<Self> {
        let own = triangle.depth.filter(|own| own.normal.dot(depth.normal) >= ALIKE);
        let more = reach(triangle, depth.normal, below) - triangle.slack - depth.depth;
        let is_separated = more <= NEAR * triangle.diameters;
        let rest = if is_separated { more.max(0.0) } else { 0.0 };
        (is_separated || own.is_some()).then_some(Self { own, rest })
    }
}

/// How far a triangle and a body reach past each other along a normal, rounded.
fn reach(triangle: &TouchingTriangle, normal: DVec3, below: f64) -> f64 {
    let [p, q, r] = triangle.corners;
    normal.dot(p).max(normal.dot(q)).max(normal.dot(r)) + below
}
