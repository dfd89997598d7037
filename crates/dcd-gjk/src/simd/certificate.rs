//! The three certificates of the lanes. What they conclude is proved; what they leave open is not
//! wrong, only unresolved (docs/numerics/proofs.md, "lanes").

use super::bounds::{HULL_OF_SPHERE, SHORTEST, U};
use super::decide::{Scratch, Slice};
use super::frame::{LIVE, WHOLE};
use super::packet::{Number, PairPacket};
use super::vector::V3;
use crate::Report;
use dcd_simd::Lanes;

/// What a conclusion is worth.
pub trait ErrorBounds: Copy + Send + Sync {
    /// What stands for a quantity's rounding: the bound itself, or nothing.
    fn rounding<L: Lanes>(l: L, bound: L::F) -> L::F;

    /// Whether a pair on which nothing is left to gain is handed on rather than called touching.
    const HANDS_ON: bool;

    /// The mark of records whose pairs are decided.
    const JUDGED: u8;

    /// What is kept beside a conclusion.
    const KEEPS: KeptProof;

    /// [`Slice::judge`]. Of no type parameter, so that the kernels are compiled here, once, and not
    /// by every crate that names a narrow phase.
    fn judge(slice: &Slice<'_>, scratch: &mut Scratch, report: &mut Report);
}

/// What is kept of a proof for later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeptProof {
    /// Nothing but its conclusion.
    Nothing,
    /// How far apart the two objects are at least, where it proves that they are.
    Gap,
    /// Its clearance, and an axis to begin with in the next step: more is done for a proof that lasts longer.
    Clearance,
}

/// Every rounding is counted: what is concluded is proved.
#[derive(Clone, Copy, Debug)]
pub struct CertifiedBounds;

impl ErrorBounds for CertifiedBounds {
    #[inline(always)]
    fn rounding<L: Lanes>(_: L, bound: L::F) -> L::F {
        bound
    }
    const HANDS_ON: bool = true;
    const JUDGED: u8 = LIVE;
    const KEEPS: KeptProof = KeptProof::Nothing;

    fn judge(slice: &Slice<'_>, scratch: &mut Scratch, report: &mut Report) {
        slice.judge::<Self>(scratch, report);
    }
}

/// As [`CertifiedBounds`], and how far the two objects may move before the proof no longer holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClearanceBounds;

impl ErrorBounds for ClearanceBounds {
    #[inline(always)]
    fn rounding<L: Lanes>(_: L, bound: L::F) -> L::F {
        bound
    }
    const HANDS_ON: bool = true;
    const JUDGED: u8 = LIVE;
    const KEEPS: KeptProof = KeptProof::Clearance;

    fn judge(slice: &Slice<'_>, scratch: &mut Scratch, report: &mut Report) {
        slice.judge::<Self>(scratch, report);
    }
}

/// As [`CertifiedBounds`], and how far the two objects are apart at least where they are apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GapBounds;

impl ErrorBounds for GapBounds {
    #[inline(always)]
    fn rounding<L: Lanes>(_: L, bound: L::F) -> L::F {
        bound
    }
    const HANDS_ON: bool = true;
    const JUDGED: u8 = LIVE;
    const KEEPS: KeptProof = KeptProof::Gap;

    fn judge(slice: &Slice<'_>, scratch: &mut Scratch, report: &mut Report) {
        slice.judge::<Self>(scratch, report);
    }
}

/// No error bounds: f32 results are used as they are, as in most libraries.
#[derive(Clone, Copy, Debug)]
pub struct UncheckedBounds;

impl ErrorBounds for UncheckedBounds {
    #[inline(always)]
    fn rounding<L: Lanes>(l: L, _: L::F) -> L::F {
        l.splat(0.0)
    }
    const HANDS_ON: bool = false;
    // Between the hull inside a curved shape and the shape itself only bounds can decide.
    const JUDGED: u8 = WHOLE;
    const KEEPS: KeptProof = KeptProof::Nothing;

    fn judge(slice: &Slice<'_>, scratch: &mut Scratch, report: &mut Report) {
        slice.judge::<Self>(scratch, report);
    }
}

