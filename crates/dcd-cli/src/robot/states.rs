//! States from a file, a line each, and a line of JSON for what is found.

use super::lines::{CellCache, Given, Question, Refusal, Which, sorted_names};
use super::picture::Picture;
use dcd_geom::Polytope;
use dcd_pipeline::{Par, Pipeline};
use dcd_robot::{
    AttachedObject, Clearance, Robot, RobotError, State, StateChecker, StateReader, Workcell,
};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::slice;
use std::sync::Arc;

/// What `--states` reads and prints.
pub(super) const FORMAT: &str = r#"--states takes a state a line:
  {"q": {"joint": value, …}} or {"q": [values in the order of the moved joints]}
Joints that an object does not name are where the world has them, else at 0. With "attached" the robot carries more in that state, a list of
  {"name": "…", "link": "…", "touch": ["…"], "shape": …, "pose": {"xyz": [x, y, z], "q": [x, y, z, w]}}
with one of {"box": [x, y, z]} (edges), {"sphere": radius}, {"cylinder": [radius, length]} (round z) and {"mesh": "file"} (beside the file of states; its hull, or with --links meshes its triangles), the pose in the link's frame. It may touch its link and what "touch" names. Other keys are refused, but for "name" and those that begin with an underscore. A line of more than 268,435,456 bytes ends the run, after the answers to those before it. A line comes out for each, in order, the same at any number of threads:
  {"state": k, "free": true|false|null, "contacts": [["a", "b"], …], "undecided": [["a", "b"], …]}
k counts from 0; each pair of contacts and of undecided is there once, its names and the pairs sorted; free is true only if every pair is proved apart, false if one is proved touching, else null; undecided is there where a pair is. With --clearance there is also
  "clearance": {"distance": metres, "error_bound": …, "pair": ["a", "b"], "normal": [..], "point_a": [..], "point_b": [..], "gradient": {"joint": …, …}}
the least signed distance of all pairs that are checked (below 0: how deep they overlap), the bound that holds for it, points and normal (from a to b) in the world, and its derivative by each value of a state; null where there is no pair, {"error": …} where one is not known. A line that is no state comes out as {"state": k, "error": "line …"}, and the run goes on; the exit code is 2 then."#;

/// `--states`: which links touch in each.
pub(super) struct States {
    /// Whether the least signed distance is measured too.
    pub(super) clearance: bool,
}

/// What a thread checks states with.
#[derive(Debug, Default)]
pub(super) struct Checker {
    cell: CellCache<Kept>,
    pipeline: Pipeline,
}

/// How many lines in a row carry the same before a robot of spheres and what it carries are prepared for many states.
/// Larger: short files are slower. Smaller: files that carry something else from time to time are. No effect on any
/// answer.
const PREPARED_AFTER: usize = 64;

/// What is kept while lines carry the same.
#[derive(Debug)]
struct Kept {
    cell: Workcell,
    /// How many lines have been answered with it.
    lines: usize,
    /// None before [`PREPARED_AFTER`], nor where a part is no sphere: lines of hulls and meshes take as long without, and
    /// covering them with spheres takes as long as some thousand lines.
    states: Option<StateChecker>,
}

impl Kept {
    fn of(cell: Workcell) -> Self {
        Self { cell, lines: 0, states: None }
    }

    /// Whether all that moves is spheres.
    fn is_of_spheres(&self) -> bool {
        let is_point = |polytope: &Polytope| polytope.vertices().len() == 1;
        let mut parts = self.cell.robot().parts().iter();
        parts.all(|part| part.shape.as_polytope().is_some_and(is_point))
    }

    /// The pairs of a state, which the cell is in, that touch, and those that are undecided and of no such name.
    fn found(&mut self, values: &[f64], pipeline: &mut Pipeline) -> [BTreeSet<[String; 2]>; 2] {
        self.lines += 1;
        if self.lines == PREPARED_AFTER && self.is_of_spheres() {
            self.states = StateChecker::new(self.cell.clone()).ok();
        }
        let named = |pair| sorted_names(&self.cell, pair);
        let all = self.states.as_ref().and_then(|states| states.all(&[values], Par::Serial).ok());
        let [contacts, undecided]: [BTreeSet<_>; 2] = match all {
            Some(hits) => {
                let of = |touching: bool| {
                    let hits = hits.iter().filter(move |hit| hit.touches() == touching);
                    hits.map(|hit| named(hit.pair.into())).collect()
                };
                [of(true), of(false)]
            }
            // Also what the checker refuses and the cell does not.
            None => {
                let step = pipeline.step(self.cell.scene(), Par::Serial);
                let left = step.report().undecided().iter();
                let left = left.map(|left| named(left.pair.into())).collect();
                [step.contacts().map(named).collect(), left]
            }
        };
        let left = undecided.into_iter().filter(|pair| !contacts.contains(pair)).collect();
        [contacts, left]
    }
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Answer {
    /// Only if every pair is proved apart; not if one is proved touching; else unknown.
    free: Option<bool>,
    contacts: BTreeSet<[String; 2]>,
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    undecided: BTreeSet<[String; 2]>,
    /// Only on request.
    #[serde(skip_serializing_if = "Option::is_none")]
    clearance: Option<Measured>,
}

/// The least signed distance, if there is a pair and it is known.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
enum Measured {
    Known(Option<Nearest>),
    Unknown { error: String },
}

/// The least signed distance of a state.
#[derive(Clone, Debug, Serialize)]
struct Nearest {
    distance: f64,
    error_bound: f64,
    pair: [String; 2],
    normal: [f64; 3],
    point_a: [f64; 3],
    point_b: [f64; 3],
    /// By each variable, by its name.
    gradient: BTreeMap<String, f64>,
}

impl Nearest {
    fn of(cell: &Workcell, clearance: &Clearance) -> Self {
        let &Clearance { objects: [a, b], proximity, ref gradient } = clearance;
        let variables = cell.robot().variables().iter().cloned();
        Self {
            distance: proximity.signed_distance,
            error_bound: proximity.error_bound,
            pair: cell.names_of((a, b)).map(str::to_owned),
            normal: proximity.normal.to_array(),
            point_a: proximity.point_a.to_array(),
            point_b: proximity.point_b.to_array(),
            gradient: variables.zip(gradient.iter().copied()).collect(),
        }
    }
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
    ) -> Result<Answer, Refusal> {
        let Checker { cell, pipeline } = checker;
        let kept = cell.of(&state.attached, |attached| given.cell(attached).map(Kept::of))?;
        // Refuses what no cell may be in.
        kept.cell.set_state(&state.values)?;
        let [contacts, undecided] = kept.found(&state.values, pipeline);
        let free = match (contacts.is_empty(), undecided.is_empty()) {
            (false, _) => Some(false),
            (true, true) => Some(true),
            (true, false) => None,
        };
        let clearance = if self.clearance {
            // What is proved of contacts stands, whatever is known of distances.
            Some(match kept.cell.clearance(&state.values) {
                Ok(nearest) => {
                    Measured::Known(nearest.map(|found| Nearest::of(&kept.cell, &found)))
                }
                Err(error) => Measured::Unknown { error: error.to_string() },
            })
        } else {
            None
        };
        Ok(Answer { free, contacts, undecided, clearance })
    }

    fn attached(state: &State) -> &Arc<[AttachedObject]> {
        &state.attached
    }

    fn draw(_: &Robot, state: &State, _: &Answer, picture: &mut Picture) {
        picture.show(&state.values);
    }
}
