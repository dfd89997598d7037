//! Spheres and AABBs that cost nothing per vertex.

mod packed;
#[cfg(test)]
mod tests;

pub use packed::PackedSphereBounds;

use crate::{Aabb, BoundingSphere, Pose, Shape, Sphere};
use glam::{DVec3, Vec3};

/// A sphere round a shape and one inside it, at any pose without the shape's vertices. What the outer
/// one does not reach is not near, larger than [`Shape::aabb`] as its AABB is; what the inner one
/// reaches is touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereBounds {
    /// In the shape's own frame, metres.
    sphere: Sphere,
    /// Inside the shape, in the same frame; of a radius of −∞ where no point of it is known.
    inner: Sphere,
    /// The radius of a sphere about the outer one's centre inside the inner one, below 0 where the
    /// centre is outside of it.
    inner_at_centre: f64,
    /// A bound on the distance of any of its points from the frame's origin.
    reach: f64,
}

/// A sphere in the world inside of what it stands for, smaller by more than f32 loses where two are
/// compared (docs/numerics/proofs.md, "what is near"). Its radius is below 0 where that is more than there
/// is, and −∞ where nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InscribedSphere {
    /// Metres.
    pub centre: Vec3,
    /// Metres.
    pub radius: f32,
}

impl InscribedSphere {
    /// The sphere of what is not known.
    pub const NOTHING: Self = Self { centre: Vec3::ZERO, radius: f32::NEG_INFINITY };

    /// How far two are from meeting, square metres: the less, the nearer. Where it is **not above 0**
    /// what they stand for has a common point; a NaN is above.
    #[inline]
    pub fn short_of(&self, other: &Self) -> f32 {
        let Vec3 { x, y, z } = self.centre - other.centre;
        let both = self.radius + other.radius;
        // Summed in this order on every CPU. What underflows is below the least normal number.
        x * x + y * y + z * z + f32::MIN_POSITIVE - both * both.abs()
    }
}

/// By how much the AABB is larger than the sphere, and the inner sphere smaller than it could be. Unit:
/// metres a metre of the reach and of the translation.
///
/// Several times what f32 loses in an AABB of vertices rotated in f32: twice 5.01 units of 2⁻²⁴ for a
/// vertex, some ten for what is rounded up, of a size at most twice the reach, and eleven of the reach
/// for a sphere's centre posed in f32. Smaller: such an AABB could stand out of this one, and spheres that
/// do not meet be taken for a contact. Larger: more is near, and less is proved to touch.
const MARGIN: f64 = 1.0 / (1 << 16) as f64;

impl SphereBounds {
    /// The bounds of a shape; `None` if it is infinite.
    pub fn of(shape: &Shape) -> Option<Self> {
        let inner = shape.inner();
        let (sphere, inner) = match shape {
            Shape::HalfSpace(_) => return None,
            Shape::Polytope(polytope) => {
                let swept = polytope.swept_radius();
                (around(polytope.vertices(), swept), larger(inner, swept))
            }
            Shape::Curved(curved) => {
                let sphere = Sphere { centre: DVec3::ZERO, radius: shape.reach() };
                (sphere, larger(inner, curved.swept_radius()))
            }
            Shape::Ellipsoid(ellipsoid) => {
                let sphere = Sphere { centre: DVec3::ZERO, radius: shape.reach() };
                (sphere, larger(inner, ellipsoid.swept_radius()))
            }
            Shape::Mesh(mesh) => (around(mesh.points(), mesh.swept_radius()), UNKNOWN),
            Shape::Custom(_) => (Sphere { centre: DVec3::ZERO, radius: shape.reach() }, UNKNOWN),
            Shape::Compound(compound) => {
                let parts = compound.parts().iter().map(|part| Self::of(part.placed()));
                round_all(middle(shape), parts)
            }
        };
        let reach = sphere.centre.length() + sphere.radius;
        let inner_at_centre = inner.radius - inner.centre.distance(sphere.centre);
        reach.is_finite().then_some(Self { sphere, inner, inner_at_centre, reach })
    }

    /// The bounds with a sphere of this radius swept round the shape, metres. What is inside of the shape is left
    /// as it is.
    pub fn swept(self, by: f64) -> Self {
        Self { sphere: larger(self.sphere, by), reach: self.reach + by, ..self }
    }

