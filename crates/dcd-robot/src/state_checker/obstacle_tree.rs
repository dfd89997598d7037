//! Many obstacles, where comparing with one after the other would cost more than a tree.

use super::rounded_links::bits;
use dcd_broad::{IdentifiedAabbs, StaticTree};
use dcd_exec::{Exec, Par};
use dcd_geom::{Aabb, Pair};
use dcd_simd::{Block, Row, WIDTH};

/// How many obstacles are compared one after the other. Larger: worlds of many cost more. Smaller: a tree is queried
/// where few comparisons would do. No effect on any answer.
const FEW: usize = 64;

/// How many obstacles may have changed since the tree was built. Larger: each query compares more boxes. Smaller: trees
/// are built more often. No effect on any answer.
const MOST_CHANGED: usize = 32;

/// A tree over the boxes of obstacles, with a list of those that have changed since it was built.
#[derive(Debug)]
pub(super) struct ObstacleTree {
    tree: StaticTree,
    /// The names of the sixteen query boxes: numbers after those of the obstacles in the tree.
    names: [u32; WIDTH],
    /// Those whose boxes in the tree are not theirs any more, or are not in it.
    changed: Vec<u32>,
    /// Of each in the tree whether it is among them, or gone.
    is_stale: Vec<bool>,
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
        let names = std::array::from_fn(|lane| first + lane as u32);
        Some(Self { tree, names, changed: Vec::new(), is_stale: vec![false; aabbs.len()] })
    }

    /// Takes note that an obstacle is new, is elsewhere or, with its number, another one.
    pub(super) fn change(&mut self, obstacle: u32) {
        if !self.changed.contains(&obstacle) {
            self.changed.push(obstacle);
        }
        if let Some(stale) = self.is_stale.get_mut(obstacle as usize) {
            *stale = true;
        }
    }

    /// Takes note that there is no obstacle of that number any more.
    pub(super) fn forget(&mut self, obstacle: u32) {
        self.change(obstacle);
        self.changed.retain(|&changed| changed != obstacle);
    }

    /// Whether so many have changed that a new tree is better.
    pub(super) fn is_worn(&self) -> bool {
        self.changed.len() > MOST_CHANGED
    }

    /// Lists the obstacles whose boxes are near some of sixteen spheres, in the order of both, each with a bit.
    pub(super) fn list_near(
        &self,
        (centres, reach): (&Block, &Row),
        some: u32,
        of: &[Aabb],
        near: &mut Vec<(u32, u32)>,
    ) {
        let mut aabbs = [Aabb::EMPTY; WIDTH];
        for lane in bits(some) {
            let (centre, reach) = (centres.point(lane), reach.0[lane]);
            let aabb = Aabb { min: centre - reach, max: centre + reach };
            // Written so that a NaN is near everything.
            let is_known = aabb.min.is_finite() && aabb.max.is_finite();
            aabbs[lane] = if is_known { aabb } else { Aabb::EVERYTHING };
        }
        let reached = self.reached(&aabbs, of).into_iter();
        near.extend(reached.map(|(obstacle, lane)| (obstacle, 1 << lane)));
    }

    /// Lists each obstacle whose box overlaps one of sixteen boxes, and the number of that box: in the order of both.
    fn reached(&self, aabbs: &[Aabb; WIDTH], of: &[Aabb]) -> Vec<(u32, usize)> {
        let mut pairs: Vec<Pair> = Vec::new();
        let queries = IdentifiedAabbs { aabbs, names: &self.names };
        self.tree.append_pairs(queries, |i, _| !self.is_stale[i as usize], &mut pairs);
        let lane = |pair: &Pair| (pair.j - self.names[0]) as usize;
        let mut reached: Vec<(u32, usize)> = pairs.iter().map(|p| (p.i, lane(p))).collect();
        let around = aabbs.iter().fold(Aabb::EMPTY, |all, aabb| all.union(aabb));
        for &obstacle in &self.changed {
            let own = &of[obstacle as usize];
            if around.overlaps(own) {
                let lanes = (0..WIDTH).filter(|&lane| aabbs[lane].overlaps(own));
                reached.extend(lanes.map(|lane| (obstacle, lane)));
            }
        }
        reached.sort_unstable();
        reached
    }
}
