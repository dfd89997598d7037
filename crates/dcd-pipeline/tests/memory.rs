//! What a step allocates, and what it holds.

use dcd_geom::{Object, Pose, Scene};
use dcd_gjk::{Coherent, Method};
use dcd_pipeline::{Events, LinkSet, Overlap, Par, Pipeline, StaticWorld, WideTree};
use dcd_scenes::{RandomWalk, SceneSpec};

fn scene(name: &str, objects: usize) -> Scene {
    SceneSpec::parse(name).unwrap().with_objects(objects).scene().unwrap()
}

#[test]
fn from_the_third_frame_on_a_serial_step_allocates_nothing() {
    for name in ["paper", "sparse", "boxes"] {
        let mut scene = scene(name, 2000);
        let mut pipeline = Pipeline::new();
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

#[test]
fn a_coherent_step_of_objects_that_barely_move_allocates_nothing_either() {
    let mut scene = scene("paper", 2000);
    let mut pipeline = Pipeline::with(WideTree::default(), Coherent::default());
    let mut walk = RandomWalk::new(1e-4, 3).unwrap();
    for frame in 0..8 {
        let mut remembered = 0;
        let seen = allocation_counter::measure(|| {
            let step = pipeline.step(&scene, Par::Serial);
            remembered = step.report().resolved(Method::Remembered);
        });
        assert!(frame < 2 || seen.count_total == 0, "frame {frame}: {seen:?}");
        assert!(frame < 1 || remembered > 10_000, "frame {frame}: {remembered}");
        walk.step(&mut scene).unwrap();
    }
}

#[test]
fn static_objects_filters_and_events_allocate_nothing_either() {
    let plain = scene("sparse", 2000);
    let objects = (0..2000).map(|i| {
        let object = Object::new(i, plain.poses()[i as usize]);
        if i % 3 == 0 { object.fixed() } else { object }
    });
    let mut scene = Scene::new(plain.shapes().to_vec(), objects).unwrap();
    scene.ignore_pair(0, 1).unwrap();
    let (mut pipeline, mut events) = (Pipeline::new(), Events::default());
    for frame in 0..8 {
        let seen = allocation_counter::measure(|| {
            let step = pipeline.step_where(&scene, Par::Serial, |i, j| i + j != 9);
            assert!(!events.follow(&scene, &step, Par::Serial).unwrap().is_empty());
        });
        assert!(frame < 4 || seen.count_total == 0, "frame {frame}: {seen:?}");
        for i in (1..scene.len()).step_by(3) {
            let pose = scene.poses()[i];
            let turned = Pose::from_matrix(*pose.rotation(), -pose.translation()).unwrap();
            scene.set_pose(i, turned).unwrap();
        }
    }
}

#[test]
fn from_the_second_batch_on_serial_configurations_allocate_nothing() {
    let world = StaticWorld::new(&scene("paper", 200), Overlap::default(), Par::Serial).unwrap();
    let robot = scene("paper", 4);
    let link_set = LinkSet::new(robot.shapes().to_vec()).against_itself(&[(0, 1)]).unwrap();
    let mut checker = world.checker(link_set).unwrap();
    let poses = scene("paper", 800).poses().to_vec();
    for batch in 0..4 {
        let seen = allocation_counter::measure(|| {
            assert!(checker.first(&poses, Par::Serial).unwrap().iter().any(Option::is_some));
            assert!(!checker.all(&poses, Par::Serial).unwrap().is_empty());
        });
        assert!(batch < 1 || seen.count_total == 0, "batch {batch}: {seen:?}");
    }
}
