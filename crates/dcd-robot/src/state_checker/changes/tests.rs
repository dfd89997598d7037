//! Worlds that change beside worlds made anew.

use super::super::tests::{Draw, robot, seeded, shape, state};
use super::*;
use crate::{
    AllowedPairs, EdgeAnswer, EdgeChecker, JointPath, Padding, Robot, SensedPoint, SensedWorld,
    World,
};
use dcd_pipeline::Par;
use std::sync::Arc;

fn obstacle(draw: &mut Draw, name: String) -> Obstacle {
    Obstacle { name, shape: shape(draw), pose: draw.pose(0.8) }
}

/// What a robot checks, changed in place and made anew.
struct Both {
    robot: Arc<Robot>,
    world: World,
    allowed: AllowedPairs,
    changed: StateChecker,
    /// How many obstacles there ever were: no name comes twice, but those that pairs speak of.
    named: usize,
}

impl Both {
    fn new(draw: &mut Draw, obstacles: u32) -> Self {
        let spheres_alone = draw.below(2) == 0;
        let robot = Arc::new(robot(draw, spheres_alone));
        let mut allowed = AllowedPairs::adjacent(&robot);
        let mut world = World::default();
        match draw.below(6) {
            0 => {
                let padding = Padding { padding: 0.02, ..Padding::NONE };
                world.padding.insert("l0".to_owned(), padding);
            }
            1 => allowed.allow("l0", "special"),
            _ => {}
        }
        let obstacles = (0..obstacles).map(|k| obstacle(draw, format!("o{k}")));
        world.obstacles = obstacles.collect();
        let cell = Workcell::new(robot.clone(), &world, &allowed).unwrap();
        let (changed, named) = (StateChecker::new(cell).unwrap(), world.obstacles.len());
        Self { robot, world, allowed, changed, named }
    }

    fn next(&mut self, draw: &mut Draw) -> Obstacle {
        self.named += 1;
        let is_special = draw.below(4) == 0;
        let name = if is_special { "special".to_owned() } else { format!("o{}", self.named) };
        obstacle(draw, name)
    }

    fn change(&mut self, draw: &mut Draw) {
        let count = self.world.obstacles.len();
        let place = draw.below(count.max(1) as u32) as usize;
        match draw.below(10) {
            0 => {
                let all = draw.below(if count > 64 { 140 } else { 20 });
                let all: Vec<Obstacle> = (0..all).map(|_| self.next(draw)).collect();
                self.changed.set_obstacles(&all).unwrap();
                self.world.obstacles = all;
            }
            1..=3 => {
                let new = self.next(draw);
                assert_eq!(self.changed.add_obstacle(&new).unwrap(), count);
                self.world.obstacles.push(new);
            }
            4..=6 if count > 0 => {
                let pose = draw.pose(0.8);
                self.changed.move_obstacle(place, pose).unwrap();
                self.world.obstacles[place].pose = pose;
            }
            9 => {
                let cell = Workcell::new(self.robot.clone(), &self.world, &self.allowed).unwrap();
                self.changed.set_cell(cell).unwrap();
            }
            _ if count > 0 => {
                self.changed.remove_obstacle(place).unwrap();
                self.world.obstacles.swap_remove(place);
            }
            _ => assert!(self.changed.remove_obstacle(place).is_err()),
        }
    }

    /// Compares all answers of the two, and returns how many hits there are.
    fn compare(&self, states: &[Vec<f64>]) -> usize {
        let cell = Workcell::new(self.robot.clone(), &self.world, &self.allowed).unwrap();
        let (own, new) = (self.changed.cell(), &cell);
        assert_eq!(own.names(), new.names());
        assert_eq!(own.scene().poses(), new.scene().poses());
        assert!(own.scene().has_same_filters(new.scene(), 0..new.scene().len()));
        let anew = StateChecker::new(cell).unwrap();
        let all = anew.all(states, Par::Serial).unwrap();
        assert_eq!(self.changed.all(states, Par::Serial).unwrap(), all);
        let first = |checker: &StateChecker| checker.first(states, Par::Serial).unwrap();
        assert_eq!(first(&self.changed), first(&anew));
        all.len()
    }
}

