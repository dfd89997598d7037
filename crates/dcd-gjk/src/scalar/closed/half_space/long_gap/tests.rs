//! Against the exact gap.

use super::super::ExactGap;
use super::*;
use crate::PosedShape;
use crate::motion::tests::Draw;
use dcd_geom::Shape;
use dcd_geom::glam::{DMat3, DQuat, DVec3};

fn pose(draw: &mut Draw, size: f64) -> Pose {
    let turn = DQuat::from_vec4(draw.vector().extend(draw.number())).normalize();
    Pose::new(turn, draw.vector() * size).unwrap()
}

fn shapes(draw: &mut Draw) -> Vec<Shape> {
    let half = draw.vector().abs() + 0.1;
    let corners = [0; 3].map(|_| draw.vector());
    vec![
        Shape::sphere(0.3).unwrap(),
        Shape::capsule(half.x, half.y).unwrap(),
        Shape::cuboid(half).unwrap(),
        Shape::cuboid(half).unwrap().rounded(0.1).unwrap(),
        Shape::triangle(corners).unwrap(),
        Shape::hull((0..20).map(|_| draw.vector()).collect()).unwrap(),
    ]
}

#[test]
fn a_gap_is_within_the_bound_of_the_exact_one_and_mostly_known() {
    let mut draw = Draw(31);
    let (mut known, mut close, mut all) = (0, 0, 0);
    for round in 0..200 {
        let size = [1.0, 1e-6, 1e9][round % 3];
        let normal = draw.vector() * [1.0, 1e-20, 1e20][round / 3 % 3];
        let at = pose(&mut draw, size);
        for shape in shapes(&mut draw) {
            // Faces lie in the plane in some, but for rounding; there is a gap of any size.
            let there = match round % 4 {
                0 => Pose::from_matrix(*at.rotation(), draw.vector()).unwrap(),
                _ => pose(&mut draw, size),
            };
            let normal = if round % 8 == 0 { DVec3::Z } else { normal };
            let level = Shape::half_space(normal, 0.0).unwrap().rounded(0.2).unwrap();
            let other = PosedShape { shape: &shape, pose: &there };
            let gap = |half_space: &Shape| {
                let plane = PosedShape { shape: half_space, pose: &at };
                ExactGap::of(Plane::of(plane).unwrap(), other).unwrap().distance()
            };
            let up = gap(&level);
            let scale = 10f64.powf(-15.0 * draw.number().abs());
            let offset = up * (1.0 - scale) * normal.length();
            let half_space = Shape::half_space(normal, offset).unwrap().rounded(0.2).unwrap();
            let plane = Plane::of(PosedShape { shape: &half_space, pose: &at }).unwrap();
            let due = gap(&half_space);
            let in_f64 = Gap::of(plane, other);
            let Shape::Polytope(polytope) = &shape else { panic!() };
            let found = of(&in_f64, plane, (polytope, &there));
            all += 1;
            if let Some(found) = found {
                known += 1;
                close += u32::from(due.abs() < 1e-12 * up.abs());
                assert!((found - due).abs() <= 25.0 * UNIT * due.abs(), "{shape:?}: {found} {due}");
            }
        }
    }
    assert!(known * 10 > all * 8 && close > 20, "{known} of {all}, {close} of them close");
}

#[test]
fn what_rounding_may_exceed_is_left_to_exact_numbers() {
    let half_space = Shape::half_space(DVec3::new(0.6, 0.8, 0.0), 1.0).unwrap();
    let shape = Shape::sphere(0.0).unwrap();
    let Shape::Polytope(polytope) = &shape else { panic!() };
    let gap = |scale: f64, error: Option<f64>| {
        let there = Pose::from_translation(DVec3::new(0.6, 0.8, 0.0) * scale).unwrap();
        let plane = PosedShape { shape: &half_space, pose: &Pose::IDENTITY };
        let in_f64 = Gap::of(Plane::of(plane).unwrap(), PosedShape { shape: &shape, pose: &there });
        let in_f64 = Gap { error: error.unwrap_or(in_f64.error), ..in_f64 };
        of(&in_f64, Plane::of(plane).unwrap(), (polytope, &there))
    };
    assert!(gap(1.0 + 1e-13, None).is_some_and(|gap| (gap - 1e-13).abs() < 1e-15));
    assert_eq!(gap(1.0, None), None);
    // As of a pair that is larger.
    for error in [1.0, f64::INFINITY, f64::NAN] {
        assert_eq!(gap(1.0 + 1e-13, Some(error)), None);
    }
}

#[test]
fn of_corners_that_are_level_but_for_rounding_the_lowest_counts() {
    let mut draw = Draw(37);
    let (mut known, mut wrong) = (0, 0);
    for _ in 0..300 {
        // Along the plane the products in f64 say nothing of which is the lowest.
        let at = pose(&mut draw, 1.0);
        let tilt = DMat3::from_cols(draw.vector(), draw.vector(), draw.vector()) * 3e-16;
        let there = Pose::from_matrix(*at.rotation() + tilt, at.translation()).unwrap();
        let corner = |draw: &mut Draw| (draw.vector() * 1000.0).with_z(1.0 + 1e-9);
        let shape = Shape::triangle([0; 3].map(|_| corner(&mut draw))).unwrap();
        let half_space = Shape::half_space(DVec3::Z, 1.0).unwrap();
        let plane = Plane::of(PosedShape { shape: &half_space, pose: &at }).unwrap();
        let other = PosedShape { shape: &shape, pose: &there };
        let due = ExactGap::of(plane, other).unwrap().distance();
        let Shape::Polytope(polytope) = &shape else { panic!() };
        let by = |gap: &Gap| of(gap, plane, (polytope, &there));
        let is_right = |found: f64| (found - due).abs() <= 25.0 * UNIT * due.abs();
        let in_f64 = Gap::of(plane, other);
        if let Some(found) = by(&in_f64) {
            assert!(is_right(found), "{found} {due}");
            known += 1;
        }
        // If f64 were better, its lowest corner would do.
        wrong += u32::from(by(&Gap { error: 1e-60, ..in_f64 }).is_some_and(|gap| !is_right(gap)));
    }
    assert!(known > 250 && wrong > 5, "{known} {wrong}");
}
