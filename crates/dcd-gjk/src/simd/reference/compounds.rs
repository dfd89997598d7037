//! Compounds part by part: the verdict of the lanes is that of resolving every pair of parts by itself.

use super::{Numbers, paths, prepared};
use crate::simd::cores::MAX_PARTS;
use crate::simd::{Overlap, Scratch};
use crate::{
    ContactSink, Method, NarrowPhase, PosedShape, PosedSupport, Prepared, Report, Verdict,
    certified,
};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Aabb, Pair, Pose, Scene, Shape};
use dcd_simd::Path;

fn pose(numbers: &mut Numbers, half: f64) -> Pose {
    let turn = DQuat::from_xyzw(numbers.next(), numbers.next(), numbers.next(), numbers.next());
    Pose::new(turn.normalize(), numbers.vector() * half).unwrap()
}

fn convex(numbers: &mut Numbers, k: usize) -> Shape {
    match k % 6 {
        0 => Shape::hull((0..20).map(|_| numbers.vector() * 0.3).collect()).unwrap(),
        1 => Shape::sphere(0.2).unwrap(),
        2 => Shape::capsule(0.3, 0.1).unwrap(),
        3 => Shape::triangle([(); 3].map(|()| numbers.vector() * 0.5)).unwrap(),
        4 => Shape::cuboid(DVec3::new(0.2, 0.3, 0.1)).unwrap().rounded(0.05).unwrap(),
        _ => Shape::cuboid(numbers.vector().abs() * 0.3 + 0.05).unwrap(),
    }
}

/// Compounds of 1 to 40 parts, among them one of more than the lanes know, and what else there is.
fn scene(seed: u64) -> Scene {
    let mut numbers = Numbers(seed);
    let compound = |parts: usize, numbers: &mut Numbers| {
        let part = |k: usize, numbers: &mut Numbers| {
            let pose = if k % 4 == 1 { Pose::IDENTITY } else { pose(numbers, 1.0) };
            (convex(numbers, k * k + parts), pose)
        };
        Shape::compound((0..parts).map(|k| part(k, numbers)).collect()).unwrap()
    };
    let mut shapes: Vec<Shape> =
        [1, 2, 3, 5, 15, 16, 17, 40].map(|parts| compound(parts, &mut numbers)).into();
    shapes.push(compound(MAX_PARTS + 1, &mut numbers));
    shapes.extend((0..6).map(|k| convex(&mut numbers, k)));
    let corners = (0..12).map(|_| numbers.vector()).collect();
    shapes.push(Shape::mesh(corners, (0..10).map(|k| [k, k + 1, k + 2]).collect()).unwrap());
    let poses = shapes.iter().map(|_| pose(&mut numbers, 1.4)).collect();
    Scene::one_each(shapes, poses).unwrap()
}

/// The contacts, and how many pairs were resolved or left undecided.
fn judged(scene: &Scene, path: Path, pairs: &[Pair]) -> (Vec<Pair>, u64) {
    let (frame, _) = prepared(scene, path);
    let side = Prepared { scene, frame: &frame };
    let (mut contacts, mut report) = (Vec::new(), Report::default());
    let sink = &mut ContactSink { contacts: &mut contacts, report: &mut report };
    Overlap::on(path).decide(side, side, pairs, &mut Scratch::default(), sink);
    let resolved: u64 = Method::ALL.iter().map(|&method| report.resolved(method)).sum();
    let contacts = contacts.iter().map(|contact| contact.pair).collect();
    (contacts, resolved + report.undecided().len() as u64)
}

/// The parts in the frame of their shape.
fn parts(shape: &Shape) -> Vec<Shape> {
    match shape {
        Shape::Compound(compound) => compound.parts().iter().map(|p| p.placed().clone()).collect(),
        Shape::Mesh(mesh) => (0..mesh.triangles().len())
            .map(|k| Shape::hull(mesh.corners(k).unwrap().to_vec()).unwrap())
            .collect(),
        convex => vec![convex.clone()],
    }
}

