//! Concatenated lists, and their entries that are kept.

use dcd_simd::IndexRow;
use std::ops::Range;

/// The obstacles that spheres may reach, sphere by sphere. Reusable memory.
///
/// Filled without a branch that depends on what is near: first the spheres with a list that is not empty are
/// selected, then all lists are concatenated, then every entry is tested.
#[derive(Clone, Debug, Default)]
pub struct GridHits {
    /// The non-empty lists, longer than their number: entries beyond it are void, as in what
    /// follows.
    lists: Vec<Cell>,
    listed: usize,
    /// The cells of the spheres that are looked up.
    pub(super) cells: Vec<IndexRow>,
    pub(super) numbers: Vec<u32>,
    /// For each listed number the x, y and z of its sphere's centre and its radius.
    pub(super) spheres: [Vec<f32>; 4],
    /// For every sixteen listed numbers which of them are reached.
    pub(super) kept: Vec<Kept>,
}

/// Which of sixteen listed numbers are reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    /// A bit each.
    pub(super) bits: u32,
    /// How many before the first of them are reached.
    pub(super) before: u32,
}

/// A sphere with a non-empty list.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cell {
    /// Its number.
    pub sphere: u32,
    /// The number of the obstacle that it most likely touches; [`super::ObstacleGrid::unknown`] where none
    /// is known.
    pub likeliest: u32,
    /// Where its list begins: among the members, then among the numbers.
    pub(super) start: u32,
    /// How many it has, then where it ends.
    pub(super) end: u32,
}

impl GridHits {
    /// The spheres that may reach something: their numbers, ascending, and where among the
    /// [`GridHits::numbers`] those of what they reach begin and end. A sphere may reach nothing there.
    pub fn spans(&self) -> impl Iterator<Item = (usize, [u32; 2])> {
        self.lists[..self.listed].iter().map(|list| (list.sphere as usize, [list.start, list.end]))
    }

    /// The numbers of the obstacles that each sphere may reach, ascending, sphere by sphere. Where that is
    /// not known, [`super::ObstacleGrid::unknown`] alone.
    pub fn numbers(&self) -> &[u32] {
        let end = self.lists[..self.listed].last().map_or(0, |list| list.end);
        &self.numbers[..end as usize]
    }

    /// Forgets all spheres.
    pub fn clear(&mut self) {
        self.listed = 0;
    }

    /// How many spheres are noted.
    pub fn noted(&self) -> usize {
        self.listed
    }

    /// Passes the noted spheres from the `from`-th on to `ends`, by runs of so many spheres, with the number of
    /// the run. Where it returns true, the rest of the run is skipped and all of it is dropped.
    #[inline]
    pub fn sift(&mut self, from: usize, run: usize, mut ends: impl FnMut(usize, &Cell) -> bool) {
        let (lists, run) = (&mut self.lists[..self.listed], run.max(1));
        let from = from.min(lists.len());
        let (mut next, mut kept) = (from, from);
        while next < lists.len() {
            let number = lists[next].sphere as usize / run;
            let end = (number + 1) * run;
            let (start, mut has_ended) = (kept, false);
            while next < lists.len() && (lists[next].sphere as usize) < end {
                if !has_ended {
                    lists[kept] = lists[next];
                    has_ended = ends(number, &lists[kept]);
                    kept += 1;
                }
                next += 1;
            }
            kept = if has_ended { start } else { kept };
        }
        self.listed = kept;
    }

    /// Notes those of the looked-up spheres whose cell lists anything. `list` takes the count of earlier entries
    /// and the cell; it returns where among the members its list lies, of at most [`LONGEST`](super::LONGEST), and which
    /// obstacle is the likeliest.
    #[inline]
    pub(super) fn note(
        &mut self,
        spheres: Range<usize>,
        list: impl Fn(usize, usize) -> (Range<u32>, u32),
    ) {
        // Never shrinks, so that nothing is filled twice.
        let most = self.lists.len().max(self.listed + spheres.len() + 1);
        self.lists.resize(most, Cell::default());
        let cells = self.cells.iter().flat_map(|row| row.0).enumerate();
        for (sphere, (k, cell)) in spheres.zip(cells) {
            let (Range { start, end }, likeliest) = list(k, cell as usize);
            self.lists[self.listed] =
                Cell { sphere: sphere as u32, likeliest, start, end: end - start };
            self.listed += usize::from(end > start);
        }
    }

    /// The noted spheres.
    pub(super) fn lists_mut(&mut self) -> &mut [Cell] {
        &mut self.lists[..self.listed]
    }
}
