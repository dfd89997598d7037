//! The fast tree: sixteen AABBs a node, no pointers.

use crate::bins::Centre;
use crate::tiles::Tiles;
use crate::{BoundingTree, BuildTree, Node, NodeContent};
use dcd_exec::Exec;
use dcd_geom::{Aabb, Aabb16};
use dcd_simd::{IndexRow, WIDTH};

/// An implicit tree of sixteen children a node over spatially sorted AABBs.
///
/// Leaf k holds sixteen AABBs; node n of level 0 the AABBs of leaves 16n to 16n + 15; node n of
/// the next level those of the nodes 16n to 16n + 15 below; and so up to a level of one node.
/// Lanes past the end hold the empty AABB, which overlaps nothing.
///
/// ```
/// use dcd_bvh::{BoundingTree, WideBvh};
/// use dcd_exec::{Exec, Par};
/// use dcd_geom::{Aabb, glam::Vec3};
/// let unit = |x: f32| Aabb { min: Vec3::new(x, 0.0, 0.0), max: Vec3::new(x + 1.0, 1.0, 1.0) };
/// let boxes: Vec<Aabb> = (0..40).map(|k| unit(k as f32 * 2.0)).collect();
/// let mut tree = WideBvh::default();
/// tree.build(&boxes, Exec::from(Par::Serial));
/// assert_eq!(tree.leaves().len(), 3); // sixteen boxes a leaf
/// let root = tree.root().map(|root| tree.node(root).aabb);
/// assert_eq!(root.map(|aabb| aabb.max.x), Some(79.0));
/// ```
#[derive(Clone, Debug, Default)]
pub struct WideBvh {
    leaves: Vec<Aabb16>,
    ids: Vec<IndexRow>,
    levels: Vec<Vec<Aabb16>>,
    tiles: Tiles,
    /// 0, 1, 2, … for every leaf and node: what the trait's slices of children are cut from.
    numbers: Vec<u32>,
    count: usize,
}

/// Builds a [`WideBvh`] behind the trait, for traversals that take any tree.
#[derive(Clone, Copy, Debug, Default)]
pub struct WideBuilder;

impl BuildTree for WideBuilder {
    type Tree = WideBvh;

    fn build(&self, aabbs: &[Aabb], exec: Exec, tree: &mut WideBvh) {
        tree.build(aabbs, exec);
    }
}

/// Leaves are numbered first, then the nodes level by level.
impl BoundingTree for WideBvh {
    fn root(&self) -> Option<u32> {
        self.numbers.last().copied()
    }

    fn node(&self, number: u32) -> Node<'_> {
        let mut place = number as usize;
        if let Some(leaf) = self.leaves.get(place) {
            let count = (self.count - place * WIDTH).min(WIDTH);
            return Node {
                aabb: leaf.union(),
                below: NodeContent::Boxes(&self.ids[place].0[..count]),
            };
        }
        // Where the level below starts, and how many it has.
        let (mut start, mut below) = (0, self.leaves.len());
        place -= below;
        let mut levels = self.levels.iter();
        loop {
            let Some(level) = levels.next() else {
                return Node { aabb: Aabb::EMPTY, below: NodeContent::Boxes(&[]) };
            };
            if let Some(node) = level.get(place) {
                let first = place * WIDTH;
                let children = start + first..start + below.min(first + WIDTH);
                return Node {
                    aabb: node.union(),
                    below: NodeContent::Nodes(&self.numbers[children]),
                };
            }
            start += below;
            below = level.len();
            place -= below;
        }
    }
}

/// How many leaves or nodes a task fills: a microsecond of work or two. Larger: in small scenes
/// workers without a task fall asleep before the pairs are found.
const NODES_PER_TASK: usize = 16;

impl WideBvh {
    /// Makes the tree over these AABBs, which are valid, in place of what it held. The result does
    /// not depend on `exec`. O(n log n).
    pub fn build(&mut self, aabbs: &[Aabb], exec: Exec) {
        self.count = aabbs.len();
        self.tiles.sort(aabbs, WIDTH, exec);
        self.refit(aabbs, exec);
    }

    /// Takes in moved AABBs, as many as before, and keeps the order of the leaves. O(n).
    fn refit(&mut self, aabbs: &[Aabb], exec: Exec) {
        let leaves = self.count.div_ceil(WIDTH);
        self.leaves.resize(leaves, Aabb16::EMPTY);
        self.ids.resize(leaves, IndexRow::default());
        let order = self.tiles.order();
        let rows = (&mut self.leaves[..], &mut self.ids[..]);
        exec.divide(rows, NODES_PER_TASK, |first, (leaves, ids)| {
            let members = order[first * WIDTH..].chunks(WIDTH);
            for ((leaf, ids), members) in leaves.iter_mut().zip(ids).zip(members) {
                (*leaf, *ids) = (Aabb16::EMPTY, IndexRow::default());
                for (k, number) in members.iter().map(Centre::number).enumerate() {
                    ids.0[k] = number;
                    leaf.set(k, &aabbs[number as usize]);
                }
            }
        });
        self.raise_levels(exec);
        let nodes = self.levels.iter().fold(leaves, |sum, level| sum + level.len());
        self.numbers.clear();
        self.numbers.extend(0..nodes as u32);
    }

