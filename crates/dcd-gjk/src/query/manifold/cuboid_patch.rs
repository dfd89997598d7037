//! The manifold of two cuboids from the patch that the lanes found: f64 numbers and features from its codes.

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
    let whole = [of_first, of_second];
    let corners = Numbered::of(patch.shown[clips], patch.shown[1 - clips]);
    let is_crossing = patch.shown[clips].kind != ShownKind::Face;
    // Which of the two ends is a's, and whose face the points are on.
    let (of_a, on_face) = (usize::from(patch.is_swapped), [whole[clips], whole[1 - clips]]);
    for (point, of_lanes) in found.points.iter_mut().zip(&patch.points[..usize::from(patch.count)])
    {
        let depth = f64::from(of_lanes.depth);
        let [x, y, z] = of_lanes.offset;
        let offset = DVec3::new(x.into(), y.into(), z.into());
        let here = origin + offset;
        let (on_first, on_second) =
            if clips == 0 { (here, here - normal * depth) } else { (here + normal * depth, here) };
        let features = match is_crossing {
            true => whole,
            false => {
                let [j, k] = of_lanes.bounds;
                let [of_clips, of_clipped] = corners.features([j, k], on_face);
                if clips == 0 { [of_clips, of_clipped] } else { [of_clipped, of_clips] }
            }
        };
        if of_a == 0 {
            (point.point_a, point.point_b, point.features) = (on_first, on_second, features);
        } else {
            let [first, second] = features;
            (point.point_a, point.point_b, point.features) = (on_second, on_first, [second, first]);
        }
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

/// The corners of a face that clips and of what it clips, by their numbers, each in a round.
struct Numbered {
    /// Low along both edges, high along the first, along both, along the second.
    clipped: [u8; 4],
    /// High along both sides, low along the first, along both, along the second.
    clips: [u8; 4],
}

impl Numbered {
    #[inline(always)]
    fn of(clips: Shown, clipped: Shown) -> Self {
        const NEXT: [u8; 4] = [1, 2, 0, 0];
        let bits = |axis: u8| {
            let after = NEXT[usize::from(axis % 4)];
            (1u8 << after, 1u8 << NEXT[usize::from(after)])
        };
        let (u, v) = match clipped.kind {
            ShownKind::Face => bits(clipped.axis),
            ShownKind::Edge => (1 << clipped.axis, 0),
            ShownKind::Vertex => (0, 0),
        };
        let low = clipped.corner & !(u | v);
        let (p, q) = bits(clips.axis);
        let base = clips.corner & !(p | q);
        Self {
            clipped: [low, low | u, low | u | v, low | v],
            clips: [base | p | q, base | q, base, base | p],
        }
    }

    /// What of the shape that clips and of the other a corner belongs to: by the bounds that meet there.
    #[inline(always)]
    fn features(&self, [j, k]: [u8; 2], [of_clips, of_clipped]: [Feature; 2]) -> [Feature; 2] {
        match (j, k) {
            (0..4, 0..4) => [of_clips, Feature::Vertex(self.clipped[usize::from(j)].into())],
            (0..4, 8..) => [of_clips, self.edge(j)],
            (0..4, _) => [self.side(k), self.edge(j)],
            (_, 8..) => [self.side(j), of_clipped],
            // The corner where a side of the first axis meets one of the second.
            _ => {
                let corner = [[0, 3], [1, 2]][usize::from(j & 1)][usize::from(k & 1)];
                [Feature::Vertex(self.clips[corner].into()), of_clipped]
            }
        }
    }

    /// The edge of what is clipped from the corner of that number to the next.
    #[inline(always)]
    fn edge(&self, from: u8) -> Feature {
        let [from, to] = [from, from + 1].map(|k| self.clipped[usize::from(k % 4)]);
        edge(from.into(), to.into())
    }

    /// The side of the face of that number.
    #[inline(always)]
    fn side(&self, bound: u8) -> Feature {
        let (from, to) = [(3, 0), (1, 2), (0, 1), (2, 3)][usize::from(bound % 4)];
        edge(self.clips[from].into(), self.clips[to].into())
    }
}
