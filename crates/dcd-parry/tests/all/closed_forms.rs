//! Pairs whose answer is known by hand, in every way and in both precisions.

use crate::common::{answers, assert_all, two};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Polytope, Pose, Shape};
use std::f64::consts::FRAC_PI_4;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(DVec3::new(x, y, z)).unwrap()
}

#[test]
fn spheres_touch_up_to_the_sum_of_their_radii() {
    let (small, large) = (Shape::sphere(0.5).unwrap(), Shape::sphere(1.5).unwrap());
    let along = DVec3::new(1.0, 2.0, 2.0) / 3.0;
    for (distance, touching) in [(0.0, true), (1.0, true), (1.999, true), (2.001, false)] {
        let there = Pose::from_translation(along * distance).unwrap();
        assert_all((&small, Pose::IDENTITY), (&large, there), touching);
    }
}

#[test]
fn cuboids_touch_edge_to_edge_up_to_their_diagonals() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    // Turned about z and about y: an edge along z against an edge along y.
    let a = Pose::new(DQuat::from_rotation_z(FRAC_PI_4), DVec3::ZERO).unwrap();
    for (gap, touching) in [(-1e-3, true), (1e-3, false)] {
        let distance = DVec3::X * (2f64.sqrt() + gap);
        let b = Pose::new(DQuat::from_rotation_y(FRAC_PI_4), distance).unwrap();
        assert_all((&cube, a), (&cube, b), touching);
    }
}

#[test]
fn a_hull_is_met_where_its_face_is() {
    let corners = |k: u32| DVec3::new((k & 1).into(), (k >> 1 & 1).into(), (k >> 2).into());
    let cube = Shape::hull((0..8).map(corners).collect()).unwrap();
    let sphere = Shape::sphere(0.25).unwrap();
    let cuboid = Shape::cuboid(DVec3::splat(0.25)).unwrap();
    for (gap, touching) in [(-1e-3, true), (1e-3, false)] {
        let above = at(0.3, 0.4, 1.25 + gap);
        assert_all((&cube, Pose::IDENTITY), (&sphere, above), touching);
        assert_all((&cube, Pose::IDENTITY), (&cuboid, above), touching);
        assert_all((&cube, Pose::IDENTITY), (&cube, at(1.0 + gap, 0.3, -0.2)), touching);
    }
}

#[test]
fn a_radius_is_added_to_hulls_and_cuboids() {
    let cube = Polytope::cuboid(DVec3::splat(0.5)).unwrap();
    let hull = Polytope::hull(cube.vertices().to_vec()).unwrap();
    let [cube, hull] = [cube, hull].map(|core| Shape::from(core.rounded(0.125).unwrap()));
    for (gap, touching) in [(-1e-3, true), (1e-3, false)] {
        // Corner to corner, where a box grown by the radius would touch earlier.
        let corner = DVec3::splat(1.0 + (0.25 + gap) / 3f64.sqrt());
        let there = Pose::from_translation(corner).unwrap();
        for a in [&cube, &hull] {
            for b in [&cube, &hull] {
                assert_all((a, Pose::IDENTITY), (b, there), touching);
            }
        }
    }
}

#[test]
fn touching_cuboids_are_a_contact() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let scene = two((&cube, Pose::IDENTITY), (&cube, at(1.0, 0.0, 0.0)));
    for (way, answer) in answers::<f64>(&scene) {
        assert_eq!(answer, Ok(true), "{way}");
    }
}
