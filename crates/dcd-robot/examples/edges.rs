//! Straight edges from the start to the goal of every problem of an archive (MotionBenchMaker's): how many
//! are free, and what their proofs cost on one thread.
//!
//! `cargo run --release -p dcd-robot --example edges -- ROBOT.urdf ROBOT.srdf PROBLEMS.tar.bz2`

use dcd_robot::{
    AllowedPairs, EdgeAnswer, EdgeChecker, JointPath, Robot, Srdf, Workcell, read_problems,
};
use std::env::args_os;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The most intervals of an edge.
const BUDGET: usize = 100_000;

/// Edges with the same answer.
#[derive(Default)]
struct Group {
    times: Vec<Duration>,
    nodes: usize,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let paths: Vec<PathBuf> = args_os().skip(1).map(PathBuf::from).collect();
    let [urdf, srdf, archive] = &paths[..] else {
        println!("edges ROBOT.urdf ROBOT.srdf PROBLEMS.tar.bz2");
        return Ok(());
    };
    let robot = Robot::load(urdf)?;
    let srdf = Srdf::load(srdf)?;
    let [mut free, mut hit, mut undecided] = [Group::default(), Group::default(), Group::default()];
    let mut making = Duration::ZERO;
    for problem in read_problems(archive)? {
        let mut world = problem.scene.world(&robot, Some(&srdf))?;
        problem.request.place_base(&mut world, &robot, Some(&srdf))?;
        let start = problem.request.start_in(&world, &robot)?;
        let goal = problem.request.goal_in(&world, &robot)?;
        let mut allowed = srdf.allowed.clone();
        allowed.extend(&world.allowed);
        world.allowed = AllowedPairs::default();
        let begun = Instant::now();
        let checker = EdgeChecker::new(Workcell::new(robot.clone(), &world, &allowed)?);
        making += begun.elapsed();
        let begun = Instant::now();
        let edge = checker.check(&JointPath::Straight([start, goal]), BUDGET)?;
        let group = match edge.answer {
            EdgeAnswer::Free { .. } => &mut free,
            EdgeAnswer::Hit { .. } => &mut hit,
            EdgeAnswer::Undecided { .. } => &mut undecided,
        };
        group.times.push(begun.elapsed());
        group.nodes += edge.nodes;
    }
    println!("checkers: {:.1} ms in all", making.as_secs_f64() * 1e3);
    for (name, group) in [("free", free), ("hit", hit), ("undecided", undecided)] {
        group.tell(name);
    }
    Ok(())
}

impl Group {
    fn tell(mut self, name: &str) {
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
