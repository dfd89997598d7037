//! One pair of parts: f64 with its bounds, then exact integers.

use super::between::Between;
use super::piercing;
use super::side::{Part, Side};
use crate::gjk::overlap_with_simplex;
use crate::{Body, Difference, Placed, Rung, Verdict, certified, exact};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose, Shape, Support, SupportMap};
use std::borrow::Cow;

/// Settles a pair of parts, by their indices, as the ladder does any pair.
pub(super) fn settle([a, b]: [&Side<'_>; 2], [part_a, part_b]: [u32; 2]) -> (Verdict<()>, Rung) {
    let (part_a, part_b) = (a.part(part_a), b.part(part_b));
    if let (Some(core_a), Some(core_b)) = (Core::of(&part_a), Core::of(&part_b)) {
        return overlap([&core_a, &core_b], [a.pose, b.pose]);
    }
    // A foreign part: no exact rung.
    match (to_shape(part_a), to_shape(part_b)) {
        (Some(shape_a), Some(shape_b)) => certified::overlap_of(
            Placed { shape: &shape_a, pose: a.pose },
            Placed { shape: &shape_b, pose: b.pose },
        ),
        // Checked corners are finite, and a hull of three is never refused.
        _ => (Verdict::Undecided(crate::Reason::Range), Rung::F64),
    }
}

/// The same for two triangles that no axis of theirs is known to separate: most of them pierce.
pub(super) fn settle_triangles(
    between: &Between,
    [a, b]: [&Side<'_>; 2],
    [part_a, part_b]: [u32; 2],
) -> (Verdict<()>, Rung) {
    if let (Part::Triangle { corners: in_a, .. }, Part::Triangle { corners: in_b, .. }) =
        (a.part(part_a), b.part(part_b))
    {
        let delta = b.pose.translation() - a.pose.translation();
        let in_a = in_a.map(|corner| *a.pose.rotation() * corner);
        let in_b = in_b.map(|corner| *b.pose.rotation() * corner + delta);
        if piercing::touch(&in_a, &in_b, between.size()) {
            return (Verdict::Touching(()), Rung::F64);
        }
    }
    settle([a, b], [part_a, part_b])
}

/// The core of a part that is the hull of points.
enum Core<'a> {
    Polytope(&'a Polytope),
    Triangle { corners: [DVec3; 3], reach: f64, radius: f64 },
}

impl<'a> Core<'a> {
    fn of(part: &Part<'a>) -> Option<Self> {
        match *part {
            Part::Shape(shape) => shape.as_polytope().map(Self::Polytope),
            Part::Triangle { corners, reach, radius } => {
                Some(Self::Triangle { corners, reach, radius })
            }
        }
    }

    fn body<'b>(&'b self, pose: &'b Pose) -> Body<'b, Self> {
        let (reach, centre, inner) = match self {
            Self::Polytope(polytope) => {
                let inner = polytope.inner();
                (polytope.reach(), inner.centre, inner.radius)
            }
            Self::Triangle { corners: [a, b, c], reach, .. } => {
                (*reach, *a / 3.0 + *b / 3.0 + *c / 3.0, 0.0)
            }
        };
        Body { map: self, pose, reach, centre, inner }
    }

    fn polytope(&self) -> Option<Cow<'a, Polytope>> {
        match self {
            Self::Polytope(polytope) => Some(Cow::Borrowed(polytope)),
            Self::Triangle { corners, radius, .. } => triangle(*corners, *radius).map(Cow::Owned),
        }
    }
}

impl SupportMap<f64> for Core<'_> {
    fn support(&self, direction: DVec3) -> Support<f64> {
        match self {
            Self::Polytope(polytope) => polytope.support(direction),
            Self::Triangle { corners, .. } => {
                let along = corners.map(|corner| corner.dot(direction));
                let second = usize::from(along[1] > along[0]);
                let k = if along[2] > along[second] { 2 } else { second };
                Support { point: corners[k], feature: k as u32 }
            }
        }
    }

    fn radius(&self) -> f64 {
        match self {
            Self::Polytope(polytope) => polytope.swept_radius(),
            Self::Triangle { radius, .. } => *radius,
        }
    }
}

/// A part as a shape of its own.
pub(super) fn to_shape(part: Part<'_>) -> Option<Cow<'_, Shape>> {
    match part {
        Part::Shape(shape) => Some(Cow::Borrowed(shape)),
        Part::Triangle { corners, radius, .. } => {
            triangle(corners, radius).map(|polytope| Cow::Owned(Shape::Polytope(polytope)))
        }
    }
}

fn triangle(corners: [DVec3; 3], radius: f64) -> Option<Polytope> {
    Polytope::hull(corners.to_vec()).and_then(|hull| hull.rounded(radius)).ok()
}

/// The ladder for two hulls of points.
fn overlap([a, b]: [&Core<'_>; 2], [pose_a, pose_b]: [&Pose; 2]) -> (Verdict<()>, Rung) {
    let mut hint = [[0; 2]; 4];
    let mut known = 0;
    if let Some(difference) = Difference::<f64, _, _>::new(a.body(pose_a), b.body(pose_b)) {
        let (verdict, simplex) = overlap_with_simplex(&difference);
        if !matches!(verdict, Verdict::Undecided(_)) {
            return (verdict, Rung::F64);
        }
        for (slot, vertex) in hint.iter_mut().zip(simplex.vertices()) {
            *slot = [vertex.a.feature, vertex.b.feature];
            known += 1;
        }
    }
    let (Some(a), Some(b)) = (a.polytope(), b.polytope()) else {
        return (Verdict::Undecided(crate::Reason::Range), Rung::F64);
    };
    let (a, b) = (Body::polytope(&a, pose_a), Body::polytope(&b, pose_b));
    let touches = exact::touches(a, b, &hint[..known]);
    (if touches { Verdict::Touching(()) } else { Verdict::Apart }, Rung::Exact)
}
