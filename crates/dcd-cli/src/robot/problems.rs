//! Every problem of an archive, checked by us and by Parry.

use super::geometry::Geometry;
use super::judge::{Judged, judge_pair};
use super::refused;
use crate::failure::{Failure, print_message};
use crate::progress::Progress;
use dcd_geom::{Pair, Pose};
use dcd_io::shown;
use dcd_parry::{ParryRobot, Until};
use dcd_pipeline::Par;
use dcd_robot::{AllowedPairs, Problem, Robot, Srdf, StateChecker, Workcell, read_problems};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

/// States on the way from start to goal, both among them.
const STATES: usize = 100;

/// The most shapes of a robot: all of its pairs are listed for each problem.
const SHAPES: usize = 4096;

/// What all problems have in common.
pub(super) struct Given<'a> {
    pub(super) robot: &'a Robot,
    pub(super) srdf: Option<&'a Srdf>,
    pub(super) allowed: AllowedPairs,
    pub(super) geometry: Geometry,
}

/// The results of all problems.
#[derive(Debug, Default, Serialize)]
pub(super) struct Checked {
    #[serde(flatten)]
    geometry: Geometry,
    problems: usize,
    states: usize,
    /// States in which something touches.
    in_contact: usize,
    /// States of which the search for one hit finds one.
    first_hits: usize,
    starts_in_contact: usize,
    goals_in_contact: usize,
    /// Touching pairs, over all states.
    contacts: usize,
    undecided: usize,
    parry_contacts: usize,
    /// Pairs that Parry left undecided.
    parry_undecided: usize,
    differences: Vec<Difference>,
    #[serde(flatten)]
    times: Times,
    sets: Vec<Set>,
}

/// Milliseconds of one thread.
#[derive(Debug, Default, Serialize)]
struct Times {
    /// Of where the links are, from joint values: measured by itself, and taken off the two below.
    ms_kinematics: f64,
    /// Of worlds and robots, once a problem.
    ms_preparation: f64,
    /// Of all hits.
    ms: f64,
    /// Of a first hit of each state.
    ms_first: f64,
    parry_ms: f64,
    parry_ms_first: f64,
    /// Parry's check alone over our kinematics, preparation and check: all hits.
    ratio: f64,
    /// The same for first hits.
    ratio_first: f64,
}

/// The time of each part, of all problems.
#[derive(Default)]
struct Spent {
    kinematics: Duration,
    preparation: Duration,
    all: Duration,
    first: Duration,
    parry_all: Duration,
    parry_first: Duration,
}

impl Spent {
    fn times(&self) -> Times {
        let ms = |spent: Duration| spent.as_secs_f64() * 1e3;
        let before = ms(self.kinematics) + ms(self.preparation);
        Times {
            ms_kinematics: ms(self.kinematics),
            ms_preparation: ms(self.preparation),
            ms: ms(self.all),
            ms_first: ms(self.first),
            parry_ms: ms(self.parry_all),
            parry_ms_first: ms(self.parry_first),
            ratio: ms(self.parry_all) / (before + ms(self.all)),
            ratio_first: ms(self.parry_first) / (before + ms(self.first)),
        }
    }
}

/// The problems of one folder.
#[derive(Debug, Default, Serialize)]
struct Set {
    name: String,
    problems: usize,
    in_contact: usize,
    starts_in_contact: usize,
    goals_in_contact: usize,
    contacts: usize,
}

/// A pair on which Parry in f64 and we differ.
#[derive(Debug, Serialize)]
struct Difference {
    set: String,
    number: String,
    /// From 0, the start, to 99, the goal.
    state: usize,
    pair: [String; 2],
    we_say: &'static str,
    #[serde(flatten)]
    judged: Judged,
}

/// What one problem leaves to the next.
#[derive(Default)]
struct Runner {
    /// State by state.
    batch: Vec<Vec<Pair>>,
    ours: Vec<Pair>,
    theirs: Vec<Pair>,
    spent: Spent,
    /// In how many states the search for a first hit found one.
    first_hits: usize,
    /// Of the problem before.
    checker: Option<StateChecker>,
    /// What the files say that is not used, and in how many problems.
    notes: BTreeMap<String, usize>,
}

/// Reads and checks the archive.
pub(super) fn check(given: &Given<'_>, archive: &Path) -> Result<Checked, Failure> {
    let shapes = given.robot.parts().len();
    if shapes > SHAPES {
        let message = format!("--all-problems: {shapes} shapes of the robot, more than {SHAPES}");
        return Err(Failure::Input(message));
    }
    let problems = read_problems(archive).map_err(refused)?;
    let mut checked = Checked { geometry: given.geometry.clone(), ..Checked::default() };
    let mut runner = Runner::default();
    let progress = Progress::over(problems.len() as u64, "problems");
    for problem in &problems {
        progress.step();
        let place = || format!("{}: {}/{}", shown(archive), problem.set, problem.number);
        checked.add(given, problem, &mut runner).map_err(|e| match e {
            Failure::Input(message) => Failure::at(place(), message),
            other => other,
        })?;
    }
    for (note, count) in &runner.notes {
        print_message(format_args!("{}: in {count} problems: {note}", shown(archive)));
    }
    checked.times = runner.spent.times();
    checked.first_hits = runner.first_hits;
    Ok(checked)
}

