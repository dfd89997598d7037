//! What began, stayed and ended from one step to the next.

mod rows;

use crate::{QueryError, StepPairs};
use dcd_exec::{Exec, Segments};
use dcd_geom::{Handle, Pair, Scene};
use rows::Rows;

/// What became of a touching pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Change {
    /// They touched in the step before, and no longer do, or one of them has been removed.
    End,
    /// They touch, as in the step before.
    Stay,
    /// They touch, and did not in the step before.
    Begin,
}

/// A pair and what became of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Event {
    /// The object of the smaller index.
    pub a: Handle,
    /// The object of the larger index.
    pub b: Handle,
    /// What became of the two.
    pub change: Change,
}

impl Event {
    /// The objects' indices; that of an ended pair may have gone to other objects since.
    pub fn pair(&self) -> Pair {
        Pair { i: self.a.index, j: self.b.index }
    }
}

/// Compares each step's touching pairs with those of the step before.
///
/// The list depends on the two sets of pairs alone, and ascends by the objects' indices; where a
/// slot has changed hands, the old pair's end comes before the new pair's begin. O(objects + pairs)
/// but for sorting each object's own partners; allocates nothing after the first steps.
///
/// ```
/// use dcd_pipeline::prelude::*;
/// let poses = [0.0, 0.9, 2.1].map(|x| Pose::from_translation(DVec3::X * x));
/// let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 3], poses)?;
/// # let mut scene = scene;
/// let (mut pipeline, mut events) = (Pipeline::new(), Events::default());
/// events.follow(&scene, &pipeline.step(&scene, Par::Serial), Par::Serial)?;
/// assert_eq!(events.of(Change::Begin).count(), 1);
/// scene.set_pose(1, Pose::from_translation(DVec3::Z * 5.0)?)?;
/// events.follow(&scene, &pipeline.step(&scene, Par::Serial), Par::Serial)?;
/// assert_eq!(events.of(Change::End).map(|event| event.pair()).collect::<Vec<_>>(), [Pair { i: 0, j: 1 }]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Events {
    before: Touching,
    now: Touching,
    list: Segments<Event>,
}

/// The touching pairs of a step, object by object.
#[derive(Debug, Default)]
struct Touching {
    /// For each object its touching partners of larger index, ascending.
    partners: Rows,
    generations: Vec<u32>,
}

/// How many objects a task compares: some tens of microseconds.
const OBJECTS_PER_TASK: usize = 256;

impl Events {
    /// Takes in what a step found in that scene, and replaces the list. The first step's pairs all
    /// begin.
    ///
    /// # Errors
    /// The scene is another than the step's, or an object has come or gone since, or changed its shape; nothing is changed then.
    pub fn follow<'e>(
        &mut self,
        scene: &Scene,
        step: &impl StepPairs,
        exec: impl Into<Exec<'e>>,
    ) -> Result<&Self, QueryError> {
        check_layout(scene, step)?;
        Ok(self.follow_pairs(scene, || step.contact_pairs(), exec.into()))
    }

    /// The same of the pairs with a sensor ([`Step::sensor_pairs`](crate::Step::sensor_pairs)): what entered it, stayed and left. To be
    /// followed beside contacts, in a list of its own.
    ///
    /// # Errors
    /// Those of [`Events::follow`].
    pub fn follow_sensors<'e>(
        &mut self,
        scene: &Scene,
        step: &impl StepPairs,
        exec: impl Into<Exec<'e>>,
    ) -> Result<&Self, QueryError> {
        check_layout(scene, step)?;
        Ok(self.follow_pairs(scene, || step.pairs_with_sensors(), exec.into()))
    }

    fn follow_pairs<P: Iterator<Item = (u32, u32)>>(
        &mut self,
        scene: &Scene,
        pairs: impl Fn() -> P,
        exec: Exec,
    ) -> &Self {
        std::mem::swap(&mut self.before, &mut self.now);
        self.now.generations.clear();
        self.now.generations.extend_from_slice(scene.generations());
        self.now.partners.fill(scene.len(), pairs, exec);
        let (before, now) = (&self.before, &self.now);
        let objects = before.generations.len().max(now.generations.len());
        self.list.fill(exec, objects.div_ceil(OBJECTS_PER_TASK), |task, list| {
            for i in (OBJECTS_PER_TASK * task..objects).take(OBJECTS_PER_TASK) {
                compare(i as u32, before, now, list);
            }
        });
        self
    }

    /// The events of the last step, in order.
    pub fn iter(&self) -> impl Iterator<Item = Event> + use<'_> {
        self.list.iter().flatten().copied()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there is none: nothing touches, and nothing did.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Those of one kind, in order.
    pub fn of(&self, change: Change) -> impl Iterator<Item = Event> + use<'_> {
        self.iter().filter(move |event| event.change == change)
    }
}

impl Touching {
    fn event(&self, i: u32, j: u32, change: Change) -> Event {
        let handle = |index: u32| Handle { index, generation: self.generations[index as usize] };
        Event { a: handle(i), b: handle(j), change }
    }
}

/// Refuses a scene that has other slots than the step's had.
fn check_layout(scene: &Scene, step: &impl StepPairs) -> Result<(), QueryError> {
    if step.layout() == scene.layout() { Ok(()) } else { Err(QueryError::SceneChanged) }
}

