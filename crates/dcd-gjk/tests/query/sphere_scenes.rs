//! Scenes of spheres alone, beside the same spheres among other shapes, whose yes or no is that of the lanes.

use super::scenes::Draw;
use super::within::found;
use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pair, Pose, Scene, Shape};
use dcd_gjk::{
    Accuracy, Contact, Depths, Manifolds, Method, Overlap, Report, SimdDepths, SimdDistances,
};
use dcd_simd::Path;
use std::fmt::Debug;

const ACCURACIES: [Accuracy; 3] = [Accuracy::F32, Accuracy::F64, Accuracy::Certified];

/// Metres; the lattice has pairs that are as far apart.
const MARGIN: f64 = 0.25;

/// Spheres on two lattices, of which neighbours touch exactly and are a margin apart exactly, some of them off by a step
/// of f64 or by 1e-9; then some anywhere, points among them, and some with one centre. With or without a cuboid, of which there
/// is no object.
fn spheres(others: &[Shape]) -> (Scene, Vec<Pair>) {
    let mut draw = Draw::seeded(83);
    let own = [0.5, 0.25, 0.0, 0.7].map(|radius| Shape::sphere(radius).unwrap());
    let shapes = [&own, others].concat();
    let mut objects = Vec::new();
    let mut add = |kind: u32, place| {
        objects.push(Object::new(kind, Pose::from_translation(place).unwrap()));
    };
    for k in 0..128u32 {
        let (step, aside) = if k < 64 { (1.0, 0.0) } else { (1.0 + MARGIN, 10.0) };
        let place = [k % 4, k / 4 % 4, k / 16 % 4].map(f64::from);
        let off = [0.0, 0.0, f64::EPSILON, -f64::EPSILON, 1e-9, -1e-9][k as usize % 6];
        add(0, DVec3::from(place) * step + DVec3::new(aside + off, 0.0, 0.0));
    }
    for k in 0..120 {
        let place = draw.vector() * 2.0 - DVec3::X * 10.0;
        add(k % 4, place);
        if k % 20 == 0 {
            add(3, place);
        }
    }
    let count = objects.len() as u32;
    let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| Pair::new(i, j)));
    (Scene::new(shapes, objects).unwrap(), pairs.collect())
}

/// What a narrow phase finds of spheres alone and among others.
type Finds<'a, A> = dyn Fn(Path, &Scene, &[Pair]) -> (Vec<Contact<A>>, Report) + 'a;

fn assert_same<A: PartialEq + Debug>(what: &str, find: &Finds<'_, A>) {
    let (alone, pairs) = spheres(&[]);
    let (beside, _) = spheres(&[Shape::cuboid(DVec3::ONE).unwrap()]);
    let (due, of_due) = find(Path::best(), &beside, &pairs);
    assert!(due.len() > 200, "{what}: {}", due.len());
    for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
        let (all, report) = find(path, &alone, &pairs);
        assert_eq!(all.len(), due.len(), "{path:?} {what}");
        for (one, other) in all.iter().zip(&due) {
            assert_eq!(one, other, "{path:?} {what}");
        }
        let resolved = |report: &Report| Method::ALL.map(|method| report.resolved(method));
        let [own, others] = [&report, &of_due].map(|report| resolved(report).iter().sum::<u64>());
        assert_eq!((own, report.undecided()), (others, of_due.undecided()), "{path:?} {what}");
        // Some are resolved by squares and roots, some by longer numbers.
        let by_spheres = report.resolved(Method::Spheres);
        assert!(by_spheres > 300 && by_spheres < own, "{path:?} {what}: {by_spheres} of {own}");
    }
}

#[test]
fn spheres_alone_are_as_far_apart_as_beside_other_shapes() {
    for accuracy in ACCURACIES {
        for margin in [0.0, MARGIN] {
            let find = |path, scene: &Scene, pairs: &[Pair]| {
                found(&SimdDistances::on(path, margin, accuracy).unwrap(), scene, pairs)
            };
            assert_same(&format!("{accuracy:?} within {margin}"), &find);
        }
    }
}

#[test]
fn spheres_alone_touch_where_they_touch_beside_other_shapes() {
    let find = |path, scene: &Scene, pairs: &[Pair]| found(&Overlap::on(path), scene, pairs);
    assert_same("yes or no", &find);
    // Of a few pairs there is no whole packet.
    let (scene, pairs) = spheres(&[]);
    for count in 0..40 {
        let some = &pairs[pairs.len() - count..];
        let (contacts, _) = found(&Overlap::default(), &scene, some);
        let touch = |pair: &&Pair| !found(&Overlap::default(), &scene, &[**pair]).0.is_empty();
        assert!(contacts.iter().map(|contact| &contact.pair).eq(some.iter().filter(touch)));
    }
}

