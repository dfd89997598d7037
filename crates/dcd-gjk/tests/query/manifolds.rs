//! Where touching pairs touch.

use super::scenes::{Draw, pile, shapes};
use super::{PosedSupport, answer_of, solve};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Polytope, Pose, Shape, SupportMap};
use dcd_gjk::query::Feature;
use dcd_gjk::{
    Depths, DistanceResult, Manifold, Manifolds, PairSolver, Pairwise, PosedShape,
    PosedSupport as Core, ThenMeasure, Verdict, contract, distance,
};

#[test]
fn manifolds_keep_the_contract_one_by_one_and_after_the_lanes() {
    let (scene, pairs) = pile(shapes(), 40);
    contract::narrow_phase(&Pairwise(Manifolds::default()), &scene, &pairs).unwrap();
    contract::narrow_phase(&ThenMeasure::new(Manifolds::default()).unwrap(), &scene, &pairs)
        .unwrap();
}

/// The only manifold of two that touch.
fn one(a: &PosedSupport, b: &PosedSupport) -> Manifold {
    let found = answer_of(&Manifolds::default(), a, b);
    let [manifold] = found[..] else { panic!("{found:?}\n{a:?}\n{b:?}") };
    manifold
}

/// How far a point is from a body: by the distance of a sphere of radius 0, another method.
fn outside(point: DVec3, body: &PosedSupport) -> f64 {
    let sphere = Polytope::sphere(0.0).unwrap();
    let pose = Pose::from_translation(point).unwrap();
    let polytope = body.shape.as_polytope().unwrap();
    let (sphere, body) = (Core::polytope(&sphere, &pose), Core::polytope(polytope, &body.pose));
    match distance::of_polytopes(sphere, body).0 {
        DistanceResult::Apart(found) => found.distance,
        _ => 0.0,
    }
}

/// Judges a manifold by the distance of its points from the bodies and by the depth.
fn judge(found: &Manifold, a: &PosedSupport, b: &PosedSupport) {
    let depth = answer_of(&Depths, a, b);
    let bound = found.error_bound;
    let points = found.points();
    assert!((1..=4).contains(&points.len()), "{found:?}");
    assert_eq!(found.normal, depth.normal);
    assert_eq!(points[0].depth, depth.depth, "the deepest first: {found:?}");
    // What leans by up to 15 degrees is that part of the radius below the surface.
    let leaning = 0.0341 * a.shape.radius().max(b.shape.radius());
    assert!(bound <= depth.error_bound + 1e-7 + leaning, "{bound}");
    for point in points {
        assert!(outside(point.point_a, a) <= bound, "{point:?} {bound}\n{a:?}\n{b:?}");
        assert!(outside(point.point_b, b) <= bound, "{point:?} {bound}\n{a:?}\n{b:?}");
        assert!((0.0..=depth.depth).contains(&point.depth), "{found:?}");
        let between = point.point_a - point.point_b - found.normal * point.depth;
        assert!(between.length() <= bound, "{between} {found:?}\n{a:?}\n{b:?}");
    }
}

#[test]
fn points_lie_in_their_shapes_and_the_deepest_is_as_deep_as_the_pair() {
    let mut draw = Draw(31);
    let mut shapes = shapes();
    shapes.pop();
    let mut touching = [0; 5];
    for k in 0..1500usize {
        // A third not turned, a third hardly turned: faces flat on faces, and nearly.
        let mut body = |k: usize| {
            let turn = match k % 3 {
                0 => DQuat::IDENTITY,
                1 => DQuat::from_scaled_axis(draw.vector() * 0.02),
                _ => draw.turn(),
            };
            let place = draw.vector() * 0.6;
            let place = if k.is_multiple_of(2) { (place * 10.0).round() / 10.0 } else { place };
            PosedSupport::new(shapes[k % shapes.len()].clone(), turn, place)
        };
        let (a, b) = (body(k), body(k / 5));
        if let Verdict::Touching(found) = solve(&Manifolds::default(), &a, &b) {
            let [found] = found[..] else { panic!("{found:?}") };
            judge(&found, &a, &b);
            touching[found.points().len()] += 1;
        }
    }
    assert!(touching[1..].iter().all(|&count| count > 20), "{touching:?}");
}