/// What a certificate proves of sixteen pairs.
///
/// The clearance of a lane where it holds is a distance s, metres, rounded down: along every unit
/// direction A − B reaches s beyond the origin (touching), or along one it stays s short of it
/// (apart). So the conclusion outlasts any motion of the two objects by which no point of A and
/// no point of B travel more than s together. A caller that does not read it does not pay for it.
#[derive(Clone, Copy)]
pub(super) struct Certificate<L: Lanes> {
    pub(super) holds: L::M,
    pub(super) clearance: L::F,
}

/// What the few roundings of a clearance, a square root among them, may add to it. No unit.
const CLEARANCE: f32 = 1.0 - 16.0 * U;

impl<L: Lanes> Certificate<L> {
    /// By a difference whose parts are rounded to the safe side already, in units of `unit`.
    #[inline(always)]
    pub(super) fn new(l: L, holds: L::M, difference: L::F, unit: L::F) -> Self {
        Self { holds, clearance: l.mul(l.div(difference, unit), l.splat(CLEARANCE)) }
    }
}

/// Whether a sphere of radius t round v holds the origin: v·v < t², t > 0. The clearance in units of
/// `unit`.
#[inline(always)]
pub(super) fn sphere_holds_origin<L: Lanes>(
    l: L,
    squared: L::F,
    t: L::F,
    unit: L::F,
) -> Certificate<L> {
    let holds = l.and(l.lt(l.splat(0.0), t), l.lt(squared, l.mul(t, t)));
    let length = l.mul(l.sqrt(squared), l.splat(1.0 + 4.0 * U));
    Certificate::new(l, holds, l.sub(t, length), unit)
}

/// Whether v is longer than the radius t: spheres round two objects that do not meet.
#[inline(always)]
pub(super) fn sphere_misses_origin<L: Lanes>(l: L, squared: L::F, t: L::F) -> Certificate<L> {
    let holds = l.lt(l.mul(t, t), squared);
    let length = l.mul(l.sqrt(squared), l.splat(1.0 - 4.0 * U));
    Certificate::new(l, holds, l.sub(length, t), l.splat(1.0))
}

/// Whether the hull of the inner sphere and `points` points p_k holds the origin, with
/// v = c + Σ τ_k·p_k and `taus` = Σ τ_k for any τ_k ≥ 0.
#[inline(always)]
pub(super) fn hull_holds_origin<L: Lanes, T: ErrorBounds>(
    l: L,
    packet: &PairPacket,
    v: V3<L>,
    taus: L::F,
    points: usize,
) -> Certificate<L> {
    let slack = packet.number(l, Number::Slack);
    let rounding = l.mul_add(
        packet.number(l, Number::Unit),
        l.splat(HULL_OF_SPHERE[points]),
        l.add(slack, slack),
    );
    let weight = l.add(l.splat(1.0), taus);
    let rounding = T::rounding(l, l.mul(rounding, weight));
    let t = l.sub(packet.number(l, Number::Inner), rounding);
    // The hull holds a sphere of 1/(1 + Σ τ_k) of that round the origin.
    sphere_holds_origin(l, v.dot(l, v), t, weight)
}

/// Whether A − B is on the far side of direction d, with w its support along −d: the separation
/// d·w exceeds what it may be off by, and the swept radii.
#[inline(always)]
pub(super) fn separates<L: Lanes, T: ErrorBounds>(
    l: L,
    packet: &PairPacket,
    d: V3<L>,
    w: V3<L>,
) -> Certificate<L> {
    let norm1 = d.norm1(l);
    let rounding = T::rounding(l, l.mul(norm1, packet.number(l, Number::Separation)));
    // |d|₂ is off by 3u at most; the radii are rounded up by more than the product loses.
    let length = l.mul(l.sqrt(d.dot(l, d)), l.splat(1.0 + 8.0 * U));
    let bound = l.mul_add(packet.number(l, Number::Radius), length, rounding);
    let long_enough = l.lt(l.splat(SHORTEST), norm1);
    let separation = d.dot(l, w);
    let holds = l.and(l.lt(bound, separation), long_enough);
    Certificate::new(l, holds, l.sub(separation, bound), length)
}
