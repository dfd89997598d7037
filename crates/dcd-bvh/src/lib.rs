//! Bounding volume hierarchies over boxes.
//!
//! Deliberately absent: shapes, pairs, any knowledge of what is in a box.
#![forbid(unsafe_code)]

mod door;

pub use door::{Below, BoundingTree, BuildTree, Node};
