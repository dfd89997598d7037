//! The nearest points of rounded shapes' cores: a pair touches if they are no farther apart than
//! the radii (GJK; E. Gilbert, D. Johnson and S. Keerthi, "A fast procedure for computing the
//! distance between complex objects in three-dimensional space", 1988).

use super::bounds::{NEAREST, RADIUS, U};
use super::certificate::{Certificate, ErrorBounds, separates, sphere_holds_origin};
use super::first_stages::{Place, Resolved};
use super::packet::{Number, PairPacket, Vector};
use super::portal::ROUNDS;
use super::vector::V3;
use dcd_simd::Lanes;

/// Begins with the first support as the nearest point known.
#[inline(always)]
pub(super) fn begin<L: Lanes>(l: L, packet: &mut PairPacket) {
    let p = packet.vector(l, Vector::P0);
    packet.set_vector(l, Vector::P1, p);
    packet.set_vector(l, Vector::P2, p);
    packet.set_vector(l, Vector::D, p.neg(l));
    packet.set_number(l, Number::Round, l.splat(0.0));
}

/// One support towards the origin and what follows from it: apart, touching, a nearer point; or
/// `stuck`, where no point is nearer: the cores overlap, or only rounding is left to gain.
#[inline(always)]
pub(super) fn round<L: Lanes, T: ErrorBounds>(
    l: L,
    at: &mut Place<'_>,
    packet: &mut PairPacket,
    used: usize,
) -> (Resolved<L>, u32) {
    let d = packet.vector(l, Vector::D);
    let p =
        [packet.vector(l, Vector::P0), packet.vector(l, Vector::P1), packet.vector(l, Vector::P2)];
    let w = at.farthest(l, packet, d, used);
    let apart = separates::<L, T>(l, packet, d.neg(l), w);

    let [p0, p1, p2] = p;
    let p = [Vertex::unnumbered(l, p0), Vertex::unnumbered(l, p1), Vertex::unnumbered(l, p2)];
    let nearest = Nearest::of(l, Vertex::unnumbered(l, w), p);
    let touching = radii_reach::<L, T>(l, packet, nearest.squared);

    let round = l.add(packet.number(l, Number::Round), l.splat(1.0));
    let gains = l.lt(nearest.squared, d.dot(l, d));
    let stuck = l.or(l.le(l.splat(ROUNDS), round), l.and_not(l.mask(u32::MAX), gains));
    packet.set_number(l, Number::Round, round);
    packet.set_vector(l, Vector::P0, w);
    packet.set_vector(l, Vector::P1, nearest.p.at);
    packet.set_vector(l, Vector::P2, nearest.q.at);
    packet.set_vector(l, Vector::D, nearest.point.neg(l));
    let resolved = Resolved::by(l, apart, touching, u32::MAX);
    (resolved, l.bits(stuck) & !resolved.all())
}

/// Whether the radii reach as far as the nearest point of two cores, by the square of its distance.
#[inline(always)]
pub(super) fn radii_reach<L: Lanes, T: ErrorBounds>(
    l: L,
    packet: &PairPacket,
    squared: L::F,
) -> Certificate<L> {
    let slack = packet.number(l, Number::Slack);
    let rounding = l.mul_add(packet.number(l, Number::Unit), l.splat(NEAREST), l.add(slack, slack));
    let radius = l.mul(packet.number(l, Number::Radius), l.splat(1.0 - RADIUS * U));
    let within = l.sub(radius, T::rounding(l, rounding));
    sphere_holds_origin(l, squared, within, l.splat(1.0))
}

/// A point of A − B, and which vertices of a and b it is the difference of: see [`super::packet::Corner`].
pub(super) struct Vertex<L: Lanes> {
    pub(super) at: V3<L>,
    pub(super) corner: L::F,
}

impl<L: Lanes> Clone for Vertex<L> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<L: Lanes> Copy for Vertex<L> {}

impl<L: Lanes> Vertex<L> {
    /// A vertex whose numbers are never read.
    #[inline(always)]
    pub(super) fn unnumbered(l: L, at: V3<L>) -> Self {
        Self { at, corner: l.splat(0.0) }
    }

    #[inline(always)]
    pub(super) fn select(l: L, mask: L::M, yes: Self, no: Self) -> Self {
        let corner = l.select(mask, yes.corner, no.corner);
        Self { at: V3::select(l, mask, yes.at, no.at), corner }
    }
}

/// The point nearest to the origin of what w spans with three others: w itself, three edges, three
/// triangles. A nearer point than the last lies on one of them, unless the four hold the origin.
pub(super) struct Nearest<L: Lanes> {
    pub(super) point: V3<L>,
    pub(super) squared: L::F,
    /// The points that it lies between, and w; those that it does not need are another's copy.
    pub(super) p: Vertex<L>,
    pub(super) q: Vertex<L>,
    /// The weights of those two; w has what they leave of 1.
    pub(super) weights: [L::F; 2],
}

