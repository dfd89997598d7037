//! Edges from a file, a line each, and a line of JSON for what is proved of them.

use super::lines::{CellCache, Given, Question, Which};
use super::picture::Picture;
use dcd_robot::{
    AttachedObject, EdgeAnswer, EdgeChecker, EdgeRequest, Robot, RobotError, StateReader,
};
use serde::Serialize;
use std::sync::Arc;

/// What `--edges` reads and prints.
pub(super) const FORMAT: &str = r#"--edges takes an edge a line, between states as --states has them:
  {"from": q, "to": q}, straight in joint space, or {"control": [q0, q1, q2, q3]}, a cubic Bézier curve
with "attached" as above. Continuous joints turn as the numbers say, never the short way round. A line comes out for each, in order, the same at any number of threads, with "free_until": t, up to which all of it is proved free (t from 0 to 1), and
  {"edge": k, "answer": "free", "clearance": metres, …}: no configuration on it comes nearer to anything than that, proved; null where there is nothing to meet
  {"edge": k, "answer": "hit", "t": t, "pair": ["a", "b"], …}: the configuration at t touches, proved
  {"edge": k, "answer": "undecided", "t": [lo, hi], "pair": ["a", "b"], "reason": "…", …}: the first interval that is neither
--budget is a number of intervals of one edge, so that an answer does not depend on the machine."#;

/// `--edges`: whether each is free.
pub(super) struct Edges {
    /// The most intervals of one edge.
    pub(super) budget: usize,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Answer {
    #[serde(flatten)]
    outcome: Outcome,
    free_until: f64,
}

#[derive(Clone, Debug, Serialize)]
#[serde(tag = "answer", rename_all = "lowercase")]
enum Outcome {
    // An infinite number is null in JSON.
    Free { clearance: f64 },
    Hit { t: f64, pair: [String; 2] },
    Undecided { t: [f64; 2], pair: [String; 2], reason: &'static str },
}

impl Question for Edges {
    type Item = EdgeRequest;
    type Checker = CellCache<EdgeChecker>;
    type Answer = Answer;
    const PLURAL: &'static str = "edges";
    const PER_TASK: usize = 1;

    fn which(index: usize) -> Which {
        Which::Edge(index)
    }

    fn read(reader: &mut StateReader<'_>, line: &[u8]) -> Result<EdgeRequest, RobotError> {
        reader.read_edge(line)
    }

    fn states(edge: &EdgeRequest) -> &[Vec<f64>] {
        edge.path.control_points()
    }

    fn check(
        &self,
        given: &Given<'_>,
        checker: &mut CellCache<EdgeChecker>,
        edge: &EdgeRequest,
    ) -> Result<Answer, RobotError> {
        let made = |attached: &_| given.cell(attached).map(EdgeChecker::new);
        let checker = checker.of(&edge.attached, made)?;
        let found = checker.check(&edge.path, self.budget)?;
        let named = |pair: [u32; 2]| {
            let mut names = checker.cell().names_of(pair.into()).map(str::to_owned);
            names.sort();
            names
        };
        let outcome = match found.answer {
            EdgeAnswer::Free { clearance } => Outcome::Free { clearance },
            EdgeAnswer::Hit { t, pair } => Outcome::Hit { t, pair: named(pair) },
            EdgeAnswer::Undecided { t, pair, reason } => {
                Outcome::Undecided { t, pair: named(pair), reason: reason.as_str() }
            }
        };
        Ok(Answer { outcome, free_until: found.free_until })
    }

    fn attached(edge: &EdgeRequest) -> &Arc<[AttachedObject]> {
        &edge.attached
    }

    fn draw(robot: &Robot, edge: &EdgeRequest, answer: &Answer, picture: &mut Picture) {
        let hit = match &answer.outcome {
            Outcome::Hit { t, .. } => Some(*t),
            _ => None,
        };
        picture.follow(robot, &edge.path, hit);
    }
}
