//! Where two cuboids that touch touch: the axis of the least overlap, and up to four corners of what they have in common
//! along it: sixteen pairs at a time, in f32.
//!
//! Seen along the normal, what one cuboid shows is a parallelogram, an edge or a corner, and the face of the other that
//! clips it a rectangle. Each corner of what they have in common is found by itself: those of the parallelogram, the
//! crossings of its edges with the sides and with the surface, those of the rectangle, and where its sides meet the surface.
//! What the bounds do not settle is left to f64 (docs/numerics/proofs.md, "cuboids in lanes").

mod clip;
mod corners;
mod found;
pub(in super::super) mod level;
mod side;
mod within;

use super::super::bounds::U;
use super::super::frame::FramePair;
use super::super::vector::V3;
use super::overlap::Overlap;
use super::{CuboidPairs, Order, in_range};
use clip::Clip;
use corners::{Corners, Kept};
use dcd_geom::Pair;
use dcd_simd::{Kernel, Lanes, Path, Unfused, WIDTH, dispatch_on};
pub use found::CuboidPatch;
use found::{PLACES, Rows, WHOLE};
pub(crate) use found::{PatchPoint, Shown, ShownKind};
use side::{Crossing, Side};

/// How far a point may be from the surfaces of its cuboids, beyond the bound of the depth, which is 48 at the least and is
/// added. Unit: u·m; of crossing edges over the sine between them. Derived: 102 with those. Smaller: false bounds.
const POINTS: f32 = 80.0;

/// How far beside a side, or above the surface, a corner may be that counts as on it. Unit: u·m. Smaller: corners that
/// rounding loses. Larger: points beside their faces; [`POINTS`] counts it.
const SLACK: f32 = 16.0;

/// Corners that are no farther apart are one. Unit: u·m. Larger than twice [`SLACK`].
const APART: f32 = 64.0;

/// How far the deepest corner's depth may be from the least overlap. Unit: u·m. The bound counts it. Decides who answers.
const SAME: f32 = 32.0;

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Scratch {
    packet: CuboidPairs,
    /// Of each sixteen pairs what was found.
    rows: Vec<Rows>,
}

impl Scratch {
    /// What was found of the pair of that number, which must be below how many there were.
    #[inline(always)]
    pub(in super::super) fn of(&self, number: usize) -> CuboidPatch<'_> {
        CuboidPatch { rows: &self.rows[number / WIDTH], lane: number % WIDTH }
    }
}

/// Looks at pairs of cuboids, all of which are known to touch. The same bits on every path.
pub(in super::super) fn find(
    path: Path,
    frames: FramePair<'_>,
    pairs: &[Pair],
    scratch: &mut Scratch,
) {
    scratch.rows.resize_with(pairs.len().div_ceil(WIDTH), Rows::default);
    dispatch_on(path, Unfused(PatchSearch { frames, pairs, scratch }));
}

struct PatchSearch<'a> {
    frames: FramePair<'a>,
    pairs: &'a [Pair],
    scratch: &'a mut Scratch,
}

impl Kernel for PatchSearch<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Scratch { packet, rows } = self.scratch;
        for (pairs, rows) in self.pairs.chunks(WIDTH).zip(rows) {
            packet.read(self.frames, pairs, Order::ByCentres);
            search(l, packet, rows);
        }
    }
}

/// What is found of sixteen pairs.
struct Found<L: Lanes> {
    overlap: Overlap<L>,
    sides: [Side<L>; 2],
    /// Whether one shows a face, and whether it is the second's that clips.
    has_face: L::M,
    second_clips: L::M,
    clip: Clip<L>,
    kept: Kept<L>,
    /// Where edges cross, if neither shows a face.
    crossing: Crossing<L>,
    /// How far the deepest corner's depth is from the least overlap.
    off: L::F,
    /// U times the pair's size.
    unit: L::F,
}

