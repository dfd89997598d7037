//! States and edges of a robot as lines of JSON, with what the robot carries there.
//!
//! A state is `{"q": {"joint": value, …}}` or `{"q": [values in the order of the moved joints]}`, an edge
//! `{"from": q, "to": q}` or `{"control": [q, q, q, q]}`; both optionally with
//! `"attached": [{"name": "…", "link": "…", "touch": ["…"], "shape": {"box": [x, y, z]} | {"sphere": r} |
//! {"cylinder": [r, length]} | {"mesh": "file"}, "pose": {"xyz": […], "q": [x, y, z, w]}}]`.

use super::json::{self, Json, refused};
use super::kinematics::JointFrame;
use super::shapes::Shapes;
use super::urdf::Geometry;
use super::{Attached, JointPath, LinkShapes, MeshSource, MovedJoint, Robot, RobotError};
use dcd_geom::Pose;
use glam::{DQuat, DVec3};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// A state, and what the robot carries in it.
#[derive(Clone, Debug)]
pub struct State {
    /// A value for each of [`Robot::variables`].
    pub values: Vec<f64>,
    /// What the robot carries, beside what its world says; shared by neighbouring lines that say the same.
    pub attached: Arc<[AttachedObject]>,
}

/// An edge, and what the robot carries on it.
#[derive(Clone, Debug)]
pub struct EdgeRequest {
    /// The edge.
    pub path: JointPath,
    /// As a [`State`] has it.
    pub attached: Arc<[AttachedObject]>,
}

/// An object that a link carries, and what it may touch.
#[derive(Clone, Debug)]
pub struct AttachedObject {
    /// The object.
    pub object: Attached,
    /// Names of links, obstacles and other carried objects that it may touch, beside its own link.
    pub touch: Vec<String>,
}

/// Reads states of one robot.
///
/// ```
/// use dcd_robot::{LinkShapes, MeshSource, Robot, StateReader};
/// use std::path::Path;
/// let guide = Path::new("../../docs/guide/arm"); // the guide's arm and its shelf
/// let robot = Robot::load(&guide.join("arm_description/urdf/arm.urdf"))?;
/// use dcd_io::{MeshPaths, UpAxis};
/// let (paths, of_links) = (MeshPaths::new(guide), Default::default());
/// let meshes = MeshSource { paths, up_axis: UpAxis::Ros, shapes: LinkShapes::Hulls, of_links };
/// let mut reader = StateReader::new(&robot, vec![0.0; 5], meshes);
/// assert_eq!(reader.read(br#"{"q": {"elbow": -1.0}}"#)?.values, [0.0, 0.0, -1.0, 0.0, 0.0]);
/// assert!(reader.read(br#"{"q": {"elbow": -1.0}, "speed": 2}"#).is_err()); // not understood
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct StateReader<'a> {
    robot: &'a Robot,
    /// Those that have values.
    joints: HashMap<&'a str, &'a MovedJoint>,
    /// What holds for joints that a line does not name.
    defaults: Vec<f64>,
    meshes: MeshSource,
    /// The last line's carried objects as JSON, and what they are.
    last: (Option<Json>, Arc<[AttachedObject]>),
    /// What a user should know of the carried meshes, and whether it was handed out.
    notes: BTreeMap<String, bool>,
}

impl<'a> StateReader<'a> {
    /// For a robot whose joints are at `defaults` (a value for each of [`Robot::variables`]) where a
    /// line says nothing else; `meshes` says where the mesh files of carried objects are.
    pub fn new(robot: &'a Robot, defaults: Vec<f64>, meshes: MeshSource) -> Self {
        let joints =
            robot.moved_joints().iter().map(|joint| (joint.name.as_str(), joint)).collect();
        let (last, notes): ((_, Arc<[_]>), _) = ((None, Arc::new([])), BTreeMap::new());
        Self { robot, joints, defaults, meshes, last, notes }
    }

    /// What a user should know of the meshes that were carried since the last call: a sentence each, each once.
    pub fn take_notes(&mut self) -> Vec<String> {
        let new = self.notes.iter_mut().filter(|(_, is_said)| !**is_said);
        new.map(|(note, is_said)| {
            *is_said = true;
            note.clone()
        })
        .collect()
    }

