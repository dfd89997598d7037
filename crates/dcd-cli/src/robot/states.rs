//! States from a file, a line each, and a line of JSON for what is found.

use super::refused;
use crate::failure::{Failure, tell};
use crate::progress::Progress;
use dcd_exec::{Exec, PerThread, Segments};
use dcd_io::{read_lines, shown};
use dcd_pipeline::{Par, Pipeline};
use dcd_robot::{
    AllowedPairs, AttachedObject, MeshSource, Robot, State, StateReader, Workcell, World,
};
use serde::Serialize;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufReader, IsTerminal, Write, stdout};
use std::path::Path;
use std::sync::Arc;

/// What `--states` reads and prints.
pub(super) const FORMAT: &str = r#"--states takes a state a line:
  {"q": {"joint": value, …}} or {"q": [values in the order of the moved joints]}
Joints that an object does not name are where the world has them, else at 0. With "attached" the robot carries more in that state, a list of
  {"name": "…", "link": "…", "touch": ["…"], "shape": …, "pose": {"xyz": [x, y, z], "q": [x, y, z, w]}}
with one of {"box": [x, y, z]} (edges), {"sphere": radius}, {"cylinder": [radius, length]} (round z) and {"mesh": "file"} (beside the file of states; taken as --links says), the pose in the link's frame. It may touch its link and what "touch" names. Other keys are refused, but for "name" and those that begin with an underscore; so is a line of more than 268,435,456 bytes. A line comes out for each, in order, the same at any number of threads:
  {"state": k, "free": true|false|null, "contacts": [["a", "b"], …], "undecided": [["a", "b"], …]}
k counts from 0; free is true only if every pair is proved apart, false if one is proved touching, else null; undecided is there where a pair is. A line that is no state comes out as {"state": k, "error": "line …"}, and the run goes on; the exit code is 2 then."#;

/// How many lines are read before they are checked, and how many a task checks.
const BLOCK: usize = 4096;
const PER_TASK: usize = 32;

/// What all states are about.
pub(super) struct Given<'a> {
    pub(super) robot: &'a Robot,
    pub(super) world: &'a World,
    pub(super) allowed: &'a AllowedPairs,
    pub(super) meshes: MeshSource,
}

/// What comes out for a line.
#[derive(Clone, Debug, Serialize)]
struct Line {
    state: usize,
    #[serde(flatten)]
    outcome: Outcome,
}

#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
enum Outcome {
    Checked {
        /// Only if every pair is proved apart; not if one is proved touching; else unknown.
        free: Option<bool>,
        contacts: BTreeSet<[String; 2]>,
        #[serde(skip_serializing_if = "BTreeSet::is_empty")]
        undecided: BTreeSet<[String; 2]>,
    },
    Refused {
        error: String,
    },
}

/// What a thread checks states with.
#[derive(Debug, Default)]
struct Checker {
    /// The robot with what it carries.
    cell: Option<(Arc<[AttachedObject]>, Workcell)>,
    pipeline: Pipeline,
}

/// Checks the states of a file and prints a line for each, in their order.
pub(super) fn check(given: &Given<'_>, path: &Path) -> Result<(), Failure> {
    let place = shown(path);
    let file = File::open(path).map_err(|error| Failure::at(&place, error))?;
    let defaults = given.robot.state(&given.world.joints).map_err(refused)?;
    let mut reader = StateReader::new(given.robot, defaults, given.meshes.clone());
    let mut out = stdout().lock();
    // Lines that are looked at are progress enough.
    let progress = (!out.is_terminal()).then(|| Progress::over(0, "states"));
    let mut lines = read_lines(BufReader::new(file));
    let (mut tally, checkers, mut answers) =
        (Tally::default(), PerThread::default(), Segments::default());
    loop {
        let mut block = Vec::new();
        for line in lines.by_ref().take(BLOCK) {
            let line = line.map_err(|error| Failure::at(&place, error))?;
            block.push(reader.read(&line).map_err(|error| error.to_string()));
        }
        if block.is_empty() {
            break;
        }
        tally.note_limits(given.robot, &block, &place);
        let exec = Exec::from(Par::Pool).serial_below(block.len(), 2 * PER_TASK);
        answers.fill(exec, block.len().div_ceil(PER_TASK), |task, answers| {
            checkers.with(|checker: &mut Checker| {
                let first = task * PER_TASK;
                for (k, state) in (first..).zip(&block[first..]).take(PER_TASK) {
                    let outcome = checker.outcome(given, state, tally.lines + k + 1);
                    answers.push(Line { state: tally.lines + k, outcome });
                    progress.iter().for_each(Progress::step);
                }
            });
        });
        for line in answers.iter().flatten() {
            if let Outcome::Refused { error } = &line.outcome {
                tell(format_args!("{place}: {error}"));
                tally.refused += 1;
            }
            serde_json::to_writer(&mut out, line).map_err(|error| Failure::Output(error.into()))?;
            out.write_all(b"\n").map_err(Failure::Output)?;
        }
        tally.lines += block.len();
    }
    drop(progress);
    tally.end(&place)
}

