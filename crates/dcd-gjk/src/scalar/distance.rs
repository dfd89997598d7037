//! How far apart two shapes are, where they are nearest, and what that is worth.
//!
//! GJK in f64 finds the nearest features; its duality gap bounds the distance from both sides.
//! Between polytopes the search then ends in double-double, so that the distance is right in
//! nearly all its digits even where it is far below the rounding of f64 coordinates; what even that
//! leaves open is resolved in exact integers. Scalar and without fused multiply-add: the same bits
//! everywhere.

mod answer;
mod approach;
mod features;
mod nearer;
mod newton;
mod refine;
#[cfg(test)]
mod tests;
mod warm_start;

use crate::UNIT;
use crate::certificate::Bounds;
use crate::closed::{self, half_space};
use crate::exact::{self, Exact};
use crate::gjk::Simplex;
use crate::mesh::Limited;
use crate::query::{Accuracy, distance_at_once};
use crate::supports::InBlocks;
use crate::{
    Difference, Method, PosedShape, PosedSupport, Reason, Verdict, Vertex, certified, mesh, order,
    portal,
};
pub use answer::{Distance, DistanceResult};
use approach::approach_from;
pub(crate) use approach::{Approach, approach, proposed};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Shape, Support, SupportMap};
pub(crate) use nearer::{Nearer, nearer};

/// The distance and the method that reached it: never undecided between polytopes.
///
/// Between polytopes, rounded or not, its relative error is at most 1e-12 wherever it is above
/// 1e-12 of the shapes' size, and the bound is of that order. With a foreign shape it is
/// [`in_f64`]'s. Of compounds and meshes it is that of the nearest parts: see [`mesh::distance`].
/// (a, b) and (b, a) give the same bits, mirrored.
pub fn distance(a: PosedShape<'_>, b: PosedShape<'_>) -> (DistanceResult, Method) {
    if mesh::have_parts(a.shape, b.shape) {
        return mesh::distance(a, b, &mut mesh::Scratch::default());
    }
    if let Some(found) = half_space::distance(a, b) {
        return found;
    }
    match (a.shape, b.shape) {
        (Shape::Polytope(in_a), Shape::Polytope(in_b)) => {
            of_polytopes(PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose))
        }
        _ => (in_f64(a, b), Method::F64),
    }
}

/// At most the gap of two convex shapes along a direction from a to b (world, any length): how far apart two
/// planes are that are normal to it, a on one side and b beyond the other. Metres; below 0 where none
/// such fit between. `None` for half-spaces, compounds and meshes, which have no support map, for a direction
/// that is none, and where the pair leaves the range.
///
/// Proved in f64: unlike a distance it holds along that direction, so that what is known of both
/// shapes' motion along it can be taken from it. One support of each shape.
pub fn gap_along(a: PosedShape<'_>, b: PosedShape<'_>, direction: DVec3) -> Option<f64> {
    let has_support = |shape: &Shape| shape.is_convex() && shape.is_bounded();
    if !has_support(a.shape) || !has_support(b.shape) {
        return None;
    }
    let axis = crate::gjk::unit::<f64>((-direction).to_array())?;
    let (a, b) = (PosedSupport::shape(a.shape, a.pose), PosedSupport::shape(b.shape, b.pose));
    let difference = Difference::<f64, _, _>::new(a, b)?;
    let (_, separation) = difference.lowest(axis);
    let bounds = Bounds::of(&difference);
    let gap = (bounds.lower_bound(axis, separation) - bounds.swept_upper()).next_down();
    let gap = gap / difference.scale();
    gap.is_finite().then_some(gap)
}

