//! Whether the direction of least depth has a rival: there the depth has no derivative.

use super::Direction;
use super::apart::Gap;
use super::hull::Hull;
use super::lattice::{Normal, POINT_BITS, length, rounded, scaled, two_to};
use super::search::{Bounds, GROWTHS, Viewer};
use dcd_geom::Vector;
use dcd_geom::glam::DVec3;

/// How much deeper a direction must be not to be a rival, relative to the depth of the shapes with
/// their radii: the depth that a caller gets, however little of it is the cores'. A billionth,
/// as promised for the depth itself. Larger: smooth points taken for kinks. Smaller: "smooth" where
/// the direction is an accident of rounding.
const NEAR: f64 = 1e-9;

/// The same for depths near 0, units: a millionth of a millionth of the pair's size.
const NEAR_ZERO: f64 = 1e-12;

/// Below which angle, in radians, two directions are one: the rounding of their lengths.
const ONE: f64 = 1e-12;

impl Viewer<'_> {
    /// Of cores that overlap, with that sum of radii, metres. The hull must be as the search left it,
    /// and its queue is used up.
    pub(super) fn direction(&mut self, hull: &mut Hull, best: &Bounds, radius: f64) -> Direction {
        if self.difference.is_flat() {
            // Both sides of a flat difference are equally near.
            return Direction::Rivalled;
        }
        let depth = best.upper.max(0.0);
        let near = depth + self.margin(depth + self.in_units(radius));
        self.alone(hull, &best.normal, near)
    }

    /// Of cores that are apart, with that sum of radii, metres.
    ///
    /// With a gap g the reach along the returned direction is −g, and a rival's at most −g + ε. Where g
    /// exceeds ε those are the directions of a negative reach below some bound: a convex cone round the
    /// returned one, for the reach is sublinear, in which the nearest point moves on without a kink. Where
    /// it does not, another facet of the difference, or its other side, may be as near. Then the
    /// facets are found as if the cores overlapped.
    pub(super) fn direction_across(
        &mut self,
        hull: &mut Hull,
        gap: &Gap,
        radius: f64,
    ) -> Direction {
        let margin = self.margin((self.in_units(radius) - gap.lower).abs());
        if gap.lower > margin {
            return Direction::Alone;
        }
        // Which side the origin is on is unknown.
        if gap.lower <= self.difference.slack() {
            return Direction::Rivalled;
        }
        self.look_past_separation();
        let grown =
            self.thorough().and_then(|corners| self.expand(corners, hull, GROWTHS).map(|_| ()));
        if grown.is_err() || self.difference.is_flat() {
            return Direction::Rivalled;
        }
        self.alone(hull, &gap.normal, margin - gap.lower)
    }

    /// How much more reach makes a direction no rival, units, for shapes of that depth or distance.
    fn margin(&self, depth: f64) -> f64 {
        depth * NEAR + NEAR_ZERO * two_to(POINT_BITS) + self.difference.slack()
    }

    fn in_units(&self, metres: f64) -> f64 {
        scaled(metres, -self.difference.unit())
    }

    /// Grows the hull on, until the nearest facet that looks another way is known to be beyond `near`
    /// or not.
    fn alone(&mut self, hull: &mut Hull, best: &Normal, near: f64) -> Direction {
        let best = unit(rounded(best));
        for _ in 0..GROWTHS {
            let Some(index) = hull.take_nearest() else { return Direction::Alone };
            let face = hull.face(index);
            if face.distance() > near {
                return Direction::Alone;
            }
            let normal = face.normal;
            if Vector::length(unit(rounded(&normal)) - best) < ONE {
                continue;
            }
            let Ok(support) = self.view(&normal) else { return Direction::Rivalled };
            if support.reach.to_f64() / length(&normal) <= near {
                return Direction::Rivalled;
            }
            hull.insert(support.vertex, index);
        }
        Direction::Rivalled
    }
}

fn unit(n: DVec3) -> DVec3 {
    n / Vector::length(n)
}
