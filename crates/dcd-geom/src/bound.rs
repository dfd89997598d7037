//! Balls and boxes that cost nothing per vertex.

use crate::{Aabb, Ball, Pose, Shape};
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

/// A ball in the world, larger than what it stands for by more than f32 loses where two are compared
/// (docs/numerics.md, "what is near"). Its radius is infinite where the shape is out of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LooseBall {
    /// Metres.
    pub centre: Vec3,
    /// Metres.
    pub radius: f32,
}

impl LooseBall {
    /// The ball of all there is.
    pub const EVERYTHING: Self = Self { centre: Vec3::ZERO, radius: f32::INFINITY };

    /// The box round it.
    #[inline]
    pub fn aabb(&self) -> Aabb {
        Aabb { min: self.centre - self.radius, max: self.centre + self.radius }
    }
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
/// vertex, some ten for what is rounded up, of a size at most twice the reach. Smaller: such a box
/// could stand out of this one, and balls that do not meet be taken for a contact. Larger: more is
/// near, and less is proved to touch.
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

    /// No [`Bound::ball`] has a larger radius at a pose whose translation has no coordinate beyond
    /// `within`, metres.
    pub fn largest_ball(&self, within: f64) -> f32 {
        let stretch = 1.0 + 8.0 * Pose::UNIT_TOLERANCE;
        let margin = MARGIN * (within + self.reach * stretch) + f64::from(f32::MIN_POSITIVE);
        ((self.ball.radius * stretch + margin) as f32).next_up()
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use std::sync::Arc;

    fn shapes() -> Vec<Shape> {
        let far = DVec3::new(1e4, -3e3, 20.0);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let hull = Shape::hull(corners.map(|v| v + far).to_vec()).unwrap();
        let place = Pose::new(DQuat::from_rotation_y(0.3), DVec3::new(0.0, 9.0, 1.0)).unwrap();
        vec![
            hull.clone(),
            hull.clone().rounded(0.25).unwrap(),
            Shape::sphere(1e-30).unwrap(),
            Shape::cuboid(DVec3::new(3.0, 0.1, 1e-9)).unwrap(),
            Shape::cylinder(1.0, 0.2).unwrap(),
            Shape::cone(0.4, 2.0).unwrap(),
            Shape::mesh(corners.to_vec(), vec![[0, 1, 2], [1, 2, 3]]).unwrap(),
            Shape::custom(Arc::new(polytope())).unwrap(),
            Shape::compound(vec![(hull, place), (Shape::cone(1.0, 1.0).unwrap(), place)]).unwrap(),
        ]
    }

    fn polytope() -> crate::Polytope {
        crate::Polytope::hull(vec![DVec3::X, DVec3::Y * 3.0, DVec3::Z]).unwrap()
    }

    #[test]
    fn it_holds_the_box_of_every_shape_at_every_pose() {
        let turns = [0.0, 0.1, 1.0, 2.0, 3.0]
            .map(|angle| DQuat::from_rotation_x(angle) * DQuat::from_rotation_z(0.7 * angle));
        let places =
            [DVec3::ZERO, DVec3::new(-1e4, 3e3, -20.0), DVec3::splat(1e-20), DVec3::X * 1e30];
        for shape in shapes() {
            let bound = Bound::of(&shape).unwrap();
            for (turn, place) in turns.iter().flat_map(|q| places.map(|t| (*q, t))) {
                let pose = Pose::new(turn, place).unwrap();
                let (loose, tight) = (bound.aabb(&pose), shape.aabb(&pose));
                assert!(loose.contains(&tight), "{shape:?} at {pose:?}: {loose:?}, {tight:?}");
                let swept = shape.swept(0.5).unwrap().aabb(&pose);
                assert!(bound.swept(0.5).aabb(&pose).contains(&swept), "{shape:?} at {pose:?}");
            }
        }
    }

    #[test]
    fn the_largest_ball_is_as_large_as_any_within_that_far() {
        for bound in shapes().iter().filter_map(Bound::of) {
            for place in [DVec3::ZERO, DVec3::new(-1e4, 3e3, -20.0), DVec3::X * 1e30] {
                let turn = DQuat::from_rotation_x(0.7);
                let ball = bound.ball(&Pose::new(turn, place).unwrap());
                let within = place.abs().max_element();
                assert!(ball.radius <= bound.largest_ball(within), "{bound:?} at {place}");
            }
        }
    }

    fn places() -> impl Iterator<Item = Pose> {
        let turn = |k: u32| DQuat::from_rotation_x(f64::from(k)) * DQuat::from_rotation_z(0.7);
        let place = |k: u32| DVec3::new(f64::from(k), -0.3, 1e3 * f64::from(k % 3));
        (0..9).map(move |k| Pose::new(turn(k), place(k)).unwrap())
    }

    #[test]
    fn an_inner_ball_reaches_no_farther_than_its_shape_in_any_direction() {
        let directions = (0..500).map(|k| {
            let t = f64::from(k);
            DVec3::new(t.sin(), (t * 0.73).cos(), (t * 0.37).sin()).normalize()
        });
        let mut known = 0;
        for (shape, pose) in shapes().iter().flat_map(|shape| places().map(move |p| (shape, p))) {
            let bound = Bound::of(shape).unwrap();
            let (loose, best) = (bound.ball(&pose), bound.inner_ball(&pose));
            let concentric = bound.concentric(&loose);
            assert!(concentric.radius <= best.radius && concentric.centre == loose.centre);
            known += usize::from(concentric.radius > 0.0);
            // A box is the reach along six directions, and those of a turned shape along others.
            for d in directions.clone() {
                let turned = Pose::new(DQuat::from_rotation_arc(d, DVec3::X), DVec3::ZERO).unwrap();
                let whole = Pose::from_matrix(
                    *turned.rotation() * *pose.rotation(),
                    *turned.rotation() * pose.translation(),
                );
                let reach = f64::from(shape.aabb(&whole.unwrap()).max.x);
                for ball in [best, concentric] {
                    let far = d.dot(ball.centre.as_dvec3()) + f64::from(ball.radius);
                    assert!(far <= reach, "{ball:?} of {shape:?} at {pose:?} along {d}");
                }
            }
        }
        assert!(known > 10, "{known}");
    }

    #[test]
    fn balls_that_just_miss_are_short_of_meeting_and_those_that_overlap_are_not() {
        let at = |x: f32, radius| SnugBall { centre: Vec3::X * x, radius };
        for size in [1e-15, 1e-6, 1.0, 1e6, 1e15] {
            let ball = at(3.0 * size, size);
            assert!(ball.short_of(&at(0.0, 1.999 * size)) > 0.0);
            assert!(ball.short_of(&at(0.0, 2.001 * size)) <= 0.0);
        }
        // No ball of negative radius meets any but one that holds its centre by more.
        assert!(at(0.0, -1.0).short_of(&at(0.0, -1.0)) > 0.0);
        assert!(at(0.0, -1.0).short_of(&at(0.0, 0.5)) > 0.0);
        assert!(at(0.0, -1.0).short_of(&at(0.5, 2.0)) <= 0.0);
        for other in [at(0.0, 1e30), at(f32::NAN, 1.0), at(0.0, f32::NAN), SnugBall::NOTHING] {
            let short_of = SnugBall::NOTHING.short_of(&other);
            assert!(short_of > 0.0 || short_of.is_nan(), "{other:?}");
        }
    }

    #[test]
    fn of_what_is_known_by_its_surface_or_its_map_alone_no_inner_ball_is_known() {
        for shape in shapes() {
            let bound = Bound::of(&shape).unwrap();
            let ball = bound.inner_ball(&Pose::IDENTITY);
            let is_solid = !matches!(shape, Shape::Mesh(_) | Shape::Custom(_));
            assert_eq!(ball.radius > f32::NEG_INFINITY, is_solid, "{shape:?}");
        }
        let far = Pose::from_translation(DVec3::X * 1e200).unwrap();
        let bound = Bound::of(&Shape::sphere(1.0).unwrap()).unwrap();
        assert_eq!(bound.inner_ball(&far).radius, f32::NEG_INFINITY);
    }

    #[test]
    fn it_is_no_larger_than_a_ball_needs() {
        let bound = Bound::of(&Shape::sphere(2.0).unwrap()).unwrap();
        let aabb = bound.aabb(&Pose::from_translation(DVec3::X * 3.0).unwrap());
        assert!(aabb.max.x < 5.0001 && aabb.min.x > 0.9999);
    }

    #[test]
    fn what_has_no_end_has_no_bound_and_what_is_out_of_range_is_everywhere() {
        assert_eq!(Bound::of(&Shape::half_space(DVec3::Z, 0.0).unwrap()), None);
        let bound = Bound::of(&Shape::sphere(1.0).unwrap()).unwrap();
        let far = Pose::from_translation(DVec3::X * 1e200).unwrap();
        assert_eq!(bound.aabb(&far), Aabb::EVERYTHING);
    }
}
