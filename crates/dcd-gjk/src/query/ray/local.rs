//! A ray in a shape's own frame, and what that costs.

use super::{Ray, RayHit};
use crate::PosedShape;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_simd::RaySlabs;

/// What bringing a ray into a frame and a closed form on it lose, as a length: two differences and products of a
/// matrix (16), an inverse where there is one (32), the closed forms (at most 24 of the sizes that go into them),
/// doubled. Unit: 2⁻⁵³ of the distance and the shape's size. Larger: wider brackets. Smaller: false answers.
const ROUNDING: f64 = 144.0 * (f64::EPSILON / 2.0);

/// Up to which deviation a rotation's inverse is its transpose; the deviation is then part of the margin.
const ORTHONORMAL: f64 = 1e-12;

/// What a time is nudged by for its own last roundings, relative.
const NUDGE: f64 = 8.0 * f64::EPSILON;

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
        let rotation = *posed.pose.rotation();
        let deviation = posed.pose.deviation();
        let (inverse, off) = if deviation <= ORTHONORMAL {
            (rotation.transpose(), 2.0 * deviation)
        } else {
            (rotation.inverse(), 0.0)
        };
        let from = ray.origin - posed.pose.translation();
        let (origin, direction) = (inverse * from, inverse * ray.direction);
        // Lengths of which a shape stretched by its pose is at most 1e-6 longer.
        let sizes = 2.0 * (from.length() + reach);
        Self { origin, direction, margin: (ROUNDING + off) * sizes + f64::MIN_POSITIVE, rotation }
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
        let t = if is_inside { t_lower } else { t };
        Some(RayHit { t, t_lower, t_upper, is_certain, normal, facet, part: None })
    }

    /// A direction in the world, of unit length.
    pub(super) fn in_world(&self, normal: DVec3) -> DVec3 {
        (self.rotation * normal).normalize_or_zero()
    }
}
