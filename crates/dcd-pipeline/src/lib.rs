//! Collision detection of a whole scene: the step, events, and batches of configurations.
//!
//! [`Pipeline::step`] takes a [`Scene`] to its touching pairs: AABBs, tree, candidate pairs, answers. It
//! owns every buffer and cuts the work into tasks. By default it uses [`WideTree`] and [`Overlap`], the
//! certified narrow phase; any other [`BroadPhase`] and [`NarrowPhase`] can take their places. An
//! [`AnyPipeline`] takes its [`Question`] at run time.
//! [`Events`] compares a step's contacts with those of the step before. A [`StaticWorld`] prepares
//! obstacles once; a [`BatchChecker`] checks configurations of a [`LinkSet`] against them, and its links
//! against each other.
//!
//! Deliberately absent: Parry, files, a clock (but for [`StageClock`], for callers who want times).
#![forbid(unsafe_code)]

mod any;
mod batch;
mod clock;
mod events;
mod moving_ranges;
mod partition;
pub mod prelude;
mod queries;
mod step;

pub use any::{Answer, AnyPipeline, AnyStep, Precision, Question};
pub use batch::{BatchChecker, Candidate, Hit, Hits, LinkSet, Other, PairDecider, StaticWorld};
pub use clock::StageClock;
pub use dcd_broad::{BroadPhase, WideTree};
pub use dcd_exec::{Exec, Par, Segments};
pub use dcd_geom::{self as geom, Pose, Scene, Shape};
pub use dcd_gjk::query::ray::{Ray, RayError, RayHit};
pub use dcd_gjk::{NarrowPhase, Overlap};
pub use events::{Change, Event, Events};
pub use queries::{
    Found, Impacts, NearestObject, ObjectHit, ObjectImpact, PairImpact, Queries, QueryError,
    QueryFilter, RegionError, SensorChoice, Velocity,
};
pub use step::{Pipeline, Step, StepPairs};

/// The guide's pages, whose code is compiled and run.
#[cfg(doctest)]
mod guide {
    #[doc = include_str!("../../../README.md")]
    mod readme {}
    #[doc = include_str!("../../../docs/guide/hello.md")]
    mod hello {}
    #[doc = include_str!("../../../docs/guide/frames-and-events.md")]
    mod frames_and_events {}
    #[doc = include_str!("../../../docs/guide/scene-queries.md")]
    mod scene_queries {}
    #[doc = include_str!("../../../docs/guide/bring-your-own.md")]
    mod bring_your_own {}
    #[doc = include_str!("../../../docs/guide/add-a-shape.md")]
    mod add_a_shape {}
}
