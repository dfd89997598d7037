//! Boxes with parallel edges, by a closed form that is exact: bricks, shelves, voxels, crates.
//!
//! What is stacked touches exactly or within rounding, where every general search has to end in
//! long integers. Here A − B is a box itself, and whether it holds the origin is three signs, most
//! of them plain in f64 (docs/numerics.md, "parallel boxes").

use super::expansion::{exact_sign, filtered_sign, sum_and_loss};
use crate::double_double::{self, DoubleDouble};
use crate::simplex::{Scalar, Triple, cross, dot, minus, norm1};
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

/// What is known of two bodies as boxes with parallel edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stack {
    /// They are no such boxes.
    Other,
    /// Whether they share a point, and which rung proved it.
    Known(bool, Rung),
    /// They are within rounding of touching.
    Open,
}

/// What the closed form tells by signs that f64 is sure of, and by sums that are exact.
#[inline]
fn touch_quickly(a: Body<'_, Polytope>, b: Body<'_, Polytope>) -> Stack {
    match pair_of(a, b) {
        None => Stack::Other,
        Some(Pair::Aligned(half)) => aligned(a, b, half),
        Some(Pair::Turned(half)) => turned(a, b, half),
    }
}

/// What it tells with as many digits as need be: never open.
#[inline]
pub(crate) fn touch(a: Body<'_, Polytope>, b: Body<'_, Polytope>) -> Stack {
    match touch_quickly(a, b) {
        Stack::Open => match pair_of(a, b) {
            Some(Pair::Turned(half)) => turned_closely(a, b, half),
            _ => Stack::Open,
        },
        known => known,
    }
}

/// Boxes with parallel edges.
enum Pair {
    /// Along the world's axes.
    Aligned(Halves),
    /// By one rotation, along its columns.
    Turned(Halves),
}

#[inline]
fn pair_of(a: Body<'_, Polytope>, b: Body<'_, Polytope>) -> Option<Pair> {
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
    let halves = Halves { a: half_a, b: half_b };
    if r_a == r_b {
        return Some(match axes_of(r_a) {
            Some(axes) => Pair::Aligned(halves.along(axes, axes)),
            None => Pair::Turned(halves),
        });
    }
    Some(Pair::Aligned(halves.along(axes_of(r_a)?, axes_of(r_b)?)))
}

/// Half the edges of both.
#[derive(Clone, Copy)]
struct Halves {
    a: DVec3,
    b: DVec3,
}

impl Halves {
    /// Half the edges along the world's axes, exactly, from those along the boxes' own.
    #[inline]
    fn along(self, of_a: [DVec3; 3], of_b: [DVec3; 3]) -> Self {
        let turned =
            |axes: [DVec3; 3], half: DVec3| axes[0] * half.x + axes[1] * half.y + axes[2] * half.z;
        Self { a: turned(of_a, self.a), b: turned(of_b, self.b) }
    }
}

/// Along which of the world's axes the edges of a box lie, if they do.
#[inline]
fn axes_of(r: &DMat3) -> Option<[DVec3; 3]> {
    let columns = [r.x_axis.abs(), r.y_axis.abs(), r.z_axis.abs()];
    // Entries of 0 and ±1 alone: a rotation to within 1e-6, so each row has one that is not 0.
    let are_axes = columns.iter().all(|c| *c * *c == *c);
    are_axes.then_some(columns)
}

/// h_A + h_B − |t_A − t_B|: half edge i against the centres along world axis k.
#[inline]
fn room(bodies: [Body<'_, Polytope>; 2], half: Halves, i: usize, k: usize) -> [f64; 4] {
    let [t_a, t_b] = bodies.map(|body| body.pose.translation()[k]);
    [half.a[i], half.b[i], t_a.min(t_b), -t_a.max(t_b)]
}

#[inline]
fn aligned(a: Body<'_, Polytope>, b: Body<'_, Polytope>, half: Halves) -> Stack {
    let rooms = [0, 1, 2].map(|k| room([a, b], half, k, k));
    // Without a branch: on which axis bricks touch cannot be predicted.
    let [x, y, z] = rooms.map(sum_and_loss);
    if x.1 + y.1 + z.1 == 0.0 {
        let least = x.0.min(y.0).min(z.0);
        // Just touching is what f64's filter alone could not have told.
        return Stack::Known(least >= 0.0, if least == 0.0 { Rung::Exact } else { Rung::F64 });
    }
    let signs = rooms.map(filtered_sign);
    if signs.contains(&Some(Ordering::Less)) {
        return Stack::Known(false, Rung::F64);
    }
    if !signs.contains(&None) {
        return Stack::Known(true, Rung::F64);
    }
    let touch = rooms.into_iter().all(|terms| exact_sign(terms) != Ordering::Less);
    Stack::Known(touch, Rung::Exact)
}

/// Boxes with one rotation R: A − B = R·box(H) + δ holds the origin if |nᵢ·δ| ≤ Hᵢ·det R for each
/// product nᵢ of two columns of R, by Cramer's rule.
fn turned(a: Body<'_, Polytope>, b: Body<'_, Polytope>, half: Halves) -> Stack {
    let plain = Arithmetic { unit: f64::EPSILON / 2.0, sign: filtered_sign };
    match signs::<f64>([a, b], half, &plain) {
        Some(touch) => Stack::Known(touch, Rung::F64),
        None => Stack::Open,
    }
}

/// The same with more digits: double-double, then integers.
fn turned_closely(a: Body<'_, Polytope>, b: Body<'_, Polytope>, half: Halves) -> Stack {
    let long = Arithmetic { unit: double_double::EPSILON, sign: |sum| Some(exact_sign(sum)) };
    let touch = signs::<DoubleDouble>([a, b], half, &long);
    Stack::Known(touch.unwrap_or_else(|| super::touches(a, b, &[])), Rung::Exact)
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
    [a, b]: [Body<'_, Polytope>; 2],
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
    let mut inside = true;
    for (i, normal) in normals.iter().enumerate() {
        if let Some(k) = upright(rotation, i) {
            match (arithmetic.sign)(room([a, b], half, i, k)) {
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
