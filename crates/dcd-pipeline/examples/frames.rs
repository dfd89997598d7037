//! Objects move, the pipeline and its buffers stay.

use dcd_pipeline::geom::glam::{DQuat, DVec3};
use dcd_pipeline::{Par, Pipeline, Pose, Scene, Shape};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count = 1000;
    let shapes = vec![Shape::cuboid(DVec3::new(0.5, 0.3, 0.2))?; count];
    let mut scene = Scene::one_each(shapes, vec![Pose::IDENTITY; count])?;
    let mut pipeline = Pipeline::new();
    for frame in 0..10 {
        let time = f64::from(frame) * 0.1;
        for i in 0..count {
            scene.set_pose(i, orbit(i as f64, time)?)?;
        }
        let step = pipeline.step(&scene, Par::Pool);
        let (candidates, contacts) = (step.candidate_count(), step.contact_count());
        println!("frame {frame}: {candidates} candidate pairs, {contacts} contacts");
        assert!(contacts > 0 && step.report().undecided().is_empty());
    }
    Ok(())
}

/// Where object i is at that time: each on a circle of its own.
fn orbit(i: f64, time: f64) -> Result<Pose, dcd_pipeline::geom::PoseError> {
    let angle = i * 2.4 + time / (1.0 + i * 0.01);
    let radius = i.sqrt() * 0.4;
    let at = DVec3::new(radius * angle.cos(), radius * angle.sin(), (i * 0.7).sin());
    Pose::new(DQuat::from_rotation_y(angle), at)
}
