//! How far apart the pairs within a margin are.

use super::{Accuracy, MeasureAt, check_margin, few_parts};
use crate::UNIT;
use crate::closed;
use crate::distance::{Distance, DistanceResult, distance, distance_at};
use crate::mesh::Limited;
use crate::{Method, PairSolver, PosedShape, Verdict, certified, mesh, order};
use dcd_geom::{Aabb, Shape, ShapeError, Sphere};

/// How far apart pairs are, and between which points, for those within a margin: "touching" is
/// "within the margin".
///
/// The answer of each pair is its [`Distance`], or `None` where the pair shares a point: its distance is 0.
/// A distance of 0 with a bound means that f64 cannot decide whether the pair touches, and that it is surely
/// within the margin.
/// Between polytopes, rounded or not, nothing is undecided, and the distance is right in twelve
/// digits; with another shape see [`crate::distance::in_f64`]. Costs a few microseconds a pair
/// within the margin, and for most others a comparison of two spheres.
///
/// ```
/// use dcd_geom::glam::DVec3;
/// use dcd_geom::{Pose, Shape};
/// use dcd_gjk::{Distances, PairSolver, PosedShape, Verdict};
/// let (cube, ball) = (Shape::cuboid(DVec3::ONE)?, Shape::sphere(0.5)?);
/// let pose = Pose::from_translation(DVec3::X * 1.6)?;
/// let (a, b) = (PosedShape { shape: &cube, pose: &Pose::IDENTITY }, PosedShape { shape: &ball, pose: &pose });
/// let Verdict::Touching(Some(found)) = Distances::within(0.2)?.solve(a, b, &mut Default::default()) else {
///     panic!("0.1 m apart");
/// };
/// assert!((found.distance - 0.1).abs() <= found.error_bound);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Distances {
    margin: f64,
}

impl Distances {
    /// Of the pairs within that many metres.
    ///
    /// # Errors
    /// A margin that is negative, not a number, or above [`Aabb::LIMIT`].
    pub fn within(margin: f64) -> Result<Self, ShapeError> {
        check_margin(margin)?;
        Ok(Self { margin })
    }
}

impl PairSolver for Distances {
    type Answer = Option<Distance>;
    type Scratch = ();

    fn method(&self) -> Method {
        Method::F64
    }

    fn margin(&self) -> f64 {
        self.margin
    }

    fn solve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut (),
    ) -> Verdict<Self::Answer> {
        self.resolve(a, b, scratch).0
    }

    fn measure(&self, a: PosedShape<'_>, b: PosedShape<'_>, (): &mut ()) -> Verdict<Self::Answer> {
        self.measure_at(Accuracy::Certified, a, b, &mut ())
    }

    fn resolve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        (): &mut (),
    ) -> (Verdict<Self::Answer>, Method) {
        if spheres_are_apart(a, b, self.margin) {
            return (Verdict::Apart, Method::F64);
        }
        let (found, method) = distance(a, b);
        (within_margin(found, self.margin, a, b), method)
    }
}

impl MeasureAt for Distances {
    fn measure_at(
        &self,
        accuracy: Accuracy,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        (): &mut (),
    ) -> Verdict<Self::Answer> {
        match distance_at(accuracy, a, b).0 {
            DistanceResult::Apart(found) => Verdict::Touching(Some(found)),
            DistanceResult::Touching => Verdict::Touching(None),
            // What touches has no distance, whatever f64 knows of it.
            DistanceResult::Interval { .. } if self.margin == 0.0 => Verdict::Touching(None),
            DistanceResult::Interval { within, .. } => Verdict::Touching(Some(within)),
            DistanceResult::Undecided(reason) => Verdict::Undecided(reason),
        }
    }
}

