//! The points of cylinders and cones that a search in f32 may come to: those of their rims, and the middles of their discs.
//!
//! Each has a number, as a vertex has, from which it is known again in f64.

use dcd_geom::Curved;
use dcd_geom::glam::{DVec2, DVec3, Vec3};

/// The bit of a number that says which disc: set of the upper one.
const UPPER: u32 = 1 << 31;

/// How many bits say where in a quarter of a rim a point is.
const BITS: u32 = 29;

/// Where a quarter ends.
const QUARTER: u32 = 1 << BITS;

/// The middle of a disc: where the last quarter would end.
const MIDDLE: u32 = UPPER - 1;

/// The least square of how much of a direction is across the axis for its part to be known: no square underflows by more than
/// rounding. Larger: the middles of discs where their rims are farther.
const LEAST: f32 = f32::MIN_POSITIVE / f32::EPSILON;

/// A cylinder's or cone's core as f32 has it, in its own frame, round a point of its axis.
#[derive(Clone, Copy)]
pub(crate) struct Rims {
    /// z from that point, and the radius.
    discs: [(f32, f32); 2],
}

impl Rims {
    /// Of a core whose centre is that, on its axis.
    #[inline]
    pub(crate) fn of(curved: &Curved, centre: DVec3) -> Self {
        Self { discs: curved.discs().map(|(z, radius)| ((z - centre.z) as f32, radius as f32)) }
    }

    /// The point that is farthest along a direction, up to rounding, and its number. It is a point of the core but for 5u of the
    /// radius.
    #[inline]
    pub(crate) fn farthest(&self, Vec3 { x, y, z }: Vec3) -> (Vec3, u32) {
        let [low, high] = self.discs;
        let squared = x * x + y * y;
        let across = squared.sqrt();
        let is_upper = z * high.0 + across * high.1 > z * low.0 + across * low.1;
        // Along the axis any point will do. False for NaN.
        let seen = if squared >= LEAST { [x / across, y / across] } else { [0.0; 2] };
        self.at(seen, is_upper)
    }

    /// The point of a rim next to one that is as far from the centre, and its number.
    pub(crate) fn next_to(&self, Vec3 { x, y, z }: Vec3) -> (Vec3, u32) {
        let [low, high] = self.discs;
        // Of 1 at most, so that the squares of small shapes do not underflow: what is longer than 1 would be beside the rim.
        let most = x.abs().max(y.abs());
        let [x, y] = if most > 0.0 { [x / most, y / most] } else { [0.0; 2] };
        let length = (x * x + y * y).sqrt();
        let seen = if length > 0.0 { [x / length, y / length] } else { [0.0; 2] };
        self.at(seen, (z - high.0).abs() < (z - low.0).abs())
    }

    /// The point of one of the rims that is seen from the axis in that direction, of unit length or 0, and its number.
    #[inline]
    fn at(&self, [x, y]: [f32; 2], is_upper: bool) -> (Vec3, u32) {
        let (z, radius) = self.discs[usize::from(is_upper)];
        (Vec3::new(radius * x, radius * y, z), number([x, y], is_upper))
    }
}

/// The number of a point of a rim that is seen from the axis in that direction, or of a disc's middle.
#[inline]
fn number([x, y]: [f32; 2], is_upper: bool) -> u32 {
    let disc = u32::from(is_upper) << 31;
    let sum = x.abs() + y.abs();
    // False for NaN.
    if !(sum > 0.0) {
        return disc | MIDDLE;
    }
    // Quarters go round counter-clockwise. In the odd ones the share of x grows.
    let (left, below) = (x < 0.0, y < 0.0);
    let is_odd = left != below;
    let quarter = u32::from(below) << 1 | u32::from(is_odd);
    let share = if is_odd { x.abs() } else { y.abs() } / sum;
    // A whole quarter would be the next one's first point, or the middle.
    let place = ((share * QUARTER as f32) as u32).min(QUARTER - 2);
    disc | quarter << BITS | place
}

/// The point of that number, in the shape's own frame.
#[inline]
pub(crate) fn point(curved: &Curved, number: u32) -> DVec3 {
    let (z, radius) = curved.discs()[usize::from(number & UPPER != 0)];
    if number & MIDDLE == MIDDLE {
        return DVec3::Z * z;
    }
    let share = f64::from(number & (QUARTER - 1)) / f64::from(QUARTER);
    let (near, far) = (1.0 - share, share);
    let seen = match number >> BITS & 3 {
        0 => DVec2::new(near, far),
        1 => DVec2::new(-far, near),
        2 => DVec2::new(-near, -far),
        _ => DVec2::new(far, -near),
    };
    (seen * (radius / seen.length())).extend(z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::tests::Draw;
    use dcd_geom::SupportMap;

    /// What f32 may lose of such a point, relative to the core's size: some roundings.
    const LOST: f64 = 8.0 / (1u64 << 24) as f64;

    /// A cylinder or cone, flat, long or neither.
    fn curved(draw: &mut Draw, k: usize) -> Curved {
        let [height, radius, _] = (draw.vector().abs() + 1e-3).to_array();
        let found = match k % 3 {
            0 => Curved::cone(height, radius),
            1 => Curved::cylinder(height * 1e-6, radius),
            _ => Curved::cylinder(height, radius * 1e-6),
        };
        found.unwrap()
    }

    #[test]
    fn what_is_farthest_is_a_point_of_the_core_and_known_again_by_its_number() {
        let mut draw = Draw(5);
        let mut middles = 0;
        for k in 0..20_000 {
            let curved = curved(&mut draw, k);
            let centre = curved.inner().centre;
            let rims = Rims::of(&curved, centre);
            let mut direction = draw.vector();
            // Along an axis, and all but along one.
            direction[k / 3 % 3] *= [1.0, 0.0, 1e-12][k / 9 % 3];
            direction[k / 7 % 3] *= [1.0, 0.0, -1e-30][k / 27 % 3];
            let direction = direction.as_vec3();
            let (found, number) = rims.farthest(direction);
            let lost = LOST * curved.reach();
            let own = point(&curved, number);
            assert!(found.as_dvec3().distance(own - centre) <= lost, "{k}: {found} {own}");
            // No farther than the support, and no nearer.
            let d = direction.as_dvec3();
            let due = d.dot(SupportMap::<f64>::support(&curved, d).point - own);
            assert!(due.abs() <= lost * d.length(), "{k}: {due} {own}");
            let [(low, _), (high, _)] = curved.discs();
            assert!(own.z == low || own.z == high, "{k}: {own}");
            middles += usize::from(own.truncate() == DVec2::ZERO);
        }
        assert!((100..15_000).contains(&middles), "{middles}");
    }

    #[test]
    fn what_is_next_to_a_point_of_a_rim_is_that_point() {
        let mut draw = Draw(6);
        for k in 0..2000 {
            // Down to where squares of lengths underflow.
            let curved = match k % 4 {
                0 => curved(&mut draw, k),
                _ => Curved::cylinder(1e-22, 1e-20 * 0.1f64.powi(k as i32 % 5)).unwrap(),
            };
            let rims = Rims::of(&curved, curved.inner().centre);
            let (found, number) = rims.farthest(draw.vector().as_vec3());
            let (next, again) = rims.next_to(found);
            let apart = point(&curved, number).distance(point(&curved, again));
            let lost = LOST * curved.reach();
            assert!(
                f64::from(found.distance(next)) <= lost && apart <= lost,
                "{k}: {found} {next}"
            );
        }
    }
}
