//! What all ranks find together is what one machine finds: contacts, order, answers, candidates.

use crate::common::*;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pose, Scene, Shape, Support, SupportMap};
use dcd_gjk::Accuracy;
use dcd_io::{data, load_boxes};
use dcd_pipeline::{Par, Precision, Question};
use dcd_ranks::threads;
use dcd_ranks::{Body, RankError, RankScene, Share, Transport, sort_contacts};
use dcd_scenes::SceneSpec;
use std::sync::Arc;

#[test]
fn every_seeded_scene_has_the_same_contacts_at_any_number_of_ranks() {
    for spec in SceneSpec::all() {
        if spec.name().starts_with("game") && data::folder().is_none() {
            eprintln!("skipped: {}, since there is no data folder", spec.name());
            continue;
        }
        let objects = spec.objects.min(1500);
        let scene = spec.with_objects(objects).with_seed(7).scene().unwrap();
        for (size, deal) in
            [(1, IN_A_ROW), (2, DEALT), (3, ALL_ON_THE_LAST), (8, DEALT), (64, IN_A_ROW)]
        {
            check(spec.name(), &scene, size, deal);
        }
    }
}

#[test]
fn the_boxes_of_game_levels_are_found_by_64_ranks() {
    for file in ["bounds01.txt", "bounds03.txt", "32006GPUAABBs.txt"] {
        let Some(path) = data::file(&format!("aabbs/{file}")) else {
            eprintln!("skipped: {file}, which is not in the data folder");
            continue;
        };
        let boxes = load_boxes(&path).unwrap();
        let mut scene = Scene::default();
        for aabb in boxes {
            let [min, max] = [aabb.min, aabb.max].map(|corner| corner.as_dvec3());
            let shape = Shape::cuboid((max - min) * 0.5).unwrap();
            let shape = scene.add_shapes([shape]).unwrap().start;
            let pose = Pose::from_translation((min + max) * 0.5).unwrap();
            scene.insert(Object::new(shape, pose)).unwrap();
        }
        for size in [5, 64] {
            check(file, &scene, size, DEALT);
        }
    }
}

#[test]
fn what_is_measured_is_the_same_to_the_last_bit() {
    let scene = SceneSpec::sparse().with_objects(1200).scene().unwrap();
    let mixed = SceneSpec::mixed().with_objects(1500).scene().unwrap();
    for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
        for question in measures(accuracy) {
            for scene in [&scene, &mixed] {
                check_measured(scene, question, 3);
            }
        }
    }
}

#[test]
fn objects_that_wander_are_found_frame_by_frame_and_the_cuts_follow() {
    const FRAMES: usize = 40;
    let mut whole = SceneSpec::sparse().with_objects(1000).scene().unwrap();
    // They gather in one corner, turn, and part again: most change their rank several times.
    let place = |scene: &Scene, k: usize, frame: usize| {
        let start = scene.poses()[k];
        let phase = frame as f64 / FRAMES as f64 * 2.0;
        let pull = (1.0 - (phase - 1.0).abs()) * 0.7;
        let spot = start.translation().lerp(DVec3::new(-6.0, 5.0, 4.0), pull);
        let turn = DQuat::from_rotation_z(0.1 * frame as f64 + k as f64);
        Pose::new(turn, spot).unwrap()
    };
    let start = whole.clone();
    let found = threads::run(4, |rank| {
        let mut ranked = RankScene::new(rank, share(&start, rank, IN_A_ROW), CERTIFIED).unwrap();
        let mut recuts = 0;
        let mut frames = Vec::new();
        for frame in 0..FRAMES {
            let names: Vec<u64> = ranked.owned().map(|(name, _)| name).collect();
            for name in names {
                ranked.set_pose(name, place(&start, name as usize, frame)).unwrap();
            }
            let found = step(&mut ranked);
            recuts += usize::from(ranked.balance(found.load));
            frames.push(sort_contacts(rank, found.contacts).contacts);
        }
        (frames, recuts)
    });
    assert!(found[0].1 > 0, "the cuts were never made anew");
    for frame in 0..FRAMES {
        for k in 0..whole.len() {
            whole.set_pose(k, place(&start, k, frame)).unwrap();
        }
        let contacts: Vec<_> = found.iter().flat_map(|part| part.0[frame].clone()).collect();
        assert_eq!(contacts, on_one_machine(&whole, CERTIFIED).contacts, "frame {frame}");
    }
}

