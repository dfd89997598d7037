//! States from a file, a line each, and a line of JSON for what is found.

use super::lines::{CellCache, Given, Question, Which};
use dcd_pipeline::{Par, Pipeline};
use dcd_robot::{RobotError, State, StateReader, Workcell};
use serde::Serialize;
use std::collections::BTreeSet;
use std::slice;

/// What `--states` reads and prints.
pub(super) const FORMAT: &str = r#"--states takes a state a line:
  {"q": {"joint": value, …}} or {"q": [values in the order of the moved joints]}
Joints that an object does not name are where the world has them, else at 0. With "attached" the robot carries more in that state, a list of
  {"name": "…", "link": "…", "touch": ["…"], "shape": …, "pose": {"xyz": [x, y, z], "q": [x, y, z, w]}}
with one of {"box": [x, y, z]} (edges), {"sphere": radius}, {"cylinder": [radius, length]} (round z) and {"mesh": "file"} (beside the file of states; taken as --links says), the pose in the link's frame. It may touch its link and what "touch" names. Other keys are refused, but for "name" and those that begin with an underscore; so is a line of more than 268,435,456 bytes. A line comes out for each, in order, the same at any number of threads:
  {"state": k, "free": true|false|null, "contacts": [["a", "b"], …], "undecided": [["a", "b"], …]}
k counts from 0; free is true only if every pair is proved apart, false if one is proved touching, else null; undecided is there where a pair is. A line that is no state comes out as {"state": k, "error": "line …"}, and the run goes on; the exit code is 2 then."#;

/// `--states`: which links touch in each.
pub(super) struct States;

/// What a thread checks states with.
#[derive(Debug, Default)]
pub(super) struct Checker {
    cell: CellCache<Workcell>,
    pipeline: Pipeline,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Answer {
    /// Only if every pair is proved apart; not if one is proved touching; else unknown.
    free: Option<bool>,
    contacts: BTreeSet<[String; 2]>,
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    undecided: BTreeSet<[String; 2]>,
}

impl Question for States {
    type Item = State;
    type Checker = Checker;
    type Answer = Answer;
    const PLURAL: &'static str = "states";
    const PER_TASK: usize = 32;

    fn which(index: usize) -> Which {
        Which::State(index)
    }

    fn read(reader: &mut StateReader<'_>, line: &[u8]) -> Result<State, RobotError> {
        reader.read(line)
    }

    fn states(state: &State) -> &[Vec<f64>] {
        slice::from_ref(&state.values)
    }

    fn check(
        &self,
        given: &Given<'_>,
        checker: &mut Checker,
        state: &State,
    ) -> Result<Answer, RobotError> {
        let cell = checker.cell.of(&state.attached, |attached| given.cell(attached))?;
        cell.set_state(&state.values)?;
        let step = checker.pipeline.step(cell.scene(), Par::Serial);
        let named = |pair| cell.names_of(pair).map(str::to_owned);
        let contacts: BTreeSet<_> = step.contacts().map(named).collect();
        let left = step.report().undecided().iter().map(|left| named(left.pair.into()));
        let undecided: BTreeSet<_> = left.filter(|pair| !contacts.contains(pair)).collect();
        let free = match (contacts.is_empty(), undecided.is_empty()) {
            (false, _) => Some(false),
            (true, true) => Some(true),
            (true, false) => None,
        };
        Ok(Answer { free, contacts, undecided })
    }
}
