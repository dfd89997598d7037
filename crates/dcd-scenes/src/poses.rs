//! Seeded poses in a box.

use crate::random::Draw;
use dcd_geom::Pose;
use glam::DVec3;

/// Seeded poses: the paper's rotations, translations uniform in a box, metres. The same on every
/// machine; the first do not depend on how many are taken.
pub fn poses_in(low: DVec3, high: DVec3, seed: u64) -> impl Iterator<Item = Pose> {
    (0..).filter_map(move |k| {
        let mut draw = Draw::new(seed, k);
        let turn = draw.rotation();
        let [x, y, z] = [0, 1, 2].map(|axis| draw.between(low[axis], high[axis]));
        // A box that is not finite gives no pose.
        Pose::new(turn, DVec3::new(x, y, z)).ok()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_those_of_the_seed_and_in_the_box() {
        let (low, high) = (DVec3::new(-1.0, 2.0, 5.0), DVec3::new(1.0, 3.0, 9.0));
        let poses: Vec<_> = poses_in(low, high, 7).take(50).collect();
        assert_eq!(poses[..20], poses_in(low, high, 7).take(20).collect::<Vec<_>>());
        assert_ne!(poses[0], poses_in(low, high, 8).next().unwrap());
        for pose in poses {
            let t = pose.translation();
            assert!(t.cmpge(low).all() && t.cmplt(high).all());
        }
    }
}
