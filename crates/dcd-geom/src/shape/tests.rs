use super::*;
use glam::DQuat;

#[test]
fn the_box_of_a_turned_cube_holds_its_corners() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let turned = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_4);
    let aabb = cube.aabb(&Pose::new(turned, DVec3::new(10.0, 0.0, 0.0)).unwrap());
    let half = 0.5f64.sqrt();
    assert!(f64::from(aabb.max.x) >= 10.0 + half && f64::from(aabb.max.x) < 10.0 + half + 1e-5);
    assert!(f64::from(aabb.min.z) <= -0.5);
}

#[test]
fn a_custom_shape_has_the_box_of_the_shape_behind_it() {
    let pose = Pose::new(DQuat::from_rotation_x(0.3), DVec3::ONE).unwrap();
    let sphere = Polytope::sphere(2.0).unwrap();
    let custom = Shape::custom(Arc::new(sphere.clone())).unwrap().aabb(&pose);
    assert!(custom.contains(&Aabb::outward(DVec3::splat(-1.0), DVec3::splat(3.0))));
    assert_eq!(custom, Shape::from(sphere).aabb(&pose));
}

#[test]
fn a_swept_shape_has_the_sum_of_the_radii_and_no_bad_one() {
    let sphere = Shape::sphere(0.5).unwrap();
    let custom = Shape::custom(Arc::new(Polytope::sphere(0.5).unwrap())).unwrap();
    for shape in [sphere, custom] {
        assert_eq!(shape.swept(0.25).unwrap().radius(), 0.75);
        assert!(shape.swept(-0.25).is_err() && shape.swept(f64::NAN).is_err());
        assert!(shape.swept(f64::MAX).is_ok_and(|s| s.radius() == f64::MAX));
    }
}

#[test]
fn every_kind_is_rounded_by_the_radius_given() {
    let sphere: Arc<dyn SupportMap<f64>> = Arc::new(Polytope::sphere(2.0).unwrap());
    let shapes = [
        Shape::capsule(1.0, 0.5),
        Shape::cuboid(DVec3::ONE),
        Shape::cylinder(1.0, 0.5),
        Shape::cone(1.0, 0.5),
        Shape::ellipsoid(DVec3::new(1.0, 0.5, 0.25)),
        Shape::half_space(DVec3::Z, 0.0),
        Shape::custom(sphere),
    ];
    for shape in shapes.map(Result::unwrap) {
        assert_eq!(shape.clone().rounded(0.125).unwrap().radius(), 0.125);
        assert!(shape.rounded(f64::NAN).is_err());
    }
}

#[test]
fn the_boxes_of_curved_shapes_hold_their_rims() {
    let pose = Pose::new(DQuat::from_rotation_x(0.3), DVec3::ONE).unwrap();
    for shape in [Shape::cylinder(1.0, 0.5), Shape::cone(1.0, 0.5)].map(Result::unwrap) {
        let aabb = shape.aabb(&pose);
        for k in 0..100 {
            let (sin, cos) = (f64::from(k) * 0.0628).sin_cos();
            let rim = pose.apply(DVec3::new(0.5 * cos, 0.5 * sin, -1.0));
            assert!(aabb.contains(&Aabb::outward(rim, rim)), "{shape:?} {rim}");
        }
        let rounded = shape.rounded(0.25).unwrap().aabb(&pose);
        assert!((rounded.min.x - aabb.min.x + 0.25).abs() < 1e-5);
    }
}

#[test]
fn the_boxes_of_curved_shapes_are_those_that_their_supports_give() {
    let turns = [(0.0, 0.0), (0.3, -1.2), (2.9, 0.7), (std::f64::consts::FRAC_PI_2, 0.0)];
    let sizes = [(1.0, 0.5), (0.0, 2.0), (3.0, 0.0), (1e-3, 40.0)];
    for ((a, b), (half_height, radius)) in
        turns.into_iter().flat_map(|turn| sizes.map(|size| (turn, size)))
    {
        let turn = DQuat::from_rotation_x(a) * DQuat::from_rotation_y(b);
        let pose = Pose::new(turn, DVec3::new(1.0, -2.0, 0.5)).unwrap();
        let curved = [Curved::cylinder(half_height, radius), Curved::cone(half_height, radius)];
        for curved in curved.map(Result::unwrap) {
            let plain = Shape::custom(Arc::new(curved)).unwrap().aabb(&pose);
            let closed = Shape::from(curved).aabb(&pose);
            let off = (plain.min - closed.min).abs().max((plain.max - closed.max).abs());
            assert!(off.max_element() < 1e-5, "{curved:?} {plain:?} {closed:?}");
        }
    }
}

#[test]
fn the_box_of_an_ellipsoid_touches_its_surface_on_all_six_sides() {
    let half = DVec3::new(1.0, 2.0, 0.25);
    let ellipsoid = Shape::ellipsoid(half).unwrap();
    let turn = DQuat::from_rotation_x(0.3) * DQuat::from_rotation_y(-1.2);
    let pose = Pose::new(turn, DVec3::ONE).unwrap();
    let aabb = ellipsoid.aabb(&pose);
    // The norms of the rows of R·diag(a, b, c).
    let rows = (*pose.rotation() * glam::DMat3::from_diagonal(half)).transpose();
    let reach = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
    let off = (aabb.max.as_dvec3() - 1.0 - reach).abs();
    assert!(off.max_element() < 1e-6 && aabb.max.as_dvec3().cmpge(reach + 1.0).all());
    assert!(aabb.min.as_dvec3().cmple(1.0 - reach).all());
}

#[test]
fn a_custom_shape_that_answers_nan_is_refused() {
    struct Nan;
    impl SupportMap<f64> for Nan {
        fn support(&self, _: DVec3) -> Support<f64> {
            Support { point: DVec3::NAN, feature: 0 }
        }
    }
    assert!(matches!(Shape::custom(Arc::new(Nan)), Err(ShapeError::NotFinite { vertex: 0, .. })));
}
