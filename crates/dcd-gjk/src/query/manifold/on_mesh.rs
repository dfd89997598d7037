//! The manifolds of a mesh and one convex polytope, or a compound of few where f32's accuracy suffices: as those of any parts,
//! in one pass over the triangles that touch, of which hardly any becomes a shape.

use super::corners::{Corners, size_with_triangle};
use super::facing::Part;
use super::feature::{Placed, View};
use super::parts::{ALIKE, ANGLE, NEAR};
use super::{Feature, Manifold, ManifoldSet, SAME, bound_of, write_one_point};
use crate::PosedShape;
use crate::epa::{self, Depth};
use crate::mesh::{self, KnownParts, PartIndex, TouchingTriangle};
use crate::query::Accuracy;
use crate::query::depths::tolerance;
use crate::query::few_parts;
use crate::query::open_triangles::{
    Body, OpenTriangles, is_of_few, reach, touching_parts, triangles_of_parts,
};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Shape, SupportMap};

/// What a thread reuses from pair to pair.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pairs: Vec<[u32; 2]>,
    triangles: Vec<TouchingTriangle>,
    members: Vec<TriangleMember>,
}

/// What of other memory is needed.
pub(super) type Lent<'a> =
    (&'a mut Scratch, &'a mut mesh::Scratch, &'a mut Corners, &'a mut epa::Scratch);

/// Writes the manifolds of a mesh and a polytope or compound that touch, in that order, over a set of one empty manifold;
/// `None`, and anything written, where the general way is needed: for other shapes, and where a triangle cannot be measured.
pub(super) fn write(
    accuracy: Accuracy,
    sides: [PosedShape<'_>; 2],
    known: Option<KnownParts<'_>>,
    (scratch, parts, corners, memory): Lent<'_>,
    set: &mut ManifoldSet,
) -> Option<()> {
    let Shape::Mesh(_) = sides[0].shape else { return None };
    let is_f32 = accuracy == Accuracy::F32;
    let of_sphere = match sides[1].shape {
        Shape::Polytope(body) => is_f32 && body.kind() == Kind::Point,
        other if is_f32 && is_of_few(other) => false,
        _ => return None,
    };
    let Scratch { pairs, triangles, members } = scratch;
    triangles.clear();
    // Of spheres the depths tell which triangles touch.
    let parts_known = known.map(|known| known.parts);
    let is_known = of_sphere && mesh::triangles_in_sphere(sides, parts_known, triangles).is_some();
    let touching = match parts_known {
        Some(touching) => touching,
        None if is_known => &[],
        None => {
            pairs.clear();
            mesh::touching_or_open(sides, parts, pairs);
            pairs
        }
    };
    if let Shape::Compound(_) = sides[1].shape {
        let parts = touching_parts(sides[1], touching)?;
        let bodies = &triangles_of_parts(sides[0], &parts, touching, triangles)?;
        let of = OpenTriangles { accuracy, mesh: sides[0], bodies, triangles, memory };
        return TrianglePatches { of, whole: sides[1], members, corners }.write_all(set);
    }
    if !is_known {
        triangles.clear();
        let touching = touching.iter().map(|&[triangle, _]| triangle);
        let touching = (touching, known.unwrap_or_default());
        mesh::touching_triangles(sides, tolerance(accuracy), touching, triangles)?;
    }
    let bodies = &[Body::whole(sides[1], triangles)?];
    let of = OpenTriangles { accuracy, mesh: sides[0], bodies, triangles, memory };
    TrianglePatches { of, whole: sides[1], members, corners }.write_all(set)
}

/// The triangles that belong to no manifold yet, and what their manifolds are made with.
struct TrianglePatches<'a> {
    of: OpenTriangles<'a>,
    /// What the bodies are parts of.
    whole: PosedShape<'a>,
    members: &'a mut Vec<TriangleMember>,
    corners: &'a mut Corners,
}

/// The triangle that a manifold is of first, what of its body faces it, and how deep they are.
#[derive(Clone, Copy)]
struct Lead<'a> {
    number: usize,
    depth: &'a Depth,
    part: Part<'a>,
}

impl<'a> TrianglePatches<'a> {
    fn write_all(&mut self, set: &mut ManifoldSet) -> Option<()> {
        let (lead, depth) = self.of.deepest()?;
        self.write(lead, &depth, set.only_mut()?)?;
        loop {
            let left = self.of.open().count();
            if left == 0 {
                return Some(());
            }
            let (lead, depth) = self.of.deepest()?;
            set.push_with(left, |manifold| self.write(lead, &depth, manifold))?;
        }
    }

