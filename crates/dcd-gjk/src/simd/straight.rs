//! Spheres, capsules and cuboids, by the nearest points of their cores: two that are straight, or one and a cuboid.
//!
//! One evaluation bounds how far the cores are apart from both sides, so that all but those within rounding of touching
//! are resolved, and their gap is known (docs/numerics/proofs.md, "Straight cores in lanes").

use super::bounds::{RADIUS, STRAIGHT, U};
use super::certificate::{Certificate, sphere_holds_origin};
use super::first_stages::Resolved;
use super::frame::{BOX, FramePair, Record, STRAIGHT_CORE, SimdFrame};
use super::packet::{AFTER_SPHERES, LanesOf, Number, PacketQueue, PairPacket, Vector, Whole};
use super::vector::V3;
use dcd_geom::Pair;
use dcd_simd::{Lanes, Row, WIDTH};

/// How often the place along a segment that is nearest to a cuboid is narrowed: three are usual. Fewer: more pairs left to the
/// stages behind. More: all take longer. Never an answer.
const NARROWINGS: usize = 5;

/// Which of these forms a pair has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CoreForm {
    /// Two segments or points.
    Straight,
    /// A segment or point, and a cuboid without a radius.
    AndCuboid,
    /// Others.
    Others,
}

impl CoreForm {
    #[inline(always)]
    pub(super) fn of(a: &Record, b: &Record) -> Self {
        let (both, either) = (a.marks & b.marks, a.marks | b.marks);
        let is_each_known =
            (a.marks & (STRAIGHT_CORE | BOX) != 0) & (b.marks & (STRAIGHT_CORE | BOX) != 0);
        match both & STRAIGHT_CORE != 0 {
            true => Self::Straight,
            false if is_each_known && either & STRAIGHT_CORE != 0 => Self::AndCuboid,
            false => Self::Others,
        }
    }

    #[inline(always)]
    pub(super) fn of_pair(frames: FramePair<'_>, pair: Pair) -> Self {
        Self::of(frames.a.record(pair.i), frames.b.record(pair.j))
    }
}

/// The pairs that wait for their nearest points, by their form.
#[derive(Clone, Debug, Default)]
pub(super) struct Straight {
    pairs: StraightPairs,
    two: PacketQueue<AFTER_SPHERES>,
    beside_cuboid: PacketQueue<AFTER_SPHERES>,
}

impl Straight {
    /// Whether a packet of one form can be taken that is `whole`.
    #[inline(always)]
    pub(super) fn has(&self, whole: Whole) -> bool {
        self.two.has(whole) || self.beside_cuboid.has(whole)
    }

    /// Appends the pairs among these lanes that have such a form, and returns which they are. There must be no whole packet.
    #[inline(always)]
    pub(super) fn push<L: Lanes>(
        &mut self,
        l: L,
        frames: FramePair<'_>,
        (packet, lanes): (&PairPacket, u32),
    ) -> u32 {
        let (mut two, mut beside_cuboid) = (0, 0);
        for lane in LanesOf(lanes) {
            let (a, b) = (frames.a.record(packet.a.0[lane]), frames.b.record(packet.b.0[lane]));
            let cores = CoreForm::of(a, b);
            two |= u32::from(cores == CoreForm::Straight) << lane;
            beside_cuboid |= u32::from(cores == CoreForm::AndCuboid) << lane;
        }
        self.two.push(l, packet, two);
        self.beside_cuboid.push(l, packet, beside_cuboid);
        two | beside_cuboid
    }

    /// Moves pairs of one form into the packet; how many, and what is proved of them.
    #[inline(always)]
    pub(super) fn resolve<L: Lanes>(
        &mut self,
        l: L,
        frames: FramePair<'_>,
        packet: &mut PairPacket,
        whole: Whole,
    ) -> (usize, Resolved<L>) {
        let Self { pairs, two, beside_cuboid } = self;
        if two.has(whole) {
            let taken = two.take(l, packet);
            return (taken, pairs.of_two(l, frames, (packet, taken)));
        }
        let taken = beside_cuboid.take(l, packet);
        (taken, pairs.beside_cuboid(l, frames, (packet, taken)))
    }
}

/// Sixteen pairs as they are read; kept, so that it need not be cleared.
#[derive(Clone, Debug, Default)]
struct StraightPairs {
    /// From the middle of a segment to an end: of a and b, or of the one that is no cuboid.
    ends: [[Row; 3]; 2],
    cuboids: [Row; WIDTH],
    /// −1 where a is the cuboid, else 1.
    sense: Row,
}

impl StraightPairs {
    #[inline(always)]
    fn set_end(&mut self, side: usize, lane: usize, (frame, object): (&SimdFrame, u32)) {
        // The other end is as far on the other side of the centre.
        let block = &frame.blocks()[frame.record(object).first as usize];
        for (end, row) in self.ends[side].iter_mut().zip(&block.0) {
            end.0[lane] = row.0[0];
        }
    }

