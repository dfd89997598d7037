//! The search against exact brute force over all pairs of parts.

mod at_f32;
mod at_once;
mod measures;
mod part_by_part;

use super::{Scratch, overlap, overlap_on, touching};
use crate::distance::DistanceResult;
use crate::{Method, PosedShape, PosedSupport, Reason, Verdict, certified};
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Mesh, Polytope, Pose, Shape, Support, SupportMap};
use dcd_simd::Path;
use std::sync::Arc;

/// Numbers in [0, 1) from a seed.
struct Draw(u64);

impl Draw {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self, half: f64) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| (2.0 * self.number() - 1.0) * half))
    }

    fn pose(&mut self, half: f64) -> Pose {
        let [x, y, z] = self.point(1.0).to_array();
        let turn = DQuat::from_xyzw(x, y, z, self.number() + 0.1).normalize();
        Pose::new(turn, self.point(half)).unwrap()
    }

    /// Triangles strewn in a cube, some of them segments or points.
    fn mesh(&mut self, triangles: usize, scale: f64) -> Shape {
        let mut vertices = Vec::new();
        for k in 0..triangles {
            let at = self.point(scale);
            let [b, c] = [(); 2].map(|()| at + self.point(0.7 * scale));
            let b = if k % 7 == 3 { at } else { b };
            vertices.extend([at, b, if k % 11 == 3 { b } else { c }]);
        }
        let corners = |k: u32| [3 * k, 3 * k + 1, 3 * k + 2];
        Shape::mesh(vertices, (0..triangles as u32).map(corners).collect()).unwrap()
    }

    fn hull(&mut self, scale: f64) -> Shape {
        let at = self.point(scale);
        Shape::hull((0..12).map(|_| at + self.point(0.3 * scale)).collect()).unwrap()
    }

    fn compound(&mut self, parts: usize, scale: f64) -> Shape {
        let part = |k: usize, draw: &mut Self| match k % 3 {
            0 => (Shape::cuboid(DVec3::splat(0.2 * scale)).unwrap(), draw.pose(scale)),
            1 => (Shape::sphere(0.3 * scale).unwrap(), draw.pose(scale)),
            _ => (draw.hull(scale), Pose::IDENTITY),
        };
        Shape::compound((0..parts).map(|k| part(k, self)).collect()).unwrap()
    }
}

/// The parts as polytopes in the frame of their shape.
fn polytopes(shape: &Shape) -> Vec<Polytope> {
    match shape {
        Shape::Polytope(polytope) => vec![Polytope::clone(polytope)],
        Shape::Compound(compound) => {
            compound.parts().iter().map(|p| p.placed().as_polytope().unwrap().clone()).collect()
        }
        Shape::Mesh(mesh) => (0..mesh.triangles().len())
            .map(|k| {
                let hull = Polytope::hull(mesh.corners(k).unwrap().to_vec()).unwrap();
                hull.rounded(mesh.swept_radius()).unwrap()
            })
            .collect(),
        other => panic!("{other:?} is no union of polytopes"),
    }
}

/// Every touching pair of parts, by the exact method alone.
fn brute_force(a: PosedShape<'_>, b: PosedShape<'_>) -> Vec<[u32; 2]> {
    let (parts_a, parts_b) = (polytopes(a.shape), polytopes(b.shape));
    let mut pairs = Vec::new();
    for (i, in_a) in (0u32..).zip(&parts_a) {
        for (j, in_b) in (0u32..).zip(&parts_b) {
            let (a, b) =
                (PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose));
            if certified::overlap_exactly(a, b) {
                pairs.push([i, j]);
            }
        }
    }
    pairs
}

/// Compares every kind of search with brute force. Returns how many pairs of parts touch.
fn check(a: PosedShape<'_>, b: PosedShape<'_>, scratch: &mut Scratch, what: &str) -> usize {
    let expected = brute_force(a, b);
    let touches = !expected.is_empty();
    let verdict = if touches { Verdict::Touching(()) } else { Verdict::Apart };
    let there = overlap(a, b, scratch);
    assert_eq!(there.0, verdict, "{what}");
    assert_eq!(overlap(b, a, scratch), there, "{what}: the other order");
    for path in Path::ALL {
        assert_eq!(overlap_on(path, [a, b], scratch).0, verdict, "{what}: {path:?}");
    }
    let mut pairs = vec![[7, 7]];
    assert_eq!(touching(a, b, scratch, &mut pairs).0, verdict, "{what}");
    assert_eq!(pairs[1..], expected, "{what}");
    let mut mirrored = Vec::new();
    let _ = touching(b, a, scratch, &mut mirrored);
    let mut back: Vec<_> = mirrored.iter().map(|&[b, a]| [a, b]).collect();
    back.sort_unstable();
    assert_eq!(back, expected, "{what}: the other order");
    expected.len()
}

