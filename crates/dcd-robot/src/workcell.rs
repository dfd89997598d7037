//! A robot and its world as one scene.

mod obstacles;
mod pairs;

use super::kinematics::JointFrame;
use super::model::Part;
use super::{AllowedPairs, Obstacle, Padding, Robot, RobotError, World};
use dcd_geom::{Filter, Object, Pair, Pose, Scene, Shape};
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

/// A robot in a world: a checked scene whose first objects are the robot's parts, in their order,
/// what it carries behind its links; then the world's obstacles, which stand still; then, for each
/// part that the world alone pads, the padded one, which meets obstacles alone while the part itself meets
/// the robot alone.
///
/// Pairs that may touch are no candidates, nor are two parts of one link.
///
/// ```
/// use dcd_robot::{AllowedPairs, Robot, Workcell, World};
/// use std::path::Path;
/// let guide = Path::new("../../docs/guide/arm"); // the guide's arm and its shelf
/// let robot = Robot::load(&guide.join("arm_description/urdf/arm.urdf"))?;
/// use dcd_pipeline::prelude::*;
/// let world = World::load(&guide.join("shelf.yaml"), &robot, None)?;
/// let allowed = AllowedPairs::adjacent(&robot);
/// let mut cell = Workcell::new(robot, &world, &allowed)?;
/// cell.set_state(&[0.0, 0.935, 1.289, -0.654, 0.0])?; // closes the fingers on the can
/// let mut pipeline = Pipeline::new();
/// let contacts: Vec<_> = pipeline.step(cell.scene(), Par::Serial).contacts().collect();
/// let names: Vec<_> = contacts.iter().map(|&pair| cell.names_of(pair)).collect();
/// assert!(names.contains(&["left_finger", "can"]), "{names:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Workcell {
    robot: Arc<Robot>,
    scene: Scene,
    /// For each object the name of its link or obstacle.
    names: Vec<String>,
    poses: Vec<Pose>,
    /// For each padded object its part.
    padded: Vec<usize>,
    first_padded: usize,
    known: Arc<KnownNames>,
    /// Whether an allowed pair, or a default, speaks of an obstacle that there is.
    obstacles_named: bool,
}

/// The names that an obstacle may not have, or of which allowed pairs speak.
#[derive(Debug)]
struct KnownNames {
    allowed: AllowedPairs,
    /// For each name whether the robot has it.
    names: OnceLock<Names>,
    /// Whether a default speaks of every obstacle.
    all: bool,
}

/// Who meets whom where links are padded.
const LINK: u32 = 1;
const OBSTACLE: u32 = 2;
const PADDED: u32 = 4;

impl Workcell {
    /// With all joint values 0. What the world says of the robot's base, of what it carries and of
    /// padding holds; its allowed pairs count where `allowed` was extended by them. The robot is shared between cells
    /// that are made of clones of one [`Arc`] where the world leaves it as it is.
    ///
    /// # Errors
    /// A scene that is out of range; a link, an obstacle or a carried object of one name; a carried
    /// object whose link the robot does not have; more allowed pairs than
    /// [`ALLOWED_PAIRS`](super::bounds::ALLOWED_PAIRS).
    pub fn new(
        robot: impl Into<Arc<Robot>>,
        world: &World,
        allowed: &AllowedPairs,
    ) -> Result<Self, RobotError> {
        let mut robot = robot.into();
        if !world.leaves(&robot) {
            robot = Arc::new(Arc::unwrap_or_clone(robot).equipped(world)?);
        }
        let mut poses = Vec::new();
        robot.place(&robot.rest_state(), &mut poses)?;
        let larger = padded(&robot, world)?;
        let known = Arc::new(KnownNames::of(allowed.clone().of_robot(&robot)));
        Self::assemble((robot, poses), &world.obstacles, larger, known)
    }

