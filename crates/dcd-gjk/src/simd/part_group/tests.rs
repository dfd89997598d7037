//! Parts side by side beside the same parts one by one.

use crate::simd::{Overlap, SimdFrame};
use crate::{NarrowPhase, Sides};
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Aabb, Pose, Scene, Shape};
use dcd_simd::Path;

fn paths() -> impl Iterator<Item = Path> {
    Path::ALL.into_iter().filter(|path| path.is_available())
}

fn pose(k: usize, size: f64) -> Pose {
    let t = k as f64;
    let turn = DQuat::from_rotation_x(1.1 * t) * DQuat::from_rotation_y(0.7 * t);
    Pose::new(turn, DVec3::new((2.3 * t).sin(), (1.7 * t).cos(), 0.3) * size).unwrap()
}

/// Compounds of 1 to 40 cuboids of that size, of which some have hulls or spheres among them.
fn compounds(size: f64) -> Vec<Shape> {
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
    boxes.into_iter().chain([compound(30..46), compound(40..48)]).collect()
}

fn scene(size: f64, distance: f64) -> Scene {
    let shapes = compounds(size);
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
        let scene = scene(size, distance);
        for path in paths() {
            for (i, aabb) in prepare(&scene, path, &mut SimdFrame::default()).iter().enumerate() {
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
    let mut scene = scene(1.0, 3.0);
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
    let scene = scene(1.0, 3.0);
    let mut frame = SimdFrame::default();
    prepare(&scene, Path::best(), &mut frame);
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
