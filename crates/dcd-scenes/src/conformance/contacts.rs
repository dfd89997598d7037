//! Cuboids that meet in faces, edges and corners, and stacks of cuboids.

use super::bodies::{Placed, cuboid, moved, quarter_turns, sign, turned};
use crate::random::Draw;
use dcd_geom::{Polytope, Pose};
use glam::DVec3;

/// What a meeting is off by, relative to 1: nothing, an ulp, and steps beyond.
const OFF: [f64; 10] =
    [0.0, f64::EPSILON, -f64::EPSILON, 0.0, 1e-12, -1e-12, 0.0, 1e-7, -1e-7, 0.0];

/// Two cuboids that meet along so many axes: one a face, two an edge, three a corner. Their extents
/// are binary fractions and their turns quarter turns, so that they meet exactly; every third pair
/// is turned as a whole, and meets but for rounding.
pub(super) fn meeting(axes: usize, k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let (a, b) = (cuboid(draw)?, cuboid(draw)?);
    let turn = quarter_turns(draw);
    let [half_a, half_b] = [half(&a), (turn * half(&b)).abs()];
    let off = OFF[k % OFF.len()];
    let first = draw.count(0..3) as usize;
    let mut spot = DVec3::ZERO;
    for step in 0..3 {
        let axis = (first + step) % 3;
        let sum = half_a[axis] + half_b[axis];
        spot[axis] = sign(draw) * if step < axes { sum * (1.0 + off) } else { sum * 0.375 };
    }
    let at_b = Pose::from_matrix(turn, spot).ok()?;
    if k % 3 != 2 {
        return Some([(a, Pose::IDENTITY), (b, at_b)]);
    }
    let whole = turned(draw, DVec3::ZERO)?;
    let at_b = Pose::from_matrix(*whole.rotation() * turn, *whole.rotation() * spot).ok()?;
    Some([(a, whole), (b, at_b)])
}

fn half(cuboid: &Polytope) -> DVec3 {
    cuboid.vertices().iter().fold(DVec3::ZERO, |half, v| half.max(v.abs()))
}

/// Pitches of stacks: overlapping, exact, apart.
const PITCHES: [f64; 7] =
    [1.0, 1.0 - 1e-3, 1.0 + 1e-9, 1.0 - 1e-9, 1.0 + 1e-3, 1.0 + f64::EPSILON, 1.0 - f64::EPSILON];

/// Cuboids of a stack, of one size or two, near the origin or far out, turned together or not.
pub(super) fn aligned(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let pitch = PITCHES[k % PITCHES.len()];
    let a = Polytope::cuboid(DVec3::splat(0.5)).ok()?;
    let b = if k.is_multiple_of(4) { cuboid(draw)? } else { a.clone() };
    let cell = |draw: &mut Draw| {
        let of_axis = [(); 3].map(|()| f64::from(draw.count(0..3)) - 1.0);
        DVec3::from_array(of_axis) * pitch
    };
    let corner = DVec3::splat(if k.is_multiple_of(3) { 1024.0 } else { 0.0 });
    let (here, there) = (corner, corner + cell(draw));
    let whole = match k % 2 {
        0 => Pose::IDENTITY,
        _ => turned(draw, DVec3::ZERO)?,
    };
    let at = |spot: DVec3| moved(&whole, *whole.rotation() * spot);
    Some([(a, at(here)?), (b, at(there)?)])
}
