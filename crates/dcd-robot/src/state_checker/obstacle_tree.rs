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

/// The obstacles near something.
#[derive(Clone, Debug, Default)]
pub(super) struct NearObstacles {
    /// By number, each with a bit for each lane that it is near.
    pub(super) listed: Vec<(u32, u32)>,
    /// What a tree finds.
    pairs: Vec<Pair>,
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

    /// Lists the obstacles whose boxes are near some of sixteen spheres, in their order, each with a bit for each of these.
    pub(super) fn list_near(
        &self,
        (centres, reach): (&Block, &Row),
        some: u32,
        of: &[Aabb],
        NearObstacles { listed, pairs }: &mut NearObstacles,
    ) {
        let mut aabbs = [Aabb::EMPTY; WIDTH];
        for lane in bits(some) {
            let (centre, reach) = (centres.point(lane), reach.0[lane]);
            let aabb = Aabb { min: centre - reach, max: centre + reach };
            // Written so that a NaN is near everything.
            let is_known = aabb.min.is_finite() && aabb.max.is_finite();
            aabbs[lane] = if is_known { aabb } else { Aabb::EVERYTHING };
        }
        self.find_overlaps(&aabbs, of, pairs);
        for &Pair { i: obstacle, j: name } in &*pairs {
            let bit = 1 << (name - self.names[0]);
            match listed.last_mut() {
                Some((last, lanes)) if *last == obstacle => *lanes |= bit,
                _ => listed.push((obstacle, bit)),
            }
        }
    }

    /// Lists which boxes overlap those of which obstacles, as pairs of both places.
    pub(super) fn list_overlaps(&self, aabbs: &[Aabb], of: &[Aabb], listed: &mut Vec<[u32; 2]>) {
        let mut pairs = Vec::new();
        for (first, few) in (0..).step_by(WIDTH).zip(aabbs.chunks(WIDTH)) {
            let mut sixteen = [Aabb::EMPTY; WIDTH];
            sixteen[..few.len()].copy_from_slice(few);
            self.find_overlaps(&sixteen, of, &mut pairs);
            listed.extend(pairs.iter().map(|pair| [first + (pair.j - self.names[0]), pair.i]));
        }
    }

    /// Finds each obstacle whose box overlaps one of sixteen boxes, with the name of that one, by the order of the obstacles.
    fn find_overlaps(&self, aabbs: &[Aabb; WIDTH], of: &[Aabb], pairs: &mut Vec<Pair>) {
        pairs.clear();
        let queries = IdentifiedAabbs { aabbs, names: &self.names };
        self.tree.append_pairs(queries, |i, _| !self.is_stale[i as usize], pairs);
        let around = aabbs.iter().fold(Aabb::EMPTY, |all, aabb| all.union(aabb));
        for &obstacle in &self.changed {
            let own = &of[obstacle as usize];
            if around.overlaps(own) {
                let overlapped =
                    self.names.iter().zip(aabbs).filter(|(_, aabb)| aabb.overlaps(own));
                pairs.extend(overlapped.map(|(&name, _)| Pair { i: obstacle, j: name }));
            }
        }
        pairs.sort_unstable_by_key(|pair| pair.i);
    }
}
