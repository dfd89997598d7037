//! The clearance of a proof beside the true distance or depth, ways beside the points' own, and facts
//! that expire.

use super::facts::{Fact, Facts};
use super::track::Track;
use super::*;
use crate::simd::Overlap;
use crate::simd::axis::Axis;
use crate::simd::certificate::GapBounds;
use crate::simd::cores::Cores;
use crate::{Depths, DistanceResult, PairSolver, PosedShape, Verdict, distance};
use dcd_geom::Shape;
use dcd_geom::glam::{DMat3, DQuat, DVec3, Vec3};
use dcd_geom::{Object, Pose};
use proptest::prelude::*;

fn vector(half_width: f64) -> impl Strategy<Value = DVec3> {
    let number = -half_width..half_width;
    (number.clone(), number.clone(), number).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

fn pose(half_width: f64) -> impl Strategy<Value = Pose> {
    (vector(3.0), vector(half_width))
        .prop_map(|(turn, at)| Pose::new(DQuat::from_scaled_axis(turn), at).unwrap())
}

/// Hulls of all proportions, rounded or not, spheres and boxes.
fn shape() -> impl Strategy<Value = Shape> {
    let size = (0.02f64..1.0, 0.02f64..1.0, 0.02f64..1.0);
    let points = prop::collection::vec(vector(1.0), 4..40);
    (points, size, 0u32..5, 0.01f64..0.3).prop_filter_map("flat", |(points, size, kind, radius)| {
        let size = DVec3::new(size.0, size.1, size.2);
        let hull = Shape::hull(points.iter().map(|p| *p * size).collect());
        match kind {
            0 => Shape::sphere(radius).ok(),
            1 => Shape::cuboid(size).ok(),
            2 => hull.and_then(|hull| hull.rounded(radius)).ok(),
            _ => hull.ok(),
        }
    })
}

fn cores_of(scene: &Scene) -> Cores {
    let mut cores = Cores::default();
    cores.follow(scene);
    cores
}

/// The pairs of a scene, each with what the lanes proved of it and the clearance of that, after axes to
/// be tried first and looking for that much clearance.
fn clearances(scene: &Scene, path: Path, axes: &[Axis], wanted: f32) -> Vec<(Pair, bool, f32)> {
    judged::<ClearanceBounds>(scene, path, axes, wanted)
}

fn judged<T: ErrorBounds>(
    scene: &Scene,
    path: Path,
    axes: &[Axis],
    wanted: f32,
) -> Vec<(Pair, bool, f32)> {
    let narrow = Overlap::on(path);
    let mut lanes = frame::SimdFrame::default();
    let mut aabbs = vec![Aabb::default(); scene.len()];
    let part = narrow.layout(scene, Sides::One, &mut lanes);
    narrow.prepare(scene, 0, part, &mut aabbs);
    let objects = 0..scene.len() as u32;
    let pairs = objects.clone().flat_map(|j| (0..j).map(move |i| Pair::new(i, j)));
    let pairs: Vec<Pair> = pairs.collect();
    let mut scratch = decide::Scratch::default();
    let kept = scratch.kept_mut();
    kept.want(wanted);
    kept.axes.extend(pairs.iter().zip(axes.iter().cycle()).map(|(_, axis)| *axis));
    let side = Prepared { scene, frame: &lanes };
    let slice = Slice { path, a: side, b: side, pairs: &pairs };
    let mut report = Report::default();
    slice.judge::<T>(&mut scratch, &mut report);
    // However many proofs a pair has, it is counted once.
    let resolved: u64 = Method::ALL.iter().map(|&method| report.resolved(method)).sum();
    assert_eq!(resolved as usize + report.undecided().len(), pairs.len());
    let found = scratch.touching().iter().zip(scratch.kept().clearance());
    pairs
        .iter()
        .zip(found)
        .map(|(&pair, (&touching, &clearance))| (pair, touching, clearance))
        .collect()
}

/// How far apart two objects are, or how deep in each other, at most.
fn reach(scene: &Scene, pair: Pair) -> f64 {
    let placed =
        |i: u32| PosedShape { shape: scene.shape(i as usize), pose: &scene.poses()[i as usize] };
    let (a, b) = (placed(pair.i), placed(pair.j));
    match distance::distance(a, b).0 {
        DistanceResult::Apart(distance) => distance.upper(),
        _ => match Depths.solve(a, b, &mut <Depths as PairSolver>::Scratch::default()) {
            Verdict::Touching(depth) => depth.depth + depth.error_bound,
            other => panic!("{pair:?}: {other:?}"),
        },
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_proof_has_more_clearance_than_the_true_distance_or_depth(
        objects in prop::collection::vec((shape(), pose(1.2)), 2..12),
        axes in prop::collection::vec((vector(1.0), any::<bool>()), 0..7),
    ) {
        let (shapes, poses) = objects.into_iter().unzip();
        let scene = Scene::one_each(shapes, poses).unwrap();
        let axis = |(d, is): (DVec3, bool)| if is { Axis::along(d.as_vec3()) } else { Axis::default() };
        let axes: Vec<Axis> = axes.into_iter().map(axis).collect();
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let fresh = clearances(&scene, path, &[], 0.0);
            let hinted = clearances(&scene, path, &axes, 0.0);
            let [widened, widest] = [1.0 / 32.0, 1e3].map(|wanted| clearances(&scene, path, &[], wanted));
            for (k, &(pair, touching, clearance)) in fresh.iter().enumerate() {
                // Whatever is tried first and however much clearance is looked for, the answer is the same.
                for other in [hinted[k], widened[k], widest[k]] {
                    prop_assert_eq!(touching, other.1, "{:?}, {:?}", pair, path);
                }
                // A proof that had enough is not given up for one that has less.
                prop_assert!(clearance <= widened[k].2 && clearance <= widest[k].2, "{pair:?}, {path:?}");
                let reach = reach(&scene, pair);
                for clearance in [clearance, hinted[k].2, widened[k].2, widest[k].2] {
                    prop_assert!(f64::from(clearance) <= reach, "{pair:?}, {path:?}: {clearance} of {reach}");
                }
            }
        }
    }

    #[test]
    fn a_gap_is_at_most_the_distance_of_two_that_are_apart(
        objects in prop::collection::vec((shape(), pose(1.2)), 2..12),
    ) {
        let (shapes, poses) = objects.into_iter().unzip();
        let scene = Scene::one_each(shapes, poses).unwrap();
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let gaps = judged::<GapBounds>(&scene, path, &[], 0.0);
            for (found, (pair, touching, gap)) in clearances(&scene, path, &[], 0.0).iter().zip(gaps) {
                prop_assert_eq!((found.0, found.1), (pair, touching), "{:?}", path);
                let is_gap = gap < 0.0 || !touching && f64::from(gap) <= reach(&scene, pair);
                prop_assert!(is_gap, "{pair:?}, {path:?}: {gap}");
                // Either kind of lanes leaves open what is within rounding of touching alone.
                prop_assert!(touching || found.2 < 1e-3 || gap > 0.0, "{pair:?}, {path:?}: {gap}");
            }
        }
    }

    #[test]
    fn no_point_of_an_object_moves_farther_than_its_way(
        shape in shape(),
        from in pose(5.0),
        to in pose(5.0),
        part in 0.0f64..1.0,
        stretch in -5e-7f64..5e-7,
    ) {
        // From almost no motion to any, and matrices that are almost rotations.
        let blend = |a: DVec3, b: DVec3| a + (b - a) * part.powi(8);
        let turn = DQuat::from_mat3(from.rotation()).slerp(DQuat::from_mat3(to.rotation()), part.powi(8));
        let matrix = DMat3::from_quat(turn.normalize()) * (1.0 + stretch);
        let to = Pose::from_matrix(matrix, blend(from.translation(), to.translation())).unwrap();
        let object = Object::new(0, from);
        let mut scene = Scene::new(vec![shape.clone()], [object]).unwrap();
        let mut track = Track::default();
        let cores = cores_of(&scene);
        track.follow(&scene, cores.cores(), 0);
        let before = track.way();
        scene.set_pose(0, to).unwrap();
        track.follow(&scene, cores.cores(), 0);
        let way = track.way().travelled - before.travelled;
        for v in shape.as_polytope().unwrap().vertices() {
            let moved = to.apply(*v).distance(from.apply(*v));
            prop_assert!(way == before.limit || moved <= way * (1.0 + 1e-15) + 1e-15, "{moved} {way}");
        }
    }
}

