//! What a scene places: an object, how it is filtered, and how it is known again.

use crate::Pose;
use std::sync::atomic::{AtomicU64, Ordering};

/// Which objects may pair: each is a member of some groups and asks for some groups.
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

    /// Whether each asks for a group of the other.
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
#[derive(Clone, Copy, Debug)]
pub struct Object {
    /// The shape's index in the scene.
    pub shape: u32,
    /// Where it is.
    pub pose: Pose,
    /// What it may pair with.
    pub filter: Filter,
    /// Whether it moves.
    pub motion: Motion,
}

impl Object {
    /// A moving object that may pair with all.
    pub fn new(shape: u32, pose: Pose) -> Self {
        Self { shape, pose, filter: Filter::ALL, motion: Motion::Moving }
    }

    /// The same standing still.
    pub fn fixed(self) -> Self {
        Self { motion: Motion::Static, ..self }
    }
}

/// An object of a scene, known again after others have come and gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Handle {
    /// The slot: the object's index in contacts, poses and boxes.
    pub index: u32,
    /// How many objects had the slot before it.
    pub generation: u32,
}

/// Marks what a scene holds at some moment: equal stamps, equal contents, whichever scene shows
/// them. A change draws a stamp that no scene of the process has had.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamp(u64);

impl Stamp {
    pub(super) fn draw() -> Self {
        // 0 is that of the scene of nothing.
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}
