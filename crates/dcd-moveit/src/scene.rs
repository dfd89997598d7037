//! moveit_msgs/PlanningScene and the messages in it.
#![expect(missing_docs, reason = "fields are those of the ROS messages, and documented there")]

use super::yaml::{Coordinates, IsSet, ListOrMap, MapKey, NameOrNumber, WithLine};
use serde::Deserialize;

/// moveit_msgs/PlanningScene.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanningScene {
    #[serde(rename = "name")]
    _name: Option<IsSet>,
    pub robot_model_name: String,
    pub robot_state: RobotState,
    pub fixed_frame_transforms: Vec<WithLine<TransformStamped>>,
    pub allowed_collision_matrix: Option<WithLine<AllowedCollisionMatrix>>,
    pub link_padding: Vec<WithLine<LinkPadding>>,
    pub link_scale: Vec<WithLine<LinkScale>>,
    pub object_colors: Option<WithLine<IsSet>>,
    pub world: Option<PlanningSceneWorld>,
    pub is_diff: bool,
}

/// moveit_msgs/PlanningSceneWorld.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanningSceneWorld {
    pub collision_objects: Vec<WithLine<CollisionObject>>,
    pub octomap: Option<WithLine<OctomapWithPose>>,
}

/// octomap_msgs/OctomapWithPose.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OctomapWithPose {
    pub header: Header,
    #[serde(rename = "origin")]
    _origin: IsSet,
    pub octomap: Octomap,
}

/// octomap_msgs/Octomap.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Octomap {
    #[serde(rename = "header")]
    _header: Header,
    #[serde(rename = "binary")]
    _binary: bool,
    #[serde(rename = "id")]
    _id: String,
    #[serde(rename = "resolution")]
    _resolution: f64,
    pub data: IsSet,
}

/// std_msgs/Header.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Header {
    #[serde(rename = "seq")]
    _seq: u64,
    #[serde(rename = "stamp")]
    _revision: IsSet,
    pub frame_id: String,
}

/// moveit_msgs/RobotState.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RobotState {
    pub joint_state: WithLine<JointState>,
    pub multi_dof_joint_state: WithLine<MultiDofJointState>,
    pub attached_collision_objects: Vec<WithLine<AttachedCollisionObject>>,
    pub is_diff: bool,
}

/// sensor_msgs/JointState.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointState {
    #[serde(rename = "header")]
    _header: Header,
    pub name: Vec<String>,
    pub position: Vec<f64>,
    pub velocity: Option<WithLine<IsSet>>,
    pub effort: Option<WithLine<IsSet>>,
}

/// sensor_msgs/MultiDOFJointState.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MultiDofJointState {
    pub header: Header,
    pub joint_names: Vec<String>,
    pub transforms: Vec<Transform>,
    pub twist: Option<WithLine<IsSet>>,
    pub wrench: Option<WithLine<IsSet>>,
}

/// geometry_msgs/Transform.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Transform {
    pub translation: Coordinates<3>,
    pub rotation: Coordinates<4>,
}

/// geometry_msgs/TransformStamped.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransformStamped {
    #[serde(default)]
    pub header: Header,
    pub child_frame_id: String,
    pub transform: Transform,
}

/// geometry_msgs/Pose.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    pub position: Coordinates<3>,
    pub orientation: Coordinates<4>,
}

/// moveit_msgs/AllowedCollisionMatrix.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AllowedCollisionMatrix {
    pub entry_names: Vec<String>,
    pub entry_values: Vec<ListOrMap<bool, AllowedCollisionEntry>>,
    pub default_entry_names: Vec<String>,
    pub default_entry_values: Vec<bool>,
}

/// moveit_msgs/AllowedCollisionEntry.
#[derive(Clone, Debug)]
pub struct AllowedCollisionEntry;

impl MapKey for AllowedCollisionEntry {
    const KEY: &'static str = "enabled";
}