/// What is told of all lines together.
#[derive(Default)]
struct Tally {
    lines: usize,
    refused: usize,
    beyond: usize,
}

impl Tally {
    /// Tells of the first state that a planner would not go to, and counts all.
    fn note_limits(&mut self, robot: &Robot, block: &[Result<State, String>], place: &str) {
        for (k, state) in (self.lines..).zip(block) {
            let Ok(state) = state else { continue };
            let beyond = robot.beyond_limits(&state.values);
            if let (Some(first), 0) = (beyond.first(), self.beyond) {
                tell(format_args!("{place}: line {}: {first}", k + 1));
            }
            self.beyond += usize::from(!beyond.is_empty());
        }
    }

    fn end(self, place: &str) -> Result<(), Failure> {
        let Self { lines, refused, beyond } = self;
        if beyond > 1 {
            tell(format_args!("{place}: {beyond} of {lines} states are beyond limits"));
        }
        if refused > 0 {
            return Err(Failure::at(place, format_args!("{refused} of {lines} lines refused")));
        }
        if lines == 0 {
            return Err(Failure::at(place, "there is no state in it"));
        }
        Ok(())
    }
}

impl Checker {
    /// `line` is the state's, from 1.
    fn outcome(
        &mut self,
        given: &Given<'_>,
        state: &Result<State, String>,
        line: usize,
    ) -> Outcome {
        let checked = match state {
            Ok(state) => self.check(given, state).map_err(|error| error.to_string()),
            Err(error) => Err(error.clone()),
        };
        checked.unwrap_or_else(|error| Outcome::Refused { error: format!("line {line}: {error}") })
    }

    fn check(
        &mut self,
        given: &Given<'_>,
        state: &State,
    ) -> Result<Outcome, dcd_robot::RobotError> {
        let cell = match &mut self.cell {
            Some((attached, cell)) if Arc::ptr_eq(attached, &state.attached) => cell,
            other => {
                let cell = given.cell(&state.attached)?;
                &mut other.insert((Arc::clone(&state.attached), cell)).1
            }
        };
        cell.set_state(&state.values)?;
        let step = self.pipeline.step(cell.scene(), Par::Serial);
        let named = |pair| cell.names_of(pair).map(str::to_owned);
        let contacts: BTreeSet<_> = step.contacts().map(named).collect();
        let left = step.report().undecided().iter().map(|left| named(left.pair.into()));
        let undecided: BTreeSet<_> = left.filter(|pair| !contacts.contains(pair)).collect();
        let free = match (contacts.is_empty(), undecided.is_empty()) {
            (false, _) => Some(false),
            (true, true) => Some(true),
            (true, false) => None,
        };
        Ok(Outcome::Checked { free, contacts, undecided })
    }
}

impl Given<'_> {
    /// The robot in its world, with what a state says that it carries.
    fn cell(&self, attached: &[AttachedObject]) -> Result<Workcell, dcd_robot::RobotError> {
        let mut world = World { allowed: AllowedPairs::default(), ..self.world.clone() };
        for AttachedObject { object, touch } in attached {
            world.attach(object.clone(), touch);
        }
        // What an attached object may touch counts more than what is said of all states.
        let mut allowed = self.allowed.clone();
        allowed.extend(&world.allowed);
        Workcell::new(self.robot.clone(), &world, &allowed)
    }
}
