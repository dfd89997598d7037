//! Hull scenes, raw, little endian: u32 n; then n times u32 vertex count, u32 triangle count,
//! vertices (3 f64), triangles (3 u32), quaternion x y z w (4 f64), translation (3 f64).

use crate::bytes::{Cursor, Field};
use crate::{RawObject, RawScene, RawShape, RawShare, ReadError};
use dcd_geom::SceneError;
use glam::{DQuat, DVec3};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

/// Bytes of a pose: seven f64.
const POSE_BYTES: u64 = 7 * 8;
/// Bytes of an object without vertices and triangles: two counts and a pose.
const SMALLEST: u64 = 8 + POSE_BYTES;

/// Reads a hull scene, one shape an object. Poses, and that the numbers are finite, are checked by
/// [`RawScene::into_scene`].
///
/// # Errors
/// A file that is cut short or goes on, a count that it cannot hold, a triangle with a corner that
/// is no vertex.
pub fn read_hull_scene(bytes: &[u8]) -> Result<RawScene, ReadError> {
    let mut cursor = Cursor::new(bytes, 0);
    let count = cursor.u32(Field { what: "count", index: 0 })?;
    cursor.check_count(Field { what: "objects", index: 0 }, count.into(), SMALLEST)?;
    let scene = read_records(&mut cursor, 0..count)?;
    cursor.end()?;
    Ok(scene)
}

/// The records of these objects; the first has the first shape.
fn read_records(cursor: &mut Cursor<'_>, objects: Range<u32>) -> Result<RawScene, ReadError> {
    let mut scene = RawScene::default();
    for (shape, index) in (0..).zip(objects) {
        let index = index as usize;
        scene.shapes.push(read_shape(cursor, index)?);
        let field = Field { what: "pose", index };
        cursor.check_count(field, 1, POSE_BYTES)?;
        let rotation = DQuat::from_array(cursor.f64s(field)?);
        let translation = DVec3::from_array(cursor.f64s(field)?);
        scene.objects.push(RawObject { shape, rotation, translation });
    }
    Ok(scene)
}

/// Where the records of some objects stand in a hull scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HullRecords {
    /// The objects.
    pub objects: Range<u32>,
    /// Their records, bytes of the file.
    pub bytes: Range<u64>,
}

impl HullRecords {
    /// Finds where the records of so many parts stand, in each about as many objects, by looking at every
    /// record's counts alone: what does not fit in memory can be read part by part.
    ///
    /// # Errors
    /// Those of reading the file; a file that is cut short or goes on.
    pub fn find(path: &Path, parts: usize) -> Result<Vec<Self>, ReadError> {
        let within = |error| ReadError::InFile { path: path.to_path_buf(), error: Box::new(error) };
        let io = |error| ReadError::Io { path: path.to_path_buf(), error };
        let mut file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        let mut scan = Scan { file: &mut file, at: 0, length };
        let [count] =
            scan.counts(Field { what: "count", index: 0 }).map_err(io)?.map_err(within)?;
        scan.check_count(Field { what: "objects", index: 0 }, count, SMALLEST).map_err(within)?;
        let parts = parts.max(1) as u64;
        let first = |part: u64| (u64::from(count) * part / parts) as u32;
        let mut found = Vec::new();
        for part in 0..parts {
            let (objects, start) = (first(part)..first(part + 1), scan.at);
            for object in objects.clone() {
                scan.pass(object as usize).map_err(io)?.map_err(within)?;
            }
            found.push(Self { objects, bytes: start..scan.at });
        }
        if scan.at < length {
            let (at, left) = (scan.at as usize, (length - scan.at) as usize);
            return Err(within(ReadError::Oversized { at, left }));
        }
        Ok(found)
    }
}

/// What a file's system says, and what the file does.
type Scanned<T> = io::Result<Result<T, ReadError>>;

/// A place in a file of which little is read.
struct Scan<'a> {
    file: &'a mut File,
    at: u64,
    length: u64,
}

