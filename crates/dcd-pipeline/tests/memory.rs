//! What a step allocates, and what it holds.

use dcd_geom::{Pose, Scene};
use dcd_pipeline::{Par, Pipeline};
use dcd_scenes::SceneSpec;

fn scene(name: &str, objects: usize) -> Scene {
    SceneSpec::parse(name).unwrap().with_objects(objects).scene().unwrap()
}

#[test]
fn from_the_third_frame_on_a_serial_step_allocates_nothing() {
    for name in ["paper", "sparse", "boxes"] {
        let mut scene = scene(name, 2000);
        let mut pipeline = <Pipeline>::default();
        for frame in 0..6 {
            let seen = allocation_counter::measure(|| {
                assert!(pipeline.step(&scene, Par::Serial).contact_count() > 0);
            });
            assert!(frame < 2 || seen.count_total == 0, "{name}, frame {frame}: {seen:?}");
            // A mirrored translation keeps the number of pairs alike, not the pairs.
            for i in 0..scene.len() {
                let pose = scene.poses()[i];
                let turned = Pose::from_matrix(*pose.rotation(), -pose.translation()).unwrap();
                scene.set_pose(i, turned).unwrap();
            }
        }
    }
}
