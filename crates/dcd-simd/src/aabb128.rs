//! AABBs side by side.

use crate::{Aabb, Aabb16, WIDTH};

/// Which AABBs of a [`Aabb128`], a bit each.
pub type Mask128 = u128;

/// AABBs side by side, coordinate by coordinate: as many as a [`Mask128`] has bits.
#[derive(Clone, Debug)]
pub struct Aabb128 {
    /// The AABBs, sixteen by sixteen.
    pub boxes: [Aabb16; Self::LENGTH / WIDTH],
}

impl Default for Aabb128 {
    fn default() -> Self {
        Self { boxes: [Aabb16::EMPTY; Self::LENGTH / WIDTH] }
    }
}

impl Aabb128 {
    /// How many there are.
    pub const LENGTH: usize = Mask128::BITS as usize;

    /// Replaces AABB k, which must be below the length.
    #[inline]
    pub fn set(&mut self, k: usize, aabb: &Aabb) {
        self.boxes[k / WIDTH].set(k % WIDTH, aabb);
    }
}
