//! Recorded frames: a scene and where its objects were, frame by frame.

mod read;
mod shape;
mod write;

pub use shape::{read_shape, write_shape};

use dcd_geom::{Pose, Scene, SceneError};
use std::fmt;

/// What a file begins with.
const SIGNATURE: [u8; 8] = *b"DCDCAPT\0";
/// The version that is written and read.
const VERSION: u32 = 1;
/// Bytes of one pose: R column by column, then t, in f64.
const POSE_BYTES: usize = 12 * 8;

/// What a slot holds.
mod slot {
    pub(super) const MOVING: u32 = 0;
    pub(super) const STATIC: u32 = 1;
    pub(super) const FREE: u32 = 2;
    /// Added to one of the first two: a sensor.
    pub(super) const SENSOR: u32 = 4;
}

/// A scene and the poses of its objects in each frame, bit for bit: what a replay answers is what
/// the recorded run answered.
///
/// Everything but the poses is that of [`Capture::new`] for all frames: shapes, which slot holds
/// an object, filters, which are sensors, ignored pairs. The bytes of a file are described in `docs/captures.md`.
///
/// ```
/// use dcd_geom::{Pose, Scene, Shape};
/// use dcd_io::Capture;
/// let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 2], vec![Pose::IDENTITY; 2])?;
/// let mut capture = Capture::new(&scene)?;
/// capture.frame(&scene)?; // once a step, as the scene stands
/// let mut file = Vec::new();
/// capture.write(&mut file)?;
/// let replay = Capture::read(&file)?;
/// assert_eq!(replay.frames().count(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Capture {
    scene: Scene,
    /// Frame by frame, in each as many as there are objects.
    poses: Vec<Pose>,
    count: usize,
}

impl Capture {
    /// A capture of this scene, without frames. Copies the poses and shares the shapes.
    ///
    /// # Errors
    /// A shape that the format has no words for: a foreign one.
    pub fn new(scene: &Scene) -> Result<Self, CaptureError> {
        match scene.shapes().iter().position(|shape| shape::kind_of(shape).is_none()) {
            Some(shape) => Err(CaptureError::Shape { shape }),
            None => Ok(Self { scene: scene.clone(), poses: Vec::new(), count: 0 }),
        }
    }

    /// Adds a frame: the poses of the scene as it stands.
    ///
    /// # Errors
    /// The scene is not the one that the capture was made of, or a copy: objects have come, gone,
    /// or changed whom they may touch.
    pub fn frame(&mut self, scene: &Scene) -> Result<(), CaptureError> {
        let recorded = &self.scene;
        let what = if scene.layout() != recorded.layout() {
            "objects"
        } else if scene.filters() != recorded.filters() {
            "filters"
        } else if scene.sensors() != recorded.sensors() {
            "sensors"
        } else if !scene.ignored_pairs().eq(recorded.ignored_pairs()) {
            "ignored pairs"
        } else {
            self.poses.extend_from_slice(scene.poses());
            self.count += 1;
            return Ok(());
        };
        Err(CaptureError::Changed { what, frame: self.count })
    }

    /// The scene as it stood when recording began; of a file, as in its first frame.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// How many frames there are.
    pub fn frame_count(&self) -> usize {
        self.count
    }

    /// The poses of each frame, one for each object.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = &[Pose]> {
        let objects = self.scene.len();
        (0..self.count).map(move |frame| &self.poses[frame * objects..][..objects])
    }
}

/// Moves the objects of a scene to these poses, one for each slot; those of free slots say nothing.
///
/// # Errors
/// Another number of poses than of slots, or a pose out of range; the objects before it have
/// moved then.
pub fn place_frame(scene: &mut Scene, poses: &[Pose]) -> Result<(), SceneError> {
    if poses.len() != scene.len() {
        return Err(SceneError::LengthsDiffer { shapes: scene.len(), poses: poses.len() });
    }
    for (slot, &pose) in poses.iter().enumerate() {
        // What stands still is left alone, so that nothing is made anew for it.
        if scene.motion(slot).is_some() && scene.poses()[slot] != pose {
            scene.set_pose(slot, pose)?;
        }
    }
    Ok(())
}

/// Why a scene cannot be recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CaptureError {
    /// A shape is of a kind that the format has no words for: known by its support map alone.
    Shape {
        /// Its index.
        shape: usize,
    },
    /// More than poses has changed since the capture was begun.
    Changed {
        /// What: "objects", "filters", "sensors", "ignored pairs".
        what: &'static str,
        /// The frame that was to be added.
        frame: usize,
    },
}

impl fmt::Display for CaptureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape { shape } => {
                write!(f, "shape {shape} is of a kind that captures have no words for")
            }
            Self::Changed { what, frame } => {
                write!(f, "frame {frame}: the scene's {what} have changed since the first")
            }
        }
    }
}

impl std::error::Error for CaptureError {}

#[cfg(test)]
mod tests;
