//! From whole numbers to f64.

use crate::world::Point;
use num_bigint::BigInt;

/// m and e with x = m·2^e to nearest: |m| < 2⁶⁴, 0 for 0.
pub(crate) fn leading(x: &BigInt) -> (f64, i64) {
    let (sign, magnitude) = x.clone().into_parts();
    let excess = magnitude.bits().saturating_sub(62);
    let mut top = (&magnitude >> excess).iter_u64_digits().next().unwrap_or(0) << 1;
    // A bit that stands for all that was cut off: so nothing is rounded twice.
    top |= u64::from(magnitude.trailing_zeros().is_some_and(|zeros| zeros < excess));
    let top = top as f64;
    let negative = sign == num_bigint::Sign::Minus;
    (if negative { -top } else { top }, excess as i64 - 1)
}

/// x·2^e; where that is denormal it is rounded once more.
pub(crate) fn scaled(x: f64, exponent: i64) -> f64 {
    let mut rest = exponent.clamp(-5000, 5000) as i32;
    let mut x = x;
    while rest != 0 && x != 0.0 && x.is_finite() {
        let step = rest.clamp(-1000, 1000);
        x *= 2f64.powi(step);
        rest -= step;
    }
    x
}

/// The exponent of the power of two above the largest component; `None` for the zero vector.
pub(crate) fn exponent_above(p: &Point) -> Option<i64> {
    let bits = p.iter().map(BigInt::bits).max().unwrap_or(0);
    (bits > 0).then_some(bits as i64)
}

/// p / 2^exponent, to nearest component by component.
pub(crate) fn point(p: &Point, exponent: i64) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let (m, e) = leading(&p[k]);
        scaled(m, e - exponent)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_float_is_found_with_a_half_and_a_bit_beyond_it() {
        let value = |x: &BigInt| {
            let (m, e) = leading(x);
            scaled(m, e)
        };
        let large = BigInt::from(1) << 200;
        let step = BigInt::from(1) << (200 - 52);
        let half = &step >> 1;
        let one = 2f64.powi(200);
        assert_eq!(value(&large), one);
        assert_eq!(value(&(&large + &half)), one, "a tie goes to the even one");
        assert_eq!(value(&(&large + &half + 1)), one.next_up());
        assert_eq!(value(&(-&large - &step)), -one.next_up());
        assert_eq!((value(&BigInt::from(0)), value(&BigInt::from(-3))), (0.0, -3.0));
        assert_eq!(value(&(BigInt::from(1) << 2000)), f64::INFINITY);
    }
}
