//! What the records show of a pair, beside its polytopes.

use super::super::super::prepare::{Prepare, prepare};
use super::super::confirm::{SearchedPair, Side};
use super::*;
use crate::motion::tests::Draw;
use crate::simd::Purpose;
use crate::{PosedShape, Sides, Verdict, certified};
use dcd_geom::glam::DQuat;
use dcd_geom::{Aabb, Object, Pose, Scene, Shape, SupportMap};
use dcd_simd::Path;

const ACCURACIES: [Accuracy; 3] = [Accuracy::F32, Accuracy::F64, Accuracy::Certified];

/// Spheres, capsules, cuboids, hulls, and these rounded: their cores, and what is swept round them.
fn shapes(draw: &mut Draw) -> Vec<(Shape, Shape)> {
    let hull = |draw: &mut Draw| Shape::hull((0..20).map(|_| draw.vector()).collect()).unwrap();
    let cores = [
        Shape::sphere(0.0).unwrap(),
        Shape::capsule(0.8, 0.0).unwrap(),
        Shape::cuboid(DVec3::new(0.7, 0.5, 0.4)).unwrap(),
        hull(draw),
        hull(draw),
        Shape::cylinder(0.5, 0.4).unwrap(),
    ];
    let mut all = Vec::new();
    for core in cores {
        all.extend(core.swept(0.3).ok().map(|swept| (core.clone(), swept)));
        all.push((core.clone(), core));
    }
    all
}

/// Pairs 2k, 2k + 1 that mostly touch; and the same objects without what is swept round them.
fn scenes(draw: &mut Draw, count: usize) -> [Scene; 2] {
    let (cores, swept): (Vec<_>, Vec<_>) = shapes(draw).into_iter().unzip();
    let objects: Vec<_> = (0..2 * count)
        .map(|k| {
            let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
            let kind = (draw.number().abs() * 1e6) as usize % swept.len();
            let pose = Pose::new(turn, DVec3::splat((k / 2) as f64) + draw.vector() * 0.8).unwrap();
            Object::new(kind as u32, pose)
        })
        .collect();
    [cores, swept].map(|shapes| Scene::new(shapes, objects.clone()).unwrap())
}

fn prepared(scene: &Scene) -> SimdFrame {
    let (mut frame, mut aabbs) = (SimdFrame::default(), vec![Aabb::default(); scene.len()]);
    let part = frame.layout(scene, Sides::One, Purpose::Measure);
    prepare(Path::best(), Prepare { scene, first: 0, part, aabbs: &mut aabbs });
    frame
}

#[test]
fn no_pair_that_the_lanes_search_is_left_out_and_hardly_another_is_listed() {
    let [_, scene] = scenes(&mut Draw(7), 4000);
    let frame = prepared(&scene);
    let frames = FramePair::of_one(&frame);
    let side = |object: u32| Side {
        core: &frame.cores().cores()[scene.shape_index(object as usize) as usize],
        blocks: frame.blocks_of(frame.record(object)),
        placed: PosedShape::of(&scene, object),
    };
    for accuracy in ACCURACIES {
        let (mut searched, mut others) = (0, 0);
        for pair in (0..4000).map(|k| Pair::new(2 * k, 2 * k + 1)) {
            let is_searched = SearchedPair::of([side(pair.i), side(pair.j)], accuracy).is_some();
            let may_be = may_be_searched(frames, pair, accuracy);
            assert!(may_be || !is_searched, "{accuracy:?} {pair:?}");
            searched += usize::from(is_searched);
            others += usize::from(may_be && !is_searched);
        }
        // Cylinders, rounded cuboids, what has no radius at all.
        assert!(searched > 1000 && others < 2000, "{accuracy:?} {searched} {others}");
    }
}

#[test]
fn cores_that_overlap_by_their_spheres_are_not_thought_to_be_apart_and_most_others_are() {
    let [cores, swept] = scenes(&mut Draw(8), 4000);
    let frame = prepared(&swept);
    let frames = FramePair::of_one(&frame);
    // Cores that are apart, and that are not: not thought so, and thought so.
    let mut counts = [[0; 2]; 2];
    for pair in (0..4000).map(|k| Pair::new(2 * k, 2 * k + 1)) {
        let is_swept = [pair.i, pair.j].map(|k| swept.shape(k as usize).radius() > 0.0);
        let thought = are_cores_apart(frames, pair);
        if is_swept == [false; 2] || !may_be_searched(frames, pair, Accuracy::F64) {
            assert!(is_swept != [false; 2] || !thought, "{pair:?}");
            continue;
        }
        let [a, b] = [pair.i, pair.j].map(|k| PosedShape::of(&cores, k));
        let touch = certified::overlap_of(a, b).0 == Verdict::Touching(());
        assert!(thought || touch, "{pair:?}");
        counts[usize::from(touch)][usize::from(thought)] += 1;
    }
    let [[_, apart], [known, taken_for_apart]] = counts;
    assert!(apart > 500 && known > 500 && taken_for_apart < known, "{counts:?}");
}

#[test]
fn each_pair_is_listed_once_with_others_alike_and_in_their_order() {
    let [_, scene] = scenes(&mut Draw(9), 500);
    let frame = prepared(&scene);
    let frames = FramePair::of_one(&frame);
    let pairs: Vec<_> = (0..500).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let mut searched = Searched::default();
    // What was listed before is forgotten.
    for _ in 0..2 {
        searched.begin();
        (0..).zip(&pairs).for_each(|(number, &pair)| searched.push(frames, (number, pair)));
        searched.end(&pairs);
    }
    let like = |number: &u32| {
        let Pair { i, j } = pairs[*number as usize];
        let either = frame.record(i).marks | frame.record(j).marks;
        let is_straight = either & STRAIGHT_CORE != 0;
        let like = if is_straight { 1 } else { 2 };
        (if either & BOX != 0 { 0 } else { like }, *number)
    };
    let mut due: Vec<u32> = (0..500).collect();
    due.sort_by_key(like);
    assert_eq!(searched.numbers, due);
    assert!(searched.pairs.iter().eq(due.iter().map(|&number| &pairs[number as usize])));
}