#[test]
fn a_wall_is_shared_and_clusters_are_spread() {
    let scene = SceneSpec::big_and_small().with_objects(4000).scene().unwrap();
    for (name, scene) in [
        ("big-and-small", scene),
        ("clustered", SceneSpec::clustered().with_objects(10_000).scene().unwrap()),
    ] {
        let costs = check(name, &scene, 8, IN_A_ROW);
        let (most, mean) =
            (*costs.iter().max().unwrap() as f64, costs.iter().sum::<u64>() as f64 / 8.0);
        assert!(most / mean < 1.1, "{name}: {costs:?}");
    }
}

#[test]
fn an_error_of_one_rank_is_one_of_all() {
    struct Foreign;
    impl SupportMap<f64> for Foreign {
        fn support(&self, direction: DVec3) -> Support<f64> {
            Support { point: direction, feature: 0 }
        }
    }
    let foreign = Shape::custom(Arc::new(Foreign)).unwrap();
    let found = threads::run(3, |rank| {
        let mut share = Share::default();
        if rank.rank() == 1 {
            share.shapes.push((9, foreign.clone()));
            share.bodies.push(Body { name: 4, shape: 0, pose: Pose::IDENTITY });
        }
        RankScene::new(rank, share, CERTIFIED).err().map(|error| error.to_string())
    });
    assert!(found[1].as_ref().is_some_and(|message| message.starts_with("shape 9: ")));
    assert!(found[0].as_ref().is_some_and(|message| message.starts_with("rank 1: shape 9: ")));
    assert_eq!(found[0], found[2]);
    let lost = threads::run(2, |rank| {
        let bodies = vec![Body { name: 5, shape: 3, pose: Pose::IDENTITY }];
        RankScene::new(rank, Share { shapes: vec![], bodies }, CERTIFIED)
            .err()
            .map(|e| e.to_string())
    });
    assert_eq!(lost[0].as_deref(), Some("object 5: there is no shape 3 among 0"));
}

#[test]
fn contacts_that_would_depend_on_the_number_of_ranks_are_refused() {
    let scene = SceneSpec::sparse().with_objects(50).scene().unwrap();
    for (precision, is_taken) in
        [(Precision::Certified, true), (Precision::F64, true), (Precision::Fast, false)]
    {
        let question = Question::Overlap { precision, margin: 0.0 };
        let taken = threads::run(2, |rank| {
            let scene = RankScene::new(rank, share(&scene, rank, DEALT), question);
            scene.map(drop).map_err(|error| assert_eq!(error, RankError::Unchecked)).is_ok()
        });
        assert_eq!(taken, [is_taken; 2], "{precision:?}");
    }
}

#[test]
fn a_body_of_another_rank_is_not_moved() {
    let scene = SceneSpec::sparse().with_objects(50).scene().unwrap();
    let refused = threads::run(2, |rank| {
        let mut ranked = RankScene::new(rank, share(&scene, rank, IN_A_ROW), CERTIFIED).unwrap();
        let own: Vec<u64> = ranked.owned().map(|(name, _)| name).collect();
        (0..50)
            .filter(|name| ranked.set_pose(*name, Pose::IDENTITY).is_err() == own.contains(name))
            .count()
    });
    assert_eq!(refused, [0, 0]);
}

