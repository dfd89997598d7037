//! Boxes along the axes beside what clipping one face with the other finds.

use super::super::cuboid_pair;
use super::super::cuboids::CuboidPolygon;
use super::super::{Manifold, ManifoldPoint};
use super::*;
use crate::motion::tests::Draw;
use crate::{Accuracy, Depths, Verdict, order, query::MeasureAt};
use dcd_geom::glam::DMat3;
use dcd_geom::{Pose, Shape};

/// One of the 24 ways in which a box stands along the axes.
fn turn(k: usize) -> DMat3 {
    let third = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    let quarter = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z);
    let half = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
    let turns = [DMat3::IDENTITY, third, third * third];
    let quarters = [DMat3::IDENTITY, quarter, quarter * quarter, quarter.transpose()];
    turns[k % 3] * quarters[k / 3 % 4] * [DMat3::IDENTITY, half][k / 12 % 2]
}

/// The points in an order that does not depend on what found them.
fn sorted(found: &Manifold) -> Vec<ManifoldPoint> {
    let mut points = found.points().to_vec();
    let key = |point: &ManifoldPoint| (point.point_a * 1e6).round().to_array();
    points.sort_by(|p, q| key(p).partial_cmp(&key(q)).unwrap());
    points
}

/// Both manifolds of two boxes that touch: by their ends, and by clipping; `None` of boxes apart.
fn both(sides: [PosedShape<'_>; 2]) -> Option<[Manifold; 2]> {
    let [a, b] = sides;
    if crate::certified::overlap_of(a, b).0 != Verdict::Touching(()) {
        return None;
    }
    let measured = Depths.measure_at(Accuracy::Certified, a, b, &mut Default::default());
    let Verdict::Touching(depth) = measured else { panic!("{measured:?}") };
    let [mut upright, mut clipped] = [Manifold::default(), Manifold::default()];
    let clips = usize::from(order::is_swapped(a, b));
    assert!(write(&depth, sides, clips, &mut upright), "{depth:?}");
    let (depth, sides) = if clips == 0 { (depth, [a, b]) } else { (depth.mirrored(), [b, a]) };
    assert!(cuboid_pair::write_clipped(&depth, sides, &mut CuboidPolygon::default(), &mut clipped));
    if clips == 1 {
        clipped.mirror();
    }
    Some([upright, clipped])
}

#[test]
fn boxes_along_the_axes_have_the_points_and_features_that_clipping_finds() {
    let mut draw = Draw(29);
    let mut counts = [0; 5];
    for k in 0..6000usize {
        let half = [(); 2].map(|()| draw.vector().abs() * 0.5 + 0.05);
        let shapes = half.map(|half| Shape::cuboid(half).unwrap());
        let place = draw.vector() * [1.0, 100.0][k % 2];
        let poses = [(k, place), (k / 24, place + draw.vector() * 0.8)]
            .map(|(turned, place)| Pose::from_matrix(turn(turned), place).unwrap());
        let sides = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        let Some([upright, clipped]) = both(sides) else { continue };
        counts[upright.points().len()] += 1;
        assert_eq!(upright.normal, clipped.normal);
        assert!((upright.error_bound - clipped.error_bound).abs() < 1e-13, "{k}");
        let (found, due) = (sorted(&upright), sorted(&clipped));
        assert_eq!(found.len(), due.len(), "{k} {found:?} {due:?}");
        for (p, q) in found.iter().zip(&due) {
            assert_eq!(p.features, q.features, "{k} {found:?} {due:?}");
            assert!(p.point_a.distance(q.point_a) < 1e-12, "{k}");
            assert!(p.point_b.distance(q.point_b) < 1e-12, "{k}");
            assert!((p.depth - q.depth).abs() < 1e-12, "{k}");
        }
    }
    assert!(counts[4] > 1000, "{counts:?}");
}

#[test]
fn boxes_of_a_grid_meet_in_faces_lines_and_corners() {
    // Tenths that f64 does not hold: ends that agree but for rounding.
    let half = [DVec3::new(0.1, 0.2, 0.3), DVec3::splat(0.3), DVec3::new(0.3, 0.1, 0.2)];
    let shapes = half.map(|half| Shape::cuboid(half).unwrap());
    let mut counts = [0; 5];
    for k in 0..20_000usize {
        let step = [k % 13, k / 13 % 13, k / 169 % 13].map(|n| n as f64 * 0.1 - 0.6);
        let place = DVec3::splat(0.7) * (k % 3) as f64;
        let poses = [(k, place), (k / 7, place + DVec3::from_array(step))]
            .map(|(turned, place)| Pose::from_matrix(turn(turned), place).unwrap());
        let of =
            |side: usize, shape: usize| PosedShape { shape: &shapes[shape], pose: &poses[side] };
        let sides = [of(0, k % 3), of(1, k / 3 % 3)];
        let Some([upright, clipped]) = both(sides) else { continue };
        counts[upright.points().len()] += 1;
        let (found, due) = (sorted(&upright), sorted(&clipped));
        assert_eq!(found.len(), due.len(), "{k} {found:?} {due:?}");
        let mut mirrored = Manifold::default();
        let mut found_mirrored = upright;
        let measured =
            Depths.measure_at(Accuracy::Certified, sides[1], sides[0], &mut Default::default());
        let Verdict::Touching(depth) = measured else { panic!("{measured:?}") };
        let clips = usize::from(order::is_swapped(sides[1], sides[0]));
        assert!(write(&depth, [sides[1], sides[0]], clips, &mut mirrored));
        found_mirrored.mirror();
        assert_eq!(found_mirrored, mirrored, "{k}");
        for (p, q) in found.iter().zip(&due) {
            assert!(p.point_a.distance(q.point_a) < 1e-12, "{k} {found:?} {due:?}");
            assert!(p.point_b.distance(q.point_b) < 1e-12, "{k}");
        }
    }
    assert!(counts[1] > 10 && counts[2] > 200 && counts[4] > 1000, "{counts:?}");
}

#[test]
fn other_boxes_are_left() {
    let cuboid = Shape::cuboid(DVec3::new(0.5, 0.4, 0.3)).unwrap();
    let rounded = cuboid.clone().rounded(0.1).unwrap();
    let flat = Shape::cuboid(DVec3::new(0.5, 0.4, 0.0)).unwrap();
    let leaning = DMat3::from_rotation_x(1e-9);
    let depth = Depth { depth: 0.1, normal: DVec3::Z, ..Depth::default() };
    let below = Pose::IDENTITY;
    let above = |turn: DMat3| Pose::from_matrix(turn, DVec3::Z * 0.5).unwrap();
    for (shape, turn, is_written) in [
        (&cuboid, DMat3::IDENTITY, true),
        (&rounded, DMat3::IDENTITY, false),
        (&flat, DMat3::IDENTITY, false),
        (&cuboid, leaning, false),
    ] {
        let other = above(turn);
        let sides =
            [PosedShape { shape: &cuboid, pose: &below }, PosedShape { shape, pose: &other }];
        let mut found = Manifold::default();
        assert_eq!(write(&depth, sides, 0, &mut found), is_written, "{shape:?} {turn}");
    }
    // A normal that is no axis, and ends that do not meet.
    let far = Pose::from_translation(DVec3::new(2.0, 0.0, 0.5)).unwrap();
    let tilted = Depth { normal: DVec3::new(0.6, 0.0, 0.8), ..depth };
    for (depth, pose) in [(tilted, above(DMat3::IDENTITY)), (depth, far)] {
        let sides = [
            PosedShape { shape: &cuboid, pose: &below },
            PosedShape { shape: &cuboid, pose: &pose },
        ];
        assert!(!write(&depth, sides, 0, &mut Manifold::default()));
    }
}
