//! What the lanes know of the parts of compounds: parts that are hardly off a rotation, and parts that rest on one plane.

use super::scenes::all_pairs;
use super::within::found;
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Pose, Scene, Shape};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{
    Accuracy, Depths, ManifoldSet, Manifolds, PairSolver, PosedShape, SimdDepths, Verdict,
};

const ACCURACIES: [Accuracy; 3] = [Accuracy::F32, Accuracy::F64, Accuracy::Certified];

/// A brick whose pose in its compound is a quarter turn, and longer than one by that, beside a cuboid.
fn brick(off: f64) -> Scene {
    let quarter = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z) * (1.0 + off);
    let brick = Shape::cuboid(DVec3::new(1.0, 0.3, 0.2)).unwrap();
    let part = (brick, Pose::from_matrix(quarter, DVec3::ZERO).unwrap());
    let other = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let turned = Pose::new(DQuat::from_rotation_x(0.1), DVec3::new(0.7, 0.1, 0.05)).unwrap();
    let shapes = vec![Shape::compound(vec![part]).unwrap(), other];
    Scene::one_each(shapes, vec![Pose::IDENTITY, turned]).unwrap()
}

#[test]
fn a_part_whose_pose_is_hardly_off_a_rotation_is_as_deep_as_it_is() {
    for off in [0.0, 1e-15, 2e-14, 1e-13, 1e-12, 1e-11, 1e-10, 3e-10] {
        let scene = brick(off);
        let Shape::Compound(compound) = scene.shape(0) else { panic!("no compound") };
        let side = |shape, k: usize| PosedShape { shape, pose: &scene.poses()[k] };
        let sides = [side(compound.parts()[0].placed(), 0), side(scene.shape(1), 1)];
        let Verdict::Touching(truth) = Depths.solve(sides[0], sides[1], &mut Default::default())
        else {
            panic!("{off}")
        };
        for accuracy in ACCURACIES {
            let depths = found(&SimdDepths::new(Depths, accuracy), &scene, &all_pairs(2)).0;
            let (one, said) =
                (depths[0].answer, format!("{off} {accuracy:?} {depths:?} {truth:?}"));
            let unsure = one.error_bound + truth.error_bound;
            assert!((one.depth - truth.depth).abs() <= unsure, "{said}");
            assert!(one.normal.dot(truth.normal) > 0.99, "{said}");
            let manifolds = SimdDepths::new(Manifolds::default(), accuracy);
            let sets = found(&manifolds, &scene, &all_pairs(2)).0;
            assert!(sets[0].answer[0].normal.dot(truth.normal) > 0.99, "{said} {sets:?}");
        }
    }
}

#[test]
fn a_part_that_the_lanes_do_not_know_is_as_deep_as_it_is() {
    // Where it is not in the compound's origin, an ellipsoid is a support map like a user's own.
    let ellipsoid = Shape::ellipsoid(DVec3::new(0.9, 0.8, 0.7)).unwrap();
    let part = |shape, place| (shape, Pose::from_translation(place).unwrap());
    let small = Shape::cuboid(DVec3::splat(0.1)).unwrap();
    let parts = vec![part(ellipsoid, DVec3::X * 1e-3), part(small, DVec3::new(0.2, 0.0, 0.25))];
    let shapes =
        vec![Shape::compound(parts).unwrap(), Shape::cuboid(DVec3::new(0.3, 0.3, 0.5)).unwrap()];
    let upside_down = Pose::new(DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0), DVec3::Z * 0.8).unwrap();
    let scene = Scene::one_each(shapes, vec![upside_down, Pose::IDENTITY]).unwrap();
    for accuracy in ACCURACIES {
        let one = found(&SimdDepths::new(Depths, accuracy), &scene, &all_pairs(2)).0[0].answer;
        // The ellipsoid reaches 0.7 down from 0.8 m, the cuboid 0.5 up.
        assert!((one.depth - 0.4).abs() <= one.error_bound + 1e-15, "{accuracy:?} {one:?}");
        assert!(one.error_bound < 3e-6, "{accuracy:?} {one:?}");
    }
}

/// The eight corners of a cuboid as a hull.
fn hull(half: DVec3) -> Shape {
    let corner = |k: u32| {
        let sign = |axis: u32| if k >> axis & 1 == 0 { -1.0 } else { 1.0 };
        half * DVec3::new(sign(0), sign(1), sign(2))
    };
    Shape::hull((0..8).map(corner).collect()).unwrap()
}

/// A table of a board and four legs, which reach 0.8 m down from it, all larger by that.
fn table_on(leg: &Shape, off: f64) -> Shape {
    let larger = DMat3::IDENTITY * (1.0 + off);
    let place = |x: f64, y: f64, z: f64| Pose::from_matrix(larger, DVec3::new(x, y, z)).unwrap();
    let legs = [(0.6, 0.4), (0.6, -0.4), (-0.6, 0.4), (-0.6, -0.4)]
        .map(|(x, y)| (leg.clone(), place(x, y, 0.4)));
    let board = (Shape::cuboid(DVec3::new(0.7, 0.5, 0.03)).unwrap(), place(0.0, 0.0, 0.83));
    Shape::compound(legs.into_iter().chain([board]).collect()).unwrap()
}

