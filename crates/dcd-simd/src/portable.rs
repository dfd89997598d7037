//! Sixteen lanes as arrays: the scalar reference of the other paths, for any CPU; x86-64 has `sse2` in its place.

use super::{Kernel, Lanes, Row, WIDTH};
use std::array::from_fn;

/// Runs the kernel on arrays.
pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Portable)
}

#[derive(Clone, Copy)]
pub(super) struct Portable;

/// One loop a lane: small enough that the compiler makes vectors of it.
macro_rules! each {
    ($k:ident => $body:expr) => {
        from_fn(
            #[inline(always)]
            |$k| $body,
        )
    };
}

/// Writes the items whose bits `keep` has, moved down to the front, from `at` on. Out of line: it is called too
/// rarely to be worth its length.
pub(super) fn front<T: Copy>(keep: u32, a: &[T; WIDTH], to: &mut [T; 2 * WIDTH], at: usize) {
    let mut end = at.min(WIDTH);
    for (k, &item) in a.iter().enumerate() {
        // At most the last place, as the mask shows to the compiler.
        to[end & (2 * WIDTH - 1)] = item;
        end += (keep >> k & 1) as usize;
    }
}

impl Lanes for Portable {
    type F = [f32; WIDTH];
    type U = [u32; WIDTH];
    type M = [bool; WIDTH];
    type D = [f64; WIDTH / 2];

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F {
        [x; WIDTH]
    }
    #[inline(always)]
    fn load_from(self, numbers: &[f32; WIDTH]) -> Self::F {
        *numbers
    }
    #[inline(always)]
    fn round_from(self, numbers: [&[f64; WIDTH / 2]; 2]) -> Self::F {
        std::array::from_fn(|k| numbers[k / (WIDTH / 2)][k % (WIDTH / 2)] as f32)
    }
    #[inline(always)]
    fn store_to(self, a: Self::F, numbers: &mut [f32; WIDTH]) {
        *numbers = a;
    }
    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        each!(k => a[k] + b[k])
    }
    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        each!(k => a[k] - b[k])
    }
    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        each!(k => a[k] * b[k])
    }
    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        each!(k => a[k] / b[k])
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        // Two roundings: a fused one without hardware support is a slow library call.
        each!(k => a[k] * b[k] + c[k])
    }
    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        each!(k => if a[k] < b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        each!(k => if a[k] > b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn abs(self, a: Self::F) -> Self::F {
        each!(k => a[k].abs())
    }
    #[inline(always)]
    fn sqrt(self, a: Self::F) -> Self::F {
        each!(k => a[k].sqrt())
    }
    #[inline(always)]
    fn lt(self, a: Self::F, b: Self::F) -> Self::M {
        each!(k => a[k] < b[k])
    }
    #[inline(always)]
    fn le(self, a: Self::F, b: Self::F) -> Self::M {
        each!(k => a[k] <= b[k])
    }
    #[inline(always)]
    fn select(self, mask: Self::M, yes: Self::F, no: Self::F) -> Self::F {
        each!(k => if mask[k] { yes[k] } else { no[k] })
    }

    #[inline(always)]
    fn and(self, a: Self::M, b: Self::M) -> Self::M {
        each!(k => a[k] & b[k])
    }
    #[inline(always)]
    fn or(self, a: Self::M, b: Self::M) -> Self::M {
        each!(k => a[k] | b[k])
    }
    #[inline(always)]
    fn and_not(self, a: Self::M, b: Self::M) -> Self::M {
        each!(k => a[k] & !b[k])
    }
    #[inline(always)]
    fn bits(self, mask: Self::M) -> u32 {
        (0..WIDTH).fold(0, |bits, k| bits | u32::from(mask[k]) << k)
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::M {
        each!(k => bits >> k & 1 == 1)
    }

    #[inline(always)]
    fn splat_d(self, x: f64) -> Self::D {
        [x; WIDTH / 2]
    }
    #[inline(always)]
    fn load_d(self, numbers: &[f64; WIDTH / 2]) -> Self::D {
        *numbers
    }
    #[inline(always)]
    fn store_d(self, a: Self::D, numbers: &mut [f64; WIDTH / 2]) {
        *numbers = a;
    }
    #[inline(always)]
    fn add_d(self, a: Self::D, b: Self::D) -> Self::D {
        each!(k => a[k] + b[k])
    }
    #[inline(always)]
    fn sub_d(self, a: Self::D, b: Self::D) -> Self::D {
        each!(k => a[k] - b[k])
    }
    #[inline(always)]
    fn mul_d(self, a: Self::D, b: Self::D) -> Self::D {
        each!(k => a[k] * b[k])
    }
    #[inline(always)]
    fn div_d(self, a: Self::D, b: Self::D) -> Self::D {
        each!(k => a[k] / b[k])
    }
    #[inline(always)]
    fn select_lt_d(self, a: Self::D, b: Self::D, yes: Self::D, no: Self::D) -> Self::D {
        each!(k => if a[k] < b[k] { yes[k] } else { no[k] })
    }

    #[inline(always)]
    fn splat_u(self, x: u32) -> Self::U {
        [x; WIDTH]
    }
    #[inline(always)]
    fn load_from_u(self, numbers: &[u32; WIDTH]) -> Self::U {
        *numbers
    }
    #[inline(always)]
    fn store_to_u(self, a: Self::U, numbers: &mut [u32; WIDTH]) {
        *numbers = a;
    }
    #[inline(always)]
    fn add_u(self, a: Self::U, b: Self::U) -> Self::U {
        each!(k => a[k].wrapping_add(b[k]))
    }
    #[inline(always)]
    fn lane_numbers(self) -> Self::U {
        each!(k => k as u32)
    }

    #[inline(always)]
    fn compress_to(self, keep: u32, a: Self::F, to: &mut [f32; 2 * WIDTH], at: usize) {
        front(keep, &a, to, at);
    }
    #[inline(always)]
    fn compress_to_u(self, keep: u32, a: Self::U, to: &mut [u32; 2 * WIDTH], at: usize) {
        front(keep, &a, to, at);
    }
    #[inline(always)]
    fn tag(self, a: Self::F, mask: Self::U, tag: Self::U) -> Self::F {
        each!(k => f32::from_bits(a[k].to_bits() & !mask[k] | tag[k]))
    }
    #[inline(always)]
    fn tag_of(self, a: Self::F, mask: Self::U) -> Self::U {
        each!(k => a[k].to_bits() & mask[k])
    }
    #[inline(always)]
    fn largest_of_each(self, rows: &[Row; WIDTH]) -> Self::F {
        each!(k => {
            let halves: [f32; 8] = from_fn(|h| if rows[k].0[h] > rows[k].0[h + 8] { rows[k].0[h] } else { rows[k].0[h + 8] });
            halves.into_iter().fold(f32::NEG_INFINITY, |m, x| if x > m { x } else { m })
        })
    }
}
