//! How far apart.

use super::scenes::{Draw, all_pairs, in_both_orders, pile, shapes};
use super::within::found;
use super::{PosedSupport, answer_of, solve};
use dcd_geom::glam::{DQuat, DVec2, DVec3};
use dcd_geom::{Polytope, Pose, Shape};
use dcd_gjk::query::{MeasureAt, Smoothness};
use dcd_gjk::{
    Accuracy, Contact, Distance, Distances, PairSolver, Pairwise, PosedShape, Proximities, Reason,
    SimdDistances, ThenMeasure, Verdict, contract,
};
use dcd_simd::Path;
use std::sync::Arc;

#[test]
fn distances_keep_the_contract_one_by_one_and_after_the_lanes() {
    let (scene, pairs) = pile(shapes(), 40);
    for margin in [0.0, 0.5] {
        let solver = Distances::within(margin).unwrap();
        contract::narrow_phase(&Pairwise(solver), &scene, &pairs).unwrap();
        contract::narrow_phase(&ThenMeasure::new(solver).unwrap(), &scene, &pairs).unwrap();
    }
}

#[test]
fn both_ways_of_measuring_agree() {
    let mut polytopes = shapes();
    polytopes.pop();
    let (scene, pairs) = pile(polytopes, 40);
    let solver = Distances::within(0.5).unwrap();
    let (alone, _) = found(&Pairwise(solver), &scene, &pairs);
    let (after, report) = found(&ThenMeasure::new(solver).unwrap(), &scene, &pairs);
    assert!(alone.len() > 50 && alone == after, "{} {}", alone.len(), after.len());
    assert!(report.undecided().is_empty(), "{:?}", report.undecided());
    let apart = alone.iter().filter_map(|contact| contact.answer);
    assert!(apart.clone().count() > 10 && apart.clone().all(|d| d.lower() <= 0.5));
}

#[test]
fn a_pair_beyond_the_margin_is_apart_and_one_that_touches_has_no_distance() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let solver = Distances::within(1.0).unwrap();
    let a = PosedSupport::at(&cube, DVec3::ZERO);
    assert_eq!(solve(&solver, &a, &PosedSupport::at(&cube, DVec3::X * 2.5)), Verdict::Apart);
    assert_eq!(solve(&solver, &a, &PosedSupport::at(&cube, DVec3::X * 1e30)), Verdict::Apart);
    assert_eq!(answer_of(&solver, &a, &PosedSupport::at(&cube, DVec3::X)), None);
    let found = answer_of(&solver, &a, &PosedSupport::at(&cube, DVec3::X * 1.75)).unwrap();
    assert!(found.lower() <= 0.75 && 0.75 <= found.upper() && found.upper() < 0.75 + 1e-15);
    assert_eq!((found.normal, found.point_a.x, found.point_b.x), (DVec3::X, 0.5, 1.25));
}

#[test]
fn a_pair_that_f64_cannot_decide_is_within_a_margin_at_zero_with_its_bound() {
    // Rims that just touch: cylinders have no exact method.
    let cylinder = Shape::cylinder(0.5, 0.25).unwrap();
    let (a, b) =
        (PosedSupport::at(&cylinder, DVec3::ZERO), PosedSupport::at(&cylinder, DVec3::X * 0.5));
    let parts = vec![(cylinder.clone(), Pose::IDENTITY)];
    let compound = Shape::compound(parts).unwrap();
    for a in [a, PosedSupport::at(&compound, DVec3::ZERO)] {
        let solver = Distances::within(0.1).unwrap();
        let found = answer_of(&solver, &a, &b).unwrap();
        assert!(found.distance == 0.0 && found.normal.x > 0.99, "{found:?}");
        assert!((1e-18..1e-13).contains(&found.error_bound), "{found:?}");
        let near = answer_of(&Proximities::within(0.1).unwrap(), &a, &b);
        assert_eq!((near.signed_distance, near.error_bound), (0.0, found.error_bound));
        assert_eq!(near.smoothness, Smoothness::Unknown);
        // Of no margin, and of one below the bound, it is not known whether they are within it.
        for margin in [0.0, 1e-17] {
            let answer = solve(&Distances::within(margin).unwrap(), &a, &b);
            assert_eq!(answer, Verdict::Undecided(Reason::WithinRounding), "{margin}");
        }
    }
}

