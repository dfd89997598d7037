//! Cuboid against cuboid, rounded or not: the fifteen separating axes.

use super::{SIZES, UNIT};
use crate::{PosedSupport, Verdict};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Vector};

/// How clearly an axis must separate or overlap, relative to the pair's size m: 2⁻³⁹. An axis and a
/// separation along it lose less than 100u·m, and what R may depart from a rotation by is at most
/// [`DEVIATION`], twice for each body: 2000u in all, a quarter of this. What is less clear is left
/// to the general path. (docs/numerics/proofs.md, "closed forms")
const CLEAR: f64 = 16384.0 * UNIT;

/// The largest deviation of a pose for which [`CLEAR`] is enough.
const DEVIATION: f64 = 256.0 * UNIT;

/// The verdict where all fifteen axes are clear, or one separates clearly.
pub(super) fn overlap(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<Verdict<()>> {
    let (Kind::Cuboid { half_extents: half_a }, Kind::Cuboid { half_extents: half_b }) =
        (a.map.kind(), b.map.kind())
    else {
        return None;
    };
    let delta = b.pose.translation() - a.pose.translation();
    let radius = a.map.swept_radius() + b.map.swept_radius();
    let size = 1.1 * (a.reach + b.reach) + delta.norm1() + radius;
    let straight = a.pose.deviation().max(b.pose.deviation()) <= DEVIATION;
    // False for NaN.
    if !(SIZES.contains(&size) && straight) {
        return None;
    }
    let clear = CLEAR * size;
    let to_a = a.pose.rotation().transpose();
    let (t, turned) = (to_a * delta, to_a * *b.pose.rotation());
    let b_axes = [turned.x_axis, turned.y_axis, turned.z_axis];
    let b_abs = b_axes.map(DVec3::abs);
    let reach_b = b_abs[0] * half_b.x + b_abs[1] * half_b.y + b_abs[2] * half_b.z;

    let along_a = t.abs() - half_a - reach_b;
    let most_a = along_a.max_element();
    if most_a > radius + clear {
        return Some(Verdict::Apart);
    }
    let mut most = most_a;
    for k in 0..3 {
        let along = b_axes[k].dot(t).abs() - half_b[k] - b_abs[k].dot(half_a);
        if along > radius + clear {
            return Some(Verdict::Apart);
        }
        most = most.max(along);
    }
    // Each product of an axis of A and one of B, at the length that it has: at most 1.
    for j in 0..3 {
        let (axis, abs) = (b_axes[j], b_abs[j]);
        let (next, last) = ((j + 1) % 3, (j + 2) % 3);
        let (abs_next, abs_last) = (b_abs[next], b_abs[last]);
        for k in 0..3 {
            let (p, q) = ((k + 1) % 3, (k + 2) % 3);
            let between = (t[q] * axis[p] - t[p] * axis[q]).abs();
            let reach_a = half_a[p] * abs[q] + half_a[q] * abs[p];
            let reach_b = half_b[next] * abs_last[k] + half_b[last] * abs_next[k];
            let along = between - reach_a - reach_b;
            // The radius counts at the axis's length: at most all of it.
            if along > radius + clear {
                return Some(Verdict::Apart);
            }
            most = most.max(along);
        }
    }
    (most < -clear).then_some(Verdict::Touching(()))
}
