//! The operations on lanes: what a kernel is written with.

use crate::{Block, Half, IndexRow, Kernel, Pair, Row, WIDTH, half, unfused};

/// What a kernel computes with: operations on sixteen f32, on sixteen u32, on sixteen yes/no, and on eight f64.
///
/// Arithmetic is IEEE, rounded to nearest, so that f64 lanes are the bits of the same operations one by one;
/// [`Lanes::mul_add`] may or may not fuse. Comparisons
/// with NaN are false. Where an operand of `min` or `max` is NaN, the result may be either operand.
pub trait Lanes: Copy {
    /// Sixteen f32.
    type F: Copy;
    /// Sixteen u32.
    type U: Copy;
    /// Sixteen yes or no.
    type M: Copy;
    /// Eight f64.
    type D: Copy;
    /// Whether [`Lanes::mul_add`] rounds once.
    const FUSED: bool = false;
    /// Whether half of the lanes take less than all of them: see [`Lanes::run_half`].
    const HALVES: bool = false;

    /// x in every lane.
    fn splat(self, x: f32) -> Self::F;
    /// Loads from memory, unaligned.
    fn load_from(self, numbers: &[f32; WIDTH]) -> Self::F;
    /// Eight f64 and eight more, rounded.
    fn round_from(self, numbers: [&[f64; WIDTH / 2]; 2]) -> Self::F;
    /// To memory, wherever it begins.
    fn store_to(self, a: Self::F, numbers: &mut [f32; WIDTH]);
    /// a + b.
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// a − b.
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// a·b.
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// a / b.
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// a·b + c, with one rounding or two.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// The smaller.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// The larger.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// |a|.
    fn abs(self, a: Self::F) -> Self::F;
    /// √a.
    fn sqrt(self, a: Self::F) -> Self::F;
    /// a < b.
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    /// a ≤ b.
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    /// `yes` where the mask is set, else `no`.
    fn select(self, mask: Self::M, yes: Self::F, no: Self::F) -> Self::F;

    /// Both.
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    /// Either.
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// a and not b.
    fn and_not(self, a: Self::M, b: Self::M) -> Self::M;
    /// Lane k is bit k.
    fn bits(self, mask: Self::M) -> u32;
    /// Bit k is lane k; higher bits are ignored.
    fn mask(self, bits: u32) -> Self::M;

