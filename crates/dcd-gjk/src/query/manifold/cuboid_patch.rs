//! The manifold of two cuboids from the patch that the lanes found: f64 numbers and features from its codes.

use super::feature_code::FeatureCode;
use super::patch_writer::{PatchWriter, Point};
use super::{Feature, cuboid_faces};
use crate::PosedShape;
use crate::epa::Depth;
use crate::simd::{CuboidPatch, PatchPoint, Shown, ShownKind};
use dcd_geom::Kind;
use dcd_geom::glam::{DMat3, DVec3};
use std::hint::select_unpredictable;

/// Writes the manifold of a patch that is known; false, and nothing written, for a face without a number.
#[inline(always)]
pub(super) fn write(
    patch: CuboidPatch<'_>,
    sides: [PosedShape<'_>; 2],
    writer: &mut impl PatchWriter,
) -> bool {
    let (codes, seen) = (patch.codes(), SeenPatch::of(patch, sides));
    // Of the one that clips, and of the other.
    let [clips, other] = patch.shown();
    let [a, b] = sides;
    let [of_clips, of_other] = if seen.is_of_a { [a, b] } else { [b, a] };
    let (Some(of_clips), Some(of_other)) = (whole(clips, of_clips), whole(other, of_other)) else {
        return false;
    };
    let whole = [of_clips, of_other];
    let is_crossing = clips.kind != ShownKind::Face;
    let corners = Numbered::of([clips, other]);
    let to_other = seen.normal * if codes.clips() == 0 { -1.0 } else { 1.0 };
    let SeenPatch { origin, is_of_a, .. } = seen;
    let placed = Placed { origin, to_other, is_of_a, is_crossing, whole, corners };
    let mut points = patch.points();
    let Some(deepest) = points.next() else { return false };
    writer.begin(seen.normal_of_a(patch), seen.error_bound, placed.point(deepest));
    for point in points {
        writer.push(placed.point(point));
    }
    true
}

/// The depth of a patch that is known, with the deepest of its points.
pub(in crate::query) fn depth_of_patch(
    patch: CuboidPatch<'_>,
    sides: [PosedShape<'_>; 2],
) -> Option<Depth> {
    let seen = SeenPatch::of(patch, sides);
    let PatchPoint { offset: [x, y, z], depth, .. } = patch.points().next()?;
    let depth = f64::from(depth);
    let on_clips = seen.origin + DVec3::new(x.into(), y.into(), z.into());
    let normal = seen.normal_of_a(patch);
    // a is deepest ahead along the normal.
    let [point_a, point_b] = match seen.is_of_a {
        true => [on_clips, on_clips - normal * depth],
        false => [on_clips + normal * depth, on_clips],
    };
    let is_finite = normal.is_finite() && point_a.is_finite() && point_b.is_finite();
    let error_bound = seen.error_bound;
    is_finite.then_some(Depth { depth, normal, point_a, point_b, error_bound })
}

/// A patch beside its two cuboids.
struct SeenPatch {
    /// The first's centre.
    origin: DVec3,
    /// From the first to the second.
    normal: DVec3,
    /// Whether a is the one that clips.
    is_of_a: bool,
    error_bound: f64,
}

impl SeenPatch {
    #[inline(always)]
    fn of(patch: CuboidPatch<'_>, [a, b]: [PosedShape<'_>; 2]) -> Self {
        let is_swapped = patch.is_swapped();
        let sides = if is_swapped { [b, a] } else { [a, b] };
        let normal = normal(patch, [sides[0].pose.rotation(), sides[1].pose.rotation()]);
        let origin = sides[0].pose.translation();
        let far = origin.length() + sides[1].pose.translation().length();
        let error_bound = f64::from(patch.error_bound()) + 8.0 * f64::EPSILON * far;
        Self { origin, normal, is_of_a: (patch.codes().clips() == 1) == is_swapped, error_bound }
    }

    /// From a to b.
    #[inline(always)]
    fn normal_of_a(&self, patch: CuboidPatch<'_>) -> DVec3 {
        self.normal * if patch.is_swapped() { -1.0 } else { 1.0 }
    }
}

/// What the points of a patch have in common.
struct Placed {
    /// The first's centre.
    origin: DVec3,
    /// From the one that clips into the other.
    to_other: DVec3,
    /// Whether a is the one that clips.
    is_of_a: bool,
    /// Whether two edges cross, which is the only point.
    is_crossing: bool,
    /// What the one that clips shows, and the other.
    whole: [FeatureCode; 2],
    corners: Numbered,
}

impl Placed {
    #[inline(always)]
    fn point(&self, PatchPoint { offset: [x, y, z], depth, bounds }: PatchPoint) -> Point {
        let depth = f64::from(depth);
        let on_clips = self.origin + DVec3::new(x.into(), y.into(), z.into());
        let on_other = on_clips + self.to_other * depth;
        let [of_clips, of_other] =
            if self.is_crossing { self.whole } else { self.corners.features(bounds, self.whole) };
        let ([point_a, point_b], features) = match self.is_of_a {
            true => ([on_clips, on_other], [of_clips, of_other]),
            false => ([on_other, on_clips], [of_other, of_clips]),
        };
        Point { point_a, point_b, depth, features }
    }
}

/// From the first to the second.
#[inline(always)]
fn normal(patch: CuboidPatch<'_>, [first, second]: [&DMat3; 2]) -> DVec3 {
    let axis = |rotation: &DMat3, edge: usize| {
        let columns: &[f64; 9] = rotation.as_ref();
        let first = 3 * edge.min(2);
        DVec3::new(columns[first], columns[first + 1], columns[first + 2])
    };
    let along = match patch.codes().edges() {
        [Some(j), Some(k)] => axis(first, j).cross(axis(second, k)),
        // Selected: whose face it is cannot be predicted.
        [of_first, of_second] => axis(
            select_unpredictable(of_first.is_some(), first, second),
            of_first.or(of_second).unwrap_or_default(),
        ),
    };
    let scale = along.length().recip();
    along * select_unpredictable(patch.is_back(), -scale, scale)
}

/// What a cuboid shows, by its number; `None` for other shapes, and for a face without one.
#[inline(always)]
fn whole(shown: Shown, side: PosedShape<'_>) -> Option<FeatureCode> {
    let Shown { kind, axis, corner, case } = shown;
    Some(match kind {
        ShownKind::Vertex => FeatureCode::vertex(corner),
        ShownKind::Edge => FeatureCode::edge(corner & !(1 << axis), corner | 1 << axis),
        ShownKind::Face => {
            let is_forward = corner >> axis & 1 == 1;
            let number = cuboid_faces::number_in(case, axis as usize, is_forward);
            Feature::Face(number.or_else(|| face(side, axis as usize, is_forward))?).into()
        }
    })
}

/// The same of the face along an axis or against it, from the shape itself.
#[inline(never)]
fn face(side: PosedShape<'_>, axis: usize, is_forward: bool) -> Option<u32> {
    let polytope = side.shape.as_polytope()?;
    let Kind::Cuboid { half_extents: half } = polytope.kind() else { return None };
    cuboid_faces::face_number(polytope, half.to_array(), axis, is_forward)
}

/// The corners of a face that clips and of what it clips, by their numbers.
struct Numbered {
    /// The corner of what is clipped that is low along both of its edges, and their bits.
    clipped: u32,
    edges: [u32; 2],
    /// The corner of the face that clips that is low along both of its sides, and their bits.
    clips: u32,
    sides: [u32; 2],
}

impl Numbered {
    /// Of the one that clips and the other.
    #[inline(always)]
    fn of([clips, clipped]: [Shown; 2]) -> Self {
        // The bits of the two axes after one.
        let after = |axis: u32| {
            let twice = 0b001_001_u32 << axis;
            [twice >> 2 & 7, twice >> 1 & 7]
        };
        let edges = match clipped.kind {
            ShownKind::Face => after(clipped.axis),
            ShownKind::Edge => [1 << clipped.axis, 0],
            ShownKind::Vertex => [0, 0],
        };
        let sides = after(clips.axis);
        let low = |corner: u32, [p, q]: [u32; 2]| corner & !(p | q);
        Self { clipped: low(clipped.corner, edges), edges, clips: low(clips.corner, sides), sides }
    }

    /// What of the shape that clips and of the other a corner belongs to: by the bounds that meet there. Selected, since they
    /// cannot be predicted.
    #[inline(always)]
    fn features(&self, [j, k]: [u8; 2], whole: [FeatureCode; 2]) -> [FeatureCode; 2] {
        let [of_clips, of_clipped] = whole;
        let select = FeatureCode::select;
        let is_side = |bound: u8| bound & 12 == 4;
        let (are_sides, is_edge) = ([is_side(j), is_side(k)], j < 4);
        // On one side, or where a side of the first axis meets one of the second.
        let side = self.side(select_unpredictable(are_sides[0], j, k));
        let corner = FeatureCode::vertex(self.clips | self.end(j) | self.end(k));
        let beside = select(are_sides[0] & are_sides[1], corner, side);
        let of_clips = select(are_sides[0] | are_sides[1], beside, of_clips);
        let own = select(k < 4, FeatureCode::vertex(self.corner(j)), self.edge(j));
        [of_clips, select(is_edge, own, of_clipped)]
    }

    /// Of what is clipped: low along both edges, high along the first, along both, along the second.
    #[inline(always)]
    fn corner(&self, number: u8) -> u32 {
        let [u, v] = self.edges;
        // All bits or none.
        let mask = |is_high: bool| u32::from(is_high).wrapping_neg();
        self.clipped | u & mask((number + 1) & 2 != 0) | v & mask(number & 2 != 0)
    }

    /// The edge of what is clipped from the corner of that number to the next.
    #[inline(always)]
    fn edge(&self, from: u8) -> FeatureCode {
        let bit = select_unpredictable(from & 1 == 0, self.edges[0], self.edges[1]);
        let corner = self.corner(from);
        FeatureCode::edge(corner & !bit, corner | bit)
    }

    /// The side of the face of that number.
    #[inline(always)]
    fn side(&self, bound: u8) -> FeatureCode {
        let along = select_unpredictable(bound & 2 == 0, self.sides[1], self.sides[0]);
        let low = self.clips | self.end(bound);
        FeatureCode::edge(low, low | along)
    }

    /// The bit of a side that is at the high end of its axis.
    #[inline(always)]
    fn end(&self, bound: u8) -> u32 {
        let [p, q] = self.sides;
        let end = select_unpredictable(bound & 2 == 0, p, q);
        select_unpredictable(bound & 1 == 0, end, 0)
    }
}