    /// Of the robot's parts at these poses, and of those that are padded with their shapes.
    fn assemble(
        (robot, poses): (Arc<Robot>, Vec<Pose>),
        obstacles: &[Obstacle],
        (padded, larger): (Vec<usize>, Vec<Shape>),
        known: Arc<KnownNames>,
    ) -> Result<Self, RobotError> {
        let mut names: Vec<String> =
            robot.parts().iter().map(|part| robot.name_of(part).to_owned()).collect();
        if let Some(same) =
            obstacles.iter().find(|obstacle| known.get(&robot, &obstacle.name) == Some(true))
        {
            return Err(robot.has_name(&same.name));
        }
        let obstacles_named = known.all
            || obstacles.iter().any(|obstacle| known.get(&robot, &obstacle.name).is_some());
        names.extend(obstacles.iter().map(|obstacle| obstacle.name.clone()));
        let first_padded = names.len();
        let of_padded: Vec<String> = padded.iter().map(|&part| names[part].clone()).collect();
        names.extend(of_padded);
        let objects = objects(&poses, obstacles, &padded);
        let shapes = robot.parts().iter().map(|part| part.shape.clone());
        let shapes = shapes.chain(obstacles.iter().map(|o| o.shape.clone())).chain(larger);
        let made = Scene::new(shapes.collect(), objects);
        let user = |object: usize| {
            let part = object.checked_sub(first_padded).map_or(object, |k| padded[k]);
            user_of(&robot, part, || &names[part])
        };
        let mut scene = made.map_err(|error| RobotError::of_scene(error, user))?;
        let places = robot.parts().len()..first_padded;
        pairs::ignore(&mut scene, &names, places, &known.allowed)?;
        Ok(Self { robot, scene, names, poses, padded, first_padded, known, obstacles_named })
    }

    /// Moves the robot to a state: see [`Robot::place`].
    ///
    /// # Errors
    /// Those of [`Robot::place`]; a part out of range. Nothing is moved then.
    pub fn set_state(&mut self, state: &[f64]) -> Result<(), RobotError> {
        let mut poses = std::mem::take(&mut self.poses);
        let moved = self.robot.place(state, &mut poses).and_then(|()| self.set_poses(&poses));
        self.poses = poses;
        moved
    }

    /// Moves the robot's parts to these poses, one for each, as [`Robot::place`] gives them.
    ///
    /// # Errors
    /// Another number of poses than of parts; a part out of range. Nothing is moved then.
    pub fn set_poses(&mut self, poses: &[Pose]) -> Result<(), RobotError> {
        let (expected, found) = (self.robot.parts().len(), poses.len());
        if expected != found {
            let user = format!("robot {:?}", self.robot.name);
            return Err(RobotError::Count { what: "poses", user, expected, found });
        }
        let padded = (self.first_padded..).zip(&self.padded).map(|(i, &part)| (i, poses[part]));
        let all = poses.iter().copied().enumerate().chain(padded);
        let mut before = Vec::with_capacity(poses.len() + self.padded.len());
        for (i, pose) in all {
            before.push((i, self.scene.poses()[i]));
            if let Err(error) = self.scene.set_pose(i, pose) {
                // As it was: what a scene has taken before it takes again.
                for (i, pose) in before {
                    self.scene.set_pose(i, pose).ok();
                }
                return Err(RobotError::of_scene(error, |object| self.user(object)));
            }
        }
        Ok(())
    }

    /// An object, for messages.
    pub(super) fn user(&self, object: usize) -> String {
        let part = self.part_of(object).unwrap_or(object);
        user_of(&self.robot, part, || &self.names[object])
    }

    /// The robot, with what it carries.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The scene as it stands.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// For each object of the scene the name of its link or obstacle.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The names of a pair of objects, the robot's first: of a padded link its own.
    ///
    /// # Panics
    /// One of them is not in the scene.
    pub fn names_of(&self, (i, j): (u32, u32)) -> [&str; 2] {
        let (i, j) = (self.unpadded(i), self.unpadded(j));
        [i.min(j), i.max(j)].map(|k| self.names[k].as_str())
    }

    /// A pair in the order of its names.
    pub(super) fn in_order(&self, Pair { i, j }: Pair) -> [u32; 2] {
        if self.unpadded(i) <= self.unpadded(j) { [i, j] } else { [j, i] }
    }

