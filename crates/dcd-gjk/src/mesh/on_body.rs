//! The triangles of a mesh that touch a convex polytope, each with its depth by a formula.

use super::KnownParts;
use super::deepest::Deepest;
use super::reach::{Couple, longest_edge};
use super::side::{Part, Side};
use crate::epa::Depth;
use crate::{PosedShape, closed};
use dcd_geom::glam::DVec3;
use dcd_geom::{Shape, SupportMap};

/// A triangle of a mesh that touches a polytope.
#[derive(Clone, Debug)]
pub(crate) struct TouchingTriangle {
    pub(crate) triangle: u32,
    /// World axes, from the mesh's origin.
    pub(crate) corners: [DVec3; 3],
    /// From the mesh to the body; `None` where no formula finds it with a bound that is good enough.
    pub(crate) depth: Option<Depth>,
    /// An upper bound of how deep the two overlap, metres.
    pub(crate) at_most: f64,
    /// At least the sum of the two diameters.
    pub(crate) diameters: f64,
    /// What their reach along a normal may be off, metres.
    pub(crate) slack: f64,
    /// Whether it is still looked at.
    pub(crate) is_open: bool,
}

impl TouchingTriangle {
    /// What is known of its depth if the body is not where it was measured, but its points at most so far from there,
    /// metres.
    pub(crate) fn widen(&mut self, moved: f64) {
        if let Some(depth) = &mut self.depth {
            depth.error_bound = (depth.error_bound + moved).next_up();
        }
        self.at_most = (self.at_most + moved).next_up();
    }
}

/// Appends those triangles that touch a sphere, with their depths; which do may be known. `None`, and some of them, where
/// it is not known of one whether it touches, and of another shape.
pub(crate) fn triangles_in_sphere(
    sides: [PosedShape<'_>; 2],
    touching: Option<&[[u32; 2]]>,
    found: &mut Vec<TouchingTriangle>,
) -> Option<()> {
    let [mesh, sphere] = sides;
    let side = Side::of(mesh);
    let slack =
        Couple::of([side.part(0), Part::Shape(sphere.shape)], [mesh.pose, sphere.pose])?.slack();
    let turn = *mesh.pose.rotation();
    let radii = mesh.shape.radius() + sphere.shape.radius();
    let touching = touching.map(|touching| touching.iter().map(|&[triangle, _]| triangle));
    closed::centred::triangles_in_sphere(sides, touching, |triangle, &[p, q, r], depth| {
        found.push(TouchingTriangle {
            triangle,
            corners: [turn * p, turn * q, turn * r],
            depth: Some(depth),
            at_most: (depth.depth + depth.error_bound).next_up(),
            diameters: longest_edge([p, q, r]) + 2.0 * radii,
            slack,
            is_open: true,
        });
    })
}

/// How deep a mesh and a sphere overlap, at the accuracy of f32, of which these parts touch; `None` of other shapes, and
/// where f64 leaves one open.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(crate) fn depth_in_sphere([a, b]: [PosedShape<'_>; 2], touching: &[[u32; 2]]) -> Option<Depth> {
    let (sides, mesh) = match (a.shape, b.shape) {
        (Shape::Mesh(_), _) => ([a, b], 0),
        _ => ([b, a], 1),
    };
    let mut deepest = Deepest::default();
    let triangles = touching.iter().map(|pair| pair[mesh]);
    closed::centred::triangles_in_sphere(sides, Some(triangles), |_, _, depth| {
        deepest.add(depth);
    })?;
    let found = deepest.depth()?;
    Some(if mesh == 0 { found } else { found.mirrored() })
}

/// Appends those triangles that are known to touch, with depths whose bounds are at
/// most a part `relative` of them or `of_size` of the pair's size; what is known of these is not found again. `None`, and
/// some of them, where a length is out of range.
pub(crate) fn touching_triangles(
    [mesh, body]: [PosedShape<'_>; 2],
    good: [f64; 2],
    (triangles, known): (impl Iterator<Item = u32>, KnownParts<'_>),
    found: &mut Vec<TouchingTriangle>,
) -> Option<()> {
    let Shape::Mesh(of_mesh) = mesh.shape else { return None };
    let mut triangles = triangles.peekable();
    let Some(&first) = triangles.peek() else { return Some(()) };
    let first = Side::of(mesh).part(first);
    let mut couple = Couple::of([first, Part::Shape(body.shape)], [mesh.pose, body.pose])?;
    let (slack, is_good) = (couple.slack(), couple.is_good(good));
    let of_body = couple.second_diameter();
    let most = |found: &Depth| (found.depth + found.error_bound).next_up();
    let turn = *mesh.pose.rotation();
    for triangle in triangles {
        let corners = of_mesh.corners(triangle as usize)?;
        couple.take_triangle(corners);
        let depth = couple.by_formula(known.depth(triangle), &is_good);
        let at_most = match &depth {
            Some(found) => most(found),
            None => couple.by_nearest().map_or_else(|| couple.most(), |found| most(&found)),
        };
        let [p, q, r] = corners;
        found.push(TouchingTriangle {
            triangle,
            corners: [turn * p, turn * q, turn * r],
            depth,
            at_most,
            diameters: couple.diameters_with(of_body, slack),
            slack,
            is_open: true,
        });
    }
    Some(())
}

/// How deep a mesh and a convex polytope overlap of which those parts touch; the mesh's is the part of that place. The bound is
/// at most a part `relative` of the depth or `of_size` of the pair's size. `None` where no formula finds the depth of a triangle
/// that may be the deepest, and where a length is out of range.
///
/// A triangle that the deepest before it bounds, or that is known to be less deep, is not measured.
pub(crate) fn deepest_by_formula(
    [mesh, body]: [PosedShape<'_>; 2],
    good: [f64; 2],
    (known, of_mesh): (KnownParts<'_>, usize),
) -> Option<Depth> {
    let Shape::Mesh(triangles) = mesh.shape else { return None };
    let parts = known.parts;
    let triangle = |place: usize| parts[place][of_mesh];
    let first = Side::of(mesh).part(parts.first()?[of_mesh]);
    let mut couple = Couple::of([first, Part::Shape(body.shape)], [mesh.pose, body.pose])?;
    let slack = couple.slack();
    let is_good = couple.is_good(good);
    let mut deepest = Deepest::default();
    // What the body reaches along the normal of the deepest so far.
    let mut body_along = None;
    // What may be the deepest first, for it bounds the others.
    let most = |&j: &usize, &k: &usize| {
        known.at_most(triangle(j)).total_cmp(&known.at_most(triangle(k))).then(k.cmp(&j))
    };
    let lead = (0..parts.len()).max_by(most)?;
    for place in std::iter::once(lead).chain((0..parts.len()).filter(|&place| place != lead)) {
        let triangle = triangle(place);
        if deepest.bounds(known.at_most(triangle)) {
            continue;
        }
        let corners = triangles.corners(triangle as usize)?;
        if let Some(normal) = deepest.normal() {
            let body_along = body_along.get_or_insert_with(|| couple.second_along(normal));
            if deepest.bounds(body_along.of_triangle(&corners) + slack) {
                continue;
            }
        }
        couple.take_triangle(corners);
        if deepest.add(couple.by_formula(known.depth(triangle), &is_good)?) {
            body_along = None;
        }
    }
    deepest.depth()
}
