//! Signs of sums of f64s, exactly and without an integer.
//!
//! Source: Shewchuk 1997: a sum kept as components that do not overlap has the sign of the largest.

use crate::double_double::two_sum;
use std::cmp::Ordering;

/// The sign of the sum where plain f64 decides it: `None` where it is within rounding, or where
/// the sum leaves the range of f64.
#[inline]
pub(crate) fn filtered_sign<const N: usize>(terms: [f64; N]) -> Option<Ordering> {
    let sum: f64 = terms.iter().sum();
    let magnitude: f64 = terms.iter().map(|x| x.abs()).sum();
    // N − 1 roundings of at most u·magnitude each; twice that, for the magnitude's own.
    let bound = N as f64 * f64::EPSILON * magnitude;
    // False for NaN; an infinite sum is not above an infinite bound.
    if sum > bound {
        Some(Ordering::Greater)
    } else if sum < -bound {
        Some(Ordering::Less)
    } else {
        None
    }
}

/// A number with the sign of h₀ + h₁ − |t₀ − t₁|, if what comes with it is 0: what was rounded away
/// before the last difference, as a magnitude. So it is with numbers of few digits, as on a grid.
#[inline(always)]
pub(crate) fn difference_and_loss(h: [f64; 2], t: [f64; 2]) -> (f64, f64) {
    let (sum, distance) = (two_sum(h[0], h[1]), two_sum(t[0], -t[1]));
    // A rounded difference of two numbers has the sign of the difference.
    (sum.high - distance.high.abs(), sum.low.abs() + distance.low.abs())
}

/// The sign of the sum, exactly. Every partial sum must be finite.
pub(crate) fn exact_sign<const N: usize>(terms: [f64; N]) -> Ordering {
    // Components in ascending order, some of them 0. The first k are in use.
    let mut components = [0.0; N];
    for (k, &term) in terms.iter().enumerate() {
        let mut rest = term;
        for component in &mut components[..k] {
            let sum = two_sum(rest, *component);
            (rest, *component) = (sum.high, sum.low);
        }
        components[k] = rest;
    }
    let largest = components.iter().rev().find(|&&x| x != 0.0);
    largest.map_or(Ordering::Equal, |x| x.total_cmp(&0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    /// In units of the least positive number.
    fn whole(x: f64) -> BigInt {
        let bits = x.abs().to_bits();
        let (exponent, fraction) = (bits >> 52, bits & ((1 << 52) - 1));
        let mantissa = if exponent == 0 { fraction } else { fraction | 1 << 52 };
        let whole = BigInt::from(mantissa) << exponent.saturating_sub(1);
        if x < 0.0 { -whole } else { whole }
    }

    fn check(terms: [f64; 5]) {
        let sum: BigInt = terms.iter().map(|&x| whole(x)).sum();
        let truth = sum.cmp(&BigInt::ZERO);
        assert_eq!(exact_sign(terms), truth, "{terms:?}");
        assert!(filtered_sign(terms).is_none_or(|sign| sign == truth), "{terms:?}");
        let (h, t) = ([terms[0], terms[1]], [-terms[2], terms[3] + terms[4]]);
        let truth = exact_sign([h[0], h[1], t[0].min(t[1]), -t[0].max(t[1])]);
        let (difference, loss) = difference_and_loss(h, t);
        assert!(loss != 0.0 || difference.partial_cmp(&0.0) == Some(truth), "{h:?} {t:?}");
    }

    #[test]
    fn what_cancels_is_zero_and_what_is_left_has_its_sign() {
        let tiny = f64::from_bits(1);
        check([0.1, 0.2, -0.1, -0.2, 0.0]);
        check([1e300, tiny, -1e300, 0.0, -0.0]);
        check([1e300, -tiny, 1.0, -1.0, -1e300]);
        check([0.0; 5]);
    }

    proptest! {
        #[test]
        fn signs_are_those_of_whole_numbers(
            a in -1e3..1e3f64, b in -1e3..1e3f64, scale in -60..60i32, ulps in -2i64..=2,
        ) {
            let small = a * 2f64.powi(scale);
            let near = f64::from_bits((a + b).to_bits().wrapping_add_signed(ulps));
            check([a, b, -near, small, -small]);
            check([small, a, -near, b, 0.0]);
        }
    }
}
