//! How far sixteen triangles are from one, in f32: from above by a point of each, from below by the direction between these.

use super::bounds::{NEAREST, U};
use super::spheres::Flat;
use super::triangles::{Leaves, edges, interval, load};
use crate::simd::vector::V3;
use dcd_simd::{Block, Lanes};

/// How far the difference of two points that are computed, one of each triangle, may be from that of two points of the
/// triangles. Unit: u·l, u of f32, l the size of the two leaves. [`NEAREST`] with corners that lose 8 in place of 2, √3 of
/// that; between two edges 30. Smaller: the nearest triangles are missed.
const POINTS: f64 = NEAREST + 22.0;

/// What is known of sixteen pairs of triangles. Metres of the first axes.
pub(super) struct TriangleGaps<L: Lanes> {
    /// At most their distances.
    pub(super) lower: L::F,
    /// At least their distances.
    pub(super) upper: L::F,
    /// From the second to the first, of any length.
    pub(super) direction: V3<L>,
}

impl<L: Lanes> TriangleGaps<L> {
    /// Of the triangles of a leaf and triangle `lane` of another, whose corners were turned into the first axes; no two of
    /// which intersect.
    #[inline(always)]
    pub(super) fn of(l: L, leaves: &Leaves, corners: [&[Block; 3]; 2], lane: usize) -> Self {
        let [a, b] = load(l, leaves, corners, lane);
        let direction = between(l, [&a, &b]);
        let length = l.sqrt(direction.dot(l, direction));
        let ([low, _], [_, high]) = (interval(l, direction, &a), interval(l, direction, &b));
        let lost = l.mul(l.splat(leaves.bound()), direction.norm1(l));
        let lower = l.div(l.sub(l.sub(low, high), lost), length);
        // The division and the length lose 3u. NaN, of triangles that seem to meet, bounds nothing.
        let lower = l.mul(l.max(lower, l.splat(0.0)), l.splat(1.0 - 4.0 * f32::EPSILON));
        let lower = l.select(l.lt(l.splat(0.0), length), lower, l.splat(0.0));
        let off = (POINTS * U * leaves.size()) as f32;
        let upper = l.add(length, l.splat(off + 2.0 * leaves.bound()));
        Self { lower, upper: l.mul(upper, l.splat(1.0 + 4.0 * f32::EPSILON)), direction }
    }
}

/// The shortest of the vectors from a corner of one to the nearest point of the other, and of those between two edges that
/// cross. From the second to the first; between two points of them to within rounding, whatever their shapes.
#[inline(always)]
fn between<L: Lanes>(l: L, [a, b]: [&[V3<L>; 3]; 2]) -> V3<L> {
    let (flat_a, flat_b) = (Flat::of(l, *a), Flat::of(l, *b));
    let all = l.mask(0xffff);
    let mut shortest = Shortest::of(l, flat_a.nearest(l, a[0].sub(l, b[0])));
    shortest.offer(l, flat_a.nearest(l, a[0].sub(l, b[1])), all);
    shortest.offer(l, flat_a.nearest(l, a[0].sub(l, b[2])), all);
    for corner in a {
        shortest.offer(l, flat_b.nearest(l, b[0].sub(l, *corner)).neg(l), all);
    }
    let (edges_a, edges_b) = (edges(l, a), edges(l, b));
    let (squares_a, squares_b) = (squares(l, &edges_a), squares(l, &edges_b));
    for j in 0..3 {
        for k in 0..3 {
            let (along, across) = ((edges_a[j], squares_a[j]), (edges_b[k], squares_b[k]));
            shortest.offer_crossing(l, a[j].sub(l, b[k]), along, across);
        }
    }
    shortest.vector
}

#[inline(always)]
fn squares<L: Lanes>(l: L, [p, q, r]: &[V3<L>; 3]) -> [L::F; 3] {
    [p.dot(l, *p), q.dot(l, *q), r.dot(l, *r)]
}

/// The shortest vector so far.
struct Shortest<L: Lanes> {
    vector: V3<L>,
    square: L::F,
}

impl<L: Lanes> Shortest<L> {
    #[inline(always)]
    fn of(l: L, vector: V3<L>) -> Self {
        Self { vector, square: vector.dot(l, vector) }
    }

    #[inline(always)]
    fn offer(&mut self, l: L, vector: V3<L>, allowed: L::M) {
        let square = vector.dot(l, vector);
        let is_shorter = l.and(allowed, l.lt(square, self.square));
        self.vector = V3::select(l, is_shorter, vector, self.vector);
        self.square = l.select(is_shorter, square, self.square);
    }

    /// Between two edges, each with its square, where the shortest way between their lines is between them. `from` goes from
    /// the start of the second to that of the first.
    #[inline(always)]
    fn offer_crossing(
        &mut self,
        l: L,
        from: V3<L>,
        (along, a): (V3<L>, L::F),
        (across, e): (V3<L>, L::F),
    ) {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let (b, c, f) = (along.dot(l, across), along.dot(l, from), across.dot(l, from));
        let area = l.sub(l.mul(a, e), l.mul(b, b));
        let s = l.div(l.sub(l.mul(b, f), l.mul(c, e)), area);
        let t = l.div(l.sub(l.mul(a, f), l.mul(b, c)), area);
        // Written so that NaN, of parallel edges, is outside: there a corner is as near.
        let (is_within_a, is_within_b) =
            (l.and(l.le(zero, s), l.le(s, one)), l.and(l.le(zero, t), l.le(t, one)));
        let vector = from.plus(l, s, along).plus(l, l.neg(t), across);
        self.offer(l, vector, l.and(is_within_a, is_within_b));
    }
}
