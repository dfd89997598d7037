//! (a, b) and (b, a) at places where much is equally near or deep: rounded shapes along the world's axes on a lattice.

use super::PosedSupport;
use super::lane_depths::alone;
use super::lane_parts::manifolds;
use super::scenes::{Draw, all_pairs, in_both_orders};
use super::within::found;
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Object, Pair, Polytope, Pose, Scene, Shape};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{Accuracy, Contact, Depths, Manifolds, SimdDepths, SimdDistances, Verdict};
use std::f64::consts::{FRAC_PI_2, TAU};

const OBJECTS: u32 = 60;

const ACCURACIES: [Accuracy; 3] = [Accuracy::F32, Accuracy::F64, Accuracy::Certified];

/// A prism of that many sides along z.
fn prism(sides: u32, height: f64) -> Shape {
    let corner = |k: u32| DVec3::new(0.5, 0.0, 0.0).rotate_z(TAU * f64::from(k) / f64::from(sides));
    let corners = (0..sides).flat_map(|k| [-height, height].map(|z| corner(k) + DVec3::Z * z));
    Shape::hull(corners.collect()).unwrap()
}

/// The scene, and the same with its objects in the reverse order, so that every pair is the other way round.
fn scenes(draw: &mut Draw) -> [Scene; 2] {
    let mut below = |count: u32| ((draw.unit() + 1.0) * 0.5 * f64::from(count)) as u32;
    let mut shapes = Vec::new();
    // No two alike, but for what one is turned to.
    for height in [0.125, 0.25, 0.375, 0.5, 0.75, 1.0] {
        shapes.push(prism(3 + below(28), height));
        shapes.push(prism(3 + below(28), height).swept(0.1).unwrap());
        shapes.push(Shape::capsule(height, 0.25).unwrap());
        shapes.push(Shape::cuboid(DVec3::new(0.5, 0.25, height)).unwrap());
    }
    let objects: Vec<_> = (0..OBJECTS)
        .map(|k| {
            let place = DVec3::new(below(5).into(), below(5).into(), below(5).into()) * 0.5;
            let turn = DQuat::from_rotation_z(FRAC_PI_2 * f64::from(below(4)));
            Object::new(k % shapes.len() as u32, Pose::new(turn, place).unwrap())
        })
        .collect();
    in_both_orders(shapes, objects)
}

/// Every contact of the scene beside that of the other, except for equal objects at one place: there both orders are one.
fn beside<'a, A>(
    scene: &'a Scene,
    [ones, others]: &'a [Vec<Contact<A>>; 2],
) -> impl Iterator<Item = (&'a A, &'a A)> {
    assert_eq!(ones.len(), others.len());
    let differ = |pair: Pair| {
        let [i, j] = [pair.i, pair.j].map(|k| k as usize);
        scene.shape_of()[i] != scene.shape_of()[j] || scene.poses()[i] != scene.poses()[j]
    };
    ones.iter().filter(move |one| differ(one.pair)).map(|one| {
        let pair = Pair::new(OBJECTS - 1 - one.pair.j, OBJECTS - 1 - one.pair.i);
        let other = others.iter().find(|other| other.pair == pair).unwrap();
        (&one.answer, &other.answer)
    })
}

