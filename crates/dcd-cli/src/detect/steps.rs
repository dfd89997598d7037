//! The steps at the chosen precision, with the time of each stage.

use super::question::{Answers, Query};
use crate::failure::Failure;
use crate::precision::Precision;
use crate::progress::Progress;
use crate::reported::{Report, Reported};
use crate::stepper::{Stepper, on_threads, stepper};
use dcd_geom::{Pair, Scene};
use dcd_gjk::Undecided;
use dcd_pipeline::{Exec, Par, StageClock};
use std::time::{Duration, Instant};

/// The run: how the scene is stepped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    pub(super) precision: Precision,
    pub(super) query: Query,
    /// At least 1; 1 is serial.
    pub(super) threads: usize,
    /// At least 1.
    pub(super) repeats: u32,
}

/// The results, and the time of each step.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// How many candidates there were.
    pub(super) pairs: usize,
    /// Sorted.
    pub(super) contacts: Vec<Pair>,
    /// The answer for each, in the same order, if it is kept.
    pub(super) reported: Vec<(Pair, Reported)>,
    /// The bound of each measure that has one.
    pub(super) error_bounds: Vec<f64>,
    pub(super) undecided: Vec<Undecided>,
    /// On Parry's precisions, how many shapes it refused: their pairs are undecided.
    pub(super) refused: Option<usize>,
    /// For each step the stages in their order, and last the whole.
    pub(super) times: Vec<[Duration; 5]>,
}

/// Runs the plan. What depends on the shapes alone is derived before the first step.
pub(super) fn run(scene: &Scene, plan: Plan) -> Result<Found, Failure> {
    let mut stepper = stepper(scene, plan.precision, plan.query.question())?;
    let found = on_threads(plan.threads, |par| steps(scene, &mut *stepper, par, plan))?;
    Ok(Found { refused: stepper.refused(), ..found })
}

fn steps(scene: &Scene, stepper: &mut dyn Stepper, par: Par, plan: Plan) -> Found {
    let clock = StageClock::default();
    let mut found = Found::default();
    let progress = Progress::over(plan.repeats.into(), "steps");
    for _ in 0..plan.repeats {
        let begun = Instant::now();
        let step = stepper.step(scene, Exec::observed(par, &clock));
        let whole = begun.elapsed();
        let [boxes, build, pairs, narrow] = clock.take();
        found.times.push([boxes, build, pairs, narrow, whole]);
        progress.step();
        if found.times.len() == plan.repeats as usize {
            found.pairs = step.candidate_count();
            found.contacts = step.contacts().map(|(i, j)| Pair::new(i, j)).collect();
            found.error_bounds =
                step.answers().filter_map(|(_, answer)| answer.error_bound()).collect();
            if plan.query.answers == Answers::Kept {
                found.reported =
                    step.answers().map(|(pair, answer)| (pair, answer.report())).collect();
            }
            found.undecided = step.report().undecided().to_vec();
        }
    }
    found.reported.sort_unstable_by_key(|(pair, _)| *pair);
    found.contacts.sort_unstable();
    found
}
