//! Groups of joints, states of them and end effectors: what a planner plans for.

use super::super::bounds::NESTING;
use super::super::names::Names;
use super::super::xml::Walk;
use super::super::{Drive, Motion, MovedJoint, Robot, RobotError};
use super::{Srdf, name_in};
use roxmltree::Node;
use std::collections::{BTreeSet, HashMap, HashSet};

/// A group of joints, as the file describes it; [`Srdf::joint_group`] finds them in a robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Its name, which no other group has.
    pub name: String,
    /// What it consists of.
    pub members: Vec<GroupMember>,
}

/// What a group consists of, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GroupMember {
    /// The joint that moves this link.
    Link(String),
    /// A joint.
    Joint(String),
    /// The joints on the way from one link to another.
    Chain {
        /// The link that it starts from.
        base: String,
        /// The link at its end.
        tip: String,
    },
    /// All of another group.
    Group(String),
}

/// Values of a group's joints that have a name, as "home".
#[derive(Clone, Debug, PartialEq)]
pub struct GroupState {
    /// Its name, which no other state of the group has.
    pub name: String,
    /// The group's name.
    pub group: String,
    /// The joints by name, each with its values: one, or those of [`MovedJoint`].
    pub joints: Vec<(String, Vec<f64>)>,
}

/// A group that is the hand of another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EndEffector {
    /// Its name.
    pub name: String,
    /// The group of its own joints.
    pub group: String,
    /// The link that it is mounted on.
    pub parent_link: String,
    /// The group that moves it, if the file says so.
    pub parent_group: Option<String>,
}

/// A group of a robot's joints, by their indices.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct JointGroup {
    /// In [`Robot::joints`], ascending.
    pub joints: Vec<usize>,
    /// The links that these joints carry, and links that the group names; in [`Robot::links`], ascending.
    pub links: Vec<usize>,
    /// The values of a state that are the group's own, in [`Robot::variables`], ascending: a joint that mimics
    /// one of another group has none.
    pub variables: Vec<usize>,
}

impl Group {
    pub(super) fn read(walk: &mut Walk, node: Node<'_, '_>) -> Result<Self, RobotError> {
        walk.only(node, &["name"], "group")?;
        let name = name_in(walk, node, "name", "group")?.to_owned();
        let user = format!("group {name:?}");
        let mut members = Vec::new();
        for child in walk.children(node)? {
            let said = |attribute| name_in(walk, child, attribute, &user).map(str::to_owned);
            let (known, member): (&[_], _) = match child.tag_name().name() {
                "link" => (&["name"], GroupMember::Link(said("name")?)),
                "joint" | "passive_joint" => (&["name"], GroupMember::Joint(said("name")?)),
                "group" => (&["name"], GroupMember::Group(said("name")?)),
                "chain" => {
                    let (base, tip) = (said("base_link")?, said("tip_link")?);
                    (&["base_link", "tip_link"], GroupMember::Chain { base, tip })
                }
                other => {
                    let why = format!("element {other:?} is not understood here");
                    return Err(walk.refused(child, &user, why));
                }
            };
            walk.only_attributes(child, known, &user)?;
            members.push(member);
        }
        Ok(Self { name, members })
    }
}

impl GroupState {
    pub(super) fn read(walk: &mut Walk, node: Node<'_, '_>) -> Result<Self, RobotError> {
        walk.only(node, &["name", "group"], "group_state")?;
        let said = |name| name_in(walk, node, name, "group_state").map(str::to_owned);
        let (name, group) = (said("name")?, said("group")?);
        let user = format!("group_state {name:?}");
        let mut joints = Vec::new();
        for child in walk.children(node)? {
            if child.tag_name().name() != "joint" {
                let why = format!("element {:?} is not understood here", child.tag_name().name());
                return Err(walk.refused(child, &user, why));
            }
            walk.only_attributes(child, &["name", "value"], &user)?;
            let joint = name_in(walk, child, "name", &user)?.to_owned();
            walk.required(child, "value", &user)?;
            joints.push((joint, walk.any_numbers(child, "value", &user)?));
        }
        Ok(Self { name, group, joints })
    }
}

impl EndEffector {
    pub(super) fn read(walk: &mut Walk, node: Node<'_, '_>) -> Result<Self, RobotError> {
        let user = "end_effector";
        let known = ["name", "parent_link", "group", "parent_group", "component_id"];
        walk.only_attributes(node, &known, user)?;
        let said = |name| name_in(walk, node, name, user).map(str::to_owned);
        Ok(Self {
            name: said("name")?,
            group: said("group")?,
            parent_link: said("parent_link")?,
            parent_group: node.attribute("parent_group").map(str::to_owned),
        })
    }
}

/// The names of groups and of their states, each of which stands once.
#[derive(Default)]
pub(super) struct GroupNames {
    groups: HashSet<String>,
    states: HashSet<[String; 2]>,
}