/// Appends the events of object i with those of larger index.
fn compare(i: u32, before: &Touching, now: &Touching, list: &mut Vec<Event>) {
    let (mut old, mut new) = (before.partners.row(i as usize), now.partners.row(i as usize));
    loop {
        let (ended, touches) = match (old.first(), new.first()) {
            (None, None) => return,
            (Some(&j), None) => (Some(j), None),
            (None, Some(&j)) => (None, Some(j)),
            (Some(&was), Some(&is)) => ((was <= is).then_some(was), (is <= was).then_some(is)),
        };
        old = &old[usize::from(ended.is_some())..];
        new = &new[usize::from(touches.is_some())..];
        let ended = ended.map(|j| before.event(i, j, Change::End));
        match (ended, touches.map(|j| now.event(i, j, Change::Begin))) {
            (Some(was), Some(is)) if (was.a, was.b) == (is.a, is.b) => {
                list.push(Event { change: Change::Stay, ..is });
            }
            (was, is) => list.extend(was.into_iter().chain(is)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AnyPipeline, Par, Pipeline, Question};
    use dcd_geom::{Object, Pose, Shape, glam::DVec3};

    fn at(x: f64) -> Pose {
        Pose::from_translation(DVec3::X * x).unwrap()
    }

    #[test]
    fn a_pair_begins_stays_and_ends() {
        let sphere = Shape::sphere(0.5).unwrap();
        let mut scene =
            Scene::new(vec![sphere], [0.0, 0.9, 5.0].map(|x| Object::new(0, at(x)))).unwrap();
        let (mut pipeline, mut events) = (Pipeline::new(), Events::default());
        let mut reported = |scene: &Scene| -> Vec<(u32, u32, Change)> {
            let step = pipeline.step(scene, Par::Serial);
            let events = events.follow(scene, &step, Par::Serial).unwrap();
            assert_eq!(events.iter().count(), events.len());
            events.iter().map(|e| (e.a.index, e.b.index, e.change)).collect()
        };
        assert_eq!(reported(&scene), [(0, 1, Change::Begin)]);
        scene.set_pose(2, at(-0.9)).unwrap();
        assert_eq!(reported(&scene), [(0, 1, Change::Stay), (0, 2, Change::Begin)]);
        scene.set_pose(1, at(9.0)).unwrap();
        assert_eq!(reported(&scene), [(0, 1, Change::End), (0, 2, Change::Stay)]);
        scene.set_pose(0, at(7.0)).unwrap();
        assert_eq!(reported(&scene), [(0, 2, Change::End)]);
        assert_eq!(reported(&scene), []);
    }

    #[test]
    fn a_slot_that_changes_hands_ends_one_pair_and_begins_another() {
        let sphere = Shape::sphere(0.5).unwrap();
        let objects = [0.0, 0.5, 1.0].map(|x| Object::new(0, at(x)));
        let mut scene = Scene::new(vec![sphere], objects).unwrap();
        let (mut pipeline, mut events) = (Pipeline::new(), Events::default());
        events.follow(&scene, &pipeline.step(&scene, Par::Serial), Par::Serial).unwrap();
        let old = scene.handle(1).unwrap();
        scene.remove(old).unwrap();
        let new = scene.insert(Object::new(0, at(0.5))).unwrap();
        events.follow(&scene, &pipeline.step(&scene, Par::Serial), Par::Serial).unwrap();
        let (first, last) = (scene.handle(0).unwrap(), scene.handle(2).unwrap());
        let event = |a, b, change| Event { a, b, change };
        let expected = [
            event(first, old, Change::End),
            event(first, new, Change::Begin),
            event(first, last, Change::Stay),
            event(old, last, Change::End),
            event(new, last, Change::Begin),
        ];
        assert_eq!(events.iter().collect::<Vec<_>>(), expected);
        assert_eq!(events.of(Change::Stay).collect::<Vec<_>>(), [expected[2]]);

        // A scene that has fewer slots ends what the others had.
        let empty = Scene::default();
        events.follow(&empty, &pipeline.step(&empty, Par::Serial), Par::Serial).unwrap();
        assert!(events.len() == 3 && events.of(Change::End).count() == 3);
    }

    #[test]
    fn a_scene_that_is_not_the_steps_is_refused_and_changes_nothing() {
        let sphere = Shape::sphere(0.5).unwrap();
        let objects = [0.0, 0.5, 1.25].map(|x| Object::new(0, at(x)));
        let mut scene = Scene::new(vec![sphere], objects).unwrap();
        let mut pipeline = AnyPipeline::new(Question::default()).unwrap();
        let (mut events, mut sensed) = (Events::default(), Events::default());
        let step = pipeline.step(&scene, Par::Serial);
        assert_eq!(events.follow(&scene, &step, Par::Serial).map(Events::len), Ok(2));
        let other = Scene::default();
        // Where it stands may have changed since.
        scene.set_pose(2, at(9.0)).unwrap();
        assert_eq!(events.follow(&scene, &step, Par::Serial).map(Events::len), Ok(2));
        let last = scene.handle(2).unwrap();
        scene.remove(last).unwrap();
        for scene in [&scene, &other] {
            let changed = QueryError::SceneChanged;
            assert_eq!(events.follow(scene, &step, Par::Serial).err(), Some(changed));
            assert_eq!(sensed.follow_sensors(scene, &step, Par::Serial).err(), Some(changed));
        }
        assert!(events.of(Change::Stay).count() == 2 && sensed.is_empty());
    }
}
