//! Axis-aligned bounding boxes in f32.

use glam::{DVec3, Vec3};

/// A closed axis-aligned bounding box in world coordinates, metres. f32, because AABBs decide how much
/// memory a broad phase reads; whoever makes one from f64 rounds outward, so that none is lost.
/// With serde, {"min": [x, y, z], "max": [x, y, z]}; JSON has no form for an infinite one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Aabb {
    /// The smallest corner.
    pub min: Vec3,
    /// The largest corner, in no component below `min`.
    pub max: Vec3,
}

impl Aabb {
    /// The AABB of nothing: the neutral element of [`Aabb::union`], overlapping no AABB with finite sides.
    pub const EMPTY: Self =
        Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// The AABB of all there is, which overlaps every AABB. Not a valid AABB of an object.
    pub const EVERYTHING: Self =
        Self { min: Vec3::splat(f32::NEG_INFINITY), max: Vec3::splat(f32::INFINITY) };

    /// How far an object may reach along an axis, in metres: small enough to add two coordinates and
    /// to scale them by a rounding bound without overflow in f32.
    pub const LIMIT: f64 = 1.0e37;

    /// The smallest f32 AABB that contains the f64 one.
    #[inline]
    pub fn outward(min: DVec3, max: DVec3) -> Self {
        Self {
            min: Vec3::new(round_down(min.x), round_down(min.y), round_down(min.z)),
            max: Vec3::new(round_up(max.x), round_up(max.y), round_up(max.z)),
        }
    }

    /// The smallest f32 AABB that contains the f64 one, which is finite, and all its sides within itself.
    #[inline]
    pub fn strictly_outward(min: DVec3, max: DVec3) -> Self {
        let (min, max) = ((-min).to_array().map(above), max.to_array().map(above));
        Self { min: -Vec3::from_array(min), max: Vec3::from_array(max) }
    }

    /// Whether the closed AABBs share a point: touching counts.
    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.x <= other.max.x
            && other.min.x <= self.max.x
            && self.min.y <= other.max.y
            && other.min.y <= self.max.y
            && self.min.z <= other.max.z
            && other.min.z <= self.max.z
    }

    /// The smallest AABB that contains both.
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether every point of `other` is in this AABB.
    pub fn contains(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    /// The middle, finite for every finite AABB.
    #[inline]
    pub fn centre(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Whether all six numbers are finite and `min` is nowhere above `max`.
    pub fn is_valid(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }
}

/// The largest f32 not above x. Which way the nearest one lies is as good as random, so that a
/// branch on it would be mispredicted half of the time.
#[inline]
pub(crate) fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    let bits = nearest.to_bits();
    let step = i32::from(f64::from(nearest) > x);
    // One less for a positive number, one more for a negative one. Nothing above x is −∞ or, for x
    // of 0, zero; a NaN is above nothing.
    let sign = bits as i32 >> 31;
    f32::from_bits(bits.wrapping_sub(((step ^ sign) - sign) as u32))
}

/// The smallest f32 not below x.
#[inline]
pub(crate) fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

/// The smallest f32 above a finite x.
#[inline]
pub(crate) fn above(x: f64) -> f32 {
    let nearest = x as f32;
    // Without the sign of −0, which is that of no number below 0.
    let bits = (nearest + 0.0).to_bits();
    let step = i32::from(f64::from(nearest) <= x);
    let sign = bits as i32 >> 31;
    f32::from_bits(bits.wrapping_add(((step ^ sign) - sign) as u32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outward_rounding_contains_the_f64_box_and_keeps_f32_values() {
        for x in [0.1, -0.1, 1e-300, -1e-300, 16777217.0, 1.0] {
            let b = Aabb::outward(DVec3::splat(x), DVec3::splat(x));
            assert!(f64::from(b.min.x) <= x && x <= f64::from(b.max.x), "{x}");
        }
        let exact = Aabb::outward(DVec3::ONE, DVec3::ONE);
        assert_eq!(exact.min, exact.max);
    }

    #[test]
    fn rounding_outward_is_to_the_next_float_and_no_farther() {
        let mut bits = 1u64;
        let any = std::iter::repeat_with(|| {
            bits = bits.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            // Exponents of f32 and a little beyond.
            let exponent = 1023 - 160 + (bits >> 54) % 300;
            f64::from_bits(bits << 63 | exponent << 52 | bits >> 12)
        });
        let special = [0.0, -0.0, 1.0, 1e-46, 1e-45, 3e-39, 3.4028236e38, 1e300, f64::INFINITY];
        for x in special.into_iter().flat_map(|x| [x, -x]).chain(any.take(20_000)) {
            let (down, up) = (round_down(x), round_up(x));
            assert!(f64::from(down) <= x && x <= f64::from(up), "{x}");
            assert!(down == up || up == down.next_up(), "{x}: {down} {up}");
            if x.is_finite() {
                let around = Aabb::strictly_outward(DVec3::splat(x), DVec3::splat(x));
                let beside = Aabb::outward(DVec3::splat(x.next_down()), DVec3::splat(x.next_up()));
                assert_eq!(around, beside, "{x}");
                assert!(f64::from(around.min.x) < x && x < f64::from(around.max.x), "{x}");
            }
        }
    }

    #[test]
    fn touching_boxes_overlap_and_the_next_float_does_not() {
        let a = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
        let b = Aabb { min: Vec3::new(1.0, 0.0, 0.0), max: Vec3::splat(2.0) };
        assert!(a.overlaps(&b) && b.overlaps(&a));
        let c = Aabb { min: Vec3::new(1f32.next_up(), 0.0, 0.0), ..b };
        assert!(!a.overlaps(&c) && !c.overlaps(&a));
    }

    #[test]
    fn the_empty_box_is_neutral_and_overlaps_nothing() {
        let a = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
        assert_eq!(a.union(&Aabb::EMPTY), a);
        assert!(!a.overlaps(&Aabb::EMPTY) && !Aabb::EMPTY.overlaps(&Aabb::EMPTY));
    }
}
