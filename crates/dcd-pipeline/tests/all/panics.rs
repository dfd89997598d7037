//! Code of the caller's own that panics, and what holds once the panic is caught.

use dcd_broad::WideTree;
use dcd_exec::with_threads;
use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pose, Scene, Shape, Support, SupportMap};
use dcd_pipeline::{LinkSet, Overlap, Par, Pipeline, StaticWorld};
use dcd_scenes::SceneSpec;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The corners of an octahedron, for as many supports as are left.
struct Breaks(Arc<AtomicUsize>);

impl SupportMap<f64> for Breaks {
    fn support(&self, direction: DVec3) -> Support<f64> {
        let left = self.0.fetch_sub(1, Relaxed);
        assert!(left > 0, "broken");
        let axis = direction.abs().max_position();
        Support::of_point(DVec3::AXES[axis] * direction[axis].signum())
    }
}

/// More supports than are asked for.
const WHOLE: usize = usize::MAX / 2;

fn at(x: f64) -> Pose {
    Pose::from_translation(DVec3::X * x).unwrap()
}

/// A ball at rest that another touches, and far from both what may break.
fn scene(left: &Arc<AtomicUsize>) -> Scene {
    let ball = Shape::sphere(0.5).unwrap();
    let breaks = Shape::custom(Arc::new(Breaks(left.clone()))).unwrap();
    let objects = [
        Object::new(0, at(0.0)).fixed(),
        Object::new(0, at(0.75)),
        Object::new(1, at(9.0)),
        Object::new(1, at(19.0)).fixed(),
    ];
    Scene::new(vec![ball, breaks], objects).unwrap()
}

#[test]
fn a_step_behind_one_that_panicked_finds_what_a_new_pipeline_does() {
    let left = Arc::new(AtomicUsize::new(WHOLE));
    let scene = scene(&left);
    let mut elsewhere = scene.clone();
    elsewhere.set_pose(0, at(99.0)).unwrap();
    let due = [(0, 1)];
    let mut pipeline = Pipeline::<WideTree, Overlap>::default();
    assert_eq!(pipeline.step(&scene, Par::Serial).contacts().collect::<Vec<_>>(), due);
    left.store(0, Relaxed);
    let step = || {
        pipeline.step(&elsewhere, Par::Serial);
    };
    assert!(catch_unwind(AssertUnwindSafe(step)).is_err());
    left.store(WHOLE, Relaxed);
    assert!(pipeline.queries(&scene).is_err());
    assert_eq!(pipeline.step(&scene, Par::Serial).contacts().collect::<Vec<_>>(), due);
}

#[test]
fn a_world_whose_change_panicked_answers_once_another_has_succeeded() {
    let left = Arc::new(AtomicUsize::new(WHOLE));
    let scene = scene(&left);
    let mut world = StaticWorld::for_pairs(&scene, 0..4, Overlap::default()).unwrap();
    let check = |world: &StaticWorld| {
        let links = LinkSet::new(vec![Shape::sphere(0.1).unwrap()]);
        let mut checker = world.checker(links).unwrap();
        [0.0, 8.0, 9.0, 50.0].map(|x| checker.first(&[at(x)], Par::Serial).unwrap()[0].is_some())
    };
    let mut refused = 0;
    for supports in 0.. {
        left.store(supports, Relaxed);
        let is_moved = catch_unwind(AssertUnwindSafe(|| world.set_pose(2, at(7.0)))).is_ok();
        left.store(WHOLE, Relaxed);
        if is_moved {
            break;
        }
        match catch_unwind(AssertUnwindSafe(|| check(&world))) {
            Ok(found) => assert_eq!(found, [true, true, true, false], "{supports}"),
            Err(_) => refused += 1,
        }
        assert_eq!(world.set_pose(2, at(9.0)), Ok(()));
        assert_eq!(check(&world), [true, true, true, false], "{supports}");
    }
    assert_eq!(check(&world), [true, true, false, false]);
    assert!(refused > 0);
}

#[test]
fn a_step_on_the_pool_behind_one_that_panicked_finds_what_a_new_pipeline_does() {
    let scene = SceneSpec::sparse().with_objects(3000).scene().unwrap();
    let contacts = |pipeline: &mut Pipeline| -> Vec<_> {
        pipeline.step(&scene, Par::Pool).contacts().collect()
    };
    for threads in [1, 4] {
        with_threads(threads, || {
            let due = contacts(&mut Pipeline::new());
            let mut pipeline = Pipeline::new();
            for round in 0..10 {
                // Some tasks have written by then, and some have not.
                let breaks = |i: u32, j: u32| {
                    assert!(i + j != 3000 + 10 * round, "on purpose");
                    true
                };
                let step = || {
                    pipeline.step_where(&scene, Par::Pool, breaks);
                };
                catch_unwind(AssertUnwindSafe(step)).ok();
                assert!(contacts(&mut pipeline) == due, "{threads} threads, round {round}");
            }
        })
        .unwrap();
    }
}
