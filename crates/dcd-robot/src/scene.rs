//! MoveIt's scenes: what they say, and the world that it comes to for a robot.

use super::allowed::{Layer, Matrix};
use super::frames::{Frames, frame_of};
use super::kinematics::JointFrame;
use super::notes::Unused;
use super::world::{Attached, Padding, World};
use super::{MovedJoint, Robot, RobotError, Srdf, objects, xml, yaml};
use dcd_moveit::{
    AllowedCollisionMatrix, AttachedCollisionObject, CollisionObject, Coordinates, JointState,
    MultiDofJointState, PlanningScene as SceneMessage, RobotState, Transform, WithLine,
};
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// A scene of MoveIt, read and not yet laid out for a robot.
///
/// ```
/// use dcd_robot::{PlanningScene, Robot};
/// use std::path::Path;
/// let guide = Path::new("../../docs/guide/arm"); // the guide's arm and its shelf
/// let robot = Robot::load(&guide.join("arm_description/urdf/arm.urdf"))?;
/// let yaml = r#"
/// world:
///   collision_objects:
///     - id: wall
///       primitives: [{type: box, dimensions: [0.2, 2, 2]}]
///       primitive_poses: [{position: [0.6, 0, 0.5], orientation: [0, 0, 0, 1]}]
/// "#;
/// let world = PlanningScene::read(yaml)?.world(&robot, None)?;
/// assert_eq!(world.obstacles[0].name, "wall");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PlanningScene(SceneMessage);

impl PlanningScene {
    /// Reads a scene as YAML: moveit_msgs/PlanningScene, in the spelling of ROS or of Robowflex. Keys
    /// that such a message does not have are refused.
    ///
    /// # Errors
    /// What is no such YAML, or has no `world`; more than the [`bounds`](super::bounds).
    pub fn read(yaml: &str) -> Result<Self, RobotError> {
        let message = yaml::read("scene", yaml, dcd_moveit::read_scene)?;
        if message.world.is_none() {
            let error = "there is no world in it".to_owned();
            return Err(RobotError::NotOfKind { what: "scene", error });
        }
        Ok(Self(message))
    }

    /// [`PlanningScene::read`] from a file.
    ///
    /// # Errors
    /// Those of [`PlanningScene::read`], and those of reading the file, both with its path.
    pub fn load(path: &Path) -> Result<Self, RobotError> {
        Self::read(&xml::text_of(path)?).map_err(|error| error.inside(path))
    }

    /// What the scene says, for this robot, in the frame that the robot's root stands in: that of the
    /// SRDF's virtual joint, or the root's own.
    ///
    /// Frames are that one (or none), any link's at the scene's state, and those of
    /// `fixed_frame_transforms`. `operation` may add an object or remove an earlier one. An attached
    /// object without shapes is the world's of that name. Primitives are boxes, spheres, cylinders
    /// (height, radius; round z) and cones (height, radius; apex up); meshes are surfaces.
    ///
    /// # Errors
    /// A frame, link or joint that is not known; two objects of one name; planes, an octomap and other
    /// operations; dimensions, poses or matrix rows of another number than belong there, or that are
    /// refused; a matrix that says two things of a pair.
    pub fn world(&self, robot: &Robot, srdf: Option<&Srdf>) -> Result<World, RobotError> {
        let message = &self.0;
        let MultiDof { base, values } = MultiDof::of(&message.robot_state, robot, srdf)?;
        let mut robot = robot.clone();
        robot.base = base.unwrap_or(robot.base);
        let mut world = World {
            base: base
                .map(|frame| frame.pose())
                .transpose()
                .map_err(|error| in_state(&message.robot_state, error))?,
            ..World::default()
        };
        world.joints = joint_values(&message.robot_state)?;
        world.joints.extend(values);
        let state = robot.state(&world.joints)?;
        let mut frames = Frames::of(&robot, srdf, &state)?;
        message.fixed_frame_transforms.iter().try_for_each(|said| frames.fix(said))?;
        self.place_objects(&mut world, &frames)?;
        let mut layer = Layer::default();
        if let Some(matrix) = &message.allowed_collision_matrix {
            let added = add_matrix(&matrix.value, &mut layer);
            added.map_err(|error| error.at_line(matrix.line))?;
        }
        world.allowed.push(layer);
        self.attach(&mut world, &frames)?;
        self.pad(&mut world, &robot)?;
        self.note(&mut world, &robot);
        Ok(world)
    }

