//! The steps themselves, on the rung asked for, with the time of each stage.

use crate::failure::Failure;
use crate::rung::Rung;
use dcd_broad::WideTree;
use dcd_exec::with_threads;
use dcd_geom::{Pair, Scene};
use dcd_gjk::{EachPair, Gjk, NarrowPhase, Overlap, Undecided};
use dcd_parry::{Library, ParryShapes};
use dcd_pipeline::{Exec, Par, Pipeline, StageClock};
use std::time::{Duration, Instant};

/// What is to be run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    pub(super) rung: Rung,
    /// At least 1; 1 is serial.
    pub(super) threads: usize,
    /// At least 1.
    pub(super) repeats: u32,
}

/// What was found, and how long each step took.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// How many candidates there were.
    pub(super) pairs: usize,
    /// Sorted.
    pub(super) contacts: Vec<Pair>,
    pub(super) undecided: Vec<Undecided>,
    /// On Parry's rungs, how many shapes it refused: their pairs are undecided.
    pub(super) refused: Option<usize>,
    /// For each step the stages in their order, and last the whole.
    pub(super) times: Vec<[Duration; 5]>,
}

/// Runs the plan. What a narrow phase derives from the shapes alone is made before the first step.
pub(super) fn run(scene: &Scene, plan: Plan) -> Result<Found, Failure> {
    match plan.rung {
        Rung::Fast => on_threads(scene, EachPair(Gjk::<f32>::default()), plan),
        Rung::F64 => on_threads(scene, EachPair(Gjk::<f64>::default()), plan),
        Rung::Certified => on_threads(scene, Overlap::default(), plan),
        Rung::ParryF32 => with_parry::<f32>(scene, plan),
        Rung::ParryF64 => with_parry::<f64>(scene, plan),
    }
}

fn with_parry<R: Library>(scene: &Scene, plan: Plan) -> Result<Found, Failure> {
    let shapes = ParryShapes::<R>::new(scene);
    let refused = Some(shapes.refused().count());
    Ok(Found { refused, ..on_threads(scene, shapes, plan)? })
}

fn on_threads<N>(scene: &Scene, narrow: N, plan: Plan) -> Result<Found, Failure>
where
    N: NarrowPhase + Send,
{
    if plan.threads == 1 {
        return Ok(steps(scene, narrow, Par::Serial, plan.repeats));
    }
    with_threads(plan.threads, || steps(scene, narrow, Par::Pool, plan.repeats))
        .map_err(|error| Failure::at(format_args!("{} threads", plan.threads), error))
}

fn steps<N: NarrowPhase>(scene: &Scene, narrow: N, par: Par, repeats: u32) -> Found {
    let clock = StageClock::default();
    let mut pipeline = Pipeline::new(WideTree::default(), narrow);
    let mut found = Found::default();
    for _ in 0..repeats {
        let begun = Instant::now();
        let step = pipeline.step(scene, Exec::observed(par, &clock));
        let whole = begun.elapsed();
        let [boxes, build, pairs, narrow] = clock.take();
        found.times.push([boxes, build, pairs, narrow, whole]);
        if found.times.len() == repeats as usize {
            found.pairs = step.candidate_count();
            found.contacts = step.contacts().map(|(i, j)| Pair::new(i, j)).collect();
            found.undecided = step.report().undecided().to_vec();
        }
    }
    found.contacts.sort_unstable();
    found
}
