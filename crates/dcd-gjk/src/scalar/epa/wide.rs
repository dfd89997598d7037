//! Integers of 256 bits, as far as the polytope needs them.

use std::ops::{Add, Neg, Sub};

/// A signed integer of 256 bits; sums and products wrap, which the lattice's size rules out.
// The order of the fields makes the derived order the order of the numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Wide {
    high: i128,
    low: u128,
}

impl Wide {
    pub(super) const ZERO: Self = Self { high: 0, low: 0 };

    /// The product of two numbers of 128 bits, never wrapped.
    #[inline]
    pub(super) fn product(a: i128, b: i128) -> Self {
        let low = full_product(a.unsigned_abs(), b.unsigned_abs());
        if (a < 0) == (b < 0) { low } else { -low }
    }

    /// self·b.
    #[inline]
    pub(super) fn times(self, b: i128) -> Self {
        let m = b.unsigned_abs();
        let mut product = full_product(self.low, m);
        product.high = product.high.wrapping_add(self.high.wrapping_mul(m as i128));
        if b < 0 { -product } else { product }
    }

    /// How many bits its absolute value has.
    pub(super) fn bits(self) -> u32 {
        let m = self.magnitude();
        if m.high == 0 { 128 - m.low.leading_zeros() } else { 256 - m.high.leading_zeros() }
    }

    /// self / 2^shift, rounded down, where that fits in 128 bits.
    pub(super) fn shifted_down(self, shift: u32) -> i128 {
        match shift {
            0 => self.low as i128,
            1..=127 => (self.low >> shift) as i128 | self.high << (128 - shift),
            _ => self.high >> (shift - 128).min(127),
        }
    }

    /// The f64 of its leading 64 bits: within 1.01·2⁻⁵³ of itself, the sign always right.
    #[inline]
    pub(super) fn to_f64(self) -> f64 {
        let m = self.magnitude();
        let shift = m.bits().saturating_sub(64);
        let leading = m.shifted_down(shift) as u64 as f64;
        // At most 2¹⁹²: always a normal number.
        let scale = f64::from_bits(u64::from(1023 + shift) << 52);
        if self.high < 0 { -(leading * scale) } else { leading * scale }
    }

    /// The absolute value; −2²⁵⁵ does not occur.
    #[inline]
    fn magnitude(self) -> Self {
        if self.high < 0 { -self } else { self }
    }
}

impl From<i128> for Wide {
    #[inline]
    fn from(x: i128) -> Self {
        Self { high: x >> 127, low: x as u128 }
    }
}

impl Add for Wide {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        let (low, carry) = self.low.overflowing_add(b.low);
        Self { high: self.high.wrapping_add(b.high).wrapping_add(carry as i128), low }
    }
}

impl Sub for Wide {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        let (low, borrow) = self.low.overflowing_sub(b.low);
        Self { high: self.high.wrapping_sub(b.high).wrapping_sub(borrow as i128), low }
    }
}

impl Neg for Wide {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self::ZERO - self
    }
}

/// All 256 bits of a·b, by four products of 64 bits.
#[inline]
fn full_product(a: u128, b: u128) -> Wide {
    const LOW: u128 = u64::MAX as u128;
    let (a0, a1) = (a & LOW, a >> 64);
    let (b0, b1) = (b & LOW, b >> 64);
    let (p00, p01, p10, p11) = (a0 * b0, a0 * b1, a1 * b0, a1 * b1);
    let middle = (p00 >> 64) + (p01 & LOW) + (p10 & LOW);
    let high = p11 + (p01 >> 64) + (p10 >> 64) + (middle >> 64);
    Wide { high: high as i128, low: middle << 64 | p00 & LOW }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    fn big(x: Wide) -> BigInt {
        (BigInt::from(x.high) << 128) + BigInt::from(x.low)
    }

    proptest! {
        #[test]
        fn sums_and_products_are_those_of_unbounded_integers(
            a in any::<i128>(), b in any::<i128>(), c in -(1i128 << 100)..1i128 << 100,
        ) {
            let ab = Wide::product(a, b);
            prop_assert_eq!(big(ab), BigInt::from(a) * b);
            let sum = Wide::from(a) + ab;
            prop_assert_eq!(big(sum), BigInt::from(a) * b + a);
            prop_assert_eq!(big(Wide::from(b) - sum), -(BigInt::from(a) * b) - a + b);
            let small = Wide::product(a >> 40, c >> 40);
            prop_assert_eq!(big(small.times(c)), BigInt::from(a >> 40) * (c >> 40) * c);
        }

        #[test]
        fn order_bits_shifts_and_rounding_agree_with_unbounded_integers(
            a in any::<i128>(), b in any::<i128>(), shift in 0u32..200,
        ) {
            let (x, y) = (Wide::product(a, b), Wide::from(b));
            prop_assert_eq!(x.cmp(&y), big(x).cmp(&big(y)));
            prop_assert_eq!(u64::from(x.bits()), big(x).bits());
            if x.bits() < 127 + shift {
                prop_assert_eq!(BigInt::from(x.shifted_down(shift)), big(x) >> shift);
            }
            let rounded = x.to_f64();
            let back = (a as f64) * (b as f64);
            prop_assert!((rounded - back).abs() <= 8.0 * f64::EPSILON * back.abs());
        }
    }
}
