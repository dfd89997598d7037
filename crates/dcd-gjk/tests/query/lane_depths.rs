//! How deep, with lanes inside each pair: beside the exact search, on every path.

use super::scenes::{Draw, pile, shapes};
use super::within::found;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Object, Pair, Polytope, Pose, Scene, Shape, SupportMap};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{
    Accuracy, Contact, Depths, DistanceResult, Distances, Manifolds, Overlap, PosedShape,
    PosedSupport, SimdDepths, SimdDistances, ThenMeasure, Verdict, WithAccuracy, distance, epa,
};
use dcd_simd::Path;

/// How many pairs of random hulls are compared with the exact search.
const PAIRS: u32 = 20_000;

/// Hulls of many sorts, each in 0.2 … 2 times `scale`: round ones, cuboids, needles, plates, flat and collinear
/// ones, single points, one far from its own origin, a lattice of many coplanar corners.
fn hulls(draw: &mut Draw, scale: f64) -> Vec<Shape> {
    let mut all = Vec::new();
    for k in 0..48 {
        let count = [1, 2, 3, 4, 5, 8, 16, 24, 40, 64][k % 10];
        let stretch = match k % 6 {
            0 => DVec3::new(1.0, 0.03, 0.02),
            1 => DVec3::new(1.0, 1.0, 1e-3),
            2 => DVec3::new(1.0, 0.7, 0.0),
            _ => DVec3::new(1.0, 0.8, 0.6),
        };
        let on_lattice = k % 7 == 3;
        let away = if k % 11 == 5 { DVec3::splat(3.0) } else { DVec3::ZERO };
        let corner = |draw: &mut Draw| {
            let v = draw.vector();
            let v = if on_lattice { (v * 2.0).round() / 2.0 } else { v };
            (v * stretch + away) * scale
        };
        let points: Vec<_> = (0..count).map(|_| corner(draw)).collect();
        all.push(Shape::hull(points).unwrap());
    }
    all.push(Shape::cuboid(DVec3::new(0.5, 0.4, 0.3) * scale).unwrap());
    all
}

/// Pairs 2k, 2k + 1 that touch in many ways: deep, nested, concentric, identical, and by next to nothing.
fn pairs_of(draw: &mut Draw, scale: f64, far: f64, count: u32) -> (Scene, Vec<Pair>) {
    let shapes = hulls(draw, scale);
    pairs_among(draw, shapes, [scale, far], count)
}

/// The same of such shapes.
fn pairs_among(
    draw: &mut Draw,
    shapes: Vec<Shape>,
    [scale, far]: [f64; 2],
    count: u32,
) -> (Scene, Vec<Pair>) {
    let kinds = shapes.len() as u32;
    let mut objects = Vec::new();
    for k in 0..count {
        let kind = |draw: &mut Draw| ((draw.unit().abs() * f64::from(kinds)) as u32).min(kinds - 1);
        let (one, other) = (kind(draw), kind(draw));
        let other = if k % 16 == 0 { one } else { other };
        let place = draw.vector() * far;
        let turn = draw.turn();
        objects.push(Object::new(one, Pose::new(turn, place).unwrap()));
        let reach = match k % 8 {
            0 => 0.0,
            1 => 1e-9,
            2 => 1e-3,
            3 => 0.2,
            _ => 1.0,
        };
        let middle = |kind: u32| shapes[kind as usize].as_polytope().unwrap().inner().centre;
        let second = if k % 5 == 0 { turn } else { draw.turn() };
        let centres = turn * middle(one) - second * middle(other);
        let there = place + centres + draw.vector() * reach * scale;
        objects.push(Object::new(other, Pose::new(second, there).unwrap()));
    }
    let pairs = (0..count).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    (Scene::new(shapes, objects).unwrap(), pairs)
}

fn exact(scene: &Scene, pair: Pair, scratch: &mut epa::Scratch) -> epa::Depth {
    let side = |k: u32| {
        let shape = scene.shape(k as usize).as_polytope().unwrap();
        PosedSupport::polytope(shape, &scene.poses()[k as usize])
    };
    epa::depth_of_overlap(side(pair.i), side(pair.j), scratch)
}

