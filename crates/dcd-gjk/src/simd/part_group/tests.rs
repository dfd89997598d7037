//! Parts side by side beside the same parts one by one.

use crate::simd::{Overlap, SimdFrame};
use crate::{
    Accuracy, ContactSink, Depths, NarrowPhase, PosedShape, Prepared, Report, Sides, SimdDepths,
    Verdict, certified,
};
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Aabb, Pair, Pose, Scene, Shape, Support, SupportMap};
use dcd_simd::Path;
use std::sync::Arc;

fn paths() -> impl Iterator<Item = Path> {
    Path::ALL.into_iter().filter(|path| path.is_available())
}

fn pose(k: usize, size: f64) -> Pose {
    let t = k as f64;
    let turn = DQuat::from_rotation_x(1.1 * t) * DQuat::from_rotation_y(0.7 * t);
    Pose::new(turn, DVec3::new((2.3 * t).sin(), (1.7 * t).cos(), 0.3) * size).unwrap()
}

/// What parts are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Parts {
    /// Cuboids, without vertices where pairs are only decided.
    Cuboids,
    /// Hulls and spheres among them.
    Mixed,
}

const PARTS: [Parts; 2] = [Parts::Cuboids, Parts::Mixed];

/// Compounds of 1 to 40 parts of that size.
fn compounds(parts: Parts, size: f64) -> Vec<Shape> {
    let part = |k: usize| {
        let t = k as f64;
        let half = DVec3::new(0.3 + 0.2 * t.sin(), 0.2, 0.1 + 0.05 * t.cos()) * size;
        match k {
            43 => Shape::sphere(half.x).unwrap(),
            44 => Shape::cuboid(half).unwrap().rounded(half.y).unwrap(),
            45 => Shape::hull(vec![half, -half, DVec3::X * size, DVec3::Y * size]).unwrap(),
            _ => Shape::cuboid(half).unwrap(),
        }
    };
    let compound = |parts: std::ops::Range<usize>| {
        Shape::compound(parts.map(|k| (part(k), pose(k * k + 3, size))).collect()).unwrap()
    };
    let boxes = [1, 2, 7, 8, 9, 15, 16, 17, 40].map(|count| compound(0..count));
    let mixed = [compound(30..46), compound(40..48)];
    match parts {
        Parts::Cuboids => boxes.into_iter().chain([compound(30..42)]).collect(),
        Parts::Mixed => boxes.into_iter().chain(mixed).collect(),
    }
}

fn scene(parts: Parts, size: f64, distance: f64) -> Scene {
    let shapes = compounds(parts, size);
    let poses = (0..shapes.len()).map(|k| pose(k, distance)).collect();
    Scene::one_each(shapes, poses).unwrap()
}

fn prepare(scene: &Scene, path: Path, frame: &mut SimdFrame) -> Vec<Aabb> {
    let narrow = Overlap::on(path);
    let mut aabbs = vec![Aabb::EMPTY; scene.len()];
    let part = narrow.layout(scene, Sides::One, frame);
    narrow.prepare(scene, 0, part, &mut aabbs);
    aabbs
}

#[test]
fn the_box_round_a_compound_of_cuboids_holds_their_vertices_and_hardly_more() {
    for (size, distance) in [(1e-9, 1e-9), (1e-9, 1.0), (1.0, 1.0), (1.0, 1e6), (1e6, 1e9)] {
        let scenes = PARTS.map(|parts| scene(parts, size, distance));
        for (path, scene) in paths().flat_map(|path| scenes.iter().map(move |s| (path, s))) {
            for (i, aabb) in prepare(scene, path, &mut SimdFrame::default()).iter().enumerate() {
                let (shape, pose) = (scene.shape(i), &scene.poses()[i]);
                let Shape::Compound(compound) = shape else { panic!("{i}: no compound") };
                let reach = shape.reach() + pose.translation().abs().max_element();
                for part in compound.parts() {
                    let placed = part.placed().as_polytope().unwrap();
                    let radius = placed.swept_radius() - 1e-15 * reach;
                    for &vertex in placed.vertices() {
                        let [low, high] = [-radius, radius].map(|r| pose.apply(vertex) + r);
                        let holds =
                            low.cmpge(aabb.min.as_dvec3()) & high.cmple(aabb.max.as_dvec3());
                        assert!(holds.all(), "{path:?} {i}: {aabb:?} does not hold {vertex}");
                    }
                }
                let (plain, slack) = (shape.aabb(pose), (2e-6 * reach) as f32);
                let larger = Aabb { min: plain.min - slack, max: plain.max + slack };
                assert!(larger.contains(aabb), "{path:?} {i}: {aabb:?}, {plain:?}");
            }
        }
    }
}