#[test]
fn a_changed_world_answers_as_one_made_anew() {
    let mut draw = seeded(11);
    let mut hits = 0;
    for round in 0..24 {
        // Few, or so many that there is a tree.
        let count = if round % 3 == 0 { 60 + draw.below(40) } else { draw.below(12) };
        let mut both = Both::new(&mut draw, count);
        for _ in 0..12 {
            // Several between two looks, so that what is made at need is stale or was never made.
            for _ in 0..1 + draw.below(if round % 6 == 0 { 40 } else { 4 }) {
                both.change(&mut draw);
            }
            let states: Vec<_> = (0..18).map(|_| state(&mut draw, &both.robot)).collect();
            hits += both.compare(&states);
        }
    }
    assert!(hits > 5_000, "{hits}");
}

#[test]
fn clearances_follow_an_obstacle_that_moves() {
    let mut draw = Draw(5);
    let mut both = Both::new(&mut draw, 6);
    let states: Vec<_> = (0..6).map(|_| state(&mut draw, &both.robot)).collect();
    let mut before = None;
    for _ in 0..4 {
        let place = draw.below(6) as usize;
        let pose = draw.pose(0.3);
        both.changed.move_obstacle(place, pose).unwrap();
        both.world.obstacles[place].pose = pose;
        let cell = Workcell::new(both.robot.clone(), &both.world, &both.allowed).unwrap();
        let anew = StateChecker::new(cell).unwrap().clearances(&states, Par::Serial).unwrap();
        assert_eq!(both.changed.clearances(&states, Par::Serial).unwrap(), anew);
        assert_ne!(before, Some(anew.clone()));
        before = Some(anew);
    }
}

#[test]
fn what_is_refused_changes_nothing() {
    let mut draw = Draw(2);
    for count in [3, 80] {
        let mut both = Both::new(&mut draw, count);
        let states: Vec<_> = (0..16).map(|_| state(&mut draw, &both.robot)).collect();
        let far = Pose::from_translation(glam::DVec3::X * 1e300).unwrap();
        let own = obstacle(&mut draw, "l1".to_owned());
        let beyond = Obstacle { pose: far, ..obstacle(&mut draw, "far".to_owned()) };
        let changed = &mut both.changed;
        let errors = [
            changed.add_obstacle(&own).unwrap_err(),
            changed.add_obstacle(&beyond).unwrap_err(),
            changed.set_obstacles(&[own]).unwrap_err(),
            changed.set_obstacles(&[beyond]).unwrap_err(),
            changed.move_obstacle(1, far).unwrap_err(),
            changed.move_obstacle(count as usize, Pose::IDENTITY).unwrap_err(),
            changed.remove_obstacle(count as usize).unwrap_err(),
        ];
        let said: Vec<String> = errors.iter().map(ToString::to_string).collect();
        assert!(said[0].contains("obstacle \"l1\"") && said[2] == said[0], "{said:?}");
        assert!(said[5].contains(&count.to_string()), "{said:?}");
        both.compare(&states);
    }
}

/// Points and boxes in one place after the other, some of no size, some far away.
fn replace_cloud(draw: &mut Draw, sensed: &mut SensedWorld) -> SensedWorld {
    let count = [0, 1, 40, 300][draw.below(4) as usize];
    let (about, spread) = (draw.vector() * 0.5, draw.size(1e-3, 1.5));
    let mut points: Vec<SensedPoint> = (0..count)
        .map(|k| {
            let radius = if k % 2 == 0 { 0.0 } else { draw.size(0.0, 0.05) };
            SensedPoint { centre: about + draw.vector() * spread, radius }
        })
        .collect();
    if draw.below(4) == 0 {
        points.push(SensedPoint { centre: glam::DVec3::new(1e7, -3.0, 2e5), radius: 1.0 });
    }
    if draw.below(2) == 0 {
        sensed.replace_points(&points).unwrap();
        return SensedWorld::of_points(&points).unwrap();
    }
    let centres: Vec<_> = points.iter().map(|point| point.centre).collect();
    let mut half = draw.vector().abs() * 0.05;
    half.z = if draw.below(2) == 0 { 0.0 } else { half.z };
    sensed.replace_boxes(half, &centres).unwrap();
    SensedWorld::of_boxes(half, &centres).unwrap()
}

