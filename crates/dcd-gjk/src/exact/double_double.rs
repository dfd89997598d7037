//! Numbers of about 106 bits: an f64 and the f64 of what it lacks.
//!
//! Source: Dekker 1971, Knuth (two-sum), and the error bounds of Joldes, Muller, Popescu 2017. No
//! fused multiply-add: products are split, so that the bits are the same everywhere.

use crate::exact::Number;
use crate::simplex::{Scalar, Triple};
use dcd_geom::glam::DVec3;
use std::cmp::Ordering;

/// The relative error of a sum, difference or product: at most 7·2⁻¹⁰⁶.
pub(crate) const EPSILON: f64 = f64::from_bits((1023 - 103) << 52);

/// high + low, |low| at most half an ulp of high.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DoubleDouble {
    pub(crate) high: f64,
    pub(crate) low: f64,
}

/// a + b and what its rounding lost, for any a and b.
#[inline]
pub(crate) fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    let of_b = high - a;
    let of_a = high - of_b;
    DoubleDouble { high, low: (a - of_a) + (b - of_b) }
}

/// The same for |a| ≥ |b| or a = 0.
#[inline]
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    DoubleDouble { high, low: b - (high - a) }
}

/// x as two numbers of 26 bits.
#[inline]
fn split(x: f64) -> (f64, f64) {
    const SPLITTER: f64 = 134_217_729.0; // 2²⁷ + 1
    let wide = SPLITTER * x;
    let high = wide - (wide - x);
    (high, x - high)
}

/// a·b and what its rounding lost.
#[inline]
fn two_product(a: f64, b: f64) -> DoubleDouble {
    let high = a * b;
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    DoubleDouble { high, low: ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2 }
}

/// a·b as a product in f64 and at most 3u of it, u = 2⁻⁵³. Off by 8u² of it: 2 for the two mixed products, 2 for their sum, 1
/// for the product of the low ends, which is left out, and 3 for the last sum.
#[inline]
fn long_product(a: &DoubleDouble, b: &DoubleDouble) -> DoubleDouble {
    let DoubleDouble { high, low } = two_product(a.high, b.high);
    DoubleDouble { high, low: low + (a.high * b.low + a.low * b.high) }
}

/// A sum of numbers and products: what each addition loses is added up beside it (Ogita, Rump and Oishi 2005).
///
/// Of n terms it is off by at most n²·2⁻¹⁰⁵ times the sum of their magnitudes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    #[inline]
    pub(crate) fn add(&mut self, x: f64) {
        let sum = two_sum(self.high, x);
        (self.high, self.low) = (sum.high, self.low + sum.low);
    }

    #[inline]
    pub(crate) fn add_product(&mut self, a: f64, b: f64) {
        let product = two_product(a, b);
        self.add(product.high);
        self.low += product.low;
    }

    /// The same of two numbers of 106 bits, but for the product of their ends: 2⁻¹⁰⁶ of theirs.
    #[inline]
    pub(crate) fn add_long_product(&mut self, a: &DoubleDouble, b: &DoubleDouble) {
        let product = long_product(a, b);
        self.add(product.high);
        self.low += product.low;
    }

    #[inline]
    pub(crate) fn total(self) -> DoubleDouble {
        // Of terms that cancel the low part may be the larger.
        two_sum(self.high, self.low)
    }
}

impl From<DoubleDouble> for Sum {
    fn from(DoubleDouble { high, low }: DoubleDouble) -> Self {
        Self { high, low }
    }
}

impl DoubleDouble {
    #[inline]
    pub(crate) fn to_f64(self) -> f64 {
        self.high
    }

    pub(crate) fn divided_by(self, divisor: Self) -> Self {
        let first = self.high / divisor.high;
        let rest = self.minus(&divisor.times(&Self::from(first)));
        let second = rest.high / divisor.high;
        let rest = rest.minus(&divisor.times(&Self::from(second)));
        quick_two_sum(first, second).plus(&Self::from(rest.high / divisor.high))
    }

    /// 0 for 0 and below.
    pub(crate) fn sqrt(self) -> Self {
        if !(self.high > 0.0) {
            return Self::from(0.0);
        }
        let root = self.high.sqrt();
        let rest = self.minus(&two_product(root, root));
        quick_two_sum(root, rest.high / (2.0 * root))
    }
}

