//! Boxes that cost nothing per vertex.

use crate::{Aabb, Ball, Pose, Shape};
use glam::{DVec3, Vec3};

/// A ball round a shape, from which a box follows at any pose without the shape's vertices: larger
/// than [`Shape::aabb`], and enough to know that nothing is near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// In the shape's own frame, metres.
    ball: Ball,
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

/// By how much the box is larger than the ball. Unit: metres a metre of the reach and of the
/// translation.
///
/// Several times what f32 loses in a box of vertices rotated in f32: twice 5.01 units of 2⁻²⁴ for a
/// vertex, some ten for what is rounded up, of a size at most twice the reach. Smaller: such a box
/// could stand out of this one. Larger: more is near.
const MARGIN: f64 = 1.0 / (1 << 16) as f64;

impl Bound {
    /// Of a shape that has an end in every direction.
    pub fn of(shape: &Shape) -> Option<Self> {
        let ball = match shape {
            Shape::HalfSpace(_) => return None,
            Shape::Polytope(polytope) => around(polytope.vertices(), polytope.swept_radius()),
            Shape::Mesh(mesh) => around(mesh.points(), mesh.swept_radius()),
            Shape::Compound(compound) => {
                let centre = middle(shape);
                let parts = compound.parts().iter().map(|part| Self::of(part.placed()));
                let reach = |bound: Self| bound.ball.centre.distance(centre) + bound.ball.radius;
                let radius =
                    parts.map(|bound| bound.map_or(f64::INFINITY, reach)).fold(0.0, f64::max);
                Ball { centre, radius }
            }
            Shape::Curved(_) | Shape::Custom(_) => {
                Ball { centre: DVec3::ZERO, radius: shape.reach() }
            }
        };
        let reach = ball.centre.length() + ball.radius;
        reach.is_finite().then_some(Self { ball, reach })
    }

    /// With a ball of this radius swept round the shape, metres.
    pub fn swept(self, by: f64) -> Self {
        let ball = Ball { radius: self.ball.radius + by, ..self.ball };
        Self { ball, reach: self.reach + by }
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

    /// No [`Bound::ball`] has a larger radius at a pose whose translation has no coordinate beyond
    /// `within`, metres.
    pub fn largest_ball(&self, within: f64) -> f32 {
        let stretch = 1.0 + 8.0 * Pose::UNIT_TOLERANCE;
        let margin = MARGIN * (within + self.reach * stretch) + f64::from(f32::MIN_POSITIVE);
        ((self.ball.radius * stretch + margin) as f32).next_up()
    }
}

/// Round points and what is swept round them.
fn around(points: &[DVec3], swept: f64) -> Ball {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = points.iter().fold(none, |(min, max), &v| (min.min(v), max.max(v)));
    let ball = Ball::around(min * 0.5 + max * 0.5, points);
    Ball { radius: ball.radius + swept, ..ball }
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
