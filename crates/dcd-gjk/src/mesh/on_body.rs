//! The triangles of a mesh that touch a convex polytope, each with its depth by a formula.

use super::reach::Couple;
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
    /// At least how deep the two overlap, metres.
    pub(crate) at_most: f64,
    /// At least the sum of the two diameters.
    pub(crate) diameters: f64,
    /// What their reach along a normal may be off, metres.
    pub(crate) slack: f64,
}

/// Appends those triangles that touch a sphere, with their depths. `None`, and some of them, where it is not known of
/// one whether it touches, and of another shape.
pub(crate) fn triangles_in_sphere(
    sides: [PosedShape<'_>; 2],
    found: &mut Vec<TouchingTriangle>,
) -> Option<()> {
    let [mesh, sphere] = sides;
    let side = Side::of(mesh);
    let slack =
        Couple::of([side.part(0), Part::Shape(sphere.shape)], [mesh.pose, sphere.pose])?.slack();
    let turn = *mesh.pose.rotation();
    let radii = mesh.shape.radius() + sphere.shape.radius();
    closed::centred::triangles_in_sphere(sides, |triangle, &[p, q, r], depth| {
        let longest = p.distance_squared(q).max(q.distance_squared(r)).max(r.distance_squared(p));
        found.push(TouchingTriangle {
            triangle,
            corners: [turn * p, turn * q, turn * r],
            depth: Some(depth),
            at_most: (depth.depth + depth.error_bound).next_up(),
            diameters: longest.sqrt() + 2.0 * radii,
            slack,
        });
    })
}

/// Appends those triangles that are known to touch, with depths whose bounds are at
/// most a part `tolerance` of the pair's size. `None`, and some of them, where a length is out of range.
pub(crate) fn touching_triangles(
    [mesh, body]: [PosedShape<'_>; 2],
    tolerance: f64,
    triangles: impl Iterator<Item = u32>,
    found: &mut Vec<TouchingTriangle>,
) -> Option<()> {
    let Shape::Mesh(_) = mesh.shape else { return None };
    let side = Side::of(mesh);
    for triangle in triangles {
        let part = side.part(triangle);
        let Part::Triangle { corners: [p, q, r], .. } = part else { return None };
        let couple = Couple::of([part, Part::Shape(body.shape)], [mesh.pose, body.pose])?;
        let is_good = |found: &Depth| found.error_bound <= tolerance * couple.size();
        let depth = couple.by_formula(is_good);
        let at_most = match &depth {
            Some(found) => (found.depth + found.error_bound).next_up(),
            None => couple.most(),
        };
        let turn = *mesh.pose.rotation();
        found.push(TouchingTriangle {
            triangle,
            corners: [turn * p, turn * q, turn * r],
            depth,
            at_most,
            diameters: couple.diameters(),
            slack: couple.slack(),
        });
    }
    Some(())
}
