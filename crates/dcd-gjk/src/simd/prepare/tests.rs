//! The boxes of meshes beside those of the scalar reference.

use crate::{NarrowPhase, Overlap, Sides};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Aabb, Pose, Scene, Shape};
use dcd_simd::Path;

fn boxes(scene: &Scene, path: Path) -> Vec<Aabb> {
    let narrow = Overlap::on(path);
    let mut frame = Default::default();
    let mut aabbs = vec![Aabb::EMPTY; scene.len()];
    let part = narrow.layout(scene, Sides::One, &mut frame);
    narrow.prepare(scene, 0, part, &mut aabbs);
    aabbs
}

/// A strip of so many triangles round a spiral.
fn strip(triangles: u32, size: f64, from: DVec3) -> Shape {
    let corner = |k: u32| {
        let t = f64::from(k);
        from + DVec3::new(t.sin(), (1.3 * t).cos() * 0.4, (0.7 * t).sin() * 2.0) * size
    };
    let corners = (0..triangles + 2).map(corner).collect();
    Shape::mesh(corners, (0..triangles).map(|k| [k, k + 1, k + 2]).collect()).unwrap()
}

#[test]
fn the_box_of_a_mesh_holds_its_corners_and_is_hardly_larger_than_its_plain_reference() {
    for size in [1e-9, 1e-3, 1.0, 1e6] {
        // One block of corners, one more than that, many times as many as are turned at once.
        let mut shapes: Vec<Shape> = [1, 14, 15, 900].map(|n| strip(n, size, DVec3::ZERO)).into();
        shapes.push(strip(60, size, DVec3::new(30.0, -8.0, 5.0) * size));
        shapes.push(shapes[3].clone().rounded(0.3 * size).unwrap());
        let poses = (0..40).map(|k| {
            let t = f64::from(k);
            let turn = DQuat::from_rotation_x(t) * DQuat::from_rotation_y(0.7 * t);
            Pose::new(turn, DVec3::new(t, -3.0 * t, 0.1) * size * f64::from(k % 3)).unwrap()
        });
        let poses: Vec<Pose> = poses.collect();
        let shapes = shapes.into_iter().cycle().take(poses.len()).collect();
        let scene = Scene::one_each(shapes, poses).unwrap();
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            for (i, aabb) in boxes(&scene, path).iter().enumerate() {
                let (shape, pose) = (scene.shape(i), &scene.poses()[i]);
                let reach = shape.reach() + pose.translation().abs().max_element();
                let Shape::Mesh(mesh) = shape else { panic!("{shape:?} is no mesh") };
                for &corner in mesh.points() {
                    let (at, radius) = (pose.apply(corner), mesh.swept_radius() - 1e-15 * reach);
                    let [low, high] = [at - radius, at + radius];
                    let holds = low.cmpge(aabb.min.as_dvec3()) & high.cmple(aabb.max.as_dvec3());
                    assert!(holds.all(), "{path:?} {i}: {aabb:?} does not hold {at}");
                }
                let (reference, slack) = (shape.aabb(pose), (1e-6 * reach) as f32);
                let larger = Aabb { min: reference.min - slack, max: reference.max + slack };
                assert!(larger.contains(aabb), "{path:?} {i}: {aabb:?}, {reference:?}");
            }
        }
    }
}

#[test]
fn boxes_are_the_same_on_every_path() {
    let half = DVec3::new(0.3, 0.2, 0.1);
    let cloud = (0..23).map(|k| {
        let t = f64::from(k);
        DVec3::new(t.sin(), (1.3 * t).cos() * 0.4, (0.7 * t).sin() * 2.0)
    });
    let kinds = [
        Shape::cuboid(half),
        Shape::cuboid(half).and_then(|cuboid| cuboid.rounded(0.07)),
        Shape::hull(cloud.collect()),
        Shape::capsule(0.3, 0.1),
        Shape::sphere(0.2),
        Shape::cylinder(0.3, 0.1),
        Shape::triangle([half, -half, DVec3::X]),
        Ok(strip(40, 0.2, DVec3::Y)),
    ];
    let kinds = kinds.map(Result::unwrap);
    // All kinds in one scene, and each in one of its own, which may have a form of its own.
    let scenes = (0..=kinds.len()).map(|only| {
        let poses = (0..200).map(|k| {
            let t = f64::from(k);
            let turn = DQuat::from_rotation_x(1.1 * t) * DQuat::from_rotation_y(0.7 * t);
            Pose::new(turn, DVec3::new(0.31 * t, -3.0 * t.sin(), 0.1 * t)).unwrap()
        });
        let poses: Vec<Pose> = poses.collect();
        let shapes =
            kinds.iter().enumerate().cycle().filter(|(k, _)| only == kinds.len() || only == *k);
        let shapes = shapes.map(|(_, shape)| shape.clone()).take(poses.len()).collect();
        Scene::one_each(shapes, poses).unwrap()
    });
    for (number, scene) in scenes.enumerate() {
        let bits = |path| {
            let numbers =
                |aabb: Aabb| [aabb.min, aabb.max].map(|end| end.to_array().map(f32::to_bits));
            boxes(&scene, path).into_iter().map(numbers).collect::<Vec<_>>()
        };
        let portable = bits(Path::Portable);
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            assert_eq!(bits(path), portable, "{number} {path:?}");
        }
    }
}