    fn place_objects(&self, world: &mut World, frames: &Frames<'_>) -> Result<(), RobotError> {
        let message = self.0.world.as_ref();
        let octomap = message.and_then(|world| world.octomap.as_ref());
        if let Some(map) = octomap.filter(|map| map.value.octomap.data.0) {
            let (user, why) = ("world".to_owned(), "an octomap is not supported".to_owned());
            return Err(RobotError::Refused { user, why }.at_line(map.line));
        }
        // Objects in their order, those that were removed empty.
        let mut objects: Vec<Vec<super::Obstacle>> = Vec::new();
        let mut known: HashMap<&str, usize> = HashMap::new();
        for said in message.iter().flat_map(|world| &world.collision_objects) {
            let object = &said.value;
            let at = |error: RobotError| error.at_line(said.line);
            match object.operation.0.to_lowercase().as_str() {
                "" | "0" | "add" => {
                    if known.insert(&object.id, objects.len()).is_some() {
                        let name = object.id.clone();
                        return Err(at(RobotError::Twice { what: "object", name }));
                    }
                    // Its geometry may be in a database that is not here.
                    if object.has_no_shape() {
                        let user = format!("object {:?}", object.id);
                        return Err(at(RobotError::Refused {
                            user,
                            why: "it has no shape".to_owned(),
                        }));
                    }
                    objects.push(objects::obstacles(object, frames).map_err(at)?);
                }
                "1" | "remove" if object.id.is_empty() => {
                    known.clear();
                    objects.clear();
                }
                "1" | "remove" => match known.remove(object.id.as_str()) {
                    Some(index) => objects[index].clear(),
                    None => world.notes.push(format!("no object {:?} to remove", object.id)),
                },
                other => {
                    let (what, kind) = ("operation", other.to_owned());
                    let user = format!("object {:?}", object.id);
                    return Err(at(RobotError::Unsupported { what, kind, user }));
                }
            }
        }
        world.obstacles = objects.concat();
        Ok(())
    }

    fn attach(&self, world: &mut World, frames: &Frames<'_>) -> Result<(), RobotError> {
        let mut layer = Layer::default();
        for said in &self.0.robot_state.attached_collision_objects {
            let AttachedCollisionObject { link_name, object, touch_links, .. } = &said.value;
            let attached = attached(said, world, frames);
            let attached = attached.map_err(|error| error.at_line(said.line))?;
            layer.carry(&object.id, link_name);
            for link in touch_links.iter().chain([link_name]) {
                if frames.link(link).is_none() {
                    world.notes.push(format!(
                        "object {:?} may touch link {link:?}, which the robot does not have",
                        object.id
                    ));
                }
                layer.set(&object.id, link, true);
            }
            world.attached.push(attached);
        }
        world.allowed.push(layer);
        Ok(())
    }

    fn pad(&self, world: &mut World, robot: &Robot) -> Result<(), RobotError> {
        let paddings = self.0.link_padding.iter().map(|said| {
            let value = said.value.padding;
            (&said.value.link_name, "padding", value, said.line, value >= 0.0)
        });
        let scales = self.0.link_scale.iter().map(|said| {
            let value = said.value.scale;
            (&said.value.link_name, "scale", value, said.line, value > 0.0)
        });
        let mut said = HashSet::new();
        let links: HashSet<&str> = robot.links().iter().map(|link| link.name.as_str()).collect();
        for (link, what, value, line, in_range) in paddings.chain(scales) {
            let user = format!("link {link:?}");
            if !(in_range && value.is_finite()) {
                return Err(RobotError::BadNumber { what, user, value }.at_line(line));
            }
            if !said.insert((what, link)) {
                return Err(RobotError::Twice { what, name: link.clone() }.at_line(line));
            }
            if !links.contains(link.as_str()) {
                world.notes.push(format!("{what} of {user}: the robot has no such link"));
                continue;
            }
            let padding = world.padding.entry(link.clone()).or_insert(Padding::NONE);
            match what {
                "padding" => padding.padding = value,
                _ => padding.scale = value,
            }
        }
        world.padding.retain(|_, padding| *padding != Padding::NONE);
        Ok(())
    }

