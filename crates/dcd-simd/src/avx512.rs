//! Sixteen lanes in one AVX-512 register.

use super::{Block, FLOATS, Kernel, Lanes, MAX_BLOCKS, Row, WIDTH};
use crate::pair::{Pair, room_for_sixteen};
use crate::sphere_pairs;
use std::arch::x86_64::*;

/// Runs the kernel in a function that carries the feature, into which all of it is inlined. Out of line itself, so that it
/// is compiled once for all who call it.
///
/// # Safety
/// The CPU has AVX-512 F, DQ, BW and VL, AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT.
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
pub(super) unsafe fn run<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx512(()))
}

/// Made only in [`run`], whose caller vouches for the CPU: that is the reason behind every SAFETY
/// line of this file.
#[derive(Clone, Copy)]
pub(super) struct Avx512(());

/// One intrinsic on registers.
macro_rules! op {
    ($intrinsic:expr) => {
        // SAFETY: an `Avx512` exists only where the CPU has the feature.
        unsafe { $intrinsic }
    };
}

impl Lanes for Avx512 {
    type F = __m512;
    type U = __m512i;
    type M = __mmask16;
    type D = __m512d;
    const FUSED: bool = true;

    #[inline(always)]
    fn call<K: Kernel>(self, kernel: K) -> K::Output {
        // SAFETY: an `Avx512` exists only where the CPU has the features.
        unsafe { run(kernel) }
    }
    #[inline(always)]
    fn splat(self, x: f32) -> __m512 {
        op!(_mm512_set1_ps(x))
    }
    #[inline(always)]
    fn load_from(self, numbers: &[f32; WIDTH]) -> __m512 {
        // SAFETY: as above; sixteen f32 are read from wherever they are.
        unsafe { _mm512_loadu_ps(numbers.as_ptr()) }
    }
    #[inline(always)]
    fn round_from(self, numbers: [&[f64; WIDTH / 2]; 2]) -> __m512 {
        // SAFETY: as above; eight f64 are read from wherever they are, twice.
        unsafe {
            let low = _mm512_cvtpd_ps(_mm512_loadu_pd(numbers[0].as_ptr()));
            let high = _mm512_cvtpd_ps(_mm512_loadu_pd(numbers[1].as_ptr()));
            _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high)
        }
    }
    #[inline(always)]
    fn store_to(self, a: __m512, numbers: &mut [f32; WIDTH]) {
        // SAFETY: as above; sixteen f32 are written to wherever they are.
        unsafe { _mm512_storeu_ps(numbers.as_mut_ptr(), a) }
    }
    #[inline(always)]
    fn load_half(self, numbers: &[f32; WIDTH / 2]) -> __m512 {
        // SAFETY: as above; eight f32 are read from wherever they are.
        unsafe {
            let half = _mm256_loadu_ps(numbers.as_ptr());
            _mm512_insertf32x8::<1>(_mm512_castps256_ps512(half), half)
        }
    }
    #[inline(always)]
    fn load_points(self, points: [&[f32; 4]; WIDTH / 2]) -> [__m512; 3] {
        let mut four = [op!(_mm512_setzero_ps()); 4];
        for k in 0..4 {
            // SAFETY: as above; four f32 are read from wherever they are, twice.
            four[k] = unsafe {
                let half = _mm512_castps128_ps512(_mm_loadu_ps(points[k].as_ptr()));
                let last = _mm_loadu_ps(points[k + 4].as_ptr());
                _mm512_insertf32x4::<1>(half, last)
            };
        }
        let [a, b, c, d] = four;
        op!({
            let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
            let (ab_high, cd_high) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
            [
                _mm512_shuffle_ps::<0b01_00_01_00>(ab, cd),
                _mm512_shuffle_ps::<0b11_10_11_10>(ab, cd),
                _mm512_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
            ]
        })
    }
    #[inline(always)]
    fn store_half(self, a: __m512, numbers: &mut [f32; WIDTH / 2]) {
        // SAFETY: as above; eight f32 are written to wherever they are.
        unsafe { _mm256_storeu_ps(numbers.as_mut_ptr(), _mm512_castps512_ps256(a)) }
    }
    #[inline(always)]
    fn add(self, a: __m512, b: __m512) -> __m512 {
        op!(_mm512_add_ps(a, b))
    }
    #[inline(always)]
    fn sub(self, a: __m512, b: __m512) -> __m512 {
        op!(_mm512_sub_ps(a, b))
    }
    #[inline(always)]
    fn mul(self, a: __m512, b: __m512) -> __m512 {
        op!(_mm512_mul_ps(a, b))
    }
    #[inline(always)]
    fn div(self, a: __m512, b: __m512) -> __m512 {
        op!(_mm512_div_ps(a, b))
    }
    #[inline(always)]
    fn mul_add(self, a: __m512, b: __m512, c: __m512) -> __m512 {
        op!(_mm512_fmadd_ps(a, b, c))
    }
    #[inline(always)]
    fn min(self, a: __m512, b: __m512) -> __m512 {
        op!(_mm512_min_ps(a, b))
    }
    #[inline(always)]
    fn max(self, a: __m512, b: __m512) -> __m512 {
        op!(_mm512_max_ps(a, b))
    }
    #[inline(always)]
    fn abs(self, a: __m512) -> __m512 {
        op!(_mm512_abs_ps(a))
    }
    #[inline(always)]
    fn sqrt(self, a: __m512) -> __m512 {
        op!(_mm512_sqrt_ps(a))
    }
    #[inline(always)]
    fn largest(self, a: __m512) -> f32 {
        op!(_mm512_reduce_max_ps(a))
    }
    #[inline(always)]
    fn lt(self, a: __m512, b: __m512) -> __mmask16 {
        op!(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b))
    }
    #[inline(always)]
    fn le(self, a: __m512, b: __m512) -> __mmask16 {
        op!(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b))
    }
    #[inline(always)]
    fn select(self, mask: __mmask16, yes: __m512, no: __m512) -> __m512 {
        op!(_mm512_mask_blend_ps(mask, no, yes))
    }

    #[inline(always)]
    fn and(self, a: __mmask16, b: __mmask16) -> __mmask16 {
        a & b
    }
    #[inline(always)]
    fn or(self, a: __mmask16, b: __mmask16) -> __mmask16 {
        a | b
    }
    #[inline(always)]
    fn and_not(self, a: __mmask16, b: __mmask16) -> __mmask16 {
        a & !b
    }
    #[inline(always)]
    fn bits(self, mask: __mmask16) -> u32 {
        mask.into()
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> __mmask16 {
        bits as __mmask16
    }

    #[inline(always)]
    fn splat_d(self, x: f64) -> __m512d {
        op!(_mm512_set1_pd(x))
    }
    #[inline(always)]
    fn load_d(self, numbers: &[f64; WIDTH / 2]) -> __m512d {
        // SAFETY: as above; eight f64 are read from wherever they are.
        unsafe { _mm512_loadu_pd(numbers.as_ptr()) }
    }
    #[inline(always)]
    fn store_d(self, a: __m512d, numbers: &mut [f64; WIDTH / 2]) {
        // SAFETY: as above; eight f64 are written to wherever they are.
        unsafe { _mm512_storeu_pd(numbers.as_mut_ptr(), a) }
    }
    #[inline(always)]
    fn add_d(self, a: __m512d, b: __m512d) -> __m512d {
        op!(_mm512_add_pd(a, b))
    }
    #[inline(always)]
    fn sub_d(self, a: __m512d, b: __m512d) -> __m512d {
        op!(_mm512_sub_pd(a, b))
    }
    #[inline(always)]
    fn mul_d(self, a: __m512d, b: __m512d) -> __m512d {
        op!(_mm512_mul_pd(a, b))
    }
    #[inline(always)]
    fn div_d(self, a: __m512d, b: __m512d) -> __m512d {
        op!(_mm512_div_pd(a, b))
    }
    #[inline(always)]
    fn select_lt_d(self, a: __m512d, b: __m512d, yes: __m512d, no: __m512d) -> __m512d {
        op!(_mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b), no, yes))
    }
    #[inline(always)]
    fn lt_d(self, a: __m512d, b: __m512d) -> u32 {
        op!(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b)).into()
    }
    #[inline(always)]
    fn sphere_pairs<S: AsRef<[f64; 4]>>(
        self,
        spheres: [&[S]; 2],
        &[a, b, c, d, e, f, g, h]: &[Pair; WIDTH / 2],
    ) -> [__m512d; 4] {
        // SAFETY: as above.
        let (low, high) = unsafe {
            (sphere_pairs::four(spheres, &[a, b, c, d]), sphere_pairs::four(spheres, &[e, f, g, h]))
        };
        let mut columns = [self.splat_d(0.0); 4];
        for k in 0..4 {
            columns[k] = op!(_mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low[k]), high[k]));
        }
        columns
    }

    #[inline(always)]
    fn splat_u(self, x: u32) -> __m512i {
        op!(_mm512_set1_epi32(x.cast_signed()))
    }
    #[inline(always)]
    fn load_from_u(self, numbers: &[u32; WIDTH]) -> __m512i {
        // SAFETY: as above; sixteen u32 are read from wherever they are.
        unsafe { _mm512_loadu_si512(numbers.as_ptr().cast()) }
    }
    #[inline(always)]
    fn store_to_u(self, a: __m512i, numbers: &mut [u32; WIDTH]) {
        // SAFETY: as above; sixteen u32 are written to wherever they are.
        unsafe { _mm512_storeu_si512(numbers.as_mut_ptr().cast(), a) }
    }
    #[inline(always)]
    fn add_u(self, a: __m512i, b: __m512i) -> __m512i {
        op!(_mm512_add_epi32(a, b))
    }
    #[inline(always)]
    fn lane_numbers(self) -> __m512i {
        op!(_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15))
    }

    #[inline(always)]
    fn compress_to(self, keep: u32, a: __m512, to: &mut [f32; 2 * WIDTH], at: usize) {
        // A masked store of what is kept would be slower on many a CPU.
        let kept = op!(_mm512_maskz_compress_ps(self.mask(keep), a));
        if let Some(to) = to[at.min(WIDTH)..].first_chunk_mut() {
            self.store_to(kept, to);
        }
    }
    #[inline(always)]
    fn compress_to_u(self, keep: u32, a: __m512i, to: &mut [u32; 2 * WIDTH], at: usize) {
        let kept = op!(_mm512_maskz_compress_epi32(self.mask(keep), a));
        if let Some(to) = to[at.min(WIDTH)..].first_chunk_mut() {
            self.store_to_u(kept, to);
        }
    }
    #[inline(always)]
    fn append_pairs(self, keep: u32, (one, others): (u32, __m512i), to: &mut Vec<Pair>) {
        let end = room_for_sixteen(to);
        // SAFETY: as above; sixteen pairs are thirty-two u32 in a row, as `repr(C)` has them, and all are written.
        unsafe {
            let kept = _mm512_maskz_compress_epi32(self.mask(keep), others);
            let one = self.splat_u(one);
            let (i, j) = (_mm512_min_epu32(one, kept), _mm512_max_epu32(one, kept));
            let first = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
            let last =
                _mm512_setr_epi32(8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
            _mm512_storeu_si512(end.cast(), _mm512_permutex2var_epi32(i, first, j));
            _mm512_storeu_si512(end.add(8).cast(), _mm512_permutex2var_epi32(i, last, j));
            to.set_len(to.len() + (keep & 0xffff).count_ones() as usize);
        }
    }
    #[inline(always)]
    fn tag(self, a: __m512, mask: __m512i, tag: __m512i) -> __m512 {
        // 0xBA: (a and not mask) or tag, in one ternary operation.
        op!(_mm512_castsi512_ps(_mm512_ternarylogic_epi32::<0xBA>(
            _mm512_castps_si512(a),
            mask,
            tag
        )))
    }
    #[inline(always)]
    fn tag_of(self, a: __m512, mask: __m512i) -> __m512i {
        op!(_mm512_and_si512(_mm512_castps_si512(a), mask))
    }
    #[inline(always)]
    fn largest_of_each(self, rows: &[Row; WIDTH]) -> __m512 {
        // Each level halves the rows and keeps twice as many row numbers apart in a register.
        let l1: [__m512; 8] = [
            self.singles(&rows[0], &rows[1]),
            self.singles(&rows[2], &rows[3]),
            self.singles(&rows[4], &rows[5]),
            self.singles(&rows[6], &rows[7]),
            self.singles(&rows[8], &rows[9]),
            self.singles(&rows[10], &rows[11]),
            self.singles(&rows[12], &rows[13]),
            self.singles(&rows[14], &rows[15]),
        ];
        let l2 = [
            self.doubles(l1[0], l1[1]),
            self.doubles(l1[2], l1[3]),
            self.doubles(l1[4], l1[5]),
            self.doubles(l1[6], l1[7]),
        ];
        self.quarters(self.quarters(l2[0], l2[1]), self.quarters(l2[2], l2[3]))
    }

    #[inline(always)]
    fn transpose(self, rows: &[Row; WIDTH]) -> [__m512; WIDTH] {
        let quads = [
            self.transpose_four(&rows[0], &rows[1], &rows[2], &rows[3]),
            self.transpose_four(&rows[4], &rows[5], &rows[6], &rows[7]),
            self.transpose_four(&rows[8], &rows[9], &rows[10], &rows[11]),
            self.transpose_four(&rows[12], &rows[13], &rows[14], &rows[15]),
        ];
        let mut columns = [self.splat(0.0); WIDTH];
        for k in 0..4 {
            // Quarters 0 and 2, then 1 and 3, of two fours of rows, and of both such pairs.
            let low = op!(_mm512_shuffle_f32x4::<0x88>(quads[0][k], quads[1][k]));
            let high = op!(_mm512_shuffle_f32x4::<0x88>(quads[2][k], quads[3][k]));
            columns[k] = op!(_mm512_shuffle_f32x4::<0x88>(low, high));
            columns[8 + k] = op!(_mm512_shuffle_f32x4::<0xdd>(low, high));
            let low = op!(_mm512_shuffle_f32x4::<0xdd>(quads[0][k], quads[1][k]));
            let high = op!(_mm512_shuffle_f32x4::<0xdd>(quads[2][k], quads[3][k]));
            columns[4 + k] = op!(_mm512_shuffle_f32x4::<0x88>(low, high));
            columns[12 + k] = op!(_mm512_shuffle_f32x4::<0xdd>(low, high));
        }
        columns
    }

    #[inline(always)]
    fn pick(self, blocks: &[Block], first: __m512i, number: __m512i) -> [__m512; 3] {
        let Some(last) = blocks.len().min(MAX_BLOCKS).checked_sub(1) else {
            return [self.splat(0.0); 3];
        };
        // SAFETY: as above; what is read is of a block that exists, for its number is at most
        // `last`, and its offset in floats is below 2³¹, as `MAX_BLOCKS` has it.
        unsafe {
            let block = _mm512_add_epi32(first, _mm512_srli_epi32::<4>(number));
            let block = _mm512_min_epu32(block, _mm512_set1_epi32(last as i32));
            let lane = _mm512_and_si512(number, _mm512_set1_epi32(15));
            let at = _mm512_mullo_epi32(block, _mm512_set1_epi32(FLOATS as i32));
            let at = _mm512_add_epi32(at, lane);
            let x = blocks.as_ptr().cast::<f32>();
            [
                _mm512_i32gather_ps::<4>(at, x),
                _mm512_i32gather_ps::<4>(at, x.add(WIDTH)),
                _mm512_i32gather_ps::<4>(at, x.add(2 * WIDTH)),
            ]
        }
    }
}

