//! The later stages: a second point, then a portal that the ray from the centre to the origin
//! passes, refined until it holds the origin or a plane separates it (MPR; G. Snethen, "XenoCollide:
//! Complex Collision Made Simple", Game Programming Gems 7, 2008).

use super::bounds::{GAIN, PLANE, U};
use super::certificate::{Certificate, ErrorBounds, hull_holds_origin, separates};
use super::first_stages::{Place, Resolved, nearest_multiple};
use super::packet::{Number, PairPacket, Vector};
use super::tetrahedron;
use super::vector::V3;
use dcd_simd::Lanes;

/// How many supports a pair may take after the second, before it is left to f64. The median is
/// two; pairs that need more are within rounding of touching, or thin.
pub(super) const ROUNDS: f32 = 24.0;

/// Evaluates a second point across the cone's axis: accepts if the hull of the inner sphere and both
/// points holds the origin; else spans a plane through the centre and both, and looks beyond it on
/// the origin's side.
#[inline(always)]
pub(super) fn second_point<L: Lanes, T: ErrorBounds>(
    l: L,
    at: &mut Place<'_>,
    packet: &mut PairPacket,
    used: usize,
) -> Certificate<L> {
    let (c, p) = (packet.vector(l, Vector::C), packet.vector(l, Vector::P0));
    // c + τ·p is at right angles to p: the support against it opens the widest angle.
    let d = c.plus(l, nearest_multiple(l, c, p), p).neg(l);
    let q = at.farthest(l, packet, d, used);

    let (pp, pq, qq) = (p.dot(l, p), p.dot(l, q), q.dot(l, q));
    let (cp, cq) = (c.dot(l, p), c.dot(l, q));
    let determinant = l.sub(l.mul(pp, qq), l.mul(pq, pq));
    let zero = l.splat(0.0);
    let tau_p = l.max(l.div(l.sub(l.mul(cq, pq), l.mul(cp, qq)), determinant), zero);
    let tau_q = l.max(l.div(l.sub(l.mul(cp, pq), l.mul(cq, pp)), determinant), zero);
    let v = c.plus(l, tau_p, p).plus(l, tau_q, q);
    let touching = hull_holds_origin::<L, T>(l, packet, v, l.add(tau_p, tau_q), 2);

    let edge = p.sub(l, c);
    let normal = edge.cross(l, q.sub(l, c));
    // The plane's normal points to the origin's side once p and q are in this order.
    let turned = l.lt(zero, normal.dot(l, c));
    packet.set_vector(l, Vector::P0, V3::select(l, turned, q, p));
    packet.set_vector(l, Vector::P1, V3::select(l, turned, p, q));
    let normal = V3::select(l, turned, normal.neg(l), normal);
    // Where q is p again there is no plane: nothing lies across the axis, and the pair is most
    // likely apart along the shortest way from the segment to the origin. As long as a normal.
    let size = l.mul(packet.number(l, Number::Unit), l.splat(1.0 / U));
    let shortest = c.plus(l, l.div(l.neg(c.dot(l, edge)), edge.dot(l, edge)), edge);
    let nothing = V3(zero, zero, zero);
    let back = nothing.plus(l, l.neg(size), shortest);
    packet.set_vector(l, Vector::D, V3::select(l, has_no_plane(l, packet, normal), back, normal));
    packet.set_number(l, Number::Found, zero);
    packet.set_number(l, Number::Round, zero);
    touching
}

