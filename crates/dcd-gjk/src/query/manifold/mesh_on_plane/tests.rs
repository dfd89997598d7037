//! Meshes on half-spaces, and spheres in meshes, beside the manifolds of all pairs of parts.

use crate::motion::tests::Draw;
use crate::query::manifold::Scratch;
use crate::query::manifold::parts::{Measure, write_pair_by_pair};
use crate::query::{Accuracy, Feature, Manifold, ManifoldOptions, MeasureAt, PartIndex};
use crate::{Depths, ManifoldSet, Manifolds, PosedShape, Verdict, certified};
use dcd_geom::glam::{DQuat, DVec3};
use dcd_geom::{Mesh, Pose, Shape, SupportMap};

/// A sheet of squares, wavy or level, or triangles strewn about, which share no vertex by index; needles and points among
/// them.
fn mesh(draw: &mut Draw, k: usize) -> Mesh {
    let side = 2 + k as u32 % 7;
    let (vertices, triangles): (Vec<DVec3>, Vec<[u32; 3]>) = if k.is_multiple_of(3) {
        let place = |j: u32, draw: &mut Draw| match j % 9 {
            4 => DVec3::ZERO,
            _ => draw.vector() * 0.6,
        };
        let count = 3 * (side * side);
        (
            (0..count).map(|j| place(j, draw)).collect(),
            (0..count / 3).map(|j| [3 * j, 3 * j + 1, 3 * j + 2]).collect(),
        )
    } else {
        let wave = if k % 3 == 1 { 0.2 } else { 0.0 };
        let at = |j: u32| {
            let [x, y] = [j % side, j / side].map(|i| f64::from(i) / f64::from(side - 1) - 0.5);
            DVec3::new(x, y, wave * (6.0 * x).sin() * (5.0 * y).cos())
        };
        let cells = (0..side * (side - 1)).filter(|j| (j + 1) % side > 0);
        let square = |j: u32| [[j, j + 1, j + side], [j + 1, j + side + 1, j + side]];
        ((0..side * side).map(at).collect(), cells.flat_map(square).collect())
    };
    let radius = if k.is_multiple_of(4) { 0.05 } else { 0.0 };
    Mesh::new(vertices, triangles).unwrap().rounded(radius).unwrap()
}

fn pose(draw: &mut Draw, is_turned: bool, far: f64) -> Pose {
    let turn = if is_turned { draw.vector() * 3.0 } else { DVec3::ZERO };
    Pose::new(DQuat::from_scaled_axis(turn).normalize(), draw.vector() * 0.4 + far).unwrap()
}

fn manifolds(accuracy: Accuracy, a: PosedShape<'_>, b: PosedShape<'_>) -> Option<ManifoldSet> {
    match Manifolds::default().measure_at(accuracy, a, b, &mut Default::default()) {
        Verdict::Touching(found) => Some(found),
        _ => None,
    }
}

/// The certified manifolds in the general way.
fn pair_by_pair(a: PosedShape<'_>, b: PosedShape<'_>) -> ManifoldSet {
    let how = Measure { accuracy: Accuracy::Certified, options: ManifoldOptions::default() };
    let mut found = ManifoldSet::default();
    write_pair_by_pair(how, None, [a, b], (&mut Scratch::default(), &mut found)).unwrap();
    found
}

fn deepest(a: PosedShape<'_>, b: PosedShape<'_>) -> crate::epa::Depth {
    match Depths.measure_at(Accuracy::Certified, a, b, &mut Default::default()) {
        Verdict::Touching(found) => found,
        other => panic!("{other:?}"),
    }
}

/// The largest distance of two of its points.
fn span(found: &Manifold) -> f64 {
    let points = found.points();
    let far = |p: &DVec3| points.iter().map(|q| q.point_a.distance(*p)).fold(0.0, f64::max);
    points.iter().map(|p| far(&p.point_a)).fold(0.0, f64::max)
}

/// Each point is a vertex below the plane, as its name says, and as deep as it is there.
fn check_points(
    what: &str,
    found: &Manifold,
    mesh: &Mesh,
    a: PosedShape<'_>,
    plane: PosedShape<'_>,
) {
    let sphere = Shape::sphere(mesh.swept_radius()).unwrap();
    for point in found.points() {
        let (Some(PartIndex::Triangle(triangle)), Feature::Vertex(corner)) =
            (point.parts[0], point.features[0])
        else {
            panic!("{what}: {point:?}");
        };
        let vertex = mesh.corners(triangle as usize).unwrap()[corner as usize];
        let at = Pose::from_translation(a.pose.apply(vertex)).unwrap();
        let off = at.translation() + found.normal * mesh.swept_radius() - point.point_a;
        let far = 1e-14 * (1.0 + at.translation().length());
        assert!(off.length() <= far, "{what}: {point:?}");
        let alone = PosedShape { shape: &sphere, pose: &at };
        let due = match certified::overlap_of(alone, plane).0 {
            Verdict::Touching(()) => deepest(alone, plane).depth,
            _ => 0.0,
        };
        assert!((point.depth - due).abs() <= found.error_bound + far, "{what}: {point:?} {due}");
        let between = point.point_a - point.point_b - found.normal * point.depth;
        assert!(between.length() <= found.error_bound + far, "{what}: {point:?}");
    }
}

