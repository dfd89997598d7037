//! Regions to the last bit.

use dcd_geom::glam::DVec3;
use dcd_geom::{Pose, Scene, Shape};
use dcd_pipeline::prelude::*;
use dcd_pipeline::{Found, QueryFilter};

/// A triangle whose corner at that x is the first that a box below it meets.
fn at_or_after(x: f64) -> Shape {
    let corners = [[x, 0.1, 0.1], [x + 1.0, 0.3, 0.1], [x + 1.0, 0.1, 0.7]];
    Shape::triangle(corners.map(DVec3::from_array)).unwrap()
}

#[test]
fn a_box_ends_where_its_corners_are_to_the_last_bit() {
    // None of these boxes is a cuboid of f64's numbers round a centre of f64's.
    let ends = [0.3, 1e-3, 7.1, 1e5 + 0.1];
    for (k, end) in ends.into_iter().enumerate() {
        let shapes = vec![at_or_after(end), at_or_after(end.next_up())];
        let scene = Scene::one_each(shapes, vec![Pose::IDENTITY; 2]).unwrap();
        let mut pipeline = Pipeline::new();
        pipeline.step(&scene, Par::Serial);
        let queries = pipeline.queries(&scene).unwrap();
        let mut found = Vec::new();
        let corners = [DVec3::new(-0.1, -0.7, -1.3), DVec3::new(end, 0.9, 0.2)];
        // Also by the other two corners of the same diagonal.
        for corners in [corners, [corners[1], corners[0]]] {
            queries.in_box(corners, &QueryFilter::ALL, &mut found).unwrap();
            assert_eq!(found, [Found { object: 0, is_certain: true }], "{k}");
        }
        // A box without a width, at that corner alone.
        let corner = DVec3::new(end, 0.1, 0.1);
        queries.in_box([corner; 2], &QueryFilter::ALL, &mut found).unwrap();
        assert_eq!(found, [Found { object: 0, is_certain: true }], "{k}");
    }
}
