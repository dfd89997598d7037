//! Scenes of one kind beside the same objects with vertices, and beside exact arithmetic.

use super::super::bounds::TURNED;
use super::super::frame::{BOX, HAS_OBB, LIVE, WHOLE};
use super::super::{Overlap, Scratch};
use super::{Numbers, pairs, paths, prepared};
use crate::{ContactSink, Method, NarrowPhase, PosedSupport, Prepared, Report, certified};
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Pair, Pose, Scene, Shape, SupportMap};
use dcd_simd::Path;

/// Every seventh object rests on the one before: side by side along x by exactly what they reach.
fn placed(seed: u64, shapes: Vec<Shape>) -> Scene {
    let mut numbers = Numbers(seed);
    let reach = |shape: &Shape| shape.as_polytope().unwrap().vertices().last().unwrap().x;
    let mut poses: Vec<Pose> = Vec::new();
    for (k, shape) in shapes.iter().enumerate() {
        let turn = DQuat::from_xyzw(numbers.next(), numbers.next(), numbers.next(), numbers.next());
        let pose = Pose::new(turn.normalize(), numbers.vector() * 0.9).unwrap();
        poses.push(match (k % 7, poses.last()) {
            (6, Some(last)) => {
                let far = reach(&shapes[k - 1]) + shapes[k - 1].radius();
                let step = DVec3::X * (far + reach(shape) + shape.radius());
                Pose::from_matrix(*last.rotation(), last.translation() + *last.rotation() * step)
                    .unwrap()
            }
            // No rotation to the last digit: some within what the boxes allow, some beyond.
            (k, _) if k < 2 => {
                let stretch = [0.5 * TURNED, 200.0 * TURNED][k];
                let matrix =
                    *pose.rotation() * DMat3::from_diagonal(DVec3::new(1.0, 1.0 + stretch, 1.0));
                Pose::from_matrix(matrix, pose.translation()).unwrap()
            }
            _ => pose,
        });
    }
    Scene::one_each(shapes, poses).unwrap()
}

fn spheres() -> Scene {
    let mut numbers = Numbers(31);
    let mut shapes: Vec<Shape> =
        (0..60).map(|_| Shape::sphere(numbers.next().abs() * 0.5).unwrap()).collect();
    shapes[5] = Shape::sphere(0.0).unwrap();
    placed(32, shapes)
}

fn cuboids() -> Scene {
    let mut numbers = Numbers(33);
    let mut shapes: Vec<Shape> =
        (0..60).map(|_| Shape::cuboid((numbers.vector() * 0.6).abs()).unwrap()).collect();
    shapes[5] = Shape::cuboid(DVec3::new(0.5, 0.0, 0.5)).unwrap();
    shapes[20] = Shape::cuboid(DVec3::ZERO).unwrap();
    placed(34, shapes)
}

/// Cuboids along the world's axes, turned by quarters, each beside the one before: in touch along
/// one axis, or a float short of it or past it, far from the origin and near.
fn upright() -> Scene {
    let mut numbers = Numbers(35);
    let quarter = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z);
    let third = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    let (mut shapes, mut poses) = (Vec::new(), Vec::<Pose>::new());
    for k in 0..60usize {
        let half = (numbers.vector() * 0.4).abs() + 0.1;
        let turn = [DMat3::IDENTITY, quarter, third, quarter * third][k % 4];
        let far = DVec3::X * [0.0, 1e3, 1e6][k / 20];
        let t = match (k % 20, poses.last().zip(shapes.last())) {
            (1.., Some((last, &(before, turned)))) => {
                let axis = DVec3::AXES[k % 3];
                let reach = |half: DVec3, turn: DMat3| (turn.transpose() * axis).abs().dot(half);
                let step = reach(half, turn) + reach(before, turned);
                let ulps = [0i64, 1, -1, 40][k % 4];
                let along = (last.translation().dot(axis) + step).to_bits();
                let along = f64::from_bits(along.wrapping_add_signed(ulps));
                last.translation() * (DVec3::ONE - axis) + axis * along
            }
            _ => far,
        };
        shapes.push((half, turn));
        poses.push(Pose::from_matrix(turn, t).unwrap());
    }
    let shapes = shapes.into_iter().map(|(half, _)| Shape::cuboid(half).unwrap());
    Scene::one_each(shapes.collect(), poses).unwrap()
}

/// The verdict of the lanes on every pair, and how many of them they leave to the later methods.
pub(super) fn contacts(scene: &Scene, path: Path) -> (Vec<Pair>, Report) {
    let (frame, _) = prepared(scene, path);
    let side = Prepared { scene, frame: &frame };
    let (mut contacts, mut report) = (Vec::new(), Report::default());
    let sink = &mut ContactSink { contacts: &mut contacts, report: &mut report };
    Overlap::on(path).decide(side, side, &pairs(scene), &mut Scratch::default(), sink);
    (contacts.into_iter().map(|contact| contact.pair).collect(), report)
}

