//! Whether two convex shapes touch, and what the answer is worth.
//!
//! Deliberately absent: threads, trees, foreign libraries, a clock.
#![forbid(unsafe_code)]

mod bounds_only;
mod door;
mod each_pair;
mod exact;
pub mod law;
pub mod mesh;
pub mod query;
mod scalar;
pub mod simd;
pub mod simplify;
mod temporal;

pub(crate) use exact::double_double;
pub use mesh as parts;
pub(crate) use scalar::{certificate, difference, order, portal, simplex, solvers};
pub use scalar::{certified, closed, distance, epa, gjk};
pub use simd as lanes;

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
