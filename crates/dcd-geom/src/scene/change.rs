//! What changes between steps: poses, objects, shapes, pairs that are not told.

use super::{Slot, check_count, check_reach, derive_cores};
use crate::{Filter, Handle, Motion, Object, Pose, Scene, SceneError, Shape, Stamp};
use std::ops::Range;

impl Scene {
    /// Moves object `i`. To move a static object is legal, and costs the next step what it keeps
    /// of all static ones.
    ///
    /// # Errors
    /// There is no such object, or it would reach beyond [`crate::Aabb::LIMIT`]; nothing is changed
    /// then.
    pub fn set_pose(&mut self, i: usize, pose: Pose) -> Result<(), SceneError> {
        let motion = self.existing(i)?;
        check_reach(i, &self.shapes[self.shape_of[i] as usize], &pose)?;
        self.poses[i] = pose;
        if motion == Motion::Static {
            self.standing_stamp = Stamp::draw();
        }
        Ok(())
    }

    /// Adds an object, in the slot that became free last or in a new one. Nothing that is there
    /// moves.
    ///
    /// # Errors
    /// Those of [`Scene::new`], the index that of the slot; nothing is changed then.
    pub fn insert(&mut self, object: Object) -> Result<Handle, SceneError> {
        let index = self.place(object)?;
        self.mark_change(object.motion);
        Ok(Handle { index, generation: self.generations[index as usize] })
    }

    /// Takes an object out, with the pairs of it that were ignored. Its slot has an empty box until
    /// another object takes it.
    ///
    /// # Errors
    /// The object has been removed before; nothing is changed then.
    pub fn remove(&mut self, handle: Handle) -> Result<(), SceneError> {
        let i = self.index_of(handle)?;
        let motion = self.existing(i)?;
        self.slots[i] = Slot::Free;
        *self.count_of(motion) -= 1;
        self.ignored.forget(handle.index);
        // A slot that has had as many objects as a u32 counts is not used again.
        if let Some(next) = handle.generation.checked_add(1) {
            self.generations[i] = next;
            self.free.push(handle.index);
        }
        self.mark_change(motion);
        Ok(())
    }

    /// The handle of the object in slot `i`, if there is one.
    pub fn handle(&self, i: usize) -> Option<Handle> {
        self.motion(i)?;
        Some(Handle { index: u32::try_from(i).ok()?, generation: self.generations[i] })
    }

    /// The index of the object that the handle was given for.
    ///
    /// # Errors
    /// It has been removed.
    pub fn index_of(&self, handle: Handle) -> Result<usize, SceneError> {
        match self.handle(handle.index as usize) {
            Some(known) if known == handle => Ok(handle.index as usize),
            _ => Err(SceneError::NoLongerThere { handle }),
        }
    }

    /// Adds shapes, and returns their indices. What is derived from the shapes is derived anew, so
    /// that many at once cost little more than one.
    ///
    /// # Errors
    /// More shapes, or blocks of vertices, than a u32 counts; nothing is changed then.
    pub fn add_shapes(
        &mut self,
        shapes: impl IntoIterator<Item = Shape>,
    ) -> Result<Range<u32>, SceneError> {
        let all: Vec<Shape> = self.shapes.iter().cloned().chain(shapes).collect();
        let cores = derive_cores(&all)?;
        // Both fit a u32, or the cores would not have been made.
        let added = self.shapes.len() as u32..all.len() as u32;
        (self.shapes, self.cores, self.layout) = (all.into(), cores, Stamp::draw());
        Ok(added)
    }

    /// Never tells the pair of objects i and j, until one of them is removed: a robot's adjacent
    /// links, which are allowed to touch.
    ///
    /// # Errors
    /// One of them is not there, or both are one.
    pub fn ignore_pair(&mut self, i: usize, j: usize) -> Result<(), SceneError> {
        let (i, j) = self.two_objects(i, j)?;
        self.ignored.insert(i, j);
        Ok(())
    }

    /// Never tells a pair of these objects, until it is removed: parts of one rigid body. Costs a
    /// number an object, not one a pair. An object is in one group at a time: the last it was named
    /// in.
    ///
    /// # Errors
    /// One of them is not there; nothing is changed then.
    pub fn ignore_among(&mut self, objects: &[usize]) -> Result<(), SceneError> {
        objects.iter().try_for_each(|&i| self.existing(i).map(drop))?;
        // They are slots, which a u32 counts.
        let objects: Vec<u32> = objects.iter().map(|&i| i as u32).collect();
        self.ignored.group(&objects);
        Ok(())
    }

    /// Takes [`Scene::ignore_pair`] back, if it was said, and [`Scene::ignore_among`] for this pair.
    ///
    /// # Errors
    /// One of them is not there, or both are one.
    pub fn heed_pair(&mut self, i: usize, j: usize) -> Result<(), SceneError> {
        let (i, j) = self.two_objects(i, j)?;
        self.ignored.remove(i, j);
        Ok(())
    }

    /// Puts an object in its slot, which is returned; the stamps are the caller's matter.
    pub(super) fn place(&mut self, object: Object) -> Result<u32, SceneError> {
        let slot = self.free.last().map_or(self.slots.len(), |&slot| slot as usize);
        check_count("objects", slot)?;
        let Object { shape, pose, filter, motion } = object;
        let shapes = self.shapes.len();
        let known = self.shapes.get(shape as usize);
        let known = known.ok_or(SceneError::NoSuchShape { object: slot, shape, shapes })?;
        check_reach(slot, known, &pose)?;
        if self.free.pop().is_some() {
            self.shape_of[slot] = shape;
            self.poses[slot] = pose;
            self.filters[slot] = filter;
            self.slots[slot] = Slot::Holds(motion);
        } else {
            self.shape_of.push(shape);
            self.poses.push(pose);
            self.filters.push(filter);
            self.slots.push(Slot::Holds(motion));
            self.generations.push(0);
        }
        self.filtered |= filter != Filter::ALL;
        *self.count_of(motion) += 1;
        Ok(slot as u32)
    }

    fn existing(&self, i: usize) -> Result<Motion, SceneError> {
        let missing = SceneError::NoSuchObject { object: i, objects: self.len() };
        self.motion(i).ok_or(missing)
    }

    fn two_objects(&self, i: usize, j: usize) -> Result<(u32, u32), SceneError> {
        self.existing(i)?;
        self.existing(j)?;
        if i == j {
            return Err(SceneError::PairOfOne { object: i });
        }
        // Both are slots, which a u32 counts.
        Ok((i as u32, j as u32))
    }

    fn count_of(&mut self, motion: Motion) -> &mut usize {
        match motion {
            Motion::Moving => &mut self.moving,
            Motion::Static => &mut self.standing,
        }
    }

    fn mark_change(&mut self, motion: Motion) {
        self.layout = Stamp::draw();
        if motion == Motion::Static {
            self.standing_stamp = Stamp::draw();
        }
    }
}
