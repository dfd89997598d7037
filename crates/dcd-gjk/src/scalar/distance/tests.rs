mod tiny_gaps;

use super::*;
use dcd_geom::Pose;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

fn measure(a: &Shape, pose_a: &Pose, b: &Shape, pose_b: &Pose) -> Distance {
    let (a, b) = (PosedShape { shape: a, pose: pose_a }, PosedShape { shape: b, pose: pose_b });
    let (result, _) = distance(a, b);
    assert_eq!(result, distance(b, a).0.mirrored());
    match result {
        DistanceResult::Apart(found) => found,
        other => panic!("{other:?}"),
    }
}

#[test]
fn cubes_have_the_distance_of_their_faces_edges_and_corners() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let origin = at(0.0, 0.0, 0.0);
    let face = measure(&cube, &origin, &cube, &at(3.0, 0.25, 0.0));
    assert_eq!((face.distance, face.normal), (2.0, DVec3::X));
    assert_eq!((face.point_a.x, face.point_b.x), (0.5, 2.5));
    assert_eq!(face.point_a.with_x(0.0), face.point_b.with_x(0.0));
    let edge = measure(&cube, &origin, &cube, &at(4.0, 5.0, 0.0));
    assert_eq!((edge.distance, edge.normal), (5.0, DVec3::new(0.6, 0.8, 0.0)));
    let corner = measure(&cube, &origin, &cube, &at(2.0, 3.0, 3.0));
    assert_eq!((corner.distance, corner.point_a), (3.0, DVec3::splat(0.5)));
    assert_eq!(corner.point_b, DVec3::new(1.5, 2.5, 2.5));
}

#[test]
fn gaps_far_below_f64s_rounding_are_measured() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let origin = at(0.0, 0.0, 0.0);
    let gap = 2f64.powi(-52);
    let found = measure(&cube, &origin, &cube, &at(1.0 + gap, 0.0, 0.0));
    assert_eq!((found.distance, found.normal), (gap, DVec3::X));
    // Two points of one line, 1e-200 apart, beside a third one far away.
    let a = Shape::hull(vec![DVec3::ZERO, DVec3::new(-1.0, 0.0, 0.0)]).unwrap();
    let b = Shape::hull(vec![DVec3::new(1e-200, 0.0, 0.0), DVec3::X]).unwrap();
    let found = measure(&a, &origin, &b, &origin);
    assert!((found.distance - 1e-200).abs() <= found.error_bound);
    assert!(found.error_bound < 1e-214);
}

#[test]
fn radii_shorten_the_distance_and_move_the_points() {
    let sphere = Shape::sphere(1.0).unwrap();
    let found = measure(&sphere, &at(0.0, 0.0, 0.0), &sphere, &at(0.0, 3.0, 4.0));
    assert_eq!((found.distance, found.normal), (3.0, DVec3::new(0.0, 0.6, 0.8)));
    assert_eq!(found.point_a, found.normal);
    let near = 2.0f64.next_up();
    let found = measure(&sphere, &at(0.0, 0.0, 0.0), &sphere, &at(near, 0.0, 0.0));
    assert_eq!(found.distance, near - 2.0);
}

#[test]
fn touching_and_overlapping_shapes_have_no_distance() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let sphere = Shape::sphere(0.5).unwrap();
    let origin = at(0.0, 0.0, 0.0);
    for x in [0.0, 0.5, 1.0 - 1e-16, 1.0] {
        let there = at(x, 0.0, 0.0);
        for shape in [&cube, &sphere] {
            let (a, b) =
                (PosedShape { shape: &cube, pose: &origin }, PosedShape { shape, pose: &there });
            assert_eq!(distance(a, b).0, DistanceResult::Touching);
        }
    }
}

#[test]
fn a_foreign_shape_has_its_distance_within_its_support_error() {
    struct Vague(Polytope);
    impl SupportMap<f64> for Vague {
        fn support(&self, direction: DVec3) -> dcd_geom::Support<f64> {
            self.0.support(direction)
        }
        fn support_error(&self) -> f64 {
            1e-3
        }
    }
    let cube = Polytope::cuboid(DVec3::splat(0.5)).unwrap();
    let vague = Shape::custom(std::sync::Arc::new(Vague(cube.clone()))).unwrap();
    let found = measure(&vague, &at(0.0, 0.0, 0.0), &cube.into(), &at(2.0, 0.0, 0.0));
    assert!((found.distance - 1.0).abs() < 1e-12);
    assert!((1e-3..1e-2).contains(&found.error_bound));
}

#[test]
fn f64_alone_states_its_bound() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let origin = at(0.0, 0.0, 0.0);
    let there = at(1.0 + 1e-9, 0.1, 0.0);
    let (a, b) =
        (PosedShape { shape: &cube, pose: &origin }, PosedShape { shape: &cube, pose: &there });
    let DistanceResult::Apart(found) = in_f64(a, b) else { panic!() };
    assert!((found.distance - 1e-9).abs() <= found.error_bound && found.error_bound < 1e-13);
    let there = at(1.0 + 1e-15, 0.1, 0.0);
    let b = PosedShape { shape: &cube, pose: &there };
    let DistanceResult::Interval { reason, within, depth } = in_f64(a, b) else { panic!() };
    assert!(reason == Reason::WithinRounding && within.distance == 0.0, "{within:?}");
    assert!(within.normal.dot(DVec3::X) > 0.9, "{within:?}");
    assert!((1.1e-15..1e-14).contains(&within.error_bound) && depth < 1e-14, "{within:?} {depth}");
    let DistanceResult::Interval { within: other, .. } = in_f64(b, a) else { panic!() };
    assert_eq!(other, within.mirrored());
}

#[test]
fn a_distance_that_no_f64_holds_is_known_from_below_and_marked() {
    let point = Shape::sphere(0.0).unwrap();
    let (low, high) = (at(-f64::MAX, 0.0, 0.0), at(f64::MAX, 0.0, 0.0));
    let found = measure(&point, &low, &point, &high);
    assert_eq!((found.distance, found.normal), (f64::MAX, DVec3::X));
    assert!(found.is_saturated() && found.lower() == f64::MAX && found.upper() == f64::MAX);
    assert!(found.point_a.is_finite() && found.point_b.is_finite());
    let found = measure(&point, &at(0.0, 0.0, 0.0), &point, &high);
    assert!(found.distance == f64::MAX && !found.is_saturated());
}
