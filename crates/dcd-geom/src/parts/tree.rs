//! A static tree over the parts of one shape, sixteen AABBs a block.

use super::build;
use crate::{Aabb, Aabb16};
use dcd_simd::{IndexRow, WIDTH};

/// A tree over the AABBs of a shape's parts, in the shape's own frame.
///
/// It is made of blocks of sixteen AABBs. The first blocks are the leaves: their AABBs are those of
/// parts. An AABB of any other block is that round all of a block with a smaller number. The last
/// block is the root. Lanes that are not needed hold the empty AABB.
#[derive(Clone, Debug, Default)]
pub struct PartTree {
    blocks: Vec<Aabb16>,
    below: Vec<IndexRow>,
    unions: Vec<Aabb>,
    /// For each block, how many of its lanes, the first ones, are needed.
    filled: Vec<u8>,
    leaves: usize,
    reach: f64,
}

impl PartTree {
    /// A tree over these AABBs, at least one, at most u32::MAX. O(n log² n).
    pub(crate) fn over(boxes: &[Aabb]) -> Self {
        let mut tree = Self::default();
        build::build(boxes, &mut tree);
        let Aabb { min, max } = tree.aabb();
        // Squares and sums lose 3u; 8u cover them.
        let lost = 1.0 + 4.0 * f64::EPSILON;
        tree.reach = min.abs().max(max.abs()).as_dvec3().length() * lost;
        tree
    }

    /// The blocks: the leaves, then the others, the root last.
    pub fn blocks(&self) -> &[Aabb16] {
        &self.blocks
    }

    /// For each block, the children of its AABBs: parts below a leaf, else blocks. Lanes of empty
    /// AABBs are 0.
    pub fn below(&self) -> &[IndexRow] {
        &self.below
    }