#[test]
fn the_spheres_reject_nothing_that_is_within_the_margin() {
    // Two spheres along a random line, moved about the margin in steps of rounding.
    let mut draw = Draw(5);
    for k in 0..2000 {
        let scale = 10f64.powi(k % 19 - 9);
        let radii = [draw.unit().abs(), draw.unit().abs()].map(|r| r * scale);
        let margin = draw.unit().abs() * scale;
        let place = draw.vector() * scale * 10f64.powi(k % 7 - 1);
        let far = radii[0] + radii[1] + margin;
        let off = draw.vector().normalize() * far * (1.0 + f64::from(k % 5 - 2) * 1e-16);
        let [a, b] = [(radii[0], place), (radii[1], place + off)].map(|(radius, place)| {
            let sphere = Polytope::sphere(radius).unwrap();
            let shape = if k % 3 == 0 {
                Shape::custom(Arc::new(sphere)).unwrap()
            } else {
                Shape::from(sphere)
            };
            PosedSupport::new(shape, draw.turn(), place)
        });
        let solver = Distances::within(margin).unwrap();
        let measured = solver.measure(a.placed(), b.placed(), &mut ());
        if let (Verdict::Touching(Some(found)), Verdict::Apart) = (measured, solve(&solver, &a, &b))
        {
            assert!(found.upper() > margin, "{found:?} {margin}\n{a:?}\n{b:?}");
        }
    }
}

/// Hulls of many sizes and shapes, some rounded, near each other and far, some by a hair.
fn hulls(draw: &mut Draw, scale: f64) -> Vec<Shape> {
    let hull = |draw: &mut Draw, k: u32| {
        let flat = DVec3::new(
            1.0,
            1.0 / f64::from(1 + k % 7),
            if k.is_multiple_of(5) { 0.0 } else { 0.6 },
        );
        let points = (0..4 + k * 5 % 90).map(|_| draw.vector() * flat * scale).collect();
        let swept = if k.is_multiple_of(3) { 0.1 * scale } else { 0.0 };
        Polytope::hull(points).unwrap().rounded(swept).unwrap().into()
    };
    let mut shapes: Vec<Shape> = (0..30).map(|k| hull(draw, k)).collect();
    shapes.push(Shape::sphere(0.3 * scale).unwrap());
    shapes.push(Shape::cuboid(DVec3::new(0.5, 0.4, 0.3) * scale).unwrap());
    shapes
}

#[test]
fn the_lanes_report_the_same_pairs_and_the_distance_alone_is_within_their_bound_on_every_path() {
    let mut draw = Draw(17);
    let mut bounds: [Vec<f64>; 3] = Default::default();
    for (round, scale) in [1.0, 1e-3, 1e3, 1.0].into_iter().enumerate() {
        let shapes = hulls(&mut draw, scale);
        let kinds = shapes.len() as u32;
        let objects = (0..90).map(|k| {
            let place = draw.vector() * 2.5 * scale + DVec3::splat(round as f64 * 100.0 * scale);
            let turn = if k % 4 == 0 { dcd_geom::glam::DQuat::IDENTITY } else { draw.turn() };
            dcd_geom::Object::new(k % kinds, Pose::new(turn, place).unwrap())
        });
        let scene = dcd_geom::Scene::new(shapes, objects.collect::<Vec<_>>()).unwrap();
        let pairs: Vec<_> =
            (0..90).flat_map(|i| (i + 1..90).map(move |j| dcd_geom::Pair::new(i, j))).collect();
        let margin = 0.8 * scale;
        let solver = Distances::within(margin).unwrap();
        let (certified, reference) = found(&ThenMeasure::new(solver).unwrap(), &scene, &pairs);
        for (accuracy, bounds) in ACCURACIES.into_iter().zip(&mut bounds) {
            let mut first = None;
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let lanes = SimdDistances::on(path, margin, accuracy).unwrap();
                let (lanes, report) = found(&lanes, &scene, &pairs);
                assert!(report.undecided().is_empty());
                assert_eq!(report.pair_count(), reference.pair_count());
                let first = first.get_or_insert_with(|| lanes.clone());
                assert!(*first == lanes, "{path:?} {accuracy:?}");
            }
            let lanes = first.unwrap();
            assert_eq!(lanes.len(), certified.len());
            for (lanes, certified) in lanes.iter().zip(&certified) {
                assert_eq!(lanes.pair, certified.pair);
                assert_eq!(lanes.answer.is_some(), certified.answer.is_some());
                let [i, j] = [lanes.pair.i, lanes.pair.j].map(|k| k as usize);
                let (Some(lanes), Some(certified)) = (lanes.answer, certified.answer) else {
                    continue;
                };
                assert!(
                    lanes.lower() <= certified.upper() && certified.lower() <= lanes.upper(),
                    "{accuracy:?} {lanes:?} {certified:?}"
                );
                let along = lanes.point_b - lanes.point_a - lanes.normal * lanes.distance;
                assert!(along.length() < 1e-11 * 300.0 * scale, "{along}");
                assert!((lanes.normal.length() - 1.0).abs() < 1e-14);
                if accuracy == Accuracy::Certified {
                    let most = (4.0 * certified.error_bound).max(2e-15 * certified.distance);
                    assert!(lanes.error_bound <= most, "{lanes:?} {certified:?}");
                }
                let apart = scene.poses()[i].translation() - scene.poses()[j].translation();
                let size =
                    scene.shape(i).reach() + scene.shape(j).reach() + apart.abs().element_sum();
                bounds.push(lanes.error_bound / size);
            }
        }
    }
    for (bounds, most) in bounds.iter_mut().zip([1e-5, 1e-14, 1e-14]) {
        bounds.sort_unstable_by(f64::total_cmp);
        let (median, worst) = (bounds[bounds.len() / 2], bounds[bounds.len() - 1]);
        println!("{} distances, bounds of {median:e} and {worst:e} of the size", bounds.len());
        assert!(bounds.len() > 1000 && worst < most, "{} {worst}", bounds.len());
    }
}

