//! How far compounds and meshes are apart and how deep compounds overlap, against all pairs of their parts.

use super::PosedSupport;
use super::patches::judge_at;
use super::scenes::{Draw, all_pairs, in_both_orders};
use super::within::found;
use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pair, Pose, Scene, Shape};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{
    Accuracy, Contact, Depths, Distance, Distances, Manifolds, PosedShape, SimdDepths,
    SimdDistances, Verdict, certified,
};
use dcd_simd::Path;
use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

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

/// Compounds of one part and more, some of equal cuboids, and convex shapes.
fn compounds(draw: &mut Draw, is_lattice: bool, most: f64) -> Vec<Shape> {
    (0..36)
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
        .collect()
}

/// A box of twelve triangles, a ball, or a part of a ball that is open; some rounded.
fn mesh(draw: &mut Draw, is_lattice: bool) -> Shape {
    let half = if is_lattice { DVec3::new(0.25, 0.5, 0.125) } else { draw.vector().abs() * 0.5 };
    let half = half.max(DVec3::splat(0.01));
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    if is_lattice || draw.unit() < 0.0 {
        let corner = |k: u32, bit: u32| if k & bit == 0 { -1.0 } else { 1.0 };
        vertices.extend((0..8).map(|k| DVec3::from([1, 2, 4].map(|bit| corner(k, bit))) * half));
        for [a, b, c, d] in
            [[0, 2, 1, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 6, 3, 7], [0, 4, 2, 6], [1, 3, 5, 7]]
        {
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    } else {
        let (rings, sides) = (3 + (draw.unit() + 1.0) as u32, 4 + (draw.unit() * 2.0 + 2.0) as u32);
        for ring in 0..=rings {
            for side in 0..sides {
                let polar =
                    PI * (f64::from(ring) + 0.2) / (f64::from(rings) + 0.4 + draw.unit().abs());
                let around = TAU * f64::from(side) / f64::from(sides);
                let (sin, cos) = polar.sin_cos();
                vertices.push(DVec3::new(sin * around.cos(), sin * around.sin(), cos) * half);
                if ring < rings {
                    let (p, q) = (ring * sides + side, ring * sides + (side + 1) % sides);
                    triangles.extend([[p, q, p + sides], [q, q + sides, p + sides]]);
                }
            }
        }
    }
    let swept = if draw.unit() > 0.6 { 0.05 } else { 0.0 };
    Shape::mesh(vertices, triangles).unwrap().rounded(swept).unwrap()
}

/// The shapes in a cube of that half-width, and the same in the reverse order.
fn scenes(draw: &mut Draw, shapes: Vec<Shape>, is_lattice: bool, far: f64) -> [Scene; 2] {
    let objects = (0..shapes.len() as u32).map(|k| Object::new(k, pose(draw, is_lattice, far)));
    in_both_orders(shapes, objects.collect())
}

/// A shape's parts, placed.
fn parts(shape: &Shape) -> Vec<Cow<'_, Shape>> {
    match shape {
        Shape::Compound(compound) => {
            compound.parts().iter().map(|part| Cow::Borrowed(part.placed())).collect()
        }
        Shape::Mesh(mesh) => (0..mesh.triangles().len())
            .map(|k| Shape::triangle(mesh.corners(k).unwrap()).unwrap())
            .map(|triangle| Cow::Owned(triangle.rounded(mesh.swept_radius()).unwrap()))
            .collect(),
        other => vec![Cow::Borrowed(other)],
    }
}

