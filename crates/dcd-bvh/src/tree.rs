//! The trait for a tree of one's own.

use dcd_exec::Exec;
use dcd_geom::Aabb;

/// Makes a tree over AABBs.
///
/// # Contract
/// The tree keeps the contract of [`BoundingTree`] for these AABBs, and is the same whatever `exec` is.
/// `contract` tests both.
pub trait BuildTree: Send + Sync {
    /// What is made. Its `Default` is the tree over no AABB.
    type Tree: BoundingTree + Default + Send;

    /// Makes the tree over `aabbs` in place of what `tree` held; its memory may be reused.
    fn build(&self, aabbs: &[Aabb], exec: Exec, tree: &mut Self::Tree);
}

/// A bounding volume hierarchy whose leaves name AABBs by index.
///
/// # Contract
/// From the root each index below the number of AABBs is reached in exactly one leaf, each node
/// in one way; a node's AABB contains the AABBs of all that is below it; a leaf names at least one.
pub trait BoundingTree: Sync {
    /// The root's number; `None` where there is no AABB.
    fn root(&self) -> Option<u32>;

    /// The node of that number, which came from the root or from a node above.
    fn node(&self, number: u32) -> Node<'_>;
}

/// What a traversal sees of a node.
#[derive(Clone, Copy, Debug)]
pub struct Node<'t> {
    /// Contains the AABBs of all objects below.
    pub aabb: Aabb,
    /// What is directly below.
    pub below: NodeContent<'t>,
}

/// What is directly below a node.
#[derive(Clone, Copy, Debug)]
pub enum NodeContent<'t> {
    /// The numbers of its children, at least one.
    Nodes(&'t [u32]),
    /// The indices of its AABBs, at least one.
    Boxes(&'t [u32]),
}