#[test]
fn stacked_faces_touch_in_the_corners_of_what_they_share() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let place = DVec3::new(1e6, 0.0, 0.0);
    for (gap, moved) in
        [(0.0, DVec3::ZERO), (0.125, DVec3::ZERO), (0.0, DVec3::new(0.25, 0.5, 0.0))]
    {
        let a = PosedSupport::at(&cube, place);
        let b = PosedSupport::at(&cube, place + moved + DVec3::Z * (1.0 - gap));
        let found = one(&a, &b);
        judge(&found, &a, &b);
        assert_eq!((found.normal, found.points().len()), (DVec3::Z, 4));
        let at = |k: usize| found.points()[k].point_a - place;
        let low = (0..4).map(at).fold(DVec3::INFINITY, DVec3::min);
        let high = (0..4).map(at).fold(DVec3::NEG_INFINITY, DVec3::max);
        let shared = (moved - DVec3::new(0.5, 0.5, -0.5), DVec3::splat(0.5));
        assert!(low.distance(shared.0.with_z(0.5)) < 1e-9 && high.distance(shared.1) < 1e-9);
        assert!(found.points().iter().all(|point| (point.depth - gap).abs() < 1e-9));
    }
}

#[test]
fn a_box_rocked_a_little_touches_along_its_edge_and_where_it_leaves_the_face() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let a = PosedSupport::at(&Shape::cuboid(DVec3::new(2.0, 2.0, 0.5)).unwrap(), DVec3::ZERO);
    let b = PosedSupport::new(cube, DQuat::from_rotation_y(0.01), DVec3::Z * 1.0);
    let found = one(&a, &b);
    judge(&found, &a, &b);
    let depths: Vec<f64> = found.points().iter().map(|point| point.depth).collect();
    assert_eq!(depths.len(), 4, "{found:?}");
    assert!((depths[0] - depths[1].max(depths[2]).max(depths[3])).abs() < 1e-12);
    assert_eq!(depths.iter().filter(|&&depth| depth < 1e-12).count(), 2, "{depths:?}");
}

#[test]
fn crossing_edges_touch_in_one_point_and_parallel_capsules_in_two() {
    let beam = Shape::cuboid(DVec3::new(2.0, 0.5, 0.5)).unwrap();
    let rolled = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_4);
    let across = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2) * rolled;
    let height = DVec3::Z * (2f64.sqrt() - 0.01);
    let a = PosedSupport::new(beam.clone(), rolled, DVec3::ZERO);
    let b = PosedSupport::new(beam, across, height);
    let found = one(&a, &b);
    judge(&found, &a, &b);
    assert_eq!(found.points().len(), 1);
    assert!(matches!(found.points()[0].features, [Feature::Edge(..), Feature::Edge(..)]));
    let capsule = Shape::capsule(2.0, 0.5).unwrap();
    for turn in [DQuat::IDENTITY, rolled] {
        let a = PosedSupport::new(capsule.clone(), turn, DVec3::ZERO);
        let b = PosedSupport::new(capsule.clone(), turn, turn * DVec3::new(0.9, 0.0, 1.0));
        let found = one(&a, &b);
        judge(&found, &a, &b);
        let points = found.points();
        assert_eq!(points.len(), 2, "{found:?}");
        assert!((points[0].point_a.distance(points[1].point_a) - 3.0).abs() < 1e-9, "{found:?}");
    }
}

#[test]
fn points_segments_and_identical_shapes_have_their_manifolds() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let point = Shape::sphere(0.0).unwrap();
    let needle = Shape::segment(DVec3::NEG_X * 0.25, DVec3::X * 0.25).unwrap();
    let capsule = Shape::capsule(0.25, 0.1).unwrap();
    let sphere = Shape::sphere(0.5).unwrap();
    let flat = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let top = |height: f64| DVec3::Z * (0.5 + height);
    for (b, count) in [
        (PosedSupport::at(&point, top(-0.1)), 1),
        (PosedSupport::at(&needle, top(-0.1)), 2),
        (PosedSupport::at(&needle, top(0.0)), 2),
        (PosedSupport::new(capsule.clone(), flat, top(0.05)), 2),
        (PosedSupport::at(&capsule, top(0.3)), 1),
        (PosedSupport::at(&sphere, top(0.4)), 1),
        (PosedSupport::at(&cube, DVec3::ZERO), 4),
    ] {
        let a = PosedSupport::at(&cube, DVec3::ZERO);
        let found = one(&a, &b);
        judge(&found, &a, &b);
        assert_eq!(found.points().len(), count, "{b:?} {found:?}");
    }
    for shape in [&point, &needle, &sphere] {
        let body = PosedSupport::at(shape, DVec3::ONE);
        judge(&one(&body, &body), &body, &body);
    }
}