#[test]
fn clouds_and_obstacles_that_change_are_met_as_those_made_anew() {
    let mut draw = seeded(43);
    let (mut seen, mut removed) = (0, 0);
    for round in 0..10 {
        let mut both = Both::new(&mut draw, [3, 70][round % 2]);
        let mut sensed = SensedWorld::default();
        for _ in 0..6 {
            let mut anew = replace_cloud(&mut draw, &mut sensed);
            for _ in 0..draw.below(3) {
                both.change(&mut draw);
            }
            let states: Vec<_> = (0..17).map(|_| state(&mut draw, &both.robot)).collect();
            if draw.below(2) == 0 {
                let own = both.changed.own_points(&states[0], &sensed, 0.02).unwrap();
                sensed.remove(&own);
                anew.remove(&own);
                removed += own.len();
                assert_eq!(sensed.points(), anew.points());
            }
            let cell = Workcell::new(both.robot.clone(), &both.world, &both.allowed).unwrap();
            let checker = StateChecker::new(cell).unwrap();
            let hits = checker.sensed_hits(&states, &anew, Par::Serial).unwrap();
            assert_eq!(both.changed.sensed_hits(&states, &sensed, Par::Pool).unwrap(), hits);
            let collides = |checker: &StateChecker, world| {
                checker.collides_with_sensed(&states, world, Par::Serial).unwrap()
            };
            assert_eq!(collides(&both.changed, &sensed), collides(&checker, &anew));
            both.compare(&states);
            seen += hits.len();
        }
    }
    assert!(seen > 200 && removed > 5, "{seen} {removed}");
}

#[test]
fn edges_in_a_changed_world_are_those_in_one_made_anew() {
    let mut draw = seeded(47);
    let mut kinds = [0; 3];
    for round in 0..12 {
        let mut both = Both::new(&mut draw, 4);
        let cell = Workcell::new(both.robot.clone(), &both.world, &both.allowed).unwrap();
        let mut edges = EdgeChecker::new(cell);
        for step in 0..6 {
            both.change(&mut draw);
            match (round + step) % 3 {
                0 => {
                    let world = &both.world;
                    edges
                        .set_cell(Workcell::new(both.robot.clone(), world, &both.allowed).unwrap());
                }
                1 => edges.set_cell(both.changed.cell().clone()),
                _ => edges.set_obstacles(&both.world.obstacles).unwrap(),
            }
            let cell = Workcell::new(both.robot.clone(), &both.world, &both.allowed).unwrap();
            let anew = EdgeChecker::new(cell);
            for _ in 0..4 {
                let (from, to) = (state(&mut draw, &both.robot), state(&mut draw, &both.robot));
                let path = JointPath::Straight([from, to]);
                let of = |checker: &EdgeChecker| {
                    [checker.check(&path, 300).unwrap(), checker.check_any(&path, 300).unwrap()]
                };
                let due = of(&anew);
                assert_eq!(of(&edges), due, "round {round}, step {step}");
                kinds[match due[0].answer {
                    EdgeAnswer::Free { .. } => 0,
                    EdgeAnswer::Hit { .. } => 1,
                    EdgeAnswer::Undecided { .. } => 2,
                }] += 1;
            }
        }
    }
    assert!(kinds[..2].iter().all(|&count| count > 10), "{kinds:?}");
}
