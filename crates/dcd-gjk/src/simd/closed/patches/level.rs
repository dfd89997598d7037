//! Where two cuboids that are not turned touch: boxes along the world's axes, whose patch is a rectangle.
//!
//! What the general search finds of them, without its projections and its list of corners.

use super::super::super::bounds::U;
use super::super::super::frame::{AXIS_ALIGNED, FramePair, ObbRecord};
use super::super::nearest_features::GAP;
use super::super::{CuboidPairs, Cuboids, Order, in_range, pick};
use super::found::{PLACES, Rows, WHOLE};
use super::{APART, POINTS, SLACK};
use dcd_geom::Pair;
use dcd_simd::{Kernel, Lanes, Path, Unfused, WIDTH, dispatch_on};

/// Whether both are cuboids whose edges are along the world's axes in the same order.
#[inline(always)]
pub(in crate::simd) fn are_level(frames: FramePair<'_>, pair: Pair) -> bool {
    let marks = frames.a.record(pair.i).marks & frames.b.record(pair.j).marks;
    marks & AXIS_ALIGNED != 0
        && is_unturned(frames.a.boxes(pair.i))
        && is_unturned(frames.b.boxes(pair.j))
}

/// Of edges along the world's axes.
#[inline(always)]
fn is_unturned(boxes: &ObbRecord) -> bool {
    let numbers = &boxes.numbers.0;
    (numbers[0] == 1.0) & (numbers[4] == 1.0) & (numbers[8] == 1.0)
}

/// Looks at pairs that are level, all of which are known to touch. The same bits on every path.
pub(in crate::simd) fn find(
    path: Path,
    frames: FramePair<'_>,
    pairs: &[Pair],
    scratch: &mut super::Scratch,
) {
    scratch.rows.resize_with(pairs.len().div_ceil(WIDTH), Rows::default);
    dispatch_on(path, Unfused(LevelPatches { frames, pairs, scratch }));
}

struct LevelPatches<'a> {
    frames: FramePair<'a>,
    pairs: &'a [Pair],
    scratch: &'a mut super::Scratch,
}

impl Kernel for LevelPatches<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let super::Scratch { packet, rows } = self.scratch;
        for (pairs, rows) in self.pairs.chunks(WIDTH).zip(rows) {
            packet.read(self.frames, pairs, Order::ByCentres);
            search(l, packet, rows);
        }
    }
}

/// Along a world axis: how deep the first and the second overlap, and where that begins and ends, from the first's centre.
#[derive(Clone, Copy)]
struct Extent<L: Lanes> {
    overlap: L::F,
    low: End<L>,
    high: End<L>,
}

/// An end of what both have in common.
#[derive(Clone, Copy)]
struct End<L: Lanes> {
    at: L::F,
    /// Whether the first ends there, and the second goes on.
    is_of_first: L::M,
}

impl<L: Lanes> End<L> {
    #[inline(always)]
    fn of(l: L, own: L::F, other: L::F, is_of_first: L::M) -> Self {
        Self { at: l.select(is_of_first, own, other), is_of_first }
    }

    #[inline(always)]
    fn select(l: L, mask: L::M, yes: Self, no: Self) -> Self {
        let of_first = l.or(l.and(mask, yes.is_of_first), l.and_not(no.is_of_first, mask));
        Self { at: l.select(mask, yes.at, no.at), is_of_first: of_first }
    }
}

impl<L: Lanes> Extent<L> {
    /// Of half edges, and the second's centre as it is seen from the first's. What is beside an end by no more than the slack is
    /// not beyond it.
    #[inline(always)]
    fn of(l: L, [first, second]: [L::F; 2], centre: L::F, slack: L::F) -> Self {
        let (above, below) = (l.add(centre, second), l.sub(centre, second));
        let back = l.neg(first);
        Self {
            overlap: l.sub(l.add(first, second), l.abs(centre)),
            low: End::of(l, back, below, l.lt(l.add(below, slack), back)),
            high: End::of(l, first, above, l.lt(l.add(first, slack), above)),
        }
    }

    /// Of three, the one with the number in each lane.
    #[inline(always)]
    fn pick(l: L, number: L::F, [x, y, z]: [Self; 3]) -> Self {
        let (is_x, is_y) = (l.lt(number, l.splat(0.5)), l.lt(number, l.splat(1.5)));
        Self {
            overlap: l.select(is_x, x.overlap, l.select(is_y, y.overlap, z.overlap)),
            low: End::select(l, is_x, x.low, End::select(l, is_y, y.low, z.low)),
            high: End::select(l, is_x, x.high, End::select(l, is_y, y.high, z.high)),
        }
    }

    #[inline(always)]
    fn end(&self, is_high: bool) -> End<L> {
        if is_high { self.high } else { self.low }
    }

    /// 2 where its ends are farther apart than that, else 1.
    #[inline(always)]
    fn ends(&self, l: L, near: L::F) -> L::F {
        let is_wide = l.lt(near, l.sub(self.high.at, self.low.at));
        l.select(is_wide, l.splat(2.0), l.splat(1.0))
    }
}

/// The corners of the rectangle by whether they are high along its first and second side, in an order in which those that are left
/// where it is a line or a point come first.
const CORNERS: [[bool; 2]; 4] = [[false, false], [true, true], [true, false], [false, true]];

