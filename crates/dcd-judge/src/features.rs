//! Yes or no by linear programming, and the distance by enumerating every feature of A − B.

use crate::program;
use crate::world::{World, cross, dot, lowest_bit, minus, whole};
use crate::{Side, Truth};
use num_bigint::BigInt;

/// Whether the shapes, radii included, share a point.
pub fn touches(a: Side<'_>, b: Side<'_>) -> bool {
    let world = World::of(a, b);
    if program::hulls_touch(&world.a, &world.b) {
        return true;
    }
    world.radius != BigInt::ZERO && Truth::in_world(&world).touches()
}

/// Whether the distance of two shapes that are apart, radii taken off, is in low..=high, exactly.
pub fn distance_is_in(a: Side<'_>, b: Side<'_>, low: f64, high: f64) -> bool {
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

/// The squared distance of two cores that are apart, as a fraction, in squares of the unit: the
/// least over every vertex, every segment between two and every triangle between three vertices
/// of the difference, each where the foot of the perpendicular is inside.
fn squared_distance_apart(world: &World) -> (BigInt, BigInt) {
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
                let inside = |u: &_, v: &_| dot(&cross(u, v), &normal) >= zero;
                if size > zero && inside(p, q) && inside(q, r) && inside(r, p) {
                    let height = dot(&normal, p);
                    consider(&height * &height, size);
                }
            }
        }
    }
    best
}