impl GroupNames {
    pub(super) fn add_group(&mut self, group: &Group) -> Result<(), RobotError> {
        if self.groups.insert(group.name.clone()) {
            return Ok(());
        }
        Err(RobotError::Twice { what: "group", name: group.name.clone() })
    }

    pub(super) fn add_state(&mut self, state: &GroupState) -> Result<(), RobotError> {
        if self.states.insert([state.group.clone(), state.name.clone()]) {
            return Ok(());
        }
        let user = format!("group {:?}", state.group);
        let why = format!("there are two of state {:?}", state.name);
        Err(RobotError::Refused { user, why })
    }
}

impl Srdf {
    /// The joints of a group in a robot, those of its subgroups among them. As MoveIt has it, a link stands for
    /// the joint that moves it, and a chain may go up from its base and down again.
    ///
    /// # Errors
    /// A group, a link or a joint of a name that there is not; a group that holds itself.
    pub fn joint_group(&self, robot: &Robot, name: &str) -> Result<JointGroup, RobotError> {
        let find = Find::new(self, robot)?;
        let mut found = Found::default();
        find.add(name, "a joint group", &mut found)?;
        Ok(find.ends(found))
    }

    /// A named state of a group: each variable of its joints, by its index in [`Robot::variables`], with its value.
    /// Joints without a value of their own (fixed, or mimicking others) say nothing.
    ///
    /// # Errors
    /// A state of that group that there is not; a joint that the robot does not have; another number of
    /// values than the joint has.
    pub fn group_state(
        &self,
        robot: &Robot,
        group: &str,
        name: &str,
    ) -> Result<Vec<(usize, f64)>, RobotError> {
        let mut states = self.group_states.iter();
        let Some(state) = states.find(|state| state.group == group && state.name == name) else {
            let (what, name, user) = ("state", name.to_owned(), format!("group {group:?}"));
            return Err(RobotError::Unknown { what, name, user });
        };
        Find::new(self, robot)?.state(state)
    }

    /// What groups, their states and end effectors name that there is not: a planner would go on without.
    pub(super) fn note_groups(
        &self,
        robot: &Robot,
        notes: &mut Vec<String>,
    ) -> Result<(), RobotError> {
        let find = Find::new(self, robot)?;
        let mut note = |refused: Option<RobotError>| notes.extend(refused.map(|e| e.to_string()));
        for Group { name, members } in &self.groups {
            let user = format!("group {name:?}");
            members.iter().for_each(|member| note(find.member(member, &user).err()));
        }
        self.group_states.iter().for_each(|state| note(find.state(state).err()));
        for EndEffector { name, group, parent_link, parent_group } in &self.end_effectors {
            let user = format!("end_effector {name:?}");
            for group in std::iter::once(group).chain(parent_group) {
                note(find.group(group, &user).err());
            }
            note(find.links.index(parent_link, &user).err());
        }
        Ok(())
    }
}

/// Indices in a robot.
#[derive(Default)]
struct Found {
    joints: BTreeSet<usize>,
    links: BTreeSet<usize>,
    /// The groups on the way down to the one that is looked at.
    open: Vec<String>,
    /// The groups that need no second look.
    done: HashSet<String>,
}

/// Finds what groups name.
struct Find<'a> {
    robot: &'a Robot,
    groups: HashMap<&'a str, &'a Group>,
    links: Names<'a>,
    joints: Names<'a>,
    moved: HashMap<&'a str, &'a MovedJoint>,
    /// For each link the joint that moves it.
    above: Vec<Option<usize>>,
}

impl<'a> Find<'a> {
    fn new(srdf: &'a Srdf, robot: &'a Robot) -> Result<Self, RobotError> {
        let mut above = vec![None; robot.links().len()];
        for (index, joint) in robot.joints().iter().enumerate() {
            above[joint.child] = Some(index);
        }
        let moved = robot.moved_joints().iter().map(|moved| (&*moved.name, moved));
        Ok(Self {
            robot,
            groups: srdf.groups.iter().map(|group| (&*group.name, group)).collect(),
            links: Names::of("link", robot.links().iter().map(|link| (&*link.name, 0)))?,
            joints: Names::of("joint", robot.joints().iter().map(|joint| (&*joint.name, 0)))?,
            moved: moved.collect(),
            above,
        })
    }

