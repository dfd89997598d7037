//! How many candidate pairs a scene will have, before a step lists them.

use crate::failure::Failure;
use crate::memory;
use dcd_geom::{Aabb, Scene};

/// Pairs that are drawn. More: a surer estimate, later.
const DRAWN: u32 = 1 << 18;

/// Bytes of a candidate pair while a step decides it, at least.
const BYTES_A_PAIR: f64 = 16.0;

/// Checks that memory holds the candidate pairs of the scene, estimated from a sample of all pairs.
pub(super) fn check(scene: &Scene) -> Result<(), Failure> {
    let count = scene.len() as f64;
    let all = count * (count - 1.0) * 0.5;
    if all * BYTES_A_PAIR <= memory::available_bytes() as f64 {
        return Ok(());
    }
    let boxes: Vec<Aabb> = (0..scene.len()).map(|i| scene.aabb(i)).collect();
    let pairs = all * overlapping(&boxes);
    let what = format_args!("some {pairs:.1e} pairs of {} objects", scene.len());
    memory::demand("the scene", what, pairs * BYTES_A_PAIR)
}

/// The part of all pairs whose AABBs overlap, by a fixed draw, so that a scene is always refused, or
/// never.
fn overlapping(boxes: &[Aabb]) -> f64 {
    let mut state = 1u64;
    let mut draw = || {
        state = state.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(1);
        // The upper bits, which a multiplication mixes best.
        (((state >> 32) * boxes.len() as u64) >> 32) as usize
    };
    let mut found = 0u32;
    for _ in 0..DRAWN {
        let (i, j) = (draw(), draw());
        found += u32::from(i != j && boxes[i].overlaps(&boxes[j]));
    }
    f64::from(found) / f64::from(DRAWN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::Vec3;

    #[test]
    fn the_part_that_overlaps_is_found_within_a_tenth() {
        // In 100 places, 30 AABBs each: one pair in 100.
        let at = |k: usize| {
            let min = Vec3::X * (k % 100) as f32 * 2.0;
            Aabb { min, max: min + Vec3::ONE }
        };
        let boxes: Vec<Aabb> = (0..3000).map(at).collect();
        let part = overlapping(&boxes);
        assert!((part * 100.0 - 1.0).abs() < 0.1, "{part}");
        assert_eq!(overlapping(&boxes[..100]), 0.0);
    }
}
