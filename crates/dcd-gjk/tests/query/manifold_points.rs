//! What every manifold says of its points, for every two kinds of shape, at round poses and at random ones: each point is of
//! its own surface, and as deep as the manifold says.

use super::PosedSupport;
use super::patches::{grid, off_surface};
use super::scenes::Draw;
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Pose, Shape};
use dcd_gjk::query::{Feature, MeasureAt};
use dcd_gjk::{Accuracy, Depths, Manifold, Manifolds, PosedShape, SimdDepths, Verdict, certified};
use dcd_pipeline::prelude::{Par, Pipeline, Scene, WideTree};

/// What f64 loses of the judge's own coordinates, metres.
pub(super) const ROUNDING: f64 = 1e-9;

pub(super) const ACCURACIES: [Accuracy; 3] = [Accuracy::F32, Accuracy::F64, Accuracy::Certified];

/// Lengths that meet each other in many ways, or any.
fn lengths(draw: &mut Draw, round: bool) -> DVec3 {
    let mut length = || match round {
        true => [0.125, 0.25, 0.5, 1.0][(draw.unit().abs() * 4.0) as usize],
        false => 0.02 + 0.7 * draw.unit().abs(),
    };
    DVec3::new(length(), length(), length())
}

/// A place on a grid of quarters, or any.
pub(super) fn place(draw: &mut Draw, round: bool) -> DVec3 {
    let v = draw.vector();
    if round { (v * 4.0).round() / 4.0 } else { v }
}

/// Axes exchanged, turned by next to nothing, or any.
pub(super) fn turn(draw: &mut Draw, round: bool) -> DMat3 {
    let any = place(draw, false);
    match (round, (draw.unit().abs() * 4.0) as usize) {
        (true, 0) => DMat3::IDENTITY,
        (true, 1) => DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
        (true, 2) => DMat3::from_cols(DVec3::Z, -DVec3::Y, DVec3::X),
        (true, _) => DMat3::from_quat(DQuat::from_scaled_axis(any * 1e-7)),
        (false, _) => DMat3::from_quat(DQuat::from_scaled_axis(any * 3.0)),
    }
}

pub(super) fn convex(draw: &mut Draw, kind: usize, round: bool) -> Shape {
    let half = lengths(draw, round);
    match kind {
        0 => Shape::sphere(half.x),
        1 => Shape::capsule(half.x, half.y),
        2 => Shape::cuboid(half),
        3 => Shape::cuboid(half).and_then(|cuboid| cuboid.rounded(0.05)),
        4 => Shape::cylinder(half.x, half.y),
        5 => Shape::cone(half.x, half.y),
        6 => Shape::cylinder(half.x, half.y).and_then(|cylinder| cylinder.rounded(0.03)),
        // Twelve points of a small grid may be flat.
        7 => Shape::hull((0..12).map(|_| place(draw, round) * half).collect())
            .or_else(|_| Shape::cuboid(half)),
        // Without a needle: its corners are half the lengths and more from each other.
        _ => Shape::triangle([DVec3::ZERO, DVec3::X * half, DVec3::new(0.1, 0.2 * half.y, half.z)]),
    }
    .unwrap()
}

pub(super) const CONVEX: usize = 9;

pub(super) fn shape(draw: &mut Draw, kind: usize, round: bool) -> Shape {
    match kind {
        CONVEX => Shape::half_space([DVec3::Z, DVec3::X][usize::from(round)], 0.0).unwrap(),
        10 => {
            let wave = if round { 0.0 } else { 0.3 * draw.unit().abs() };
            let at = |x: f64, y: f64| {
                let [x, y] = [x, y].map(|k| k / 4.0 - 0.5);
                DVec3::new(x, y, wave * (3.0 * x).sin() * (4.0 * y).cos())
            };
            let (vertices, triangles) = grid(4, at);
            Shape::mesh(vertices, triangles).unwrap()
        }
        11 => {
            let part = |draw: &mut Draw| {
                let kind = (draw.unit().abs() * CONVEX as f64) as usize;
                let at = place(draw, round) * 0.4;
                (convex(draw, kind, round), Pose::from_matrix(turn(draw, round), at).unwrap())
            };
            let count = 1 + (draw.unit().abs() * 4.0) as usize;
            Shape::compound((0..count).map(|_| part(draw)).collect()).unwrap()
        }
        kind => convex(draw, kind, round),
    }
}

/// A cylinder's rim and a tiny ball may be undecided, which blames no point.
pub(super) fn verdict(a: PosedShape<'_>, b: PosedShape<'_>) -> Verdict<()> {
    certified::overlap_of(a, b).0
}

