//! What a scene is made from, before anything is checked.

use crate::run::{self, Run};
use dcd_geom::{Object, Pose, PoseError, Scene, SceneError, Shape, ShapeError};
use glam::{DQuat, DVec3};
use std::fmt;

/// A shape as it was drawn or read, metres, in its own frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RawShape {
    /// The hull of points.
    Hull {
        /// The points; some may lie inside.
        points: Vec<DVec3>,
        /// The hull's surface, outward, by index into `points`; empty where it is not known.
        triangles: Vec<[u32; 3]>,
    },
    /// A cuboid round the origin.
    Cuboid {
        /// Half the edge along x, y and z.
        half_extents: DVec3,
    },
    /// A sphere round the origin.
    Sphere {
        /// Its radius.
        radius: f64,
    },
    /// A sphere swept along the z axis, its middle at the origin.
    Capsule {
        /// Half the way of the sphere's centre.
        half_height: f64,
        /// The sphere's radius.
        radius: f64,
    },
}

impl RawShape {
    /// The hull of a cloud: its vertices and surface where it has a volume, else the cloud itself,
    /// which is the same shape.
    pub fn of_cloud(points: Vec<DVec3>) -> Self {
        if let Ok(hull) = crate::convex_hull(&points) {
            return Self::Hull { points: hull.vertices, triangles: hull.triangles };
        }
        Self::Hull { points, triangles: Vec::new() }
    }

    /// The points whose hull is its core: a cuboid's eight corners, x fastest; a sphere's or a
    /// capsule's centres.
    pub fn points(&self) -> Vec<DVec3> {
        match self {
            Self::Hull { points, .. } => points.clone(),
            Self::Cuboid { half_extents } => (0..8u32)
                .map(|k| {
                    let side = |axis: u32| if k >> axis & 1 == 0 { -1.0 } else { 1.0 };
                    *half_extents * DVec3::new(side(0), side(1), side(2))
                })
                .collect(),
            Self::Sphere { .. } => vec![DVec3::ZERO],
            Self::Capsule { half_height, .. } => {
                vec![DVec3::Z * -*half_height, DVec3::Z * *half_height]
            }
        }
    }

    fn into_shape(self) -> Result<Shape, ShapeError> {
        match self {
            Self::Hull { points, .. } => Shape::hull(points),
            Self::Cuboid { half_extents } => Shape::cuboid(half_extents),
            Self::Sphere { radius } => Shape::sphere(radius),
            Self::Capsule { half_height, radius } => Shape::capsule(half_height, radius),
        }
    }
}

/// A shape somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawObject {
    /// The shape's index.
    pub shape: u32,
    /// A unit quaternion, up to [`Pose::UNIT_TOLERANCE`].
    pub rotation: DQuat,
    /// Metres.
    pub translation: DVec3,
}

/// Shapes and objects, not yet checked: what a seeded scene or a file gives.
///
/// ```
/// use dcd_io::{RawObject, RawScene, RawShape};
/// use glam::{DQuat, DVec3};
/// let object = RawObject { shape: 0, rotation: DQuat::IDENTITY, translation: DVec3::ZERO };
/// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let raw = RawScene { shapes: vec![RawShape::of_cloud(corners)], objects: vec![object] };
/// assert_eq!(raw.into_scene()?.len(), 1); // checked here
/// # Ok::<(), dcd_io::BuildError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawScene {
    /// The shapes.
    pub shapes: Vec<RawShape>,
    /// The objects that place them.
    pub objects: Vec<RawObject>,
}

impl RawScene {
    /// The checked scene, objects and shapes in the same order.
    ///
    /// # Errors
    /// The first pose or shape that is refused, or a scene that is, with index and value.
    pub fn into_scene(self) -> Result<Scene, BuildError> {
        self.into_scene_by(&run::in_order)
    }

    /// [`RawScene::into_scene`], the same by any [`Run`]: a task makes a shape.
    ///
    /// # Errors
    /// Those of [`RawScene::into_scene`].
    pub fn into_scene_by(self, run: &Run<'_>) -> Result<Scene, BuildError> {
        let shapes = run::map(run, self.shapes, |shape, raw: RawShape| {
            raw.into_shape().map_err(|error| BuildError::Shape { shape, error })
        });
        let shapes = shapes.into_iter().collect::<Result<Vec<_>, _>>()?;
        let objects = self.objects.iter().enumerate().map(|(object, raw)| {
            let pose = Pose::new(raw.rotation, raw.translation)
                .map_err(|error| BuildError::Pose { object, error })?;
            Ok(Object::new(raw.shape, pose))
        });
        let objects = objects.collect::<Result<Vec<_>, _>>()?;
        Scene::new(shapes, objects).map_err(BuildError::Scene)
    }

