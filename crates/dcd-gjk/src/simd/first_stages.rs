//! The first stages of a pair: spheres, the axis between the centres, the cone.

use super::bounds::{HULL_OF_SPHERE, OUTER_SPHERES, SEPARATION, SIZE, U};
use super::certificate::{
    Certificate, ErrorBounds, hull_holds_origin, separates, sphere_holds_origin,
    sphere_misses_origin,
};
use super::frame::{FramePair, HAS_OBB};
use super::packet::{Number, PairPacket, Vector};
use super::support::{SupportScratch, supports};
use super::vector::V3;
use dcd_geom::Pair;
use dcd_simd::{Lanes, Row, WIDTH};

/// Which of sixteen pairs a stage resolved.
#[derive(Clone, Copy)]
pub(super) struct Resolved<L: Lanes> {
    pub(super) apart: u32,
    pub(super) touching: u32,
    /// The clearance of each resolved lane: see [`Certificate`].
    pub(super) clearance: L::F,
}

impl<L: Lanes> Resolved<L> {
    /// By two certificates of which a lane has one at most, in the lanes of `live`.
    #[inline(always)]
    pub(super) fn by(l: L, apart: Certificate<L>, touching: Certificate<L>, live: u32) -> Self {
        let clearance = l.select(touching.holds, touching.clearance, apart.clearance);
        let (apart, touching) = (l.bits(apart.holds) & live, l.bits(touching.holds) & live);
        Self { apart: apart & !touching, touching, clearance }
    }

    /// By a certificate that rejects.
    #[inline(always)]
    pub(super) fn apart(l: L, apart: Certificate<L>) -> Self {
        Self { apart: l.bits(apart.holds), touching: 0, clearance: apart.clearance }
    }

    /// By a certificate that accepts.
    #[inline(always)]
    pub(super) fn touching(l: L, touching: Certificate<L>) -> Self {
        Self { apart: 0, touching: l.bits(touching.holds), clearance: touching.clearance }
    }

    /// Without the lanes that another has resolved.
    #[inline(always)]
    pub(super) fn but(self, other: Self) -> Self {
        let open = !other.all();
        Self { apart: self.apart & open, touching: self.touching & open, ..self }
    }

    /// Which lanes it resolved, either way.
    #[inline(always)]
    pub(super) fn all(&self) -> u32 {
        self.apart | self.touching
    }
}

/// Sixteen pairs as they enter.
#[derive(Clone, Debug, Default)]
pub(super) struct Entry {
    pub(super) packet: PairPacket,
    /// What the two records of each pair give together: the difference of the centres, and 0; the sums
    /// of the inner radii, the outer radii, the sizes, the swept radii, the slacks, and of what the
    /// choice of the vertices may lose.
    sums: [Row; WIDTH],
    /// The lanes in use of which both objects are marked as judged.
    pub(super) live: u32,
    /// Those whose objects both have boxes.
    pub(super) boxed: u32,
    /// Those of them that are not judged otherwise: one is a mesh, of which nothing is known but a box.
    pub(super) boxed_alone: u32,
    /// What both objects of some pair are marked as.
    pub(super) marks: u8,
}

impl Entry {
    /// Reads at most sixteen pairs' records; the first is number `first` of the slice.
    #[inline(always)]
    pub(super) fn read<T: ErrorBounds>(
        &mut self,
        frames: FramePair<'_>,
        pairs: &[Pair],
        first: u32,
    ) {
        (self.live, self.boxed, self.marks) = (0, 0, 0);
        let packet = &mut self.packet;
        for (k, pair) in pairs.iter().enumerate() {
            let (a, b) = (frames.a.record(pair.i), frames.b.record(pair.j));
            packet.number.0[k] = first + k as u32;
            packet.a.0[k] = pair.i;
            packet.b.0[k] = pair.j;
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
            self.boxed |= u32::from(both & HAS_OBB != 0) << k;
            self.marks |= both;
        }
        self.boxed_alone = self.boxed & !self.live;
    }

