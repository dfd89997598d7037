//! Sixteen lanes in four SSE2 registers of four: what every x86-64 CPU has.
//!
//! The arrays of `portable` would do, and say what each operation means; of code as long as a kernel the compiler
//! makes scalar instructions, four times as many and twice as long to compile.
//!
//! Where debug assertions are on, which is where kernels are tested and nobody waits for this path, each operation is
//! a call: inlined, its four registers were a third of the time that the kernels take to compile.

use super::{Kernel, Lanes, Row, WIDTH};
use crate::portable::front;
use std::arch::x86_64::*;
use std::array::from_fn;

/// Runs the kernel on SSE2. Out of line, so that it is compiled once for all who call it.
#[inline(never)]
pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Sse2)
}

#[derive(Clone, Copy)]
pub(super) struct Sse2;

/// Lanes 0 to 3, 4 to 7, 8 to 11 and 12 to 15, or half as many f64.
type Quarters<T> = [T; 4];

/// One intrinsic on registers.
macro_rules! op {
    ($intrinsic:expr) => {
        // SAFETY: every x86-64 CPU has SSE2.
        unsafe { $intrinsic }
    };
}

/// The same intrinsic on all quarters.
macro_rules! each {
    ($intrinsic:path, $($arg:ident),+) => {
        // SAFETY: every x86-64 CPU has SSE2.
        unsafe {
            [
                $intrinsic($($arg[0]),+), $intrinsic($($arg[1]),+),
                $intrinsic($($arg[2]),+), $intrinsic($($arg[3]),+),
            ]
        }
    };
}

