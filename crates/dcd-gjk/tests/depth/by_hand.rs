//! Cases whose depth is known without arithmetic.

use super::*;
use dcd_geom::glam::{DMat3, DQuat};
use dcd_judge::Truth;

#[test]
fn unit_cubes_have_the_depth_that_one_reads_off() {
    for (x, depth) in [(0.75, 0.25), (0.25, 0.75), (0.0, 1.0), (1.0, 0.0), (-0.75, 0.25)] {
        let found = touching(&(cube(), Pose::IDENTITY), &(cube(), at(x, 0.0, 0.0)));
        assert_eq!(found.depth, depth, "{x}: {found:?}");
        assert!(found.error_bound <= 1e-14);
        if x != 0.0 {
            assert_eq!(found.normal, DVec3::X * x.signum());
        }
        let between = found.point_a - found.point_b;
        assert!(between.distance(found.normal * depth) < 1e-15, "{found:?}");
        assert!(found.point_a.abs().max_element() <= 0.5);
    }
}

#[test]
fn a_gap_and_an_overlap_of_one_ulp_are_distinguished_from_touching() {
    let here = (cube(), Pose::IDENTITY);
    assert_eq!(solve(&here, &(cube(), at(1f64.next_up(), 0.3, 0.0))), Verdict::Apart);
    let least = touching(&here, &(cube(), at(1f64.next_down(), 0.3, 0.0)));
    assert_eq!(least.depth, f64::EPSILON / 2.0);
    assert!(least.error_bound <= 1e-12 * least.depth, "{least:?}");
    for (y, z) in [(0.3, 0.0), (1.0, 0.7), (1.0, 1.0), (-1.0, 1.0)] {
        let touch = touching(&here, &(cube(), at(1.0, y, z)));
        assert_eq!((touch.depth, touch.error_bound < 1e-300), (0.0, true));
        assert!(touch.point_a.distance(touch.point_b) < 1e-15);
    }
}

/// Capsules beside a cuboid, a capsule and a triangle in turns, deep by 1e-5 to 1e-13 of their size: f64 knows the distance of
/// the cores to 1e-16 of it, which is too little of the depth.
#[test]
fn hardly_touching_rounded_shapes_have_nine_digits_of_their_depth() {
    let capsule = Polytope::capsule(0.5, 0.5).unwrap();
    let corners = [DVec3::ZERO, DVec3::new(-0.2, 0.9, 1.0), DVec3::new(-0.1, -1.0, 0.8)];
    let others = [
        Polytope::cuboid(DVec3::new(0.25, 0.75, 0.5)).unwrap(),
        Polytope::capsule(0.4, 0.25).unwrap(),
        Polytope::mesh_triangle(corners.map(|corner| -corner)).unwrap(),
    ];
    let reach = [0.75, 0.75, 0.5];
    let mut measured = 0;
    for k in 0..120 {
        let (other, reach) = (&others[k % 3], reach[k % 3]);
        let depth = 10f64.powi(-5 - (k / 3 % 9) as i32);
        let lean = DVec3::new(0.3, -0.7, 0.4) * [0.0, 1e-11, 1e-9, 1e-7][k / 27 % 4];
        let turn = DQuat::from_scaled_axis(lean);
        let pose = Pose::new(turn, DVec3::new(reach - depth, 0.0, 0.002 * k as f64)).unwrap();
        let (a, b) = ((capsule.clone(), Pose::IDENTITY), (other.clone(), pose));
        let truth = Truth::of((&a.0, &a.1), (&b.0, &b.1));
        for (a, b) in [(&a, &b), (&b, &a)] {
            let Verdict::Touching(found) = solve(a, b) else { continue };
            assert!(
                truth.is_within(found.lower(), found.upper()),
                "{k}: {found:?} {}",
                truth.value()
            );
            assert!(found.error_bound <= 1e-9 * found.depth + 1e-22, "{k}: {found:?}");
            measured += 1;
        }
    }
    assert!(measured > 150, "{measured}");
}