    /// Measures the open triangles whose own normal may agree with that of the manifold, where no formula did; at the accuracy
    /// of f32 these have manifolds of their own.
    fn measure_alike(&mut self, lead: usize, depth: &Depth) -> Option<()> {
        for body in self.of.bodies {
            let is_unknown =
                |triangle: &TouchingTriangle| triangle.is_open && triangle.depth.is_none();
            if !self.of.triangles[body.triangles.clone()].iter().any(is_unknown) {
                continue;
            }
            let below = body.below(self.of.mesh, depth.normal);
            for k in body.triangles.clone() {
                let triangle = &self.of.triangles[k];
                let least = reach(triangle, depth.normal, below) - triangle.slack;
                let may_agree = least <= triangle.at_most + ANGLE * triangle.diameters;
                if k != lead && is_unknown(triangle) && may_agree {
                    self.of.measure_one(k)?;
                }
            }
        }
        Some(())
    }

    /// Lists the open triangles that belong to the manifold of one of them.
    fn find_members(&mut self, lead: usize, depth: &Depth) {
        let OpenTriangles { mesh, bodies, triangles, .. } = &self.of;
        self.members.clear();
        for body in *bodies {
            let open = || body.triangles.clone().filter(|&k| triangles[k].is_open);
            // Of the last one nobody asks.
            let has_others = open().any(|k| k != lead);
            let below = if has_others { body.below(*mesh, depth.normal) } else { 0.0 };
            self.members.extend(open().filter_map(|number| match number == lead {
                true => Some(TriangleMember { number, is_alike: true, rest: 0.0 }),
                false => TriangleMember::of((number, &triangles[number]), depth, below),
            }));
        }
    }

    /// Whether the witnesses of the depth are all that a manifold shows: a vertex of the body shares no corner with any
    /// triangle, and no other member has witnesses along the normal.
    fn shows_witness_alone(&self, lead: usize, body: &Body<'_>, part: &Part<'_>) -> bool {
        let adds_none = |m: &TriangleMember| {
            m.number == lead || !m.is_alike && body.triangles.contains(&m.number)
        };
        self.of.accuracy == Accuracy::F32
            && matches!(part, Part::Vertex(_))
            && self.members.iter().all(adds_none)
    }

