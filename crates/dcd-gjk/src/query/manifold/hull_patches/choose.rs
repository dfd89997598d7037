//! Four corners of each patch that stand for all.

use super::rows::{Kept, Slot, Slots, Vector, abs, store};
use dcd_simd::Lanes;

/// A place square to the normal.
type Place<L> = [<L as Lanes>::D; 2];

/// The first corner with the largest value so far.
struct Best<L: Lanes> {
    value: L::D,
    place: Place<L>,
    depth: L::D,
    slot: L::D,
}

impl<L: Lanes> Best<L> {
    #[inline(always)]
    fn none(l: L) -> Self {
        let (zero, least) = (l.splat_d(0.0), l.splat_d(f64::NEG_INFINITY));
        Self { value: least, place: [zero; 2], depth: least, slot: zero }
    }

    /// Takes a place for a larger value.
    #[inline(always)]
    fn offer(&mut self, l: L, [x, y, depth]: Vector<L>, slot: usize, value: L::D) {
        let offered = Self { value, place: [x, y], depth, slot: l.splat_d(slot as f64) };
        *self = Self::select_lt(l, [self.value, value], &offered, self);
    }

    /// `yes` where the first of two numbers is less, else `no`.
    #[inline(always)]
    fn select_lt(l: L, [a, b]: [L::D; 2], yes: &Self, no: &Self) -> Self {
        Self {
            value: l.select_lt_d(a, b, yes.value, no.value),
            place: [
                l.select_lt_d(a, b, yes.place[0], no.place[0]),
                l.select_lt_d(a, b, yes.place[1], no.place[1]),
            ],
            depth: l.select_lt_d(a, b, yes.depth, no.depth),
            slot: l.select_lt_d(a, b, yes.slot, no.slot),
        }
    }
}

/// A side of a triangle: how far a place is outside of it, times its length.
struct Side<L: Lanes>([L::D; 3]);

impl<L: Lanes> Side<L> {
    /// Outside is to the right of the way from one to another, for a sense of 1.
    #[inline(always)]
    fn of(l: L, [from, to]: [Place<L>; 2], sense: L::D) -> Self {
        let [x, y] = minus(l, to, from);
        let (a, b) = (l.mul_d(y, sense), l.mul_d(l.sub_d(l.splat_d(0.0), x), sense));
        let there = l.add_d(l.mul_d(a, from[0]), l.mul_d(b, from[1]));
        Self([a, b, l.sub_d(l.splat_d(0.0), there)])
    }

    #[inline(always)]
    fn outside(&self, l: L, x: L::D, y: L::D) -> L::D {
        let Self([a, b, c]) = *self;
        l.add_d(l.add_d(l.mul_d(a, x), l.mul_d(b, y)), c)
    }
}

#[inline(always)]
fn minus<L: Lanes>(l: L, p: Place<L>, q: Place<L>) -> Place<L> {
    [l.sub_d(p[0], q[0]), l.sub_d(p[1], q[1])]
}

#[inline(always)]
fn squared<L: Lanes>(l: L, [x, y]: Place<L>) -> L::D {
    l.add_d(l.mul_d(x, x), l.mul_d(y, y))
}

impl Slots {
    #[inline(always)]
    fn load<L: Lanes>(&self, l: L, slot: usize) -> Vector<L> {
        let Slot { x, y, depth, .. } = &self.0[slot];
        [l.load_d(x), l.load_d(y), l.load_d(depth)]
    }
}

/// That value of a corner, of other places the least.
#[inline(always)]
fn if_corner<L: Lanes>(l: L, depth: L::D, value: L::D) -> L::D {
    let least = l.splat_d(f64::NEG_INFINITY);
    l.select_lt_d(least, depth, value, least)
}

/// The corner that is farthest from a place, and by how much, squared.
#[inline(always)]
fn farthest<L: Lanes>(l: L, slots: &Slots, count: usize, from: Place<L>) -> Best<L> {
    let mut best = Best::none(l);
    for slot in 0..count {
        let corner @ [x, y, depth] = slots.load(l, slot);
        let distance = squared(l, minus(l, [x, y], from));
        best.offer(l, corner, slot, if_corner(l, depth, distance));
    }
    best
}

