//! How far apart or how deep, as one number, and how it changes when the objects move.

use super::contact_set::Extent;
use super::{Accuracy, MeasureAt, depths};
use crate::distance::{self, DistanceResult};
use crate::epa::{self, Direction};
use crate::{Distance, Distances, Method, PairSolver, PosedShape, PosedSupport, Verdict};
use dcd_geom::glam::DVec3;
use dcd_geom::{Shape, ShapeError};

/// The signed distance of two objects, where it is measured, and its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Proximity {
    /// The distance of objects that are apart; less the depth of those that touch. Metres, finite.
    pub signed_distance: f64,
    /// The true one is within `signed_distance ± error_bound`. Metres, finite; `f64::MAX` marks a
    /// number that f64 does not hold.
    pub error_bound: f64,
    /// The direction in which the objects are nearest, or part soonest: from a to b, of unit
    /// length.
    pub normal: DVec3,
    /// The point of a nearest to b, or deepest in it. World frame, metres.
    pub point_a: DVec3,
    /// The point of b nearest to a, or deepest in it.
    pub point_b: DVec3,
    /// How the signed distance changes.
    pub gradient: Gradient,
    /// Whether it has that derivative.
    pub smoothness: Smoothness,
}

/// The derivatives of a signed distance with respect to both poses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gradient {
    /// For a motion of a.
    pub a: Twist,
    /// For a motion of b.
    pub b: Twist,
}

/// The derivative for a motion of one object, the other at rest. World axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// For a translation, per axis: metres a metre.
    pub translation: DVec3,
    /// For a rotation about the origin of the object's own frame, per axis: metres a radian.
    pub rotation: DVec3,
}

/// Whether the signed distance has a derivative at these poses.
///
/// Where it has none, the gradient is that of one of the directions or points that are equally
/// near: a step against it still brings the objects together, or apart, at first order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Smoothness {
    /// Not known: one of the shapes is a cylinder, a cone, or known by its support map alone; or whether
    /// they touch is not known.
    #[default]
    Unknown,
    /// It has, and the gradient is it. Never returned where another direction is as good to within a
    /// billionth of the depth or distance, radii included, or a millionth of a millionth of the pair's
    /// size.
    Smooth,
    /// Faces or edges are parallel, to within a billionth: the points are not the only ones, and
    /// the derivatives for rotations differ with their sense. Those for translations hold.
    ManyPoints,
    /// Several directions part the objects equally soon, to within a billionth of the depth, radii
    /// included; or the objects just touch at an edge or a vertex, to within a millionth of a millionth
    /// of their size.
    ManyDirections,
}

/// The signed distance, with derivatives, of the pairs within a margin: "touching" is "within the
/// margin".
///
/// Costs what [`Distances`] costs where objects are apart, and a little more than
/// [`Depths`](super::Depths) where they touch.
///
/// ```
/// use dcd_geom::glam::DVec3;
/// use dcd_geom::{Pose, Shape};
/// use dcd_gjk::{Proximities, PairSolver, PosedShape, Verdict};
/// let (cube, ball) = (Shape::cuboid(DVec3::ONE)?, Shape::sphere(0.5)?);
/// let pose = Pose::from_translation(DVec3::X * 1.6)?;
/// let (a, b) = (PosedShape { shape: &cube, pose: &Pose::IDENTITY }, PosedShape { shape: &ball, pose: &pose });
/// let Verdict::Touching(found) = Proximities::within(0.2)?.solve(a, b, &mut Default::default()) else {
///     panic!("0.1 m apart");
/// };
/// // Signed: below 0 would be a depth.
/// assert!((found.signed_distance - 0.1).abs() <= found.error_bound);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Proximities {
    distances: Distances,
}

impl Proximities {
    /// Of the pairs within that many metres.
    ///
    /// # Errors
    /// A margin that is negative, not a number, or above [`dcd_geom::Aabb::LIMIT`].
    pub fn within(margin: f64) -> Result<Self, ShapeError> {
        Ok(Self { distances: Distances::within(margin)? })
    }
}

impl PairSolver for Proximities {
    type Answer = Proximity;
    type Scratch = epa::Scratch;

    fn method(&self) -> Method {
        Method::F64
    }

    fn margin(&self) -> f64 {
        self.distances.margin()
    }

    fn solve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut epa::Scratch,
    ) -> Verdict<Proximity> {
        answer(Accuracy::Certified, self.distances.solve(a, b, &mut ()), (a, b), scratch)
    }

    fn measure(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut epa::Scratch,
    ) -> Verdict<Proximity> {
        self.measure_at(Accuracy::Certified, a, b, scratch)
    }
}

impl MeasureAt for Proximities {
    /// Below the accuracy that is certified, [`Smoothness`] is unknown.
    fn measure_at(
        &self,
        accuracy: Accuracy,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut epa::Scratch,
    ) -> Verdict<Proximity> {
        let distance = self.distances.measure_at(accuracy, a, b, &mut ());
        answer(accuracy, distance, (a, b), scratch)
    }
}

