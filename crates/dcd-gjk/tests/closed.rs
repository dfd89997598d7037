//! Closed forms against the paths that serve any polytope.

mod judge;

use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Polytope, Pose, Shape};
use dcd_gjk::certified::{overlap, overlap_exactly};
use dcd_gjk::{
    Depths, DistanceResult, Method, PairSolver, PosedShape, PosedSupport, Verdict, distance,
};
use judge::cases::Draw;

fn length(draw: &mut Draw, size: f64) -> f64 {
    (0.1 + 0.5 * draw.unit().abs()) * size
}

/// A sphere, a capsule, a segment or a cuboid, rounded or not; some flat.
fn shape(draw: &mut Draw, size: f64) -> Polytope {
    let flat = if draw.below(4) == 0 { 0.0 } else { 1.0 };
    let made = match draw.below(5) {
        0 => Polytope::sphere(length(draw, size)),
        1 => Polytope::capsule(length(draw, size), length(draw, size)),
        2 => Polytope::segment(draw.vector() * size, draw.vector() * size * flat),
        3 => {
            let edges = [(); 3].map(|()| length(draw, size));
            Polytope::cuboid(DVec3::from_array(edges) * DVec3::new(1.0, 1.0, flat))
        }
        _ => Polytope::cuboid(DVec3::splat(length(draw, size))).unwrap().rounded(0.125 * size),
    };
    made.unwrap()
}

fn pose(draw: &mut Draw, size: f64) -> Pose {
    let t = draw.vector() * (1.2 * size);
    match draw.below(4) {
        0 => Pose::from_translation(t).unwrap(),
        1 => {
            // As far from a rotation as a pose may be.
            let off = DMat3::from_diagonal(DVec3::ONE + draw.vector() * 3e-7);
            Pose::from_matrix(DMat3::from_quat(draw.rotation()) * off, t).unwrap()
        }
        _ => Pose::new(draw.rotation(), t).unwrap(),
    }
}

#[test]
fn closed_answers_are_the_exact_methods_down_to_neighbouring_floats() {
    let mut draw = Draw(31);
    let mut exact = 0;
    for k in 0..900 {
        let size = [1e-3, 1.0, 1e3, 1e-60][k % 4];
        let (a, b) = (shape(&mut draw, size), shape(&mut draw, size));
        let (pose_a, pose_b) = (pose(&mut draw, size), pose(&mut draw, size));
        let away = draw.vector() * (8.0 * size);
        let mut judge = |step: f64| {
            let t = pose_b.translation() + away * step;
            let there = Pose::from_matrix(*pose_b.rotation(), t).unwrap();
            let (a, b) = (PosedSupport::polytope(&a, &pose_a), PosedSupport::polytope(&b, &there));
            let (answer, method) = overlap(a, b);
            assert_eq!((answer, method), overlap(b, a));
            exact += usize::from(method == Method::Exact);
            let touching = overlap_exactly(a, b);
            assert_eq!(answer == Verdict::Touching(()), touching, "{a:?} {b:?}");
            touching
        };
        if !judge(0.0) || judge(1.0) {
            continue;
        }
        let (mut near, mut far) = (0.0, 1.0);
        for _ in 0..56 {
            let middle = 0.5 * (near + far);
            if judge(middle) { near = middle } else { far = middle }
        }
    }
    assert!(exact > 500, "{exact}");
}

