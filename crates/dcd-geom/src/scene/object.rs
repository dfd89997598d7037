//! What a scene places: an object, how it is filtered, and how it is known again.

use crate::{Pose, Scene, SceneError};
use std::sync::atomic::{AtomicU64, Ordering};

/// Which objects may pair: each is a member of some groups and collides with some groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    /// The groups it is in, one bit each.
    pub groups: u32,
    /// The groups it can touch.
    pub mask: u32,
}

impl Filter {
    /// In every group, touching every group: what an object has unless said otherwise.
    pub const ALL: Self = Self { groups: u32::MAX, mask: u32::MAX };

    /// Whether each collides with a group of the other.
    #[inline]
    pub fn allows(self, other: Self) -> bool {
        self.groups & other.mask != 0 && other.groups & self.mask != 0
    }
}

impl Default for Filter {
    fn default() -> Self {
        Self::ALL
    }
}

/// Whether an object is expected to move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Motion {
    /// Its pose may change at every step.
    #[default]
    Moving,
    /// Its pose seldom changes, and then at a cost: what is kept of all static objects is made
    /// anew. Two static objects never pair.
    Static,
}

/// A shape somewhere.
///
/// ```
/// use dcd_geom::{Filter, Object, Pose};
/// const ROBOT: u32 = 1;
/// const WORLD: u32 = 2;
/// // In group ROBOT, and it meets what is in group WORLD.
/// let link = Object::new(0, Pose::IDENTITY).with_filter(Filter { groups: ROBOT, mask: WORLD });
/// let wall = Object::new(1, Pose::IDENTITY).fixed().with_filter(Filter { groups: WORLD, mask: ROBOT });
/// assert!(link.filter.allows(wall.filter) && !link.filter.allows(link.filter));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Object {
    /// The shape's index in the scene.
    pub shape: u32,
    /// Its pose.
    pub pose: Pose,
    /// Its filter.
    pub filter: Filter,
    /// Whether it moves.
    pub motion: Motion,
    /// Whether it is a sensor: a step lists what touches it apart from the contacts, and measures nothing of
    /// it.
    pub sensor: bool,
    /// Whatever the caller wants to find again: an entity's number, an index, a pointer. Nothing here reads
    /// it. 0 unless said otherwise.
    pub user_data: u64,
}

impl Object {
    /// A moving object that may pair with all.
    pub fn new(shape: u32, pose: Pose) -> Self {
        let (filter, motion) = (Filter::ALL, Motion::Moving);
        Self { shape, pose, filter, motion, sensor: false, user_data: 0 }
    }

    /// The object with another filter.
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// The object with a number of the caller's.
    pub fn with_user_data(self, user_data: u64) -> Self {
        Self { user_data, ..self }
    }

    /// The object as a sensor: a region that reports what enters it.
    pub fn as_sensor(self) -> Self {
        Self { sensor: true, ..self }
    }

    /// The object as a static one.
    pub fn fixed(self) -> Self {
        Self { motion: Motion::Static, ..self }
    }
}

/// An object of a scene, known again after others have come and gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Handle {
    /// The slot: the object's index in contacts, poses and AABBs.
    pub index: u32,
    /// How many objects had the slot before it.
    pub generation: u32,
}

/// Identifies an object of a scene: its [`Handle`], or its index where that is known to be valid.
///
/// A handle is refused once its object has been removed. An index names whatever has the slot now.
pub trait ObjectRef: Copy + sealed::Sealed {
    /// The index of the object in `scene`.
    ///
    /// # Errors
    /// There is no such object, or it has been removed.
    fn index_in(self, scene: &Scene) -> Result<usize, SceneError>;
}

impl ObjectRef for Handle {
    fn index_in(self, scene: &Scene) -> Result<usize, SceneError> {
        scene.index_of(self)
    }
}

impl ObjectRef for usize {
    fn index_in(self, scene: &Scene) -> Result<usize, SceneError> {
        let missing = SceneError::NoSuchObject { object: self, objects: scene.len() };
        scene.motion(self).map(|_| self).ok_or(missing)
    }
}

/// Both ways to name an object are here: an index of another type would make `set_pose(0, …)` ambiguous.
mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Handle {}
    impl Sealed for usize {}
}

/// Marks what a scene holds at some moment: equal revisions, equal contents, whichever scene shows
/// them. A change draws a revision that no scene of the process has had.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Revision(u64);

impl Revision {
    pub(super) fn draw() -> Self {
        // 0 is that of the scene of nothing.
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// A revision that is drawn when it is next read, so that marking a change costs a store.
#[derive(Debug, Default)]
pub(super) struct LazyRevision(AtomicU64);

impl LazyRevision {
    /// Something has changed.
    pub(super) fn mark(&mut self) {
        *self.0.get_mut() = 0;
    }

    pub(super) fn get(&self) -> Revision {
        let known = self.0.load(Ordering::Acquire);
        if known != 0 {
            return Revision(known);
        }
        let drawn = Revision::draw();
        // Whoever comes second takes what the first has drawn.
        match self.0.compare_exchange(0, drawn.0, Ordering::AcqRel, Ordering::Acquire) {
            Ok(_) => drawn,
            Err(first) => Revision(first),
        }
    }
}

impl Clone for LazyRevision {
    fn clone(&self) -> Self {
        Self(AtomicU64::new(self.0.load(Ordering::Acquire)))
    }
}
