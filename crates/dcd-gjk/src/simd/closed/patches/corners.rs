//! The corners of a patch, and the four that stand for all.

use dcd_simd::Lanes;

/// How many places there are for corners: four of the parallelogram or where its edges come in, four where they go out, four
/// of the rectangle, and one on each of its sides.
pub(super) const SLOTS: usize = 16;

/// A corner: its place along the sides and as it is seen along the normal, its depth, and the bounds that meet there.
#[derive(Clone, Copy)]
pub(super) struct Corner<L: Lanes> {
    pub(super) x: L::F,
    pub(super) y: L::F,
    pub(super) flat: Flat<L>,
    pub(super) depth: L::F,
    pub(super) bounds: L::F,
}

impl<L: Lanes> Corner<L> {
    #[inline(always)]
    pub(super) fn select(l: L, mask: L::M, yes: Self, no: Self) -> Self {
        Self {
            x: l.select(mask, yes.x, no.x),
            y: l.select(mask, yes.y, no.y),
            flat: [
                l.select(mask, yes.flat[0], no.flat[0]),
                l.select(mask, yes.flat[1], no.flat[1]),
            ],
            depth: l.select(mask, yes.depth, no.depth),
            bounds: l.select(mask, yes.bounds, no.bounds),
        }
    }
}

impl<L: Lanes> Corner<L> {
    /// That value if it is a corner, else the least.
    #[inline(always)]
    pub(super) fn if_used(&self, l: L, value: L::F) -> L::F {
        let least = l.splat(f32::NEG_INFINITY);
        l.select(l.lt(least, self.depth), value, least)
    }
}

/// The corners that some pair has; of the others the depth is −∞.
pub(super) struct Corners<L: Lanes> {
    pub(super) corners: [Corner<L>; SLOTS],
    pub(super) count: usize,
}

/// The corners that stand for all, and how many they are.
pub(super) struct Kept<L: Lanes> {
    pub(super) corners: [Corner<L>; 4],
    pub(super) count: L::F,
}

impl<L: Lanes> Corners<L> {
    #[inline(always)]
    pub(super) fn empty(l: L) -> Self {
        let zero = l.splat(0.0);
        let depth = l.splat(f32::NEG_INFINITY);
        let none = Corner { x: zero, y: zero, flat: [zero; 2], depth, bounds: zero };
        Self { corners: [none; SLOTS], count: 0 }
    }

    /// The deepest; the farthest from it, seen along the normal; the one that spans the largest triangle with both; and the
    /// one farthest outside of that triangle. Of corners in line the ends.
    #[inline(always)]
    pub(super) fn to_four(&self, l: L, near: L::F) -> Kept<L> {
        let corners = &self.corners[..self.count];
        let mut best = Best::of(l, &self.corners[0]);
        for corner in corners {
            best.offer(l, corner, corner.depth);
        }
        let first = best.corner;
        let farthest = self.farthest_from(l, first.flat);
        let second = farthest.corner;
        let base = minus(l, second.flat, first.flat);
        let mut best = Best::of(l, &self.corners[0]);
        for corner in corners {
            let off_line = l.abs(cross(l, base, minus(l, corner.flat, first.flat)));
            best.offer(l, corner, corner.if_used(l, off_line));
        }
        let (third, off_line) = (best.corner, best.value);
        let near_squared = l.mul(near, near);
        let level = l.mul(near, l.sqrt(squared(l, base)));
        let has_second = l.lt(near_squared, farthest.value);
        let is_wide = l.and(has_second, l.lt(level, off_line));
        let (mut fourth, mut has_fourth) = (third, is_wide);
        if l.bits(is_wide) != 0 {
            let best = self.farthest_outside(l, [first.flat, second.flat, third.flat]);
            (fourth, has_fourth) = (best.corner, l.and(is_wide, l.lt(level, best.value)));
        }
        // In line: the other end, unless the deepest is it.
        let is_line = l.and_not(has_second, is_wide);
        let (mut third, mut has_third) = (third, is_wide);
        if l.bits(is_line) != 0 {
            let last = self.farthest_from(l, second.flat).corner;
            let has_last = l.lt(near_squared, squared(l, minus(l, last.flat, first.flat)));
            third = Corner::select(l, is_wide, third, last);
            has_third = l.or(is_wide, l.and(has_second, has_last));
        }
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let mut count = one;
        for has in [has_second, has_third, has_fourth] {
            count = l.add(count, l.select(has, one, zero));
        }
        Kept { corners: [first, second, third, fourth], count }
    }

