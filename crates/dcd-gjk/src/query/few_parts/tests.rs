//! Parts as they were given beside parts as they are placed.

use super::{Wanted, depth, distance, may_be_nearest, name, touching};
use crate::distance::{DistanceResult, distance as certified_distance, gap_along};
use crate::motion::tests::Draw;
use crate::query::{Accuracy, Feature, MeasureAt};
use crate::{Depths, Manifolds, PosedShape, Verdict, certified, mesh};
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Pose, Shape};

fn pose(draw: &mut Draw, reach: f64, is_turned: bool) -> Pose {
    let turn = if is_turned { draw.vector() * 3.0 } else { DVec3::ZERO };
    Pose::new(DQuat::from_scaled_axis(turn).normalize(), draw.vector() * reach).unwrap()
}

fn convex(draw: &mut Draw, k: usize) -> Shape {
    let half = draw.vector().abs() * 0.3 + 0.05;
    let made = match k % 9 {
        0 | 5 => Shape::sphere(half.x),
        1 | 6 | 7 => Shape::cuboid(half),
        2 => Shape::capsule(half.x, half.y),
        3 => Shape::cylinder(half.x, half.y),
        8 => Shape::triangle([0; 3].map(|_| draw.vector() * 0.4)),
        _ => Shape::cuboid(half).and_then(|cuboid| cuboid.rounded(0.05)),
    };
    made.unwrap()
}

/// Of one to five parts; some in a row whose faces meet.
fn compound(draw: &mut Draw, k: usize) -> Shape {
    if k.is_multiple_of(4) {
        let at = |x: f64| Pose::from_translation(DVec3::X * x).unwrap();
        let cube = || Shape::cuboid(DVec3::splat(0.25)).unwrap();
        return Shape::compound([-0.5, 0.0, 0.5].map(|x| (cube(), at(x))).to_vec()).unwrap();
    }
    let parts = (0..1 + k % 5).map(|j| {
        let shape = convex(draw, j + k / 4);
        (shape, pose(draw, 0.3, !j.is_multiple_of(3)))
    });
    Shape::compound(parts.collect()).unwrap()
}

/// A compound and another shape, some far from the world's origin.
fn pair(draw: &mut Draw, k: usize) -> ([Shape; 2], [Pose; 2]) {
    let one = compound(draw, k);
    let other = match k % 3 {
        0 => compound(draw, k / 3 + 1),
        _ if k.is_multiple_of(13) => Shape::half_space(draw.vector(), 0.0).unwrap(),
        _ => convex(draw, k / 2),
    };
    let far = if k.is_multiple_of(17) { DVec3::new(3e3, -1e3, 2e3) } else { DVec3::ZERO };
    let poses = [pose(draw, 0.4, !k.is_multiple_of(5)), pose(draw, 0.4, !k.is_multiple_of(7))];
    let moved = |pose: Pose| pose.with_translation(pose.translation() + far).unwrap();
    let (shapes, poses) = ([one, other], poses.map(moved));
    match k % 2 {
        0 => (shapes, poses),
        _ => {
            let ([a, b], [p, q]) = (shapes, poses);
            ([b, a], [q, p])
        }
    }
}

/// By the seed that `DCD_SEED` names, else by this one.
fn draw(seed: u64) -> Draw {
    Draw(std::env::var("DCD_SEED").map_or(seed, |seed| seed.parse().expect("a seed")))
}

