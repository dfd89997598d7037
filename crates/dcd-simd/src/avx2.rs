//! Sixteen lanes in two AVX2 registers of eight.

mod front;

use super::{Block, FLOATS, Kernel, Lanes, MAX_BLOCKS, Row, WIDTH};
use crate::pair::{Pair, room_for_sixteen};
use crate::sphere_pairs;
use front::FRONT;
use std::arch::x86_64::*;

/// Runs the kernel in a function that carries the feature, into which all of it is inlined. Out of line itself, so that it
/// is compiled once for all who call it.
///
/// # Safety
/// The CPU has AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
pub(super) unsafe fn run<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx2(()))
}

/// Made only in [`run`], whose caller vouches for the CPU: that is the reason behind every SAFETY
/// line of this file.
#[derive(Clone, Copy)]
pub(super) struct Avx2(());

/// Lanes 0 to 7 and 8 to 15.
type Halves<T> = (T, T);

/// One intrinsic on registers.
macro_rules! op {
    ($intrinsic:expr) => {
        // SAFETY: an `Avx2` exists only where the CPU has the feature.
        unsafe { $intrinsic }
    };
}

/// The same intrinsic on both halves.
macro_rules! both {
    ($intrinsic:path, $($arg:ident),+) => {
        // SAFETY: an `Avx2` exists only where the CPU has the feature.
        unsafe { ($intrinsic($($arg.0),+), $intrinsic($($arg.1),+)) }
    };
}

// Behind the macros, which it uses.
mod transpose;

impl Lanes for Avx2 {
    type F = Halves<__m256>;
    type U = Halves<__m256i>;
    type M = Halves<__m256>;
    type D = Halves<__m256d>;
    const FUSED: bool = true;
    const HALVES: bool = true;