    /// The used corner that is farthest outside of a triangle, and by how much, times the edge's length.
    #[inline(always)]
    fn farthest_outside(&self, l: L, [first, second, third]: [Flat<L>; 3]) -> Best<L> {
        let base = minus(l, second, first);
        let side = cross(l, base, minus(l, third, first));
        let (to_third, back) = (minus(l, third, second), minus(l, first, third));
        let mut best = Best::of(l, &self.corners[0]);
        for corner in &self.corners[..self.count] {
            let beyond_base = outside(l, base, minus(l, corner.flat, first), side);
            let beyond_next = outside(l, to_third, minus(l, corner.flat, second), side);
            let beyond_last = outside(l, back, minus(l, corner.flat, third), side);
            let beyond = l.max(beyond_base, l.max(beyond_next, beyond_last));
            best.offer(l, corner, corner.if_used(l, beyond));
        }
        best
    }

    /// The used corner that is farthest from a place, and by how much, squared.
    #[inline(always)]
    pub(super) fn farthest_from(&self, l: L, place: Flat<L>) -> Best<L> {
        let corners = &self.corners[..self.count];
        let mut best = Best::of(l, &self.corners[0]);
        for corner in corners {
            let distance = squared(l, minus(l, corner.flat, place));
            best.offer(l, corner, corner.if_used(l, distance));
        }
        best
    }
}

/// The first corner with the largest value so far.
pub(super) struct Best<L: Lanes> {
    pub(super) corner: Corner<L>,
    pub(super) value: L::F,
}

impl<L: Lanes> Best<L> {
    #[inline(always)]
    pub(super) fn of(l: L, corner: &Corner<L>) -> Self {
        Self { corner: *corner, value: l.splat(f32::NEG_INFINITY) }
    }

    #[inline(always)]
    pub(super) fn offer(&mut self, l: L, corner: &Corner<L>, value: L::F) {
        let is_more = l.lt(self.value, value);
        self.corner = Corner::select(l, is_more, *corner, self.corner);
        self.value = l.max(self.value, value);
    }
}

/// A place seen along the normal.
pub(super) type Flat<L> = [<L as Lanes>::F; 2];

#[inline(always)]
pub(super) fn minus<L: Lanes>(l: L, p: Flat<L>, q: Flat<L>) -> Flat<L> {
    [l.sub(p[0], q[0]), l.sub(p[1], q[1])]
}

#[inline(always)]
pub(super) fn cross<L: Lanes>(l: L, p: Flat<L>, q: Flat<L>) -> L::F {
    l.sub(l.mul(p[0], q[1]), l.mul(p[1], q[0]))
}

#[inline(always)]
pub(super) fn squared<L: Lanes>(l: L, p: Flat<L>) -> L::F {
    l.mul_add(p[0], p[0], l.mul(p[1], p[1]))
}

/// How far outside of an edge of a triangle that goes round in that sense, times the edge's length.
#[inline(always)]
pub(super) fn outside<L: Lanes>(l: L, edge: Flat<L>, from_edge: Flat<L>, sense: L::F) -> L::F {
    let inside = cross(l, edge, from_edge);
    l.select(l.lt(l.splat(0.0), sense), l.neg(inside), inside)
}
