//! Algorithm 1: build a node, then its two subtrees.

use super::partition::{partition, reduce};
use super::{PaperTree, Split};
use crate::binary::{BinaryNode, BinaryTree, Content};
use dcd_exec::{Exec, Par};
use dcd_geom::Aabb;

/// Levels that are split at a midpoint; below them the list is halved. Bounds the recursion.
/// Larger: more stack on input made to need it, such as centroids at powers of two. Smaller: worse
/// trees for scenes whose sizes span as many powers of two.
const MIDPOINT_LEVELS: u32 = 128;

pub(super) fn build(parameters: &PaperTree, aabbs: &[Aabb], exec: Exec, tree: &mut BinaryTree) {
    let (indices, nodes) = tree.reserve(aabbs.len());
    let Some((root, below)) = nodes.split_first_mut() else { return };
    let parallel_above = parameters.parallel_above.of(aabbs.len());
    let builder = Builder { parameters, aabbs, parallel_above };
    *root = builder.subtree(Part { first: 0, indices, below }, 0, exec);
}

/// What all nodes of a build share.
#[derive(Clone, Copy)]
struct Builder<'b> {
    parameters: &'b PaperTree,
    aabbs: &'b [Aabb],
    parallel_above: usize,
}

/// A subtree's part of the tree's arrays.
struct Part<'t> {
    /// Where `indices` begins in the tree's list.
    first: usize,
    /// The AABBs of the subtree.
    indices: &'t mut [u32],
    /// Slots for the nodes below the subtree's root: two for every AABB but one.
    below: &'t mut [BinaryNode],
}

impl<'t> Part<'t> {
    /// The two parts on both sides of `middle`, and the slots between them for their roots. Which slots
    /// those are depends on `first + middle` alone, and no other node is split there: so a node's place does
    /// not depend on who builds it when.
    fn split_at(self, middle: usize) -> (Self, &'t mut [BinaryNode], Self) {
        let (left, right) = self.indices.split_at_mut(middle);
        let (below_left, rest) = self.below.split_at_mut(2 * middle - 2);
        let (roots, below_right) = rest.split_at_mut(2);
        (
            Self { first: self.first, indices: left, below: below_left },
            roots,
            Self { first: self.first + middle, indices: right, below: below_right },
        )
    }
}

impl Builder<'_> {
    /// Fills the part and returns its root.
    fn subtree(self, part: Part, depth: u32, exec: Exec) -> BinaryNode {
        let count = part.indices.len();
        if count <= self.parameters.leaf_cutoff.get() as usize {
            return self.leaf(&part, Par::Serial.into());
        }
        let exec = if count > self.parallel_above { exec } else { Par::Serial.into() };
        let middle = self.split(part.indices, depth, exec);
        if middle == 0 || middle == count {
            return self.leaf(&part, exec);
        }
        let right_root = 2 * (part.first + middle) as u32;
        let (left, roots, right) = part.split_at(middle);
        let (left, right) = exec
            .join(|| self.subtree(left, depth + 1, exec), || self.subtree(right, depth + 1, exec));
        roots.copy_from_slice(&[left, right]);
        BinaryNode {
            aabb: left.aabb.union(&right.aabb),
            content: Content::Nodes([right_root - 1, right_root]),
        }
    }

    /// Orders the AABBs of a node into a left and a right side; where the right side begins.
    fn split(self, indices: &mut [u32], depth: u32, exec: Exec) -> usize {
        if depth >= MIDPOINT_LEVELS {
            return indices.len() / 2;
        }
        let bounds = match self.parameters.split {
            Split::CentroidSpread => reduce(indices, exec, &|i| {
                let centroid = self.aabb(i).centre();
                Aabb { min: centroid, max: centroid }
            }),
            Split::BoxExtent => reduce(indices, exec, &|i| self.aabb(i)),
        };
        // Halved before the subtraction, which could overflow; the first of equal axes.
        let extent = bounds.max * 0.5 - bounds.min * 0.5;
        let axis = extent.to_array().iter().position(|&x| x == extent.max_element()).unwrap_or(0);
        let middle = bounds.centre()[axis];
        let is_left = |i| self.aabb(i).centre()[axis] < middle;
        partition(self.parameters.partition, indices, exec, &is_left)
    }

    fn leaf(self, part: &Part, exec: Exec) -> BinaryNode {
        BinaryNode {
            aabb: reduce(part.indices, exec, &|i| self.aabb(i)),
            content: Content::Boxes { first: part.first as u32, count: part.indices.len() as u32 },
        }
    }

    fn aabb(self, index: u32) -> Aabb {
        self.aabbs[index as usize]
    }
}
