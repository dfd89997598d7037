//! Where shapes that are made of parts touch: a manifold for each patch, beside the answers for every two parts.

use super::scenes::Draw;
use super::{PosedSupport, answer_of, solve};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Polytope, Pose, Shape, SupportMap};
use dcd_gjk::mesh::KnownParts;
use dcd_gjk::query::{MeasureAt, MeasureDepth, PartIndex};
use dcd_gjk::{
    Accuracy, Depths, Distances, Manifold, ManifoldSet, Manifolds, PosedShape, Verdict,
    WithAccuracy, certified,
};

/// A grid of squares, two triangles each, whose vertex (i, j) is `at(i, j)`.
pub(super) fn grid(side: u32, at: impl Fn(f64, f64) -> DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let line = side + 1;
    let vertices = (0..line)
        .flat_map(|i| (0..line).map(move |j| (f64::from(i), f64::from(j))))
        .collect::<Vec<_>>();
    let vertices = vertices.into_iter().map(|(i, j)| at(i, j)).collect();
    let square = |i: u32, j: u32| {
        let [a, b, c, d] =
            [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| i * line + j);
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..side).flat_map(|i| (0..side).flat_map(move |j| square(i, j))).collect();
    (vertices, triangles)
}

/// Two grids as one mesh.
fn joined(one: (Vec<DVec3>, Vec<[u32; 3]>), other: (Vec<DVec3>, Vec<[u32; 3]>)) -> Shape {
    let (mut vertices, mut triangles) = one;
    let first = vertices.len() as u32;
    vertices.extend(other.0);
    triangles.extend(other.1.iter().map(|triangle| triangle.map(|k| k + first)));
    Shape::mesh(vertices, triangles).unwrap()
}

/// The parts of a shape as shapes of its own frame.
pub(super) fn parts(shape: &Shape) -> Vec<Shape> {
    match shape {
        Shape::Mesh(mesh) => (0..mesh.triangles().len())
            .map(|k| {
                let triangle = Shape::triangle(mesh.corners(k).unwrap()).unwrap();
                if mesh.swept_radius() > 0.0 {
                    triangle.swept(mesh.swept_radius()).unwrap()
                } else {
                    triangle
                }
            })
            .collect(),
        Shape::Compound(compound) => compound.parts().iter().map(|p| p.placed().clone()).collect(),
        convex => vec![convex.clone()],
    }
}

pub(super) fn part_of(parts: &[Shape], index: Option<PartIndex>) -> &Shape {
    match index {
        None => &parts[0],
        Some(PartIndex::Part(k) | PartIndex::Triangle(k)) => &parts[k as usize],
    }
}

/// How far a point is from a convex body's surface, outside or inside of it: by the distance and the depth of a sphere
/// of radius 0.
pub(super) fn off_surface(point: DVec3, shape: &Shape, pose: &Pose) -> f64 {
    let sphere = Polytope::sphere(0.0).unwrap().into();
    let point = Pose::from_translation(point).unwrap();
    let body = PosedSupport { shape: shape.clone(), pose: *pose };
    let point = PosedSupport { shape: sphere, pose: point };
    match solve(&Depths, &point, &body) {
        Verdict::Touching(depth) => depth.depth,
        _ => match answer_of(&Distances::within(1e6).unwrap(), &point, &body) {
            Some(found) => found.distance,
            None => 0.0,
        },
    }
}

fn moved(pose: &Pose, by: DVec3) -> Pose {
    Pose::from_matrix(*pose.rotation(), pose.translation() + by).unwrap()
}

/// How far two shapes reach past each other along a direction from the first to the second: by their supports.
fn reach_along(normal: DVec3, [a, b]: [(&Shape, &Pose); 2]) -> f64 {
    let farthest = |(shape, pose): (&Shape, &Pose), direction: DVec3| {
        let local = pose.rotation().transpose() * direction;
        local.dot(shape.support(local).point) + shape.radius()
    };
    farthest(a, normal) + farthest(b, -normal) - normal.dot(b.1.translation() - a.1.translation())
}

/// Judges each manifold by the parts that it names, and all of them by every two parts that touch. Returns how many
/// pairs of parts touch.
fn judge(what: &str, found: &ManifoldSet, a: &PosedSupport, b: &PosedSupport) -> usize {
    judge_at(Accuracy::Certified, what, found, [a, b])
}

