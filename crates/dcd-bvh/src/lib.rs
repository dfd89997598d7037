//! Bounding volume hierarchies over boxes.
//!
//! A tree of one's own comes in by the traits [`BuildTree`] and [`BoundingTree`], whose contracts
//! [`contract`] tests. [`PaperTree`] makes the paper's tree in both of its versions; [`WideBvh`] is the
//! fast one.
//!
//! Deliberately absent: shapes, pairs, any knowledge of what is in a box.
#![forbid(unsafe_code)]

mod binary;
pub mod contract;
mod paper;
mod sample_sort;
mod tree;
mod wide;

pub use binary::BinaryTree;
pub use paper::{BuildThreshold, PaperTree, Partition, Split};
pub use tree::{BoundingTree, BuildTree, Node, NodeContent};
pub use wide::{WideBuilder, WideBvh};
