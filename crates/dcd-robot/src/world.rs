//! What stands round a robot, and what a scene sets for the robot in it.

use super::kinematics::JointFrame;
use super::{AllowedPairs, PlanningScene, Robot, RobotError, Srdf, scene_text, xml};
use dcd_geom::{Pose, Shape, ShapeError};
use std::collections::BTreeMap;
use std::path::Path;

/// Obstacles, the pairs that the scene itself allows to touch, and the robot's place in it.
///
/// ```
/// use dcd_robot::{Attached, Robot, World};
/// use std::path::Path;
/// let guide = Path::new("../../docs/guide/arm"); // the guide's arm and its shelf
/// let robot = Robot::load(&guide.join("arm_description/urdf/arm.urdf"))?;
/// use dcd_geom::{Pose, Shape, glam::DVec3};
/// let mut world = World::load(&guide.join("shelf.yaml"), &robot, None)?;
/// // The palm carries a tin between its fingers.
/// let between = Pose::from_translation(DVec3::new(0.0, 0.0, 0.13))?;
/// let tin = Attached::new("tin", "palm", [(Shape::sphere(0.02)?, between)]);
/// world.attach(tin, ["left_finger", "right_finger"]);
/// world.pad(&robot, 0.005)?; // links 5 mm larger to obstacles
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct World {
    /// The obstacles, in the file's order.
    pub obstacles: Vec<Obstacle>,
    /// What the scene's allowed collision matrix and its attached objects allow. Where it lists a
    /// pair it counts more than an SRDF.
    pub allowed: AllowedPairs,
    /// The scene's joint values, by name.
    pub joints: Vec<(String, f64)>,
    /// Where the robot's root stands, if the scene gives it.
    pub base: Option<Pose>,
    /// What the robot carries; [`World::attach`] and [`World::detach`] keep [`World::allowed`] in step.
    pub attached: Vec<Attached>,
    /// Links that are larger to the world, by name.
    pub padding: BTreeMap<String, Padding>,
    /// What the scene contains that is not used, or that a planner would warn of. A sentence each.
    pub notes: Vec<String>,
}

/// A shape of the world.
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// Its name; the shapes of one collision object share theirs.
    pub name: String,
    /// The shape.
    pub shape: Shape,
    /// Where it is.
    pub pose: Pose,
}

/// An object that a link carries: it moves with the link, and touches whatever it is not allowed to.
#[derive(Clone, Debug)]
pub struct Attached {
    /// Its name.
    pub name: String,
    /// The link's name.
    pub link: String,
    /// Its shapes, each with its frame in the link's.
    pub(super) parts: Vec<(Shape, JointFrame)>,
}

impl Attached {
    /// An object of these shapes, each at its pose in the frame of the link that carries it.
    pub fn new(name: &str, link: &str, shapes: impl IntoIterator<Item = (Shape, Pose)>) -> Self {
        let parts = shapes.into_iter().map(|(shape, pose)| (shape, JointFrame::of_pose(&pose)));
        Self { name: name.to_owned(), link: link.to_owned(), parts: parts.collect() }
    }

    /// Its shapes as obstacles, where they are when its link is there (see [`Robot::link_poses`]).
    ///
    /// # Errors
    /// A place that is out of range.
    pub fn obstacles(&self, link: &Pose) -> Result<Vec<Obstacle>, RobotError> {
        let link = JointFrame::of_pose(link);
        let refused = |error| {
            let user = format!("attached object {:?}", self.name);
            RobotError::Pose { user, error }
        };
        let placed = self.parts.iter().map(|(shape, origin)| {
            let pose = link.then(origin).pose().map_err(refused)?;
            Ok(Obstacle { name: self.name.clone(), shape: shape.clone(), pose })
        });
        placed.collect()
    }
}

