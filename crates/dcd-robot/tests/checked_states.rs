//! States of robots that nobody here made, checked sixteen at a time and each as a scene of its own. Without the
//! data folder these tests say that they skip.
#![allow(missing_docs)]

use dcd_geom::{Pair, Pose, Shape};
use dcd_io::data;
use dcd_pipeline::{Par, Pipeline};
use dcd_robot::{AllowedPairs, LinkShapes, Obstacle, Robot, StateChecker, Workcell, World};
use glam::{DQuat, DVec3};

const ROBOTS: [&str; 5] = [
    "panda/panda.urdf",
    "panda/panda_spherized.urdf",
    "robots/ur_description/urdf/ur10.urdf",
    "robots/example-robot-data/robots/pr2_description/urdf/pr2.urdf",
    "robots/example-robot-data/robots/baxter_description/urdf/baxter.urdf",
];

/// Numbers in −1 … 1 by a linear congruence.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn pose(&mut self) -> Pose {
        let turn = DQuat::from_xyzw(self.next(), self.next(), self.next(), self.next());
        let at = DVec3::new(self.next(), self.next(), self.next() + 0.7) * 1.1;
        Pose::new(turn.normalize(), at).unwrap()
    }
}

fn world(draw: &mut Draw, obstacles: usize) -> World {
    let shape = |draw: &mut Draw, k: usize| {
        let size = 0.05 + 0.1 * draw.next().abs();
        match k % 4 {
            0 => Shape::cuboid(DVec3::new(size, 0.2, 2.0 * size)),
            1 => Shape::cylinder(2.0 * size, size),
            2 => Shape::sphere(size),
            _ => Shape::hull(vec![DVec3::ZERO, DVec3::X * size, DVec3::Y * 0.3, DVec3::Z * 0.2]),
        }
    };
    let obstacle = |k: usize| {
        let (shape, pose) = (shape(draw, k).unwrap(), draw.pose());
        Obstacle { name: format!("obstacle {k}"), shape, pose }
    };
    World { obstacles: (0..obstacles).map(obstacle).collect(), ..World::default() }
}

/// Checks random states in a world both ways; how many contacts there were, and how many free states.
fn agrees(robot: &Robot, obstacles: usize, states: usize, draw: &mut Draw) -> [usize; 2] {
    let allowed = AllowedPairs::adjacent(robot);
    let world = world(draw, obstacles);
    let mut cell = Workcell::new(robot.clone(), &world, &allowed).unwrap();
    let checker = StateChecker::new(cell.clone()).unwrap();
    let count = robot.variables().len();
    let states: Vec<Vec<f64>> =
        (0..states).map(|_| (0..count).map(|_| 2.0 * draw.next()).collect()).collect();
    let mut all: Vec<Vec<Pair>> = vec![Vec::new(); states.len()];
    for hit in checker.all(&states, Par::Pool).unwrap() {
        assert!(hit.touches(), "{hit:?}");
        all[hit.state as usize].push(hit.pair);
    }
    let first = checker.first(&states, Par::Pool).unwrap();
    let mut pipeline = Pipeline::new();
    let (mut contacts, mut free) = (0, 0);
    for (k, state) in states.iter().enumerate() {
        cell.set_state(state).unwrap();
        let step = pipeline.step(cell.scene(), Par::Serial);
        assert!(step.report().undecided().is_empty());
        let mut truth: Vec<Pair> = step.contacts().map(|(i, j)| Pair { i, j }).collect();
        truth.sort_unstable();
        assert_eq!(all[k], truth, "{}: state {k}", robot.name);
        match first[k] {
            Some(hit) => assert!(truth.contains(&hit.pair), "{}: state {k}", robot.name),
            None => assert!(truth.is_empty(), "{}: state {k}", robot.name),
        }
        contacts += truth.len();
        free += usize::from(truth.is_empty());
    }
    [contacts, free]
}

#[test]
fn states_of_robots_are_those_of_scenes() {
    let mut draw = Draw(11);
    for path in ROBOTS {
        let Some(urdf) = data::file(path) else {
            println!("skipped: {path} is not there");
            continue;
        };
        for shapes in [LinkShapes::Hulls, LinkShapes::Meshes] {
            let robot = Robot::load_as(&urdf, shapes).unwrap();
            let [few, many] = if shapes == LinkShapes::Hulls { [60, 40] } else { [10, 6] };
            let found = [
                agrees(&robot, 6, few, &mut draw),
                agrees(&robot, 0, few, &mut draw),
                agrees(&robot, 150, many, &mut draw),
            ];
            println!("{path}, {shapes:?}: contacts and free states {found:?}");
            assert!(found[2][0] > 0);
        }
    }
}
