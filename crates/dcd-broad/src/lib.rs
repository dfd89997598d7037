//! From boxes to candidate pairs.
//!
//! [`WideTree`] is the fast way. [`TreePairs`] drives the paper's tree or one of one's own; a whole
//! broad phase of one's own comes in by the door [`BroadPhase`], whose law [`law`] tests. What
//! stands still is a [`StandingTree`], built once and asked by other boxes.
//! [`BruteForce`] and [`SweepAndPrune`] share nothing with the trees that they judge.
//!
//! Deliberately absent: shapes, solvers.
#![forbid(unsafe_code)]

mod against;
mod append;
mod brute_force;
mod door;
pub mod law;
mod sweep;
mod tree_pairs;
mod vicinity;
mod wide;

pub use against::{Named, StandingTree};
pub use brute_force::BruteForce;
pub use dcd_geom::lanes::{BoxRow, BoxSet};
pub use door::BroadPhase;
pub use sweep::SweepAndPrune;
pub use tree_pairs::{LeafPairs, Traversal, TreePairs, Visits};
pub use vicinity::{Listing, Outline, Posed, Reached, Vicinity};
pub use wide::WideTree;
