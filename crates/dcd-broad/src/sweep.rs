//! Sweep and prune along one axis.

use crate::BroadPhase;
use dcd_exec::{Exec, Segments};
use dcd_geom::{Aabb, Pair};
use glam::DVec3;

/// Places of the sorted list that a task sweeps from.
const GRAIN: usize = 256;

/// Sorts the AABBs by where they begin along one axis and compares each with those that begin
/// before it ends. The axis is that along which the centres vary most (Ericson, Real-Time Collision
/// Detection, 2005, section 7.5).
///
/// Cost: O(N log N), and a test for each pair of AABBs that overlap along the axis: a few AABBs as
/// long as the scene do no harm, many do. In the order of the sweep.
#[derive(Clone, Debug, Default)]
pub struct SweepAndPrune {
    axis: usize,
    /// Where each AABB begins, and its index: what is sorted.
    keys: Vec<u64>,
    sorted: Vec<(Aabb, u32)>,
}

impl BroadPhase for SweepAndPrune {
    fn build(&mut self, aabbs: &[Aabb], exec: Exec) {
        self.axis = axis_of_variance(aabbs);
        self.keys.clear();
        // AABBs that begin at one place follow each other by index: the order is that of no sort.
        let begins = |aabb: &Aabb| u64::from(ascending_bits(aabb.min[self.axis])) << 32;
        self.keys.extend(aabbs.iter().zip(0..).map(|(aabb, index)| begins(aabb) | index));
        exec.sort(&mut self.keys);
        self.sorted.clear();
        let indices = self.keys.iter().map(|&key| key as u32);
        self.sorted.extend(indices.map(|index| (aabbs[index as usize], index)));
    }

    fn pairs(
        &mut self,
        _: &[Aabb],
        keep: impl Fn(u32, u32) -> bool + Sync,
        exec: Exec,
        out: &mut Segments<Pair>,
    ) {
        let Self { axis, ref sorted, .. } = *self;
        out.fill(exec, sorted.len().div_ceil(GRAIN), |task, out| {
            for place in (GRAIN * task..sorted.len()).take(GRAIN) {
                let (a, i) = &sorted[place];
                let begun =
                    sorted[place + 1..].iter().take_while(|(b, _)| b.min[axis] <= a.max[axis]);
                for (b, j) in begun {
                    let pair = Pair::new(*i, *j);
                    if a.overlaps(b) && keep(pair.i, pair.j) {
                        out.push(pair);
                    }
                }
            }
        });
    }
}

/// Integers in the order of the numbers; −0 is just below 0.
fn ascending_bits(x: f32) -> u32 {
    let bits = x.to_bits();
    if x.is_sign_negative() { !bits } else { bits | 1 << 31 }
}

/// The axis of largest variance; in f64, where no square of a coordinate overflows.
fn axis_of_variance(aabbs: &[Aabb]) -> usize {
    let centres = || aabbs.iter().map(|aabb| aabb.centre().as_dvec3());
    let mean = centres().sum::<DVec3>() / aabbs.len().max(1) as f64;
    let variance: DVec3 = centres().map(|centre| (centre - mean) * (centre - mean)).sum();
    variance.max_position()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn ascending_bits_ascend_with_the_numbers() {
        let numbers = [f32::MIN, -1.0, -f32::MIN_POSITIVE, -1e-45, -0.0, 0.0, 1e-45, 1.0, f32::MAX];
        assert!(numbers.map(ascending_bits).is_sorted());
    }

    #[test]
    fn the_axis_is_that_of_the_most_variance_even_of_huge_coordinates() {
        let at = |x: f32, y: f32, z: f32| Aabb { min: Vec3::new(x, y, z), max: Vec3::new(x, y, z) };
        assert_eq!(axis_of_variance(&[]), 0);
        assert_eq!(axis_of_variance(&[at(0.0, 0.0, 5.0), at(1.0, -3.0, 5.0)]), 1);
        assert_eq!(axis_of_variance(&[at(1e38, 0.0, -2e38), at(-1e38, 0.0, 2e38)]), 2);
    }
}
