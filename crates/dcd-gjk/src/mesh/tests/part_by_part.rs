//! Distances and depths of shapes of parts at f64 and certified, beside those of every pair of their parts.

use super::at_f32::{body, mesh, pose};
use super::*;
use crate::distance::{distance, distance_at};
use crate::mesh::{Side, pair};
use crate::query::{Accuracy, MeasureAt};
use crate::{Depths, PairSolver};

/// The parts of a shape, each a shape of its own.
fn parts(placed: PosedShape<'_>) -> Vec<Shape> {
    let side = Side::of(placed);
    (0..side.count()).filter_map(|k| Some(pair::to_shape(side.part(k))?.into_owned())).collect()
}

/// The least certified distance of all pairs of parts; `None` where two touch.
fn least_distance(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<[f64; 2]> {
    let mut least = [f64::INFINITY; 2];
    for in_a in &parts(a) {
        for in_b in &parts(b) {
            let sides = [PosedShape { shape: in_a, ..a }, PosedShape { shape: in_b, ..b }];
            let DistanceResult::Apart(found) = distance(sides[0], sides[1]).0 else { return None };
            least = [least[0].min(found.lower()), least[1].min(found.upper())];
        }
    }
    Some(least)
}

/// The greatest certified depth of all pairs of parts that touch, and a bound.
fn greatest_depth(a: PosedShape<'_>, b: PosedShape<'_>) -> [f64; 2] {
    let mut greatest = [0.0f64; 2];
    for in_a in &parts(a) {
        for in_b in &parts(b) {
            let [a, b] = [PosedShape { shape: in_a, ..a }, PosedShape { shape: in_b, ..b }];
            if let Verdict::Touching(found) = Depths.solve(a, b, &mut Default::default()) {
                let ends = [found.depth - found.error_bound, found.depth + found.error_bound];
                greatest = [greatest[0].max(ends[0]), greatest[1].max(ends[1])];
            }
        }
    }
    greatest
}

#[test]
fn what_f64_leaves_holds_the_nearest_and_the_deepest_part() {
    let mut draw = Draw(std::env::var("DCD_SEED").map_or(5, |seed| seed.parse().expect("a seed")));
    // Spheres, half-spaces, others; touching ones behind those apart.
    let mut counts = [[0; 3]; 2];
    for round in 0..420usize {
        let kind = round / 3 % 14;
        let (mesh, mut body) = (mesh(&mut draw, round), body(&mut draw, kind));
        if kind == 0 && round / 42 % 2 == 0 {
            body = Shape::sphere(0.2 + draw.number()).unwrap();
        }
        let far = if round % 11 == 0 { draw.point(1e4) } else { DVec3::ZERO };
        let mut poses = [pose(&mut draw, round / 42, far), pose(&mut draw, round / 126, far)];
        if round / 42 % 2 == 0 {
            // Nearer: more that touch.
            let between = (poses[1].translation() - poses[0].translation()) * 0.3;
            poses[1] = poses[1].with_translation(poses[0].translation() + between).unwrap();
        }
        let a = PosedShape { shape: &mesh, pose: &poses[0] };
        let b = PosedShape { shape: &body, pose: &poses[1] };
        let due = least_distance(a, b);
        for accuracy in [Accuracy::F64, Accuracy::Certified] {
            let what = format!("{round}, kind {kind}, {accuracy:?}");
            let found = distance_at(accuracy, a, b).0;
            assert_eq!(found, distance_at(accuracy, b, a).0.mirrored(), "{what}");
            match (found, due) {
                (DistanceResult::Apart(found), Some([least, most])) => {
                    assert!(found.lower() <= most && least <= found.upper(), "{what}: {found:?}");
                    let is_certified = accuracy == Accuracy::Certified && kind != 4 && kind != 5;
                    let sharp = if is_certified { 1e-12 } else { 1e-9 };
                    let bound = sharp * found.distance + 1e-14 * (2.0 + far.length());
                    assert!(found.error_bound <= bound, "{what}: {found:?}");
                }
                (DistanceResult::Touching, None) => {}
                // Of curved shapes f64 leaves open what just touches.
                (found, due) => panic!("{what}: {found:?} {due:?}"),
            }
            if due.is_some() {
                continue;
            }
            let depth = |a, b| Depths.measure_at(accuracy, a, b, &mut Default::default());
            let (found, back) = (depth(a, b), depth(b, a));
            assert_eq!(found, back.map(|found| found.mirrored()), "{what}");
            let Verdict::Touching(found) = found else { panic!("{what}: {found:?}") };
            let [least, most] = greatest_depth(a, b);
            let ends = [found.depth - found.error_bound, found.depth + found.error_bound];
            assert!(ends[0] <= most && least <= ends[1], "{what}: {found:?} {least} {most}");
        }
        counts[usize::from(due.is_none())][kind.min(2)] += 1;
    }
    assert!(counts.as_flattened().iter().all(|&count| count > 1), "{counts:?}");
}

#[test]
fn triangles_a_hair_nearer_than_others_are_not_passed_by() {
    let mut draw = Draw(9);
    let mut nearer = 0;
    for round in 0..60u32 {
        // Triangles of their own, each a little higher or lower than its neighbours.
        let at = |k: u32| DVec3::new(f64::from(k % 8), f64::from(k / 8), 0.0) * 0.1;
        let corners = [DVec3::ZERO, DVec3::X * 0.1, DVec3::Y * 0.1];
        let vertices = (0..64).flat_map(|k| {
            let height = DVec3::Z * (draw.number() * 1e-10);
            corners.map(|corner| at(k) + corner + height)
        });
        let vertices: Vec<DVec3> = vertices.collect();
        let triangles = (0..64).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mesh = Shape::mesh(vertices, triangles).unwrap();
        let body = match round % 3 {
            0 => Shape::cuboid(DVec3::new(0.3, 0.2, 0.1)).unwrap(),
            1 => Shape::hull((0..8).map(|_| draw.point(0.2) * DVec3::new(1.0, 1.0, 0.0)).collect())
                .unwrap(),
            _ => Shape::sphere(0.1).unwrap(),
        };
        let pose = Pose::from_translation(DVec3::new(0.4, 0.4, 0.3)).unwrap();
        let a = PosedShape { shape: &mesh, pose: &Pose::IDENTITY };
        let b = PosedShape { shape: &body, pose: &pose };
        let [_, most] = least_distance(a, b).unwrap();
        let DistanceResult::Apart(found) = distance(a, b).0 else { panic!("{round}") };
        let off = (found.distance - most).abs();
        assert!(off <= 2.0 * found.error_bound + 1e-15, "{round}: {found:?} {most}");
        let in_f32 = distance_at(Accuracy::F32, a, b).0;
        nearer += usize::from(
            matches!(in_f32, DistanceResult::Apart(other) if other.distance > most + 1e-12),
        );
    }
    // Those that are passed by where less is asked for.
    assert!(nearer > 5, "{nearer}");
}
