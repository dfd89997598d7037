//! Axis-aligned bounding boxes in f32.

use glam::{DVec3, Vec3};

/// A closed axis-aligned box in world coordinates, metres. f32, because boxes decide how much
/// memory a broad phase reads; whoever makes one from f64 rounds outward, so that none is lost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Aabb {
    /// The smallest corner.
    pub min: Vec3,
    /// The largest corner, in no component below `min`.
    pub max: Vec3,
}

impl Aabb {
    /// The box of nothing: the neutral element of [`Aabb::union`], overlapping no box.
    pub const EMPTY: Self =
        Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// How far an object may reach along an axis, in metres: a power of two that leaves room to
    /// add two coordinates and to scale them by a rounding bound without overflow in f32.
    pub const LIMIT: f64 = 1.0e37;

    /// The smallest f32 box that contains the f64 one.
    pub fn outward(min: DVec3, max: DVec3) -> Self {
        Self {
            min: Vec3::new(round_down(min.x), round_down(min.y), round_down(min.z)),
            max: Vec3::new(round_up(max.x), round_up(max.y), round_up(max.z)),
        }
    }

    /// Whether the closed boxes share a point: touching counts.
    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.x <= other.max.x
            && other.min.x <= self.max.x
            && self.min.y <= other.max.y
            && other.min.y <= self.max.y
            && self.min.z <= other.max.z
            && other.min.z <= self.max.z
    }

    /// The smallest box that contains both.
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether every point of `other` is in this box.
    pub fn contains(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    /// The middle, finite for every finite box.
    #[inline]
    pub fn centre(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Whether all six numbers are finite and `min` is nowhere above `max`.
    pub fn is_valid(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }
}

fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
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
