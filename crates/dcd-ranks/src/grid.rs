//! The cells of the world, along a Morton curve.

use dcd_geom::Aabb;
use dcd_geom::glam::{DVec3, Vec3};

/// Cells along each axis: 2²¹, so that a key of all three has 63 bits.
pub(crate) const BITS: u32 = 21;

/// The last cell of an axis.
pub(crate) const LAST: u32 = (1 << BITS) - 1;

/// A cube of 2²¹ cells along each axis. What lies outside belongs to the outermost cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    origin: DVec3,
    cells_per_metre: f64,
}

impl Grid {
    /// Over the points between `min` and `max`, metres. Where there are none (`min` beyond `max`), or only
    /// one, any cell is as good as another.
    pub fn over(min: DVec3, max: DVec3) -> Self {
        let edge = (max - min).max_element();
        let cells_per_metre = f64::from(1 << BITS) / edge;
        if edge > 0.0 && cells_per_metre.is_finite() {
            Self { origin: min, cells_per_metre }
        } else {
            Self { origin: DVec3::ZERO, cells_per_metre: 0.0 }
        }
    }

    /// The cell of a point. Along each axis it never falls where the coordinate rises: what lies between two
    /// points is in a cell between theirs.
    #[inline]
    pub(crate) fn cell(&self, point: Vec3) -> [u32; 3] {
        let along = (point.as_dvec3() - self.origin) * self.cells_per_metre;
        // A cast rounds towards zero and saturates.
        along.to_array().map(|x| (x as u32).min(LAST))
    }

    /// The key of a point's cell.
    #[inline]
    pub(crate) fn key(&self, point: Vec3) -> u64 {
        key(self.cell(point))
    }

    /// The key of a box's middle.
    #[inline]
    pub(crate) fn key_of(&self, aabb: &Aabb) -> u64 {
        self.key(aabb.min + (aabb.max - aabb.min) * 0.5)
    }
}

/// Interleaves the cell's bits, x lowest. Where no coordinate falls, the key does not.
#[inline]
pub(crate) fn key(cell: [u32; 3]) -> u64 {
    let [x, y, z] = cell.map(spread);
    x | y << 1 | z << 2
}

/// Two zeros between any two of the lower 21 bits.
#[inline]
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x) & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_interleaves_the_bits() {
        let slowly = |cell: [u32; 3]| {
            (0..63).fold(0u64, |key, bit| {
                key | u64::from(cell[bit as usize % 3] >> (bit / 3) & 1) << bit
            })
        };
        for cell in [[0, 0, 0], [LAST; 3], [1, 2, 4], [0x15_5555, 0x0a_aaaa, 0x1f_0f0f]] {
            assert_eq!(key(cell), slowly(cell));
        }
        assert_eq!(key([LAST; 3]), (1 << 63) - 1);
    }

    #[test]
    fn cells_ascend_with_the_point_and_what_is_outside_is_in_the_outermost() {
        let grid = Grid::over(DVec3::splat(-1.0), DVec3::splat(3.0));
        let cells: Vec<u32> =
            (-50..80).map(|k| grid.cell(Vec3::splat(k as f32 * 0.05))[0]).collect();
        assert!(cells.is_sorted());
        assert_eq!((cells[0], cells[cells.len() - 1]), (0, LAST));
        assert_eq!(grid.cell(Vec3::splat(1.0)), [1 << (BITS - 1); 3]);
    }

    #[test]
    fn no_point_or_one_makes_a_grid_of_one_cell() {
        for (min, max) in [(DVec3::ONE, DVec3::ONE), (DVec3::INFINITY, DVec3::NEG_INFINITY)] {
            let grid = Grid::over(min, max);
            assert_eq!(grid.key(Vec3::splat(1e30)), 0);
            assert_eq!(grid.key(Vec3::splat(-1e30)), 0);
        }
    }
}
