//! The later stages: a second point, then a portal that the ray from the centre to the origin
//! passes, refined until it holds the origin or a plane separates it (MPR; G. Snethen, "XenoCollide:
//! Complex Collision Made Simple", Game Programming Gems 7, 2008).

use super::certificate::{hull_holds_origin, separates};
use super::frame::Frame;
use super::lot::Lot;
use super::opening::{Settled, farthest, nearest_multiple};
use super::vector::V3;
use dcd_geom::lanes::Lanes;

/// How many supports a pair may take after the second, before it is left to f64. The median is
/// two; pairs that need more are within rounding of touching, or thin.
pub(super) const ROUNDS: usize = 24;

/// Asks for a second point across the cone's axis: accepts if the hull of the inner ball and both
/// points holds the origin; else spans a plane through the centre and both, and looks beyond it on
/// the origin's side.
#[inline(always)]
pub(super) fn second_point<L: Lanes>(l: L, frame: &Frame, lot: &mut Lot, open: u32) -> u32 {
    let (c, p) = (V3::load(l, &lot.c), V3::load(l, &lot.p[0]));
    // c + τ·p is at right angles to p: the support against it opens the widest angle.
    c.plus(l, nearest_multiple(l, c, p), p).neg(l).store(l, &mut lot.d);
    let q = farthest(l, frame, lot, open);

    let (pp, pq, qq) = (p.dot(l, p), p.dot(l, q), q.dot(l, q));
    let (cp, cq) = (c.dot(l, p), c.dot(l, q));
    let determinant = l.sub(l.mul(pp, qq), l.mul(pq, pq));
    let weight = |x, xx, y| l.div(l.sub(l.mul(y, pq), l.mul(x, xx)), determinant);
    let zero = l.splat(0.0);
    let (tau_p, tau_q) = (l.max(weight(cp, qq, cq), zero), l.max(weight(cq, pp, cp), zero));
    let v = c.plus(l, tau_p, p).plus(l, tau_q, q);
    let touching = hull_holds_origin(l, lot, v, l.add(tau_p, tau_q), 2);

    let normal = p.sub(l, c).cross(l, q.sub(l, c));
    // The plane's normal points to the origin's side once p and q are in this order.
    let turned = l.lt(zero, normal.dot(l, c));
    V3::select(l, turned, q, p).store(l, &mut lot.p[0]);
    V3::select(l, turned, p, q).store(l, &mut lot.p[1]);
    V3::select(l, turned, normal.neg(l), normal).store(l, &mut lot.d);
    lot.found &= !open;
    open & l.bits(touching)
}

/// One support and what follows from it: apart, touching, a better portal; or `stuck`, where the
/// support is no farther than the portal itself and only rounding is left to gain.
#[inline(always)]
pub(super) fn round<L: Lanes>(l: L, frame: &Frame, lot: &mut Lot, open: u32) -> (Settled, u32) {
    let c = V3::load(l, &lot.c);
    let d = V3::load(l, &lot.d);
    let mut p = lot.p.each_ref().map(|p| V3::load(l, p));
    let w = farthest(l, frame, lot, open);
    let apart = separates(l, lot, d.neg(l), w);
    let had_portal = l.mask(lot.found);
    let gain = w.sub(l, p[0]).dot(l, d);
    let rounding = l.mul(l.mul(l.load(&lot.unit), l.splat(8.0)), d.norm1(l));
    let stuck = l.and(had_portal, l.le(gain, rounding));

    // On which side of the planes through the ray (from c through the origin) and w each point is.
    let zero = l.splat(0.0);
    let across = w.cross(l, c);
    let side = [0, 1, 2].map(
        #[inline(always)]
        |k: usize| l.lt(zero, p[k].dot(l, across)),
    );
    let all = l.mask(u32::MAX);
    let not = |m| l.and_not(all, m);

    // Without a portal yet: w takes the place of the point that the ray does not pass beside.
    let replaces_q = not(side[0]);
    let replaces_p = l.and(side[0], side[1]);
    let completes = l.and(side[0], not(side[1]));
    // With one: w splits it in three, and the ray passes one of them.
    let first = l.or(l.and(side[0], side[1]), l.and(not(side[0]), not(side[2])));
    let second = l.and(not(side[0]), side[2]);
    let third = l.and(side[0], not(side[1]));

    let choose = |with, without| l.or(l.and(had_portal, with), l.and_not(without, had_portal));
    p[0] = V3::select(l, choose(first, replaces_p), w, p[0]);
    p[1] = V3::select(l, choose(second, replaces_q), w, p[1]);
    p[2] = V3::select(l, choose(third, completes), w, p[2]);
    let found = l.or(had_portal, completes);
    lot.found = l.bits(found);

    let (from, to) = (V3::select(l, found, p[0], c), [p[0], p[1], p[2]]);
    let one = V3::select(l, found, to[1], to[0]).sub(l, from);
    let two = V3::select(l, found, to[2], to[1]).sub(l, from);
    one.cross(l, two).store(l, &mut lot.d);
    for (rows, p) in lot.p.iter_mut().zip(p) {
        p.store(l, rows);
    }
    let touching = l.and(found, portal_holds_origin(l, lot, c, p));
    let settled = Settled { apart: open & l.bits(apart), touching: open & l.bits(touching) };
    (settled, open & l.bits(stuck) & !settled.apart & !settled.touching)
}

/// Whether c + Σ τ_k·p_k = 0 has a solution with every τ_k ≥ 0, by the ball's certificate.
#[inline(always)]
fn portal_holds_origin<L: Lanes>(l: L, lot: &Lot, c: V3<L>, p: [V3<L>; 3]) -> L::M {
    let zero = l.splat(0.0);
    let minors = [p[1].cross(l, p[2]), p[2].cross(l, p[0]), p[0].cross(l, p[1])];
    let scale = l.div(l.splat(-1.0), p[0].dot(l, minors[0]));
    let mut v = c;
    let mut taus = zero;
    for (p, minor) in p.into_iter().zip(minors) {
        let tau = l.max(l.mul(c.dot(l, minor), scale), zero);
        v = v.plus(l, tau, p);
        taus = l.add(taus, tau);
    }
    hull_holds_origin(l, lot, v, taus, 3)
}
