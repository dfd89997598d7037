//! Obstacles that come, move and go, while the robot stays.

use super::{Workcell, obstacle_object, obstacle_user};
use crate::{Obstacle, RobotError};
use dcd_geom::Pose;
use dcd_simd::prefetch;
use std::ops::Range;

impl Workcell {
    /// Exchanges all obstacles: the cell that [`Workcell::new`] makes of a world that differs in its obstacles alone.
    /// The robot, what it carries, padding and allowed pairs stay, the latter by name: what was said of the name
    /// of an obstacle holds for a new one of that name. Costs what the new ones cost, where no link is padded and
    /// no obstacle is named in an allowed pair; else the scene is made anew.
    ///
    /// # Errors
    /// An obstacle out of range, or with the name of a link or of what the robot carries; nothing is changed then.
    pub fn set_obstacles(&mut self, obstacles: &[Obstacle]) -> Result<(), RobotError> {
        // The names that come and those that go are anywhere in memory: they are fetched beside each other.
        let first = self.obstacles().start;
        self.names[first..].iter().for_each(|name| prefetch(name.as_bytes()));
        obstacles.iter().for_each(|obstacle| prefetch(obstacle.name.as_bytes()));
        for obstacle in obstacles {
            self.check_name(&obstacle.name)?;
        }
        if !self.stays_unfiltered(obstacles) {
            return self.rebuild(obstacles);
        }
        let objects = obstacles.iter().map(|o| (&o.shape, obstacle_object(0, o.pose)));
        let user = |object: usize| obstacle_user(&obstacles[object - first].name);
        let replaced = self.scene.replace_from(first, objects);
        replaced.map_err(|error| RobotError::of_scene(error, user))?;
        self.names.truncate(first + obstacles.len());
        let held = self.names.len() - first;
        for (name, obstacle) in self.names[first..].iter_mut().zip(obstacles) {
            name.clone_from(&obstacle.name);
        }
        self.names.extend(obstacles[held..].iter().map(|obstacle| obstacle.name.clone()));
        self.first_padded = self.names.len();
        Ok(())
    }

    /// Adds an obstacle behind the others, and returns its place among them. Costs as [`Workcell::set_obstacles`] of
    /// that one.
    ///
    /// # Errors
    /// Those of [`Workcell::set_obstacles`].
    pub fn add_obstacle(&mut self, obstacle: &Obstacle) -> Result<usize, RobotError> {
        self.check_name(&obstacle.name)?;
        let place = self.obstacles().len();
        if !self.stays_unfiltered(std::slice::from_ref(obstacle)) {
            let mut all = self.all_obstacles();
            all.push(obstacle.clone());
            return self.rebuild(&all).map(|()| place);
        }
        let object = (&obstacle.shape, obstacle_object(0, obstacle.pose));
        let added = self.scene.replace_from(self.scene.len(), [object]);
        added.map_err(|error| RobotError::of_scene(error, |_| obstacle_user(&obstacle.name)))?;
        self.names.push(obstacle.name.clone());
        self.first_padded = self.names.len();
        Ok(place)
    }

    /// Moves an obstacle, by its place among the obstacles.
    ///
    /// # Errors
    /// There is no such obstacle, or it would be out of range; nothing is changed then.
    pub fn move_obstacle(&mut self, place: usize, pose: Pose) -> Result<(), RobotError> {
        let object = self.obstacle(place)?;
        let moved = self.scene.set_pose(object, pose);
        moved.map_err(|error| RobotError::of_scene(error, |object| self.user(object)))
    }

    /// Takes an obstacle away, by its place among the obstacles: the last obstacle takes that place. Costs what
    /// comes to a look at each obstacle; where [`Workcell::set_obstacles`] makes the scene anew, as much as that.
    ///
    /// # Errors
    /// There is no such obstacle.
    pub fn remove_obstacle(&mut self, place: usize) -> Result<(), RobotError> {
        let object = self.obstacle(place)?;
        if !self.stays_unfiltered(&[]) {
            let mut all = self.all_obstacles();
            all.swap_remove(place);
            return self.rebuild(&all);
        }
        self.scene.swap_remove(object).map_err(RobotError::Scene)?;
        self.names.swap_remove(object);
        self.first_padded = self.names.len();
        Ok(())
    }

    /// The objects of the scene that are obstacles.
    pub fn obstacles(&self) -> Range<usize> {
        self.robot.parts().len()..self.first_padded
    }

    /// The object of an obstacle.
    fn obstacle(&self, place: usize) -> Result<usize, RobotError> {
        let objects = self.obstacles();
        if place < objects.len() {
            Ok(objects.start + place)
        } else {
            Err(RobotError::NoSuchObstacle { place, obstacles: objects.len() })
        }
    }

    /// The obstacles as they were given.
    fn all_obstacles(&self) -> Vec<Obstacle> {
        let obstacle = |i: usize| Obstacle {
            name: self.names[i].clone(),
            shape: self.scene.shape(i).clone(),
            pose: self.scene.poses()[i],
        };
        self.obstacles().map(obstacle).collect()
    }

    /// Whether a filter or an ignored pair may speak of an obstacle; where not, every body of the robot meets them all.
    pub(crate) fn filters_obstacles(&self) -> bool {
        self.is_padded() || self.obstacles_named
    }

    /// Refuses the name of a link or of what the robot carries.
    fn check_name(&self, name: &str) -> Result<(), RobotError> {
        if self.known.get(&self.robot, name) == Some(true) {
            Err(self.robot.has_name(name))
        } else {
            Ok(())
        }
    }

    /// Whether nothing is said of any obstacle, of these neither, nor of any by default: then obstacles are the last
    /// objects, and in no ignored pair.
    fn stays_unfiltered(&self, new: &[Obstacle]) -> bool {
        self.padded.is_empty()
            && !self.obstacles_named
            && !new.iter().any(|obstacle| self.known.get(&self.robot, &obstacle.name).is_some())
    }

    /// Makes the scene anew.
    fn rebuild(&mut self, obstacles: &[Obstacle]) -> Result<(), RobotError> {
        let larger = (self.first_padded..self.scene.len()).map(|i| self.scene.shape(i).clone());
        let larger = (self.padded.clone(), larger.collect());
        let (robot, known) = (self.robot.clone(), self.known.clone());
        let poses = self.scene.poses()[..self.obstacles().start].to_vec();
        *self = Self::assemble((robot, poses), obstacles, larger, known)?;
        Ok(())
    }
}
