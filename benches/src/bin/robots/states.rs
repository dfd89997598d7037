//! States of every problem: kinematics, preparation and check, first hits and all, beside Parry in f64.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use dcd_benches::timing::time;
use dcd_exec::{Par, with_threads};
use dcd_geom::Pair;
use dcd_parry::{ParryRobot, Until};
use dcd_robot::{Obstacle, StateChecker, Workcell};
use serde::{Deserialize, Serialize};

use crate::data::{Geometry, Setting, on_the_way};

/// States of a problem.
const STATES: usize = 100;

/// How many states are checked at once; the last on a finer line.
pub(crate) const BATCHES: [usize; 4] = [1, 16, STATES, 10_000];

/// What was found and how long it took, of one geometry on so many threads.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) geometry: String,
    pub(crate) threads: usize,
    pub(crate) problems: usize,
    /// Of [`STATES`] a problem.
    pub(crate) contacts: usize,
    pub(crate) undecided: usize,
    /// Pairs that Parry reports and we do not, and the other way.
    pub(crate) differences: usize,
    /// Nanoseconds a state, the median of the rounds.
    pub(crate) kinematics: f64,
    /// Nanoseconds a problem: the median of the rounds' means, and the mean of the problems' medians of the rounds, which
    /// leaves out what a problem waits for in few rounds.
    pub(crate) preparation: [f64; 2],
    pub(crate) rows: Vec<Row>,
}

/// Checks of so many states at once, kinematics among them: nanoseconds a state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) batch: usize,
    pub(crate) until: String,
    pub(crate) ours: f64,
    /// Parry's check alone, its poses made before; on one thread.
    pub(crate) parry: f64,
    /// Parry's by ours: the median of the rounds, the least and the most.
    pub(crate) ratio: [f64; 3],
}

