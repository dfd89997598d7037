//! MoveIt's planning scenes and motion planning requests as YAML.
//!
//! The structs are the ROS messages with every field that they have: a key that is none of them is refused, and
//! what is left out has the value that an empty message has. What a field means for what touches is `dcd-robot`'s
//! matter. A crate of its own, because the structs and their reader take as long to compile as a solver and need none.
//!
//! Deliberately absent: shapes, poses, robots, files.
#![forbid(unsafe_code)]

mod request;
mod scene;
mod words;
mod yaml;

pub use request::{Constraints, JointConstraint, MotionPlanRequest};
pub use scene::{
    AllowedCollisionEntry, AllowedCollisionMatrix, AttachedCollisionObject, CollisionObject,
    Header, JointState, LinkPadding, LinkScale, Mesh, MeshTriangle, MultiDofJointState, Octomap,
    OctomapWithPose, OnUnused, PlanningScene, PlanningSceneWorld, Pose, RobotState, SolidPrimitive,
    Transform, TransformStamped,
};
pub use yaml::{Coordinates, IsSet, ListOrMap, MapKey, NameOrNumber, WithLine};

/// How large a YAML text may be; what goes beyond is refused before memory is taken for it.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// How deep lists and maps may be nested.
    pub nesting: usize,
    /// Names and values, lists and maps, what aliases repeat among them.
    pub nodes: usize,
    /// Aliases, and the anchors that they name.
    pub aliases: usize,
}

/// Reads a moveit_msgs/PlanningScene.
///
/// ```
/// let limits = dcd_moveit::Limits { nesting: 64, nodes: 1000, aliases: 10 };
/// let yaml = "world:\n  collision_objects:\n  - id: wall\n";
/// let world = dcd_moveit::read_scene(yaml, limits)?.world.unwrap_or_default();
/// assert_eq!((world.collision_objects[0].line, world.collision_objects[0].value.id.as_str()), (3, "wall"));
/// assert!(dcd_moveit::read_scene("world: {walls: []}", limits).is_err());
/// # Ok::<(), String>(())
/// ```
///
/// # Errors
/// What is no such YAML, or beyond the limits: a sentence with the line and the column.
pub fn read_scene(yaml: &str, limits: Limits) -> Result<PlanningScene, String> {
    yaml::parse(yaml, limits)
}

/// Reads a moveit_msgs/MotionPlanRequest.
///
/// # Errors
/// As [`read_scene`].
pub fn read_request(yaml: &str, limits: Limits) -> Result<MotionPlanRequest, String> {
    yaml::parse(yaml, limits)
}