pub(super) const ACCURACIES: [Accuracy; 3] = [Accuracy::F32, Accuracy::F64, Accuracy::Certified];

/// How many pairs of a scene of so many objects have a distance; each mirrored in the scene of the same objects in reverse.
pub(super) fn measured_in_both_orders(
    all: &[Contact<Option<Distance>>],
    seen: &[Contact<Option<Distance>>],
    objects: u32,
) -> usize {
    assert_eq!(seen.len(), all.len());
    let last = objects - 1;
    for contact in all {
        let pair = dcd_geom::Pair::new(last - contact.pair.j, last - contact.pair.i);
        let other = seen.iter().find(|other| other.pair == pair).unwrap();
        let mirror = |found: Distance| {
            let (point_a, point_b) = (found.point_b, found.point_a);
            Distance { point_a, point_b, normal: -found.normal, ..found }
        };
        assert_eq!(contact.answer, other.answer.map(mirror), "{pair:?}");
    }
    all.iter().filter(|contact| contact.answer.is_some()).count()
}

#[test]
fn both_orders_choose_alike_among_vertices_at_right_angles_to_a_direction() {
    let mut draw = Draw(41);
    let corner = |k: u32| DVec2::from_angle(f64::from(k)).extend(1.0) * 0.4;
    let shapes = vec![
        Shape::capsule(0.5, 0.1).unwrap(),
        Shape::cuboid(DVec3::new(0.3, 0.0, 0.3)).unwrap(),
        Shape::hull(
            (0..7).flat_map(|k| [corner(k), corner(k) * DVec3::new(1.0, 1.0, -1.0)]).collect(),
        )
        .unwrap(),
    ];
    let object = |k: u32| {
        let turn =
            if k.is_multiple_of(2) { DQuat::IDENTITY } else { DQuat::from_rotation_z(draw.unit()) };
        let place = DVec3::new(draw.unit() * 2.0, draw.unit() * 2.0, f64::from(k / 4 % 3) * 0.25);
        dcd_geom::Object::new(k % 3, Pose::new(turn, place).unwrap())
    };
    let [scene, mirrored] = in_both_orders(shapes, (0..60).map(object).collect());
    let pairs = all_pairs(60);
    for accuracy in ACCURACIES {
        let lanes = SimdDistances::within(1.0, accuracy).unwrap();
        let (all, seen) = (found(&lanes, &scene, &pairs).0, found(&lanes, &mirrored, &pairs).0);
        let measured = measured_in_both_orders(&all, &seen, 60);
        assert!(measured > 100, "{measured}");
    }
}

