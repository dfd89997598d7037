//! SIMD lanes for collision kernels, and packed AABBs and spheres built of them.
//!
//! A [`Kernel`] is written once, generic over [`Lanes`]; [`dispatch`] runs it on the widest path that
//! the CPU has: AVX-512, AVX2, or what every CPU of the target has, always sixteen f32 wide. [`Aabb16`], [`Aabb128`] and
//! [`Sphere16`] store AABBs and spheres coordinate by coordinate, so that one comparison tests sixteen.
//!
//! Every function between [`Kernel::run`] and a lane operation must be `#[inline(always)]`: the
//! operations become single instructions only inside the function that carries the CPU feature, and
//! cost ten to fifty times as much outside of it.
//!
//! This is the only crate with `unsafe`. A lane type can be had only through [`dispatch`], which has
//! checked the CPU feature: that is the reason in every SAFETY line.

mod aabb;
mod aabb128;
mod aabb16;
mod array_vec;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod box_test;
mod half;
mod lane_numbers;
mod lanes;
mod ordered;
mod pair;
mod path;
#[cfg_attr(
    target_arch = "x86_64",
    allow(dead_code, reason = "the reference in tests, and the path of other CPUs")
)]
mod portable;
mod sphere16;
#[cfg(target_arch = "x86_64")]
mod sphere_pairs;
#[cfg(target_arch = "x86_64")]
mod sse2;
mod unfused;

pub use aabb::Aabb;
pub use aabb16::Aabb16;
pub use aabb128::{Aabb128, Mask128};
pub use array_vec::ArrayVec;
pub use box_test::{BoxTest, HeightsAlong, PlaneSet, PointDistance, RaySlabs, nearest_first};
pub use half::Half;
pub use lane_numbers::LaneNumbers;
pub use lanes::Lanes;
pub use ordered::{larger, smaller};
pub use pair::Pair;
pub use path::{Path, UnavailablePath};
pub use sphere16::{BoundingSphere, Sphere16};
pub use unfused::Unfused;

/// glam, so that a user has the same version of it.
pub use glam;

/// How many lanes every path has.
pub const WIDTH: usize = 16;

/// Sixteen numbers in memory, on a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Row(pub [f32; WIDTH]);

/// Sixteen indices in memory, on a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C, align(64))]
pub struct IndexRow(pub [u32; WIDTH]);

/// Sixteen points in memory: their x, their y, their z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Block(pub [Row; 3]);

impl Block {
    /// Point k, which must be below sixteen.
    #[inline]
    pub fn point(&self, k: usize) -> glam::Vec3 {
        let Self([x, y, z]) = self;
        glam::Vec3::new(x.0[k], y.0[k], z.0[k])
    }

    /// The products of the points and a direction, each rounded twice and summed from the left: the same bits on every path.
    #[inline(always)]
    pub fn along<L: Lanes>(&self, l: L, direction: &[L::F; 3]) -> L::F {
        let Self([x, y, z]) = self;
        let [along_x, along_y, along_z] = *direction;
        let (x, y) = (l.mul(l.load(x), along_x), l.mul(l.load(y), along_y));
        l.add(l.add(x, y), l.mul(l.load(z), along_z))
    }

    /// Points relative to a centre, subtracted in f64 and rounded to f32, sixteen a block; the last block is
    /// filled up with the last point.
    pub fn relative(
        points: &[glam::DVec3],
        centre: glam::DVec3,
    ) -> impl Iterator<Item = Self> + '_ {
        points.chunks(WIDTH).map(move |chunk| {
            let mut block = Self::default();
            for lane in 0..WIDTH {
                let point = chunk[lane.min(chunk.len() - 1)];
                let relative = (point - centre).as_vec3().to_array();
                for (row, x) in block.0.iter_mut().zip(relative) {
                    row.0[lane] = x;
                }
            }
            block
        })
    }
}

/// How many floats a block has.
const FLOATS: usize = 3 * WIDTH;

/// How many blocks [`Lanes::pick`] can address: the offset of a float is a signed 32-bit
/// number. 8 GB of vertices.
pub const MAX_BLOCKS: usize = i32::MAX as usize / FLOATS;

/// A computation written once for every path.
pub trait Kernel {
    /// What it returns.
    type Output;
    /// The computation; to be marked `#[inline(always)]`.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Runs the kernel on the widest path of this CPU. Once a batch, never once a pair.
#[inline]
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    dispatch_on(Path::best(), kernel)
}

