//! Shapes without thickness, of one point repeated, very small, very large, far from the world's origin, or at one place: what
//! each question answers of them is consistent at every accuracy, and true as far as moved shapes tell.

use super::PosedSupport;
use super::manifold_points::{
    ACCURACIES, CONVEX, convex, judge_all, judge_depths, place, turn, verdict,
};
use super::scenes::Draw;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Pose, Shape};
use dcd_gjk::query::MeasureAt;
use dcd_gjk::{Accuracy, Depths, Distances, PosedShape, Verdict};
use dcd_pipeline::prelude::{Par, Pipeline, Scene};

/// A shape of that kind, most of them without thickness along an axis or two.
pub(super) fn thin(draw: &mut Draw, kind: usize, scale: f64) -> Shape {
    let number = (draw.unit().abs() * 42.0) as usize;
    let needle = without_area(draw, number).map(|corner| corner * scale);
    let mut grid = || (place(draw, true) * 2.0).round() * (0.5 * scale);
    let radius = 0.125 * scale;
    let mut points =
        |count: usize, flat: DVec3| -> Vec<DVec3> { (0..count).map(|_| grid() * flat).collect() };
    let corners = |points: Vec<DVec3>| [points[0], points[1], points[2]];
    let (flat, line) = (DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 0.0, 0.0));
    let made = match kind {
        0 => Shape::sphere(0.0).or_else(|_| Shape::sphere(radius)),
        1 => Shape::hull(points(9, flat)),
        2 => Shape::hull(points(4, line)),
        3 => Shape::hull(vec![points(1, DVec3::ONE)[0]; 3]),
        4 => Shape::triangle(corners(points(3, flat))),
        5 => Shape::triangle(corners(points(3, line))),
        6 => Shape::hull(points(9, flat)).and_then(|hull| hull.rounded(radius)),
        7 => Shape::hull(points(20, DVec3::ONE)),
        8 => Shape::cuboid(DVec3::new(scale, 0.5 * scale, 1e-9 * scale)),
        9 => Shape::cuboid(DVec3::new(scale, 1e-7 * scale, 1e-7 * scale)),
        10 => Shape::capsule(scale, 1e-6 * scale),
        11 => Shape::cylinder(1e-6 * scale, scale),
        12 => Shape::cone(scale, 1e-3 * scale),
        13 => Shape::segment(DVec3::ZERO, points(1, DVec3::ONE)[0]),
        14 => Shape::hull(needle.to_vec()),
        15 => Shape::triangle(needle),
        _ => Shape::cuboid(DVec3::splat(0.5 * scale)),
    };
    made.unwrap_or_else(|_| Shape::cuboid(DVec3::splat(0.5 * scale)).unwrap())
}

pub(super) const KINDS: usize = 17;

#[test]
fn questions_of_thin_far_tiny_and_huge_shapes_agree_and_are_true() {
    let mut draw = Draw::seeded(37);
    let [mut apart, mut touching] = [0; 2];
    for k in 0..20_000usize {
        let scale = [1.0, 1.0, 1e-6, 1e6][k / 5 % 4];
        let far = DVec3::new(3.0, -5.0, 7.0) * [0.0, 0.0, 1e5 * scale][k / 3 % 3];
        let round = k % 4 < 3;
        let kinds = [k % KINDS, k / KINDS % KINDS];
        let [a, b] = kinds.map(|kind| {
            let (shape, at) = (thin(&mut draw, kind, scale), place(&mut draw, round) * scale);
            // One place for both now and then.
            let at = if k % 11 == 0 { DVec3::ZERO } else { at };
            let pose = Pose::from_matrix(turn(&mut draw, round), at + far).unwrap();
            PosedSupport { shape, pose }
        });
        let (a, b) = (a.placed(), b.placed());
        let rounding = 1e-9 * scale + 1e-14 * far.length();
        let what = format!("{k}, kinds {kinds:?}, scale {scale:e}, far {}", far.length());
        match verdict(a, b) {
            Verdict::Touching(()) => {
                touching += 1;
                judge_touching(a, b, rounding, &what);
            }
            Verdict::Apart => {
                apart += 1;
                judge_apart(a, b, rounding, &what);
            }
            Verdict::Undecided(_) => {}
        }
    }
    assert!(apart > 2_000 && touching > 2_000, "{apart} {touching}");
}