#[test]
fn a_swapped_pair_has_the_mirrored_manifold_bit_for_bit() {
    let mut draw = Draw(32);
    let shapes = shapes();
    let mut touching = 0;
    for k in 0..300usize {
        let mut body = |k: usize| {
            let turn = if k.is_multiple_of(2) { DQuat::IDENTITY } else { draw.turn() };
            PosedSupport::new(shapes[k % shapes.len()].clone(), turn, draw.vector() * 0.5)
        };
        let (a, b) = (body(k), body(k / 6));
        let (Verdict::Touching(ab), Verdict::Touching(ba)) =
            (solve(&Manifolds::default(), &a, &b), solve(&Manifolds::default(), &b, &a))
        else {
            continue;
        };
        touching += 1;
        let ([ab], [ba]) = (&ab[..], &ba[..]) else { panic!("{ab:?} {ba:?}") };
        assert_eq!((ab.normal, ab.points().len()), (-ba.normal, ba.points().len()));
        for (p, q) in ab.points().iter().zip(ba.points()) {
            assert_eq!((p.point_a, p.point_b, p.depth), (q.point_b, q.point_a, q.depth));
            assert_eq!(p.features, [q.features[1], q.features[0]]);
        }
    }
    assert!(touching > 150, "{touching}");
}

#[test]
fn features_stay_as_a_box_slides() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let a = PosedSupport::at(&Shape::cuboid(DVec3::new(3.0, 3.0, 0.5)).unwrap(), DVec3::ZERO);
    let turn = DQuat::from_rotation_z(0.2);
    let at = |x: f64| one(&a, &PosedSupport::new(cube.clone(), turn, DVec3::new(x, 0.1, 0.99)));
    let features = |found: Manifold| {
        let mut features: Vec<_> = found.points().iter().map(|point| point.features).collect();
        features.sort();
        features
    };
    assert_eq!(features(at(0.0)), features(at(0.3)));
    assert!(features(at(0.0)).iter().all(|f| matches!(f, [Feature::Face(_), Feature::Vertex(_)])));
}

/// A floor of triangles at height 0, 0.5 wide each, larger than what stands on it.
fn floor() -> Shape {
    let side = 9;
    let vertex =
        |i: u32, j: u32| DVec3::new(f64::from(i) * 0.5 - 2.0, f64::from(j) * 0.5 - 2.0, 0.0);
    let vertices = (0..side).flat_map(|i| (0..side).map(move |j| vertex(i, j))).collect();
    let triangles = (0..side - 1).flat_map(|i| {
        (0..side - 1).flat_map(move |j| {
            let [a, b, c, d] =
                [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| i * side + j);
            [[a, b, c], [a, c, d]]
        })
    });
    Shape::mesh(vertices, triangles.collect()).unwrap()
}

/// What a shape can rest on at height 0, with its place.
pub(super) fn grounds() -> Vec<(&'static str, PosedSupport)> {
    let half = DVec3::new(1.0, 1.0, 0.5);
    let tile = Shape::cuboid(half).unwrap();
    let at = |x: f64, y: f64| Pose::from_translation(DVec3::new(x, y, -0.5)).unwrap();
    let tiles = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let tiles = tiles.map(|(x, y)| (tile.clone(), at(x, y))).to_vec();
    let plane = Shape::half_space(DVec3::Z, 0.0).unwrap();
    vec![
        ("cuboid", PosedSupport::at(&Shape::cuboid(DVec3::splat(2.0)).unwrap(), DVec3::Z * -2.0)),
        ("half-space", PosedSupport::at(&plane, DVec3::ZERO)),
        ("mesh", PosedSupport::at(&floor(), DVec3::ZERO)),
        ("compound", PosedSupport::at(&Shape::compound(tiles).unwrap(), DVec3::ZERO)),
    ]
}

