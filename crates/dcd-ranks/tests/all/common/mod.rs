//! A scene on one machine and on ranks that are threads.
// Each test file takes some of it.
#![allow(dead_code)]

use dcd_geom::Scene;
use dcd_gjk::Accuracy;
use dcd_pipeline::{Answer, AnyPipeline, Par, Precision, Question};
use dcd_ranks::threads::{self, ThreadRank};
use dcd_ranks::{Body, RankScene, RankStep, Share, Transport, digest, sort_contacts};

pub(crate) const CERTIFIED: Question =
    Question::Overlap { precision: Precision::Certified, margin: 0.0 };

/// Which rank brings an object along.
pub(crate) type Deal = fn(object: usize, objects: usize, size: usize) -> usize;

pub(crate) const IN_A_ROW: Deal = |object, objects, size| object * size / objects;
pub(crate) const DEALT: Deal = |object, _, size| object.wrapping_mul(0x9e37_79b9) % size;
pub(crate) const ALL_ON_THE_LAST: Deal = |_, _, size| size - 1;

/// The part of the scene that a rank brings along. Shapes are named by index.
pub(crate) fn share(scene: &Scene, rank: &ThreadRank, deal: Deal) -> Share {
    let whole = Share::of_scene(scene, 0, |shape| shape as u64).unwrap();
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

pub(crate) struct Whole {
    pub(crate) contacts: Vec<[u64; 2]>,
    pub(crate) answers: Vec<(u32, u32, Answer)>,
    pub(crate) candidates: usize,
    pub(crate) undecided: usize,
}

pub(crate) fn on_one_machine(scene: &Scene, question: Question) -> Whole {
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

pub(crate) fn step<T: Transport>(ranked: &mut RankScene<'_, T>) -> RankStep {
    ranked.refresh(Par::Serial).unwrap();
    ranked.detect(Par::Serial).unwrap()
}

/// That the steps' contacts are those of one machine, and how the load was spread.
pub(crate) fn check(name: &str, scene: &Scene, size: usize, deal: Deal) -> Vec<u64> {
    let whole = on_one_machine(scene, CERTIFIED);
    let found = threads::run(size, |rank| {
        let mut ranked = RankScene::new(rank, share(scene, rank, deal), CERTIFIED).unwrap();
        let first = step(&mut ranked);
        // A second step sends the ranks less, and finds the same.
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

/// That what the ranks measure of each pair is what one machine does, to the last bit.
pub(crate) fn check_measured(scene: &Scene, question: Question, size: usize) {
    let whole = on_one_machine(scene, question);
    let found = threads::run(size, |rank| {
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
    assert_eq!(answers.len(), whole.answers.len(), "{question:?}");
    for (found, due) in answers.iter().zip(&whole.answers) {
        assert_eq!(found, due, "{question:?} at {size} ranks");
    }
}

/// All that can be measured, as good as that.
pub(crate) fn measures(accuracy: Accuracy) -> [Question; 4] {
    [
        Question::Distance { accuracy, margin: 0.2 },
        Question::Depth { accuracy },
        Question::Manifold { accuracy, options: Default::default() },
        Question::Gradient { accuracy, margin: 0.05 },
    ]
}
