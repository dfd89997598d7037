//! What all ranks find together is what one machine finds: contacts, order, answers, candidates.

use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pose, Scene, Shape};
use dcd_gjk::Accuracy;
use dcd_io::{data, load_boxes};
use dcd_pipeline::{Answer, AnyPipeline, Par, Precision, Question};
use dcd_ranks::threads::{self, ThreadRank};
use dcd_ranks::{Body, RankScene, RankStep, Share, Transport, digest, sort_contacts};
use dcd_scenes::SceneSpec;

const CERTIFIED: Question = Question::Overlap { precision: Precision::Certified, margin: 0.0 };

/// Which rank brings an object along.
type Deal = fn(object: usize, objects: usize, size: usize) -> usize;

const IN_A_ROW: Deal = |object, objects, size| object * size / objects;
const DEALT: Deal = |object, _, size| object.wrapping_mul(0x9e37_79b9) % size;
const ALL_ON_THE_LAST: Deal = |_, _, size| size - 1;

/// The part of the scene that a rank brings along. Shapes are named by index.
fn share(scene: &Scene, rank: &ThreadRank, deal: Deal) -> Share {
    let whole = Share::of_scene(scene, 0, |shape| shape as u64);
    let is_own = |body: &Body| deal(body.name as usize, scene.len(), rank.size()) == rank.rank();
    let bodies: Vec<Body> = whole.bodies.into_iter().filter(is_own).collect();
    // With those shapes alone that it needs.
    let mut shapes = Vec::new();
    let mut own = Vec::new();
    for body in bodies {
        let shape = whole.shapes[body.shape as usize].clone();
        let place = shapes.iter().position(|(name, _)| *name == shape.0).unwrap_or_else(|| {
            shapes.push(shape);
            shapes.len() - 1
        });
        own.push(Body { shape: place as u32, ..body });
    }
    Share { shapes, bodies: own }
}

struct Whole {
    contacts: Vec<[u64; 2]>,
    answers: Vec<(u32, u32, Answer)>,
    candidates: usize,
    undecided: usize,
}

fn on_one_machine(scene: &Scene, question: Question) -> Whole {
    let mut pipeline = AnyPipeline::new(question).unwrap();
    let step = pipeline.step(scene, Par::Serial);
    let mut contacts: Vec<[u64; 2]> =
        step.contacts().map(|(i, j)| [u64::from(i), u64::from(j)]).collect();
    contacts.sort_unstable();
    let mut answers: Vec<_> =
        step.answers().map(|(pair, answer)| (pair.i, pair.j, answer)).collect();
    answers.sort_by_key(|&(i, j, _)| (i, j));
    let (candidates, undecided) = (step.candidate_count(), step.report().undecided().len());
    Whole { contacts, answers, candidates, undecided }
}

fn step<T: Transport>(ranked: &mut RankScene<'_, T>) -> RankStep {
    ranked.refresh(Par::Serial).unwrap();
    ranked.detect(Par::Serial)
}

/// That the steps' contacts are those of one machine, and how the load was spread.
fn check(name: &str, scene: &Scene, size: usize, deal: Deal) -> Vec<u64> {
    let whole = on_one_machine(scene, CERTIFIED);
    let found = threads::run(size, |rank| {
        let mut ranked = RankScene::new(rank, share(scene, rank, deal), CERTIFIED).unwrap();
        let first = step(&mut ranked);
        // A second step tells the ranks less, and finds the same.
        let found = step(&mut ranked);
        assert_eq!(found.contacts.len(), first.contacts.len());
        let sorted = sort_contacts(rank, found.contacts);
        let digest = digest(rank, &sorted).unwrap();
        let own: Vec<u64> = ranked.owned().map(|(name, _)| name).collect();
        (sorted.contacts, digest, found.load, found.undecided, own)
    });
    let contacts: Vec<_> = found.iter().flat_map(|part| part.0.clone()).collect();
    assert_eq!(contacts, whole.contacts, "{name} at {size} ranks");
    let candidates: u64 = found.iter().map(|part| part.2.pairs).sum();
    assert_eq!(candidates as usize, whole.candidates, "{name} at {size} ranks");
    assert_eq!(found.iter().map(|part| part.3).sum::<usize>(), whole.undecided);
    let mut owned: Vec<u64> = found.iter().flat_map(|part| part.4.clone()).collect();
    owned.sort_unstable();
    assert!(owned.iter().copied().eq(0..scene.len() as u64), "{name}: each is owned once");
    let alone =
        threads::run(1, |rank| digest(rank, &sort_contacts(rank, whole.contacts.clone())).unwrap());
    assert!(found.iter().all(|part| part.1 == alone[0]));
    found.iter().map(|part| part.2.cost()).collect()
}

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
        let questions = [
            Question::Distance { accuracy, margin: 0.2 },
            Question::Depth { accuracy },
            Question::Manifold { accuracy },
            Question::Gradient { accuracy, margin: 0.05 },
        ];
        for question in questions {
            for scene in [&scene, &mixed] {
                let whole = on_one_machine(scene, question);
                let found = threads::run(3, |rank| {
                    let share = share(scene, rank, DEALT);
                    let mut ranked = RankScene::new(rank, share, question).unwrap();
                    step(&mut ranked)
                });
                let mut answers: Vec<_> = found
                    .into_iter()
                    .flat_map(|part| part.contacts.into_iter().zip(part.answers))
                    .map(|([i, j], answer)| (i as u32, j as u32, answer))
                    .collect();
                answers.sort_by_key(|&(i, j, _)| (i, j));
                assert!(!answers.is_empty());
                assert_eq!(answers, whole.answers, "{question:?}");
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
    let cylinder = Shape::cylinder(1.0, 0.5).unwrap();
    let found = threads::run(3, |rank| {
        let mut share = Share::default();
        if rank.rank() == 1 {
            share.shapes.push((9, cylinder.clone()));
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
