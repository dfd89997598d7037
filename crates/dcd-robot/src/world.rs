//! What stands round a robot: boxes, cylinders and spheres, from MoveIt's scenes.

use super::{AllowedPairs, RobotError};
use dcd_geom::{Pose, Shape, ShapeError};
use glam::{DQuat, DVec3};
use serde::Deserialize;
use std::path::Path;

/// Obstacles, and the pairs that the scene itself allows to touch.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// The obstacles, in the file's order.
    pub obstacles: Vec<Obstacle>,
    /// The pairs of the scene's allowed collision matrix.
    pub allowed: AllowedPairs,
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

#[derive(Deserialize)]
struct Scene {
    allowed_collision_matrix: Option<Matrix>,
    world: Option<Objects>,
}

#[derive(Deserialize)]
struct Matrix {
    #[serde(default)]
    entry_names: Vec<String>,
    #[serde(default)]
    entry_values: Vec<Vec<bool>>,
}

#[derive(Deserialize)]
struct Objects {
    #[serde(default)]
    collision_objects: Vec<CollisionObject>,
}

#[derive(Deserialize)]
struct CollisionObject {
    id: String,
    pose: Option<Place>,
    #[serde(default)]
    primitives: Vec<Primitive>,
    #[serde(default)]
    primitive_poses: Vec<Place>,
    #[serde(default)]
    meshes: Vec<serde::de::IgnoredAny>,
    #[serde(default)]
    planes: Vec<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
struct Primitive {
    #[serde(rename = "type")]
    kind: String,
    dimensions: Vec<f64>,
}

/// A pose as the files write it: lists of numbers, the quaternion x y z w.
#[derive(Deserialize)]
struct Place {
    position: [f64; 3],
    orientation: [f64; 4],
}

impl World {
    /// Reads a scene of MoveIt as YAML: `world.collision_objects` with `primitives` of the types
    /// box (edges x y z), cylinder (height, radius; round its z) and sphere (radius), and the
    /// `allowed_collision_matrix`. A file without a world is an empty one.
    ///
    /// # Errors
    /// What is no such YAML; a type, mesh or plane that is not supported; dimensions, poses or
    /// matrix rows of another number than belong there, or that are refused.
    pub fn read(yaml: &str) -> Result<Self, RobotError> {
        let scene: Scene = super::request::parse("scene", yaml)?;
        let objects = scene.world.map_or_else(Vec::new, |world| world.collision_objects);
        let mut obstacles = Vec::new();
        for object in &objects {
            object.add_to(&mut obstacles)?;
        }
        let mut allowed = AllowedPairs::default();
        if let Some(matrix) = scene.allowed_collision_matrix {
            matrix.add_to(&mut allowed)?;
        }
        Ok(Self { obstacles, allowed })
    }