/// Writes what is found of sixteen pairs.
#[inline(always)]
fn search<L: Lanes>(l: L, packet: &CuboidPairs, rows: &mut Rows) {
    let (first, second, between, size) = packet.load(l);
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    let unit = l.mul(size, l.splat(U));
    let slack = l.mul(unit, l.splat(SLACK));
    let centre = [between.0, between.1, between.2];
    let halves = [first.half, second.half];
    let x = Extent::of(l, [halves[0][0], halves[1][0]], centre[0], slack);
    let y = Extent::of(l, [halves[0][1], halves[1][1]], centre[1], slack);
    let z = Extent::of(l, [halves[0][2], halves[1][2]], centre[2], slack);
    // Of equals the first.
    let is_y = l.lt(y.overlap, x.overlap);
    let least = l.min(x.overlap, y.overlap);
    let is_z = l.lt(z.overlap, least);
    let axis = l.select(is_z, l.splat(2.0), l.select(is_y, one, zero));
    let normal = Extent::pick(l, axis, [x, y, z]);
    let p = Extent::pick(l, axis, [y, z, x]);
    let q = Extent::pick(l, axis, [z, x, y]);
    let along = pick(l, axis, centre);
    let is_back = l.lt(along, zero);
    let half = pick(l, axis, first.half);
    let plane = l.select(is_back, l.neg(half), half);
    for ([is_high_p, is_high_q], rows) in CORNERS.into_iter().zip(&mut rows.points) {
        let (at_p, at_q) = (p.end(is_high_p), q.end(is_high_q));
        let offset = turned_back(l, axis, [plane, at_p.at, at_q.at]);
        let [of_x, of_y, of_z, of_depth, bounds] = rows;
        l.store(offset[0], of_x);
        l.store(offset[1], of_y);
        l.store(offset[2], of_z);
        // What touches is at least 0 deep.
        l.store(l.max(normal.overlap, zero), of_depth);
        let code = corner_code(l, [at_p.is_of_first, at_q.is_of_first], [is_high_p, is_high_q]);
        l.store(l.add(code, l.splat(WHOLE)), bounds);
    }
    let near = l.mul(unit, l.splat(APART));
    let count = l.mul(p.ends(l, near), q.ends(l, near));
    l.store(l.mul(unit, l.splat(GAP + POINTS)), &mut rows.bound);
    let parts = [
        count,
        l.add(axis, one),
        zero,
        zero,
        face_code(l, axis, is_back),
        face_code(l, axis, l.and_not(l.le(zero, zero), is_back)),
    ];
    let mut codes = l.splat(WHOLE);
    for (part, place) in parts.into_iter().zip(PLACES) {
        codes = l.mul_add(part, l.splat(place), codes);
    }
    l.store(codes, &mut rows.codes);
    let cases = l.mul_add(second.case, l.splat(32.0), first.case);
    l.store(l.add(cases, l.splat(WHOLE)), &mut rows.cases);
    rows.known = known(l, [&first, &second], between.norm1(l)) & in_range(l, size);
    (rows.swapped, rows.backward) = (packet.swapped, l.bits(is_back));
}

/// The lanes whose centres are not one, which have no order, and whose cuboids are solid.
#[inline(always)]
fn known<L: Lanes>(l: L, [first, second]: [&Cuboids<L>; 2], apart: L::F) -> u32 {
    let are_solid = l.and(first.is_solid(l), second.is_solid(l));
    l.bits(l.and(l.lt(l.splat(0.0), apart), are_solid))
}

/// Parts along the axis of that number and the two after it, along x, y and z.
#[inline(always)]
fn turned_back<L: Lanes>(l: L, axis: L::F, [upright, p, q]: [L::F; 3]) -> [L::F; 3] {
    [pick(l, axis, [upright, q, p]), pick(l, axis, [p, upright, q]), pick(l, axis, [q, p, upright])]
}

/// What a face shows that is square to the axis of that number, as a number: see [`Shown`](super::Shown). The other corners are high
/// along the other axes.
#[inline(always)]
fn face_code<L: Lanes>(l: L, axis: L::F, is_low: L::M) -> L::F {
    let bit = pick(l, axis, [l.splat(16.0), l.splat(32.0), l.splat(64.0)]);
    let all = l.mul_add(axis, l.splat(4.0), l.splat(112.0));
    l.select(is_low, l.sub(all, bit), all)
}

/// The bounds that meet at a corner, as [`PatchPoint`](super::PatchPoint) has them, times 16 and added: by whether it is the first
/// that ends there along each side.
#[inline(always)]
fn corner_code<L: Lanes>(l: L, [of_p, of_q]: [L::M; 2], [high_p, high_q]: [bool; 2]) -> L::F {
    // The corner of the second, and its edges that are on either side.
    let own = match (high_p, high_q) {
        (false, false) => 0,
        (true, false) => 1,
        (true, true) => 2,
        (false, true) => 3,
    };
    let (edge_p, edge_q) = (if high_p { 1 } else { 3 }, if high_q { 2 } else { 0 });
    // The first's sides.
    let (side_p, side_q) = (if high_p { 4 } else { 5 }, if high_q { 6 } else { 7 });
    let [of_both, of_first, of_second, of_none] =
        [16 * side_p + side_q, 16 * edge_q + side_p, 16 * edge_p + side_q, 17 * own];
    let if_p = l.select(of_q, l.splat(of_both as f32), l.splat(of_first as f32));
    let if_not = l.select(of_q, l.splat(of_second as f32), l.splat(of_none as f32));
    l.select(of_p, if_p, if_not)
}
