//! The contents of an SRDF file: pairs that may touch, the robot's root, groups of joints.

mod groups;

pub use groups::{EndEffector, Group, GroupMember, GroupState, JointGroup};

use super::allowed::Layer;
use super::xml::{Walk, parse, text_of};
use super::{AllowedPairs, Robot, RobotError};
use groups::GroupNames;
use roxmltree::Node;
use std::path::Path;

/// An SRDF file: which pairs may touch, which frame the robot stands in, and groups of its joints.
#[derive(Clone, Debug, Default)]
pub struct Srdf {
    /// The robot that it is for.
    pub robot: String,
    /// The pairs that it disables, whatever their reason, and links that it disables by default.
    pub allowed: AllowedPairs,
    /// What joins the robot's root to the world, if the file gives it.
    pub virtual_joint: Option<VirtualJoint>,
    /// Its groups of joints, in its order.
    pub groups: Vec<Group>,
    /// Their named states.
    pub group_states: Vec<GroupState>,
    /// Which groups are the hands of others.
    pub end_effectors: Vec<EndEffector>,
    notes: Vec<String>,
}

/// How a robot's root stands in a frame of the world.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VirtualJoint {
    /// Its name.
    pub name: String,
    /// The frame.
    pub parent: String,
    /// The robot's root link.
    pub child: String,
}

/// Settings for controllers and planners, and extensions of other programs.
const NOT_USED: [&str; 5] = [
    "passive_joint",
    "joint_property",
    "link_sphere_approximation",
    "gripper",
    "disable_default_controllers",
];

impl Srdf {
    /// Reads a file: `disable_collisions`, `enable_collisions`, `disable_default_collisions`, `virtual_joint`,
    /// `group`, `group_state` and `end_effector`.
    ///
    /// # Errors
    /// A file that cannot be read or is no SRDF; what is not understood; an element without an attribute
    /// that it needs; two virtual joints, groups or states of one name; xacro; more than the
    /// [`bounds`](super::bounds).
    pub fn load(path: &Path) -> Result<Self, RobotError> {
        Self::read(&text_of(path)?).map_err(|error| error.inside(path))
    }

    /// [`Srdf::load`] of a text.
    ///
    /// # Errors
    /// Those of [`Srdf::load`].
    pub fn read(text: &str) -> Result<Self, RobotError> {
        let document = parse("SRDF", text)?;
        let mut walk = Walk::of(text);
        walk.refuse_xacro(&document)?;
        let root = document.root_element();
        if root.tag_name().name() != "robot" {
            let error = format!("the root is {:?}, not \"robot\"", root.tag_name().name());
            return Err(RobotError::NotOfKind { what: "SRDF", error });
        }
        walk.pass_over_attributes(root, &["name", "version"]);
        let mut srdf = Self {
            robot: root.attribute("name").unwrap_or_default().to_owned(),
            ..Self::default()
        };
        let (mut layer, mut names) = (Layer::of_links(), GroupNames::default());
        for node in walk.children(root)? {
            match node.tag_name().name() {
                "disable_collisions" => pair(&mut walk, node, &mut layer, true)?,
                "enable_collisions" => pair(&mut walk, node, &mut layer, false)?,
                "disable_default_collisions" => {
                    walk.only_attributes(node, &["link"], "disable_default_collisions")?;
                    layer.set_default(name_in(&walk, node, "link", "robot")?, true);
                }
                "virtual_joint" => {
                    let joint = virtual_joint(&mut walk, node)?;
                    if srdf.virtual_joint.replace(joint).is_some() {
                        let why = "there are two of them: a robot has one root";
                        return Err(walk.refused(node, "virtual_joint", why));
                    }
                }
                "group" => {
                    let group = Group::read(&mut walk, node)?;
                    names.add_group(&group).map_err(|error| walk.at(node, error))?;
                    srdf.groups.push(group);
                }
                "group_state" => {
                    let state = GroupState::read(&mut walk, node)?;
                    names.add_state(&state).map_err(|error| walk.at(node, error))?;
                    srdf.group_states.push(state);
                }
                "end_effector" => srdf.end_effectors.push(EndEffector::read(&mut walk, node)?),
                other if NOT_USED.contains(&other) => walk.pass_over(node),
                other => {
                    let why = format!("element {other:?} is not understood here");
                    return Err(walk.refused(node, "robot", why));
                }
            }
        }
        srdf.allowed.push(layer);
        srdf.notes.extend(walk.unused.note());
        Ok(srdf)
    }