    /// What a planner would go on after, and what is not used.
    fn note(&self, world: &mut World, robot: &Robot) {
        let message = &self.0;
        if message.is_diff || message.robot_state.is_diff {
            let what = if message.is_diff { "the scene" } else { "robot_state" };
            world.notes.push(format!("{what} is a difference (is_diff): taken as the whole"));
        }
        let model = &message.robot_model_name;
        if !model.is_empty() && *model != robot.name {
            world.notes.push(format!("it is for robot {model:?}, not {:?}", robot.name));
        }
        world.note_obstacles();
        world.notes.extend(robot.idle_values(&world.joints));
        let mut unused = Unused::default();
        message.for_each_unused(&mut |kind, line| unused.add(kind, line));
        world.notes.extend(unused.kinds());
    }
}

fn in_state(state: &RobotState, error: dcd_geom::PoseError) -> RobotError {
    let user = "robot_state".to_owned();
    RobotError::Pose { user, error }.at_line(state.multi_dof_joint_state.line)
}

/// Refuses a name that stands twice: of two things that are said of one, neither is dropped.
pub(super) fn each_once(what: &'static str, names: &[String]) -> Result<(), RobotError> {
    let mut seen = HashSet::new();
    match names.iter().find(|name| !seen.insert(name.as_str())) {
        None => Ok(()),
        Some(name) => Err(RobotError::Twice { what, name: name.clone() }),
    }
}

/// The joint values of a state, by name.
pub(super) fn joint_values(state: &RobotState) -> Result<Vec<(String, f64)>, RobotError> {
    let WithLine { value: JointState { name, position, .. }, line } = &state.joint_state;
    let (expected, found) = (name.len(), position.len());
    if expected != found {
        let user = "joint_state".to_owned();
        let error = RobotError::Count { what: "positions", user, expected, found };
        return Err(error.at_line(*line));
    }
    each_once("value of joint", name).map_err(|error| error.at_line(*line))?;
    Ok(name.iter().cloned().zip(position.iter().copied()).collect())
}

/// What a state says of joints of several values.
#[derive(Debug, Default, PartialEq)]
pub(super) struct MultiDof {
    /// Where the robot's root is: by the SRDF's virtual joint.
    pub(super) base: Option<JointFrame>,
    /// Values of the robot's own joints, by their names.
    pub(super) values: Vec<(String, f64)>,
}

impl MultiDof {
    /// From `multi_dof_joint_state`, whose transforms are a virtual joint's, a floating or a planar joint's.
    pub(super) fn of(
        state: &RobotState,
        robot: &Robot,
        srdf: Option<&Srdf>,
    ) -> Result<Self, RobotError> {
        let WithLine { value, line } = &state.multi_dof_joint_state;
        let said = Self::of_joints(value, robot, srdf).and_then(|said| said.check_once(state));
        said.map_err(|error| error.at_line(*line))
    }

    /// Refuses a value that `joint_state` has too: which of the two counts would be a guess.
    fn check_once(self, state: &RobotState) -> Result<Self, RobotError> {
        let names: HashSet<&String> = state.joint_state.value.name.iter().collect();
        match self.values.iter().find(|(name, _)| names.contains(name)) {
            Some((name, _)) => {
                Err(RobotError::Twice { what: "value of joint", name: name.clone() })
            }
            None => Ok(self),
        }
    }

    fn of_joints(
        joints: &MultiDofJointState,
        robot: &Robot,
        srdf: Option<&Srdf>,
    ) -> Result<Self, RobotError> {
        let user = "multi_dof_joint_state".to_owned();
        let (expected, found) = (joints.joint_names.len(), joints.transforms.len());
        if expected != found {
            return Err(RobotError::Count { what: "transforms", user, expected, found });
        }
        each_once("transform of joint", &joints.joint_names)?;
        let known = srdf.and_then(|srdf| srdf.virtual_joint.as_ref());
        let frame = joints.header.frame_id.trim_start_matches('/');
        let model_frame = known.map_or(&*robot.links()[robot.root].name, |joint| &joint.parent);
        let mut said = Self::default();
        for (name, transform) in joints.joint_names.iter().zip(&joints.transforms) {
            let place = frame_of(transform, &format!("joint {name:?}"))?;
            let is_base = known.is_some_and(|joint| joint.name == *name);
            let own = robot.moved_joints().iter().find(|joint| joint.name == *name);
            let own = own.filter(|joint| joint.values.len() > 1);
            // Whatever stands still at the identity says nothing, known or not.
            if place == JointFrame::IDENTITY && !is_base && own.is_none() {
                continue;
            }
            if !is_base && own.is_none() {
                let what = "virtual joint (of an SRDF) and no joint of several values";
                return Err(RobotError::Unknown { what, name: name.clone(), user });
            }
            if !frame.is_empty() && frame != model_frame {
                return Err(RobotError::Unknown { what: "frame", name: frame.to_owned(), user });
            }
            match own {
                Some(joint) => {
                    let names = robot.variables()[joint.values.clone()].iter().cloned();
                    said.values.extend(names.zip(values_of(joint, transform)?));
                }
                None => said.base = Some(place),
            }
        }
        Ok(said)
    }
}

