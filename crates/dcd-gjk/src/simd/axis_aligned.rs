//! Cuboids that stand along the world's axes: bricks, crates, shelves, voxels. What spheres leave open of
//! them is resolved exactly, without a general search.

use super::frame::{AXIS_ALIGNED, FramePair};
use crate::Method;
use crate::exact::boxes::{Halves, aligned, along, axes_of};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Pair, Pose, Shape};

/// The sum of all lengths of a pair must be below this for the closed form, metres: no sum overflows.
const LARGEST: f64 = 1e300;

/// Half the edges of a cuboid along the world's axes, exactly, metres. Its centre is its record's:
/// exactly the translation, for a cuboid is round the origin of its frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AxisAligned {
    half: DVec3,
}

impl AxisAligned {
    /// Of a shape at a pose, if it is a cuboid of radius 0 that stands so.
    #[inline]
    pub(super) fn of(shape: &Shape, pose: &Pose) -> Option<Self> {
        // Most rotations have no such axes, and need no look at the shape.
        let axes = axes_of(pose.rotation())?;
        let polytope = shape.as_polytope().filter(|polytope| polytope.swept_radius() == 0.0)?;
        let Kind::Cuboid { half_extents } = polytope.kind() else { return None };
        Some(Self { half: along(axes, half_extents) })
    }
}

/// Whether both objects are marked as upright.
#[inline(always)]
pub(super) fn are_upright(frames: FramePair<'_>, pair: Pair) -> bool {
    frames.a.record(pair.i).marks & frames.b.record(pair.j).marks & AXIS_ALIGNED != 0
}

/// Whether two objects touch, by the exact closed form, and which method that was; `None` unless both
/// are marked as upright.
#[inline]
pub(super) fn touch(frames: FramePair<'_>, pair: Pair) -> Option<(bool, Method)> {
    if !are_upright(frames, pair) {
        return None;
    }
    let records = [frames.a.record(pair.i), frames.b.record(pair.j)];
    let half = Halves { a: frames.a.upright(pair.i).half, b: frames.b.upright(pair.j).half };
    let centres = records.map(|record| {
        let [x, y, z, _] = record.centre;
        DVec3::new(x, y, z)
    });
    let size = half.a + half.b + centres[0].abs() + centres[1].abs();
    // False for an infinite sum.
    (size.element_sum() < LARGEST).then(|| aligned(centres, half))
}
