use super::*;
use dcd_geom::Pose;
use dcd_geom::glam::{DQuat, DVec3};

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

fn judge(a: &Polytope, pose_a: &Pose, b: &Polytope, pose_b: &Pose) -> (Verdict<()>, Method) {
    let (a, b) = (PosedSupport::polytope(a, pose_a), PosedSupport::polytope(b, pose_b));
    let answer = overlap(a, b);
    assert_eq!(answer, overlap(b, a));
    answer
}

fn cube(half: f64) -> Polytope {
    Polytope::cuboid(DVec3::splat(half)).unwrap()
}

const TOUCHING: Verdict<()> = Verdict::Touching(());

#[test]
fn touching_faces_edges_and_corners_are_a_contact_and_a_float_more_is_not() {
    for scale in [1.0, 2f64.powi(-30), 2f64.powi(40), 2f64.powi(-1000), 2f64.powi(1000)] {
        let cube = cube(0.5 * scale);
        let origin = at(0.0, 0.0, 0.0);
        for axis in [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE, DVec3::new(1.0, 0.25, -0.5)] {
            let there =
                |x: f64| Pose::from_translation(DVec3::new(x, axis.y * scale, axis.z * scale));
            let touching = judge(&cube, &origin, &cube, &there(scale).unwrap());
            assert_eq!(touching, (TOUCHING, Method::Exact));
            let apart = judge(&cube, &origin, &cube, &there(scale.next_up()).unwrap());
            assert_eq!(apart.0, Verdict::Apart);
            let inside = judge(&cube, &origin, &cube, &there(scale.next_down()).unwrap());
            assert_eq!(inside.0, TOUCHING);
        }
    }
}

#[test]
fn denormal_and_near_overflow_hulls_are_judged() {
    let tiny = f64::from_bits(1);
    for (half, step) in [(4.0 * tiny, 8.0 * tiny), (f64::MAX / 8.0, f64::MAX / 4.0)] {
        let cube = cube(half);
        let origin = at(0.0, 0.0, 0.0);
        assert_eq!(judge(&cube, &origin, &cube, &at(0.0, step, 0.0)).0, TOUCHING);
        assert_eq!(judge(&cube, &origin, &cube, &at(0.0, step.next_up(), 0.0)).0, Verdict::Apart);
    }
    let mixed = Polytope::hull(vec![DVec3::splat(tiny), DVec3::splat(f64::MAX / 16.0)]).unwrap();
    let point = Polytope::hull(vec![DVec3::splat(1.0)]).unwrap();
    let turned = Pose::new(DQuat::from_rotation_x(1e-9), DVec3::ZERO).unwrap();
    assert_eq!(judge(&mixed, &at(0.0, 0.0, 0.0), &point, &at(0.0, 0.0, 0.0)).0, TOUCHING);
    assert_eq!(judge(&mixed, &turned, &point, &at(0.0, 0.0, 0.0)).0, Verdict::Apart);
}

#[test]
fn flat_and_collinear_hulls_and_points_are_judged() {
    let square = Polytope::cuboid(DVec3::new(1.0, 1.0, 0.0)).unwrap();
    let line = Polytope::hull(vec![-DVec3::X, DVec3::X, DVec3::ZERO]).unwrap();
    let point = Polytope::hull(vec![DVec3::ZERO; 3]).unwrap();
    let origin = at(0.0, 0.0, 0.0);
    for shape in [&square, &line, &point] {
        for other in [&square, &line, &point] {
            assert_eq!(judge(shape, &origin, other, &origin).0, TOUCHING);
            let above = at(0.0, 0.0, 1e-300);
            assert_eq!(judge(shape, &origin, other, &above).0, Verdict::Apart);
        }
    }
    assert_eq!(judge(&line, &at(2.0, 0.0, 0.0), &line, &origin).0, TOUCHING);
    assert_eq!(judge(&line, &at(2.0f64.next_up(), 0.0, 0.0), &line, &origin).0, Verdict::Apart);
}

#[test]
fn rounded_hulls_are_judged_by_their_radii_exactly() {
    let sphere = Polytope::sphere(0.75).unwrap();
    let rounded = cube(0.5).rounded(0.25).unwrap();
    let origin = at(0.0, 0.0, 0.0);
    assert_eq!(judge(&sphere, &origin, &sphere, &at(1.5, 0.0, 0.0)), (TOUCHING, Method::Exact));
    assert_eq!(judge(&sphere, &origin, &sphere, &at(1.5f64.next_up(), 0.0, 0.0)).0, Verdict::Apart);
    assert_eq!(judge(&sphere, &origin, &rounded, &at(0.25, 1.5, 0.0)).0, TOUCHING);
    assert_eq!(
        judge(&sphere, &origin, &rounded, &at(0.25, 1.5f64.next_up(), 0.0)).0,
        Verdict::Apart
    );
    // Edge to sphere: 3-4-5, but for the rounding of 1.1 and 1.3.
    let edge = at(0.5 + 0.6, 0.5 + 0.8, 0.0);
    assert_eq!(judge(&rounded, &origin, &sphere, &edge).0, sphere_on_edge());
    // Radii far larger than their cores, and cores far larger than their radii.
    let dot = Polytope::hull(vec![DVec3::splat(1e-20)]).unwrap().rounded(1e20).unwrap();
    assert_eq!(judge(&dot, &origin, &dot, &at(2e20, 0.0, 0.0)).0, TOUCHING);
    let thin = cube(1e10).rounded(1e-10).unwrap();
    assert_eq!(judge(&thin, &origin, &thin, &at(2e10, 0.0, 0.0)).0, TOUCHING);
    assert_eq!(judge(&thin, &origin, &thin, &at(2e10 + 1e-5, 0.0, 0.0)).0, Verdict::Apart);
}

/// x² + y² against 1, the square of 0.75 + 0.25, in integers of 2⁻⁶⁰.
fn sphere_on_edge() -> Verdict<()> {
    let grid = |x: f64| (x * 2f64.powi(60)) as i128;
    let (x, y) = (grid(0.5 + 0.6) - grid(0.5), grid(0.5 + 0.8) - grid(0.5));
    if x * x + y * y <= 1i128 << 120 { TOUCHING } else { Verdict::Apart }
}

#[test]
fn a_foreign_shape_is_undecided_within_its_support_error() {
    struct Vague(Polytope);
    impl SupportMap<f64> for Vague {
        fn support(&self, direction: DVec3) -> dcd_geom::Support<f64> {
            self.0.support(direction)
        }
        fn support_error(&self) -> f64 {
            1e-3
        }
    }
    let vague = Shape::custom(std::sync::Arc::new(Vague(cube(0.5)))).unwrap();
    let cube = Shape::from(cube(0.5));
    let origin = at(0.0, 0.0, 0.0);
    let judge = |x: f64| {
        let there = at(x, 0.0, 0.0);
        let (a, b) = (
            PosedShape { shape: &vague, pose: &origin },
            PosedShape { shape: &cube, pose: &there },
        );
        let answer = overlap_of(a, b);
        assert_eq!(answer, overlap_of(b, a));
        answer.0
    };
    assert_eq!(judge(1.1), Verdict::Apart);
    assert_eq!(judge(0.9), TOUCHING);
    assert_eq!(judge(1.0005), Verdict::Undecided(Reason::WithinRounding));
}
