//! Where a search starts: the vertices of both objects that are farthest along the world's axes.

use super::surface::load;
use dcd_simd::{Block, Lanes, Row, WIDTH};

/// The numbers of the vertices farthest along x, y, z, −x, −y, −z: the first among equals.
pub(super) type Extremes = [u8; 6];

/// Of how many objects the farthest vertices are remembered. A power of two. No effect on any result. Larger: memory.
/// Smaller: objects whose vertices are looked through again.
const REMEMBERED: usize = 512;

/// What is remembered of an object.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    /// The slice, odd for an object of the second frame, and the object's number.
    key: (u32, u32),
    extremes: Extremes,
}

/// The farthest vertices of objects that recur in one slice.
#[derive(Clone, Debug)]
pub(super) struct Starts {
    /// Twice the number of the slice: poses may change between two.
    slice: u32,
    entries: Box<[Entry; REMEMBERED]>,
}

impl Default for Starts {
    fn default() -> Self {
        Self { slice: 0, entries: Box::new([Entry::default(); REMEMBERED]) }
    }
}

impl Starts {
    /// Forgets all.
    pub(super) fn begin(&mut self) {
        self.slice = self.slice.wrapping_add(2);
        if self.slice == 0 {
            *self = Self { slice: 2, ..Self::default() };
        }
    }

    /// Of an object of the first frame, or of the second of two.
    #[inline(always)]
    pub(super) fn of<L: Lanes>(
        &mut self,
        l: L,
        (object, is_second): (u32, bool),
        blocks: &[Block],
    ) -> Extremes {
        let key = (self.slice | u32::from(is_second), object);
        let entry = &mut self.entries[object as usize % REMEMBERED];
        if entry.key != key {
            *entry = Entry { key, extremes: extremes(l, blocks) };
        }
        entry.extremes
    }
}

/// The vertices farthest along the axes, of at most 256.
#[inline(always)]
fn extremes<L: Lanes>(l: L, blocks: &[Block]) -> Extremes {
    let mut extremes = [0; 6];
    for axis in 0..3 {
        let Some((first, rest)) = blocks.split_first() else { return extremes };
        let (mut most, mut least) = (load(l, first)[axis], load(l, first)[axis]);
        // The blocks' numbers as bits: no arithmetic is done on them.
        let zero = l.splat(f32::from_bits(0));
        let (mut of_most, mut of_least) = (zero, zero);
        for (number, block) in (1..).zip(rest) {
            let (along, number) = (load(l, block)[axis], l.splat(f32::from_bits(number)));
            of_most = l.select(l.lt(most, along), number, of_most);
            of_least = l.select(l.lt(along, least), number, of_least);
            (most, least) = (l.max(most, along), l.min(least, along));
        }
        extremes[axis] = first_largest(l, most, of_most);
        extremes[axis + 3] = first_largest(l, l.neg(least), of_least);
    }
    extremes
}

/// The vertex of the first lane with the largest value, in the block of which that lane has the number.
#[inline(always)]
fn first_largest<L: Lanes>(l: L, values: L::F, of_block: L::F) -> u8 {
    let top = l.splat(l.largest(values));
    let lane = l.bits(l.le(top, values)).trailing_zeros() as usize % WIDTH;
    let mut numbers = Row([0.0; WIDTH]);
    l.store(of_block, &mut numbers);
    (numbers.0[lane].to_bits() as usize * WIDTH + lane) as u8
}
