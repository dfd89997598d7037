//! The first stages of a pair: balls, the axis between the centres, the cone.

use super::bounds::{HULL_OF_BALL, OUTER_BALLS, SEPARATION, SIZE, U};
use super::certificate::{
    Certificate, Trust, ball_holds_origin, ball_misses_origin, hull_holds_origin, separates,
};
use super::frame::{BOXED, Frame};
use super::lot::{Lot, Number, Vector};
use super::support::{Desk, supports};
use super::vector::V3;
use dcd_geom::Pair;
use dcd_geom::lanes::{Lanes, Row, WIDTH};

/// Which of sixteen pairs a stage settled.
#[derive(Clone, Copy)]
pub(super) struct Settled<L: Lanes> {
    pub(super) apart: u32,
    pub(super) touching: u32,
    /// The room of each settled lane: see [`Certificate`].
    pub(super) room: L::F,
}

impl<L: Lanes> Settled<L> {
    /// By two certificates of which a lane has one at most, in the lanes of `live`.
    #[inline(always)]
    pub(super) fn by(l: L, apart: Certificate<L>, touching: Certificate<L>, live: u32) -> Self {
        let room = l.select(touching.holds, touching.room, apart.room);
        let (apart, touching) = (l.bits(apart.holds) & live, l.bits(touching.holds) & live);
        Self { apart: apart & !touching, touching, room }
    }

    /// By a certificate that rejects.
    #[inline(always)]
    pub(super) fn apart(l: L, apart: Certificate<L>) -> Self {
        Self { apart: l.bits(apart.holds), touching: 0, room: apart.room }
    }

    /// By a certificate that accepts.
    #[inline(always)]
    pub(super) fn touching(l: L, touching: Certificate<L>) -> Self {
        Self { apart: 0, touching: l.bits(touching.holds), room: touching.room }
    }

    /// Without the lanes that another has settled.
    #[inline(always)]
    pub(super) fn but(self, other: Self) -> Self {
        let open = !other.all();
        Self { apart: self.apart & open, touching: self.touching & open, ..self }
    }

    /// Which lanes it settled, either way.
    #[inline(always)]
    pub(super) fn all(&self) -> u32 {
        self.apart | self.touching
    }
}

/// Sixteen pairs as they enter.
#[derive(Clone, Debug, Default)]
pub(super) struct Entry {
    pub(super) lot: Lot,
    /// What the two records of each pair say together: the difference of the centres, and 0; the sums
    /// of the inner radii, the outer radii, the sizes, the swept radii, the slacks, and of what the
    /// choice of the vertices may lose.
    sums: [Row; WIDTH],
    /// The lanes in use of which both objects are marked as judged.
    pub(super) live: u32,
    /// Those whose objects both have boxes.
    pub(super) boxed: u32,
}

impl Entry {
    /// Reads at most sixteen pairs' records; the first is number `first` of the slice.
    #[inline(always)]
    pub(super) fn read<T: Trust>(&mut self, frame: &Frame, pairs: &[Pair], first: u32) {
        (self.live, self.boxed) = (0, 0);
        let lot = &mut self.lot;
        for (k, pair) in pairs.iter().enumerate() {
            let (a, b) = (frame.record(pair.i), frame.record(pair.j));
            lot.number.0[k] = first + k as u32;
            lot.a.0[k] = pair.i;
            lot.b.0[k] = pair.j;
            let sums = &mut self.sums[k].0;
            // In the order of the record, so that they are computed as vectors.
            sums[0] = (a.centre[0] - b.centre[0]) as f32;
            sums[1] = (a.centre[1] - b.centre[1]) as f32;
            sums[2] = (a.centre[2] - b.centre[2]) as f32;
            sums[3] = (a.centre[3] - b.centre[3]) as f32;
            sums[4] = a.inner + b.inner;
            sums[5] = a.outer + b.outer;
            sums[6] = a.size + b.size;
            sums[7] = a.radius + b.radius;
            sums[8] = a.slack + b.slack;
            sums[9] = a.choice + b.choice;
            let both = a.marks & b.marks;
            self.live |= u32::from(both & T::JUDGED != 0) << k;
            self.boxed |= u32::from(both & BOXED != 0) << k;
        }
    }

