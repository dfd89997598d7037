//! Recorded frames: a scene and where its objects were, frame by frame.

mod read;
mod write;

use dcd_geom::{Kind, Pose, Scene, SceneError, Shape};
use std::fmt;

/// What a file begins with.
const SIGNATURE: [u8; 8] = *b"DCDCAPT\0";
/// The version that is written and read.
const VERSION: u32 = 1;
/// Bytes of one pose: R column by column, then t, in f64.
const POSE_BYTES: usize = 12 * 8;

/// What a shape's tag says.
mod tag {
    pub(super) const HULL: u32 = 0;
    pub(super) const CUBOID: u32 = 1;
    pub(super) const SPHERE: u32 = 2;
}

/// A scene and the poses of its objects in each frame, bit for bit: what a replay answers is what
/// the recorded run answered.
///
/// The shapes, the number of objects and their filters are those of [`Capture::new`] for all
/// frames. The bytes of a file are described in `docs/captures.md`.
///
/// ```
/// use dcd_scenes::{Capture, SceneSpec};
/// let scene = SceneSpec::paper().with_objects(20).scene()?;
/// let mut capture = Capture::new(&scene)?;
/// capture.frame(&scene)?; // once a step, as the scene stands
/// let mut file = Vec::new();
/// capture.write(&mut file)?;
/// let replay = Capture::read(&file)?;
/// assert_eq!(replay.frames().next(), Some(scene.poses()));
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
    /// Of this scene, no frame yet. Copies the poses and shares the shapes.
    ///
    /// # Errors
    /// A shape that the format has no words for: a foreign one.
    pub fn new(scene: &Scene) -> Result<Self, CaptureError> {
        match scene.shapes().iter().position(|shape| !is_recordable(shape)) {
            Some(shape) => Err(CaptureError::Shape { shape }),
            None => Ok(Self { scene: scene.clone(), poses: Vec::new(), count: 0 }),
        }
    }

    /// Adds a frame: the poses of the scene as it stands.
    ///
    /// # Errors
    /// The scene has another number of objects than the one that the capture was made of.
    pub fn frame(&mut self, scene: &Scene) -> Result<(), CaptureError> {
        let [recorded, found] = [&self.scene, scene].map(Scene::len);
        if recorded != found {
            return Err(CaptureError::Objects { recorded, found });
        }
        self.poses.extend_from_slice(scene.poses());
        self.count += 1;
        Ok(())
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

fn is_recordable(shape: &Shape) -> bool {
    let kind = shape.as_polytope().map(|polytope| polytope.kind());
    matches!(kind, Some(Kind::Hull | Kind::Point | Kind::Cuboid { .. }))
}

/// Moves the objects of a scene to these poses, one for each.
///
/// # Errors
/// Another number of poses than of objects, or a pose out of range; the objects before it have
/// moved then.
pub fn place_frame(scene: &mut Scene, poses: &[Pose]) -> Result<(), SceneError> {
    if poses.len() != scene.len() {
        return Err(SceneError::LengthsDiffer { shapes: scene.len(), poses: poses.len() });
    }
    poses.iter().enumerate().try_for_each(|(object, &pose)| scene.set_pose(object, pose))
}

/// Why a scene cannot be recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CaptureError {
    /// A shape is known by its support map alone.
    Shape {
        /// Its index.
        shape: usize,
    },
    /// A frame has another number of objects than the frames before.
    Objects {
        /// How many the capture has.
        recorded: usize,
        /// How many the frame has.
        found: usize,
    },
}

impl fmt::Display for CaptureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape { shape } => {
                write!(f, "shape {shape} is of a kind that captures have no words for")
            }
            Self::Objects { recorded, found } => {
                write!(f, "the capture has {recorded} objects, the frame {found}")
            }
        }
    }
}

impl std::error::Error for CaptureError {}

#[cfg(test)]
mod tests;