    /// Two segments.
    #[inline(always)]
    fn of_two<L: Lanes>(
        &mut self,
        l: L,
        frames: FramePair<'_>,
        (packet, used): (&PairPacket, usize),
    ) -> Resolved<L> {
        for lane in 0..used.min(WIDTH) {
            self.set_end(0, lane, (frames.a, packet.a.0[lane]));
            self.set_end(1, lane, (frames.b, packet.b.0[lane]));
        }
        let [a, b] = [V3::load(l, &self.ends[0]), V3::load(l, &self.ends[1])];
        let NearestOfTwo { w, past, .. } = NearestOfTwo::of(l, packet.vector(l, Vector::C), [a, b]);
        resolve(l, packet, w.dot(l, w), past)
    }

    /// A segment and a cuboid.
    #[inline(always)]
    fn beside_cuboid<L: Lanes>(
        &mut self,
        l: L,
        frames: FramePair<'_>,
        (packet, used): (&PairPacket, usize),
    ) -> Resolved<L> {
        for lane in 0..used.min(WIDTH) {
            let (a, b) = ((frames.a, packet.a.0[lane]), (frames.b, packet.b.0[lane]));
            let is_first = a.0.record(a.1).marks & BOX != 0;
            let (cuboid, other) = if is_first { (a, b) } else { (b, a) };
            self.cuboids[lane] = cuboid.0.boxes(cuboid.1).numbers;
            self.sense.0[lane] = if is_first { -1.0 } else { 1.0 };
            self.set_end(0, lane, other);
        }
        let (c, sense) = (packet.vector(l, Vector::C), l.load(&self.sense));
        let middle = V3(l.mul(c.0, sense), l.mul(c.1, sense), l.mul(c.2, sense));
        let segment = InFrame::of(l, &self.cuboids, middle, V3::load(l, &self.ends[0]));
        let NearestInFrame { away, past, .. } = segment.nearest(l);
        resolve(l, packet, dot(l, away, away), past)
    }
}

/// The nearest points of two segments, at s and t in [−1, 1] from their middles to their ends.
pub(super) struct NearestOfTwo<L: Lanes> {
    pub(super) s: L::F,
    pub(super) t: L::F,
    /// From b's point to a's.
    pub(super) w: V3<L>,
    /// How far past the points ends reach along w, times its length.
    pub(super) past: L::F,
}

impl<L: Lanes> NearestOfTwo<L> {
    /// With c from b's middle to a's and their ends a and b from there: w is c + s·a − t·b.
    #[inline(always)]
    pub(super) fn of(l: L, c: V3<L>, [a, b]: [V3<L>; 2]) -> Self {
        let (aa, bb, ab) = (a.dot(l, a), b.dot(l, b), a.dot(l, b));
        let (ac, bc) = (a.dot(l, c), b.dot(l, c));
        let determinant = l.sub(l.mul(aa, bb), l.mul(ab, ab));
        let mut s = share(l, l.sub(l.mul(ab, bc), l.mul(bb, ac)), determinant);
        let mut t = share(l, l.mul_add(ab, s, bc), bb);
        // From there each to its nearest of the other: the ends, where one of them is there, and what rounding left.
        s = share(l, l.sub(l.mul(ab, t), ac), aa);
        t = share(l, l.mul_add(ab, s, bc), bb);
        let w = c.plus(l, s, a).plus(l, l.neg(t), b);
        let past_a = past_end(l, s, w.dot(l, a));
        let past_b = past_end(l, l.neg(t), w.dot(l, b));
        Self { s, t, w, past: l.add(past_a, past_b) }
    }
}

/// The quotient, from −1 to 1; 0 where the divisor is not above 0.
#[inline(always)]
fn share<L: Lanes>(l: L, x: L::F, divisor: L::F) -> L::F {
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    let within = l.max(l.min(l.div(x, divisor), one), l.neg(one));
    l.select(l.lt(zero, divisor), within, zero)
}

/// How far past the point at t in [−1, 1] of a segment an end reaches, towards less, along a direction on which the
/// half segment is `rise` long.
#[inline(always)]
fn past_end<L: Lanes>(l: L, t: L::F, rise: L::F) -> L::F {
    let one = l.splat(1.0);
    l.max(l.mul(l.add(t, one), rise), l.mul(l.sub(t, one), rise))
}

/// The place t in [−1, 1] of a segment that is nearest to a cuboid, in the cuboid's frame.
pub(super) struct NearestInFrame<L: Lanes> {
    pub(super) t: L::F,
    /// From the cuboid to the place.
    pub(super) away: [L::F; 3],
    /// How far past the place an end reaches along their difference, times its length.
    pub(super) past: L::F,
}

