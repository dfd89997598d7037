//! MoveIt's messages as YAML, with every field that they have: a key that is none of them is refused.
//! What is left out has the value that an empty message has.

use super::notes::Unused;
use super::yaml::{Held, Key, Lined, Listed, Numbers, Word, line_of};
use serde::Deserialize;

/// moveit_msgs/PlanningScene.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct SceneMessage {
    #[serde(rename = "name")]
    pub(super) _name: Option<Held>,
    pub(super) robot_model_name: String,
    pub(super) robot_state: StateMessage,
    pub(super) fixed_frame_transforms: Vec<Lined<FixedTransform>>,
    pub(super) allowed_collision_matrix: Option<Lined<MatrixMessage>>,
    pub(super) link_padding: Vec<Lined<PaddingMessage>>,
    pub(super) link_scale: Vec<Lined<ScaleMessage>>,
    pub(super) object_colors: Option<Lined<Held>>,
    pub(super) world: Option<WorldMessage>,
    pub(super) is_diff: bool,
}

/// moveit_msgs/PlanningSceneWorld.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct WorldMessage {
    pub(super) collision_objects: Vec<Lined<ObjectMessage>>,
    pub(super) octomap: Option<Lined<OctomapMessage>>,
}

/// octomap_msgs/OctomapWithPose.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct OctomapMessage {
    pub(super) header: Header,
    #[serde(rename = "origin")]
    pub(super) _origin: Held,
    pub(super) octomap: Octree,
}

/// octomap_msgs/Octomap.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Octree {
    #[serde(rename = "header")]
    pub(super) _header: Header,
    #[serde(rename = "binary")]
    pub(super) _binary: bool,
    #[serde(rename = "id")]
    pub(super) _id: String,
    #[serde(rename = "resolution")]
    pub(super) _resolution: f64,
    pub(super) data: Held,
}

/// std_msgs/Header.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Header {
    #[serde(rename = "seq")]
    pub(super) _seq: u64,
    #[serde(rename = "stamp")]
    pub(super) _revision: Held,
    pub(super) frame_id: String,
}

/// moveit_msgs/RobotState.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct StateMessage {
    pub(super) joint_state: JointState,
    pub(super) multi_dof_joint_state: MultiDofState,
    pub(super) attached_collision_objects: Vec<Lined<AttachedMessage>>,
    pub(super) is_diff: bool,
}

/// sensor_msgs/JointState.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct JointState {
    #[serde(rename = "header")]
    pub(super) _header: Header,
    pub(super) name: Vec<String>,
    pub(super) position: Vec<f64>,
    pub(super) velocity: Option<Lined<Held>>,
    pub(super) effort: Option<Lined<Held>>,
}

/// sensor_msgs/MultiDOFJointState.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct MultiDofState {
    pub(super) header: Header,
    pub(super) joint_names: Vec<String>,
    pub(super) transforms: Vec<Transform>,
    pub(super) twist: Option<Lined<Held>>,
    pub(super) wrench: Option<Lined<Held>>,
}

/// geometry_msgs/Transform.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Transform {
    pub(super) translation: Numbers<3>,
    pub(super) rotation: Numbers<4>,
}

/// geometry_msgs/TransformStamped.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FixedTransform {
    #[serde(default)]
    pub(super) header: Header,
    pub(super) child_frame_id: String,
    pub(super) transform: Transform,
}

/// geometry_msgs/Pose.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Place {
    pub(super) position: Numbers<3>,
    pub(super) orientation: Numbers<4>,
}

/// moveit_msgs/AllowedCollisionMatrix.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct MatrixMessage {
    pub(super) entry_names: Vec<String>,
    pub(super) entry_values: Vec<Listed<bool, Enabled>>,
    pub(super) default_entry_names: Vec<String>,
    pub(super) default_entry_values: Vec<bool>,
}

/// moveit_msgs/AllowedCollisionEntry.
#[derive(Clone, Debug)]
pub(super) struct Enabled;

impl Key for Enabled {
    const KEY: &'static str = "enabled";
}

/// moveit_msgs/LinkPadding.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PaddingMessage {
    pub(super) link_name: String,
    pub(super) padding: f64,
}

/// moveit_msgs/LinkScale.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScaleMessage {
    pub(super) link_name: String,
    pub(super) scale: f64,
}

/// moveit_msgs/AttachedCollisionObject.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AttachedMessage {
    pub(super) link_name: String,
    pub(super) object: ObjectMessage,
    #[serde(default)]
    pub(super) touch_links: Vec<String>,
    pub(super) detach_posture: Option<Lined<Held>>,
    pub(super) weight: Option<Lined<Held>>,
}

/// moveit_msgs/CollisionObject.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ObjectMessage {
    pub(super) header: Header,
    pub(super) pose: Option<Place>,
    pub(super) id: String,
    #[serde(rename = "type")]
    pub(super) of_type: Option<Lined<Held>>,
    pub(super) primitives: Vec<Primitive>,
    pub(super) primitive_poses: Vec<Place>,
    pub(super) meshes: Vec<MeshMessage>,
    pub(super) mesh_poses: Vec<Place>,
    pub(super) planes: Vec<Held>,
    #[serde(rename = "plane_poses")]
    pub(super) _plane_poses: Vec<Held>,
    pub(super) subframe_names: Option<Lined<Held>>,
    #[serde(rename = "subframe_poses")]
    pub(super) _subframe_poses: Vec<Held>,
    pub(super) operation: Word,
}

/// shape_msgs/SolidPrimitive.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Primitive {
    #[serde(rename = "type")]
    pub(super) kind: Word,
    pub(super) dimensions: Vec<f64>,
    /// Of a prism alone.
    #[serde(default, rename = "polygon")]
    pub(super) _polygon: Held,
}

/// shape_msgs/Mesh.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshMessage {
    pub(super) triangles: Vec<Listed<u32, VertexIndices>>,
    pub(super) vertices: Vec<Numbers<3>>,
}

/// shape_msgs/MeshTriangle.
#[derive(Clone, Debug)]
pub(super) struct VertexIndices;

impl Key for VertexIndices {
    const KEY: &'static str = "vertex_indices";
}

/// Counts a field that holds something and is not used.
pub(super) fn count(unused: &mut Unused, kind: &str, field: &Option<Lined<Held>>) {
    if let Some(field) = field.as_ref().filter(|field| field.value.0) {
        unused.add(kind, line_of(field));
    }
}

impl SceneMessage {
    /// What is known and makes no difference.
    pub(super) fn count_unused(&self, unused: &mut Unused) {
        count(unused, "object_colors", &self.object_colors);
        self.robot_state.count_unused(unused);
        let objects = self.world.iter().flat_map(|world| &world.collision_objects);
        objects.for_each(|object| object.value.count_unused(unused));
    }
}

impl StateMessage {
    /// What is known and makes no difference.
    pub(super) fn count_unused(&self, unused: &mut Unused) {
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
    fn count_unused(&self, unused: &mut Unused) {
        count(unused, "object type", &self.of_type);
        count(unused, "subframes", &self.subframe_names);
    }
}
