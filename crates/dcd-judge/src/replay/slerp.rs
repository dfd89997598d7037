//! The way of a unit quaternion on the great circle, at constant speed.

use super::angle::sin_cos;
use super::interval::Interval;
use super::jet::Jet;
use crate::rounding::{leading, scaled};
use crate::world::whole;
use num_bigint::BigInt;
use std::array::from_fn;

/// From f to g, both of length 1 and α apart: cos((t − ½)·α)·m + sin((t − ½)·α)·d with m and d the directions of f + g and
/// g − f, which are at right angles. Both are as well known near no turn and near a full one as anywhere, for they come from
/// whole numbers; a direction at right angles to f, divided by sin α, would lose there what the division gains.
pub(super) struct Slerp {
    middle: [Interval; 4],
    across: [Interval; 4],
    /// α/2, rad.
    half: Interval,
}

/// Numbers here are whole numbers of 2^-BITS: each f64 is one.
const BITS: i32 = 1100;

/// Shorter sums are those of opposite quaternions, shorter differences are none: 2^-SHORT. No unit.
const SHORT: i32 = 100;

/// At least what the components of a direction lose in whole numbers: unit quaternions are off by less than 4 of them, their
/// sums and differences by 8 and the length of these by 17, which the division by 2^-SHORT at the least makes 2⁵·2^(SHORT − BITS).
const LOST: i32 = 900;

/// A vector in whole numbers.
type Whole = [BigInt; 4];

impl Slerp {
    /// Between the directions of two quaternions x y z w.
    pub(super) fn between(from: [f64; 4], to: [f64; 4]) -> Result<Self, String> {
        let (from, to) = (unit(from)?, unit(to)?);
        let sum: Whole = from_fn(|k| &from[k] + &to[k]);
        let difference: Whole = from_fn(|k| &to[k] - &from[k]);
        let [far, near] = [length(&sum), length(&difference)];
        let least = BigInt::from(1) << (BITS - SHORT);
        // Opposite quaternions have no one way between them.
        if far < least {
            return Err("opposite quaternions".to_owned());
        }
        let middle = along(&sum, &far);
        if near < least {
            // α/2 ≤ tan(α/2) = |g − f| / |f + g|, the divisor above 1.
            let half = Interval::new(0.0, 2f64.powi(-SHORT));
            return Ok(Self { middle, across: [Interval::within(1.0); 4], half });
        }
        let half = angle(enclosed(&near), enclosed(&far))?;
        Ok(Self { middle, across: along(&difference, &near), half })
    }

    /// Of one that stays where it is.
    pub(super) fn still(at: [f64; 4]) -> Result<Self, String> {
        let middle = unit(at)?.each_ref().map(enclosed);
        Ok(Self { middle, across: [Interval::ZERO; 4], half: Interval::ZERO })
    }

    /// The rotation's rows.
    pub(super) fn rotation(&self, t: Interval) -> [[Jet; 3]; 3] {
        let two = Interval::point(2.0);
        let from_middle = t.mul(two).sub(Interval::ONE);
        let angle = Jet {
            value: from_middle.mul(self.half),
            first: two.mul(self.half),
            second: Interval::ZERO,
        };
        let [sin, cos] = angle.sin_cos();
        let of = |k: usize| cos.scale(self.middle[k]).add(sin.scale(self.across[k]));
        let [x, y, z, w] = from_fn(of);
        let double = |a: Jet, b: Jet| a.mul(b).scale(two);
        let one = Jet::constant(Interval::ONE);
        let diagonal = |a: Jet, b: Jet| one.sub(double(a, a)).sub(double(b, b));
        [
            [diagonal(y, z), double(x, y).sub(double(z, w)), double(x, z).add(double(y, w))],
            [double(x, y).add(double(z, w)), diagonal(x, z), double(y, z).sub(double(x, w))],
            [double(x, z).sub(double(y, w)), double(y, z).add(double(x, w)), diagonal(x, y)],
        ]
    }
}

fn unit(q: [f64; 4]) -> Result<Whole, String> {
    let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(size > 0.999 && size < 1.001) {
        return Err(format!("a quaternion of length {size}"));
    }
    let q = q.map(|x| whole(x, -BITS));
    Ok(direction(&q, &length(&q)))
}

fn length(v: &Whole) -> BigInt {
    v.iter().map(|x| x * x).sum::<BigInt>().sqrt()
}

fn direction(v: &Whole, length: &BigInt) -> Whole {
    v.each_ref().map(|x| (x << BITS) / length)
}

fn along(v: &Whole, length: &BigInt) -> [Interval; 4] {
    direction(v, length).each_ref().map(enclosed)
}

fn enclosed(x: &BigInt) -> Interval {
    let (m, exponent) = leading(x);
    let nearest = scaled(m, exponent - i64::from(BITS));
    // A sum is rounded outward by a step, what is nearest is off by half of one.
    Interval::point(nearest).add(Interval::within(2f64.powi(-LOST)))
}