impl Avx512 {
    /// Quarter q of register k is lane 4q + k of the four rows.
    #[inline(always)]
    fn transpose_four(self, a: &Row, b: &Row, c: &Row, d: &Row) -> [__m512; 4] {
        op!({
            let (a, b, c, d) = (self.load(a), self.load(b), self.load(c), self.load(d));
            let ab_low = _mm512_castps_pd(_mm512_unpacklo_ps(a, b));
            let ab_high = _mm512_castps_pd(_mm512_unpackhi_ps(a, b));
            let cd_low = _mm512_castps_pd(_mm512_unpacklo_ps(c, d));
            let cd_high = _mm512_castps_pd(_mm512_unpackhi_ps(c, d));
            [
                _mm512_castpd_ps(_mm512_unpacklo_pd(ab_low, cd_low)),
                _mm512_castpd_ps(_mm512_unpackhi_pd(ab_low, cd_low)),
                _mm512_castpd_ps(_mm512_unpacklo_pd(ab_high, cd_high)),
                _mm512_castpd_ps(_mm512_unpackhi_pd(ab_high, cd_high)),
            ]
        })
    }
}

/// The three ways in which two registers are folded into one, by the size of what is kept apart.
impl Avx512 {
    #[inline(always)]
    fn singles(self, a: &Row, b: &Row) -> __m512 {
        let (a, b) = (self.load(a), self.load(b));
        op!(_mm512_max_ps(_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b)))
    }

    #[inline(always)]
    fn doubles(self, a: __m512, b: __m512) -> __m512 {
        op!({
            let (a, b) = (_mm512_castps_pd(a), _mm512_castps_pd(b));
            let low = _mm512_castpd_ps(_mm512_unpacklo_pd(a, b));
            _mm512_max_ps(low, _mm512_castpd_ps(_mm512_unpackhi_pd(a, b)))
        })
    }

    #[inline(always)]
    fn quarters(self, a: __m512, b: __m512) -> __m512 {
        op!(_mm512_max_ps(
            _mm512_shuffle_f32x4::<0b10_00_10_00>(a, b),
            _mm512_shuffle_f32x4::<0b11_01_11_01>(a, b)
        ))
    }
}