fn check_seeds(
    seeds: u64,
    shapes: impl Fn(&mut Draw) -> [Shape; 2],
    half: impl Fn(u64) -> (f64, f64),
) -> (usize, usize) {
    let mut scratch = Scratch::default();
    let (mut touching, mut pairs) = (0, 0);
    for seed in 0..seeds {
        let mut draw = Draw(seed);
        let [a, b] = shapes(&mut draw);
        let (spread, offset) = half(seed);
        let shift =
            |pose: Pose| Pose::from_matrix(*pose.rotation(), pose.translation() + offset).unwrap();
        let (pose_a, pose_b) = (shift(draw.pose(spread)), shift(draw.pose(spread)));
        let a = PosedShape { shape: &a, pose: &pose_a };
        let b = PosedShape { shape: &b, pose: &pose_b };
        let found = check(a, b, &mut scratch, &format!("seed {seed}"));
        touching += usize::from(found > 0);
        pairs += found;
    }
    (touching, pairs)
}

#[test]
fn two_meshes_touch_where_a_pair_of_triangles_does() {
    let meshes = |draw: &mut Draw| {
        [(); 2].map(|()| {
            let count = 1 + (draw.number() * draw.number() * 60.0) as usize;
            draw.mesh(count, 1.0)
        })
    };
    let (touching, pairs) = check_seeds(120, meshes, |_| (1.4, 0.0));
    assert!((20..110).contains(&touching) && pairs > 50, "{touching}, {pairs}");
}

#[test]
fn a_mesh_of_one_triangle_is_a_triangle() {
    let single = |draw: &mut Draw| [draw.mesh(1, 1.0), draw.mesh(1, 1.0)];
    let (touching, _) = check_seeds(2000, single, |_| (0.3, 0.0));
    assert!(touching > 20, "{touching}");
}

#[test]
fn one_triangle_meets_one_convex_shape_whichever_pose_comes_first() {
    let (mut scratch, mut touching) = (Scratch::default(), 0);
    for seed in 0..400 {
        let mut draw = Draw(seed);
        let (mesh, hull) = (draw.mesh(1, 1.0), draw.hull(1.0));
        let (pose_a, pose_b) = (draw.pose(0.4), draw.pose(0.4));
        let (a, b) = (
            PosedShape { shape: &mesh, pose: &pose_a },
            PosedShape { shape: &hull, pose: &pose_b },
        );
        touching += check(a, b, &mut scratch, &format!("seed {seed}"));
        let swapped = [PosedShape { pose: &pose_b, ..a }, PosedShape { pose: &pose_a, ..b }];
        touching += check(swapped[0], swapped[1], &mut scratch, &format!("seed {seed}, swapped"));
    }
    assert!((10..700).contains(&touching), "{touching}");
}

