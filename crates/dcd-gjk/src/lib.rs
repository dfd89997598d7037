//! Whether two convex shapes touch, and what the answer is worth.
//!
//! Deliberately absent: threads, trees, foreign libraries, a clock.
#![forbid(unsafe_code)]

mod bounds_only;
mod certificate;
pub mod certified;
pub mod closed;
mod difference;
pub mod distance;
mod door;
mod double_double;
mod each_pair;
pub mod epa;
mod exact;
pub mod gjk;
pub mod lanes;
pub mod law;
mod order;
pub mod parts;
mod portal;
pub mod query;
mod simplex;
pub mod simplify;
mod solvers;

pub use bounds_only::BoundsOnly;
pub use difference::{Body, Difference, Vertex};
pub use distance::{Distance, DistanceResult};
pub use door::{Contact, Findings, NarrowPhase, Reason, Report, Rung, Undecided, Verdict};
pub use each_pair::{EachPair, Nothing, PairSolver, Placed};
pub use lanes::{Coherent, Overlap, OverlapUnproved};
pub use query::{
    Depths, Distances, Manifold, Manifolds, OfTouching, Proximities, Proximity, Within,
};
pub use solvers::{Certified, Gjk};
