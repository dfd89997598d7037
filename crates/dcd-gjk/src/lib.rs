//! Whether two convex shapes touch, and what the answer is worth.
//!
//! Deliberately absent: threads, trees, foreign libraries, a clock.
#![forbid(unsafe_code)]

mod bounds_only;
pub mod contract;
mod exact;
pub mod mesh;
mod narrow_phase;
mod pairwise;
pub mod query;
mod scalar;
pub mod simd;
pub mod simplify;
mod temporal;

pub(crate) use exact::double_double;
pub(crate) use scalar::{certificate, difference, order, portal, simplex, solvers};
pub use scalar::{certified, closed, distance, epa, gjk};

pub use bounds_only::BoundsOnly;
pub use difference::{Difference, PosedSupport, Vertex};
pub use distance::{Distance, DistanceResult};
pub use narrow_phase::{
    Contact, ContactSink, Method, NarrowPhase, Reason, Report, Undecided, Verdict,
};
pub use pairwise::{Empty, PairSolver, Pairwise, PosedShape};
pub use query::{
    Depths, Distances, Manifold, Manifolds, Proximities, Proximity, ThenMeasure, Within,
};
pub use simd::{Coherent, Overlap, OverlapUnchecked};
pub use solvers::{Certified, Gjk};