#[test]
fn what_is_detected_behind_new_cuts_and_before_a_refresh_is_whole_or_refused() {
    const COUNT: u64 = 300;
    // Those of small names move together, so that one rank comes to have most of the work.
    let at = |name: u64, frame: i32| {
        let squeezed = if name < COUNT / 3 { 0.99 * 0.5f64.powi(frame) } else { 0.99 };
        Pose::from_translation(DVec3::X * (squeezed * name as f64)).unwrap()
    };
    let frames = 6;
    let poses = (0..COUNT).map(|name| at(name, frames)).collect();
    let ball = Shape::sphere(0.5).unwrap();
    let scene = Scene::one_each(vec![ball.clone(); COUNT as usize], poses).unwrap();
    let due = on_one_machine(&scene, CERTIFIED).contacts.len() as u64;
    let found = threads::run(3, |rank| {
        let names = (0..COUNT).filter(|k| k % 3 == rank.rank() as u64);
        let bodies = names.map(|name| Body { name, shape: 0, pose: at(name, 0) }).collect();
        let share = Share { shapes: vec![(0, ball.clone())], bodies };
        let mut scene = RankScene::new(rank, share, CERTIFIED).unwrap();
        let (mut cuts, mut refused) = (0, 0);
        for frame in 1..=frames {
            refused +=
                usize::from(scene.detect(Par::Serial).err() == Some(RankError::NotRefreshed));
            scene.refresh(Par::Serial).unwrap();
            for name in scene.owned().map(|(name, _)| name).collect::<Vec<_>>() {
                scene.set_pose(name, at(name, frame)).unwrap();
            }
            assert_eq!(scene.detect(Par::Serial).err(), Some(RankError::NotRefreshed));
            scene.refresh(Par::Serial).unwrap();
            let load = scene.detect(Par::Serial).unwrap().load;
            if scene.balance(load) {
                cuts += 1;
                // As far as it has come.
                let contacts = scene.detect(Par::Serial).unwrap().contacts;
                let again = step(&mut scene).contacts;
                let totals = [contacts, again].map(|found| sort_contacts(rank, found).total);
                assert_eq!(totals[0], totals[1], "frame {frame}");
            }
        }
        assert_eq!(refused, 1, "only before the first refresh");
        let contacts = scene.detect(Par::Serial).unwrap().contacts;
        (cuts, sort_contacts(rank, contacts).total)
    });
    assert!(found.iter().all(|&(cuts, total)| cuts > 0 && total == due), "{found:?}, {due}");
}

#[test]
fn two_shapes_of_one_name_are_refused_on_all_ranks() {
    let ball = |radius: f64| Shape::sphere(radius).unwrap();
    let body = |name: u64, shape: u32| Body {
        name,
        shape,
        pose: Pose::from_translation(DVec3::X * (2.2 * name as f64)).unwrap(),
    };
    let new = |shapes: [Vec<(u64, Shape)>; 3]| {
        threads::run(3, |rank| {
            let shapes = shapes[rank.rank()].clone();
            let bodies =
                (0..shapes.len() as u32).map(|k| body(10 * rank.rank() as u64 + u64::from(k), k));
            let share = Share { bodies: bodies.collect(), shapes };
            RankScene::new(rank, share, CERTIFIED).err().map(|error| error.to_string())
        })
    };
    let one = || vec![(7, ball(0.5))];
    assert!(new([one(), one(), one()]).iter().all(Option::is_none));
    // One shape may be listed twice.
    assert!(new([vec![(7, ball(0.5)), (7, ball(0.5))], one(), one()]).iter().all(Option::is_none));
    for shapes in [
        [vec![(7, ball(0.5)), (7, ball(2.0))], one(), one()],
        [one(), vec![(8, ball(2.0)), (7, ball(0.5f64.next_up()))], one()],
    ] {
        let found = new(shapes);
        let says = |error: &String| error.contains("shape 7 is two different shapes");
        assert!(found.iter().flatten().filter(|error| says(error)).count() == 3, "{found:?}");
    }
}