    /// Writes the witnesses of the depth of a triangle and a vertex over an empty manifold. False, and nothing written, where
    /// they are not known well enough to stand for it.
    ///
    /// The body's is moved by what the two miss of the depth, so that one is above the other; the bound counts that twice,
    /// once for the way and once for what the mesh's may be off by as much.
    fn write_witness(
        &self,
        (lead, body): (usize, &Body<'_>),
        depth: &Depth,
        manifold: &mut Manifold,
    ) -> bool {
        let TouchingTriangle { corners, triangle, .. } = &self.of.triangles[lead];
        let size = size_with_triangle(corners, body.polytope);
        let missed = depth.missed();
        // Written so that NaN is missed.
        if !(missed <= SAME * size) {
            return false;
        }
        write_one_point(depth, [Feature::Surface; 2], manifold);
        let sides = [self.of.mesh, body.side];
        manifold.error_bound = bound_of(depth, size, sides) + 2.0 * missed;
        manifold.parts = parts_of(*triangle, body);
        let point = &mut manifold.points[0];
        point.parts = manifold.parts;
        point.point_b = point.point_a - depth.normal * depth.depth;
        true
    }

    /// Writes the manifold of the deepest open triangle over an empty one, with all open ones that belong to it: none of
    /// these is open then.
    fn write(&mut self, lead: usize, depth: &Depth, manifold: &mut Manifold) -> Option<()> {
        if self.of.accuracy != Accuracy::F32 {
            self.measure_alike(lead, depth)?;
        }
        self.find_members(lead, depth);
        let body = self.of.body_of(lead)?;
        let part = body.facing(depth.normal);
        let is_witness = self.shows_witness_alone(lead, body, &part)
            && self.write_witness((lead, body), depth, manifold);
        if !is_witness {
            self.write_corners(Lead { number: lead, depth, part }, manifold)?;
        }
        let (mut rest, mut moved) = (0.0f64, 0.0f64);
        for member in &*self.members {
            self.of.triangles[member.number].is_open = false;
            rest = rest.max(member.rest);
            moved = moved.max(self.of.body_of(member.number)?.moved);
        }
        manifold.error_bound = (manifold.error_bound + rest + moved).min(f64::MAX);
        Some(())
    }

    /// Writes the corners that the members share with their bodies over an empty manifold, but for what of the bound is not
    /// theirs.
    fn write_corners(&mut self, lead: Lead<'_>, manifold: &mut Manifold) -> Option<()> {
        let view = View::along(lead.depth.normal);
        self.corners.clear();
        let features = self.add_members(&view, lead)?;
        let sides = [self.of.mesh, self.whole];
        let of_points = self.corners.write(&view, lead.depth, sides, features, manifold);
        let parts = |k: usize| Some(parts_of(self.of.triangles[k].triangle, self.of.body_of(k)?));
        manifold.parts = parts(lead.number)?;
        for (point, number) in manifold.points.iter_mut().zip(of_points) {
            let number = number.map_or(lead.number, |number| number as usize);
            point.parts = parts(number)?;
            if let Some(part) = self.of.body_of(number)?.part {
                point.features[1] = few_parts::name(self.whole, part, point.features[1])?;
            }
        }
        Some(())
    }

    /// Adds the corners of the members. What the deepest and its body show as wholes.
    fn add_members(&mut self, view: &View, lead: Lead<'_>) -> Option<[Feature; 2]> {
        let Self { of: OpenTriangles { mesh, bodies, triangles, .. }, members, corners, .. } = self;
        let (mut features, mut left) = ([Feature::Surface; 2], &members[..]);
        for body in *bodies {
            let count = left.iter().take_while(|m| body.triangles.contains(&m.number)).count();
            let (own, others) = left.split_at(count);
            left = others;
            if own.is_empty() {
                continue;
            }
            let is_leads = body.triangles.contains(&lead.number);
            let part = if is_leads { lead.part } else { body.facing(lead.depth.normal) };
            let delta = body.side.pose.translation() - mesh.pose.translation();
            let placed = Placed { rotation: body.side.pose.rotation(), place: delta, sense: -1.0 };
            let facing = Corners::facing(view, part, body.polytope, placed);
            let radii = [mesh.shape.radius(), body.side.shape.radius()];
            for &TriangleMember { number, is_alike, .. } in own {
                let triangle = &triangles[number];
                let before = corners.len();
                let is_lead = number == lead.number;
                if is_lead || !facing.is_round() {
                    let how = (lead.depth, radii);
                    let whole = corners.add_triangle(view, how, &triangle.corners, &facing)?;
                    features = if is_lead { whole } else { features };
                }
                let witness = if is_lead { Some(lead.depth) } else { triangle.depth.as_ref() };
                if let Some(witness) = witness.filter(|_| is_alike && corners.len() == before) {
                    corners.add_witness(view, witness, mesh.pose.translation());
                }
                corners.are_of(number as u32, before);
            }
        }
        Some(features)
    }
}

/// A triangle, and a body's part.
fn parts_of(triangle: u32, body: &Body<'_>) -> [Option<PartIndex>; 2] {
    [Some(PartIndex::Triangle(triangle)), body.part.map(PartIndex::Part)]
}

impl<'a> Body<'a> {
    /// What of it faces a mesh whose normal that is.
    fn facing(&self, normal: DVec3) -> Part<'a> {
        let direction = self.side.pose.rotation().transpose() * -normal;
        // Round a hull's farthest vertex there is less to look at than all round it.
        let is_hull = self.polytope.kind() == Kind::Hull;
        let farthest = || SupportMap::<f64>::support(self.polytope, direction).feature;
        Part::round(self.polytope, direction, is_hull.then(farthest))
    }
}

/// How a triangle belongs to the manifold of another.
#[derive(Clone, Copy, Debug)]
struct TriangleMember {
    number: usize,
    /// Whether its normal agrees.
    is_alike: bool,
    /// How much more than the manifold's depth separates it along the normal, metres.
    rest: f64,
}

impl TriangleMember {
    /// `None` of one that does not: neither agrees its normal, nor does the manifold's depth separate it.
    #[inline(always)]
    fn of(
        (number, triangle): (usize, &TouchingTriangle),
        depth: &Depth,
        below: f64,
    ) -> Option<Self> {
        let is_alike =
            triangle.depth.as_ref().is_some_and(|own| own.normal.dot(depth.normal) >= ALIKE);
        let more = reach(triangle, depth.normal, below) - triangle.slack - depth.depth;
        let is_separated = more <= NEAR * triangle.diameters;
        let rest = if is_separated { (more + 2.0 * triangle.slack).max(0.0) } else { 0.0 };
        (is_separated || is_alike).then_some(Self { number, is_alike, rest })
    }
}
