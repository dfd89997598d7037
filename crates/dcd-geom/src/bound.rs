//! Balls and boxes that cost nothing per vertex.

mod bounds;
#[cfg(test)]
mod tests;

pub use bounds::Bounds;

use crate::{Aabb, Ball, LooseBall, Pose, Shape};
use glam::{DVec3, Vec3};

/// A ball round a shape and one inside it, at any pose without the shape's vertices. What the outer
/// one does not reach is not near, larger than [`Shape::aabb`] as its box is; what the inner one
/// reaches is touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// In the shape's own frame, metres.
    ball: Ball,
    /// Inside the shape, in the same frame; of a radius of −∞ where no point of it is known.
    inner: Ball,
    /// The radius of a ball about the outer one's centre inside the inner one, below 0 where the
    /// centre is outside of it.
    inner_at_centre: f64,
    /// A bound on the distance of any of its points from the frame's origin.
    reach: f64,
}

/// A ball in the world inside of what it stands for, smaller by more than f32 loses where two are
/// compared (docs/numerics.md, "what is near"). Its radius is below 0 where that is more than there
/// is, and −∞ where nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SnugBall {
    /// Metres.
    pub centre: Vec3,
    /// Metres.
    pub radius: f32,
}

impl SnugBall {
    /// The ball of what is not known.
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

/// By how much the box is larger than the ball, and the inner ball smaller than it could be. Unit:
/// metres a metre of the reach and of the translation.
///
/// Several times what f32 loses in a box of vertices rotated in f32: twice 5.01 units of 2⁻²⁴ for a
/// vertex, some ten for what is rounded up, of a size at most twice the reach, and eleven of the reach
/// for a ball's centre posed in f32. Smaller: such a box could stand out of this one, and balls that
/// do not meet be taken for a contact. Larger: more is near, and less is proved to touch.
const MARGIN: f64 = 1.0 / (1 << 16) as f64;

impl Bound {
    /// Of a shape that has an end in every direction.
    pub fn of(shape: &Shape) -> Option<Self> {
        let inner = shape.inner();
        let (ball, inner) = match shape {
            Shape::HalfSpace(_) => return None,
            Shape::Polytope(polytope) => {
                let swept = polytope.swept_radius();
                (around(polytope.vertices(), swept), larger(inner, swept))
            }
            Shape::Curved(curved) => {
                let ball = Ball { centre: DVec3::ZERO, radius: shape.reach() };
                (ball, larger(inner, curved.swept_radius()))
            }
            Shape::Mesh(mesh) => (around(mesh.points(), mesh.swept_radius()), UNKNOWN),
            Shape::Custom(_) => (Ball { centre: DVec3::ZERO, radius: shape.reach() }, UNKNOWN),
            Shape::Compound(compound) => {
                let parts = compound.parts().iter().map(|part| Self::of(part.placed()));
                round_all(middle(shape), parts)
            }
        };
        let reach = ball.centre.length() + ball.radius;
        let inner_at_centre = inner.radius - inner.centre.distance(ball.centre);
        reach.is_finite().then_some(Self { ball, inner, inner_at_centre, reach })
    }

    /// With a ball of this radius swept round the shape, metres. What is inside of the shape is left
    /// as it is.
    pub fn swept(self, by: f64) -> Self {
        Self { ball: larger(self.ball, by), reach: self.reach + by, ..self }
    }

    /// A box that contains [`Shape::aabb`], and every other box of the shape that is exact up to
    /// what f32 loses. The infinite one where the shape reaches beyond [`Aabb::LIMIT`].
    #[inline]
    pub fn aabb(&self, pose: &Pose) -> Aabb {
        self.ball(pose).aabb()
    }

    /// A ball that contains the shape. Infinite where the shape reaches beyond [`Aabb::LIMIT`].
    #[inline]
    pub fn ball(&self, pose: &Pose) -> LooseBall {
        let stretch = 1.0 + pose.deviation();
        let t = pose.translation();
        let reach = t.abs().max_element() + self.reach * stretch;
        // Written so that NaN is out of range.
        if !(reach <= Aabb::LIMIT) {
            return LooseBall::EVERYTHING;
        }
        let centre = (*pose.rotation() * self.ball.centre + t).as_vec3();
        let margin = MARGIN * reach + f64::from(f32::MIN_POSITIVE);
        LooseBall { centre, radius: (self.ball.radius * stretch + margin) as f32 }
    }

    /// A ball inside the shape, about the best centre that is known.
    pub fn inner_ball(&self, pose: &Pose) -> SnugBall {
        let centre = (*pose.rotation() * self.inner.centre + pose.translation()).as_vec3();
        SnugBall { centre, ..self.inside(&self.ball(pose), self.inner.radius) }
    }

    /// What is left of it about the centre of [`Bound::ball`], given that: no second centre has to be
    /// turned.
    #[inline]
    pub fn concentric(&self, ball: &LooseBall) -> SnugBall {
        self.inside(ball, self.inner_at_centre)
    }

    /// As much smaller than that radius as the loose ball is larger than it need be.
    #[inline]
    fn inside(&self, ball: &LooseBall, radius: f64) -> SnugBall {
        let both = (radius + self.ball.radius) as f32;
        SnugBall { centre: ball.centre, radius: both - ball.radius }
    }

    /// Neither [`Bound::ball`] nor [`Bounds::balls`] has a larger radius at a pose whose translation has
    /// no coordinate beyond `within`, metres.
    pub fn largest_ball(&self, within: f64) -> f32 {
        let stretch = 1.0 + 8.0 * Pose::UNIT_TOLERANCE;
        let margin = MARGIN * (within + self.reach * stretch) + f64::from(f32::MIN_POSITIVE);
        // A power of two more than the six roundings of a radius in f32.
        ((self.ball.radius * stretch + margin) * (1.0 + 4.0 * f64::from(f32::EPSILON))) as f32
    }
}

/// Inside of a shape of which nothing is known to be inside.
const UNKNOWN: Ball = Ball { centre: DVec3::ZERO, radius: f64::NEG_INFINITY };

fn larger(ball: Ball, by: f64) -> Ball {
    Ball { radius: ball.radius + by, ..ball }
}

/// Round points and what is swept round them.
fn around(points: &[DVec3], swept: f64) -> Ball {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = points.iter().fold(none, |(min, max), &v| (min.min(v), max.max(v)));
    larger(Ball::around(min * 0.5 + max * 0.5, points), swept)
}

/// Round all parts, about that centre, and inside the roundest of them.
fn round_all(centre: DVec3, parts: impl Iterator<Item = Option<Bound>>) -> (Ball, Ball) {
    let (mut ball, mut inner) = (Ball { centre, radius: 0.0 }, UNKNOWN);
    for part in parts {
        let reach = |part: &Bound| part.ball.centre.distance(centre) + part.ball.radius;
        ball.radius = ball.radius.max(part.as_ref().map_or(f64::INFINITY, reach));
        if let Some(part) = part.filter(|part| part.inner.radius > inner.radius) {
            inner = part.inner;
        }
    }
    (ball, inner)
}

/// The middle of a shape's box in its own frame.
fn middle(shape: &Shape) -> DVec3 {
    shape.aabb(&Pose::IDENTITY).centre().as_dvec3()
}
