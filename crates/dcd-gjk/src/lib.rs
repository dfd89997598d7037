//! Whether two convex shapes touch, and what the answer is worth.
//!
//! Deliberately absent: threads, trees, foreign libraries, a clock.
#![forbid(unsafe_code)]

mod difference;
mod door;
mod each_pair;

pub use difference::{Body, Difference, Vertex};
pub use door::{Contact, Findings, NarrowPhase, Reason, Report, Rung, Undecided, Verdict};
pub use each_pair::{EachPair, Nothing, PairSolver, Placed};
