//! Spheres and capsules against cylinders, cones and triangles: what the closed forms say, judged by the search
//! that says yes or no of grown and moved shapes, and by the exact methods for hulls.

mod judge;

use dcd_geom::glam::DVec3;
use dcd_geom::{Pose, Shape};
use dcd_gjk::epa::Depth;
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{
    Accuracy, Depths, DistanceResult, PairSolver, PosedShape, Verdict, certified, distance,
};
use judge::cases::Draw;

const ACCURACIES: [Accuracy; 3] = [Accuracy::F32, Accuracy::F64, Accuracy::Certified];

fn length(draw: &mut Draw, size: f64) -> f64 {
    (0.1 + 0.5 * draw.unit().abs()) * size
}

fn round(draw: &mut Draw, size: f64) -> Shape {
    if draw.below(2) == 0 {
        Shape::sphere(length(draw, size)).unwrap()
    } else {
        Shape::capsule(length(draw, size), length(draw, size) * 0.5).unwrap()
    }
}

fn curved(draw: &mut Draw, size: f64) -> Shape {
    let (height, radius) = (length(draw, size), length(draw, size));
    let swept = if draw.below(3) == 0 { 0.1 * size } else { 0.0 };
    let shape = match draw.below(2) {
        0 => Shape::cylinder(height, radius),
        _ => Shape::cone(height, radius),
    };
    shape.unwrap().rounded(swept).unwrap()
}

fn pose(draw: &mut Draw, reach: f64, place: DVec3) -> Pose {
    Pose::new(draw.rotation(), place + draw.vector() * reach).unwrap()
}

fn depth(accuracy: Accuracy, a: PosedShape<'_>, b: PosedShape<'_>) -> Verdict<Depth> {
    Depths.measure_at(accuracy, a, b, &mut <Depths as PairSolver>::Scratch::default())
}

/// Grown by less than the distance the two stay apart, by more they touch: by another search.
fn judge_distance(a: PosedShape<'_>, b: PosedShape<'_>, seed: usize) -> bool {
    for accuracy in ACCURACIES {
        let found = distance::distance_at(accuracy, a, b).0;
        let DistanceResult::Apart(found) = found else { return false };
        let DistanceResult::Apart(back) = distance::distance_at(accuracy, b, a).0 else {
            panic!("{seed}: the other order is not apart")
        };
        assert_eq!((found.distance, found.point_a), (back.distance, back.point_b), "{seed}");
        let grown = |by: f64| {
            let shape = a.shape.swept(by).unwrap();
            certified::overlap_of(PosedShape { shape: &shape, ..a }, b).0
        };
        assert_ne!(
            grown(found.lower() * (1.0 - 1e-12)),
            Verdict::Touching(()),
            "{seed}: {found:?}"
        );
        assert_ne!(grown(found.upper() * (1.0 + 1e-12)), Verdict::Apart, "{seed}: {found:?}");
        let between = found.point_b - found.point_a - found.normal * found.distance;
        let far = a.pose.translation().length() + b.pose.translation().length();
        assert!(between.length() <= 1e-12 * far + 1e-6 * found.distance, "{seed}: {found:?}");
    }
    true
}

/// Moved along the normal by more than the depth they are apart; along no direction by less.
fn judge_depth(a: PosedShape<'_>, b: PosedShape<'_>, draw: &mut Draw, seed: usize) {
    for accuracy in ACCURACIES {
        let Verdict::Touching(found) = depth(accuracy, a, b) else { panic!("{seed}: no depth") };
        let Verdict::Touching(back) = depth(accuracy, b, a) else { panic!("{seed}: no depth") };
        assert_eq!((found.depth, found.normal), (back.depth, -back.normal), "{seed}");
        let moved = |direction: DVec3, by: f64| {
            let pose = b.pose.with_translation(b.pose.translation() + direction * by).unwrap();
            certified::overlap_of(a, PosedShape { pose: &pose, ..b }).0
        };
        let far = a.pose.translation().length() + b.pose.translation().length();
        let rounding = 1e-13 * (far + found.depth);
        let upper = found.depth + found.error_bound + rounding;
        assert_ne!(moved(found.normal, upper), Verdict::Touching(()), "{seed}: {found:?}");
        let lower = found.depth - found.error_bound - rounding;
        for k in 0..16 {
            let direction = if k == 0 { found.normal } else { draw.vector().normalize() };
            assert_ne!(moved(direction, lower.max(0.0)), Verdict::Apart, "{seed}: {found:?}");
        }
    }
}

