//! Closed forms: pairs whose answer needs no search.
//!
//! Each says what it proves and leaves the rest to the general path, which is its oracle. A form
//! stays here only where it measures faster than that path, or where there is no other
//! (half-spaces, which have no support map).

mod binary;
mod cuboids;
pub mod half_space;
mod segments;

use crate::{DistanceResult, PosedSupport, Verdict};
use dcd_geom::{Kind, Polytope};

/// Unit roundoff of f64.
const UNIT: f64 = f64::EPSILON / 2.0;

/// See `apart` in certificate.rs. Unit: u·m·|d|₁.
const SEPARATION: f64 = 7.01;

/// What a length loses, or a radius times one. Unit: u, relative. See certificate.rs.
const LENGTH: f64 = 8.0;

/// Sizes of a pair, metres, whose squares and products stay clear of under- and overflow.
const SIZES: std::ops::Range<f64> = 1e-70..1e70;

/// What a formula proves of two polytopes, if there is one for their kinds.
#[inline]
pub(crate) fn overlap(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<Verdict<()>> {
    match (a.map.kind(), b.map.kind()) {
        (Kind::Hull | Kind::Triangle, _) | (_, Kind::Hull | Kind::Triangle) => None,
        (Kind::Cuboid { .. }, Kind::Cuboid { .. }) => cuboids::overlap(a, b),
        _ => segments::overlap(a, b),
    }
}

/// The distance of two polytopes that a formula proves and that is as sharp as is promised, or that
/// they touch.
#[inline]
pub(crate) fn distance(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<DistanceResult> {
    match (a.map.kind(), b.map.kind()) {
        (Kind::Hull | Kind::Triangle, _) | (_, Kind::Hull | Kind::Triangle) => None,
        (Kind::Cuboid { .. }, Kind::Cuboid { .. }) => match cuboids::overlap(a, b)? {
            Verdict::Touching(()) => Some(DistanceResult::Touching),
            _ => None,
        },
        _ => segments::distance(a, b),
    }
}
