//! Sines and cosines that come out the same one at a time and in lanes: sums, differences and products, each rounded
//! once, in one order.

use dcd_simd::Lanes;

/// How far from 0 the angles are of which [`near_sin_cos`] knows the sine, rad; a million turns and a half less would
/// be 2²³. Beyond, libm is called. Larger: [`QUARTER`] times the number of quarters is no longer exact.
pub(crate) const FAR: f64 = (1 << 20) as f64;

/// π/2 to 33 bits, so that it times a number of 20 bits is exact; the rest of π/2, to within 2⁻⁵³ of it.
const QUARTER: [f64; 2] =
    [f64::from_bits(0x3ff9_21fb_5440_0000), f64::from_bits(0x3dd0_b461_1a62_6331)];

/// What added and subtracted rounds to a whole number: 1.5 · 2⁵².
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// What a sine is computed with.
pub(crate) trait Arithmetic: Copy {
    type Number: Copy;
    fn of(self, x: f64) -> Self::Number;
    fn add(self, a: Self::Number, b: Self::Number) -> Self::Number;
    fn sub(self, a: Self::Number, b: Self::Number) -> Self::Number;
    fn mul(self, a: Self::Number, b: Self::Number) -> Self::Number;
}

/// One number at a time.
#[derive(Clone, Copy)]
struct Scalar;

impl Arithmetic for Scalar {
    type Number = f64;

    #[inline(always)]
    fn of(self, x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn add(self, a: f64, b: f64) -> f64 {
        a + b
    }

    #[inline(always)]
    fn sub(self, a: f64, b: f64) -> f64 {
        a - b
    }

    #[inline(always)]
    fn mul(self, a: f64, b: f64) -> f64 {
        a * b
    }
}

/// Eight numbers at a time.
#[derive(Clone, Copy)]
pub(crate) struct InLanes<L>(pub(crate) L);

impl<L: Lanes> Arithmetic for InLanes<L> {
    type Number = L::D;

    #[inline(always)]
    fn of(self, x: f64) -> L::D {
        self.0.splat_d(x)
    }

    #[inline(always)]
    fn add(self, a: L::D, b: L::D) -> L::D {
        self.0.add_d(a, b)
    }

    #[inline(always)]
    fn sub(self, a: L::D, b: L::D) -> L::D {
        self.0.sub_d(a, b)
    }

