//! A capture from bytes, every one of them checked.

use super::{Capture, POSE_BYTES, SIGNATURE, VERSION, place_frame, shape, slot};
use crate::ReadError;
use crate::bytes::{Cursor, Field};
use dcd_geom::{Filter, Motion, Object, Pose, Scene, SceneError, Shape};
use glam::{DMat3, DVec3};
use std::path::Path;

/// The least that a shape and an object take: checked before memory is reserved for their number.
const LEAST_SHAPE_BYTES: u64 = 4 + 8;
const OBJECT_BYTES: u64 = 4 * 4;

impl Capture {
    /// Reads a file that [`Capture::write`] wrote.
    ///
    /// # Errors
    /// No capture, one of another version, one that is cut short or goes on behind its last frame,
    /// a shape of an unknown kind, an object or pair of what does not exist, a number that is not
    /// finite, a matrix that is no rotation, an object out of range: each with its place and value.
    pub fn read(bytes: &[u8]) -> Result<Self, ReadError> {
        let mut cursor = Cursor::new(bytes, 0);
        let [shapes, objects, frames] = read_header(&mut cursor)?;
        cursor.check_count(field("shapes", 0), u64::from(shapes), LEAST_SHAPE_BYTES)?;
        let shapes: Vec<Shape> = (0..shapes as usize)
            .map(|index| shape::read(&mut cursor, index))
            .collect::<Result<_, _>>()?;
        cursor.check_count(field("objects", 0), u64::from(objects), OBJECT_BYTES)?;
        let placed: Vec<Placed> = (0..objects as usize)
            .map(|index| read_object(&mut cursor, index, shapes.len()))
            .collect::<Result<_, _>>()?;
        let ignored = read_ignored(&mut cursor)?;
        let frame_bytes = 4 + u64::from(objects) * POSE_BYTES as u64;
        cursor.check_count(field("frames", 0), u64::from(frames), frame_bytes)?;
        // The file holds so many, so that they can be counted in memory.
        let mut poses = Vec::with_capacity(frames as usize * placed.len());
        for frame in 0..frames {
            read_frame(&mut cursor, frame, placed.len(), &mut poses)?;
        }
        cursor.end()?;
        let scene = build(shapes, &placed, &poses)
            .and_then(|scene| ignore(scene, &ignored))
            .map_err(|error| ReadError::Scene { frame: 0, error })?;
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

    /// Checks that no frame moves an object out of range, so that a replay can set every pose.
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
    held: u32,
}

/// The scene of the first frame.
fn build(shapes: Vec<Shape>, placed: &[Placed], poses: &[Pose]) -> Result<Scene, SceneError> {
    let objects = placed.iter().enumerate().map(|(slot, &Placed { shape, filter, held })| {
        // Without a frame there is no pose.
        let pose = poses.get(slot).copied().unwrap_or(Pose::IDENTITY);
        let is_static = held & !slot::SENSOR == slot::STATIC;
        let motion = if is_static { Motion::Static } else { Motion::Moving };
        let sensor = held & slot::SENSOR != 0;
        Object { filter, motion, sensor, ..Object::new(shape, pose) }
    });
    let mut scene = Scene::new(shapes, objects)?;
    for (slot, _) in placed.iter().enumerate().filter(|(_, placed)| placed.held == slot::FREE) {
        if let Some(handle) = scene.handle(slot) {
            scene.remove(handle)?;
        }
    }
    Ok(scene)
}

fn ignore(mut scene: Scene, pairs: &[[u32; 2]]) -> Result<Scene, SceneError> {
    pairs.iter().try_for_each(|&[i, j]| scene.ignore_pair(i as usize, j as usize))?;
    Ok(scene)
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

fn read_object(cursor: &mut Cursor<'_>, index: usize, shapes: usize) -> Result<Placed, ReadError> {
    let what = "object";
    let at = cursor.at();
    let mut words = [0; 4];
    for word in &mut words {
        *word = cursor.u32(field(what, index))?;
    }
    let [shape, groups, mask, held] = words;
    if shape as usize >= shapes {
        let target = i64::from(shape);
        return Err(ReadError::OutOfBounds { what, index, target, count: shapes });
    }
    if ![slot::MOVING, slot::STATIC].contains(&(held & !slot::SENSOR)) && held != slot::FREE {
        return Err(ReadError::UnknownKind { what, index, at, tag: held });
    }
    Ok(Placed { shape, filter: Filter { groups, mask }, held })
}

fn read_ignored(cursor: &mut Cursor<'_>) -> Result<Vec<[u32; 2]>, ReadError> {
    let count = cursor.u32(field("ignored pairs", 0))?;
    cursor.check_count(field("ignored pairs", 0), u64::from(count), 2 * 4)?;
    let pair = |index: u32| {
        let field = field("ignored pairs", index as usize);
        Ok([cursor.u32(field)?, cursor.u32(field)?])
    };
    (0..count).map(pair).collect()
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