/// The depths of all pairs that touch, the same on every path.
fn depths_on_every_path(
    accuracy: Accuracy,
    scene: &Scene,
    pairs: &[Pair],
) -> Vec<Contact<epa::Depth>> {
    let (yes, _) = found(&Overlap::default(), scene, pairs);
    let mut first: Option<Vec<Contact<epa::Depth>>> = None;
    for path in paths() {
        let narrow = SimdDepths::on(path, Depths, accuracy);
        let (depths, report) = found(&narrow, scene, pairs);
        assert!(report.undecided().is_empty());
        assert!(depths.iter().map(|c| c.pair).eq(yes.iter().map(|c| c.pair)));
        match &first {
            Some(first) => assert!(*first == depths, "{path:?}"),
            None => first = Some(depths),
        }
    }
    first.unwrap()
}

/// What single pairs of a scene have, which touch.
pub(super) fn alone(
    accuracy: Accuracy,
    scene: &Scene,
    pairs: impl Iterator<Item = Pair>,
) -> Vec<Contact<epa::Depth>> {
    let mut scratch = epa::Scratch::default();
    let measured = pairs.map(|pair| {
        let [a, b] = [pair.i, pair.j].map(|k| PosedShape::of(scene, k));
        match Depths.measure_at(accuracy, a, b, &mut scratch) {
            Verdict::Touching(answer) => Contact { pair, answer },
            other => panic!("{pair:?} {other:?}"),
        }
    });
    measured.collect()
}

/// How far the points of a depth are from differing by it along its normal.
fn missed(found: &epa::Depth) -> f64 {
    (found.point_a - found.point_b - found.normal * found.depth).length()
}

#[test]
fn points_are_along_the_normal_where_faces_all_but_lie_in_one_plane() {
    // Two wedges, an edge of one in a face of the other but for 1e-7.
    let corner = |k: u32| {
        let sign = |bit: u32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
        DVec3::new(1.0, 1e-3 * sign(0), 1e-7 * sign(1))
    };
    let ends = [-1e-3, 1e-3].map(|y| DVec3::new(0.0, y, 0.0));
    let wedge = Shape::hull((0..4).map(corner).chain(ends).collect()).unwrap();
    let half_turn = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0));
    let turn = DMat3::from_cols_array(&[
        -0.9999999999996989,
        4.365558646481551e-7,
        6.4150524660713e-7,
        4.3655574467203865e-7,
        0.9999999999998872,
        -1.870229421839235e-7,
        -6.415053282530199e-7,
        -1.8702266213106658e-7,
        -0.9999999999997767,
    ]);
    let place = DVec3::new(-1.625149205684424e-8, 0.0, 1.8702350779165045e-10);
    let poses = [(half_turn, DVec3::ZERO), (turn, place)]
        .map(|(turn, place)| Pose::from_matrix(turn, place).unwrap());
    let wedges = Scene::one_each(vec![wedge.clone(), wedge], poses.to_vec()).unwrap();
    // A small hull in a large flat one, one of whose points is inside of its outline.
    let points = |all: &[[f64; 3]]| all.iter().map(|&point| DVec3::from(point)).collect();
    let small = points(&[
        [0.0, 1.0, 1.0],
        [-1.0, -1.0, 1.0],
        [0.0, 0.0, 2.0],
        [-1.0, -2.0, 2.0],
        [-2.0, 1.0, 0.0],
    ]);
    let flat = points(&[[-2e5, -2e5, 0.0], [2e5, 2e5, 0.0], [-1e5, -1e5, 0.0], [0.0, 0.0, 0.0]]);
    let third = DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y);
    let poses = [(half_turn, DVec3::ZERO), (third, DVec3::new(2.0, -2.0, -1.0))]
        .map(|(turn, place)| Pose::from_matrix(turn, place).unwrap());
    let shapes = [small, flat].map(|points| Shape::hull(points).unwrap());
    let needle = Scene::one_each(shapes.to_vec(), poses.to_vec()).unwrap();
    let pairs = [Pair::new(0, 1)];
    for (scene, size) in [(wedges, 2.0), (needle, 3e5)] {
        for (accuracy, most) in
            [(Accuracy::F32, 1e-5), (Accuracy::F64, 2e-9), (Accuracy::Certified, 2e-9)]
        {
            let in_lanes = depths_on_every_path(accuracy, &scene, &pairs);
            let alone = alone(accuracy, &scene, pairs.into_iter());
            for Contact { answer, .. } in in_lanes.iter().chain(&alone) {
                assert!(missed(answer) <= most * size, "{accuracy:?} {answer:?}");
            }
        }
    }
}

