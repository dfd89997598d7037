//! From bounds on the lattice to a depth in the world.

use super::Depth;
use super::apart::Gap;
use super::hull::Hull;
use super::lattice::{LatticeDifference, Normal, length, rounded, scaled};
use super::search::Bounds;
use super::witness::where_ray_leaves;
use crate::UNIT;
use dcd_geom::glam::DVec3;

/// What a quotient of two rounded integers, n·w / |n|, may be off by, relative to itself: 1.01u for
/// the product, as much for each component of n, 3.01u for the length, 1u for the division; and
/// a margin.
const QUOTIENT: f64 = 16.0 * UNIT;

/// What the double-double of [`Gap::left_of`] may lose of each bound, relative to the radii: 11 times 2⁻¹⁰³, and a margin
/// (docs/numerics/proofs.md, "Depth"). Smaller: depths of hardly touching shapes outside their bound.
const LEFT: f64 = 1.0 / (1u128 << 96) as f64;

/// What is known of whether the pair touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Certainty {
    Apart,
    Touching,
    /// The bounds leave it open.
    Unknown,
    /// The depth or its bound overflows.
    OutOfRange,
}

/// A depth of rounded shapes in metres; normal and witnesses of the cores on the lattice.
pub(super) struct Answer {
    depth: f64,
    error: f64,
    certainty: Certainty,
    normal: Normal,
    witnesses: [DVec3; 2],
}

impl Answer {
    /// Cores without a radius that are apart along a direction: no overlap, and the points that are nearest.
    pub(super) fn apart(difference: &LatticeDifference<'_>, normal: Normal, gap: &Gap) -> Self {
        let witnesses = difference.witnesses(gap.corners());
        Self { depth: 0.0, error: 0.0, certainty: Certainty::Apart, normal, witnesses }
    }

    /// Cores that overlap, or touch within rounding: the depth of the cores plus the radii.
    pub(super) fn of_overlap(
        difference: &LatticeDifference<'_>,
        hull: &Hull,
        bounds: Bounds,
        radius: f64,
    ) -> Self {
        let depth = bounds.upper.max(0.0);
        let least = if bounds.enclosed { bounds.lower.max(0.0) } else { 0.0 };
        let error = (depth - least) + difference.slack() + 2.0 * QUOTIENT * depth;
        let certainty = if bounds.enclosed { Certainty::Touching } else { Certainty::Unknown };
        let corners = where_ray_leaves(hull, &bounds.normal);
        Self {
            depth: scaled(depth, difference.unit()) + radius,
            error: scaled(error, difference.unit()),
            certainty,
            normal: bounds.normal,
            witnesses: difference.witnesses(&corners),
        }
    }

    /// Cores that are apart, or touch within rounding: the radii less the distance of the cores.
    /// `overlap` bounds how deep the cores overlap if they do after all, in lattice units.
    pub(super) fn of_gap(
        difference: &LatticeDifference<'_>,
        gap: &Gap,
        overlap: f64,
        radii: [f64; 2],
    ) -> Self {
        let radius = radii[0] + radii[1];
        let unit = difference.unit();
        let slack = difference.slack();
        let rounding = QUOTIENT * gap.upper + slack;
        let near = scaled(gap.lower - rounding, unit);
        let far = scaled(gap.upper + rounding, unit);
        let error = (gap.upper - gap.lower).max(0.0) + 2.0 * rounding + overlap.max(0.0);
        let error = scaled(error, unit) + 4.0 * UNIT * radius;
        let in_units = radii.map(|radius| scaled(radius, -unit));
        let (depth, error) = match gap.left_of(in_units) {
            Some([above, below]) => {
                let rounding = QUOTIENT * (above.abs() + below.abs())
                    + 2.0 * LEFT * (in_units[0] + in_units[1]);
                let sharp = (above - below).max(0.0) + rounding + 2.0 * slack + overlap.max(0.0);
                // Radii of more than a unit are exact in units.
                let is_exact = in_units.iter().all(|&radius| radius == 0.0 || radius >= 1.0);
                let error = if is_exact { error.min(scaled(sharp, unit)) } else { error };
                (scaled(above, unit), error)
            }
            None => (radius - scaled(gap.lower, unit), error),
        };
        // The sum of the radii is rounded once, the products here once more.
        let certainty = if far <= radius * (1.0 - 4.0 * UNIT) {
            Certainty::Touching
        } else if near > radius * (1.0 + 4.0 * UNIT) {
            Certainty::Apart
        } else {
            Certainty::Unknown
        };
        Self {
            depth: depth.max(0.0),
            error,
            certainty,
            normal: gap.normal,
            witnesses: difference.witnesses(gap.corners()),
        }
    }

    /// The depth in the world, rounded, and whether the shapes touch.
    pub(super) fn in_world(self, unit: i32, radii: [f64; 2]) -> (Depth, Certainty) {
        let normal = rounded(&self.normal) / length(&self.normal);
        let [a, b] =
            self.witnesses.map(|w| DVec3::from_array(w.to_array().map(|x| scaled(x, unit))));
        // Scaling may underflow: half the least number each for depth and error.
        let error = self.error + 4.0 * UNIT * self.depth + 2.0 * f64::from_bits(1);
        let in_range = self.depth.is_finite() && error.is_finite();
        let depth = Depth {
            depth: self.depth.min(f64::MAX),
            normal,
            point_a: (a + normal * radii[0]).clamp(DVec3::MIN, DVec3::MAX),
            point_b: (b - normal * radii[1]).clamp(DVec3::MIN, DVec3::MAX),
            error_bound: if in_range { error } else { f64::MAX },
        };
        let certainty = if in_range { self.certainty } else { Certainty::OutOfRange };
        (depth, certainty)
    }
}
