//! Numbers of twice the digits of f64, as far as one cancellation needs them.
//!
//! Source: Dekker 1971; no fused multiply-add, so the bits are the same everywhere.

use super::wide::Wide;
use std::ops::{Add, Mul, Sub};

/// high + low, |low| at most half an ulp of high; good to about 2⁻¹⁰⁰ of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Double {
    high: f64,
    low: f64,
}

impl Double {
    /// a + b, exactly.
    pub(super) fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let b_part = high - a;
        Self { high, low: (a - (high - b_part)) + (b - b_part) }
    }

    /// a·b, exactly unless it leaves the normal numbers.
    fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        let ((a1, a2), (b1, b2)) = (halves(a), halves(b));
        Self { high, low: ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2 }
    }

    pub(super) fn to_f64(self) -> f64 {
        self.high + self.low
    }
}

/// x as a sum of two numbers of 26 bits, so that their products are exact.
fn halves(x: f64) -> (f64, f64) {
    const SPLITTER: f64 = ((1u64 << 27) + 1) as f64;
    let scaled = SPLITTER * x;
    let high = scaled - (scaled - x);
    (high, x - high)
}

impl From<Wide> for Double {
    /// The leading 106 bits.
    fn from(x: Wide) -> Self {
        let shift = x.bits().saturating_sub(106);
        let leading = x.shifted_down(shift);
        let high = leading as f64;
        let scale = 2f64.powi(shift as i32);
        Self { high: high * scale, low: (leading - high as i128) as f64 * scale }
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let (high, low) = (Self::sum(self.high, b.high), Self::sum(self.low, b.low));
        let first = Self::sum(high.high, high.low + low.high);
        Self::sum(first.high, first.low + low.low)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + Self { high: -b.high, low: -b.low }
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let product = Self::product(self.high, b.high);
        Self::sum(product.high, product.low + (self.high * b.low + self.low * b.high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_cancels_in_f64_is_left_with_its_digits(
            a in 1i128 << 60..1i128 << 80, b in 1i128 << 60..1i128 << 80,
        ) {
            // (a + 1)(b + 1) − ab = a + b + 1, some 80 bits below the products.
            let double = |x: i128| Double::from(Wide::from(x));
            let left = double(a + 1) * double(b + 1) - double(a) * double(b);
            let truth = (a + b + 1) as f64;
            prop_assert!((left.to_f64() - truth).abs() <= truth * 1e-5);
        }

        #[test]
        fn wide_integers_keep_106_bits(a in any::<i128>(), b in any::<i64>()) {
            let wide = Wide::product(a, b.into());
            let double = Double::from(wide);
            prop_assert!((double.to_f64() - wide.to_f64()).abs() <= 4e-16 * wide.to_f64().abs());
            let rest = wide - Wide::product(double.high as i128, 1);
            if wide.bits() < 106 {
                prop_assert_eq!(rest.to_f64(), double.low);
            }
        }
    }
}
