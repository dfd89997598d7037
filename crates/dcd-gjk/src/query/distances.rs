//! How far apart the pairs within a margin are.

use super::check_margin;
use crate::distance::{Distance, DistanceResult, distance};
use crate::{PairSolver, Placed, Rung, Verdict, certified};
use dcd_geom::{Aabb, Ball, ShapeError};

/// How far apart pairs are, and between which points, for those within a margin: "touching" is
/// "within the margin".
///
/// Told of each is its [`Distance`]; `None` for a pair that shares a point, whose distance is 0. A
/// distance of 0 with a bound is that of a pair of which f64 cannot tell whether it touches, and that
/// is surely within the margin.
/// Between polytopes, rounded or not, nothing is undecided, and the distance is right in twelve
/// digits; with another shape see [`crate::distance::in_f64`]. Costs a few microseconds a pair
/// within the margin, and for most others a comparison of two balls.
#[derive(Clone, Copy, Debug)]
pub struct Distances {
    margin: f64,
}

impl Distances {
    /// Of the pairs within that many metres.
    ///
    /// # Errors
    /// A margin that is negative, not a number, or above [`Aabb::LIMIT`].
    pub fn within(margin: f64) -> Result<Self, ShapeError> {
        check_margin(margin)?;
        Ok(Self { margin })
    }
}

impl PairSolver for Distances {
    type Answer = Option<Distance>;
    type Scratch = ();

    fn rung(&self) -> Rung {
        Rung::F64
    }

    fn margin(&self) -> f64 {
        self.margin
    }

    fn solve(&self, a: Placed<'_>, b: Placed<'_>, scratch: &mut ()) -> Verdict<Self::Answer> {
        self.settle(a, b, scratch).0
    }

    fn measure(&self, a: Placed<'_>, b: Placed<'_>, (): &mut ()) -> Verdict<Self::Answer> {
        match distance(a, b).0 {
            DistanceResult::Apart(found) => Verdict::Touching(Some(found)),
            DistanceResult::Touching => Verdict::Touching(None),
            // What touches has no distance, whatever f64 knows of it.
            DistanceResult::Interval { .. } if self.margin == 0.0 => Verdict::Touching(None),
            DistanceResult::Interval { within, .. } => Verdict::Touching(Some(within)),
            DistanceResult::Undecided(reason) => Verdict::Undecided(reason),
        }
    }

    fn settle(&self, a: Placed<'_>, b: Placed<'_>, (): &mut ()) -> (Verdict<Self::Answer>, Rung) {
        if balls_are_apart(a, b, self.margin) {
            return (Verdict::Apart, Rung::F64);
        }
        let (found, rung) = distance(a, b);
        let verdict = match found {
            DistanceResult::Touching => Verdict::Touching(None),
            DistanceResult::Undecided(reason) => Verdict::Undecided(reason),
            DistanceResult::Apart(found) if found.lower() > self.margin => Verdict::Apart,
            DistanceResult::Apart(found) if found.upper() <= self.margin => {
                Verdict::Touching(Some(found))
            }
            DistanceResult::Interval { within, .. } if within.upper() <= self.margin => {
                Verdict::Touching(Some(within))
            }
            DistanceResult::Apart(found) | DistanceResult::Interval { within: found, .. } => {
                match are_within(a, b, self.margin) {
                    Verdict::Touching(()) => Verdict::Touching(Some(found)),
                    Verdict::Apart => Verdict::Apart,
                    Verdict::Undecided(reason) => Verdict::Undecided(reason),
                }
            }
        };
        (verdict, rung)
    }
}

/// Whether two shapes are within a margin where their distance's bounds leave it open: the word of
/// the same shapes, each grown by half.
pub(super) fn are_within(a: Placed<'_>, b: Placed<'_>, margin: f64) -> Verdict<()> {
    match (a.shape.swept(margin / 2.0), b.shape.swept(margin / 2.0)) {
        (Ok(in_a), Ok(in_b)) => {
            let (a, b) = (Placed { shape: &in_a, ..a }, Placed { shape: &in_b, ..b });
            certified::overlap_of(a, b).0
        }
        // A radius that overflows reaches everywhere.
        _ => Verdict::Touching(()),
    }
}

/// Whether balls round two shapes prove that they are farther apart than `margin`.
///
/// The centres and their difference lose at most 8u of everything that is added up, the radii's
/// sum 4u; 16u and 8u leave room. NaN and overflow prove nothing.
pub(super) fn balls_are_apart(a: Placed<'_>, b: Placed<'_>, margin: f64) -> bool {
    const U: f64 = f64::EPSILON / 2.0;
    let (ball_a, ball_b) = (ball(a), ball(b));
    let size = |side: Placed<'_>, ball: Ball| {
        side.pose.translation().abs().element_sum() + ball.centre.abs().element_sum() * 1.1
    };
    let centres = a.pose.apply(ball_a.centre).distance(b.pose.apply(ball_b.centre));
    let radii = ball_a.radius + ball_b.radius + margin;
    let slack = 16.0 * U * (size(a, ball_a) + size(b, ball_b)) + 8.0 * U * (radii + centres);
    centres - radii > slack && centres <= Aabb::LIMIT * 4.0
}

/// A ball in the shape's own frame whose image holds the placed shape.
fn ball(side: Placed<'_>) -> Ball {
    let stretch = 1.0 + side.pose.deviation();
    match side.shape.as_polytope() {
        Some(polytope) => Ball {
            centre: polytope.inner().centre,
            radius: polytope.outer_radius() * stretch + polytope.swept_radius(),
        },
        None => Ball { centre: dcd_geom::glam::DVec3::ZERO, radius: side.shape.reach() * stretch },
    }
}