fn paths() -> impl Iterator<Item = Path> {
    Path::ALL.into_iter().filter(|path| path.is_available())
}

#[test]
fn the_exact_depth_is_within_the_bound_on_every_path_and_all_paths_agree() {
    let mut scratch = epa::Scratch::default();
    let mut bounds = Vec::new();
    for (seed, scale, far, count) in [
        (1, 1.0, 1.0, PAIRS),
        (2, 1e-4, 1e-4, 2000),
        (3, 1e5, 1e5, 2000),
        (4, 1.0, 1e6, 2000),
        (5, 1e-12, 1e-12, 200),
        (6, 1e12, 1e12, 200),
    ] {
        let mut draw = Draw(seed);
        let (scene, pairs) = pairs_of(&mut draw, scale, far, count);
        let (yes, _) = found(&Overlap::default(), &scene, &pairs);
        let truths: Vec<_> = yes.iter().map(|yes| exact(&scene, yes.pair, &mut scratch)).collect();
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let depths = depths_on_every_path(accuracy, &scene, &pairs);
            let alone = alone(accuracy, &scene, yes.iter().map(|yes| yes.pair));
            let in_turn = depths.iter().chain(&alone);
            for (Contact { pair, answer }, truth) in in_turn.zip(truths.iter().chain(&truths)) {
                let (i, j) = (pair.i as usize, pair.j as usize);
                let apart = scene.poses()[i].translation() - scene.poses()[j].translation();
                let size =
                    scene.shape(i).reach() + scene.shape(j).reach() + apart.abs().element_sum();
                let off = (answer.depth - truth.depth).abs();
                assert!(
                    off <= answer.error_bound + truth.error_bound,
                    "{seed} {pair:?} {accuracy:?} {answer:?} {truth:?}"
                );
                assert!((answer.normal.length() - 1.0).abs() < 1e-14);
                match accuracy {
                    Accuracy::F32 => bounds.push(answer.error_bound / size),
                    Accuracy::F64 => assert!(answer.error_bound <= 1e-9 * size),
                    Accuracy::Certified => {
                        let most = (1e-9 * answer.depth).max(1e-21 * size);
                        assert!(answer.error_bound <= most, "{seed} {pair:?} {answer:?}");
                    }
                }
            }
        }
    }
    bounds.sort_unstable_by(f64::total_cmp);
    let (median, worst) = (bounds[bounds.len() / 2], bounds[bounds.len() - 1]);
    println!("{} depths, bounds of {median:e} and {worst:e} of the size", bounds.len());
    assert!(bounds.len() > 10_000 && worst < 1e-5, "{} {worst}", bounds.len());
}

#[test]
fn both_orders_are_mirrored_and_other_pairs_change_nothing() {
    let mut draw = Draw(23);
    let scene = pairs_of(&mut draw, 1.0, 2.0, 1000);
    are_mirrored_and_alone(scene);
    are_mirrored_and_alone(swept_pairs(&mut draw, 1.0, 1000));
}

fn are_mirrored_and_alone((scene, pairs): (Scene, Vec<Pair>)) {
    let reversed: Vec<_> = (0..2000u32)
        .rev()
        .map(|k| Object::new(scene.shape_of()[k as usize], scene.poses()[k as usize]))
        .collect();
    let mirrored = Scene::new(scene.shapes().to_vec(), reversed).unwrap();
    for accuracy in [Accuracy::F32, Accuracy::Certified] {
        let lanes = SimdDepths::new(Depths, accuracy);
        let (all, _) = found(&lanes, &scene, &pairs);
        let other_pairs: Vec<_> =
            pairs.iter().rev().map(|pair| Pair::new(1999 - pair.j, 1999 - pair.i)).collect();
        let (seen, _) = found(&lanes, &mirrored, &other_pairs);
        assert!(all.len() > 500 && all.len() == seen.len());
        for (one, other) in all.iter().zip(seen.iter().rev()) {
            let [i, j] = [one.pair.i, one.pair.j].map(|k| k as usize);
            let same = scene.shape_of()[i] == scene.shape_of()[j];
            if same && scene.poses()[i] == scene.poses()[j] {
                // Both are equal, so both orders are one.
                continue;
            }
            let (one, other) = (one.answer, other.answer);
            assert_eq!((one.depth, one.error_bound), (other.depth, other.error_bound));
            assert_eq!((one.point_a, one.point_b), (other.point_b, other.point_a));
            assert_eq!(one.normal, -other.normal);
        }
        for chunk in pairs.chunks(7).take(40) {
            let (some, _) = found(&lanes, &scene, chunk);
            assert!(some.iter().eq(all.iter().filter(|contact| chunk.contains(&contact.pair))));
        }
    }
}

