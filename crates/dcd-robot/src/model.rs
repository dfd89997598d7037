//! A robot: links that carry shapes, and the joints between them.

use super::kinematics::JointFrame;
use super::names::Names;
use super::shapes::{MadeShape, Shapes};
use super::urdf::{Described, DescribedJoint, Kind};
use super::{MeshSource, RobotError, several, tree, urdf, xml};
use dcd_geom::Shape;
use glam::{DAffine3, DVec3};
use std::ops::Range;
use std::path::Path;

/// Links, joints, and the shapes that the links carry.
///
/// ```
/// use dcd_robot::{Robot};
/// use std::path::Path;
/// let guide = Path::new("../../docs/guide/arm"); // the guide's arm and its shelf
/// let robot = Robot::load(&guide.join("arm_description/urdf/arm.urdf"))?;
/// assert_eq!(robot.variables(), ["waist", "shoulder", "elbow", "wrist", "grip"]);
/// let mut poses = Vec::new();
/// robot.place(&[0.0, 0.5, 0.5, 0.0, 0.02], &mut poses)?; // radians and metres
/// assert_eq!(poses.len(), robot.parts().len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Robot {
    /// Its name.
    pub name: String,
    pub(super) links: Vec<Link>,
    /// Each behind the one that moves its parent link.
    pub(super) joints: Vec<Joint>,
    pub(super) parts: Vec<Part>,
    /// For each value of a state its name.
    pub(super) moved: Vec<String>,
    /// The file's joints that have values.
    pub(super) moved_joints: Vec<MovedJoint>,
    /// The link that has no parent.
    pub(super) root: usize,
    /// Its frame in the world.
    pub(super) base: JointFrame,
    /// What the file contains and this robot does not use.
    pub(super) notes: Vec<String>,
}

/// A joint of a URDF that a state has values for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MovedJoint {
    /// Its name.
    pub name: String,
    /// Which values of a state are its own: one; x, y (metres) and an angle (rad) of a planar joint; x, y, z
    /// (metres) and a unit quaternion x, y, z, w of a floating one.
    pub values: Range<usize>,
}

/// A rigid body of a robot.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name, which no other link has.
    pub name: String,
}

/// A shape on a link: convex, unless the robot was read with meshes.
#[derive(Clone, Debug)]
pub struct Part {
    /// The link's index.
    pub link: usize,
    /// The shape, in a frame of its own.
    pub shape: Shape,
    /// The name of the object that it is of, if the link carries it and does not consist of it.
    pub object: Option<String>,
    /// By how much at most the shape stands out of the hull of a mesh, metres, proved: 0 but for
    /// [`LinkShapes::OuterHulls`].
    pub tolerance: f64,
    /// That frame in the link's.
    pub(super) origin: JointFrame,
}

/// What joins a link to its parent.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Its name, which no other joint has.
    pub name: String,
    /// The parent link's index.
    pub parent: usize,
    /// The child link's index; no other joint has that child.
    pub child: usize,
    /// How it moves.
    pub motion: Motion,
    /// Its least and its largest value, rad or metres; none where it has no limits.
    pub limits: Option<[f64; 2]>,
    pub(super) origin: JointFrame,
}

/// How a joint moves: by a value of the state, times a factor, plus an offset (which are 1 and 0
/// but for joints that mimic others).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Motion {
    /// Not at all.
    Fixed,
    /// Turns about an axis of unit length, rad.
    Turns {
        /// The axis, in the joint's frame.
        axis: DVec3,
        /// By what.
        by: Drive,
    },
    /// Slides along an axis of unit length, metres.
    Slides {
        /// The axis, in the joint's frame.
        axis: DVec3,
        /// By what.
        by: Drive,
    },
    /// Turns by a unit quaternion.
    Orients {
        /// Where its x, y, z and w begin in a state.
        first: usize,
    },
}

/// Which value of a state moves a joint, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// The value's index in a state.
    pub value: usize,
    /// What it is multiplied by.
    pub factor: f64,
    /// What is added.
    pub offset: f64,
}

impl Part {
    /// Its shape's frame in its link's, metres.
    pub fn origin(&self) -> DAffine3 {
        self.origin.affine()
    }
}

impl Motion {
    /// The value that moves it; none where nothing does, or a quaternion.
    pub fn drive(&self) -> Option<Drive> {
        match *self {
            Self::Fixed | Self::Orients { .. } => None,
            Self::Turns { by, .. } | Self::Slides { by, .. } => Some(by),
        }
    }
}

impl Drive {
    /// The joint's value in a state; none where the state is too short.
    pub fn of(&self, state: &[f64]) -> Option<f64> {
        state.get(self.value).map(|value| value * self.factor + self.offset)
    }
}

/// What the meshes of a URDF's collision geometry are taken as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LinkShapes {
    /// The hull of the vertices of each: solid and convex.
    #[default]
    Hulls,
    /// A hull of few vertices that contains the hull of each, exactly: what is free of it is free of the mesh.
    /// [`Part::tolerance`] says how much larger it may be.
    OuterHulls {
        /// At most so many vertices, at least [`Budget::FEWEST`](dcd_gjk::simplify::Budget::FEWEST). Fewer:
        /// faster, and larger.
        vertices: usize,
    },
    /// The triangles of each: a surface, without an inside.
    Meshes,
}