    /// [`World::read`] from a file.
    ///
    /// # Errors
    /// Those of [`World::read`], and those of reading the file, both with its path.
    pub fn load(path: &Path) -> Result<Self, RobotError> {
        let text = std::fs::read_to_string(path).map_err(RobotError::io(path))?;
        Self::read(&text).map_err(|error| error.inside(path))
    }
}

impl CollisionObject {
    fn add_to(&self, obstacles: &mut Vec<Obstacle>) -> Result<(), RobotError> {
        let user = format!("object {:?}", self.id);
        for (kind, list) in [("meshes", &self.meshes), ("planes", &self.planes)] {
            if !list.is_empty() {
                let kind = kind.to_owned();
                return Err(RobotError::Unsupported { what: "shape", kind, user });
            }
        }
        let (expected, found) = (self.primitives.len(), self.primitive_poses.len());
        if expected != found {
            return Err(RobotError::Count { what: "primitive poses", user, expected, found });
        }
        for (primitive, place) in self.primitives.iter().zip(&self.primitive_poses) {
            let refused = |error| RobotError::Pose { user: user.clone(), error };
            let own = place.checked().map_err(refused)?;
            let pose = match &self.pose {
                None => own,
                Some(outer) => {
                    composed(&outer.checked().map_err(refused)?, &own).map_err(refused)?
                }
            };
            let shape = primitive.shape(&user)?;
            obstacles.push(Obstacle { name: self.id.clone(), shape, pose });
        }
        Ok(())
    }
}

impl Primitive {
    fn shape(&self, user: &str) -> Result<Shape, RobotError> {
        let shape = match (self.kind.as_str(), &self.dimensions[..]) {
            ("box", &[x, y, z]) => Shape::cuboid(DVec3::new(x, y, z) * 0.5),
            ("cylinder", &[height, radius]) => cylinder(height, radius),
            ("sphere", &[radius]) => Shape::sphere(radius),
            ("box" | "cylinder" | "sphere", dimensions) => {
                let expected = match self.kind.as_str() {
                    "box" => 3,
                    "cylinder" => 2,
                    _ => 1,
                };
                return Err(RobotError::Count {
                    what: "dimensions",
                    user: format!("{user}: {}", self.kind),
                    expected,
                    found: dimensions.len(),
                });
            }
            (kind, _) => {
                let (kind, user) = (kind.to_owned(), user.to_owned());
                return Err(RobotError::Unsupported { what: "shape", kind, user });
            }
        };
        shape.map_err(|error| RobotError::Shape { user: user.to_owned(), error })
    }
}

impl Place {
    fn checked(&self) -> Result<Pose, dcd_geom::PoseError> {
        Pose::new(DQuat::from_array(self.orientation), DVec3::from_array(self.position))
    }
}

fn composed(outer: &Pose, inner: &Pose) -> Result<Pose, dcd_geom::PoseError> {
    let rotation = *outer.rotation() * *inner.rotation();
    Pose::from_matrix(rotation, outer.apply(inner.translation()))
}

impl Matrix {
    fn add_to(self, allowed: &mut AllowedPairs) -> Result<(), RobotError> {
        let count = |found| RobotError::Count {
            what: "entries",
            user: "allowed_collision_matrix".to_owned(),
            expected: self.entry_names.len(),
            found,
        };
        if self.entry_values.len() != self.entry_names.len() {
            return Err(count(self.entry_values.len()));
        }
        for (name, row) in self.entry_names.iter().zip(&self.entry_values) {
            if row.len() != self.entry_names.len() {
                return Err(count(row.len()));
            }
            let others = self.entry_names.iter().zip(row).filter(|(_, allowed)| **allowed);
            others.for_each(|(other, _)| allowed.allow(name, other));
        }
        Ok(())
    }
}

/// A cylinder round its z axis.
pub(super) fn cylinder(height: f64, radius: f64) -> Result<Shape, ShapeError> {
    Shape::cylinder(height * 0.5, radius)
}

/// A capsule round its z axis; its height is that of the cylinder between its balls.
pub(super) fn capsule(height: f64, radius: f64) -> Result<Shape, ShapeError> {
    Shape::capsule(height * 0.5, radius)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scenes_boxes_cylinders_and_spheres_are_read_with_their_poses() {
        let world = World::read(
            "world:
  collision_objects:
    - id: table
      primitives:
        - {type: box, dimensions: [2, 4, 6]}
        - {type: sphere, dimensions: [0.5]}
      primitive_poses:
        - {position: [1, 2, 3], orientation: [0, 0, 0, 1]}
        - {position: [0, 0, 1], orientation: [0, 0, 1, 0]}
    - id: can
      pose: {position: [0, 0, 5], orientation: [0, 0, 0.7071067811865476, 0.7071067811865476]}
      primitives: [{type: cylinder, dimensions: [0.4, 0.1]}]
      primitive_poses: [{position: [1, 0, 0], orientation: [0, 0, 0, 1]}]
allowed_collision_matrix:
  entry_names: [table, hand]
  entry_values: [[false, true], [true, false]]
",
        )
        .unwrap();
        let names: Vec<&str> = world.obstacles.iter().map(|o| o.name.as_str()).collect();
        assert_eq!(names, ["table", "table", "can"]);
        let [table, ball, can] = &world.obstacles[..] else { unreachable!() };
        let boxed = table.shape.aabb(&table.pose);
        assert!(boxed.min.z <= 0.0 && boxed.min.z > -1e-5 && boxed.max.y < 4.00001);
        assert_eq!(ball.pose.translation(), DVec3::Z);
        assert!(can.pose.translation().distance(DVec3::new(0.0, 1.0, 5.0)) < 1e-15);
        let boxed = can.shape.aabb(&can.pose);
        assert!((boxed.max.z - 5.2).abs() < 1e-5 && (boxed.max.x - 0.1).abs() < 1e-5);
        assert!(world.allowed.contains("hand", "table") && !world.allowed.contains("can", "hand"));
    }

    #[test]
    fn what_is_wrong_in_a_scene_is_named() {
        let scene = |primitive: &str, pose: &str| {
            let text = format!(
                "world: {{collision_objects: [{{id: can, primitives: [{primitive}], \
                 primitive_poses: [{pose}]}}]}}"
            );
            World::read(&text).unwrap_err().to_string()
        };
        let here = "{position: [0, 0, 0], orientation: [0, 0, 0, 1]}";
        for (primitive, pose, why) in [
            ("{type: box, dimensions: [1, 2]}", here, "\"can\": box: 2 dimensions, not 3"),
            ("{type: torus, dimensions: [1, 2]}", here, "shape \"torus\" is not supported"),
            ("{type: sphere, dimensions: [-1]}", here, "\"can\": the radius is -1"),
            ("{type: sphere, dimensions: [.nan]}", here, "the radius is NaN"),
            ("{type: sphere, dimensions: [1]}", "", "0 primitive poses, not 1"),
            (
                "{type: sphere, dimensions: [1]}",
                "{position: [0, 0, 0], orientation: [0, 0, 0, 0]}",
                "|q|² = 0",
            ),
            ("{type: sphere, dimensions: [one]}", here, "no scene"),
        ] {
            let refused = scene(primitive, pose);
            assert!(refused.contains(why), "{why:?} is not in {refused:?}");
        }
        let rows = World::read(
            "allowed_collision_matrix: {entry_names: [a, b], entry_values: [[false, true]]}",
        );
        assert!(rows.unwrap_err().to_string().contains("1 entries, not 2"));
        let mesh = "world: {collision_objects: [{id: cup, meshes: [{}]}]}";
        assert!(World::read(mesh).unwrap_err().to_string().contains("meshes"));
    }

    #[test]
    fn a_file_without_a_world_is_an_empty_one() {
        assert!(World::read("{}").unwrap().obstacles.is_empty());
    }
}
