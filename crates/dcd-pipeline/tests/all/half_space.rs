//! Half-spaces in a scene: in the tree with everything else.

use dcd_broad::{BruteForce, SweepAndPrune, WideTree};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Pose, Scene, Shape};
use dcd_gjk::Overlap;
use dcd_pipeline::{Par, Pipeline};

/// A floor, a slope and 400 objects of all kinds above and below them.
fn scene() -> Scene {
    let kinds = [
        Shape::cylinder(0.5, 0.25),
        Shape::cuboid(DVec3::splat(0.5)),
        Shape::cone(0.5, 0.25),
        Shape::sphere(0.5),
        Shape::capsule(0.25, 0.25),
    ]
    .map(Result::unwrap);
    let mut shapes = vec![
        Shape::half_space(DVec3::Z, 0.0).unwrap(),
        Shape::half_space(DVec3::new(1.0, 0.5, 0.25), -8.0).unwrap(),
    ];
    let mut poses = vec![Pose::IDENTITY; 2];
    for k in 0..400u32 {
        let x = f64::from(k);
        let at = DVec3::new((k % 20).into(), (k / 20).into(), (x * 0.37) % 6.0 - 1.0);
        let turned = DQuat::from_rotation_x(x) * DQuat::from_rotation_y(2.0 * x);
        shapes.push(kinds[k as usize % kinds.len()].clone());
        poses.push(Pose::new(turned, at - DVec3::new(10.0, 10.0, 0.0)).unwrap());
    }
    Scene::one_each(shapes, poses).unwrap()
}

#[test]
fn every_broad_phase_finds_what_touches_a_half_space() {
    let scene = scene();
    let mut brute = Pipeline::with(BruteForce, Overlap::default());
    let step = brute.step(&scene, Par::Serial);
    assert!(step.report().undecided().is_empty());
    let mut expected: Vec<_> = step.contacts().collect();
    expected.sort_unstable();
    let with_floor = expected.iter().filter(|pair| pair.0 == 0).count();
    let with_slope = expected.iter().filter(|pair| pair.0 == 1).count();
    assert!(with_floor > 50 && with_floor < 250 && with_slope > 5, "{with_floor} {with_slope}");

    let mut wide = Pipeline::with(WideTree::default(), Overlap::default());
    let mut sweep = Pipeline::with(SweepAndPrune::default(), Overlap::default());
    for par in [Par::Serial, Par::Pool] {
        for mut found in [
            wide.step(&scene, par).contacts().collect::<Vec<_>>(),
            sweep.step(&scene, par).contacts().collect(),
        ] {
            found.sort_unstable();
            assert_eq!(found, expected);
        }
    }
}

#[test]
fn a_floor_is_a_candidate_only_of_what_is_near_it() {
    let scene = scene();
    let mut wide = Pipeline::with(WideTree::default(), Overlap::default());
    let step = wide.step(&scene, Par::Serial);
    let candidates = step.candidates().filter(|pair| pair.i == 0).count();
    let touching = step.contacts().filter(|pair| pair.0 == 0).count();
    assert!(candidates < touching + 60, "{candidates} {touching}");
}
