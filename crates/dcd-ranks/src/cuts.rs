//! Which rank a place belongs to.

use crate::grid::{BITS, Grid, LAST, key};
use dcd_geom::Aabb;
use dcd_geom::glam::Vec3;
use std::ops::Range;

/// The regions of all ranks: intervals of Morton keys, by rank; some may be empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Cuts {
    grid: Grid,
    /// The first key of each rank; ascending, the first 0.
    starts: Vec<u64>,
}

/// A cube of cells whose keys follow each other.
#[derive(Clone, Copy)]
struct Octant {
    corner: [u32; 3],
    /// Its edge is 2 to this, cells.
    level: u32,
}

/// The cells that a box meets, from the first to the last along each axis.
struct CellBox {
    first: [u32; 3],
    last: [u32; 3],
}

impl Cuts {
    /// Regions of a grid that begin at these keys, which must ascend; the first is taken for 0.
    pub(crate) fn new(grid: Grid, mut starts: Vec<u64>) -> Self {
        debug_assert!(starts.is_sorted());
        match starts.first_mut() {
            Some(first) => *first = 0,
            None => starts.push(0),
        }
        Self { grid, starts }
    }

    /// The grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The rank of a box's middle: that which owns the object.
    #[inline]
    pub fn owner(&self, aabb: &Aabb) -> usize {
        self.of_key(self.grid.key_of(aabb))
    }

    /// The keys of a rank's region.
    pub(crate) fn region(&self, rank: usize) -> Range<u64> {
        let end = self.starts.get(rank + 1).copied().unwrap_or(u64::MAX);
        self.starts[rank]..end
    }

    /// Whether both ends of the box, and with them all of it, lie in a region.
    #[inline]
    pub(crate) fn is_inside(&self, region: &Range<u64>, aabb: &Aabb) -> bool {
        self.grid.key(aabb.min) >= region.start && self.grid.key(aabb.max) < region.end
    }

    /// Whether the lower corner of two boxes' intersection lies in a region. Of boxes that do not overlap,
    /// some point.
    #[inline]
    pub(crate) fn holds_corner(&self, region: &Range<u64>, a: &Aabb, b: &Aabb) -> bool {
        let corner: Vec3 = a.min.max(b.min);
        region.contains(&self.grid.key(corner))
    }

    /// Replaces `ranks` by those whose regions the box reaches, ascending.
    pub fn reached(&self, aabb: &Aabb, ranks: &mut Vec<usize>) {
        ranks.clear();
        let cells = CellBox { first: self.grid.cell(aabb.min), last: self.grid.cell(aabb.max) };
        let ends = [cells.first, cells.last].map(key);
        // The smallest octant that holds both ends holds all that is between.
        let level = (u64::BITS - (ends[0] ^ ends[1]).leading_zeros()).div_ceil(3).min(BITS);
        let corner = cells.first.map(|c| c >> level << level);
        self.descend(Octant { corner, level }, &cells, ranks);
        ranks.sort_unstable();
        ranks.dedup();
    }

    fn descend(&self, octant: Octant, cells: &CellBox, ranks: &mut Vec<usize>) {
        let first = key(octant.corner);
        let last = first + ((1u64 << (3 * octant.level)) - 1);
        let (from, to) = (self.of_key(first), self.of_key(last));
        if from == to {
            ranks.push(from);
        } else if octant.is_within(cells) {
            ranks.extend((from..=to).filter(|&rank| !self.region(rank).is_empty()));
        } else {
            // One octant of a level at most holds a given cut, so that this ends soon.
            let halves = octant.halves();
            halves
                .filter(|half| half.meets(cells))
                .for_each(|half| self.descend(half, cells, ranks));
        }
    }

    #[inline]
    fn of_key(&self, key: u64) -> usize {
        // The first start is 0.
        self.starts.partition_point(|&start| start <= key) - 1
    }
}

impl Octant {
    /// Its last cell along each axis.
    fn last(self) -> [u32; 3] {
        self.corner.map(|c| (c + ((1 << self.level) - 1)).min(LAST))
    }