/// The scalar reference: each pair of parts alone, by the last method.
fn touches(scene: &Scene, pair: Pair) -> bool {
    let [(i, a), (j, b)] = [pair.i, pair.j].map(|k| (k as usize, parts(scene.shape(k as usize))));
    let (at_a, at_b) = (&scene.poses()[i], &scene.poses()[j]);
    a.iter().any(|a| {
        b.iter().any(|b| match (a.as_polytope(), b.as_polytope()) {
            (Some(a), Some(b)) => certified::overlap_exactly(
                PosedSupport::polytope(a, at_a),
                PosedSupport::polytope(b, at_b),
            ),
            _ => {
                let a = PosedShape { shape: a, pose: at_a };
                certified::overlap_of(a, PosedShape { shape: b, pose: at_b }).0
                    == Verdict::Touching(())
            }
        })
    })
}

fn agrees_with_every_pair_of_parts(scene: &Scene) -> usize {
    let pairs = super::pairs(scene);
    let expected: Vec<Pair> = pairs.iter().copied().filter(|&p| touches(scene, p)).collect();
    for path in paths() {
        let (contacts, answered) = judged(scene, path, &pairs);
        assert_eq!(contacts, expected, "{path:?}");
        assert_eq!(answered, pairs.len() as u64, "{path:?}");
        // A verdict does not depend on the other pairs.
        for pair in pairs.iter().step_by(3) {
            assert_eq!(judged(scene, path, &[*pair]).0.is_empty(), !expected.contains(pair));
        }
    }
    expected.len()
}

#[test]
fn compounds_touch_where_a_pair_of_their_parts_does() {
    let (mut touching, mut all) = (0, 0);
    for seed in 0..4 {
        let scene = scene(seed);
        touching += agrees_with_every_pair_of_parts(&scene);
        all += super::pairs(&scene).len();
    }
    assert!(touching > 50 && touching < all, "{touching} of {all}");
}

#[test]
fn compounds_of_bricks_that_just_touch_are_contacts() {
    let brick = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let at = |x: f64, y: f64| Pose::from_translation(DVec3::new(x, y, 0.0)).unwrap();
    let hook = vec![(brick.clone(), at(0.0, 0.0)), (brick.clone(), at(1.0, 1.0))];
    let hook = Shape::compound(hook).unwrap();
    for (gap, expected) in [(0.0, true), (2.0 * f64::EPSILON, false), (-f64::EPSILON, true)] {
        let shapes = vec![hook.clone(), hook.clone(), brick.clone()];
        let scene = Scene::one_each(shapes, vec![at(0.0, 0.0), at(2.0 + gap, 0.0), at(9.0, 9.0)]);
        let scene = scene.unwrap();
        assert_eq!(agrees_with_every_pair_of_parts(&scene), usize::from(expected), "{gap}");
    }
}

#[test]
fn a_box_round_a_compound_holds_its_parts_and_little_else() {
    let scene = scene(9);
    for path in paths() {
        let (_, aabbs) = prepared(&scene, path);
        for (i, found) in aabbs.iter().enumerate() {
            let plain = scene.aabb(i);
            let grown = Aabb { min: plain.min - 1e-5, max: plain.max + 1e-5 };
            let shrunk = Aabb { min: plain.min + 1e-6, max: plain.max - 1e-6 };
            assert!(grown.contains(found) && found.contains(&shrunk), "{i}: {found:?}, {plain:?}");
            for part in parts(scene.shape(i)) {
                let vertices = part.as_polytope().unwrap().vertices();
                for world in vertices.iter().map(|&v| scene.poses()[i].apply(v)) {
                    let low = world - part.as_polytope().unwrap().swept_radius() + 1e-15;
                    assert!(low.cmpge(found.min.as_dvec3()).all(), "{i}: {world}");
                }
            }
        }
    }
}
