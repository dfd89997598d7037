//! One pair at a time in f64 (and f32): GJK, EPA, portal refinement, closed forms, and the
//! certificates of scalar arithmetic.

pub(crate) mod body;
pub(crate) mod certificate;
pub mod certified;
pub mod closed;
pub(crate) mod difference;
pub mod distance;
pub mod epa;
pub(crate) mod expanding;
pub mod gjk;
pub(crate) mod order;
pub(crate) mod portal;
pub(crate) mod rims;
pub(crate) mod simplex;
pub(crate) mod solvers;
pub(crate) mod supports;
