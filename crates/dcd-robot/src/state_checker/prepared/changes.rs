//! Obstacles that change: what is kept of them follows, and nothing else is computed.

use super::super::obstacle_tree::ObstacleTree;
use super::super::packed_aabbs::PackedAabbs;
use super::super::solids::Solid;
use super::Prepared;
use crate::{Obstacle, RobotError};
use dcd_geom::Pose;

/// How many blocks of vertices there may be beside twice as many as obstacles can have: those of obstacles that went
/// stay. Larger: more memory. Smaller: all obstacles are taken up again more often.
const SPARE: usize = 64;

impl Prepared {
    /// Exchanges all obstacles.
    pub(in super::super) fn set_obstacles(&mut self, new: &[Obstacle]) -> Result<(), RobotError> {
        self.cell.set_obstacles(new)?;
        self.take_all();
        Ok(())
    }

    /// Adds an obstacle behind the others, and returns its place.
    pub(in super::super) fn add_obstacle(&mut self, new: &Obstacle) -> Result<usize, RobotError> {
        let place = self.cell.add_obstacle(new)?;
        if self.bodies_moved() {
            self.take_all();
            return Ok(place);
        }
        let object = self.obstacles().start + place;
        let (solid, aabb) = self.solid(object);
        PackedAabbs::put(&mut self.boxes, place, &aabb, &solid);
        self.aabbs.push(aabb);
        self.solids.push(solid);
        self.note_filters();
        self.note_in_tree(place);
        Ok(place)
    }

    /// Moves an obstacle.
    pub(in super::super) fn move_obstacle(
        &mut self,
        place: usize,
        pose: Pose,
    ) -> Result<(), RobotError> {
        self.cell.move_obstacle(place, pose)?;
        let object = self.obstacles().start + place;
        // Of the same shape there are as many blocks.
        let (held, first) = (self.solids[place].corner_range(), self.corners.len());
        let (solid, aabb) = self.solid(object);
        self.corners.copy_within(first.., held.start);
        self.corners.truncate(first);
        self.put(place, aabb, solid.with_corners(held.start));
        self.note_in_tree(place);
        Ok(())
    }

    /// Takes an obstacle away, whose place the last one takes.
    pub(in super::super) fn remove_obstacle(&mut self, place: usize) -> Result<(), RobotError> {
        self.cell.remove_obstacle(place)?;
        let count = self.solids.len();
        if self.bodies_moved() || self.corners.len() > 8 * count + SPARE {
            self.take_all();
            return Ok(());
        }
        let last = (self.aabbs.pop(), self.solids.pop());
        PackedAabbs::drop_last(&mut self.boxes, count);
        self.note_filters();
        if let Some(tree) = &mut self.tree {
            tree.forget(count as u32 - 1);
        }
        if let (Some(aabb), Some(solid)) = last
            && place + 1 < count
        {
            self.put(place, aabb, solid);
            self.note_in_tree(place);
        }
        Ok(())
    }

    fn put(&mut self, place: usize, aabb: dcd_geom::Aabb, solid: Solid) {
        PackedAabbs::put(&mut self.boxes, place, &aabb, &solid);
        (self.aabbs[place], self.solids[place]) = (aabb, solid);
    }

    /// Follows a change in the tree, or builds a new one.
    fn note_in_tree(&mut self, place: usize) {
        if let Some(tree) = &mut self.tree {
            tree.change(place as u32);
        }
        if self.tree.as_ref().is_none_or(ObstacleTree::is_worn) {
            self.tree = ObstacleTree::of(&self.aabbs);
        }
    }

    /// Whether padded bodies, which are behind the obstacles in the scene, have other objects now.
    fn bodies_moved(&self) -> bool {
        self.cell.is_padded()
    }

    fn take_all(&mut self) {
        if self.bodies_moved() {
            self.bodies = super::bodies(&self.cell);
        }
        self.take_obstacles();
    }
}
