//! Whether the direction of least depth has a rival: there the depth has no derivative.

use super::Direction;
use super::hull::Hull;
use super::lattice::{POINT_BITS, length, rounded, two_to};
use super::search::{Bounds, GROWTHS, Viewer};
use dcd_geom::Vector;
use dcd_geom::glam::DVec3;

/// How much deeper a direction must be not to be a rival, relative to the depth. A billionth, as
/// is promised of the depth itself. Larger: smooth points taken for kinks.
const NEAR: f64 = 1e-9;

/// The same for depths near 0, units: a millionth of a millionth of the pair's size.
const NEAR_ZERO: f64 = 1e-12;

/// Below which angle, in radians, two directions are one: the rounding of their lengths.
const ONE: f64 = 1e-12;

impl Viewer<'_> {
    /// Grows the hull on, until the nearest facet that looks another way is known. The hull must
    /// be as the search left it, and its queue is used up.
    pub(super) fn direction(&mut self, hull: &mut Hull, best: &Bounds) -> Direction {
        if self.difference.is_flat() {
            // Both sides of a flat difference are equally near.
            return Direction::Rivalled;
        }
        let best_normal = unit(rounded(&best.normal));
        let near = best.upper.max(0.0) * (1.0 + NEAR)
            + NEAR_ZERO * two_to(POINT_BITS)
            + self.difference.slack();
        for _ in 0..GROWTHS {
            let Some(index) = hull.take_nearest() else { return Direction::Alone };
            let face = hull.face(index);
            if face.distance() > near {
                return Direction::Alone;
            }
            let normal = face.normal;
            if Vector::length(unit(rounded(&normal)) - best_normal) < ONE {
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