#[test]
fn depths_manifolds_and_distances_on_a_lattice_are_mirrored() {
    let mut draw = Draw::seeded(8);
    let pairs = all_pairs(OBJECTS);
    let mut counts = [0; 3];
    for round in 0..24 {
        let scenes = scenes(&mut draw);
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let said = format!("round {round}, {accuracy:?}");
            let depths = SimdDepths::new(Depths, accuracy);
            let both = scenes.each_ref().map(|scene| found(&depths, scene, &pairs).0);
            for (one, other) in beside(&scenes[0], &both) {
                assert_eq!(
                    (one.depth, one.error_bound),
                    (other.depth, other.error_bound),
                    "{said}"
                );
                assert_eq!((one.point_a, one.point_b), (other.point_b, other.point_a), "{said}");
                assert_eq!(one.normal, -other.normal, "{said}");
                counts[0] += 1;
            }
            let manifolds = SimdDepths::new(Manifolds::default(), accuracy);
            let both = scenes.each_ref().map(|scene| found(&manifolds, scene, &pairs).0);
            for (one, other) in beside(&scenes[0], &both) {
                assert_eq!(one.len(), other.len(), "{said}");
                for (one, other) in one.iter().zip(other.iter()) {
                    assert_eq!(one.normal, -other.normal, "{said}");
                    assert_eq!(one.points().len(), other.points().len(), "{said}");
                    for (one, other) in one.points().iter().zip(other.points()) {
                        assert_eq!((one.point_a, one.point_b), (other.point_b, other.point_a));
                    }
                    counts[1] += 1;
                }
            }
            let distances = SimdDistances::within(0.5, accuracy).unwrap();
            let both = scenes.each_ref().map(|scene| found(&distances, scene, &pairs).0);
            for (one, other) in beside(&scenes[0], &both) {
                let (Some(one), Some(other)) = (one, other) else { continue };
                assert_eq!((one.distance, one.error_bound), (other.distance, other.error_bound));
                assert_eq!((one.point_a, one.point_b), (other.point_b, other.point_a), "{said}");
                assert_eq!(one.normal, -other.normal, "{said}");
                counts[2] += 1;
            }
        }
    }
    assert!(counts.iter().all(|&count| count > 10_000), "{counts:?}");
}

/// Some equal cuboids on a lattice.
fn cuboids(draw: &mut Draw) -> Shape {
    let cuboid = Shape::cuboid(DVec3::new(0.25, 0.2, 0.15)).unwrap();
    let parts = (0..2 + (draw.unit() > 0.0) as u32).map(|k| {
        let place = DVec3::new(0.4 * f64::from(k), 0.25 * draw.unit().round(), 0.0);
        let turn = DQuat::from_rotation_z(FRAC_PI_2 * draw.unit().round());
        (cuboid.clone(), Pose::new(turn, place).unwrap())
    });
    Shape::compound(parts.collect()).unwrap()
}

#[test]
fn depths_of_compounds_whose_parts_are_equally_deep_are_mirrored() {
    let mut draw = Draw::seeded(9);
    let mut touching = [0; 3];
    for round in 0..400 {
        let shape = cuboids(&mut draw);
        let other = if round % 2 == 0 { shape.clone() } else { cuboids(&mut draw) };
        // Turned about one axis, so that edges of several parts are equally deep but for rounding.
        let axis = draw.vector().normalize();
        let mut body = |shape: &Shape| {
            let turn = DQuat::from_axis_angle(axis, FRAC_PI_2 * draw.unit().round());
            PosedSupport::new(shape.clone(), turn, axis.cross(draw.vector()) * 0.3)
        };
        let [a, b] = [body(&shape), body(&other)];
        for (k, accuracy) in
            [Accuracy::F32, Accuracy::F64, Accuracy::Certified].into_iter().enumerate()
        {
            let depth = |a: &PosedSupport, b: &PosedSupport| {
                Depths.measure_at(accuracy, a.placed(), b.placed(), &mut Default::default())
            };
            let (Verdict::Touching(one), Verdict::Touching(other)) = (depth(&a, &b), depth(&b, &a))
            else {
                continue;
            };
            let what = format!("{round} {accuracy:?}: {a:?} {b:?}");
            assert_eq!((one.depth, one.error_bound), (other.depth, other.error_bound), "{what}");
            assert_eq!((one.point_a, one.point_b), (other.point_b, other.point_a), "{what}");
            assert_eq!(one.normal, -other.normal, "{what}");
            touching[k] += 1;
        }
    }
    assert!(touching.iter().all(|&count| count > 100), "{touching:?}");
}

