//! The slow exact judge: a linear program in whole numbers, and all features one by one. It shares
//! neither code nor method with the crate.
#![allow(dead_code, unreachable_pub)] // each test binary uses its part

pub mod cases;
pub mod program;

use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose};
use dcd_gjk::Body;
use num_bigint::BigInt;

/// A polytope somewhere.
#[derive(Clone, Debug)]
pub struct Placed {
    pub shape: Polytope,
    pub pose: Pose,
}

impl Placed {
    pub fn hull(vertices: Vec<DVec3>, pose: Pose) -> Self {
        Self { shape: Polytope::hull(vertices).unwrap(), pose }
    }

    pub fn body(&self) -> Body<'_, Polytope> {
        Body::polytope(&self.shape, &self.pose)
    }

    /// The same, with every length of its own frame and its translation multiplied.
    pub fn scaled(&self, by: f64) -> Self {
        let vertices = self.shape.vertices().iter().map(|&v| v * by).collect();
        let shape = Polytope::hull(vertices).unwrap();
        let shape = shape.rounded(self.shape.swept_radius() * by).unwrap();
        let t = self.pose.translation() * by;
        Self { shape, pose: Pose::from_matrix(*self.pose.rotation(), t).unwrap() }
    }

    pub fn moved_to(&self, t: DVec3) -> Self {
        let pose = Pose::from_matrix(*self.pose.rotation(), t).unwrap();
        Self { shape: self.shape.clone(), pose }
    }
}

/// World vertices of both in whole numbers of 2^unit, and the sum of the radii.
pub struct World {
    pub a: Vec<[BigInt; 3]>,
    pub b: Vec<[BigInt; 3]>,
    pub radius: BigInt,
    pub unit: i32,
}

/// The exponent of the lowest bit that is set.
fn lowest_bit(x: f64) -> i32 {
    let mut exponent = 1100;
    if x != 0.0 {
        let bits = x.to_bits();
        let field = (bits >> 52) as i32 & 0x7ff;
        let fraction = (bits & 0xf_ffff_ffff_ffff) | if field == 0 { 0 } else { 1 << 52 };
        exponent = field.max(1) - 1075 + fraction.trailing_zeros() as i32;
    }
    exponent
}

/// x / 2^unit, which must be whole.
fn whole(x: f64, unit: i32) -> BigInt {
    if x == 0.0 {
        return BigInt::ZERO;
    }
    let bits = x.to_bits();
    let field = (bits >> 52) as i32 & 0x7ff;
    let fraction = (bits & 0xf_ffff_ffff_ffff) | if field == 0 { 0 } else { 1 << 52 };
    let shift = field.max(1) - 1075 - unit;
    let fraction = BigInt::from(fraction);
    let magnitude = if shift < 0 { fraction >> -shift } else { fraction << shift };
    if x < 0.0 { -magnitude } else { magnitude }
}

impl World {
    pub fn of(a: &Placed, b: &Placed) -> Self {
        let low = |numbers: &mut dyn Iterator<Item = f64>| numbers.map(lowest_bit).min().unwrap();
        let rotation = |p: &Placed| low(&mut p.pose.rotation().to_cols_array().into_iter());
        let vertex = |p: &Placed| low(&mut p.shape.vertices().iter().flat_map(|v| v.to_array()));
        let rest = |p: &Placed| {
            let t = p.pose.translation().to_array();
            low(&mut t.into_iter().chain([p.shape.swept_radius()]))
        };
        let of = |p: &Placed| (rotation(p) + vertex(p)).min(rest(p));
        let unit = of(a).min(of(b));
        let points = |p: &Placed| {
            let (in_r, in_v) = (rotation(p), vertex(p));
            let point = |v: &DVec3| {
                [0, 1, 2].map(|r| {
                    let row = p.pose.rotation().row(r).to_array();
                    let terms = row.into_iter().zip(v.to_array());
                    let turned: BigInt = terms.map(|(m, x)| whole(m, in_r) * whole(x, in_v)).sum();
                    (turned << (in_r + in_v - unit)) + whole(p.pose.translation()[r], unit)
                })
            };
            p.shape.vertices().iter().map(point).collect()
        };
        let radius = whole(a.shape.swept_radius(), unit) + whole(b.shape.swept_radius(), unit);
        Self { a: points(a), b: points(b), radius, unit }
    }

    /// All a − b.
    pub fn differences(&self) -> Vec<[BigInt; 3]> {
        let minus = |a: &[BigInt; 3], b: &[BigInt; 3]| [0, 1, 2].map(|k| &a[k] - &b[k]);
        self.a.iter().flat_map(|a| self.b.iter().map(move |b| minus(a, b))).collect()
    }
}

/// Whether the cores share a point, by linear programming.
pub fn cores_touch(a: &Placed, b: &Placed) -> bool {
    let world = World::of(a, b);
    program::hulls_touch(&world.a, &world.b)
}

/// Whether the shapes, radii included, share a point.
pub fn touches(a: &Placed, b: &Placed) -> bool {
    if cores_touch(a, b) {
        return true;
    }
    let world = World::of(a, b);
    let (numerator, divisor) = squared_distance_apart(&world);
    numerator <= &world.radius * &world.radius * divisor
}

fn dot(a: &[BigInt; 3], b: &[BigInt; 3]) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &[BigInt; 3], b: &[BigInt; 3]) -> [BigInt; 3] {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

fn minus(a: &[BigInt; 3], b: &[BigInt; 3]) -> [BigInt; 3] {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

/// The squared distance of two cores that are apart, as a fraction, in squares of the unit: the
/// least over every vertex, every segment between two and every triangle between three vertices
/// of the difference, each where the foot of the perpendicular is inside.
pub fn squared_distance_apart(world: &World) -> (BigInt, BigInt) {
    let points = world.differences();
    let mut best = (dot(&points[0], &points[0]), BigInt::from(1));
    let mut consider = |numerator: BigInt, divisor: BigInt| {
        if &numerator * &best.1 < &best.0 * &divisor {
            best = (numerator, divisor);
        }
    };
    let zero = BigInt::ZERO;
    for (i, p) in points.iter().enumerate() {
        consider(dot(p, p), BigInt::from(1));
        for (j, q) in points.iter().enumerate().skip(i + 1) {
            let e = minus(q, p);
            let along = -dot(p, &e);
            let length = dot(&e, &e);
            if along > zero && along < length {
                consider(dot(p, p) * &length - &along * &along, length);
            }
            for r in &points[j + 1..] {
                let normal = cross(&e, &minus(r, p));
                let size = dot(&normal, &normal);
                let inside = |u: &[BigInt; 3], v: &[BigInt; 3]| dot(&cross(u, v), &normal) >= zero;
                if size > zero && inside(p, q) && inside(q, r) && inside(r, p) {
                    let height = dot(&normal, p);
                    consider(&height * &height, size);
                }
            }
        }
    }
    best
}

/// Whether the distance of two shapes that are apart, radii taken off, is in low..=high, exactly.
pub fn distance_is_in(a: &Placed, b: &Placed, low: f64, high: f64) -> bool {
    let world = World::of(a, b);
    let (numerator, divisor) = squared_distance_apart(&world);
    let unit = world.unit.min(lowest_bit(low)).min(lowest_bit(high));
    let finer = world.unit - unit;
    let numerator = numerator << (2 * finer);
    let radius = &world.radius << finer;
    let squared = |x: f64| {
        let reach = whole(x, unit) + &radius;
        &reach * &reach * &divisor
    };
    squared(low) <= numerator && numerator <= squared(high)
}
