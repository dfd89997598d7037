//! Every pair of AABBs.

use crate::BroadPhase;
use dcd_exec::{Exec, Segments};
use dcd_geom::{Aabb, Pair};

/// Rows of the triangle of all pairs that a task tests.
const ROWS: usize = 32;

/// Compares every AABB with every other: the reference for the other phases. N²/2 tests, no memory; in
/// ascending order.
#[derive(Clone, Copy, Debug, Default)]
pub struct BruteForce;

impl BroadPhase for BruteForce {
    fn build(&mut self, _: &[Aabb], _: Exec) {}

    fn pairs(
        &mut self,
        aabbs: &[Aabb],
        keep: impl Fn(u32, u32) -> bool + Sync,
        exec: Exec,
        out: &mut Segments<Pair>,
    ) {
        out.fill(exec, aabbs.len().div_ceil(ROWS), |task, out| {
            for i in (ROWS * task..aabbs.len()).take(ROWS) {
                for j in i + 1..aabbs.len() {
                    if aabbs[i].overlaps(&aabbs[j]) && keep(i as u32, j as u32) {
                        out.push(Pair { i: i as u32, j: j as u32 });
                    }
                }
            }
        });
    }
}
