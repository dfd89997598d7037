//! Distance and depth.

use crate::Input;
use crate::overlap::{body, pair};
use dcd_geom::{Polytope, Pose, Shape};
use dcd_gjk::certified::overlap_exactly;
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{
    Accuracy, Depths, Distance, DistanceResult, PosedShape, PosedSupport, Verdict, distance, epa,
};
use glam::DVec3;

/// Sizes whose squares and products stay within f64, metres: what the checks here compute with.
const SQUARED: std::ops::Range<f64> = 1e-100..1e100;

/// Distance and depth agree with yes or no, their numbers are finite and mirrored, their bounds
/// hold against each other, and moving a shape by its depth parts the two.
pub fn measures(bytes: &[u8]) {
    let Some(pair) = pair(&mut Input(bytes)) else { return };
    let [a, b] = pair.each_ref().map(body);
    let touches = overlap_exactly(a, b);
    check_distance(a, b, touches);
    check_depth(a, b, touches);
}

fn check_distance(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>, touches: bool) {
    let (result, _) = distance::of_polytopes(a, b);
    let (seen_from_b, _) = distance::of_polytopes(b, a);
    match (result, seen_from_b) {
        (DistanceResult::Touching, DistanceResult::Touching) => assert!(touches),
        (DistanceResult::Apart(found), DistanceResult::Apart(mirrored)) => {
            assert!(!touches);
            check_finite(&found, a, b);
            assert_eq!(found.distance.to_bits(), mirrored.distance.to_bits());
            assert_eq!(found.error_bound.to_bits(), mirrored.error_bound.to_bits());
            if !is_same(a, b) {
                assert_eq!((found.point_a, found.normal), (mirrored.point_b, -mirrored.normal));
            }
            check_f64_alone(&found, a, b);
            check_lesser_distances(a, b, &found);
        }
        other => panic!("touches: {touches}, {other:?}"),
    }
}

fn check_finite(found: &Distance, a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>) {
    assert!(found.distance >= 0.0 && found.error_bound >= 0.0, "{found:?}");
    assert!(found.error_bound.is_finite() && found.normal.is_finite(), "{found:?}");
    assert!((found.normal.length() - 1.0).abs() < 1e-9, "{found:?}");
    let size = size(a, b);
    if SQUARED.contains(&size) {
        let between = (found.point_a - found.point_b).length();
        assert!((between - found.distance).abs() <= 1e-9 * size, "{found:?}, {between}");
    }
}

fn check_f64_alone(found: &Distance, a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>) {
    let [in_a, in_b] = [a, b].map(|body| Shape::from(body.map.clone()));
    let (a, b) =
        (PosedShape { shape: &in_a, pose: a.pose }, PosedShape { shape: &in_b, pose: b.pose });
    match distance::in_f64(a, b) {
        DistanceResult::Apart(rough) => {
            let error = found.error_bound + rough.error_bound;
            let off = (found.distance - rough.distance).abs();
            assert!(off <= error * (1.0 + 1e-12), "{found:?} {rough:?}");
        }
        DistanceResult::Touching => panic!("f64 alone: touching; {found:?}"),
        DistanceResult::Interval { within, depth, .. } => {
            assert!(within.distance == 0.0 && within.error_bound.is_finite(), "{within:?}");
            let least = found.distance - found.error_bound;
            assert!(least <= within.error_bound * (1.0 + 1e-12), "{found:?} {within:?}");
            assert!(depth.is_finite(), "{depth}");
        }
        DistanceResult::Undecided(_) => {}
    }
}

fn check_depth(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>, touches: bool) {
    let mut scratch = epa::Scratch::default();
    let verdict = epa::depth(a, b, &mut scratch);
    let mirrored = epa::depth(b, a, &mut scratch);
    match (verdict, mirrored) {
        (Verdict::Touching(depth), Verdict::Touching(mirrored)) => {
            assert!(touches, "{depth:?}");
            assert!(depth.depth >= 0.0 && depth.depth.is_finite(), "{depth:?}");
            assert!(depth.error_bound >= 0.0 && depth.error_bound.is_finite(), "{depth:?}");
            assert!((depth.normal.length() - 1.0).abs() < 1e-9, "{depth:?}");
            assert_eq!(depth.depth.to_bits(), mirrored.depth.to_bits());
            if !is_same(a, b) {
                assert_eq!((depth.point_a, depth.normal), (mirrored.point_b, -mirrored.normal));
            }
            check_parting(a, b, &depth);
            check_lesser_depths(a, b, &depth);
        }
        (Verdict::Apart, Verdict::Apart) => assert!(!touches),
        (Verdict::Undecided(_), Verdict::Undecided(_)) => {}
        other => panic!("{other:?}"),
    }
}

