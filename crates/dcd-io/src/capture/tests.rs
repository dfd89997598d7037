use super::*;
use crate::ReadError;
use dcd_geom::{
    Filter, Motion, Object, Polytope, PoseError, Shape, ShapeError, Support, SupportMap,
};
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// A hull, a rounded box and a sphere, which is a sensor; the box twice; three frames.
fn recorded() -> Capture {
    let hull = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.1, 0.2, 0.3)];
    let cuboid = Polytope::cuboid(DVec3::new(1.0, 2.0, 3.0)).unwrap().rounded(0.25).unwrap();
    let shapes = vec![Shape::hull(hull).unwrap(), cuboid.into(), Shape::sphere(0.5).unwrap()];
    let object = |shape, x| Object {
        shape,
        pose: Pose::new(DQuat::from_rotation_y(x), DVec3::X * x).unwrap(),
        filter: Filter { groups: 1 << shape, mask: !(4 << shape) },
        motion: if shape == 0 { Motion::Static } else { Motion::Moving },
        sensor: shape == 2,
        user_data: 0,
    };
    let objects = [object(1, 0.3), object(0, -2.0), object(2, 0.7), object(1, 1.1)];
    let mut scene = Scene::new(shapes, objects).unwrap();
    scene.remove(scene.handle(3).unwrap()).unwrap();
    scene.ignore_pair(0, 2).unwrap();
    let mut capture = Capture::new(&scene).unwrap();
    for frame in 0..3 {
        let turn = DQuat::from_rotation_x(f64::from(frame) * 0.1);
        scene.set_pose(2, Pose::new(turn, DVec3::Z * f64::from(frame)).unwrap()).unwrap();
        capture.frame(&scene).unwrap();
    }
    capture
}

fn written(capture: &Capture) -> Vec<u8> {
    let mut bytes = Vec::new();
    capture.write(&mut bytes).unwrap();
    bytes
}

/// Where the header ends; where shape 1, object 0 and the first pose begin.
const HEADER: usize = 8 + 4 * 4;
const SHAPE_1: usize = HEADER + 4 + 8 + 4 + 4 * 24;
const OBJECT_0: usize = SHAPE_1 + (4 + 8 + 24) + (4 + 8);
const IGNORED: usize = OBJECT_0 + 4 * 16;
const FRAME_0: usize = IGNORED + 4 + 8;
const FRAME_BYTES: usize = 4 + 4 * POSE_BYTES;

/// Where a pose begins.
fn pose_at(frame: usize, object: usize) -> usize {
    FRAME_0 + frame * FRAME_BYTES + 4 + object * POSE_BYTES
}

fn spoilt(at: usize, bytes: &[u8]) -> ReadError {
    let mut file = written(&recorded());
    file[at..at + bytes.len()].copy_from_slice(bytes);
    Capture::read(&file).unwrap_err()
}

#[test]
fn what_is_written_reads_back_bit_for_bit() {
    let capture = recorded();
    let bytes = written(&capture);
    assert_eq!(bytes.len(), pose_at(3, 0) - 4);
    let again = Capture::read(&bytes).unwrap();
    assert_eq!(again.frame_count(), 3);
    assert!(again.frames().eq(capture.frames()));
    let [a, b] = [&again, &capture].map(Capture::scene);
    assert_eq!(a.filters(), b.filters());
    assert!((0..5).all(|slot| a.motion(slot) == b.motion(slot)));
    assert_eq!((a.sensors(), a.sensors()), (&[false, false, true, false][..], b.sensors()));
    assert_eq!((a.motion(1), a.motion(3)), (Some(Motion::Static), None));
    assert!(!a.allows(0, 2) && a.ignored_pairs().eq(b.ignored_pairs()));
    assert_eq!(written(&again), bytes);
}

/// Its surface; with a vertex that no triangle names, and a triangle that is a segment.
fn tetrahedron() -> Result<Shape, ShapeError> {
    let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE * 9.0];
    Shape::mesh(vertices, vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2], [0, 1, 1]])
}

/// Parts of radii of their own, one of them turned, one a cone that is moved.
fn compound() -> Result<Shape, ShapeError> {
    let turned = Pose::new(DQuat::from_rotation_z(0.3), DVec3::X).unwrap();
    let parts = vec![
        (Shape::cuboid(DVec3::ONE)?.rounded(0.25)?, Pose::IDENTITY),
        (Shape::cone(1.0, 0.5)?.rounded(0.125)?, turned),
        (Shape::sphere(0.5)?, turned),
    ];
    Shape::compound(parts)
}

#[test]
fn a_shape_alone_reads_back_and_leaves_what_follows() {
    for shape in [tetrahedron().unwrap(), compound().unwrap(), Shape::sphere(2.0).unwrap()] {
        let mut bytes = Vec::new();
        write_shape(&mut bytes, &shape).unwrap();
        for end in 0..bytes.len() {
            assert!(read_shape(&bytes[..end]).is_err(), "{shape:?}: {end}");
        }
        bytes.extend([7, 8, 9]);
        let (again, rest) = read_shape(&bytes).unwrap();
        assert_eq!(format!("{again:?}"), format!("{shape:?}"));
        assert_eq!(rest, [7, 8, 9]);
    }
}

