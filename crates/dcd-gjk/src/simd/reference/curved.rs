//! Curved shapes, which the lanes know by a hull inside and an excess, beside f64's support maps.

use super::super::{OverlapUnchecked, Scratch};
use super::forms::contacts;
use super::{Numbers, pairs, paths, prepared};
use crate::{ContactSink, Method, NarrowPhase, PosedShape, Prepared, Report, Verdict, certified};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pair, Pose, Scene, Shape, SupportMap};

/// Round, long and flat ones, some rounded, some upright, among boxes and hulls, at this scale.
fn scene(seed: u64, scale: f64) -> Scene {
    let mut numbers = Numbers(seed);
    let mut shapes = Vec::new();
    let mut poses = Vec::new();
    for k in 0..96 {
        let half = (numbers.vector().abs() * 0.5 + 0.03) * scale;
        let shape = match k % 8 {
            0 => Shape::cylinder(half.x, half.y),
            1 => Shape::cone(half.x, half.y),
            2 => Shape::cylinder(half.x, half.y).and_then(|shape| shape.rounded(0.1 * scale)),
            3 => Shape::cone(half.x, half.y).and_then(|shape| shape.rounded(0.05 * scale)),
            4 => Shape::ellipsoid(half),
            5 => Shape::ellipsoid(half).and_then(|shape| shape.rounded(0.07 * scale)),
            6 => Shape::cuboid(half),
            _ => Shape::hull((0..20).map(|_| numbers.vector() * half).collect()),
        };
        let turn = DQuat::from_xyzw(numbers.next(), numbers.next(), numbers.next(), numbers.next());
        let turn = if k % 5 == 0 { DQuat::IDENTITY } else { turn.normalize() };
        shapes.push(shape.unwrap());
        poses.push(Pose::new(turn, numbers.vector() * 0.9 * scale).unwrap());
    }
    Scene::one_each(shapes, poses).unwrap()
}

fn is_curved_shape(shape: &Shape) -> bool {
    matches!(shape, Shape::Curved(_) | Shape::Ellipsoid(_))
}

/// The verdict of f64 on every pair, by support maps alone.
fn in_f64(scene: &Scene) -> Vec<Pair> {
    let placed =
        |i: u32| PosedShape { shape: scene.shape(i as usize), pose: &scene.poses()[i as usize] };
    let touch = |pair: &Pair| match certified::overlap_of(placed(pair.i), placed(pair.j)).0 {
        Verdict::Undecided(reason) => panic!("{pair:?}: {reason:?}"),
        verdict => verdict == Verdict::Touching(()),
    };
    pairs(scene).into_iter().filter(touch).collect()
}

#[test]
fn curved_shapes_are_answered_as_f64_answers_them_and_most_pairs_in_the_lanes() {
    for (seed, scale) in [(41, 1.0), (42, 1e-3), (43, 1e4)] {
        let scene = scene(seed, scale);
        let expected = in_f64(&scene);
        assert!(expected.len() > 250, "{}", expected.len());
        for path in paths() {
            let (found, report) = contacts(&scene, path);
            assert_eq!(found, expected, "{path:?} {scale}");
            let (later, all) = (report.resolved(Method::F64), pairs(&scene).len() as u64);
            assert!(later > 0 && later < all / 20, "{later} of {all}");
        }
    }
}

#[test]
fn without_a_certificate_curved_shapes_are_left_to_f64() {
    let scene = scene(44, 1.0);
    for path in paths() {
        let (frame, _) = prepared(&scene, path);
        let side = Prepared { scene: &scene, frame: &frame };
        let (mut contacts, mut report) = (Vec::new(), Report::default());
        let sink = &mut ContactSink { contacts: &mut contacts, report: &mut report };
        let unproved = OverlapUnchecked::on(path);
        unproved.decide(side, side, &pairs(&scene), &mut Scratch::default(), sink);
        let is_curved = |i: u32| is_curved_shape(scene.shape(i as usize));
        let curved = pairs(&scene).into_iter().filter(|p| is_curved(p.i) || is_curved(p.j));
        assert!(report.resolved(Method::F64) >= curved.count() as u64);
        let found: Vec<Pair> = contacts.into_iter().map(|contact| contact.pair).collect();
        assert_eq!(found, in_f64(&scene), "{path:?}");
    }
}

#[test]
fn boxes_of_curved_shapes_are_those_of_the_shapes() {
    let scene = scene(45, 1.0);
    for path in paths() {
        let (_, aabbs) = prepared(&scene, path);
        for (i, aabb) in aabbs.iter().enumerate() {
            if is_curved_shape(scene.shape(i)) {
                assert_eq!(*aabb, scene.aabb(i), "{path:?} {i}");
            }
            let d = DVec3::new(0.3, -0.2, 0.7);
            let own = scene.poses()[i].rotation().transpose() * d;
            let farthest = scene.shape(i).support(own).point;
            let at = scene.poses()[i].apply(farthest);
            assert!(
                aabb.max.as_dvec3().dot(d.max(DVec3::ZERO))
                    + aabb.min.as_dvec3().dot(d.min(DVec3::ZERO))
                    >= at.dot(d)
            );
        }
    }
}
