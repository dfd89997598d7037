//! Closed forms: pairs whose answer needs no search.
//!
//! Each returns what it proves and leaves the rest to the general path, which is its oracle. A form
//! stays here only where it measures faster than that path, or where there is no other
//! (half-spaces, which have no support map).

mod binary;
mod capsules;
pub(crate) mod centred;
mod cuboid_depth;
mod cuboid_nearest;
mod cuboids;
pub(crate) mod curved;
mod curved_points;
pub(crate) mod feature_normal;
mod gap;
pub mod half_space;
pub(crate) mod level;
mod long_points;
mod near_features;
mod profile;
mod segments;
mod spheres;
mod triangles;
pub(crate) mod two_curved;
mod upright_depth;

use crate::UNIT;
use crate::epa::Depth;
use crate::query::Accuracy;
use crate::{DistanceResult, PosedShape, PosedSupport, Verdict};
pub(crate) use cuboid_depth::{
    Axes, are_beyond as cuboids_are_beyond, depth as cuboid_depth,
    depth_along as cuboid_depth_along,
};
use dcd_geom::{Kind, Polytope, Shape};
pub(crate) use gap::Gap;
pub(crate) use near_features::{
    NearFeatures, distance_in_double_double, distance_in_f64, square_to,
};
pub(crate) use segments::{PosedCore, depth_of_cores, overlap_of_cores};
pub(crate) use spheres::{
    PlacedSphere, compare_squares, depth_of_spheres, depth_of_two_spheres, distance_of_spheres,
    distance_within, off_surface, spheres_are_beyond, two_spheres,
};
pub(crate) use triangles::nearest as nearest_of_triangle;
pub(crate) use upright_depth::depth as upright_depth;

/// See `apart` in certificate.rs. Unit: u·m·|d|₁.
const SEPARATION: f64 = 7.01;

/// What a length loses, or a radius times one. Unit: u, relative. See certificate.rs.
const LENGTH: f64 = 8.0;

/// Sizes of a pair, metres, whose squares and products stay clear of under- and overflow.
pub(crate) const SIZES: std::ops::Range<f64> = 1e-70..1e70;

/// Whether there is a formula for two kinds: none for hulls, for triangles only against spheres and capsules.
fn have_formula(one: Kind, other: Kind) -> bool {
    match (one, other) {
        (Kind::Triangle, Kind::Point | Kind::Segment)
        | (Kind::Point | Kind::Segment, Kind::Triangle) => true,
        _ => [one, other].iter().all(|kind| !matches!(kind, Kind::Hull | Kind::Triangle)),
    }
}

/// What a formula proves of two polytopes, if there is one for their kinds.
#[inline]
pub(crate) fn overlap(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<Verdict<()>> {
    match (a.map.kind(), b.map.kind()) {
        (one, other) if !have_formula(one, other) => None,
        (Kind::Cuboid { .. }, Kind::Cuboid { .. }) => cuboids::overlap(a, b),
        (Kind::Point, Kind::Point) => spheres::overlap(a, b).or_else(|| segments::overlap(a, b)),
        _ => segments::overlap(a, b),
    }
}

/// How far the bounds may leave a certified distance or depth open, relative to itself: a tenth of what is
/// promised of a distance.
pub(crate) const SHARP: f64 = 1e-13;

/// What a formula leaves open is taken up to [`WIDEST`]: some 40 · 2⁻⁵³ of the pair's size, more beside needles.
pub(crate) const AS_F64: f64 = f64::INFINITY;

/// The widest bound of a formula in f64 that is taken, relative to the pair's size: of poses that are far from rotations it may be
/// wider than that of a search. Larger: wider bounds. Smaller: more searches.
const WIDEST: f64 = 1e-6;

/// Whether a bound is no wider.
fn is_narrow(
    error_bound: f64,
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> bool {
    let apart = a.pose.translation().distance(b.pose.translation());
    // False for NaN.
    error_bound <= WIDEST * (a.map.reach() + b.map.reach() + apart)
}

/// The bound, relative to itself, that a formula may leave at an accuracy.
pub(crate) fn sharp_of(accuracy: Accuracy) -> f64 {
    match accuracy {
        Accuracy::Certified => SHARP,
        Accuracy::F64 | Accuracy::F32 => AS_F64,
    }
}

/// How far apart a half-space or a sphere and another shape are, or a capsule and a capsule or cuboid at the accuracy of f32,
/// negative where they overlap. `None` of other kinds, of two spheres, where one evaluation in f64 does not say, and at the certified accuracy.
///
/// (a, b) and (b, a) give the same bits, mirrored.
#[inline]
pub(crate) fn gap(accuracy: Accuracy, a: PosedShape<'_>, b: PosedShape<'_>) -> Option<Gap> {
    if let (Shape::HalfSpace(_), _) | (_, Shape::HalfSpace(_)) = (a.shape, b.shape) {
        return level::gap_of(accuracy, a, b);
    }
    match accuracy {
        _ if is_sphere(a) || is_sphere(b) => centred::gap_of(accuracy, a, b),
        Accuracy::F32 => capsules::gap_of(a, b),
        _ => None,
    }
}

/// Whether it is a sphere, wherever its centre is.
#[inline(always)]
pub(crate) fn is_sphere(side: PosedShape<'_>) -> bool {
    matches!(side.shape, Shape::Polytope(polytope) if polytope.kind() == Kind::Point)
}

/// How deep two polytopes that touch overlap, if a formula proves it with a bound of at most `sharp` times
/// the depth.
#[inline]
pub(crate) fn depth(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    sharp: f64,
) -> Option<Depth> {
    match (a.map.kind(), b.map.kind()) {
        (one, other) if !have_formula(one, other) => None,
        (Kind::Cuboid { .. }, Kind::Cuboid { .. }) => None,
        (Kind::Point, Kind::Point) => {
            spheres::depth(a, b, sharp).or_else(|| segments::depth(a, b, sharp))
        }
        _ => segments::depth(a, b, sharp).filter(|found| is_narrow(found.error_bound, a, b)),
    }
}

/// The distance of two polytopes that a formula proves with a bound of at most `sharp` times itself, or that they
/// touch.
#[inline]
pub(crate) fn distance(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    sharp: f64,
) -> Option<DistanceResult> {
    match (a.map.kind(), b.map.kind()) {
        (one, other) if !have_formula(one, other) => None,
        (Kind::Cuboid { .. }, Kind::Cuboid { .. }) => {
            // The certified accuracy is nearly always finer than f64 reaches.
            let found = match sharp {
                AS_F64 => segments::distance_of_cuboids(a, b),
                _ => segments::long_distance_of_cuboids(a, b, sharp),
            };
            if let Some(found) = found {
                return Some(DistanceResult::Apart(found));
            }
            match cuboids::overlap(a, b)? {
                Verdict::Touching(()) => Some(DistanceResult::Touching),
                _ => None,
            }
        }
        (Kind::Point, Kind::Point) => {
            spheres::distance(a, b, sharp).or_else(|| segments::distance(a, b, sharp))
        }
        _ => segments::distance(a, b, sharp).filter(|found| match found {
            DistanceResult::Apart(found) => is_narrow(found.error_bound, a, b),
            _ => true,
        }),
    }
}
