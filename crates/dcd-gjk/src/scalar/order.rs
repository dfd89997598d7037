//! A canonical order of a pair, by content: solvers see (a, b) and (b, a) as one, so that both
//! give the same bits.

use crate::{PosedShape, PosedSupport};
use dcd_geom::glam::DVec3;
use dcd_geom::{CurvedKind, Kind, Mesh, Polytope, Pose, Shape, SupportMap};
use std::cmp::Ordering;

/// The pair in its order. Where both are equal the order is as given, and cannot matter.
pub(crate) fn canonical<'a>(
    a: PosedShape<'a>,
    b: PosedShape<'a>,
) -> (PosedShape<'a>, PosedShape<'a>) {
    if is_swapped(a, b) { (b, a) } else { (a, b) }
}

/// Whether the second comes first.
#[inline]
pub(crate) fn is_swapped(a: PosedShape<'_>, b: PosedShape<'_>) -> bool {
    placed(a, b).is_gt()
}

/// Which comes first.
pub(crate) fn placed(a: PosedShape<'_>, b: PosedShape<'_>) -> Ordering {
    poses(a.pose, b.pose).then_with(|| shapes(a.shape, b.shape))
}

/// The same for polytopes.
pub(crate) fn are_swapped(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>) -> bool {
    poses(a.pose, b.pose).then_with(|| polytopes(a.map, b.map)).is_gt()
}

fn poses(a: &Pose, b: &Pose) -> Ordering {
    // Nearly always enough.
    let first = a.translation().x.total_cmp(&b.translation().x);
    if first.is_ne() {
        return first;
    }
    vectors([a.translation()], [b.translation()])
        .then_with(|| numbers(a.rotation().to_cols_array(), b.rotation().to_cols_array()))
}

fn shapes(a: &Shape, b: &Shape) -> Ordering {
    match (a, b) {
        (Shape::Mesh(a), Shape::Mesh(b)) => return meshes(a, b),
        (Shape::Compound(a), Shape::Compound(b)) => {
            let parts = a.parts().iter().zip(b.parts());
            let orders = parts.map(|(a, b)| shapes(a.placed(), b.placed()));
            return first_difference(orders);
        }
        _ => {}
    }
    match (a.as_polytope(), b.as_polytope()) {
        (Some(a), Some(b)) => polytopes(a, b),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        // All that a foreign map provides: lengths, and how far it reaches.
        (None, None) => numbers([a.radius(), a.support_error()], [b.radius(), b.support_error()])
            .then_with(|| vectors(ends(a), ends(b)))
            .then_with(|| is_cone(a).cmp(&is_cone(b))),
    }
}

/// Without a radius a cone reaches as far as a cylinder.
fn is_cone(shape: &Shape) -> bool {
    matches!(shape, Shape::Curved(curved) if curved.kind() == CurvedKind::Cone)
}

fn meshes(a: &Mesh, b: &Mesh) -> Ordering {
    if std::ptr::eq(a, b) {
        return Ordering::Equal;
    }
    a.swept_radius()
        .total_cmp(&b.swept_radius())
        .then_with(|| a.triangles().cmp(b.triangles()))
        .then_with(|| vectors(a.vertices().iter().copied(), b.vertices().iter().copied()))
}

fn ends(shape: &Shape) -> impl Iterator<Item = DVec3> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 2.0, 3.0)];
    axes.into_iter().flat_map(|d| [d, -d]).map(|d| shape.support(d).point)
}

fn polytopes(a: &Polytope, b: &Polytope) -> Ordering {
    if std::ptr::eq(a, b) {
        return Ordering::Equal;
    }
    a.swept_radius()
        .total_cmp(&b.swept_radius())
        .then_with(|| a.vertices().len().cmp(&b.vertices().len()))
        .then_with(|| vectors(a.vertices().iter().copied(), b.vertices().iter().copied()))
        // A cuboid, and the hull of its corners: what has a formula is measured otherwise.
        .then_with(|| (a.kind() == Kind::Hull).cmp(&(b.kind() == Kind::Hull)))
}

fn vectors(a: impl IntoIterator<Item = DVec3>, b: impl IntoIterator<Item = DVec3>) -> Ordering {
    let components = |v: DVec3| v.to_array();
    numbers(a.into_iter().flat_map(components), b.into_iter().flat_map(components))
}

fn numbers(a: impl IntoIterator<Item = f64>, b: impl IntoIterator<Item = f64>) -> Ordering {
    let pairs = a.into_iter().zip(b);
    first_difference(pairs.map(|(a, b)| a.total_cmp(&b)))
}

fn first_difference(mut orders: impl Iterator<Item = Ordering>) -> Ordering {
    orders.find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
}
