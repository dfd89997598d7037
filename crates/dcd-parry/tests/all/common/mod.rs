//! One pair decided in every way that this crate knows.
#![allow(dead_code)] // each test file uses its part

use dcd_exec::Par;
use dcd_geom::{Aabb, Pair, Pose, Scene, Shape};
use dcd_gjk::{ContactSink, NarrowPhase, Pairwise, Prepared, Reason, Report, Sides};
use dcd_parry::{Library, ParryGjk, ParryPipeline, ParryShapes, Query};
use dcd_pipeline::Pipeline;

pub(crate) const QUERIES: [Query; 3] =
    [Query::IntersectionTest, Query::DirectIntersectionTest, Query::Distance];

/// What a narrow phase says of objects 0 and 1: touching or not, or why it is undecided.
pub(crate) fn decide<N: NarrowPhase<Answer = ()>>(
    narrow: &N,
    scene: &Scene,
) -> Result<bool, Reason> {
    let mut frame = N::Frame::default();
    let mut aabbs = vec![Aabb::default(); scene.len()];
    let part = narrow.layout(scene, Sides::One, &mut frame);
    narrow.prepare(scene, 0, part, &mut aabbs);
    let (mut contacts, mut report) = (Vec::new(), Report::default());
    let sink = &mut ContactSink { contacts: &mut contacts, report: &mut report };
    let side = Prepared { scene, frame: &frame };
    narrow.decide(side, side, &[Pair::new(0, 1)], &mut N::Scratch::default(), sink);
    report.undecided().first().map_or(Ok(!contacts.is_empty()), |undecided| Err(undecided.reason))
}

pub(crate) fn two(a: (&Shape, Pose), b: (&Shape, Pose)) -> Scene {
    Scene::one_each(vec![a.0.clone(), b.0.clone()], vec![a.1, b.1]).unwrap()
}

/// Every way in one precision, by name.
pub(crate) fn answers<R: Library>(scene: &Scene) -> Vec<(String, Result<bool, Reason>)> {
    let mut answers = vec![("GJK".into(), decide(&Pairwise(ParryGjk::<R>::default()), scene))];
    for query in QUERIES {
        let shapes = ParryShapes::<R>::new(scene).with_query(query);
        answers.push((format!("{query:?}"), decide(&shapes, scene)));
    }
    answers
}

/// Asserts that every way in both precisions says so, in both orders of the pair.
pub(crate) fn assert_all(a: (&Shape, Pose), b: (&Shape, Pose), touching: bool) {
    for scene in [two(a, b), two(b, a)] {
        let all = answers::<f32>(&scene).into_iter().chain(answers::<f64>(&scene));
        for (index, (way, answer)) in all.enumerate() {
            assert_eq!(answer, Ok(touching), "{way}, number {index}: {a:?} {b:?}");
        }
    }
}

/// The sorted contacts of a whole scene.
pub(crate) fn contacts<B, N>(broad: B, narrow: N, scene: &Scene) -> Vec<Pair>
where
    B: dcd_broad::BroadPhase,
    N: NarrowPhase<Answer = ()>,
{
    let mut pipeline = Pipeline::with(broad, narrow);
    let step = pipeline.step(scene, Par::Serial);
    assert_eq!(step.report().undecided(), []);
    let mut pairs: Vec<_> = step.contacts().map(|(i, j)| Pair { i, j }).collect();
    pairs.sort_unstable();
    pairs
}

/// The sorted contacts of Parry's own pipeline.
pub(crate) fn rival_contacts<R: Library>(query: Query, scene: &Scene) -> Vec<Pair> {
    let mut pipeline = ParryPipeline::<R>::new(scene, query);
    let mut ready = pipeline.place(scene);
    let step = ready.step(Par::Serial);
    assert_eq!(step.report().undecided(), []);
    step.sorted_contacts()
}
