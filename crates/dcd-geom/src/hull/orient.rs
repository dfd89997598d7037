//! On which side of a plane a point lies, exactly.
//!
//! The sign of a 3 × 3 determinant: in f64 with a proven bound, and where that leaves it open by
//! Shewchuk's expansions (1997; the crate `robust`). Expansions are exact as long as nothing over-
//! or underflows, so coordinates are first multiplied by a power of two that puts the largest just
//! below 2^[`TOP`]. A determinant is then below 6 · 2^(3·331) < 2¹⁰²³; and if every coordinate is a
//! multiple of 2^[`BOTTOM`], whatever is added or multiplied on the way is one of 2^(3·BOTTOM) ≥
//! 2⁻¹⁰⁷⁴, which f64 holds.

use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// The exponent below which the largest coordinate is brought. Differences double it.
const TOP: i32 = 330;

/// The exponent of the smallest bit of a coordinate: three times it is that of the smallest f64.
const BOTTOM: i32 = -358;

/// The error bound of the determinant, in multiples of the product of the three extents. No unit.
///
/// It is the sum of six products of one difference along each axis, and each product takes part in
/// eight roundings: three of differences, two of multiplications, three of sums. So it is wrong by at
/// most 6 · ((1 + ε)⁸ − 1), ε = 2⁻⁵³; 9 in place of 8 covers the higher orders and the rounding of
/// extents and bound. Smaller: wrong signs. Larger: more calls of the expansions.
const ROUNDING: f64 = 9.0 * 6.0 * (f64::EPSILON / 2.0);

/// Points whose signs are exact.
pub(crate) struct ExactPoints {
    points: Vec<DVec3>,
    /// Determinants beyond it have the sign of the exact one.
    bound: f64,
}

/// A plane through three points, counter-clockwise seen from above.
#[derive(Clone, Copy)]
pub(crate) struct Plane {
    corners: [u32; 3],
    base: DVec3,
    /// Rounded; of twice the triangle's area.
    normal: DVec3,
}

impl ExactPoints {
    /// The points times a power of two; none if their bits span more than 688 binary places, or if
    /// one is not finite.
    pub(crate) fn scaled(points: &[DVec3]) -> Option<Self> {
        let (mut top, mut bottom) = (i32::MIN, i32::MAX);
        for x in points.iter().flat_map(|p| p.to_array()).filter(|&x| x != 0.0) {
            let [above, lowest] = bits(x)?;
            (top, bottom) = (top.max(above), bottom.min(lowest));
        }
        if top == i32::MIN {
            return Some(Self::in_range(points.to_vec()));
        }
        let shift = TOP - top;
        if bottom + shift < BOTTOM {
            return None;
        }
        // In two steps: the whole factor may be out of range where what it gives is not. Each is
        // exact, since the first goes half of the way.
        let (first, second) = (power_of_two(shift / 2), power_of_two(shift - shift / 2));
        Some(Self::in_range(points.iter().map(|&p| p * first * second).collect()))
    }

    /// Points with coordinates below 2^330 that are multiples of 2⁻³⁵⁸.
    pub(crate) fn in_range(points: Vec<DVec3>) -> Self {
        let first = points.first().copied().unwrap_or_default();
        let low = points.iter().fold(first, |low, &p| low.min(p));
        let high = points.iter().fold(first, |high, &p| high.max(p));
        Self { bound: ROUNDING * (high - low).element_product(), points }
    }

    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    pub(crate) fn get(&self, k: u32) -> DVec3 {
        self.points[k as usize]
    }

    /// These points alone, renumbered.
    pub(crate) fn only(&self, kept: &[u32]) -> Self {
        Self::in_range(kept.iter().map(|&k| self.get(k)).collect())
    }

    /// These points and one more, within the same limits.
    pub(crate) fn with(&self, point: DVec3) -> Self {
        let mut points = self.points.clone();
        points.push(point);
        Self::in_range(points)
    }

    pub(crate) fn plane(&self, corners: [u32; 3]) -> Plane {
        let [a, b, c] = corners.map(|k| self.get(k));
        Plane { corners, base: a, normal: (b - a).cross(c - a) }
    }

