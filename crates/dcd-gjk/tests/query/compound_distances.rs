//! How far compounds are apart, against the distances of all pairs of their parts.

use super::scenes::{Draw, all_pairs, in_both_orders};
use super::within::found;
use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pair, Pose, Scene, Shape};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{Accuracy, Contact, Distance, Distances, PosedShape, SimdDistances, Verdict};
use dcd_simd::Path;

const OBJECTS: u32 = 36;
const ACCURACIES: [Accuracy; 3] = [Accuracy::F32, Accuracy::F64, Accuracy::Certified];

/// A convex shape of any kind, some tenths of a metre across.
fn convex(draw: &mut Draw) -> Shape {
    let mut length = || 0.15 + 0.1 * draw.unit();
    let half = DVec3::new(length(), length(), length());
    match ((draw.unit() + 1.0) * 3.5) as u32 {
        0 => Shape::sphere(half.x).unwrap(),
        1 => Shape::capsule(half.x, half.y).unwrap(),
        2 => Shape::cylinder(half.x, half.y).unwrap(),
        3 => Shape::cuboid(half).unwrap().rounded(0.05).unwrap(),
        4 => Shape::hull((0..12).map(|_| draw.vector() * half).collect()).unwrap(),
        _ => Shape::cuboid(half).unwrap(),
    }
}

/// A place and a turn: on a lattice, where much is equally near, or anywhere.
fn pose(draw: &mut Draw, is_lattice: bool, far: f64) -> Pose {
    let place = draw.vector() * far;
    match is_lattice {
        true => Pose::from_translation((place * 4.0).round() / 4.0).unwrap(),
        false => Pose::new(draw.turn(), place).unwrap(),
    }
}

/// Compounds of one part and more, some of equal cuboids, and convex shapes; and the same in the reverse order.
fn scenes(draw: &mut Draw, is_lattice: bool, most: f64) -> [Scene; 2] {
    let shapes: Vec<Shape> = (0..OBJECTS)
        .map(|k| {
            if k % 4 == 3 {
                return convex(draw);
            }
            let count = 1 + ((draw.unit() + 1.0) * 0.5 * most) as u32;
            let part = |_| {
                let shape = match is_lattice {
                    true => Shape::cuboid(DVec3::new(0.125, 0.25, 0.125)).unwrap(),
                    false => convex(draw),
                };
                (shape, pose(draw, is_lattice, 0.6))
            };
            Shape::compound((0..count).map(part).collect()).unwrap()
        })
        .collect();
    let objects = (0..OBJECTS).map(|k| Object::new(k, pose(draw, is_lattice, 2.0))).collect();
    in_both_orders(shapes, objects)
}

/// A shape's parts, placed.
fn parts(shape: &Shape) -> Vec<&Shape> {
    match shape {
        Shape::Compound(compound) => compound.parts().iter().map(|part| part.placed()).collect(),
        other => vec![other],
    }
}

/// The least distance of all pairs of parts, and what bounds it; `None` where a pair touches, or f64 leaves that open.
fn nearest(scene: &Scene, pair: Pair) -> Option<[f64; 2]> {
    let [i, j] = [pair.i, pair.j].map(|k| k as usize);
    let solver = Distances::within(1e3).unwrap();
    let mut least = [f64::INFINITY; 2];
    for a in parts(scene.shape(i)) {
        for b in parts(scene.shape(j)) {
            let a = PosedShape { shape: a, pose: &scene.poses()[i] };
            let b = PosedShape { shape: b, pose: &scene.poses()[j] };
            let Verdict::Touching(Some(found)) =
                solver.measure_at(Accuracy::Certified, a, b, &mut ())
            else {
                return None;
            };
            least = [least[0].min(found.lower()), least[1].min(found.upper())];
        }
    }
    Some(least)
}

fn check_mirrored(ones: &[Contact<Option<Distance>>], others: &[Contact<Option<Distance>>]) {
    assert_eq!(ones.len(), others.len());
    for one in ones {
        let pair = Pair::new(OBJECTS - 1 - one.pair.j, OBJECTS - 1 - one.pair.i);
        let other = others.iter().find(|other| other.pair == pair).unwrap();
        let (Some(a), Some(b)) = (one.answer, other.answer) else {
            assert_eq!(one.answer, other.answer);
            continue;
        };
        assert_eq!((a.distance, a.error_bound), (b.distance, b.error_bound), "{pair:?}");
        assert_eq!((a.point_a, a.point_b, a.normal), (b.point_b, b.point_a, -b.normal));
    }
}

#[test]
fn compounds_are_as_far_apart_as_their_nearest_parts() {
    let mut draw = Draw::seeded(31);
    let pairs = all_pairs(OBJECTS);
    let (mut measured, mut worst) = (0, 0.0f64);
    for round in 0..12 {
        let (is_lattice, most) = (round % 3 == 0, [4.0, 24.0][round % 2]);
        let scenes = scenes(&mut draw, is_lattice, most);
        for margin in [0.3, 3.0] {
            for accuracy in ACCURACIES {
                let said = format!("round {round}, {margin} m, {accuracy:?}");
                let [lanes, reversed] = scenes.each_ref().map(|scene| {
                    let narrow = SimdDistances::within(margin, accuracy).unwrap();
                    let (found, report) = found(&narrow, scene, &pairs);
                    assert!(report.undecided().is_empty(), "{said} {:?}", report.undecided());
                    found
                });
                for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                    let narrow = SimdDistances::on(path, margin, accuracy).unwrap();
                    assert_eq!(found(&narrow, &scenes[0], &pairs).0, lanes, "{said} {path:?}");
                }
                check_mirrored(&lanes, &reversed);
                for &pair in &pairs {
                    let Some([lower, upper]) = nearest(&scenes[0], pair) else { continue };
                    let found = lanes.iter().find(|contact| contact.pair == pair);
                    let said = format!("{said}, {pair:?}: {lower} to {upper}, {found:?}");
                    match found {
                        Some(contact) => {
                            let found = contact.answer.expect(&said);
                            assert!(lower <= margin, "{said}");
                            assert!(found.lower() <= upper && lower <= found.upper(), "{said}");
                            let between = found.point_a.distance(found.point_b);
                            assert!((between - found.distance).abs() < 1e-5, "{said}");
                            worst = worst.max(found.error_bound);
                            measured += 1;
                        }
                        None => assert!(upper > margin, "{said}"),
                    }
                }
            }
        }
    }
    assert!(measured > 5_000 && worst < 1e-4, "{measured} {worst}");
}