    /// Adds the contents of another file of the same robot, which win where both list a pair or a default. A pair that either lists
    /// comes before the defaults of both.
    ///
    /// # Errors
    /// Another virtual joint than there is; a group or a group's state of a name that there is. Nothing is
    /// changed then.
    pub fn extend(&mut self, other: Self) -> Result<(), RobotError> {
        let Self { robot: _, allowed, virtual_joint, groups, group_states, end_effectors, notes } =
            other;
        if let (Some(old), Some(new)) = (&self.virtual_joint, &virtual_joint)
            && old != new
        {
            let user = format!("virtual_joint {:?}", new.name);
            let why = format!("there is {:?} already: a robot has one root", old.name);
            return Err(RobotError::Refused { user, why });
        }
        let mut names = GroupNames::default();
        self.groups.iter().chain(&groups).try_for_each(|group| names.add_group(group))?;
        let mut states = self.group_states.iter().chain(&group_states);
        states.try_for_each(|state| names.add_state(state))?;
        self.groups.extend(groups);
        self.group_states.extend(group_states);
        self.end_effectors.extend(end_effectors);
        self.allowed.merge(allowed);
        self.virtual_joint = self.virtual_joint.take().or(virtual_joint);
        self.notes.extend(notes);
        Ok(())
    }

    /// What the file says that is not used, and what it says that this robot does not have: a
    /// planner would go on.
    ///
    /// # Errors
    /// A virtual joint to what is not the robot's root.
    pub fn notes(&self, robot: &Robot) -> Result<Vec<String>, RobotError> {
        let mut notes = self.notes.clone();
        if self.robot != robot.name {
            notes.push(format!("it is for robot {:?}, not {:?}", self.robot, robot.name));
        }
        let known: std::collections::HashSet<&str> =
            robot.links().iter().map(|link| link.name.as_str()).collect();
        let named = self.allowed.layers().iter().flat_map(Layer::names);
        let mut unknown: Vec<&str> = named.filter(|name| !known.contains(name)).collect();
        unknown.sort_unstable();
        unknown.dedup();
        for name in unknown {
            notes.push(format!("pairs of {name:?}: the robot has no such link"));
        }
        self.note_groups(robot, &mut notes)?;
        match &self.virtual_joint {
            Some(joint) if joint.child != robot.links()[robot.root].name => {
                let user = format!("virtual_joint {:?}", joint.name);
                let root = &robot.links()[robot.root].name;
                let why = format!("its child is {:?}, but the root is {root:?}", joint.child);
                Err(RobotError::Refused { user, why })
            }
            _ => Ok(notes),
        }
    }
}

/// Whether a pair `may` touch.
fn pair(
    walk: &mut Walk,
    node: Node<'_, '_>,
    layer: &mut Layer,
    may: bool,
) -> Result<(), RobotError> {
    let user = node.tag_name().name();
    walk.only_attributes(node, &["link1", "link2", "reason", "proved"], user)?;
    let [a, b] = ["link1", "link2"].map(|of| name_in(walk, node, of, "robot"));
    layer.set(a?, b?, may);
    Ok(())
}

/// An attribute that is a name: without the spaces round it, as srdfdom reads them.
fn name_in<'a>(
    walk: &Walk,
    node: Node<'a, '_>,
    of: &str,
    user: &str,
) -> Result<&'a str, RobotError> {
    let is_space = |c: char| c.is_ascii_whitespace() || c == '\u{b}';
    Ok(walk.required(node, of, user)?.trim_matches(is_space))
}