fn is_near(side: PosedShape<'_>, at: DVec3, radius: f64) -> bool {
    let ball = Shape::sphere(radius).unwrap();
    let pose = Pose::from_translation(at).unwrap();
    verdict(side, PosedShape { shape: &ball, pose: &pose }) != Verdict::Apart
}

fn judge_touching(a: PosedShape<'_>, b: PosedShape<'_>, rounding: f64, what: &str) {
    judge_depths([a, b], (rounding, what));
    judge_all([a, b], true, (rounding, what));
}

fn judge_apart(a: PosedShape<'_>, b: PosedShape<'_>, rounding: f64, what: &str) {
    let mut ranges = [f64::NEG_INFINITY, f64::INFINITY];
    for accuracy in ACCURACIES {
        let found = Distances::within(1e9).unwrap().measure_at(accuracy, a, b, &mut ());
        let Verdict::Touching(Some(distance)) = found else {
            panic!("{what} {accuracy:?}: {found:?}")
        };
        ranges = [ranges[0].max(distance.lower()), ranges[1].min(distance.upper())];
        assert!(ranges[0] <= ranges[1] + rounding, "{what} {accuracy:?}: {ranges:?} {distance:?}");
        let unsure = distance.error_bound + rounding;
        for (side, at) in [(a, distance.point_a), (b, distance.point_b)] {
            assert!(is_near(side, at, unsure), "{what} {accuracy:?}: off {distance:?}");
        }
        let length = distance.point_a.distance(distance.point_b);
        assert!(
            (length - distance.distance).abs() <= unsure,
            "{what} {accuracy:?}: {length} {distance:?}"
        );
    }
}

/// A needle of a triangle ends inside of a hull's face: where its long sides are cut, they are all but parallel.
#[test]
fn no_point_is_beyond_the_end_of_a_needle_that_lies_in_a_face() {
    let far = DVec3::new(3e11, -5e11, 7e11);
    let needle = Shape::triangle([
        DVec3::new(-72945.23654149598, 280315.85799551004, 879464.8566006855),
        DVec3::new(-85381.79616831856, 251098.8370488509, 830334.9931468129),
        DVec3::new(-258346.16998265547, -155243.7472587944, 147049.87536454818),
    ])
    .unwrap();
    let turn = DMat3::from_cols(
        DVec3::new(0.9999999999999999, 1.1863542071796444e-9, -1.7871394362988933e-8),
        DVec3::new(-1.1863535329205214e-9, 0.9999999999999993, 3.772840041974874e-8),
        DVec3::new(1.7871394407748166e-8, -3.7728400398546935e-8, 0.9999999999999991),
    );
    let corners = [
        [-1.0, 1.0, -0.5],
        [1.0, -0.5, 1.0],
        [-1.0, -1.0, -1.0],
        [1.0, -0.5, -1.0],
        [-1.0, 0.5, -1.0],
        [-0.5, -1.0, -0.5],
        [0.5, -0.5, 1.0],
        [-1.0, 1.0, 1.0],
        [-0.5, -0.5, 0.5],
        [0.5, 1.0, -0.5],
        [1.0, 1.0, 0.5],
        [-0.5, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-0.5, 1.0, 1.0],
        [1.0, 0.5, 1.0],
    ];
    let hull = Shape::hull(corners.map(|c| DVec3::from_array(c) * 1e6).to_vec()).unwrap();
    for place in [DVec3::ZERO, far] {
        let (a, b) =
            (Pose::from_matrix(turn, place).unwrap(), Pose::from_translation(place).unwrap());
        let sides = [(&needle, &a), (&hull, &b)].map(|(shape, pose)| PosedShape { shape, pose });
        judge_touching(sides[0], sides[1], 1e-3 + 1e-14 * place.length(), "a needle in a face");
    }
}

