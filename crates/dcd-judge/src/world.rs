//! World vertices in whole numbers.

use crate::Side;
use num_bigint::BigInt;

/// A point or a direction.
pub(crate) type Point = [BigInt; 3];

/// World vertices of both in whole numbers of 2^unit, and the sum of the radii.
pub(crate) struct World {
    pub(crate) a: Vec<Point>,
    pub(crate) b: Vec<Point>,
    pub(crate) radius: BigInt,
    pub(crate) unit: i32,
}

/// Above every exponent that an f64 has: the lowest bit of 0.
const NO_BIT: i32 = 1100;

/// m and e with x = m·2^e, m odd or 0.
fn split(x: f64) -> (i64, i32) {
    if x == 0.0 {
        return (0, NO_BIT);
    }
    let bits = x.to_bits();
    let field = (bits >> 52) as i32 & 0x7ff;
    let fraction = (bits & 0xf_ffff_ffff_ffff) | if field == 0 { 0 } else { 1 << 52 };
    let zeros = fraction.trailing_zeros();
    let magnitude = (fraction >> zeros) as i64;
    (if x < 0.0 { -magnitude } else { magnitude }, field.max(1) - 1075 + zeros as i32)
}

/// The exponent of the lowest bit that is set.
pub(crate) fn lowest_bit(x: f64) -> i32 {
    split(x).1
}

/// x / 2^unit, which must be whole: unit is at most the lowest bit of x.
pub(crate) fn whole(x: f64, unit: i32) -> BigInt {
    let (m, e) = split(x);
    if m == 0 { BigInt::ZERO } else { BigInt::from(m) << (e - unit) }
}

/// The exponents of the lowest bits of a side's rotation and vertices, and of the rest of it.
fn units((shape, pose): Side<'_>) -> [i32; 3] {
    let low = |numbers: &mut dyn Iterator<Item = f64>| {
        numbers.map(lowest_bit).fold(NO_BIT, |least, bit| least.min(bit))
    };
    let rotation = low(&mut pose.rotation().to_cols_array().into_iter());
    let vertices = low(&mut shape.vertices().iter().flat_map(|v| v.to_array()));
    let rest = pose.translation().to_array().into_iter().chain([shape.swept_radius()]);
    [rotation, vertices, low(&mut { rest })]
}

impl World {
    pub(crate) fn of(a: Side<'_>, b: Side<'_>) -> Self {
        let of = |side| {
            let [rotation, vertices, rest] = units(side);
            (rotation + vertices).min(rest)
        };
        let unit = of(a).min(of(b));
        let radius = whole(a.0.swept_radius(), unit) + whole(b.0.swept_radius(), unit);
        Self { a: points(a, unit), b: points(b, unit), radius, unit }
    }

    /// All a − b.
    pub(crate) fn differences(&self) -> Vec<Point> {
        self.a.iter().flat_map(|a| self.b.iter().map(move |b| minus(a, b))).collect()
    }
}

fn points(side: Side<'_>, unit: i32) -> Vec<Point> {
    let (shape, pose) = side;
    let [in_r, in_v, _] = units(side);
    let point = |v: &dcd_geom::glam::DVec3| {
        [0, 1, 2].map(|r| {
            let row = pose.rotation().row(r).to_array();
            let terms = row.into_iter().zip(v.to_array());
            let turned: BigInt = terms.map(|(m, x)| whole(m, in_r) * whole(x, in_v)).sum();
            (turned << (in_r + in_v - unit)) + whole(pose.translation()[r], unit)
        })
    };
    shape.vertices().iter().map(point).collect()
}

pub(crate) fn dot(a: &Point, b: &Point) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

pub(crate) fn cross(a: &Point, b: &Point) -> Point {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

pub(crate) fn minus(a: &Point, b: &Point) -> Point {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

pub(crate) fn is_zero(a: &Point) -> bool {
    a.iter().all(|x| *x == BigInt::ZERO)
}
