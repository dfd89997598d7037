//! Objects that come and go with their shapes: the last ones exchanged, one replaced by the last.

use super::{Slot, check_count, check_reach};
use crate::{Object, ObjectRef, Revision, Scene, SceneError, Shape};
use dcd_simd::prefetch;
use std::sync::Arc;

impl Scene {
    /// Takes out the objects of all slots from `first` on and puts others there, in order, each with a shape of its
    /// own: [`Object::shape`] is not read. Free slots before `first` stay free. Shapes behind the last that an object before names are dropped, memory
    /// is kept. Costs what comes and goes.
    ///
    /// # Errors
    /// `first` beyond [`Scene::len`]; an object that would reach beyond [`crate::Aabb::LIMIT`], by its slot; more
    /// than a u32 counts. Nothing is changed then.
    pub fn replace_from<'a, I>(&mut self, first: usize, objects: I) -> Result<(), SceneError>
    where
        I: IntoIterator<Item = (&'a Shape, Object), IntoIter: Clone>,
    {
        if first > self.len() {
            return Err(SceneError::NoSuchObject { object: first, objects: self.len() });
        }
        let objects = objects.into_iter();
        // The shapes that come and those that go are anywhere in memory, and counted by atomics that wait.
        objects.clone().for_each(|(shape, _)| prefetch_shape(shape));
        let kept = self.shape_of[..first].iter().max().map_or(0, |&shape| shape as usize + 1);
        self.shapes.get(kept..).unwrap_or_default().iter().for_each(prefetch_shape);
        let mut count = 0;
        for (shape, object) in objects.clone() {
            check_reach(first + count, shape, &object.pose)?;
            if let Shape::Polytope(polytope) = shape {
                prefetch(polytope.vertices());
            }
            count += 1;
        }
        check_count("objects", first + count)?;
        check_count("shapes", kept + count)?;
        self.truncate(first);
        self.set_shapes_from(kept, objects.clone().map(|(shape, _)| shape.clone()));
        // All were checked.
        for (shape, (_, object)) in (kept as u32..).zip(objects) {
            self.put_in(self.len(), Object { shape, ..object });
        }
        self.mark_replaced();
        Ok(())
    }

    /// Takes an object out and gives its slot to the object of the last slot, which keeps its ignored pairs with no
    /// one. The shape goes too, where no other object names it: the last shape takes its index. Costs a look at
    /// every object's shape index.
    ///
    /// # Errors
    /// There is no such object, or the last slot is free; nothing is changed then.
    pub fn swap_remove(&mut self, object: impl ObjectRef) -> Result<(), SceneError> {
        let (i, last) = (object.index_in(self)?, self.len() - 1);
        let Some(motion) = self.motion(last) else {
            return Err(SceneError::NoSuchObject { object: last, objects: self.len() });
        };
        let shape = self.shape_of[i];
        let moved = Object {
            shape: self.shape_of[last],
            pose: self.poses[last],
            filter: self.filters[last],
            motion,
            sensor: self.sensors[last],
            user_data: self.user_data[last],
        };
        self.truncate(last);
        if i < last {
            // What was there goes the same way; the last one takes its place.
            self.vacate(i);
            self.put_in(i, moved);
        }
        if !self.shape_of.contains(&shape) {
            self.drop_shape(shape);
        }
        self.mark_replaced();
        Ok(())
    }

    /// Ends the lists of objects at a slot.
    fn truncate(&mut self, first: usize) {
        for slot in first..self.len() {
            if self.slots[slot] != Slot::Free {
                self.vacate(slot);
            }
            self.retired = self.retired.max(self.generations[slot]);
        }
        self.free.retain(|&slot| (slot as usize) < first);
        self.shape_of.truncate(first);
        self.poses.truncate(first);
        self.filters.truncate(first);
        self.sensors.truncate(first);
        self.user_data.truncate(first);
        self.slots.truncate(first);
        self.generations.truncate(first);
    }

    /// Takes the object out of a slot.
    fn vacate(&mut self, slot: usize) {
        if let Slot::Holds(motion) = std::mem::replace(&mut self.slots[slot], Slot::Free) {
            *self.count_of(motion) -= 1;
        }
        self.note_sensor(slot, false);
        self.ignored.forget(slot as u32);
        // A handle is taken for another's after as many exchanges as a u32 counts.
        self.generations[slot] = self.generations[slot].wrapping_add(1);
    }

    fn set_shapes_from(&mut self, kept: usize, new: impl Iterator<Item = Shape>) {
        match Arc::get_mut(&mut self.shapes) {
            Some(shapes) => {
                shapes.truncate(kept);
                shapes.extend(new);
            }
            None => {
                self.shapes = Arc::new(self.shapes[..kept].iter().cloned().chain(new).collect())
            }
        }
    }

    /// Drops a shape that no object names.
    fn drop_shape(&mut self, shape: u32) {
        let shapes = Arc::make_mut(&mut self.shapes);
        shapes.swap_remove(shape as usize);
        let last = shapes.len() as u32;
        self.shape_of.iter_mut().filter(|of| **of == last).for_each(|of| *of = shape);
    }

    /// What was derived from shapes and objects is stale.
    fn mark_replaced(&mut self) {
        self.shape_history.restart(self.shapes.len());
        (self.layout, self.static_revision) = (Revision::draw(), Revision::draw());
        self.pose_revision.mark();
    }
}

/// Fetches what a shape shares with its clones.
fn prefetch_shape(shape: &Shape) {
    if let Shape::Polytope(polytope) = shape {
        prefetch(std::slice::from_ref(&**polytope));
    }
}

#[cfg(test)]
mod tests {
    use crate::{Filter, Object, Pair, Pose, Scene, SceneError, Shape, Support, SupportMap};
    use glam::DVec3;
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    fn at(x: f64) -> Pose {
        Pose::from_translation(DVec3::X * x).unwrap()
    }

