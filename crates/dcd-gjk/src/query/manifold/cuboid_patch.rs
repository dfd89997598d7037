//! The manifold of two cuboids from the patch that the lanes found: f64 numbers and features from its codes.

use super::cuboid_polygon::{LineOf, features};
use super::facing::edge;
use super::{Feature, Manifold, cuboids};
use crate::PosedShape;
use crate::simd::{CuboidPatch, Shown, ShownKind};
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Polytope};

/// Writes the manifold over an empty one; false where nothing is known, and nothing written.
#[inline]
pub(super) fn write(
    patch: &CuboidPatch,
    [a, b]: [PosedShape<'_>; 2],
    found: &mut Manifold,
) -> bool {
    let sides = if patch.is_swapped { [b, a] } else { [a, b] };
    let (Some(of_first), Some(of_second)) =
        (whole(patch.shown[0], sides[0]), whole(patch.shown[1], sides[1]))
    else {
        return false;
    };
    let normal = normal(patch, [sides[0].pose.rotation(), sides[1].pose.rotation()]);
    let origin = sides[0].pose.translation();
    let clips = usize::from(patch.clips);
    let (shown, clipped) = (patch.shown[clips], patch.shown[1 - clips]);
    let is_crossing = shown.kind != ShownKind::Face;
    for (point, of_lanes) in found.points.iter_mut().zip(&patch.points[..usize::from(patch.count)])
    {
        let depth = f64::from(of_lanes.depth);
        let [x, y, z] = of_lanes.offset;
        let on_face = origin + DVec3::new(x.into(), y.into(), z.into());
        let ends = match clips {
            0 => [on_face, on_face - normal * depth],
            _ => [on_face + normal * depth, on_face],
        };
        let features = if is_crossing {
            [of_first, of_second]
        } else {
            let [j, k] = of_lanes.bounds;
            let lines = [line(shown, clipped, j), line(shown, clipped, k)];
            let whole = [of_first, of_second];
            let [of_clips, of_clipped] = features(lines, [whole[clips], whole[1 - clips]]);
            if clips == 0 { [of_clips, of_clipped] } else { [of_clipped, of_clips] }
        };
        let swapped = usize::from(patch.is_swapped);
        (point.point_a, point.point_b) = (ends[swapped], ends[1 - swapped]);
        point.features = [features[swapped], features[1 - swapped]];
        point.depth = depth;
    }
    found.count = patch.count;
    found.normal = if patch.is_swapped { -normal } else { normal };
    let far = origin.length() + sides[1].pose.translation().length();
    found.error_bound = f64::from(patch.error_bound) + 8.0 * f64::EPSILON * far;
    true
}

/// From the first to the second.
#[inline(always)]
fn normal(patch: &CuboidPatch, rotations: [&DMat3; 2]) -> DVec3 {
    let axis = |side: usize| {
        let columns: &[f64; 9] = rotations[side].as_ref();
        let k = 3 * patch.edges[side].max(0) as usize;
        DVec3::new(columns[k], columns[k + 1], columns[k + 2])
    };
    let along = match patch.edges {
        [_, ..0] => axis(0),
        [..0, _] => axis(1),
        _ => axis(0).cross(axis(1)),
    };
    let normal = along.normalize();
    if patch.is_back { -normal } else { normal }
}

/// What a cuboid shows, by its number; `None` for other shapes, and for a face without one.
#[inline(always)]
fn whole(shown: Shown, side: PosedShape<'_>) -> Option<Feature> {
    let polytope = side.shape.as_polytope()?;
    let Kind::Cuboid { half_extents: half } = polytope.kind() else { return None };
    let Shown { kind, axis, corner } = shown;
    let bit = 1u32 << axis;
    let corner = u32::from(corner);
    Some(match kind {
        ShownKind::Vertex => Feature::Vertex(corner),
        ShownKind::Edge => edge(corner & !bit, corner | bit),
        ShownKind::Face => Feature::Face(face(polytope, half, axis, corner & bit != 0)?),
    })
}

#[inline(always)]
fn face(polytope: &Polytope, half: DVec3, axis: u8, is_forward: bool) -> Option<u32> {
    cuboids::face_number(polytope, half.to_array(), usize::from(axis), is_forward)
}

/// What of the cuboids a bound is.
#[inline(always)]
fn line(clips: Shown, clipped: Shown, bound: u8) -> LineOf<u8> {
    let after = |axis: u8| if axis == 2 { 0 } else { axis + 1 };
    let bit = |axis: u8| 1u8 << axis;
    if bound < 4 {
        let (u, v) = match clipped.kind {
            ShownKind::Face => (bit(after(clipped.axis)), bit(after(after(clipped.axis)))),
            ShownKind::Edge => (bit(clipped.axis), 0),
            ShownKind::Vertex => (0, 0),
        };
        // Round it: low along both edges, high along the first, along both, along the second.
        let (from, to) = match bound {
            0 => (0, u),
            1 => (u, u | v),
            2 => (u | v, v),
            _ => (v, 0),
        };
        let corner = clipped.corner & !(u | v);
        return LineOf::Clipped(corner | from, corner | to);
    }
    let (p, q) = (bit(after(clips.axis)), bit(after(after(clips.axis))));
    let (own, other) = match bound {
        4 => (p, q),
        5 => (0, q),
        6 => (q, p),
        7 => (0, p),
        _ => return LineOf::Surface,
    };
    let corner = clips.corner & bit(clips.axis) | own;
    LineOf::Clips(corner, corner | other)
}
