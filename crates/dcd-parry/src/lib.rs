//! Parry 0.31 behind the doors of this workspace, in its f32 build and in its f64 one.
//!
//! - [`ParryGjk`]: its GJK on our support maps, one pair at a time.
//! - [`ParryShapes`]: its own shapes through its public queries, as a narrow phase.
//! - [`ParryBvh`]: its bounding volume hierarchy, as a broad phase.
//! - [`ParryPipeline`]: its best pipeline from boxes to contacts, each stage its own: the rival.
//!
//! What Parry says is passed on as it is, right or wrong; what it does not say (it panics, it runs
//! out of iterations where that can be told, it refuses the shape, the numbers leave its range) is
//! undecided. Deliberately absent: any repair of its answers, and any use of it by the rest.
#![forbid(unsafe_code)]

mod bvh;
mod forms;
mod gjk;
mod library;
mod pipeline;
mod shapes;

pub use bvh::ParryBvh;
pub use gjk::ParryGjk;
pub use library::{Library, Query};
pub use pipeline::{ParryPipeline, ParryStep, Ready};
pub use shapes::{ParryShapes, ShapesFrame};
