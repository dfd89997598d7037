//! Numbers at the ends of their range, and shapes that make the most work.

use super::*;
use proptest::prelude::*;

fn is_sound(depth: &Depth) -> bool {
    let points = depth.normal.is_finite() && depth.point_a.is_finite() && depth.point_b.is_finite();
    points
        && depth.depth.is_finite()
        && depth.depth >= 0.0
        && depth.error_bound.is_finite()
        && depth.error_bound >= 0.0
        && (depth.normal.length() - 1.0).abs() < 1e-12
}

/// Any finite number, the special ones often.
fn number() -> impl Strategy<Value = f64> {
    let special = vec![
        0.0,
        -0.0,
        1.0,
        -1.0,
        f64::MAX,
        f64::MIN,
        f64::MIN_POSITIVE,
        5e-324,
        -5e-324,
        1e-310,
        1e300,
        -1e300,
        1e-160,
        1e160,
        1.0 + f64::EPSILON,
        0.1,
    ];
    prop_oneof![
        3 => prop::sample::select(special),
        1 => prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO,
        2 => -1.0f64..1.0,
    ]
}

fn any_hull() -> impl Strategy<Value = Polytope> {
    let points = prop::collection::vec(prop::array::uniform3(number()), 1..7);
    (points, prop_oneof![2 => Just(0.0), 1 => number().prop_map(f64::abs)])
        .prop_map(|(points, radius)| hull(&points).rounded(radius).unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_finite_input_makes_nan_or_panics(
        a in any_hull(), b in any_hull(), t in [number(), number(), number()],
        q in prop::array::uniform4(-1.0f64..1.0),
    ) {
        let q = dcd_geom::glam::DQuat::from_array(q);
        let turned = Pose::new(q.normalize(), t.into()).unwrap_or(Pose::IDENTITY);
        let (a, b) = ((a, Pose::IDENTITY), (b, turned));
        let found = overlap(&a, &b);
        prop_assert!(is_sound(&found), "{found:?}");
        if let Verdict::Touching(depth) = solve(&a, &b) {
            prop_assert!(is_sound(&depth), "{depth:?}");
        }
    }
}

#[test]
fn the_least_and_the_largest_numbers_have_their_depth() {
    let least = f64::from_bits(1);
    let tiny = Polytope::cuboid(DVec3::splat(4.0 * least)).unwrap();
    let found = touching(&(tiny.clone(), Pose::IDENTITY), &(tiny, at(6.0 * least, 0.0, 0.0)));
    assert!((found.depth - 2.0 * least).abs() <= found.error_bound, "{found:?}");
    let huge = Polytope::cuboid(DVec3::splat(f64::MAX / 8.0)).unwrap();
    let found = touching(&(huge.clone(), Pose::IDENTITY), &(huge, at(f64::MAX / 8.0, 0.0, 0.0)));
    assert!(found.depth == f64::MAX / 8.0 && !found.is_saturated());
}

#[test]
fn a_depth_that_no_f64_holds_is_known_from_below_and_marked() {
    let sphere = Polytope::sphere(f64::MAX).unwrap();
    let found = touching(&(sphere.clone(), Pose::IDENTITY), &(sphere, Pose::IDENTITY));
    assert!(found.depth == f64::MAX && found.is_saturated() && is_sound(&found), "{found:?}");
    assert_eq!((found.lower(), found.upper()), (0.0, f64::MAX));
}

/// Points of a spiral on the unit sphere.
fn spiral(count: usize) -> Polytope {
    let golden_angle = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let point = |k: usize| {
        let z = 1.0 - (2 * k + 1) as f64 / count as f64;
        let (sin, cos) = (golden_angle * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    };
    Polytope::hull((0..count).map(point).collect()).unwrap()
}

#[test]
fn concentric_spirals_end_with_bounds_that_hold() {
    // All facets are nearly as far: the most work there is.
    let sphere = spiral(300);
    let found = touching(&(sphere.clone(), Pose::IDENTITY), &(sphere, Pose::IDENTITY));
    assert!(found.depth < 2.0 && found.depth > 1.9 && is_sound(&found), "{found:?}");
}

#[test]
fn memory_that_was_used_before_changes_no_bit() {
    let pairs: Vec<(PosedShape, PosedShape)> = (1..30)
        .map(|k| {
            let turn = dcd_geom::glam::DQuat::from_rotation_y(0.1 * f64::from(k));
            let place = Pose::new(turn, DVec3::new(0.02 * f64::from(k), 0.1, 0.0)).unwrap();
            ((spiral(5 + 7 * k as usize % 40), Pose::IDENTITY), (cube(), place))
        })
        .collect();
    let mut scratch = Scratch::default();
    for (a, b) in &pairs {
        let (a_body, b_body) =
            (PosedSupport::polytope(&a.0, &a.1), PosedSupport::polytope(&b.0, &b.1));
        assert_eq!(epa::depth(a_body, b_body, &mut scratch), solve(a, b));
    }
}
