//! A capture from bytes, every one of them checked.

use super::{Capture, POSE_BYTES, SIGNATURE, VERSION, place_frame, tag};
use crate::ReadError;
use crate::bytes::{Cursor, Field};
use dcd_geom::{Filter, Object, Polytope, Pose, Scene, Shape};
use glam::{DMat3, DVec3};
use std::path::Path;

/// The least that a shape and an object take: asked before room is made for their number.
const LEAST_SHAPE_BYTES: u64 = 4 + 8;
const OBJECT_BYTES: u64 = 3 * 4;

impl Capture {
    /// Reads a file that [`Capture::write`] wrote.
    ///
    /// # Errors
    /// No capture, one of another version, one that is cut short or goes on behind its last frame,
    /// a shape of an unknown kind, an object whose shape does not exist, a number that is not
    /// finite, a matrix that is no rotation, an object out of range: each with its place and value.
    pub fn read(bytes: &[u8]) -> Result<Self, ReadError> {
        let mut cursor = Cursor::new(bytes, 0);
        let [shapes, objects, frames] = read_header(&mut cursor)?;
        cursor.room(field("shapes", 0), u64::from(shapes), LEAST_SHAPE_BYTES)?;
        let shapes: Vec<Shape> = (0..shapes as usize)
            .map(|index| read_shape(&mut cursor, index))
            .collect::<Result<_, _>>()?;
        cursor.room(field("objects", 0), u64::from(objects), OBJECT_BYTES)?;
        let placed: Vec<Placed> = (0..objects as usize)
            .map(|index| read_object(&mut cursor, index, shapes.len()))
            .collect::<Result<_, _>>()?;
        let frame_bytes = 4 + u64::from(objects) * POSE_BYTES as u64;
        cursor.room(field("frames", 0), u64::from(frames), frame_bytes)?;
        // There is room for so many, so that they can be counted in memory.
        let mut poses = Vec::with_capacity(frames as usize * placed.len());
        for frame in 0..frames {
            read_frame(&mut cursor, frame, placed.len(), &mut poses)?;
        }
        cursor.end()?;
        let first = |object: usize| poses.get(object).copied().unwrap_or(Pose::IDENTITY);
        let objects = placed.iter().enumerate().map(|(index, &Placed { shape, filter })| Object {
            filter,
            ..Object::new(shape, first(index))
        });
        let scene =
            Scene::new(shapes, objects).map_err(|error| ReadError::Scene { frame: 0, error })?;
        let capture = Self { scene, poses, count: frames as usize };
        capture.check_range()?;
        Ok(capture)
    }

    /// [`Capture::read`] from a file.
    ///
    /// # Errors
    /// Those of [`Capture::read`], and those of reading the file, both with its path.
    pub fn load(path: &Path) -> Result<Self, ReadError> {
        ReadError::within(path, Self::read)
    }

    /// That no frame moves an object out of range, so that a replay can set every pose.
    fn check_range(&self) -> Result<(), ReadError> {
        let mut scene = self.scene.clone();
        self.frames().enumerate().try_for_each(|(frame, poses)| {
            place_frame(&mut scene, poses).map_err(|error| ReadError::Scene { frame, error })
        })
    }
}

/// An object but for its poses.
struct Placed {
    shape: u32,
    filter: Filter,
}

fn field(what: &'static str, index: usize) -> Field {
    Field { what, index }
}

/// The numbers of shapes, objects and frames.
fn read_header(cursor: &mut Cursor<'_>) -> Result<[u32; 3], ReadError> {
    let found = cursor.take::<8>(field("signature", 0))?;
    if found != SIGNATURE {
        return Err(ReadError::Signature { expected: SIGNATURE, found });
    }
    let found = cursor.u32(field("version", 0))?;
    if found != VERSION {
        return Err(ReadError::Version { found, known: VERSION });
    }
    let mut counts = [0; 3];
    for (count, what) in counts.iter_mut().zip(["shapes", "objects", "frames"]) {
        *count = cursor.u32(field(what, 0))?;
    }
    Ok(counts)
}

fn read_shape(cursor: &mut Cursor<'_>, index: usize) -> Result<Shape, ReadError> {
    let at = cursor.at();
    let kind = cursor.u32(field("shape", index))?;
    let [radius] = cursor.f64s(field("shape", index))?;
    let core = match kind {
        tag::HULL => Polytope::hull(read_vertices(cursor, index)?),
        tag::CUBOID => {
            Polytope::cuboid(DVec3::from_array(cursor.f64s(field("half extents", index))?))
        }
        tag::SPHERE => Polytope::sphere(radius),
        tag => return Err(ReadError::UnknownKind { what: "shape", index, at, tag }),
    };
    let shape = core.and_then(|core| core.rounded(radius));
    shape.map(Shape::from).map_err(|error| ReadError::Shape { index, at, error })
}

fn read_vertices(cursor: &mut Cursor<'_>, index: usize) -> Result<Vec<DVec3>, ReadError> {
    let count = cursor.u32(field("shape", index))?;
    cursor.room(field("vertices", index), u64::from(count), 3 * 8)?;
    let vertex = |_| cursor.f64s(field("vertices", index)).map(DVec3::from_array);
    (0..count).map(vertex).collect()
}

fn read_object(cursor: &mut Cursor<'_>, index: usize, shapes: usize) -> Result<Placed, ReadError> {
    let what = "object";
    let mut words = [0; 3];
    for word in &mut words {
        *word = cursor.u32(field(what, index))?;
    }
    let [shape, groups, mask] = words;
    if shape as usize >= shapes {
        let target = i64::from(shape);
        return Err(ReadError::OutOfBounds { what, index, target, count: shapes });
    }
    Ok(Placed { shape, filter: Filter { groups, mask } })
}

/// A frame's number, by which a file that lost bytes is known, and its poses.
fn read_frame(
    cursor: &mut Cursor<'_>,
    frame: u32,
    objects: usize,
    poses: &mut Vec<Pose>,
) -> Result<(), ReadError> {
    let (at, frame_index) = (cursor.at(), frame as usize);
    let found = cursor.u32(field("frame", frame_index))?;
    if found != frame {
        return Err(ReadError::Misplaced { what: "frame", index: frame_index, at, found });
    }
    for object in 0..objects {
        let at = cursor.at();
        let rotation = DMat3::from_cols_array(&cursor.f64s(field("frame", frame_index))?);
        let translation = DVec3::from_array(cursor.f64s(field("frame", frame_index))?);
        let pose = Pose::from_matrix(rotation, translation);
        poses.push(pose.map_err(|error| ReadError::Pose {
            frame: frame_index,
            object,
            at,
            error,
        })?);
    }
    Ok(())
}
