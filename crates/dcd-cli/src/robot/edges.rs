//! Edges from a file, a line each, and a line of JSON for what is proved of them.

use super::lines::{CellCache, Given, Proof, Question, Refusal, Which, sorted_names};
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
--budget is a number of intervals of one edge, so that an answer does not depend on the machine. --certificate FILE writes
for each free edge the separating planes of every pair on intervals of t, JSON Lines: what the robot, its world and the pairs that
may touch are, before the first free edge, and the edges in order (docs/guide/certificates.md); the planes take up to 16 times the budget's intervals."#;

/// `--edges`: whether each is free.
pub(super) struct Edges {
    /// The most intervals of one edge.
    pub(super) budget: usize,
    /// Whether free edges are proved in a certificate.
    pub(super) certificates: Certificates,
}

/// What is asked of a free edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Certificates {
    None,
    Written,
}

/// How many times the budget's intervals planes may take: each pair is proved by itself, and by half of its gap.
const OF_PLANES: usize = 16;

/// A checker, and what a certificate says of its robot and world, once one is written.
pub(super) struct Kept {
    checker: EdgeChecker,
    cell: Option<Result<Arc<str>, String>>,
}

impl Kept {
    /// The proof of a free edge.
    fn proof(&mut self, edge: &EdgeRequest, clearance: f64, budget: usize) -> Proof {
        let checker = &self.checker;
        let made = || checker.certificate_cell().map(Arc::from).map_err(|e| e.to_string());
        let lines = self.cell.get_or_insert_with(made).clone().and_then(|cell| {
            let made = checker.certificate(&edge.path, clearance, budget.saturating_mul(OF_PLANES));
            Ok((cell, made.map_err(|e| e.to_string())?))
        });
        match lines {
            Ok((cell, certificate)) => Proof::Found { cell, certificate: Arc::new(certificate) },
            Err(error) => Proof::Missing { error },
        }
    }
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Answer {
    #[serde(flatten)]
    outcome: Outcome,
    free_until: f64,
    #[serde(skip)]
    proof: Proof,
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
    type Checker = CellCache<Kept>;
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
        checker: &mut CellCache<Kept>,
        edge: &EdgeRequest,
    ) -> Result<Answer, Refusal> {
        let made = |attached: &_| {
            let checker = given.cell(attached).map(EdgeChecker::new)?;
            Ok(Kept { checker, cell: None })
        };
        let kept = checker.of(&edge.attached, made)?;
        let checker = &kept.checker;
        let found = checker.check(&edge.path, self.budget)?;
        let named = |pair: [u32; 2]| sorted_names(checker.cell(), pair.into());
        let outcome = match found.answer {
            EdgeAnswer::Free { clearance } => Outcome::Free { clearance },
            EdgeAnswer::Hit { t, pair } => Outcome::Hit { t, pair: named(pair) },
            EdgeAnswer::Undecided { t, pair, reason } => {
                Outcome::Undecided { t, pair: named(pair), reason: reason.as_str() }
            }
        };
        let proof = match (&outcome, self.certificates) {
            (_, Certificates::None) => Proof::None,
            (Outcome::Free { clearance }, Certificates::Written) => {
                kept.proof(edge, *clearance, self.budget)
            }
            (Outcome::Hit { .. }, _) => Proof::NotFree("hit"),
            (Outcome::Undecided { .. }, _) => Proof::NotFree("undecided"),
        };
        Ok(Answer { outcome, free_until: found.free_until, proof })
    }

    fn proof(answer: &Answer) -> &Proof {
        &answer.proof
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
