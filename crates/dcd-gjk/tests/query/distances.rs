//! How far apart.

use super::scenes::{Draw, pile, shapes};
use super::within::found;
use super::{PosedSupport, ask, told};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose, Shape};
use dcd_gjk::query::Smoothness;
use dcd_gjk::{
    Distances, PairSolver, Pairwise, Proximities, Reason, ThenMeasure, Verdict, contract,
};
use std::sync::Arc;

#[test]
fn distances_keep_the_contract_one_by_one_and_after_the_lanes() {
    let (scene, pairs) = pile(shapes(), 40);
    for margin in [0.0, 0.5] {
        let solver = Distances::within(margin).unwrap();
        contract::narrow_phase(&Pairwise(solver), &scene, &pairs).unwrap();
        contract::narrow_phase(&ThenMeasure::new(solver).unwrap(), &scene, &pairs).unwrap();
    }
}

#[test]
fn both_ways_of_asking_tell_the_same() {
    let mut polytopes = shapes();
    polytopes.pop();
    let (scene, pairs) = pile(polytopes, 40);
    let solver = Distances::within(0.5).unwrap();
    let (alone, _) = found(&Pairwise(solver), &scene, &pairs);
    let (after, report) = found(&ThenMeasure::new(solver).unwrap(), &scene, &pairs);
    assert!(alone.len() > 50 && alone == after, "{} {}", alone.len(), after.len());
    assert!(report.undecided().is_empty(), "{:?}", report.undecided());
    let apart = alone.iter().filter_map(|contact| contact.answer);
    assert!(apart.clone().count() > 10 && apart.clone().all(|d| d.lower() <= 0.5));
}

#[test]
fn a_pair_beyond_the_margin_is_apart_and_one_that_touches_has_no_distance() {
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let solver = Distances::within(1.0).unwrap();
    let a = PosedSupport::at(&cube, DVec3::ZERO);
    assert_eq!(ask(&solver, &a, &PosedSupport::at(&cube, DVec3::X * 2.5)), Verdict::Apart);
    assert_eq!(ask(&solver, &a, &PosedSupport::at(&cube, DVec3::X * 1e30)), Verdict::Apart);
    assert_eq!(told(&solver, &a, &PosedSupport::at(&cube, DVec3::X)), None);
    let found = told(&solver, &a, &PosedSupport::at(&cube, DVec3::X * 1.75)).unwrap();
    assert!(found.lower() <= 0.75 && 0.75 <= found.upper() && found.upper() < 0.75 + 1e-15);
    assert_eq!((found.normal, found.point_a.x, found.point_b.x), (DVec3::X, 0.5, 1.25));
}

#[test]
fn a_pair_that_f64_cannot_tell_is_within_a_margin_at_zero_with_its_bound() {
    // Rims that just touch: cylinders have no exact method.
    let cylinder = Shape::cylinder(0.5, 0.25).unwrap();
    let (a, b) =
        (PosedSupport::at(&cylinder, DVec3::ZERO), PosedSupport::at(&cylinder, DVec3::X * 0.5));
    let parts = vec![(cylinder.clone(), Pose::IDENTITY)];
    let compound = Shape::compound(parts).unwrap();
    for a in [a, PosedSupport::at(&compound, DVec3::ZERO)] {
        let solver = Distances::within(0.1).unwrap();
        let found = told(&solver, &a, &b).unwrap();
        assert!(found.distance == 0.0 && found.normal.x > 0.99, "{found:?}");
        assert!((1e-18..1e-13).contains(&found.error_bound), "{found:?}");
        let near = told(&Proximities::within(0.1).unwrap(), &a, &b);
        assert_eq!((near.signed_distance, near.error_bound), (0.0, found.error_bound));
        assert_eq!(near.smoothness, Smoothness::Unknown);
        // Of no margin, and of one below the bound, it is not known whether they are within it.
        for margin in [0.0, 1e-17] {
            let answer = ask(&Distances::within(margin).unwrap(), &a, &b);
            assert_eq!(answer, Verdict::Undecided(Reason::WithinRounding), "{margin}");
        }
    }
}

#[test]
fn the_spheres_reject_nothing_that_is_within_the_margin() {
    // Two spheres along a random line, moved about the margin in steps of rounding.
    let mut draw = Draw(5);
    for k in 0..2000 {
        let scale = 10f64.powi(k % 19 - 9);
        let radii = [draw.unit().abs(), draw.unit().abs()].map(|r| r * scale);
        let margin = draw.unit().abs() * scale;
        let place = draw.vector() * scale * 10f64.powi(k % 7 - 1);
        let far = radii[0] + radii[1] + margin;
        let off = draw.vector().normalize() * far * (1.0 + f64::from(k % 5 - 2) * 1e-16);
        let [a, b] = [(radii[0], place), (radii[1], place + off)].map(|(radius, place)| {
            let sphere = Polytope::sphere(radius).unwrap();
            let shape = if k % 3 == 0 {
                Shape::custom(Arc::new(sphere)).unwrap()
            } else {
                Shape::from(sphere)
            };
            PosedSupport::new(shape, draw.turn(), place)
        });
        let solver = Distances::within(margin).unwrap();
        let measured = solver.measure(a.placed(), b.placed(), &mut ());
        if let (Verdict::Touching(Some(found)), Verdict::Apart) = (measured, ask(&solver, &a, &b)) {
            assert!(found.upper() > margin, "{found:?} {margin}\n{a:?}\n{b:?}");
        }
    }
}
