//! A ray and a half-space, in the world: a plane's two products with their bounds.

use super::{Ray, RayHit};
use crate::query::local::UNDERFLOW;
use dcd_geom::glam::DVec3;
use dcd_geom::{HalfSpace, Pose};

/// What the transformed normal and a product with it lose, relative to the sizes that go in: an inverse (32), a
/// product of a matrix and one of vectors (16), doubled.
const ROUNDING: f64 = 96.0 * crate::UNIT;

pub(super) fn hit(ray: &Ray, half_space: &HalfSpace, pose: &Pose) -> Option<RayHit> {
    // The plane n·R⁻¹(x − t) ≤ d is that of R⁻ᵀn; grown by the radius along its length.
    let world = pose.rotation().inverse().transpose() * half_space.unit_normal();
    let from = ray.origin() - pose.translation();
    let grown = half_space.unit_offset() + half_space.swept_radius() * world.length();
    let height = world.dot(from) - grown;
    let sizes = from.length() + half_space.unit_offset().abs() + half_space.swept_radius();
    let off = ROUNDING * sizes + UNDERFLOW;
    let rise = world.dot(ray.direction());
    let tilt = ROUNDING * ray.direction().length();
    let fall = |lost: f64| -(rise + lost);
    // The earliest: least height over the fastest fall. The latest: the other way round.
    let t_lower = if height - off <= 0.0 {
        0.0
    } else if fall(-tilt) <= 0.0 {
        return None;
    } else {
        (height - off) / fall(-tilt) * (1.0 - 4.0 * f64::EPSILON)
    };
    if t_lower > ray.max_t() {
        return None;
    }
    let latest = if height + off <= 0.0 {
        Some(0.0)
    } else if fall(tilt) <= 0.0 {
        None
    } else {
        Some((height + off) / fall(tilt) * (1.0 + 4.0 * f64::EPSILON))
    };
    let met = latest.filter(|&t| t <= ray.max_t());
    let t_upper = met.unwrap_or(ray.max_t()).max(t_lower);
    let is_inside = height <= 0.0 && t_lower == 0.0;
    let t = match met {
        _ if is_inside => 0.0,
        Some(_) => 0.5 * (t_lower + t_upper),
        None => t_lower,
    };
    let normal = if is_inside { DVec3::ZERO } else { world.normalize_or_zero() };
    let is_certain = met.is_some();
    Some(RayHit { t, t_lower, t_upper, is_certain, normal, facet: None, part: None })
}