#[test]
fn a_small_cube_deep_in_a_large_one_leaves_by_the_nearest_face() {
    let large = Polytope::cuboid(DVec3::splat(512.0)).unwrap();
    let small = Polytope::cuboid(DVec3::splat(0.0009765625)).unwrap();
    let found = touching(&(large, Pose::IDENTITY), &(small, at(0.0, -100.0, 3.0)));
    assert_eq!((found.depth, found.normal), (412.0009765625, -DVec3::Y));
}

#[test]
fn flat_shapes_have_depth_zero() {
    let square = hull(&[[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.]]);
    let triangle = hull(&[[0., 0., 0.], [5., 0., 0.], [0., 5., 0.]]);
    let found = touching(&(square.clone(), Pose::IDENTITY), &(triangle.clone(), Pose::IDENTITY));
    assert_eq!((found.depth, found.normal.abs()), (0.0, DVec3::Z));
    assert!(found.point_a.distance(found.point_b) < 1e-15);
    // Corner to corner, edge to edge, and next to each other.
    let here = (square.clone(), Pose::IDENTITY);
    for pose in [at(1., 1., 0.), at(1., -1., 0.), at(0.5, 1., 0.)] {
        let found = touching(&here, &(triangle.clone(), pose));
        assert_eq!(found.depth, 0.0);
        assert!(found.point_a.distance(found.point_b) < 1e-15, "{pose:?}");
    }
    for pose in [at(1f64.next_up(), 0., 0.), at(0., 0., 1e-300), at(0.5, 1.5, 0.)] {
        assert_eq!(solve(&here, &(triangle.clone(), pose)), Verdict::Apart, "{pose:?}");
    }
}

#[test]
fn flat_shapes_turned_alike_are_flat_within_rounding() {
    let square = hull(&[[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.]]);
    let turn = DQuat::from_xyzw(0.1, 0.2, 0.3, 0.9).normalize();
    let (a, b) = (Pose::new(turn, DVec3::ZERO).unwrap(), Pose::new(turn, DVec3::ZERO).unwrap());
    let found = overlap(&(square.clone(), a), &(square.clone(), b));
    assert!(found.depth <= found.error_bound && found.error_bound < 1e-20, "{found:?}");
    assert!((found.normal.dot(a.rotation().z_axis).abs() - 1.0).abs() < 1e-12);
    let far = Pose::new(turn, a.rotation().x_axis * 3.0).unwrap();
    assert_eq!(solve(&(square.clone(), a), &(square, far)), Verdict::Apart);
}

#[test]
fn segments_and_points_touch_or_do_not() {
    let segment = |p, q| (hull(&[p, q]), Pose::IDENTITY);
    let along_x = segment([-1., 0., 0.], [1., 0., 0.]);
    for other in [
        segment([0., -1., 0.], [0., 1., 0.]),
        segment([1., 0., 0.], [2., 0., 0.]),
        segment([0.5, 0., 0.], [0.75, 0., 0.]),
        segment([1., 0., 0.], [1., 5., 3.]),
        segment([1., 0., 0.], [1., 0., 0.]),
        along_x.clone(),
    ] {
        let found = touching(&along_x, &other);
        assert_eq!(found.depth, 0.0, "{other:?}");
        assert!(found.point_a.distance(found.point_b) < 1e-15, "{other:?}");
        assert!((found.normal.length() - 1.0).abs() < 1e-15);
    }
    for other in [
        segment([1.5, 0., 0.], [2., 0., 0.]),
        segment([0., 0., 1.], [0., 1., 1.]),
        segment([0., 1., 0.], [0., 2., 0.]),
        segment([2., 0., 0.], [2., 0., 0.]),
    ] {
        assert_eq!(solve(&along_x, &other), Verdict::Apart, "{other:?}");
    }
}

#[test]
fn points_repeated_a_hundred_times_are_one_point() {
    let many = (hull(&[[0.25, 0.5, 0.125]; 100]), Pose::IDENTITY);
    let found = touching(&(cube(), Pose::IDENTITY), &many);
    assert_eq!((found.depth, found.point_b), (0.0, DVec3::new(0.25, 0.5, 0.125)));
    let inside = (many.0.clone(), at(0.0, -0.125, 0.0));
    assert_eq!(touching(&(cube(), Pose::IDENTITY), &inside).depth, 0.125);
    assert_eq!(touching(&many, &many).depth, 0.0);
}

