//! What a point of each of two cylinders or cones proves of their distance.
//!
//! From above they are no farther apart than the points, from below no nearer than both reach along the line between these
//! (docs/numerics/proofs.md, "Round shapes").

use super::feature_normal::ASIDE;
use super::{LENGTH, SIZES, UNIT};
use crate::distance::{Distance, DistanceResult, rounded_up};
use crate::mesh::Limited;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Curved, Pose, Vector};

/// How far apart the cores may be beyond the computed length between two points of them, each within 9u of its reach. Unit: u·m.
/// Derived: 15.3. Smaller: distances outside their bounds.
const ABOVE: f64 = 17.0;

/// How much nearer than a computed separation they may be. Unit: u·m. Derived: 10.3. Smaller: as above.
const BELOW: f64 = 12.0;

/// How near the bounds have to come where all that f64 has is asked for. Unit: u·m. Larger: worse bounds. Smaller: searches in
/// place of points that are the nearest but for rounding.
const CLOSE: f64 = 256.0;

/// Two placed shapes, metres.
pub(super) struct CurvedPoints<'a> {
    curved: [&'a Curved; 2],
    poses: [&'a Pose; 2],
    /// From the second's origin to the first's.
    delta: DVec3,
    /// The pair's size: at least the length of every vector from the one core to the other.
    size: f64,
    /// The radii swept round both.
    radius: f64,
}

/// Two points, world axes, each from its own shape's origin.
pub(super) struct Points {
    on_a: DVec3,
    on_b: DVec3,
    length: f64,
    /// From the second to the first, or square to both features, of unit length but for rounding.
    direction: DVec3,
    /// How far the points are beside each other, seen along the direction.
    aside: f64,
    /// At most the cores' distance.
    lower: f64,
}

impl<'a> CurvedPoints<'a> {
    /// `None` where products of lengths might leave the range.
    pub(super) fn of(curved: [&'a Curved; 2], poses: [&'a Pose; 2]) -> Option<Self> {
        let delta = poses[0].translation() - poses[1].translation();
        let reach = |k: usize| {
            (curved[k].half_height() + curved[k].radius()) * (1.0 + poses[k].deviation())
        };
        let size = (reach(0) + reach(1) + delta.norm1()) * (1.0 + 8.0 * UNIT);
        let radius = curved[0].swept_radius() + curved[1].swept_radius();
        SIZES.contains(&size).then_some(Self { curved, poses, delta, size, radius })
    }

    /// At least the sum of the radii.
    fn swept(&self) -> f64 {
        self.radius * (1.0 + LENGTH * UNIT)
    }

    /// A point of each, in its own frame, and what the line between them proves.
    pub(super) fn between(&self, on_a: DVec3, on_b: DVec3) -> Points {
        let [turn_a, turn_b] = self.poses.map(Pose::rotation);
        let (on_a, on_b) = (*turn_a * on_a, *turn_b * on_b);
        let between = (on_a - on_b) + self.delta;
        let length = between.length();
        let direction = between * (1.0 / length);
        Points { on_a, on_b, length, direction, aside: 0.0, lower: self.lower(direction) }
    }

    /// The same by another direction, world axes.
    pub(super) fn along(&self, direction: DVec3, points: &Points) -> Points {
        // A pose that is no rotation has stretched it.
        let direction = direction * (1.0 / direction.length());
        let between = (points.on_a - points.on_b) + self.delta;
        let aside = (between - direction * direction.dot(between)).length();
        Points { direction, aside, lower: self.lower(direction), ..*points }
    }

    /// The pair's size.
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// At most the cores' distance, by a direction of unit length but for rounding.
    fn lower(&self, direction: DVec3) -> f64 {
        let [turn_a, turn_b] = self.poses.map(Pose::rotation);
        let [in_a, in_b] = [
            -reach(self.curved[0], -back(turn_a, direction)),
            reach(self.curved[1], back(turn_b, direction)),
        ];
        let separation = direction.dot(self.delta) + (in_a - in_b);
        separation - separation.abs() * (LENGTH * UNIT) - BELOW * UNIT * self.size
    }
}

/// How far the core reaches along a direction of its frame.
#[inline(always)]
fn reach(curved: &Curved, direction: DVec3) -> f64 {
    let across = direction.truncate().length();
    let [low, high] = curved.discs().map(|(z, radius)| direction.z * z + across * radius);
    low.max(high)
}

/// Rᵀd.
#[inline(always)]
fn back(turn: &DMat3, d: DVec3) -> DVec3 {
    DVec3::new(turn.x_axis.dot(d), turn.y_axis.dot(d), turn.z_axis.dot(d))
}

impl Points {
    /// Whether the shapes are proved to be farther apart than that, metres. False for NaN.
    pub(super) fn are_beyond(&self, pair: &CurvedPoints<'_>, far: f64) -> bool {
        (self.lower - pair.swept()).next_down() > far
    }

    /// The distance, if the bounds are at most `gap` of the size apart, or as near as f64 brings them; no more of what is
    /// beyond a limit. `None` where they are farther apart, or leave it open whether the shapes touch.
    pub(super) fn distance(
        &self,
        pair: &CurvedPoints<'_>,
        [gap, far]: [f64; 2],
    ) -> Option<Limited> {
        if self.are_beyond(pair, far) {
            return Some(Limited::Beyond);
        }
        let Self { length, lower, .. } = *self;
        let CurvedPoints { curved: [in_a, in_b], poses: [pose_a, pose_b], size, radius, .. } =
            *pair;
        let upper = length * (1.0 + LENGTH * UNIT) + ABOVE * UNIT * size;
        debug_assert!(!(upper < lower), "points that are not of the cores");
        // Written so that NaN is refused.
        if !(upper - lower <= gap.max(CLOSE * UNIT) * size && lower > pair.swept()) {
            return None;
        }
        let distance = length - radius;
        let above = upper - radius * (1.0 - LENGTH * UNIT) - distance;
        let below = distance - (lower - pair.swept());
        // This function's own arithmetic.
        let error_bound = rounded_up(above.max(below) + 8.0 * UNIT * length);
        // Along the normal points beside each other are not as far apart as they are, nor is what is swept round them.
        if self.aside > ASIDE * UNIT * size {
            return None;
        }
        let normal = -self.direction;
        let point_a = self.on_a + pose_a.translation() + normal * in_a.swept_radius();
        let point_b = self.on_b + pose_b.translation() - normal * in_b.swept_radius();
        let found = Distance { distance, point_a, point_b, normal, error_bound };
        Some(Limited::Known(DistanceResult::Apart(found)))
    }
}
