//! Binary numbers of any length: sums and products of f64s without loss.

use crate::simplex::Scalar;
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;

/// mantissa · 2^exponent.
#[derive(Clone, Debug)]
pub(super) struct Binary {
    mantissa: BigInt,
    exponent: i64,
}

impl Binary {
    /// x, which must be finite.
    pub(super) fn new(x: f64) -> Self {
        let bits = x.to_bits();
        let field = (bits >> 52 & 0x7ff) as i64;
        let fraction = (bits & ((1 << 52) - 1)) as i64;
        let (mantissa, exponent) =
            if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
        // Short mantissas make short products: of round numbers nearly all zeros.
        let zeros = if mantissa == 0 { 0 } else { mantissa.trailing_zeros() };
        let mantissa = if x < 0.0 { -(mantissa >> zeros) } else { mantissa >> zeros };
        Self { mantissa: mantissa.into(), exponent: exponent + i64::from(zeros) }
    }

    /// m and e with m·2^e the number, within 2⁻⁵² of itself; |m| below 2⁶³.
    pub(super) fn to_float(&self) -> (f64, i64) {
        let drop = self.mantissa.bits().saturating_sub(62);
        let high = i64::try_from(&self.mantissa >> drop).unwrap_or_default();
        (high as f64, self.exponent + drop as i64)
    }

    pub(super) fn is_zero(&self) -> bool {
        self.mantissa.sign() == Sign::NoSign
    }

    pub(super) fn squared(&self) -> Self {
        self.times(self)
    }

    /// Both mantissas for the smaller exponent.
    fn aligned(&self, other: &Self) -> (BigInt, BigInt, i64) {
        // A zero has no bits to shift.
        if self.is_zero() {
            return (BigInt::ZERO, other.mantissa.clone(), other.exponent);
        }
        if other.is_zero() {
            return (self.mantissa.clone(), BigInt::ZERO, self.exponent);
        }
        let exponent = self.exponent.min(other.exponent);
        let shifted = |x: &Self| &x.mantissa << (x.exponent - exponent);
        (shifted(self), shifted(other), exponent)
    }
}

impl From<f64> for Binary {
    fn from(x: f64) -> Self {
        Self::new(x)
    }
}

impl Scalar for Binary {
    fn zero() -> Self {
        Self { mantissa: BigInt::ZERO, exponent: 0 }
    }
    fn one() -> Self {
        Self { mantissa: BigInt::from(1), exponent: 0 }
    }
    fn plus(&self, other: &Self) -> Self {
        let (a, b, exponent) = self.aligned(other);
        Self { mantissa: a + b, exponent }
    }
    fn minus(&self, other: &Self) -> Self {
        let (a, b, exponent) = self.aligned(other);
        Self { mantissa: a - b, exponent }
    }
    fn times(&self, other: &Self) -> Self {
        Self {
            mantissa: &self.mantissa * &other.mantissa,
            exponent: self.exponent + other.exponent,
        }
    }
    fn negated(&self) -> Self {
        Self { mantissa: -&self.mantissa, exponent: self.exponent }
    }
    fn sign(&self) -> Option<Ordering> {
        Some(match self.mantissa.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        })
    }
    fn ratio_is_less(n1: &Self, d1: &Self, n2: &Self, d2: &Self) -> bool {
        n1.times(d2).minus(&n2.times(d1)).is_negative()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_products_lose_nothing() {
        let (large, small) = (Binary::new(1e300), Binary::new(5e-324));
        let back = large.plus(&small).minus(&large);
        assert!(back.minus(&small).is_zero());
        let product = large.times(&small);
        let (m, e) = product.to_float();
        assert!(
            (m * 2f64.powi((e + 1000) as i32) / 2f64.powi(1000) / (1e300 * 5e-324) - 1.0).abs()
                < 1e-3
        );
        assert!(Binary::new(-0.0).is_zero() && Binary::new(-0.75).is_negative());
        let third = Binary::ratio_is_less(&Binary::one(), &3.0.into(), &Binary::one(), &2.0.into());
        assert!(third);
    }
}