/// One support and what follows from it: apart, touching, a better portal; or `stuck`, where the
/// support is no farther than the portal itself and only rounding is left to gain.
#[inline(always)]
pub(super) fn round<L: Lanes, T: ErrorBounds>(
    l: L,
    at: &mut Place<'_>,
    packet: &mut PairPacket,
    used: usize,
) -> (Resolved<L>, u32) {
    let (c, d) = (packet.vector(l, Vector::C), packet.vector(l, Vector::D));
    let p =
        [packet.vector(l, Vector::P0), packet.vector(l, Vector::P1), packet.vector(l, Vector::P2)];
    let w = at.farthest(l, packet, d, used);
    let apart = separates::<L, T>(l, packet, d.neg(l), w);
    let had_portal = l.lt(l.splat(0.0), packet.number(l, Number::Found));
    let gain = w.sub(l, p[0]).dot(l, d);
    let rounding = l.mul(l.mul(packet.number(l, Number::Unit), l.splat(GAIN)), d.norm1(l));
    let stuck = l.or(l.and(had_portal, l.le(gain, rounding)), has_no_plane(l, packet, d));

    // On which side of the planes through the ray (from c through the origin) and w each point is.
    let across = w.cross(l, c);
    let (zero, all) = (l.splat(0.0), l.mask(u32::MAX));
    let side0 = l.lt(zero, p[0].dot(l, across));
    let side1 = l.lt(zero, p[1].dot(l, across));
    let side2 = l.lt(zero, p[2].dot(l, across));
    let (not0, not1) = (l.and_not(all, side0), l.and_not(all, side1));

    // Without a portal yet, w takes the place of the point that the ray does not pass beside, or
    // completes the portal. With one, w splits it in three, and the ray passes one of them.
    let first = l.or(l.and(side0, side1), l.and_not(not0, side2));
    let to_p0 = choose(l, had_portal, first, l.and(side0, side1));
    let to_p1 = choose(l, had_portal, l.and(not0, side2), not0);
    let completes = l.and(side0, not1);
    let p0 = V3::select(l, to_p0, w, p[0]);
    let p1 = V3::select(l, to_p1, w, p[1]);
    let p2 = V3::select(l, completes, w, p[2]);
    let found = l.or(had_portal, completes);
    packet.set_number(l, Number::Found, l.select(found, l.splat(1.0), zero));
    let round = l.add(packet.number(l, Number::Round), l.splat(1.0));
    packet.set_number(l, Number::Round, round);

    let from = V3::select(l, found, p0, c);
    let one = V3::select(l, found, p1, p0).sub(l, from);
    let two = V3::select(l, found, p2, p1).sub(l, from);
    // A pair that is stuck leaves with the direction that it is stuck at.
    packet.set_vector(l, Vector::D, V3::select(l, stuck, d, one.cross(l, two)));
    packet.set_vector(l, Vector::P0, p0);
    packet.set_vector(l, Vector::P1, p1);
    packet.set_vector(l, Vector::P2, p2);
    let mut touching = portal_holds_origin::<L, T>(l, packet, c, [p0, p1, p2]);
    let flat = l.and(found, tetrahedron::is_flat(l, packet));
    if l.bits(flat) != 0 {
        let held = tetrahedron::holds_origin::<L, T>(l, packet, c, [p0, p1, p2]);
        let held = l.and_not(l.and(flat, held), touching.holds);
        // How far they reach beyond the origin is not kept.
        touching.clearance = l.select(held, zero, touching.clearance);
        touching.holds = l.or(touching.holds, held);
    }
    touching.holds = l.and(found, touching.holds);
    let stuck = l.or(stuck, l.le(l.splat(ROUNDS), round));
    let resolved = Resolved::by(l, apart, touching, u32::MAX);
    (resolved, l.bits(stuck) & !resolved.all())
}

/// Whether c + Σ τ_k·p_k = 0 has a solution with every τ_k ≥ 0, by the sphere's certificate.
#[inline(always)]
pub(super) fn portal_holds_origin<L: Lanes, T: ErrorBounds>(
    l: L,
    packet: &PairPacket,
    c: V3<L>,
    p: [V3<L>; 3],
) -> Certificate<L> {
    let zero = l.splat(0.0);
    let (m0, m1, m2) = (p[1].cross(l, p[2]), p[2].cross(l, p[0]), p[0].cross(l, p[1]));
    let scale = l.div(l.splat(-1.0), p[0].dot(l, m0));
    let tau0 = l.max(l.mul(c.dot(l, m0), scale), zero);
    let tau1 = l.max(l.mul(c.dot(l, m1), scale), zero);
    let tau2 = l.max(l.mul(c.dot(l, m2), scale), zero);
    let v = c.plus(l, tau0, p[0]).plus(l, tau1, p[1]).plus(l, tau2, p[2]);
    hull_holds_origin::<L, T>(l, packet, v, l.add(tau0, l.add(tau1, tau2)), 3)
}

/// Whether a plane's normal is too short to be one.
#[inline(always)]
fn has_no_plane<L: Lanes>(l: L, packet: &PairPacket, normal: V3<L>) -> L::M {
    let unit = packet.number(l, Number::Unit);
    l.le(normal.norm1(l), l.mul(l.mul(unit, l.splat(PLANE / U)), unit))
}

/// `yes` where the mask is set, else `no`.
#[inline(always)]
fn choose<L: Lanes>(l: L, mask: L::M, yes: L::M, no: L::M) -> L::M {
    l.or(l.and(mask, yes), l.and_not(no, mask))
}
