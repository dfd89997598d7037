//! How deep two cuboids overlap whose edges are along the world's axes: three numbers, exact but for their last bits.
//!
//! Bricks in a wall touch with depth 0, which no bound relative to the size resolves; here the bound is far below any that
//! is promised (docs/numerics/proofs.md, "The depth of cuboids").

use super::{SIZES, UNIT};
use crate::PosedSupport;
use crate::double_double::{DoubleDouble, EPSILON, Sum};
use crate::epa::Depth;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Polytope, Vector};

/// What the sum of four numbers may be off by. Unit: [`EPSILON`] times the pair's size. Derived: 2.
const ROUNDED: f64 = 8.0;

/// The depth of two cuboids that are known to touch; `None` of others, and where an edge is not along an axis.
pub(crate) fn depth(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>) -> Option<Depth> {
    let (half_a, half_b) = (upright(a)?, upright(b)?);
    let (from_a, from_b) = (a.pose.translation(), b.pose.translation());
    let between = from_b - from_a;
    let size = half_a.element_sum() + half_b.element_sum() + between.norm1();
    // False for NaN.
    if !SIZES.contains(&size) {
        return None;
    }
    let (mut axis, mut least) = (0, overlap(0, [half_a, half_b], [from_a, from_b]));
    for k in 1..3 {
        let along = overlap(k, [half_a, half_b], [from_a, from_b]);
        if (along.high, along.low) < (least.high, least.low) {
            (axis, least) = (k, along);
        }
    }
    let depth = least.to_f64().max(0.0);
    let sense = if between[axis] < 0.0 { -1.0 } else { 1.0 };
    let low = (from_a - half_a).max(from_b - half_b);
    let high = (from_a + half_a).min(from_b + half_b);
    let (mut point_a, mut point_b) = ((low + high) * 0.5, (low + high) * 0.5);
    point_a[axis] = from_a[axis] + sense * half_a[axis];
    point_b[axis] = from_b[axis] - sense * half_b[axis];
    let mut normal = DVec3::ZERO;
    normal[axis] = sense;
    let error_bound = UNIT * depth + ROUNDED * EPSILON * size;
    Some(Depth { depth, normal, point_a, point_b, error_bound })
}

/// How far two reach past each other along an axis of the world.
fn overlap(k: usize, half: [DVec3; 2], centres: [DVec3; 2]) -> DoubleDouble {
    let sense = if centres[1][k] < centres[0][k] { -1.0 } else { 1.0 };
    let mut sum = Sum::default();
    sum.add(sense * centres[0][k]);
    sum.add(-sense * centres[1][k]);
    sum.add(half[0][k]);
    sum.add(half[1][k]);
    sum.total()
}

/// Half the edges along the world's axes; `None` of a cuboid that is turned otherwise than by quarters, or rounded.
#[inline]
fn upright(side: PosedSupport<'_, Polytope>) -> Option<DVec3> {
    let DMat3 { x_axis, y_axis, z_axis } = side.pose.rotation();
    let is_axis = |v: &DVec3| {
        let v = v.abs();
        v == DVec3::X || v == DVec3::Y || v == DVec3::Z
    };
    if !(is_axis(x_axis) && is_axis(y_axis) && is_axis(z_axis)) {
        return None;
    }
    match side.map.kind() {
        Kind::Cuboid { half_extents: half } if side.map.swept_radius() == 0.0 => {
            Some(x_axis.abs() * half.x + y_axis.abs() * half.y + z_axis.abs() * half.z)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::epa::{Scratch, depth_of_overlap};
    use dcd_geom::Pose;

    #[test]
    fn cuboids_along_the_axes_are_as_deep_as_the_exact_search_says() {
        let quarter = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z);
        let third = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
        let cuboids = [DVec3::new(0.5, 0.25, 0.1), DVec3::splat(0.3), DVec3::new(0.7, 0.1, 0.0)]
            .map(|half| Polytope::cuboid(half).unwrap());
        let mut touching = 0;
        for k in 0..3000usize {
            let turn = |k: usize| [DMat3::IDENTITY, quarter, third, quarter * third][k % 4];
            let place = DVec3::new(0.1, 0.7, 1e3) * (k % 5) as f64;
            // Tenths that f64 does not hold: faces in touch but for rounding, and deep ones.
            let step = DVec3::new((k % 7) as f64, (k % 11) as f64, (k % 13) as f64) * 0.1 - 0.5;
            let poses = [(k, place), (k / 4, place + step)]
                .map(|(turned, place)| Pose::from_matrix(turn(turned), place).unwrap());
            let [a, b] = [(k % 3, 0), (k / 3 % 3, 1)]
                .map(|(shape, side)| PosedSupport::polytope(&cuboids[shape], &poses[side]));
            if crate::certified::overlap(a, b).0 != crate::Verdict::Touching(()) {
                continue;
            }
            let truth = depth_of_overlap(a, b, &mut Scratch::default());
            let found = depth(a, b).unwrap();
            touching += 1;
            let off = (found.depth - truth.depth).abs();
            assert!(off <= found.error_bound + truth.error_bound, "{k} {found:?} {truth:?}");
            assert!(found.error_bound <= 1e-9 * found.depth + 1e-22, "{k} {found:?}");
            let apart = found.point_a - found.point_b - found.normal * found.depth;
            assert!(apart.length() < 1e-12 * (1.0 + place.length()), "{k} {found:?}");
        }
        assert!(touching > 500, "{touching}");
    }
}
