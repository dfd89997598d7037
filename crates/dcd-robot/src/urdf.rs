//! The contents of a URDF file: every element and attribute is used, refused, or named as not used.

mod geometry;

pub(super) use geometry::{Collision, Geometry};

use super::kinematics::JointFrame;
use super::xml::{Walk, parse};
use super::{MovedJoint, RobotError};
use glam::DVec3;
use roxmltree::Node;

/// A file's links and joints, by their names, in its order.
pub(super) struct Described {
    pub(super) name: String,
    pub(super) links: Vec<DescribedLink>,
    pub(super) joints: Vec<DescribedJoint>,
    /// Those with values of their own.
    pub(super) moved_joints: Vec<MovedJoint>,
    /// What was not used.
    pub(super) notes: Vec<String>,
}

pub(super) struct DescribedLink {
    pub(super) name: String,
    pub(super) line: usize,
    pub(super) collisions: Vec<Collision>,
}

pub(super) struct DescribedJoint {
    pub(super) name: String,
    pub(super) line: usize,
    pub(super) kind: Kind,
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) origin: JointFrame,
    /// Of unit length; a fixed joint's means nothing.
    pub(super) axis: DVec3,
    pub(super) mimic: Option<Mimic>,
    pub(super) limits: Option<[f64; 2]>,
}

/// The kinds of joints that are understood.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Fixed,
    Turns,
    Slides,
    /// By a quaternion; no file has it alone.
    Orients,
    /// Slides along x and y and turns about z.
    Planar,
    /// Slides along all three and orients.
    Floating,
}

impl Kind {
    /// Whether a joint of this kind has more than one value.
    fn has_several(self) -> bool {
        matches!(self, Self::Planar | Self::Floating)
    }
}

pub(super) struct Mimic {
    pub(super) leader: String,
    pub(super) factor: f64,
    pub(super) offset: f64,
}

/// What a robot has beside links and joints: how it looks, moves, senses and is simulated.
const OF_A_ROBOT: [&str; 7] =
    ["material", "gazebo", "transmission", "sensor", "frame", "ros2_control", "loop_joint"];
const OF_A_LINK: [&str; 7] =
    ["inertial", "visual", "contact", "material", "sensor", "gazebo", "self_collision_checking"];
const OF_A_JOINT: [&str; 7] = [
    "dynamics",
    "calibration",
    "safety_controller",
    "hardwareInterface",
    "mechanicalReduction",
    "sensor",
    "gazebo",
];

/// Reads the text of a URDF file.
pub(super) fn read(text: &str) -> Result<Described, RobotError> {
    let document = parse("URDF", text)?;
    let mut walk = Walk::of(text);
    walk.refuse_xacro(&document)?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        let error = format!("the root is {:?}, not \"robot\"", root.tag_name().name());
        return Err(RobotError::NotOfKind { what: "URDF", error });
    }
    walk.pass_over_attributes(root, &["name", "version"]);
    let name = root.attribute("name").unwrap_or_default().to_owned();
    let mut described = Described {
        name,
        links: Vec::new(),
        joints: Vec::new(),
        moved_joints: Vec::new(),
        notes: Vec::new(),
    };
    for node in walk.children(root)? {
        match node.tag_name().name() {
            "link" => described.links.push(link(&mut walk, node)?),
            "joint" => described.joints.push(joint(&mut walk, node)?),
            other if OF_A_ROBOT.contains(&other) => walk.pass_over(node),
            other => return Err(unknown(&walk, node, other, "robot")),
        }
    }
    described.notes.extend(walk.unused.note());
    Ok(described)
}

fn unknown(walk: &Walk, node: Node<'_, '_>, name: &str, user: &str) -> RobotError {
    walk.refused(node, user, format!("element {name:?} is not understood here"))
}