    /// The object that a padded one stands for, or the object itself.
    fn unpadded(&self, object: u32) -> usize {
        let object = object as usize;
        object.checked_sub(self.first_padded).map_or(object, |padded| self.padded[padded])
    }

    /// The part of [`Robot::parts`] that moves an object of the scene; none for an obstacle.
    pub fn part_of(&self, object: usize) -> Option<usize> {
        match object.checked_sub(self.first_padded) {
            Some(padded) => self.padded.get(padded).copied(),
            None => (object < self.robot.parts().len()).then_some(object),
        }
    }

    /// Whether some link is padded: then the last objects are no obstacles.
    pub fn is_padded(&self) -> bool {
        !self.padded.is_empty()
    }
}

impl KnownNames {
    fn of(allowed: AllowedPairs) -> Self {
        let all = allowed.layers().iter().any(|layer| layer.open().next().is_some());
        Self { allowed, names: OnceLock::new(), all }
    }

    /// Whether the robot has a name; `None` for one that nothing is known of.
    fn get(&self, robot: &Robot, name: &str) -> Option<bool> {
        let names = self.names.get_or_init(|| {
            let said =
                self.allowed.layers().iter().flat_map(|layer| layer.names().chain(layer.tied()));
            let said = said.map(|name| (name, false));
            let own = pairs::own_names(robot).into_iter().map(|name| (name, true));
            Names::of(said.chain(own))
        });
        names.get(name)
    }
}

/// Names, each with whether the robot has it.
#[derive(Debug)]
struct Names {
    /// Of which mark there is some name: most that are looked up are not there.
    marks: u128,
    of: HashMap<String, bool>,
}

impl Names {
    /// Of a name that comes twice the last counts.
    fn of<'a>(names: impl Iterator<Item = (&'a str, bool)>) -> Self {
        let of: HashMap<String, bool> = names.map(|(name, own)| (name.to_owned(), own)).collect();
        let marks = of.keys().fold(0, |marks, name| marks | Self::mark(name));
        Self { marks, of }
    }

    fn get(&self, name: &str) -> Option<bool> {
        if self.marks & Self::mark(name) == 0 {
            return None;
        }
        self.of.get(name).copied()
    }

    /// One of 128 bits, by the length and both ends of a name.
    fn mark(name: &str) -> u128 {
        let bytes = name.as_bytes();
        let end = |byte: Option<&u8>| byte.map_or(0, |&byte| usize::from(byte));
        let sum = bytes.len() * 37 + end(bytes.first()) * 5 + end(bytes.last());
        1 << (sum % 128)
    }
}

impl World {
    /// Whether a robot is the same in it: at its own base, carrying nothing, not padded.
    fn leaves(&self, robot: &Robot) -> bool {
        let has_base =
            self.base.as_ref().is_none_or(|base| JointFrame::of_pose(base) == robot.base);
        has_base && self.attached.is_empty() && self.padding.is_empty()
    }
}

impl Robot {
    /// The robot where the world has it, with what it carries there.
    fn equipped(mut self, world: &World) -> Result<Self, RobotError> {
        if let Some(base) = &world.base {
            self.base = JointFrame::of_pose(base);
        }
        let links: HashMap<&str, usize> =
            self.links.iter().map(|link| link.name.as_str()).zip(0..).collect();
        let mut parts = Vec::new();
        let mut known: std::collections::HashSet<&str> = links.keys().copied().collect();
        // A robot of another cell may carry something already.
        known.extend(self.parts.iter().filter_map(|part| part.object.as_deref()));
        for attached in &world.attached {
            let user = format!("attached object {:?}", attached.name);
            let Some(&link) = links.get(&*attached.link) else {
                let (what, name) = ("link", attached.link.clone());
                return Err(RobotError::Unknown { what, name, user });
            };
            if !known.insert(&attached.name) {
                let why = "a link or another attached object has that name too".to_owned();
                return Err(RobotError::Refused { user, why });
            }
            parts.extend(attached.parts.iter().map(|(shape, origin)| Part {
                link,
                shape: shape.clone(),
                object: Some(attached.name.clone()),
                tolerance: 0.0,
                origin: *origin,
            }));
        }
        self.parts.extend(parts);
        self.pad_against_itself(world)?;
        Ok(self)
    }
}

