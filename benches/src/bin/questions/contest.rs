//! Our step and Parry's queries of the same pairs and its step, interleaved, and a check of our answers.

use std::collections::HashMap;

use anyhow::{Result, anyhow, ensure};
use dcd_benches::Effort;
use dcd_benches::timing::{Pair as Times, pairs_of, time};
use dcd_broad::WideTree;
use dcd_geom::{Pair, Scene};
use dcd_gjk::Accuracy;
use dcd_gjk::Within;
use dcd_pipeline::{Answer, AnyPipeline, Exec, Par, Pipeline, Precision, Question, StageClock};
use serde::{Deserialize, Serialize};

use crate::parry::Parry;
use crate::subject::Subject;

/// Distances are reported of pairs within that many metres.
pub(crate) const MARGIN: f64 = 0.1;

/// The kind of query.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Kind {
    Distance,
    Depth,
    Manifold,
    /// Yes or no, proved.
    Overlap,
}

impl Kind {
    pub(crate) const ALL: [Self; 4] = [Self::Overlap, Self::Distance, Self::Depth, Self::Manifold];
    /// Of bodies that nearly all touch.
    pub(crate) const TOUCHING: [Self; 3] = [Self::Overlap, Self::Depth, Self::Manifold];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Distance => "distance",
            Self::Depth => "depth",
            Self::Manifold => "manifold",
            Self::Overlap => "overlap",
        }
    }

    fn question(self, accuracy: Accuracy) -> Question {
        match self {
            Self::Distance => Question::Distance { accuracy, margin: MARGIN },
            Self::Depth => Question::Depth { accuracy },
            Self::Manifold => Question::Manifold { accuracy, options: Default::default() },
            Self::Overlap => Question::Overlap { precision: Precision::Certified, margin: 0.0 },
        }
    }

    fn margin(self) -> f64 {
        if self == Self::Distance { MARGIN } else { 0.0 }
    }
}

/// Names of accuracies, certified first: the others are checked against it.
pub(crate) const ACCURACIES: [(&str, Accuracy); 3] =
    [("certified", Accuracy::Certified), ("f64", Accuracy::F64), ("f32", Accuracy::F32)];

/// One query at one accuracy.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Measurement {
    pub(crate) kind: Kind,
    pub(crate) accuracy: String,
    pub(crate) candidates: usize,
    /// Pairs that touch, or are within the margin.
    pub(crate) found: usize,
    /// The pairs that Parry finds.
    pub(crate) parry_found: usize,
    /// The bounds of what is measured, metres: 99 of 100 are below it, and all below the worst.
    pub(crate) p99: f64,
    pub(crate) worst: f64,
    /// Answers that contradict the certified ones.
    pub(crate) beyond: usize,
    pub(crate) races: Vec<Race>,
}

/// The times at a number of threads.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Race {
    pub(crate) threads: usize,
    /// Our narrow phase and Parry's queries alone.
    pub(crate) narrow: Times,
    /// Both whole steps.
    pub(crate) whole: Times,
    /// Our whole step and Parry's queries.
    pub(crate) mixed: Times,
}

/// A scene's.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) scene: String,
    pub(crate) objects: usize,
    pub(crate) measurements: Vec<Measurement>,
}

/// What was measured of a pair: a value and its bound; none where there is nothing to measure.
type Measured = Option<[f64; 2]>;

