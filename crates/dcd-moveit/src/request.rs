//! moveit_msgs/MotionPlanRequest and the messages in it.
#![expect(missing_docs, reason = "fields are those of the ROS messages, and documented there")]

use super::scene::{OnUnused, RobotState, count};
use super::yaml::{IsSet, WithLine};
use serde::Deserialize;

/// moveit_msgs/MotionPlanRequest.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionPlanRequest {
    pub start_state: RobotState,
    #[serde(default)]
    pub goal_constraints: Vec<Constraints>,
    workspace_parameters: Option<WithLine<IsSet>>,
    path_constraints: Option<WithLine<IsSet>>,
    trajectory_constraints: Option<WithLine<IsSet>>,
    reference_trajectories: Option<WithLine<IsSet>>,
    // How to plan, which says nothing about what touches.
    group_name: Option<WithLine<IsSet>>,
    planner_id: Option<WithLine<IsSet>>,
    pipeline_id: Option<WithLine<IsSet>>,
    num_planning_attempts: Option<WithLine<IsSet>>,
    allowed_planning_time: Option<WithLine<IsSet>>,
    max_velocity_scaling_factor: Option<WithLine<IsSet>>,
    max_acceleration_scaling_factor: Option<WithLine<IsSet>>,
    cartesian_speed_end_effector_link: Option<WithLine<IsSet>>,
    cartesian_speed_limited_link: Option<WithLine<IsSet>>,
    max_cartesian_speed: Option<WithLine<IsSet>>,
}

impl MotionPlanRequest {
    /// Calls `unused` for each field that holds something and makes no difference.
    pub fn for_each_unused(&self, unused: &mut OnUnused<'_>) {
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
        let constraints = self.goal_constraints.iter().flat_map(|goal| &goal.joint_constraints);
        for constraint in constraints {
            count(unused, "tolerances of joint constraints", &constraint.tolerance_above);
            count(unused, "tolerances of joint constraints", &constraint.tolerance_below);
            count(unused, "weights of joint constraints", &constraint.weight);
        }
        self.start_state.for_each_unused(unused);
    }
}

/// moveit_msgs/Constraints.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Constraints {
    #[serde(rename = "name")]
    _name: Option<IsSet>,
    pub joint_constraints: Vec<JointConstraint>,
    pub position_constraints: IsSet,
    pub orientation_constraints: IsSet,
    pub visibility_constraints: IsSet,
}

/// moveit_msgs/JointConstraint.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointConstraint {
    pub joint_name: String,
    pub position: f64,
    tolerance_above: Option<WithLine<IsSet>>,
    tolerance_below: Option<WithLine<IsSet>>,
    weight: Option<WithLine<IsSet>>,
}