#[test]
fn a_scene_of_one_kind_is_answered_as_exact_integers_answer_it() {
    for scene in [spheres(), cuboids()] {
        let body = |i: u32| {
            let polytope = scene.shape(i as usize).as_polytope().unwrap();
            PosedSupport::polytope(polytope, &scene.poses()[i as usize])
        };
        let touch = |pair: &Pair| certified::overlap_exactly(body(pair.i), body(pair.j));
        let exact: Vec<Pair> = pairs(&scene).into_iter().filter(touch).collect();
        assert!(exact.len() > 50, "{}", exact.len());
        for path in paths() {
            let (found, report) = contacts(&scene, path);
            assert_eq!(found, exact, "{path:?}");
            assert!(report.undecided().is_empty());
            crate::contract::narrow_phase(&Overlap::on(path), &scene, &pairs(&scene)).unwrap();
        }
    }
}

#[test]
fn upright_cuboids_at_rest_are_answered_exactly_alone_and_among_hulls() {
    let alone = upright();
    let mut shapes = alone.shapes().to_vec();
    shapes.push(Shape::hull(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]).unwrap());
    let mut poses = alone.poses().to_vec();
    poses.push(Pose::from_translation(DVec3::splat(-9.0)).unwrap());
    let among = Scene::one_each(shapes, poses).unwrap();
    for scene in [alone, among] {
        let body = |i: u32| {
            let polytope = scene.shape(i as usize).as_polytope().unwrap();
            PosedSupport::polytope(polytope, &scene.poses()[i as usize])
        };
        let touch = |pair: &Pair| certified::overlap_exactly(body(pair.i), body(pair.j));
        let (exact, others): (Vec<Pair>, Vec<Pair>) = pairs(&scene).into_iter().partition(touch);
        let beside = others.iter().filter(|pair| pair.j == pair.i + 1);
        assert!(exact.len() > 25 && beside.count() > 10, "{}", exact.len());
        for path in paths() {
            let (found, report) = contacts(&scene, path);
            assert_eq!(found, exact, "{path:?}");
            assert!(report.resolved(Method::Exact) > 5, "{report:?}");
            assert_eq!(report.resolved(Method::Obbs), 0, "what is upright needs no boxes");
        }
    }
}

#[test]
fn a_scene_of_one_kind_has_no_vertices_and_one_object_more_gives_it_some() {
    for scene in [spheres(), cuboids()] {
        for path in paths() {
            assert!(!prepared(&scene, path).0.has_vertices());
        }
        let mut shapes = scene.shapes().to_vec();
        shapes.push(Shape::capsule(0.5, 0.25).unwrap());
        let mut poses = scene.poses().to_vec();
        poses.push(Pose::IDENTITY);
        let more = Scene::one_each(shapes, poses).unwrap();
        for path in paths() {
            assert!(prepared(&more, path).0.has_vertices());
            let among = |pair: &Pair| (pair.j as usize) < scene.len();
            let found: Vec<Pair> = contacts(&more, path).0.into_iter().filter(among).collect();
            assert_eq!(found, contacts(&scene, path).0, "{path:?}");
        }
    }
}

#[test]
fn boxes_of_one_kind_hold_every_corner_and_no_more_than_rounding() {
    for scene in [spheres(), cuboids()] {
        for path in paths() {
            let (_, aabbs) = prepared(&scene, path);
            for (i, aabb) in aabbs.iter().enumerate() {
                let (shape, pose) = (scene.shape(i), &scene.poses()[i]);
                let radius = shape.radius();
                for &v in shape.as_polytope().unwrap().vertices() {
                    let corner = pose.apply(v);
                    // Three products and three sums in f64.
                    let off = 4.0 * f64::EPSILON * (v.abs() + corner.abs()).max_element();
                    let (low, high) = (corner - radius - off, corner + radius + off);
                    assert!(aabb.min.as_dvec3().cmple(low).all(), "{path:?} {i}");
                    assert!(aabb.max.as_dvec3().cmpge(high).all(), "{path:?} {i}");
                }
                let plain = scene.aabb(i);
                assert!((aabb.min - plain.min).abs().max_element() < 1e-6, "{path:?} {i}");
                assert!((aabb.max - plain.max).abs().max_element() < 1e-6, "{path:?} {i}");
            }
        }
    }
}

#[test]
fn a_matrix_that_departs_too_far_leaves_a_cuboid_to_f64() {
    let scene = cuboids();
    for path in paths() {
        let (frame, _) = prepared(&scene, path);
        for (i, pose) in scene.poses().iter().enumerate() {
            let all = HAS_OBB | BOX | LIVE | WHOLE;
            let expected = if pose.deviation() < TURNED { all } else { 0 };
            assert_eq!(frame.record(i as u32).marks, expected);
        }
        let (_, report) = contacts(&scene, path);
        assert!(
            report.resolved(crate::Method::F64) > 0 && report.resolved(crate::Method::Obbs) > 0
        );
    }
}