#[test]
fn the_lanes_agree_on_both_orders_and_whatever_the_other_pairs() {
    let mut draw = Draw(23);
    let shapes = hulls(&mut draw, 1.0);
    let kinds = shapes.len() as u32;
    let object = |k: u32, draw: &mut Draw| {
        let pose = Pose::new(draw.turn(), draw.vector() * 2.5).unwrap();
        dcd_geom::Object::new(k % kinds, pose)
    };
    let [scene, mirrored] = in_both_orders(shapes, (0..60).map(|k| object(k, &mut draw)).collect());
    let pairs = all_pairs(60);
    for accuracy in ACCURACIES {
        let lanes = SimdDistances::within(0.7, accuracy).unwrap();
        let (all, _) = found(&lanes, &scene, &pairs);
        let (seen, _) = found(&lanes, &mirrored, &pairs);
        let measured = measured_in_both_orders(&all, &seen, 60);
        assert!(measured > 100, "{measured}");
        for chunk in pairs.chunks(7) {
            let (some, _) = found(&lanes, &scene, chunk);
            let same = all.iter().filter(|contact| chunk.contains(&contact.pair));
            assert!(some.iter().eq(same));
        }
    }
}

/// Cuboids turned any way, some alike and some by quarters; with or without a shape beside them that has no object.
fn cuboids(others: &[Shape]) -> (dcd_geom::Scene, dcd_geom::Scene, Vec<dcd_geom::Pair>) {
    let mut draw = Draw(53);
    let half =
        [(0.5, 0.4, 0.3), (0.2, 0.2, 0.2), (0.6, 0.05, 0.3), (0.01, 0.02, 0.7), (0.3, 0.3, 0.0)];
    let own = half.map(|(x, y, z)| Shape::cuboid(DVec3::new(x, y, z)).unwrap());
    let shapes = [&own, others].concat();
    let turn = draw.turn();
    let object = |k: u32, draw: &mut Draw| {
        let turn = match k % 4 {
            0 => turn,
            1 => turn * dcd_geom::glam::DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2),
            _ => draw.turn(),
        };
        dcd_geom::Object::new(k % 5, Pose::new(turn, draw.vector() * 1.6).unwrap())
    };
    let objects = (0..90).map(|k| object(k, &mut draw)).collect();
    let [scene, mirrored] = in_both_orders(shapes, objects);
    (scene, mirrored, all_pairs(90))
}

#[test]
fn cuboids_have_the_same_distance_on_every_path_in_both_orders_and_beside_any_shapes() {
    let (scene, mirrored, pairs) = cuboids(&[]);
    let (beside, ..) = cuboids(&hulls(&mut Draw(3), 1.0));
    for accuracy in ACCURACIES {
        let lanes = SimdDistances::within(0.6, accuracy).unwrap();
        let (all, _) = found(&lanes, &scene, &pairs);
        assert!(found(&lanes, &beside, &pairs).0 == all, "{accuracy:?}");
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let lanes = SimdDistances::on(path, 0.6, accuracy).unwrap();
            assert!(found(&lanes, &scene, &pairs).0 == all, "{path:?} {accuracy:?}");
        }
        let (seen, _) = found(&lanes, &mirrored, &pairs);
        let measured = measured_in_both_orders(&all, &seen, 90);
        assert!(measured > 500, "{measured}");
    }
}

