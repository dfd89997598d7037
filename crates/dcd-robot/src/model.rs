//! A robot: links that carry shapes, and the joints between them.

use super::RobotError;
use super::kinematics::{Frame, in_order};
use super::mesh;
use dcd_geom::{ConvexHull, Shape};
use glam::DVec3;
use std::collections::HashMap;
use std::path::Path;
use urdf_rs::{Geometry, JointType};

/// Links, joints, and the shapes that the links carry.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Its name.
    pub name: String,
    pub(super) links: Vec<Link>,
    /// Each behind the one that moves its parent link.
    pub(super) joints: Vec<Joint>,
    pub(super) parts: Vec<Part>,
    /// For each value of a state the joint that it moves.
    pub(super) moved: Vec<String>,
}

/// A rigid body of a robot.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name, which no other link has.
    pub name: String,
}

/// A shape on a link: convex, unless meshes were asked for.
#[derive(Clone, Debug)]
pub struct Part {
    /// The link's index.
    pub link: usize,
    /// The shape, in a frame of its own.
    pub shape: Shape,
    /// That frame in the link's.
    pub(super) origin: Frame,
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
    pub(super) origin: Frame,
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

/// What the meshes of a URDF's collision geometry are taken as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinkShapes {
    /// The hull of the vertices of each: solid and convex.
    #[default]
    Hulls,
    /// The triangles of each: a surface, without an inside.
    Meshes,
}

impl Robot {
    /// Reads a URDF file and the OBJ meshes that its collision geometry names: each mesh becomes
    /// the hull of its vertices. What is drawn alone (visual geometry) is not looked at.
    ///
    /// A mesh `package://A/B` is `A/B` or `B`, any other name itself, from the file's folder or one
    /// above it.
    ///
    /// # Errors
    /// A file that cannot be read; links and joints that make no tree; what is not supported
    /// (floating and planar joints, meshes that are no OBJ); a number that is not finite.
    pub fn load(urdf: &Path) -> Result<Self, RobotError> {
        Self::load_as(urdf, LinkShapes::Hulls)
    }

    /// [`Robot::load`] with meshes taken as hulls or as they are.
    ///
    /// # Errors
    /// Those of [`Robot::load`]; with [`LinkShapes::Meshes`] a mesh without a triangle.
    pub fn load_as(urdf: &Path, shapes: LinkShapes) -> Result<Self, RobotError> {
        let text = std::fs::read_to_string(urdf).map_err(RobotError::io(urdf))?;
        let refused = |error: &dyn std::fmt::Display| RobotError::Syntax {
            what: "URDF",
            place: urdf.to_path_buf(),
            error: error.to_string(),
        };
        let own = without_extensions(&text).map_err(|error| refused(&error))?;
        let read = urdf_rs::read_from_string(&own).map_err(|error| refused(&error))?;
        let folder = urdf.parent().unwrap_or(Path::new("."));
        Self::of(read, folder, shapes).map_err(|error| error.inside(urdf))
    }

    fn of(read: urdf_rs::Robot, folder: &Path, shapes: LinkShapes) -> Result<Self, RobotError> {
        let links = Names::of("link", read.links.iter().map(|link| &link.name))?;
        let joint_names = Names::of("joint", read.joints.iter().map(|joint| &joint.name))?;
        let moved = moved_joints(&read.joints);
        let joints = read.joints.iter().map(|joint| Joint::of(joint, &links, &moved));
        let joints = in_order(joints.collect::<Result<_, _>>()?, &read.links)?;
        debug_assert_eq!(joint_names.0.len(), joints.len());
        let mut parts = Vec::new();
        for (link, described) in read.links.iter().enumerate() {
            for collision in &described.collision {
                let user = format!("link {:?}", described.name);
                let (geometry, place) = (&collision.geometry, (folder, user.as_str()));
                let shape = shape(geometry, shapes, place)?;
                let origin = Frame::of_urdf(&collision.origin, &user)?;
                parts.push(Part { link, shape, origin });
            }
        }
        let links = read.links.into_iter().map(|link| Link { name: link.name }).collect();
        Ok(Self { name: read.name, links, joints, parts, moved })
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

    /// The joints that a state has a value for, in its order: all that move and mimic no other.
    pub fn moved_joints(&self) -> &[String] {
        &self.moved
    }
}

/// The text without the elements of other namespaces, which are no part of URDF and which its reader
/// does not expect.
fn without_extensions(text: &str) -> Result<String, roxmltree::Error> {
    let document = roxmltree::Document::parse(text)?;
    let foreign = document.descendants().filter(|node| node.tag_name().namespace().is_some());
    let (mut own, mut at) = (String::with_capacity(text.len()), 0);
    for range in foreign.map(|node| node.range()) {
        // What is inside another one is gone already.
        if range.start >= at {
            own.push_str(&text[at..range.start]);
            at = range.end;
        }
    }
    own.push_str(&text[at..]);
    Ok(own)
}

/// Names and their indices.
pub(super) struct Names<'a>(pub(super) HashMap<&'a str, usize>);

