//! Shapes and the objects that place them.

mod change;
mod ignored;
mod object;
mod pair_set;
mod replace;
mod swept;
#[cfg(test)]
mod tests;

use object::LazyRevision;
pub use object::{Filter, Handle, Motion, Object, ObjectRef, Revision};

use crate::{Aabb, Pose, SceneError, Shape};
use ignored::IgnoredPairs;
use std::sync::Arc;

/// Shapes, and objects that place them: the input of a step, valid by construction.
///
/// An object has a slot until it is removed: its index in everything that a step reports.
/// Objects come and go by [`Scene::insert`] and [`Scene::remove`]; a free slot has an empty AABB,
/// is in no pair, and is taken by the next object.
///
/// ```
/// use dcd_geom::glam::DVec3;
/// use dcd_geom::{Object, Pose, Scene, Shape};
/// let shapes = vec![Shape::cuboid(DVec3::splat(0.5))?, Shape::sphere(0.2)?];
/// // Objects name shapes; several may share one.
/// let mut scene = Scene::new(shapes, [Object::new(0, Pose::IDENTITY).fixed()])?;
/// let ball = scene.insert(Object::new(1, Pose::from_translation(DVec3::Z)?).with_user_data(7))?;
/// scene.set_pose(ball, Pose::from_translation(DVec3::Z * 2.0)?)?;
/// assert_eq!((scene.object_count(), scene.static_count()), (2, 1));
/// scene.remove(ball)?;
/// assert!(scene.set_pose(ball, Pose::IDENTITY).is_err()); // a handle of what is gone
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Scene {
    shapes: Arc<Vec<Shape>>,
    shape_history: ShapeHistory,
    shape_of: Vec<u32>,
    poses: Vec<Pose>,
    filters: Vec<Filter>,
    sensors: Vec<bool>,
    user_data: Vec<u64>,
    slots: Vec<Slot>,
    generations: Vec<u32>,
    /// The generation of a new slot: above those of all slots that were taken away.
    retired: u32,
    /// The slots to be taken again, the last one first.
    free: Vec<u32>,
    ignored: IgnoredPairs,
    filtered: bool,
    sensor_count: usize,
    moving: usize,
    statics: usize,
    layout: Revision,
    static_revision: Revision,
    pose_revision: LazyRevision,
}

/// The latest revisions of a list of shapes that only grows, each with the number of shapes it had.
#[derive(Clone, Debug)]
struct ShapeHistory(Vec<(Revision, usize)>);

/// How many revisions are remembered. Larger: who follows a list from far behind saves deriving all of it.
const REVISIONS: usize = 8;

impl Default for ShapeHistory {
    /// The revision of an empty list.
    fn default() -> Self {
        Self(vec![(Revision::default(), 0)])
    }
}

impl ShapeHistory {
    fn add(&mut self, count: usize) {
        self.0.push((Revision::draw(), count));
        let surplus = self.0.len().saturating_sub(REVISIONS);
        self.0.drain(..surplus);
    }

    /// For a list that is not the old one with more behind it.
    fn restart(&mut self, count: usize) {
        self.0.clear();
        self.add(count);
    }

    fn last(&self) -> Revision {
        self.0.last().map_or(Revision::default(), |&(revision, _)| revision)
    }

    fn count_at(&self, known: Revision) -> Option<usize> {
        let then = self.0.iter().rev().find(|(revision, _)| *revision == known);
        then.map(|&(_, count)| count)
    }
}

/// The content of a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slot {
    Holds(Motion),
    Free,
}

impl Scene {
    /// Shapes, shared by the objects that name them.
    ///
    /// # Errors
    /// An object whose shape does not exist or that reaches beyond [`Aabb::LIMIT`]; more shapes or
    /// objects than a u32 counts.
    pub fn new(
        shapes: Vec<Shape>,
        objects: impl IntoIterator<Item = Object>,
    ) -> Result<Self, SceneError> {
        let mut scene = Self::default();
        scene.add_shapes(shapes)?;
        for object in objects {
            scene.place(object)?;
        }
        (scene.layout, scene.static_revision) = (Revision::draw(), Revision::draw());
        Ok(scene)
    }

    /// One object for each shape, in order, as in the paper's scenes.
    ///
    /// # Errors
    /// Those of [`Scene::new`], and lengths that differ.
    pub fn one_each(shapes: Vec<Shape>, poses: Vec<Pose>) -> Result<Self, SceneError> {
        if shapes.len() != poses.len() {
            return Err(SceneError::LengthsDiffer { shapes: shapes.len(), poses: poses.len() });
        }
        Self::new(shapes, (0u32..).zip(poses).map(|(shape, pose)| Object::new(shape, pose)))
    }

    /// How many slots there are: one more than the largest index of an object.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Whether there is no slot.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// How many objects there are, moving and static.
    pub fn object_count(&self) -> usize {
        self.moving + self.statics
    }

    /// How many of them are static.
    pub fn static_count(&self) -> usize {
        self.statics
    }