#[test]
fn depths_and_distances_of_few_parts_are_those_of_the_placed_parts() {
    let mut draw = draw(12);
    let [mut deep, mut apart, mut asked] = [0; 3];
    for k in 0..3000 {
        let (shapes, poses) = pair(&mut draw, k);
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        let mut scratch = Default::default();
        let at = if k / 2 % 2 == 0 { Accuracy::F32 } else { Accuracy::F64 };
        let found = depth(at, [a, b], &mut scratch);
        assert_eq!(found, depth(at, [b, a], &mut scratch).map(|found| found.mirrored()), "{k}");
        let gap = distance(at, [a, b]);
        assert_eq!(gap, distance(at, [b, a]).map(|found| found.mirrored()), "{k}");
        asked += 1;
        // Of depths and distances, metres: at f32 what is promised of pairs of that size, at f64 1e-10 of a depth at most.
        let [of_depth, of_gap] = if at == Accuracy::F32 { [1e-5, 2e-5] } else { [5e-11, 2e-10] };
        let truth = Depths.measure_at(Accuracy::Certified, a, b, &mut scratch);
        if let Some(found) = found {
            let Verdict::Touching(best) = truth else { panic!("{k}: {truth:?}") };
            let off = (found.depth - best.depth).abs();
            assert!(off <= found.error_bound + best.error_bound, "{k}: {found:?} {best:?}");
            assert!(found.error_bound < of_depth, "{k}: {found:?}");
            deep += 1;
        }
        if let Some(gap) = gap {
            let DistanceResult::Apart(best) = certified_distance(a, b).0 else {
                panic!("{k}: {gap:?}")
            };
            let off = (gap.distance - best.distance).abs();
            assert!(off <= gap.error_bound + best.error_bound, "{k}: {gap:?} {best:?}");
            assert!(gap.error_bound < of_gap, "{k}: {gap:?}");
            assert!(found.is_none(), "{k}");
            apart += 1;
        }
    }
    assert!(deep > 1000 && apart > 500 && asked > deep, "{deep} {apart}");
}

/// The parts of a shape as they are placed.
fn placed(shape: &Shape) -> Vec<&Shape> {
    match shape {
        Shape::Compound(compound) => compound.parts().iter().map(|part| part.placed()).collect(),
        other => vec![other],
    }
}

fn touch(a: PosedShape<'_>, b: PosedShape<'_>) -> bool {
    certified::overlap_of(a, b).0 == Verdict::Touching(())
}

#[test]
fn what_f64_leaves_of_few_parts_holds_the_nearest_and_the_deepest() {
    let mut draw = draw(16);
    let (mut deep, mut apart, mut fewer) = (0, 0, 0);
    for k in 0..1500 {
        let (shapes, poses) = pair(&mut draw, k);
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        let all = || {
            let pairs = (0..).zip(placed(a.shape)).flat_map(|(j, in_a)| {
                (0..).zip(placed(b.shape)).map(move |(l, in_b)| ([j, l], in_a, in_b))
            });
            pairs.map(|(pair, in_a, in_b)| {
                (pair, [PosedShape { shape: in_a, ..a }, PosedShape { shape: in_b, ..b }])
            })
        };
        if let Some(near) = may_be_nearest([a, b]) {
            let distance_of = |[a, b]: [PosedShape<'_>; 2]| match certified_distance(a, b).0 {
                DistanceResult::Apart(found) => found.distance,
                found => panic!("{k}: {found:?}"),
            };
            let of_all = all().map(|(_, sides)| distance_of(sides)).fold(f64::INFINITY, f64::min);
            let of_near = all().filter(|(pair, _)| near.contains(pair));
            let least = of_near.map(|(_, sides)| distance_of(sides)).fold(f64::INFINITY, f64::min);
            assert_eq!(least, of_all, "{k}: {near:?}");
            fewer += usize::from(near.len() < all().count());
            apart += 1;
        }
        let mut scratch = Default::default();
        let Some(touching) = touching(Wanted::All, [a, b], &mut scratch) else { continue };
        let deepest = super::touching(Wanted::Deepest, [a, b], &mut scratch).unwrap();
        let mut greatest = [0.0f64; 2];
        for (pair, [a, b]) in all() {
            let bound = touching.iter().find(|(of, _)| *of == pair).map(|&(_, bound)| bound);
            match (Depths.measure_at(Accuracy::Certified, a, b, &mut scratch), bound) {
                (Verdict::Touching(found), Some(bound)) if touch(a, b) => {
                    let least = found.depth - found.error_bound;
                    assert!(least <= bound, "{k}: {found:?} {bound}");
                    let is_left = deepest.iter().any(|(of, _)| *of == pair);
                    // Of those that are left at most, of the others at least.
                    let (number, end) =
                        if is_left { (0, found.depth + found.error_bound) } else { (1, least) };
                    greatest[number] = greatest[number].max(end);
                }
                (_, None) => assert!(!touch(a, b), "{k}: {pair:?}"),
                (found, _) => panic!("{k}: {found:?}"),
            }
        }
        assert!(greatest[0] >= greatest[1], "{k}: {greatest:?} {deepest:?}");
        deep += 1;
    }
    assert!(deep > 300 && apart > 100 && fewer > 50, "{deep} {apart} {fewer}");
}