/// The manifolds of the first two objects of a scene: those that the lanes find, and those of the pair by itself.
pub(super) fn manifolds(scene: &Scene, accuracy: Accuracy) -> [ManifoldSet; 2] {
    let solver = Manifolds::default();
    let in_lanes = found(&SimdDepths::new(solver, accuracy), scene, &all_pairs(2)).0;
    let [a, b] = [0, 1].map(|k| PosedShape::of(scene, k));
    match solver.measure_at(accuracy, a, b, &mut Default::default()) {
        Verdict::Touching(alone) => [in_lanes[0].answer.clone(), alone],
        other => panic!("{accuracy:?} {other:?}"),
    }
}

/// How many points, at least, the manifolds of a table, 1 mm deep in the ground, have in a world that is turned so.
fn points_of(
    table: &Shape,
    (ground, top): (&Shape, f64),
    turn: DQuat,
    accuracy: Accuracy,
) -> usize {
    let about = (turn * DQuat::from_rotation_z(0.4)).normalize();
    let on = Pose::new(about, turn * DVec3::new(0.1, 0.2, -0.001)).unwrap();
    let below = Pose::new(turn, turn * DVec3::Z * -top).unwrap();
    let scene = Scene::one_each(vec![table.clone(), ground.clone()], vec![on, below]).unwrap();
    let points =
        |set: &ManifoldSet| set.iter().map(|manifold| manifold.points().len()).sum::<usize>();
    let [in_lanes, alone] = manifolds(&scene, accuracy).each_ref().map(points);
    in_lanes.min(alone)
}

#[test]
fn every_leg_of_a_table_has_a_point_whatever_the_legs_and_the_ground_are() {
    let corners = [(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)];
    let corners = corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
    let grounds = [
        (Shape::half_space(DVec3::Z, 0.0), 0.0),
        (Shape::mesh(corners, vec![[0, 1, 2], [0, 2, 3]]), 0.0),
        (Shape::cuboid(DVec3::new(5.0, 5.0, 0.5)), 0.5),
        (Ok(hull(DVec3::new(5.0, 5.0, 0.5))), 0.5),
    ];
    let legs = [
        Shape::cylinder(0.4, 0.05),
        Shape::cone(0.4, 0.05),
        Shape::ellipsoid(DVec3::new(0.05, 0.05, 0.4)),
        Shape::sphere(0.4),
        Ok(hull(DVec3::new(0.05, 0.05, 0.4))),
        Shape::cuboid(DVec3::new(0.05, 0.05, 0.4)),
    ];
    let legs = legs.map(Result::unwrap);
    for (number, (ground, top)) in grounds.into_iter().enumerate() {
        let ground = ground.unwrap();
        for (leg, accuracy) in legs.iter().flat_map(|leg| ACCURACIES.map(|at| (leg, at))) {
            for k in 0..24 {
                let off = [0.0, 1e-14, 1e-11, 1e-7][k as usize % 4];
                let table = table_on(leg, off);
                let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.7, -0.2) * f64::from(k / 4));
                let found = points_of(&table, (&ground, top), turn.normalize(), accuracy);
                let said = format!("{k} {accuracy:?}: {found} of {leg:?} on {number}");
                assert!(found >= 3, "{said}");
            }
        }
    }
}

#[test]
fn a_table_stands_on_four_legs_at_every_accuracy() {
    let cuboid = |half| Shape::cuboid(half).unwrap();
    stands_on_four_legs(&cuboid(DVec3::new(0.05, 0.05, 0.25)), &cuboid(DVec3::new(5.0, 5.0, 0.5)));
    stands_on_four_legs(&hull(DVec3::new(0.05, 0.05, 0.25)), &hull(DVec3::new(5.0, 5.0, 0.5)));
}

fn stands_on_four_legs(leg: &Shape, floor: &Shape) {
    let leg = |x: f64, y: f64| {
        let place = DVec3::new(0.45 * x, 0.45 * y, 0.25);
        (leg.clone(), Pose::from_translation(place).unwrap())
    };
    let top = Shape::cuboid(DVec3::new(0.5, 0.5, 0.05)).unwrap();
    let top = (top, Pose::from_translation(DVec3::Z * 0.5).unwrap());
    let legs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(x, y)| leg(x, y));
    let table = Shape::compound([vec![top], legs.to_vec()].concat()).unwrap();
    for k in 0..200 {
        let turn = DQuat::from_rotation_z(0.03 * f64::from(k));
        let at = DVec3::new(0.01 * f64::from(k) - 1.0, 0.3, -0.003);
        let below = Pose::new(DQuat::from_rotation_z(0.3), DVec3::Z * -0.5).unwrap();
        let poses = vec![Pose::new(turn, at).unwrap(), below];
        let scene = Scene::one_each(vec![table.clone(), floor.clone()], poses).unwrap();
        for accuracy in ACCURACIES {
            for set in manifolds(&scene, accuracy) {
                assert_eq!((set.len(), set[0].points().len()), (1, 4), "{k} {accuracy:?} {set:?}");
            }
        }
    }
}
