//! Boxes with parallel edges, by a closed form that is exact: bricks, shelves, voxels, crates.
//!
//! What is stacked touches exactly or within rounding, where every general search has to end in
//! long integers. Here A − B is a box itself, and whether it holds the origin is three signs, most
//! of them plain in f64 (docs/numerics.md, "parallel boxes").

use super::expansion::{exact_sign, filtered_sign};
use crate::double_double::{self, DoubleDouble};
use crate::simplex::{Scalar, Triple, cross, dot, norm1};
use crate::{Body, Rung};
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Polytope, Vector};
use std::cmp::Ordering;

/// Sizes in which no product under- or overflows noticeably, metres.
const SIZES: std::ops::Range<f64> = 1e-280..1e280;

/// How far |n·δ| − H·det may be off. Unit: u·(|δ|₁ + H), in the arithmetic at hand. 7.2 of |δ|₁ and
/// 11.8 of H, and room. Smaller: false answers. Larger: more pairs in longer numbers.
/// (docs/numerics.md, "parallel boxes")
const EXCESS: f64 = 16.0;

/// Whether two boxes with parallel edges share a point, and which rung proved it; `None` where they
/// are no such two.
#[inline]
pub(crate) fn touch(a: Body<'_, Polytope>, b: Body<'_, Polytope>) -> Option<(bool, Rung)> {
    let (Kind::Cuboid { half_extents: half_a }, Kind::Cuboid { half_extents: half_b }) =
        (a.map.kind(), b.map.kind())
    else {
        return None;
    };
    if a.map.swept_radius() > 0.0 || b.map.swept_radius() > 0.0 {
        return None;
    }
    let halves = Halves { a: half_a, b: half_b };
    let size = a.reach + b.reach + Vector::norm1(a.pose.translation() - b.pose.translation());
    if !SIZES.contains(&size) {
        return None;
    }
    let (r_a, r_b) = (a.pose.rotation(), b.pose.rotation());
    match (along_axes(r_a, half_a), along_axes(r_b, half_b)) {
        (Some(half_a), Some(half_b)) => Some(aligned(a, b, Halves { a: half_a, b: half_b })),
        _ if r_a == r_b => Some(parallel(a, b, halves)),
        _ => None,
    }
}

/// Half the edges of both.
#[derive(Clone, Copy)]
struct Halves {
    a: DVec3,
    b: DVec3,
}

/// Half the edges along the world's axes, exactly, of a box whose edges lie along them.
#[inline]
fn along_axes(r: &DMat3, half: DVec3) -> Option<DVec3> {
    let columns = [r.x_axis.abs(), r.y_axis.abs(), r.z_axis.abs()];
    let is_axis = |c: &DVec3| *c * *c == *c;
    // Entries of 0 and ±1 alone: a rotation to within 1e-6, so each row has one that is not 0.
    columns
        .iter()
        .all(is_axis)
        .then(|| columns[0] * half.x + columns[1] * half.y + columns[2] * half.z)
}

/// Along each axis the half edges against the distance of the centres.
#[inline]
fn aligned(a: Body<'_, Polytope>, b: Body<'_, Polytope>, half: Halves) -> (bool, Rung) {
    let (t_a, t_b) = (a.pose.translation(), b.pose.translation());
    let terms = [0, 1, 2].map(|k| {
        let (low, high) = (t_a[k].min(t_b[k]), t_a[k].max(t_b[k]));
        [half.a[k], half.b[k], low, -high]
    });
    let signs = terms.map(filtered_sign);
    if signs.contains(&Some(Ordering::Less)) {
        return (false, Rung::F64);
    }
    if !signs.contains(&None) {
        return (true, Rung::F64);
    }
    (terms.into_iter().all(|terms| exact_sign(terms) != Ordering::Less), Rung::Exact)
}

/// Boxes with one rotation R: A − B = R·box(H) + δ holds the origin if |nᵢ·δ| ≤ Hᵢ·det R for each
/// product nᵢ of two columns of R, by Cramer's rule.
fn parallel(a: Body<'_, Polytope>, b: Body<'_, Polytope>, half: Halves) -> (bool, Rung) {
    match signs::<f64>(a, b, half, f64::EPSILON / 2.0) {
        Some(touch) => (touch, Rung::F64),
        None => match signs::<DoubleDouble>(a, b, half, double_double::EPSILON) {
            Some(touch) => (touch, Rung::Exact),
            None => (super::touches(a, b, &[]), Rung::Exact),
        },
    }
}

/// Whether the two touch, by numbers with that unit roundoff; `None` within their rounding.
fn signs<T: Scalar + From<f64> + Into<f64>>(
    a: Body<'_, Polytope>,
    b: Body<'_, Polytope>,
    half: Halves,
    unit: f64,
) -> Option<bool> {
    let wide = |v: DVec3| v.to_array().map(T::from);
    let rotation = a.pose.rotation();
    let columns = [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(wide);
    let [x, y, z] = &columns;
    let normals = [cross(y, z), cross(z, x), cross(x, y)];
    let determinant = dot(x, &normals[0]);
    let delta: Triple<T> =
        crate::simplex::minus(&wide(a.pose.translation()), &wide(b.pose.translation()));
    let distance = norm1(&delta.clone().map(Into::into));
    let mut inside = true;
    for (normal, k) in normals.iter().zip(0..3) {
        let along = dot(normal, &delta);
        let along = if along.is_negative() { along.negated() } else { along };
        let half = T::from(half.a[k]).plus(&T::from(half.b[k]));
        let excess: f64 = along.minus(&half.times(&determinant)).into();
        let bound = EXCESS * unit * (distance + half.into());
        if excess > bound {
            return Some(false);
        }
        inside &= excess < -bound;
    }
    inside.then_some(true)
}

#[cfg(test)]
mod tests;
