//! The step: from a scene's poses to its touching pairs.
//!
//! A corridor between the rooms: it owns every buffer, cuts the work into tasks and runs the
//! stages; what a stage does is its room's matter. [`Pipeline::default`] is the fastest tree there
//! is and the most reliable answers there are; any other phase comes in by its door.
//!
//! Deliberately absent: Parry, files, a clock (but for [`StageClock`], which whoever wants times
//! brings).
#![forbid(unsafe_code)]

mod clock;
mod events;
mod roster;
mod step;
mod world;

pub use clock::StageClock;
pub use dcd_broad::{BroadPhase, WideTree};
pub use dcd_exec::{Exec, Par};
pub use dcd_geom::{self as geom, Pose, Scene, Shape};
pub use dcd_gjk::{NarrowPhase, Overlap};
pub use events::{Change, Event, Events};
pub use step::{Pipeline, Step};
pub use world::{Finding, Found, Linkage, Other, Probe, World};