/// The distance of two spheres; at the accuracies of f32 and f64 also of a sphere, a half-space or a compound of few parts and another;
/// at that of f32 also of a mesh and another that is no mesh, and of a capsule and a capsule or cuboid. `None` of others, and where that
/// leaves open whether they touch.
#[inline]
pub(crate) fn distance_at_once(
    at: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> Option<DistanceResult> {
    if let Some(found) = distance_of_two_spheres(at, a, b) {
        return Some(found);
    }
    if at == Accuracy::Certified {
        return None;
    }
    match (a.shape, b.shape) {
        (Shape::Mesh(_), Shape::Compound(_) | Shape::Mesh(_))
        | (Shape::Compound(_), Shape::Mesh(_)) => known(distance_of_mesh(at, [a, b], f64::MAX)?),
        (Shape::Compound(_), _) | (_, Shape::Compound(_)) => {
            few_parts::distance(at, [a, b]).map(DistanceResult::Apart)
        }
        (Shape::HalfSpace(_), _) | (_, Shape::HalfSpace(_)) => closed::level::distance(at, a, b),
        (Shape::Mesh(_), _) | (_, Shape::Mesh(_)) => known(distance_of_mesh(at, [a, b], f64::MAX)?),
        _ => closed::gap(at, a, b)?.distance(),
    }
}

/// Of two spheres round the origins of their own frames; `None` of others, and where that leaves open whether they touch.
#[inline]
fn distance_of_two_spheres(
    at: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> Option<DistanceResult> {
    let [of_a, of_b] = closed::two_spheres(a, b)?;
    let sharp = closed::sharp_of(at);
    if order::is_swapped(a, b) {
        closed::distance_of_spheres([of_b, of_a], sharp).map(DistanceResult::mirrored)
    } else {
        closed::distance_of_spheres([of_a, of_b], sharp)
    }
}

/// The distance of a mesh and another shape that is bounded, where it is below `far`: metres.
pub(crate) fn distance_of_mesh_within(
    at: Accuracy,
    [a, b]: [PosedShape<'_>; 2],
    far: f64,
) -> (Limited, Method) {
    if at != Accuracy::Certified
        && let Some(found) = distance_of_mesh(at, [a, b], far)
    {
        return (found, Method::F64);
    }
    let at = if at == Accuracy::F32 { Accuracy::F64 } else { at };
    mesh::nearer_than((far, at), [a, b], &mut mesh::Scratch::default())
}

/// The same at the accuracies of f32 and f64 of a mesh and a sphere; at that of f32 also of a mesh and another one, another convex
/// shape that is bounded, or a compound.
#[inline(never)]
fn distance_of_mesh(at: Accuracy, sides: [PosedShape<'_>; 2], far: f64) -> Option<Limited> {
    let [a, b] = sides;
    let of_sphere = closed::centred::distance(at, a, b).map(Limited::Known);
    let in_f32 = || if at == Accuracy::F32 { mesh::distance_in_f32(sides, far) } else { None };
    of_sphere.or_else(in_f32)
}

/// What is known where every distance matters.
fn known(found: Limited) -> Option<DistanceResult> {
    match found {
        Limited::Known(found) => Some(found),
        Limited::Beyond => None,
    }
}

/// The verdict on two shapes of that distance for a margin. Where the bounds leave it open, the exact methods
/// decide.
pub(crate) fn within_margin(
    found: DistanceResult,
    margin: f64,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> Verdict<Option<Distance>> {
    match found {
        DistanceResult::Touching => Verdict::Touching(None),
        DistanceResult::Undecided(reason) => Verdict::Undecided(reason),
        DistanceResult::Apart(found) if found.lower() > margin => Verdict::Apart,
        DistanceResult::Apart(found) if found.upper() <= margin => Verdict::Touching(Some(found)),
        DistanceResult::Interval { within, .. } if within.upper() <= margin => {
            Verdict::Touching(Some(within))
        }
        DistanceResult::Apart(found) | DistanceResult::Interval { within: found, .. } => {
            match are_within(a, b, margin) {
                Verdict::Touching(()) => Verdict::Touching(Some(found)),
                Verdict::Apart => Verdict::Apart,
                Verdict::Undecided(reason) => Verdict::Undecided(reason),
            }
        }
    }
}

/// Whether two shapes are within a margin where the bounds of their distance leave it open: whether
/// the same shapes touch, each grown by half the margin.
pub(super) fn are_within(a: PosedShape<'_>, b: PosedShape<'_>, margin: f64) -> Verdict<()> {
    match (a.shape.swept(margin / 2.0), b.shape.swept(margin / 2.0)) {
        (Ok(in_a), Ok(in_b)) => {
            let (a, b) = (PosedShape { shape: &in_a, ..a }, PosedShape { shape: &in_b, ..b });
            certified::overlap_of(a, b).0
        }
        // A radius that overflows reaches everywhere.
        _ => Verdict::Touching(()),
    }
}

/// Whether spheres round two shapes prove that they are farther apart than `margin`.
///
/// The centres and their difference lose at most 8u of everything that is added up, the radii's
/// sum 4u; 16u and 8u cover them. NaN and overflow prove nothing.
pub(crate) fn spheres_are_apart(a: PosedShape<'_>, b: PosedShape<'_>, margin: f64) -> bool {
    let (sphere_a, sphere_b) = (sphere(a), sphere(b));
    let size = |side: PosedShape<'_>, sphere: Sphere| {
        side.pose.translation().abs().element_sum() + sphere.centre.abs().element_sum() * 1.1
    };
    let centres = a.pose.apply(sphere_a.centre).distance(b.pose.apply(sphere_b.centre));
    let radii = sphere_a.radius + sphere_b.radius + margin;
    let slack =
        16.0 * UNIT * (size(a, sphere_a) + size(b, sphere_b)) + 8.0 * UNIT * (radii + centres);
    centres - radii > slack && centres <= Aabb::LIMIT * 4.0
}

/// A sphere in the shape's own frame whose image holds the placed shape.
fn sphere(side: PosedShape<'_>) -> Sphere {
    let stretch = 1.0 + side.pose.deviation();
    match side.shape.as_polytope() {
        Some(polytope) => Sphere {
            centre: polytope.inner().centre,
            radius: polytope.outer_radius() * stretch + polytope.swept_radius(),
        },
        None => {
            Sphere { centre: dcd_geom::glam::DVec3::ZERO, radius: side.shape.reach() * stretch }
        }
    }
}
