//! Spheres and capsules inside boxes: the formula beside the exact search.

use super::depth;
use crate::motion::tests::Draw;
use crate::query::Accuracy;
use crate::{PosedSupport, Verdict, epa};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Polytope, Pose};

/// In any direction, or along an axis, where edges are parallel.
fn pose(draw: &mut Draw, is_turned: bool) -> Pose {
    let turn = if is_turned { draw.vector() * 3.0 } else { DVec3::ZERO };
    Pose::new(DQuat::from_scaled_axis(turn).normalize(), draw.vector() * 0.5).unwrap()
}

#[test]
fn spheres_and_capsules_in_boxes_are_as_deep_as_the_exact_search_finds() {
    let (mut draw, mut scratch) = (Draw(1), epa::Scratch::default());
    let [mut touching, mut answered] = [0; 2];
    for k in 0..2000 {
        let cuboid = Polytope::cuboid(draw.vector().abs() + 0.05).unwrap();
        let cuboid = cuboid.rounded(if k % 3 == 0 { 0.1 } else { 0.0 }).unwrap();
        let radius = draw.number().abs() * 0.3;
        let round = match k % 2 {
            0 => Polytope::sphere(radius).unwrap(),
            _ => Polytope::capsule(draw.number().abs() * 0.8, radius).unwrap(),
        };
        let poses = [pose(&mut draw, k % 5 > 0), pose(&mut draw, k % 7 > 0)];
        let a = PosedSupport::polytope(&cuboid, &poses[0]);
        let b = PosedSupport::polytope(&round, &poses[1]);
        let Verdict::Touching(truth) = epa::depth(a, b, &mut scratch) else {
            assert_eq!(depth(a, b, Accuracy::F64), None, "{k}");
            continue;
        };
        // Where the cores overlap by what no rounding hides.
        let is_within = truth.depth > radius + cuboid.swept_radius() + 1e-6;
        touching += usize::from(is_within);
        for sides in [[a, b], [b, a]] {
            let Some(found) = depth(sides[0], sides[1], Accuracy::F64) else { continue };
            answered += usize::from(is_within);
            let off = (found.depth - truth.depth).abs();
            assert!(off <= found.error_bound + truth.error_bound, "{k}: {found:?} {truth:?}");
            let between = found.point_a - found.point_b - found.normal * found.depth;
            assert!(between.length() < 1e-9, "{k}: {found:?}");
        }
    }
    assert!(touching > 500 && answered * 100 > 2 * touching * 95, "{answered} of {touching}");
}