fn link(walk: &mut Walk, node: Node<'_, '_>) -> Result<DescribedLink, RobotError> {
    let name = walk.required(node, "name", "link")?.to_owned();
    let user = format!("link {name:?}");
    walk.only(node, &["name", "type"], &user)?;
    let mut link = DescribedLink { name, line: walk.line(node), collisions: Vec::new() };
    for child in walk.children(node)? {
        match child.tag_name().name() {
            "collision" => link.collisions.push(geometry::collision(walk, child, &user)?),
            other if OF_A_LINK.contains(&other) => walk.pass_over(child),
            other => return Err(unknown(walk, child, other, &user)),
        }
    }
    Ok(link)
}

/// The elements of a joint that count.
#[derive(Default)]
struct JointElements<'a, 'i> {
    origin: Option<Node<'a, 'i>>,
    parent: Option<Node<'a, 'i>>,
    child: Option<Node<'a, 'i>>,
    axis: Option<Node<'a, 'i>>,
    limit: Option<Node<'a, 'i>>,
    mimic: Option<Node<'a, 'i>>,
}

fn joint_elements<'a, 'i>(
    walk: &mut Walk,
    node: Node<'a, 'i>,
    user: &str,
) -> Result<JointElements<'a, 'i>, RobotError> {
    let mut elements = JointElements::default();
    for child in walk.children(node)? {
        let slot = match child.tag_name().name() {
            "origin" => &mut elements.origin,
            "parent" => &mut elements.parent,
            "child" => &mut elements.child,
            "axis" => &mut elements.axis,
            "limit" => &mut elements.limit,
            "mimic" => &mut elements.mimic,
            other if OF_A_JOINT.contains(&other) => {
                walk.pass_over(child);
                continue;
            }
            other => return Err(unknown(walk, child, other, user)),
        };
        once(walk, slot, child, user)?;
    }
    Ok(elements)
}

/// Puts an element in its place, which must be empty.
fn once<'a, 'i>(
    walk: &Walk,
    slot: &mut Option<Node<'a, 'i>>,
    node: Node<'a, 'i>,
    user: &str,
) -> Result<(), RobotError> {
    if slot.replace(node).is_some() {
        let why = format!("there are two of {:?}", node.tag_name().name());
        return Err(walk.refused(node, user, why));
    }
    Ok(())
}

fn joint(walk: &mut Walk, node: Node<'_, '_>) -> Result<DescribedJoint, RobotError> {
    let name = walk.required(node, "name", "joint")?.to_owned();
    let user = format!("joint {name:?}");
    walk.only(node, &["name", "type"], &user)?;
    let of_type = walk.required(node, "type", &user)?;
    let kind = match of_type {
        "fixed" => Kind::Fixed,
        "revolute" | "continuous" => Kind::Turns,
        "prismatic" => Kind::Slides,
        "planar" => Kind::Planar,
        "floating" => Kind::Floating,
        other => {
            let (what, kind) = ("joint type", other.to_owned());
            return Err(walk.at(node, RobotError::Unsupported { what, kind, user }));
        }
    };
    let elements = joint_elements(walk, node, &user)?;
    let JointElements { origin, parent, child, axis, limit, mimic } = elements;
    let link = |walk: &mut Walk, end: Option<Node<'_, '_>>, what: &str| match end {
        None => Err(walk.refused(node, &user, format!("it has no {what}"))),
        Some(end) => {
            walk.only_attributes(end, &["link"], &user)?;
            walk.required(end, "link", &user).map(str::to_owned)
        }
    };
    let (parent, child) = (link(walk, parent, "parent")?, link(walk, child, "child")?);
    let origin = geometry::origin(walk, origin, &user)?;
    refuse_for_kind(walk, kind, &elements, &user)?;
    let axis = if matches!(kind, Kind::Turns | Kind::Slides) {
        axis_of(walk, axis, &user)?
    } else {
        DVec3::X
    };
    let limits = limits(walk, limit, &user)?;
    if limits.is_none() && matches!(of_type, "revolute" | "prismatic") {
        walk.unused.add("joints without the limits that their type has", walk.line(node));
    }
    let limits = if kind.has_several() || of_type == "continuous" { None } else { limits };
    // A fixed joint mimics no other.
    let mimic = mimic.filter(|_| kind != Kind::Fixed);
    let mimic = mimic.map(|mimic| mimic_of(walk, mimic, &user)).transpose()?;
    let line = walk.line(node);
    Ok(DescribedJoint { name, line, kind, parent, child, origin, axis, mimic, limits })
}

