//! Straight edges from the start to the goal of every problem of an archive (MotionBenchMaker's): how many
//! are free, and what their proofs cost on one thread.
//!
//! `cargo run --release -p dcd-robot --example edges -- ROBOT.urdf ROBOT.srdf PROBLEMS.tar.bz2 [EVERY]`

use dcd_robot::{
    AllowedPairs, Edge, EdgeAnswer, EdgeChecker, JointPath, Robot, RobotError, Srdf, Workcell,
    read_problems,
};
use std::env::args_os;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The most intervals of an edge.
const BUDGET: usize = 100_000;

/// How often each edge is checked; the quickest counts, for what else the machine does.
const ROUNDS: usize = 5;

/// Edges with the same answer.
#[derive(Default)]
struct Group {
    times: Vec<Duration>,
    nodes: usize,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let paths: Vec<PathBuf> = args_os().skip(1).map(PathBuf::from).collect();
    let [urdf, srdf, archive, rest @ ..] = &paths[..] else {
        println!("edges ROBOT.urdf ROBOT.srdf PROBLEMS.tar.bz2 [EVERY]");
        return Ok(());
    };
    // Every so many problems.
    let every = rest.first().and_then(|text| text.to_str()?.parse().ok()).unwrap_or(1);
    let robot = Robot::load(urdf)?;
    let srdf = Srdf::load(srdf)?;
    let [mut free, mut hit, mut any, mut undecided] = [(); 4].map(|()| Group::default());
    let mut held: Option<EdgeChecker> = None;
    let mut making = Duration::ZERO;
    for problem in read_problems(archive)?.into_iter().step_by(every) {
        let mut world = problem.scene.world(&robot, Some(&srdf))?;
        problem.request.place_base(&mut world, &robot, Some(&srdf))?;
        let start = problem.request.start_in(&world, &robot)?;
        let goal = problem.request.goal_in(&world, &robot)?;
        let mut allowed = srdf.allowed.clone();
        allowed.extend(&world.allowed);
        world.allowed = AllowedPairs::default();
        let begun = Instant::now();
        let cell = Workcell::new(robot.clone(), &world, &allowed)?;
        let checker = match &mut held {
            Some(checker) => {
                checker.set_cell(cell);
                checker
            }
            None => held.insert(EdgeChecker::new(cell)),
        };
        making += begun.elapsed();
        let path = JointPath::Straight([start, goal]);
        let (edge, time) = quickest(|| checker.check(&path, BUDGET))?;
        let group = match edge.answer {
            EdgeAnswer::Free { .. } => &mut free,
            EdgeAnswer::Hit { .. } => {
                let (edge, time) = quickest(|| checker.check_any(&path, BUDGET))?;
                any.times.push(time);
                any.nodes += edge.nodes;
                &mut hit
            }
            EdgeAnswer::Undecided { .. } => &mut undecided,
        };
        group.times.push(time);
        group.nodes += edge.nodes;
    }
    println!("checkers: {:.1} ms in all", making.as_secs_f64() * 1e3);
    let groups = [
        ("free", free),
        ("hit, and free before it", hit),
        ("hit alone", any),
        ("undecided", undecided),
    ];
    for (name, group) in groups {
        group.print(name);
    }
    Ok(())
}

/// An edge, and its shortest time. The first round prepares what a planner's other edges find prepared.
fn quickest(check: impl Fn() -> Result<Edge, RobotError>) -> Result<(Edge, Duration), RobotError> {
    let (mut edge, mut least) = (check()?, Duration::MAX);
    for _ in 0..ROUNDS {
        let begun = Instant::now();
        edge = check()?;
        least = least.min(begun.elapsed());
    }
    Ok((edge, least))
}

impl Group {
    fn print(mut self, name: &str) {
        let count = self.times.len();
        if count == 0 {
            println!("{name}: none");
            return;
        }
        self.times.sort_unstable();
        let mean = self.times.iter().sum::<Duration>() / count as u32;
        let nodes = self.nodes as f64 / count as f64;
        let at = |part: f64| self.times[(part * (count - 1) as f64) as usize];
        println!(
            "{name}: {count} edges, mean {mean:.1?}, median {:.1?}, 95 % {:.1?}, {nodes:.1} nodes",
            at(0.5),
            at(0.95)
        );
    }
}
