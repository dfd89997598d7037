//! From boxes to candidate pairs.
//!
//! Deliberately absent: shapes, solvers.
#![forbid(unsafe_code)]

mod door;

pub use door::BroadPhase;
