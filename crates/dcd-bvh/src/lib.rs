//! Bounding volume hierarchies over boxes.
//!
//! A tree of one's own comes in by the doors [`BuildTree`] and [`BoundingTree`], whose laws
//! [`law`] tests. [`PaperTree`] makes the paper's tree in both of its versions; [`WideBvh`] is the
//! fast one.
//!
//! Deliberately absent: shapes, pairs, any knowledge of what is in a box.
#![forbid(unsafe_code)]

mod binary;
mod deal;
mod door;
pub mod law;
mod paper;
mod wide;

pub use binary::BinaryTree;
pub use door::{Below, BoundingTree, BuildTree, Node};
pub use paper::{BuildThreshold, PaperTree, Partition, Split};
pub use wide::{WideBuilder, WideBvh};