#[test]
fn compounds_whose_deepest_parts_are_spheres_are_mirrored() {
    let part = |shape, place| (shape, Pose::from_translation(place).unwrap());
    let ball = part(Shape::sphere(3.0).unwrap(), DVec3::ZERO);
    let brick =
        part(Shape::cuboid(DVec3::new(1.0, 0.1, 0.01)).unwrap(), DVec3::new(-1.0, 1.0, -1.0));
    let spike = part(Shape::cone(0.5, 0.5).unwrap(), DVec3::ZERO);
    let block = part(Shape::cuboid(DVec3::new(1.0, 0.5, 0.5)).unwrap(), DVec3::new(1.0, -1.0, 1.0));
    let pin = part(Shape::cylinder(0.0025, 0.005).unwrap(), DVec3::new(-0.5, 1.5, -1.0));
    let shape = Shape::compound(vec![brick, spike, block, ball, pin]).unwrap();
    // Equally high, so that a zero of the normal has the same sign in both orders; or at one place.
    let places = [DVec3::new(0.5, 0.5, -1.0), DVec3::new(0.0, -0.5, -1.0)];
    for k in 0..60u8 {
        let angle = [1e-6, 1e-3, 1.0][usize::from(k) % 3];
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7) * f64::from(k));
        let other = DQuat::from_scaled_axis(DVec3::new(1.0, 0.2, 0.5) * angle) * turn;
        let object =
            |turn: DQuat, place| Object::new(0, Pose::new(turn.normalize(), place).unwrap());
        let objects = [object(turn, places[0]), object(other, places[usize::from(k % 2)])];
        let scenes = in_both_orders(vec![shape.clone()], objects.to_vec());
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            are_mirrored(&scenes, accuracy, &format!("{k} {accuracy:?}"));
        }
    }
}

#[test]
fn shapes_of_the_same_vertices_are_mirrored_whatever_they_are_called() {
    let hull_of = |shape: &Shape| {
        let polytope = shape.as_polytope().unwrap();
        let hull = Shape::hull(polytope.vertices().to_vec()).unwrap();
        hull.swept(polytope.swept_radius()).unwrap()
    };
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.8, 0.1)];
    let [ends @ .., _] = corners;
    let shapes = [
        Shape::cuboid(DVec3::new(0.5, 0.4, 0.3)),
        Shape::from(Polytope::segment(ends[0], ends[1]).unwrap()).swept(0.2),
        Shape::triangle(corners),
        Shape::sphere(0.4),
    ];
    let named = shapes.map(|shape| shape.unwrap());
    let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -1.1, 0.7));
    let pose = Pose::new(turn.normalize(), DVec3::new(1.0, 2.0, 3.0)).unwrap();
    let objects = vec![Object::new(0, pose), Object::new(1, pose)];
    for (shape, accuracy) in named.iter().flat_map(|shape| ACCURACIES.map(|at| (shape, at))) {
        let scenes = in_both_orders(vec![shape.clone(), hull_of(shape)], objects.clone());
        are_mirrored(&scenes, accuracy, &format!("{shape:?} {accuracy:?}"));
    }
    // Of curved shapes without a radius a scene does not decide that they touch.
    let rods = [Shape::cylinder(0.4, 0.0), Shape::cone(0.4, 0.0)].map(Result::unwrap);
    let scenes = in_both_orders(rods.to_vec(), objects);
    for accuracy in ACCURACIES {
        are_mirrored_alone(&scenes, accuracy, &format!("rods {accuracy:?}"));
    }
}

fn are_mirrored_alone(scenes: &[Scene; 2], accuracy: Accuracy, said: &str) {
    let depth = |scene| alone(accuracy, scene, all_pairs(2).into_iter())[0].answer;
    let [one, other] = scenes.each_ref().map(depth);
    assert_eq!(one.normal, -other.normal, "{said}");
    assert_eq!((one.point_a, one.point_b), (other.point_b, other.point_a), "{said}");
}

/// Whether two objects are as deep in each other as the other way round, in scenes in both orders and by themselves.
fn are_mirrored(scenes: &[Scene; 2], accuracy: Accuracy, said: &str) {
    let depths = SimdDepths::new(Depths, accuracy);
    let in_lanes = scenes.each_ref().map(|scene| found(&depths, scene, &all_pairs(2)).0[0].answer);
    let [one, other] = in_lanes;
    assert_eq!(one.normal, -other.normal, "{said}");
    assert_eq!((one.point_a, one.point_b), (other.point_b, other.point_a), "{said}");
    are_mirrored_alone(scenes, accuracy, said);
    let [one, other] = scenes.each_ref().map(|scene| manifolds(scene, accuracy));
    for (one, other) in one.iter().zip(&other) {
        assert_eq!(one.len(), other.len(), "{said}");
        for (one, other) in one.iter().zip(other.iter()) {
            assert_eq!(one.normal, -other.normal, "{said}");
            for (one, other) in one.points().iter().zip(other.points()) {
                assert_eq!((one.point_a, one.point_b), (other.point_b, other.point_a), "{said}");
            }
        }
    }
}
