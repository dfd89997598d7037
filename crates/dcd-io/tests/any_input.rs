//! Whatever a file holds, it is read or refused; what is written reads back.

use dcd_io::{
    CloudKind, RawObject, RawScene, RawShape, read_boxes, read_clouds, read_hull_scene, read_pair,
    read_ply, write_hull_scene,
};
use glam::{DQuat, DVec3};
use proptest::collection::vec;
use proptest::num::f64::ANY as F64;
use proptest::prelude::*;

fn vector() -> impl Strategy<Value = DVec3> {
    [F64, F64, F64].prop_map(DVec3::from_array)
}

/// Anything that the format can hold, legal as a scene or not.
fn scene() -> impl Strategy<Value = RawScene> {
    let shape = vec(vector(), 1..6).prop_flat_map(|points| {
        let corner = 0..points.len() as u32;
        let triangles = vec([corner.clone(), corner.clone(), corner], 0..4);
        triangles.prop_map(move |triangles| RawShape::Hull { points: points.clone(), triangles })
    });
    let pose = ([F64, F64, F64, F64].prop_map(DQuat::from_array), vector());
    vec((shape, pose), 0..5).prop_map(|parts| {
        let (shapes, poses): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
        let objects = (0..).zip(poses);
        let objects = objects
            .map(|(shape, (rotation, translation))| RawObject { shape, rotation, translation })
            .collect();
        RawScene { shapes, objects }
    })
}

fn written(scene: &RawScene) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_hull_scene(scene, &mut bytes).unwrap();
    bytes
}

/// A failure prints its input; nothing is kept beside the sources.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..Default::default() }
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn a_written_scene_reads_back_bit_for_bit(scene in scene()) {
        let back = read_hull_scene(&written(&scene)).unwrap();
        prop_assert_eq!(back.digest(), scene.digest());
        // NaN differs from itself, and surfaces do not count in the digest: the bytes show both.
        prop_assert_eq!(written(&back), written(&scene));
        let _ = back.into_scene();
    }

    #[test]
    fn a_scene_with_a_byte_changed_never_panics(
        (scene, place, byte) in (scene(), any::<prop::sample::Index>(), any::<u8>()),
    ) {
        let mut bytes = written(&scene);
        let place = place.index(bytes.len());
        bytes[place] = byte;
        if let Ok(raw) = read_hull_scene(&bytes) {
            let _ = raw.into_scene();
        }
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in vec(any::<u8>(), 0..200)) {
        let _ = read_hull_scene(&bytes);
        let _ = read_clouds(&bytes);
        let _ = read_boxes(&bytes);
        let _ = read_ply(&bytes);
        let _ = read_pair(&bytes);
        let header = b"ply\nformat binary_little_endian 1.0\nelement face 5\n\
            property list uchar int vertex_index\nelement vertex 4\nproperty double x\n\
            property float y\nproperty short z\nend_header\n";
        let _ = read_ply(&[&header[..], &bytes].concat());
    }

    #[test]
    fn any_cloud_has_a_kind_and_makes_a_shape(points in vec(vector(), 1..20)) {
        let finite = points.iter().all(|p| p.is_finite());
        prop_assert_eq!(CloudKind::of(&points).is_some(), finite);
        let _ = RawShape::of_cloud(points);
    }
}

/// Small lattices, sheared, squeezed and shaken: coplanar points, slivers and duplicates.
fn degenerate_cloud() -> impl Strategy<Value = Vec<DVec3>> {
    let shake = prop::sample::select(vec![0.0, 1e-16, 1e-14, 1e-12, 1e-9, 1e-7]);
    let squeeze = (prop::sample::select(vec![1.0, 1e-2, 1e-4]), 1e-3..1.0);
    let points = vec(([0..6u8, 0..6, 0..6], [0..99u8, 0..99, 0..99]), 1..60);
    (points, shake, squeeze).prop_map(|(points, shake, (x, shear))| {
        let spot = |a: [u8; 3]| DVec3::from_array(a.map(f64::from));
        let place = |(cell, noise)| spot(cell) + spot(noise) * shake;
        let sheared = |p: DVec3| DVec3::new(p.x * x, p.y + shear * p.x, p.z);
        points.into_iter().map(|point| sheared(place(point))).collect()
    })
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn a_hull_keeps_points_of_its_cloud_and_reaches_as_far(
        (cloud, directions) in (degenerate_cloud(), vec([-1.0..1.0, -1.0..1.0, -1.0..1.0], 20)),
    ) {
        if let Ok(hull) = dcd_io::convex_hull(&cloud) {
            prop_assert!(hull.vertices.iter().all(|v| cloud.contains(v)));
            for direction in directions.into_iter().map(DVec3::from_array) {
                let reach = |points: &[DVec3]| {
                    points.iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
                };
                prop_assert!(reach(&hull.vertices) >= reach(&cloud) - 1e-9);
            }
        }
    }
}
