//! The signed distance and its derivatives.

use super::scenes::{Draw, pile, shapes};
use super::{PosedSupport, answer_of, solve};
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Pose, Shape};
use dcd_gjk::query::{Smoothness, Twist};
use dcd_gjk::{Depths, Pairwise, Proximities, ThenMeasure, Verdict, contract};

fn proximities() -> Proximities {
    Proximities::within(10.0).unwrap()
}

#[test]
fn proximities_keep_the_contract_one_by_one_and_after_the_lanes() {
    let (scene, pairs) = pile(shapes(), 40);
    for margin in [0.0, 0.5] {
        let solver = Proximities::within(margin).unwrap();
        contract::narrow_phase(&Pairwise(solver), &scene, &pairs).unwrap();
        contract::narrow_phase(&ThenMeasure::new(solver).unwrap(), &scene, &pairs).unwrap();
    }
}

/// Moves by a small translation and a small rotation about its own origin, world axes.
fn moved(body: &PosedSupport, translation: DVec3, rotation: DVec3) -> PosedSupport {
    let turn = match rotation.try_normalize() {
        Some(axis) => DMat3::from_axis_angle(axis, rotation.length()),
        None => DMat3::IDENTITY,
    };
    let place = body.pose.translation() + translation;
    let pose = Pose::from_matrix(turn * *body.pose.rotation(), place).unwrap();
    PosedSupport { shape: body.shape.clone(), pose }
}

/// The derivative by central differences, of steps that balance rounding and curvature.
fn differences(a: &PosedSupport, b: &PosedSupport, moves_a: bool) -> Twist {
    let step = 1e-6;
    let along = |translation: DVec3, rotation: DVec3| {
        let at = |sign: f64| {
            let (t, r) = (translation * sign * step, rotation * sign * step);
            let (a, b) =
                if moves_a { (moved(a, t, r), b.clone()) } else { (a.clone(), moved(b, t, r)) };
            answer_of(&proximities(), &a, &b).signed_distance
        };
        (at(1.0) - at(-1.0)) / (2.0 * step)
    };
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    Twist {
        translation: DVec3::from_array(axes.map(|axis| along(axis, DVec3::ZERO))),
        rotation: DVec3::from_array(axes.map(|axis| along(DVec3::ZERO, axis))),
    }
}

#[test]
fn derivatives_agree_with_central_differences_apart_and_overlapping() {
    let mut draw = Draw(21);
    let mut shapes = shapes();
    shapes.pop();
    let (mut apart, mut overlapping) = (0, 0);
    for k in 0..300usize {
        let mut body = |k: usize, reach: f64| {
            PosedSupport::new(shapes[k % shapes.len()].clone(), draw.turn(), draw.vector() * reach)
        };
        let reach = if k % 2 == 0 { 1.5 } else { 0.4 };
        let (a, b) = (body(k, reach), body(k / 5, reach));
        let found = answer_of(&proximities(), &a, &b);
        if found.smoothness != Smoothness::Smooth {
            // Spheres at one place, plates that overlap: the like is rare among turned shapes.
            continue;
        }
        for (gradient, moves_a) in [(found.gradient.a, true), (found.gradient.b, false)] {
            let measured = differences(&a, &b, moves_a);
            let off = (gradient.translation - measured.translation).length()
                + (gradient.rotation - measured.rotation).length();
            assert!(off < 1e-4, "{k} {off}\n{found:?}\n{measured:?}\n{a:?}\n{b:?}");
        }
        if found.signed_distance > 0.0 { apart += 1 } else { overlapping += 1 }
    }
    assert!(apart > 60 && overlapping > 60, "{apart} {overlapping}");
}

#[test]
fn the_signed_distance_is_the_distance_or_less_the_depth() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let a = PosedSupport::at(&cube, DVec3::ZERO);
    for (x, expected) in [(1.5, 0.5), (1.0, 0.0), (0.75, -0.25)] {
        let b = PosedSupport::new(cube.clone(), DQuat::from_rotation_x(0.3), DVec3::X * x);
        let found = answer_of(&proximities(), &a, &b);
        let off = (found.signed_distance - expected).abs();
        assert!(off <= found.error_bound && found.error_bound < 1e-9, "{found:?}");
        assert!((found.normal - DVec3::X).length() < 1e-12);
        if let Verdict::Touching(depth) = solve(&Depths, &a, &b) {
            assert_eq!(found.signed_distance, -depth.depth);
        }
    }
}

#[test]
fn kinks_are_marked() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let a = PosedSupport::at(&cube, DVec3::ZERO);
    let smoothness = |turn: DQuat, place: DVec3| {
        answer_of(&proximities(), &a, &PosedSupport::new(cube.clone(), turn, place)).smoothness
    };
    let (flat, skew) = (DQuat::IDENTITY, DQuat::from_euler(Default::default(), 0.3, 0.2, 0.1));
    // Face above face, apart and overlapping.
    assert_eq!(smoothness(flat, DVec3::new(1.5, 0.1, 0.2)), Smoothness::ManyPoints);
    assert_eq!(smoothness(flat, DVec3::new(0.9, 0.1, 0.2)), Smoothness::ManyPoints);
    // Parallel edges, one beside the other.
    assert_eq!(smoothness(flat, DVec3::new(1.5, 1.5, 0.2)), Smoothness::ManyPoints);
    // Two and six equally good ways out.
    assert_eq!(smoothness(flat, DVec3::new(0.9, 0.9, 0.2)), Smoothness::ManyDirections);
    assert_eq!(smoothness(skew, DVec3::ZERO), Smoothness::ManyDirections);
    assert_eq!(smoothness(flat, DVec3::ZERO), Smoothness::ManyDirections);
    // Vertex to vertex: touching is a kink, a gap is none.
    assert_eq!(smoothness(flat, DVec3::ONE), Smoothness::ManyDirections);
    assert_eq!(smoothness(flat, DVec3::splat(1.5)), Smoothness::Smooth);
    // A turned cube's vertex in a face, and before it.
    assert_eq!(smoothness(skew, DVec3::new(1.05, 0.0, 0.0)), Smoothness::Smooth);
    assert_eq!(smoothness(skew, DVec3::new(1.5, 0.0, 0.0)), Smoothness::Smooth);
}

