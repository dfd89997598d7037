//! What changes between steps: poses, objects, shapes, filters, ignored pairs.

use super::{Slot, check_count, check_reach};
use crate::{Filter, Handle, Motion, Object, ObjectRef, Pose, Revision, Scene, SceneError, Shape};
use std::ops::Range;
use std::sync::Arc;

impl Scene {
    /// Moves an object. To move a static one is legal, and costs the next step what it keeps of all
    /// static objects.
    ///
    /// # Errors
    /// There is no such object, or it would reach beyond [`crate::Aabb::LIMIT`]; nothing is changed
    /// then.
    pub fn set_pose(&mut self, object: impl ObjectRef, pose: Pose) -> Result<(), SceneError> {
        let i = object.index_in(self)?;
        check_reach(i, self.shape(i), &pose)?;
        self.poses[i] = pose;
        self.pose_revision.mark();
        if self.slots[i] == Slot::Holds(Motion::Static) {
            self.static_revision = Revision::draw();
        }
        Ok(())
    }

    /// Moves all objects: one pose for each slot, that of a free slot is not read. Static objects whose
    /// pose stays cost nothing.
    ///
    /// # Errors
    /// Not one pose a slot, or the first object that would reach beyond [`crate::Aabb::LIMIT`]; nothing
    /// is changed then.
    pub fn set_poses(&mut self, poses: &[Pose]) -> Result<(), SceneError> {
        if poses.len() != self.len() {
            return Err(SceneError::SlotsDiffer { given: poses.len(), slots: self.len() });
        }
        let mut moves_static = false;
        for (i, pose) in poses.iter().enumerate() {
            match self.slots[i] {
                Slot::Free => continue,
                Slot::Holds(Motion::Static) => moves_static |= !pose.is_identical(&self.poses[i]),
                Slot::Holds(Motion::Moving) => {}
            }
            check_reach(i, self.shape(i), pose)?;
        }
        let pairs = self.poses.iter_mut().zip(poses).zip(&self.slots);
        pairs.filter(|(_, slot)| **slot != Slot::Free).for_each(|((own, pose), _)| *own = *pose);
        self.pose_revision.mark();
        if moves_static {
            self.static_revision = Revision::draw();
        }
        Ok(())
    }

    /// Changes what an object may pair with, from the next step on.
    ///
    /// # Errors
    /// There is no such object.
    pub fn set_filter(&mut self, object: impl ObjectRef, filter: Filter) -> Result<(), SceneError> {
        let i = object.index_in(self)?;
        self.filters[i] = filter;
        self.filtered |= filter != Filter::ALL;
        Ok(())
    }

    /// Says whether an object moves from now on. It keeps its slot, its handle and its ignored pairs.
    ///
    /// # Errors
    /// There is no such object.
    pub fn set_motion(&mut self, object: impl ObjectRef, motion: Motion) -> Result<(), SceneError> {
        let i = object.index_in(self)?;
        let Slot::Holds(before) = self.slots[i] else { return Ok(()) };
        if before != motion {
            *self.count_of(before) -= 1;
            *self.count_of(motion) += 1;
            self.slots[i] = Slot::Holds(motion);
            (self.layout, self.static_revision) = (Revision::draw(), Revision::draw());
        }
        Ok(())
    }

    /// Makes an object a sensor, or solid, from the next step on.
    ///
    /// # Errors
    /// There is no such object.
    pub fn set_sensor(&mut self, object: impl ObjectRef, sensor: bool) -> Result<(), SceneError> {
        let i = object.index_in(self)?;
        self.note_sensor(i, sensor);
        Ok(())
    }

    /// Gives an object another of the scene's shapes. It keeps its slot, its handle and its ignored pairs.
    ///
    /// # Errors
    /// There is no such object or shape, or the object would reach beyond [`crate::Aabb::LIMIT`]; nothing
    /// is changed then.
    pub fn set_shape(&mut self, object: impl ObjectRef, shape: u32) -> Result<(), SceneError> {
        let i = object.index_in(self)?;
        check_reach(i, self.known_shape(i, shape)?, &self.poses[i])?;
        self.shape_of[i] = shape;
        if let Some(motion) = self.motion(i) {
            self.mark_change(motion);
        }
        Ok(())
    }

    /// Changes the caller's own number of an object.
    ///
    /// # Errors
    /// There is no such object.
    pub fn set_user_data(
        &mut self,
        object: impl ObjectRef,
        user_data: u64,
    ) -> Result<(), SceneError> {
        let i = object.index_in(self)?;
        self.user_data[i] = user_data;
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

    /// Takes an object out, with the pairs of it that were ignored. Its slot has an empty AABB until
    /// another object takes it.
    ///
    /// # Errors
    /// The object has been removed before; nothing is changed then.
    pub fn remove(&mut self, handle: Handle) -> Result<(), SceneError> {
        let i = self.index_of(handle)?;
        let Slot::Holds(motion) = self.slots[i] else { return Ok(()) };
        self.slots[i] = Slot::Free;
        *self.count_of(motion) -= 1;
        self.note_sensor(i, false);
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
            _ => Err(SceneError::StaleHandle { handle }),
        }
    }