#[test]
fn spheres_overlap_by_their_radii_less_their_distance() {
    let sphere = |r| Polytope::sphere(r).unwrap();
    let found = touching(&(sphere(2.0), Pose::IDENTITY), &(sphere(3.5), at(3.0, 0.0, 4.0)));
    assert!((found.depth - 0.5).abs() <= found.error_bound && found.error_bound < 1e-13);
    assert!(found.normal.distance(DVec3::new(0.6, 0.0, 0.8)) < 1e-15);
    assert!(found.point_a.distance(found.normal * 2.0) < 1e-15);
    let concentric = touching(&(sphere(2.0), Pose::IDENTITY), &(sphere(3.5), Pose::IDENTITY));
    assert_eq!((concentric.depth, concentric.normal.length()), (5.5, 1.0));
    assert_eq!(
        solve(&(sphere(2.0), Pose::IDENTITY), &(sphere(2.9), at(3.0, 0.0, 4.0))),
        Verdict::Apart
    );
}

#[test]
fn radii_add_to_the_depth_of_cores_that_overlap_and_pay_for_the_gap_of_others() {
    let rounded = || cube().rounded(0.25).unwrap();
    let here = (rounded(), Pose::IDENTITY);
    for (place, depth) in [
        (at(0.75, 0.25, 0.), 0.25 + 0.5),
        (at(1.0, 0.25, 0.), 0.5),
        (at(1.125, 0.25, 0.), 0.375),
        // Edge to edge and corner to corner.
        (at(1.1875, 1.25, 0.5), 0.5 - 0.3125),
        (at(1.125, 1.125, 1.1875), 0.5 - 0.2576941016011037),
    ] {
        let found = touching(&here, &(rounded(), place));
        assert!((found.depth - depth).abs() <= found.error_bound, "{place:?}: {found:?}");
        assert!(found.error_bound < 1e-14);
        let between = found.point_a - found.point_b;
        assert!(between.distance(found.normal * found.depth) < 1e-15, "{found:?}");
    }
    assert_eq!(solve(&here, &(rounded(), at(1.53125, 0., 0.))), Verdict::Apart);
    assert_eq!(touching(&here, &(rounded(), at(1.5, 0.25, 0.))).depth, 0.0);
    assert_eq!(solve(&here, &(rounded(), at(1.5f64.next_up(), 0.25, 0.))), Verdict::Apart);
    let least = touching(&here, &(rounded(), at(1.5f64.next_down(), 0.25, 0.)));
    assert!((least.depth - f64::EPSILON).abs() < 1e-9 * least.depth, "{least:?}");
}

#[test]
fn rounded_plates_in_one_plane_have_the_depth_of_their_gap() {
    // Two edges a unit apart, then two corners at (3, 4); the difference is flat.
    let square = hull(&[[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.]]);
    let rounded = |radius| square.clone().rounded(radius).unwrap();
    for (place, gap) in [(at(3., 0.5, 0.), 1.0), (at(5., 6., 0.), 5.0), (at(-5., 6., 0.), 5.0)] {
        let (a, b) = (rounded(0.25 * gap), rounded(gap));
        let found = touching(&(a.clone(), Pose::IDENTITY), &(b, place));
        assert_eq!(found.depth, 0.25 * gap);
        assert!(found.error_bound < 1e-13 && found.normal.z == 0.0, "{found:?}");
        let short = (rounded(gap * 0.5), place);
        assert_eq!(solve(&(a, Pose::IDENTITY), &short), Verdict::Apart);
    }
    // On top of each other: the depth is all radius.
    let found = touching(&(rounded(0.25), Pose::IDENTITY), &(rounded(0.5), at(0.5, 0., 0.)));
    assert_eq!((found.depth, found.normal.abs()), (0.75, DVec3::Z));
}

#[test]
fn a_right_turn_changes_nothing() {
    let turn = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    let pose = Pose::from_matrix(turn, DVec3::new(0.25, 0.75, -0.125)).unwrap();
    let found = touching(&(cube(), Pose::IDENTITY), &(cube(), pose));
    assert_eq!((found.depth, found.normal), (0.25, DVec3::Y));
}