#[test]
fn a_part_that_no_compound_holds_is_refused_with_its_index() {
    let mut bytes = Vec::new();
    write_shape(&mut bytes, &compound().unwrap()).unwrap();
    // The first part's kind stands behind the compound's kind, radius and count, and the part's pose.
    let kind = 4 + 8 + 4 + POSE_BYTES;
    let mut nested = bytes.clone();
    nested[kind..kind + 4].copy_from_slice(&9u32.to_le_bytes());
    let refused = read_shape(&nested).unwrap_err();
    let error = ShapeError::BadPart { part: 0 };
    assert!(matches!(refused, ReadError::Shape { error: e, .. } if e == error), "{refused}");
    let mut mirrored = bytes;
    mirrored[16..24].copy_from_slice(&(-1f64).to_le_bytes());
    let refused = read_shape(&mirrored).unwrap_err();
    assert!(matches!(refused, ReadError::PartPose { part: 0, at: 16, .. }), "{refused}");
}

#[test]
fn every_kind_of_shape_reads_back_as_it_was() {
    let shapes = [
        Shape::capsule(1.0, 0.5),
        Shape::segment(DVec3::X, DVec3::Y),
        Shape::triangle([DVec3::X, DVec3::Y, DVec3::Z]),
        Shape::cylinder(1.5, 0.25),
        Shape::cone(1.5, 0.75).and_then(|cone| cone.rounded(0.125)),
        Shape::ellipsoid(DVec3::new(1.0, 0.0, 2.5)).and_then(|shape| shape.rounded(0.25)),
        Shape::half_space(DVec3::new(0.1, 0.2, 3.0), -0.5),
        Shape::cuboid(DVec3::ONE).and_then(|cuboid| cuboid.rounded(0.1)),
        Shape::sphere(2.0),
        Shape::hull(vec![DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Z]),
        tetrahedron().and_then(|mesh| mesh.rounded(0.01)),
        compound(),
    ];
    let shapes: Vec<Shape> = shapes.into_iter().collect::<Result<_, _>>().unwrap();
    let scene = Scene::one_each(shapes.clone(), vec![Pose::IDENTITY; shapes.len()]).unwrap();
    let again = Capture::read(&written(&Capture::new(&scene).unwrap())).unwrap();
    // All that a shape is made of shows here.
    let [before, after] = [&scene, again.scene()].map(|scene| format!("{:?}", scene.shapes()));
    assert_eq!(before, after);
}

#[test]
fn a_capture_without_objects_or_frames_is_legal() {
    let empty = Scene::one_each(vec![], vec![]).unwrap();
    let mut capture = Capture::new(&empty).unwrap();
    capture.frame(&empty).unwrap();
    assert_eq!(Capture::read(&written(&capture)).unwrap().frames().len(), 1);
    let mut still = recorded();
    (still.count, still.poses) = (0, Vec::new());
    let again = Capture::read(&written(&still)).unwrap();
    assert_eq!((again.frame_count(), again.scene().len()), (0, 4));
}

#[test]
fn a_file_cut_at_any_byte_is_refused_with_its_place() {
    let bytes = written(&recorded());
    for end in 0..bytes.len() {
        let refused = Capture::read(&bytes[..end]).unwrap_err();
        let placed = matches!(refused, ReadError::Truncated { at, .. } if at <= end);
        assert!(placed, "{end}: {refused}");
    }
}

#[test]
fn a_byte_too_many_is_refused_with_its_place() {
    let mut bytes = written(&recorded());
    let end = bytes.len();
    bytes.push(0);
    let refused = Capture::read(&bytes).unwrap_err();
    assert!(matches!(refused, ReadError::Oversized { at, left: 1 } if at == end), "{refused}");
}

#[test]
fn another_signature_or_version_is_refused_with_what_stands_there() {
    let signature = spoilt(0, b"RIFF");
    assert!(matches!(signature, ReadError::Signature { found, .. } if found[..4] == *b"RIFF"));
    let version = spoilt(8, &2u32.to_le_bytes());
    assert!(matches!(version, ReadError::Version { found: 2, known: 1 }), "{version}");
    assert_eq!(version.to_string(), "the file is of version 2, not 1");
}

#[test]
fn counts_that_the_file_cannot_hold_are_refused_before_allocation() {
    for (at, what) in [
        (12, "shapes"),
        (16, "objects"),
        (20, "frames"),
        (IGNORED, "ignored pairs"),
        (HEADER + 12, "vertices"),
    ] {
        let refused = spoilt(at, &u32::MAX.to_le_bytes());
        let named = matches!(refused, ReadError::Truncated { what: w, .. } if w == what);
        assert!(named, "{what}: {refused}");
    }
}

