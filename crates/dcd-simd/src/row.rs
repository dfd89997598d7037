//! Boxes side by side.

use crate::{Aabb, Sixteen, WIDTH};

/// Which boxes of a [`BoxRow`], a bit each.
pub type BoxSet = u128;

/// Boxes side by side, coordinate by coordinate: as many as a [`BoxSet`] has bits.
#[derive(Clone, Debug)]
pub struct BoxRow {
    /// The boxes, sixteen by sixteen.
    pub boxes: [Sixteen; Self::LENGTH / WIDTH],
}

impl Default for BoxRow {
    fn default() -> Self {
        Self { boxes: [Sixteen::EMPTY; Self::LENGTH / WIDTH] }
    }
}

impl BoxRow {
    /// How many there are.
    pub const LENGTH: usize = BoxSet::BITS as usize;

    /// Replaces box k, which must be below the length.
    #[inline]
    pub fn set(&mut self, k: usize, aabb: &Aabb) {
        self.boxes[k / WIDTH].set(k % WIDTH, aabb);
    }
}