/// The answer, from the verdict on the distance; measures the depth of what touches.
fn answer(
    accuracy: Accuracy,
    verdict: Verdict<Option<Distance>>,
    (a, b): (PosedShape<'_>, PosedShape<'_>),
    scratch: &mut epa::Scratch,
) -> Verdict<Proximity> {
    let is_certified = accuracy == Accuracy::Certified;
    match verdict {
        Verdict::Apart => Verdict::Apart,
        Verdict::Undecided(reason) => Verdict::Undecided(reason),
        Verdict::Touching(Some(found)) => {
            let near = Proximity {
                signed_distance: found.distance,
                error_bound: found.error_bound,
                normal: found.normal,
                point_a: found.point_a,
                point_b: found.point_b,
                ..Proximity::default()
            }
            .with_gradient(a, b, is_certified.then(|| across(&found, (a, b), scratch)));
            if found.distance > 0.0 {
                return Verdict::Touching(near);
            }
            match distance::distance(a, b).0 {
                // Perhaps they overlap: the signed distance is as far below 0 as that may be deep.
                DistanceResult::Interval { depth, .. } => {
                    let error_bound = found.error_bound.max(depth);
                    let smoothness = Smoothness::Unknown;
                    Verdict::Touching(Proximity { error_bound, smoothness, ..near })
                }
                _ => Verdict::Touching(near),
            }
        }
        Verdict::Touching(None) => overlapping(accuracy, a, b, scratch),
    }
}

/// Below which gap between two cores, relative to their size, the direction of their distance is
/// looked at twice. Larger: slower. It has to be above ten times what the solver of depths takes for
/// touching, for a pair's size there is up to six times that of the cores.
const NARROW: f64 = 1e-11;

/// Whether the direction of a distance is the only one: nearest points of convex sets lie along one
/// direction, but of cores that barely miss each other at an edge it is an accident.
fn across(
    found: &Distance,
    (a, b): (PosedShape<'_>, PosedShape<'_>),
    scratch: &mut epa::Scratch,
) -> Direction {
    let (Shape::Polytope(in_a), Shape::Polytope(in_b)) = (a.shape, b.shape) else {
        return Direction::Alone;
    };
    let gap = found.distance + in_a.swept_radius() + in_b.swept_radius();
    if gap > NARROW * (in_a.outer_radius() + in_b.outer_radius()) {
        return Direction::Alone;
    }
    let (a, b) = (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
    epa::depth_and_direction(a, b, scratch).1
}

fn overlapping(
    accuracy: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut epa::Scratch,
) -> Verdict<Proximity> {
    let (verdict, direction) = match (a.shape, b.shape) {
        _ if accuracy != Accuracy::Certified => {
            (depths::of_touching(accuracy, a, b, scratch), None)
        }
        (Shape::Polytope(in_a), Shape::Polytope(in_b)) => {
            let (a, b) =
                (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
            let (found, direction) = epa::depth_and_direction(a, b, scratch);
            (Verdict::Touching(found), Some(direction))
        }
        _ => (depths::of_touching(accuracy, a, b, scratch), Some(Direction::Alone)),
    };
    let found = match verdict {
        Verdict::Touching(found) => found,
        Verdict::Apart => return Verdict::Apart,
        Verdict::Undecided(reason) => return Verdict::Undecided(reason),
    };
    let touching = Proximity {
        signed_distance: -found.depth,
        error_bound: found.error_bound,
        normal: found.normal,
        point_a: found.point_a,
        point_b: found.point_b,
        ..Proximity::default()
    };
    Verdict::Touching(touching.with_gradient(a, b, direction))
}

impl Proximity {
    /// A point x that moves with an object moves by δt + δω × (x − t); the signed distance changes
    /// by the normal's part of that, for neither the normal's own change nor the points' along
    /// their features counts at first order (docs/numerics/proofs.md, "derivatives").
    ///
    /// Without a direction the smoothness is unknown.
    fn with_gradient(
        self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        direction: Option<Direction>,
    ) -> Self {
        let Self { normal, point_a, point_b, .. } = self;
        let turning =
            |point: DVec3, side: PosedShape<'_>| (point - side.pose.translation()).cross(normal);
        let gradient = Gradient {
            a: Twist { translation: -normal, rotation: -turning(point_a, a) },
            b: Twist { translation: normal, rotation: turning(point_b, b) },
        };
        let Some(direction) = direction else { return Self { gradient, ..self } };
        let smoothness = match (direction, Extent::of(a, normal), Extent::of(b, -normal)) {
            (_, None, _) | (_, _, None) => Smoothness::Unknown,
            (Direction::Rivalled, ..) => Smoothness::ManyDirections,
            (Direction::Alone, Some(in_a), Some(in_b)) => {
                if in_a.meets_in_one_point(&in_b) {
                    Smoothness::Smooth
                } else {
                    Smoothness::ManyPoints
                }
            }
        };
        Self { gradient, smoothness, ..self }
    }
}