/// The times of one round, summed over the problems.
#[derive(Clone, Default)]
struct Round {
    kinematics: Duration,
    /// Of each problem.
    preparations: Vec<Duration>,
    /// For each batch the first hits and all.
    ours: [[Duration; 2]; BATCHES.len()],
    parry: [Duration; 2],
    counts: Counts,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Counts {
    contacts: usize,
    undecided: usize,
    differences: usize,
}

pub(crate) fn run(
    geometry: Geometry,
    settings: &[&Setting],
    (threads, rounds): (usize, usize),
) -> Result<Outcome> {
    let par = if threads == 1 { Par::Serial } else { Par::WarmPool };
    let all = || -> Result<Vec<Round>> {
        let mut checker = None;
        // The first round warms up.
        let rounds = (0..=rounds).map(|_| round(settings, par, &mut checker));
        rounds.skip(1).collect()
    };
    let rounds = with_threads(threads, all)
        .map_err(|error| anyhow::anyhow!("{threads} threads: {error}"))??;
    let counts = rounds.first().context("no round")?.counts;
    ensure!(rounds.iter().all(|round| round.counts == counts), "two rounds differ");
    let each = |spent: Duration, count: usize| spent.as_secs_f64() * 1e9 / count as f64;
    let median = |of: &dyn Fn(&Round) -> f64| quantiles(rounds.iter().map(of))[0];
    let mut rows = Vec::new();
    for (k, &batch) in BATCHES.iter().enumerate() {
        for (hits, until) in ["first", "all"].into_iter().enumerate() {
            let states = settings.len() * batch.max(STATES);
            let ours = |round: &Round| each(round.ours[k][hits], states);
            let parry = |round: &Round| each(round.parry[hits], settings.len() * STATES);
            let ratio = quantiles(rounds.iter().map(|round| parry(round) / ours(round)));
            let (ours, parry) = (median(&ours), median(&parry));
            rows.push(Row { batch, until: until.to_owned(), ours, parry, ratio });
        }
    }
    Ok(Outcome {
        geometry: geometry.name().to_owned(),
        threads,
        problems: settings.len(),
        contacts: counts.contacts,
        undecided: counts.undecided,
        differences: counts.differences,
        kinematics: median(&|round| each(round.kinematics, settings.len() * STATES)),
        preparation: preparation(&rounds, settings.len()),
        rows,
    })
}

/// The median of the rounds' means of so many problems, and the mean of the problems' medians; nanoseconds.
fn preparation(rounds: &[Round], problems: usize) -> [f64; 2] {
    let nanoseconds =
        |round: &Round, problem: usize| round.preparations[problem].as_secs_f64() * 1e9;
    let mean = |of: &dyn Fn(usize) -> f64| (0..problems).map(of).sum::<f64>() / problems as f64;
    let of_round = |round| mean(&|problem| nanoseconds(round, problem));
    let of_problem = |problem| quantiles(rounds.iter().map(|round| nanoseconds(round, problem)))[0];
    [quantiles(rounds.iter().map(of_round))[0], mean(&of_problem)]
}

/// The median, the least and the most.
pub(crate) fn quantiles(numbers: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut sorted: Vec<f64> = numbers.collect();
    sorted.sort_by(f64::total_cmp);
    let at = |k: usize| sorted.get(k).copied().unwrap_or(f64::NAN);
    [at(sorted.len() / 2), at(0), at(sorted.len().saturating_sub(1))]
}

/// What is found of some states.
#[derive(Clone, Debug, PartialEq)]
struct Found {
    /// By state and pair, undecided ones among them.
    contacts: Vec<(u32, Pair)>,
    undecided: usize,
}

/// First hits and all, so many states at once: their times, and what all are. Each begins with the obstacles taken anew,
/// so that what is made at the first use is counted in both.
fn checked(
    (checker, obstacles): (&mut StateChecker, &[Obstacle]),
    (states, batch): (&[Vec<f64>], usize),
    par: Par,
) -> Result<([Duration; 2], Found)> {
    checker.set_obstacles(obstacles)?;
    let (first_time, first) = time(|| {
        let found = states.chunks(batch).map(|states| checker.first(states, par));
        found.collect::<Result<Vec<_>, _>>()
    });
    checker.set_obstacles(obstacles)?;
    let (all_time, all) = time(|| {
        let found = states.chunks(batch).map(|states| checker.all(states, par));
        found.collect::<Result<Vec<_>, _>>()
    });
    let mut found = Found { contacts: Vec::new(), undecided: 0 };
    for (start, hits) in (0..).step_by(batch).zip(&all?) {
        found.undecided += hits.iter().filter(|hit| !hit.touches()).count();
        found.contacts.extend(hits.iter().map(|hit| (start + hit.state, hit.pair)));
    }
    let mut touches = vec![false; states.len()];
    found.contacts.iter().for_each(|(state, _)| touches[*state as usize] = true);
    let hits = first?.into_iter().flatten().map(|hit| hit.is_some());
    ensure!(hits.eq(touches), "first hits and all hits differ in batches of {batch}");
    Ok(([first_time, all_time], found))
}

/// Whether a cell has the robot of another, with the same pairs that may touch.
fn robot_stays(held: &Workcell, cell: &Workcell) -> bool {
    let parts = 0..cell.robot().parts().len();
    std::ptr::eq(held.robot(), cell.robot()) && held.scene().has_same_filters(cell.scene(), parts)
}

/// Whether a cell is another but for the robot's state.
fn is_cell(a: &Workcell, b: &Workcell) -> bool {
    let (of_a, of_b) = (a.scene(), b.scene());
    let obstacles = a.obstacles();
    a.names() == b.names()
        && of_a.len() == of_b.len()
        && of_a.poses()[obstacles.clone()] == of_b.poses()[obstacles]
        && of_a.has_same_filters(of_b, 0..of_a.len())
}

/// In which order a problem's batches take their turns: each size is as often as any other the first after Parry,
/// which leaves cold caches, and before or after any other.
fn turns(problem: usize) -> [usize; BATCHES.len()] {
    let count = BATCHES.len();
    let mut turns = std::array::from_fn(|k| (k + problem) % count);
    if problem / count % 2 == 1 {
        turns.reverse();
    }
    turns
}

fn round(settings: &[&Setting], par: Par, held: &mut Option<StateChecker>) -> Result<Round> {
    let mut round = Round::default();
    for (problem, setting) in settings.iter().enumerate() {
        // Made before anything is timed: what allocator and kernel put off when Parry's memory went is done meanwhile.
        let states = on_the_way(&setting.ends, STATES);
        let many = on_the_way(&setting.ends, BATCHES[BATCHES.len() - 1]);
        // As a planner does that is given the obstacles of its next problem. No cell is dropped while it is timed.
        let stays = held.as_ref().is_some_and(|held| robot_stays(held.cell(), &setting.cell));
        let cell = (!stays).then(|| setting.cell.clone());
        let (preparation, prepared) = match (held.as_mut(), cell) {
            (Some(checker), None) => time(|| checker.set_obstacles(&setting.obstacles)),
            (Some(checker), Some(cell)) => time(|| checker.set_cell(cell)),
            (None, cell) => {
                let cell = cell.unwrap_or_else(|| setting.cell.clone());
                let (spent, new) = time(|| StateChecker::new(cell));
                (spent, new.map(|new| *held = Some(new)))
            }
        };
        prepared?;
        let checker = held.as_mut().context("no checker")?;
        ensure!(is_cell(checker.cell(), &setting.cell), "an exchanged cell is not the problem's");
        round.preparations.push(preparation);
        let (kinematics, placed) = time(|| checker.place_links(&states));
        placed?;
        round.kinematics += kinematics;
        let mut known: Option<Found> = None;
        for turn in turns(problem) {
            let (batch, ours) = (BATCHES[turn], &mut round.ours[turn]);
            let states = if batch > STATES { &many } else { &states };
            let (times, found) = checked((checker, &setting.obstacles), (states, batch), par)?;
            ours.iter_mut().zip(times).for_each(|(sum, time)| *sum += time);
            if batch <= STATES {
                ensure!(known.get_or_insert(found.clone()) == &found, "batches of {batch} differ");
            }
        }
        let Found { mut contacts, undecided } = known.context("no batch")?;
        round.counts.contacts += contacts.len() - undecided;
        round.counts.undecided += undecided;
        let theirs = parry(setting, &states, &mut round)?;
        contacts.sort_unstable();
        let only = |a: &[(u32, Pair)], b: &[(u32, Pair)]| {
            a.iter().filter(|hit| b.binary_search(hit).is_err()).count()
        };
        round.counts.differences += only(&contacts, &theirs) + only(&theirs, &contacts);
    }
    Ok(round)
}

/// The contacts that Parry reports, by state.
fn parry(setting: &Setting, states: &[Vec<f64>], round: &mut Round) -> Result<Vec<(u32, Pair)>> {
    let robot = setting.cell.robot();
    let rival = ParryRobot::new(setting.cell.scene(), robot.parts().len());
    let mut rival = rival.context("Parry has no shape for one of them")?;
    let (mut contacts, mut found, mut poses) = (Vec::new(), Vec::new(), Vec::new());
    for (k, state) in (0..).zip(states) {
        robot.place(state, &mut poses)?;
        let parts = robot.parts().iter().zip(&poses);
        let placed: Vec<_> =
            parts.map(|(part, pose)| ParryRobot::pose(&part.shape, pose)).collect();
        for (spent, until) in round.parry.iter_mut().zip([Until::First, Until::Last]) {
            *spent += time(|| rival.check(&placed, until, &mut found)).0;
        }
        contacts.extend(found.iter().map(|&pair| (k, pair)));
    }
    contacts.sort_unstable();
    Ok(contacts)
}