impl Robot {
    /// Reads a URDF file and the meshes (STL, COLLADA, OBJ, glTF, PLY) that its collision geometry names:
    /// each mesh becomes the hull of its vertices. What is drawn alone (visual geometry) is not looked at.
    ///
    /// Meshes are looked for as [`dcd_io::MeshPaths`] says, without packages or roots. Each mesh file
    /// is read once for a scale.
    ///
    /// # Errors
    /// A file that cannot be read; links and joints that are not one tree; xacro; elements and
    /// attributes that are not understood; what is not supported (a planar joint whose axis is not z, what
    /// a mesh reader refuses); a number that is not finite; no collision geometry at all; more than the
    /// [`bounds`](super::bounds).
    pub fn load(urdf: &Path) -> Result<Self, RobotError> {
        Self::load_as(urdf, LinkShapes::Hulls)
    }

    /// [`Robot::load`] with meshes taken as hulls or as they are.
    ///
    /// # Errors
    /// Those of [`Robot::load`]; with [`LinkShapes::Meshes`] a mesh without a triangle.
    pub fn load_as(path: &Path, shapes: LinkShapes) -> Result<Self, RobotError> {
        let folder = path.parent().unwrap_or(Path::new("."));
        Self::load_with(path, &MeshSource::beside(folder, shapes))
    }

    /// [`Robot::load`] with meshes from where and as they are said to be.
    ///
    /// # Errors
    /// Those of [`Robot::load_as`]; a link of [`MeshSource::of_links`] that the robot does not have; fewer vertices
    /// than a hull may have.
    pub fn load_with(path: &Path, meshes: &MeshSource) -> Result<Self, RobotError> {
        let text = xml::text_of(path)?;
        let read = urdf::read(&text).and_then(|read| Self::of(read, Shapes::new(meshes)));
        read.map_err(|error| error.inside(path))
    }

    /// [`Robot::load_as`] of a text, whose meshes are looked for from a folder on.
    ///
    /// # Errors
    /// Those of [`Robot::load_as`].
    pub fn read(urdf: &str, folder: &Path, shapes: LinkShapes) -> Result<Self, RobotError> {
        Self::of(urdf::read(urdf)?, Shapes::new(&MeshSource::beside(folder, shapes)))
    }

    fn of(read: Described, mut shapes: Shapes<'_>) -> Result<Self, RobotError> {
        let read = several::expanded(read);
        let links = Names::of("link", read.links.iter().map(|link| (&*link.name, link.line)))?;
        for link in shapes.source.of_links.keys() {
            links.index(link, "what links' meshes are taken as")?;
        }
        let joint_names = read.joints.iter().map(|joint| (&*joint.name, joint.line));
        let drives = tree::drives(&read.joints, &Names::of("joint", joint_names)?)?;
        let joints = read.joints.iter().zip(&drives.by).map(|(joint, &by)| {
            Joint::of(joint, by, &links).map_err(|error| error.at_line(joint.line))
        });
        let tree = tree::in_order(joints.collect::<Result<_, _>>()?, &read.links)?;
        let mut parts = Vec::new();
        for (link, described) in read.links.iter().enumerate() {
            let user = format!("link {:?}", described.name);
            let meshes = shapes.source.shapes_of(&described.name);
            for collision in &described.collisions {
                let shape = shapes.shape(&collision.geometry, (&user, meshes));
                let MadeShape { shape, tolerance } =
                    shape.map_err(|error| error.at_line(collision.line))?;
                let origin = collision.origin;
                parts.push(Part { link, shape, object: None, tolerance, origin });
            }
        }
        if parts.is_empty() {
            return Err(RobotError::NoShapes { robot: read.name });
        }
        let mut notes = read.notes;
        notes.extend(shapes.notes());
        Ok(Self {
            name: read.name,
            links: read.links.into_iter().map(|link| Link { name: link.name }).collect(),
            joints: tree.joints,
            parts,
            moved: drives.moved,
            moved_joints: read.moved_joints,
            root: tree.root,
            base: JointFrame::IDENTITY,
            notes,
        })
    }

    /// The name of the link or of the carried object that a part is of.
    pub(super) fn name_of<'a>(&'a self, part: &'a Part) -> &'a str {
        part.object.as_ref().unwrap_or(&self.links[part.link].name)
    }

    /// What the file says that makes no difference to what touches: how the robot looks, what it
    /// weighs; and what a user should know of how its mesh files were read, with the file's path. A
    /// sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The links, in the file's order.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The joints, each behind the one that moves its parent link.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The shapes, in the order of their links.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The URDF's joints that a state has values for, in its order: all that move and mimic no other.
    pub fn moved_joints(&self) -> &[MovedJoint] {
        &self.moved_joints
    }

    /// The names of a state's values, in its order: of a joint with one value its own, of others with what the
    /// value is, as MoveIt has them (`base/x`, `base/y`, `base/theta`; `base/trans_x` … `base/rot_w`).
    pub fn variables(&self) -> &[String] {
        &self.moved
    }
}

impl Joint {
    /// Its frame at rest in its parent link's, metres; at its value the child link's frame.
    pub fn origin(&self) -> DAffine3 {
        self.origin.affine()
    }

    fn of(
        joint: &DescribedJoint,
        by: Option<Drive>,
        links: &Names<'_>,
    ) -> Result<Self, RobotError> {
        let user = format!("joint {:?}", joint.name);
        let motion = match (joint.kind, by) {
            (Kind::Turns, Some(by)) => Motion::Turns { axis: joint.axis, by },
            (Kind::Slides, Some(by)) => Motion::Slides { axis: joint.axis, by },
            (Kind::Orients, Some(by)) => Motion::Orients { first: by.value },
            _ => Motion::Fixed,
        };
        Ok(Self {
            name: joint.name.clone(),
            parent: links.index(&joint.parent, &user)?,
            child: links.index(&joint.child, &user)?,
            motion,
            limits: joint.limits,
            origin: joint.origin,
        })
    }
}