#[test]
fn what_a_compound_sees_of_a_sphere_is_where_the_world_has_it() {
    let mut draw = draw(15);
    let (mut deep, mut apart) = (0, 0);
    for k in 0..3000 {
        let ([one, _], poses) = pair(&mut draw, 2 * k);
        let radius = draw.vector().x.abs() * 0.3 + 0.05;
        let sphere = Shape::sphere(radius).unwrap();
        let a = PosedShape { shape: &one, pose: &poses[0] };
        let b = PosedShape { shape: &sphere, pose: &poses[1] };
        let centre = poses[1].translation();
        let is_due = |normal: DVec3, point: DVec3| {
            (normal.length() - 1.0).abs() < 1e-12
                && point.distance(centre - normal * radius) < 1e-10
        };
        if let Some(found) = depth(Accuracy::F32, [a, b], &mut Default::default()) {
            assert!(is_due(found.normal, found.point_b), "{k}: {found:?}");
            let set = Manifolds::default().measure_at(Accuracy::F32, a, b, &mut Default::default());
            let Verdict::Touching(set) = set else { panic!("{k}") };
            let point = set[0].points()[0];
            assert!(is_due(set[0].normal, point.point_b), "{k}: {set:?}");
            deep += 1;
        }
        if let Some(found) = distance(Accuracy::F32, [a, b]) {
            assert!(is_due(found.normal, found.point_b), "{k}: {found:?}");
            apart += 1;
        }
    }
    assert!(deep > 500 && apart > 500, "{deep} {apart}");
}

#[test]
fn a_face_of_a_part_has_the_name_that_it_has_where_it_is_placed() {
    let mut draw = draw(14);
    for k in 0..300usize {
        let cuboid = Shape::cuboid(draw.vector().abs() + 0.05).unwrap();
        let at = pose(&mut draw, 1.0, !k.is_multiple_of(10));
        let compound = Shape::compound(vec![(cuboid.clone(), at)]).unwrap();
        let whole = PosedShape { shape: &compound, pose: &Pose::IDENTITY };
        let Shape::Compound(placed) = &compound else { panic!("{k}") };
        let corners = |shape: &Shape, index: u32| {
            let facets = shape.as_polytope().unwrap().facets();
            let mut corners = facets.corners(&facets.facets()[index as usize]).to_vec();
            corners.sort_unstable();
            corners
        };
        for face in 0..6 {
            let Some(Feature::Face(there)) = name(whole, 0, Feature::Face(face)) else {
                panic!("{k}: face {face} has no name");
            };
            let due = corners(&cuboid, face);
            assert_eq!(due, corners(placed.parts()[0].placed(), there), "{k}: face {face}");
        }
        let edge = Feature::Edge(1, 3);
        assert_eq!(name(whole, 0, edge), Some(edge));
    }
}

#[test]
fn every_two_parts_that_touch_belong_to_a_manifold() {
    let mut draw = draw(13);
    let (mut pairs_seen, mut several) = (0, 0);
    for k in 0..2000 {
        let (shapes, poses) = pair(&mut draw, k);
        let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
        if depth(Accuracy::F32, [a, b], &mut Default::default()).is_none() {
            continue;
        }
        let at = Accuracy::F32;
        let Verdict::Touching(set) =
            Manifolds::default().measure_at(at, a, b, &mut Default::default())
        else {
            panic!("{k}: not measured");
        };
        several += usize::from(set.len() > 1);
        for manifold in &set {
            assert!(!manifold.points().is_empty(), "{k}");
            for point in manifold.points() {
                let between = point.point_a - point.point_b - manifold.normal * point.depth;
                assert!(between.length() < 1e-6 + manifold.error_bound, "{k}: {manifold:?}");
                assert_eq!(
                    point.parts.map(|part| part.is_some()),
                    manifold.parts.map(|p| p.is_some())
                );
            }
        }
        let mut touching = Vec::new();
        mesh::touching(a, b, &mut Default::default(), &mut touching);
        for [i, j] in touching {
            let part = |side: PosedShape<'_>, k: u32| match side.shape {
                Shape::Compound(compound) => compound.parts()[k as usize].placed().clone(),
                other => other.clone(),
            };
            let (in_a, in_b) = (part(a, i), part(b, j));
            if !(in_a.is_bounded() && in_b.is_bounded()) {
                continue;
            }
            pairs_seen += 1;
            let (in_a, in_b) = (PosedShape { shape: &in_a, ..a }, PosedShape { shape: &in_b, ..b });
            let Verdict::Touching(own) =
                Depths.measure_at(Accuracy::Certified, in_a, in_b, &mut Default::default())
            else {
                continue;
            };
            let is_alike = |normal: DVec3| own.normal.dot(normal) >= 1.0 - 1e-6;
            let is_separated = |normal: DVec3, least: f64| {
                gap_along(in_a, in_b, normal).is_some_and(|gap| gap >= -least - 1e-9)
            };
            let belongs = set.iter().any(|m| {
                let depth = m.points()[0].depth + m.error_bound;
                is_alike(m.normal) || is_separated(m.normal, depth)
            });
            assert!(belongs, "{k}: parts {i} {j}, {own:?}, {set:?}");
        }
    }
    assert!(pairs_seen > 1000 && several > 100, "{pairs_seen} {several}");
}