/// The distance between two polytopes: see [`distance`].
pub fn of_polytopes(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> (DistanceResult, Method) {
    if order::are_swapped(a, b) {
        let (result, method) = in_order(b, a);
        (result.mirrored(), method)
    } else {
        in_order(a, b)
    }
}

/// The distance by f64 alone: where a gap or overlap is within its rounding an interval round 0, and
/// with a bound of about 28 · 2⁻⁵³ of the pair's size at the least, 40 by a closed form.
pub fn in_f64(a: PosedShape<'_>, b: PosedShape<'_>) -> DistanceResult {
    if mesh::have_parts(a.shape, b.shape) {
        return DistanceResult::Undecided(Reason::NotConvex);
    }
    to_within(0.0, a, b)
}

/// The distance with a bound as good as an accuracy requires: from f64 where that suffices. Never undecided
/// between polytopes; (a, b) and (b, a) give the same bits, mirrored.
pub fn distance_at(
    accuracy: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> (DistanceResult, Method) {
    if let Some(found) = distance_at_once(accuracy, a, b) {
        return (found, Method::F64);
    }
    let is_bounded = a.shape.is_bounded() && b.shape.is_bounded();
    if accuracy == Accuracy::Certified {
        return distance(a, b);
    }
    if mesh::have_parts(a.shape, b.shape) {
        return mesh::distance_at(Accuracy::F64, [a, b], &mut mesh::Scratch::default());
    }
    if !is_bounded {
        let found = half_space::distance_within(a, b, closed::AS_F64);
        return found.unwrap_or_else(|| distance(a, b));
    }
    match to_within(gap_at(accuracy), a, b) {
        DistanceResult::Interval { .. } | DistanceResult::Undecided(_) => distance(a, b),
        found => (found, Method::F64),
    }
}

/// The same where a distance below `far` alone matters: metres. Of two cylinders or cones that is soon known.
pub(crate) fn distance_below(
    (accuracy, far): (Accuracy, f64),
    a: PosedShape<'_>,
    b: PosedShape<'_>,
) -> (Limited, Method) {
    let limits = [gap_at(accuracy), far];
    let found = if order::is_swapped(a, b) {
        closed::two_curved::distance(limits, [b, a]).map(Limited::mirrored)
    } else {
        closed::two_curved::distance(limits, [a, b])
    };
    match found {
        Some(found) => (found, Method::F64),
        None => {
            let (found, method) = distance_at(accuracy, a, b);
            (Limited::Known(found), method)
        }
    }
}

/// How near the bounds of f64 have to come, relative to the pair's size; 0 for all that it has.
fn gap_at(accuracy: Accuracy) -> f64 {
    if accuracy == Accuracy::F32 { F32_GAP } else { 0.0 }
}

/// How near the bounds have to come for the accuracy of f32, relative to the pair's size. Larger: the bound
/// is above what that accuracy promises. Smaller: more supports.
const F32_GAP: f64 = 1e-6;

/// [`distance_at`] of two polytopes that are known to be apart. The search starts from vertices of a and of b between
/// which the nearest points are thought to be: any are sound, good ones quick.
///
/// The same bits for the same vertices; (b, a) with theirs exchanged is mirrored.
pub(crate) fn of_apart(
    accuracy: Accuracy,
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    nearest: [[u32; 2]; 3],
) -> DistanceResult {
    let in_order = |a, b, nearest| match accuracy {
        Accuracy::Certified => of_apart_in_order(a, b, nearest),
        _ => in_f64_from(a, b, nearest),
    };
    if order::are_swapped(a, b) {
        in_order(b, a, nearest.map(|[a, b]| [b, a])).mirrored()
    } else {
        in_order(a, b, nearest)
    }
}

fn of_apart_in_order(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    nearest: [[u32; 2]; 3],
) -> DistanceResult {
    if let Some(found) = closed::distance(a, b, closed::SHARP) {
        return found;
    }
    let of_hint = |scale| {
        let (pairs, count) = different(nearest);
        of_hint(a, b, scale, &pairs[..count]).0
    };
    let Some(difference) = Difference::new(a, b) else { return of_hint(None) };
    let bounds = Bounds::of(&difference);
    match from_vertices(&difference, &bounds, nearest) {
        Ok(near) => of_near(a, b, difference.scale(), &near).0,
        Err(_) => of_hint(Some(difference.scale())),
    }
}

/// GJK in f64 from vertices of each, by index.
pub(crate) fn from_vertices(
    difference: &Difference<'_, f64, Polytope, Polytope>,
    bounds: &Bounds<f64>,
    nearest: [[u32; 2]; 3],
) -> Result<Approach, Verdict<()>> {
    let (pairs, count) = different(nearest);
    let (in_a, in_b) = difference.maps();
    let support = |polytope: &Polytope, feature: u32| Support {
        point: polytope.vertices()[feature as usize],
        feature,
    };
    let mut simplex = Simplex::default();
    for &[k, l] in &pairs[..count] {
        let (a, b) = (support(in_a, k), support(in_b, l));
        simplex.push(Vertex { w: difference.world(a.point, b.point), a, b });
    }
    approach_from(difference, bounds, [0.0, f64::MAX], simplex)
}

/// [`distance_at`] of two shapes that are no meshes, compounds or half-spaces and whose cores are known to be apart, by f64 alone. The
/// search starts from points of a and of b, in their own frames, between which the nearest points are thought to be; `None` where it
/// leads nowhere.
///
/// The same bits for the same points; (b, a) with theirs exchanged is mirrored.
pub(crate) fn of_apart_cores(
    accuracy: Accuracy,
    [a, b]: [PosedShape<'_>; 2],
    nearest: [[Support<f64>; 2]; 3],
) -> Option<DistanceResult> {
    let gap = gap_at(accuracy);
    let found = if order::is_swapped(a, b) {
        of_shapes(gap, [b, a], &nearest.map(|[a, b]| [b, a])).mirrored()
    } else {
        of_shapes(gap, [a, b], &nearest)
    };
    matches!(found, DistanceResult::Apart(_)).then_some(found)
}

/// The distance of two shapes of which one is no polytope, by f64, from those points of a and of b if there are some.
fn of_shapes(
    gap: f64,
    sides: [PosedShape<'_>; 2],
    nearest: &[[Support<f64>; 2]],
) -> DistanceResult {
    let [a, b] = sides.map(|side| PosedSupport::shape(side.shape, side.pose));
    measured(a, b, |difference, bounds, near| {
        for &[a, b] in nearest {
            let vertex = Vertex { w: difference.world(a.point, b.point), a, b };
            if !near.simplex.holds(&vertex) {
                near.simplex.push(vertex);
            }
        }
        newton::approach(difference, bounds, (gap, sides), near)
    })
}

/// In f64 where that knows more than that they are apart.
fn in_f64_from(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    nearest: [[u32; 2]; 3],
) -> DistanceResult {
    if let Some(found) = closed::distance(a, b, closed::AS_F64) {
        return found;
    }
    if let Some(difference) = Difference::new(a, b) {
        let bounds = Bounds::of(&difference);
        if let Ok(near) = from_vertices(&difference, &bounds, nearest)
            && near.lower > bounds.swept_upper()
        {
            return DistanceResult::Apart(near.distance(&bounds, difference.scale(), (a, b)));
        }
    }
    of_apart_in_order(a, b, nearest)
}

/// Those that differ from the ones before them, and how many they are.
fn different(pairs: [[u32; 2]; 3]) -> ([[u32; 2]; 3], usize) {
    let (mut kept, mut count) = (pairs, 0);
    for pair in pairs {
        if !kept[..count].contains(&pair) {
            kept[count] = pair;
            count += 1;
        }
    }
    (kept, count)
}

fn to_within(gap: f64, a: PosedShape<'_>, b: PosedShape<'_>) -> DistanceResult {
    if order::is_swapped(a, b) {
        in_f64_in_order(gap, b, a).mirrored()
    } else {
        in_f64_in_order(gap, a, b)
    }
}

fn in_f64_in_order(gap: f64, a: PosedShape<'_>, b: PosedShape<'_>) -> DistanceResult {
    match (a.shape, b.shape) {
        (Shape::Polytope(in_a), Shape::Polytope(in_b)) => {
            let (a, b) =
                (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
            closed::distance(a, b, closed::AS_F64).unwrap_or_else(|| {
                measured(a, b, |pair, bounds, near| approach(pair, bounds, gap, near))
            })
        }
        _ => {
            if let Some(Limited::Known(found)) =
                closed::two_curved::distance([gap, f64::INFINITY], [a, b])
            {
                return found;
            }
            of_shapes(gap, [a, b], &[])
        }
    }
}

/// The distance by what a search proves.
fn measured<S: InBlocks>(
    a: PosedSupport<'_, S>,
    b: PosedSupport<'_, S>,
    search: impl FnOnce(
        &Difference<'_, f64, S, S>,
        &Bounds<f64>,
        &mut Approach,
    ) -> Result<(), Verdict<()>>,
) -> DistanceResult {
    let Some(difference) = Difference::new(a, b) else {
        return DistanceResult::Undecided(Reason::Range);
    };
    let bounds = Bounds::of(&difference);
    let mut near = Approach::begin(&difference);
    match search(&difference, &bounds, &mut near) {
        Ok(()) => {}
        Err(Verdict::Undecided(reason)) => return DistanceResult::Undecided(reason),
        Err(_) => return DistanceResult::Touching,
    }
    if near.lower > bounds.swept_upper() {
        return DistanceResult::Apart(near.distance(&bounds, difference.scale(), (a, b)));
    }
    match undecided_or_proved(&difference, &bounds, &near) {
        Verdict::Touching(()) => DistanceResult::Touching,
        // Proved by an axis whose length is no bound: between 0 and what the search found.
        Verdict::Apart => {
            let within = near.within(&bounds, difference.scale(), (a, b));
            let half = 0.5 * within.error_bound;
            let error_bound = rounded_up(half);
            DistanceResult::Apart(Distance { distance: half, error_bound, ..within })
        }
        Verdict::Undecided(reason) => DistanceResult::Interval {
            reason,
            within: near.within(&bounds, difference.scale(), (a, b)),
            // Any separation is at most the signed distance.
            depth: rounded_up((bounds.swept_upper() - near.lower) / difference.scale()),
        },
    }
}

/// The verdict where the nearest point found does not prove the shapes apart.
fn undecided_or_proved<S: SupportMap<f64>>(
    difference: &Difference<'_, f64, S, S>,
    bounds: &Bounds<f64>,
    near: &Approach,
) -> Verdict<()> {
    if bounds.proves_swept_touching(near.length) {
        return Verdict::Touching(());
    }
    portal::overlap(difference, bounds)
}

fn in_order(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> (DistanceResult, Method) {
    if let Some(found) = closed::distance(a, b, closed::SHARP) {
        return (found, Method::F64);
    }
    let Some(difference) = Difference::<f64, _, _>::new(a, b) else {
        return touching(a, b).unwrap_or_else(|| of_hint(a, b, None, &[]));
    };
    let bounds = Bounds::of(&difference);
    let mut near = Approach::begin(&difference);
    let found = approach(&difference, &bounds, 0.0, &mut near);
    if found == Err(Verdict::Touching(())) {
        return (DistanceResult::Touching, Method::F64);
    }
    let is_apart = found.is_ok() && near.lower > bounds.swept_upper();
    if !is_apart && let Some(touching) = touching(a, b) {
        return touching;
    }
    match found {
        Ok(()) => of_near(a, b, difference.scale(), &near),
        Err(_) => of_hint(a, b, Some(difference.scale()), &[]),
    }
}

/// The answer of two that are not apart.
fn touching(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<(DistanceResult, Method)> {
    let (verdict, method) = certified::overlap(a, b);
    (verdict == Verdict::Touching(())).then_some((DistanceResult::Touching, method))
}

/// Of two that are apart, from where the search in f64 has come.
fn of_near(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    scale: f64,
    near: &Approach,
) -> (DistanceResult, Method) {
    if let Some(found) = features::distance(a, b, near) {
        return (DistanceResult::Apart(found), Method::F64);
    }
    let mut hint = [[0; 2]; 3];
    let vertices = near.simplex.vertices();
    for (slot, vertex) in hint.iter_mut().zip(vertices) {
        *slot = [vertex.a.feature, vertex.b.feature];
    }
    of_hint(a, b, Some(scale), &hint[..vertices.len().min(3)])
}

/// From vertices between which the nearest points may be: in double-double, else exactly. `scale` is the pair's, where it
/// has one.
fn of_hint(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    scale: Option<f64>,
    hint: &[[u32; 2]],
) -> (DistanceResult, Method) {
    if let Some(found) = scale.and_then(|scale| refine::refined(a, b, scale, hint)) {
        return (DistanceResult::Apart(found.saturated()), Method::F64);
    }
    match exact::closest(a, b, hint) {
        Some(found) => (DistanceResult::Apart(of_exact(a, b, &found).saturated()), Method::Exact),
        None => (DistanceResult::Touching, Method::Exact),
    }
}

fn of_exact(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    found: &Exact,
) -> Distance {
    let normal = unit(-found.direction);
    let [core_a, core_b] = weighted(a, b, &found.pairs, &found.weights);
    Distance {
        distance: found.distance,
        point_a: core_a + normal * a.map.swept_radius(),
        point_b: core_b - normal * b.map.swept_radius(),
        normal,
        error_bound: rounded_up(found.distance * f64::from(2).powi(-49)),
    }
}

/// R·Σλv + t of both, for vertices by index and weights that sum to 1.
fn weighted(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    pairs: &[[usize; 2]],
    weights: &[f64],
) -> [DVec3; 2] {
    let (mut in_a, mut in_b) = (DVec3::ZERO, DVec3::ZERO);
    for (&[k, l], &weight) in pairs.iter().zip(weights) {
        in_a += a.map.vertices()[k] * weight;
        in_b += b.map.vertices()[l] * weight;
    }
    [a.pose.apply(in_a), b.pose.apply(in_b)]
}

/// Of unit length but for rounding, for a largest component near 1.
fn unit(direction: DVec3) -> DVec3 {
    direction / direction.length()
}

/// A little more, in the denormal range too; finite.
#[inline]
pub(crate) fn rounded_up(x: f64) -> f64 {
    (x.next_up() + f64::from_bits(1)).clamp(0.0, f64::MAX)
}