    /// Accepts by inner spheres and rejects by outer ones. Lanes whose size is out of range are left
    /// out of `live` from here on.
    #[inline(always)]
    pub(super) fn spheres<L: Lanes, T: ErrorBounds>(&mut self, l: L) -> Resolved<L> {
        let packet = &mut self.packet;
        let [x, y, z, _, inner, outer, size, radius, slack, choice, ..] = l.transpose(&self.sums);
        let c = V3(x, y, z);
        packet.set_vector(l, Vector::C, c);
        packet.set_number(l, Number::Inner, inner);
        packet.set_number(l, Number::Radius, radius);
        packet.set_number(l, Number::Slack, slack);
        let size = l.add(size, c.norm1(l));
        let in_range = l.and(l.lt(l.splat(SIZE.start), size), l.lt(size, l.splat(SIZE.end)));
        let live = l.and(l.mask(self.live), in_range);
        self.live = l.bits(live);
        self.boxed_alone &= l.bits(in_range);
        let unit = l.mul(size, l.splat(U));
        packet.set_number(l, Number::Unit, unit);

        // Not fused: distances and their bounds come of it, which are the same on every path.
        let separation = l.add(l.mul(unit, l.splat(SEPARATION)), l.add(slack, choice));
        packet.set_number(l, Number::Separation, separation);
        let squared = c.dot(l, c);
        let error = l.mul_add(unit, l.splat(HULL_OF_SPHERE[0]), l.add(slack, slack));
        let inner = l.sub(inner, T::rounding(l, error));
        let touching = sphere_holds_origin(l, squared, inner, l.splat(1.0));
        let error = l.mul_add(unit, l.splat(OUTER_SPHERES), l.add(slack, slack));
        let outer = l.add(outer, T::rounding(l, error));
        let apart = sphere_misses_origin(l, squared, outer);
        Resolved::by(l, apart, touching, self.live)
    }
}

/// Evaluates the support against an axis, by default the one between the centres: rejects if it
/// separates.
#[inline(always)]
pub(super) fn first_axis<L: Lanes, T: ErrorBounds>(
    l: L,
    at: &mut Place<'_>,
    (packet, used): (&mut PairPacket, usize),
    axis: V3<L>,
) -> Certificate<L> {
    let p = at.farthest(l, packet, axis.neg(l), used);
    packet.set_vector(l, Vector::P0, p);
    separates::<L, T>(l, packet, axis, p)
}

/// Accepts if the hull of the inner sphere and that support point holds the origin.
#[inline(always)]
pub(super) fn cone<L: Lanes, T: ErrorBounds>(l: L, packet: &PairPacket) -> Certificate<L> {
    let (c, p) = (packet.vector(l, Vector::C), packet.vector(l, Vector::P0));
    let tau = nearest_multiple(l, c, p);
    let v = c.plus(l, tau, p);
    hull_holds_origin::<L, T>(l, packet, v, tau, 1)
}

/// The multiple τ ≥ 0 of p that brings c + τ·p nearest to the origin.
#[inline(always)]
pub(super) fn nearest_multiple<L: Lanes>(l: L, c: V3<L>, p: V3<L>) -> L::F {
    let tau = l.div(l.neg(c.dot(l, p)), p.dot(l, p));
    l.max(tau, l.splat(0.0))
}

/// Where supports are found.
pub(super) struct Place<'a> {
    pub(super) frames: FramePair<'a>,
    pub(super) support_scratch: &'a mut SupportScratch,
}

impl Place<'_> {
    /// The point of A − B farthest along d, for the first lanes.
    #[inline(always)]
    pub(super) fn farthest<L: Lanes>(
        &mut self,
        l: L,
        packet: &PairPacket,
        d: V3<L>,
        used: usize,
    ) -> V3<L> {
        self.farthest_numbered(l, packet, d, used).0
    }

    /// The same, with the numbers of the two vertices.
    #[inline(always)]
    pub(super) fn farthest_numbered<L: Lanes>(
        &mut self,
        l: L,
        packet: &PairPacket,
        d: V3<L>,
        used: usize,
    ) -> (V3<L>, [L::U; 2]) {
        let Self { frames, support_scratch } = self;
        let (a, of_a) = supports(l, frames.a, support_scratch, (&packet.a, d), used);
        let (b, of_b) = supports(l, frames.b, support_scratch, (&packet.b, d.neg(l)), used);
        (a.sub(l, b).add(l, packet.vector(l, Vector::C)), [of_a, of_b])
    }
}
