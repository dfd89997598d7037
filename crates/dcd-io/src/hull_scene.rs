//! Hull scenes, raw, little endian: u32 n; then n times u32 vertex count, u32 triangle count,
//! vertices (3 f64), triangles (3 u32), quaternion x y z w (4 f64), translation (3 f64).

use crate::bytes::{Cursor, Field};
use crate::{RawObject, RawScene, RawShape, ReadError};
use dcd_geom::SceneError;
use glam::{DQuat, DVec3};
use std::io::{self, Write};
use std::path::Path;

/// Bytes of an object without vertices and triangles: two counts and seven f64.
const SMALLEST: u64 = 8 + 7 * 8;

/// Reads a hull scene, one shape an object. Poses, and that the numbers are finite, are checked by
/// [`RawScene::into_scene`].
///
/// # Errors
/// A file that is cut short or goes on, a count that it cannot hold, a triangle with a corner that
/// is no vertex.
pub fn read_hull_scene(bytes: &[u8]) -> Result<RawScene, ReadError> {
    let mut cursor = Cursor::new(bytes, 0);
    let count = cursor.u32(Field { what: "count", index: 0 })?;
    cursor.room(Field { what: "objects", index: 0 }, count.into(), SMALLEST)?;
    let mut scene = RawScene::default();
    for shape in 0..count {
        let index = shape as usize;
        scene.shapes.push(read_shape(&mut cursor, index)?);
        let field = Field { what: "pose", index };
        let rotation = DQuat::from_array(cursor.f64s(field)?);
        let translation = DVec3::from_array(cursor.f64s(field)?);
        scene.objects.push(RawObject { shape, rotation, translation });
    }
    cursor.end()?;
    Ok(scene)
}

/// [`read_hull_scene`] from a file.
///
/// # Errors
/// Those of [`read_hull_scene`], and those of reading the file, both with its path.
pub fn load_hull_scene(path: &Path) -> Result<RawScene, ReadError> {
    ReadError::within(path, read_hull_scene)
}

fn read_shape(cursor: &mut Cursor<'_>, index: usize) -> Result<RawShape, ReadError> {
    let counts = Field { what: "counts", index };
    let (vertices, triangles) = (cursor.u32(counts)?, cursor.u32(counts)?);
    let field = Field { what: "vertices", index };
    cursor.room(field, vertices.into(), 24)?;
    let mut points = Vec::with_capacity(vertices as usize);
    for _ in 0..vertices {
        points.push(DVec3::from_array(cursor.f64s(field)?));
    }
    let field = Field { what: "triangles", index };
    cursor.room(field, triangles.into(), 12)?;
    let mut surface = Vec::with_capacity(triangles as usize);
    for _ in 0..triangles {
        let triangle = [cursor.u32(field)?, cursor.u32(field)?, cursor.u32(field)?];
        if let Some(&corner) = triangle.iter().find(|&&corner| corner >= vertices) {
            return Err(ReadError::OutOfBounds {
                what: "a triangle of object",
                index,
                target: corner.into(),
                count: vertices as usize,
            });
        }
        surface.push(triangle);
    }
    Ok(RawShape::Hull { points, triangles: surface })
}

/// Writes a scene so that [`read_hull_scene`] gives the same numbers back. A shape that several
/// objects share is written with each; a cuboid is written as its corners.
///
/// # Errors
/// Those of the writer; counts past u32 and an object whose shape does not exist, as invalid input
/// that holds a [`SceneError`]; a sphere or a capsule, which the format has no radius for.
pub fn write_hull_scene(scene: &RawScene, out: &mut impl Write) -> io::Result<()> {
    out.write_all(&count("objects", scene.objects.len())?)?;
    for (object, raw) in scene.objects.iter().enumerate() {
        let Some(shape) = scene.shapes.get(raw.shape as usize) else {
            let shapes = scene.shapes.len();
            return Err(invalid(SceneError::NoSuchShape { object, shape: raw.shape, shapes }));
        };
        if let RawShape::Sphere { radius } | RawShape::Capsule { radius, .. } = shape {
            let refused =
                format!("object {object}: a hull scene has no room for radius {radius:e}");
            return Err(io::Error::new(io::ErrorKind::InvalidInput, refused));
        }
        write_shape(shape, out)?;
        write_numbers(&raw.rotation.to_array(), out)?;
        write_numbers(&raw.translation.to_array(), out)?;
    }
    out.flush()
}

fn write_shape(shape: &RawShape, out: &mut impl Write) -> io::Result<()> {
    let points = shape.points();
    let triangles: &[[u32; 3]] = match shape {
        RawShape::Hull { triangles, .. } => triangles,
        _ => &[],
    };
    out.write_all(&count("vertices", points.len())?)?;
    out.write_all(&count("triangles", triangles.len())?)?;
    for point in &points {
        write_numbers(&point.to_array(), out)?;
    }
    for corner in triangles.as_flattened() {
        out.write_all(&corner.to_le_bytes())?;
    }
    Ok(())
}

