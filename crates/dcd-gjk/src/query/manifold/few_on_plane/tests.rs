//! The parts as they are placed, each compared with all others, are the other method.

use super::*;
use crate::motion::tests::Draw;
use crate::query::{ManifoldOptions, MeasureAt};
use crate::{Depths, Manifolds, PairSolver};
use dcd_geom::SupportMap;
use dcd_geom::glam::DQuat;

/// Far above what rounding does to lengths of about a metre.
const SAME_PLACE: f64 = 1e-9;

fn pose(draw: &mut Draw, reach: f64, turn: f64) -> Pose {
    let turn = DQuat::from_scaled_axis(draw.vector() * turn);
    Pose::new(turn.normalize(), draw.vector() * reach).unwrap()
}

fn part(draw: &mut Draw, k: usize) -> Shape {
    let half = draw.vector().abs() * 0.2 + 0.05;
    let made = match k % 7 {
        0 => Shape::sphere(half.x),
        1 => Shape::capsule(half.x, half.y),
        2 => Shape::hull((0..10).map(|_| draw.vector() * 0.3).collect()),
        3 => Shape::triangle([0; 3].map(|_| draw.vector() * 0.4)),
        4 => Shape::cuboid(half).and_then(|cuboid| cuboid.rounded(0.05)),
        _ => Shape::cuboid(half),
    };
    made.unwrap()
}

/// A compound of one to eight parts and a half-space; some flat on it, some far from the world's origin.
fn pair(draw: &mut Draw, k: usize) -> ([Shape; 2], [Pose; 2]) {
    let turn = if k.is_multiple_of(3) { 0.0 } else { 3.0 };
    let parts = (0..1 + k % 8).map(|j| (part(draw, j + k / 8), pose(draw, 0.4, turn)));
    let compound = Shape::compound(parts.collect()).unwrap();
    let radius = if k.is_multiple_of(5) { 0.1 } else { 0.0 };
    let normal = if k.is_multiple_of(3) { DVec3::Z * 2.0 } else { draw.vector() };
    let plane = Shape::half_space(normal, 0.1 * (k % 4) as f64).and_then(|p| p.rounded(radius));
    let far = if k.is_multiple_of(7) { DVec3::new(3e3, -1e3, 2e3) } else { DVec3::ZERO };
    let poses = [pose(draw, 0.3, turn * 1e-3), pose(draw, 0.3, turn)];
    let moved = |pose: Pose| pose.with_translation(pose.translation() + far).unwrap();
    ([compound, plane.unwrap()], poses.map(moved))
}

/// Whether a point is a corner of the part that it names, with what is swept round that, and the other on the plane over it.
fn is_of_corner(point: &ManifoldPoint, [a, b]: [PosedShape<'_>; 2], normal: DVec3) -> bool {
    let Shape::Compound(compound) = a.shape else { return false };
    let [Some(PartIndex::Part(number)), None] = point.parts else { return false };
    let [Feature::Vertex(vertex), Feature::Surface] = point.features else { return false };
    let placed = compound.parts()[number as usize].placed().as_polytope().unwrap();
    let corner = a.pose.apply(placed.vertices()[vertex as usize]);
    let due = corner + normal * placed.swept_radius();
    let Shape::HalfSpace(half_space) = b.shape else { return false };
    let local = b.pose.rotation().transpose() * (point.point_b - b.pose.translation());
    let length = half_space.normal().length();
    let above = (half_space.normal().dot(local) - half_space.offset()) / length - b.shape.radius();
    due.distance(point.point_a) < SAME_PLACE
        && above.abs() < SAME_PLACE
        && (point.point_a - point.point_b - normal * point.depth).length() < SAME_PLACE
}

#[test]
fn few_parts_rest_on_a_plane_where_the_placed_parts_do() {
    let mut draw = Draw(71);
    let (mut compared, mut same, mut counts) = (0, 0, [0; 5]);
    for k in 0..4000 {
        let (shapes, poses) = pair(&mut draw, k);
        let sides = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        let mut found = Manifold::default();
        if write(Accuracy::F32, sides, &mut found).is_none() {
            assert!(found.points().is_empty(), "{k}");
            continue;
        }
        let mut scratch = <Manifolds as PairSolver>::Scratch::default();
        let solver = Manifolds { options: ManifoldOptions::default() };
        let due = solver.measure_at(Accuracy::Certified, sides[0], sides[1], &mut scratch);
        let Verdict::Touching(due) = due else { panic!("{k}: {found:?}") };
        let [due] = &due[..] else { panic!("{k}: {due:?}") };
        let depth =
            Depths.measure_at(Accuracy::Certified, sides[0], sides[1], &mut Default::default());
        let Verdict::Touching(depth) = depth else { panic!("{k}") };
        assert!(found.normal.distance(due.normal) < 1e-11, "{k}");
        assert!((found.points()[0].depth - depth.depth).abs() <= found.error_bound, "{k}");
        assert!((found.error_bound - due.error_bound).abs() < SAME_PLACE, "{k}");
        assert_eq!(found.points().len(), due.points().len(), "{k}: {found:?} {due:?}");
        for point in found.points() {
            assert!(is_of_corner(point, sides, found.normal), "{k}: {point:?}");
            assert!((0.0..=found.points()[0].depth).contains(&point.depth), "{k}");
        }
        let is_there = |point: &ManifoldPoint| {
            due.points().iter().any(|other| {
                point.point_a.distance(other.point_a) < SAME_PLACE
                    && point.features == other.features
                    && point.parts == other.parts
            })
        };
        compared += 1;
        // Of corners that are as far or as deep as others these may be chosen.
        same += usize::from(found.points().iter().all(is_there));
        counts[found.points().len()] += 1;
    }
    assert!(compared > 2000 && same * 20 > compared * 19, "{compared} {same}");
    assert!(counts[1..].iter().all(|&count| count > 50), "{counts:?}");
}

#[test]
fn both_orders_of_a_compound_and_a_plane_are_mirrored() {
    let mut draw = Draw(72);
    let mut several = 0;
    for k in 0..2000 {
        let (shapes, poses) = pair(&mut draw, k);
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        if crate::certified::overlap_of(a, b).0 != Verdict::Touching(()) {
            continue;
        }
        let mut scratch = <Manifolds as PairSolver>::Scratch::default();
        let found = Manifolds::default().measure_at(Accuracy::F32, a, b, &mut scratch);
        let back = Manifolds::default().measure_at(Accuracy::F32, b, a, &mut scratch);
        let (Verdict::Touching(found), Verdict::Touching(mut back)) = (found, back) else {
            panic!("{k}")
        };
        back.mirror();
        assert_eq!(found, back, "{k}");
        several += usize::from(found[0].points().len() > 1);
    }
    assert!(several > 500, "{several}");
}