/// Rounded hulls, capsules and spheres; and among pairs of these as many whose cores all but touch, apart or overlapping by
/// next to nothing.
fn swept_pairs(draw: &mut Draw, scale: f64, count: u32) -> (Scene, Vec<Pair>) {
    let cores = hulls(draw, scale);
    let mut swept: Vec<_> = (0..)
        .zip(&cores)
        .map(|(k, core)| match k % 3 {
            0 => core.clone(),
            _ => core.swept(0.1 * f64::from(k % 3) * scale).unwrap(),
        })
        .collect();
    swept.push(Shape::capsule(0.4 * scale, 0.2 * scale).unwrap());
    swept.push(Shape::sphere(0.3 * scale).unwrap());
    let (mut scene, pairs) = pairs_among(draw, swept, [scale, scale], count);
    for pair in pairs.iter().step_by(2) {
        let [i, j] = [pair.i, pair.j].map(|k| k as usize);
        let core = |k: usize| cores.get(scene.shape_of()[k] as usize);
        let (Some(a), Some(b)) = (core(i), core(j)) else { continue };
        let pose = scene.poses()[j];
        let away = draw.vector().normalize() * 10.0 * scale;
        let far = Pose::from_matrix(*pose.rotation(), scene.poses()[i].translation() + away);
        let far = far.unwrap();
        let one = PosedShape { shape: a, pose: &scene.poses()[i] };
        let (gap, _) = distance::distance(one, PosedShape { shape: b, pose: &far });
        let DistanceResult::Apart(gap) = gap else { continue };
        let left = [0.0, 1e-9, -1e-9, 3e-8, -3e-8, 1e-6, -1e-6][i / 4 % 7] * scale;
        let place = far.translation() - gap.normal * (gap.distance + left);
        scene.set_pose(j, Pose::from_matrix(*far.rotation(), place).unwrap()).unwrap();
    }
    (scene, pairs)
}

#[test]
fn the_exact_depth_of_rounded_hulls_is_within_the_bound_whether_their_cores_meet_or_not() {
    let mut scratch = epa::Scratch::default();
    for (seed, scale, count) in [(41, 1.0, 6000), (42, 1e-4, 1000), (43, 1e5, 1000)] {
        let (scene, pairs) = swept_pairs(&mut Draw(seed), scale, count);
        let mut truths = Vec::new();
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let depths = depths_on_every_path(accuracy, &scene, &pairs);
            if truths.is_empty() {
                truths.extend(depths.iter().map(|found| exact(&scene, found.pair, &mut scratch)));
            }
            let alone = alone(accuracy, &scene, depths.iter().map(|found| found.pair));
            let (mut rounded, mut open) = (0, 0);
            let in_turn = depths.iter().chain(&alone);
            for (Contact { pair, answer }, truth) in in_turn.zip(truths.iter().chain(&truths)) {
                let sides = [pair.i, pair.j].map(|k| scene.shape(k as usize));
                let reach = sides[0].reach() + sides[1].reach();
                let off = (answer.depth - truth.depth).abs();
                assert!(
                    off <= answer.error_bound + truth.error_bound,
                    "{seed} {pair:?} {accuracy:?} {answer:?} {truth:?}"
                );
                if sides[0].radius() + sides[1].radius() == 0.0 {
                    continue;
                }
                rounded += 1;
                open += usize::from(answer.error_bound > 1e-9 * answer.depth.max(1e-3 * reach));
                let between = answer.point_a - answer.point_b - answer.normal * answer.depth;
                assert!(
                    between.length() <= 1e-5 * reach,
                    "{seed} {pair:?} {accuracy:?} {answer:?}"
                );
            }
            // At the accuracy of f32 a few are what the scalar search leaves.
            let most = if accuracy == Accuracy::F32 { rounded / 20 } else { 0 };
            assert!(rounded > count as usize / 4 && open <= most, "{seed} {rounded} {open}");
        }
    }
}

