//! Between a state and another that has other hits: bisected down to two neighbouring numbers.

use super::alone;
use super::random::{robot, seeded, state, world};
use crate::{AllowedPairs, Motion, Robot, StateChecker, Workcell};
use dcd_geom::Pose;
use dcd_pipeline::Par;

/// The state that share of the way from one to another of the same orientations.
fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(from, to)| from + (to - from) * share).collect()
}

/// Gives a state another's orientations.
fn take_orientations(robot: &Robot, state: &mut [f64], of: &[f64]) {
    for joint in robot.joints() {
        if let Motion::Orients { first } = joint.motion {
            state[first..first + 4].copy_from_slice(&of[first..first + 4]);
        }
    }
}

#[test]
fn states_between_which_a_hit_begins_are_decided_as_pairs_alone() {
    let mut draw = seeded(31);
    let mut bisected = 0;
    for round in 0..60 {
        let spheres_alone = round % 2 == 0;
        let robot = robot(&mut draw, spheres_alone);
        let mut world = world(&mut draw, &robot);
        // Where f32 is as coarse as a millimetre, or a decimetre.
        let far = draw.vector() * [0.0, 1e4, 1e6][round % 3];
        let moved = |pose: &Pose| pose.with_translation(pose.translation() + far).unwrap();
        world.base = Some(moved(&world.base.unwrap_or(Pose::IDENTITY)));
        for obstacle in &mut world.obstacles {
            obstacle.pose = moved(&obstacle.pose);
        }
        let allowed = AllowedPairs::adjacent(&robot);
        let mut cell = Workcell::new(robot, &world, &allowed).unwrap();
        let checker = StateChecker::new(cell.clone()).unwrap();
        let from = state(&mut draw, cell.robot());
        let mut to = state(&mut draw, cell.robot());
        take_orientations(cell.robot(), &mut to, &from);
        let at_start = alone(&mut cell, &from);
        let (mut low, mut high) = (0.0, 1.0);
        if alone(&mut cell, &to) == at_start {
            continue;
        }
        bisected += 1;
        loop {
            let share = f64::midpoint(low, high);
            if share == low || share == high {
                break;
            }
            let state = between(&from, &to, share);
            let truth = alone(&mut cell, &state);
            let states = [state];
            let hits = checker.all(&states, Par::Serial).unwrap();
            let ours: Vec<_> = hits.iter().map(|hit| (hit.pair, hit.touches())).collect();
            assert_eq!(ours, truth, "round {round}, {share:e} of the way, alone");
            assert_eq!(checker.collides(&states, Par::Serial).unwrap(), [!truth.is_empty()]);
            // Among others, in another lane.
            let mut states = vec![between(&from, &to, low); 21];
            states[round % 21] = between(&from, &to, share);
            let hits = checker.all(&states, Par::Serial).unwrap();
            let hits = hits.iter().filter(|hit| hit.state as usize == round % 21);
            let ours: Vec<_> = hits.map(|hit| (hit.pair, hit.touches())).collect();
            assert_eq!(ours, truth, "round {round}, {share:e} of the way, among others");
            if truth == at_start { low = share } else { high = share }
        }
    }
    assert!(bisected > 12, "{bisected}");
}