    #[inline(always)]
    fn call<K: Kernel>(self, kernel: K) -> K::Output {
        // SAFETY: an `Avx2` exists only where the CPU has the features.
        unsafe { run(kernel) }
    }
    #[inline(always)]
    fn splat(self, x: f32) -> Self::F {
        let half = op!(_mm256_set1_ps(x));
        (half, half)
    }
    #[inline(always)]
    fn load_from(self, numbers: &[f32; WIDTH]) -> Self::F {
        let at = numbers.as_ptr();
        // SAFETY: as above; sixteen f32 are read from wherever they are.
        unsafe { (_mm256_loadu_ps(at), _mm256_loadu_ps(at.add(8))) }
    }
    #[inline(always)]
    fn round_from(self, numbers: [&[f64; WIDTH / 2]; 2]) -> Self::F {
        let half = |numbers: &[f64; WIDTH / 2]| {
            // SAFETY: as above; four f64 are read from wherever they are, twice.
            unsafe {
                let low = _mm256_cvtpd_ps(_mm256_loadu_pd(numbers.as_ptr()));
                let high = _mm256_cvtpd_ps(_mm256_loadu_pd(numbers.as_ptr().add(WIDTH / 4)));
                _mm256_set_m128(high, low)
            }
        };
        (half(numbers[0]), half(numbers[1]))
    }
    #[inline(always)]
    fn store_to(self, a: Self::F, numbers: &mut [f32; WIDTH]) {
        let at = numbers.as_mut_ptr();
        // SAFETY: as above; sixteen f32 are written to wherever they are.
        unsafe {
            _mm256_storeu_ps(at, a.0);
            _mm256_storeu_ps(at.add(8), a.1);
        }
    }
    #[inline(always)]
    fn load_half(self, numbers: &[f32; WIDTH / 2]) -> Self::F {
        // SAFETY: as above; eight f32 are read from wherever they are.
        let half = unsafe { _mm256_loadu_ps(numbers.as_ptr()) };
        (half, half)
    }
    #[inline(always)]
    fn load_points(self, points: [&[f32; 4]; WIDTH / 2]) -> [Self::F; 3] {
        let [x, y, z] = self.eight_points(points);
        [(x, x), (y, y), (z, z)]
    }
    #[inline(always)]
    fn store_half(self, a: Self::F, numbers: &mut [f32; WIDTH / 2]) {
        // SAFETY: as above; eight f32 are written to wherever they are.
        unsafe { _mm256_storeu_ps(numbers.as_mut_ptr(), a.0) }
    }
    #[inline(always)]
    fn half_bits(self, mask: Self::M) -> u32 {
        op!(_mm256_movemask_ps(mask.0)).cast_unsigned()
    }
    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        both!(_mm256_add_ps, a, b)
    }
    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        both!(_mm256_sub_ps, a, b)
    }
    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        both!(_mm256_mul_ps, a, b)
    }
    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        both!(_mm256_div_ps, a, b)
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        both!(_mm256_fmadd_ps, a, b, c)
    }
    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        both!(_mm256_min_ps, a, b)
    }
    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        both!(_mm256_max_ps, a, b)
    }
    #[inline(always)]
    fn abs(self, a: Self::F) -> Self::F {
        let sign = self.splat(-0.0);
        both!(_mm256_andnot_ps, sign, a)
    }
    #[inline(always)]
    fn sqrt(self, a: Self::F) -> Self::F {
        both!(_mm256_sqrt_ps, a)
    }
    #[inline(always)]
    fn lt(self, a: Self::F, b: Self::F) -> Self::M {
        both!(_mm256_cmp_ps::<_CMP_LT_OQ>, a, b)
    }
    #[inline(always)]
    fn le(self, a: Self::F, b: Self::F) -> Self::M {
        both!(_mm256_cmp_ps::<_CMP_LE_OQ>, a, b)
    }
    #[inline(always)]
    fn select(self, mask: Self::M, yes: Self::F, no: Self::F) -> Self::F {
        both!(_mm256_blendv_ps, no, yes, mask)
    }

    #[inline(always)]
    fn and(self, a: Self::M, b: Self::M) -> Self::M {
        both!(_mm256_and_ps, a, b)
    }
    #[inline(always)]
    fn or(self, a: Self::M, b: Self::M) -> Self::M {
        both!(_mm256_or_ps, a, b)
    }
    #[inline(always)]
    fn and_not(self, a: Self::M, b: Self::M) -> Self::M {
        both!(_mm256_andnot_ps, b, a)
    }
    #[inline(always)]
    fn bits(self, mask: Self::M) -> u32 {
        let (low, high) = both!(_mm256_movemask_ps, mask);
        (low | high << 8).cast_unsigned()
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::M {
        (self.half_mask(bits), self.half_mask(bits >> 8))
    }

    #[inline(always)]
    fn splat_d(self, x: f64) -> Self::D {
        let half = op!(_mm256_set1_pd(x));
        (half, half)
    }
    #[inline(always)]
    fn load_d(self, numbers: &[f64; WIDTH / 2]) -> Self::D {
        let at = numbers.as_ptr();
        // SAFETY: as above; eight f64 are read from wherever they are.
        unsafe { (_mm256_loadu_pd(at), _mm256_loadu_pd(at.add(WIDTH / 4))) }
    }
    #[inline(always)]
    fn store_d(self, a: Self::D, numbers: &mut [f64; WIDTH / 2]) {
        let at = numbers.as_mut_ptr();
        // SAFETY: as above; eight f64 are written to wherever they are.
        unsafe {
            _mm256_storeu_pd(at, a.0);
            _mm256_storeu_pd(at.add(WIDTH / 4), a.1);
        }
    }
    #[inline(always)]
    fn add_d(self, a: Self::D, b: Self::D) -> Self::D {
        both!(_mm256_add_pd, a, b)
    }
    #[inline(always)]
    fn sub_d(self, a: Self::D, b: Self::D) -> Self::D {
        both!(_mm256_sub_pd, a, b)
    }
    #[inline(always)]
    fn mul_d(self, a: Self::D, b: Self::D) -> Self::D {
        both!(_mm256_mul_pd, a, b)
    }
    #[inline(always)]
    fn div_d(self, a: Self::D, b: Self::D) -> Self::D {
        both!(_mm256_div_pd, a, b)
    }
    #[inline(always)]
    fn select_lt_d(self, a: Self::D, b: Self::D, yes: Self::D, no: Self::D) -> Self::D {
        let is_less = both!(_mm256_cmp_pd::<_CMP_LT_OQ>, a, b);
        both!(_mm256_blendv_pd, no, yes, is_less)
    }
    #[inline(always)]
    fn lt_d(self, a: Self::D, b: Self::D) -> u32 {
        let less = both!(sphere_pairs::less, a, b);
        (less.0 | less.1 << 4).cast_unsigned()
    }
    #[inline(always)]
    fn sphere_pairs<S: AsRef<[f64; 4]>>(
        self,
        spheres: [&[S]; 2],
        &[a, b, c, d, e, f, g, h]: &[Pair; WIDTH / 2],
    ) -> [Self::D; 4] {
        // SAFETY: as above.
        let (low, high) = unsafe {
            (sphere_pairs::four(spheres, &[a, b, c, d]), sphere_pairs::four(spheres, &[e, f, g, h]))
        };
        [(low[0], high[0]), (low[1], high[1]), (low[2], high[2]), (low[3], high[3])]
    }

    #[inline(always)]
    fn splat_u(self, x: u32) -> Self::U {
        let half = op!(_mm256_set1_epi32(x.cast_signed()));
        (half, half)
    }
    #[inline(always)]
    fn load_from_u(self, numbers: &[u32; WIDTH]) -> Self::U {
        let at = numbers.as_ptr().cast::<__m256i>();
        // SAFETY: as above; sixteen u32 are read from wherever they are.
        unsafe { (_mm256_loadu_si256(at), _mm256_loadu_si256(at.add(1))) }
    }
    #[inline(always)]
    fn store_to_u(self, a: Self::U, numbers: &mut [u32; WIDTH]) {
        let at = numbers.as_mut_ptr().cast::<__m256i>();
        // SAFETY: as above; sixteen u32 are written to wherever they are.
        unsafe {
            _mm256_storeu_si256(at, a.0);
            _mm256_storeu_si256(at.add(1), a.1);
        }
    }
    #[inline(always)]
    fn add_u(self, a: Self::U, b: Self::U) -> Self::U {
        both!(_mm256_add_epi32, a, b)
    }
    #[inline(always)]
    fn lane_numbers(self) -> Self::U {
        op!((
            _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7),
            _mm256_setr_epi32(8, 9, 10, 11, 12, 13, 14, 15)
        ))
    }

    #[inline(always)]
    fn compress_to(self, keep: u32, a: Self::F, to: &mut [f32; 2 * WIDTH], at: usize) {
        let numbers = both!(_mm256_castps_si256, a);
        // SAFETY: as above; sixteen numbers of 32 bits from at most the sixteenth of thirty-two on.
        unsafe { self.fronts_to(keep, numbers, to.as_mut_ptr().add(at.min(WIDTH)).cast()) }
    }
    #[inline(always)]
    fn compress_to_u(self, keep: u32, a: Self::U, to: &mut [u32; 2 * WIDTH], at: usize) {
        // SAFETY: as above.
        unsafe { self.fronts_to(keep, a, to.as_mut_ptr().add(at.min(WIDTH))) }
    }
    #[inline(always)]
    fn append_pairs(self, keep: u32, (one, others): (u32, Self::U), to: &mut Vec<Pair>) {
        let one = op!(_mm256_set1_epi32(one.cast_signed()));
        let end = room_for_sixteen(to);
        // SAFETY: as above; eight pairs at most eight after the first of sixteen. The kept ones are written.
        unsafe {
            self.front_pairs_to(keep, (one, others.0), end);
            self.front_pairs_to(keep >> 8, (one, others.1), end.add(kept_below(keep)));
            to.set_len(to.len() + kept_below(keep) + kept_below(keep >> 8));
        }
    }
    #[inline(always)]
    fn tag(self, a: Self::F, mask: Self::U, tag: Self::U) -> Self::F {
        let mask = (op!(_mm256_castsi256_ps(mask.0)), op!(_mm256_castsi256_ps(mask.1)));
        let tag = (op!(_mm256_castsi256_ps(tag.0)), op!(_mm256_castsi256_ps(tag.1)));
        let rest = both!(_mm256_andnot_ps, mask, a);
        both!(_mm256_or_ps, rest, tag)
    }
    #[inline(always)]
    fn tag_of(self, a: Self::F, mask: Self::U) -> Self::U {
        let bits = both!(_mm256_castps_si256, a);
        both!(_mm256_and_si256, bits, mask)
    }
    #[inline(always)]
    fn transpose(self, rows: &[Row; WIDTH]) -> [Self::F; WIDTH] {
        let mut columns = [self.splat(0.0); WIDTH];
        for side in 0..2 {
            let above = self.transpose_eight(rows, 0, 8 * side);
            let below = self.transpose_eight(rows, 8, 8 * side);
            for k in 0..8 {
                columns[8 * side + k] = (above[k], below[k]);
            }
        }
        columns
    }
    #[inline(always)]
    fn largest_of_each(self, rows: &[Row; WIDTH]) -> Self::F {
        (self.largest_of_eight(rows, 0), self.largest_of_eight(rows, 8))
    }
    #[inline(always)]
    fn largest(self, a: Self::F) -> f32 {
        let eight = op!(_mm256_max_ps(a.0, a.1));
        let high = op!(_mm256_extractf128_ps::<1>(eight));
        let four = op!(_mm_max_ps(_mm256_castps256_ps128(eight), high));
        let two = op!(_mm_max_ps(four, _mm_movehl_ps(four, four)));
        op!(_mm_cvtss_f32(_mm_max_ss(two, _mm_shuffle_ps::<1>(two, two))))
    }
    #[inline(always)]
    fn pick(self, blocks: &[Block], first: Self::U, number: Self::U) -> [Self::F; 3] {
        let Some(last) = blocks.len().min(MAX_BLOCKS).checked_sub(1) else {
            return [self.splat(0.0); 3];
        };
        let last = op!(_mm256_set1_epi32(last as i32));
        let mut at = [0; WIDTH];
        let halves =
            (self.floats_at(first.0, number.0, last), self.floats_at(first.1, number.1, last));
        self.store_to_u(halves, &mut at);
        let x = blocks.as_ptr().cast::<f32>();
        // SAFETY: each is that of an x, y or z of a block that exists.
        unsafe {
            [
                self.gather(x, &at),
                self.gather(x.add(WIDTH), &at),
                self.gather(x.add(2 * WIDTH), &at),
            ]
        }
    }
}