#[test]
fn round_shapes_against_cylinders_and_cones_are_as_far_and_as_deep_as_another_search_says() {
    let mut draw = Draw(41);
    let [mut apart, mut touching] = [0; 2];
    for k in 0..1500 {
        let size = [1e-3, 1.0, 1e3][k % 3];
        let place = DVec3::X * [0.0, 0.0, 0.0, 1e6][k % 4] * size;
        let (shape_a, shape_b) = (round(&mut draw, size), curved(&mut draw, size));
        let (pose_a, pose_b) = (pose(&mut draw, size, place), pose(&mut draw, 0.5 * size, place));
        let a = PosedShape { shape: &shape_a, pose: &pose_a };
        let b = PosedShape { shape: &shape_b, pose: &pose_b };
        match certified::overlap_of(a, b).0 {
            Verdict::Apart => apart += usize::from(judge_distance(a, b, k)),
            Verdict::Touching(()) => {
                judge_depth(a, b, &mut draw, k);
                touching += 1;
            }
            Verdict::Undecided(_) => {}
        }
    }
    assert!(apart > 200 && touching > 200, "{apart} {touching}");
}

#[test]
fn a_sphere_on_the_axis_and_one_at_the_apex_have_depths_by_hand() {
    let origin = Pose::IDENTITY;
    let sphere = Shape::sphere(0.125).unwrap();
    let cylinder = Shape::cylinder(2.0, 0.5).unwrap();
    let at = |x: f64, z: f64| Pose::from_translation(DVec3::new(x, 0.0, z)).unwrap();
    for (x, z, expected, normal) in [
        (0.0, 0.0, 0.625, None),
        (0.25, 0.0, 0.375, Some(DVec3::X)),
        (0.125, 1.875, 0.25, Some(DVec3::Z)),
        (0.125, -1.875, 0.25, Some(-DVec3::Z)),
    ] {
        let there = at(x, z);
        let (a, b) = (
            PosedShape { shape: &cylinder, pose: &origin },
            PosedShape { shape: &sphere, pose: &there },
        );
        for accuracy in ACCURACIES {
            let Verdict::Touching(found) = depth(accuracy, a, b) else { panic!("{x} {z}") };
            assert!((found.depth - expected).abs() <= found.error_bound + 1e-15, "{found:?}");
            assert!(normal.is_none_or(|normal| found.normal.distance(normal) < 1e-12), "{found:?}");
        }
    }
    // A cone of slope 3 : 4 above its axis: 4/5 of the radius at the middle.
    let cone = Shape::cone(2.0, 3.0).unwrap();
    let middle = at(0.0, 0.0);
    let (a, b) =
        (PosedShape { shape: &cone, pose: &origin }, PosedShape { shape: &sphere, pose: &middle });
    let Verdict::Touching(found) = depth(Accuracy::Certified, a, b) else { panic!() };
    assert!((found.depth - (1.2 + 0.125)).abs() <= found.error_bound + 1e-15, "{found:?}");
}

