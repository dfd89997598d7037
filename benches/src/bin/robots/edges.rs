//! The straight edge of every problem: proved, beside samples at 1e-3 rad; its certificate, written and replayed.

use std::time::Duration;

use anyhow::{Result, ensure};
use dcd_benches::timing::time;
use dcd_exec::Par;
use dcd_judge::{Replay, Replayed};
use dcd_robot::{Edge, EdgeAnswer, EdgeChecker, JointPath, RobotError, StateChecker};
use serde::{Deserialize, Serialize};

use crate::data::{Geometry, Setting, on_the_way};

/// The most intervals of an edge.
pub(crate) const BUDGET: usize = 100_000;

/// How far a joint turns from sample to sample at most, rad.
const STEP: f64 = 1e-3;

/// How many samples are checked at once: those behind a hit in a batch are in vain.
const SAMPLES_AT_ONCE: usize = 128;

/// What was found and how long it took, of one geometry.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) geometry: String,
    pub(crate) groups: Vec<Group>,
    pub(crate) certificates: Certificates,
}

/// Edges with the same answer: times in microseconds.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Group {
    pub(crate) name: String,
    pub(crate) times: Vec<f64>,
    pub(crate) nodes: Vec<f64>,
    /// Of samples up to the first that touches.
    pub(crate) sampled: Vec<f64>,
    /// Edges on which samples find no contact.
    pub(crate) samples_free: usize,
}

/// Certificates of the free edges.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Certificates {
    pub(crate) accepted: usize,
    pub(crate) refused: Vec<String>,
    /// Milliseconds.
    pub(crate) written: Vec<f64>,
    pub(crate) replayed: Vec<f64>,
    pub(crate) planes: Vec<f64>,
    pub(crate) bytes: Vec<f64>,
}

pub(crate) fn run(geometry: Geometry, settings: &[Setting], rounds: usize) -> Result<Outcome> {
    let names = ["free", "hit, and free before it", "hit alone", "undecided"];
    let mut groups = names.map(|name| Group { name: name.to_owned(), ..Group::default() });
    let mut certificates = Certificates::default();
    let mut held: Option<(EdgeChecker, StateChecker)> = None;
    for setting in settings {
        let (checker, states) = match &mut held {
            Some(held) => {
                held.0.set_cell(setting.cell.clone());
                held.1.set_cell(setting.cell.clone())?;
                held
            }
            None => held.insert((
                EdgeChecker::new(setting.cell.clone()),
                StateChecker::new(setting.cell.clone())?,
            )),
        };
        let path = JointPath::Straight(setting.ends.clone());
        let samples = samples(&setting.ends);
        // The first of each prepares what the others find prepared.
        let (edge, (hit, _)) = (checker.check(&path, BUDGET)?, first(states, &samples)?);
        let (mut proved, mut by_samples, mut alone) = (Vec::new(), Vec::new(), Vec::new());
        let mut nodes_alone = 0;
        for _ in 0..rounds {
            let (spent, again) = time(|| checker.check(&path, BUDGET));
            ensure!(again? == edge, "two checks of an edge differ");
            proved.push(spent);
            by_samples.push(first(states, &samples)?.1);
            if let EdgeAnswer::Hit { .. } = edge.answer {
                let (spent, again) = time(|| checker.check_any(&path, BUDGET));
                nodes_alone = again?.nodes;
                alone.push(spent);
            }
        }
        let is_free = matches!(edge.answer, EdgeAnswer::Free { .. });
        ensure!(!(is_free && hit), "a sample of an edge that is proved free touches");
        let group = match edge.answer {
            EdgeAnswer::Free { .. } => 0,
            EdgeAnswer::Hit { .. } => 1,
            EdgeAnswer::Undecided { .. } => 3,
        };
        groups[group].add((proved, edge.nodes), (by_samples.clone(), hit));
        if group == 1 {
            groups[2].add((alone, nodes_alone), (by_samples, hit));
        }
        if let EdgeAnswer::Free { clearance } = edge.answer {
            certificates.add((checker, &path), (&edge, clearance))?;
        }
    }
    let geometry = geometry.name().to_owned();
    Ok(Outcome { geometry, groups: groups.to_vec(), certificates })
}

/// States at most [`STEP`] from each other in every joint.
fn samples(ends: &[Vec<f64>; 2]) -> Vec<Vec<f64>> {
    let turns = ends[0].iter().zip(&ends[1]).map(|(a, b)| (b - a).abs());
    let steps = (turns.fold(0.0, f64::max) / STEP).ceil();
    on_the_way(ends, steps as usize + 1)
}

/// Whether a sample touches, and the time until that was known.
fn first(checker: &StateChecker, samples: &[Vec<f64>]) -> Result<(bool, Duration), RobotError> {
    let (spent, hit) = time(|| {
        for batch in samples.chunks(SAMPLES_AT_ONCE) {
            if checker.first(batch, Par::Serial)?.iter().flatten().next().is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    });
    Ok((hit?, spent))
}

/// The median, microseconds.
fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    times.get(times.len() / 2).map_or(f64::NAN, |time| time.as_secs_f64() * 1e6)
}

impl Group {
    fn add(
        &mut self,
        (proved, nodes): (Vec<Duration>, usize),
        (sampled, hit): (Vec<Duration>, bool),
    ) {
        self.times.push(median(proved));
        self.nodes.push(nodes as f64);
        self.sampled.push(median(sampled));
        self.samples_free += usize::from(!hit);
    }
}

impl Certificates {
    fn add(
        &mut self,
        (checker, path): (&EdgeChecker, &JointPath),
        (edge, clearance): (&Edge, f64),
    ) -> Result<()> {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        // As the command does; each pair by itself takes more intervals than the edge.
        let budget = BUDGET.saturating_mul(16);
        let cell = checker.certificate_cell()?;
        let (spent, line) = time(|| {
            let certificate = checker.certificate(path, clearance, budget)?;
            Ok::<_, RobotError>(certificate.line(0))
        });
        let line = match line {
            Ok(line) => line,
            Err(error) => {
                self.refused.push(format!("{edge:?}: {error}"));
                return Ok(());
            }
        };
        self.written.push(ms(spent));
        self.bytes.push(line.len() as f64);
        let mut replay = Replay::default();
        replay.line(&cell).map_err(anyhow::Error::msg)?;
        let (spent, found) = time(|| replay.line(&line));
        self.replayed.push(ms(spent));
        match found.map_err(anyhow::Error::msg)? {
            Replayed::Accepted { planes, .. } => {
                self.accepted += 1;
                self.planes.push(planes as f64);
            }
            other => self.refused.push(format!("{edge:?}: {other:?}")),
        }
        Ok(())
    }
}
