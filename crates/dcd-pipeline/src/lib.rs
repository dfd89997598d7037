//! The step: from a scene's poses to its touching pairs.
//!
//! A corridor between the rooms: it owns every buffer, cuts the work into tasks and runs the
//! stages; what a stage does is its room's matter. [`Pipeline::new`] has the fastest tree there
//! is and proved answers; [`Pipeline::with`] takes any other broad or narrow phase.
//! [`prelude`] brings all that a scene needs into scope.
//!
//! Deliberately absent: Parry, files, a clock (but for [`StageClock`], which whoever wants times
//! brings).
#![forbid(unsafe_code)]

mod batch;
mod clock;
mod events;
mod partition;
pub mod prelude;
mod step;

pub use batch::{BatchChecker, Hit, Hits, LinkSet, Other, StaticWorld};
pub use clock::StageClock;
pub use dcd_broad::{BroadPhase, WideTree};
pub use dcd_exec::{Exec, Par};
pub use dcd_geom::{self as geom, Pose, Scene, Shape};
pub use dcd_gjk::{NarrowPhase, Overlap};
pub use events::{Change, Event, Events};
pub use step::{Pipeline, Step};

/// The guide's pages, whose code is compiled and run.
#[cfg(doctest)]
mod guide {
    #[doc = include_str!("../../../README.md")]
    mod readme {}
    #[doc = include_str!("../../../docs/guide/hello.md")]
    mod hello {}
    #[doc = include_str!("../../../docs/guide/frames-and-events.md")]
    mod frames_and_events {}
    #[doc = include_str!("../../../docs/guide/bring-your-own.md")]
    mod bring_your_own {}
}