/// A search that goes on knows nearer points, the one before it a better direction.
#[test]
fn the_points_of_a_line_and_a_disc_are_as_near_as_is_said() {
    let ends = [5e-7, -5e-7, 5e-7, -1e-6].map(|x| DVec3::new(x, 0.0, 0.0));
    let line = Shape::hull(ends.to_vec()).unwrap();
    let disc = Shape::cylinder(1e-12, 1e-6).unwrap();
    let turn = DMat3::from_cols(
        DVec3::new(0.9999999999999989, 4.5649116380413294e-8, -1.015656611356322e-8),
        DVec3::new(-4.564911709063619e-8, 0.9999999999999966, -6.992747318460933e-8),
        DVec3::new(1.0156562921435824e-8, 6.992747364824753e-8, 0.9999999999999976),
    );
    let a = Pose::from_matrix(turn, DVec3::new(0.0, 5e-7, -5e-7)).unwrap();
    let across = DMat3::from_cols(DVec3::Z, DVec3::NEG_Y, DVec3::X);
    let b = Pose::from_matrix(across, DVec3::new(5e-7, -5e-7, -5e-7)).unwrap();
    let [a, b] = [(&line, &a), (&disc, &b)].map(|(shape, pose)| PosedShape { shape, pose });
    judge_apart(a, b, 1e-15, "a line and a disc");
    judge_apart(b, a, 1e-15, "a disc and a line");
}

/// Corners on a line, in one point, or next to it; turned, so that rounding gives them a plane.
pub(super) fn without_area(draw: &mut Draw, k: usize) -> [DVec3; 3] {
    let (from, to) = (place(draw, false), place(draw, false));
    let off = [0.0, 0.0, 1e-17, 1e-13, 1e-10, 1e-8][k % 6];
    let middle = from.lerp(to, draw.unit().abs()) + place(draw, false) * off;
    let mut corners = match k % 7 {
        0 => [from, from, to],
        1 => [from; 3],
        _ => [from, to, middle],
    };
    corners.rotate_left(k % 3);
    corners
}

/// A measure and its bound.
type Measured = Verdict<[f64; 2]>;

fn distance_between(accuracy: Accuracy, a: PosedShape<'_>, b: PosedShape<'_>) -> Measured {
    match Distances::within(1e3).unwrap().measure_at(accuracy, a, b, &mut ()) {
        Verdict::Touching(found) => {
            Verdict::Touching(found.map_or([0.0; 2], |found| [found.distance, found.error_bound]))
        }
        Verdict::Apart => Verdict::Apart,
        Verdict::Undecided(reason) => Verdict::Undecided(reason),
    }
}

fn depth_of(accuracy: Accuracy, a: PosedShape<'_>, b: PosedShape<'_>) -> Measured {
    match Depths.measure_at(accuracy, a, b, &mut Default::default()) {
        Verdict::Touching(found) => Verdict::Touching([found.depth, found.error_bound]),
        Verdict::Apart => Verdict::Apart,
        Verdict::Undecided(reason) => Verdict::Undecided(reason),
    }
}