/// Pairs 2k, 2k + 1 whose faces, edges or corners meet with a gap: none, below rounding, small.
fn nearly_touching(
    draw: &mut Draw,
    scale: f64,
    far: f64,
) -> (dcd_geom::Scene, Vec<dcd_geom::Pair>) {
    let mut shapes = hulls(draw, scale);
    let corner = |k: u32| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
    let boxed = |half: DVec3| {
        let corners = (0..8).map(|k| (corner(k) * 2.0 - 1.0) * half * scale).collect();
        Shape::hull(corners).unwrap()
    };
    shapes.push(boxed(DVec3::new(0.5, 0.25, 0.125)));
    shapes.push(boxed(DVec3::new(1.0, 1.0, 0.001)));
    shapes.push(boxed(DVec3::new(0.5, 0.5, 0.0)));
    let lattice = |k: u32| DVec3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9));
    shapes.push(Shape::hull((0..27).map(|k| lattice(k) * 0.25 * scale).collect()).unwrap());
    let kinds = shapes.len() as u32;
    let mut objects = Vec::new();
    for k in 0..600 {
        let kind = |draw: &mut Draw| match k % 3 {
            0 => kinds - 1 - (draw.unit().abs() * 4.0) as u32 % 4,
            _ => (draw.unit().abs() * f64::from(kinds)) as u32 % kinds,
        };
        let (one, other) = (kind(draw), kind(draw));
        let turn = |draw: &mut Draw| match k % 3 {
            0 => dcd_geom::glam::DQuat::IDENTITY,
            _ => draw.turn(),
        };
        let turns = [turn(draw), turn(draw)];
        let along = if k % 2 == 0 { DVec3::X } else { draw.vector().normalize() };
        let reach = |kind: u32, turn: dcd_geom::glam::DQuat, along: DVec3| {
            let polytope = shapes[kind as usize].as_polytope().unwrap();
            let farthest = polytope.vertices().iter().map(|&vertex| (turn * vertex).dot(along));
            farthest.fold(f64::NEG_INFINITY, f64::max) + polytope.swept_radius()
        };
        let gap = [0.0, 1e-16, 1e-13, 1e-8, 1e-3, 0.05][k % 6] * scale;
        let apart = reach(one, turns[0], along) + reach(other, turns[1], -along) + gap;
        let place = draw.vector() * far;
        objects.push(dcd_geom::Object::new(one, Pose::new(turns[0], place).unwrap()));
        let there = place + along * apart;
        objects.push(dcd_geom::Object::new(other, Pose::new(turns[1], there).unwrap()));
    }
    let pairs = (0..600).map(|k| dcd_geom::Pair::new(2 * k, 2 * k + 1)).collect();
    (dcd_geom::Scene::new(shapes, objects).unwrap(), pairs)
}

#[test]
fn gaps_below_rounding_have_the_distance_that_they_have_alone_on_every_path() {
    let mut draw = Draw(41);
    let mut measured = 0;
    for (scale, far) in [(1.0, 0.0), (1.0, 8.0), (1e-3, 1.0), (1e4, 1e3), (1e-9, 1e-9)] {
        let (scene, pairs) = nearly_touching(&mut draw, scale, far);
        let margin = 0.2 * scale;
        let alone = Pairwise(Distances::within(margin).unwrap());
        let (alone, _) = found(&alone, &scene, &pairs);
        for accuracy in ACCURACIES {
            let mut first = None;
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let lanes = SimdDistances::on(path, margin, accuracy).unwrap();
                let (lanes, report) = found(&lanes, &scene, &pairs);
                assert!(report.undecided().is_empty());
                let first = first.get_or_insert_with(|| lanes.clone());
                assert!(*first == lanes, "{path:?} {accuracy:?}");
            }
            let lanes = first.unwrap();
            assert_eq!(lanes.len(), alone.len());
            for (lanes, alone) in lanes.iter().zip(&alone) {
                assert_eq!(lanes.pair, alone.pair);
                let (Some(lanes), Some(alone)) = (lanes.answer, alone.answer) else {
                    assert_eq!(lanes.answer, alone.answer);
                    continue;
                };
                assert!(
                    lanes.lower() <= alone.upper() && alone.lower() <= lanes.upper(),
                    "{accuracy:?} {lanes:?} {alone:?}"
                );
                if accuracy == Accuracy::Certified {
                    let most = (4.0 * alone.error_bound).max(2e-15 * alone.distance);
                    assert!(lanes.error_bound <= most, "{lanes:?} {alone:?}");
                    measured += 1;
                }
            }
        }
    }
    assert!(measured > 1000, "{measured}");
}