#[test]
fn triangles_as_near_to_a_boxs_face_as_rounding_are_decided_exactly() {
    let (mut scratch, mut touching) = (Scratch::default(), 0);
    for seed in 0..600 {
        let mut draw = Draw(seed);
        let half = draw.point(1.0).abs() + 0.05;
        let cuboid = Shape::cuboid(half).unwrap();
        let part = vec![(cuboid.clone(), draw.pose(0.5))];
        let lone = Shape::compound(part.clone()).unwrap();
        let (shape, place) =
            if seed % 2 == 0 { (&cuboid, Pose::IDENTITY) } else { (&lone, part[0].1) };
        // Above or below the face that looks along z, by some 1e-10 to 1e-4 of the box.
        let gap = 10f64.powf(-4.0 - 6.0 * draw.number()) * (draw.number() - 0.5).signum();
        let corners = [(); 3].map(|()| {
            let DVec3 { x, y, .. } = draw.point(0.8);
            let slope = 0.3 * gap.abs() * draw.number();
            place.apply(half * DVec3::new(x, y, 1.0) + DVec3::Z * (gap + slope))
        });
        let mesh = Shape::mesh(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let pose = draw.pose(10.0);
        let (a, b) = (PosedShape { shape, pose: &pose }, PosedShape { shape: &mesh, pose: &pose });
        touching += check(a, b, &mut scratch, &format!("seed {seed}, gap {gap:e}"));
    }
    assert!((200..400).contains(&touching), "{touching}");
}

#[test]
fn a_triangle_without_extent_is_as_far_from_a_convex_shape_as_its_point() {
    let mesh = Shape::mesh(vec![DVec3::ZERO], vec![[0; 3]]).unwrap();
    let cube = Shape::cuboid(DVec3::splat(0.5)).unwrap();
    let mut scratch = Scratch::default();
    for x in [-1.0, 1.0, 0.5, -0.5] {
        let pose = Pose::from_translation(DVec3::X * x).unwrap();
        let point = PosedShape { shape: &mesh, pose: &pose };
        let cube = PosedShape { shape: &cube, pose: &Pose::IDENTITY };
        let DistanceResult::Apart(found) = super::distance(point, cube, &mut scratch).0 else {
            assert_eq!(x.abs(), 0.5);
            continue;
        };
        assert_eq!((found.distance, x.abs()), (0.5, 1.0));
    }
}

#[test]
fn a_compound_touches_where_a_pair_of_parts_does() {
    let compounds = |draw: &mut Draw| [draw.compound(20, 1.0), draw.compound(9, 1.0)];
    let (touching, pairs) = check_seeds(60, compounds, |_| (1.7, 0.0));
    assert!((5..60).contains(&touching) && pairs > 50, "{touching}, {pairs}");
}

#[test]
fn a_mesh_meets_compounds_and_convex_shapes() {
    let mixed = |draw: &mut Draw| [draw.mesh(60, 1.0), draw.compound(7, 1.0)];
    let (touching, _) = check_seeds(50, mixed, |_| (1.7, 0.0));
    assert!((5..50).contains(&touching), "{touching}");
    let hull = |draw: &mut Draw| [draw.hull(1.0), draw.mesh(60, 1.0)];
    let (touching, _) = check_seeds(150, hull, |_| (1.5, 0.0));
    assert!((20..140).contains(&touching), "{touching}");
    let cube = |draw: &mut Draw| {
        let cube = Shape::cuboid(draw.point(0.4).abs()).unwrap();
        [cube.rounded(0.1 * draw.number()).unwrap(), draw.mesh(200, 1.0)]
    };
    let (touching, _) = check_seeds(150, cube, |_| (2.0, 0.0));
    assert!((20..140).contains(&touching), "{touching}");
    let sphere = |draw: &mut Draw| [Shape::sphere(0.2).unwrap(), draw.mesh(200, 1.0)];
    let (touching, _) = check_seeds(150, sphere, |_| (2.0, 0.0));
    assert!((20..140).contains(&touching), "{touching}");
    let sphere = |draw: &mut Draw| [Shape::sphere(0.2).unwrap(), draw.compound(30, 1.0)];
    let (touching, _) = check_seeds(150, sphere, |_| (1.0, 0.0));
    assert!((20..140).contains(&touching), "{touching}");
}

#[test]
fn answers_are_exact_a_million_metres_from_the_origin() {
    let meshes = |draw: &mut Draw| [draw.mesh(40, 1.0), draw.mesh(40, 1.0)];
    let (touching, _) = check_seeds(60, meshes, |_| (1.2, 1e6));
    assert!((10..60).contains(&touching), "{touching}");
}

#[test]
fn scale_does_not_matter_inside_and_outside_of_the_range_of_f32() {
    for scale in [1e-300, 1e-42, 1e-9, 1e-6, 1e-3, 1e3, 1e8, 1e12, 1e40, 1e150] {
        let meshes = |draw: &mut Draw| [draw.mesh(20, scale), draw.mesh(20, scale)];
        let (touching, _) = check_seeds(20, meshes, |_| (1.2 * scale, 0.0));
        assert!((2..20).contains(&touching), "{scale}: {touching}");
    }
}

#[test]
fn a_rounded_mesh_sweeps_a_sphere_round_every_triangle() {
    let rounded = |draw: &mut Draw| {
        let shapes = [draw.mesh(25, 1.0), draw.mesh(25, 1.0)];
        shapes.map(|shape| shape.rounded(0.1 * draw.number()).unwrap())
    };
    let (touching, _) = check_seeds(60, rounded, |_| (2.0, 0.0));
    assert!((5..60).contains(&touching), "{touching}");
}

/// A grid of squares in the plane z = 0, each of two triangles.
fn floor(cells: u32) -> Shape {
    let vertices = (0..=cells).flat_map(|x| (0..=cells).map(move |y| [x, y]));
    let vertices = vertices.map(|[x, y]| DVec3::new(x.into(), y.into(), 0.0)).collect();
    let at = |x: u32, y: u32| x * (cells + 1) + y;
    let cell = |k: u32| (k / cells, k % cells);
    let two = |(x, y): (u32, u32)| {
        [[at(x, y), at(x + 1, y), at(x, y + 1)], [at(x + 1, y + 1), at(x + 1, y), at(x, y + 1)]]
    };
    Shape::mesh(vertices, (0..cells * cells).map(cell).flat_map(two).collect()).unwrap()
}

#[test]
fn resting_is_a_contact_and_the_next_float_above_is_none() {
    let (ground, cube) = (floor(6), Shape::cuboid(DVec3::splat(0.5)).unwrap());
    let mut scratch = Scratch::default();
    let ground = PosedShape { shape: &ground, pose: &Pose::IDENTITY };
    for (z, contacts) in [(0.5, 18), (0.5f64.next_up(), 0), (0.5f64.next_down(), 18)] {
        let pose = Pose::from_translation(DVec3::new(2.5, 3.5, z)).unwrap();
        let cube = PosedShape { shape: &cube, pose: &pose };
        // The cell below, two triangles of it, and whatever has a corner or an edge with it.
        let found = check(ground, cube, &mut scratch, &format!("z = {z}"));
        assert_eq!(found > 0, contacts > 0, "{found}");
    }
    let other = floor(2);
    for (z, touches) in [(0.0, true), (f64::from_bits(1), false)] {
        let pose = Pose::from_translation(DVec3::new(1.0, 1.0, z)).unwrap();
        let found =
            check(ground, PosedShape { shape: &other, pose: &pose }, &mut scratch, "floors");
        assert_eq!(found > 0, touches);
    }
}

#[test]
fn poses_that_shear_within_the_tolerance_change_no_answer() {
    // Matrices as far from rotations as a pose admits: R_Aᵀ is not the inverse of R_A.
    let mut scratch = Scratch::default();
    let mut touching = 0;
    for seed in 0..40 {
        let mut draw = Draw(seed);
        let (a, b) = (draw.mesh(30, 1.0), draw.mesh(20, 1.0));
        let pose = |draw: &mut Draw| {
            let pose = draw.pose(1.0);
            let stretched = *pose.rotation() * (1.0 + 4e-7 * (2.0 * draw.number() - 1.0));
            Pose::from_matrix(stretched, pose.translation()).unwrap()
        };
        let (pose_a, pose_b) = (pose(&mut draw), pose(&mut draw));
        let a = PosedShape { shape: &a, pose: &pose_a };
        let b = PosedShape { shape: &b, pose: &pose_b };
        touching += usize::from(check(a, b, &mut scratch, &format!("seed {seed}")) > 0);
    }
    assert!((3..40).contains(&touching), "{touching}");
}

#[test]
fn one_pose_for_both_is_the_same_in_both_orders() {
    let mut draw = Draw(5);
    let (a, b) = (draw.mesh(12, 1.0), draw.mesh(12, 1.0));
    let mut scratch = Scratch::default();
    let at = |shape| PosedShape { shape, pose: &Pose::IDENTITY };
    let _ = check(at(&a), at(&b), &mut scratch, "two meshes");
    assert!(check(at(&a), at(&a), &mut scratch, "a mesh with itself") >= 12);
}

#[test]
fn a_cylinder_meets_a_mesh_where_it_meets_a_triangle() {
    let (mut scratch, mut touching) = (Scratch::default(), 0);
    for seed in 0..150 {
        let mut draw = Draw(seed);
        let mesh = draw.mesh(100, 1.0);
        let [h, r, swept] = [0.8, 0.4, 0.1].map(|most| most * draw.number());
        let shape = if seed % 2 == 0 { Shape::cylinder(h, r) } else { Shape::cone(h, r) };
        let shape = shape.unwrap().rounded(if seed % 3 == 0 { swept } else { 0.0 }).unwrap();
        let (pose_a, pose_b) = (draw.pose(2.0), draw.pose(2.0));
        let (a, b) = (
            PosedShape { shape: &shape, pose: &pose_a },
            PosedShape { shape: &mesh, pose: &pose_b },
        );
        let mut expected = Vec::new();
        for (k, triangle) in (0u32..).zip(polytopes(&mesh)) {
            let triangle = Shape::from(triangle);
            let (verdict, _) =
                certified::overlap_of(a, PosedShape { shape: &triangle, pose: &pose_b });
            assert!(!matches!(verdict, Verdict::Undecided(_)), "seed {seed}");
            if verdict == Verdict::Touching(()) {
                expected.push([0, k]);
            }
        }
        let mut found = Vec::new();
        let _ = super::touching(a, b, &mut scratch, &mut found);
        assert_eq!(found, expected, "seed {seed}");
        let verdict = overlap(b, a, &mut scratch).0;
        assert_eq!(verdict == Verdict::Touching(()), !expected.is_empty(), "seed {seed}");
        touching += usize::from(!expected.is_empty());
    }
    assert!((20..130).contains(&touching), "{touching}");
}

/// A sphere that owns up to no more than its support map.
struct Foreign;

impl SupportMap<f64> for Foreign {
    fn support(&self, _: DVec3) -> Support<f64> {
        Support { point: DVec3::ZERO, feature: 0 }
    }
    fn radius(&self) -> f64 {
        0.5
    }
    fn support_error(&self) -> f64 {
        1e-9
    }
}

#[test]
fn a_foreign_part_is_undecided_within_rounding_where_no_other_part_touches() {
    let foreign = Shape::custom(Arc::new(Foreign)).unwrap();
    let at = |x: f64| Pose::from_translation(DVec3::X * x).unwrap();
    let (near, far) = (Shape::sphere(0.5).unwrap(), Shape::sphere(0.25).unwrap());
    let alone = Shape::compound(vec![(foreign.clone(), at(0.0)), (far.clone(), at(9.0))]).unwrap();
    let mut scratch = Scratch::default();
    let mut decide = |shape: &Shape, x: f64| {
        let a = PosedShape { shape, pose: &Pose::IDENTITY };
        overlap(a, PosedShape { shape: &near, pose: &at(x) }, &mut scratch)
    };
    assert_eq!(decide(&alone, 1.0).0, Verdict::Undecided(Reason::WithinRounding));
    assert_eq!(decide(&alone, 0.9).0, Verdict::Touching(()));
    assert_eq!(decide(&alone, 1.1).0, Verdict::Apart);
    let beside = Shape::compound(vec![(foreign, at(0.0)), (far, at(0.5))]).unwrap();
    assert_eq!(decide(&beside, 1.0), (Verdict::Touching(()), Method::F64));
}

#[test]
fn the_origin_of_a_foreign_frame_is_not_taken_for_a_point_of_its_shape() {
    // A sphere of radius 1 about (1.5, 1.5, 0), beside a triangle round the origin of its frame.
    let sphere = Polytope::hull(vec![DVec3::new(1.5, 1.5, 0.0)]).unwrap().rounded(1.0).unwrap();
    let corners = vec![DVec3::ZERO, DVec3::X * 0.6, DVec3::Y * 0.6];
    let mesh = Shape::mesh(corners, vec![[0, 1, 2]]).unwrap();
    let foreign = Shape::custom(Arc::new(sphere.clone())).unwrap();
    for sphere in [Shape::from(sphere), foreign] {
        let mut scratch = Scratch::default();
        let here = |shape| PosedShape { shape, pose: &Pose::IDENTITY };
        let (a, b) = (here(&mesh), here(&sphere));
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let found = overlap_on(path, [a, b], &mut scratch).0;
            assert_eq!(found, Verdict::Apart, "{sphere:?} on {path:?}");
        }
    }
}