/// moveit_msgs/LinkPadding.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkPadding {
    pub link_name: String,
    pub padding: f64,
}

/// moveit_msgs/LinkScale.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkScale {
    pub link_name: String,
    pub scale: f64,
}

/// moveit_msgs/AttachedCollisionObject.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttachedCollisionObject {
    pub link_name: String,
    pub object: CollisionObject,
    #[serde(default)]
    pub touch_links: Vec<String>,
    pub detach_posture: Option<WithLine<IsSet>>,
    pub weight: Option<WithLine<IsSet>>,
}

/// moveit_msgs/CollisionObject.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CollisionObject {
    pub header: Header,
    pub pose: Option<Pose>,
    pub id: String,
    #[serde(rename = "type")]
    pub of_type: Option<WithLine<IsSet>>,
    pub primitives: Vec<SolidPrimitive>,
    pub primitive_poses: Vec<Pose>,
    pub meshes: Vec<Mesh>,
    pub mesh_poses: Vec<Pose>,
    pub planes: Vec<IsSet>,
    #[serde(rename = "plane_poses")]
    _plane_poses: Vec<IsSet>,
    pub subframe_names: Option<WithLine<IsSet>>,
    #[serde(rename = "subframe_poses")]
    _subframe_poses: Vec<IsSet>,
    pub operation: NameOrNumber,
}

/// shape_msgs/SolidPrimitive.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolidPrimitive {
    #[serde(rename = "type")]
    pub kind: NameOrNumber,
    pub dimensions: Vec<f64>,
    /// Of a prism alone.
    #[serde(default, rename = "polygon")]
    _polygon: IsSet,
}

/// shape_msgs/Mesh.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    pub triangles: Vec<ListOrMap<u32, MeshTriangle>>,
    pub vertices: Vec<Coordinates<3>>,
}

/// shape_msgs/MeshTriangle.
#[derive(Clone, Debug)]
pub struct MeshTriangle;

impl MapKey for MeshTriangle {
    const KEY: &'static str = "vertex_indices";
}

/// Called with the kind and the line of a field that holds something and makes no difference to what touches.
pub type OnUnused<'a> = dyn FnMut(&str, usize) + 'a;

pub(crate) fn count(unused: &mut OnUnused<'_>, kind: &str, field: &Option<WithLine<IsSet>>) {
    if let Some(field) = field.as_ref().filter(|field| field.value.0) {
        unused(kind, field.line);
    }
}

impl PlanningScene {
    /// Calls `unused` for each field that holds something and makes no difference.
    pub fn for_each_unused(&self, unused: &mut OnUnused<'_>) {
        count(unused, "object_colors", &self.object_colors);
        self.robot_state.for_each_unused(unused);
        let objects = self.world.iter().flat_map(|world| &world.collision_objects);
        objects.for_each(|object| object.value.for_each_unused(unused));
    }
}

impl RobotState {
    pub(crate) fn for_each_unused(&self, unused: &mut OnUnused<'_>) {
        let (joints, multi_dof) = (&self.joint_state.value, &self.multi_dof_joint_state.value);
        count(unused, "joint velocities", &joints.velocity);
        count(unused, "joint efforts", &joints.effort);
        count(unused, "twists", &multi_dof.twist);
        count(unused, "wrenches", &multi_dof.wrench);
        for attached in &self.attached_collision_objects {
            count(unused, "detach_posture", &attached.value.detach_posture);
            count(unused, "weight", &attached.value.weight);
            attached.value.object.for_each_unused(unused);
        }
    }
}

impl CollisionObject {
    /// Whether it has no shape at all.
    pub fn has_no_shape(&self) -> bool {
        self.primitives.is_empty() && self.meshes.is_empty() && self.planes.is_empty()
    }

    fn for_each_unused(&self, unused: &mut OnUnused<'_>) {
        count(unused, "object type", &self.of_type);
        count(unused, "subframes", &self.subframe_names);
    }
}