    /// A digest of every number, in order: 64-bit FNV-1a. Two scenes with the same digest are, but
    /// for malice, the same scene. Surfaces do not count, since they change no answer.
    pub fn digest(&self) -> u64 {
        let mut digest = Fnv::new();
        for shape in &self.shapes {
            match shape {
                RawShape::Hull { points, .. } => {
                    digest.number(points.len() as u64);
                    points.iter().for_each(|&point| digest.vector(point));
                }
                RawShape::Cuboid { half_extents } => {
                    digest.number(u64::MAX);
                    digest.vector(*half_extents);
                }
                RawShape::Sphere { radius } => {
                    digest.number(u64::MAX - 1);
                    digest.number(radius.to_bits());
                }
                RawShape::Capsule { half_height, radius } => {
                    digest.number(u64::MAX - 2);
                    digest.number(half_height.to_bits());
                    digest.number(radius.to_bits());
                }
            }
        }
        for object in &self.objects {
            digest.number(u64::from(object.shape));
            object.rotation.to_array().into_iter().for_each(|x| digest.number(x.to_bits()));
            digest.vector(object.translation);
        }
        digest.0
    }
}

/// Some of a scene's objects, one after the other, with the shapes that they have: what one of several
/// processes makes or reads of a whole that none of them holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawShare {
    /// The index of the first object in the whole.
    pub first: usize,
    /// For each shape its index in the whole.
    pub shape_names: Vec<u64>,
    /// The shapes and objects; these name the shapes by their index in here.
    pub scene: RawScene,
}

impl RawShare {
    /// [`RawScene::into_scene_by`] of the share.
    ///
    /// # Errors
    /// Those of [`RawScene::into_scene`], with the indices of the whole.
    pub fn into_scene_by(self, run: &Run<'_>) -> Result<Scene, BuildError> {
        let Self { first, shape_names, scene } = self;
        // One for each shape, and a shape's index is below 2⁶⁴.
        let shape_name = |shape: usize| shape_names.get(shape).map_or(shape, |&name| name as usize);
        scene.into_scene_by(run).map_err(|error| match error {
            BuildError::Pose { object, error } => {
                BuildError::Pose { object: first + object, error }
            }
            BuildError::Shape { shape, error } => {
                BuildError::Shape { shape: shape_name(shape), error }
            }
            BuildError::Scene(SceneError::OutOfRange { object, reach }) => {
                BuildError::Scene(SceneError::OutOfRange { object: first + object, reach })
            }
            error => error,
        })
    }
}

struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn number(&mut self, bits: u64) {
        for byte in bits.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    fn vector(&mut self, v: DVec3) {
        v.to_array().into_iter().for_each(|x| self.number(x.to_bits()));
    }
}

/// Why raw material makes no scene.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// An object's pose.
    Pose {
        /// The object's index.
        object: usize,
        /// What is wrong with it.
        error: PoseError,
    },
    /// A shape; in a file of one shape an object this is the object's index too.
    Shape {
        /// The shape's index.
        shape: usize,
        /// What is wrong with it.
        error: ShapeError,
    },
    /// The scene as a whole.
    Scene(SceneError),
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pose { object, error } => write!(f, "object {object}: {error}"),
            Self::Shape { shape, error } => write!(f, "shape {shape}: {error}"),
            Self::Scene(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for BuildError {}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(rotation: DQuat, point: DVec3) -> RawScene {
        let shape = RawShape::Hull { points: vec![point], triangles: vec![] };
        let object = RawObject { shape: 0, rotation, translation: DVec3::ZERO };
        RawScene { shapes: vec![shape], objects: vec![object] }
    }

    #[test]
    fn a_bad_pose_shape_or_index_is_named() {
        let zero = one(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), DVec3::ONE).into_scene().unwrap_err();
        let unit = PoseError::NotUnit { length_squared: 0.0 };
        assert_eq!(zero, BuildError::Pose { object: 0, error: unit });
        let nan = one(DQuat::IDENTITY, DVec3::INFINITY).into_scene().unwrap_err();
        let error = ShapeError::NotFinite { vertex: 0, value: f64::INFINITY };
        assert_eq!(nan, BuildError::Shape { shape: 0, error });
        let mut lost = one(DQuat::IDENTITY, DVec3::ONE);
        lost.objects[0].shape = 1;
        let error = SceneError::NoSuchShape { object: 0, shape: 1, shapes: 1 };
        assert_eq!(lost.into_scene().unwrap_err(), BuildError::Scene(error));
    }

    #[test]
    fn a_share_names_what_is_refused_as_the_whole_does() {
        let share = |scene| RawShare { first: 10, shape_names: vec![30], scene };
        let refused = |scene| share(scene).into_scene_by(&run::in_order).unwrap_err().to_string();
        let zero = one(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), DVec3::ONE);
        assert!(refused(zero).starts_with("object 10: "));
        assert!(refused(one(DQuat::IDENTITY, DVec3::NAN)).starts_with("shape 30: "));
        let far = refused(one(DQuat::IDENTITY, DVec3::splat(1e300)));
        assert!(far.contains("object 10"), "{far}");
    }

    #[test]
    fn nothing_makes_an_empty_scene() {
        assert!(RawScene::default().into_scene().unwrap().is_empty());
    }

    #[test]
    fn the_digest_sees_a_last_bit_and_the_sign_of_zero() {
        let digest = |point| one(DQuat::IDENTITY, point).digest();
        assert_ne!(digest(DVec3::ONE), digest(DVec3::new(1.0, 1f64.next_up(), 1.0)));
        assert_ne!(digest(DVec3::ZERO), digest(DVec3::new(0.0, -0.0, 0.0)));
    }
}
