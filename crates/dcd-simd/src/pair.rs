//! Two objects of a scene.

use crate::WIDTH;

/// Two different objects by index, the smaller first. Eight bytes: candidate pairs are what a
/// step writes most of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(C)]
pub struct Pair {
    /// The smaller index.
    pub i: u32,
    /// The larger index.
    pub j: u32,
}

impl Pair {
    /// The pair of two different indices, in either order.
    #[inline(always)]
    pub fn new(a: u32, b: u32) -> Self {
        debug_assert_ne!(a, b);
        Self { i: a.min(b), j: a.max(b) }
    }
}

impl From<Pair> for (u32, u32) {
    fn from(pair: Pair) -> Self {
        (pair.i, pair.j)
    }
}

/// Makes room for sixteen pairs more. They can be written from where it points to.
#[inline(always)]
pub(crate) fn room_for_sixteen(pairs: &mut Vec<Pair>) -> *mut Pair {
    pairs.reserve(WIDTH);
    pairs.spare_capacity_mut().as_mut_ptr().cast()
}