/// Refuses what a joint of this kind cannot have, and names what makes no difference to it.
fn refuse_for_kind(
    walk: &mut Walk,
    kind: Kind,
    elements: &JointElements<'_, '_>,
    user: &str,
) -> Result<(), RobotError> {
    let &JointElements { axis, limit, mimic, .. } = elements;
    if let (true, Some(mimic)) = (kind.has_several(), mimic) {
        return Err(walk.refused(mimic, user, "a joint of several values mimics none"));
    }
    if let (Kind::Planar, Some(node)) = (kind, axis)
        && axis_of(walk, Some(node), user)? != DVec3::Z
    {
        let why = "the axis of a planar joint is not z: which way its x and y point is not given";
        return Err(walk.refused(node, user, why));
    }
    if let (true, Some(limit)) = (kind.has_several(), limit) {
        walk.unused.add("limits of joints of several values", walk.line(limit));
    }
    if let (Kind::Fixed | Kind::Floating, Some(axis)) = (kind, axis) {
        walk.unused.add("fixed or floating joints' axes", walk.line(axis));
    }
    if let (Kind::Fixed, Some(mimic)) = (kind, mimic) {
        walk.unused.add("mimic of a fixed joint", walk.line(mimic));
    }
    let dynamic = ["effort", "velocity", "acceleration", "deceleration", "jerk"];
    if let Some(limit) = limit.filter(|l| l.attributes().any(|a| dynamic.contains(&a.name()))) {
        walk.unused.add("limits of effort or velocity", walk.line(limit));
    }
    Ok(())
}

/// Of unit length; the x axis where none is given.
fn axis_of(walk: &mut Walk, node: Option<Node<'_, '_>>, user: &str) -> Result<DVec3, RobotError> {
    let Some(node) = node else { return Ok(DVec3::X) };
    walk.only_attributes(node, &["xyz"], user)?;
    let given = DVec3::from_array(walk.numbers(node, "xyz", user)?.unwrap_or([1.0, 0.0, 0.0]));
    given.try_normalize().ok_or_else(|| {
        let (what, user, value) = ("length of the axis", user.to_owned(), given.length());
        walk.at(node, RobotError::BadNumber { what, user, value })
    })
}

/// The least and the largest value; `None` where neither is given.
fn limits(
    walk: &mut Walk,
    node: Option<Node<'_, '_>>,
    user: &str,
) -> Result<Option<[f64; 2]>, RobotError> {
    let Some(node) = node else { return Ok(None) };
    let known = ["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"];
    walk.only_attributes(node, &known, user)?;
    let [lower, upper] = ["lower", "upper"].map(|name| walk.number(node, name, user));
    match (lower?, upper?) {
        (None, None) => Ok(None),
        // By URDF, what is not given is 0.
        (lower, upper) => Ok(Some([lower.unwrap_or(0.0), upper.unwrap_or(0.0)])),
    }
}

fn mimic_of(walk: &mut Walk, node: Node<'_, '_>, user: &str) -> Result<Mimic, RobotError> {
    walk.only_attributes(node, &["joint", "multiplier", "offset"], user)?;
    Ok(Mimic {
        leader: walk.required(node, "joint", user)?.to_owned(),
        factor: walk.number(node, "multiplier", user)?.unwrap_or(1.0),
        offset: walk.number(node, "offset", user)?.unwrap_or(0.0),
    })
}

#[cfg(test)]
mod tests;