    /// Whether slot `i` holds a moving object, a static one, or none.
    #[inline]
    pub fn motion(&self, i: usize) -> Option<Motion> {
        match self.slots.get(i) {
            Some(&Slot::Holds(motion)) => Some(motion),
            _ => None,
        }
    }

    /// The shapes.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The revision of the shapes: data derived from them is valid while it is equal.
    pub fn shape_revision(&self) -> Revision {
        self.shape_history.last()
    }

    /// The shapes that were added since the list had that revision, the newest last. `None` where it never had
    /// it, or had it many changes ago: then what was derived from the shapes has to be derived anew.
    pub fn shapes_since(&self, known: Revision) -> Option<&[Shape]> {
        self.shapes.get(self.shape_history.count_at(known)?..)
    }

    /// For each slot the index of its shape; that of the last object where it is free.
    pub fn shape_of(&self) -> &[u32] {
        &self.shape_of
    }

    /// For each slot its pose; that of the last object where it is free.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// For each slot its filter.
    pub fn filters(&self) -> &[Filter] {
        &self.filters
    }

    /// For each slot the caller's own number: see [`Object::user_data`].
    pub fn user_data(&self) -> &[u64] {
        &self.user_data
    }

    /// For each slot whether it holds a sensor: see [`Object::sensor`].
    pub fn sensors(&self) -> &[bool] {
        &self.sensors
    }

    /// Whether any object is a sensor.
    pub fn has_sensors(&self) -> bool {
        self.sensor_count > 0
    }

    /// The pairs that [`Scene::ignore_pair`] named, and those among [`Scene::ignore_among`], once
    /// each, ascending.
    pub fn ignored_pairs(&self) -> impl Iterator<Item = crate::Pair> {
        self.ignored.iter()
    }

    /// For each slot how many objects have left it: see [`Handle`].
    pub fn generations(&self) -> &[u32] {
        &self.generations
    }

    /// The shape of object `i`, which must be below [`Scene::len`].
    #[inline]
    pub fn shape(&self, i: usize) -> &Shape {
        &self.shapes[self.shape_of[i] as usize]
    }

    /// Which of [`Scene::shapes`] object `i` has, which must be below [`Scene::len`].
    #[inline]
    pub fn shape_index(&self, i: usize) -> u32 {
        self.shape_of[i]
    }

    /// Marks everything but poses and filters: the shapes, and which slot holds what.
    pub fn layout(&self) -> Revision {
        self.layout
    }

    /// Marks everything about the static objects, their poses included.
    pub fn statics(&self) -> Revision {
        self.static_revision
    }

    /// Marks the poses of all objects: drawn at the first call after a pose was set.
    pub fn pose_revision(&self) -> Revision {
        self.pose_revision.get()
    }

    /// Whether [`Scene::allows`] may refuse some pair of slots.
    pub fn is_filtered(&self) -> bool {
        self.filters_movers() || self.statics > 1 || self.object_count() < self.len()
    }

    /// Whether it may refuse a pair with a moving object in it: filters other than
    /// [`Filter::ALL`], or ignored pairs.
    pub fn filters_movers(&self) -> bool {
        self.filtered || !self.ignored.is_empty()
    }

    /// Whether two slots may pair: both hold objects, not both static ones, whose filters agree
    /// and whose pair is not ignored.
    #[inline]
    pub fn allows(&self, i: u32, j: u32) -> bool {
        let moves = match (self.slots[i as usize], self.slots[j as usize]) {
            (Slot::Free, _) | (_, Slot::Free) => false,
            (a, b) => a != Slot::Holds(Motion::Static) || b != Slot::Holds(Motion::Static),
        };
        moves
            && self.filters[i as usize].allows(self.filters[j as usize])
            && !self.ignored.contains(i, j)
    }

    /// Whether another scene filters the objects of these indices as this one does and ignores the same pairs
    /// by the same calls: then both allow the same pairs of them. Compares lists; where it says no, they still
    /// may.
    pub fn has_same_filters(&self, other: &Self, objects: std::ops::Range<usize>) -> bool {
        let own = self.filters.get(objects.clone());
        self.ignored == other.ignored && own == other.filters.get(objects)
    }

    /// The AABB of object `i`: see [`Shape::aabb`]. Empty where the slot is free.
    pub fn aabb(&self, i: usize) -> Aabb {
        match self.slots[i] {
            Slot::Holds(_) => self.shape(i).aabb(&self.poses[i]),
            Slot::Free => Aabb::EMPTY,
        }
    }
}

/// Checks that a scene may have this many of something.
fn check_count(what: &'static str, count: usize) -> Result<(), SceneError> {
    if u32::try_from(count).is_ok() { Ok(()) } else { Err(SceneError::TooMany { what, count }) }
}

fn check_reach(object: usize, shape: &Shape, pose: &Pose) -> Result<(), SceneError> {
    // A half-space's AABB ends where the range does.
    let own = if shape.is_bounded() { shape.reach() } else { 0.0 };
    let reach = pose.translation().abs().max_element() + own * (1.0 + pose.deviation());
    // Written so that NaN is refused.
    if reach <= Aabb::LIMIT { Ok(()) } else { Err(SceneError::OutOfRange { object, reach }) }
}
