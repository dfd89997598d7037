//! Which pairs are within a margin.

use super::scenes::{pile, shapes};
use dcd_geom::glam::DVec3;
use dcd_geom::{List, Pair, Pose, Scene, Shape};
use dcd_gjk::{
    Certified, Contact, ContactList, ContactSink, ContactsOf, Distances, NarrowPhase, Overlap,
    Pairwise, Prepared, Reason, Report, Sides, ThenMeasure, Within, contract,
};
use dcd_simd::Path;

/// The contacts among the pairs whose boxes overlap, and the report.
pub(crate) fn found<N: NarrowPhase>(
    narrow: &N,
    scene: &Scene,
    pairs: &[Pair],
) -> (Vec<Contact<N::Answer>>, Report) {
    let mut frame = N::Frame::default();
    let mut aabbs = vec![dcd_geom::Aabb::default(); scene.len()];
    let part = narrow.layout(scene, Sides::One, &mut frame);
    narrow.prepare(scene, 0, part, &mut aabbs);
    let overlap = |pair: &Pair| aabbs[pair.i as usize].overlaps(&aabbs[pair.j as usize]);
    let candidates: Vec<Pair> = pairs.iter().copied().filter(overlap).collect();
    let (mut contacts, mut report) = (ContactsOf::<N::Answer>::default(), Report::default());
    let mut sink = ContactSink { contacts: &mut contacts, report: &mut report };
    let side = Prepared { scene, frame: &frame };
    narrow.decide(side, side, &candidates, &mut N::Scratch::default(), &mut sink);
    (contacts.contacts(0..contacts.len()).collect(), report)
}

/// The contacts that a narrow phase finds on every path, which are the same.
pub(crate) fn on_every_path<N: NarrowPhase>(
    narrow: impl Fn(Path) -> N,
    scene: &Scene,
    pairs: &[Pair],
) -> Vec<Contact<N::Answer>>
where
    N::Answer: PartialEq,
{
    let mut first: Option<Vec<Contact<N::Answer>>> = None;
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        let (found, _) = found(&narrow(path), scene, pairs);
        match &first {
            Some(first) => assert!(*first == found, "{path:?}"),
            None => first = Some(found),
        }
    }
    first.unwrap()
}

fn pairs_of<A>(contacts: &[Contact<A>]) -> Vec<Pair> {
    contacts.iter().map(|contact| contact.pair).collect()
}

#[test]
fn every_margin_keeps_the_contract_by_any_narrow_phase() {
    let (scene, pairs) = pile(shapes(), 40);
    for margin in [0.0, 0.3] {
        contract::narrow_phase(&Within::margin(margin).unwrap(), &scene, &pairs).unwrap();
        let one_by_one = Within::by(Pairwise(Certified), margin).unwrap();
        contract::narrow_phase(&one_by_one, &scene, &pairs).unwrap();
    }
    contract::narrow_phase(&Within::margin(0.1).unwrap(), &Scene::default(), &[]).unwrap();
}

#[test]
fn the_pairs_within_a_margin_are_those_whose_distance_says_so() {
    let mut polytopes = shapes();
    polytopes.pop();
    let (scene, pairs) = pile(polytopes, 60);
    let mut last = 0;
    for margin in [0.0, 0.125, 0.25, 1.0] {
        let lanes = found(&Within::margin(margin).unwrap(), &scene, &pairs).0;
        let alone = found(&Pairwise(Distances::within(margin).unwrap()), &scene, &pairs).0;
        assert_eq!(pairs_of(&lanes), pairs_of(&alone), "{margin}");
        assert!(lanes.len() > last && lanes.len() < pairs.len(), "{}", lanes.len());
        last = lanes.len();
    }
}

#[test]
fn a_gap_of_the_margin_is_within_it_and_the_next_float_is_not() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    for (gap, within) in [(0.25, 1), (0.25f64.next_up(), 1), (0.25 + f64::EPSILON, 0)] {
        // 1.25 swallows the least step that 0.25 knows.
        let there = Pose::from_translation(DVec3::X * (1.0 + gap)).unwrap();
        let scene = Scene::one_each(vec![cube.clone(); 2], vec![Pose::IDENTITY, there]).unwrap();
        let pairs = [Pair::new(0, 1)];
        assert_eq!(found(&Within::margin(0.25).unwrap(), &scene, &pairs).0.len(), within, "{gap}");
        let far = ThenMeasure::new(Distances::within(0.25).unwrap()).unwrap();
        assert_eq!(found(&far, &scene, &pairs).0.len(), within, "{gap}");
        let alone = Pairwise(Distances::within(0.25).unwrap());
        assert_eq!(found(&alone, &scene, &pairs).0.len(), within, "{gap}");
    }
}

#[test]
fn a_frame_follows_poses_and_shapes_from_step_to_step() {
    let narrow = Within::margin(0.25).unwrap();
    let mut frame = Default::default();
    for (x, shape) in [(1.5, 0.5), (1.2, 0.5), (2.2, 0.5), (2.2, 1.0)] {
        let cube = Shape::cuboid(DVec3::splat(shape)).unwrap();
        let there = Pose::from_translation(DVec3::X * x).unwrap();
        let scene = Scene::one_each(vec![cube; 2], vec![Pose::IDENTITY, there]).unwrap();
        let part = narrow.layout(&scene, Sides::One, &mut frame);
        let mut aabbs = [dcd_geom::Aabb::default(); 2];
        narrow.prepare(&scene, 0, part, &mut aabbs);
        let (mut contacts, mut report) = (Vec::new(), Report::default());
        let mut sink = ContactSink { contacts: &mut contacts, report: &mut report };
        let mut scratch = <Overlap as NarrowPhase>::Scratch::default();
        let side = Prepared { scene: &scene, frame: &frame };
        narrow.decide(side, side, &[Pair::new(0, 1)], &mut scratch, &mut sink);
        assert_eq!(contacts.len() == 1, x - 2.0 * shape <= 0.25, "{x} {shape}");
    }
}

#[test]
fn an_object_that_grows_out_of_range_leaves_its_pairs_undecided() {
    let sphere = Shape::sphere(1.0).unwrap();
    let far = Pose::from_translation(DVec3::X * 9.9e36).unwrap();
    let scene = Scene::one_each(vec![sphere.clone(), sphere], vec![far, Pose::IDENTITY]).unwrap();
    let pairs = [Pair::new(0, 1)];
    let narrow = Within::margin(1e37).unwrap();
    let (contacts, report) = found(&narrow, &scene, &pairs);
    assert!(contacts.is_empty());
    assert_eq!(report.undecided()[0].reason, Reason::Range);
    contract::narrow_phase(&narrow, &scene, &pairs).unwrap();
}
