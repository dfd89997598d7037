//! Integers of the exact method: machine words where every number surely fits, else long ones.

use crate::simplex::{Scalar, Triple};
use dcd_geom::glam::DVec3;
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;

/// An f64 as an integer times a power of two, without loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dyadic {
    /// Odd, or 0.
    pub(super) mantissa: i64,
    /// Of two.
    pub(super) exponent: i32,
}

impl Dyadic {
    /// `x` must be finite; what is not is taken as 0.
    pub(super) fn new(x: f64) -> Self {
        if x == 0.0 || !x.is_finite() {
            return Self { mantissa: 0, exponent: 0 };
        }
        let bits = x.to_bits();
        let field = (bits >> 52 & 0x7ff) as i32;
        let fraction = (bits & ((1 << 52) - 1)) as i64;
        let (mantissa, exponent) =
            if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
        let zeros = mantissa.trailing_zeros();
        let mantissa = mantissa >> zeros;
        Self {
            mantissa: if x < 0.0 { -mantissa } else { mantissa },
            exponent: exponent + zeros as i32,
        }
    }

    /// The exponent of its highest bit; `None` for 0.
    pub(super) fn highest(self) -> Option<i32> {
        let bits = 64 - self.mantissa.unsigned_abs().leading_zeros() as i32;
        (self.mantissa != 0).then_some(self.exponent + bits)
    }

    /// The exponent of its lowest bit; `None` for 0.
    pub(super) fn lowest(self) -> Option<i32> {
        (self.mantissa != 0).then_some(self.exponent)
    }
}

/// A number that a grid's coordinates can be.
pub(crate) trait Number: Scalar {
    /// `x` in units of 2^unit; for integers the unit must not be above its lowest bit.
    fn on_grid(x: f64, unit: i32) -> Self;
    /// 2^shift.
    fn power_of_two(shift: u32) -> Self;
    /// A direction in f64, its largest component near 1, each within 2.01 u of that of the exact.
    fn rounded(direction: &Triple<Self>) -> DVec3;
}

/// An exact integer.
pub(crate) trait Integer: Scalar {
    /// mantissa · 2^shift.
    fn shifted(mantissa: i64, shift: u32) -> Self;
    /// |x| < 2^bits, and no smaller.
    fn bits(&self) -> u64;
    /// x · 2^−drop, rounded down; must then be below 2⁶³.
    fn high(&self, drop: u64) -> i64;

    /// m and e with m·2^e the number, but for a relative error of 1.01·2⁻⁵³.
    fn to_float(&self) -> (f64, i64) {
        let drop = self.bits().saturating_sub(62);
        (self.high(drop) as f64, drop as i64)
    }
}

impl<T: Integer> Number for T {
    fn on_grid(x: f64, unit: i32) -> Self {
        let Dyadic { mantissa, exponent } = Dyadic::new(x);
        Self::shifted(mantissa, if mantissa == 0 { 0 } else { exponent.abs_diff(unit) })
    }

    fn power_of_two(shift: u32) -> Self {
        Self::shifted(1, shift)
    }

    fn rounded(direction: &Triple<Self>) -> DVec3 {
        let bits = direction.iter().map(T::bits).max().unwrap_or(0);
        let drop = bits.saturating_sub(62);
        let length = (1u64 << (bits - drop)) as f64;
        DVec3::from_array([0, 1, 2].map(|k| direction[k].high(drop) as f64 / length))
    }
}

/// 127 bits and a sign. Its users have shown that nothing is larger.
#[derive(Clone, Debug)]
pub(super) struct Small(i128);

impl Scalar for Small {
    fn zero() -> Self {
        Self(0)
    }
    fn one() -> Self {
        Self(1)
    }
    fn plus(&self, other: &Self) -> Self {
        Self(self.0 + other.0)
    }
    fn minus(&self, other: &Self) -> Self {
        Self(self.0 - other.0)
    }
    fn times(&self, other: &Self) -> Self {
        Self(self.0 * other.0)
    }
    fn negated(&self) -> Self {
        Self(-self.0)
    }
    fn sign(&self) -> Option<Ordering> {
        Some(self.0.cmp(&0))
    }
    fn ratio_is_less(n1: &Self, d1: &Self, n2: &Self, d2: &Self) -> bool {
        n1.0 * d2.0 < n2.0 * d1.0
    }
}

impl Integer for Small {
    fn shifted(mantissa: i64, shift: u32) -> Self {
        Self(i128::from(mantissa) << shift)
    }
    fn bits(&self) -> u64 {
        u64::from(128 - self.0.unsigned_abs().leading_zeros())
    }
    fn high(&self, drop: u64) -> i64 {
        (self.0 >> drop.min(127)) as i64
    }
}

/// As long as need be.
#[derive(Clone, Debug)]
pub(crate) struct Large(BigInt);

impl Scalar for Large {
    fn zero() -> Self {
        Self(BigInt::ZERO)
    }
    fn one() -> Self {
        Self(BigInt::from(1))
    }
    fn plus(&self, other: &Self) -> Self {
        Self(&self.0 + &other.0)
    }
    fn minus(&self, other: &Self) -> Self {
        Self(&self.0 - &other.0)
    }
    fn times(&self, other: &Self) -> Self {
        Self(&self.0 * &other.0)
    }
    fn negated(&self) -> Self {
        Self(-&self.0)
    }
    fn sign(&self) -> Option<Ordering> {
        Some(match self.0.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        })
    }
    fn ratio_is_less(n1: &Self, d1: &Self, n2: &Self, d2: &Self) -> bool {
        &n1.0 * &d2.0 < &n2.0 * &d1.0
    }
}

impl Integer for Large {
    fn shifted(mantissa: i64, shift: u32) -> Self {
        Self(BigInt::from(mantissa) << shift)
    }
    fn bits(&self) -> u64 {
        self.0.bits()
    }
    fn high(&self, drop: u64) -> i64 {
        i64::try_from(&self.0 >> drop).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dyadics_give_the_number_back() {
        let odd = Dyadic::new(-0.75);
        assert_eq!(odd, Dyadic { mantissa: -3, exponent: -2 });
        assert_eq!((odd.lowest(), odd.highest()), (Some(-2), Some(0)));
        assert_eq!(Dyadic::new(5e-324), Dyadic { mantissa: 1, exponent: -1074 });
        assert_eq!(Dyadic::new(f64::MAX).highest(), Some(1024));
        assert_eq!(Dyadic::new(-0.0), Dyadic { mantissa: 0, exponent: 0 });
        for x in [0.1, 1e300, -3.5e-310] {
            let Dyadic { mantissa, exponent } = Dyadic::new(x);
            let half = exponent / 2;
            assert_eq!(mantissa as f64 * 2f64.powi(half) * 2f64.powi(exponent - half), x);
        }
    }

    #[test]
    fn both_integers_agree() {
        fn check<T: Integer>() {
            let x = T::shifted(-5, 20);
            assert_eq!((x.bits(), x.high(18), x.high(21)), (23, -20, -3));
            assert!(x.is_negative() && x.times(&x).is_positive());
            assert!(x.plus(&x.negated()).sign() == Some(Ordering::Equal));
            assert!(T::ratio_is_less(&T::one(), &T::shifted(3, 0), &T::one(), &T::shifted(1, 1)));
            assert_eq!(T::on_grid(0.75, -4).high(0), 12);
        }
        check::<Small>();
        check::<Large>();
    }
}