fn virtual_joint(walk: &mut Walk, node: Node<'_, '_>) -> Result<VirtualJoint, RobotError> {
    let user = "virtual_joint";
    walk.only_attributes(node, &["name", "type", "parent_frame", "child_link"], user)?;
    let said = |of| name_in(walk, node, of, user).map(str::to_owned);
    match said("type")?.as_str() {
        "fixed" | "floating" | "planar" => {}
        other => {
            let (what, kind) = ("joint type", other.to_owned());
            let user = user.to_owned();
            return Err(walk.at(node, RobotError::Unsupported { what, kind, user }));
        }
    }
    Ok(VirtualJoint {
        name: said("name")?,
        parent: said("parent_frame")?,
        child: said("child_link")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disabled_pairs_are_read_in_both_orders() {
        let text = r#"<robot name="r">
            <group name="g"><link name="a"/></group>
            <virtual_joint name="v" type="floating" parent_frame="world" child_link="a"/>
            <disable_collisions link1="b" link2="a" reason="Adjacent"/>
            <disable_collisions link1="a" link2="c"/>
            <disable_default_collisions link="d"/><enable_collisions link1="d" link2="c"/></robot>"#;
        let srdf = Srdf::read(text).unwrap();
        let allowed = &srdf.allowed;
        assert_eq!(allowed.len(), 2);
        assert!(allowed.contains("a", "b") && allowed.contains("b", "a"));
        assert!(allowed.contains("c", "a") && !allowed.contains("b", "c"));
        assert!(allowed.contains("d", "a") && !allowed.contains("c", "d"));
        assert_eq!(srdf.virtual_joint.unwrap().parent, "world");
        assert_eq!(srdf.groups.len(), 1);
        let unused = r#"<robot name="r"><passive_joint name="p"/></robot>"#;
        assert_eq!(Srdf::read(unused).unwrap().notes, ["not used: passive_joint (line 1)"]);
    }

    #[test]
    fn of_two_files_the_second_counts_more_and_one_virtual_joint_is_enough() {
        let joint = r#"<virtual_joint name="v" type="fixed" parent_frame="world" child_link="a"/>"#;
        let read = |body: &str| Srdf::read(&format!("<robot name=\"r\">{body}</robot>")).unwrap();
        let disabled = r#"<disable_collisions link1="a" link2="b"/>"#;
        let mut both = read(&format!("{disabled}{joint}"));
        both.extend(read(r#"<disable_collisions link1="c" link2="b"/>"#)).unwrap();
        assert!(both.allowed.contains("a", "b") && both.allowed.contains("b", "c"));
        both.extend(read(&format!(r#"<enable_collisions link1="b" link2="a"/>{joint}"#))).unwrap();
        assert!(!both.allowed.contains("a", "b") && both.allowed.contains("b", "c"));
        let other = both.extend(read(&joint.replace("world", "map"))).unwrap_err().to_string();
        assert!(other.contains("one root"), "{other}");
    }

    #[test]
    fn what_is_no_srdf_is_refused_with_its_place() {
        let refused = |text: &str| Srdf::read(text).unwrap_err().to_string();
        let lacking = refused("<robot>\n  <disable_collisions link1=\"a\"/>\n</robot>");
        assert_eq!(lacking, "line 2: robot: disable_collisions has no link2");
        assert!(Srdf::read("<robot").is_err());
        assert!(refused("<scene/>").contains("\"scene\""));
        let other =
            refused("<robot><enable_collisions xmlns=\"u\" link1=\"a\" link2=\"b\"/></robot>");
        assert!(other.contains("enable_collisions has a namespace of its own"), "{other}");
        assert!(refused("<x:robot xmlns:x=\"u\"/>").contains("root \"robot\" has a prefix"));
        let inside = refused("<robot xmlns=\"u\" xmlns:x=\"u\"><x:disable_collisions/></robot>");
        assert!(inside.contains("a prefix without one"), "{inside}");
        assert!(refused("<robot><enable_colisions/></robot>").contains("enable_colisions"));
        let inside = |inside: &str| {
            let links = "link1=\"a\" link2=\"b\"";
            refused(&format!(
                "<robot><disable_collisions {links}>{inside}</disable_collisions></robot>"
            ))
        };
        assert!(inside("<if state=\"x\"/>").contains("element \"if\" is not understood in"));
        assert!(inside("never").contains("says \"never\", where attributes alone"));
        assert!(matches!(
            AllowedPairs::load(Path::new("no/such.srdf")),
            Err(RobotError::Io { path, .. }) if path == Path::new("no/such.srdf")
        ));
    }
}
