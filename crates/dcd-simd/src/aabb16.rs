//! Sixteen AABBs side by side: what trees are made of.

use crate::Aabb;
use crate::{Lanes, Row, WIDTH};
use glam::{Vec3, Vec4};

/// Sixteen AABBs, coordinate by coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb16 {
    /// Their smallest x, y and z.
    pub min: [Row; 3],
    /// Their largest x, y and z.
    pub max: [Row; 3],
}

impl Default for Aabb16 {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Aabb16 {
    /// Sixteen empty AABBs.
    pub const EMPTY: Self =
        Self { min: [Row([f32::INFINITY; WIDTH]); 3], max: [Row([f32::NEG_INFINITY; WIDTH]); 3] };

    /// AABB k, which must be below sixteen.
    #[inline(always)]
    pub fn get(&self, k: usize) -> Aabb {
        let [x, y, z] = &self.min;
        let min = Vec3::new(x.0[k], y.0[k], z.0[k]);
        let [x, y, z] = &self.max;
        Aabb { min, max: Vec3::new(x.0[k], y.0[k], z.0[k]) }
    }

    /// Replaces AABB k, which must be below sixteen.
    #[inline]
    pub fn set(&mut self, k: usize, aabb: &Aabb) {
        for (row, x) in self.min.iter_mut().zip(aabb.min.to_array()) {
            row.0[k] = x;
        }
        for (row, x) in self.max.iter_mut().zip(aabb.max.to_array()) {
            row.0[k] = x;
        }
    }

    /// The AABB round all sixteen. Out of line: in a kernel it would hold registers that the kernel needs.
    #[inline(never)]
    pub fn union(&self) -> Aabb {
        let [min, max] = [&self.min, &self.max];
        Aabb {
            min: Vec3::new(least(&min[0]), least(&min[1]), least(&min[2])),
            max: Vec3::new(largest(&max[0]), largest(&max[1]), largest(&max[2])),
        }
    }

    /// Which of the sixteen overlap that AABB, lane k as bit k; empty AABBs never do, if its sides are
    /// finite. For kernels.
    #[inline(always)]
    pub fn overlaps<L: Lanes>(&self, l: L, one: &Aabb) -> u32 {
        let (min, max) = (one.min.to_array(), one.max.to_array());
        let mut all = l.mask(0xffff);
        for axis in 0..3 {
            let starts = l.le(l.load(&self.min[axis]), l.splat(max[axis]));
            let ends = l.le(l.splat(min[axis]), l.load(&self.max[axis]));
            all = l.and(all, l.and(starts, ends));
        }
        l.bits(all)
    }

    /// How far each of the sixteen overlaps that AABB, along the axis where it does least: negative
    /// where it does not, without end of an empty AABB. The sign is exact, as that of any difference
    /// of two numbers is. For kernels that need more than [`Aabb16::overlaps`].
    #[inline(always)]
    pub fn depths<L: Lanes>(&self, l: L, one: &Aabb) -> L::F {
        let (min, max) = (one.min.to_array(), one.max.to_array());
        let mut depth = l.splat(f32::INFINITY);
        for axis in 0..3 {
            let high = l.min(l.load(&self.max[axis]), l.splat(max[axis]));
            let low = l.max(l.load(&self.min[axis]), l.splat(min[axis]));
            depth = l.min(depth, l.sub(high, low));
        }
        depth
    }

    /// At most how far each of the sixteen is from that AABB, in their unit: between 1e-18 and 9e18 less than three millionths of it
    /// less, below perhaps 0, above at least 9e18. Infinite of an empty AABB, and where the way along an axis is above all f32.
    #[inline(always)]
    pub fn gaps<L: Lanes>(&self, l: L, one: &Aabb) -> L::F {
        let (min, max) = (one.min.to_array(), one.max.to_array());
        let zero = l.splat(0.0);
        let (mut square, mut longest) = (zero, zero);
        for axis in 0..3 {
            let before = l.sub(l.splat(min[axis]), l.load(&self.max[axis]));
            let after = l.sub(l.load(&self.min[axis]), l.splat(max[axis]));
            let along = l.max(zero, l.max(before, after));
            longest = l.max(longest, along);
            let along = l.min(along, l.splat(LONGEST));
            square = l.mul_add(along, along, square);
        }
        // What underflow rounds up is no gap.
        let square = l.select(l.le(square, l.splat(SMALLEST)), zero, square);
        // Differences, squares, sums and the root lose 5u of f32 at most, this product one.
        let gap = l.mul(l.sqrt(square), l.splat(1.0 - 16.0 * f32::EPSILON));
        l.select(l.le(l.splat(f32::INFINITY), longest), longest, gap)
    }
}

/// What is farther along an axis counts as no farther than this: three squares of it have a sum. Larger: gaps without end.
const LONGEST: f32 = 1e19;

/// A sum of squares that is not above this may have lost all its digits. Smaller: gaps that are more than there are.
const SMALLEST: f32 = 1e-36;

/// The least of a row, four numbers at a time.
#[inline(always)]
fn least(row: &Row) -> f32 {
    let [p, q, r, s] = fours(row);
    p.min(q).min(r.min(s)).min_element()
}

/// The largest.
#[inline(always)]
fn largest(row: &Row) -> f32 {
    let [p, q, r, s] = fours(row);
    p.max(q).max(r.max(s)).max_element()
}

#[inline(always)]
fn fours(row: &Row) -> [Vec4; WIDTH / 4] {
    std::array::from_fn(|k| Vec4::from_slice(&row.0[4 * k..]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kernel, Path, dispatch_on};

    struct Overlaps<'a>(&'a Aabb16, &'a Aabb);

    impl Kernel for Overlaps<'_> {
        type Output = u32;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> u32 {
            self.0.overlaps(l, self.1)
        }
    }

    struct Gaps<'a>(&'a Aabb16, &'a Aabb);

    impl Kernel for Gaps<'_> {
        type Output = Row;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Row {
            let mut row = Row::default();
            l.store(self.0.gaps(l, self.1), &mut row);
            row
        }
    }

