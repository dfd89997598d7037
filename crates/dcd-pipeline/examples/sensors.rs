//! A gate that notices who passes: what touches a sensor is no contact, and is never measured.

use dcd_pipeline::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let at = |x: f64| Pose::from_translation(DVec3::X * x);
    let shapes = vec![Shape::cuboid(DVec3::new(0.1, 2.0, 2.0))?, Shape::sphere(0.5)?];
    let gate = Object::new(0, at(0.0)?).fixed().as_sensor();
    let mut scene = Scene::new(shapes, [gate, Object::new(1, at(-2.0)?)])?;

    let (mut pipeline, mut passing) = (Pipeline::new(), Events::default());
    for frame in 0..40 {
        scene.set_pose(1, at(-2.0 + 0.1 * f64::from(frame))?)?;
        let step = pipeline.step(&scene, Par::Serial);
        assert_eq!(step.contact_count(), 0);
        passing.follow_sensors(&scene, &step, Par::Serial)?;
        for event in passing.iter().filter(|event| event.change != Change::Stay) {
            println!("frame {frame}: {:?}", event.change);
        }
    }
    Ok(())
}
