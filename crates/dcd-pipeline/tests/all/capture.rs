//! A recorded run, replayed: the same contacts, in the same order, on any number of threads.

use dcd_exec::with_threads;
use dcd_io::{Capture, place_frame};
use dcd_pipeline::{Par, Pipeline, Scene};
use dcd_scenes::{RandomWalk, SceneSpec};

type Contacts = Vec<(u32, u32)>;

/// Eight frames of a walk with their contacts, as a program would record them.
fn recorded_run() -> (Vec<u8>, Vec<Contacts>) {
    let mut scene = SceneSpec::clustered().with_objects(1_500).with_seed(4).scene().unwrap();
    let mut walk = RandomWalk::new(0.05, 4).unwrap();
    let mut capture = Capture::new(&scene).unwrap();
    let mut pipeline: Pipeline = Pipeline::default();
    let mut found = Vec::new();
    for _ in 0..8 {
        walk.step(&mut scene).unwrap();
        found.push(pipeline.step(&scene, Par::Serial).contacts().collect());
        capture.frame(&scene).unwrap();
    }
    let mut file = Vec::new();
    capture.write(&mut file).unwrap();
    (file, found)
}

fn replayed(capture: &Capture, par: Par) -> Vec<Contacts> {
    let mut scene: Scene = capture.scene().clone();
    let mut pipeline: Pipeline = Pipeline::default();
    let step = |poses| {
        place_frame(&mut scene, poses).unwrap();
        pipeline.step(&scene, par).contacts().collect()
    };
    capture.frames().map(step).collect()
}

#[test]
fn a_replay_gives_the_recorded_runs_contacts_in_order_at_any_thread_count() {
    let (file, found) = recorded_run();
    assert!(found.iter().all(|contacts| contacts.len() > 1_000));
    assert!(found.windows(2).all(|frames| frames[0] != frames[1]));
    let capture = Capture::read(&file).unwrap();
    assert_eq!(replayed(&capture, Par::Serial), found);
    for threads in [1, 2, 3] {
        let pooled = with_threads(threads, || replayed(&capture, Par::Pool)).unwrap();
        assert_eq!(pooled, found, "{threads} threads");
    }
}
