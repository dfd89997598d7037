//! Seeded pairs against the oracle.

use super::*;
use dcd_geom::glam::{DMat3, DQuat};
use dcd_gjk::{DistanceResult, distance};
use dcd_judge::Truth;
use proptest::prelude::*;
use std::ops::Range;

/// What is promised of a depth, relative to itself.
const PROMISED: f64 = 1e-9;

fn judge(a: &PosedShape, b: &PosedShape) -> Result<(), TestCaseError> {
    let truth = Truth::of((&a.0, &a.1), (&b.0, &b.1));
    let found = match solve(a, b) {
        Verdict::Apart => {
            prop_assert!(!truth.touches(), "{} deep", truth.value());
            return Ok(());
        }
        Verdict::Touching(depth) => {
            prop_assert!(truth.touches(), "apart, not {depth:?}");
            depth
        }
        undecided => return Err(TestCaseError::fail(format!("{undecided:?}"))),
    };
    let Depth { depth, error_bound, .. } = found;
    let value = truth.value();
    prop_assert!(truth.is_within(depth - error_bound, depth + error_bound), "{found:?}, {value}");
    prop_assert!((depth - value).abs() <= PROMISED * value + 1e-22, "{found:?}, {value}");
    let size = a.0.reach() + b.0.reach();
    prop_assert!(error_bound <= PROMISED * depth + 1e-22 * size, "{found:?}");
    separates(a, b, &found)?;
    let mirrored = overlap(b, a);
    prop_assert_eq!(mirrored.depth.to_bits(), depth.to_bits());
    prop_assert_eq!(mirrored.error_bound.to_bits(), error_bound.to_bits());
    prop_assert_eq!(mirrored.normal, -found.normal);
    prop_assert_eq!((mirrored.point_a, mirrored.point_b), (found.point_b, found.point_a));
    Ok(())
}

/// That the normal parts the shapes, and that the witnesses are where it says.
fn separates(a: &PosedShape, b: &PosedShape, found: &Depth) -> Result<(), TestCaseError> {
    let size = a.0.reach() + b.0.reach() + a.1.translation().length() + b.1.translation().length();
    let slack = 1e-14 * size;
    prop_assert!((found.normal.length() - 1.0).abs() < 1e-15);
    let between = found.point_a - found.point_b;
    prop_assert!(between.distance(found.normal * found.depth) <= slack, "{found:?}");
    let farthest = |(map, pose): &PosedShape, n: DVec3| {
        let along = map.vertices().iter().map(|&v| pose.apply(v).dot(n));
        along.fold(f64::NEG_INFINITY, f64::max)
    };
    prop_assert!((farthest(a, found.normal) - found.point_a.dot(found.normal)).abs() <= slack);
    prop_assert!((farthest(b, -found.normal) + found.point_b.dot(found.normal)).abs() <= slack);
    Ok(())
}

/// Few coordinates, so that faces are parallel, edges meet, and vertices coincide.
fn grid_hull() -> impl Strategy<Value = Polytope> {
    let point = prop::array::uniform3((-3i32..=3).prop_map(f64::from));
    prop::collection::vec(point, 4..8)
        .prop_filter("flat", |points| is_solid(points))
        .prop_map(|points| hull(&points))
}

fn is_solid(points: &[[f64; 3]]) -> bool {
    let p: Vec<DVec3> = points.iter().map(|&p| p.into()).collect();
    (1..p.len()).any(|i| {
        (1..i).any(|j| (1..j).any(|k| (p[i] - p[0]).cross(p[j] - p[0]).dot(p[k] - p[0]) != 0.0))
    })
}

/// The 24 turns of a cube, by two of its axes.
fn right_turn() -> impl Strategy<Value = DMat3> {
    let axis = (0usize..3, prop::bool::ANY)
        .prop_map(|(k, sign)| DVec3::AXES[k] * if sign { 1.0 } else { -1.0 });
    (axis.clone(), axis)
        .prop_filter("parallel", |(x, y)| x.dot(*y) == 0.0)
        .prop_map(|(x, y)| DMat3::from_cols(x, y, x.cross(y)))
}

fn any_turn() -> impl Strategy<Value = DQuat> {
    prop::array::uniform4(-1.0f64..1.0)
        .prop_filter("short", |q| q.iter().map(|x| x * x).sum::<f64>() > 0.01)
        .prop_map(|q| DQuat::from_array(q).normalize())
}

/// Points in a box of the given half extents.
fn cloud(half: DVec3) -> impl Strategy<Value = Polytope> {
    points(half, 4..8)
}

fn points(half: DVec3, count: Range<usize>) -> impl Strategy<Value = Polytope> {
    let point = prop::array::uniform3(-1.0f64..1.0).prop_map(move |p| DVec3::from(p) * half);
    prop::collection::vec(point, count).prop_map(|points| Polytope::hull(points).unwrap())
}

