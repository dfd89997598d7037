//! Numbers from a seed, the same on every machine.

use glam::{DQuat, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::ops::Range;

/// One stream of a seed. Each object of a scene draws from a stream of its own, so that a scene's
/// first objects do not depend on how many follow.
#[derive(Clone, Debug)]
pub(crate) struct Draw(ChaCha8Rng);

impl Draw {
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(stream);
        Self(rng)
    }

    /// Uniform in [low, high): 53 random bits.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.0.next_u64() >> 11) as f64 * (f64::EPSILON / 2.0);
        low + (high - low) * unit
    }

    /// Uniform in the range, up to one part in 2³² of its length.
    pub(crate) fn count(&mut self, range: Range<u32>) -> u32 {
        let length = u64::from(range.end - range.start);
        range.start + ((u64::from(self.0.next_u32()) * length) >> 32) as u32
    }

    /// Uniform in the cube [low, high)³.
    pub(crate) fn point(&mut self, low: f64, high: f64) -> DVec3 {
        let x = self.between(low, high);
        let y = self.between(low, high);
        DVec3::new(x, y, self.between(low, high))
    }

    /// The paper's rotation: roll, pitch and yaw uniform in [-3, 3) rad, turned about x, then y,
    /// then z of the world. Not uniform over all rotations, and of unit length up to rounding.
    pub(crate) fn rotation(&mut self) -> DQuat {
        let mut half_angle = || libm::sincos(0.5 * self.between(-3.0, 3.0));
        let ((sr, cr), (sp, cp), (sy, cy)) = (half_angle(), half_angle(), half_angle());
        DQuat::from_xyzw(
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_in_their_range_and_fill_it() {
        let mut draw = Draw::new(1, 0);
        let numbers: Vec<f64> = (0..10_000).map(|_| draw.between(-3.0, 3.0)).collect();
        assert!(numbers.iter().all(|x| (-3.0..3.0).contains(x)));
        assert!((numbers.iter().sum::<f64>() / 10_000.0).abs() < 0.06);
        let mut seen = [0u32; 50];
        for _ in 0..50_000 {
            seen[draw.count(50..100) as usize - 50] += 1;
        }
        assert!(seen.iter().all(|&times| (800..1200).contains(&times)), "{seen:?}");
    }

    #[test]
    fn a_rotation_is_of_unit_length_and_turns_about_x_then_y_then_z() {
        let mut draw = Draw::new(2, 3);
        let mut again = Draw::new(2, 3);
        for _ in 0..100 {
            let [roll, pitch, yaw] = [(); 3].map(|()| again.between(-3.0, 3.0));
            let q = draw.rotation();
            assert!((q.length_squared() - 1.0).abs() < 1e-15);
            let steps = DQuat::from_rotation_z(yaw)
                * DQuat::from_rotation_y(pitch)
                * DQuat::from_rotation_x(roll);
            assert!(q.abs_diff_eq(steps, 1e-15));
        }
    }

    #[test]
    fn streams_and_seeds_differ() {
        let first = |seed, stream| Draw::new(seed, stream).between(0.0, 1.0);
        assert_ne!(first(1, 0), first(1, 1));
        assert_ne!(first(1, 0), first(2, 0));
    }
}