impl Scan<'_> {
    fn check_count(&self, field: Field, count: u32, size: u64) -> Result<(), ReadError> {
        let (needed, left) = (u64::from(count) * size, self.length - self.at);
        if needed <= left {
            return Ok(());
        }
        let Field { what, index } = field;
        Err(ReadError::Truncated { what, index, at: self.at as usize, needed, left: left as usize })
    }

    /// The next u32s.
    fn counts<const N: usize>(&mut self, field: Field) -> Scanned<[u32; N]> {
        if let Err(error) = self.check_count(field, N as u32, 4) {
            return Ok(Err(error));
        }
        let mut counts = [[0; 4]; N];
        self.file.read_exact(counts.as_flattened_mut())?;
        self.at += 4 * N as u64;
        Ok(Ok(counts.map(u32::from_le_bytes)))
    }

    /// Passes over an object's record.
    fn pass(&mut self, index: usize) -> Scanned<()> {
        let [vertices, triangles] = match self.counts(Field { what: "counts", index })? {
            Ok(counts) => counts,
            Err(error) => return Ok(Err(error)),
        };
        for (what, count, size) in
            [("vertices", vertices, 24), ("triangles", triangles, 12), ("pose", 1, POSE_BYTES)]
        {
            if let Err(error) = self.check_count(Field { what, index }, count, size) {
                return Ok(Err(error));
            }
            self.at += u64::from(count) * size;
        }
        self.file.seek(SeekFrom::Start(self.at))?;
        Ok(Ok(()))
    }
}

/// Reads the records that [`HullRecords::find`] found.
///
/// # Errors
/// Those of reading the file, and those of [`read_hull_scene`], with the indices of the whole; a file that has
/// changed meanwhile.
pub fn load_hull_records(path: &Path, records: &HullRecords) -> Result<RawShare, ReadError> {
    let io = |error| ReadError::Io { path: path.to_path_buf(), error };
    let mut file = File::open(path).map_err(io)?;
    file.seek(SeekFrom::Start(records.bytes.start)).map_err(io)?;
    let mut bytes = Vec::new();
    file.take(records.bytes.end - records.bytes.start).read_to_end(&mut bytes).map_err(io)?;
    let mut cursor = Cursor::new(&bytes, 0);
    let scene = read_records(&mut cursor, records.objects.clone())
        .and_then(|scene| cursor.end().map(|()| scene))
        .map_err(|error| ReadError::InFile { path: path.to_path_buf(), error: Box::new(error) })?;
    Ok(RawShare {
        first: records.objects.start as usize,
        shape_names: records.objects.clone().map(u64::from).collect(),
        scene,
    })
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
    cursor.check_count(counts, 1, 8)?;
    let (vertices, triangles) = (cursor.u32(counts)?, cursor.u32(counts)?);
    let field = Field { what: "vertices", index };
    cursor.check_count(field, vertices.into(), 24)?;
    let mut points = Vec::with_capacity(vertices as usize);
    for _ in 0..vertices {
        points.push(DVec3::from_array(cursor.f64s(field)?));
    }
    let field = Field { what: "triangles", index };
    cursor.check_count(field, triangles.into(), 12)?;
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
            let refused = format!("object {object}: a hull scene cannot hold radius {radius:e}");
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
    fn the_parts_of_a_file_are_the_whole() {
        let mut whole = tetrahedron();
        for k in 0..9 {
            whole.objects.push(RawObject {
                shape: k % 2,
                translation: DVec3::splat(f64::from(k)),
                ..whole.objects[0]
            });
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene");
        std::fs::write(&path, written(&whole)).unwrap();
        let whole = load_hull_scene(&path).unwrap();
        for parts in [1, 2, 5, 11, 40] {
            let found = HullRecords::find(&path, parts).unwrap();
            assert_eq!(found.len(), parts);
            let mut joined = RawScene::default();
            for records in &found {
                let share = load_hull_records(&path, records).unwrap();
                assert_eq!(share.first, joined.objects.len());
                let names = share.shape_names.iter().map(|&name| name as u32);
                let objects = share.scene.objects.iter().zip(names);
                joined
                    .objects
                    .extend(objects.map(|(&object, shape)| RawObject { shape, ..object }));
                joined.shapes.extend(share.scene.shapes);
            }
            assert_eq!(joined, whole);
        }
        let bytes = written(&tetrahedron());
        for end in 0..bytes.len() {
            std::fs::write(&path, &bytes[..end]).unwrap();
            let [slowly, scanned] =
                [load_hull_scene(&path).err(), HullRecords::find(&path, 2).err()]
                    .map(|error| error.map(|error| error.to_string()));
            assert_eq!(scanned, slowly, "{end}");
        }
        std::fs::write(&path, [bytes.clone(), vec![0]].concat()).unwrap();
        assert!(HullRecords::find(&path, 2).unwrap_err().to_string().contains("1 bytes are left"));
        let corner = u32::from_le_bytes(bytes[108..112].try_into().unwrap());
        assert!(corner < 4);
        let mut wrong = bytes;
        wrong[108] = 9;
        std::fs::write(&path, wrong).unwrap();
        let found = HullRecords::find(&path, 1).unwrap();
        let refused = load_hull_records(&path, &found[0]).unwrap_err().to_string();
        assert!(refused.contains("object 0") && refused.contains('9'), "{refused}");
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