/// A transform as the values of a floating or a planar joint.
fn values_of(joint: &MovedJoint, transform: &Transform) -> Result<Vec<f64>, RobotError> {
    let Transform { translation: Coordinates([x, y, z]), rotation: Coordinates([a, b, c, w]) } =
        *transform;
    if joint.values.len() == 7 {
        return Ok(vec![x, y, z, a, b, c, w]);
    }
    if [z, a, b] != [0.0; 3] {
        let user = format!("joint {:?}", joint.name);
        let why = "it is planar, and its transform leaves the plane z = 0".to_owned();
        return Err(RobotError::Refused { user, why });
    }
    Ok(vec![x, y, 2.0 * libm::atan2(c, w)])
}

fn attached(
    said: &WithLine<AttachedCollisionObject>,
    world: &mut World,
    frames: &Frames<'_>,
) -> Result<Attached, RobotError> {
    let AttachedCollisionObject { link_name, object, .. } = &said.value;
    let user = format!("attached object {:?}", object.id);
    if !matches!(object.operation.0.to_lowercase().as_str(), "" | "0" | "add") {
        let (what, kind) = ("operation", object.operation.0.clone());
        return Err(RobotError::Unsupported { what, kind, user });
    }
    let Some(link) = frames.link(link_name) else {
        let (what, name) = ("link", link_name.clone());
        return Err(RobotError::Unknown { what, name, user });
    };
    let shapes = shapes_of(object, world, frames)?;
    if shapes.is_empty() {
        let why = "it has no shape, and the world has no object of that name".to_owned();
        return Err(RobotError::Refused { user, why });
    }
    let to_link = link.inverse();
    let parts = shapes.into_iter().map(|shape| {
        let origin = to_link.then(&JointFrame::of_pose(&shape.pose));
        (shape.shape, origin)
    });
    Ok(Attached { name: object.id.clone(), link: link_name.clone(), parts: parts.collect() })
}

/// An object's own shapes, or those of the world's object of its name, which leaves the world.
fn shapes_of(
    object: &CollisionObject,
    world: &mut World,
    frames: &Frames<'_>,
) -> Result<Vec<super::Obstacle>, RobotError> {
    if !object.has_no_shape() {
        return objects::obstacles(object, frames);
    }
    let (own, rest) =
        std::mem::take(&mut world.obstacles).into_iter().partition(|o| o.name == object.id);
    world.obstacles = rest;
    Ok(own)
}

fn add_matrix(matrix: &AllowedCollisionMatrix, layer: &mut Layer) -> Result<(), RobotError> {
    let user = || "allowed_collision_matrix".to_owned();
    let AllowedCollisionMatrix {
        entry_names,
        entry_values,
        default_entry_names,
        default_entry_values,
    } = matrix;
    let counts = [
        (entry_names.len(), entry_values.len()),
        (default_entry_names.len(), default_entry_values.len()),
    ];
    let rows = entry_values.iter().map(|row| (entry_names.len(), row.0.len()));
    for (expected, found) in counts.into_iter().chain(rows) {
        if expected != found {
            return Err(RobotError::Count { what: "entries", user: user(), expected, found });
        }
    }
    each_once("entry", entry_names)?;
    each_once("default entry", default_entry_names)?;
    for (i, row) in entry_values.iter().enumerate() {
        for (j, &value) in row.0.iter().enumerate().skip(i) {
            if entry_values[j].0[i] != value {
                let (a, b) = (&entry_names[i], &entry_names[j]);
                let why = format!("of {a:?} and {b:?} it says both that they may touch and not");
                return Err(RobotError::Refused { user: user(), why });
            }
        }
    }
    let rows: Vec<Vec<bool>> = entry_values.iter().map(|row| row.0.clone()).collect();
    layer.set_matrix(Matrix::new(entry_names.clone(), &rows));
    for (name, &may) in default_entry_names.iter().zip(default_entry_values) {
        layer.set_default(name, may);
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests;
