//! Which of a few shapes touch? Every answer is proved.

use dcd_pipeline::geom::glam::{DQuat, DVec3};
use dcd_pipeline::{Par, Pipeline, Pose, Scene, Shape};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let tetrahedron = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let shapes =
        vec![Shape::cuboid(DVec3::splat(0.5))?, Shape::sphere(0.5)?, Shape::hull(tetrahedron)?];
    let turned = DQuat::from_rotation_z(0.3);
    let poses = vec![
        Pose::from_translation(DVec3::ZERO)?,
        Pose::from_translation(DVec3::new(1.0, 0.0, 0.0))?,
        Pose::new(turned, DVec3::new(0.0, 2.0, 0.0))?,
    ];
    let scene = Scene::one_each(shapes, poses)?;

    let mut pipeline = Pipeline::new();
    let step = pipeline.step(&scene, Par::Pool);
    for (i, j) in step.contacts() {
        println!("objects {i} and {j} touch");
    }
    // The box and the sphere touch in exactly one point; the tetrahedron is away from both.
    assert_eq!(step.contacts().collect::<Vec<_>>(), [(0, 1)]);
    Ok(())
}