proptest! {
    // The oracle's directions are many more here.
    #![proptest_config(ProptestConfig::with_cases(50))]

    #[test]
    fn rounded_hulls_have_their_exact_depth_cores_apart_or_not(
        a in cloud(DVec3::ONE), b in cloud(DVec3::ONE), turns in [any_turn(), any_turn()],
        t in prop::array::uniform3(-2.5f64..2.5), share in prop_oneof![Just(0.0), 0.0f64..1e-9, 0.0f64..2.0],
    ) {
        let [p, q] = turns;
        let (a, b) = ((a, Pose::new(p, DVec3::ZERO).unwrap()), (b, Pose::new(q, t.into()).unwrap()));
        judge_rounded(&a, &b, share)?;
    }

    #[test]
    fn capsules_and_rounded_plates_have_their_exact_depth(
        a in prop_oneof![points(DVec3::ONE, 1..4), points(DVec3::new(1.0, 1.0, 0.0), 2..6)],
        b in prop_oneof![points(DVec3::ONE, 2..4), points(DVec3::new(1.0, 1.0, 0.0), 2..6)],
        turns in prop_oneof![[any_turn(), any_turn()], any_turn().prop_map(|q| [q, q])],
        t in prop::array::uniform3(-2.5f64..2.5),
        share in prop_oneof![Just(0.0), 0.0f64..1e-9, 0.0f64..2.0],
    ) {
        let [p, q] = turns;
        let (a, b) = ((a, Pose::new(p, DVec3::ZERO).unwrap()), (b, Pose::new(q, t.into()).unwrap()));
        judge_rounded(&a, &b, share)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn hulls_on_a_grid_turned_at_right_angles_have_their_exact_depth(
        a in grid_hull(), b in grid_hull(), turn in right_turn(),
        t in prop::array::uniform3((-6i32..=6).prop_map(|x| f64::from(x) * 0.5)),
    ) {
        let place = Pose::from_matrix(turn, t.into()).unwrap();
        judge(&(a, Pose::IDENTITY), &(b, place))?;
    }

    #[test]
    fn hulls_at_any_angle_have_their_exact_depth(
        a in cloud(DVec3::ONE), b in cloud(DVec3::ONE), turns in [any_turn(), any_turn()],
        t in prop::array::uniform3(-0.7f64..0.7),
    ) {
        let [p, q] = turns;
        judge(&(a, Pose::new(p, DVec3::ZERO).unwrap()), &(b, Pose::new(q, t.into()).unwrap()))?;
    }

    #[test]
    fn slivers_and_needles_have_their_exact_depth(
        a in cloud(DVec3::new(1.0, 1e-3, 1e-7)), b in cloud(DVec3::new(1e-5, 1e-5, 2.0)),
        turns in [any_turn(), any_turn()], t in prop::array::uniform3(-1e-5f64..1e-5),
    ) {
        let [p, q] = turns;
        judge(&(a, Pose::new(p, DVec3::ZERO).unwrap()), &(b, Pose::new(q, t.into()).unwrap()))?;
    }

    #[test]
    fn shapes_far_out_at_any_scale_have_their_exact_depth(
        a in cloud(DVec3::ONE), b in cloud(DVec3::ONE), turns in [any_turn(), any_turn()],
        t in prop::array::uniform3(-0.5f64..0.5), scale in -9i32..=9, ratio in -6i32..=0,
        far in prop::sample::select(vec![0.0, 1.0, 1e9]),
    ) {
        let sized = |shape: &Polytope, size: f64| {
            Polytope::hull(shape.vertices().iter().map(|&v| v * size).collect()).unwrap()
        };
        let size = 10f64.powi(scale);
        let [p, q] = turns;
        let out = DVec3::splat(far * size);
        let place = Pose::new(q, out + DVec3::from(t) * size).unwrap();
        let small = sized(&b, size * 10f64.powi(ratio));
        judge_sized(&(sized(&a, size), Pose::new(p, out).unwrap()), &(small, place), size)?;
    }

    #[test]
    fn rounded_plates_in_one_plane_have_their_exact_depth(
        a in points(DVec3::new(1.0, 0.1, 0.0), 3..6), b in points(DVec3::new(0.1, 1.0, 0.0), 3..6),
        t in prop::array::uniform2(-1.5f64..1.5), share in 0.0f64..2.0,
    ) {
        judge_rounded(&(a, Pose::IDENTITY), &(b, at(t[0], t[1], 0.0)), share)?;
    }

    #[test]
    fn rounded_ellipses_in_one_plane_overlap_by_their_radii_less_their_distance(
        tilts in [0.0f64..3.2, 0.0f64..3.2], t in prop::array::uniform2(-1.0f64..1.0),
    ) {
        let [a, b] = tilts.map(ellipse);
        let place = Pose::from_translation(in_plane(t[0], t[1])).unwrap();
        let (body_a, body_b) = (PosedSupport::polytope(&a, &Pose::IDENTITY), PosedSupport::polytope(&b, &place));
        if let (DistanceResult::Apart(gap), _) = distance::of_polytopes(body_a, body_b) {
            let gap = gap.distance;
            let b = b.rounded(2.0 * gap).unwrap();
            let found = touching(&(a, Pose::IDENTITY), &(b, place));
            prop_assert!((found.depth - gap).abs() <= 1e-12 * gap + 1e-16, "{found:?}, {gap}");
            let across = found.normal.dot(DVec3::new(1.0, 2.0, -1.0));
            prop_assert!(found.error_bound <= 1e-12 && across.abs() < 1e-12);
        }
    }

    #[test]
    fn boxes_bisected_to_the_last_overlap_have_their_exact_depth(
        half in [prop::array::uniform3(0.1f64..1.0), prop::array::uniform3(0.1f64..1.0)],
        turns in [any_turn(), any_turn()], way in prop::array::uniform3(-1.0f64..1.0),
    ) {
        let [a, b] = half.map(|h| Polytope::cuboid(h.into()).unwrap());
        let a = (a, Pose::new(turns[0], DVec3::ZERO).unwrap());
        let (mut touch, mut apart) = (0.0, 100.0);
        let place = |s: f64| Pose::new(turns[1], DVec3::from(way).normalize_or(DVec3::X) * s);
        while (touch + apart) * 0.5 != touch && (touch + apart) * 0.5 != apart {
            let middle = (touch + apart) * 0.5;
            match solve(&a, &(b.clone(), place(middle).unwrap())) {
                Verdict::Apart => apart = middle,
                _ => touch = middle,
            }
        }
        for s in [touch, apart, touch * 0.999_999_999] {
            judge(&a, &(b.clone(), place(s).unwrap()))?;
        }
    }
}

/// The point of the plane z = x + 2y over two coordinates, which are rounded so that it is exact.
fn in_plane(x: f64, y: f64) -> DVec3 {
    let [x, y] = [x, y].map(|x| (x * 1048576.0).round() / 1048576.0);
    DVec3::new(x, y, x + 2.0 * y)
}

/// A slim ellipse of 24 corners in that plane.
fn ellipse(tilt: f64) -> Polytope {
    let corner = |k: i32| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 24.0).sin_cos();
        let (x, y) = (0.8 * cos, 0.15 * sin);
        let (sin, cos) = tilt.sin_cos();
        in_plane(x * cos - y * sin, x * sin + y * cos)
    };
    Polytope::hull((0..24).map(corner).collect()).unwrap()
}

