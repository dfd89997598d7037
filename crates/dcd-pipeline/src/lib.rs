//! The step: from a scene's poses to its touching pairs.
//!
//! A corridor between the rooms: it owns every buffer, cuts the work into tasks and runs the
//! stages; what a stage does is its room's matter. Deliberately absent: Parry, files, a clock (but
//! for [`StageClock`], which whoever wants times brings).
#![forbid(unsafe_code)]

mod clock;
mod step;

pub use clock::StageClock;
pub use dcd_exec::{Exec, Par};
pub use step::{Pipeline, Step};
