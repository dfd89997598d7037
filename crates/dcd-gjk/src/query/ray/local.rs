//! A ray in a shape's own frame, and what that costs.

use super::{Ray, RayHit};
use crate::PosedShape;
use crate::query::local::LocalPoint;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_simd::RaySlabs;

/// What a time is nudged by for its own last roundings, relative.
const NUDGE: f64 = 8.0 * f64::EPSILON;

/// Whether what begins at `enter` is proved to begin after `limit`. False for NaN.
pub(super) fn is_later(enter: f64, limit: f64) -> bool {
    enter * (1.0 - NUDGE) > limit
}

/// A ray in a shape's own frame, every point of it that may be of the shape within `margin` of the true one.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalRay {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    pub(super) margin: f64,
    rotation: DMat3,
}

/// Where a line is inside of a convex set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    pub(super) enter: f64,
    pub(super) leave: f64,
    /// Of the surface where it enters, outward, in the shape's frame; any length.
    pub(super) normal: DVec3,
    pub(super) facet: Option<u32>,
}

impl Chord {
    /// All of the line.
    pub(super) const LINE: Self =
        Self { enter: f64::NEG_INFINITY, leave: f64::INFINITY, normal: DVec3::ZERO, facet: None };

    /// What both have.
    pub(super) fn and(self, other: Self) -> Option<Self> {
        let later = if other.enter > self.enter { other } else { self };
        let chord = Self { leave: self.leave.min(other.leave), ..later };
        (chord.enter <= chord.leave).then_some(chord)
    }
}

impl LocalRay {
    /// In the frame of a shape that reaches so far from its origin, metres.
    pub(super) fn of(ray: &Ray, posed: &PosedShape<'_>, reach: f64) -> Self {
        let LocalPoint { inverse, point, margin } = LocalPoint::of(ray.origin, posed.pose, reach);
        let (direction, rotation) = (inverse * ray.direction, *posed.pose.rotation());
        Self { origin: point, direction, margin, rotation }
    }

    /// What boxes in this frame are tested with, each grown by so much.
    pub(super) fn slabs(&self, grown: f64) -> RaySlabs {
        RaySlabs::new(self.origin, self.direction, self.margin + grown)
    }

    pub(super) fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// The hit of a shape between a larger and a smaller one, if it may be one.
    pub(super) fn bracket(&self, ray: &Ray, outer: Chord, inner: Option<Chord>) -> Option<RayHit> {
        let t_lower = outer.enter.max(0.0) * (1.0 - NUDGE);
        // Written so that NaN is a hit that nothing is known of.
        if outer.leave < 0.0 || t_lower > ray.max_t {
            return None;
        }
        let end = |t: f64| t.max(0.0) * (1.0 + NUDGE);
        let met = inner.filter(|chord| chord.leave >= 0.0 && end(chord.enter) <= ray.max_t);
        let (t_upper, is_certain) = match met {
            Some(chord) => (end(chord.enter), true),
            None => (end(outer.leave).min(ray.max_t), false),
        };
        let (t_lower, t_upper) = (t_lower.min(t_upper), t_upper.max(t_lower));
        let t = if t_lower == t_upper || !t_upper.is_finite() {
            t_lower
        } else {
            0.5 * (t_lower + t_upper)
        };
        let is_inside = outer.enter <= 0.0 && inner.is_none_or(|chord| chord.enter <= 0.0);
        let normal = if is_inside { DVec3::ZERO } else { self.in_world(outer.normal) };
        let facet = outer.facet.filter(|_| !is_inside);
        // Of what may be met, when it would be at the earliest: nothing later comes before it.
        let t = if is_inside || !is_certain { t_lower } else { t };
        Some(RayHit { t, t_lower, t_upper, is_certain, normal, facet, part: None })
    }

    /// A direction in the world, of unit length.
    pub(super) fn in_world(&self, normal: DVec3) -> DVec3 {
        let turned = self.rotation * normal;
        // Of a tiny triangle the square of its area underflows.
        turned
            .try_normalize()
            .unwrap_or_else(|| (turned / turned.abs().max_element()).normalize_or_zero())
    }
}
