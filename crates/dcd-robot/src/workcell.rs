//! A robot and its world as one scene.

use super::{AllowedPairs, Robot, RobotError, World};
use dcd_geom::{Object, Pose, Scene};

/// A robot in a world: a checked scene whose first objects are the robot's parts, in their order,
/// the others the world's obstacles, which stand still.
///
/// Pairs that may touch are no candidates, nor are two parts of one link.
#[derive(Clone, Debug)]
pub struct Workcell {
    robot: Robot,
    scene: Scene,
    /// For each object the name of its link or obstacle.
    names: Vec<String>,
    poses: Vec<Pose>,
}

impl Workcell {
    /// With all joint values 0.
    ///
    /// # Errors
    /// A scene that is out of range.
    pub fn new(robot: Robot, world: &World, allowed: &AllowedPairs) -> Result<Self, RobotError> {
        let mut poses = Vec::new();
        robot.place(&vec![0.0; robot.moved_joints().len()], &mut poses)?;
        let parts = robot.parts().iter();
        let obstacles = &world.obstacles;
        let links = parts.clone().map(|part| robot.links()[part.link].name.clone());
        let names = links.chain(obstacles.iter().map(|o| o.name.clone())).collect::<Vec<_>>();
        let shapes = parts.map(|part| part.shape.clone());
        let shapes = shapes.chain(obstacles.iter().map(|o| o.shape.clone())).collect();
        let moving = (0..).zip(&poses).map(|(shape, &pose)| Object::new(shape, pose));
        let first = poses.len() as u32;
        let standing = (first..).zip(obstacles).map(|(s, o)| Object::new(s, o.pose).fixed());
        let mut scene = Scene::new(shapes, moving.chain(standing)).map_err(RobotError::Scene)?;
        for i in 0..poses.len() {
            for j in i + 1..names.len() {
                if names[i] == names[j] || allowed.contains(&names[i], &names[j]) {
                    scene.ignore_pair(i, j).map_err(RobotError::Scene)?;
                }
            }
        }
        Ok(Self { robot, scene, names, poses })
    }

    /// Moves the robot to a state: see [`Robot::place`].
    ///
    /// # Errors
    /// Those of [`Robot::place`]; a part out of range.
    pub fn set_state(&mut self, state: &[f64]) -> Result<(), RobotError> {
        let mut poses = std::mem::take(&mut self.poses);
        let moved = self.robot.place(state, &mut poses).and_then(|()| self.set_poses(&poses));
        self.poses = poses;
        moved
    }

    /// Moves the robot's parts to these poses, one for each, as [`Robot::place`] gives them.
    ///
    /// # Errors
    /// Another number of poses than of parts; a part out of range.
    pub fn set_poses(&mut self, poses: &[Pose]) -> Result<(), RobotError> {
        let (expected, found) = (self.robot.parts().len(), poses.len());
        if expected != found {
            let user = format!("robot {:?}", self.robot.name);
            return Err(RobotError::Count { what: "poses", user, expected, found });
        }
        for (part, &pose) in poses.iter().enumerate() {
            self.scene.set_pose(part, pose).map_err(RobotError::Scene)?;
        }
        Ok(())
    }

    /// The robot.
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
}