/// Radii that leave some overlap, down to an ulp or none, of whatever the cores' distance is.
fn judge_rounded(a: &PosedShape, b: &PosedShape, share: f64) -> Result<(), TestCaseError> {
    let truth = Truth::of((&a.0, &a.1), (&b.0, &b.1));
    let distance = (-truth.value()).max(0.0);
    let radius = (distance * (1.0 + share)).next_up().next_up();
    let round =
        |(map, pose): &PosedShape, radius: f64| (map.clone().rounded(radius).unwrap(), *pose);
    // In two parts whose sum is exact: the oracle takes one radius.
    let part = radius * 0.75;
    let (a, b) = (round(a, part), round(b, radius - part));
    let value = truth.rounded_by(radius).value();
    match solve(&a, &b) {
        Verdict::Touching(found) => {
            let Depth { depth, error_bound, .. } = found;
            prop_assert!(value >= 0.0);
            prop_assert!((depth - value).abs() <= error_bound + 1e-15 * value);
            let size = radius + a.0.reach() + b.0.reach();
            let promised = PROMISED * value + 1e-22 * size;
            prop_assert!((depth - value).abs() <= promised, "{found:?}, {value}");
            prop_assert!(error_bound <= PROMISED * depth + 1e-12 * size, "{error_bound}");
            let between = found.point_a - found.point_b;
            prop_assert!(between.distance(found.normal * depth) <= 1e-12, "{found:?}, {distance}");
        }
        verdict => prop_assert!(verdict == Verdict::Apart && value < 0.0, "{verdict:?}, {value}"),
    }
    Ok(())
}

fn judge_sized(a: &PosedShape, b: &PosedShape, size: f64) -> Result<(), TestCaseError> {
    let truth = Truth::of((&a.0, &a.1), (&b.0, &b.1));
    let value = truth.value();
    let verdict = solve(a, b);
    let Verdict::Touching(Depth { depth, error_bound, .. }) = verdict else {
        prop_assert!(!truth.touches() && verdict == Verdict::Apart, "{verdict:?}, {value}");
        return Ok(());
    };
    prop_assert!(truth.touches() && truth.is_within(depth - error_bound, depth + error_bound));
    prop_assert!((depth - value).abs() <= PROMISED * value + 1e-21 * size);
    prop_assert!(error_bound <= PROMISED * depth + 1e-20 * size, "{error_bound}, {depth}");
    Ok(())
}
