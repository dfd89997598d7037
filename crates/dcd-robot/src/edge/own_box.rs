//! Boxes round shapes in their own frames: long shapes, which spheres hold badly.

use dcd_geom::{Aabb, Pose, Shape, Vector};
use glam::DVec3;

/// The box, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct OwnBox {
    middle: DVec3,
    half: DVec3,
}

/// What the frames' coordinates lose in f64, relative to them, with much room.
const ROUNDING: f64 = 1e-12;

impl OwnBox {
    /// Infinite for what has no end.
    pub(super) fn of(shape: &Shape) -> Self {
        let Aabb { min, max } = shape.aabb(&Pose::IDENTITY);
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        Self { middle: 0.5 * min + 0.5 * max, half: 0.5 * max - 0.5 * min }
    }

    /// At most the distance of a point from the box at a pose: 0 inside.
    pub(super) fn far(&self, pose: &Pose, point: DVec3) -> f64 {
        let from = point - pose.translation();
        let local = pose.rotation().transpose() * from - self.middle;
        let outside = (local.abs() - self.half).max(DVec3::ZERO).length();
        // A rotation that is none turns the box into something near it.
        let lengths = from.norm1() + point.norm1() + pose.translation().norm1();
        outside - (ROUNDING + 4.0 * pose.deviation()) * (lengths + self.half.norm1())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn a_point_is_no_nearer_than_the_box_says() {
        let plate = Shape::cuboid(DVec3::new(1.0, 2.0, 0.01)).unwrap();
        let turn = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        let pose = Pose::new(turn, DVec3::new(0.0, 5.0, 0.0)).unwrap();
        // Its thin side is along the world's y.
        let own = OwnBox::of(&plate);
        let far = own.far(&pose, DVec3::new(0.0, 4.0, 1.5));
        assert!(far <= 0.99 && far > 0.989, "{far}");
        assert!(own.far(&pose, DVec3::new(0.5, 5.0, -1.9)) <= 0.0);
        let ground = Shape::half_space(DVec3::Z, 0.0).unwrap();
        assert!(!(OwnBox::of(&ground).far(&Pose::IDENTITY, DVec3::Z * 9.0) > 0.0));
    }
}
