//! Sixteen lanes in one AVX-512 register.

use super::{IndexRow, Kernel, Lanes, Row, WIDTH};
use std::arch::x86_64::*;

/// Runs the kernel in a function that carries the feature, into which all of it is inlined.
///
/// # Safety
/// The CPU has AVX-512 F, DQ, BW and VL.
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
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

    #[inline(always)]
    fn splat(self, x: f32) -> __m512 {
        op!(_mm512_set1_ps(x))
    }
    #[inline(always)]
    fn load(self, row: &Row) -> __m512 {
        // SAFETY: as above; a `Row` is sixteen f32, aligned to 64.
        unsafe { _mm512_load_ps(row.0.as_ptr()) }
    }
    #[inline(always)]
    fn store(self, a: __m512, row: &mut Row) {
        // SAFETY: as above; a `Row` is sixteen f32, aligned to 64.
        unsafe { _mm512_store_ps(row.0.as_mut_ptr(), a) }
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
    fn splat_u(self, x: u32) -> __m512i {
        op!(_mm512_set1_epi32(x.cast_signed()))
    }
    #[inline(always)]
    fn load_u(self, row: &IndexRow) -> __m512i {
        // SAFETY: as above; an `IndexRow` is sixteen u32, aligned to 64.
        unsafe { _mm512_load_si512(row.0.as_ptr().cast()) }
    }
    #[inline(always)]
    fn store_u(self, a: __m512i, row: &mut IndexRow) {
        // SAFETY: as above; an `IndexRow` is sixteen u32, aligned to 64.
        unsafe { _mm512_store_si512(row.0.as_mut_ptr().cast(), a) }
    }
    #[inline(always)]
    fn select_u(self, mask: __mmask16, yes: __m512i, no: __m512i) -> __m512i {
        op!(_mm512_mask_blend_epi32(mask, no, yes))
    }

    #[inline(always)]
    fn compress_u(self, mask: __mmask16, a: __m512i) -> __m512i {
        op!(_mm512_maskz_compress_epi32(mask, a))
    }
    #[inline(always)]
    fn tag(self, a: __m512) -> __m512 {
        let lane = op!(_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
        // 0xEA: (a and not-low-bits) or lane, in one ternary operation.
        op!(_mm512_castsi512_ps(_mm512_ternarylogic_epi32::<0xEA>(
            _mm512_castps_si512(a),
            _mm512_set1_epi32(!15),
            lane
        )))
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
