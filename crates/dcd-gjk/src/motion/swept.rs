//! Where a moving shape may be: boxes round all of its way.

use super::{MovingShape, UNIT, radius, speed};
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Shape, SupportMap};

/// What the corners of such a box lose. Unit: u, of the lengths that go into it.
const ROUNDING: f64 = 128.0;

impl MovingShape<'_> {
    /// A box that moves with the centre and holds the shape whenever, by its corners at t = 0: the shape's own where
    /// it does not turn, else that and what a turn adds until then, no more than the sphere about the centre.
    /// `None` of a half-space.
    pub fn carried_box(&self, until: f64) -> Option<[DVec3; 2]> {
        if let Shape::HalfSpace(_) = self.shape {
            return None;
        }
        let motion = self.motion;
        let aabb = self.shape.aabb(&motion.start);
        // Of the core, and with what is swept round it.
        let radius = radius(self);
        let whole = (radius + SupportMap::<f64>::radius(self.shape)).next_up();
        let centre = motion.start.apply(motion.centre);
        let way = (motion.linear.abs() * until).max_element();
        // Finite, for a centre at the origin is off by no part of it: infinite times 0 would be a box that nothing meets.
        let turn = (speed(motion.angular) * until).min(f64::MAX);
        let sizes = motion.start.translation().abs().max_element()
            + whole
            + way
            + centre.abs().max_element();
        let off = ROUNDING * UNIT * (sizes + 2.0 * motion.centre.length() * (1.0 + turn));
        // A chord of the circle that a point goes along; no less than what the angle's own rounding hides.
        let chord = if motion.angular == DVec3::ZERO { 0.0 } else { radius * turn * (1.0 + 1e-12) };
        let (low, high) = (aabb.min.as_dvec3() - chord, aabb.max.as_dvec3() + chord);
        let [low, high] = if motion.angular == DVec3::ZERO {
            [low, high]
        } else {
            [low.max(centre - whole), high.min(centre + whole)]
        };
        Some([low - off, high + off])
    }

    /// A box round all places of the shape from t = 0 to `until`, rounded outward; all of space for a half-space that
    /// moves.
    pub fn swept_aabb(&self, until: f64) -> Aabb {
        let motion = self.motion;
        let Some([low, high]) = self.carried_box(until) else {
            if motion.linear == DVec3::ZERO && motion.angular == DVec3::ZERO {
                return self.shape.aabb(&motion.start);
            }
            return Aabb::outward(DVec3::splat(-Aabb::LIMIT), DVec3::splat(Aabb::LIMIT));
        };
        let way = motion.linear * until;
        let off = way.abs() * (4.0 * UNIT);
        let limit = DVec3::splat(Aabb::LIMIT);
        let low = (low + way.min(DVec3::ZERO) - off).max(-limit);
        Aabb::outward(low, (high + way.max(DVec3::ZERO) + off).min(limit))
    }
}