/// A segment in a cuboid's frame: from its middle to an end, and the cuboid's half edges.
pub(super) struct InFrame<L: Lanes> {
    from: [L::F; 3],
    along: [L::F; 3],
    half: [L::F; 3],
}

impl<L: Lanes> InFrame<L> {
    /// Of a segment from its middle, which is seen from the cuboid's centre, to its end.
    #[inline(always)]
    pub(super) fn of(l: L, cuboids: &[Row; WIDTH], middle: V3<L>, end: V3<L>) -> Self {
        let [ax, ay, az, bx, by, bz, cx, cy, cz, ox, oy, oz, ix, iy, iz, _] = l.transpose(cuboids);
        let edges = [V3(ax, ay, az), V3(bx, by, bz), V3(cx, cy, cz)];
        let half = [mean(l, ox, ix), mean(l, oy, iy), mean(l, oz, iz)];
        Self { from: seen(l, edges, middle), along: seen(l, edges, end), half }
    }

    /// From the cuboid to the point at t.
    #[inline(always)]
    fn away(&self, l: L, t: L::F) -> [L::F; 3] {
        let Self { from, along, half } = *self;
        let mut away = from;
        for k in 0..3 {
            let place = l.mul_add(t, along[k], from[k]);
            away[k] = l.sub(place, l.max(l.min(place, half[k]), l.neg(half[k])));
        }
        away
    }

    /// The derivative of half the squared distance is linear between the planes of the cuboid, and never falls: Newton's
    /// method between what brackets its root.
    #[inline(always)]
    pub(super) fn nearest(&self, l: L) -> NearestInFrame<L> {
        let along = self.along;
        let (zero, one, half) = (l.splat(0.0), l.splat(1.0), l.splat(0.5));
        let at_low = dot(l, self.away(l, l.neg(one)), along);
        let at_high = dot(l, self.away(l, one), along);
        let (is_low, is_high) = (l.le(zero, at_low), l.le(at_high, zero));
        let mut low = l.select(l.and_not(is_high, is_low), one, l.neg(one));
        let mut high = l.select(is_low, l.neg(one), one);
        let secant = l.div(l.add(at_low, at_high), l.sub(at_low, at_high));
        let mut t = l.select(l.lt(low, high), secant, low);
        for _ in 0..NARROWINGS {
            let away = self.away(l, t);
            let slope = dot(l, away, along);
            let is_before = l.lt(slope, zero);
            low = l.select(is_before, t, low);
            high = l.select(is_before, high, t);
            let mut outside = along;
            for k in 0..3 {
                outside[k] = l.select(l.lt(zero, l.abs(away[k])), along[k], zero);
            }
            let bend = dot(l, outside, outside);
            // Where there is none the point is nearest.
            let next = l.select(l.lt(zero, bend), l.sub(t, l.div(slope, bend)), t);
            let is_between = l.and(l.le(low, next), l.le(next, high));
            t = l.select(is_between, next, l.mul(l.add(low, high), half));
        }
        let away = self.away(l, t);
        NearestInFrame { t, away, past: past_end(l, t, dot(l, away, along)) }
    }
}

/// A vector's part along each edge.
#[inline(always)]
fn seen<L: Lanes>(l: L, [a, b, c]: [V3<L>; 3], v: V3<L>) -> [L::F; 3] {
    [a.dot(l, v), b.dot(l, v), c.dot(l, v)]
}

#[inline(always)]
fn mean<L: Lanes>(l: L, x: L::F, y: L::F) -> L::F {
    l.mul(l.add(x, y), l.splat(0.5))
}

#[inline(always)]
fn dot<L: Lanes>(l: L, [a, b, c]: [L::F; 3], [x, y, z]: [L::F; 3]) -> L::F {
    V3(a, b, c).dot(l, V3(x, y, z))
}

/// What two points of the cores prove, by their squared distance and how far past them, times their distance, the cores reach
/// along their difference.
#[inline(always)]
fn resolve<L: Lanes>(l: L, packet: &PairPacket, squared: L::F, beyond: L::F) -> Resolved<L> {
    let (slack, radius) = (packet.number(l, Number::Slack), packet.number(l, Number::Radius));
    let error = l.mul_add(packet.number(l, Number::Unit), l.splat(STRAIGHT), l.add(slack, slack));
    let length = l.sqrt(squared);
    // No number where they are one point, which proves nothing.
    let lower = l.sub(l.sub(length, l.div(beyond, length)), error);
    let apart = Certificate::new(l, l.lt(radius, lower), l.sub(lower, radius), l.splat(1.0));
    let within = l.sub(l.mul(radius, l.splat(1.0 - RADIUS * U)), error);
    let touching = sphere_holds_origin(l, squared, within, l.splat(1.0));
    Resolved::by(l, apart, touching, u32::MAX)
}

#[cfg(test)]
mod tests;
