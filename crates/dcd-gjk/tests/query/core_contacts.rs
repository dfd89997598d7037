//! How deep spheres, capsules and cuboids overlap, and where, as the lanes find it at the accuracy of f32: beside the certified
//! answers and their surfaces.

use super::patches::off_surface;
use super::round_depths::objects;
use super::scenes::{Draw, in_both_orders};
use super::within::{found, on_every_path};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pair, Polytope, Pose, Scene, Shape};
use dcd_gjk::distance::gap_along;
use dcd_gjk::query::{Feature, MeasureAt};
use dcd_gjk::{
    Accuracy, Contact, Depths, ManifoldSet, Manifolds, PairSolver, PosedShape, SimdDepths,
    ThenMeasure, Verdict, WithAccuracy, certified,
};

/// 24 spheres and capsules, some long, hardly longer than spheres or off their origins, and six cuboids, some of them flat.
fn shapes(draw: &mut Draw, scale: f64) -> Vec<Shape> {
    let mut all = Vec::new();
    for k in 0..24 {
        let radius = (0.05 + 0.4 * draw.unit().abs()) * scale;
        let length = radius * [1.0, 1e-7, 20.0][k / 4 % 3];
        all.push(match k % 4 {
            0 => Shape::sphere(radius).unwrap(),
            1 => {
                let [from, to] = [0; 2].map(|_| draw.vector() * 0.4 * scale);
                Polytope::segment(from, to).unwrap().rounded(radius).unwrap().into()
            }
            _ => Shape::capsule(length, radius).unwrap(),
        });
    }
    for flat in [1.0, 1.0, 0.3, 1e-2, 1e-4, 0.0] {
        let half = draw.vector().abs() * 0.4 + 0.1;
        all.push(Shape::cuboid(half * DVec3::new(1.0, flat, 1.0) * scale).unwrap());
    }
    all
}

/// What every path finds, which is the same.
fn manifolds(scene: &Scene, pairs: &[Pair]) -> Vec<Contact<ManifoldSet>> {
    let narrow = |path| SimdDepths::on(path, Manifolds::default(), Accuracy::F32);
    on_every_path(narrow, scene, pairs)
}

#[test]
fn depths_are_within_their_bounds_and_points_on_both_surfaces() {
    let (mut bounds, mut single) = (Vec::new(), 0);
    let mut scratch = <Depths as PairSolver>::Scratch::default();
    for (seed, scale, far, count) in [
        (11, 1.0, 1.0, 4000),
        (12, 1e-6, 1e-6, 1000),
        (13, 1e7, 1e7, 1000),
        (14, 1.0, 1e7, 1000),
        (15, 1e-12, 1e-12, 300),
        (16, 1e12, 1e12, 300),
    ] {
        let mut draw = Draw::seeded(seed);
        let shapes = shapes(&mut draw, scale);
        let objects = objects(&mut draw, &shapes, [scale, far], count);
        let scene = Scene::new(shapes, objects).unwrap();
        let pairs: Vec<_> = (0..count).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
        let (depths, _) = found(&SimdDepths::new(Depths, Accuracy::F32), &scene, &pairs);
        let sets = manifolds(&scene, &pairs);
        assert_eq!(sets.len(), depths.len());
        for (Contact { pair, answer }, set) in depths.into_iter().zip(sets) {
            let sides = [pair.i, pair.j].map(|k| PosedShape::of(&scene, k));
            let [a, b] = sides;
            let apart = a.pose.translation() - b.pose.translation();
            let size = a.shape.reach() + b.shape.reach() + apart.abs().element_sum();
            let what = format!("{seed} {pair:?} {answer:?} {:?} {:?}", a.shape, b.shape);
            let truth = match Depths.measure_at(Accuracy::Certified, a, b, &mut scratch) {
                Verdict::Touching(truth) => truth,
                other => panic!("{what}: {other:?}"),
            };
            let off = (answer.depth - truth.depth).abs();
            assert!(off <= answer.error_bound + truth.error_bound, "{what} {truth:?}");
            bounds.push(answer.error_bound / size);
            let slack = 1e-13 * size + 1e-15 * far;
            // By that way the two come apart, and planes across it fit between.
            let needs = -gap_along(a, b, answer.normal).unwrap();
            assert!(needs <= answer.depth + answer.error_bound + slack, "{what} {needs}");
            let by = answer.normal * (answer.depth + answer.error_bound + slack);
            let away = Pose::from_matrix(*b.pose.rotation(), b.pose.translation() + by).unwrap();
            let moved = certified::overlap_of(a, PosedShape { pose: &away, ..b }).0;
            assert_ne!(moved, Verdict::Touching(()), "{what}");
            let missed = answer.point_a - answer.point_b - answer.normal * answer.depth;
            assert!(
                missed.length() <= answer.error_bound + 1e-8 * size + slack,
                "{what}: {missed}"
            );
            let [manifold] = &*set.answer else { panic!("{what}: {set:?}") };
            let first = manifold.points()[0];
            let off = (first.depth - truth.depth).abs();
            assert!(off <= manifold.error_bound + truth.error_bound, "{what}: {manifold:?}");
            for point in manifold.points() {
                for (point, side) in [(point.point_a, a), (point.point_b, b)] {
                    let beside = off_surface(point, side.shape, side.pose);
                    assert!(beside <= manifold.error_bound + slack, "{what}: {beside}");
                }
            }
            single += usize::from(manifold.points().len() == 1);
        }
    }
    bounds.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| bounds[((bounds.len() - 1) as f64 * share) as usize];
    println!("{} depths, {:e}, {:e}, {:e}", bounds.len(), at(0.5), at(0.99), at(1.0));
    assert!(bounds.len() > 4000 && single > 3000, "{} {single}", bounds.len());
    assert!(at(0.99) < 1e-5, "{}", at(0.99));
}

