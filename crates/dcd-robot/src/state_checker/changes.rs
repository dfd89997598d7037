//! Worlds that change while the robot stays.

use super::StateChecker;
use crate::{Obstacle, RobotError, Workcell};
use dcd_geom::{Pose, SceneError};
use dcd_gjk::Overlap;
use dcd_pipeline::StaticWorld;
use std::sync::PoisonError;

impl StateChecker {
    /// Checks among other obstacles from now on: [`Workcell::set_obstacles`]. The robot, what it carries and its pairs
    /// stay as they are prepared, and memory is used again.
    ///
    /// # Errors
    /// Those of [`Workcell::set_obstacles`] and [`StateChecker::new`]; nothing is changed then.
    pub fn set_obstacles(&mut self, obstacles: &[Obstacle]) -> Result<(), RobotError> {
        self.check_obstacles(obstacles.len())?;
        self.prepared.set_obstacles(obstacles)?;
        self.forget_obstacles();
        Ok(())
    }

    /// Checks against another obstacle too: [`Workcell::add_obstacle`]. Returns its place among the obstacles.
    ///
    /// # Errors
    /// Those of [`Workcell::add_obstacle`] and [`StateChecker::new`]; nothing is changed then.
    pub fn add_obstacle(&mut self, obstacle: &Obstacle) -> Result<usize, RobotError> {
        self.check_obstacles(self.cell().obstacles().len() + 1)?;
        let place = self.prepared.add_obstacle(obstacle)?;
        self.forget_obstacles();
        Ok(place)
    }

    /// Moves an obstacle, by its place among the obstacles: [`Workcell::move_obstacle`]. Costs no more in a world of
    /// many, but for a tree over all their boxes from time to time.
    ///
    /// # Errors
    /// Those of [`Workcell::move_obstacle`]; nothing is changed then.
    pub fn move_obstacle(&mut self, place: usize, pose: Pose) -> Result<(), RobotError> {
        self.prepared.move_obstacle(place, pose)?;
        let moved = self.world.get_mut().is_none_or(|world| world.set_pose(place, pose).is_ok());
        if !moved {
            self.forget_obstacles();
        }
        Ok(())
    }

    /// Takes an obstacle away, by its place among the obstacles, which the last one takes:
    /// [`Workcell::remove_obstacle`].
    ///
    /// # Errors
    /// Those of [`Workcell::remove_obstacle`].
    pub fn remove_obstacle(&mut self, place: usize) -> Result<(), RobotError> {
        self.prepared.remove_obstacle(place)?;
        self.forget_obstacles();
        Ok(())
    }

    /// What was prepared of the obstacles for single pairs is stale.
    pub(super) fn forget_obstacles(&mut self) {
        if let Some(world) = self.world.take() {
            let old = self.old_world.get_mut().unwrap_or_else(PoisonError::into_inner);
            *old = Some(world);
        }
    }

    /// The obstacles, prepared for single pairs.
    pub(super) fn new_world(&self) -> Result<StaticWorld, SceneError> {
        let (scene, obstacles) = (self.cell().scene(), self.cell().obstacles());
        let old = self.old_world.lock().unwrap_or_else(PoisonError::into_inner).take();
        match old {
            Some(mut world) => world.replace_for_pairs(scene, obstacles).map(|()| world),
            None => StaticWorld::for_pairs(scene, obstacles, Overlap::default()),
        }
    }

    /// Refuses more objects than a u32 counts, with so many obstacles.
    fn check_obstacles(&self, count: usize) -> Result<(), RobotError> {
        let cell = self.cell();
        Self::check_objects(cell.scene().len() - cell.obstacles().len() + count)
    }
}

impl Workcell {
    /// Whether the obstacles are the same and unchanged since one cell was cloned from the other.
    pub(super) fn has_obstacles_of(&self, other: &Self) -> bool {
        let (own, other) = (self.scene(), other.scene());
        own.layout() == other.layout() && own.statics() == other.statics()
    }
}

#[cfg(test)]
mod tests;