    /// Adds shapes, and returns their indices. Costs what the new ones cost; those of a clone of this scene
    /// are shared, and copied once. What a pipeline remembers of pairs is forgotten.
    ///
    /// # Errors
    /// More shapes than a u32 counts; nothing is changed then.
    pub fn add_shapes(
        &mut self,
        shapes: impl IntoIterator<Item = Shape>,
    ) -> Result<Range<u32>, SceneError> {
        let new: Vec<Shape> = shapes.into_iter().collect();
        let first = self.shapes.len();
        check_count("shapes", first + new.len())?;
        // Both fit a u32.
        let added = first as u32..(first + new.len()) as u32;
        let shapes = Arc::make_mut(&mut self.shapes);
        if shapes.is_empty() {
            *shapes = new;
        } else {
            shapes.extend(new);
        }
        self.shape_history.add(self.shapes.len());
        self.layout = Revision::draw();
        Ok(added)
    }

    /// Ignores the pair of objects i and j, until one of them is removed: a robot's adjacent
    /// links, which are allowed to touch.
    ///
    /// # Errors
    /// One of them is not there, or both are one.
    pub fn ignore_pair(&mut self, i: impl ObjectRef, j: impl ObjectRef) -> Result<(), SceneError> {
        let (i, j) = self.two_objects(i, j)?;
        self.ignored.insert(i, j);
        Ok(())
    }

    /// Ignores all pairs of these objects, until they are removed: parts of one rigid body. Costs a number an
    /// object, not one a pair. An object is in one group at a time: the last one that names it.
    ///
    /// # Errors
    /// One of them is not there; nothing is changed then.
    pub fn ignore_among(&mut self, objects: &[usize]) -> Result<(), SceneError> {
        objects.iter().try_for_each(|&i| i.index_in(self).map(drop))?;
        // They are slots, which a u32 counts.
        let objects: Vec<u32> = objects.iter().map(|&i| i as u32).collect();
        self.ignored.group(&objects);
        Ok(())
    }

    /// Takes [`Scene::ignore_pair`] back, if it was said, and [`Scene::ignore_among`] for this pair: the other pairs
    /// of the group stay ignored.
    ///
    /// # Errors
    /// One of them is not there, or both are one.
    pub fn unignore_pair(
        &mut self,
        i: impl ObjectRef,
        j: impl ObjectRef,
    ) -> Result<(), SceneError> {
        let (i, j) = self.two_objects(i, j)?;
        self.ignored.remove(i, j);
        Ok(())
    }

    /// Puts an object in the slot that became free last or in a new one, which is returned; the revisions are the
    /// caller's matter.
    pub(super) fn place(&mut self, object: Object) -> Result<u32, SceneError> {
        let slot = self.free.last().map_or(self.slots.len(), |&slot| slot as usize);
        self.place_in(slot, object)?;
        self.free.pop();
        Ok(slot as u32)
    }

    /// Puts an object in a slot that holds none, or behind the last slot; the list of free slots and the revisions
    /// are the caller's matter.
    pub(super) fn place_in(&mut self, slot: usize, object: Object) -> Result<(), SceneError> {
        check_count("objects", slot)?;
        check_reach(slot, self.known_shape(slot, object.shape)?, &object.pose)?;
        self.put_in(slot, object);
        Ok(())
    }

    /// The same of an object that was checked: no shape is asked anything, which may be a caller's own and panic.
    pub(super) fn put_in(&mut self, slot: usize, object: Object) {
        let Object { shape, pose, filter, motion, sensor, user_data } = object;
        if slot < self.slots.len() {
            self.shape_of[slot] = shape;
            self.poses[slot] = pose;
            self.filters[slot] = filter;
            self.user_data[slot] = user_data;
            self.slots[slot] = Slot::Holds(motion);
        } else {
            self.shape_of.push(shape);
            self.poses.push(pose);
            self.filters.push(filter);
            self.sensors.push(false);
            self.user_data.push(user_data);
            self.slots.push(Slot::Holds(motion));
            self.generations.push(self.retired);
        }
        self.pose_revision.mark();
        self.note_sensor(slot, sensor);
        self.filtered |= filter != Filter::ALL;
        *self.count_of(motion) += 1;
    }

    pub(super) fn note_sensor(&mut self, slot: usize, sensor: bool) {
        let before = std::mem::replace(&mut self.sensors[slot], sensor);
        self.sensor_count = self.sensor_count + usize::from(sensor) - usize::from(before);
    }

    fn known_shape(&self, object: usize, shape: u32) -> Result<&Shape, SceneError> {
        let missing = SceneError::NoSuchShape { object, shape, shapes: self.shapes.len() };
        self.shapes.get(shape as usize).ok_or(missing)
    }

    fn two_objects(&self, i: impl ObjectRef, j: impl ObjectRef) -> Result<(u32, u32), SceneError> {
        let (i, j) = (i.index_in(self)?, j.index_in(self)?);
        if i == j {
            return Err(SceneError::SelfPair { object: i });
        }
        // Both are slots, which a u32 counts.
        Ok((i as u32, j as u32))
    }

    pub(super) fn count_of(&mut self, motion: Motion) -> &mut usize {
        match motion {
            Motion::Moving => &mut self.moving,
            Motion::Static => &mut self.statics,
        }
    }

    fn mark_change(&mut self, motion: Motion) {
        self.layout = Revision::draw();
        if motion == Motion::Static {
            self.static_revision = Revision::draw();
        }
    }
}
