//! The plane of a half-space in the frame of a compound, where its parts have their poses: what all parts share is computed
//! once.

use super::{DEVIATION, Gap, Lowest};
use crate::PosedShape;
use crate::closed::{SIZES, UNIT, centred};
use crate::query::Accuracy;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Pose, Shape, Vector};

/// What the height of a part over a plane that is seen in a compound's frame may be off. Unit: u·m. Derived: 48, what a
/// height loses, the normal once more turned, and three sums.
const LOST_IN_FRAME: f64 = 64.0;

/// The plane of a half-space in the frame of a compound, where the parts have their poses.
pub(crate) struct PlaneInFrame {
    /// Of unit length, but for what the frame's pose is off a rotation by: in the frame, and in the world.
    outward: DVec3,
    in_world: DVec3,
    /// How high the frame's origin is above it: metres.
    height: f64,
    /// At least the lengths that this was computed with.
    far: f64,
    /// What a height may be off by, relative to the lengths.
    lost: f64,
    /// At least how much longer a vector is in the world than in the frame.
    stretch: f64,
}

impl PlaneInFrame {
    /// `None` of other shapes than half-spaces, and of poses that are hardly rotations.
    pub(crate) fn of(accuracy: Accuracy, plane: PosedShape<'_>, frame: &Pose) -> Option<Self> {
        let Shape::HalfSpace(half_space) = plane.shape else { return None };
        let most = centred::largest_deviation(accuracy)?;
        if !(plane.pose.deviation() <= most && frame.deviation() <= most) {
            return None;
        }
        let in_world = *plane.pose.rotation() * half_space.unit_normal();
        let offset = half_space.unit_offset();
        let delta = frame.translation() - plane.pose.translation();
        let DMat3 { x_axis, y_axis, z_axis } = frame.rotation();
        let outward = DVec3::new(x_axis.dot(in_world), y_axis.dot(in_world), z_axis.dot(in_world));
        let radius = half_space.swept_radius();
        Some(Self {
            outward,
            in_world,
            height: in_world.dot(delta) - offset - radius,
            far: delta.norm1() + offset.abs() + radius,
            lost: LOST_IN_FRAME * UNIT + DEVIATION * plane.pose.deviation(),
            stretch: 1.0 + frame.deviation(),
        })
    }

    /// Into the half-space: in the frame, and in the world.
    pub(crate) fn inward(&self) -> [DVec3; 2] {
        [-self.outward, -self.in_world]
    }

    /// From a part at its pose in the frame to the plane, in the frame: how far the lowest point is above it, and which
    /// vertex of a polytope that is no cuboid that is. The part may be elsewhere by `moved`, metres. `None` of other kinds.
    #[inline(always)]
    pub(crate) fn gap_of(&self, part: PosedShape<'_>, moved: f64) -> Option<(Gap, Option<u32>)> {
        let outward = self.outward;
        let DMat3 { x_axis, y_axis, z_axis } = part.pose.rotation();
        let along = DVec3::new(x_axis.dot(outward), y_axis.dot(outward), z_axis.dot(outward));
        let Lowest { point, height, vertex, reach, swept } = Lowest::of(part.shape, along)?;
        let place = part.pose.translation();
        let value = (height + outward.dot(place)) + self.height - swept;
        let own = reach * (1.0 + part.pose.deviation()) + place.norm1();
        let size = own * self.stretch + self.far + swept;
        // False for NaN.
        if !SIZES.contains(&size) {
            return None;
        }
        let error = self.lost * size + moved * self.stretch;
        let lowest = part.pose.apply(point) - outward * swept;
        let on_plane = lowest - outward * value;
        Some((Gap::new((value, error), outward, [on_plane, lowest], true), vertex))
    }
}

#[cfg(test)]
mod tests;