#[test]
fn an_unknown_kind_and_an_unknown_shape_are_refused_with_index_and_value() {
    let kind = spoilt(SHAPE_1, &77u32.to_le_bytes());
    let named = matches!(kind, ReadError::UnknownKind { index: 1, at: SHAPE_1, tag: 77, .. });
    assert!(named, "{kind}");
    let shape = spoilt(OBJECT_0 + 16, &3u32.to_le_bytes());
    let named = matches!(shape, ReadError::OutOfBounds { index: 1, target: 3, count: 3, .. });
    assert!(named, "{shape}");
    let held = spoilt(OBJECT_0 + 12, &3u32.to_le_bytes());
    assert!(
        matches!(held, ReadError::UnknownKind { index: 0, at: OBJECT_0, tag: 3, .. }),
        "{held}"
    );
    let pair = spoilt(IGNORED + 8, &9u32.to_le_bytes());
    let missing = SceneError::NoSuchObject { object: 9, objects: 4 };
    assert!(matches!(pair, ReadError::Scene { error, .. } if error == missing), "{pair}");
}

#[test]
fn numbers_that_are_not_finite_are_refused_with_index_place_and_value() {
    let nan = f64::NAN.to_le_bytes();
    let vertex = spoilt(HEADER + 16 + 2 * 24, &nan);
    let error = |error: &ReadError| match *error {
        ReadError::Shape { index, at, error } => Some((index, at, error)),
        _ => None,
    };
    let named = matches!(
        error(&vertex),
        Some((0, HEADER, ShapeError::NotFinite { vertex: 2, value })) if value.is_nan()
    );
    assert!(named, "{vertex}");
    let radius = spoilt(SHAPE_1 + 4, &(-1f64).to_le_bytes());
    assert!(matches!(error(&radius), Some((1, SHAPE_1, ShapeError::BadLength { .. }))), "{radius}");
    // The second frame's third object, its y.
    let place = pose_at(1, 2);
    let pose = spoilt(place + 10 * 8, &nan);
    let named = matches!(
        pose,
        ReadError::Pose { frame: 1, object: 2, at, error: PoseError::NotFinite { value } }
            if at == place && value.is_nan()
    );
    assert!(named, "{pose}");
    assert!(pose.to_string().contains("frame 1, object 2"), "{pose}");
}

#[test]
fn a_matrix_that_is_no_rotation_and_a_pose_out_of_range_are_refused_with_frame_and_object() {
    let place = pose_at(0, 0);
    let matrix = spoilt(place, &2f64.to_le_bytes());
    assert!(
        matches!(matrix, ReadError::Pose { frame: 0, object: 0, at, .. } if at == place),
        "{matrix}"
    );
    let far = spoilt(pose_at(2, 1) + 11 * 8, &1e38f64.to_le_bytes());
    let named = matches!(
        far,
        ReadError::Scene { frame: 2, error: SceneError::OutOfRange { object: 1, .. } }
    );
    assert!(named, "{far}");
}

#[test]
fn a_frame_that_carries_another_number_is_refused_with_both() {
    let at = pose_at(1, 0) - 4;
    let refused = spoilt(at, &7u32.to_le_bytes());
    let place = at;
    let named = matches!(
        refused,
        ReadError::Misplaced { index: 1, at, found: 7, .. } if at == place
    );
    assert!(named, "{refused}");
}

#[test]
fn a_frame_of_a_scene_that_changed_and_a_foreign_shape_are_refused() {
    let mut capture = recorded();
    let refused = |capture: &mut Capture, scene: &Scene| capture.frame(scene).unwrap_err();
    let changed = |what| CaptureError::Changed { what, frame: 3 };
    let mut scene = capture.scene().clone();
    scene.unignore_pair(0, 2).unwrap();
    assert_eq!(refused(&mut capture, &scene), changed("ignored pairs"));
    scene.set_sensor(2, false).unwrap();
    assert_eq!(refused(&mut capture, &scene), changed("sensors"));
    scene.insert(Object::new(0, Pose::IDENTITY)).unwrap();
    assert_eq!(refused(&mut capture, &scene), changed("objects"));
    assert_eq!(capture.frame_count(), 3);
    struct Foreign;
    impl SupportMap<f64> for Foreign {
        fn support(&self, _: DVec3) -> Support<f64> {
            Support { point: DVec3::ZERO, feature: 0 }
        }
    }
    let shapes = vec![Shape::sphere(1.0).unwrap(), Shape::custom(Arc::new(Foreign)).unwrap()];
    let scene = Scene::one_each(shapes, vec![Pose::IDENTITY; 2]).unwrap();
    assert_eq!(Capture::new(&scene).unwrap_err(), CaptureError::Shape { shape: 1 });
    let inside = Shape::compound(vec![(scene.shapes()[1].clone(), Pose::IDENTITY)]).unwrap();
    let refused = write_shape(&mut Vec::new(), &inside).unwrap_err();
    assert_eq!(refused.kind(), std::io::ErrorKind::Unsupported);
}
