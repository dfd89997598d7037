//! Certificates of edges of the Panda, which the judge replays. They say that they skip where the data is absent.
#![allow(missing_docs)]

use dcd_io::data;
use dcd_judge::{Replay, Replayed};
use dcd_robot::{
    AllowedPairs, EdgeAnswer, EdgeChecker, JointPath, LinkShapes, Robot, Srdf, Workcell,
    read_problems,
};

/// Parts of the way from start to goal.
const PARTS: [[f64; 2]; 3] = [[0.0, 0.1], [0.45, 0.6], [0.9, 1.0]];

/// Every so many problems.
const EVERY: usize = 41;

/// How many edges are free, each of which replays.
fn free_edges(urdf: &str, shapes: LinkShapes) -> Option<usize> {
    let files = [urdf, "panda/panda.srdf", "panda/problems.tar.bz2"].map(|file| {
        let found = data::file(file);
        if found.is_none() {
            println!("skipped: {file} is not there");
        }
        found
    });
    let [Some(urdf), Some(srdf), Some(problems)] = files else { return None };
    let (robot, srdf) = (Robot::load_as(&urdf, shapes).unwrap(), Srdf::load(&srdf).unwrap());
    let mut free = 0;
    for problem in read_problems(&problems).unwrap().iter().step_by(EVERY) {
        let mut world = problem.scene.world(&robot, Some(&srdf)).unwrap();
        problem.request.place_base(&mut world, &robot, Some(&srdf)).unwrap();
        let start = problem.request.start_in(&world, &robot).unwrap();
        let goal = problem.request.goal_in(&world, &robot).unwrap();
        let mut allowed = srdf.allowed.clone();
        allowed.extend(&world.allowed);
        world.allowed = AllowedPairs::default();
        let checker = EdgeChecker::new(Workcell::new(robot.clone(), &world, &allowed).unwrap());
        let mut replay = Replay::default();
        replay.line(&checker.certificate_cell().unwrap()).unwrap();
        for (k, part) in PARTS.iter().enumerate() {
            let at = |t: f64| start.iter().zip(&goal).map(|(a, b)| a + t * (b - a)).collect();
            let [from, to]: [Vec<f64>; 2] = part.map(at);
            let path = if k == 1 {
                let bent = from.iter().map(|x| x + 0.05).collect();
                JointPath::Bezier([from.clone(), bent, to.clone(), to])
            } else {
                JointPath::Straight([from, to])
            };
            let edge = checker.check(&path, 100_000).unwrap();
            let EdgeAnswer::Free { clearance } = edge.answer else { continue };
            let certificate = checker.certificate(&path, clearance, 1_000_000).unwrap();
            match replay.line(&certificate.line(k)) {
                Ok(Replayed::Accepted { .. }) => free += 1,
                other => panic!("{}/{} {k}: {edge:?} {other:?}", problem.set, problem.number),
            }
        }
    }
    Some(free)
}

#[test]
fn free_edges_of_the_panda_as_hulls_replay() {
    assert!(free_edges("panda/panda.urdf", LinkShapes::Hulls).is_none_or(|free| free > 10));
}

#[test]
fn free_edges_of_the_panda_as_meshes_replay() {
    assert!(free_edges("panda/panda.urdf", LinkShapes::Meshes).is_none_or(|free| free > 10));
}

#[test]
fn free_edges_of_the_panda_as_spheres_replay() {
    let free = free_edges("panda/panda_spherized.urdf", LinkShapes::Hulls);
    assert!(free.is_none_or(|free| free > 10));
}
