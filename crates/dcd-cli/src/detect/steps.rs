//! The steps themselves, on the precision asked for, with the time of each stage.

use super::ask::{Answers, Query, Question};
use crate::failure::Failure;
use crate::precision::Precision;
use crate::progress::Progress;
use crate::reported::{Report, Reported};
use dcd_broad::WideTree;
use dcd_exec::with_threads;
use dcd_geom::{Pair, Scene};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{
    Depths, Distances, Gjk, Manifolds, NarrowPhase, Overlap, OverlapUnchecked, Pairwise,
    Proximities, ThenMeasure, Undecided, WithAccuracy, Within,
};
use dcd_parry::{Library, ParryShapes};
use dcd_pipeline::{Exec, Par, Pipeline, StageClock};
use std::time::{Duration, Instant};

/// What is to be run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    pub(super) precision: Precision,
    pub(super) query: Query,
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
    /// What was told of each, in the same order, if it is kept.
    pub(super) reported: Vec<(Pair, Reported)>,
    /// The bound of each measure that has one.
    pub(super) error_bounds: Vec<f64>,
    pub(super) undecided: Vec<Undecided>,
    /// On Parry's precisions, how many shapes it refused: their pairs are undecided.
    pub(super) refused: Option<usize>,
    /// For each step the stages in their order, and last the whole.
    pub(super) times: Vec<[Duration; 5]>,
}

/// Runs the plan. What a narrow phase derives from the shapes alone is made before the first step.
pub(super) fn run(scene: &Scene, plan: Plan) -> Result<Found, Failure> {
    match plan.precision {
        Precision::Fast => ours(scene, OverlapUnchecked::default(), plan),
        Precision::F64 => ours(scene, Pairwise(Gjk::<f64>::default()), plan),
        Precision::Certified => ours(scene, Overlap::default(), plan),
        Precision::ParryF32 => with_parry::<f32>(scene, plan),
        Precision::ParryF64 => with_parry::<f64>(scene, plan),
    }
}

/// That narrow phase, and what else is asked of the pairs that it finds.
fn ours<N>(scene: &Scene, narrow: N, plan: Plan) -> Result<Found, Failure>
where
    N: NarrowPhase<Answer = ()> + Send,
{
    let Query { question, margin, .. } = plan.query;
    let refused = |error| Failure::at("--margin", error);
    match question {
        Question::Overlap => on_threads(scene, Within::by(narrow, margin).map_err(refused)?, plan),
        Question::Distance => {
            after(scene, narrow, Distances::within(margin).map_err(refused)?, plan)
        }
        Question::Gradient => {
            after(scene, narrow, Proximities::within(margin).map_err(refused)?, plan)
        }
        Question::Depth => after(scene, narrow, Depths, plan),
        Question::Manifold => after(scene, narrow, Manifolds, plan),
    }
}

fn after<N, S>(scene: &Scene, narrow: N, solver: S, plan: Plan) -> Result<Found, Failure>
where
    N: NarrowPhase + Send,
    S: MeasureAt<Answer: Report> + Send + 'static,
{
    let solver = WithAccuracy::new(solver, plan.query.accuracy.into());
    let narrow = ThenMeasure::after(narrow, solver);
    on_threads(scene, narrow.map_err(|error| Failure::at("--margin", error))?, plan)
}

fn with_parry<R: Library>(scene: &Scene, plan: Plan) -> Result<Found, Failure> {
    let shapes = ParryShapes::<R>::new(scene);
    let refused = Some(shapes.refused().count());
    Ok(Found { refused, ..on_threads(scene, shapes, plan)? })
}

fn on_threads<N>(scene: &Scene, narrow: N, plan: Plan) -> Result<Found, Failure>
where
    N: NarrowPhase<Answer: Report> + Send,
{
    if plan.threads == 1 {
        return Ok(steps(scene, narrow, Par::Serial, plan));
    }
    with_threads(plan.threads, || steps(scene, narrow, Par::WarmPool, plan))
        .map_err(|error| Failure::at(format_args!("{} threads", plan.threads), error))
}

fn steps<N: NarrowPhase<Answer: Report>>(scene: &Scene, narrow: N, par: Par, plan: Plan) -> Found {
    let clock = StageClock::default();
    let mut pipeline = Pipeline::with(WideTree::default(), narrow);
    let mut found = Found::default();
    let progress = Progress::over(plan.repeats.into(), "steps");
    for _ in 0..plan.repeats {
        let begun = Instant::now();
        let step = pipeline.step(scene, Exec::observed(par, &clock));
        let whole = begun.elapsed();
        let [boxes, build, pairs, narrow] = clock.take();
        found.times.push([boxes, build, pairs, narrow, whole]);
        progress.step();
        if found.times.len() == plan.repeats as usize {
            found.pairs = step.candidate_count();
            found.contacts = step.contacts().map(|(i, j)| Pair::new(i, j)).collect();
            found.error_bounds = step.answers().filter_map(|c| c.answer.error_bound()).collect();
            if plan.query.answers == Answers::Kept {
                found.reported = step.answers().map(|c| (c.pair, c.answer.tell())).collect();
            }
            found.undecided = step.report().undecided().to_vec();
        }
    }
    found.reported.sort_unstable_by_key(|(pair, _)| *pair);
    found.contacts.sort_unstable();
    found
}