#[test]
fn shapes_that_the_lanes_do_not_know_have_the_distances_that_they_have_alone() {
    let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.2)];
    let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 4, 2]];
    let mut all = shapes();
    all.pop();
    let parts =
        [0.4, -0.4].map(|x| (all[0].clone(), Pose::from_translation(DVec3::X * x).unwrap()));
    all.push(Shape::compound(parts.to_vec()).unwrap());
    all.push(Shape::mesh(corners, triangles).unwrap());
    all.push(Shape::cylinder(0.5, 0.3).unwrap());
    all.push(Shape::cone(0.5, 0.3).unwrap().rounded(0.05).unwrap());
    all.push(Shape::half_space(DVec3::new(0.1, 0.2, 1.0), -3.0).unwrap());
    let (scene, pairs) = pile(all, 90);
    let cases = ACCURACIES.into_iter().flat_map(|a| [0.0, 0.02, 0.6].map(|margin| (a, margin)));
    for (accuracy, margin) in cases {
        let solver = Distances::within(margin).unwrap();
        let (certified, reference) = found(&ThenMeasure::new(solver).unwrap(), &scene, &pairs);
        let lanes = SimdDistances::within(margin, accuracy).unwrap();
        let (quick, report) = found(&lanes, &scene, &pairs);
        let open = |report: &dcd_gjk::Report| -> Vec<_> {
            report.undecided().iter().map(|undecided| undecided.pair).collect()
        };
        // Two half-spaces touch, but how far apart they are is not known one by one; and nothing decides curved
        // shapes that only just touch, or just do not.
        let (left, of_certified) = (open(&report), open(&reference));
        assert!(left.iter().all(|pair| of_certified.contains(pair)), "{left:?}");
        let quick: Vec<_> = quick.iter().filter(|c| !of_certified.contains(&c.pair)).collect();
        assert!(left.len() < 5 && quick.len() > 200, "{} {left:?}", quick.len());
        assert_eq!(quick.len(), certified.len(), "{margin}");
        for (quick, certified) in quick.iter().zip(certified) {
            assert_eq!(quick.pair, certified.pair);
            let bounds = |answer: Option<dcd_gjk::Distance>| {
                answer.map_or([0.0; 2], |d| [d.lower(), d.upper()])
            };
            let ([low, high], [least, most]) = (bounds(quick.answer), bounds(certified.answer));
            assert!(low <= most && least <= high, "{quick:?} {certified:?}");
        }
    }
}

#[test]
fn spheres_capsules_and_cuboids_have_the_distance_that_one_evaluation_in_f64_gives_them_on_every_path()
 {
    let mut draw = Draw(31);
    let shapes: Vec<Shape> = (0..24)
        .map(|k| {
            let half = draw.vector().abs() * 0.4 + 0.05;
            match k % 3 {
                0 => Shape::sphere(half.x).unwrap(),
                1 => Shape::capsule(half.x, half.y).unwrap(),
                _ => Shape::cuboid(half).unwrap(),
            }
        })
        .collect();
    let poses = (0..240).map(|_| Pose::new(draw.turn(), draw.vector() * 2.0).unwrap());
    let objects = poses.zip((0..24).cycle()).map(|(pose, k)| dcd_geom::Object::new(k, pose));
    let scene = dcd_geom::Scene::new(shapes, objects.collect::<Vec<_>>()).unwrap();
    let pairs: Vec<_> =
        (0..240).flat_map(|i| (i + 1..240).map(move |j| dcd_geom::Pair::new(i, j))).collect();
    let margin = 0.5;
    let solver = Distances::within(margin).unwrap();
    let (due, _) = found(&Pairwise(solver), &scene, &pairs);
    let placed = |k: u32| PosedShape::of(&scene, k);
    let mut counts = [0; 2];
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        let narrow = SimdDistances::on(path, margin, Accuracy::F32).unwrap();
        let (measured, report) = found(&narrow, &scene, &pairs);
        assert!(report.undecided().is_empty(), "{:?}", report.undecided());
        let of =
            |contacts: &[dcd_gjk::Contact<_>]| contacts.iter().map(|c| c.pair).collect::<Vec<_>>();
        assert_eq!(of(&due), of(&measured), "{path:?}");
        for contact in &measured {
            let kinds = [contact.pair.i, contact.pair.j].map(|k| k % 3);
            let (a, b) = (placed(contact.pair.i), placed(contact.pair.j));
            let Some(found) = contact.answer else {
                counts[0] += 1;
                continue;
            };
            if kinds != [2, 2] {
                let alone = solver.measure_at(Accuracy::F32, a, b, &mut ());
                assert_eq!(alone, Verdict::Touching(Some(found)), "{kinds:?}");
                assert!(found.error_bound < 1e-12, "{kinds:?} {found:?}");
                counts[1] += 1;
            }
        }
    }
    assert!(counts[0] > 500 && counts[1] > 500, "{counts:?}");
}