/// Runs the kernel on the path given, or on [`Path::Portable`] where this CPU does not have it.
#[inline]
pub fn dispatch_on<K: Kernel>(path: Path, kernel: K) -> K::Output {
    match path {
        #[cfg(target_arch = "x86_64")]
        Path::Avx512 if path.is_available() => {
            // SAFETY: the features were detected on this CPU.
            unsafe { avx512::run(kernel) }
        }
        #[cfg(target_arch = "x86_64")]
        Path::Avx2 if path.is_available() => {
            // SAFETY: the features were detected on this CPU.
            unsafe { avx2::run(kernel) }
        }
        #[cfg(target_arch = "x86_64")]
        _ => sse2::run(kernel),
        #[cfg(not(target_arch = "x86_64"))]
        _ => portable::run(kernel),
    }
}

/// Prefetches into the nearest cache what will be read soon: a hint, without effect on any result. Does
/// nothing where there is no such instruction.
#[inline(always)]
pub fn prefetch<T>(items: &[T]) {
    let size = size_of_val(items);
    for offset in (0..size).step_by(CACHE_LINE) {
        prefetch_line(items, offset);
    }
    // Items that begin within a cache line end within one more.
    if size > 0 && align_of::<T>() < CACHE_LINE {
        prefetch_line(items, size - 1);
    }
}

/// [`prefetch`] of items that mostly fill no more than that many cache lines: so many at once, the last again and again where
/// they are fewer. Only what is beyond takes a loop, whose end no branch predictor knows.
#[inline(always)]
pub fn prefetch_few<const LINES: usize, T>(items: &[T]) {
    let last = size_of_val(items).saturating_sub(1);
    for line in 0..LINES {
        prefetch_line(items, last.min(line * CACHE_LINE));
    }
    if last >= LINES * CACHE_LINE {
        (LINES * CACHE_LINE..last).step_by(CACHE_LINE).for_each(|at| prefetch_line(items, at));
        prefetch_line(items, last);
    }
}

/// [`prefetch`] of that many cache lines from the first item on, whether the items fill them or not: without a loop, whose
/// end no branch predictor knows.
#[inline(always)]
pub fn prefetch_lines<const LINES: usize, T>(items: &[T]) {
    for line in 0..LINES {
        prefetch_line(items, line * CACHE_LINE);
    }
}

