//! Shapes and places so large that squares overflow in f32.

use super::{alone, seeded};
use crate::{AllowedPairs, LinkShapes, Obstacle, Robot, RobotError, SensedPoint, SensedWorld};
use crate::{StateChecker, Workcell, World};
use dcd_geom::{Pose, Shape};
use dcd_pipeline::Par;
use glam::DVec3;
use std::path::Path;

/// Two spheres, the second of which slides along x.
fn sliding(radii: [f64; 2]) -> Robot {
    let [base, hand] = radii;
    let urdf = format!(
        r#"<robot name="pair">
        <link name="base"><collision><geometry><sphere radius="{base}"/></geometry></collision></link>
        <link name="hand"><collision><geometry><sphere radius="{hand}"/></geometry></collision></link>
        <joint name="slide" type="prismatic"><parent link="base"/><child link="hand"/><axis xyz="1 0 0"/>
        <limit lower="0" upper="1e30" effort="1" velocity="1"/></joint></robot>"#
    );
    Robot::read(&urdf, Path::new("."), LinkShapes::Hulls).unwrap()
}

fn check(robot: &Robot, obstacle: Option<(Shape, DVec3)>, value: f64) -> bool {
    let obstacles = obstacle.map(|(shape, place)| Obstacle {
        name: "huge".to_owned(),
        shape,
        pose: Pose::from_translation(place).unwrap(),
    });
    let world = World { obstacles: obstacles.into_iter().collect(), ..World::default() };
    let mut cell = Workcell::new(robot.clone(), &world, &AllowedPairs::default()).unwrap();
    let checker = StateChecker::new(cell.clone()).unwrap();
    let state = vec![value];
    let truth = alone(&mut cell, &state);
    for states in [vec![state.clone()], vec![state; 17]] {
        let hits = checker.all(&states, Par::Serial).unwrap();
        let of_last = hits.iter().filter(|hit| hit.state as usize == states.len() - 1);
        let ours: Vec<_> = of_last.map(|hit| (hit.pair, hit.touches())).collect();
        assert_eq!(ours, truth, "{:?} at {value:e}", world.obstacles);
    }
    !truth.is_empty()
}

#[test]
fn where_squares_overflow_states_are_decided_as_pairs_alone() {
    let mut draw = seeded(57);
    let robot = sliding([0.1, 0.1]);
    let middle = DVec3::splat(1.9e19);
    // Each in a place where it holds the origin, and in one where its box does and it does not.
    let cylinder = Shape::cylinder(1.0, 3e19).unwrap();
    assert!(check(&robot, Some((cylinder, DVec3::X * 2e19)), 3.0));
    assert!(!check(&robot, Some((Shape::sphere(2e19).unwrap(), middle)), 3.0));
    let (mut touching, mut apart) = (0, 0);
    // Whatever the seed, until there were some of both.
    while touching + apart < 60 || touching < 10 || apart < 10 {
        assert!(touching + apart < 1000, "{touching} {apart}");
        let size = 10f64.powf(13.5 + 7.0 * draw.size(0.0, 1.0));
        let shape = match draw.below(4) {
            0 => Shape::cylinder(size * draw.size(0.0, 1.0), size),
            1 => Shape::sphere(size),
            2 => Shape::capsule(size * draw.size(0.0, 1.0), size),
            _ => Shape::cuboid(DVec3::new(size, size * (draw.size(0.1, 1.1)), size)),
        };
        let place = draw.vector() * 1.4 * size;
        let touches = check(&robot, Some((shape.unwrap(), place)), 3.0);
        if touches { touching += 1 } else { apart += 1 }
    }
}

#[test]
fn links_whose_squares_overflow_are_decided_as_pairs_alone() {
    let robot = sliding([1e19, 1e19]);
    assert!(check(&robot, None, 1e19));
    assert!(!check(&robot, None, 1e20));
}

#[test]
fn a_sensed_point_whose_squares_overflow_proves_no_contact() {
    let robot = sliding([0.1, 0.1]);
    let cell = Workcell::new(robot, &World::default(), &AllowedPairs::default()).unwrap();
    let checker = StateChecker::new(cell).unwrap();
    for (centre, touches) in [(DVec3::splat(1.9e19), false), (DVec3::X * 1.9e19, true)] {
        let seen = SensedWorld::of_points(&[SensedPoint { centre, radius: 2e19 }]).unwrap();
        let hits = checker.sensed_hits(&[[3.0]], &seen, Par::Serial).unwrap();
        assert_eq!(hits.iter().any(|hit| hit.touches()), touches, "{centre}: {hits:?}");
        assert_eq!(!hits.is_empty(), touches, "{centre}: {hits:?}");
    }
}

fn said<T>(result: Result<T, RobotError>) -> String {
    result.err().unwrap().to_string()
}

#[test]
fn what_leaves_the_range_is_refused_by_its_name() {
    let text = "<robot name=\"r\">\n<link name=\"a\">\n<collision><geometry>\n<box size=\"1 1 4e38\"/>\n\
                </geometry></collision></link></robot>";
    let shape = said(Robot::read(text, Path::new("."), LinkShapes::Hulls));
    assert!(shape.starts_with("line 3: link \"a\": reaches 2.0"), "{shape}");

    let robot = sliding([0.1, 0.1]);
    let obstacle = |name: &str, x: f64| {
        let shape = Shape::sphere(0.5).unwrap();
        let pose = Pose::from_translation(DVec3::X * x).unwrap();
        Obstacle { name: name.to_owned(), shape, pose }
    };
    let world =
        |obstacles: &[Obstacle]| World { obstacles: obstacles.to_vec(), ..World::default() };
    let none = AllowedPairs::default();
    let (near, far) = (obstacle("near", 9.0), obstacle("far", 1e39));
    let both = [near.clone(), far.clone()];
    let of_far = "obstacle \"far\": reaches 1e39 m";
    assert!(said(Workcell::new(robot.clone(), &world(&both), &none)).starts_with(of_far));

    let mut padded = world(&both[..1]);
    padded.pad(&robot, 0.1).unwrap();
    for world in [world(&both[..1]), padded] {
        let mut cell = Workcell::new(robot.clone(), &world, &none).unwrap();
        assert!(said(cell.set_obstacles(&both)).starts_with(of_far));
        assert!(said(cell.add_obstacle(&far)).starts_with(of_far));
        let moved = cell.move_obstacle(0, far.pose);
        assert!(said(moved).starts_with("obstacle \"near\": reaches 1e39 m"));
        let of_hand = "link \"hand\": reaches 1e39 m";
        let before = cell.scene().poses().to_vec();
        assert!(said(cell.set_state(&[1e39])).starts_with(of_hand));
        assert_eq!(before, cell.scene().poses(), "half of the robot has moved");
        // What a batch decides pair by pair.
        let checker = StateChecker::new(cell).unwrap();
        let states = checker.all(&[[3.0], [1e39]], Par::Serial);
        assert!(said(states).contains(of_hand));
    }
}
