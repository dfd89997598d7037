//! What the lanes know of the parts of compounds: parts that are hardly off a rotation, and parts that rest on one plane.

use super::scenes::all_pairs;
use super::within::found;
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Pose, Scene, Shape};
use dcd_gjk::{Accuracy, Depths, Manifolds, PairSolver, PosedShape, SimdDepths, Verdict};

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
fn a_table_stands_on_four_legs_at_every_accuracy() {
    let leg = |x: f64, y: f64| {
        let place = DVec3::new(0.45 * x, 0.45 * y, 0.25);
        let shape = Shape::cuboid(DVec3::new(0.05, 0.05, 0.25)).unwrap();
        (shape, Pose::from_translation(place).unwrap())
    };
    let top = Shape::cuboid(DVec3::new(0.5, 0.5, 0.05)).unwrap();
    let top = (top, Pose::from_translation(DVec3::Z * 0.5).unwrap());
    let legs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(x, y)| leg(x, y));
    let table = Shape::compound([vec![top], legs.to_vec()].concat()).unwrap();
    let floor = Shape::cuboid(DVec3::new(5.0, 5.0, 0.5)).unwrap();
    for k in 0..200 {
        let turn = DQuat::from_rotation_z(0.03 * f64::from(k));
        let at = DVec3::new(0.01 * f64::from(k) - 1.0, 0.3, -0.003);
        let below = Pose::new(DQuat::from_rotation_z(0.3), DVec3::Z * -0.5).unwrap();
        let poses = vec![Pose::new(turn, at).unwrap(), below];
        let scene = Scene::one_each(vec![table.clone(), floor.clone()], poses).unwrap();
        for accuracy in ACCURACIES {
            let manifolds = SimdDepths::new(Manifolds::default(), accuracy);
            let sets = found(&manifolds, &scene, &all_pairs(2)).0;
            let set = &sets[0].answer;
            assert_eq!((set.len(), set[0].points().len()), (1, 4), "{k} {accuracy:?} {set:?}");
        }
    }
}
