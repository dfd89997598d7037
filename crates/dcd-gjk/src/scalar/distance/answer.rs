//! What is known of the distance of two shapes.

use crate::Reason;
use dcd_geom::glam::DVec3;

/// How far apart two shapes are, and where. World frame, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    /// Positive and finite; 0 only below 5e-324, `f64::MAX` for all that is above it (see
    /// [`Distance::is_saturated`]).
    pub distance: f64,
    /// A point of a nearest to b, to within the rounding of world coordinates; of a swept shape it may be below the surface by up
    /// to `error_bound`. Where a cylinder, cone or ellipsoid nearly touches another shape and a radius is swept round either,
    /// the two points may be farther apart than [`Distance::upper`], by some 1e-7 of the size: radii are added along the normal.
    pub point_a: DVec3,
    /// A point of b nearest to a.
    pub point_b: DVec3,
    /// From a to b, of unit length but for rounding. It has no bound of its own: planes across it may leave less than
    /// [`Distance::lower`] between the shapes, mostly of curved ones that are close; what they leave is
    /// [`gap_along`](super::gap_along) it.
    pub normal: DVec3,
    /// The true distance is within `distance ± error_bound`. Finite; `f64::MAX` marks a distance
    /// that is known from below alone.
    pub error_bound: f64,
}

impl Distance {
    /// Whether the shapes are farther apart than any f64: `distance` is then a lower bound, and
    /// nothing finite is an upper one.
    pub fn is_saturated(&self) -> bool {
        self.error_bound == f64::MAX
    }

    /// At most the true distance: at least 0, finite.
    pub fn lower(&self) -> f64 {
        if self.is_saturated() {
            return self.distance;
        }
        (self.distance - self.error_bound).next_down().max(0.0)
    }

    /// At least the true distance, unless it [is saturated](Self::is_saturated). Finite.
    pub fn upper(&self) -> f64 {
        (self.distance + self.error_bound).next_up().min(f64::MAX)
    }

    /// The same with finite numbers where f64 ends.
    pub(super) fn saturated(self) -> Self {
        let error_bound = if self.distance <= f64::MAX { self.error_bound } else { f64::MAX };
        Self {
            distance: self.distance.min(f64::MAX),
            point_a: self.point_a.clamp(DVec3::MIN, DVec3::MAX),
            point_b: self.point_b.clamp(DVec3::MIN, DVec3::MAX),
            error_bound,
            ..self
        }
    }

    /// The same seen from b.
    pub(crate) fn mirrored(self) -> Self {
        let Self { point_a, point_b, normal, .. } = self;
        Self { point_a: point_b, point_b: point_a, normal: -normal, ..self }
    }
}

/// What is known of the distance of two shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DistanceResult {
    /// No common point, and how far apart.
    Apart(Distance),
    /// At least one common point: the distance is 0.
    Touching,
    /// Whether they touch is not known.
    Interval {
        /// Why.
        reason: Reason,
        /// A distance of 0: the true one is at most its `error_bound`. The points and the normal are
        /// those of the search's end.
        within: Distance,
        /// If they overlap, they are at most so deep. Metres, finite.
        depth: f64,
    },
    /// Nothing is known, and why.
    Undecided(Reason),
}

impl DistanceResult {
    pub(crate) fn mirrored(self) -> Self {
        match self {
            Self::Apart(distance) => Self::Apart(distance.mirrored()),
            Self::Interval { reason, within, depth } => {
                Self::Interval { reason, within: within.mirrored(), depth }
            }
            other => other,
        }
    }
}
