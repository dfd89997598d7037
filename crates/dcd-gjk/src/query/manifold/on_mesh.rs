//! The manifolds of a mesh and one convex polytope where f32's accuracy suffices: as those of any parts, in one pass over
//! the triangles that touch, none of which becomes a shape.

use super::corners::{Corners, size_with_triangle};
use super::facing::Part;
use super::feature::{Placed, View};
use super::parts::{ALIKE, NEAR};
use super::{Feature, Manifold, ManifoldSet, SAME, bound_of, missed, write_one_point};
use crate::PosedShape;
use crate::epa::{self, Depth};
use crate::mesh::{self, PartIndex, TouchingTriangle};
use crate::query::open_triangles::{OF_SIZE, OpenTriangles, reach};
use dcd_geom::{Kind, Shape, SupportMap};

/// What a thread reuses from pair to pair.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pairs: Vec<[u32; 2]>,
    triangles: Vec<TouchingTriangle>,
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
    let Scratch { pairs, triangles } = scratch;
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
        mesh::touching_triangles(sides, OF_SIZE, touching, triangles)?;
    }
    let mut patches = Patches { of: OpenTriangles { sides, body, triangles, memory }, corners };
    let (lead, depth) = patches.of.deepest()?;
    patches.write(lead, &depth, set.only_mut()?)?;
    loop {
        let left = patches.of.open().count();
        if left == 0 {
            break;
        }
        let (lead, depth) = patches.of.deepest()?;
        set.push_with(left, |manifold| patches.write(lead, &depth, manifold))?;
    }
    Some(())
}

/// The triangles that belong to no manifold yet, and what their manifolds are made with.
struct Patches<'a> {
    of: OpenTriangles<'a>,
    corners: &'a mut Corners,
}

impl Patches<'_> {
    /// Writes the manifold of a triangle and a vertex, which share no corner: the witnesses of the depth. False, and nothing
    /// written, where they are not known well enough to stand for it.
    ///
    /// The body's is moved by what the two miss of the depth, so that one is above the other; the bound counts that twice,
    /// once for the way and once for what the mesh's may be off by as much.
    fn write_witness(&self, lead: usize, depth: &Depth, manifold: &mut Manifold) -> bool {
        let TouchingTriangle { corners, triangle, .. } = &self.of.triangles[lead];
        let size = size_with_triangle(corners, self.of.body);
        let missed = missed(depth);
        // Written so that NaN is missed.
        if !(missed <= SAME * size) {
            return false;
        }
        write_one_point(depth, [Feature::Surface; 2], manifold);
        manifold.error_bound = (bound_of(depth, size, self.of.sides) + 2.0 * missed).min(f64::MAX);
        manifold.parts = [Some(PartIndex::Triangle(*triangle)), None];
        let point = &mut manifold.points[0];
        point.parts = manifold.parts;
        point.point_b = point.point_a - depth.normal * depth.depth;
        true
    }

    /// Writes the manifold of the deepest open triangle over an empty one, with all open ones that belong to it: none of
    /// these is open then.
    fn write(&mut self, lead: usize, depth: &Depth, manifold: &mut Manifold) -> Option<()> {
        let [mesh, body] = self.of.sides;
        let direction = body.pose.rotation().transpose() * -depth.normal;
        let part = Part::facing(self.of.body, direction);
        let others = || self.of.open().filter(|&(k, _)| k != lead);
        // Of the last one nobody asks.
        let below = if others().next().is_some() { self.of.below(depth.normal) } else { 0.0 };
        let is_alone = !others().any(|(_, other)| Member::of(other, depth, below).is_some());
        if is_alone && matches!(part, Part::Vertex(_)) && self.write_witness(lead, depth, manifold)
        {
            self.of.triangles[lead].is_open = false;
            return Some(());
        }
        let view = View::along(depth.normal);
        let delta = body.pose.translation() - mesh.pose.translation();
        let placed = Placed { rotation: body.pose.rotation(), place: delta, sense: -1.0 };
        self.corners.clear();
        let facing = Corners::facing(&view, part, self.of.body, placed);
        let radii = [mesh.shape.radius(), body.shape.radius()];
        let (mut features, mut rest) = ([Feature::Surface; 2], 0.0f64);
        for (k, triangle) in self.of.triangles.iter_mut().enumerate() {
            let member = match triangle.is_open {
                true if k == lead => Some(Member { own: Some(*depth), rest: 0.0 }),
                true => Member::of(triangle, depth, below),
                false => None,
            };
            let Some(member) = member else { continue };
            triangle.is_open = false;
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
        let of_points = self.corners.write(&view, depth, self.of.sides, features, manifold);
        manifold.error_bound = (manifold.error_bound + rest).min(f64::MAX);
        let part = |k: usize| Some(PartIndex::Triangle(self.of.triangles[k].triangle));
        manifold.parts = [part(lead), None];
        for (point, pair) in manifold.points.iter_mut().zip(of_points) {
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