    /// x in every lane.
    fn splat_d(self, x: f64) -> Self::D;
    /// Loads from memory, unaligned.
    fn load_d(self, numbers: &[f64; WIDTH / 2]) -> Self::D;
    /// To memory, wherever it begins.
    fn store_d(self, a: Self::D, numbers: &mut [f64; WIDTH / 2]);
    /// a + b.
    fn add_d(self, a: Self::D, b: Self::D) -> Self::D;
    /// a − b.
    fn sub_d(self, a: Self::D, b: Self::D) -> Self::D;
    /// a·b.
    fn mul_d(self, a: Self::D, b: Self::D) -> Self::D;
    /// a / b.
    fn div_d(self, a: Self::D, b: Self::D) -> Self::D;
    /// `yes` where a < b, else `no`.
    fn select_lt_d(self, a: Self::D, b: Self::D, yes: Self::D, no: Self::D) -> Self::D;
    /// a < b: lane k is bit k.
    #[inline(always)]
    fn lt_d(self, a: Self::D, b: Self::D) -> u32 {
        let [mut left, mut right] = [[0.0; WIDTH / 2]; 2];
        self.store_d(a, &mut left);
        self.store_d(b, &mut right);
        let mut bits = 0;
        for k in 0..WIDTH / 2 {
            bits |= u32::from(left[k] < right[k]) << k;
        }
        bits
    }
    /// The differences of the centres' x, y and z and the sums of the radii of eight pairs of spheres, each of which is its
    /// centre and its radius.
    ///
    /// # Panics
    /// There is no such sphere.
    #[inline(always)]
    fn sphere_pairs<S: AsRef<[f64; 4]>>(
        self,
        [first, second]: [&[S]; 2],
        pairs: &[Pair; WIDTH / 2],
    ) -> [Self::D; 4] {
        let [mut x, mut y, mut z, mut radii] = [[0.0; WIDTH / 2]; 4];
        for k in 0..WIDTH / 2 {
            let a = first[pairs[k].i as usize].as_ref();
            let b = second[pairs[k].j as usize].as_ref();
            (x[k], y[k], z[k], radii[k]) = (a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] + b[3]);
        }
        [self.load_d(&x), self.load_d(&y), self.load_d(&z), self.load_d(&radii)]
    }

    /// x in every lane.
    fn splat_u(self, x: u32) -> Self::U;
    /// Loads from memory, unaligned.
    fn load_from_u(self, numbers: &[u32; WIDTH]) -> Self::U;
    /// To memory, wherever it begins.
    fn store_to_u(self, a: Self::U, numbers: &mut [u32; WIDTH]);
    /// a + b, modulo 2³².
    fn add_u(self, a: Self::U, b: Self::U) -> Self::U;
    /// Each lane's own number.
    fn lane_numbers(self) -> Self::U;

    /// Writes the lanes whose bits `keep` has, moved down to the front, from `at` on, which is at most
    /// sixteen. Sixteen numbers are written; those past the kept ones are unspecified.
    fn compress_to(self, keep: u32, a: Self::F, to: &mut [f32; 2 * WIDTH], at: usize);
    /// [`Lanes::compress_to`] of indices.
    fn compress_to_u(self, keep: u32, a: Self::U, to: &mut [u32; 2 * WIDTH], at: usize);
    /// Appends the pairs of `one` and each of the lanes whose bits `keep` has, in the order of the lanes.
    #[inline(always)]
    fn append_pairs(self, keep: u32, (one, others): (u32, Self::U), to: &mut Vec<Pair>) {
        let mut kept = [0; 2 * WIDTH];
        self.compress_to_u(keep, others, &mut kept, 0);
        // Sixteen are appended and the surplus dropped: a copy of fixed length has no loop.
        to.extend(kept[..WIDTH].iter().map(|&other| Pair { i: one.min(other), j: one.max(other) }));
        to.truncate(to.len() - WIDTH + (keep & 0xffff).count_ones() as usize);
    }
    /// The bits of `a` outside `mask`, and the bits of `tag`, which lie inside it.
    fn tag(self, a: Self::F, mask: Self::U, tag: Self::U) -> Self::F;
    /// The bits of `a` inside `mask`.
    fn tag_of(self, a: Self::F, mask: Self::U) -> Self::U;
    /// Lane k of the result is the largest lane of row k.
    fn largest_of_each(self, rows: &[Row; WIDTH]) -> Self::F;

    /// The largest lane; where a lane is NaN any, or NaN.
    #[inline(always)]
    fn largest(self, a: Self::F) -> f32 {
        let mut row = Row::default();
        self.store(a, &mut row);
        let mut width = WIDTH / 2;
        while width > 0 {
            for k in 0..width {
                let (x, y) = (row.0[k], row.0[k + width]);
                row.0[k] = if x > y { x } else { y };
            }
            width /= 2;
        }
        row.0[0]
    }

    /// Row k of the result is lane k of all rows.
    #[inline(always)]
    fn transpose(self, rows: &[Row; WIDTH]) -> [Self::F; WIDTH] {
        let mut columns = [Row::default(); WIDTH];
        let mut result = [self.splat(0.0); WIDTH];
        for k in 0..WIDTH {
            for (number, row) in rows.iter().enumerate() {
                columns[k].0[number] = row.0[k];
            }
            result[k] = self.load(&columns[k]);
        }
        result
    }

    /// The x, y and z of sixteen points: in lane k the point `number` of those that begin with
    /// block `first`, sixteen a block. Past the last block, or past [`MAX_BLOCKS`](crate::MAX_BLOCKS), a point of some
    /// block; without a block, 0.
    #[inline(always)]
    fn pick(self, blocks: &[Block], first: Self::U, number: Self::U) -> [Self::F; 3] {
        let (mut firsts, mut numbers) = (IndexRow::default(), IndexRow::default());
        self.store_u(first, &mut firsts);
        self.store_u(number, &mut numbers);
        let points = picked(blocks, &firsts, &numbers);
        [self.load(&points.0[0]), self.load(&points.0[1]), self.load(&points.0[2])]
    }

    /// A row from memory.
    #[inline(always)]
    fn load(self, row: &Row) -> Self::F {
        self.load_from(&row.0)
    }
    /// A row to memory.
    #[inline(always)]
    fn store(self, a: Self::F, row: &mut Row) {
        self.store_to(a, &mut row.0);
    }
    /// A row from memory.
    #[inline(always)]
    fn load_u(self, row: &IndexRow) -> Self::U {
        self.load_from_u(&row.0)
    }
    /// A row to memory.
    #[inline(always)]
    fn store_u(self, a: Self::U, row: &mut IndexRow) {
        self.store_to_u(a, &mut row.0);
    }

    /// Runs a part of a kernel out of line on the same lanes: it is compiled once, however many kernels call it. A call
    /// takes lanes from memory and leaves them there.
    #[inline(always)]
    fn call<K: Kernel>(self, kernel: K) -> K::Output {
        kernel.run(self)
    }

    /// Runs a kernel on lanes whose [`Lanes::mul_add`] rounds twice.
    #[inline(always)]
    fn run_unfused<K: Kernel>(self, kernel: K) -> K::Output {
        kernel.run(unfused::Apart(self))
    }

    /// Runs a kernel on one half of the lanes, with half the registers where there are several. Each lane of it has its own number; of
    /// the other half no lane is loaded, none stored, and no bit is set.
    #[inline(always)]
    fn run_half<K: Kernel>(self, half: Half, kernel: K) -> K::Output {
        kernel.run(half::Eight(self, half))
    }

    /// Loads eight from memory, unaligned, into the first lanes; the others hold some of them. Where no more than
    /// [`Lanes::store_half`] and [`Lanes::half_bits`] keep is made of it, half the registers are left out.
    #[inline(always)]
    fn load_half(self, numbers: &[f32; WIDTH / 2]) -> Self::F {
        let mut row = Row::default();
        row.0[..WIDTH / 2].copy_from_slice(numbers);
        row.0[WIDTH / 2..].copy_from_slice(numbers);
        self.load(&row)
    }
    /// The x, y and z of eight points, wherever each is, in the first lanes, as [`Lanes::load_half`] has them. A point is read as
    /// it was written, four numbers at once, where one number after the other would be waited for.
    #[inline(always)]
    fn load_points(self, points: [&[f32; 4]; WIDTH / 2]) -> [Self::F; 3] {
        let mut axes = [[0.0; WIDTH / 2]; 3];
        for (k, [x, y, z, _]) in points.into_iter().enumerate() {
            (axes[0][k], axes[1][k], axes[2][k]) = (*x, *y, *z);
        }
        [self.load_half(&axes[0]), self.load_half(&axes[1]), self.load_half(&axes[2])]
    }
    /// The first eight lanes to memory, wherever it begins.
    #[inline(always)]
    fn store_half(self, a: Self::F, numbers: &mut [f32; WIDTH / 2]) {
        let mut row = Row::default();
        self.store(a, &mut row);
        numbers.copy_from_slice(&row.0[..WIDTH / 2]);
    }
    /// [`Lanes::bits`] of the first eight lanes.
    #[inline(always)]
    fn half_bits(self, mask: Self::M) -> u32 {
        self.bits(mask) & 0xFF
    }

    /// −a.
    #[inline(always)]
    fn neg(self, a: Self::F) -> Self::F {
        self.sub(self.splat(-0.0), a)
    }
}

/// What [`Lanes::pick`] loads where there is no instruction for it. Out of line: the call is the smallest part.
fn picked(blocks: &[Block], first: &IndexRow, number: &IndexRow) -> Block {
    let mut points = Block::default();
    for k in 0..WIDTH {
        let number = number.0[k] as usize;
        let block = (first.0[k] as usize + number / WIDTH).min(blocks.len().saturating_sub(1));
        let Some(Block([x, y, z])) = blocks.get(block) else { break };
        points.0[0].0[k] = x.0[number % WIDTH];
        points.0[1].0[k] = y.0[number % WIDTH];
        points.0[2].0[k] = z.0[number % WIDTH];
    }
    points
}