pub(super) fn judge_at(
    accuracy: Accuracy,
    what: &str,
    found: &ManifoldSet,
    [a, b]: [&PosedSupport; 2],
) -> usize {
    let [parts_a, parts_b] = [a, b].map(|side| parts(&side.shape));
    let far = a.pose.translation().length() + b.pose.translation().length();
    let size = a.shape.reach().min(b.shape.reach());
    let slack = 1e-9 * size + 1e-14 * far;
    assert!(!found.is_empty(), "{what}");
    let whole = answer_of(&Depths, a, b);
    let off = (found[0].points()[0].depth - whole.depth).abs();
    match accuracy {
        Accuracy::Certified => {
            assert_eq!((found[0].normal, off), (whole.normal, 0.0), "{what}");
            // What agrees is in one manifold.
            let others = |k: usize| found[k + 1..].iter().map(move |q| (k, q));
            for (k, other) in (0..found.len()).flat_map(others) {
                let cosine = found[k].normal.dot(other.normal);
                assert!(cosine < 1.0 - 4.9e-7, "{what}: {cosine} {found:?}");
            }
        }
        _ => {
            let bound = found[0].error_bound + whole.error_bound + slack;
            assert!(off <= bound, "{what}: {off} {found:?} {whole:?}");
        }
    }
    let deepest = |manifold: &Manifold| manifold.points()[0].depth;
    assert!(found.is_sorted_by(|p, q| deepest(p) >= deepest(q)), "{what}: {found:?}");
    for manifold in found {
        let Manifold { normal, error_bound: bound, .. } = *manifold;
        assert!((normal.length() - 1.0).abs() < 1e-12 && bound.is_finite(), "{what}: {manifold:?}");
        let lead = [part_of(&parts_a, manifold.parts[0]), part_of(&parts_b, manifold.parts[1])];
        let reach = reach_along(normal, [(lead[0], &a.pose), (lead[1], &b.pose)]);
        assert!((reach - deepest(manifold)).abs() <= bound + slack, "{what}: {reach} {manifold:?}");
        for point in manifold.points() {
            assert!((0.0..=deepest(manifold)).contains(&point.depth), "{what}: {manifold:?}");
            let between = point.point_a - point.point_b - normal * point.depth;
            assert!(between.length() <= bound + slack, "{what}: {manifold:?}");
            let off_a = off_surface(point.point_a, part_of(&parts_a, point.parts[0]), &a.pose);
            let off_b = off_surface(point.point_b, part_of(&parts_b, point.parts[1]), &b.pose);
            assert!(off_a <= bound + slack, "{what}: {off_a} {point:?} {manifold:?}");
            assert!(off_b <= bound + slack, "{what}: {off_b} {point:?} {manifold:?}");
        }
    }
    let mut touching = 0;
    for part_a in &parts_a {
        let in_a = PosedShape { shape: part_a, pose: &a.pose };
        for part_b in &parts_b {
            let in_b = PosedShape { shape: part_b, pose: &b.pose };
            if certified::overlap_of(in_a, in_b).0 != Verdict::Touching(()) {
                continue;
            }
            touching += 1;
            let separates = |manifold: &Manifold| {
                let by = deepest(manifold) + manifold.error_bound + slack;
                let pose = moved(&b.pose, manifold.normal * by);
                let in_b = PosedShape { shape: part_b, pose: &pose };
                certified::overlap_of(in_a, in_b).0 == Verdict::Apart
            };
            if found.iter().any(separates) {
                continue;
            }
            let one = PosedSupport { shape: part_a.clone(), pose: a.pose };
            let other = PosedSupport { shape: part_b.clone(), pose: b.pose };
            let own = answer_of(&Depths, &one, &other);
            let agrees = |manifold: &Manifold| {
                manifold.normal.dot(own.normal) >= 1.0 - 5.1e-7
                    && own.depth <= deepest(manifold) + manifold.error_bound + own.error_bound
            };
            assert!(found.iter().any(agrees), "{what}: {own:?} is in none of {found:?}");
        }
    }
    touching
}

fn is_mirrored(found: &ManifoldSet, back: &ManifoldSet) -> bool {
    let pairs = || found.iter().zip(back.iter());
    found.len() == back.len()
        && pairs().all(|(p, q)| {
            let points = || p.points().iter().zip(q.points());
            (p.normal, p.error_bound, p.points().len())
                == (-q.normal, q.error_bound, q.points().len())
                && p.parts == [q.parts[1], q.parts[0]]
                && points().all(|(x, y)| {
                    (x.point_a, x.point_b, x.depth) == (y.point_b, y.point_a, y.depth)
                        && x.features == [y.features[1], y.features[0]]
                        && x.parts == [y.parts[1], y.parts[0]]
                })
        })
}

