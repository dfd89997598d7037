//! The one evaluation beside the searches, which need no frame.

use super::{distance, gap_of};
use crate::closed::Gap;
use crate::distance::gap_along;
use crate::motion::tests::Draw;
use crate::query::{Accuracy, MeasureAt};
use crate::{Depths, DistanceResult, PosedShape, Verdict, certified};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pose, Shape, SupportMap};

/// One of the kinds, some flat, some rounded.
fn shape(draw: &mut Draw, k: usize) -> Shape {
    let half = draw.vector().abs() * 0.5 + 0.01;
    let half = if k.is_multiple_of(7) { half * DVec3::new(1.0, 1.0, 0.0) } else { half };
    let made = match k % 7 {
        0 => Shape::cuboid(half),
        1 => Shape::capsule(half.x, half.z),
        2 => Shape::cylinder(half.z, half.x),
        3 => Shape::cone(half.z, half.x),
        4 => Shape::triangle([draw.vector(), draw.vector(), draw.vector()]),
        5 => Shape::hull((0..16).map(|_| draw.vector() * 0.6).collect()),
        // Faces of four corners, and none at all where it is flat.
        _ => {
            let corner = |j: i32| DVec3::new((j & 1) as f64, (j >> 1 & 1) as f64, (j >> 2) as f64);
            Shape::hull((0..8).map(|j| (corner(j) - 0.5) * half).collect())
        }
    };
    let made = made.unwrap();
    if k.is_multiple_of(3) { made.rounded(0.1).unwrap() } else { made }
}

/// Where in a shape's frame a sphere's middle is: anywhere, or on the axes and level with what the shape has there.
fn place(draw: &mut Draw, k: usize) -> DVec3 {
    let anywhere = draw.vector();
    match k % 5 {
        0 => DVec3::new(0.0, 0.0, anywhere.z),
        1 => DVec3::new(anywhere.x, 0.0, 0.0),
        2 => anywhere * 0.1,
        _ => anywhere,
    }
}

fn pose(draw: &mut Draw, k: usize) -> Pose {
    let turn = if k.is_multiple_of(6) { DVec3::ZERO } else { draw.vector() * 3.0 };
    Pose::new(DQuat::from_scaled_axis(turn).normalize(), draw.vector() * 2.0).unwrap()
}

/// Checks the answers for a sphere and a shape: whether they touch, where that is known.
fn check(k: usize, at: Accuracy, a: PosedShape<'_>, b: PosedShape<'_>) -> Option<bool> {
    let mirrored = |found: crate::epa::Depth| found.mirrored();
    let depth = |accuracy, a, b| gap_of(accuracy, a, b).and_then(Gap::depth);
    let known = [depth(at, a, b), depth(at, b, a).map(mirrored)];
    assert_eq!(known[0], known[1], "{k}");
    let apart = [distance(at, a, b), distance(at, b, a).map(DistanceResult::mirrored)];
    assert_eq!(apart[0], apart[1], "{k}");
    let size = 2.0 * a.shape.reach()
        + (b.shape.reach() + b.shape.radius())
        + (a.pose.translation() - b.pose.translation()).abs().element_sum();
    let most = if at == Accuracy::F64 { 4e-14 * size } else { 1e-8 * size };
    let truth = certified::overlap_of(a, b).0;
    if let Some(found) = known[0] {
        assert_eq!(truth, Verdict::Touching(()), "{k}: {found:?}");
        assert_eq!(apart[0], Some(DistanceResult::Touching), "{k}");
        let Verdict::Touching(best) =
            Depths.measure_at(Accuracy::Certified, a, b, &mut Default::default())
        else {
            panic!("{k}: no depth");
        };
        assert!(found.error_bound <= most, "{k}, {at:?}: {found:?}");
        let off = (found.depth - best.depth).abs();
        assert!(off <= found.error_bound + best.error_bound, "{k}: {found:?} {best:?}");
        // Moved out along the normal they are apart: no support says otherwise.
        let gap = gap_along(a, b, found.normal).unwrap();
        assert!(gap >= -(found.depth + found.error_bound) - 1e-14, "{k}: {gap} {found:?}");
        assert!((found.normal.length() - 1.0).abs() < 1e-14);
        let between = found.point_a - found.point_b - found.normal * found.depth;
        assert!(between.length() < 1e-14, "{k}: {found:?}");
        return Some(true);
    }
    let Some(DistanceResult::Apart(found)) = apart[0] else { return None };
    assert_eq!(truth, Verdict::Apart, "{k}: {found:?}");
    let DistanceResult::Apart(best) = crate::distance::distance(a, b).0 else {
        panic!("{k}: no distance");
    };
    assert!(found.error_bound <= most, "{k}, {at:?}: {found:?}");
    let off = (found.distance - best.distance).abs();
    assert!(off <= found.error_bound + best.error_bound, "{k}: {found:?} {best:?}");
    let gap = gap_along(a, b, found.normal).unwrap();
    assert!(gap >= found.distance - found.error_bound - 1e-14, "{k}: {gap} {found:?}");
    assert!(
        found.point_a.distance(best.point_a) < 1e-6 && found.point_b.distance(best.point_b) < 1e-6
    );
    Some(false)
}

#[test]
fn spheres_are_as_far_from_and_as_deep_in_others_as_the_searches_find() {
    // Another seed by `DCD_SEED`.
    let seed = std::env::var("DCD_SEED").map_or(5, |seed| seed.parse().expect("a seed"));
    let mut draw = Draw(seed);
    let mut counts = [[0; 2]; 2];
    for k in 0..6000 {
        let (other, at) = (shape(&mut draw, k), pose(&mut draw, k));
        let sphere = Shape::sphere(0.001 + draw.number().abs() * 0.4).unwrap();
        let centre = Pose::from_translation(at.apply(place(&mut draw, k / 7))).unwrap();
        let (a, b) =
            (PosedShape { shape: &sphere, pose: &centre }, PosedShape { shape: &other, pose: &at });
        for (at, counts) in [Accuracy::F32, Accuracy::F64].into_iter().zip(&mut counts) {
            match check(k, at, a, b) {
                Some(true) => counts[0] += 1,
                Some(false) => counts[1] += 1,
                None => {}
            }
        }
    }
    // At f64 hulls have the search more often.
    for [touching, apart] in counts {
        assert!(touching > 1500 && apart > 1000 && touching + apart > 4500, "{counts:?}");
    }
}