/// A convex shape of about that size, or a half-space at about that distance.
fn sized(draw: &mut Draw, k: usize, size: f64) -> Shape {
    let half = draw.vector().abs() * 0.3 * size + 0.02 * size;
    let made = match k % 8 {
        0 => Shape::sphere(half.x),
        1 | 5 => Shape::cuboid(half),
        2 => Shape::capsule(half.x, half.y),
        3 => Shape::cylinder(half.x, half.y),
        4 => Shape::triangle([0; 3].map(|_| draw.vector() * 0.4 * size)),
        6 => Shape::cone(half.x, half.y),
        _ => Shape::cuboid(half).and_then(|cuboid| cuboid.rounded(0.1 * size)),
    };
    made.unwrap()
}

/// The pose with a matrix that is off a rotation by about that.
fn tilted(draw: &mut Draw, pose: &Pose, off: f64) -> Pose {
    let [x, y, z] = [0; 3].map(|_| draw.vector() * off);
    let rotation = *pose.rotation() + DMat3::from_cols(x, y, z);
    Pose::from_matrix(rotation, pose.translation()).unwrap()
}

/// Of any rank, of sizes far apart, and at poses that are hardly rotations.
#[test]
fn bounds_of_few_parts_hold_at_every_rank() {
    let mut draw = draw(16);
    let (mut deep, mut apart) = (0, 0);
    for k in 0..4000usize {
        let size = [1e-6, 1e-3, 1.0, 1e6][k % 4];
        let other_size = size * [1.0, 1e-3, 30.0][k / 4 % 3];
        let parts = (0..1 + k % 5).map(|j| {
            let shape = sized(&mut draw, j + k / 7, size);
            (shape, pose(&mut draw, 0.3 * size, j > 0))
        });
        let one = Shape::compound(parts.collect()).unwrap();
        let other = match k % 9 {
            0 => Shape::half_space(draw.vector() * 3.0, draw.vector().x * size).unwrap(),
            1 => {
                let part = (sized(&mut draw, k / 3, other_size), pose(&mut draw, 0.2 * size, true));
                Shape::compound(vec![part]).unwrap()
            }
            _ => sized(&mut draw, k / 3, other_size),
        };
        let far = draw.vector() * size * [0.0, 1.0, 300.0][k / 5 % 3];
        let off = [0.0, 1e-13, 3e-13, 1e-8][k / 11 % 4];
        let poses = [(); 2].map(|()| {
            let pose = pose(&mut draw, 0.5 * size, k % 13 > 0);
            let pose = pose.with_translation(pose.translation() + far).unwrap();
            tilted(&mut draw, &pose, off)
        });
        let [a, b] = [
            PosedShape { shape: &one, pose: &poses[0] },
            PosedShape { shape: &other, pose: &poses[1] },
        ];
        let mut scratch = Default::default();
        if let Some(found) = depth(Accuracy::F32, [a, b], &mut scratch) {
            let truth = Depths.measure_at(Accuracy::Certified, a, b, &mut scratch);
            let Verdict::Touching(best) = truth else { panic!("{k}: {truth:?}") };
            let off = (found.depth - best.depth).abs();
            assert!(off <= found.error_bound + best.error_bound, "{k}: {found:?} {best:?}");
            assert!((found.normal.length() - 1.0).abs() < 4.0 * f64::EPSILON, "{k}: {found:?}");
            deep += 1;
        }
        if let Some(gap) = distance(Accuracy::F32, [a, b]) {
            let DistanceResult::Apart(best) = certified_distance(a, b).0 else {
                panic!("{k}: {gap:?}")
            };
            let off = (gap.distance - best.distance).abs();
            assert!(off <= gap.error_bound + best.error_bound, "{k}: {gap:?} {best:?}");
            assert!((gap.normal.length() - 1.0).abs() < 4.0 * f64::EPSILON, "{k}: {gap:?}");
            apart += 1;
        }
    }
    assert!(deep > 200 && apart > 600, "{deep} {apart}");
}