/// How many of the first eight lanes are kept: at most eight.
#[inline(always)]
fn kept_below(keep: u32) -> usize {
    (keep & 255).count_ones() as usize
}

/// What one half needs.
impl Avx2 {
    #[inline(always)]
    fn half_mask(self, bits: u32) -> __m256 {
        op!({
            let bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = _mm256_and_si256(_mm256_set1_epi32(bits.cast_signed()), bit);
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, bit))
        })
    }

    #[inline(always)]
    fn half_front(self, bits: u32, a: __m256i) -> __m256i {
        let table = &FRONT[(bits & 255) as usize];
        // SAFETY: as above; a table row is eight bytes, read unaligned.
        let lanes = unsafe { _mm256_cvtepu8_epi32(_mm_loadl_epi64(table.as_ptr().cast())) };
        op!(_mm256_permutevar8x32_epi32(a, lanes))
    }

    /// Writes the kept lanes of each half where they belong, the second over the first's tail: through
    /// a buffer, no store could be forwarded to the load that joins them.
    ///
    /// # Safety
    /// Sixteen can be written.
    #[inline(always)]
    unsafe fn fronts_to(self, keep: u32, a: Halves<__m256i>, to: *mut u32) {
        // SAFETY: eight u32 at an offset of at most eight.
        unsafe {
            _mm256_storeu_si256(to.cast(), self.half_front(keep, a.0));
            let after = to.add(kept_below(keep)).cast();
            _mm256_storeu_si256(after, self.half_front(keep >> 8, a.1));
        }
    }

    /// The kept lanes' pairs with the other.
    ///
    /// # Safety
    /// Eight can be written.
    #[inline(always)]
    unsafe fn front_pairs_to(self, keep: u32, (one, others): (__m256i, __m256i), to: *mut Pair) {
        let others = self.half_front(keep, others);
        // SAFETY: eight pairs are sixteen u32 in a row, as `repr(C)` has them.
        unsafe {
            let (i, j) = (_mm256_min_epu32(one, others), _mm256_max_epu32(one, others));
            let (low, high) = (_mm256_unpacklo_epi32(i, j), _mm256_unpackhi_epi32(i, j));
            let to = to.cast::<__m256i>();
            _mm256_storeu_si256(to, _mm256_permute2x128_si256::<0x20>(low, high));
            _mm256_storeu_si256(to.add(1), _mm256_permute2x128_si256::<0x31>(low, high));
        }
    }

    /// Where the x of eight points are, counted in floats: each of a block that exists, so below 2³¹ as
    /// `MAX_BLOCKS` has it.
    #[inline(always)]
    fn floats_at(self, first: __m256i, number: __m256i, last: __m256i) -> __m256i {
        op!({
            let block = _mm256_add_epi32(first, _mm256_srli_epi32::<4>(number));
            let block = _mm256_min_epu32(block, last);
            let lane = _mm256_and_si256(number, _mm256_set1_epi32(15));
            let at = _mm256_mullo_epi32(block, _mm256_set1_epi32(FLOATS as i32));
            _mm256_add_epi32(at, lane)
        })
    }

    /// Sixteen floats from wherever they are: on most CPUs without a wider path faster than the
    /// instruction for it.
    ///
    /// # Safety
    /// They are there.
    #[inline(always)]
    unsafe fn gather(self, from: *const f32, at: &[u32; WIDTH]) -> Halves<__m256> {
        // SAFETY: as the caller says.
        unsafe {
            let four = [
                self.gather_four(from, [at[0], at[1], at[2], at[3]]),
                self.gather_four(from, [at[4], at[5], at[6], at[7]]),
                self.gather_four(from, [at[8], at[9], at[10], at[11]]),
                self.gather_four(from, [at[12], at[13], at[14], at[15]]),
            ];
            (_mm256_set_m128(four[1], four[0]), _mm256_set_m128(four[3], four[2]))
        }
    }

    /// # Safety
    /// They are there.
    #[inline(always)]
    unsafe fn gather_four(self, from: *const f32, at: [u32; 4]) -> __m128 {
        // SAFETY: as the caller says.
        unsafe {
            let a = _mm_load_ss(from.add(at[0] as usize));
            let b = _mm_insert_ps::<0x10>(a, _mm_load_ss(from.add(at[1] as usize)));
            let c = _mm_insert_ps::<0x20>(b, _mm_load_ss(from.add(at[2] as usize)));
            _mm_insert_ps::<0x30>(c, _mm_load_ss(from.add(at[3] as usize)))
        }
    }

    /// Lane k of the result is the largest lane of row `first + k`. Each level halves the rows and
    /// keeps twice as many row numbers apart in a register.
    #[inline(always)]
    fn largest_of_eight(self, rows: &[Row; WIDTH], first: usize) -> __m256 {
        let r = &rows[first..first + 8];
        let l1 = [
            self.singles(&r[0], &r[1]),
            self.singles(&r[2], &r[3]),
            self.singles(&r[4], &r[5]),
            self.singles(&r[6], &r[7]),
        ];
        let (a, b) = (self.doubles(l1[0], l1[1]), self.doubles(l1[2], l1[3]));
        op!(_mm256_max_ps(
            _mm256_permute2f128_ps::<0x20>(a, b),
            _mm256_permute2f128_ps::<0x31>(a, b)
        ))
    }

    #[inline(always)]
    fn singles(self, a: &Row, b: &Row) -> __m256 {
        let (a, b) = (self.load(a), self.load(b));
        op!({
            let (a, b) = (_mm256_max_ps(a.0, a.1), _mm256_max_ps(b.0, b.1));
            _mm256_max_ps(_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b))
        })
    }

    #[inline(always)]
    fn doubles(self, a: __m256, b: __m256) -> __m256 {
        op!({
            let (a, b) = (_mm256_castps_pd(a), _mm256_castps_pd(b));
            let low = _mm256_castpd_ps(_mm256_unpacklo_pd(a, b));
            _mm256_max_ps(low, _mm256_castpd_ps(_mm256_unpackhi_pd(a, b)))
        })
    }
}
