//! Narrow phase: whether shapes touch, how far they are apart, how deep they overlap.
//!
//! [`Overlap`] decides a scene's candidate pairs in packets of sixteen, each answer with a certificate;
//! pairs that f32 cannot certify go to f64 and then to exact arithmetic. [`Coherent`] also reuses the proofs
//! of earlier steps. For single pairs, a [`PairSolver`] answers one question: yes or no ([`Certified`],
//! [`Gjk`]), distance ([`Distances`]), depth ([`Depths`]), manifold ([`Manifolds`]). [`SimdDistances`]
//! measures distances in packets too, [`SimdDepths`] depths and manifolds with lanes inside each pair.
//! [`Pairwise`] makes a narrow phase of a solver, [`ThenMeasure`] runs it on touching pairs only. A narrow
//! phase of your own implements [`NarrowPhase`]; [`contract`] tests it.
//!
//! Folders: `simd` (packets), `temporal` (proofs kept between steps), `scalar` (one pair in f64),
//! `exact` (exact arithmetic), `mesh` (compounds and triangle meshes), `query` (what is measured).
//!
//! Deliberately absent: threads, trees over objects, foreign libraries, a clock.
#![forbid(unsafe_code)]

mod bounds_only;
mod contact_list;
pub mod contract;
mod exact;
pub mod mesh;
pub mod motion;
mod narrow_phase;
mod pairwise;
pub mod query;
mod scalar;
pub mod simd;
pub mod simplify;
mod temporal;

pub(crate) use exact::double_double;
pub(crate) use scalar::{
    body, certificate, difference, expanding, order, portal, rims, simplex, solvers, supports,
};
pub use scalar::{certified, closed, distance, epa, gjk};

pub use bounds_only::BoundsOnly;
pub use contact_list::{ContactAnswer, ContactList, ContactsOf};
pub use difference::{Difference, PosedSupport, Vertex};
pub use distance::{Distance, DistanceResult};
pub use narrow_phase::{
    Contact, ContactSink, Method, NarrowPhase, Prepared, Reason, Report, Sides, Undecided, Verdict,
};
pub use pairwise::{Empty, PairSolver, Pairwise, PosedShape};
pub use query::{
    Accuracy, Depths, Distances, Manifold, ManifoldSet, Manifolds, Proximities, Proximity,
    ThenMeasure, WithAccuracy, Within,
};
pub use simd::{Coherent, Overlap, OverlapUnchecked, SimdDepths, SimdDistances};
pub use solvers::{Certified, Gjk};

/// Unit roundoff of f64, the u of every bound.
pub(crate) const UNIT: f64 = f64::EPSILON / 2.0;