#[test]
fn a_solver_of_convex_shapes_says_so() {
    use crate::{Gjk, PairSolver};
    let mesh = Shape::from(Mesh::new(vec![DVec3::ZERO], vec![[0; 3]]).unwrap());
    let placed = PosedShape { shape: &mesh, pose: &Pose::IDENTITY };
    let expected = Verdict::Undecided(Reason::NotConvex);
    assert_eq!(Gjk::<f64>::default().solve(placed, placed, &mut ()), expected);
    assert_eq!(Gjk::<f32>::default().solve(placed, placed, &mut ()), expected);
    assert_eq!(certified::overlap_of(placed, placed).0, Verdict::Touching(()));
}

/// A body whose lowest point is that far over the plane of a triangle of the mesh, over a point of it or beside it.
fn over_a_triangle(draw: &mut Draw, mesh: &Mesh, body: &Shape, gap: f64) -> Pose {
    let k = (draw.number() * mesh.triangles().len() as f64) as usize;
    let [p, q, r] = mesh.corners(k).unwrap();
    let normal = (q - p).cross(r - p).normalize_or(DVec3::Z);
    let normal = if draw.number() < 0.5 { -normal } else { normal };
    let turn = match (draw.number() * 3.0) as usize {
        // An edge along one of the triangle's, a side in its plane.
        0 => {
            let x = (q - p).normalize_or(DVec3::X);
            DQuat::from_mat3(&DMat3::from_cols(x, normal.cross(x), normal)).normalize()
        }
        1 => DQuat::IDENTITY,
        _ => DQuat::from_scaled_axis(draw.point(3.0)),
    };
    let low = turn * body.support(turn.inverse() * -normal).point;
    let on = p + (q - p) * (1.4 * draw.number() - 0.2) + (r - p) * (0.7 * draw.number() - 0.1);
    let swept = body.radius() + mesh.swept_radius();
    Pose::new(turn, on + normal * (swept + gap) - low).unwrap()
}