fn write_numbers(numbers: &[f64], out: &mut impl Write) -> io::Result<()> {
    numbers.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

fn count(what: &'static str, count: usize) -> io::Result<[u8; 4]> {
    match u32::try_from(count) {
        Ok(count) => Ok(count.to_le_bytes()),
        Err(_) => Err(invalid(SceneError::TooMany { what, count })),
    }
}

fn invalid(error: SceneError) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> RawScene {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let object = |shape, x| RawObject {
            shape,
            rotation: DQuat::IDENTITY,
            translation: DVec3::new(x, 0.0, 0.0),
        };
        RawScene {
            shapes: vec![
                RawShape::Hull { points: points.clone(), triangles },
                RawShape::Hull { points, triangles: vec![] },
            ],
            objects: vec![object(0, 0.0), object(1, 0.5)],
        }
    }

    fn written(scene: &RawScene) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_hull_scene(scene, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn a_radius_is_refused_with_its_object() {
        let mut scene = tetrahedron();
        scene.shapes[1] = RawShape::Sphere { radius: 0.5 };
        let refused = write_hull_scene(&scene, &mut Vec::new()).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::InvalidInput);
        assert!(refused.to_string().contains("object 1") && refused.to_string().contains("5e-1"));
    }

    #[test]
    fn what_is_written_reads_back() {
        let scene = tetrahedron();
        assert_eq!(read_hull_scene(&written(&scene)).unwrap(), scene);
        assert_eq!(read_hull_scene(&[0; 4]).unwrap(), RawScene::default());
    }

    #[test]
    fn a_file_cut_at_any_byte_is_refused_as_truncated() {
        let bytes = written(&tetrahedron());
        for end in 0..bytes.len() {
            let refused = read_hull_scene(&bytes[..end]).unwrap_err();
            assert!(matches!(refused, ReadError::Truncated { .. }), "{end}: {refused}");
        }
    }

    #[test]
    fn a_byte_too_many_is_refused_with_its_place() {
        let mut bytes = written(&tetrahedron());
        let at = bytes.len();
        bytes.push(0);
        let refused = read_hull_scene(&bytes).unwrap_err();
        assert!(matches!(refused, ReadError::Oversized { at: place, left: 1 } if place == at));
    }

    #[test]
    fn a_corrupt_count_is_refused_before_it_is_allocated() {
        for (place, what) in [(0, "objects"), (4, "vertices"), (8, "triangles")] {
            let mut bytes = written(&tetrahedron());
            bytes[place..place + 4].fill(0xff);
            let refused = read_hull_scene(&bytes).unwrap_err();
            let named =
                matches!(refused, ReadError::Truncated { what: w, index: 0, .. } if w == what);
            assert!(named, "{refused}");
        }
    }

    #[test]
    fn a_triangle_whose_corner_is_no_vertex_is_refused() {
        let mut scene = tetrahedron();
        let RawShape::Hull { triangles, .. } = &mut scene.shapes[0] else { unreachable!() };
        triangles[3][1] = 4;
        let refused = read_hull_scene(&written(&scene)).unwrap_err();
        let named = matches!(refused, ReadError::OutOfBounds { index: 0, target: 4, count: 4, .. });
        assert!(named, "{refused}");
    }

    #[test]
    fn nan_no_vertex_and_a_quaternion_that_is_none_are_refused_by_the_scene() {
        for (place, value) in [(12, f64::NAN), (156, f64::NAN), (180, 0.0), (188, f64::INFINITY)] {
            let mut bytes = written(&tetrahedron());
            bytes[place..place + 8].copy_from_slice(&value.to_le_bytes());
            assert!(read_hull_scene(&bytes).unwrap().into_scene().is_err(), "{place} {value}");
        }
        let mut empty = tetrahedron();
        empty.shapes[1] = RawShape::Hull { points: vec![], triangles: vec![] };
        let refused = read_hull_scene(&written(&empty)).unwrap().into_scene().unwrap_err();
        assert_eq!(refused.to_string(), "shape 1: the shape has no point");
    }

    #[test]
    fn writing_an_object_without_shape_is_refused() {
        let mut scene = tetrahedron();
        scene.objects[1].shape = 9;
        let refused = write_hull_scene(&scene, &mut Vec::new()).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::InvalidInput);
        assert!(count("objects", u32::MAX as usize + 1).is_err());
    }

    #[test]
    fn an_absent_file_is_named() {
        let refused = load_hull_scene(Path::new("no/such.scene")).unwrap_err();
        assert!(matches!(&refused, ReadError::Io { .. }));
        assert!(refused.to_string().contains("no/such.scene"));
    }
}