#[test]
fn both_orders_are_mirrored_and_other_pairs_change_nothing() {
    let mut draw = Draw::seeded(21);
    let shapes = shapes(&mut draw, 1.0);
    let objects = objects(&mut draw, &shapes, [1.0, 2.0], 800);
    let [scene, mirrored] = in_both_orders(shapes, objects);
    let pairs: Vec<_> = (0..800).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let back: Vec<_> =
        pairs.iter().rev().map(|pair| Pair::new(1599 - pair.j, 1599 - pair.i)).collect();
    let (all, seen) = (manifolds(&scene, &pairs), manifolds(&mirrored, &back));
    assert!(all.len() > 400 && all.len() == seen.len());
    for (one, other) in all.iter().zip(seen.iter().rev()) {
        let [i, j] = [one.pair.i, one.pair.j].map(|k| k as usize);
        if scene.shape_of()[i] == scene.shape_of()[j] && scene.poses()[i] == scene.poses()[j] {
            // Both are equal, so both orders are one.
            continue;
        }
        let (ours, theirs) = (&one.answer[0], &other.answer[0]);
        assert_eq!((ours.normal, ours.error_bound), (-theirs.normal, theirs.error_bound));
        assert_eq!(ours.points().len(), theirs.points().len());
        for (ours, theirs) in ours.points().iter().zip(theirs.points()) {
            assert_eq!(
                (ours.depth, ours.point_a, ours.point_b),
                (theirs.depth, theirs.point_b, theirs.point_a)
            );
            assert_eq!(ours.features, [theirs.features[1], theirs.features[0]]);
        }
    }
    let narrow = SimdDepths::new(Manifolds::default(), Accuracy::F32);
    for chunk in pairs.chunks(7) {
        let (some, _) = found(&narrow, &scene, chunk);
        assert!(some.iter().eq(all.iter().filter(|contact| chunk.contains(&contact.pair))));
    }
}

#[test]
fn features_are_those_that_the_solver_names() {
    let mut draw = Draw::seeded(31);
    let shapes = shapes(&mut draw, 1.0);
    let objects = objects(&mut draw, &shapes, [1.0, 1.0], 4000);
    let scene = Scene::new(shapes, objects).unwrap();
    let pairs: Vec<_> = (0..4000).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let solver = WithAccuracy::new(Manifolds::default(), Accuracy::F32);
    let (alone, _) = found(&ThenMeasure::new(solver).unwrap(), &scene, &pairs);
    let lanes = manifolds(&scene, &pairs);
    assert!(alone.len() > 2000 && alone.len() == lanes.len());
    let (mut differ, mut kinds) = (0, [0; 3]);
    for (one, other) in alone.iter().zip(&lanes) {
        let [one, other] = [one, other].map(|contact| &contact.answer[0]);
        let features = |found: &dcd_gjk::Manifold| -> Vec<_> {
            found.points().iter().map(|point| point.features).collect()
        };
        // What leans by just as much as decides what is shown, as f32 has it, may be named otherwise.
        differ += usize::from(features(one) != features(other));
        for feature in other.points()[0].features {
            match feature {
                Feature::Vertex(_) => kinds[0] += 1,
                Feature::Edge(..) => kinds[1] += 1,
                Feature::Face(_) => kinds[2] += 1,
                Feature::Surface => {}
            }
        }
    }
    assert!(differ <= alone.len() / 200, "{differ} of {}", alone.len());
    assert!(kinds.iter().all(|&count| count > 200), "{kinds:?}");
}

#[test]
fn planes_across_the_normal_of_long_capsules_with_near_cores_fit_after_the_bound() {
    let mut draw = Draw::seeded(41);
    let shapes = vec![Shape::capsule(1.0, 0.1).unwrap(), Shape::capsule(0.4, 0.05).unwrap()];
    let mut objects = Vec::new();
    for k in 0..4000 {
        // They cross at up to 0.3 rad, some millimetres between their cores.
        let turn = draw.turn();
        let angle = 0.3 * draw.unit();
        let bent = turn * DQuat::from_rotation_y(angle);
        let gap = 10f64.powf(-2.3 + 0.5 * draw.unit());
        let (along, other) = (DVec3::Z * draw.unit(), DVec3::Z * 0.4 * draw.unit());
        let at = turn * (along + DVec3::Y * gap) - bent * other;
        objects.push(Object::new(0, Pose::new(turn, DVec3::ZERO).unwrap()));
        objects.push(Object::new(k % 2, Pose::new(bent, at).unwrap()));
    }
    let scene = Scene::new(shapes, objects).unwrap();
    let pairs: Vec<_> = (0..4000).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
    let (depths, _) = found(&SimdDepths::new(Depths, Accuracy::F32), &scene, &pairs);
    assert_eq!(depths.len(), 4000);
    let mut in_lanes = 0;
    for Contact { pair, answer } in depths {
        let [a, b] = [pair.i, pair.j].map(|k| PosedShape::of(&scene, k));
        let needs = -gap_along(a, b, answer.normal).unwrap();
        assert!(needs <= answer.depth + answer.error_bound + 1e-13, "{pair:?} {answer:?} {needs}");
        in_lanes += usize::from(answer.error_bound > 1e-9);
    }
    assert!(in_lanes > 1000, "{in_lanes}");
}
