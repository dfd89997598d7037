//! Where two boxes that are apart are nearest: proposed by the axis of the widest gap.
//!
//! A face's axis proposes the corner that is nearest to the face and what of the box is nearest to it, a product of two
//! edges the crossing of their lines. What the points are worth is proved by their difference, as of other closed forms.

use super::cuboid_depth::{Axis, Placed, crossing, posed};
use crate::PosedSupport;
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope};

/// A point of each core, each in its own frame, near one another; `None` for other shapes, boxes out of range, and boxes
/// of which no axis shows a gap.
pub(super) fn points(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<[DVec3; 2]> {
    let (Kind::Cuboid { half_extents: half_a }, Kind::Cuboid { half_extents: half_b }) =
        (a.map.kind(), b.map.kind())
    else {
        return None;
    };
    let (search, [placed_a, placed_b]) = posed([a, b], [half_a, half_b])?;
    let (axis, overlap) = search.widest();
    if overlap >= 0.0 {
        return None;
    }
    let towards_b = |axis: DVec3| if axis.dot(placed_b.centre) < 0.0 { -axis } else { axis };
    let start = match axis {
        Axis::OfA(k) => placed_b.farthest(-towards_b(placed_a.axes[k])),
        Axis::OfB(k) => {
            let corner = placed_a.farthest(towards_b(placed_b.axes[k]));
            placed_b.in_world(placed_b.nearest(corner))
        }
        Axis::Product(j, k) => {
            let normal = towards_b(placed_a.axes[j].cross(placed_b.axes[k]));
            let [in_a, in_b] = crossing([&placed_a, &placed_b], [j, k], normal, f64::INFINITY)?;
            return Some([placed_a.nearest(in_a), placed_b.nearest(in_b)]);
        }
    };
    // Level faces and edges: from either to the nearest of the other.
    let in_b = placed_b.nearest(placed_a.in_world(placed_a.nearest(start)));
    Some([placed_a.nearest(placed_b.in_world(in_b)), in_b])
}

impl Placed {
    /// The point of the box nearest to another, in the box's frame.
    fn nearest(&self, point: DVec3) -> DVec3 {
        let from_centre = point - self.centre;
        let along = |k: usize| self.axes[k].dot(from_centre);
        DVec3::new(along(0), along(1), along(2)).clamp(-self.half, self.half)
    }

    fn in_world(&self, point: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        self.centre + (x * point.x + y * point.y + z * point.z)
    }
}