impl<L: Lanes> Nearest<L> {
    #[inline(always)]
    pub(super) fn of(l: L, new: Vertex<L>, p: [Vertex<L>; 3]) -> Self {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let w = new.at;
        let mut best = Candidate { point: w, squared: w.dot(l, w), weights: [zero; 3] };
        let edges = [p[0].at.sub(l, w), p[1].at.sub(l, w), p[2].at.sub(l, w)];
        let (mut along, mut square) = ([zero; 3], [zero; 3]);
        for i in 0..3 {
            along[i] = edges[i].dot(l, w);
            square[i] = edges[i].dot(l, edges[i]);
            let s = l.min(l.max(l.div(l.neg(along[i]), square[i]), zero), one);
            let mut weights = [zero; 3];
            weights[i] = s;
            let offered = Candidate::at(l, w.plus(l, s, edges[i]), weights);
            best.take_nearer(l, offered, l.mask(u32::MAX));
        }
        for i in 0..3 {
            let j = (i + 1) % 3;
            let product = edges[i].dot(l, edges[j]);
            let determinant = l.sub(l.mul(square[i], square[j]), l.mul(product, product));
            let s = l.sub(l.mul(along[j], product), l.mul(along[i], square[j]));
            let t = l.sub(l.mul(along[i], product), l.mul(along[j], square[i]));
            let (s, t) = (l.div(s, determinant), l.div(t, determinant));
            // False for a NaN, which a triangle without area makes.
            let inside = l.and(l.and(l.lt(zero, s), l.lt(zero, t)), l.lt(l.add(s, t), one));
            let point = w.plus(l, s, edges[i]).plus(l, t, edges[j]);
            let mut weights = [zero; 3];
            (weights[i], weights[j]) = (s, t);
            best.take_nearer(l, Candidate::at(l, point, weights), inside);
        }
        best.between(l, new, p)
    }

    /// The direction from the origin to the point, at right angles to what it lies in up to rounding of its own length,
    /// where `new` is the vertex that it was found with.
    ///
    /// The point itself is off by u·m, and along its plane by much more where that is thin: as a direction by that over its
    /// length. What is left of it along the plane is known to far more digits.
    #[inline(always)]
    pub(super) fn direction(&self, l: L, new: Vertex<L>) -> V3<L> {
        let (zero, one, v) = (l.splat(0.0), l.splat(1.0), self.point);
        let (e, f) = (self.p.at.sub(l, new.at), self.q.at.sub(l, new.at));
        let (ee, ef, ff) = (e.dot(l, e), e.dot(l, f), f.dot(l, f));
        let (ev, fv) = (e.dot(l, v), f.dot(l, v));
        let determinant = l.sub(l.mul(ee, ff), l.mul(ef, ef));
        let of_e = l.sub(l.mul(fv, ef), l.mul(ev, ff));
        let of_f = l.sub(l.mul(ev, ef), l.mul(fv, ee));
        let has_plane = l.lt(zero, self.weights[1]);
        let divisor = l.select(has_plane, determinant, ee);
        let s = l.div(l.select(has_plane, of_e, l.neg(ev)), divisor);
        let t = l.div(l.select(has_plane, of_f, zero), divisor);
        // False for a NaN, which a plane without area makes, and where the point is a vertex.
        let is_known = l.lt(l.add(l.abs(s), l.abs(t)), one);
        V3::select(l, is_known, v.plus(l, s, e).plus(l, t, f), v)
    }
}

/// A point of the hull of w and three others, by the weights of those.
struct Candidate<L: Lanes> {
    point: V3<L>,
    squared: L::F,
    weights: [L::F; 3],
}

impl<L: Lanes> Candidate<L> {
    #[inline(always)]
    fn at(l: L, point: V3<L>, weights: [L::F; 3]) -> Self {
        Self { point, squared: point.dot(l, point), weights }
    }

    /// Takes a point that is nearer. A NaN is not.
    #[inline(always)]
    fn take_nearer(&mut self, l: L, other: Self, allowed: L::M) {
        let nearer = l.and(l.lt(other.squared, self.squared), allowed);
        self.point = V3::select(l, nearer, other.point, self.point);
        self.squared = l.select(nearer, other.squared, self.squared);
        for k in 0..3 {
            self.weights[k] = l.select(nearer, other.weights[k], self.weights[k]);
        }
    }

    /// With the points that have a weight, two at most: the first of them and the last.
    #[inline(always)]
    fn between(self, l: L, new: Vertex<L>, p: [Vertex<L>; 3]) -> Nearest<L> {
        let Self { point, squared, weights } = self;
        let (zero, [w0, w1, w2]) = (l.splat(0.0), weights);
        let [has0, has1, has2] = [l.lt(zero, w0), l.lt(zero, w1), l.lt(zero, w2)];
        let first = Vertex::select(l, has2, p[2], new);
        let first = Vertex::select(l, has1, p[1], first);
        let first = Vertex::select(l, has0, p[0], first);
        let last = Vertex::select(l, has0, p[0], new);
        let last = Vertex::select(l, has1, p[1], last);
        let last = Vertex::select(l, has2, p[2], last);
        let second = l.select(has0, w0, l.select(has1, w1, w2));
        let middle = l.select(l.and(has0, has1), w1, zero);
        let third = l.select(l.and(l.or(has0, has1), has2), w2, middle);
        Nearest { point, squared, p: first, q: last, weights: [second, third] }
    }
}
