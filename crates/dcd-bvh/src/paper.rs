//! The paper's tree, with every parameter settable.

mod build;
mod partition;

use crate::{BinaryTree, BuildTree};
use dcd_exec::Exec;
use dcd_geom::Aabb;
use std::num::NonZeroU32;

/// Builds a binary tree by splitting at the middle of the longest axis, as algorithm 1 of the
/// ParustDCD paper does. The paper's text and its code differ: each is a preset.
///
/// Serial and parallel are one code path, and the tree is the same at any number of threads. A node
/// that cannot be split, because all its centroids fall on one side, is a leaf of any size.
///
/// Departure: below 128 levels a node is split in the middle of its list, so that no input makes
/// the recursion deeper than 128 + log₂ N. The paper's depth is bounded by N alone.
///
/// Cost: O(N) a level; for up to 2³¹ AABBs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PaperTree {
    /// Where a node is split.
    pub split: Split,
    /// Whether a split keeps the order of the AABBs on each side.
    pub partition: Partition,
    /// The number of AABBs above which a node's work is shared.
    pub parallel_above: BuildThreshold,
    /// The most AABBs of a node that no split is tried on.
    pub leaf_cutoff: NonZeroU32,
}

/// Along which axis a node is split, and where. Either way an AABB goes to the left if its centroid
/// lies below the middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// The axis on which the centroids spread farthest, at the middle of their spread. Both sides
    /// get AABBs, but for centroids that are equal or neighbouring floats.
    CentroidSpread,
    /// The axis on which the AABBs extend farthest, at the middle of their extent. Centroids may
    /// all lie on one side of that: one slab as large as the scene turns half of it into one leaf.
    BoxExtent,
}

/// Whether a split keeps order. The candidates are the same set; their order is another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partition {
    /// AABBs keep their order on each side.
    Stable,
    /// AABBs are exchanged from both ends of the list, which moves fewer of them.
    Unstable,
}

/// Above how many AABBs a node's bounds, its split and its two subtrees are shared among threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildThreshold {
    /// Above a third of all AABBs, rounded up: the topmost one to three nodes.
    ThirdOfObjects,
    /// Above so many AABBs.
    Objects(usize),
}

/// The paper's default (section 3.4).
const LEAF_CUTOFF: NonZeroU32 = NonZeroU32::new(4).unwrap();

impl PaperTree {
    /// What the paper's text says: section 2.1, and section 3.4 for the parameters.
    pub const fn as_written() -> Self {
        Self {
            split: Split::CentroidSpread,
            partition: Partition::Stable,
            parallel_above: BuildThreshold::ThirdOfObjects,
            leaf_cutoff: LEAF_CUTOFF,
        }
    }

    /// What the paper's code does.
    pub const fn as_coded() -> Self {
        Self {
            split: Split::BoxExtent,
            partition: Partition::Unstable,
            parallel_above: BuildThreshold::Objects(4096),
            leaf_cutoff: LEAF_CUTOFF,
        }
    }
}

/// [`PaperTree::as_written`]: the preset that no large AABB can degrade.
impl Default for PaperTree {
    fn default() -> Self {
        Self::as_written()
    }
}

impl BuildThreshold {
    fn of(self, objects: usize) -> usize {
        match self {
            Self::ThirdOfObjects => objects.div_ceil(3),
            Self::Objects(count) => count,
        }
    }
}

impl BuildTree for PaperTree {
    type Tree = BinaryTree;

    fn build(&self, aabbs: &[Aabb], exec: Exec, tree: &mut BinaryTree) {
        build::build(self, aabbs, exec, tree);
    }
}