/// The cache line at that many bytes from the first item.
#[inline(always)]
fn prefetch_line<T>(items: &[T], offset: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        let at = items.as_ptr().cast::<i8>().wrapping_add(offset);
        // SAFETY: a prefetch of any address is harmless, and every x86-64 CPU has it.
        unsafe {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            _mm_prefetch::<_MM_HINT_T0>(at);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (items, offset);
}

/// How many bytes a CPU reads at once.
const CACHE_LINE: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    /// Bits past the lanes, which mean nothing.
    const UNUSED: u32 = 0xffff_0000;

    /// Every operation on one set of inputs, so that the paths can be compared bit by bit.
    struct Everything<'a> {
        a: &'a Row,
        b: &'a Row,
        rows: &'a [Row; WIDTH],
        blocks: &'a [Block],
    }

    /// Eight f64 through every operation on them, rounded.
    #[inline(always)]
    fn in_f64<L: Lanes>(l: L, [a, b]: &[[f64; WIDTH / 2]; 2]) -> L::F {
        let (a, b) = (l.load_d(a), l.load_d(b));
        let low = l.sub_d(l.mul_d(a, b), l.add_d(a, l.splat_d(0.1)));
        let mut halves = [[0.0; WIDTH / 2]; 2];
        l.store_d(low, &mut halves[0]);
        let quotient = l.div_d(l.mul_d(low, low), b);
        l.store_d(l.select_lt_d(a, b, low, quotient), &mut halves[1]);
        l.round_from([&halves[0], &halves[1]])
    }

    /// A centre and a radius.
    struct Ball([f64; 4]);

    impl AsRef<[f64; 4]> for Ball {
        fn as_ref(&self) -> &[f64; 4] {
            &self.0
        }
    }

    /// Of which of two spheres, and of two others, eight pairs are.
    const OF_BALLS: [Pair; WIDTH / 2] = {
        let mut pairs = [Pair { i: 0, j: 0 }; WIDTH / 2];
        let mut k = 0;
        while k < WIDTH / 2 {
            pairs[k] = Pair { i: k as u32 % 2, j: k as u32 / 2 % 2 };
            k += 1;
        }
        pairs
    };

    /// Points that do not follow each other.
    const SHUFFLED: [usize; WIDTH / 2] = [3, 0, 7, 5, 2, 6, 1, 4];

    /// What is between them: differences beside differences, and differences beside sums, rounded.
    fn between_balls<L: Lanes>(l: L, numbers: &[[f64; WIDTH / 2]; 2]) -> [L::F; 2] {
        let balls =
            numbers.map(|eight| [[0, 1, 2, 3], [4, 5, 6, 7]].map(|of| Ball(of.map(|k| eight[k]))));
        let found = l.sphere_pairs([&balls[0], &balls[1]], &OF_BALLS);
        let columns = found.map(|column| {
            let mut numbers = [0.0; WIDTH / 2];
            l.store_d(column, &mut numbers);
            numbers
        });
        [l.round_from([&columns[0], &columns[1]]), l.round_from([&columns[2], &columns[3]])]
    }

    /// The first eight lanes, beside zeros.
    #[inline(always)]
    fn half_stored<L: Lanes>(l: L, a: L::F) -> L::F {
        let mut row = Row::default();
        if let Some(half) = row.0.first_chunk_mut() {
            l.store_half(a, half);
        }
        l.load(&row)
    }

    impl Kernel for Everything<'_> {
        type Output = (Vec<Row>, Vec<u32>, Vec<u32>);

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let (a, b) = (l.load(self.a), l.load(self.b));
            // Some lie past the last of five blocks.
            let (first, number) = (l.tag_of(b, l.splat_u(3)), l.tag_of(a, l.splat_u(63)));
            let halves = [0, WIDTH / 2].map(|from| self.a.0[from..].first_chunk().unwrap());
            let rows = self.rows;
            let fours: [[f32; 4]; WIDTH / 2] = std::array::from_fn(|k| {
                std::array::from_fn(|axis| rows[k / 4].0[4 * (k % 4) + axis])
            });
            let fours = SHUFFLED.map(|k| &fours[k]);
            let thirds = halves.map(|half: &[f32; WIDTH / 2]| half.map(|x| f64::from(x) / 3.0));
            let floats = [
                l.splat(0.1),
                l.add(a, b),
                l.sub(a, b),
                l.mul(a, b),
                l.div(a, b),
                l.min(a, b),
                l.max(a, b),
                l.abs(a),
                l.neg(a),
                l.sqrt(l.abs(a)),
                l.select(l.lt(a, b), a, b),
                l.largest_of_each(self.rows),
                l.tag(a, l.splat_u(63), l.add_u(l.lane_numbers(), l.splat_u(32))),
                l.pick(self.blocks, first, number)[0],
                l.pick(self.blocks, first, number)[2],
                l.pick(&[], first, number)[1],
                l.transpose(self.rows)[0],
                l.transpose(self.rows)[7],
                l.transpose(self.rows)[13],
                l.round_from([&thirds[0], &thirds[1]]),
                in_f64(l, &thirds),
                l.splat(l.largest(a)),
                l.load_half(halves[0]),
                half_stored(l, l.add(a, b)),
                half_stored(l, l.load_points(fours)[0]),
                half_stored(l, l.load_points(fours)[1]),
                half_stored(l, l.load_points(fours)[2]),
                between_balls(l, &thirds)[0],
                between_balls(l, &thirds)[1],
            ];
            let (lt, le) = (l.lt(a, b), l.le(a, b));
            let masks = [
                l.and(lt, le),
                l.or(lt, le),
                l.and_not(le, lt),
                l.mask(0xA5C3),
                l.mask(l.half_bits(le)),
                l.mask(l.lt_d(l.load_d(&thirds[0]), l.load_d(&thirds[1]))),
            ];
            let index = l.load_u(&IndexRow(std::array::from_fn(|k| 100 + k as u32)));
            let kept = l.bits(lt).count_ones() as usize;
            let mut chosen = IndexRow::default();
            l.store_u(l.tag_of(a, l.splat_u(15)), &mut chosen);
            let floats = floats.map(|f| {
                let mut row = Row::default();
                l.store(f, &mut row);
                row
            });
            let keep = l.bits(lt) | UNUSED;
            let mut compressed = Vec::new();
            // What is there before `at` stays.
            for at in [0, 5, WIDTH] {
                let (mut front, mut packed) = ([0.5; 2 * WIDTH], [7; 2 * WIDTH]);
                l.compress_to(keep, a, &mut front, at);
                l.compress_to_u(keep, index, &mut packed, at);
                compressed.extend(front[..at + kept].iter().map(|x| x.to_bits()));
                compressed.extend(&packed[..at + kept]);
            }
            // What is there stays, and a list without room grows.
            let mut pairs = Vec::from([Pair::new(3, 4)]);
            l.append_pairs(keep, (107, index), &mut pairs);
            l.append_pairs(keep, (108, index), &mut pairs);
            assert_eq!((pairs.len(), pairs[0]), (1 + 2 * kept, Pair::new(3, 4)));
            assert!(pairs.iter().all(|pair| pair.i <= pair.j));
            let pairs = pairs[1..].iter().flat_map(|pair| [pair.i, pair.j]);
            let indices = chosen.0.into_iter().chain(compressed).chain(pairs).collect();
            (floats.to_vec(), masks.map(|m| l.bits(m)).to_vec(), indices)
        }
    }

    #[test]
    fn every_path_gives_the_same_bits() {
        let number = |k: usize| ((k * 2654435761) % 1000) as f32 * 0.37 - 150.0;
        for seed in 0..50 {
            let mut a = Row(std::array::from_fn(|k| number(k + 31 * seed)));
            let b = Row(std::array::from_fn(|k| number(k + 17 * seed + 5)));
            a.0[3] = b.0[3];
            let rows =
                std::array::from_fn(|r| Row(std::array::from_fn(|k| number(r * 16 + k + seed))));
            let blocks: [Block; 5] = std::array::from_fn(|block| {
                Block(std::array::from_fn(|axis| rows[block + axis * 5]))
            });
            let everything = || Everything { a: &a, b: &b, rows: &rows, blocks: &blocks };
            let (floats, masks, indices) = portable::run(everything());
            for (row, &largest) in rows.iter().zip(&floats[11].0) {
                assert_eq!(largest, row.0.iter().copied().fold(f32::MIN, f32::max));
            }
            for (x, &rounded) in a.0.iter().zip(&floats[19].0) {
                assert_eq!(rounded, (f64::from(*x) / 3.0) as f32);
            }
            assert_eq!(floats[22].0[..8], a.0[..8]);
            let sums = (0..WIDTH).map(|k| if k < 8 { a.0[k] + b.0[k] } else { 0.0 });
            assert!(sums.eq(floats[23].0));
            for (axis, found) in floats[24..27].iter().enumerate() {
                let due = SHUFFLED.map(|k| rows[k / 4].0[4 * (k % 4) + axis]);
                assert_eq!(found.0[..8], due, "{axis}");
            }
            for (k, pair) in OF_BALLS.iter().enumerate() {
                let of = |first: usize, axis: usize| f64::from(a.0[first + axis]) / 3.0;
                let [one, other] = [4 * pair.i as usize, 8 + 4 * pair.j as usize];
                let [x, y, z] = [0, 1, 2].map(|axis| (of(one, axis) - of(other, axis)) as f32);
                let radii = (of(one, 3) + of(other, 3)) as f32;
                let found =
                    [floats[27].0[k], floats[27].0[k + 8], floats[28].0[k], floats[28].0[k + 8]];
                assert_eq!(found, [x, y, z, radii]);
            }
            let less = (0..8).filter(|&k| a.0[k] < a.0[k + 8]).fold(0, |bits, k| bits | 1 << k);
            assert_eq!(masks[5], less);
            assert_eq!(floats[21].0[0], a.0.iter().copied().fold(f32::MIN, f32::max));
            for (row, &lane_13) in rows.iter().zip(&floats[18].0) {
                assert_eq!(lane_13, row.0[13]);
            }
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let there = dispatch_on(path, everything());
                let bits =
                    |rows: &[Row]| rows.iter().map(|r| r.0.map(f32::to_bits)).collect::<Vec<_>>();
                assert_eq!(bits(&there.0), bits(&floats), "{path:?}");
                assert_eq!((there.1, there.2), (masks.clone(), indices.clone()), "{path:?}");
            }
        }
    }

    #[test]
    fn comparisons_with_nan_are_false() {
        struct Nan;
        impl Kernel for Nan {
            type Output = u32;
            #[inline(always)]
            fn run<L: Lanes>(self, l: L) -> u32 {
                let (nan, one) = (l.splat(f32::NAN), l.splat(1.0));
                let (nan_d, one_d) = (l.splat_d(f64::NAN), l.splat_d(1.0));
                let in_f64 = l.lt_d(nan_d, one_d) | l.lt_d(one_d, nan_d) | l.lt_d(nan_d, nan_d);
                let mut chosen = [0.0; WIDTH / 2];
                let (yes, no) = (l.splat_d(1.0), l.splat_d(0.0));
                for (p, q) in [(nan_d, one_d), (one_d, nan_d)] {
                    l.store_d(l.select_lt_d(p, q, yes, no), &mut chosen);
                    assert_eq!(chosen, [0.0; WIDTH / 2]);
                }
                l.bits(l.lt(nan, one)) | l.bits(l.le(one, nan)) | l.bits(l.lt(one, nan)) | in_f64
            }
        }
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            assert_eq!(dispatch_on(path, Nan), 0, "{path:?}");
        }
    }
}
