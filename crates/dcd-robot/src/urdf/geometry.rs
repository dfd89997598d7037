//! What stands inside `collision`.

use super::{once, unknown};
use crate::RobotError;
use crate::kinematics::JointFrame;
use crate::xml::Walk;
use glam::{DQuat, DVec3};
use roxmltree::Node;

/// A shape of a link, and where it is.
pub(crate) struct Collision {
    pub(crate) line: usize,
    pub(crate) origin: JointFrame,
    pub(crate) geometry: Geometry,
}

/// Metres.
pub(crate) enum Geometry {
    Box { size: DVec3 },
    Sphere { radius: f64 },
    Cylinder { radius: f64, length: f64 },
    Capsule { radius: f64, length: f64 },
    Mesh { file: String, scale: DVec3 },
}

const OF_A_COLLISION: [&str; 6] =
    ["material", "verbose", "contact_coefficients", "surface", "max_contacts", "bounce"];

pub(super) fn collision(
    walk: &mut Walk,
    node: Node<'_, '_>,
    user: &str,
) -> Result<Collision, RobotError> {
    walk.only(node, &["name", "group", "concave"], user)?;
    let (mut at, mut shape) = (None, None);
    for child in walk.children(node)? {
        match child.tag_name().name() {
            "origin" => once(walk, &mut at, child, user)?,
            "geometry" => once(walk, &mut shape, child, user)?,
            other if OF_A_COLLISION.contains(&other) => walk.pass_over(child),
            other => return Err(unknown(walk, child, other, user)),
        }
    }
    let Some(shape) = shape else {
        return Err(walk.refused(node, user, "a collision has no geometry"));
    };
    Ok(Collision {
        line: walk.line(node),
        origin: origin(walk, at, user)?,
        geometry: geometry(walk, shape, user)?,
    })
}

/// The frame of an `origin`, which may be absent. A quaternion (x y z w, URDF 1.1) may stand in
/// place of the angles.
pub(super) fn origin(
    walk: &mut Walk,
    node: Option<Node<'_, '_>>,
    user: &str,
) -> Result<JointFrame, RobotError> {
    let Some(node) = node else { return Ok(JointFrame::IDENTITY) };
    walk.only_attributes(node, &["xyz", "rpy", "quat_xyzw"], user)?;
    let xyz = DVec3::from_array(walk.numbers(node, "xyz", user)?.unwrap_or_default());
    let rpy = walk.numbers(node, "rpy", user)?;
    let Some(quaternion) = walk.numbers(node, "quat_xyzw", user)? else {
        return Ok(JointFrame::of_angles(xyz, rpy.unwrap_or_default()));
    };
    if rpy.is_some() {
        return Err(walk.refused(node, user, "origin has both rpy and quat_xyzw"));
    }
    let pose = dcd_geom::Pose::new(DQuat::from_array(quaternion), xyz);
    let pose = pose.map_err(|error| RobotError::Pose { user: user.to_owned(), error });
    Ok(JointFrame::of_pose(&pose.map_err(|error| walk.at(node, error))?))
}

fn geometry(walk: &mut Walk, node: Node<'_, '_>, user: &str) -> Result<Geometry, RobotError> {
    walk.only(node, &["name"], user)?;
    let shapes = walk.children(node)?;
    let &[shape] = &shapes[..] else {
        let why = format!("a geometry has {} shapes, not 1", shapes.len());
        return Err(walk.refused(node, user, why));
    };
    let length = |walk: &Walk, name: &str| {
        walk.required(shape, name, user)?;
        // It is there.
        Ok::<f64, RobotError>(walk.number(shape, name, user)?.unwrap_or_default())
    };
    let mut known = |names: &[&str]| walk.only_attributes(shape, names, user);
    match shape.tag_name().name() {
        "box" => {
            known(&["size"])?;
            walk.required(shape, "size", user)?;
            let size = walk.numbers(shape, "size", user)?.unwrap_or_default();
            Ok(Geometry::Box { size: DVec3::from_array(size) })
        }
        "sphere" => {
            known(&["radius"])?;
            Ok(Geometry::Sphere { radius: length(walk, "radius")? })
        }
        "cylinder" => {
            known(&["radius", "length"])?;
            Ok(Geometry::Cylinder {
                radius: length(walk, "radius")?,
                length: length(walk, "length")?,
            })
        }
        "capsule" => {
            known(&["radius", "length"])?;
            Ok(Geometry::Capsule {
                radius: length(walk, "radius")?,
                length: length(walk, "length")?,
            })
        }
        "mesh" => {
            known(&["filename", "scale"])?;
            let file = walk.required(shape, "filename", user)?.to_owned();
            let scale = walk.numbers(shape, "scale", user)?.unwrap_or([1.0; 3]);
            Ok(Geometry::Mesh { file, scale: DVec3::from_array(scale) })
        }
        other => {
            let (what, kind) = ("shape", other.to_owned());
            let error = RobotError::Unsupported { what, kind, user: user.to_owned() };
            Err(walk.at(shape, error))
        }
    }
}