    fn group(&self, name: &str, user: &str) -> Result<&'a Group, RobotError> {
        self.groups.get(name).copied().ok_or_else(|| RobotError::Unknown {
            what: "group",
            name: name.to_owned(),
            user: user.to_owned(),
        })
    }

    /// That all that it names is there.
    fn member(&self, member: &GroupMember, user: &str) -> Result<(), RobotError> {
        match member {
            GroupMember::Group(group) => self.group(group, user).map(drop),
            GroupMember::Joint(joint) => self.known_joint(joint, user),
            GroupMember::Link(link) => self.links.index(link, user).map(drop),
            GroupMember::Chain { base, tip } => {
                self.links.index(base, user)?;
                self.links.index(tip, user).map(drop)
            }
        }
    }

    /// Adds all that a group consists of.
    fn add(&self, name: &str, user: &str, found: &mut Found) -> Result<(), RobotError> {
        let group = self.group(name, user)?;
        let own = format!("group {name:?}");
        let refused = |why| Err(RobotError::Refused { user: own.clone(), why });
        if found.open.iter().any(|open| open == name) {
            return refused("it holds itself, by way of others".to_owned());
        }
        if found.open.len() == NESTING {
            return refused(format!("groups in groups more than {NESTING} deep"));
        }
        if !found.done.insert(name.to_owned()) {
            return Ok(());
        }
        found.open.push(name.to_owned());
        for member in &group.members {
            match member {
                GroupMember::Group(inner) => self.add(inner, &own, found)?,
                GroupMember::Joint(joint) => found.joints.extend(self.joint(joint, &own)?),
                GroupMember::Link(link) => {
                    let link = self.links.index(link, &own)?;
                    found.links.insert(link);
                    found.joints.extend(self.above[link]);
                }
                GroupMember::Chain { base, tip } => {
                    let [base, tip] = [base, tip].map(|link| self.links.index(link, &own));
                    let (up, down) = (self.to_root(base?), self.to_root(tip?));
                    found.joints.extend(up.symmetric_difference(&down));
                }
            }
        }
        found.open.pop();
        Ok(())
    }

    /// The variables of a named state, by their indices, with their values.
    fn state(&self, state: &GroupState) -> Result<Vec<(usize, f64)>, RobotError> {
        let user = format!("group_state {:?}", state.name);
        let mut values = Vec::new();
        for (joint, given) in &state.joints {
            let Some(own) = self.moved.get(joint.as_str()) else {
                self.known_joint(joint, &user)?;
                continue;
            };
            if own.values.len() != given.len() {
                let (expected, found) = (own.values.len(), given.len());
                let user = format!("{user}, joint {joint:?}");
                return Err(RobotError::Count { what: "values", user, expected, found });
            }
            values.extend(own.values.clone().zip(given.iter().copied()));
        }
        Ok(values)
    }

    /// A joint of the URDF: several where it has several values.
    fn joint(&self, name: &str, user: &str) -> Result<Vec<usize>, RobotError> {
        match self.moved.get(name).filter(|moved| moved.values.len() > 1) {
            Some(moved) => Ok(self.moved_by(moved.values.clone())),
            None => Ok(vec![self.joints.index(name, user)?]),
        }
    }

    /// That there is such a joint.
    fn known_joint(&self, name: &str, user: &str) -> Result<(), RobotError> {
        if self.moved.contains_key(name) {
            return Ok(());
        }
        self.joints.index(name, user).map(drop)
    }

    fn moved_by(&self, values: std::ops::Range<usize>) -> Vec<usize> {
        let joints = self.robot.joints().iter().enumerate();
        let moved = joints.filter(|(_, joint)| match joint.motion {
            Motion::Orients { first } => values.contains(&first),
            motion => motion.drive().is_some_and(|by| values.contains(&by.value)),
        });
        moved.map(|(index, _)| index).collect()
    }

    /// All joints that move the link against the root.
    fn to_root(&self, mut link: usize) -> BTreeSet<usize> {
        let mut joints = BTreeSet::new();
        while let Some(joint) = self.above[link] {
            joints.insert(joint);
            link = self.robot.joints()[joint].parent;
        }
        joints
    }

    fn ends(&self, Found { mut joints, mut links, .. }: Found) -> JointGroup {
        // Of a joint of several values all belong to it, whichever of its steps was named.
        let moved = self.robot.moved_joints().iter();
        for several in moved.filter(|moved| moved.values.len() > 1) {
            let steps = self.moved_by(several.values.clone());
            if steps.iter().any(|step| joints.contains(step)) {
                joints.extend(steps);
            }
        }
        links.extend(joints.iter().map(|&joint| self.robot.joints()[joint].child));
        let own = |&joint: &usize| {
            let joint = &self.robot.joints()[joint];
            match joint.motion {
                Motion::Orients { first } => first..first + 4,
                motion => match motion.drive() {
                    Some(Drive { value, .. }) if self.is_own(joint.name.as_str(), value) => {
                        value..value + 1
                    }
                    _ => 0..0,
                },
            }
        };
        let variables: BTreeSet<usize> = joints.iter().flat_map(own).collect();
        JointGroup {
            joints: joints.into_iter().collect(),
            links: links.into_iter().collect(),
            variables: variables.into_iter().collect(),
        }
    }

    /// Whether the value is the joint's own, and not one that it mimics.
    fn is_own(&self, joint: &str, value: usize) -> bool {
        self.robot.variables()[value] == joint
    }
}

#[cfg(test)]
mod tests;
