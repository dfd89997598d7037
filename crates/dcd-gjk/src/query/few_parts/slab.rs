//! Between which heights a half-space or a triangle is: how far apart from a sphere it is at the least.

use crate::PosedShape;
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Pose, Shape};

/// The largest deviation of the pose of a half-space or triangle whose normal is that of a slab.
pub(super) const TURNED: f64 = 1e-12;

/// Between which heights a half-space or a triangle is along its normal, in world axes.
#[derive(Clone, Copy)]
pub(super) struct Slab {
    /// Of unit length, but for rounding.
    pub(super) outward: DVec3,
    /// How far along that it begins, −∞ for a half-space, and ends.
    pub(super) low: f64,
    pub(super) high: f64,
    /// At least the lengths that this was computed with.
    pub(super) far: f64,
}

impl Slab {
    /// `None` of other shapes, and of a pose that is hardly a rotation.
    pub(super) fn of(side: PosedShape<'_>) -> Option<Self> {
        let (pose, place) = (side.pose, side.pose.translation());
        if !(pose.deviation() <= TURNED) {
            return None;
        }
        match side.shape {
            Shape::HalfSpace(half_space) => {
                let outward = *pose.rotation() * half_space.unit_normal();
                let own = half_space.unit_offset();
                let radius = half_space.swept_radius();
                let far = place.abs().element_sum() + own.abs() + radius;
                let high = outward.dot(place) + own + radius;
                Some(Self { outward, low: f64::NEG_INFINITY, high, far })
            }
            Shape::Polytope(triangle) if triangle.kind() == Kind::Triangle => {
                Self::of_triangle(triangle, pose)
            }
            _ => None,
        }
    }

    /// Any direction of unit length would do: the heights are those of the corners.
    fn of_triangle(triangle: &Polytope, pose: &Pose) -> Option<Self> {
        let &[p, q, r] = triangle.vertices() else { return None };
        let radius = triangle.swept_radius();
        let [p, q, r] = [p, q, r].map(|corner| pose.apply(corner));
        let across = (q - p).cross(r - p);
        // Its length is that of squares, which underflow in a tiny triangle. Of NaN and of a needle there is none.
        let largest = across.abs().max_element();
        let outward =
            (largest > 0.0).then(|| across / largest).filter(|n| n.is_finite())?.normalize();
        let [of_p, of_q, of_r] = [p, q, r].map(|corner| outward.dot(corner));
        let low = of_p.min(of_q).min(of_r) - radius;
        let high = of_p.max(of_q).max(of_r) + radius;
        let far = pose.translation().abs().element_sum() + 2.0 * triangle.reach() + radius;
        Some(Self { outward, low, high, far })
    }
}