/// The point at `state` of [`STATES`] on the line between two states; the ends bit for bit.
fn on_the_way(start: &[f64], goal: &[f64], state: usize) -> Vec<f64> {
    let part = state as f64 / (STATES - 1) as f64;
    start.iter().zip(goal).map(|(a, b)| a * (1.0 - part) + b * part).collect()
}

impl Checked {
    fn add(
        &mut self,
        given: &Given<'_>,
        problem: &Problem,
        runner: &mut Runner,
    ) -> Result<(), Failure> {
        let Given { robot, srdf, allowed, .. } = given;
        let mut world = problem.scene.world(robot, *srdf).map_err(refused)?;
        problem.request.place_base(&mut world, robot, *srdf).map_err(refused)?;
        let mut allowed = allowed.clone();
        allowed.extend(&world.allowed);
        let start = problem.request.start_in(&world, robot).map_err(refused)?;
        let goal = problem.request.goal_in(&world, robot).map_err(refused)?;
        runner.note(problem, &world.notes, robot);
        for (end, state) in [("start", &start), ("goal", &goal)] {
            let beyond = robot.beyond_limits(state).into_iter();
            let said = beyond.map(|beyond| {
                format!("at the {end} joint {:?} is beyond its limits", beyond.joint)
            });
            said.for_each(|said| runner.count_note(said));
        }
        let begun = Instant::now();
        let mut cell = Workcell::new((*robot).clone(), &world, &allowed).map_err(refused)?;
        runner.spent.preparation += begun.elapsed();
        if cell.is_padded() {
            return Err(Failure::Input("padded links are not checked beside Parry".into()));
        }
        let mut rival = ParryRobot::new(cell.scene(), cell.robot().parts().len())
            .ok_or_else(|| Failure::Input("Parry has no shape for one of them".into()))?;
        if self.sets.last().is_none_or(|set| set.name != problem.set) {
            self.sets.push(Set { name: problem.set.clone(), ..Set::default() });
        }
        self.problems += 1;
        let states: Vec<Vec<f64>> =
            (0..STATES).map(|state| on_the_way(&start, &goal, state)).collect();
        self.undecided += runner.check(&cell, &states)?;
        let mut poses = Vec::new();
        for (state, values) in states.iter().enumerate() {
            cell.robot().place(values, &mut poses).map_err(refused)?;
            runner.ours = std::mem::take(&mut runner.batch[state]);
            self.parry_undecided += runner.query_parry(&cell, &mut rival, &poses);
            self.count(state, runner);
            if runner.ours != runner.theirs {
                cell.set_poses(&poses).map_err(refused)?;
                let found = differences(runner).map(|(pair, we_say)| Difference {
                    set: problem.set.clone(),
                    number: problem.number.clone(),
                    state,
                    pair: [pair.i, pair.j].map(|k| cell.names()[k as usize].clone()),
                    we_say,
                    judged: judge_pair(cell.scene(), pair),
                });
                self.differences.extend(found);
            }
        }
        if let Some(set) = self.sets.last_mut() {
            set.problems += 1;
        }
        Ok(())
    }

    fn count(&mut self, state: usize, runner: &Runner) {
        let touches = usize::from(!runner.ours.is_empty());
        let at = |end| if state == end { touches } else { 0 };
        let (starts, goals) = (at(0), at(STATES - 1));
        self.states += 1;
        self.in_contact += touches;
        self.starts_in_contact += starts;
        self.goals_in_contact += goals;
        self.contacts += runner.ours.len();
        self.parry_contacts += runner.theirs.len();
        if let Some(set) = self.sets.last_mut() {
            set.in_contact += touches;
            set.starts_in_contact += starts;
            set.goals_in_contact += goals;
            set.contacts += runner.ours.len();
        }
    }
}

impl Runner {
    fn note(&mut self, problem: &Problem, notes: &[String], robot: &Robot) {
        let notes = notes.iter().map(|note| format!("scene: {note}"));
        let of_request = problem.request.notes(robot).into_iter();
        let all = notes.chain(of_request.map(|note| format!("request: {note}")));
        all.for_each(|note| self.count_note(note));
    }

    fn count_note(&mut self, note: String) {
        *self.notes.entry(note).or_default() += 1;
    }