#[test]
fn most_proofs_have_more_clearance_where_it_is_wanted() {
    let wave =
        |k: i32| DVec3::new(f64::from(k).sin(), f64::from(3 * k).cos(), f64::from(7 * k).sin());
    let hull = |k: i32| Shape::hull((0..20).map(|n| wave(20 * k + n) * 0.5).collect()).unwrap();
    let place = |k: i32| Pose::new(DQuat::from_scaled_axis(wave(k)), wave(1000 + k) * 2.0).unwrap();
    let scene = Scene::one_each((0..60).map(hull).collect(), (0..60).map(place).collect()).unwrap();
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        let fresh = clearances(&scene, path, &[], 0.0);
        let widened = clearances(&scene, path, &[], 1.0 / 32.0);
        let is_narrow = |&k: &usize| (0.0..0.02).contains(&fresh[k].2);
        let near: Vec<usize> = (0..fresh.len()).filter(is_narrow).collect();
        let wider = near.iter().filter(|&&k| widened[k].2 > 1.5 * fresh[k].2).count();
        assert!(near.len() > 20 && 2 * wider > near.len(), "{wider} of {}, {path:?}", near.len());
    }
}

#[test]
fn upright_cuboids_have_a_proof_that_lasts_though_their_closed_form_has_none() {
    let cuboid = Shape::cuboid(DVec3::new(0.5, 0.1, 0.1)).unwrap();
    let place = |x: f64| Pose::from_translation(DVec3::new(x, 0.0, 0.0)).unwrap();
    // The second is deep in the first, the third a quarter of a metre from the second.
    let poses = [0.0, 0.5, 1.75].map(place).to_vec();
    let scene = Scene::one_each(vec![cuboid; 3], poses).unwrap();
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        let found = clearances(&scene, path, &[], 0.0);
        assert!(found.iter().all(|&(_, _, clearance)| clearance > 0.09), "{path:?}: {found:?}");
        let plain = judged::<GapBounds>(&scene, path, &[], 0.0);
        let answers = plain.iter().map(|&(_, touching, _)| touching);
        assert!(answers.eq([true, false, false]), "{path:?}: {plain:?}");
    }
}

