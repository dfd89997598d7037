//! The certified solver of single pairs: f64 as far as it proves its answer, then double-double, then exact
//! integers; boxes with parallel edges by a closed form.

use crate::certificate::Bounds;
use crate::closed::{self, half_space};
use crate::exact::boxes;
use crate::exact::resting;
use crate::gjk::overlap_with_simplex;
use crate::{Difference, Method, PosedShape, PosedSupport, Reason, Verdict, exact, mesh, order};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Shape, SupportMap};

/// By how much more than rounding an axis of the lanes has to part two shapes that have no exact method. Unit: the pair's
/// size. Nearer the search alone decides, or leaves the pair undecided: an axis of f32 is another on another path. Smaller
/// than the gaps that the search surely proves, 1e-9 (docs/numerics/proofs.md, "cylinders and cones"): pairs that are
/// undecided on some paths. Larger: more searches.
const CLEARLY: f64 = 2e-9;

/// Whether two polytopes, rounded or not, touch, and which method proved it: exact for the vertices
/// R·v + t and the radii as they are, touching included, never undecided.
///
/// The same for (a, b) and (b, a). Some hundred nanoseconds in f64, some tens for boxes with
/// parallel edges; where the gap or overlap is within rounding, a microsecond in double-double, and
/// for exact touching some microseconds in integers.
pub fn overlap(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> (Verdict<()>, Method) {
    overlap_after(&[], a, b)
}

/// [`overlap`], after axes that perhaps separate (world, from b to a, any length): what a search in
/// f32 ended with is often right and only not certain.
pub(crate) fn overlap_after(
    axes: &[DVec3],
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> (Verdict<()>, Method) {
    if let Some((touch, method)) = boxes::touch(a, b) {
        return (verdict_of(touch), method);
    }
    // What it leaves is decided exactly.
    if axes.iter().any(|&axis| are_apart_along(axis, a, b, 0.0)) {
        return (Verdict::Apart, Method::F64);
    }
    let (a, b) = if order::are_swapped(a, b) { (b, a) } else { (a, b) };
    if let Some(verdict) = closed::overlap(a, b) {
        return (verdict, Method::F64);
    }
    let mut hint = [[0; 2]; 4];
    let mut known = 0;
    if let Some(difference) = Difference::<f64, _, _>::new(a, b) {
        let (verdict, simplex) = overlap_with_simplex(&difference);
        if !matches!(verdict, Verdict::Undecided(_)) {
            return (verdict, Method::F64);
        }
        if let Some(touch) = resting::touch(a, b, &difference) {
            return (verdict_of(touch), Method::Exact);
        }
        for (slot, vertex) in hint.iter_mut().zip(simplex.vertices()) {
            *slot = [vertex.a.feature, vertex.b.feature];
            known += 1;
        }
    }
    (verdict_of(exact::touches(a, b, &hint[..known])), Method::Exact)
}

/// What a sure answer is.
pub(crate) fn verdict_of(touch: bool) -> Verdict<()> {
    if touch { Verdict::Touching(()) } else { Verdict::Apart }
}

/// [`overlap_with`], after testing such axes; shapes with parts, or without a support, skip them.
pub(crate) fn overlap_with_after(
    axes: &[DVec3],
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut mesh::Scratch,
) -> (Verdict<()>, Method) {
    by_axes_or(axes, a, b, || overlap_with(a, b, scratch))
}

/// The same for a part of each of two shapes, by index, as it and as a shape of its own.
pub(crate) fn overlap_of_parts_after(
    axes: &[DVec3],
    whole: [PosedShape<'_>; 2],
    [(part_a, a), (part_b, b)]: [(u32, PosedShape<'_>); 2],
) -> (Verdict<()>, Method) {
    // Without an exact method it matters by which bounds: those of the shapes that they are parts of.
    by_axes_or(axes, a, b, || mesh::overlap_of_parts(whole, [part_a, part_b]))
}

/// Exact for polytopes; for others what the axes prove, or else that search.
#[inline(always)]
fn by_axes_or(
    axes: &[DVec3],
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    search: impl FnOnce() -> (Verdict<()>, Method),
) -> (Verdict<()>, Method) {
    if let (Some(in_a), Some(in_b)) = (a.shape.as_polytope(), b.shape.as_polytope()) {
        return overlap_after(
            axes,
            PosedSupport::polytope(in_a, a.pose),
            PosedSupport::polytope(in_b, b.pose),
        );
    }
    if are_shapes_apart_along(axes, a, b) {
        return (Verdict::Apart, Method::F64);
    }
    search()
}

/// Whether f64 proves two shapes that have a support of their own apart by one of these axes.
fn are_shapes_apart_along(axes: &[DVec3], a: PosedShape<'_>, b: PosedShape<'_>) -> bool {
    let has_support = |shape: &Shape| {
        matches!(shape, Shape::Polytope(_) | Shape::Curved(_) | Shape::Ellipsoid(_))
    };
    has_support(a.shape) && has_support(b.shape) && {
        let (a, b) = (PosedSupport::shape(a.shape, a.pose), PosedSupport::shape(b.shape, b.pose));
        axes.iter().any(|&axis| are_apart_along(axis, a, b, CLEARLY))
    }
}

/// Whether f64 proves two shapes apart by one axis, world, from b to a, of any length, and by so much of their size more than
/// it has to.
fn are_apart_along<S: SupportMap<f64>>(
    axis: DVec3,
    a: PosedSupport<'_, S>,
    b: PosedSupport<'_, S>,
    margin: f64,
) -> bool {
    let direction = crate::gjk::unit::<f64>(axis.to_array());
    let (Some(direction), Some(difference)) = (direction, Difference::<f64, _, _>::new(a, b))
    else {
        return false;
    };
    let (_, separation) = difference.lowest(direction);
    Bounds::of(&difference).proves_apart(direction, separation - margin)
}

/// The last method alone: slow, and never in doubt. What every other answer is judged by.
pub fn overlap_exactly(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>) -> bool {
    exact::touches(a, b, &[])
}

/// Whether any two shapes touch, and which method proved it. Exact between polytopes, and between a
/// half-space and all but foreign shapes. Cylinders, cones and foreign shapes know no exact method
/// else: a pair with one stays undecided where f64, widened by the stated support error, cannot
/// decide.
///
/// Compounds and meshes are resolved part by part, in memory of this call's own: see [`overlap_with`].
pub fn overlap_of(a: PosedShape<'_>, b: PosedShape<'_>) -> (Verdict<()>, Method) {
    overlap_with(a, b, &mut mesh::Scratch::default())
}

/// The same in memory that is kept from pair to pair; convex shapes need none.
pub fn overlap_with(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut mesh::Scratch,
) -> (Verdict<()>, Method) {
    if mesh::have_parts(a.shape, b.shape) {
        return mesh::overlap(a, b, scratch);
    }
    if let Some(known) = half_space::overlap(a, b) {
        return known;
    }
    match (a.shape, b.shape) {
        (Shape::Polytope(in_a), Shape::Polytope(in_b)) => {
            overlap(PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose))
        }
        _ => (overlap_in_f64(a, b), Method::F64),
    }
}

/// What f64 alone can prove of any two shapes.
pub(crate) fn overlap_in_f64(a: PosedShape<'_>, b: PosedShape<'_>) -> Verdict<()> {
    if mesh::have_parts(a.shape, b.shape) {
        return Verdict::Undecided(Reason::NotConvex);
    }
    if let Some(verdict) = half_space::overlap_in_f64(a, b) {
        return verdict;
    }
    let (a, b) = order::canonical(a, b);
    match (a.shape, b.shape) {
        (Shape::Polytope(in_a), Shape::Polytope(in_b)) => {
            verdict(PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose))
        }
        _ => verdict(PosedSupport::shape(a.shape, a.pose), PosedSupport::shape(b.shape, b.pose)),
    }
}

fn verdict<S: SupportMap<f64>>(a: PosedSupport<'_, S>, b: PosedSupport<'_, S>) -> Verdict<()> {
    match Difference::new(a, b) {
        Some(difference) => crate::gjk::overlap(&difference),
        None => Verdict::Undecided(Reason::Range),
    }
}

#[cfg(test)]
mod tests;
