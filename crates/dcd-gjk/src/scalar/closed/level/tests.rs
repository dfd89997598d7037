//! The plane in f64 beside the exact one.

use super::{distance, gap_of};
use crate::closed::Gap;
use crate::motion::tests::Draw;
use crate::query::{Accuracy, MeasureAt};
use crate::{Depths, DistanceResult, PosedShape, Verdict, certified};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pose, Shape};

fn shape(draw: &mut Draw, k: usize) -> Shape {
    let half = draw.vector().abs() * 0.5 + 0.01;
    let made = match k % 7 {
        0 => Shape::cuboid(half),
        1 => Shape::capsule(half.x, half.z),
        2 => Shape::cylinder(half.z, half.x),
        3 => Shape::cone(half.z, half.x),
        4 => Shape::hull((0..15).map(|_| draw.vector() * 0.5).collect()),
        5 => Shape::triangle([draw.vector(), draw.vector(), draw.vector()]),
        _ => Shape::sphere(half.x),
    };
    let made = made.unwrap();
    if k.is_multiple_of(4) { made.rounded(0.1).unwrap() } else { made }
}

fn pose(draw: &mut Draw, is_turned: bool, far: f64) -> Pose {
    let turn = if is_turned { draw.vector() * 3.0 } else { DVec3::ZERO };
    Pose::new(DQuat::from_scaled_axis(turn).normalize(), draw.vector() + far).unwrap()
}

#[test]
fn half_spaces_are_as_far_from_and_as_deep_in_others_as_exact_planes_are() {
    // Another seed by `DCD_SEED`.
    let seed = std::env::var("DCD_SEED").map_or(8, |seed| seed.parse().expect("a seed"));
    let mut draw = Draw(seed);
    let [mut touching, mut apart] = [0; 2];
    for k in 0..5000usize {
        let far = if k.is_multiple_of(11) { 1e4 } else { 0.0 };
        let normal =
            if k.is_multiple_of(5) { DVec3::Z } else { draw.vector() * [1.0, 1e-3, 1e3][k % 3] };
        let offset = draw.number() * 0.2 * normal.length();
        let half_space = Shape::half_space(normal, offset).unwrap();
        let half_space = half_space.rounded(if k.is_multiple_of(6) { 0.05 } else { 0.0 }).unwrap();
        let other = shape(&mut draw, k);
        let poses = [
            pose(&mut draw, !k.is_multiple_of(3), far),
            pose(&mut draw, !k.is_multiple_of(4), far),
        ];
        let a = PosedShape { shape: &half_space, pose: &poses[0] };
        let b = PosedShape { shape: &other, pose: &poses[1] };
        let depth = |accuracy, a, b| gap_of(accuracy, a, b).and_then(Gap::depth);
        let deep = depth(Accuracy::F32, a, b);
        assert_eq!(deep, depth(Accuracy::F32, b, a).map(|found| found.mirrored()), "{k}");
        let near = distance(Accuracy::F32, a, b);
        assert_eq!(near, distance(Accuracy::F32, b, a).map(DistanceResult::mirrored), "{k}");
        let truth = certified::overlap_of(a, b).0;
        if let Some(found) = deep {
            let at = Accuracy::Certified;
            let Verdict::Touching(best) = Depths.measure_at(at, a, b, &mut Default::default())
            else {
                panic!("{k}: {found:?}");
            };
            assert_eq!(near, Some(DistanceResult::Touching), "{k}");
            let off = (found.depth - best.depth).abs();
            assert!(off <= found.error_bound + best.error_bound, "{k}: {found:?} {best:?}");
            assert!(found.normal.distance(best.normal) < 1e-12, "{k}: {found:?} {best:?}");
            let between = found.point_a - found.point_b - found.normal * found.depth;
            assert!(between.length() < 1e-14 * (100.0 + far), "{k}: {found:?}");
            touching += 1;
        } else if let Some(DistanceResult::Apart(found)) = near {
            assert_eq!(truth, Verdict::Apart, "{k}: {found:?}");
            let DistanceResult::Apart(best) = crate::distance::distance(a, b).0 else {
                panic!("{k}: {found:?}");
            };
            let off = (found.distance - best.distance).abs();
            assert!(off <= found.error_bound + best.error_bound, "{k}: {found:?} {best:?}");
            assert!(found.normal.distance(best.normal) < 1e-12, "{k}: {found:?} {best:?}");
            apart += 1;
        }
        assert_eq!(depth(Accuracy::Certified, a, b), None);
    }
    assert!(touching > 2000 && apart > 1000 && touching + apart > 4900, "{touching} {apart}");
}