    /// How far above a plane a point is, times twice the triangle's area. The sign is exact, zero
    /// included; the value is rounded.
    #[inline]
    pub(crate) fn height(&self, k: u32, plane: &Plane) -> f64 {
        let rounded = plane.normal.dot(self.get(k) - plane.base);
        if rounded.abs() > self.bound { rounded } else { self.exact_height(k, plane.corners) }
    }

    #[cold]
    fn exact_height(&self, k: u32, corners: [u32; 3]) -> f64 {
        let [a, b, c] = corners.map(|k| coordinates(self.get(k)));
        // Theirs is positive below the plane.
        -orient3d(a, b, c, coordinates(self.get(k)))
    }

    /// Whether three points are on one line: whether they are in all three projections.
    pub(crate) fn is_straight(&self, corners: [u32; 3]) -> bool {
        (0..3).all(|axis| self.turn(corners, axis) == 0.0)
    }

    /// Twice the area of the triangle seen along an axis, its sign exact.
    pub(crate) fn turn(&self, corners: [u32; 3], axis: usize) -> f64 {
        let flat = |k: u32| {
            let p = self.get(k);
            Coord { x: p[(axis + 1) % 3], y: p[(axis + 2) % 3] }
        };
        let [a, b, c] = corners.map(flat);
        orient2d(a, b, c)
    }
}

fn coordinates(p: DVec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

/// The exponents of the power of two just above |x| and of the lowest bit of x, which is not 0.
fn bits(x: f64) -> Option<[i32; 2]> {
    if !x.is_finite() {
        return None;
    }
    let exponent = (x.to_bits() >> 52 & 0x7ff) as i32;
    let fraction = x.to_bits() & ((1 << 52) - 1);
    let significand = if exponent == 0 { fraction } else { fraction | 1 << 52 };
    let unit = exponent.max(1) - 1075;
    let width = 64 - significand.leading_zeros() as i32;
    Some([unit + width, unit + significand.trailing_zeros() as i32])
}

/// 2^exponent, exactly; the exponent that of a normal f64.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_and_the_lowest_bit_are_found_in_every_binade() {
        assert_eq!(bits(1.0), Some([1, 0]));
        assert_eq!(bits(-12.0), Some([4, 2]));
        assert_eq!(bits(f64::MAX), Some([1024, 971]));
        assert_eq!(bits(f64::MIN_POSITIVE), Some([-1021, -1022]));
        assert_eq!(bits(5e-324), Some([-1073, -1074]));
        assert_eq!(bits(f64::NAN), None);
    }

    #[test]
    fn the_sign_of_a_height_is_exact_at_both_ends_of_the_range() {
        let tilted = |x: f64| [[0.0, 0.0, 0.0], [x, 0.0, 0.0], [0.0, x, 0.0], [x, x, 0.0]];
        for unit in [5e-324, f64::MIN_POSITIVE, 1e-150, 1.0, 1e150, 2f64.powi(1023)] {
            let flat = tilted(unit).map(DVec3::from_array);
            let exact = ExactPoints::scaled(&flat).unwrap();
            assert_eq!(exact.height(3, &exact.plane([0, 1, 2])), 0.0, "{unit:e}");
            for (z, sign) in [(5e-324, 1.0), (-5e-324, -1.0)] {
                let mut bent = flat;
                bent[3].z = z;
                let Some(exact) = ExactPoints::scaled(&bent) else {
                    assert!(unit > 1e-120, "{unit:e}");
                    continue;
                };
                assert!(exact.height(3, &exact.plane([0, 1, 2])) * sign > 0.0, "{unit:e}");
            }
        }
    }

    #[test]
    fn points_whose_bits_span_too_much_are_refused() {
        let spread =
            |bottom: i32| ExactPoints::scaled(&[DVec3::new(1.0, 2f64.powi(bottom), 0.0)]).is_some();
        // 1 is below 2¹: from there to 2⁻⁶⁸⁷ there are 688 places.
        assert!(spread(-687) && !spread(-688));
    }
}
