//! Distances of meshes at the accuracy of f32, and depths of spheres and half-spaces, beside the certified ones of all
//! pairs of parts.

use super::*;
use crate::distance::{Distance, distance_at};
use crate::mesh::Limited;
use crate::query::{Accuracy, MeasureAt};
use crate::{Depths, closed};

/// About a metre across; each may be rounded.
pub(super) fn body(draw: &mut Draw, kind: usize) -> Shape {
    let half = draw.point(0.4).abs() + 0.05;
    let made = match kind {
        0 => Shape::sphere(half.x),
        1 => Shape::half_space(draw.point(1.0) + DVec3::Z * 0.01, 0.0),
        2 => Shape::capsule(half.x, half.y),
        3 => Shape::cuboid(half),
        4 => Shape::cylinder(half.x, half.y),
        5 => Shape::cone(half.x, half.y),
        6 => Ok(draw.hull(0.7)),
        7 => Shape::triangle([draw.point(0.7), draw.point(0.7), draw.point(0.7)]),
        8 => Shape::cuboid(DVec3::new(half.x, 0.0, half.z)),
        _ => return draw.compound(1 + kind % 5, 0.6),
    };
    let radius = if draw.number() < 0.3 { 0.1 } else { 0.0 };
    made.unwrap().rounded(radius).unwrap()
}

/// Strewn triangles, needles and points among them; a wavy sheet; a level one, of which many corners are as near and
/// as low as any other.
pub(super) fn mesh(draw: &mut Draw, round: usize) -> Shape {
    let made = match round % 3 {
        0 => draw.mesh(1 + round % 61, 0.7),
        sheet => {
            let side = 2 + round as u32 % 9;
            let at = |k: u32| {
                let [x, y] = [k % side, k / side].map(|j| f64::from(j) / f64::from(side - 1) - 0.5);
                DVec3::new(
                    x,
                    y,
                    if sheet == 1 { 0.1 * (7.0 * x).sin() * (5.0 * y).cos() } else { 0.0 },
                )
            };
            let cells = (0..side * (side - 1)).filter(|k| (k + 1) % side > 0);
            let square = |k: u32| [[k, k + 1, k + side], [k + 1, k + side + 1, k + side]];
            Shape::mesh((0..side * side).map(at).collect(), cells.flat_map(square).collect())
                .unwrap()
        }
    };
    let Shape::Mesh(mesh) = &made else { panic!("no mesh") };
    let radius = if round % 4 == 3 { 0.05 } else { 0.0 };
    Shape::from(Mesh::clone(mesh).rounded(radius).unwrap())
}

/// A pose in reach, turned by right angles or not at all one time in three each.
pub(super) fn pose(draw: &mut Draw, round: usize, far: DVec3) -> Pose {
    let pose = draw.pose(0.9);
    let turn = match round % 3 {
        0 => DMat3::IDENTITY,
        1 => DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
        _ => *pose.rotation(),
    };
    Pose::from_matrix(turn, pose.translation() + far).unwrap()
}

/// What is found of a mesh in f32.
fn in_f32(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<DistanceResult> {
    match crate::mesh::distance_in_f32([a, b], f64::MAX)? {
        Limited::Known(found) => Some(found),
        Limited::Beyond => None,
    }
}

/// What is found at once.
fn at_once(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<DistanceResult> {
    closed::level::distance(Accuracy::F32, a, b)
        .or_else(|| closed::centred::distance(Accuracy::F32, a, b))
        .or_else(|| in_f32(a, b))
}

fn check_distance(what: &str, found: &Distance, best: &Distance, sides: [PosedShape<'_>; 2]) {
    let off = (found.distance - best.distance).abs();
    assert!(off <= found.error_bound + best.error_bound, "{what}: {found:?} {best:?}");
    let bounded = sides.iter().filter(|side| side.shape.is_bounded());
    let size: f64 = bounded.map(|side| side.shape.reach() + side.shape.radius()).sum();
    let far = sides.iter().map(|side| side.pose.translation().length()).fold(0.0, f64::max);
    assert!(found.error_bound <= 4e-6 * size + 1e-14 * far, "{what}: {found:?}");
    assert!((found.normal.length() - 1.0).abs() < 1e-12, "{what}: {found:?}");
    let between = found.point_b - found.point_a - found.normal * found.distance;
    assert!(between.length() < 1e-3 * size + 1e-14 * far, "{what}: {found:?}");
}

#[test]
fn at_the_accuracy_of_f32_distances_and_depths_hold_the_certified_ones() {
    // Another seed by `DCD_SEED`.
    let seed = std::env::var("DCD_SEED").map_or(3, |seed| seed.parse().expect("a seed"));
    let mut draw = Draw(seed);
    let (mut apart, mut touching, mut deep, mut open) = (0, 0, 0, 0);
    for round in 0..1500usize {
        let kind = round / 3 % 14;
        let (mesh, body) = (mesh(&mut draw, round), body(&mut draw, kind));
        let far = if round % 11 == 0 { draw.point(1e4) } else { DVec3::ZERO };
        let poses = [pose(&mut draw, round / 42, far), pose(&mut draw, round / 126, far)];
        let a = PosedShape { shape: &mesh, pose: &poses[0] };
        let b = PosedShape { shape: &body, pose: &poses[1] };
        let what = format!("{round}, kind {kind}");
        let found = at_once(a, b);
        assert_eq!(found, at_once(b, a).map(DistanceResult::mirrored), "{what}");
        let truth = certified::overlap_of(a, b).0;
        match found {
            Some(DistanceResult::Apart(found)) => {
                assert_eq!(truth, Verdict::Apart, "{what}: {found:?}");
                let DistanceResult::Apart(best) = crate::distance::distance(a, b).0 else {
                    panic!("{what}: {found:?}");
                };
                check_distance(&what, &found, &best, [a, b]);
                let there = DistanceResult::Apart(found);
                assert_eq!(distance_at(Accuracy::F32, a, b).0, there, "{what}");
                apart += 1;
            }
            Some(found) => {
                assert_eq!((found, truth), (DistanceResult::Touching, Verdict::Touching(())));
                touching += 1;
            }
            None => open += 1,
        }
        let depth = |a, b| closed::gap(Accuracy::F32, a, b)?.depth();
        let Some(found) = depth(a, b) else { continue };
        assert_eq!(Some(found), depth(b, a).map(|found| found.mirrored()), "{what}");
        let Verdict::Touching(best) =
            Depths.measure_at(Accuracy::Certified, a, b, &mut Default::default())
        else {
            panic!("{what}: {found:?}");
        };
        let off = (found.depth - best.depth).abs();
        assert!(off <= found.error_bound + best.error_bound, "{what}: {found:?} {best:?}");
        let between = found.point_a - found.point_b - found.normal * found.depth;
        assert!(between.length() < 1e-12 * (1.0 + far.length()), "{what}: {found:?}");
        deep += 1;
    }
    let all = [apart, touching, deep, open];
    assert!(apart > 500 && touching > 200 && deep > 40 && open < 100, "{all:?}");
}