#[test]
fn whatever_rests_on_a_face_or_a_line_has_four_points_or_two_on_every_ground() {
    let turned = DQuat::from_rotation_z(0.3);
    let lying = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let cube = Shape::cuboid(DVec3::splat(0.4)).unwrap();
    let bodies = [
        ("box", cube.clone(), turned, 0.4, 4),
        ("rounded box", cube.swept(0.1).unwrap(), turned, 0.5, 4),
        ("capsule", Shape::capsule(0.4, 0.2).unwrap(), lying, 0.2, 2),
        ("cylinder", Shape::cylinder(0.3, 0.4).unwrap(), turned, 0.3, 4),
        ("lying cylinder", Shape::cylinder(0.3, 0.4).unwrap(), lying, 0.4, 2),
        ("cone", Shape::cone(0.3, 0.4).unwrap(), turned, 0.3, 4),
        ("sphere", Shape::sphere(0.4).unwrap(), turned, 0.4, 1),
    ];
    for (ground_name, ground) in grounds() {
        for (name, shape, turn, height, count) in &bodies {
            for deep in [0.01, 1e-4] {
                let what = format!("{name} on {ground_name}, {deep}");
                let place = DVec3::new(0.1, 0.05, height - deep);
                let body = PosedSupport::new(shape.clone(), *turn, place);
                let found = one(&ground, &body);
                assert!(found.normal.distance(DVec3::Z) < 1e-9, "{what}: {found:?}");
                let points = found.points();
                assert_eq!(points.len(), *count, "{what}: {found:?}");
                let mut middle = DVec3::ZERO;
                for point in points {
                    assert!((point.depth - deep).abs() < 1e-7, "{what}: {found:?}");
                    assert!(point.point_a.z.abs() < 1e-7, "{what}: {found:?}");
                    assert!((point.point_b.z + deep).abs() < 1e-7, "{what}: {found:?}");
                    middle += point.point_a / points.len() as f64;
                }
                // What it rests on is round its middle: it stands.
                assert!(middle.truncate().distance(place.truncate()) < 0.15, "{what}: {found:?}");
                let back = one(&body, &ground);
                assert_eq!((back.normal, back.points().len()), (-found.normal, *count), "{what}");
                let is_made_of_parts = matches!(ground_name, "mesh" | "compound");
                assert_eq!(found.parts[0].is_some(), is_made_of_parts, "{what}");
                assert_eq!((found.parts[1], back.parts[1]), (None, found.parts[0]), "{what}");
            }
        }
    }
}

#[test]
fn a_plane_given_by_a_long_normal_has_the_bound_of_any_plane() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let above = Pose::from_translation(DVec3::Z * 1.49).unwrap();
    let bounds = [1.0, 1e12].map(|length| {
        let plane = Shape::half_space(DVec3::Z * length, length).unwrap();
        let sides = (
            PosedShape { shape: &cube, pose: &above },
            PosedShape { shape: &plane, pose: &Pose::IDENTITY },
        );
        let found = Manifolds::default().solve(sides.0, sides.1, &mut Default::default());
        let Verdict::Touching(set) = found else { panic!("{found:?}") };
        set.iter().map(|manifold| manifold.error_bound).fold(0.0, f64::max)
    });
    assert!(bounds[1] < 1e-7 && bounds[1] < 2.0 * bounds[0] + 1e-12, "{bounds:?}");
}

#[test]
fn the_corners_of_an_upright_cylinder_stay_where_they_are_when_rounding_tilts_it() {
    let (cylinder, floor) =
        (Shape::cylinder(0.5, 1.0).unwrap(), Shape::half_space(DVec3::Z, 0.0).unwrap());
    let mut places: Vec<(Feature, DVec3)> = Vec::new();
    let mut known_again = 0;
    for k in 0..40 {
        let tilt = 1e-16 * f64::from(k % 7);
        let turn = DQuat::from_rotation_z(f64::from(k)) * DQuat::from_rotation_x(tilt);
        let turn = (turn * DQuat::from_rotation_z(-f64::from(k))).normalize();
        let pose = Pose::new(turn, DVec3::Z * 0.499).unwrap();
        let sides = (
            PosedShape { shape: &cylinder, pose: &pose },
            PosedShape { shape: &floor, pose: &Pose::IDENTITY },
        );
        let found = Manifolds::default().solve(sides.0, sides.1, &mut Default::default());
        let Verdict::Touching(set) = found else { panic!("{found:?}") };
        for point in set.iter().flat_map(|manifold| manifold.points()) {
            let feature = point.features[0];
            match places.iter().find(|(known, _)| *known == feature) {
                Some((_, place)) => {
                    assert!(place.distance(point.point_a) < 1e-9, "{k}: {feature:?} {place}");
                    known_again += 1;
                }
                None => places.push((feature, point.point_a)),
            }
        }
    }
    assert!(known_again > 100 && places.len() <= 8, "{known_again}");
}
