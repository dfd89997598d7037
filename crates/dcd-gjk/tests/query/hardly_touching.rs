//! Shapes whose cores hardly touch, or hardly do not: what f64 leaves of their difference is rounding, and so is a normal that
//! is taken from it.

use super::PosedSupport;
use super::manifold_points::{
    CONVEX, ROUNDING, convex, judge, judge_all, judge_depth, place, turn, verdict,
};
use super::scenes::Draw;
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Pose, Shape, SupportMap};
use dcd_gjk::distance::distance_at;
use dcd_gjk::{
    Accuracy, Distance, DistanceResult, Manifolds, PosedShape, SimdDepths, SimdDistances, Verdict,
};
use dcd_pipeline::prelude::{Pair, Par, Pipeline, Scene, WideTree};

/// Whether the points of a distance are of their surfaces, and as far apart along the normal as it says.
fn judge_distance(found: &Distance, sides: [PosedShape<'_>; 2], what: &str) {
    let unsure = found.error_bound + ROUNDING;
    for (side, at) in sides.into_iter().zip([found.point_a, found.point_b]) {
        let ball = Shape::sphere(unsure).unwrap();
        let pose = Pose::from_translation(at).unwrap();
        let is_off = verdict(side, PosedShape { shape: &ball, pose: &pose }) == Verdict::Apart;
        assert!(!is_off, "{what}: {found:?}");
    }
    // What may be no distance has no normal.
    if found.lower() <= 0.0 {
        return;
    }
    let between = found.point_b - found.point_a;
    for length in [between.length(), between.dot(found.normal)] {
        assert!((length - found.distance).abs() <= unsure, "{what}: {length} {found:?}");
    }
    // Along the normal they are no nearer than the distance.
    let [a, b] = sides;
    let nearer = b.pose.translation() - found.normal * (found.distance - unsure).max(0.0);
    let pose = Pose::from_matrix(*b.pose.rotation(), nearer).unwrap();
    // Of curved shapes that are a nanometre apart the verdict may be left open.
    let is_open = found.distance <= unsure
        || verdict(a, PosedShape { pose: &pose, ..b }) != Verdict::Touching(());
    assert!(is_open, "{what}: {found:?}");
}

#[test]
fn points_of_a_disc_that_all_but_touches_an_edge_are_as_near_as_the_distance() {
    let pose = |turn: [f64; 9], at: [f64; 3]| {
        Pose::from_matrix(DMat3::from_cols_array(&turn), at.into()).unwrap()
    };
    let turn_a = [
        0.44811106181877813,
        0.831353983246874,
        -0.32870508182138514,
        0.8934169560710642,
        -0.40343573144797373,
        0.19759998278277494,
        0.03166415766069719,
        -0.38221743174611356,
        -0.9235297591247638,
    ];
    let turn_b = [
        -0.10644860485459118,
        0.9647148964839585,
        0.24081915004097332,
        0.185350708942349,
        -0.21869778060242728,
        0.958027345880138,
        0.9768898654500824,
        0.14661667456847566,
        -0.15553051636062287,
    ];
    let place = [-0.5396490424790643, 1.2619488022447742, -0.2862601027269076];
    let (pose_a, pose_b) = (pose(turn_a, [0.0; 3]), pose(turn_b, place));
    let cuboid = Shape::cuboid(DVec3::new(0.5, 0.75, 1.0)).unwrap();
    let disc = Shape::cylinder(0.01, 0.5).unwrap();
    let a = PosedShape { shape: &cuboid, pose: &pose_a };
    let b = PosedShape { shape: &disc, pose: &pose_b };
    for accuracy in [Accuracy::F64, Accuracy::Certified] {
        let DistanceResult::Apart(found) = distance_at(accuracy, a, b).0 else { panic!() };
        let apart = found.point_a.distance(found.point_b);
        // They were 3.3e-6 apart, by weights that were rounding.
        assert!(apart <= found.upper() + 1e-11, "{accuracy:?} {apart} {found:?}");
    }
}

/// Two shapes whose cores are beside each other along an axis of the world, apart or overlapping by next to nothing, and
/// lean by as little.
fn hardly_touching(draw: &mut Draw, k: usize) -> [PosedSupport; 2] {
    let (kinds, round) = ([k % CONVEX, k / CONVEX % CONVEX], k % 5 < 3);
    let shapes = kinds.map(|kind| convex(draw, kind, round));
    let axis = [DVec3::X, DVec3::Y, DVec3::Z][k % 3];
    let lean = [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5][k / 7 % 6];
    let gap = [0.0, 1e-16, -1e-16, 1e-14, -1e-14, 1e-11, -1e-11, 1e-8, -1e-8, 1e-6][k / 11 % 10];
    let upright = turn(draw, true);
    let leaning = DMat3::from_quat(DQuat::from_scaled_axis(place(draw, false) * lean));
    let turns = [upright, leaning * turn(draw, true)];
    let end = |number: usize, axis: DVec3| {
        let at = shapes[number].support(turns[number].transpose() * axis).point;
        turns[number] * at
    };
    let beside = axis * (axis.dot(end(0, axis) - end(1, -axis)) + gap);
    let across = (place(draw, round) * 0.25) * (DVec3::ONE - axis);
    let origin = place(draw, round);
    let places = [origin, origin + beside + across];
    let mut number = 0;
    shapes.map(|shape| {
        let pose = Pose::from_matrix(turns[number], places[number]).unwrap();
        number += 1;
        PosedSupport { shape, pose }
    })
}

#[test]
fn manifolds_at_every_accuracy_are_as_deep_as_they_say() {
    let mut draw = Draw::seeded(29);
    let mut judged = 0;
    for k in 0..24_000usize {
        let [a, b] = hardly_touching(&mut draw, k);
        let (a, b) = (a.placed(), b.placed());
        if verdict(a, b) == Verdict::Touching(()) {
            judged += judge_all([a, b], true, (ROUNDING, &format!("{k}")));
        }
    }
    assert!(judged > 20_000, "{judged}");
}

#[test]
fn scenes_of_them_have_manifolds_and_distances_that_are_true() {
    let mut draw = Draw::seeded(31);
    let [mut manifolds, mut distances] = [0; 2];
    for k in 0..100usize {
        let pairs = (0..81).map(|j| hardly_touching(&mut draw, 81 * k + j));
        // Each where no other is near.
        let far = |j: usize| DVec3::new((j % 9) as f64, (j / 9) as f64, 0.0) * 32.0;
        let posed = pairs.enumerate().flat_map(|(j, pair)| {
            pair.map(|PosedSupport { shape, pose }| {
                let place = pose.translation() + far(j);
                (shape, Pose::from_matrix(*pose.rotation(), place).unwrap())
            })
        });
        let (shapes, poses) = posed.unzip();
        let scene = Scene::one_each(shapes, poses).unwrap();
        let posed = |pair: Pair| [pair.i, pair.j].map(|object| PosedShape::of(&scene, object));
        let narrow = SimdDepths::new(Manifolds::default(), Accuracy::F32);
        for found in Pipeline::with(WideTree::default(), narrow).step(&scene, Par::Serial).answers()
        {
            let what = format!("scene {k}, {:?}", found.pair);
            for manifold in found.answer.iter() {
                judge(manifold, posed(found.pair), (ROUNDING, &what));
                judge_depth(manifold, posed(found.pair), (ROUNDING, &what));
                manifolds += 1;
            }
        }
        let narrow = SimdDistances::within(0.01, Accuracy::F32).unwrap();
        for found in Pipeline::with(WideTree::default(), narrow).step(&scene, Par::Serial).answers()
        {
            if let Some(distance) = found.answer {
                judge_distance(
                    &distance,
                    posed(found.pair),
                    &format!("scene {k}, {:?}", found.pair),
                );
                distances += 1;
            }
        }
    }
    assert!(manifolds > 4_000 && distances > 800, "{manifolds} {distances}");
}