#[test]
fn other_shapes_have_what_the_solver_says_alone() {
    let mut all = shapes();
    let parts =
        [0.4, -0.4].map(|x| (all[0].clone(), Pose::from_translation(DVec3::X * x).unwrap()));
    all.push(Shape::compound(parts.to_vec()).unwrap());
    all.push(Shape::cylinder(0.5, 0.3).unwrap());
    all.push(Polytope::segment(DVec3::NEG_X, DVec3::X).unwrap().rounded(0.2).unwrap().into());
    let (scene, pairs) = pile(all, 80);
    let accuracy = Accuracy::F64;
    let alone = ThenMeasure::new(WithAccuracy::new(Depths, accuracy)).unwrap();
    let (alone, _) = found(&alone, &scene, &pairs);
    let (lanes, _) = found(&SimdDepths::new(Depths, accuracy), &scene, &pairs);
    assert!(lanes.len() > 100 && lanes.len() == alone.len());
    for (lanes, alone) in lanes.iter().zip(&alone) {
        assert_eq!(lanes.pair, alone.pair);
        let (lanes, alone) = (lanes.answer, alone.answer);
        assert!(lanes.lower() <= alone.upper() && alone.lower() <= lanes.upper());
    }
}

/// Spheres of four sizes, some with one centre, some that just touch, some far from the origin, some 0.3 apart but for
/// rounding; and shapes of which there are no objects.
fn spheres(others: &[Shape]) -> (Scene, Vec<Pair>) {
    let mut draw = Draw(31);
    let radii = [0.5, 0.25, 0.1, 1e-6];
    let shapes = radii.map(|radius| Shape::sphere(radius).unwrap());
    let shapes = [&shapes, others].concat();
    let objects = (0..232).map(|k: u32| {
        let place = match k % 10 {
            _ if k >= 200 => DVec3::X * (10.0 + 0.4 * f64::from(k / 4 % 8)),
            0 => DVec3::X,
            1 => DVec3::new(1.75, 0.0, 0.0),
            2 => DVec3::new(1e6, f64::from(k % 20) * 0.03, 0.0),
            _ => draw.vector() * 1.5,
        };
        Object::new(k % 4, Pose::new(draw.turn(), place).unwrap())
    });
    let scene = Scene::new(shapes, objects).unwrap();
    let pairs = (0..232).flat_map(|i| (i + 1..232).map(move |j| Pair::new(i, j))).collect();
    (scene, pairs)
}

#[test]
fn spheres_have_to_the_bit_what_they_have_alone_on_every_path() {
    spheres_have_what_they_have_alone(&[]);
}

#[test]
fn spheres_beside_other_shapes_have_to_the_bit_what_they_have_alone() {
    spheres_have_what_they_have_alone(&[Shape::cuboid(DVec3::ONE).unwrap()]);
}

fn spheres_have_what_they_have_alone(others: &[Shape]) {
    let (scene, pairs) = spheres(others);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let alone = ThenMeasure::new(WithAccuracy::new(Depths, accuracy)).unwrap();
            let (alone, _) = found(&alone, &scene, &pairs);
            let (lanes, _) = found(&SimdDepths::on(path, Depths, accuracy), &scene, &pairs);
            assert!(alone.len() > 1000 && alone == lanes, "{path:?} {accuracy:?}");

            let solver = WithAccuracy::new(Manifolds::default(), accuracy);
            let (alone, _) = found(&ThenMeasure::new(solver).unwrap(), &scene, &pairs);
            let lanes = SimdDepths::on(path, Manifolds::default(), accuracy);
            let (lanes, _) = found(&lanes, &scene, &pairs);
            assert!(alone.len() > 1000 && alone == lanes, "{path:?} {accuracy:?}");

            let solver = WithAccuracy::new(Distances::within(0.3).unwrap(), accuracy);
            let (alone, _) = found(&ThenMeasure::new(solver).unwrap(), &scene, &pairs);
            let lanes = SimdDistances::on(path, 0.3, accuracy).unwrap();
            let (lanes, _) = found(&lanes, &scene, &pairs);
            assert!(alone.len() > 1500 && alone == lanes, "{path:?} {accuracy:?}");
        }
    }
}