impl Robot {
    /// That an obstacle has a name of the robot's.
    fn has_name(&self, obstacle: &str) -> RobotError {
        let (user, name) = (obstacle_user(obstacle), &self.name);
        let why = format!("a link of robot {name:?}, or what it carries, has that name too");
        RobotError::Refused { user, why }
    }

    /// Makes those parts larger that are so to the robot too.
    fn pad_against_itself(&mut self, world: &World) -> Result<(), RobotError> {
        for part in &mut self.parts {
            let name = &self.links[part.link].name;
            if let Some(padding) = world.padding.get(name).filter(|p| p.against_robot) {
                part.shape = padded_shape(padding, part, name)?;
            }
        }
        Ok(())
    }
}

/// Of a part of a link, or of what the link carries, which is padded as the link is.
fn padded_shape(padding: &Padding, part: &Part, link: &str) -> Result<Shape, RobotError> {
    let user = || match &part.object {
        Some(carried) => format!("attached object {carried:?}"),
        None => format!("link {link:?}"),
    };
    let shape = &part.shape;
    if !padding.suits(shape) {
        let why = "a shape that is known by its support map alone has no scale".to_owned();
        return Err(RobotError::Refused { user: user(), why });
    }
    padding.applied(shape).map_err(|error| RobotError::Shape { user: user(), error })
}

/// The parts that the world alone pads, and their shapes when padded.
fn padded(robot: &Robot, world: &World) -> Result<(Vec<usize>, Vec<Shape>), RobotError> {
    let (mut parts, mut shapes) = (Vec::new(), Vec::new());
    for (index, part) in robot.parts().iter().enumerate() {
        let name = &robot.links()[part.link].name;
        if let Some(padding) = world.padding.get(name).filter(|p| !p.against_robot) {
            parts.push(index);
            shapes.push(padded_shape(padding, part, name)?);
        }
    }
    Ok((parts, shapes))
}

/// A part of the robot, or an obstacle of that name behind them, for messages.
fn user_of<'a>(robot: &Robot, object: usize, obstacle: impl FnOnce() -> &'a String) -> String {
    match robot.parts().get(object) {
        Some(Part { object: Some(carried), .. }) => format!("attached object {carried:?}"),
        Some(part) => format!("link {:?}", robot.links()[part.link].name),
        None => obstacle_user(obstacle()),
    }
}

fn obstacle_user(name: &str) -> String {
    format!("obstacle {name:?}")
}

/// An obstacle where nothing is padded.
fn obstacle_object(shape: u32, pose: Pose) -> Object {
    Object::new(shape, pose).fixed()
}

/// The scene's objects, with filters only where something is padded.
fn objects(poses: &[Pose], obstacles: &[Obstacle], padded: &[usize]) -> Vec<Object> {
    let none = padded.is_empty();
    let filter = |groups, mask| if none { Filter::ALL } else { Filter { groups, mask } };
    let mut objects: Vec<Object> =
        (0..).zip(poses).map(|(s, &pose)| Object::new(s, pose)).collect();
    for object in &mut objects {
        object.filter = filter(LINK, LINK | OBSTACLE);
    }
    for &part in padded {
        objects[part].filter = filter(LINK, LINK);
    }
    let first = poses.len() as u32;
    objects.extend((first..).zip(obstacles).map(|(shape, obstacle)| Object {
        filter: filter(OBSTACLE, LINK | PADDED),
        ..obstacle_object(shape, obstacle.pose)
    }));
    let first = objects.len() as u32;
    objects.extend((first..).zip(padded).map(|(shape, &part)| Object {
        filter: filter(PADDED, OBSTACLE),
        ..Object::new(shape, poses[part])
    }));
    objects
}
