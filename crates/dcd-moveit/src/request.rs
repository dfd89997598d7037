//! moveit_msgs/MotionPlanRequest and the messages in it.
#![expect(missing_docs, reason = "fields are those of the ROS messages, and documented there")]

use super::scene::{CountUnused, StateMessage, count};
use super::yaml::{Held, Lined};
use serde::Deserialize;

/// moveit_msgs/MotionPlanRequest.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RequestMessage {
    pub start_state: StateMessage,
    #[serde(default)]
    pub goal_constraints: Vec<ConstraintsMessage>,
    workspace_parameters: Option<Lined<Held>>,
    path_constraints: Option<Lined<Held>>,
    trajectory_constraints: Option<Lined<Held>>,
    reference_trajectories: Option<Lined<Held>>,
    // How to plan, which says nothing about what touches.
    group_name: Option<Lined<Held>>,
    planner_id: Option<Lined<Held>>,
    pipeline_id: Option<Lined<Held>>,
    num_planning_attempts: Option<Lined<Held>>,
    allowed_planning_time: Option<Lined<Held>>,
    max_velocity_scaling_factor: Option<Lined<Held>>,
    max_acceleration_scaling_factor: Option<Lined<Held>>,
    cartesian_speed_end_effector_link: Option<Lined<Held>>,
    cartesian_speed_limited_link: Option<Lined<Held>>,
    max_cartesian_speed: Option<Lined<Held>>,
}

impl RequestMessage {
    /// Calls `unused` for each field that holds something and makes no difference.
    pub fn count_unused(&self, unused: &mut CountUnused<'_>) {
        let fields = [
            ("workspace_parameters", &self.workspace_parameters),
            ("path_constraints", &self.path_constraints),
            ("trajectory_constraints", &self.trajectory_constraints),
            ("reference_trajectories", &self.reference_trajectories),
            ("group_name", &self.group_name),
            ("planner_id", &self.planner_id),
            ("pipeline_id", &self.pipeline_id),
            ("num_planning_attempts", &self.num_planning_attempts),
            ("allowed_planning_time", &self.allowed_planning_time),
            ("max_velocity_scaling_factor", &self.max_velocity_scaling_factor),
            ("max_acceleration_scaling_factor", &self.max_acceleration_scaling_factor),
            ("cartesian_speed_end_effector_link", &self.cartesian_speed_end_effector_link),
            ("cartesian_speed_limited_link", &self.cartesian_speed_limited_link),
            ("max_cartesian_speed", &self.max_cartesian_speed),
        ];
        fields.iter().for_each(|(kind, field)| count(unused, kind, field));
        self.start_state.count_unused(unused);
    }
}

/// moveit_msgs/Constraints.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ConstraintsMessage {
    #[serde(rename = "name")]
    _name: Option<Held>,
    pub joint_constraints: Vec<JointConstraintMessage>,
    pub position_constraints: Held,
    pub orientation_constraints: Held,
    pub visibility_constraints: Held,
}

/// moveit_msgs/JointConstraint.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointConstraintMessage {
    pub joint_name: String,
    pub position: f64,
    #[serde(default, rename = "tolerance_above")]
    _tolerance_above: Held,
    #[serde(default, rename = "tolerance_below")]
    _tolerance_below: Held,
    #[serde(default, rename = "weight")]
    _weight: Held,
}