#[test]
fn an_object_at_rest_goes_no_way_and_another_in_its_slot_goes_a_long_one() {
    let shapes = vec![Shape::sphere(0.5).unwrap(), Shape::sphere(2.0).unwrap()];
    let mut scene = Scene::new(shapes, [Object::new(1, Pose::IDENTITY)]).unwrap();
    let mut track = Track::default();
    let cores = cores_of(&scene);
    track.follow(&scene, cores.cores(), 0);
    let at_first = track.way();
    track.follow(&scene, cores.cores(), 0);
    assert_eq!(track.way().travelled, at_first.travelled);
    assert!(!track.exceeds(1e-9));
    scene.remove(scene.handle(0).unwrap()).unwrap();
    scene.insert(Object::new(0, Pose::IDENTITY)).unwrap();
    track.follow(&scene, cores.cores(), 0);
    // No fact about the large one had more clearance than its limit.
    assert!(track.way().travelled >= at_first.travelled + at_first.limit);
}

#[test]
fn a_jump_beyond_all_bounds_counts_as_the_limit_and_many_of_them_wear_the_way_out() {
    let mut scene =
        Scene::new(vec![Shape::sphere(1.0).unwrap()], [Object::new(0, Pose::IDENTITY)]).unwrap();
    let mut track = Track::default();
    let cores = cores_of(&scene);
    track.follow(&scene, cores.cores(), 0);
    for jump in 1..5000 {
        let at = DVec3::X * if jump % 2 == 0 { 1e9 } else { -1e9 };
        scene.set_pose(0, Pose::from_translation(at).unwrap()).unwrap();
        let before = track.way();
        let worn = track.follow(&scene, cores.cores(), 0);
        assert_eq!(track.way().travelled, before.travelled + before.limit);
        assert!(track.exceeds(7.9) && !track.exceeds(8.1));
        if worn {
            assert!(jump > 1000, "{jump}");
            return;
        }
    }
    panic!("never worn");
}