/// All that is prepared of a frame, in a form that shows every bit.
fn bits(frame: &SimdFrame, aabbs: &[Aabb]) -> String {
    let records = frame.records();
    let boxes: Vec<_> = (0..records.len() as u32).map(|k| frame.boxes(k).numbers).collect();
    format!("{aabbs:?} {records:?} {boxes:?} {:?}", frame.blocks())
}

#[test]
fn what_is_prepared_is_the_same_on_every_path_and_whatever_pose_was_before() {
    PARTS.iter().for_each(|&parts| check_what_is_prepared(scene(parts, 1.0, 3.0)));
}

fn check_what_is_prepared(mut scene: Scene) {
    let mut fresh = SimdFrame::default();
    let aabbs = prepare(&scene, Path::Portable, &mut fresh);
    let expected = bits(&fresh, &aabbs);
    let poses = scene.poses().to_vec();
    for path in paths() {
        let mut frame = SimdFrame::default();
        let aabbs = prepare(&scene, path, &mut frame);
        assert!(bits(&frame, &aabbs) == expected, "{path:?}");
        for (k, pose) in poses.iter().enumerate() {
            let stretched =
                *pose.rotation() * DMat3::from_diagonal(DVec3::new(1.0, 1.0, 1.0 + 1e-7));
            scene.set_pose(k, Pose::from_matrix(stretched, pose.translation()).unwrap()).unwrap();
        }
        let aabbs = prepare(&scene, path, &mut frame);
        assert!(bits(&frame, &aabbs) != expected, "{path:?}");
        poses.iter().enumerate().for_each(|(k, pose)| scene.set_pose(k, *pose).unwrap());
        let aabbs = prepare(&scene, path, &mut frame);
        assert!(bits(&frame, &aabbs) == expected, "{path:?}: not as before");
    }
}

#[test]
fn parts_side_by_side_are_placed_and_turned_as_one_by_one() {
    PARTS.iter().for_each(|&parts| check_side_by_side(&scene(parts, 1.0, 3.0)));
}

fn check_side_by_side(scene: &Scene) {
    let mut frame = SimdFrame::default();
    prepare(scene, Path::best(), &mut frame);
    for (i, pose) in scene.poses().iter().enumerate() {
        let members = frame.members(i as u32).unwrap();
        let cores = frame.cores();
        let core = &cores.cores()[scene.shape_index(i) as usize];
        for part in 0..core.parts {
            let (at, record) = ((core.first_part + part) as usize, members.first + part);
            let alone = super::place(frame.record(record), &cores.parts()[at], pose);
            assert_eq!(format!("{alone:?}"), format!("{:?}", frame.record(record)));
            if cores.parts()[at].has_obb {
                let turned = super::turn(&cores.part_obbs()[at], &alone, pose);
                assert_eq!(turned.numbers, frame.boxes(record).numbers, "{i} {part}");
            }
        }
    }
}

/// Which pairs of a scene's objects touch, by a narrow phase.
fn touching<N: NarrowPhase<Answer = ()>>(narrow: &N, scene: &Scene) -> Vec<Pair> {
    let mut frame = N::Frame::default();
    let mut aabbs = vec![Aabb::EMPTY; scene.len()];
    let part = narrow.layout(scene, Sides::One, &mut frame);
    narrow.prepare(scene, 0, part, &mut aabbs);
    let count = scene.len() as u32;
    let all: Vec<Pair> =
        (0..count).flat_map(|i| (i + 1..count).map(move |j| Pair { i, j })).collect();
    let (mut contacts, mut report) = (Vec::new(), Report::default());
    let mut sink = ContactSink { contacts: &mut contacts, report: &mut report };
    let side = Prepared { scene, frame: &frame };
    narrow.decide(side, side, &all, &mut N::Scratch::default(), &mut sink);
    assert!(report.undecided().is_empty());
    contacts.iter().map(|contact| contact.pair).collect()
}

