//! Bounding volume hierarchies over AABBs.
//!
//! [`WideBvh`] is the fast one, sixteen AABBs a node. [`PaperTree`] builds the paper's binary tree in
//! both of its versions. A tree of your own implements [`BuildTree`] and [`BoundingTree`]; [`contract`]
//! tests it.
//!
//! Deliberately absent: shapes, pairs, any knowledge of what is in an AABB.
#![forbid(unsafe_code)]

mod binary;
mod bins;
pub mod contract;
mod paper;
mod sample_sort;
mod tiles;
mod tree;
mod visit;
mod wide;

pub use binary::BinaryTree;
pub use paper::{BuildThreshold, PaperTree, Partition, Split};
pub use tree::{BoundingTree, BuildTree, Node, NodeContent};
pub use wide::{WideBuilder, WideBvh};
