//! Meshes beside what is about as large: the lanes prove them apart by boxes round them, and never that they touch.

use super::scenes::{Draw, all_pairs};
use super::within::found;
use dcd_geom::glam::DVec3;
use dcd_geom::{Object, Pair, Pose, Scene, Shape};
use dcd_gjk::{Accuracy, Certified, Depths, Method, NarrowPhase, Overlap, Pairwise, SimdDepths};
use dcd_simd::Path;

/// The surface of a box.
fn box_mesh(half: DVec3) -> Shape {
    let corner = |k: u32, bit: u32| if k & bit == 0 { -1.0 } else { 1.0 };
    let corners = (0..8).map(|k| DVec3::from([1, 2, 4].map(|bit| corner(k, bit))) * half);
    let faces =
        [[0, 2, 1, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 6, 3, 7], [0, 4, 2, 6], [1, 3, 5, 7]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [b, d, c]]);
    Shape::mesh(corners.collect(), triangles.collect()).unwrap()
}

/// A shape of any kind, mostly long or flat: those have boxes.
fn shape(draw: &mut Draw, k: u32) -> Shape {
    let half = (draw.vector().abs() * DVec3::new(0.8, 0.3, 0.1)).max(DVec3::splat(0.01));
    match k % 6 {
        0 | 1 => box_mesh(half),
        2 => box_mesh(half).rounded(0.1 * half.x).unwrap(),
        3 => Shape::cuboid(half).unwrap(),
        4 => Shape::hull((0..12).map(|_| draw.vector() * half).collect()).unwrap(),
        _ => {
            // A strip that is no solid, far from its own origin.
            let at = |k: u32| DVec3::new(f64::from(k / 2), f64::from(k % 2), 7.0 + draw.unit());
            let corners: Vec<_> = (0..8).map(at).map(|corner| corner * half).collect();
            let triangles = (0..6).map(|k| [k, k + 1, k + 2]).collect();
            Shape::mesh(corners, triangles).unwrap()
        }
    }
}

fn pairs<N: NarrowPhase>(narrow: &N, scene: &Scene, all: &[Pair]) -> Vec<Pair> {
    let (contacts, report) = found(narrow, scene, all);
    assert!(report.undecided().is_empty());
    contacts.iter().map(|contact| contact.pair).collect()
}

#[test]
fn what_the_boxes_of_meshes_prove_apart_is_apart() {
    let mut draw = Draw::seeded(41);
    let (mut touching, mut by_boxes) = (0, 0);
    for far in [0.0, 1e3] {
        let shapes: Vec<Shape> = (0..90).map(|k| shape(&mut draw, k)).collect();
        let place = |draw: &mut Draw| draw.vector() * 0.9 + DVec3::splat(far);
        let objects = (0..shapes.len() as u32).map(|k| {
            let turn = draw.turn();
            Object::new(k, Pose::new(turn, place(&mut draw)).unwrap())
        });
        let objects: Vec<_> = objects.collect();
        let scene = Scene::new(shapes, objects).unwrap();
        let all = all_pairs(scene.len() as u32);
        let alone = pairs(&Pairwise(Certified), &scene, &all);
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            assert_eq!(pairs(&Overlap::on(path), &scene, &all), alone, "{path:?} {far}");
            let depths = SimdDepths::on(path, Depths, Accuracy::F32);
            assert_eq!(pairs(&depths, &scene, &all), alone, "{path:?} {far}");
        }
        touching += alone.len();
        by_boxes += found(&Overlap::default(), &scene, &all).1.resolved(Method::Obbs);
    }
    assert!(touching > 200 && by_boxes > 500, "{touching} {by_boxes}");
}

#[test]
fn what_is_inside_of_a_mesh_does_not_touch_it() {
    let half = DVec3::new(0.9, 0.3, 0.4);
    let whole = [box_mesh(half), Shape::cuboid(half * 0.7).unwrap(), box_mesh(half * 0.4)];
    let turn = Draw::seeded(42).turn();
    let poses = [1.0, 1.01, 0.99].map(|x| Pose::new(turn, DVec3::new(x, 2.0, 3.0)).unwrap());
    let scene = Scene::one_each(whole.to_vec(), poses.to_vec()).unwrap();
    // The cuboid holds the smaller mesh.
    let expected = vec![Pair { i: 1, j: 2 }];
    assert_eq!(pairs(&Pairwise(Certified), &scene, &all_pairs(3)), expected);
    assert_eq!(pairs(&Overlap::default(), &scene, &all_pairs(3)), expected);
}