impl From<f64> for DoubleDouble {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl From<DoubleDouble> for f64 {
    fn from(x: DoubleDouble) -> Self {
        x.high
    }
}

impl Scalar for DoubleDouble {
    fn zero() -> Self {
        Self::from(0.0)
    }
    fn one() -> Self {
        Self::from(1.0)
    }
    #[inline]
    fn plus(&self, other: &Self) -> Self {
        let high = two_sum(self.high, other.high);
        let low = two_sum(self.low, other.low);
        let sum = quick_two_sum(high.high, high.low + low.high);
        quick_two_sum(sum.high, sum.low + low.low)
    }
    #[inline]
    fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negated())
    }
    #[inline]
    fn times(&self, other: &Self) -> Self {
        let product = two_product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        quick_two_sum(product.high, product.low + cross)
    }
    #[inline]
    fn negated(&self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
    fn sign(&self) -> Option<Ordering> {
        self.high.partial_cmp(&0.0)
    }
    fn ratio_is_less(n1: &Self, d1: &Self, n2: &Self, d2: &Self) -> bool {
        n1.divided_by(*d1).minus(&n2.divided_by(*d2)).is_negative()
    }
    /// Off by at most 3 [`EPSILON`] of the products' magnitudes: with u = 2⁻⁵³ each product loses 8u² of itself; the low
    /// parts, at most 3u each, and what two additions lose, u each, are at most 3u, 3u, 2u and 5u in their four sums:
    /// 21u² in all, where 3 EPSILON are 24.
    #[inline]
    fn sum_of_products(a: &Triple<Self>, b: &Triple<Self>) -> Self {
        let [p, q, r] = [0, 1, 2].map(|k| long_product(&a[k], &b[k]));
        let first = two_sum(p.high, q.high);
        let sum = two_sum(first.high, r.high);
        // Of terms that cancel the low part may be the larger.
        two_sum(sum.high, ((p.low + q.low) + r.low) + (first.low + sum.low))
    }
    /// Off by at most 2 [`EPSILON`] of the products' magnitudes: 8u² for each, 3u² and 4u² for two sums, of 16.
    #[inline]
    fn difference_of_products([a, b]: [&Self; 2], [c, d]: [&Self; 2]) -> Self {
        let [p, q] = [long_product(a, b), long_product(&c.negated(), d)];
        let sum = two_sum(p.high, q.high);
        two_sum(sum.high, (p.low + q.low) + sum.low)
    }
}

/// 2^exponent: by its bits where they hold it, which is all but always.
fn power_of_two(exponent: i32) -> f64 {
    match exponent {
        -1022..=1023 => f64::from_bits(((1023 + exponent) as u64) << 52),
        _ => 2f64.powi(exponent),
    }
}

impl Number for DoubleDouble {
    fn on_grid(x: f64, unit: i32) -> Self {
        Self::from(x * power_of_two(-unit))
    }
    fn power_of_two(shift: u32) -> Self {
        Self::from(power_of_two(shift as i32))
    }
    fn rounded(direction: &Triple<Self>) -> DVec3 {
        let d = DVec3::from_array([0, 1, 2].map(|k| direction[k].high));
        d / d.abs().max_element()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    /// In units of 2⁻³⁰⁰.
    fn exact(x: DoubleDouble) -> BigInt {
        let of = |x: f64| {
            let bits = x.abs().to_bits();
            let mantissa = BigInt::from(bits & ((1 << 52) - 1) | 1 << 52);
            let shift = (bits >> 52) as i32 - 1075 + 300;
            let x_abs = if x == 0.0 { BigInt::ZERO } else { mantissa << shift };
            if x < 0.0 { -x_abs } else { x_abs }
        };
        of(x.high) + of(x.low)
    }

    fn number() -> impl Strategy<Value = DoubleDouble> {
        let any = || (-1.0f64..1.0, -20i32..20);
        (any(), any()).prop_map(|((x, e), (y, _))| two_sum(x * 2f64.powi(e), y * 2f64.powi(e - 54)))
    }

    proptest! {
        #[test]
        fn sums_products_quotients_and_roots_keep_their_bound(a in number(), b in number()) {
            let within = |error: BigInt, of: BigInt| {
                error.magnitude() << 103 <= of.magnitude() << 1
            };
            let sum = exact(a) + exact(b);
            prop_assert!(within(exact(a.plus(&b)) - &sum, sum));
            let product = exact(a) * exact(b);
            prop_assert!(within((exact(a.times(&b)) << 300) - &product, product));
            if b.high.abs() > 1e-9 {
                let back = exact(a.divided_by(b)) * exact(b);
                prop_assert!(within((back - (exact(a) << 300)) >> 3, exact(a) << 300));
            }
            if a.high > 1e-9 {
                let root = exact(a.sqrt());
                prop_assert!(within((&root * &root - (exact(a) << 300)) >> 3, exact(a) << 300));
            }
        }

        #[test]
        fn sums_of_products_keep_their_bound_where_they_cancel_too(
            a in prop::array::uniform3(number()),
            b in prop::array::uniform3(number()),
            cancels in any::<bool>(),
            smaller in prop::array::uniform2(0..60i32),
        ) {
            // What a product loses shows most beside larger ones. The last is the least if it takes the others away.
            let (mut a, mut b) = (a, b);
            for (a, by) in a[1..].iter_mut().zip(smaller) {
                *a = a.times(&DoubleDouble::from(2f64.powi(-by)));
            }
            if cancels {
                let sum = a[0].times(&b[0]).plus(&a[1].times(&b[1]));
                (a[2], b[2]) = (sum.negated(), DoubleDouble::one());
            }
            let products = [0, 1, 2].map(|k| exact(a[k]) * exact(b[k]));
            let within = |error: BigInt, count: usize| {
                let size: BigInt = products[..count].iter().map(|x| BigInt::from(x.magnitude().clone())).sum();
                let epsilons = BigInt::from(count);
                // The sum is off by the units it is compared in as well.
                error.magnitude() << 103 <= (size * epsilons).magnitude() + (BigInt::from(1) << 403u32).magnitude()
            };
            let sum: BigInt = products.iter().sum();
            prop_assert!(within((exact(DoubleDouble::sum_of_products(&a, &b)) << 300) - sum, 3));
            let difference = &products[0] - &products[1];
            let found = DoubleDouble::difference_of_products([&a[0], &b[0]], [&a[1], &b[1]]);
            prop_assert!(within((exact(found) << 300) - difference, 2));
        }
    }
}
