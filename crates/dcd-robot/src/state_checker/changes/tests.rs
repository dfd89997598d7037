//! Worlds that change beside worlds made anew.

use super::super::tests::{Draw, robot, shape, state};
use super::*;
use crate::{AllowedPairs, Padding, Robot, World};
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
        match draw.below(9) {
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
    let mut draw = Draw(11);
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