    /// The parts in the order of the leaves, each once: neighbours are near each other.
    pub fn parts(&self) -> impl Iterator<Item = u32> + '_ {
        let leaves = self.blocks.iter().zip(&self.below).take(self.leaves);
        leaves.flat_map(|(boxes, below)| {
            let is_part = |&lane: &usize| boxes.get(lane) != Aabb::EMPTY;
            (0..WIDTH).filter(is_part).map(|lane| below.0[lane])
        })
    }

    /// The lanes of a block that are needed, a bit each.
    pub(super) fn filled(&self, block: usize) -> u32 {
        (1 << self.filled[block]) - 1
    }

    /// For each block, the AABB round all of its AABBs.
    pub fn unions(&self) -> &[Aabb] {
        &self.unions
    }

    /// How many of the blocks are leaves.
    pub fn leaf_count(&self) -> usize {
        self.leaves
    }

    /// The number of the root.
    pub fn root(&self) -> usize {
        self.blocks.len().saturating_sub(1)
    }

    /// No part's AABB has a point farther from the frame's origin, metres.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// The AABB round all parts.
    pub fn aabb(&self) -> Aabb {
        self.unions.last().copied().unwrap_or(Aabb::EMPTY)
    }

    /// Appends a block of at most sixteen AABBs, each with what it stands for; the last entries
    /// appended as a leaf must come before the first that is none. The block's number.
    pub(super) fn push(&mut self, entries: impl Iterator<Item = (Aabb, u32)>) -> u32 {
        let (mut block, mut below) = (Aabb16::EMPTY, IndexRow::default());
        let mut filled = 0;
        for (lane, (aabb, number)) in entries.take(WIDTH).enumerate() {
            block.set(lane, &aabb);
            below.0[lane] = number;
            filled += 1;
        }
        self.filled.push(filled);
        self.blocks.push(block);
        self.below.push(below);
        self.unions.push(block.union());
        (self.blocks.len() - 1) as u32
    }

    /// Whatever was appended so far are the leaves.
    pub(super) fn end_of_leaves(&mut self) {
        self.leaves = self.blocks.len();
    }

    /// Whether every part stands in one leaf with its AABB, and every AABB of another block is that
    /// round the block that it stands for, each but the root once. O(n).
    pub fn validate(&self, boxes: &[Aabb]) -> bool {
        let mut parts = vec![0u32; boxes.len()];
        let mut blocks = vec![0u32; self.blocks.len()];
        for (number, (block, below)) in self.blocks.iter().zip(&self.below).enumerate() {
            for lane in 0..WIDTH {
                let (aabb, child) = (block.get(lane), below.0[lane] as usize);
                if aabb == Aabb::EMPTY {
                    continue;
                }
                let (seen, expected) = if number < self.leaves {
                    (parts.get_mut(child), boxes.get(child))
                } else if child < number {
                    (blocks.get_mut(child), self.unions.get(child))
                } else {
                    return false;
                };
                match (seen, expected) {
                    (Some(seen), Some(expected)) if aabb == *expected => *seen += 1,
                    _ => return false,
                }
            }
        }
        let root = blocks.pop();
        root == Some(0) && parts.iter().chain(&blocks).all(|&seen| seen == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

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
    fn the_tree_is_valid_at_every_size() {
        for count in [1, 2, 15, 16, 17, 255, 256, 257, 300, 4097, 5000] {
            let boxes = boxes(count);
            let tree = PartTree::over(&boxes);
            assert!(tree.validate(&boxes), "{count}");
            let all = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
            assert_eq!(tree.aabb(), all);
        }
    }

    #[test]
    fn parts_at_one_place_make_a_tree_too() {
        let boxes = vec![Aabb { min: Vec3::ONE, max: Vec3::ONE }; 1000];
        assert!(PartTree::over(&boxes).validate(&boxes));
    }

    /// How many blocks are on the longest way from the root to a part, and how many parts are below
    /// all blocks together: what building it takes, but for a factor.
    fn depth_and_work(tree: &PartTree) -> (usize, usize) {
        let mut sizes: Vec<(usize, usize)> = Vec::new();
        for (number, (block, below)) in tree.blocks.iter().zip(&tree.below).enumerate() {
            let filled = (0..WIDTH).filter(|&lane| block.get(lane) != Aabb::EMPTY);
            let size = if number < tree.leaves {
                (1, filled.count())
            } else {
                let children = filled.map(|lane| sizes[below.0[lane] as usize]);
                children.fold((0, 0), |(d, n), (depth, parts)| (d.max(depth + 1), n + parts))
            };
            sizes.push(size);
        }
        let depth = sizes.last().map_or(0, |&(depth, _)| depth);
        (depth, sizes.iter().map(|&(_, parts)| parts).sum())
    }

    #[test]
    fn building_over_coincident_parts_takes_time_linear_in_their_number() {
        let one = Aabb { min: Vec3::new(0.1, 0.7, 0.3), max: Vec3::new(1.3, 0.9, 2.1) };
        let near = |k: usize| {
            // A float apart: no two costs are the same, and none is worth a lopsided cut.
            let shift = Vec3::X * (k % 3) as f32 * f32::EPSILON;
            Aabb { min: one.min + shift, max: one.max + shift }
        };
        let flat = Aabb { max: Vec3::new(1.3, 0.7, 0.3), ..one };
        let alike: [(&str, Vec<Aabb>); 4] = [
            ("one box", vec![one; 40_000]),
            ("a float apart", (0..40_000).map(near).collect()),
            ("without area", vec![flat; 40_000]),
            ("two places", (0..40_000).map(|k| if k < 39_990 { one } else { flat }).collect()),
        ];
        for (what, boxes) in alike {
            let tree = PartTree::over(&boxes);
            assert!(tree.validate(&boxes), "{what}");
            let (depth, work) = depth_and_work(&tree);
            assert!(depth <= 7 && work <= 7 * boxes.len(), "{what}: {depth} deep, {work} in all");
        }
    }

    #[test]
    fn sizes_that_double_make_no_path_longer_than_f32_has_powers_of_two() {
        let boxes: Vec<Aabb> = (0..20_000)
            .map(|k| {
                let max = Vec3::splat(2f32.powi(k % 120 - 60));
                Aabb { min: Vec3::ZERO, max }
            })
            .collect();
        let tree = PartTree::over(&boxes);
        let (depth, work) = depth_and_work(&tree);
        assert!(tree.validate(&boxes) && depth <= 40 && work <= 40 * boxes.len(), "{depth} {work}");
    }

    #[test]
    fn leaves_are_full_but_for_the_last_of_each_cut() {
        let tree = PartTree::over(&boxes(2180));
        assert_eq!(tree.leaf_count(), 2180usize.div_ceil(WIDTH));
    }

    #[test]
    fn a_wrong_tree_is_not_valid() {
        let boxes = boxes(300);
        let mut tree = PartTree::over(&boxes);
        assert!(!tree.validate(&boxes[..299]));
        tree.blocks[0].max[1].0[3] += 1.0;
        assert!(!tree.validate(&boxes));
    }
}