/// What is asked of a scene, at those numbers of threads; yes or no has no accuracy.
pub(crate) fn run_scene(subject: &Subject, threads: &[usize], effort: Effort) -> Result<Outcome> {
    let scene = &subject.scene()?;
    let mut measurements = Vec::new();
    for &kind in subject.kinds() {
        let pairs = candidates(scene, kind.margin())?;
        let mut parry = Parry::new(scene, &pairs, kind.margin())?;
        let parry_found = [parry.count(kind, Par::Serial), parry.step(kind, Par::Serial)];
        let mut certified = HashMap::new();
        let count = if kind == Kind::Overlap { 1 } else { ACCURACIES.len() };
        for &(name, accuracy) in &ACCURACIES[..count] {
            let mut pipeline = AnyPipeline::new(kind.question(accuracy))?;
            let found = measured(&mut pipeline, scene);
            if accuracy == Accuracy::Certified {
                certified.extend(found.iter().copied());
            }
            let is_beyond = |(pair, found): &&(Pair, Measured)| {
                certified.get(pair).is_none_or(|truth| !agree(*found, *truth))
            };
            let beyond = found.iter().filter(is_beyond).count();
            let missing = certified.len().abs_diff(found.len());
            let mut bounds: Vec<f64> = found.iter().filter_map(|f| f.1).map(|[_, b]| b).collect();
            bounds.sort_unstable_by(f64::total_cmp);
            let at = |part: usize| bounds.get(bounds.len() * part / 100).copied();
            let mut race = |&threads: &usize| {
                let ours = (&mut pipeline, scene, found.len());
                race(ours, (&mut parry, kind, parry_found), threads, effort)
            };
            let races = threads.iter().map(&mut race).collect::<Result<_>>()?;
            measurements.push(Measurement {
                kind,
                accuracy: name.to_owned(),
                candidates: pairs.len(),
                found: found.len(),
                parry_found: parry_found[0],
                p99: at(99).unwrap_or(0.0),
                worst: bounds.last().copied().unwrap_or(0.0),
                beyond: beyond + missing,
                races,
            });
        }
    }
    Ok(Outcome { scene: subject.name().to_owned(), objects: scene.len(), measurements })
}

/// The times on so many threads. Whoever finds another number of pairs than before has no time.
fn race(
    ours: (&mut AnyPipeline, &Scene, usize),
    parry: (&mut Parry, Kind, [usize; 2]),
    threads: usize,
    effort: Effort,
) -> Result<Race> {
    let rounds = if effort == Effort::Quick { 1 } else { 7 };
    let [narrow, whole, mixed] = match threads {
        1 => race_here(ours, parry, Par::Serial, rounds)?,
        // Fewer rounds: what they are beside is the same question on one thread.
        _ => {
            let race = || race_here(ours, parry, Par::WarmPool, rounds.min(3));
            dcd_exec::with_threads(threads, race).map_err(|error| anyhow!(error))??
        }
    };
    Ok(Race { threads, narrow, whole, mixed })
}

fn race_here(
    (pipeline, scene, found): (&mut AnyPipeline, &Scene, usize),
    (parry, kind, parry_found): (&mut Parry, Kind, [usize; 2]),
    par: Par,
    rounds: u32,
) -> Result<[Times; 3]> {
    let clock = StageClock::default();
    let (mut strayed, mut parry_strayed) = (false, false);
    let mut ours = || {
        let observed = Exec::observed(par, &clock);
        let (whole, count) = time(|| pipeline.step(scene, observed).contact_count());
        strayed |= count != found;
        let [.., narrow] = clock.take();
        [narrow, whole, whole]
    };
    let mut theirs = || {
        let (queries, alone) = time(|| parry.count(kind, par));
        let (whole, stepped) = time(|| parry.step(kind, par));
        parry_strayed |= [alone, stepped] != parry_found;
        [queries, whole, queries]
    };
    let times = pairs_of(rounds, &mut ours, &mut theirs);
    ensure!(!strayed, "our answers changed from step to step");
    ensure!(!parry_strayed, "Parry's answers changed from step to step");
    Ok(times)
}

/// The pairs whose boxes, each grown by half the margin, meet.
fn candidates(scene: &Scene, margin: f64) -> Result<Vec<Pair>> {
    let mut pipeline = Pipeline::with(WideTree::default(), Within::margin(margin)?);
    let step = pipeline.step(scene, Par::Serial);
    Ok(step.candidates().collect())
}

fn measured(pipeline: &mut AnyPipeline, scene: &Scene) -> Vec<(Pair, Measured)> {
    let step = pipeline.step(scene, Par::Serial);
    let answers = step.answers().map(|(pair, answer)| {
        let measured = match answer {
            Answer::Distance(distance) => distance.map(|d| [d.distance, d.error_bound]),
            Answer::Depth(depth) => Some([depth.depth, depth.error_bound]),
            // Its points have no one number to be compared by.
            _ => None,
        };
        (pair, measured)
    });
    answers.collect()
}

/// Whether two measures with their bounds may be of one truth.
fn agree(found: Measured, truth: Measured) -> bool {
    match (found, truth) {
        (Some([x, of_x]), Some([y, of_y])) => (x - y).abs() <= (of_x + of_y) * (1.0 + 1e-12),
        (found, truth) => found.is_some() == truth.is_some(),
    }
}