/// At every accuracy the distance is within its bound of the certified one, and mirrored.
fn check_lesser_distances(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    truth: &Distance,
) {
    let [in_a, in_b] = [a, b].map(|body| Shape::from(body.map.clone()));
    let (a, b) =
        (PosedShape { shape: &in_a, pose: a.pose }, PosedShape { shape: &in_b, pose: b.pose });
    for accuracy in [Accuracy::F32, Accuracy::F64] {
        let found = distance::distance_at(accuracy, a, b).0;
        let back = distance::distance_at(accuracy, b, a).0;
        let (DistanceResult::Apart(found), DistanceResult::Apart(back)) = (found, back) else {
            panic!("{accuracy:?}: {truth:?}, but {found:?} and {back:?}");
        };
        assert_eq!(found.distance.to_bits(), back.distance.to_bits());
        if !(found.is_saturated() || truth.is_saturated()) {
            let error = (found.error_bound + truth.error_bound) * (1.0 + 1e-12);
            let off = (found.distance - truth.distance).abs();
            assert!(off <= error, "{accuracy:?}: {found:?} {truth:?}");
        }
    }
}

/// The same for the depth.
fn check_lesser_depths(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    truth: &epa::Depth,
) {
    let [in_a, in_b] = [a, b].map(|body| Shape::from(body.map.clone()));
    let (a, b) =
        (PosedShape { shape: &in_a, pose: a.pose }, PosedShape { shape: &in_b, pose: b.pose });
    let mut scratch = epa::Scratch::default();
    for accuracy in [Accuracy::F32, Accuracy::F64] {
        let found = Depths.measure_at(accuracy, a, b, &mut scratch);
        let back = Depths.measure_at(accuracy, b, a, &mut scratch);
        let (Verdict::Touching(found), Verdict::Touching(back)) = (found, back) else {
            panic!("{accuracy:?}: {truth:?}, but {found:?} and {back:?}");
        };
        assert_eq!(found.depth.to_bits(), back.depth.to_bits());
        assert!(found.depth >= 0.0 && found.depth.is_finite() && found.error_bound >= 0.0);
        if !(found.is_saturated() || truth.is_saturated()) {
            let error = (found.error_bound + truth.error_bound) * (1.0 + 1e-12);
            let off = (found.depth - truth.depth).abs();
            assert!(off <= error, "{accuracy:?}: {found:?} {truth:?}");
        }
    }
}

/// Moved by a little more than its depth, b is apart from a; by clearly less, it is not.
fn check_parting(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>, depth: &epa::Depth) {
    let size = size(a, b);
    if !SQUARED.contains(&size) {
        return;
    }
    let touches_after = |way: f64| {
        let t: DVec3 = b.pose.translation() + depth.normal * way;
        let moved = Pose::from_matrix(*b.pose.rotation(), t).expect("of a valid pose");
        overlap_exactly(a, PosedSupport { pose: &moved, ..b })
    };
    let margin = depth.error_bound + 1e-9 * size;
    assert!(!touches_after(depth.depth + margin), "not parted: {depth:?}");
    if depth.depth > 2.0 * margin {
        assert!(touches_after(depth.depth - margin), "parted too soon: {depth:?}");
    }
}

/// Whether the two are identical, so that the answer seen from b is the same answer.
fn is_same(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>) -> bool {
    let content = |body: PosedSupport<'_, Polytope>| {
        (*body.pose.rotation(), body.pose.translation(), body.map.swept_radius())
    };
    content(a) == content(b) && a.map.vertices() == b.map.vertices()
}

/// No coordinate of either shape is beyond it.
fn size(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>) -> f64 {
    let of = |body: PosedSupport<'_, Polytope>| {
        2.0 * body.reach + body.pose.translation().abs().element_sum() + body.map.swept_radius()
    };
    of(a) + of(b)
}