#[test]
fn what_is_measured_one_by_one_has_to_the_bit_the_manifold_that_it_has_alone() {
    let mut draw = Draw(37);
    let cuboid = Shape::cuboid(DVec3::new(0.5, 0.4, 0.3)).unwrap();
    let hull = Shape::hull((0..20).map(|_| draw.vector() * 0.6).collect()).unwrap();
    let shapes = vec![
        Shape::sphere(0.3).unwrap(),
        Shape::capsule(0.4, 0.2).unwrap(),
        cuboid.swept(0.1).unwrap(),
        cuboid,
        hull,
    ];
    let (scene, pairs) = pairs_among(&mut draw, shapes, [1.0, 1.0], 6000);
    // By the numbers of the shapes: not what the lanes search, nor what they have formulas for.
    let is_alone = |pair: Pair| {
        let [i, j] = [pair.i, pair.j].map(|k| scene.shape_of()[k as usize]);
        let (least, most) = (i.min(j), i.max(j));
        if most == 4 { least == 0 } else { least == 2 || most == 2 }
    };
    let pairs: Vec<_> = pairs.into_iter().filter(|&pair| is_alone(pair)).collect();
    let solver = WithAccuracy::new(Manifolds::default(), Accuracy::F32);
    let (alone, _) = found(&ThenMeasure::new(solver).unwrap(), &scene, &pairs);
    for path in paths() {
        let narrow = SimdDepths::on(path, Manifolds::default(), Accuracy::F32);
        let (lanes, _) = found(&narrow, &scene, &pairs);
        assert!(alone == lanes, "{path:?}");
    }
    let count = |points: usize| {
        alone.iter().filter(|found| found.answer[0].points().len() == points).count()
    };
    assert!(count(1) > 500 && count(2) > 100 && count(4) > 50, "{} {}", count(1), count(2));
}

fn is_cuboid(shape: &Shape) -> bool {
    let polytope = shape.as_polytope();
    polytope.is_some_and(|polytope| matches!(polytope.kind(), Kind::Cuboid { .. }))
}

#[test]
fn manifolds_after_the_lanes_are_as_deep_as_the_pair() {
    let mut draw = Draw(29);
    let (scene, pairs) = pairs_of(&mut draw, 1.0, 1.0, 1000);
    let (depths, _) = found(&SimdDepths::new(Depths, Accuracy::F32), &scene, &pairs);
    let (manifolds, _) =
        found(&SimdDepths::new(Manifolds::default(), Accuracy::F32), &scene, &pairs);
    assert!(manifolds.len() > 500 && manifolds.len() == depths.len());
    for (manifold, depth) in manifolds.iter().zip(&depths) {
        let pair = depth.pair;
        let (manifold, depth) = (manifold.answer[0], depth.answer);
        let deepest = manifold.points()[0].depth;
        if [pair.i, pair.j].into_iter().all(|object| is_cuboid(scene.shape(object as usize))) {
            // Each by lanes of its own.
            let bound = manifold.error_bound + depth.error_bound;
            assert!((deepest - depth.depth).abs() <= bound, "{pair:?}");
        } else {
            assert_eq!((manifold.normal, deepest), (depth.normal, depth.depth));
        }
        assert!(manifold.points().iter().all(|point| point.depth <= deepest));
    }
}

#[test]
fn the_points_are_as_far_apart_as_the_pair_is_deep() {
    let (scene, pairs) = pairs_of(&mut Draw(29), 1.0, 1.0, PAIRS);
    let (depths, _) = found(&SimdDepths::new(Depths, Accuracy::F32), &scene, &pairs);
    for Contact { pair, answer } in &depths {
        let off = (answer.point_a - answer.point_b).distance(answer.normal * answer.depth);
        // The sizes and the way between the centres are below 20.
        assert!(off < 2e-4, "{pair:?}: {off}, {answer:?}");
    }
    assert!(depths.len() > 10_000, "{}", depths.len());
}
