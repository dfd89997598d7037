//! moveit_msgs/PlanningScene and the messages in it.
#![expect(missing_docs, reason = "fields are those of the ROS messages, and documented there")]

use super::yaml::{Held, Key, Lined, Listed, Numbers, Word};
use serde::Deserialize;

/// moveit_msgs/PlanningScene.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneMessage {
    #[serde(rename = "name")]
    _name: Option<Held>,
    pub robot_model_name: String,
    pub robot_state: StateMessage,
    pub fixed_frame_transforms: Vec<Lined<FixedTransform>>,
    pub allowed_collision_matrix: Option<Lined<MatrixMessage>>,
    pub link_padding: Vec<Lined<PaddingMessage>>,
    pub link_scale: Vec<Lined<ScaleMessage>>,
    pub object_colors: Option<Lined<Held>>,
    pub world: Option<WorldMessage>,
    pub is_diff: bool,
}

/// moveit_msgs/PlanningSceneWorld.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WorldMessage {
    pub collision_objects: Vec<Lined<ObjectMessage>>,
    pub octomap: Option<Lined<OctomapMessage>>,
}

/// octomap_msgs/OctomapWithPose.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OctomapMessage {
    pub header: Header,
    #[serde(rename = "origin")]
    _origin: Held,
    pub octomap: Octree,
}

/// octomap_msgs/Octomap.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Octree {
    #[serde(rename = "header")]
    _header: Header,
    #[serde(rename = "binary")]
    _binary: bool,
    #[serde(rename = "id")]
    _id: String,
    #[serde(rename = "resolution")]
    _resolution: f64,
    pub data: Held,
}

/// std_msgs/Header.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Header {
    #[serde(rename = "seq")]
    _seq: u64,
    #[serde(rename = "stamp")]
    _revision: Held,
    pub frame_id: String,
}

/// moveit_msgs/RobotState.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StateMessage {
    pub joint_state: JointState,
    pub multi_dof_joint_state: MultiDofState,
    pub attached_collision_objects: Vec<Lined<AttachedMessage>>,
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
    pub velocity: Option<Lined<Held>>,
    pub effort: Option<Lined<Held>>,
}

/// sensor_msgs/MultiDOFJointState.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MultiDofState {
    pub header: Header,
    pub joint_names: Vec<String>,
    pub transforms: Vec<Transform>,
    pub twist: Option<Lined<Held>>,
    pub wrench: Option<Lined<Held>>,
}

/// geometry_msgs/Transform.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Transform {
    pub translation: Numbers<3>,
    pub rotation: Numbers<4>,
}

/// geometry_msgs/TransformStamped.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedTransform {
    #[serde(default)]
    pub header: Header,
    pub child_frame_id: String,
    pub transform: Transform,
}

/// geometry_msgs/Pose.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    pub position: Numbers<3>,
    pub orientation: Numbers<4>,
}

/// moveit_msgs/AllowedCollisionMatrix.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MatrixMessage {
    pub entry_names: Vec<String>,
    pub entry_values: Vec<Listed<bool, Enabled>>,
    pub default_entry_names: Vec<String>,
    pub default_entry_values: Vec<bool>,
}

/// moveit_msgs/AllowedCollisionEntry.
#[derive(Clone, Debug)]
pub struct Enabled;

impl Key for Enabled {
    const KEY: &'static str = "enabled";
}

/// moveit_msgs/LinkPadding.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaddingMessage {
    pub link_name: String,
    pub padding: f64,
}

/// moveit_msgs/LinkScale.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScaleMessage {
    pub link_name: String,
    pub scale: f64,
}

/// moveit_msgs/AttachedCollisionObject.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttachedMessage {
    pub link_name: String,
    pub object: ObjectMessage,
    #[serde(default)]
    pub touch_links: Vec<String>,
    pub detach_posture: Option<Lined<Held>>,
    pub weight: Option<Lined<Held>>,
}

/// moveit_msgs/CollisionObject.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObjectMessage {
    pub header: Header,
    pub pose: Option<Place>,
    pub id: String,
    #[serde(rename = "type")]
    pub of_type: Option<Lined<Held>>,
    pub primitives: Vec<Primitive>,
    pub primitive_poses: Vec<Place>,
    pub meshes: Vec<MeshMessage>,
    pub mesh_poses: Vec<Place>,
    pub planes: Vec<Held>,
    #[serde(rename = "plane_poses")]
    _plane_poses: Vec<Held>,
    pub subframe_names: Option<Lined<Held>>,
    #[serde(rename = "subframe_poses")]
    _subframe_poses: Vec<Held>,
    pub operation: Word,
}

/// shape_msgs/SolidPrimitive.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Primitive {
    #[serde(rename = "type")]
    pub kind: Word,
    pub dimensions: Vec<f64>,
    /// Of a prism alone.
    #[serde(default, rename = "polygon")]
    _polygon: Held,
}

/// shape_msgs/Mesh.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshMessage {
    pub triangles: Vec<Listed<u32, VertexIndices>>,
    pub vertices: Vec<Numbers<3>>,
}

/// shape_msgs/MeshTriangle.
#[derive(Clone, Debug)]
pub struct VertexIndices;

impl Key for VertexIndices {
    const KEY: &'static str = "vertex_indices";
}

/// Called with the kind and the line of a field that holds something and makes no difference to what touches.
pub type CountUnused<'a> = dyn FnMut(&str, usize) + 'a;

pub(crate) fn count(unused: &mut CountUnused<'_>, kind: &str, field: &Option<Lined<Held>>) {
    if let Some(field) = field.as_ref().filter(|field| field.value.0) {
        unused(kind, field.line);
    }
}

impl SceneMessage {
    /// Calls `unused` for each field that holds something and makes no difference.
    pub fn count_unused(&self, unused: &mut CountUnused<'_>) {
        count(unused, "object_colors", &self.object_colors);
        self.robot_state.count_unused(unused);
        let objects = self.world.iter().flat_map(|world| &world.collision_objects);
        objects.for_each(|object| object.value.count_unused(unused));
    }
}

impl StateMessage {
    pub(crate) fn count_unused(&self, unused: &mut CountUnused<'_>) {
        count(unused, "joint velocities", &self.joint_state.velocity);
        count(unused, "joint efforts", &self.joint_state.effort);
        count(unused, "twists", &self.multi_dof_joint_state.twist);
        count(unused, "wrenches", &self.multi_dof_joint_state.wrench);
        for attached in &self.attached_collision_objects {
            count(unused, "detach_posture", &attached.value.detach_posture);
            count(unused, "weight", &attached.value.weight);
            attached.value.object.count_unused(unused);
        }
    }
}

impl ObjectMessage {
    /// Whether it has no shape at all.
    pub fn is_bare(&self) -> bool {
        self.primitives.is_empty() && self.meshes.is_empty() && self.planes.is_empty()
    }

    fn count_unused(&self, unused: &mut CountUnused<'_>) {
        count(unused, "object type", &self.of_type);
        count(unused, "subframes", &self.subframe_names);
    }
}
