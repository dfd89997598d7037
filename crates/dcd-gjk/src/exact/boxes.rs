//! Boxes with parallel edges, by a closed form that is exact: bricks, shelves, voxels, crates.
//!
//! What is stacked touches exactly or within rounding, where every general search has to end in
//! long integers. Here A − B is a box itself, and whether it holds the origin is three signs, most
//! of them plain in f64 (docs/numerics/proofs.md, "parallel boxes").

use super::expansion::{difference_and_loss, exact_sign, filtered_sign};
use crate::double_double::{self, DoubleDouble};
use crate::simplex::{Scalar, Triple, cross, dot, minus, norm1};
use crate::{Method, PosedSupport};
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Polytope, Vector};
use std::cmp::Ordering;

/// Sizes in which no product under- or overflows noticeably, metres.
const SIZES: std::ops::Range<f64> = 1e-280..1e280;

/// How far |n·δ| − H·det may be off. Unit: u·(|δ|₁ + H), in the arithmetic at hand. 7.2 of |δ|₁ and
/// 11.8 of H, and a margin. Smaller: false answers. Larger: more pairs in longer numbers.
/// (docs/numerics/proofs.md, "parallel boxes")
const EXCESS: f64 = 16.0;

/// Whether two boxes with parallel edges share a point, and which method proved it, with as many
/// digits as need be; `None` where the two are no such boxes.
#[inline]
pub(crate) fn touch(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<(bool, Method)> {
    Some(match pair_of(a, b)? {
        Pair::Aligned(half) => aligned([a, b].map(|body| body.pose.translation()), half),
        Pair::Turned(half) => turned(a, b, half),
    })
}

/// Boxes with parallel edges.
enum Pair {
    /// Along the world's axes.
    Aligned(Halves),
    /// By one rotation, along its columns.
    Turned(Halves),
}

#[inline]
fn pair_of(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>) -> Option<Pair> {
    let (Kind::Cuboid { half_extents: half_a }, Kind::Cuboid { half_extents: half_b }) =
        (a.map.kind(), b.map.kind())
    else {
        return None;
    };
    if a.map.swept_radius() > 0.0 || b.map.swept_radius() > 0.0 {
        return None;
    }
    let size = a.reach + b.reach + Vector::norm1(a.pose.translation() - b.pose.translation());
    if !SIZES.contains(&size) {
        return None;
    }
    let (r_a, r_b) = (a.pose.rotation(), b.pose.rotation());
    if r_a == r_b {
        return Some(match axes_of(r_a) {
            Some(axes) => Pair::Aligned(Halves { a: along(axes, half_a), b: along(axes, half_b) }),
            None => Pair::Turned(Halves { a: half_a, b: half_b }),
        });
    }
    let (of_a, of_b) = (axes_of(r_a)?, axes_of(r_b)?);
    Some(Pair::Aligned(Halves { a: along(of_a, half_a), b: along(of_b, half_b) }))
}

/// Half the edges of both, metres.
#[derive(Clone, Copy)]
pub(crate) struct Halves {
    pub(crate) a: DVec3,
    pub(crate) b: DVec3,
}

/// Half the edges along the world's axes, exactly, of a box whose own edges lie along these.
#[inline]
pub(crate) fn along(axes: [DVec3; 3], half: DVec3) -> DVec3 {
    axes[0] * half.x + axes[1] * half.y + axes[2] * half.z
}

/// Along which of the world's axes the edges of a box lie, if they do.
#[inline]
pub(crate) fn axes_of(r: &DMat3) -> Option<[DVec3; 3]> {
    let columns = [r.x_axis.abs(), r.y_axis.abs(), r.z_axis.abs()];
    // Entries of 0 and ±1 alone: a rotation to within 1e-6, so each row has one that is not 0.
    let are_axes = columns.iter().all(|c| *c * *c == *c);
    are_axes.then_some(columns)
}

/// Whether two boxes with edges along the world's axes share a point, given their centres and half
/// their edges along those axes; and which method proved it. No sum of them may overflow.
#[inline(always)]
pub(crate) fn aligned(centres: [DVec3; 2], half: Halves) -> (bool, Method) {
    let [t_a, t_b] = centres;
    let x = difference_and_loss([half.a.x, half.b.x], [t_a.x, t_b.x]);
    let y = difference_and_loss([half.a.y, half.b.y], [t_a.y, t_b.y]);
    let z = difference_and_loss([half.a.z, half.b.z], [t_a.z, t_b.z]);
    // Without a branch: on which axis bricks touch cannot be predicted.
    if x.1 + y.1 + z.1 == 0.0 {
        let least = least(x.0, least(y.0, z.0));
        // A least of 0 is what f64's filter alone could not have decided.
        return (least >= 0.0, if least == 0.0 { Method::Exact } else { Method::F64 });
    }
    aligned_closely(centres, half)
}

/// The lesser of two numbers, neither of them NaN.
#[inline(always)]
fn least(x: f64, y: f64) -> f64 {
    if x < y { x } else { y }
}

/// The same where something is rounded away.
#[cold]
fn aligned_closely(centres: [DVec3; 2], half: Halves) -> (bool, Method) {
    let overlaps =
        [0, 1, 2].map(|k| overlap_terms([half.a[k], half.b[k]], centres.map(|centre| centre[k])));
    let signs = overlaps.map(filtered_sign);
    if signs.contains(&Some(Ordering::Less)) {
        return (false, Method::F64);
    }
    if !signs.contains(&None) {
        return (true, Method::F64);
    }
    let touch = overlaps.into_iter().all(|terms| exact_sign(terms) != Ordering::Less);
    (touch, Method::Exact)
}

/// The terms of h_A + h_B − |t_A − t_B| along an axis, given half an edge of each and their centres there.
fn overlap_terms(half: [f64; 2], [t_a, t_b]: [f64; 2]) -> [f64; 4] {
    [half[0], half[1], t_a.min(t_b), -t_a.max(t_b)]
}

/// Boxes with one rotation R: A − B = R·box(H) + δ holds the origin if |nᵢ·δ| ≤ Hᵢ·det R for each
/// product nᵢ of two columns of R, by Cramer's rule. In f64, then in double-double, then in integers.
fn turned(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    half: Halves,
) -> (bool, Method) {
    let plain = Arithmetic { unit: f64::EPSILON / 2.0, sign: filtered_sign };
    if let Some(touch) = signs::<f64>([a, b], half, &plain) {
        return (touch, Method::F64);
    }
    let long = Arithmetic { unit: double_double::EPSILON, sign: |sum| Some(exact_sign(sum)) };
    let touch = signs::<DoubleDouble>([a, b], half, &long);
    (touch.unwrap_or_else(|| super::touches(a, b, &[])), Method::Exact)
}

/// What signs are found with.
struct Arithmetic {
    /// The unit roundoff.
    unit: f64,
    /// Of a sum, as far as it is known.
    sign: fn([f64; 4]) -> Option<Ordering>,
}

/// Whether the two touch; `None` within rounding.
fn signs<T: Scalar + From<f64> + Into<f64>>(
    [a, b]: [PosedSupport<'_, Polytope>; 2],
    half: Halves,
    arithmetic: &Arithmetic,
) -> Option<bool> {
    let wide = |v: DVec3| v.to_array().map(T::from);
    let rotation = a.pose.rotation();
    let columns = [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(wide);
    let [x, y, z] = &columns;
    let normals = [cross(y, z), cross(z, x), cross(x, y)];
    let determinant = dot(x, &normals[0]);
    let delta: Triple<T> = minus(&wide(a.pose.translation()), &wide(b.pose.translation()));
    let distance = norm1(&delta.clone().map(Into::into));
    let centres = [a, b].map(|body| body.pose.translation());
    let mut inside = true;
    for (i, normal) in normals.iter().enumerate() {
        if let Some(k) = upright(rotation, i) {
            match (arithmetic.sign)(overlap_terms([half.a[i], half.b[i]], centres.map(|t| t[k]))) {
                Some(Ordering::Less) => return Some(false),
                known => inside &= known.is_some(),
            }
            continue;
        }
        let along = dot(normal, &delta);
        let along = if along.is_negative() { along.negated() } else { along };
        let half = T::from(half.a[i]).plus(&T::from(half.b[i]));
        let excess: f64 = along.minus(&half.times(&determinant)).into();
        let bound = EXCESS * arithmetic.unit * (distance + half.into());
        if excess > bound {
            return Some(false);
        }
        inside &= excess < -bound;
    }
    inside.then_some(true)
}

/// The world axis along which a box stands with its edges i, if there is one: column i of R is that
/// axis, and the others have nothing of it. Then nᵢ·δ is δ's component times det R, exactly.
fn upright(r: &DMat3, i: usize) -> Option<usize> {
    let column = r.col(i).abs();
    let k = (0..3).find(|&k| column[k] == 1.0)?;
    let nothing = |x: f64| x == 0.0;
    let rest = [(k + 1) % 3, (k + 2) % 3].map(|m| column[m]);
    let others = [(i + 1) % 3, (i + 2) % 3].map(|j| r.col(j)[k]);
    rest.into_iter().chain(others).all(nothing).then_some(k)
}

#[cfg(test)]
mod tests;
