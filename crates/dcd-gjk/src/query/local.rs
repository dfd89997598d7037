//! A point of the world in a shape's own frame, and what that costs.

use dcd_geom::Pose;
use dcd_geom::glam::{DMat3, DVec3};

/// What bringing a point or a ray into a frame and a closed form on it lose, as a length: two differences and products
/// of a matrix (16), an inverse where there is one (32), the closed forms (at most 24 of the sizes that go into them),
/// doubled. Unit: 2⁻⁵³ of the distance and the shape's size. Larger: wider brackets. Smaller: false answers.
const ROUNDING: f64 = 144.0 * crate::UNIT;

/// What lengths lose whose squares underflow, and the roots of what closed forms subtract from each other along directions of
/// 1e-50 and more: metres. Larger: tiny shapes of which nothing is known. Smaller: false answers about them.
pub(super) const UNDERFLOW: f64 = 1e-110;

/// Up to which deviation a rotation's inverse is its transpose; the deviation is then part of the margin.
pub(super) const ORTHONORMAL: f64 = 1e-12;

/// A point in a shape's own frame.
pub(super) struct LocalPoint {
    /// From world to local directions.
    pub(super) inverse: DMat3,
    pub(super) point: DVec3,
    /// Within which distance of it the true one is, with what closed forms of a shape that reaches so far lose; metres.
    pub(super) margin: f64,
}

impl LocalPoint {
    /// In the frame of a shape that reaches so far from its origin, metres.
    pub(super) fn of(point: DVec3, pose: &Pose, reach: f64) -> Self {
        let rotation = pose.rotation();
        let deviation = pose.deviation();
        let (inverse, off) = if deviation <= ORTHONORMAL {
            (rotation.transpose(), 2.0 * deviation)
        } else {
            (rotation.inverse(), 0.0)
        };
        let from = point - pose.translation();
        // Lengths of which a shape stretched by its pose is at most 1e-6 longer.
        let sizes = 2.0 * (from.length() + reach);
        let margin = (ROUNDING + off) * sizes + UNDERFLOW;
        Self { inverse, point: inverse * from, margin }
    }
}