    /// Reads one line.
    ///
    /// # Errors
    /// What is no such object; a key that is not known, but for `name` and those that begin with an
    /// underscore; a joint that the robot does not have, or that is fixed or mimics another; another number
    /// of values than of moved joints; a value that is not finite; a carried object that
    /// [`Workcell::new`](super::Workcell::new) would refuse by itself.
    pub fn read(&mut self, line: &[u8]) -> Result<State, RobotError> {
        let line = json::parse("state", line)?;
        let [values, attached] = line.fields(["q", "attached"], "state")?;
        let values = values.ok_or_else(|| refused("state", "there is no q"))?;
        Ok(State { values: self.values(values)?, attached: self.attached(attached)? })
    }

    /// Reads one line of edges: `from` and `to`, or four points of `control`.
    ///
    /// # Errors
    /// As [`read`](Self::read); neither a straight edge nor a curve, or both.
    pub fn read_edge(&mut self, line: &[u8]) -> Result<EdgeRequest, RobotError> {
        const USER: &str = "edge";
        let line = json::parse(USER, line)?;
        let keys = ["from", "to", "control", "attached"];
        let [from, to, control, attached] = line.fields(keys, USER)?;
        let path = match (from, to, control) {
            (Some(from), Some(to), None) => {
                JointPath::Straight([self.values(from)?, self.values(to)?])
            }
            (None, None, Some(control)) => {
                let points = control.list("control", USER)?;
                let points = points.iter().map(|point| self.values(point));
                let points = points.collect::<Result<Vec<_>, _>>()?;
                let points = points.try_into().map_err(|points: Vec<_>| {
                    let (what, user) = ("control points", USER.to_owned());
                    RobotError::Count { what, user, expected: 4, found: points.len() }
                })?;
                JointPath::Bezier(points)
            }
            _ => return Err(refused(USER, "it has neither from and to nor control, or both")),
        };
        Ok(EdgeRequest { path, attached: self.attached(attached)? })
    }

    /// Joint values by name, or all of them in their order.
    fn values(&self, q: &Json) -> Result<Vec<f64>, RobotError> {
        let joints = self.robot.moved_joints();
        match q {
            Json::List(list) if list.len() == joints.len() => {
                let mut values = self.defaults.clone();
                for (joint, q) in joints.iter().zip(list) {
                    set(joint, q, &mut values)?;
                }
                Ok(values)
            }
            Json::List(list) => {
                let user = format!("robot {:?}", self.robot.name);
                let (what, expected, found) = ("joint values", joints.len(), list.len());
                Err(RobotError::Count { what, user, expected, found })
            }
            Json::Object(entries) => {
                let mut values = self.defaults.clone();
                for (name, q) in entries {
                    set(self.joint(name)?, q, &mut values)?;
                }
                Ok(values)
            }
            _ => Err(refused("q", "it is neither an object nor a list")),
        }
    }

