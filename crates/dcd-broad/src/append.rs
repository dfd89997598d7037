//! Writes pairs sixteen at a time, and drops those that a predicate excludes.

use dcd_geom::Pair;
use dcd_simd::{IndexRow, Lanes, WIDTH};

/// A list to whose end pairs are written sixteen at a time.
#[derive(Debug)]
pub(crate) struct Appender<'a> {
    out: &'a mut Vec<Pair>,
    /// Where the next pair goes. What lies past it is free.
    end: usize,
}

/// By how many pairs the list grows, at least [`ROOM`]. Larger: more memory is cleared in vain at the end
/// of a task. Smaller: it grows more often.
const GROWTH: usize = 512;

/// The pairs of sixteen objects with sixteen, and the surplus of the last ones.
const ROOM: usize = WIDTH * WIDTH + WIDTH;

impl<'a> Appender<'a> {
    pub(crate) fn new(out: &'a mut Vec<Pair>) -> Self {
        let end = out.len();
        Self { out, end }
    }

    /// Makes room for the pairs of sixteen objects with sixteen others: once for all of them, for a call that may be
    /// made before each would leave no register to the search.
    #[inline(always)]
    pub(crate) fn make_room(&mut self) {
        if self.out.len() < self.end + ROOM {
            self.grow();
        }
    }

    /// Appends the pairs of an object with the `hits` of sixteen others, for which there is room.
    #[inline(always)]
    pub(crate) fn append<L: Lanes>(&mut self, l: L, one: u32, (others, hits): (&IndexRow, u32)) {
        // Sixteen are written where they stay, and the surplus is written over.
        let slot = self.out[self.end..].first_chunk_mut().expect("room is made for all pairs");
        l.compress_pairs(hits, (one, l.load_u(others)), slot);
        self.end += hits.count_ones() as usize;
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        self.out.resize(self.end + GROWTH, Pair::default());
    }
}

impl Drop for Appender<'_> {
    /// Drops the surplus.
    fn drop(&mut self) {
        self.out.truncate(self.end);
    }
}

/// Runs `search`, which appends, and drops what it appended where `keep(i, j)` does not hold. The search does
/// not see `keep`, so that its kernels are compiled once and not for every predicate.
#[inline]
pub(crate) fn append_where(
    out: &mut Vec<Pair>,
    keep: impl Fn(u32, u32) -> bool,
    search: impl FnOnce(&mut Vec<Pair>),
) {
    let start = out.len();
    search(out);
    let new = &mut out[start..];
    let mut kept = 0;
    // Branchless, since most filters would be mispredicted.
    for k in 0..new.len() {
        new[kept] = new[k];
        kept += usize::from(keep(new[k].i, new[k].j));
    }
    out.truncate(start + kept);
}