/// No vertex below the plane is farther from the first point, seen along the normal, than another of the points.
fn check_farthest(what: &str, found: &Manifold, mesh: &Mesh, a: PosedShape<'_>) {
    let first = found.points()[0];
    let beside = |point: DVec3| (point - first.point_a).reject_from(found.normal).length();
    let most = found.points().iter().map(|point| beside(point.point_a)).fold(0.0, f64::max);
    let rounding = 1e-8 * (mesh.reach() + 1e-3 * a.pose.translation().length());
    for &vertex in mesh.points() {
        let point = a.pose.apply(vertex) + found.normal * mesh.swept_radius();
        let is_below = found.normal.dot(point - first.point_b) > rounding;
        assert!(!is_below || beside(point) <= most + rounding, "{what}: {vertex} {found:?}");
    }
}

fn mirrored(mut set: ManifoldSet) -> ManifoldSet {
    set.mirror();
    set
}

#[test]
fn a_mesh_rests_on_a_half_space_on_the_deepest_and_the_farthest_of_its_vertices() {
    // Another seed by `DCD_SEED`.
    let seed = std::env::var("DCD_SEED").map_or(6, |seed| seed.parse().expect("a seed"));
    let mut draw = Draw(seed);
    let (mut touching, mut wider) = (0, 0);
    let (mut scratch, mut memory) = (Default::default(), Default::default());
    for k in 0..600usize {
        let mesh = mesh(&mut draw, k);
        // On the sheets' faces, on their edges with vertices above each other, and aslant.
        let normal = match k % 5 {
            0 => DVec3::Z,
            1 => DVec3::X,
            _ => draw.vector(),
        };
        let half_space = Shape::half_space(normal, draw.number() * 0.1).unwrap();
        let half_space = half_space.rounded(if k.is_multiple_of(6) { 0.03 } else { 0.0 }).unwrap();
        let far = if k.is_multiple_of(11) { 1e4 } else { 0.0 };
        let poses = [0, 1].map(|_| pose(&mut draw, k % 7 > 1, far));
        let shape = Shape::from(mesh.clone());
        let a = PosedShape { shape: &shape, pose: &poses[0] };
        let b = PosedShape { shape: &half_space, pose: &poses[1] };
        let at = [Accuracy::F32, Accuracy::F64, Accuracy::Certified][k / 2 % 3];
        let (memory, scratch) = (&mut memory, &mut scratch);
        let Some(found) = super::measure(at, [a, b], (scratch, memory)) else { continue };
        let what = format!("{k}");
        assert_eq!(manifolds(at, a, b).as_ref(), Some(&found), "{what}");
        let back = manifolds(at, b, a).map(mirrored);
        assert_eq!(back.as_ref(), Some(&found), "{what}");
        let [found] = &found[..] else { panic!("{what}: {found:?}") };
        let best = deepest(a, b);
        let first = found.points()[0].depth;
        assert!((first - best.depth).abs() <= found.error_bound + best.error_bound, "{what}");
        assert!(found.normal.distance(best.normal) < 1e-12, "{what}");
        check_points(&what, found, &mesh, a, b);
        check_farthest(&what, found, &mesh, a);
        // What the pairs of parts show is among the vertices.
        let general = pair_by_pair(a, b);
        let [general] = &general[..] else { panic!("{what}: {general:?}") };
        assert!(found.points().len() >= general.points().len().min(3), "{what}: {found:?}");
        let reach = shape.reach() + shape.radius();
        assert!(2.0 * span(found) >= span(general) - 1e-8 * reach, "{what}: {found:?} {general:?}");
        wider += usize::from(span(found) > span(general) + 1e-8 * reach);
        touching += 1;
    }
    assert!(touching > 250 && wider > 20, "{touching} {wider}");
}

#[test]
fn a_sphere_touches_a_mesh_along_the_normals_of_all_pairs_of_parts() {
    // Another seed by `DCD_SEED`.
    let seed = std::env::var("DCD_SEED").map_or(7, |seed| seed.parse().expect("a seed"));
    let mut draw = Draw(seed);
    let (mut touching, mut several, mut different) = (0, 0, 0);
    for k in 0..600usize {
        let shape = Shape::from(mesh(&mut draw, k));
        let sphere = Shape::sphere(0.05 + 0.3 * draw.number().abs()).unwrap();
        let far = if k.is_multiple_of(11) { 1e3 } else { 0.0 };
        let poses = [0, 1].map(|_| pose(&mut draw, k % 7 > 1, far));
        let a = PosedShape { shape: &shape, pose: &poses[0] };
        let b = PosedShape { shape: &sphere, pose: &poses[1] };
        if certified::overlap_of(a, b).0 != Verdict::Touching(()) {
            continue;
        }
        let found = manifolds(Accuracy::F32, a, b).unwrap();
        let back = manifolds(Accuracy::F32, b, a).map(mirrored);
        assert_eq!(back.as_ref(), Some(&found), "{k}");
        let best = deepest(a, b);
        let first = found[0].points()[0].depth;
        assert!((first - best.depth).abs() <= found[0].error_bound + best.error_bound, "{k}");
        let general = manifolds(Accuracy::Certified, a, b).unwrap();
        touching += 1;
        several += usize::from(general.len() > 1);
        // Of equally deep triangles either may lead.
        let is_same = |(one, other): (&Manifold, &Manifold)| {
            let off = (one.points()[0].depth - other.points()[0].depth).abs();
            off <= one.error_bound + other.error_bound && one.normal.distance(other.normal) < 2e-3
        };
        let same = found.len() == general.len() && found.iter().zip(&general).all(is_same);
        different += usize::from(!same);
    }
    assert!(touching > 200 && several > 40 && different < 5, "{touching} {several} {different}");
}