/// Floor and wall: a mesh of both, and a compound of two slabs.
fn corners(scale: f64) -> [(&'static str, Shape); 2] {
    let floor = grid(8, |i, j| DVec3::new(i * 0.5, j * 0.5 - 2.0, 0.0) * scale);
    let wall = grid(8, |i, j| DVec3::new(0.0, i * 0.5 - 2.0, j * 0.5) * scale);
    let slab = |half: DVec3, at: DVec3| {
        (Shape::cuboid(half * scale).unwrap(), Pose::from_translation(at * scale).unwrap())
    };
    let slabs = vec![
        slab(DVec3::new(2.5, 2.0, 0.5), DVec3::new(1.5, 0.0, -0.5)),
        slab(DVec3::new(0.5, 2.0, 2.0), DVec3::new(-0.5, 0.0, 2.0)),
    ];
    [("mesh", joined(floor, wall)), ("compound", Shape::compound(slabs).unwrap())]
}

#[test]
fn a_box_in_a_corner_touches_the_floor_and_the_wall() {
    for scale in [1e-3, 1.0, 1e3] {
        for far in [DVec3::ZERO, DVec3::new(1e3, -1e6, 1e5) * scale] {
            for (name, corner) in corners(scale) {
                let cube = Shape::cuboid(DVec3::splat(0.4 * scale)).unwrap();
                let a = PosedSupport::at(&corner, far);
                let b = PosedSupport::at(&cube, far + DVec3::new(0.38, 0.1, 0.39) * scale);
                let what = format!("{name}, {scale}, {far}");
                let found = answer_of(&Manifolds::default(), &a, &b);
                judge(&what, &found, &a, &b);
                let [wall, floor] = &found[..] else { panic!("{what}: {found:?}") };
                for (patch, normal, deep) in [(wall, DVec3::X, 0.02), (floor, DVec3::Z, 0.01)] {
                    assert!(patch.normal.distance(normal) < 1e-9, "{what}: {patch:?}");
                    assert_eq!(patch.points().len(), 4, "{what}: {patch:?}");
                    for point in patch.points() {
                        assert!((point.depth - deep * scale).abs() < 1e-8 * scale, "{patch:?}");
                        let part = part_of(&parts(&corner), point.parts[0]).clone();
                        let along = part.support(normal).point.dot(normal);
                        assert!(along.abs() < 1e-9 * scale, "{what}: not of that plane, {point:?}");
                        assert_eq!(point.parts[1], None);
                    }
                }
                assert!(is_mirrored(&found, &answer_of(&Manifolds::default(), &b, &a)), "{what}");
            }
        }
    }
}

#[test]
fn what_rests_on_one_plane_has_one_manifold_and_what_lies_in_a_fold_has_two() {
    let sphere = Shape::sphere(0.5).unwrap();
    let roof = |slope: f64| {
        let (vertices, triangles) =
            grid(8, |i, j| DVec3::new(i - 4.0, j - 4.0 + 0.1 * i, slope * (i - 4.0).abs()));
        Shape::mesh(vertices, triangles).unwrap()
    };
    // A ridge, planes that hardly bend, and a fold.
    for (slope, count) in [(-0.3, 1), (0.0, 1), (2e-4, 1), (0.01, 2), (0.3, 2)] {
        let a = PosedSupport::at(&roof(slope), DVec3::ZERO);
        let height = 0.49 * (1.0 + slope.max(0.0).powi(2)).sqrt();
        let b = PosedSupport::at(&sphere, DVec3::new(0.0, 0.13, height));
        let what = format!("slope {slope}");
        let found = answer_of(&Manifolds::default(), &a, &b);
        assert!(judge(&what, &found, &a, &b) >= 2, "{what}");
        assert_eq!(found.len(), count, "{what}: {found:?}");
        assert!(is_mirrored(&found, &answer_of(&Manifolds::default(), &b, &a)), "{what}");
    }
}

/// Waves, about flat, folded, or as drawn.
fn terrain(draw: &mut Draw, kind: usize) -> Shape {
    let side = 6;
    let rough = [0.0, 0.02, 0.3, 1e-5][kind % 4];
    let mut heights: Vec<f64> = (0..49).map(|_| draw.unit() * rough).collect();
    heights.push(0.0);
    let (vertices, triangles) = grid(side, |i, j| {
        DVec3::new(i * 0.4 - 1.2, j * 0.4 - 1.2, heights[(i * 7.0 + j) as usize])
    });
    let mesh = Shape::mesh(vertices, triangles).unwrap();
    if kind % 5 == 4 { mesh.swept(0.05).unwrap() } else { mesh }
}

fn bodies() -> Vec<Shape> {
    let mut draw = Draw(5);
    let cuboid = Shape::cuboid(DVec3::new(0.3, 0.2, 0.25)).unwrap();
    let cloud = (0..16).map(|_| draw.vector() * 0.4).collect();
    let arm = |x: f64, turn: DQuat| (cuboid.clone(), Pose::new(turn, DVec3::X * x).unwrap());
    vec![
        cuboid.clone(),
        Shape::sphere(0.3).unwrap(),
        Shape::capsule(0.25, 0.15).unwrap(),
        Shape::hull(cloud).unwrap(),
        cuboid.clone().swept(0.08).unwrap(),
        Shape::cylinder(0.25, 0.2).unwrap(),
        Shape::compound(vec![arm(-0.3, DQuat::IDENTITY), arm(0.3, DQuat::from_rotation_z(0.4))])
            .unwrap(),
    ]
}

/// What is measured at the accuracy of f32 as in a scene, which knows the parts that touch.
fn with_list<S: MeasureDepth>(solver: &S, sides: [&PosedSupport; 2]) -> S::Answer {
    let [a, b] = sides.map(|side| PosedShape { shape: &side.shape, pose: &side.pose });
    let mut touching = Vec::new();
    dcd_gjk::mesh::touching(a, b, &mut Default::default(), &mut touching);
    let known = KnownParts { parts: &touching, depths: &[], at_most: &[] };
    let mut found = S::Answer::default();
    let scratch = &mut Default::default();
    let verdict = solver.measure_parts(Accuracy::F32, known, [a, b], scratch, &mut found);
    assert_eq!(verdict, Verdict::Touching(()));
    found
}

#[test]
fn every_two_parts_that_touch_belong_to_a_manifold() {
    let bodies = bodies();
    let mut draw = Draw(41);
    let (mut touching, mut several) = (0, 0);
    for round in 0..420usize {
        let ground = terrain(&mut draw, round / 7);
        let turn = match round % 3 {
            0 => DQuat::IDENTITY,
            1 => DQuat::from_scaled_axis(draw.vector() * 0.1),
            _ => draw.turn(),
        };
        let far = if round % 4 == 3 { draw.vector() * 1e4 } else { DVec3::ZERO };
        let all = draw.turn();
        let place = DVec3::new(draw.unit() * 0.7, draw.unit() * 0.7, 0.27 + 0.1 * draw.unit());
        let a = PosedSupport::new(ground, all, far);
        let b = PosedSupport::new(bodies[round % 7].clone(), all * turn, far + all * place);
        let what = format!("round {round}");
        let Verdict::Touching(found) = solve(&Manifolds::default(), &a, &b) else { continue };
        judge(&what, &found, &a, &b);
        touching += 1;
        several += usize::from(found.len() > 1);
        let Verdict::Touching(back) = solve(&Manifolds::default(), &b, &a) else {
            panic!("{what}")
        };
        assert!(is_mirrored(&found, &back), "{what}");
        let fast = answer_of(&WithAccuracy::new(Manifolds::default(), Accuracy::F64), &a, &b);
        assert!(!fast.is_empty(), "{what}");
        let solver = WithAccuracy::new(Manifolds::default(), Accuracy::F32);
        let fast = answer_of(&solver, &a, &b);
        judge_at(Accuracy::F32, &what, &fast, [&a, &b]);
        assert!(is_mirrored(&fast, &answer_of(&solver, &b, &a)), "{what}");
        if b.shape.as_polytope().is_some() {
            let listed = with_list(&Manifolds::default(), [&a, &b]);
            judge_at(Accuracy::F32, &what, &listed, [&a, &b]);
            let back = with_list(&Manifolds::default(), [&b, &a]);
            assert!(is_mirrored(&listed, &back), "{what}");
            let depth = with_list(&Depths, [&a, &b]);
            let back = with_list(&Depths, [&b, &a]);
            assert_eq!((back.depth, back.normal), (depth.depth, -depth.normal), "{what}");
            assert_eq!((back.point_a, back.point_b), (depth.point_b, depth.point_a), "{what}");
            assert_eq!(back.error_bound, depth.error_bound, "{what}");
            let due = answer_of(&Depths, &a, &b);
            let off = (depth.depth - due.depth).abs();
            assert!(off <= depth.error_bound + due.error_bound, "{what}: {depth:?} {due:?}");
            assert!(depth.error_bound <= 1e-5, "{what}: {depth:?}");
        }
        // What f32 adds to a bound is millionths of the size, beside what the certified bound holds.
        let [bound, certified] = [fast.error_bound(), found.error_bound()];
        assert!(bound <= certified.max(1e-3) + 1e-5, "{what}: {bound} {certified}");
    }
    assert!(touching > 200 && several > 50, "{touching}, {several}");
}

#[test]
fn meshes_and_compounds_touch_each_other_in_patches() {
    let mut draw = Draw(42);
    let dish = |draw: &mut Draw| terrain(draw, 2);
    let compound = bodies().pop().unwrap();
    let mut several = 0;
    for round in 0..40usize {
        let a = PosedSupport::new(dish(&mut draw), draw.turn(), DVec3::ZERO);
        let other = if round % 2 == 0 { dish(&mut draw) } else { compound.clone() };
        let b = PosedSupport::new(other, draw.turn(), draw.vector() * 0.3);
        let Verdict::Touching(found) = solve(&Manifolds::default(), &a, &b) else { continue };
        judge(&format!("round {round}"), &found, &a, &b);
        several += usize::from(found.len() > 1);
        assert!(is_mirrored(&found, &answer_of(&Manifolds::default(), &b, &a)), "round {round}");
    }
    assert!(several > 10, "{several}");
}

/// Parts of every kind of polytope, turned and near each other.
fn compound(draw: &mut Draw) -> Shape {
    let mut bodies = bodies();
    bodies.truncate(5);
    let count = 2 + draw.turn().x.to_bits() as usize % 4;
    let part = |k: usize| {
        let place = draw.vector() * 0.4;
        (bodies[(k + count) % 5].clone(), Pose::new(draw.turn(), place).unwrap())
    };
    Shape::compound((0..count).map(part).collect()).unwrap()
}

#[test]
fn at_f32_the_parts_of_a_compound_share_the_patches_of_a_mesh() {
    let mut draw = Draw(43);
    let at = Accuracy::F32;
    let (mut touching, mut shared, mut points) = (0, 0, [0; 2]);
    for round in 0..160usize {
        let ground = terrain(&mut draw, round / 4);
        let far = if round % 4 == 3 { draw.vector() * 1e3 } else { DVec3::ZERO };
        let a = PosedSupport::new(ground, draw.turn(), far);
        let b = PosedSupport::new(compound(&mut draw), draw.turn(), far + draw.vector() * 0.4);
        let what = format!("round {round}");
        let Verdict::Touching(certified) = solve(&Manifolds::default(), &a, &b) else { continue };
        touching += 1;
        let manifolds = WithAccuracy::new(Manifolds::default(), at);
        let found = answer_of(&manifolds, &a, &b);
        judge_at(at, &what, &found, [&a, &b]);
        assert!(is_mirrored(&found, &answer_of(&manifolds, &b, &a)), "{what}");
        let of_several = |manifold: &Manifold| {
            manifold.points().iter().any(|point| point.parts[1] != manifold.parts[1])
        };
        shared += usize::from(found.iter().any(of_several));
        let depths = WithAccuracy::new(Depths, at);
        let (depth, due) = (answer_of(&depths, &a, &b), answer_of(&Depths, &a, &b));
        let off = (depth.depth - due.depth).abs();
        assert!(off <= depth.error_bound + due.error_bound, "{what}: {depth:?} {due:?}");
        assert!(depth.error_bound <= 1e-5, "{what}: {depth:?}");
        let back = answer_of(&depths, &b, &a);
        assert_eq!((back.depth, back.normal), (depth.depth, -depth.normal), "{what}");
        assert_eq!((back.point_a, back.point_b), (depth.point_b, depth.point_a), "{what}");
        let [bound, best] = [found.error_bound(), certified.error_bound()];
        assert!(bound <= best.max(1e-3) + 1e-5, "{what}: {bound} {best}");
        for (sum, set) in points.iter_mut().zip([&found, &certified]) {
            *sum += set.iter().map(|one| one.points().len()).sum::<usize>();
        }
    }
    assert!(touching > 80 && shared > 5, "{touching} {shared}");
    assert!(50 * points[0] > 49 * points[1], "{points:?}");
}

#[test]
fn what_no_formula_finds_of_a_mesh_far_from_its_own_origin_is_measured_and_joined() {
    let bodies = bodies();
    let mut draw = Draw(44);
    let far = DVec3::new(3e4, -1e4, 2e4);
    let mut touching = 0;
    for round in 0..60usize {
        let heights: Vec<f64> = (0..49).map(|_| draw.unit() * 1e-5).collect();
        let (vertices, triangles) = grid(6, |i, j| {
            far + DVec3::new(i * 0.4 - 1.2, j * 0.4 - 1.2, heights[(i * 7.0 + j) as usize])
        });
        let a = PosedSupport::at(&Shape::mesh(vertices, triangles).unwrap(), DVec3::ZERO);
        let body = &bodies[[0, 2, 3][round % 3]];
        let turn = DQuat::from_scaled_axis(draw.vector() * [0.0, 1e-4, 3.0][round / 3 % 3]);
        let lowest = (turn * body.support(turn.inverse() * DVec3::NEG_Z).point).z - body.radius();
        let place = DVec3::new(draw.unit() * 0.3, draw.unit() * 0.3, -lowest - 3e-3);
        let b = PosedSupport::new(body.clone(), turn, far + place);
        let what = format!("round {round}");
        let found = answer_of(&Manifolds::default(), &a, &b);
        touching += judge(&what, &found, &a, &b);
        assert!(is_mirrored(&found, &answer_of(&Manifolds::default(), &b, &a)), "{what}");
    }
    assert!(touching > 150, "{touching}");
}

#[test]
fn layers_share_the_corners_of_the_deepest_in_whatever_order_they_are_given() {
    let layer = |from: f64, to: f64| {
        let part = Shape::cuboid(DVec3::new(0.5, 0.5, (to - from) / 2.0)).unwrap();
        (part, Pose::from_translation(DVec3::Z * (from + to) / 2.0).unwrap())
    };
    // What is below is 0.15 m above the bottom of the lower layer, and 0.05 m above that of the upper one.
    let layers = [layer(0.0, 0.1), layer(0.1, 2.0)];
    let layered = |order: [usize; 2]| Shape::compound(order.map(|k| layers[k].clone()).to_vec());
    let sheet = |z: f64| grid(2, |i, j| DVec3::new((i - 1.0) * 0.5, (j - 1.0) * 0.5, z));
    let ((mut vertices, mut triangles), (below, back)) = (sheet(0.1), sheet(0.0));
    triangles.extend(back.iter().map(|&[p, q, r]| [p + 9, r + 9, q + 9]));
    vertices.extend(below);
    let bodies = [
        layered([0, 1]).unwrap(),
        layered([1, 0]).unwrap(),
        Shape::mesh(vertices, triangles).unwrap(),
    ];
    let corner = |k: u32| {
        let side = |bit: u32| if k >> bit & 1 == 0 { -0.5 } else { 0.5 };
        DVec3::new(side(0), side(1), side(2))
    };
    let grounds = [
        Shape::cuboid(DVec3::splat(0.5)).unwrap(),
        Shape::hull((0..8).map(corner).collect()).unwrap(),
        Shape::half_space(DVec3::Z, 0.5).unwrap(),
    ];
    let at = Pose::from_translation(DVec3::Z * -0.35).unwrap();
    for (k, body) in bodies.iter().enumerate() {
        for (j, ground) in grounds.iter().enumerate() {
            let a = PosedShape { shape: body, pose: &Pose::IDENTITY };
            let b = PosedShape { shape: ground, pose: &at };
            for accuracy in [Accuracy::F32, Accuracy::F64, Accuracy::Certified] {
                let what = format!("body {k} on ground {j}, {accuracy:?}");
                let found =
                    Manifolds::default().measure_at(accuracy, a, b, &mut Default::default());
                let Verdict::Touching(found) = found else { panic!("{what}: {found:?}") };
                let [only] = &found[..] else { panic!("{what}: {found:?}") };
                assert!((only.normal + DVec3::Z).length() < 1e-6, "{what}: {only:?}");
                assert_eq!(only.points().len(), 4, "{what}: {only:?}");
                for point in only.points() {
                    assert!((point.depth - 0.15).abs() <= 1e-5, "{what}: {only:?}");
                    assert!(point.point_a.z.abs() <= 1e-5, "{what}: {only:?}");
                }
            }
        }
    }
}
