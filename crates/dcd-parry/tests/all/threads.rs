//! The same pairs in the same order at any number of threads.

use dcd_broad::contract;
use dcd_exec::{Par, with_threads};
use dcd_geom::glam::Vec3;
use dcd_geom::{Aabb, Filter, Object, Pair, Scene};
use dcd_parry::{ParryBvh, ParryPipeline, Query};
use dcd_scenes::SceneSpec;

fn scene() -> Scene {
    SceneSpec::paper().with_objects(1500).scene().unwrap()
}

fn rival(scene: &Scene, par: Par) -> [Vec<Pair>; 2] {
    let mut pipeline = ParryPipeline::<f32>::new(scene, Query::DirectIntersectionTest);
    let mut ready = pipeline.place(scene);
    let step = ready.step(par);
    [step.candidates().collect(), step.contacts().collect()]
}

#[test]
fn the_pipeline_gives_the_same_at_any_thread_count() {
    let scene = scene();
    let serial = rival(&scene, Par::Serial);
    assert!(serial[1].len() > 10_000);
    for threads in [1, 2, 3, 7] {
        assert_eq!(with_threads(threads, || rival(&scene, Par::Pool)).unwrap(), serial);
    }
}

#[test]
fn the_tree_keeps_the_contract_of_broad_phases_at_any_thread_count() {
    let scene = scene();
    let aabbs: Vec<_> = (0..scene.len()).map(|i| scene.aabb(i)).collect();
    for threads in [1, 2, 3, 7] {
        let broad_phase = || contract::broad_phase(&mut ParryBvh::default(), &aabbs);
        assert_eq!(with_threads(threads, broad_phase).unwrap(), Ok(0));
    }
}

#[test]
fn no_box_one_two_and_identical_boxes_are_legal() {
    let cube = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
    for count in [0, 1, 2, 3, 100] {
        assert_eq!(contract::broad_phase(&mut ParryBvh::default(), &vec![cube; count]), Ok(0));
    }
}

#[test]
fn filtered_pairs_are_no_candidates() {
    let plain = scene();
    let objects = plain.poses().iter().enumerate().map(|(i, &pose)| {
        let filter = Filter { groups: 1 << (i % 2), mask: 1 << (1 - i % 2) };
        Object { filter, ..Object::new(i as u32, pose) }
    });
    let filtered = Scene::new(plain.shapes().to_vec(), objects).unwrap();
    let mut expected = rival(&plain, Par::Serial)[1].clone();
    expected.retain(|pair| (pair.i + pair.j) % 2 == 1);
    assert_eq!(rival(&filtered, Par::Serial)[1], expected);
}