/// Writes what is found of sixteen pairs.
#[inline(always)]
fn search<L: Lanes>(l: L, packet: &CuboidPairs, rows: &mut Rows) {
    let (first, second, between, size) = packet.load(l);
    let overlap = Overlap::of(l, [&first, &second], between, size);
    let (normal, backward) = overlap.normal(l, [&first, &second], between);
    let sides = [Side::of(l, &first, normal), Side::of(l, &second, normal.neg(l))];
    let found = Found::of(l, overlap, sides, between, l.mul(size, l.splat(U)));
    found.store_points(l, rows);
    found.store_header(l, rows);
    // Cuboids whose centres are one have no order.
    let are_apart = l.lt(l.splat(0.0), between.norm1(l));
    let are_solid = l.and(first.is_solid(l), second.is_solid(l));
    let is_known = l.and(l.and(are_apart, are_solid), found.is_known(l, size));
    let cases = l.mul_add(second.case, l.splat(32.0), first.case);
    l.store(l.add(cases, l.splat(WHOLE)), &mut rows.cases);
    rows.known = l.bits(is_known) & in_range(l, size);
    (rows.swapped, rows.backward) = (packet.swapped, l.bits(backward));
}

impl<L: Lanes> Found<L> {
    #[inline(always)]
    fn of(l: L, overlap: Overlap<L>, sides: [Side<L>; 2], between: V3<L>, unit: L::F) -> Self {
        let second_clips = l.lt(sides[0].facing(l), sides[1].facing(l));
        let has_face = l.or(sides[0].is_face, sides[1].is_face);
        let slack = l.mul(unit, l.splat(SLACK));
        let clip = Clip::of(l, [&sides[1], &sides[0]], second_clips, between);
        let mut corners = Corners::empty(l);
        clip.fill(l, slack, &mut corners);
        let kept = corners.to_four(l, l.mul(unit, l.splat(APART)));
        // A scene of upright boxes has faces alone.
        let all_have_face = l.bits(has_face).count_ones() as usize == WIDTH;
        let crossing = match all_have_face {
            true => Crossing::none(l),
            false => Crossing::of(l, &sides, between, slack),
        };
        let off = l.abs(l.sub(kept.corners[0].depth, overlap.value));
        let off = l.select(has_face, off, l.splat(0.0));
        Self { overlap, sides, has_face, second_clips, clip, kept, crossing, off, unit }
    }

    #[inline(always)]
    fn store_points(&self, l: L, rows: &mut Rows) {
        let Self { overlap, kept, crossing, .. } = self;
        for (k, (corner, rows)) in kept.corners.iter().zip(&mut rows.points).enumerate() {
            let mut offset = self.clip.in_world(l, [corner.x, corner.y]);
            let mut depth = l.min(corner.depth, overlap.value);
            if k == 0 {
                offset = V3::select(l, self.has_face, offset, crossing.offset);
                depth = overlap.value;
            }
            let [x, y, z, of_depth, bounds] = rows;
            l.store(offset.0, x);
            l.store(offset.1, y);
            l.store(offset.2, z);
            // What touches is at least 0 deep.
            l.store(l.max(depth, l.splat(0.0)), of_depth);
            l.store(l.add(corner.bounds, l.splat(WHOLE)), bounds);
        }
    }

    #[inline(always)]
    fn store_header(&self, l: L, rows: &mut Rows) {
        let Self { overlap, sides, has_face, .. } = self;
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let points = l.mul(self.unit, l.splat(POINTS));
        let points = l.select(*has_face, points, l.div(points, self.crossing.sine));
        l.store(l.add(overlap.bound, l.add(points, self.off)), &mut rows.bound);
        let parts = [
            l.select(*has_face, self.kept.count, one),
            l.add(overlap.edges[0], one),
            l.add(overlap.edges[1], one),
            l.select(self.second_clips, one, zero),
            sides[0].code(l),
            sides[1].code(l),
        ];
        let mut codes = l.splat(WHOLE);
        for k in 0..PLACES.len() {
            codes = l.mul_add(parts[k], l.splat(PLACES[k]), codes);
        }
        l.store(codes, &mut rows.codes);
    }

    /// Whether the depth is, and either a corner is as deep or two edges surely cross.
    #[inline(always)]
    fn is_known(&self, l: L, size: L::F) -> L::M {
        let is_deepest = l.le(self.off, l.mul(self.unit, l.splat(SAME)));
        let are_edges = l.and(self.sides[0].is_edge, self.sides[1].is_edge);
        let is_crossing = l.and(are_edges, self.crossing.is_known);
        let is_either =
            l.or(l.and(self.has_face, is_deepest), l.and_not(is_crossing, self.has_face));
        l.and(is_either, self.overlap.is_known(l, size))
    }
}
