//! Sines and cosines of intervals, by Taylor's series with its remainder.

use super::interval::Interval;

/// π/2 = FIRST + rest: FIRST has 33 bits, so that a whole number of 20 bits times it is exact; the rest is between the two
/// others. π/2 − FIRST = 6.0771005065061922…e-11.
const FIRST: f64 = f64::from_bits(0x3ff9_21fb_5440_0000);
const REST: Interval = Interval {
    lo: f64::from_bits(0x3dd0_b461_1a62_6331),
    hi: f64::from_bits(0x3dd0_b461_1a62_6332),
};

/// Beyond, nothing is known of an angle but that it has a sine.
const FAR: f64 = (1 << 20) as f64;

const ANY: Interval = Interval { lo: -1.0, hi: 1.0 };

/// The sines and the cosines of all angles in it, rad.
pub(crate) fn sin_cos(angle: Interval) -> [Interval; 2] {
    let Interval { lo, hi } = angle;
    if !(lo.abs() <= FAR && hi.abs() <= FAR && hi - lo < 6.0) {
        return [ANY; 2];
    }
    let [mut sin, mut cos] = at(lo);
    if lo < hi {
        let [other_sin, other_cos] = at(hi);
        (sin, cos) = (sin.hull(other_sin), cos.hull(other_cos));
        // Between its ends an extreme is at a multiple of a right angle.
        let right = Interval::point(FIRST).add(REST);
        let quarters = angle.div(right);
        let (first, last) = (quarters.lo.ceil() as i64, quarters.hi.floor() as i64);
        for quarter in first..=last {
            let extreme = Interval::point(if quarter.rem_euclid(4) < 2 { 1.0 } else { -1.0 });
            if quarter % 2 == 0 {
                cos = cos.hull(extreme);
            } else {
                sin = sin.hull(extreme);
            }
        }
    }
    [sin.and(ANY), cos.and(ANY)]
}

/// Of one angle, at most [`FAR`] from 0.
fn at(x: f64) -> [Interval; 2] {
    // Any whole number would do; this one leaves little.
    let quarters = (x * std::f64::consts::FRAC_2_PI).round();
    let turned = quarters * FIRST;
    let (left, lost) = exact_difference(x, turned);
    let left = Interval::point(left).add(Interval::point(lost));
    let left = left.sub(Interval::point(quarters).mul(REST));
    let [sin, cos] = series(left);
    match (quarters as i64).rem_euclid(4) {
        0 => [sin, cos],
        1 => [cos, sin.neg()],
        2 => [sin.neg(), cos.neg()],
        _ => [cos.neg(), sin],
    }
}

/// The difference rounded, and what that leaves of it, exactly (Knuth's two-sum).
fn exact_difference(a: f64, b: f64) -> (f64, f64) {
    let sum = a - b;
    let of_b = sum - a;
    let of_a = sum - of_b;
    (sum, (a - of_a) - (b + of_b))
}

/// The last power in the series.
const TERMS: u32 = 20;

