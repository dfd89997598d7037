//! Beside every body with every point, each pair decided by itself in f64 and exactly.

use super::super::tests::{Draw, robot, seeded, shape, state, world};
use super::*;
use crate::{AllowedPairs, Attached, SensedPoint, Workcell, World};
use dcd_geom::Shape;
use dcd_pipeline::Par;
use glam::DVec3;

/// A robot, in some rounds with padded links and what it carries, elsewhere than at the origin.
fn cell(draw: &mut Draw, round: usize) -> Workcell {
    let robot = robot(draw, round.is_multiple_of(3));
    let mut around = World::default();
    if round % 2 == 1 {
        around = world(draw, &robot);
        around.attach(Attached::new("held", "l1", [(shape(draw), draw.pose(0.3))]), ["l0"]);
    }
    Workcell::new(robot, &around, &AllowedPairs::default()).unwrap()
}

/// Whether an object moves and meets obstacles: of a padded link the larger one does.
fn meets(cell: &Workcell, object: usize) -> bool {
    let padded = |other: usize| cell.part_of(other) == cell.part_of(object);
    let last = (0..cell.scene().len()).rfind(|&other| padded(other));
    cell.part_of(object).is_some() && last == Some(object)
}

/// Every pair that is not apart: object, point and whether it touches.
fn alone(
    cell: &mut Workcell,
    state: &[f64],
    (sensed, grown): (&SensedWorld, f64),
) -> Vec<(u32, u32, bool)> {
    cell.set_state(state).unwrap();
    let (scene, half) = (cell.scene(), sensed.half_extents());
    let mut memory = Default::default();
    let mut found = Vec::new();
    for object in (0..scene.len()).filter(|&object| meets(cell, object)) {
        for (point, seen) in (0..).zip(sensed.points()) {
            // A cuboid without edges is a point as well.
            let shape = Shape::cuboid(half).unwrap().rounded(seen.radius + grown).unwrap();
            let pose = Pose::from_translation(seen.centre).unwrap();
            let body = PosedShape { shape: scene.shape(object), pose: &scene.poses()[object] };
            match Certified.solve(body, PosedShape { shape: &shape, pose: &pose }, &mut memory) {
                Verdict::Apart => {}
                verdict => {
                    found.push((object as u32, point, matches!(verdict, Verdict::Touching(_))));
                }
            }
        }
    }
    found
}

/// Points round a body of the robot in a state: dense or thin, in a plane, at one place, tiny, and some of them
/// far away.
fn points(
    draw: &mut Draw,
    round: usize,
    (cell, state): (&mut Workcell, &[f64]),
) -> Vec<SensedPoint> {
    let spread = [0.5, 2.0, 1e-4, 1.0][round % 4];
    cell.set_state(state).unwrap();
    let poses = cell.scene().poses();
    let about = poses[draw.below(poses.len() as u32) as usize].translation();
    let about = about + draw.vector() * 0.02;
    let mut points: Vec<SensedPoint> = (0..150)
        .map(|k| {
            let mut offset = draw.vector() * spread;
            if round % 5 == 1 {
                offset.z = 0.0;
            }
            let radius = if k % 3 == 0 { 0.0 } else { 0.05 * draw.next().abs() };
            SensedPoint { centre: about + offset, radius }
        })
        .collect();
    points.push(points[3]);
    if round % 4 == 3 {
        points.push(SensedPoint { centre: DVec3::splat(1e6), radius: 0.01 });
        points.push(SensedPoint { centre: DVec3::X * -1e6, radius: 999_999.9 });
    }
    points
}