#[test]
fn compounds_without_vertices_touch_as_exact_numbers_have_it() {
    let mut found = [0; 2];
    for seed in 0..60 {
        let stretch = [0.0, 1e-7, 1e-13][seed % 3];
        let shapes = compounds(Parts::Cuboids, 1.0);
        // Some cuboids of their own, and one that the parts of the first compound rest on.
        let cuboid = |k: usize| Shape::cuboid(DVec3::new(0.2, 0.3, 0.1 * k as f64 + 0.1)).unwrap();
        let shapes: Vec<Shape> = shapes.into_iter().chain((0..4).map(cuboid)).collect();
        let turned = |k: usize| {
            let pose = pose(k + 31 * seed, 4.0);
            let matrix = DMat3::from_diagonal(DVec3::new(1.0 + stretch, 1.0, 1.0));
            Pose::from_matrix(*pose.rotation() * matrix, pose.translation()).unwrap()
        };
        let poses: Vec<Pose> = (0..shapes.len()).map(turned).collect();
        let scene = Scene::one_each(shapes, poses).unwrap();
        for path in paths() {
            let all = touching(&Overlap::on(path), &scene);
            for i in 0..scene.len() as u32 {
                for j in i + 1..scene.len() as u32 {
                    let sides = [i, j].map(|k| PosedShape::of(&scene, k));
                    let expected = certified::overlap_of(sides[0], sides[1]).0;
                    let touches = all.contains(&Pair { i, j });
                    let verdict = if touches { Verdict::Touching(()) } else { Verdict::Apart };
                    assert_eq!(verdict, expected, "{path:?} {seed} {i} {j}");
                    found[usize::from(touches)] += 1;
                }
            }
        }
    }
    let least = 150 * paths().count();
    assert!(found.iter().all(|&count| count > least), "{found:?}");
}

/// A ball about the origin, known by its support map alone.
struct Ball;

impl SupportMap<f64> for Ball {
    fn support(&self, direction: DVec3) -> Support<f64> {
        Support::of_point(direction.normalize_or(DVec3::X) * 0.4)
    }

    fn support_error(&self) -> f64 {
        1e-15
    }
}

#[test]
fn parts_that_the_lanes_do_not_know_are_not_passed_by_beside_cuboids() {
    let mut found = [0; 2];
    for seed in 0..40 {
        let cuboid = Shape::cuboid(DVec3::new(0.3, 0.2, 0.1)).unwrap();
        let unknown = [
            Shape::ellipsoid(DVec3::new(0.3, 0.4, 0.5)).unwrap(),
            Shape::custom(Arc::new(Ball)).unwrap(),
        ];
        let compound = |k: usize| {
            // An ellipsoid that is not moved has vertices.
            let place = if k == 3 { Pose::IDENTITY } else { pose(k + 7 * seed, 1.0) };
            let parts =
                [(cuboid.clone(), pose(k + 5 * seed, 1.0)), (unknown[k % 2].clone(), place)];
            Shape::compound(parts.to_vec()).unwrap()
        };
        // Without a whole object that has vertices.
        let shapes: Vec<_> = (0..4).map(compound).chain([cuboid.clone(), cuboid.clone()]).collect();
        let poses = (0..shapes.len()).map(|k| pose(k + 31 * seed, 0.7)).collect();
        let scene = Scene::one_each(shapes, poses).unwrap();
        for path in paths() {
            let all = touching(&Overlap::on(path), &scene);
            for i in 0..scene.len() as u32 {
                for j in i + 1..scene.len() as u32 {
                    let [a, b] = [i, j].map(|k| PosedShape::of(&scene, k));
                    let is_touching = certified::overlap_of(a, b).0 == Verdict::Touching(());
                    let what = format!("{path:?} {seed} {i} {j}");
                    assert_eq!(all.contains(&Pair { i, j }), is_touching, "{what}");
                    found[usize::from(is_touching)] += 1;
                }
            }
        }
    }
    assert!(found.iter().all(|&count| count > 100), "{found:?}");
}

#[test]
fn parts_have_vertices_only_where_some_are_read() {
    let blocks = |parts, narrow: &dyn Fn(&Scene, &mut SimdFrame)| {
        let mut frame = SimdFrame::default();
        narrow(&scene(parts, 1.0, 3.0), &mut frame);
        frame.blocks().len()
    };
    let decides = |scene: &Scene, frame: &mut SimdFrame| {
        Overlap::on(Path::best()).layout(scene, Sides::One, frame);
    };
    let measures = |scene: &Scene, frame: &mut SimdFrame| {
        SimdDepths::new(Depths, Accuracy::F32).layout(scene, Sides::One, frame);
    };
    assert_eq!(blocks(Parts::Cuboids, &decides), 0);
    assert!(blocks(Parts::Cuboids, &measures) > 100);
    assert_eq!(blocks(Parts::Mixed, &decides), blocks(Parts::Mixed, &measures));
}