    /// Accepts by inner balls and rejects by outer ones. Lanes whose size is out of range are left
    /// out of `live` from here on.
    #[inline(always)]
    pub(super) fn balls<L: Lanes, T: Trust>(&mut self, l: L) -> Settled<L> {
        let lot = &mut self.lot;
        let [x, y, z, _, inner, outer, size, radius, slack, choice, ..] = l.transpose(&self.sums);
        let c = V3(x, y, z);
        lot.set_vector(l, Vector::C, c);
        lot.set_number(l, Number::Inner, inner);
        lot.set_number(l, Number::Radius, radius);
        lot.set_number(l, Number::Slack, slack);
        let size = l.add(size, c.norm1(l));
        let in_range = l.and(l.lt(l.splat(SIZE.start), size), l.lt(size, l.splat(SIZE.end)));
        let live = l.and(l.mask(self.live), in_range);
        self.live = l.bits(live);
        let unit = l.mul(size, l.splat(U));
        lot.set_number(l, Number::Unit, unit);

        let separation = l.add(slack, choice);
        let separation = l.mul_add(unit, l.splat(SEPARATION), separation);
        lot.set_number(l, Number::Separation, separation);
        let squared = c.dot(l, c);
        let error = l.mul_add(unit, l.splat(HULL_OF_BALL[0]), l.add(slack, slack));
        let inner = l.sub(inner, T::rounding(l, error));
        let touching = ball_holds_origin(l, squared, inner, l.splat(1.0));
        let error = l.mul_add(unit, l.splat(OUTER_BALLS), l.add(slack, slack));
        let outer = l.add(outer, T::rounding(l, error));
        let apart = ball_misses_origin(l, squared, outer);
        Settled::by(l, apart, touching, self.live)
    }
}

/// Asks for the support against an axis, of itself the one between the centres: rejects if it
/// separates.
#[inline(always)]
pub(super) fn first_axis<L: Lanes, T: Trust>(
    l: L,
    at: &mut Place<'_>,
    (lot, used): (&mut Lot, usize),
    axis: V3<L>,
) -> Certificate<L> {
    let p = at.farthest(l, lot, axis.neg(l), used);
    lot.set_vector(l, Vector::P0, p);
    separates::<L, T>(l, lot, axis, p)
}

/// Accepts if the hull of the inner ball and that support point holds the origin.
#[inline(always)]
pub(super) fn cone<L: Lanes, T: Trust>(l: L, lot: &Lot) -> Certificate<L> {
    let (c, p) = (lot.vector(l, Vector::C), lot.vector(l, Vector::P0));
    let tau = nearest_multiple(l, c, p);
    let v = c.plus(l, tau, p);
    hull_holds_origin::<L, T>(l, lot, v, tau, 1)
}

/// The multiple τ ≥ 0 of p that brings c + τ·p nearest to the origin.
#[inline(always)]
pub(super) fn nearest_multiple<L: Lanes>(l: L, c: V3<L>, p: V3<L>) -> L::F {
    let tau = l.div(l.neg(c.dot(l, p)), p.dot(l, p));
    l.max(tau, l.splat(0.0))
}

/// Where supports are found.
pub(super) struct Place<'a> {
    pub(super) frame: &'a Frame,
    pub(super) desk: &'a mut Desk,
}

impl Place<'_> {
    /// The point of A − B farthest along d, for the first lanes.
    #[inline(always)]
    pub(super) fn farthest<L: Lanes>(&mut self, l: L, lot: &Lot, d: V3<L>, used: usize) -> V3<L> {
        let a = supports(l, self.frame, self.desk, (&lot.a, d), used);
        let b = supports(l, self.frame, self.desk, (&lot.b, d.neg(l)), used);
        a.sub(l, b).add(l, lot.vector(l, Vector::C))
    }
}