    #[test]
    fn no_gap_is_larger_than_there_is() {
        let point = |x: f32| Aabb { min: Vec3::splat(x), max: Vec3::splat(x) };
        let scales = (-44..=37).map(|exponent| 10f32.powi(exponent));
        let mut row = Aabb16::EMPTY;
        for (scale, k) in scales.flat_map(|scale| (1..20).map(move |k| (scale, k))) {
            let one = point(scale * k as f32 * 0.1);
            row.set(0, &point(0.0));
            let gap = f64::from(one.min.x) * 3f64.sqrt();
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let Row(gaps) = dispatch_on(path, Gaps(&row, &one));
                assert!(f64::from(gaps[0]) <= gap, "{path:?} {gap:e} {:e}", gaps[0]);
                let least = if gap > 1e-18 { gap.min(1e19) * (1.0 - 3e-6) } else { 0.0 };
                assert!(f64::from(gaps[0]) >= least, "{path:?} {gap:e} {:e}", gaps[0]);
                assert_eq!(gaps[1], f32::INFINITY, "of an empty one");
            }
        }
    }

    struct Depths<'a>(&'a Aabb16, &'a Aabb);

    impl Kernel for Depths<'_> {
        type Output = Row;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Row {
            let mut row = Row::default();
            l.store(self.0.depths(l, self.1), &mut row);
            row
        }
    }

    /// The scalar reference.
    fn depth(a: &Aabb, b: &Aabb) -> f32 {
        (a.max.min(b.max) - a.min.max(b.min)).min_element()
    }

    /// AABBs in eighths, so that sides meet exactly; some are empty.
    fn boxes(count: u32) -> impl Iterator<Item = Aabb> {
        let mut state = 1u32;
        let mut next = move |below: u32| {
            // The generator of Numerical Recipes.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) % below
        };
        (0..count).map(move |_| {
            let mut eighths =
                |below: u32| Vec3::from_array([0; 3].map(|_| next(below) as f32 / 8.0));
            let (min, extent) = (eighths(16), eighths(13) - 0.125);
            if extent.min_element() < 0.0 { Aabb::EMPTY } else { Aabb { min, max: min + extent } }
        })
    }

    #[test]
    fn boxes_side_by_side_are_what_they_are_one_by_one() {
        let boxes: Vec<Aabb> = boxes(17 * 400).collect();
        let mut seen = [0; 3];
        for group in boxes.chunks(WIDTH + 1) {
            let (boxes, one) = (&group[..WIDTH], &group[WIDTH]);
            let mut row = Aabb16::EMPTY;
            boxes.iter().enumerate().for_each(|(k, aabb)| row.set(k, aabb));
            assert!((0..WIDTH).all(|k| row.get(k) == boxes[k]));
            assert_eq!(row.union(), boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b)));
            let overlapping = (0..WIDTH).filter(|&k| boxes[k].overlaps(one));
            let expected = overlapping.fold(0, |bits: u32, k| bits | 1 << k);
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                assert_eq!(dispatch_on(path, Overlaps(&row, one)), expected);
                let depths = dispatch_on(path, Depths(&row, one)).0;
                for (found, aabb) in depths.iter().zip(boxes) {
                    assert_eq!(*found, depth(aabb, one));
                    assert_eq!(*found >= 0.0, aabb.overlaps(one));
                }
            }
            seen[0] += expected.count_ones();
            seen[1] += u32::from(*one == Aabb::EMPTY);
            seen[2] += 1;
        }
        assert!(seen[0] > seen[2] && 0 < seen[1] && seen[1] < seen[2], "{seen:?}");
    }
}