impl Lanes for Sse2 {
    type F = Quarters<__m128>;
    type U = Quarters<__m128i>;
    type M = Quarters<__m128>;
    type D = Quarters<__m128d>;
    const HALVES: bool = true;

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat(self, x: f32) -> Self::F {
        [op!(_mm_set1_ps(x)); 4]
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn load_from(self, numbers: &[f32; WIDTH]) -> Self::F {
        // SAFETY: sixteen f32 are read from wherever they are, four at a time.
        from_fn(|k| unsafe { _mm_loadu_ps(numbers.as_ptr().add(4 * k)) })
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn round_from(self, numbers: [&[f64; WIDTH / 2]; 2]) -> Self::F {
        let two = |k: usize| {
            // SAFETY: of eight f64 two are read, from the sixth on at most.
            op!(_mm_cvtpd_ps(_mm_loadu_pd(numbers[k / 4].as_ptr().add(2 * (k % 4)))))
        };
        from_fn(|k| op!(_mm_movelh_ps(two(2 * k), two(2 * k + 1))))
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store_to(self, a: Self::F, numbers: &mut [f32; WIDTH]) {
        for (k, four) in a.into_iter().enumerate() {
            // SAFETY: sixteen f32 are written to wherever they are, four at a time.
            unsafe { _mm_storeu_ps(numbers.as_mut_ptr().add(4 * k), four) }
        }
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn load_half(self, numbers: &[f32; WIDTH / 2]) -> Self::F {
        // SAFETY: of eight f32 four are read, from the fifth on at most.
        from_fn(|k| unsafe { _mm_loadu_ps(numbers.as_ptr().add(4 * (k % 2))) })
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store_half(self, a: Self::F, numbers: &mut [f32; WIDTH / 2]) {
        // SAFETY: eight f32 are written to wherever they are, four at a time.
        unsafe {
            _mm_storeu_ps(numbers.as_mut_ptr(), a[0]);
            _mm_storeu_ps(numbers.as_mut_ptr().add(4), a[1]);
        }
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn half_bits(self, mask: Self::M) -> u32 {
        let [low, high] = [op!(_mm_movemask_ps(mask[0])), op!(_mm_movemask_ps(mask[1]))];
        (low | high << 4).cast_unsigned()
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        each!(_mm_add_ps, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        each!(_mm_sub_ps, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        each!(_mm_mul_ps, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        each!(_mm_div_ps, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        self.add(self.mul(a, b), c)
    }
    #[inline(always)]
    fn call<K: Kernel>(self, kernel: K) -> K::Output {
        run(kernel)
    }
    // Nothing fuses here.
    #[inline(always)]
    fn run_unfused<K: Kernel>(self, kernel: K) -> K::Output {
        run(kernel)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        each!(_mm_min_ps, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        each!(_mm_max_ps, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn abs(self, a: Self::F) -> Self::F {
        let sign = self.splat(-0.0);
        each!(_mm_andnot_ps, sign, a)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sqrt(self, a: Self::F) -> Self::F {
        each!(_mm_sqrt_ps, a)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lt(self, a: Self::F, b: Self::F) -> Self::M {
        each!(_mm_cmplt_ps, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn le(self, a: Self::F, b: Self::F) -> Self::M {
        each!(_mm_cmple_ps, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(self, mask: Self::M, yes: Self::F, no: Self::F) -> Self::F {
        let (yes, no) = (each!(_mm_and_ps, mask, yes), each!(_mm_andnot_ps, mask, no));
        each!(_mm_or_ps, yes, no)
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn and(self, a: Self::M, b: Self::M) -> Self::M {
        each!(_mm_and_ps, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn or(self, a: Self::M, b: Self::M) -> Self::M {
        each!(_mm_or_ps, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn and_not(self, a: Self::M, b: Self::M) -> Self::M {
        each!(_mm_andnot_ps, b, a)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bits(self, mask: Self::M) -> u32 {
        let [a, b, c, d] = each!(_mm_movemask_ps, mask);
        (a | b << 4 | c << 8 | d << 12).cast_unsigned()
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mask(self, bits: u32) -> Self::M {
        from_fn(|k| {
            op!({
                let bit = _mm_setr_epi32(1, 2, 4, 8);
                let bits = _mm_set1_epi32((bits >> (4 * k)).cast_signed());
                _mm_castsi128_ps(_mm_cmpeq_epi32(_mm_and_si128(bits, bit), bit))
            })
        })
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat_d(self, x: f64) -> Self::D {
        [op!(_mm_set1_pd(x)); 4]
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn load_d(self, numbers: &[f64; WIDTH / 2]) -> Self::D {
        // SAFETY: eight f64 are read from wherever they are, two at a time.
        from_fn(|k| unsafe { _mm_loadu_pd(numbers.as_ptr().add(2 * k)) })
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store_d(self, a: Self::D, numbers: &mut [f64; WIDTH / 2]) {
        for (k, two) in a.into_iter().enumerate() {
            // SAFETY: eight f64 are written to wherever they are, two at a time.
            unsafe { _mm_storeu_pd(numbers.as_mut_ptr().add(2 * k), two) }
        }
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_d(self, a: Self::D, b: Self::D) -> Self::D {
        each!(_mm_add_pd, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sub_d(self, a: Self::D, b: Self::D) -> Self::D {
        each!(_mm_sub_pd, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul_d(self, a: Self::D, b: Self::D) -> Self::D {
        each!(_mm_mul_pd, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn div_d(self, a: Self::D, b: Self::D) -> Self::D {
        each!(_mm_div_pd, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select_lt_d(self, a: Self::D, b: Self::D, yes: Self::D, no: Self::D) -> Self::D {
        let is_less = each!(_mm_cmplt_pd, a, b);
        let (yes, no) = (each!(_mm_and_pd, is_less, yes), each!(_mm_andnot_pd, is_less, no));
        each!(_mm_or_pd, yes, no)
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat_u(self, x: u32) -> Self::U {
        [op!(_mm_set1_epi32(x.cast_signed())); 4]
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn load_from_u(self, numbers: &[u32; WIDTH]) -> Self::U {
        // SAFETY: sixteen u32 are read from wherever they are, four at a time.
        from_fn(|k| unsafe { _mm_loadu_si128(numbers.as_ptr().add(4 * k).cast()) })
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store_to_u(self, a: Self::U, numbers: &mut [u32; WIDTH]) {
        for (k, four) in a.into_iter().enumerate() {
            // SAFETY: sixteen u32 are written to wherever they are, four at a time.
            unsafe { _mm_storeu_si128(numbers.as_mut_ptr().add(4 * k).cast(), four) }
        }
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_u(self, a: Self::U, b: Self::U) -> Self::U {
        each!(_mm_add_epi32, a, b)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane_numbers(self) -> Self::U {
        from_fn(|k| {
            let first = 4 * k as i32;
            op!(_mm_setr_epi32(first, first + 1, first + 2, first + 3))
        })
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compress_to(self, keep: u32, a: Self::F, to: &mut [f32; 2 * WIDTH], at: usize) {
        let mut numbers = [0.0; WIDTH];
        self.store_to(a, &mut numbers);
        front(keep, &numbers, to, at);
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compress_to_u(self, keep: u32, a: Self::U, to: &mut [u32; 2 * WIDTH], at: usize) {
        let mut numbers = [0; WIDTH];
        self.store_to_u(a, &mut numbers);
        front(keep, &numbers, to, at);
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn tag(self, a: Self::F, mask: Self::U, tag: Self::U) -> Self::F {
        let (mask, tag) = (each!(_mm_castsi128_ps, mask), each!(_mm_castsi128_ps, tag));
        let rest = each!(_mm_andnot_ps, mask, a);
        each!(_mm_or_ps, rest, tag)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn tag_of(self, a: Self::F, mask: Self::U) -> Self::U {
        let bits = each!(_mm_castps_si128, a);
        each!(_mm_and_si128, bits, mask)
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn transpose(self, rows: &[Row; WIDTH]) -> [Self::F; WIDTH] {
        let mut columns = [self.splat(0.0); WIDTH];
        for down in 0..4 {
            let four: [Self::F; 4] = from_fn(|k| self.load(&rows[4 * down + k]));
            for across in 0..4 {
                let block = transposed(four.map(|row| row[across]));
                for (k, column) in block.into_iter().enumerate() {
                    columns[4 * across + k][down] = column;
                }
            }
        }
        columns
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn largest_of_each(self, rows: &[Row; WIDTH]) -> Self::F {
        from_fn(|down| {
            let [a, b, c, d] =
                transposed(from_fn(|k| largest_of_four(self.load(&rows[4 * down + k]))));
            op!(_mm_max_ps(_mm_max_ps(a, b), _mm_max_ps(c, d)))
        })
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn largest(self, a: Self::F) -> f32 {
        let four = largest_of_four(a);
        op!({
            let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_max_ss(two, _mm_shuffle_ps::<1>(two, two)))
        })
    }
}

/// In place k the largest of lanes k, k + 4, k + 8 and k + 12.
#[inline(always)]
fn largest_of_four([a, b, c, d]: Quarters<__m128>) -> __m128 {
    op!(_mm_max_ps(_mm_max_ps(a, c), _mm_max_ps(b, d)))
}

/// In place j of register k what was in place k of register j.
#[inline(always)]
fn transposed([a, b, c, d]: [__m128; 4]) -> [__m128; 4] {
    op!({
        let (ab_low, ab_high) = (_mm_unpacklo_ps(a, b), _mm_unpackhi_ps(a, b));
        let (cd_low, cd_high) = (_mm_unpacklo_ps(c, d), _mm_unpackhi_ps(c, d));
        [
            _mm_movelh_ps(ab_low, cd_low),
            _mm_movehl_ps(cd_low, ab_low),
            _mm_movelh_ps(ab_high, cd_high),
            _mm_movehl_ps(cd_high, ab_high),
        ]
    })
}