/// How much larger a link and what it carries are against the world, and against the robot itself where `against_robot` is set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Padding {
    /// What their shapes are multiplied by; above 0.
    pub scale: f64,
    /// What they are grown by on all sides after that, metres; at least 0.
    pub padding: f64,
    /// Whether the robot itself meets the larger link too. A scene of MoveIt pads against the world alone.
    pub against_robot: bool,
}

impl Padding {
    /// As it is.
    pub const NONE: Self = Self { scale: 1.0, padding: 0.0, against_robot: false };
}

impl World {
    /// Reads a scene of MoveIt for a robot: [`PlanningScene::load`], then [`PlanningScene::world`]; of a file whose
    /// name ends in `.scene` the text that MoveIt and RViz save, which holds objects alone.
    ///
    /// # Errors
    /// Those of both, with the path; of a text what is not understood, with its line.
    pub fn load(path: &Path, robot: &Robot, srdf: Option<&Srdf>) -> Result<Self, RobotError> {
        if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("scene")) {
            return scene_text::read(&xml::text_of(path)?).map_err(|error| error.inside(path));
        }
        let world = PlanningScene::load(path)?.world(robot, srdf);
        world.map_err(|error| error.inside(path))
    }

    /// What a user should know of the obstacles.
    pub(super) fn note_obstacles(&mut self) {
        if self.obstacles.is_empty() {
            self.notes.push("there is no obstacle in it".to_owned());
        }
        let shapes = self.obstacles.iter().map(|o| (&o.name, &o.shape));
        let mut surfaces: Vec<&str> =
            shapes.filter(|(_, s)| matches!(s, Shape::Mesh(_))).map(|(name, _)| &**name).collect();
        surfaces.dedup();
        for name in surfaces {
            self.notes.push(format!(
                "object {name:?} is a surface of triangles: what is wholly inside does not touch it"
            ));
        }
    }

    /// Lets a link carry an object, which may touch that link, what else the link carries, and whatever is named
    /// in `touch`. The pairs are added to [`World::allowed`].
    pub fn attach(&mut self, object: Attached, touch: impl IntoIterator<Item = impl AsRef<str>>) {
        // What an earlier object of that name was carried with is elsewhere.
        self.allowed.untie(&object.name);
        self.allowed.carry(&object.name, &object.link);
        touch.into_iter().for_each(|name| self.allowed.allow(&object.name, name.as_ref()));
        self.attached.push(object);
    }

    /// Takes what the robot carries under that name from it, with the pairs that it was allowed to touch by name or as
    /// a part of what its link carries ([`World::allowed`]; the scene's matrix stays); `None`: it carries nothing of that
    /// name. [`Attached::obstacles`] puts it down.
    pub fn detach(&mut self, name: &str) -> Option<Attached> {
        let at = self.attached.iter().position(|attached| attached.name == name)?;
        self.allowed.forget(name);
        Some(self.attached.remove(at))
    }

    /// Makes all links of a robot, and what they carry, larger to the world by so much on all sides, metres, added to the padding
    /// that each has.
    ///
    /// # Errors
    /// A padding that is negative or not finite.
    pub fn pad(&mut self, robot: &Robot, padding: f64) -> Result<(), RobotError> {
        if !(padding >= 0.0 && padding.is_finite()) {
            let user = format!("robot {:?}", robot.name);
            return Err(RobotError::BadNumber { what: "padding", user, value: padding });
        }
        for link in robot.links() {
            let own = self.padding.entry(link.name.clone()).or_insert(Padding::NONE);
            own.padding += padding;
        }
        Ok(())
    }
}

/// A cylinder round its z axis.
pub(super) fn cylinder(height: f64, radius: f64) -> Result<Shape, ShapeError> {
    Shape::cylinder(height * 0.5, radius)
}

/// A capsule round its z axis; its height is that of the cylinder between its spheres.
pub(super) fn capsule(height: f64, radius: f64) -> Result<Shape, ShapeError> {
    Shape::capsule(height * 0.5, radius)
}