impl<'a> Names<'a> {
    fn of(what: &'static str, all: impl Iterator<Item = &'a String>) -> Result<Self, RobotError> {
        let mut names = HashMap::new();
        for (index, name) in all.enumerate() {
            if names.insert(name.as_str(), index).is_some() {
                return Err(RobotError::Twice { what, name: name.clone() });
            }
        }
        Ok(Self(names))
    }

    fn link(&self, name: &str, user: &str) -> Result<usize, RobotError> {
        self.0.get(name).copied().ok_or_else(|| RobotError::Unknown {
            what: "link",
            name: name.to_owned(),
            user: user.to_owned(),
        })
    }
}

/// The joints with a value of their own, in the file's order.
fn moved_joints(joints: &[urdf_rs::Joint]) -> Vec<String> {
    let moves = |joint: &&urdf_rs::Joint| {
        joint.mimic.is_none() && !matches!(joint.joint_type, JointType::Fixed)
    };
    joints.iter().filter(moves).map(|joint| joint.name.clone()).collect()
}

impl Joint {
    fn of(joint: &urdf_rs::Joint, links: &Names<'_>, moved: &[String]) -> Result<Self, RobotError> {
        let user = format!("joint {:?}", joint.name);
        let drive = || Drive::of(joint, moved);
        let motion = match joint.joint_type {
            JointType::Fixed => Motion::Fixed,
            JointType::Revolute | JointType::Continuous => {
                Motion::Turns { axis: axis(joint, &user)?, by: drive()? }
            }
            JointType::Prismatic => Motion::Slides { axis: axis(joint, &user)?, by: drive()? },
            ref other => {
                let kind = format!("{other:?}").to_lowercase();
                return Err(RobotError::Unsupported { what: "joint type", kind, user });
            }
        };
        Ok(Self {
            name: joint.name.clone(),
            parent: links.link(&joint.parent.link, &user)?,
            child: links.link(&joint.child.link, &user)?,
            motion,
            origin: Frame::of_urdf(&joint.origin, &user)?,
        })
    }
}

impl Drive {
    /// A joint that mimics another moves by that one's value, which must not mimic a third.
    fn of(joint: &urdf_rs::Joint, moved: &[String]) -> Result<Self, RobotError> {
        let leader = joint.mimic.as_ref().map_or(&joint.name, |mimic| &mimic.joint);
        let value = moved.iter().position(|name| name == leader);
        let value = value.ok_or_else(|| RobotError::Unknown {
            what: "moved joint",
            name: leader.clone(),
            user: format!("joint {:?}", joint.name),
        })?;
        let mimic = joint.mimic.as_ref();
        let factor = mimic.and_then(|mimic| mimic.multiplier).unwrap_or(1.0);
        let offset = mimic.and_then(|mimic| mimic.offset).unwrap_or(0.0);
        Ok(Self { value, factor, offset })
    }
}

/// A joint's axis, of unit length.
fn axis(joint: &urdf_rs::Joint, user: &str) -> Result<DVec3, RobotError> {
    let given = DVec3::from_array(*joint.axis.xyz);
    given.try_normalize().ok_or_else(|| RobotError::BadNumber {
        what: "length of the axis",
        user: user.to_owned(),
        value: given.length(),
    })
}

/// The corners of the points' hull, flat ones' too; all points where exact signs are out of reach, or
/// where the shape will refuse them.
fn corners(points: Vec<DVec3>) -> Vec<DVec3> {
    match ConvexHull::of(&points) {
        Ok(hull) => hull.corners().iter().map(|&k| points[k as usize]).collect(),
        Err(_) => points,
    }
}

/// The shape of a geometry that a `user` in a file of `folder` has.
fn shape(
    geometry: &Geometry,
    shapes: LinkShapes,
    (folder, user): (&Path, &str),
) -> Result<Shape, RobotError> {
    let shape = match geometry {
        Geometry::Box { size } => Shape::cuboid(DVec3::from_array(**size) * 0.5),
        Geometry::Sphere { radius } => Shape::sphere(*radius),
        Geometry::Cylinder { radius, length } => super::world::cylinder(*length, *radius),
        Geometry::Mesh { filename, scale } => {
            let mut read = mesh::load(filename, folder)?;
            if let Some(scale) = scale {
                let scale = DVec3::from_array(**scale);
                read.vertices.iter_mut().for_each(|point| *point *= scale);
            }
            match shapes {
                LinkShapes::Hulls => Shape::hull(corners(read.vertices)),
                LinkShapes::Meshes => read.into_shape(),
            }
        }
        Geometry::Capsule { radius, length } => super::world::capsule(*length, *radius),
    };
    shape.map_err(|error| RobotError::Shape { user: user.to_owned(), error })
}