/// Of an interval round 0: anything where that is beyond 1.
fn series(x: Interval) -> [Interval; 2] {
    let size = x.magnitude();
    if !(size <= 1.0) {
        return [ANY; 2];
    }
    let (mut term, mut sin, mut cos) = (Interval::ONE, Interval::ZERO, Interval::ZERO);
    for power in 0..=TERMS {
        if power > 0 {
            term = term.mul(x).div(Interval::point(f64::from(power)));
        }
        let sum = if power % 2 == 0 { &mut cos } else { &mut sin };
        *sum = if power / 2 % 2 == 0 { sum.add(term) } else { sum.sub(term) };
    }
    // Lagrange's remainder: the next term is at most 1/21! and 1/22!, below 1e-19.
    let remainder = term.mul(x).div(Interval::point(f64::from(TERMS + 1))).magnitude();
    let remainder = Interval::within(remainder);
    [sin.add(remainder), cos.add(remainder)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;

    /// The sine and cosine of a dyadic angle m·2⁻⁴⁰ in whole numbers of 2⁻²⁰⁰, off by less than 2⁻¹⁸⁰: Taylor's series
    /// without any reduction, for angles up to 16.
    fn exactly(m: i64) -> [BigInt; 2] {
        let one = BigInt::from(1) << 200;
        let (mut term, mut sums) = (one, [BigInt::ZERO, BigInt::ZERO]);
        for power in 0u32..160 {
            if power > 0 {
                term = (term * m / i64::from(power)) >> 40;
            }
            let sum = &mut sums[usize::from(power % 2 == 0)];
            *sum = if power / 2 % 2 == 0 { &*sum + &term } else { &*sum - &term };
        }
        sums
    }

    fn holds(found: Interval, exact: &BigInt) -> bool {
        // Ends in units of 2⁻¹²⁰, where an f64 below 2 and above 2⁻⁶⁰ is whole.
        let whole = |x: f64| BigInt::from((x * 2f64.powi(120)) as i128);
        let exact: BigInt = exact >> 80;
        whole(found.lo) - 1 <= exact && exact <= whole(found.hi) + 1
    }

    #[test]
    fn a_sine_is_between_its_bounds_and_these_are_close() {
        let mut draw = 7u64;
        for k in 0..4000 {
            draw = draw.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(k);
            let m = (draw >> 20) as i64 - (1 << 43);
            let m = m >> (k % 30);
            let angle = m as f64 * 2f64.powi(-40);
            let found = sin_cos(Interval::point(angle));
            for (found, exact) in found.iter().zip(&exactly(m)) {
                assert!(holds(*found, exact), "{angle}: {found:?}");
                assert!(found.hi - found.lo < 1e-14, "{angle}: {found:?}");
            }
        }
    }

    #[test]
    fn the_parts_of_a_right_angle_enclose_it() {
        // sin(FIRST + REST) is 1 less half the square of what is missing: cos has the sign of that.
        let above = at(FIRST)[1];
        // cos(FIRST) = sin(π/2 − FIRST), which is the rest up to its cube.
        assert!(above.lo <= REST.lo && REST.hi <= above.hi, "{above:?}");
        assert!(above.hi - above.lo < 1e-15);
        // Machin: π/4 = 4 atan(1/5) − atan(1/239), in units of 2⁻²⁰⁰.
        let atan = |n: i64| {
            let (mut power, mut sum) = ((BigInt::from(1) << 200) / n, BigInt::ZERO);
            for k in 0..120i64 {
                let term = &power / (2 * k + 1);
                sum = if k % 2 == 0 { sum + term } else { sum - term };
                power /= n * n;
            }
            sum
        };
        let right: BigInt = (atan(5) * 4 - atan(239)) * 2;
        let first = BigInt::from((FIRST * 2f64.powi(100)) as i128) << 100;
        let rest: BigInt = (right - first) >> 80;
        let whole = |x: f64| BigInt::from((x * 2f64.powi(120)) as i128);
        assert!(whole(REST.lo) < rest && rest < whole(REST.hi), "{rest}");
    }

    #[test]
    fn of_an_interval_all_sines_are_inside() {
        let mut draw = 3u64;
        for k in 0..2000 {
            draw = draw.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(k);
            let from = (draw >> 11) as f64 * 2f64.powi(-49) - 8.0;
            let wide = f64::from((k % 60) as u32) / 10.0;
            let [sin, cos] = sin_cos(Interval::new(from, from + wide));
            for step in 0..=40 {
                let x = from + wide * f64::from(step) / 40.0;
                let (s, c) = x.min(from + wide).sin_cos();
                assert!(sin.lo <= s + 1e-15 && s - 1e-15 <= sin.hi, "{from} {wide}: {sin:?} {s}");
                assert!(cos.lo <= c + 1e-15 && c - 1e-15 <= cos.hi, "{from} {wide}: {cos:?} {c}");
            }
        }
        assert_eq!(sin_cos(Interval::new(0.0, 7.0)), [ANY; 2]);
        assert_eq!(sin_cos(Interval::point(1e9)), [ANY; 2]);
        assert_eq!(sin_cos(Interval::ENTIRE), [ANY; 2]);
    }
}