/// Whether a measure of two shapes is at every accuracy the certified one of the hulls of their corners.
fn judge_measured(
    [a, b]: [PosedShape<'_>; 2],
    [of_a, of_b]: [PosedShape<'_>; 2],
    measure: impl Fn(Accuracy, PosedShape<'_>, PosedShape<'_>) -> Measured,
    k: usize,
) {
    let due = measure(Accuracy::Certified, of_a, of_b);
    let Verdict::Touching([due, due_bound]) = due else { panic!("{k}: {due:?}") };
    for accuracy in ACCURACIES {
        let found = measure(accuracy, a, b);
        let Verdict::Touching([value, bound]) = found else { panic!("{k}: {found:?}") };
        let off = (value - due).abs();
        assert!(off <= bound + due_bound + 1e-12, "{k} {accuracy:?}: {off}, {found:?} {due}");
    }
}

#[test]
fn triangles_without_area_touch_what_the_hull_of_their_corners_touches() {
    let mut draw = Draw::seeded(41);
    let [mut apart, mut touching] = [0; 2];
    for k in 0..60_000usize {
        let corners = match k % 9 {
            8 => [0; 3].map(|_| place(&mut draw, true)),
            _ => without_area(&mut draw, k),
        };
        let other = match k % 4 {
            0 => without_area(&mut draw, k / 4),
            1 => [0; 3].map(|_| place(&mut draw, k % 3 == 0)),
            _ => [DVec3::ZERO; 3],
        };
        let body = match k % 8 {
            2 | 3 => thin(&mut draw, k / 8 % KINDS, 1.0),
            _ => convex(&mut draw, k / 8 % CONVEX, k.is_multiple_of(3)),
        };
        let mut pose = || {
            let at = place(&mut draw, false) * 0.7;
            Pose::from_matrix(turn(&mut draw, false), at).unwrap()
        };
        let poses = [pose(), pose()];
        let triangle = |corners: [DVec3; 3]| {
            let mesh = Shape::mesh(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
            (mesh, Shape::triangle(corners).unwrap(), Shape::hull(corners.to_vec()).unwrap())
        };
        let (mesh, alone, hull) = triangle(corners);
        let others = match k % 4 {
            0 | 1 => {
                let (mesh, alone, hull) = triangle(other);
                [mesh, alone, hull]
            }
            _ => [body.clone(), body.clone(), body],
        };
        let posed = |k: usize, shape| PosedShape { shape, pose: &poses[k] };
        let due = verdict(posed(0, &hull), posed(1, &others[2]));
        let found = [
            verdict(posed(0, &mesh), posed(1, &others[0])),
            verdict(posed(1, &others[0]), posed(0, &mesh)),
            verdict(posed(0, &mesh), posed(1, &others[2])),
            verdict(posed(0, &alone), posed(1, &others[1])),
        ];
        let is_same = |found: &Verdict<()>| *found == due || matches!(found, Verdict::Undecided(_));
        assert!(
            found.iter().all(is_same),
            "{k}: {found:?}, not {due:?}: {corners:?} {other:?} {poses:?}"
        );
        let as_hulls = [posed(0, &hull), posed(1, &others[2])];
        let pairs = [(&mesh, &others[0]), (&mesh, &others[2]), (&alone, &others[1])];
        for (one, other) in pairs.map(|(one, other)| (posed(0, one), posed(1, other))) {
            match due {
                Verdict::Apart => judge_measured([one, other], as_hulls, distance_between, k),
                Verdict::Touching(()) => judge_measured([one, other], as_hulls, depth_of, k),
                Verdict::Undecided(_) => {}
            }
        }
        apart += usize::from(due == Verdict::Apart);
        touching += usize::from(due == Verdict::Touching(()));
    }
    assert!(apart > 10_000 && touching > 1_500, "{apart} {touching}");
}

#[test]
fn meshes_of_triangles_without_area_touch_in_scenes_what_their_hulls_touch() {
    let mut draw = Draw::seeded(43);
    let [mut apart, mut touching] = [0; 2];
    for k in 0..120usize {
        let triangles: Vec<_> = (0..20).map(|j| without_area(&mut draw, k + j)).collect();
        let numbers = (0..20).map(|j| [0, 1, 2].map(|corner| 3 * j + corner)).collect();
        let mesh = Shape::mesh(triangles.concat(), numbers).unwrap();
        let mut pose = || {
            let at = place(&mut draw, false) * 1.2;
            Pose::from_matrix(turn(&mut draw, false), at).unwrap()
        };
        let mut poses: Vec<_> = (0..60).map(|_| pose()).collect();
        let bodies = (1..60).map(|j| convex(&mut draw, j % CONVEX, j % 4 == 0));
        let shapes: Vec<_> = std::iter::once(mesh).chain(bodies).collect();
        let hulls: Vec<_> =
            triangles.iter().map(|corners| Shape::hull(corners.to_vec()).unwrap()).collect();
        let mesh_pose = poses[0];
        let due: Vec<Vec<_>> = (1..60usize)
            .map(|j| {
                let body = PosedShape { shape: &shapes[j], pose: &poses[j] };
                let of_hull = |hull| verdict(PosedShape { shape: hull, pose: &mesh_pose }, body);
                hulls.iter().map(of_hull).collect()
            })
            .collect();
        let scene = Scene::one_each(shapes, std::mem::take(&mut poses)).unwrap();
        let mut pipeline = Pipeline::new();
        let step = pipeline.step(&scene, Par::Serial);
        for (j, due) in (1u32..).zip(&due) {
            let found = step.answers().any(|found| (found.pair.i, found.pair.j) == (0, j));
            if due.contains(&Verdict::Touching(())) {
                assert!(found, "{k}: body {j} touches");
                touching += 1;
            } else if due.iter().all(|verdict| *verdict == Verdict::Apart) {
                assert!(!found, "{k}: body {j} is apart");
                apart += 1;
            }
        }
    }
    assert!(apart > 1_000 && touching > 1_000, "{apart} {touching}");
}
#[test]
fn radii_round_cores_that_f64_cannot_tell_apart_overlap_by_less_than_their_sum() {
    // The capsule ends a tenth of a micrometre beside the middle of an edge; along the direction that f64 finds from there its
    // other end is in the way. This pair was found at random.
    let halves = [
        [2, -1, -2],
        [-1, 0, -1],
        [-1, 2, 1],
        [2, 1, 1],
        [-2, -2, 2],
        [-2, 1, 1],
        [2, -1, -1],
        [2, -2, 1],
        [2, -2, 1],
        [1, 1, -1],
        [1, 1, 2],
        [1, -2, -1],
        [1, -2, -1],
        [0, 2, -1],
        [-1, -2, -2],
        [-2, 2, 0],
        [0, -2, 1],
        [-2, -2, 1],
        [-2, 2, 1],
        [0, -1, 0],
    ];
    let vertices = halves.map(|vertex| DVec3::from_array(vertex.map(|x: i32| 0.5 * f64::from(x))));
    let hull = Shape::hull(vertices.to_vec()).unwrap();
    let capsule = Shape::capsule(1.0, 1e-6).unwrap();
    let pose = |axes: [[f64; 3]; 3], place: [f64; 3]| {
        let [x, y, z] = axes.map(DVec3::from_array);
        Pose::from_matrix(DMat3::from_cols(x, y, z), DVec3::from_array(place)).unwrap()
    };
    let upright = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let leaning = [
        [0.9999999999999939, -8.101353558511049e-8, 7.483935524765057e-8],
        [8.101352976359283e-8, 0.9999999999999937, 7.778684926473254e-8],
        [-7.483936154943779e-8, -7.778684320173174e-8, 0.9999999999999942],
    ];
    let poses = [
        pose(upright, [299999.75, -500000.25, 699999.25]),
        pose(leaning, [300000.5, -499999.5, 700000.75]),
    ];
    let a = PosedShape { shape: &hull, pose: &poses[0] };
    let b = PosedShape { shape: &capsule, pose: &poses[1] };
    assert_eq!(verdict(a, b), Verdict::Touching(()));
    judge_touching(a, b, 2e-9, "found");
}
