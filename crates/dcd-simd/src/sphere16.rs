//! Spheres in f32, one and sixteen side by side.

use crate::{Aabb, Block, Lanes, Row};
use glam::Vec3;

/// A sphere in the world, larger than what it stands for by more than f32 loses where two are compared
/// (docs/numerics/proofs.md, "what is near"). Its radius is infinite where the shape is out of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingSphere {
    /// Metres.
    pub centre: Vec3,
    /// Metres.
    pub radius: f32,
}

impl BoundingSphere {
    /// The sphere of all there is.
    pub const EVERYTHING: Self = Self { centre: Vec3::ZERO, radius: f32::INFINITY };

    /// The AABB round it.
    #[inline]
    pub fn aabb(&self) -> Aabb {
        Aabb { min: self.centre - self.radius, max: self.centre + self.radius }
    }
}

/// Sixteen bounding spheres, component by component.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sphere16 {
    /// Metres.
    pub centre: Block,
    /// Metres.
    pub radius: Row,
}

impl Sphere16 {
    /// Sphere k, which must be below sixteen.
    #[inline]
    pub fn get(&self, k: usize) -> BoundingSphere {
        BoundingSphere { centre: self.centre.point(k), radius: self.radius.0[k] }
    }

    /// Replaces sphere k, which must be below sixteen.
    #[inline]
    pub fn set(&mut self, k: usize, sphere: &BoundingSphere) {
        let Block([x, y, z]) = &mut self.centre;
        [x.0[k], y.0[k], z.0[k]] = sphere.centre.to_array();
        self.radius.0[k] = sphere.radius;
    }

    /// Which spheres meet that of the same number in another row, a bit each: of all others what they
    /// stand for is apart (docs/numerics/proofs.md, "what is near"). For kernels.
    #[inline(always)]
    pub fn meeting<L: Lanes>(&self, l: L, other: &Self) -> u32 {
        let mut squared = l.splat(0.0);
        for axis in 0..3 {
            let (a, b) = (&self.centre.0[axis], &other.centre.0[axis]);
            let difference = l.sub(l.load(a), l.load(b));
            squared = l.add(squared, l.mul(difference, difference));
        }
        let both = l.add(l.load(&self.radius), l.load(&other.radius));
        let reach = l.add(l.mul(both, both), l.splat(f32::MIN_POSITIVE));
        l.bits(l.le(squared, reach))
    }
}
