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

/// Of what is free before a hit the part that is replayed: at its end it may be as near as rounding.
const BEFORE: f64 = 1.0 - 1e-6;

/// A straight path up to t.
fn first_part(path: &JointPath, robot: &Robot, t: f64) -> Option<JointPath> {
    let JointPath::Straight([from, _]) = path else { return None };
    let mut end = Vec::new();
    path.state_at(robot, t, &mut end);
    Some(JointPath::Straight([from.clone(), end]))
}

/// How many edges are free, and how many straight ones that hit are so before, each of which replays.
fn free_edges(urdf: &str, shapes: LinkShapes) -> Option<[usize; 2]> {
    let files = [urdf, "panda/panda.srdf", "panda/problems.tar.bz2"].map(|file| {
        let found = data::file(file);
        if found.is_none() {
            println!("skipped: {file} is not there");
        }
        found
    });
    let [Some(urdf), Some(srdf), Some(problems)] = files else { return None };
    let (robot, srdf) = (Robot::load_as(&urdf, shapes).unwrap(), Srdf::load(&srdf).unwrap());
    let (mut free, mut before) = (0, 0);
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
            let mut path = if k == 1 {
                let bent = from.iter().map(|x| x + 0.05).collect();
                JointPath::Bezier([from.clone(), bent, to.clone(), to])
            } else {
                JointPath::Straight([from, to])
            };
            let mut edge = checker.check(&path, 100_000).unwrap();
            let hits = matches!(edge.answer, EdgeAnswer::Hit { .. });
            if hits && edge.free_until > 0.0 {
                let Some(part) = first_part(&path, &robot, BEFORE * edge.free_until) else {
                    continue;
                };
                let of_part = checker.check(&part, 100_000).unwrap();
                let is_free = matches!(of_part.answer, EdgeAnswer::Free { .. });
                assert!(is_free, "{path:?}: {edge:?}, but {of_part:?} of {part:?}");
                (path, edge) = (part, of_part);
            }
            let EdgeAnswer::Free { clearance } = edge.answer else { continue };
            let certificate = checker.certificate(&path, clearance, 1_000_000).unwrap();
            match replay.line(&certificate.line(k)) {
                Ok(Replayed::Accepted { .. }) => *(if hits { &mut before } else { &mut free }) += 1,
                other => panic!("{}/{} {k}: {edge:?} {other:?}", problem.set, problem.number),
            }
        }
    }
    Some([free, before])
}

/// That the data is not there, or enough of both was found.
fn assert_enough(found: Option<[usize; 2]>) {
    assert!(found.is_none_or(|[free, before]| free > 10 && before > 3), "{found:?}");
}

#[test]
fn free_edges_of_the_panda_as_hulls_replay() {
    assert_enough(free_edges("panda/panda.urdf", LinkShapes::Hulls));
}

#[test]
fn free_edges_of_the_panda_as_meshes_replay() {
    assert_enough(free_edges("panda/panda.urdf", LinkShapes::Meshes));
}

#[test]
fn free_edges_of_the_panda_as_spheres_replay() {
    assert_enough(free_edges("panda/panda_spherized.urdf", LinkShapes::Hulls));
}
