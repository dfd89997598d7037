//! From boxes to candidate pairs.
//!
//! [`WideTree`] is the fast way. [`TreePairs`] drives the paper's tree or one of one's own; a whole
//! broad phase of one's own comes in by the trait [`BroadPhase`], whose contract [`contract`] tests. What
//! stands still is a [`StaticTree`], built once and asked by other boxes.
//! [`BruteForce`] and [`SweepAndPrune`] share nothing with the trees that they judge.
//!
//! Deliberately absent: shapes, solvers.
#![forbid(unsafe_code)]

mod append;
mod broad_phase;
mod brute_force;
pub mod contract;
mod obstacle_grid;
mod static_tree;
mod sweep;
mod tree_pairs;
mod wide;

pub use broad_phase::BroadPhase;
pub use brute_force::BruteForce;
pub use dcd_simd::{Aabb128, Mask128};
pub use obstacle_grid::{Cell, GridHits, ObstacleBounds, ObstacleGrid, PosedBounds};
pub use static_tree::{IdentifiedAabbs, StaticTree};
pub use sweep::SweepAndPrune;
pub use tree_pairs::{LeafPairs, Traversal, TreePairs, Visits};
pub use wide::WideTree;