    fn joint(&self, name: &str) -> Result<&'a MovedJoint, RobotError> {
        if let Some(&joint) = self.joints.get(name) {
            return Ok(joint);
        }
        if self.robot.joints().iter().any(|joint| joint.name == name) {
            return Err(refused(&format!("joint {name:?}"), "it is fixed or mimics another"));
        }
        let (what, name, user) = ("joint", name.to_owned(), "state".to_owned());
        Err(RobotError::Unknown { what, name, user })
    }

    fn attached(&mut self, said: Option<&Json>) -> Result<Arc<[AttachedObject]>, RobotError> {
        if self.last.0.as_ref() != said {
            let objects = said.map_or(Ok(&[][..]), |said| said.list("attached", "state"))?;
            let objects = objects.iter().map(|object| self.object(object));
            self.last = (said.cloned(), objects.collect::<Result<_, _>>()?);
        }
        Ok(Arc::clone(&self.last.1))
    }

    fn object(&mut self, said: &Json) -> Result<AttachedObject, RobotError> {
        const USER: &str = "attached object";
        let keys = ["name", "link", "touch", "shape", "pose"];
        let [name, link, touch, shape, pose] = said.fields(keys, USER)?;
        let needed = |value: Option<&'_ Json>, key: &str| -> Result<Json, RobotError> {
            value.cloned().ok_or_else(|| refused(USER, format!("there is no {key}")))
        };
        let name = needed(name, "name")?.text("name", USER)?.to_owned();
        let user = format!("{USER} {name:?}");
        let link = needed(link, "link")?.text("link", &user)?.to_owned();
        let touch = touch.map_or(Ok(&[][..]), |touch| touch.list("touch", &user))?;
        let touch = touch.iter().map(|name| name.text("touch", &user).map(str::to_owned));
        let geometry = geometry(&needed(shape, "shape")?, &user)?;
        let meshes = match self.meshes.shapes {
            LinkShapes::Meshes => LinkShapes::Meshes,
            // A budget is for the links.
            _ => LinkShapes::Hulls,
        };
        let mut shapes = Shapes::new(&self.meshes);
        let shape = shapes.shape(&geometry, (&user, meshes))?.shape;
        for note in shapes.notes() {
            self.notes.entry(note).or_insert(false);
        }
        let pose = pose.map_or(Ok(Pose::IDENTITY), |pose| posed(pose, &user))?;
        let parts = vec![(shape, JointFrame::of_pose(&pose))];
        Ok(AttachedObject {
            object: Attached { name, link, parts },
            touch: touch.collect::<Result<_, _>>()?,
        })
    }
}

/// Sets a joint's values: a number, or a list where it has several.
fn set(joint: &MovedJoint, said: &Json, values: &mut [f64]) -> Result<(), RobotError> {
    let user = format!("joint {:?}", joint.name);
    let slots = &mut values[joint.values.clone()];
    let said: &[Json] = match (said, slots.len()) {
        (said, 1) => std::slice::from_ref(said),
        (Json::List(list), count) if list.len() == count => list,
        (Json::List(list), expected) => {
            let (what, found) = ("values", list.len());
            return Err(RobotError::Count { what, user, expected, found });
        }
        (_, count) => return Err(refused(&user, format!("its value is no list of {count}"))),
    };
    for (slot, said) in slots.iter_mut().zip(said) {
        let value = said.number("its value", &user)?;
        if !value.is_finite() {
            return Err(RobotError::BadNumber { what: "value", user, value });
        }
        *slot = value;
    }
    Ok(())
}

fn geometry(said: &Json, user: &str) -> Result<Geometry, RobotError> {
    let Json::Object(entries) = said else { return Err(refused(user, "its shape is no object")) };
    let [(kind, size)] = &entries[..] else {
        return Err(refused(user, format!("its shape has {} kinds, not 1", entries.len())));
    };
    match kind.as_str() {
        "box" => {
            Ok(Geometry::Box { size: DVec3::from_array(size.numbers("edges of a box", user)?) })
        }
        "sphere" => Ok(Geometry::Sphere { radius: size.number("a sphere's radius", user)? }),
        "cylinder" => {
            let [radius, length] = size.numbers("sizes of a cylinder", user)?;
            Ok(Geometry::Cylinder { radius, length })
        }
        "mesh" => {
            let file = size.text("a mesh", user)?.to_owned();
            Ok(Geometry::Mesh { file, scale: DVec3::ONE })
        }
        _ => {
            let (what, kind, user) = ("shape", kind.clone(), user.to_owned());
            Err(RobotError::Unsupported { what, kind, user })
        }
    }
}

fn posed(said: &Json, user: &str) -> Result<Pose, RobotError> {
    let [xyz, q] = said.fields(["xyz", "q"], user)?;
    let xyz = xyz.map_or(Ok([0.0; 3]), |xyz| xyz.numbers("coordinates of a pose", user))?;
    let q = q.map_or(Ok([0.0, 0.0, 0.0, 1.0]), |q| q.numbers("numbers of a quaternion", user))?;
    let pose = Pose::new(DQuat::from_array(q), DVec3::from_array(xyz));
    pose.map_err(|error| RobotError::Pose { user: user.to_owned(), error })
}

#[cfg(test)]
mod tests;
