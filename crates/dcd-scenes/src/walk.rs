//! Frames that barely differ: every object takes a small random step.

use crate::SpecError;
use crate::random::Draw;
use dcd_geom::{Pose, Scene, SceneError};
use glam::{DMat3, DQuat, DVec3};

/// Streams from here on are walks; below they are a seeded scene's objects.
const WALK_STREAMS: u64 = 1 << 62;

/// A walk of all objects of a scene: in each frame each translation changes by a normal deviate
/// of `sigma` metres along each axis, each rotation by one of `sigma` rad about each axis.
#[derive(Clone, Debug)]
pub struct RandomWalk {
    draw: Draw,
    sigma: f64,
}

impl RandomWalk {
    /// A walk with steps of this standard deviation, metres and rad.
    ///
    /// # Errors
    /// A deviation that is not positive and finite.
    pub fn new(sigma: f64, seed: u64) -> Result<Self, SpecError> {
        // Written so that NaN is refused.
        if sigma > 0.0 && sigma.is_finite() {
            Ok(Self { draw: Draw::new(seed, WALK_STREAMS), sigma })
        } else {
            Err(SpecError::Parameter { what: "sigma", value: sigma })
        }
    }

    /// Moves every object of the scene by a step.
    ///
    /// # Errors
    /// An object leaves the range of a scene; those before it have moved then.
    pub fn step(&mut self, scene: &mut Scene) -> Result<(), SceneError> {
        for object in 0..scene.len() {
            let pose = scene.poses()[object];
            let shift = self.deviates();
            let turn = self.deviates();
            // No matrix but a rotation comes of this, up to rounding.
            if let Ok(moved) = moved(&pose, shift, turn) {
                scene.set_pose(object, moved)?;
            }
        }
        Ok(())
    }

    /// Three normal deviates (Box and Muller 1958), of which a fourth is left.
    fn deviates(&mut self) -> DVec3 {
        let mut pair = || {
            // In (0, 1]: the logarithm is finite.
            let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.draw.between(0.0, 1.0)));
            let (sin, cos) = libm::sincos(self.draw.between(0.0, std::f64::consts::TAU));
            [radius * cos, radius * sin]
        };
        let ([x, y], [z, _]) = (pair(), pair());
        DVec3::new(x, y, z) * self.sigma
    }
}

/// The rotation is made anew from a quaternion, so that a thousand steps keep it one.
fn moved(pose: &Pose, shift: DVec3, turn: DVec3) -> Result<Pose, dcd_geom::PoseError> {
    let angle = turn.length();
    let (sin, cos) = libm::sincos(0.5 * angle);
    let axis = turn.normalize_or_zero() * sin;
    let step = DQuat::from_xyzw(axis.x, axis.y, axis.z, cos);
    let rotation: &DMat3 = pose.rotation();
    let turned = step * DQuat::from_mat3(rotation);
    Pose::new(turned.normalize(), pose.translation() + shift)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SceneSpec;

    #[test]
    fn a_step_has_the_requested_deviation_and_the_same_seed_takes_the_same() {
        let before = SceneSpec::bricks(1.0).with_objects(4_000).scene().unwrap();
        let (mut scene, mut again) = (before.clone(), before.clone());
        RandomWalk::new(0.01, 5).unwrap().step(&mut scene).unwrap();
        RandomWalk::new(0.01, 5).unwrap().step(&mut again).unwrap();
        assert_eq!(scene.poses(), again.poses());
        let moves = scene.poses().iter().zip(before.poses());
        let shifts: Vec<DVec3> = moves.map(|(a, b)| a.translation() - b.translation()).collect();
        let variance = shifts.iter().map(|s| s.length_squared()).sum::<f64>() / (3.0 * 4_000.0);
        assert!((variance.sqrt() - 0.01).abs() < 3e-4, "{variance}");
        let turned = scene.poses().iter().map(|pose| DQuat::from_mat3(pose.rotation()));
        let squared = turned.map(|q| (2.0 * q.w.abs().min(1.0).acos()).powi(2)).sum::<f64>();
        let deviation = (squared / (3.0 * 4_000.0)).sqrt();
        assert!((deviation - 0.01).abs() < 3e-4, "{deviation}");
    }

    #[test]
    fn a_deviation_that_is_no_length_is_refused_with_its_value() {
        for bad in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            let refused = RandomWalk::new(bad, 1).unwrap_err();
            assert!(matches!(refused, SpecError::Parameter { what: "sigma", .. }), "{refused}");
        }
    }
}