    #[inline(always)]
    fn mul(self, a: L::D, b: L::D) -> L::D {
        self.0.mul_d(a, b)
    }
}

/// The sine and the cosine of an angle in rad, each within 2⁻⁵³.
pub(crate) fn sin_cos(angle: f64) -> [f64; 2] {
    if angle.abs() <= FAR {
        return near_sin_cos(Scalar, angle);
    }
    let (sin, cos) = libm::sincos(angle);
    [sin, cos]
}

/// Of an angle at most [`FAR`] from 0 (docs/numerics/proofs.md, "states in lanes"): what it is beyond the nearest
/// multiple of a right angle, by Taylor's series there.
#[inline(always)]
pub(crate) fn near_sin_cos<A: Arithmetic>(a: A, angle: A::Number) -> [A::Number; 2] {
    let quarters = whole(a, a.mul(angle, a.of(std::f64::consts::FRAC_2_PI)));
    let first = a.sub(angle, a.mul(quarters, a.of(QUARTER[0])));
    let rest = a.mul(quarters, a.of(QUARTER[1]));
    let x = a.sub(first, rest);
    // What rounding took off.
    let tail = a.sub(a.sub(first, x), rest);
    let square = a.mul(x, x);
    let half = a.mul(square, a.of(0.5));
    let near_one = a.sub(a.of(1.0), half);
    let cube = a.mul(a.mul(x, square), series(a, square, &SINE));
    let sin = a.add(x, a.add(cube, a.mul(tail, near_one)));
    let fourth = a.mul(a.mul(square, square), series(a, square, &COSINE));
    let lost = a.sub(a.sub(a.of(1.0), near_one), half);
    let cos = a.add(near_one, a.add(lost, a.sub(fourth, a.mul(x, tail))));
    turned(a, quarters, [sin, cos])
}

/// Turned by so many right angles. All factors are 0, 1 or −1, and one of two terms is 0, so that nothing is rounded.
#[inline(always)]
fn turned<A: Arithmetic>(a: A, quarters: A::Number, [sin, cos]: [A::Number; 2]) -> [A::Number; 2] {
    let halved = |n| {
        let even = whole(a, a.mul(n, a.of(0.5)));
        a.sub(n, a.add(even, even))
    };
    // quarters = 2·halves + odd.
    let odd = halved(quarters);
    let is_turned = halved(a.mul(a.sub(quarters, odd), a.of(0.5)));
    let sign = a.sub(a.of(1.0), a.mul(a.of(2.0), a.mul(is_turned, is_turned)));
    let even = a.sub(a.of(1.0), a.mul(odd, odd));
    [
        a.mul(sign, a.add(a.mul(even, sin), a.mul(odd, cos))),
        a.mul(sign, a.sub(a.mul(even, cos), a.mul(odd, sin))),
    ]
}

/// To the nearest whole number, of what is below 2⁵¹.
#[inline(always)]
fn whole<A: Arithmetic>(a: A, x: A::Number) -> A::Number {
    a.sub(a.add(x, a.of(WHOLE)), a.of(WHOLE))
}

#[inline(always)]
fn series<A: Arithmetic>(a: A, x: A::Number, terms: &[f64]) -> A::Number {
    let mut sum = a.of(0.0);
    for &term in terms {
        sum = a.add(a.mul(sum, x), a.of(term));
    }
    sum
}

/// Of x¹⁷ … x³ in a sine.
const SINE: [f64; 8] = [
    1.0 / 355_687_428_096_000.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
];

/// Of x¹⁶ … x⁴ in a cosine.
const COSINE: [f64; 7] = [
    1.0 / 20_922_789_888_000.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 479_001_600.0,
    -1.0 / 3_628_800.0,
    1.0 / 40_320.0,
    -1.0 / 720.0,
    1.0 / 24.0,
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    /// libm's are within one unit in the last place, at most 2⁻⁵³; so are these.
    fn check(angle: f64) {
        let ([sin, cos], (s, c)) = (sin_cos(angle), libm::sincos(angle));
        let bound = 2.0 * 0.5f64.powi(53);
        assert!((sin - s).abs() <= bound && (cos - c).abs() <= bound, "{angle:e}: {sin} {cos}");
        assert!((sin * sin + cos * cos - 1.0).abs() <= 4.0 * bound, "{angle:e}");
    }

    #[test]
    fn quarters_are_in_two_exact_parts() {
        assert_eq!(QUARTER[0] + QUARTER[1], FRAC_PI_2);
        // Twenty more bits fit.
        assert_eq!(QUARTER[0].to_bits() & ((1 << 20) - 1), 0);
        assert_eq!(WHOLE, 1.5 * 2f64.powi(52));
    }

    #[test]
    fn sines_are_within_a_unit_of_the_last_place_of_one_near_and_far() {
        let mut random: u64 = 0x2545_f491_4f6c_dd1d;
        for k in 0..400_000 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(k);
            let part = (random >> 11) as f64 * 0.5f64.powi(53) - 0.5;
            [1.0, 7.0, 100.0, 2e6, 1e9].iter().for_each(|size| check(part * size));
            check(part * 2f64.powi(-((k % 400) as i32)));
            let multiple = (part * 1.3e6).round() * FRAC_PI_4;
            [multiple, multiple.next_up(), multiple.next_down()].into_iter().for_each(check);
        }
        for angle in [0.0, -0.0, FAR, -FAR, FAR.next_up(), 1e22, f64::MAX, f64::MIN_POSITIVE] {
            check(angle);
        }
        assert_eq!((sin_cos(0.0), sin_cos(FRAC_PI_2)[0]), ([0.0, 1.0], 1.0));
    }
}