    fn raise_levels(&mut self, exec: Exec) {
        let mut nodes = self.leaves.len();
        let mut height = 0;
        while nodes > 1 || (nodes == 1 && height == 0) {
            nodes = nodes.div_ceil(WIDTH);
            if self.levels.len() == height {
                self.levels.push(Vec::new());
            }
            let (below, above) = self.levels.split_at_mut(height);
            let below = below.last().unwrap_or(&self.leaves);
            above[0].resize(nodes, Aabb16::EMPTY);
            exec.divide(&mut above[0][..], NODES_PER_TASK, |first, part| {
                for (node, children) in part.iter_mut().zip(below[first * WIDTH..].chunks(WIDTH)) {
                    *node = Aabb16::EMPTY;
                    for (k, child) in children.iter().enumerate() {
                        node.set(k, &child.union());
                    }
                }
            });
            height += 1;
        }
        self.levels.truncate(height);
    }

    /// The leaves' AABBs.
    pub fn leaves(&self) -> &[Aabb16] {
        &self.leaves
    }

    /// The index of each leaf's AABBs; lanes past the end are 0.
    pub fn ids(&self) -> &[IndexRow] {
        &self.ids
    }

    /// How many AABBs a leaf holds.
    pub fn boxes_in(&self, leaf: usize) -> usize {
        self.count.saturating_sub(leaf * WIDTH).min(WIDTH)
    }

    /// The nodes above the leaves, level by level; the last level has one node.
    pub fn levels(&self) -> &[Vec<Aabb16>] {
        &self.levels
    }

    /// Whether the tree is one over these AABBs: each in one lane of one leaf, every node's AABBs
    /// those round its children.
    pub fn validate(&self, aabbs: &[Aabb]) -> bool {
        let mut seen = vec![false; aabbs.len()];
        for (k, (leaf, ids)) in self.leaves.iter().zip(&self.ids).enumerate() {
            for lane in 0..WIDTH {
                if k * WIDTH + lane >= aabbs.len() {
                    if leaf.get(lane) != Aabb::EMPTY {
                        return false;
                    }
                } else {
                    let id = ids.0[lane] as usize;
                    if seen.get(id) != Some(&false) || leaf.get(lane) != aabbs[id] {
                        return false;
                    }
                    seen[id] = true;
                }
            }
        }
        let mut below = &self.leaves;
        self.levels.iter().all(|level| {
            let unions =
                |n: usize, k: usize| below.get(n * WIDTH + k).map_or(Aabb::EMPTY, Aabb16::union);
            let right = level.len() == below.len().div_ceil(WIDTH)
                && level
                    .iter()
                    .enumerate()
                    .all(|(n, node)| (0..WIDTH).all(|k| node.get(k) == unions(n, k)));
            below = level;
            right
        }) && seen.iter().all(|&seen| seen)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_exec::Par;
    use dcd_geom::glam::Vec3;
    use dcd_simd::{BoxTest, Lanes};

    /// AABBs on a spiral, of many sizes.
    fn boxes(count: usize) -> Vec<Aabb> {
        let at = |k: usize| {
            let t = k as f32;
            let centre = Vec3::new((t * 0.37).sin() * t, (t * 0.73).cos() * t, t % 17.0) * 0.1;
            let half = Vec3::new(0.1 + t % 3.0, 0.1, 0.3);
            Aabb { min: centre - half, max: centre + half }
        };
        (0..count).map(at).collect()
    }

    #[test]
    fn the_tree_is_valid_at_every_size_and_the_same_in_parallel() {
        let (mut serial, mut pooled) = (WideBvh::default(), WideBvh::default());
        // Grown and shrunk in place, so that what an earlier build left behind would show.
        for count in [5000, 0, 1, 2, 15, 16, 17, 255, 256, 257, 4096, 4097, 20] {
            let boxes = boxes(count);
            serial.build(&boxes, Par::Serial.into());
            pooled.build(&boxes, Par::Pool.into());
            assert!(serial.validate(&boxes), "{count}");
            assert_eq!(serial.ids, pooled.ids);
            // A tree made afresh has 0 in the lanes past the end, and so has one that was larger.
            let mut fresh = WideBvh::default();
            fresh.build(&boxes, Par::Serial.into());
            assert_eq!(serial.ids, fresh.ids, "{count}");
            assert_eq!(serial.levels, pooled.levels);
        }
    }

    #[test]
    fn behind_the_trait_it_keeps_the_contract() {
        for count in [0, 1, 16, 17, 300, 5000] {
            crate::contract::tree(&WideBuilder, &boxes(count)).unwrap();
        }
    }

    #[test]
    fn queries_without_an_end_meet_each_box_once() {
        struct AllOrNothing;
        impl BoxTest for AllOrNothing {
            #[inline(always)]
            fn keys<L: Lanes>(&self, l: L, boxes: &Aabb16) -> L::F {
                let open = l.le(l.load(&boxes.min[0]), l.load(&boxes.max[0]));
                l.select(open, l.splat(1.0), l.splat(f32::INFINITY))
            }
        }
        for count in [1, 3, 16, 17, 300] {
            let mut tree = WideBvh::default();
            tree.build(&boxes(count), Par::Serial.into());
            for limit in [0.0, f32::INFINITY] {
                let (mut met, mut keyed) = (Vec::new(), Vec::new());
                tree.visit(&Aabb::EVERYTHING, limit, &mut |k, _| {
                    met.push(k);
                    limit
                });
                tree.visit(&AllOrNothing, f32::INFINITY, &mut |k, _| {
                    keyed.push(k);
                    f32::INFINITY
                });
                for mut met in [met, keyed] {
                    met.sort_unstable();
                    assert!(met.into_iter().eq(0..count as u32), "{count} {limit}");
                }
            }
        }
    }

    #[test]
    fn a_wrong_tree_is_not_valid() {
        let boxes = boxes(300);
        let mut tree = WideBvh::default();
        tree.build(&boxes, Par::Serial.into());
        assert!(!tree.validate(&boxes[..299]));
        tree.levels[0][0].max[1].0[3] += 1.0;
        assert!(!tree.validate(&boxes));
    }
}