/// Facts about that many objects, each in a pair with each.
fn facts(objects: u32) -> (Facts, Vec<Pair>) {
    let pairs = (0..objects).flat_map(|j| (0..j).map(move |i| Pair::new(i, j)));
    let pairs: Vec<Pair> = pairs.collect();
    let mut facts = Facts::default();
    facts.resize(objects as usize);
    (0..objects as usize).for_each(|i| go(&mut facts, i, 0.0));
    facts.lay_out_tiles(std::iter::once(&pairs[..]));
    (facts, pairs)
}

fn go(facts: &mut Facts, object: usize, travelled: f64) {
    let (entries, limits) = facts.ways_mut();
    let way = facts::Way { travelled, limit: 8.0 };
    way.write(&mut entries[object], &mut limits[object]);
}

fn recall(facts: &Facts, pair: Pair) -> Option<Fact> {
    facts.recall(&facts.reader().find(pair))
}

fn remember(facts: &Facts, pair: Pair, fact: Fact, clearance: f32) {
    facts.remember((pair, facts.reader().find(pair).slot), fact, clearance);
}

#[test]
fn a_fact_holds_until_both_objects_together_have_gone_its_clearance() {
    let (mut facts, pairs) = facts(2);
    assert_eq!(recall(&facts, pairs[0]), None);
    remember(&facts, pairs[0], Fact::Touching, 0.5);
    go(&mut facts, 0, 0.3);
    go(&mut facts, 1, 0.1999);
    assert_eq!(recall(&facts, pairs[0]), Some(Fact::Touching));
    go(&mut facts, 1, 0.2);
    assert_eq!(recall(&facts, pairs[0]), None);
    remember(&facts, pairs[0], Fact::Apart, 1.0);
    assert_eq!(recall(&facts, pairs[0]), Some(Fact::Apart));
    // More clearance than the limit is not believed: a jump counts as no more.
    remember(&facts, pairs[0], Fact::Apart, 1e6);
    go(&mut facts, 1, 8.2);
    assert_eq!(recall(&facts, pairs[0]), None);
}

#[test]
fn what_is_recalled_is_what_was_remembered_in_any_order() {
    // Tiles of sixteen objects a side, and of four.
    for count in [300, 30] {
        let (facts, mut pairs) = facts(count);
        let fact = |pair: Pair| {
            if (pair.i ^ pair.j).is_multiple_of(3) { Fact::Touching } else { Fact::Apart }
        };
        let clearance = |pair: Pair| 0.1 + (pair.i + 1000 * pair.j) as f32 * 1e-6;
        pairs.iter().for_each(|&pair| remember(&facts, pair, fact(pair), clearance(pair)));
        pairs.sort_unstable_by_key(|pair| pair.i.wrapping_mul(2_654_435_761) ^ pair.j);
        let mut reader = facts.reader();
        for pair in pairs {
            assert_eq!(facts.recall(&reader.find(pair)), Some(fact(pair)), "{pair:?}");
        }
    }
}