#[test]
fn hits_are_those_of_every_body_with_every_point() {
    let mut draw = seeded(0x5e5e);
    let (mut touching, mut free) = (0, 0);
    for round in 0..24 {
        let mut cell = cell(&mut draw, round);
        let checker = StateChecker::new(cell.clone()).unwrap();
        let states: Vec<Vec<f64>> = (0..19).map(|_| state(&mut draw, cell.robot())).collect();
        let points = points(&mut draw, round, (&mut cell, &states[0]));
        let sensed = if round % 2 == 0 {
            SensedWorld::of_points(&points).unwrap()
        } else {
            let centres: Vec<DVec3> = points.iter().map(|point| point.centre).collect();
            SensedWorld::of_boxes(draw.vector().abs() * 0.05, &centres).unwrap()
        };
        let hits = checker.sensed_hits(&states, &sensed, Par::Serial).unwrap();
        assert_eq!(hits, checker.sensed_hits(&states, &sensed, Par::Pool).unwrap());
        let collides = checker.collides_with_sensed(&states, &sensed, Par::Serial).unwrap();
        for (number, state) in states.iter().enumerate() {
            let of_state = hits.iter().filter(|hit| hit.state as usize == number);
            let found: Vec<_> =
                of_state.map(|hit| (hit.object, hit.point, hit.touches())).collect();
            let truth = alone(&mut cell, state, (&sensed, 0.0));
            assert_eq!(found, truth, "round {round}, state {number}");
            assert_eq!(collides[number], !truth.is_empty(), "round {round}, state {number}");
            touching += truth.len();
            free += usize::from(truth.is_empty());
            let one = checker.sensed_hits(&[state], &sensed, Par::Serial).unwrap();
            assert!(one.iter().map(|hit| (hit.object, hit.point, hit.touches())).eq(found));
        }
    }
    assert!(touching > 500 && free > 50, "{touching} {free}");
}

#[test]
fn the_robots_own_points_are_those_within_the_distance() {
    let mut draw = seeded(77);
    let mut removed = 0;
    for round in 0..12 {
        let mut cell = cell(&mut draw, round);
        let checker = StateChecker::new(cell.clone()).unwrap();
        let state = state(&mut draw, cell.robot());
        let points = points(&mut draw, round, (&mut cell, &state));
        let mut sensed = SensedWorld::of_points(&points).unwrap();
        let distance = 0.1 * draw.next().abs();
        let own = checker.own_points(&state, &sensed, distance).unwrap();
        let mut truth: Vec<u32> = alone(&mut cell, &state, (&sensed, distance.next_up()))
            .into_iter()
            .map(|(_, point, _)| point)
            .collect();
        truth.sort_unstable();
        truth.dedup();
        assert_eq!(own, truth, "round {round}");
        removed += own.len();
        let count = sensed.len();
        sensed.remove(&own);
        assert_eq!(sensed.len(), count - own.len());
        assert!(checker.own_points(&state, &sensed, distance).unwrap().is_empty());
        assert_eq!(checker.collides_with_sensed(&[state], &sensed, Par::Serial).unwrap(), [false]);
    }
    assert!(removed > 100, "{removed}");
}

#[test]
fn bad_points_are_refused_by_their_index_and_nothing_is_changed() {
    let good = SensedPoint { centre: DVec3::ONE, radius: 0.1 };
    let mut sensed = SensedWorld::of_points(&[good]).unwrap();
    let with = |x: f64, radius: f64| SensedPoint { centre: DVec3::new(0.0, x, 0.0), radius };
    for (bad, said) in [
        (with(f64::NAN, 0.1), "point 1: the y is NaN"),
        (with(f64::INFINITY, 0.1), "point 1: the y is inf"),
        (with(0.0, f64::NAN), "point 1: the radius is NaN"),
        (with(0.0, -1e-9), "point 1: the radius is -1e-9"),
        (with(0.0, f64::INFINITY), "point 1: the radius is inf"),
    ] {
        let refused = sensed.replace_points(&[good, bad, bad]).unwrap_err();
        assert_eq!(refused.to_string(), said);
        assert_eq!(sensed.points(), [good]);
    }
    assert!(sensed.replace_boxes(DVec3::new(0.1, f64::NAN, 0.1), &[]).is_err());
    assert!(sensed.replace_boxes(DVec3::ONE, &[DVec3::NAN]).is_err());
    sensed.replace_points(&[]).unwrap();
    assert!(sensed.is_empty());
    let mut draw = Draw(5);
    let cell = cell(&mut draw, 1);
    let (checker, state) = (StateChecker::new(cell.clone()).unwrap(), cell.robot().rest_state());
    assert_eq!(checker.collides_with_sensed(&[&state], &sensed, Par::Serial).unwrap(), [false]);
    assert!(checker.own_points(&state, &sensed, f64::NAN).is_err());
    assert!(checker.own_points(&state, &sensed, -1.0).is_err());
}