#[test]
fn bodies_that_just_touch_a_triangle_are_decided_as_by_brute_force() {
    let seed = std::env::var("DCD_SEED").map_or(1907, |seed| seed.parse().expect("a seed"));
    let (mut draw, mut scratch, mut found) = (Draw(seed), Scratch::default(), [0usize; 7]);
    for round in 0..1400usize {
        let scale = [1.0, 1e-3, 1e3][round / 7 % 3];
        let strewn = draw.mesh(5 + round % 30, scale);
        let swept = round % 5 == 4;
        let ground = if swept { strewn.swept(0.03 * scale).unwrap() } else { strewn };
        let half = (draw.point(0.4).abs() + 0.02) * scale;
        let body = match round % 7 {
            0 => Shape::sphere(half.x).unwrap(),
            1 => Shape::capsule(half.x, half.y).unwrap(),
            2 => Shape::cuboid(half).unwrap(),
            3 => Shape::cuboid(half).unwrap().swept(0.1 * scale).unwrap(),
            4 => draw.hull(scale),
            5 => draw.hull(scale).swept(0.05 * scale).unwrap(),
            // Flat.
            _ => Shape::cuboid(DVec3::new(half.x, half.y, 0.0)).unwrap(),
        };
        let gap = [0.0, 1e-16, -1e-16, 1e-9, -1e-9, 1e-7, -1e-7, 2e-6, -2e-6, 1e-4, -1e-4, -0.05];
        let gap = gap[(draw.number() * gap.len() as f64) as usize] * scale;
        let Shape::Mesh(mesh) = &ground else { panic!("no mesh") };
        let pose = over_a_triangle(&mut draw, mesh, &body, gap);
        let whole = if round % 2 == 0 { Pose::IDENTITY } else { draw.pose(10.0 * scale) };
        let turn = DQuat::from_mat3(&(*whole.rotation() * *pose.rotation())).normalize();
        let place = *whole.rotation() * pose.translation() + whole.translation();
        let pose = Pose::new(turn, place).unwrap();
        let a = PosedShape { shape: &ground, pose: &whole };
        let b = PosedShape { shape: &body, pose: &pose };
        let what = format!("seed {seed}, round {round}, gap {gap}");
        found[round % 7] += usize::from(check(a, b, &mut scratch, &what) > 0);
    }
    assert!(found.iter().all(|&count| count > 30), "{found:?}");
}