    fn sphere(radius: f64) -> Shape {
        Shape::sphere(radius).unwrap()
    }

    /// Spheres of these radii at these places, each its own shape.
    fn scene(spheres: &[(f64, f64)]) -> Scene {
        let (shapes, poses) = spheres.iter().map(|&(r, x)| (sphere(r), at(x))).unzip();
        Scene::one_each(shapes, poses).unwrap()
    }

    fn assert_same(a: &Scene, b: &Scene) {
        assert_eq!((a.len(), a.shapes().len()), (b.len(), b.shapes().len()));
        assert_eq!((a.object_count(), a.static_count()), (b.object_count(), b.static_count()));
        for i in 0..a.len() {
            assert_eq!((a.shape(i).reach(), a.poses()[i]), (b.shape(i).reach(), b.poses()[i]));
            assert_eq!((a.motion(i), a.filters()[i]), (b.motion(i), b.filters()[i]));
        }
        assert!(a.ignored_pairs().eq(b.ignored_pairs()));
    }

    #[test]
    fn exchanged_objects_are_those_of_a_scene_made_anew_and_old_handles_are_stale() {
        let mut exchanged = scene(&[(1.0, 0.0), (2.0, 5.0), (3.0, 9.0)]);
        exchanged.ignore_pair(0usize, 2usize).unwrap();
        exchanged.ignore_pair(0usize, 1usize).unwrap();
        let (first, second) = (exchanged.handle(0).unwrap(), exchanged.handle(2).unwrap());
        let before = (exchanged.layout(), exchanged.shape_revision());
        let clone = exchanged.clone();
        for news in [vec![], vec![(4.0, 1.0), (5.0, 2.0), (6.0, 3.0)], vec![(7.0, 8.0)]] {
            let shapes: Vec<Shape> = news.iter().map(|&(r, _)| sphere(r)).collect();
            let objects = shapes.iter().zip(&news).map(|(s, &(_, x))| (s, Object::new(9, at(x))));
            exchanged.replace_from(2, objects).unwrap();
            let all: Vec<_> = [(1.0, 0.0), (2.0, 5.0)].into_iter().chain(news).collect();
            let mut anew = scene(&all);
            anew.ignore_pair(0usize, 1usize).unwrap();
            assert_same(&exchanged, &anew);
            assert!(exchanged.index_of(first).is_ok() && exchanged.index_of(second).is_err());
        }
        assert!(before.0 != exchanged.layout());
        assert!(exchanged.shapes_since(before.1).is_none());
        assert!(clone.ignored_pairs().eq([Pair::new(0, 1), Pair::new(0, 2)]));
        assert_eq!(clone.shapes().len(), 3);
    }

    #[test]
    fn what_is_out_of_range_changes_nothing() {
        let mut held = scene(&[(1.0, 0.0), (2.0, 5.0)]);
        let (far, near) = (at(1e300), sphere(1.0));
        let objects = [(&near, Object::new(0, at(0.0))), (&near, Object::new(0, far))];
        let error = held.replace_from(1, objects).unwrap_err().to_string();
        assert!(error.contains('2'), "{error}");
        assert!(held.replace_from(3, []).is_err() && held.swap_remove(2usize).is_err());
        assert_same(&held, &scene(&[(1.0, 0.0), (2.0, 5.0)]));
    }