#[test]
fn spheres_alone_are_as_deep_as_beside_other_shapes_and_touch_in_the_same_points() {
    for accuracy in ACCURACIES {
        let depths = |path, scene: &Scene, pairs: &[Pair]| {
            found(&SimdDepths::on(path, Depths, accuracy), scene, pairs)
        };
        assert_same(&format!("{accuracy:?} depths"), &depths);
        let manifolds = |path, scene: &Scene, pairs: &[Pair]| {
            found(&SimdDepths::on(path, Manifolds::default(), accuracy), scene, pairs)
        };
        assert_same(&format!("{accuracy:?} manifolds"), &manifolds);
    }
}

/// Spheres of whole numbers times a power of two: how far apart they are is a comparison of whole numbers. Many touch or are a
/// margin apart exactly, along the axes and across, or miss that by one in 2²⁰.
#[test]
fn spheres_of_whole_numbers_are_within_a_margin_as_their_squares_say() {
    let mut draw = Draw::seeded(89);
    let mut counts = [0; 3];
    for round in 0..24 {
        let unit = [1.0, 2f64.powi(-40), 2f64.powi(19)][round % 3];
        let margin = [0, 5, 1 << 18][round / 3 % 3];
        let mut below = |most: i64| ((draw.unit() + 1.0) * 0.5 * most as f64) as i64;
        let radii: Vec<i64> = (0..6).map(|k| if k == 0 { 0 } else { below(1 << 19) + 1 }).collect();
        let mut centres: Vec<([i64; 3], usize)> = Vec::new();
        for k in 0..40usize {
            let kind = k % 6;
            let at = match k {
                0..8 => [below(1 << 22), below(1 << 22), below(1 << 22)],
                _ => {
                    // Beside an earlier one: 1, 0, 0; 3, 4, 0; 2, 3, 6; 1, 4, 8 have whole lengths.
                    let (centre, other) = centres[below(k as i64) as usize];
                    let ways = [([1, 0, 0], 1), ([3, -4, 0], 5), ([2, 3, -6], 7), ([-1, 4, 8], 9)];
                    let (way, length) = ways[below(4) as usize];
                    let due = radii[other] + radii[kind] + if k % 2 == 0 { margin } else { 0 };
                    let times = due / length + below(3) - 1;
                    [0, 1, 2].map(|axis| centre[axis] + way[axis] * times)
                }
            };
            centres.push((at, kind));
        }
        let shapes: Vec<Shape> =
            radii.iter().map(|&radius| Shape::sphere(radius as f64 * unit).unwrap()).collect();
        let objects = centres.iter().map(|&(at, kind)| {
            let place = DVec3::from(at.map(|x| x as f64 * unit));
            Object::new(kind as u32, Pose::from_translation(place).unwrap())
        });
        let scene = Scene::new(shapes, objects.collect::<Vec<_>>()).unwrap();
        let pairs: Vec<Pair> =
            (0..40u32).flat_map(|i| (i + 1..40).map(move |j| Pair::new(i, j))).collect();
        let beyond = |pair: &Pair, margin: i64| {
            let [(a, of_a), (b, of_b)] = [pair.i, pair.j].map(|k| centres[k as usize]);
            let squares = (0..3).map(|k| i128::from(a[k] - b[k]).pow(2)).sum::<i128>();
            squares - i128::from(radii[of_a] + radii[of_b] + margin).pow(2)
        };
        let due = |margin: i64| pairs.iter().copied().filter(move |pair| beyond(pair, margin) <= 0);
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            for accuracy in ACCURACIES {
                let said = format!("round {round}, {path:?} {accuracy:?}");
                let narrow = SimdDistances::on(path, margin as f64 * unit, accuracy).unwrap();
                let (near, _) = found(&narrow, &scene, &pairs);
                assert!(near.iter().map(|c| c.pair).eq(due(margin)), "{said}");
                for Contact { pair, answer } in &near {
                    assert_eq!(answer.is_none(), beyond(pair, 0) <= 0, "{said}: {pair:?}");
                }
                let (touching, _) = found(&Overlap::on(path), &scene, &pairs);
                assert!(touching.iter().map(|c| c.pair).eq(due(0)), "{said}");
                let (deep, _) = found(&SimdDepths::on(path, Depths, accuracy), &scene, &pairs);
                assert!(deep.iter().map(|c| c.pair).eq(due(0)), "{said}");
                counts[0] += near.len();
                counts[1] += deep.len();
            }
        }
        counts[2] += pairs.iter().filter(|pair| beyond(pair, margin) == 0).count();
    }
    assert!(counts.iter().all(|&count| count > 30), "{counts:?}");
}