impl Kept {
    /// The deepest; the farthest from it; the one that spans the largest triangle with both; and the one that is farthest
    /// outside of that. Of corners in line the ends. Those that are no farther apart than `near` are one. Leaves the places in
    /// the first two rows of the offsets.
    #[inline(always)]
    pub(super) fn choose<L: Lanes>(&mut self, l: L, slots: &Slots, count: usize, near: L::D) {
        let (zero, one, least) = (l.splat_d(0.0), l.splat_d(1.0), l.splat_d(f64::NEG_INFINITY));
        let mut first = Best::none(l);
        let mut corners = zero;
        for slot in 0..count {
            let corner @ [_, _, depth] = slots.load(l, slot);
            first.offer(l, corner, slot, depth);
            corners = l.add_d(corners, l.select_lt_d(least, depth, one, zero));
        }
        let second = farthest(l, slots, count, first.place);
        let base = minus(l, second.place, first.place);
        let near_squared = l.mul_d(near, near);
        let has_second = l.select_lt_d(near_squared, second.value, one, zero);
        let line = Side::of(l, [first.place, second.place], one);
        let (mut third, mut side) = (Best::none(l), zero);
        for slot in 0..count {
            let corner @ [x, y, depth] = slots.load(l, slot);
            let off = line.outside(l, x, y);
            let value = if_corner(l, depth, abs(l, off));
            side = l.select_lt_d(third.value, value, off, side);
            third.offer(l, corner, slot, value);
        }
        // The square of a length times `near`.
        let level = l.mul_d(near_squared, squared(l, base));
        let has_third = wide(l, third.value, level, has_second);
        let four = l.select_lt_d(l.splat_d(3.5), corners, has_third, zero);
        let (mut fourth, mut has_fourth) = (Best::none(l), zero);
        if l.lt_d(zero, four) != 0 {
            // Outside of the first side is to the other side of it.
            let sense = l.select_lt_d(side, zero, one, l.splat_d(-1.0));
            let sides = [
                Side::of(l, [first.place, second.place], sense),
                Side::of(l, [second.place, third.place], sense),
                Side::of(l, [third.place, first.place], sense),
            ];
            for slot in 0..count {
                let corner @ [x, y, depth] = slots.load(l, slot);
                let [p, q, r] = [
                    sides[0].outside(l, x, y),
                    sides[1].outside(l, x, y),
                    sides[2].outside(l, x, y),
                ];
                let most = l.select_lt_d(p, q, q, p);
                let most = l.select_lt_d(most, r, r, most);
                fourth.offer(l, corner, slot, if_corner(l, depth, most));
            }
            has_fourth = wide(l, fourth.value, level, four);
        }
        // In line: the other end, unless the deepest is it.
        let in_line = l.mul_d(has_second, l.sub_d(one, has_third));
        let in_line = l.select_lt_d(l.splat_d(2.5), corners, in_line, zero);
        let mut has_third = has_third;
        if l.lt_d(zero, in_line) != 0 {
            let end = farthest(l, slots, count, second.place);
            let distance = squared(l, minus(l, end.place, first.place));
            let has_end = l.select_lt_d(near_squared, distance, in_line, zero);
            third = Best::select_lt(l, [zero, has_end], &end, &third);
            has_third = l.add_d(has_third, has_end);
        }
        for (k, best) in [&first, &second, &third, &fourth].into_iter().enumerate() {
            l.store_d(best.slot, &mut self.slots[k]);
            l.store_d(best.depth, &mut self.depths[k]);
            store(l, [best.place[0], best.place[1], zero], &mut self.offsets[k]);
        }
        let further = l.add_d(l.add_d(has_second, has_third), has_fourth);
        l.store_d(l.add_d(one, further), &mut self.count);
    }
}

/// 1 where a product of lengths is above the root of `level`, and `if_wide` is 1; else 0.
#[inline(always)]
fn wide<L: Lanes>(l: L, value: L::D, level: L::D, if_wide: L::D) -> L::D {
    let zero = l.splat_d(0.0);
    let square = l.select_lt_d(zero, value, l.mul_d(value, value), zero);
    l.select_lt_d(level, square, if_wide, zero)
}