    /// An AABB that contains [`Shape::aabb`], and every other AABB of the shape that is exact up to
    /// what f32 loses. The infinite one where the shape reaches beyond [`Aabb::LIMIT`].
    #[inline]
    pub fn aabb(&self, pose: &Pose) -> Aabb {
        self.sphere(pose).aabb()
    }

    /// A sphere that contains the shape. Infinite where the shape reaches beyond [`Aabb::LIMIT`].
    #[inline]
    pub fn sphere(&self, pose: &Pose) -> BoundingSphere {
        let stretch = 1.0 + pose.deviation();
        let t = pose.translation();
        let reach = t.abs().max_element() + self.reach * stretch;
        // Written so that NaN is out of range.
        if !(reach <= Aabb::LIMIT) {
            return BoundingSphere::EVERYTHING;
        }
        let centre = (*pose.rotation() * self.sphere.centre + t).as_vec3();
        let margin = MARGIN * reach + f64::from(f32::MIN_POSITIVE);
        BoundingSphere { centre, radius: (self.sphere.radius * stretch + margin) as f32 }
    }

    /// A sphere inside the shape, about the best centre that is known.
    pub fn inner_sphere(&self, pose: &Pose) -> InscribedSphere {
        let centre = (*pose.rotation() * self.inner.centre + pose.translation()).as_vec3();
        InscribedSphere { centre, ..self.inside(&self.sphere(pose), self.inner.radius) }
    }

    /// What is left of it about the centre of [`SphereBounds::sphere`], given that: no second centre has to be
    /// turned.
    #[inline]
    pub fn concentric(&self, sphere: &BoundingSphere) -> InscribedSphere {
        self.inside(sphere, self.inner_at_centre)
    }

    /// As much smaller than that radius as the bounding sphere is larger than it need be.
    #[inline]
    fn inside(&self, sphere: &BoundingSphere, radius: f64) -> InscribedSphere {
        let both = (radius + self.sphere.radius) as f32;
        InscribedSphere { centre: sphere.centre, radius: both - sphere.radius }
    }

    /// Neither [`SphereBounds::sphere`] nor [`PackedSphereBounds::spheres`] has a larger radius at a pose
    /// whose translation has no coordinate beyond `within`, metres.
    pub fn largest_sphere(&self, within: f64) -> f32 {
        let stretch = 1.0 + 8.0 * Pose::UNIT_TOLERANCE;
        let margin = MARGIN * (within + self.reach * stretch) + f64::from(f32::MIN_POSITIVE);
        // A power of two more than the six roundings of a radius in f32.
        ((self.sphere.radius * stretch + margin) * (1.0 + 4.0 * f64::from(f32::EPSILON))) as f32
    }
}

/// Inside of a shape of which nothing is known to be inside.
const UNKNOWN: Sphere = Sphere { centre: DVec3::ZERO, radius: f64::NEG_INFINITY };

fn larger(sphere: Sphere, by: f64) -> Sphere {
    Sphere { radius: sphere.radius + by, ..sphere }
}

/// Round points and what is swept round them.
fn around(points: &[DVec3], swept: f64) -> Sphere {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = points.iter().fold(none, |(min, max), &v| (min.min(v), max.max(v)));
    larger(Sphere::around(min * 0.5 + max * 0.5, points), swept)
}

/// Round all parts, about that centre, and inside the roundest of them.
fn round_all(centre: DVec3, parts: impl Iterator<Item = Option<SphereBounds>>) -> (Sphere, Sphere) {
    let (mut sphere, mut inner) = (Sphere { centre, radius: 0.0 }, UNKNOWN);
    for part in parts {
        let reach = |part: &SphereBounds| part.sphere.centre.distance(centre) + part.sphere.radius;
        sphere.radius = sphere.radius.max(part.as_ref().map_or(f64::INFINITY, reach));
        if let Some(part) = part.filter(|part| part.inner.radius > inner.radius) {
            inner = part.inner;
        }
    }
    (sphere, inner)
}

/// The middle of a shape's AABB in its own frame.
fn middle(shape: &Shape) -> DVec3 {
    shape.aabb(&Pose::IDENTITY).centre().as_dvec3()
}
