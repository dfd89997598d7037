//! Broad phase: from AABBs to candidate pairs.
//!
//! [`WideTree`] is the default. [`TreePairs`] traverses the paper's tree or one of your own against
//! itself. A broad phase of your own implements [`BroadPhase`]; [`contract`] tests it. Static objects
//! are in a [`StaticTree`], built once and queried with the AABBs of what moves; an [`ObstacleGrid`]
//! finds the obstacles near a sphere. [`BruteForce`] and [`SweepAndPrune`] share no code with the trees
//! that they are compared with.
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