pub(super) fn judge(found: &Manifold, sides: [PosedShape<'_>; 2], (rounding, what): (f64, &str)) {
    let bound = found.error_bound;
    for point in found.points() {
        for (side, at) in sides.into_iter().zip([point.point_a, point.point_b]) {
            let ball = Shape::sphere(bound + rounding).unwrap();
            let pose = Pose::from_translation(at).unwrap();
            let ball = PosedShape { shape: &ball, pose: &pose };
            let is_off = verdict(side, ball) == Verdict::Apart;
            assert!(!is_off, "{what}: {point:?} is off its surface by over {bound}");
        }
        assert!(point.depth >= 0.0, "{what}: {point:?}");
        let along = (point.point_a - point.point_b).dot(found.normal) - point.depth;
        assert!(along.abs() <= bound + rounding, "{what}: {point:?} by {along}, not {bound}");
    }
}

/// Whether the deepest point is as deep along the normal as two convex shapes are: moved by so much they part, by less
/// they do not.
pub(super) fn judge_depth(
    found: &Manifold,
    [a, b]: [PosedShape<'_>; 2],
    (rounding, what): (f64, &str),
) {
    let depth = found.points().iter().map(|point| point.depth).fold(0.0, f64::max);
    let unsure = found.error_bound + rounding;
    let moved_by = |way: f64| {
        let place = b.pose.translation() + found.normal * way;
        let pose = Pose::from_matrix(*b.pose.rotation(), place).unwrap();
        verdict(a, PosedShape { pose: &pose, ..b })
    };
    let is_deeper = moved_by(depth + unsure) == Verdict::Touching(());
    assert!(!is_deeper, "{what}: deeper than {found:?}");
    let is_shallower = depth > unsure && moved_by(depth - unsure) == Verdict::Apart;
    assert!(!is_shallower, "{what}: not as deep as {found:?}");
}

/// How little a face that a manifold names may look along its normal: 15 degrees and what f32 loses.
const FACING: f64 = 0.965;

/// Whether every face that a manifold of polytopes names looks along its normal, as the shape's own list of faces has it. How
/// many do.
fn judge_faces(found: &Manifold, sides: [PosedShape<'_>; 2], what: &str) -> usize {
    let mut judged = 0;
    for point in found.points() {
        for ((side, feature), sense) in sides.iter().zip(point.features).zip([1.0, -1.0]) {
            let (Some(polytope), Feature::Face(face)) = (side.shape.as_polytope(), feature) else {
                continue;
            };
            let normal = *side.pose.rotation() * polytope.facets().facets()[face as usize].normal;
            let cosine = normal.dot(found.normal) * sense;
            assert!(cosine > FACING, "{what}: {point:?} on a face at {cosine}");
            judged += 1;
        }
    }
    judged
}

/// The manifold at each accuracy of two shapes that touch, judged. How many.
pub(super) fn judge_all(
    [a, b]: [PosedShape<'_>; 2],
    are_convex: bool,
    (rounding, what): (f64, &str),
) -> usize {
    let mut judged = 0;
    for accuracy in ACCURACIES {
        let what = format!("{what}, {accuracy:?}");
        let found = Manifolds::default().measure_at(accuracy, a, b, &mut Default::default());
        let Verdict::Touching(found) = found else { panic!("{what}: {found:?}") };
        assert!(!found.is_empty(), "{what}");
        for manifold in found.iter() {
            judge(manifold, [a, b], (rounding, &what));
            if are_convex {
                judge_depth(manifold, [a, b], (rounding, &what));
            }
            judged += 1;
        }
    }
    judged
}

/// Whether the depths of two shapes that touch are one depth at every accuracy, to within their bounds.
pub(super) fn judge_depths([a, b]: [PosedShape<'_>; 2], (rounding, what): (f64, &str)) {
    let mut range = [f64::NEG_INFINITY, f64::INFINITY];
    for accuracy in ACCURACIES {
        let found = Depths.measure_at(accuracy, a, b, &mut Default::default());
        let Verdict::Touching(found) = found else { panic!("{what}, {accuracy:?}: {found:?}") };
        let [low, high] = [found.depth - found.error_bound, found.depth + found.error_bound];
        range = [range[0].max(low), range[1].min(high)];
        assert!(range[0] <= range[1] + rounding, "{what}, {accuracy:?}: {found:?} {range:?}");
        assert!((found.normal.length() - 1.0).abs() < 1e-9, "{what}, {accuracy:?}: {found:?}");
    }
}

#[test]
fn each_point_of_a_manifold_is_of_both_surfaces_and_as_deep_as_it_says() {
    let mut draw = Draw::seeded(19);
    let mut judged = 0;
    for k in 0..48_000usize {
        let (kinds, round) = ([k % 12, k / 12 % 12], k % 5 < 2);
        if kinds == [CONVEX; 2] {
            continue;
        }
        let [a, b] = kinds.map(|kind| {
            let (shape, at) = (shape(&mut draw, kind, round), place(&mut draw, round));
            let pose = Pose::from_matrix(turn(&mut draw, round), at).unwrap();
            PosedSupport { shape, pose }
        });
        let (a, b) = (a.placed(), b.placed());
        if verdict(a, b) != Verdict::Touching(()) {
            continue;
        }
        let are_convex = kinds.iter().all(|&kind| kind <= CONVEX);
        judged += judge_all([a, b], are_convex, (ROUNDING, &format!("{k}, kinds {kinds:?}")));
    }
    assert!(judged > 32_000, "{judged}");
}

/// Objects of all kinds close together, those of a round scene on a grid; cuboids and spheres, which lanes answer, the most.
fn crowd(draw: &mut Draw, round: bool) -> Scene {
    let mut objects: Vec<_> = (0..40usize)
        .map(|k| {
            let kind = if k < 24 { [2, 0, 7][k % 3] } else { k % 12 };
            let (shape, at) = (shape(draw, kind, round), place(draw, round) * 1.5);
            (shape, Pose::from_matrix(turn(draw, round), at).unwrap())
        })
        .collect();
    let floor = Shape::half_space(DVec3::Z, -1.0).unwrap();
    objects.push((floor, Pose::IDENTITY));
    let (shapes, poses) = objects.into_iter().unzip();
    Scene::one_each(shapes, poses).unwrap()
}

#[test]
fn so_are_the_points_of_a_scenes_manifolds_and_its_depths() {
    let mut draw = Draw::seeded(23);
    let [mut manifolds, mut depths, mut faces] = [0; 3];
    for k in 0..60usize {
        let scene = crowd(&mut draw, k % 2 == 0);
        let posed = |object: u32| PosedShape::of(&scene, object);
        let narrow = SimdDepths::new(Manifolds::default(), Accuracy::F32);
        let mut pipeline = Pipeline::with(WideTree::default(), narrow);
        for found in pipeline.step(&scene, Par::Serial).answers() {
            let (sides, what) = (
                [posed(found.pair.i), posed(found.pair.j)],
                format!("scene {k}, {:?}", found.pair),
            );
            let are_convex = sides.iter().all(|side| {
                !matches!(side.shape, Shape::Mesh(_) | Shape::Compound(_) | Shape::HalfSpace(_))
            });
            for manifold in found.answer.iter() {
                judge(manifold, sides, (ROUNDING, &what));
                if are_convex {
                    judge_depth(manifold, sides, (ROUNDING, &what));
                    faces += judge_faces(manifold, sides, &what);
                }
                manifolds += 1;
            }
        }
        // Beside the same pairs alone, as well as f64 knows them.
        let narrow = SimdDepths::new(Depths, Accuracy::F32);
        let mut pipeline = Pipeline::with(WideTree::default(), narrow);
        for found in pipeline.step(&scene, Par::Serial).answers() {
            let [a, b] = [posed(found.pair.i), posed(found.pair.j)];
            let alone = Depths.measure_at(Accuracy::Certified, a, b, &mut Default::default());
            let Verdict::Touching(alone) = alone else { panic!("{:?}: {alone:?}", found.pair) };
            let bound = found.answer.error_bound + alone.error_bound;
            let off = (found.answer.depth - alone.depth).abs();
            assert!(off <= bound + ROUNDING, "scene {k}, {:?}: {off} over {bound}", found.pair);
            depths += 1;
        }
    }
    assert!(manifolds > 4_000 && depths > 4_000 && faces > 2_000, "{manifolds} {depths} {faces}");
}

#[test]
fn points_of_balls_far_from_the_worlds_origin_are_within_their_bound() {
    let (mut draw, mut judged) = (Draw::seeded(29), 0);
    for k in 0..600usize {
        let radii = [0.5, 0.5 + draw.vector().x.abs()];
        let place = draw.vector() * [1.0, 10.0, 100.0, 1e6][k % 4];
        let centres = [place, place + draw.vector().normalize() * 0.7];
        let shapes = radii.map(|radius| Shape::sphere(radius).unwrap());
        let poses = centres.map(|centre| Pose::from_translation(centre).unwrap());
        let judge = |manifold: &Manifold, what: &str| {
            let only = manifold.points()[0];
            for (point, (centre, radius)) in
                [(only.point_a, 0), (only.point_b, 1)].map(|(p, k)| (p, (centres[k], radii[k])))
            {
                // The difference of neighbours far away loses nothing.
                let off = (point.distance(centre) - radius).abs();
                assert!(
                    off <= manifold.error_bound + 4.0 * f64::EPSILON,
                    "{k}, {what}: {off} {manifold:?}"
                );
            }
        };
        for accuracy in ACCURACIES {
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            let found = Manifolds::default().measure_at(accuracy, a, b, &mut Default::default());
            let Verdict::Touching(found) = found else { panic!("{k}") };
            judge(&found[0], "alone");
            let scene = Scene::one_each(shapes.to_vec(), poses.to_vec()).unwrap();
            let narrow = SimdDepths::new(Manifolds::default(), accuracy);
            let mut pipeline = Pipeline::with(WideTree::default(), narrow);
            for found in pipeline.step(&scene, Par::Serial).answers() {
                judge(&found.answer[0], "in a scene");
                judged += 1;
            }
        }
    }
    assert_eq!(judged, 1800);
}

#[test]
fn points_of_shapes_far_from_their_own_origin_are_within_their_bound() {
    let (mut draw, mut judged) = (Draw::seeded(31), 0);
    for k in 0..400usize {
        // Whole numbers, to which small ones are added without a rounding.
        let own = (draw.vector() * [0.0, 1e8, 1e9, 1e10][k % 4]).round();
        let mut near = |count: usize| -> Vec<DVec3> {
            let point = |_| (draw.vector() * 1024.0).round() / 1024.0 * 0.5;
            (0..count).map(point).collect()
        };
        let vertices = [near(12), near([12, 3, 2][k / 4 % 3])];
        let made = |vertices: &[DVec3], from: DVec3| {
            let vertices: Vec<DVec3> = vertices.iter().map(|v| *v + from).collect();
            match vertices[..] {
                [p, q, r] => Shape::triangle([p, q, r]),
                [p, q] => Shape::segment(p, q).and_then(|core| core.swept(0.25)),
                _ => Shape::hull(vertices),
            }
        };
        let far = vertices.each_ref().map(|all| made(all, own).unwrap());
        let here = vertices.each_ref().map(|all| made(all, DVec3::ZERO).unwrap());
        for accuracy in ACCURACIES {
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &far[k], pose: &Pose::IDENTITY });
            let found = Manifolds::default().measure_at(accuracy, a, b, &mut Default::default());
            let Verdict::Touching(found) = found else { continue };
            for point in found[0].points() {
                for (point, shape) in [(point.point_a, &here[0]), (point.point_b, &here[1])] {
                    let off = off_surface(point - own, shape, &Pose::IDENTITY);
                    assert!(
                        off <= found[0].error_bound + ROUNDING,
                        "{k} {accuracy:?}: {off} {found:?}"
                    );
                    judged += 1;
                }
            }
        }
    }
    assert!(judged > 1_000, "{judged}");
}

#[test]
fn points_of_a_needle_on_a_large_ball_differ_by_the_depth_within_their_bound() {
    let mut draw = Draw::seeded(41);
    let ball = Shape::sphere(1e4).unwrap();
    let mut touching = 0;
    for round in 0..600 {
        let corners = (0..3 + round % 3).map(|_| {
            let step = |steps: f64, draw: &mut Draw| (draw.unit() * steps).round();
            DVec3::new(
                step(8.0, &mut draw) / 8.0,
                step(4.0, &mut draw) * 1e-4,
                step(4.0, &mut draw) * 1e-4,
            )
        });
        let Ok(needle) = Shape::hull(corners.collect()) else { continue };
        let place = Pose::from_translation(DVec3::NEG_Z * (1e4 - 1e-4 * f64::from(round % 10)));
        let place = place.unwrap();
        let a = PosedShape { shape: &needle, pose: &Pose::IDENTITY };
        let b = PosedShape { shape: &ball, pose: &place };
        for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
            let solver = Manifolds::default();
            let found = solver.measure_at(accuracy, a, b, &mut Default::default());
            let Verdict::Touching(set) = found else { continue };
            touching += 1;
            for manifold in set.iter() {
                for point in manifold.points() {
                    let between = point.point_a - point.point_b - manifold.normal * point.depth;
                    // Of world coordinates of 1e4 m.
                    let bound = manifold.error_bound + 1e-11;
                    assert!(
                        between.length() <= bound,
                        "{round} {accuracy:?} {between} {manifold:?}"
                    );
                }
            }
        }
    }
    assert!(touching > 900, "{touching}");
}