#[test]
fn no_part_is_lost_beside_a_triangle_whose_area_underflows() {
    let pair = |radius: f64, height: f64, x: f64| {
        let ball = || Shape::sphere(radius).unwrap();
        let place =
            Pose::from_translation(DVec3::new(if radius < 0.5 { 1.0 } else { 0.95 }, height, 0.0));
        let balls = Shape::compound(vec![(ball(), Pose::IDENTITY), (ball(), place.unwrap())]);
        let edge = 1.58e-81;
        let corners = [DVec3::X * x, DVec3::new(x, edge, 0.0), DVec3::new(x, 0.0, edge)];
        (balls.unwrap(), Shape::triangle(corners).unwrap())
    };
    let at = &Pose::IDENTITY;
    for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
        let (balls, triangle) = pair(1.0, 0.999, 0.95);
        let (a, b) =
            (PosedShape { shape: &balls, pose: at }, PosedShape { shape: &triangle, pose: at });
        let found = Depths.measure_at(accuracy, a, b, &mut Default::default());
        let Verdict::Touching(found) = found else { panic!("{found:?}") };
        assert!((found.depth - 0.05).abs() <= found.error_bound + 1e-15, "{accuracy:?} {found:?}");
        let (balls, triangle) = pair(0.1, 1.05, 1.0);
        let (a, b) =
            (PosedShape { shape: &balls, pose: at }, PosedShape { shape: &triangle, pose: at });
        let DistanceResult::Apart(found) = crate::distance::distance_at(accuracy, a, b).0 else {
            panic!("{accuracy:?}")
        };
        assert!(
            (found.distance - 0.9).abs() <= found.error_bound + 1e-15,
            "{accuracy:?} {found:?}"
        );
    }
}

#[test]
fn the_bound_of_a_depth_covers_parts_of_which_it_is_not_known_whether_they_touch() {
    let at = |x: f64, z: f64| Pose::from_translation(DVec3::new(x, 0.0, z)).unwrap();
    let parts = vec![
        (Shape::cuboid(DVec3::ONE).unwrap(), at(0.0, 0.0)),
        (Shape::cylinder(1.0, 1.0).unwrap(), at(3.0, -8.88e-16)),
    ];
    let compound = Shape::compound(parts).unwrap();
    let slab = Shape::cuboid(DVec3::new(10.0, 10.0, 1.0)).unwrap();
    let (here, below) = (at(0.0, 0.0), at(0.0, -2.0));
    let sides =
        [PosedShape { shape: &compound, pose: &here }, PosedShape { shape: &slab, pose: &below }];
    for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
        for [a, b] in [sides, [sides[1], sides[0]]] {
            let found = Depths.measure_at(accuracy, a, b, &mut Default::default());
            if let Verdict::Touching(found) = found {
                assert!(found.depth + found.error_bound >= 8.88e-16, "{accuracy:?} {found:?}");
            }
            let found = Manifolds::default().measure_at(accuracy, a, b, &mut Default::default());
            if let Verdict::Touching(set) = found {
                let depths = set.iter().flat_map(|manifold| {
                    manifold.points().iter().map(|point| point.depth + manifold.error_bound)
                });
                let most = depths.fold(0.0, f64::max);
                assert!(most >= 8.88e-16, "{accuracy:?} {set:?}");
            }
        }
    }
}