/// The least distance of all pairs of parts, and what bounds it; `None` where a pair touches, or f64 leaves that open.
fn nearest(scene: &Scene, pair: Pair) -> Option<[f64; 2]> {
    let [i, j] = [pair.i, pair.j].map(|k| k as usize);
    let solver = Distances::within(1e3).unwrap();
    let mut least = [f64::INFINITY; 2];
    let (of_a, of_b) = (parts(scene.shape(i)), parts(scene.shape(j)));
    for a in &of_a {
        for b in &of_b {
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

type Found = Contact<Option<Distance>>;

/// (a, b) and (b, a) of a scene of so many objects.
fn check_mirrored(objects: u32, ones: &[Found], others: &[Found]) {
    assert_eq!(ones.len(), others.len());
    for one in ones {
        let pair = Pair::new(objects - 1 - one.pair.j, objects - 1 - one.pair.i);
        let other = others.iter().find(|other| other.pair == pair).unwrap();
        let (Some(a), Some(b)) = (one.answer, other.answer) else {
            assert_eq!(one.answer, other.answer);
            continue;
        };
        assert_eq!((a.distance, a.error_bound), (b.distance, b.error_bound), "{pair:?}");
        assert_eq!((a.point_a, a.point_b, a.normal), (b.point_b, b.point_a, -b.normal));
    }
}

/// Measures the scene at every accuracy and path, in both orders, and compares it with the nearest parts: how many pairs
/// are measured, and the widest bound.
fn check(scenes: &[Scene; 2], margin: f64, said: &str) -> (usize, f64) {
    let objects = scenes[0].len() as u32;
    let pairs = all_pairs(objects);
    let truth: Vec<_> = pairs.iter().map(|&pair| nearest(&scenes[0], pair)).collect();
    let (mut measured, mut worst) = (0, 0.0f64);
    for accuracy in ACCURACIES {
        let said = format!("{said}, {margin} m, {accuracy:?}");
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
        check_mirrored(objects, &lanes, &reversed);
        for (&pair, &truth) in pairs.iter().zip(&truth) {
            let Some([lower, upper]) = truth else { continue };
            let found = lanes.iter().find(|contact| contact.pair == pair);
            let said = format!("{said}, {pair:?}: {lower} to {upper}, {found:?}");
            let Some(contact) = found else {
                assert!(upper > margin, "{said}");
                continue;
            };
            let found = contact.answer.expect(&said);
            assert!(lower <= margin, "{said}");
            assert!(found.lower() <= upper && lower <= found.upper(), "{said}");
            let between = found.point_a.distance(found.point_b);
            assert!((between - found.distance).abs() < 1e-5, "{said}");
            worst = worst.max(found.error_bound);
            measured += 1;
        }
    }
    (measured, worst)
}

#[test]
fn compounds_are_as_far_apart_as_their_nearest_parts() {
    let mut draw = Draw::seeded(31);
    let (mut measured, mut worst) = (0, 0.0f64);
    for round in 0..12 {
        let (is_lattice, most) = (round % 3 == 0, [4.0, 24.0][round % 2]);
        let shapes = compounds(&mut draw, is_lattice, most);
        let scenes = scenes(&mut draw, shapes, is_lattice, 2.0);
        for margin in [0.3, 3.0] {
            let found = check(&scenes, margin, &format!("round {round}"));
            (measured, worst) = (measured + found.0, worst.max(found.1));
        }
    }
    assert!(measured > 5_000 && worst < 1e-4, "{measured} {worst}");
}

#[test]
fn meshes_are_as_far_apart_as_their_nearest_triangles() {
    let mut draw = Draw::seeded(32);
    let (mut measured, mut worst) = (0, 0.0f64);
    for round in 0..12 {
        let is_lattice = round % 3 == 0;
        let mut shapes: Vec<_> = (0..14).map(|_| mesh(&mut draw, is_lattice)).collect();
        // Compounds of few parts and of many beside them.
        shapes.extend(compounds(&mut draw, is_lattice, 24.0).into_iter().take(2));
        let scenes = scenes(&mut draw, shapes, is_lattice, 1.5);
        for margin in [0.3, 3.0] {
            let found = check(&scenes, margin, &format!("round {round}"));
            (measured, worst) = (measured + found.0, worst.max(found.1));
        }
    }
    assert!(measured > 1_000 && worst < 1e-4, "{measured} {worst}");
}

/// The greatest depth of all pairs of parts that touch, and what bounds it; `None` where it is not known whether one does.
fn deepest(scene: &Scene, pair: Pair) -> Option<[f64; 2]> {
    let [i, j] = [pair.i, pair.j].map(|k| k as usize);
    let (of_a, of_b) = (parts(scene.shape(i)), parts(scene.shape(j)));
    let mut most = [0.0f64; 2];
    for a in &of_a {
        for b in &of_b {
            let a = PosedShape { shape: a, pose: &scene.poses()[i] };
            let b = PosedShape { shape: b, pose: &scene.poses()[j] };
            match certified::overlap_of(a, b).0 {
                Verdict::Apart => continue,
                Verdict::Undecided(_) => return None,
                Verdict::Touching(()) => {}
            }
            let Verdict::Touching(found) =
                Depths.measure_at(Accuracy::Certified, a, b, &mut Default::default())
            else {
                return None;
            };
            let [lower, upper] = [-1.0, 1.0].map(|sign| found.depth + sign * found.error_bound);
            most = [most[0].max(lower), most[1].max(upper)];
        }
    }
    Some(most)
}

/// How many objects of that scene follow one before one of the same shape.
const APART: usize = 12;

/// Depths and manifolds of a scene whose pairs are all looked at: the same on every path, and with a and b exchanged. How many.
fn check_depths(scenes: &[Scene; 2], accuracy: Accuracy, said: &str) -> usize {
    let (objects, pairs) = (scenes[0].len() as u32, all_pairs(scenes[0].len() as u32));
    let mirrored = |pair: Pair| Pair::new(objects - 1 - pair.j, objects - 1 - pair.i);
    let depths = SimdDepths::new(Depths, accuracy);
    let manifolds = SimdDepths::new(Manifolds::default(), accuracy);
    let [ones, others] = scenes.each_ref().map(|scene| found(&depths, scene, &pairs).0);
    let [sets, exchanged] = scenes.each_ref().map(|scene| found(&manifolds, scene, &pairs).0);
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        let depths = SimdDepths::on(path, Depths, accuracy);
        assert_eq!(found(&depths, &scenes[0], &pairs).0, ones, "{said} {path:?}");
        let manifolds = SimdDepths::on(path, Manifolds::default(), accuracy);
        assert_eq!(found(&manifolds, &scenes[0], &pairs).0, sets, "{said} {path:?}");
    }
    assert_eq!((ones.len(), sets.len(), sets.len()), (others.len(), ones.len(), exchanged.len()));
    for (one, set) in ones.iter().zip(&sets) {
        // Two that are one shape at one pose have no order.
        let [a, b] = [one.pair.i, one.pair.j].map(|k| k as usize);
        if b == a + APART && scenes[0].poses()[a] == scenes[0].poses()[b] {
            continue;
        }
        let pair = mirrored(one.pair);
        let other = others.iter().find(|other| other.pair == pair).unwrap().answer;
        let (one, said) = (one.answer, format!("{said} {:?}", one.pair));
        assert_eq!((one.depth, one.error_bound), (other.depth, other.error_bound), "{said}");
        assert_eq!((one.point_a, one.normal), (other.point_b, -other.normal), "{said}");
        let other = &exchanged.iter().find(|other| other.pair == pair).unwrap().answer;
        assert_eq!(set.answer.len(), other.len(), "{said}");
        for (one, other) in set.answer.iter().zip(other.iter()) {
            assert_eq!((one.normal, one.error_bound), (-other.normal, other.error_bound), "{said}");
            assert_eq!(one.parts, [other.parts[1], other.parts[0]], "{said}");
            assert_eq!(one.points().len(), other.points().len(), "{said}");
            for (one, other) in one.points().iter().zip(other.points()) {
                assert_eq!((one.point_a, one.depth), (other.point_b, other.depth), "{said}");
                assert_eq!(one.features, [other.features[1], other.features[0]], "{said}");
            }
        }
    }
    ones.len()
}

#[test]
fn depths_and_manifolds_of_compounds_are_one_on_every_path_and_in_both_orders() {
    let mut draw = Draw::seeded(35);
    let mut measured = 0;
    for round in 0..6 {
        let (is_lattice, most) = (round % 3 == 0, [4.0, 60.0][round % 2]);
        let mut shapes: Vec<_> =
            compounds(&mut draw, is_lattice, most).into_iter().take(APART).collect();
        // The same again: equal parts meet, and some at one pose.
        shapes.extend_from_within(..4);
        let objects =
            (0..shapes.len() as u32).map(|k| Object::new(k, pose(&mut draw, is_lattice, 0.8)));
        let mut objects: Vec<_> = objects.collect();
        objects[APART] = Object::new(APART as u32, objects[0].pose);
        objects[APART + 1] = Object::new(APART as u32 + 1, objects[2].pose);
        let scenes = in_both_orders(shapes, objects);
        for accuracy in ACCURACIES {
            measured += check_depths(&scenes, accuracy, &format!("round {round} {accuracy:?}"));
        }
    }
    assert!(measured > 300, "{measured}");
}

#[test]
fn compounds_are_as_deep_as_their_deepest_parts() {
    let mut draw = Draw::seeded(33);
    let mut measured = 0;
    for round in 0..9 {
        let (is_lattice, most) = (round % 3 == 0, [4.0, 12.0, 31.0][round / 3]);
        let shapes: Vec<_> = compounds(&mut draw, is_lattice, most).into_iter().take(20).collect();
        let scenes = scenes(&mut draw, shapes, is_lattice, 1.3);
        let (objects, pairs) = (scenes[0].len() as u32, all_pairs(scenes[0].len() as u32));
        let truth: Vec<_> = pairs.iter().map(|&pair| deepest(&scenes[0], pair)).collect();
        for accuracy in ACCURACIES {
            let said = format!("round {round}, {accuracy:?}");
            let depths = SimdDepths::new(Depths, accuracy);
            let [ones, others] = scenes.each_ref().map(|scene| found(&depths, scene, &pairs).0);
            assert_eq!(ones.len(), others.len(), "{said}");
            for one in &ones {
                let pair = Pair::new(objects - 1 - one.pair.j, objects - 1 - one.pair.i);
                let other = others.iter().find(|other| other.pair == pair).unwrap().answer;
                let one = one.answer;
                assert_eq!(
                    (one.depth, one.error_bound),
                    (other.depth, other.error_bound),
                    "{said}"
                );
                assert_eq!((one.point_a, one.normal), (other.point_b, -other.normal), "{said}");
            }
            let manifolds = SimdDepths::new(Manifolds::default(), accuracy);
            let (sets, _) = found(&manifolds, &scenes[0], &pairs);
            for ((&pair, truth), contact) in pairs.iter().zip(&truth).filter_map(|(pair, truth)| {
                Some(((pair, truth.as_ref()?), ones.iter().find(|one| one.pair == *pair)?))
            }) {
                let (found, said) = (contact.answer, format!("{said} {pair:?} {truth:?}"));
                let [lower, upper] = [-1.0, 1.0].map(|sign| found.depth + sign * found.error_bound);
                assert!(lower <= truth[1] && truth[0] <= upper, "{said} {found:?}");
                let set = sets.iter().find(|set| set.pair == pair).expect(&said);
                let first = set.answer.first().expect(&said);
                let off = (first.points()[0].depth - found.depth).abs();
                assert!(off <= first.error_bound + found.error_bound, "{said} {found:?} {first:?}");
                let posed = |k: u32| {
                    let (shape, pose) =
                        (scenes[0].shape(k as usize), scenes[0].poses()[k as usize]);
                    PosedSupport { shape: shape.clone(), pose }
                };
                // Certified ones of parts that are equally deep but for rounding may be in either order.
                if accuracy != Accuracy::Certified {
                    judge_at(accuracy, &said, &set.answer, [&posed(pair.i), &posed(pair.j)]);
                }
                measured += 1;
            }
        }
    }
    assert!(measured > 300, "{measured}");
}

#[test]
fn a_triangle_at_the_margin_is_within_it_also_behind_one_that_is_farther() {
    let corners = |low: f64, x: f64| [[x, x, low], [x + 0.5, x, low], [x, x + 0.5, low]];
    let vertices = [corners(0.76, -0.2), corners(0.75, 1.0)].concat();
    let vertices: Vec<DVec3> = vertices.into_iter().map(DVec3::from).collect();
    let mesh = Shape::mesh(vertices, vec![[0, 1, 2], [3, 4, 5]]).unwrap();
    let half = DVec3::new(2.0, 2.0, 0.5);
    let cuboid = Shape::cuboid(half).unwrap();
    let compound = Shape::compound(vec![(cuboid.clone(), Pose::IDENTITY)]).unwrap();
    let top = [-half.x, half.x].map(|x| [-half.y, half.y].map(|y| DVec3::new(x, y, half.z)));
    let other = Shape::mesh(top.concat(), vec![[0, 1, 2], [1, 3, 2]]).unwrap();
    for (what, beside) in [("cuboid", cuboid), ("compound", compound), ("mesh", other)] {
        let scene = Scene::one_each(vec![beside, mesh.clone()], vec![Pose::IDENTITY; 2]).unwrap();
        for accuracy in ACCURACIES {
            for more in [0.0, 1e-12, 1e-10, 1e-9, 1e-8] {
                let narrow = SimdDistances::within(0.25 * (1.0 + more), accuracy).unwrap();
                let (within, report) = found(&narrow, &scene, &all_pairs(2));
                assert!(report.undecided().is_empty(), "{what} {accuracy:?} {more}");
                assert_eq!(within.len(), 1, "{what} {accuracy:?} {more}");
            }
            let narrow = SimdDistances::within(0.25 * (1.0 - 1e-12), accuracy).unwrap();
            let (within, _) = found(&narrow, &scene, &all_pairs(2));
            assert_eq!(within.len(), 0, "{what} {accuracy:?}");
        }
    }
}
