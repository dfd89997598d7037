//! One pair of parts: f64 with its bounds, then exact integers.

use super::cuboid::ByAxes;
use super::piercing;
use super::reach::Couple;
use super::relative_pose::RelativePose;
use super::side::{Part, Side};
use crate::epa::Depth;
use crate::gjk::{Simplex, overlap_with_simplex, start};
use crate::supports::InBlocks;
use crate::{Difference, Method, PosedShape, PosedSupport, Verdict, certified, exact};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose, Shape, Support, SupportMap};
use std::borrow::Cow;

/// What is known of a pair of parts.
pub(super) struct Resolved {
    pub(super) verdict: Verdict<()>,
    pub(super) method: Method,
    /// Where the two are apart, an axis that perhaps separates them: world, from the second to the
    /// first, of any length.
    pub(super) axis: Option<DVec3>,
    /// How deep they touch, from the first to the second, where what proves it says so.
    pub(super) depth: Option<Depth>,
}

impl Resolved {
    fn by((verdict, method): (Verdict<()>, Method)) -> Self {
        Self { verdict, method, axis: None, depth: None }
    }
}

/// Resolves a pair of parts, by their indices, as the certified solver does any pair.
pub(super) fn resolve([a, b]: [&Side<'_>; 2], [part_a, part_b]: [u32; 2]) -> Resolved {
    let (part_a, part_b) = (a.part(part_a), b.part(part_b));
    if let Some(resolved) = by_formula([part_a, part_b], [a.pose, b.pose]) {
        return resolved;
    }
    let core_a = Core::of(&part_a);
    if let (Some(core_a), Some(core_b)) = (&core_a, &Core::of(&part_b)) {
        return overlap([core_a, core_b], [a.pose, b.pose]);
    }
    // A cylinder, a cone or a foreign part: no exact method.
    if let (Some(core), Part::Shape(shape)) = (&core_a, part_b)
        && shape.is_bounded()
        && let Some(resolved) = in_f64(core.body(a.pose), PosedSupport::shape(shape, b.pose)).0
    {
        return resolved;
    }
    match (to_shape(part_a), to_shape(part_b)) {
        (Some(shape_a), Some(shape_b)) => Resolved::by(certified::overlap_of(
            PosedShape { shape: &shape_a, pose: a.pose },
            PosedShape { shape: &shape_b, pose: b.pose },
        )),
        // Checked corners are finite, and a hull of three is never refused.
        _ => Resolved::by((Verdict::Undecided(crate::Reason::Range), Method::F64)),
    }
}

/// A triangle and a convex part where a formula proves that they touch, or do not.
fn by_formula(parts: [Part<'_>; 2], poses: [&Pose; 2]) -> Option<Resolved> {
    let (Part::Triangle { .. }, Part::Shape(_)) = (&parts[0], &parts[1]) else { return None };
    let couple = Couple::of(parts, poses)?;
    let by = |verdict| Resolved::by((verdict, Method::F64));
    if let Some((verdict, axis)) = couple.verdict_by_nearest() {
        let axis = (verdict == Verdict::Apart).then_some(axis);
        return Some(Resolved { axis, ..by(verdict) });
    }
    let is_deep = |found: &Depth| found.depth > found.error_bound;
    match couple.by_axes() {
        Some(ByAxes::Apart(axis)) => {
            return Some(Resolved { axis: Some(axis), ..by(Verdict::Apart) });
        }
        Some(ByAxes::Touching(depth)) => {
            return Some(Resolved { depth, ..by(Verdict::Touching(())) });
        }
        None => {}
    }
    couple.pressed().filter(is_deep).map(|_| by(Verdict::Touching(())))
}

/// The same for two triangles that no axis of theirs is known to separate: most of them pierce.
pub(super) fn resolve_triangles(
    relative: &RelativePose,
    [a, b]: [&Side<'_>; 2],
    [part_a, part_b]: [u32; 2],
) -> Resolved {
    if let (Part::Triangle { corners: in_a, .. }, Part::Triangle { corners: in_b, .. }) =
        (a.part(part_a), b.part(part_b))
    {
        let delta = b.pose.translation() - a.pose.translation();
        let in_a = in_a.map(|corner| *a.pose.rotation() * corner);
        let in_b = in_b.map(|corner| *b.pose.rotation() * corner + delta);
        if piercing::touch(&in_a, &in_b, relative.size()) {
            return Resolved::by((Verdict::Touching(()), Method::F64));
        }
    }
    resolve([a, b], [part_a, part_b])
}

/// The core of a part that is the hull of points.
pub(super) enum Core<'a> {
    Polytope(&'a Polytope),
    Triangle { corners: [DVec3; 3], reach: f64, radius: f64 },
}

impl<'a> Core<'a> {
    pub(super) fn of(part: &Part<'a>) -> Option<Self> {
        match *part {
            Part::Shape(shape) => shape.as_polytope().map(Self::Polytope),
            Part::Triangle { corners, reach, radius } => {
                Some(Self::Triangle { corners, reach, radius })
            }
        }
    }

    pub(super) fn body<'b>(&'b self, pose: &'b Pose) -> PosedSupport<'b, Self> {
        let (reach, centre, inner) = match self {
            Self::Polytope(polytope) => {
                let inner = polytope.inner();
                (polytope.reach(), inner.centre, Some(inner.radius))
            }
            Self::Triangle { corners: [a, b, c], reach, .. } => {
                (*reach, *a / 3.0 + *b / 3.0 + *c / 3.0, Some(0.0))
            }
        };
        PosedSupport { map: self, pose, reach, centre, inner }
    }

    fn polytope(&self) -> Option<Cow<'a, Polytope>> {
        match self {
            Self::Polytope(polytope) => Some(Cow::Borrowed(polytope)),
            Self::Triangle { corners, radius, .. } => triangle(*corners, *radius).map(Cow::Owned),
        }
    }
}

impl InBlocks for Core<'_> {
    #[inline(always)]
    fn polytope(&self) -> Option<&Polytope> {
        match self {
            Self::Polytope(polytope) => Some(polytope),
            Self::Triangle { .. } => None,
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
            triangle(corners, radius).map(|polytope| Cow::Owned(Shape::from(polytope)))
        }
    }
}

fn triangle(corners: [DVec3; 3], radius: f64) -> Option<Polytope> {
    Polytope::mesh_triangle(corners).and_then(|triangle| triangle.rounded(radius)).ok()
}

/// What f64 can prove, if it can, and the simplex where it ended.
fn in_f64<A, B>(a: PosedSupport<'_, A>, b: PosedSupport<'_, B>) -> (Option<Resolved>, Simplex<f64>)
where
    A: SupportMap<f64> + ?Sized,
    B: SupportMap<f64> + ?Sized,
{
    let Some(difference) = Difference::<f64, _, _>::new(a, b) else {
        return (None, Simplex::default());
    };
    let (verdict, simplex) = overlap_with_simplex(&difference);
    let axis = match verdict {
        Verdict::Undecided(_) => return (None, simplex),
        Verdict::Touching(()) => None,
        // Where the search ended with the first support, there is no simplex.
        Verdict::Apart => Some(match simplex.nearest() {
            Some(near) => DVec3::from_array(near.direction),
            None => start::<f64>(difference.middle()),
        }),
    };
    (Some(Resolved { axis, ..Resolved::by((verdict, Method::F64)) }), simplex)
}

/// The certified solver for two hulls of points.
fn overlap([a, b]: [&Core<'_>; 2], [pose_a, pose_b]: [&Pose; 2]) -> Resolved {
    let (resolved, simplex) = in_f64(a.body(pose_a), b.body(pose_b));
    if let Some(resolved) = resolved {
        return resolved;
    }
    let mut hint = [[0; 2]; 4];
    for (slot, vertex) in hint.iter_mut().zip(simplex.vertices()) {
        *slot = [vertex.a.feature, vertex.b.feature];
    }
    let (Some(a), Some(b)) = (a.polytope(), b.polytope()) else {
        return Resolved::by((Verdict::Undecided(crate::Reason::Range), Method::F64));
    };
    let (a, b) = (PosedSupport::polytope(&a, pose_a), PosedSupport::polytope(&b, pose_b));
    let touches = exact::touches(a, b, &hint[..simplex.vertices().len()]);
    Resolved::by((certified::verdict_of(touches), Method::Exact))
}
