//! A hundred states on the straight line from the start to the goal of every problem of an archive
//! (MotionBenchMaker's): what their check costs on one thread, by each query.
//!
//! `cargo run --release -p dcd-robot --example problem_states -- ROBOT.urdf ROBOT.srdf PROBLEMS.tar.bz2 [meshes]`

use dcd_robot::{
    AllowedPairs, LinkShapes, Robot, RobotError, Srdf, StateChecker, StateHit, Workcell,
    read_problems,
};
use std::env::args;
use std::path::Path;
use std::time::{Duration, Instant};

/// States on the way, both ends among them.
const STATES: usize = 100;

/// Of all problems.
#[derive(Debug, Default)]
struct Spent {
    states: usize,
    contacts: usize,
    in_contact: usize,
    differing: usize,
    preparation: Duration,
    kinematics: Duration,
    all: Duration,
    first: Duration,
    one_by_one: Duration,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = args().skip(1).collect();
    let (paths, links) = match &args[..] {
        [urdf, srdf, archive] => ([urdf, srdf, archive], LinkShapes::Hulls),
        [urdf, srdf, archive, meshes] if meshes == "meshes" => {
            ([urdf, srdf, archive], LinkShapes::Meshes)
        }
        _ => {
            println!("problem_states ROBOT.urdf ROBOT.srdf PROBLEMS.tar.bz2 [meshes]");
            return Ok(());
        }
    };
    let [urdf, srdf, archive] = paths.map(Path::new);
    let robot = Robot::read(
        &std::fs::read_to_string(urdf)?,
        urdf.parent().unwrap_or(Path::new(".")),
        links,
    )?;
    let srdf = Srdf::load(srdf)?;
    let (mut spent, mut kept) = (Spent::default(), None);
    for problem in read_problems(archive)? {
        let mut world = problem.scene.world(&robot, Some(&srdf))?;
        problem.request.place_base(&mut world, &robot, Some(&srdf))?;
        let start = problem.request.start_in(&world, &robot)?;
        let goal = problem.request.goal_in(&world, &robot)?;
        let mut allowed = srdf.allowed.clone();
        allowed.extend(&world.allowed);
        world.allowed = AllowedPairs::default();
        let cell = Workcell::new(robot.clone(), &world, &allowed)?;
        let states: Vec<Vec<f64>> = (0..STATES)
            .map(|state| {
                let part = state as f64 / (STATES - 1) as f64;
                start.iter().zip(&goal).map(|(a, b)| a * (1.0 - part) + b * part).collect()
            })
            .collect();
        kept = Some(spent.check(kept, &cell, &states)?);
    }
    println!("{spent:#?}");
    Ok(())
}

impl Spent {
    fn check(
        &mut self,
        kept: Option<StateChecker>,
        cell: &Workcell,
        states: &[Vec<f64>],
    ) -> Result<StateChecker, RobotError> {
        let serial = dcd_pipeline::Par::Serial;
        let (given, again) = (cell.clone(), cell.clone());
        let begun = Instant::now();
        let mut checker = match kept {
            Some(mut checker) => checker.set_cell(given).map(|()| checker),
            None => StateChecker::new(given),
        }?;
        self.preparation += begun.elapsed();
        let begun = Instant::now();
        checker.place_links(states)?;
        self.kinematics += begun.elapsed();
        let begun = Instant::now();
        let first = checker.first(states, serial)?;
        self.first += begun.elapsed();
        checker.set_cell(again)?;
        let begun = Instant::now();
        let all = checker.all(states, serial)?;
        self.all += begun.elapsed();
        let begun = Instant::now();
        for (state, first) in states.iter().zip(&first) {
            let one = checker.collides(&[state], serial)?;
            self.differing += usize::from(one != [first.is_some()]);
        }
        self.one_by_one += begun.elapsed();
        self.states += states.len();
        self.contacts += all.iter().filter(|hit| hit.touches()).count();
        self.in_contact += first.iter().flatten().filter(|hit| StateHit::touches(hit)).count();
        Ok(checker)
    }
}
