//! How far cylinders and cones are from what has corners, and from each other, as the lanes begin it: beside planes between the
//! two and points on both.

use super::distances::{ACCURACIES, measured_in_both_orders};
use super::patches::off_surface;
use super::round_depths::{Couple, shapes};
use super::scenes::{Draw, in_both_orders};
use super::within::found;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Object, Pair, Pose, Scene, Shape};
use dcd_gjk::distance::gap_along;
use dcd_gjk::{Accuracy, Contact, Distance, PosedShape, SimdDistances};
use dcd_simd::Path;

/// Pairs 2k, 2k + 1, apart along some way: by much, little and hardly anything.
fn objects(draw: &mut Draw, shapes: &[Shape], [scale, far]: [f64; 2], count: u32) -> Vec<Object> {
    let pair = |k: u32| {
        let couple = Couple::draw(draw, shapes, far, k);
        let gap = [0.5 * draw.unit().abs(), 0.05, 1e-3, 1e-6][k as usize % 4] * scale;
        couple.objects(couple.parting(shapes) + gap)
    };
    (0..count).flat_map(pair).collect()
}

fn distances(accuracy: Accuracy, scene: &Scene, pairs: &[Pair]) -> Vec<Contact<Option<Distance>>> {
    let reach = scene.shapes().iter().map(Shape::reach).fold(0.0, f64::max);
    let on = |path| found(&SimdDistances::on(path, 4.0 * reach, accuracy).unwrap(), scene, pairs).0;
    let first = on(Path::Portable);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        assert_eq!(on(path), first, "{path:?}");
    }
    first
}

#[test]
fn a_plane_between_and_points_on_both_are_within_the_bound() {
    for accuracy in ACCURACIES {
        let mut bounds = Vec::new();
        for (seed, scale, far, count) in [
            (1, 1.0, 1.0, 800),
            (2, 1e-4, 1e-4, 300),
            (3, 1e5, 1e5, 300),
            (4, 1.0, 1e5, 300),
            (5, 1e-20, 1e-20, 200),
        ] {
            let mut draw = Draw::seeded(seed);
            let shapes = shapes(&mut draw, scale);
            let objects = objects(&mut draw, &shapes, [scale, far], count);
            let scene = Scene::new(shapes, objects).unwrap();
            let pairs: Vec<_> = (0..count).map(|k| Pair::new(2 * k, 2 * k + 1)).collect();
            let all = distances(accuracy, &scene, &pairs);
            assert_eq!(all.len(), pairs.len());
            for Contact { pair, answer } in all {
                // Closer than f64 knows.
                let Some(answer) = answer.filter(|answer| answer.lower() > 0.0) else { continue };
                let sides = [pair.i, pair.j].map(|k| PosedShape::of(&scene, k));
                let [a, b] = sides;
                let apart = a.pose.translation() - b.pose.translation();
                let size = a.shape.reach() + b.shape.reach() + apart.abs().element_sum();
                let what = format!("{accuracy:?} {seed} {pair:?} {answer:?} {sides:?}");
                let least = gap_along(a, b, answer.normal).unwrap();
                assert!(least <= answer.upper(), "{what}: {least}");
                let rounding = 1e-14 * (size + a.pose.translation().length());
                let between = answer.point_a.distance(answer.point_b);
                assert!(answer.lower() <= between + rounding, "{what}: {between}");
                // The plane that the bound is from may be turned a little from the one that the normal shows.
                let turned = if accuracy == Accuracy::F32 { 1e-5 } else { 1e-9 } * size;
                assert!(answer.lower() - least <= turned, "{what}: {least}");
                let slack = answer.error_bound + rounding + 3e-8 * size;
                for (point, side) in [(answer.point_a, a), (answer.point_b, b)] {
                    let beside = off_surface(point, side.shape, side.pose);
                    assert!(beside <= slack, "{what}: {beside}");
                }
                assert!(between <= answer.upper() + slack, "{what}: {between}");
                bounds.push(answer.error_bound / size);
            }
        }
        bounds.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| bounds[((bounds.len() - 1) as f64 * share) as usize];
        println!("{} {:e} {:e} {:e}", bounds.len(), at(0.5), at(0.99), at(1.0));
        let limit = if accuracy == Accuracy::F32 { 1e-5 } else { 1e-11 };
        assert!(bounds.len() > 1700 && at(0.99) < limit, "{}: {}", bounds.len(), at(0.99));
    }
}

#[test]
fn both_orders_of_round_pairs_are_mirrored_and_other_pairs_change_nothing() {
    let mut draw = Draw::seeded(6);
    let shapes = shapes(&mut draw, 1.0);
    let objects = objects(&mut draw, &shapes, [1.0, 2.0], 40);
    let count = objects.len() as u32;
    let [scene, mirrored] = in_both_orders(shapes, objects);
    let pairs: Vec<_> =
        (0..count).flat_map(|i| (i + 1..count).map(move |j| Pair::new(i, j))).collect();
    for accuracy in ACCURACIES {
        let all = distances(accuracy, &scene, &pairs);
        let seen = distances(accuracy, &mirrored, &pairs);
        let measured = measured_in_both_orders(&all, &seen, count);
        assert!(measured > 1000, "{measured}");
        for chunk in pairs.chunks(7) {
            let some = distances(accuracy, &scene, chunk);
            let same = all.iter().filter(|contact| chunk.contains(&contact.pair));
            assert!(some.iter().eq(same));
        }
    }
}

#[test]
fn a_search_that_the_lanes_lead_astray_begins_again() {
    // A disc beside a triangle, all at whole numbers: the nearest points are inside of the one and on an edge of the other.
    let corners = [[-2.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [2.0, 1.0, 1.0]].map(DVec3::from_array);
    let shapes = vec![Shape::cylinder(0.0, 2.0).unwrap(), Shape::triangle(corners).unwrap()];
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let here = Pose::from_matrix(DMat3::from_cols(-x, z, y), DVec3::ZERO).unwrap();
    let there = Pose::from_matrix(DMat3::from_cols(z, y, -x), DVec3::new(0.0, 2.0, 4.0)).unwrap();
    let scene = Scene::one_each(shapes, vec![here, there]).unwrap();
    for accuracy in [Accuracy::F64, Accuracy::Certified] {
        let all = distances(accuracy, &scene, &[Pair::new(0, 1)]);
        let found = all[0].answer.unwrap();
        assert!((found.distance - 1.0).abs() <= found.error_bound, "{found:?}");
        assert!(found.error_bound < 1e-12, "{found:?}");
    }
}