#[test]
fn closed_distances_are_those_of_the_same_vertices_as_a_hull() {
    let mut draw = Draw(32);
    let mut apart = 0;
    for k in 0..3000 {
        let size = [1e-3, 1.0, 1e3][k % 3];
        let pair = [(); 2].map(|()| shape(&mut draw, size));
        let poses = [(); 2].map(|()| pose(&mut draw, size));
        let hulls = pair.each_ref().map(|polytope| {
            let hull = Polytope::hull(polytope.vertices().to_vec()).unwrap();
            Shape::from(hull.rounded(polytope.swept_radius()).unwrap())
        });
        let pair = pair.map(Shape::from);
        let solve = |shapes: &[Shape; 2]| {
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            distance::distance(a, b).0
        };
        match (solve(&pair), solve(&hulls)) {
            (DistanceResult::Apart(ours), DistanceResult::Apart(theirs)) => {
                let bound = ours.error_bound + theirs.error_bound;
                assert!((ours.distance - theirs.distance).abs() <= bound, "{pair:?} {poses:?}");
                assert!(ours.error_bound <= 1e-12 * ours.distance, "{pair:?} {poses:?}");
                let between = ours.point_b - ours.point_a;
                let error = (between - ours.normal * ours.distance).length();
                assert!(error <= 1e-14 * 16.0 * size, "{error} {pair:?} {poses:?}");
                apart += 1;
            }
            (ours, theirs) => assert_eq!(ours, theirs, "{pair:?} {poses:?}"),
        }
    }
    assert!(apart > 1000, "{apart}");
}

/// Moved so that of two shapes that are apart some part of the distance is left, or of their radii's sum they overlap.
#[test]
fn closed_distances_and_depths_are_those_of_hulls_near_a_touch_too() {
    let mut draw = Draw(33);
    let (mut apart, mut deep) = (0, 0);
    for k in 0..1500 {
        let pair = [(); 2].map(|()| shape(&mut draw, 1.0));
        let poses = [(); 2].map(|()| pose(&mut draw, 1.0));
        let hulls = pair.each_ref().map(|polytope| {
            let hull = Polytope::hull(polytope.vertices().to_vec()).unwrap();
            Shape::from(hull.rounded(polytope.swept_radius()).unwrap())
        });
        let radii: f64 = pair.iter().map(Polytope::swept_radius).sum();
        let pair = pair.map(Shape::from);
        let placed = |shapes, poses| [0, 1].map(|k| posed(shapes, poses, k));
        let [a, b] = placed(&pair, &poses);
        let DistanceResult::Apart(found) = distance::distance(a, b).0 else { continue };
        let part = 10f64.powi(-(k % 12));
        let step =
            if k % 2 == 0 { found.distance * (1.0 - part) } else { found.distance + radii * part };
        let t = poses[1].translation() - found.normal * step;
        let poses = [poses[0], Pose::from_matrix(*poses[1].rotation(), t).unwrap()];
        let ([a, b], [of_a, of_b]) = (placed(&pair, &poses), placed(&hulls, &poses));
        match (distance::distance(a, b).0, distance::distance(of_a, of_b).0) {
            (DistanceResult::Apart(ours), DistanceResult::Apart(theirs)) => {
                let bound = ours.error_bound + theirs.error_bound;
                assert!((ours.distance - theirs.distance).abs() <= bound, "{pair:?} {poses:?}");
                assert!(ours.error_bound <= 1e-12 * ours.distance, "{pair:?} {poses:?}");
                apart += 1;
            }
            (DistanceResult::Touching, DistanceResult::Touching) => {
                let depth = |a, b| Depths.measure(a, b, &mut Default::default());
                let (Verdict::Touching(ours), Verdict::Touching(theirs)) =
                    (depth(a, b), depth(of_a, of_b))
                else {
                    panic!("{pair:?} {poses:?}")
                };
                let bound = ours.error_bound + theirs.error_bound;
                assert!((ours.depth - theirs.depth).abs() <= bound, "{pair:?} {poses:?}");
                deep += usize::from(ours.error_bound <= 1e-12 * ours.depth);
            }
            (ours, theirs) => panic!("{ours:?} {theirs:?} {pair:?} {poses:?}"),
        }
    }
    assert!(apart > 300 && deep > 200, "{apart} {deep}");
}

fn posed<'a>(shapes: &'a [Shape; 2], poses: &'a [Pose; 2], k: usize) -> PosedShape<'a> {
    PosedShape { shape: &shapes[k], pose: &poses[k] }
}