#[test]
fn an_axis_is_kept_until_the_two_touch_or_a_neighbour_takes_its_word() {
    let (facts, pairs) = facts(300);
    let slot = |pair: Pair| facts.reader().find(pair).slot;
    let (none, up) = (Axis::default(), Axis::along(Vec3::new(0.0, 1e-20, -5e-21)));
    assert_eq!(up, Axis([0, i16::MAX, -16383]));
    assert_eq!([Vec3::ZERO, Vec3::NAN].map(Axis::along), [none; 2]);
    facts.keep_axis(slot(pairs[0]), Fact::Apart, up);
    let having = pairs.iter().filter(|&&pair| facts.axis(slot(pair)) != none);
    assert_eq!(having.copied().collect::<Vec<_>>(), [pairs[0]]);
    assert_eq!(facts.axis(slot(pairs[0])), up);
    facts.keep_axis(slot(pairs[0]), Fact::Touching, up);
    assert_eq!(facts.axis(slot(pairs[0])), none);
    // Of any axes some are lost, and none is taken for another pair's.
    let own = |pair: Pair| Axis([pair.i as i16 + 1, pair.j as i16, -7]);
    pairs.iter().for_each(|&pair| facts.keep_axis(slot(pair), Fact::Apart, own(pair)));
    assert!(pairs.iter().all(|&pair| [none, own(pair)].contains(&facts.axis(slot(pair)))));
    assert!(pairs.iter().filter(|&&pair| facts.axis(slot(pair)) != none).count() > pairs.len() / 9);
}

#[test]
fn tiles_are_laid_out_for_the_candidates_and_anew_when_these_have_become_others() {
    let objects = 64;
    let chain = |step: u32| (0..objects - step).map(|i| Pair::new(i, i + step)).collect::<Vec<_>>();
    let (near, far) = (chain(1), chain(32));
    let mut facts = Facts::default();
    facts.resize(objects as usize);
    (0..objects as usize).for_each(|i| go(&mut facts, i, 0.0));
    facts.lay_out_tiles([&near[..5], &near[5..]].into_iter());
    near.iter().for_each(|&pair| remember(&facts, pair, Fact::Apart, 1.0));
    far.iter().for_each(|&pair| remember(&facts, pair, Fact::Touching, 1.0));
    assert!(near.iter().all(|&pair| recall(&facts, pair) == Some(Fact::Apart)));
    assert!(far.iter().all(|&pair| recall(&facts, pair).is_none()));
    // Too many found no tile: all is forgotten, and kept of these from now on.
    facts.lay_out_tiles(std::iter::once(&far[..]));
    assert!(near.iter().all(|&pair| recall(&facts, pair).is_none()));
    far.iter().for_each(|&pair| remember(&facts, pair, Fact::Touching, 1.0));
    facts.lay_out_tiles(std::iter::once(&far[..]));
    assert!(far.iter().all(|&pair| recall(&facts, pair) == Some(Fact::Touching)));
}

#[test]
fn nothing_is_kept_without_clearance_or_without_a_tile() {
    let (mut facts, pairs) = facts(3);
    for clearance in [0.0, -1.0, f32::NAN, 1e-38] {
        remember(&facts, pairs[0], Fact::Apart, clearance);
        assert_eq!(recall(&facts, pairs[0]), None, "{clearance}");
    }
    // No tile is about objects that came after the layout.
    facts.resize(5);
    [3, 4].into_iter().for_each(|object| go(&mut facts, object, 0.0));
    remember(&facts, pairs[0], Fact::Apart, 1.0);
    for i in 0..4 {
        remember(&facts, Pair::new(i, 4), Fact::Touching, 1.0);
    }
    assert!((0..4).all(|i| recall(&facts, Pair::new(i, 4)).is_none()));
    assert_eq!(recall(&facts, pairs[0]), Some(Fact::Apart));
}