    /// Our contacts in each state, sorted, and how many pairs stayed undecided.
    fn check(&mut self, cell: &Workcell, states: &[Vec<f64>]) -> Result<usize, Failure> {
        let (cell, again) = (cell.clone(), cell.clone());
        let begun = Instant::now();
        let checker = match self.checker.take() {
            Some(mut checker) => checker.set_cell(cell).map(|()| checker),
            None => StateChecker::new(cell),
        };
        let mut checker = checker.map_err(refused)?;
        self.spent.preparation += begun.elapsed();
        let begun = Instant::now();
        checker.place_links(states).map_err(refused)?;
        let kinematics = begun.elapsed();
        let begun = Instant::now();
        let first = checker.first(states, Par::Serial).map_err(refused)?;
        self.spent.first += begun.elapsed().saturating_sub(kinematics);
        let touching = first.iter().flatten().filter(|hit| hit.touches());
        self.first_hits += touching.count();
        // So that each prepares what it needs of the obstacles.
        checker.set_cell(again).map_err(refused)?;
        let begun = Instant::now();
        let found = checker.all(states, Par::Serial).map_err(refused)?;
        self.spent.all += begun.elapsed().saturating_sub(kinematics);
        self.spent.kinematics += kinematics;
        self.batch.clear();
        self.batch.resize(STATES, Vec::new());
        let mut undecided = 0;
        for hit in found {
            if hit.touches() {
                self.batch[hit.state as usize].push(hit.pair);
            } else {
                undecided += 1;
            }
        }
        self.checker = Some(checker);
        Ok(undecided)
    }

    /// Parry's, with the poses turned into its own before the clock starts.
    fn query_parry(&mut self, cell: &Workcell, rival: &mut ParryRobot, poses: &[Pose]) -> usize {
        let parts = cell.robot().parts().iter().zip(poses);
        let placed: Vec<_> =
            parts.map(|(part, pose)| ParryRobot::pose(&part.shape, pose)).collect();
        let begun = Instant::now();
        rival.check(&placed, Until::First, &mut self.theirs);
        self.spent.parry_first += begun.elapsed();
        let begun = Instant::now();
        let untold = rival.check(&placed, Until::Last, &mut self.theirs);
        self.spent.parry_all += begun.elapsed();
        self.theirs.sort_unstable();
        untold
    }
}

/// The pairs that one of the two lists alone has, and what we say of each.
fn differences(runner: &Runner) -> impl Iterator<Item = (Pair, &'static str)> + use<> {
    let only = |a: &[Pair], b: &[Pair]| -> Vec<Pair> {
        a.iter().filter(|pair| b.binary_search(pair).is_err()).copied().collect()
    };
    let ours = only(&runner.ours, &runner.theirs).into_iter().map(|pair| (pair, "touching"));
    let theirs = only(&runner.theirs, &runner.ours).into_iter().map(|pair| (pair, "not touching"));
    ours.chain(theirs)
}

impl Checked {
    pub(super) fn json(&self) -> String {
        // Strings and numbers alone: nothing in it can fail.
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }

    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        let width = self.sets.iter().map(|set| set.name.len()).max().unwrap_or(0);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:width$} problems starts goals states contacts", "in contact:");
        for set in &self.sets {
            let Set { name, problems, in_contact, starts_in_contact, goals_in_contact, contacts } =
                set;
            let _ = writeln!(
                text,
                "{name:width$} {problems:>8} {starts_in_contact:>6} {goals_in_contact:>5} \
                 {in_contact:>6} {contacts:>8}"
            );
        }
        let Self { problems, states, contacts, undecided, .. } = self;
        let _ = writeln!(
            text,
            "{problems} problems, {states} states: {contacts} contacts, {undecided} undecided; \
             Parry f64: {} contacts, {} unanswered, {} differences",
            self.parry_contacts,
            self.parry_undecided,
            self.differences.len()
        );
        for Difference { set, number, state, pair: [a, b], we_say, judged } in &self.differences {
            let Judged { truth, metres } = judged;
            let _ = writeln!(
                text,
                "{set}/{number} state {state}: {a} and {b}: we say {we_say}, the truth is \
                 {truth:?}, by {metres:?} m"
            );
        }
        let times = &self.times;
        let _ = writeln!(
            text,
            "kinematics {:.1} ms, preparation {:.1} ms; all hits {:.1} ms, Parry {:.1} ms: {:.2} times; first \
             hits {:.1} ms, Parry {:.1} ms: {:.2} times (Parry's check alone over our three)",
            times.ms_kinematics,
            times.ms_preparation,
            times.ms,
            times.parry_ms,
            times.ratio,
            times.ms_first,
            times.parry_ms_first,
            times.ratio_first
        );
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_ends_at_its_ends_and_is_straight_between() {
        let (start, goal) = ([0.1, -0.785], [0.7, 2.4]);
        assert_eq!(on_the_way(&start, &goal, 0), start);
        assert_eq!(on_the_way(&start, &goal, STATES - 1), goal);
        let third = on_the_way(&start, &goal, 33);
        assert!((third[0] - 0.3).abs() < 1e-12, "{third:?}");
    }
}