/// The angle between 0 and a right one whose sine and cosine are as these: a guess that is then proved, from either side, by
/// the sign of the sine of what it is off by.
fn angle(sine: Interval, cosine: Interval) -> Result<Interval, String> {
    let guess = sine.hi.atan2(cosine.lo);
    let beyond = |x: f64| {
        let [sin, cos] = sin_cos(Interval::point(x));
        sine.mul(cos).sub(cosine.mul(sin))
    };
    let proved = |outward: f64, is_proved: &dyn Fn(Interval) -> bool| {
        let steps = (0..60).map(|k| guess * (1.0 + outward * f64::EPSILON * 2f64.powi(k)));
        let mut inside = steps.take_while(|x| (0.0..=1.6).contains(x));
        inside.find(|&x| is_proved(beyond(x))).ok_or("a quaternion's way is not enclosed")
    };
    let (lo, hi) = (proved(-1.0, &|s| s.lo >= 0.0)?, proved(1.0, &|s| s.hi <= 0.0)?);
    Ok(Interval::new(lo, hi))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds(found: Interval, expected: f64, off: f64) -> bool {
        found.lo - off <= expected && expected <= found.hi + off
    }

    #[test]
    fn a_quaternion_turns_at_constant_speed_the_way_that_its_numbers_go() {
        // From no turn to one by `angle` about z; the far ones go the long way round of the rotations.
        for angle in [1e-300f64, 1e-9, 0.3, 2.0, 4.0, 6.0, 6.281] {
            let (s, c) = (angle / 2.0).sin_cos();
            let slerp = Slerp::between([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, s, c]).unwrap();
            for t in [0.0, 0.3, 0.5, 1.0] {
                let (s, c) = (angle * t).sin_cos();
                let rows = slerp.rotation(Interval::point(t));
                for (found, expected) in
                    [(rows[0][0], c), (rows[0][1], -s), (rows[1][0], s), (rows[2][2], 1.0)]
                {
                    // The end is rounded, and near a full turn what it says of the way is off by more.
                    let off = if angle < 6.1 { 1e-15 } else { 1e-12 };
                    assert!(holds(found.value, expected, off), "{angle} {t}: {found:?}");
                    let wide = found.value.hi - found.value.lo;
                    assert!(wide < 1e-13, "{angle} {t}: {found:?}");
                }
                assert!(holds(rows[1][0].first, angle * c, 1e-12), "{angle} {t}");
            }
        }
        assert!(Slerp::between([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, -1.0]).is_err());
        assert!(Slerp::between([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.9]).is_err());
        assert!(Slerp::still([0.0, f64::NAN, 0.0, 1.0]).is_err());
    }

    #[test]
    fn a_quaternion_that_nearly_comes_round_to_its_opposite_is_known_as_well_as_any() {
        // Ends whose numbers are exact: 3-4-5 quaternions, and their opposites but for a hair.
        for hair in [1e-3, 1e-6, 1e-9] {
            let (from, to) = ([0.6, 0.0, 0.0, 0.8], [-0.6, hair, 0.0, -0.8]);
            let slerp = Slerp::between(from, to).unwrap();
            // Half of the way is at right angles to both, nearly: half a turn about y, then what the ends have in common.
            let rows = slerp.rotation(Interval::point(0.5));
            for (row, expected) in
                rows.iter().zip([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])
            {
                for (found, expected) in row.iter().zip(expected) {
                    assert!(holds(found.value, expected, 2.0 * hair), "{hair}: {found:?}");
                    assert!(found.value.hi - found.value.lo < 1e-13, "{hair}: {found:?}");
                }
            }
            // Where it begins and ends the numbers themselves say how it is turned.
            for (t, [x, y, _, w]) in [(0.0, from), (1.0, to)] {
                let square = x * x + y * y + w * w;
                let found = slerp.rotation(Interval::point(t))[1][2].value;
                assert!(holds(found, -2.0 * x * w / square, 1e-15), "{hair} {t}: {found:?}");
                assert!(found.hi - found.lo < 1e-13, "{hair} {t}: {found:?}");
            }
        }
    }

    /// By the sines of the two parts of the way, which f64 knows well away from no turn and from a full one.
    #[test]
    fn any_quaternion_is_where_the_formula_of_the_great_circle_has_it() {
        let mut state = 5u64;
        let mut draw = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        let mut checked = 0;
        for _ in 0..2000 {
            let mut quaternion = || {
                let q: [f64; 4] = from_fn(|_| draw());
                let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
                q.map(|x| x / length)
            };
            let (f, g) = (quaternion(), quaternion());
            let cosine: f64 = f.iter().zip(g).map(|(x, y)| x * y).sum();
            if cosine.abs() > 0.99 || cosine.is_nan() {
                continue;
            }
            let angle = cosine.acos();
            let at = |t: f64| -> [f64; 4] {
                let (from, to) = (((1.0 - t) * angle).sin(), (t * angle).sin());
                from_fn(|k| (f[k] * from + g[k] * to) / angle.sin())
            };
            // The middle column, by turning the y axis with the quaternion.
            let turned = |[x, y, z, w]: [f64; 4]| {
                [2.0 * (x * y - z * w), w * w - x * x + y * y - z * z, 2.0 * (y * z + x * w)]
            };
            let slerp = Slerp::between(f, g).unwrap();
            for t in [0.0, 0.25, 0.6, 1.0] {
                let rows = slerp.rotation(Interval::point(t));
                let step = 1e-6;
                let (due, before, after) =
                    (turned(at(t)), turned(at(t - step)), turned(at(t + step)));
                for k in 0..3 {
                    let found = rows[k][1];
                    assert!(
                        holds(found.value, due[k], 1e-13),
                        "{f:?} {g:?} {t}: {found:?} {due:?}"
                    );
                    assert!(found.value.hi - found.value.lo < 1e-13, "{f:?} {g:?} {t}: {found:?}");
                    let speed = (after[k] - before[k]) / (2.0 * step);
                    assert!(holds(found.first, speed, 1e-8), "{f:?} {g:?} {t}: {found:?} {speed}");
                    let bend = (after[k] - 2.0 * due[k] + before[k]) / (step * step);
                    assert!(holds(found.second, bend, 0.05), "{f:?} {g:?} {t}: {found:?} {bend}");
                }
                checked += 1;
            }
        }
        assert!(checked > 5000, "{checked}");
    }
}