    fn is_within(self, cells: &CellBox) -> bool {
        let last = self.last();
        (0..3).all(|k| cells.first[k] <= self.corner[k] && last[k] <= cells.last[k])
    }

    fn meets(self, cells: &CellBox) -> bool {
        let last = self.last();
        (0..3).all(|k| cells.first[k] <= last[k] && self.corner[k] <= cells.last[k])
    }

    /// The eight octants of half its edge.
    fn halves(self) -> impl Iterator<Item = Self> {
        let level = self.level.saturating_sub(1);
        (0..8u32).map(move |k| {
            let corner = [0, 1, 2].map(|axis| self.corner[axis] | (k >> axis & 1) << level);
            Self { corner, level }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::DVec3;

    /// Numbers below 1, for tests.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(1);
            (self.0 >> 40) as f32 / (1u64 << 24) as f32
        }

        fn point(&mut self) -> Vec3 {
            let (x, y) = (self.next(), self.next());
            Vec3::new(x, y, self.next())
        }
    }

    fn drawn(numbers: &mut Numbers, size: usize) -> Cuts {
        let grid = Grid::over(DVec3::ZERO, DVec3::ONE);
        let mut starts: Vec<u64> =
            (0..size).map(|_| (f64::from(numbers.next()) * 9.2e18) as u64).collect();
        // Some empty regions.
        starts[size / 2] = starts[size / 3];
        starts.sort_unstable();
        Cuts::new(grid, starts)
    }

    #[test]
    fn every_point_of_a_box_is_in_a_region_that_it_reaches() {
        let mut numbers = Numbers(1);
        let mut reached = Vec::new();
        for round in 0..200 {
            let cuts = drawn(&mut numbers, 1 + round % 17);
            let (a, b) =
                (numbers.point() * 1.4 - 0.2, numbers.point() * [0.01, 0.3, 2.0][round % 3]);
            let aabb = Aabb { min: a, max: a + b };
            cuts.reached(&aabb, &mut reached);
            assert!(reached.is_sorted());
            for _ in 0..300 {
                let point = a + b * numbers.point();
                let rank = cuts.of_key(cuts.grid.key(point));
                assert!(reached.contains(&rank), "{aabb:?} {point} {rank} {reached:?}");
            }
            assert!(reached.contains(&cuts.owner(&aabb)));
        }
    }

    #[test]
    fn no_region_is_reached_that_has_no_cell_of_the_box() {
        // A grid of so few cells that all can be tested.
        let mut numbers = Numbers(5);
        let grid = Grid::over(DVec3::ZERO, DVec3::splat(f64::from(1 << BITS)));
        let mut reached = Vec::new();
        for _ in 0..300 {
            let mut starts: Vec<u64> = (0..9).map(|_| (numbers.next() * 512.0) as u64).collect();
            starts.sort_unstable();
            let cuts = Cuts::new(grid, starts);
            let min = (numbers.point() * 8.0).floor();
            let max = (min + (numbers.point() * 5.0).floor()).min(Vec3::splat(7.0));
            cuts.reached(&Aabb { min, max }, &mut reached);
            let [first, last] = [min, max].map(|corner| grid.cell(corner));
            let mut slowly = Vec::new();
            for x in first[0]..=last[0] {
                for y in first[1]..=last[1] {
                    slowly.extend((first[2]..=last[2]).map(|z| cuts.of_key(key([x, y, z]))));
                }
            }
            slowly.sort_unstable();
            slowly.dedup();
            assert_eq!(reached, slowly);
        }
    }

    #[test]
    fn a_box_is_inside_a_region_only_if_it_reaches_no_other() {
        let mut numbers = Numbers(9);
        let mut reached = Vec::new();
        for _ in 0..2000 {
            let cuts = drawn(&mut numbers, 4);
            let min = numbers.point();
            let aabb = Aabb { min, max: min + numbers.point() * 0.05 };
            cuts.reached(&aabb, &mut reached);
            for rank in 0..4 {
                if cuts.is_inside(&cuts.region(rank), &aabb) {
                    assert_eq!(reached, [rank]);
                }
            }
        }
    }
}
