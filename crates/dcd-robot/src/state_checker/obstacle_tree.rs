//! Many obstacles, where comparing with one after the other would cost more than a tree.

use dcd_broad::{IdentifiedAabbs, StaticTree};
use dcd_exec::{Exec, Par};
use dcd_geom::{Aabb, Pair};
use dcd_simd::WIDTH;

/// How many obstacles are compared one after the other. Larger: worlds of many cost more. Smaller: a tree is queried
/// where few comparisons would do. No effect on any answer.
const FEW: usize = 64;

/// A tree over the boxes of obstacles.
#[derive(Debug)]
pub(super) struct ObstacleTree {
    tree: StaticTree,
    /// The names of the sixteen query boxes: numbers after those of the obstacles.
    names: [u32; WIDTH],
}

impl ObstacleTree {
    /// Over these boxes, where they are many.
    pub(super) fn of(aabbs: &[Aabb]) -> Option<Self> {
        if aabbs.len() <= FEW {
            return None;
        }
        let names: Vec<u32> = (0..).take(aabbs.len()).collect();
        let mut tree = StaticTree::default();
        tree.build(IdentifiedAabbs { aabbs, names: &names }, Exec::from(Par::Serial));
        let first = aabbs.len() as u32;
        Some(Self { tree, names: std::array::from_fn(|lane| first + lane as u32) })
    }

    /// Reports each obstacle whose box overlaps one of sixteen boxes, and the number of that box.
    pub(super) fn reached(&self, aabbs: &[Aabb; WIDTH], mut report: impl FnMut(u32, usize)) {
        let mut pairs: Vec<Pair> = Vec::new();
        let queries = IdentifiedAabbs { aabbs, names: &self.names };
        self.tree.append_pairs(queries, |_, _| true, &mut pairs);
        pairs.sort_unstable();
        pairs.iter().for_each(|pair| report(pair.i, (pair.j - self.names[0]) as usize));
    }
}