#[test]
fn directions_within_a_billionth_of_the_whole_depth_are_never_called_smooth() {
    let mark = |a: &Shape, b: &Shape, at: DVec3| {
        answer_of(&proximities(), &PosedSupport::at(a, DVec3::ZERO), &PosedSupport::at(b, at))
            .smoothness
    };
    // A sphere whose centre is beside a plate: the other way out is longer by 4e-11 of the depth.
    let plate = Shape::cuboid(DVec3::new(2.0, 0.0, 3.0)).unwrap();
    let sphere = Shape::sphere(3.0).unwrap();
    for (off, smoothness) in [
        (5.8e-11, Smoothness::ManyDirections),
        (1e-9, Smoothness::ManyDirections),
        (1e-8, Smoothness::Smooth),
    ] {
        assert_eq!(mark(&plate, &sphere, DVec3::Y * off), smoothness, "{off}");
        assert_eq!(mark(&sphere, &plate, DVec3::Y * off), smoothness, "{off}");
    }
    // A sphere whose centre is inside of a cube, beside an edge: two faces.
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let sphere = Shape::sphere(1.0).unwrap();
    let inside = |x: f64, y: f64| mark(&cube, &sphere, DVec3::new(0.5 - x, 0.5 - y, 0.1));
    assert_eq!(inside(1e-10, 2e-10), Smoothness::ManyDirections);
    assert_eq!(inside(1e-10, 1e-8), Smoothness::Smooth);
    // The same outside: before a face there is one way, beside an edge or a corner another nearby.
    assert_eq!(inside(-1e-10, 0.3), Smoothness::Smooth);
    assert_eq!(inside(-1e-10, 2e-10), Smoothness::ManyDirections);
    assert_eq!(inside(-1e-10, -1e-10), Smoothness::ManyDirections);
    assert_eq!(inside(-1e-8, -1e-8), Smoothness::Smooth);
    // A point beside a point, and corners that barely miss each other.
    assert_eq!(mark(&sphere, &sphere, DVec3::X * 1e-9), Smoothness::ManyDirections);
    assert_eq!(mark(&sphere, &sphere, DVec3::X * 1e-8), Smoothness::Smooth);
    assert_eq!(mark(&cube, &cube, DVec3::splat(1.0 + 1e-14)), Smoothness::ManyDirections);
    assert_eq!(mark(&cube, &cube, DVec3::splat(1.0 + 1e-9)), Smoothness::Smooth);
}

#[test]
fn concentric_spheres_are_a_kink_and_others_are_smooth() {
    let sphere = Shape::sphere(0.5).unwrap();
    let a = PosedSupport::at(&sphere, DVec3::ZERO);
    let at = |place: DVec3| answer_of(&proximities(), &a, &PosedSupport::at(&sphere, place));
    assert_eq!(at(DVec3::ZERO).smoothness, Smoothness::ManyDirections);
    for x in [0.2, 1.0, 3.0] {
        let found = at(DVec3::new(x, 0.0, 0.0));
        assert_eq!(found.smoothness, Smoothness::Smooth);
        assert_eq!(found.gradient.b, Twist { translation: DVec3::X, rotation: DVec3::ZERO });
        assert!((found.signed_distance - (x - 1.0)).abs() <= found.error_bound);
    }
}

#[test]
fn a_foreign_shape_has_a_gradient_and_no_promise() {
    let foreign = shapes().pop().unwrap();
    let (a, b) =
        (PosedSupport::at(&foreign, DVec3::ZERO), PosedSupport::at(&foreign, DVec3::X * 2.0));
    let found = answer_of(&proximities(), &a, &b);
    assert_eq!((found.smoothness, found.normal), (Smoothness::Unknown, DVec3::X));
}

#[test]
fn a_vertex_above_a_floor_or_in_it_is_smooth_and_a_face_is_not() {
    let floor = PosedSupport::at(&Shape::half_space(DVec3::Z, 0.0).unwrap(), DVec3::ZERO);
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let skew = DQuat::from_euler(Default::default(), 0.3, 0.2, 0.1);
    for (z, turn, smoothness) in [
        (2.0, skew, Smoothness::Smooth),
        (0.3, skew, Smoothness::Smooth),
        (2.0, DQuat::IDENTITY, Smoothness::ManyPoints),
    ] {
        let b = PosedSupport::new(cube.clone(), turn, DVec3::Z * z);
        let found = answer_of(&proximities(), &floor, &b);
        assert_eq!((found.smoothness, found.normal), (smoothness, DVec3::Z));
        if smoothness == Smoothness::Smooth {
            let measured = differences(&floor, &b, false);
            assert!((found.gradient.b.rotation - measured.rotation).length() < 1e-6);
        }
    }
}