    /// A ball for as many supports as are left.
    #[derive(Debug)]
    struct Breaks(AtomicUsize);

    impl SupportMap<f64> for Breaks {
        fn support(&self, direction: DVec3) -> Support<f64> {
            assert!(self.0.fetch_sub(1, Relaxed) > 0, "on purpose");
            Support::of_point(direction.normalize_or_zero())
        }
    }

    #[test]
    fn an_exchange_in_which_a_shape_panics_changes_nothing() {
        let mut broken = 0;
        for supports in 0.. {
            let breaks = Arc::new(Breaks(AtomicUsize::new(usize::MAX / 2)));
            let shape = Shape::custom(breaks.clone()).unwrap();
            let mut held = scene(&[(1.0, 0.0), (2.0, 5.0), (3.0, 9.0)]);
            let before = (held.layout(), held.poses().to_vec());
            breaks.0.store(supports, Relaxed);
            let shapes = [sphere(4.0), shape, sphere(5.0)];
            let new = shapes.iter().map(|shape| (shape, Object::new(0, at(7.0))));
            let exchange = AssertUnwindSafe(|| held.replace_from(1, new).unwrap());
            if catch_unwind(exchange).is_ok() {
                assert_eq!((held.len(), held.object_count()), (4, 4));
                break;
            }
            broken += 1;
            assert_eq!((held.layout(), held.poses().to_vec()), before, "{supports}");
            assert_eq!(held.object_count(), 3);
        }
        assert!(broken > 0);
    }

    #[test]
    fn exchanged_objects_leave_free_slots_before_them_free() {
        let mut held = scene(&[(1.0, 0.0), (2.0, 5.0), (3.0, 9.0), (4.0, 7.0)]);
        let (gone, last) = (held.handle(0).unwrap(), held.handle(3).unwrap());
        held.remove(gone).unwrap();
        let small = sphere(0.5);
        let news = [at(100.0), at(200.0), at(1e300)].map(|pose| (&small, Object::new(0, pose)));
        let refused = held.replace_from(3, news).unwrap_err();
        assert!(matches!(refused, SceneError::OutOfRange { object: 5, .. }), "{refused}");
        assert!(held.len() == 4 && held.motion(0).is_none() && held.index_of(last).is_ok());
        held.replace_from(3, news.into_iter().take(2)).unwrap();
        assert_eq!((held.len(), held.object_count(), held.motion(0)), (5, 4, None));
        assert_eq!(held.poses()[3..], [at(100.0), at(200.0)]);
        assert!([gone, last].iter().all(|&handle| held.index_of(handle).is_err()));
        // They are the next to be taken.
        let next = held.insert(Object::new(0, at(0.0))).unwrap();
        assert_eq!(held.index_of(next), Ok(0));
        assert!(held.index_of(gone).is_err());
    }

    #[test]
    fn the_last_object_takes_the_slot_and_a_shape_in_use_stays() {
        let mut held = scene(&[(1.0, 0.0), (2.0, 5.0), (3.0, 9.0), (4.0, 7.0)]);
        held.set_filter(3usize, Filter { groups: 2, mask: 1 }).unwrap();
        held.ignore_pair(1usize, 0usize).unwrap();
        held.swap_remove(1usize).unwrap();
        let mut wanted = scene(&[(1.0, 0.0), (4.0, 7.0), (3.0, 9.0)]);
        wanted.set_filter(1usize, Filter { groups: 2, mask: 1 }).unwrap();
        assert_same(&held, &wanted);
        held.swap_remove(2usize).unwrap();
        assert_eq!((held.len(), held.shapes().len()), (2, 2));
        // Two objects of one shape.
        let shared = [0, 0, 1].map(|shape| Object::new(shape, at(f64::from(shape))));
        let mut shared = Scene::new(vec![sphere(1.0), sphere(2.0)], shared).unwrap();
        shared.swap_remove(0usize).unwrap();
        assert_eq!(shared.shape_of(), [1, 0]);
        shared.swap_remove(1usize).unwrap();
        assert_eq!((shared.shape_of(), shared.shape(0).reach()), (&[0][..], 2.0));
        shared.swap_remove(0usize).unwrap();
        assert!(shared.is_empty() && shared.shapes().is_empty());
    }
}
