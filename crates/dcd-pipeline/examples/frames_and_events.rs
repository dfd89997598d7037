//! Spheres slide over a floor that stands still: what begins and ends, who comes and goes.

use dcd_pipeline::geom::Object;
use dcd_pipeline::geom::glam::DVec3;
use dcd_pipeline::{Change, Events, Par, Pipeline, Pose, Scene, Shape};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let at = |x: f64, z: f64| Pose::from_translation(DVec3::new(x, 0.0, z));
    let shapes = vec![Shape::cuboid(DVec3::new(2.0, 2.0, 0.5))?, Shape::sphere(0.5)?];
    let mut scene = Scene::new(shapes, [Object::new(0, at(0.0, -0.5)?).fixed()])?;
    let mut spheres = Vec::new();
    for k in 0..4 {
        spheres.push(scene.insert(Object::new(1, at(f64::from(-4 - k), 0.5)?))?);
    }
    // The first two are glued together: a contact that nobody needs to hear of.
    scene.ignore_pair(scene.index_of(spheres[0])?, scene.index_of(spheres[1])?)?;

    let (mut pipeline, mut events) = (Pipeline::new(), Events::default());
    let mut begun = 0;
    for frame in 0..64 {
        // The last sphere leaves; its handle is refused from then on.
        if frame == 32 {
            scene.remove(spheres[3])?;
        }
        for (k, &sphere) in spheres.iter().enumerate() {
            if let Ok(i) = scene.index_of(sphere) {
                scene.set_pose(i, at(f64::from(frame) * 0.125 - 4.0 - k as f64, 0.5)?)?;
            }
        }
        let step = pipeline.step(&scene, Par::Pool);
        events.follow(&scene, &step, Par::Pool)?;
        for event in events.iter().filter(|event| event.change != Change::Stay) {
            println!("frame {frame}: {:?} of {:?}", event.change, event.pair());
        }
        begun += events.of(Change::Begin).count();
    }
    assert_eq!(begun, 5); // three with the floor, two with each other; the last left too early
    Ok(())
}