#[test]
fn round_shapes_against_triangles_are_as_far_and_as_deep_as_against_their_hulls() {
    let mut draw = Draw(43);
    let [mut apart, mut touching] = [0; 2];
    for k in 0..1500 {
        let size = [1e-6, 1.0, 1e3][k % 3];
        let thin = if k % 5 == 0 { DVec3::new(1.0, 1e-4, 1.0) } else { DVec3::ONE };
        let corners = [(); 3].map(|()| draw.vector() * thin * size);
        let triangle = Shape::triangle(corners).unwrap();
        let hull = Shape::hull(corners.to_vec()).unwrap();
        let other = round(&mut draw, 0.3 * size);
        let (pose_a, pose_b) =
            (pose(&mut draw, 0.2 * size, DVec3::ZERO), pose(&mut draw, 0.3 * size, DVec3::ZERO));
        let [a, exact] = [&triangle, &hull].map(|shape| PosedShape { shape, pose: &pose_a });
        let b = PosedShape { shape: &other, pose: &pose_b };
        let truth = certified::overlap_of(exact, b).0;
        assert_eq!(certified::overlap_of(a, b).0, truth, "{k}");
        if truth == Verdict::Apart {
            let DistanceResult::Apart(truth) = distance::distance(exact, b).0 else {
                panic!("{k}")
            };
            for accuracy in ACCURACIES {
                let DistanceResult::Apart(found) = distance::distance_at(accuracy, a, b).0 else {
                    continue;
                };
                let off = (found.distance - truth.distance).abs();
                assert!(off <= found.error_bound + truth.error_bound, "{k}: {found:?} {truth:?}");
            }
            apart += 1;
        } else {
            let Verdict::Touching(truth) = depth(Accuracy::Certified, exact, b) else {
                panic!("{k}")
            };
            for accuracy in ACCURACIES {
                let Verdict::Touching(found) = depth(accuracy, a, b) else { panic!("{k}") };
                let off = (found.depth - truth.depth).abs();
                assert!(off <= found.error_bound + truth.error_bound, "{k}: {found:?} {truth:?}");
                let Verdict::Touching(back) = depth(accuracy, b, a) else { panic!("{k}") };
                assert_eq!((found.depth, found.normal), (back.depth, -back.normal), "{k}");
            }
            touching += 1;
        }
    }
    assert!(apart > 100 && touching > 100, "{apart} {touching}");
}

/// A cone without height or radius is a point or a needle on its axis, and its rounded form a sphere or a capsule; also of sizes
/// whose products leave the range of f64.
#[test]
fn points_and_needles_of_any_size_are_as_far_and_as_deep_as_spheres_and_capsules() {
    let [mut apart, mut touching] = [0; 2];
    for size in [1.0, 1e3, 1e-100, 1e-163, 1e-195, 1e150] {
        let mut draw = Draw(46);
        for k in 0..300 {
            let height = if k % 2 == 0 { 0.0 } else { 0.3 * size };
            let swept = if k % 3 == 0 { 0.0 } else { 0.4 * size };
            let needle = match k / 2 % 2 {
                0 => Shape::cone(height, 0.0),
                _ => Shape::cylinder(height, 0.0),
            };
            let needle = needle.unwrap().rounded(swept).unwrap();
            let capsule = Shape::capsule(height, swept).unwrap();
            // On its axis, now and then.
            let place = match k % 5 {
                0 => DVec3::Z * draw.unit(),
                _ => draw.vector(),
            };
            let other = round(&mut draw, size);
            let pose = Pose::new(draw.rotation(), place * size * 1.5).unwrap();
            let b = PosedShape { shape: &other, pose: &pose };
            let [a, exact] =
                [&needle, &capsule].map(|shape| PosedShape { shape, pose: &Pose::IDENTITY });
            match certified::overlap_of(exact, b).0 {
                Verdict::Apart => {
                    let DistanceResult::Apart(truth) = distance::distance(exact, b).0 else {
                        continue;
                    };
                    for accuracy in ACCURACIES {
                        let found = distance::distance_at(accuracy, a, b).0;
                        let DistanceResult::Apart(found) = found else { continue };
                        let off = (found.distance - truth.distance).abs();
                        let most = found.error_bound + truth.error_bound;
                        assert!(off <= most, "{size:e} {k}: {found:?} {truth:?}");
                        apart += 1;
                    }
                }
                Verdict::Touching(()) => {
                    let Verdict::Touching(truth) = depth(Accuracy::Certified, exact, b) else {
                        continue;
                    };
                    for accuracy in ACCURACIES {
                        let Verdict::Touching(found) = depth(accuracy, a, b) else { continue };
                        let off = (found.depth - truth.depth).abs();
                        let most = found.error_bound + truth.error_bound;
                        assert!(off <= most, "{size:e} {k}: {found:?} {truth:?}");
                        touching += 1;
                    }
                }
                Verdict::Undecided(_) => {}
            }
        }
    }
    assert!(apart > 1000 && touching > 500, "{apart} {touching}");
}
