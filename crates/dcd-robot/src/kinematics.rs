//! Where a robot's shapes are for the values of its joints.

use super::{Joint, Link, Motion, Robot, RobotError};
use crate::angle::sin_cos;
use dcd_geom::{Pose, PoseError};
use dcd_gjk::motion::{rotation_from_axis_angle, rotation_from_sin_cos};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::fmt;

/// A frame in another: a point p of it is at R·p + t there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct JointFrame {
    pub(super) rotation: DMat3,
    pub(super) translation: DVec3,
}

impl JointFrame {
    pub(super) const IDENTITY: Self = Self { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// URDF's: turned about x, then y, then z of the outer frame (roll, pitch, yaw; rad).
    pub(super) fn of_angles(translation: DVec3, [roll, pitch, yaw]: [f64; 3]) -> Self {
        let rotation = rotation_from_axis_angle(DVec3::Z, yaw)
            * rotation_from_axis_angle(DVec3::Y, pitch)
            * rotation_from_axis_angle(DVec3::X, roll);
        Self { rotation, translation }
    }

    pub(super) fn of_pose(pose: &Pose) -> Self {
        Self { rotation: *pose.rotation(), translation: pose.translation() }
    }

    pub(super) fn pose(&self) -> Result<Pose, PoseError> {
        Pose::from_matrix(self.rotation, self.translation)
    }

    pub(super) fn affine(&self) -> DAffine3 {
        DAffine3 { matrix3: self.rotation, translation: self.translation }
    }

    /// The outer frame in this one.
    pub(super) fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -(rotation * self.translation) }
    }

    /// The frame that `inner` is in this one's outer frame.
    pub(super) fn then(&self, inner: &Self) -> Self {
        Self {
            rotation: if inner.is_turned() {
                self.rotation * inner.rotation
            } else {
                self.rotation
            },
            translation: self.rotation * inner.translation + self.translation,
        }
    }

    /// Whether its axes are not the outer frame's: most origins' are.
    fn is_turned(&self) -> bool {
        self.rotation != DMat3::IDENTITY
    }

    fn turned(&self, axis: DVec3, angle: f64) -> Self {
        Self { rotation: self.rotation * rotation_from_sin_cos(axis, sin_cos(angle)), ..*self }
    }

    fn slid(&self, along: DVec3) -> Self {
        Self { translation: self.rotation * along + self.translation, ..*self }
    }
}

impl Robot {
    /// Where the parts are for these values of [`Robot::variables`], the root link at the
    /// base pose: one pose for each of [`Robot::parts`], in place of what was there.
    ///
    /// Limits are not checked: a state beyond them has its place too.
    ///
    /// # Errors
    /// Another number of values than of moved joints; a value that is not finite or so large that
    /// a pose is not.
    pub fn place(&self, state: &[f64], poses: &mut Vec<Pose>) -> Result<(), RobotError> {
        self.pose_parts(&self.link_frames(state)?, poses)
    }

    /// Where the links' frames are, as [`Robot::place`] has the parts: one pose for each of [`Robot::links`].
    ///
    /// # Errors
    /// Those of [`Robot::place`].
    pub fn link_poses(&self, state: &[f64]) -> Result<Vec<Pose>, RobotError> {
        let frames = self.link_frames(state)?;
        let refused = |link: &Link| {
            let user = format!("link {:?}", link.name);
            move |error| RobotError::Pose { user, error }
        };
        let poses = self.links.iter().zip(&frames);
        poses.map(|(link, frame)| frame.pose().map_err(refused(link))).collect()
    }

    /// Where the parts are, where each link is.
    pub(super) fn pose_parts(
        &self,
        frames: &[JointFrame],
        poses: &mut Vec<Pose>,
    ) -> Result<(), RobotError> {
        poses.clear();
        let links = &self.links;
        let refused = |link: usize| {
            move |error| RobotError::Pose { user: format!("link {:?}", links[link].name), error }
        };
        // The link of the part before, if that is turned as the link is: then its rotation has been checked.
        let mut last = None;
        for part in &self.parts {
            let (link, placed) = (part.link, frames[part.link].then(&part.origin));
            let as_link = !part.origin.is_turned();
            let pose = match poses.last() {
                Some(before) if as_link && last == Some(link) => {
                    before.with_translation(placed.translation)
                }
                _ => placed.pose(),
            };
            poses.push(pose.map_err(refused(link))?);
            last = as_link.then_some(link);
        }
        Ok(())
    }

    /// Where each link is.
    pub(super) fn link_frames(&self, state: &[f64]) -> Result<Vec<JointFrame>, RobotError> {
        self.check_state(state)?;
        let mut frames = vec![self.base; self.links.len()];
        for joint in &self.joints {
            frames[joint.child] = moved(&frames[joint.parent].then(&joint.origin), joint, state);
        }
        Ok(frames)
    }

    /// The joints that a state moves beyond their limits: a planner would not go there.
    pub fn beyond_limits(&self, state: &[f64]) -> Vec<BeyondLimits<'_>> {
        let beyond = |joint: &'_ Joint| {
            let (limits, by) = (joint.limits?, joint.motion.drive()?);
            let value = by.of(state)?;
            (value < limits[0] || value > limits[1]).then_some((value, limits))
        };
        let found = self.joints.iter().filter_map(|joint| {
            beyond(joint).map(|(value, limits)| BeyondLimits { joint: &joint.name, value, limits })
        });
        found.collect()
    }

    /// For each link the rigid body that it belongs to (links that no joint moves against each other
    /// are one), and the nearest link above it that carries a shape.
    pub(super) fn bodies_and_parents(&self) -> (Vec<usize>, Vec<Option<usize>>) {
        let links = self.links.len();
        let mut has_shape = vec![false; links];
        self.parts.iter().for_each(|part| has_shape[part.link] = true);
        let mut bodies: Vec<usize> = (0..links).collect();
        let mut parents = vec![None; links];
        for joint in &self.joints {
            if joint.motion == Motion::Fixed {
                bodies[joint.child] = bodies[joint.parent];
            }
            let above =
                if has_shape[joint.parent] { Some(joint.parent) } else { parents[joint.parent] };
            parents[joint.child] = above;
        }
        (bodies, parents)
    }

    pub(super) fn check_state(&self, state: &[f64]) -> Result<(), RobotError> {
        let (expected, found) = (self.moved.len(), state.len());
        if expected != found {
            let user = format!("robot {:?}", self.name);
            return Err(RobotError::Count { what: "joint values", user, expected, found });
        }
        if let Some((joint, &value)) =
            self.moved.iter().zip(state).find(|(_, value)| !value.is_finite())
        {
            let user = format!("joint {joint:?}");
            return Err(RobotError::BadNumber { what: "value", user, value });
        }
        for joint in &self.joints {
            let Motion::Orients { first } = joint.motion else { continue };
            let square = quaternion(state, first).length_squared();
            if !((square - 1.0).abs() <= UNIT_QUATERNION) {
                let (what, user) = ("squared length of the quaternion", &joint.name);
                let user = format!("joint {user:?}");
                return Err(RobotError::BadNumber { what, user, value: square });
            }
        }
        Ok(())
    }

    /// The state in which every value is 0, but a quaternion's w, which is 1.
    pub fn rest_state(&self) -> Vec<f64> {
        let mut rest = vec![0.0; self.moved.len()];
        for joint in &self.joints {
            if let Motion::Orients { first } = joint.motion {
                rest[first + 3] = 1.0;
            }
        }
        rest
    }
}

/// How far the squared length of a quaternion may be from 1; within that it is made 1. No unit. Larger:
/// mistakes pass for rounding. Smaller: numbers with six digits are refused.
const UNIT_QUATERNION: f64 = 1e-6;

/// The quaternion x y z w at such a place of a state.
pub(super) fn quaternion(state: &[f64], first: usize) -> DQuat {
    match state.get(first..first + 4) {
        Some(&[x, y, z, w]) => DQuat::from_xyzw(x, y, z, w),
        _ => DQuat::IDENTITY,
    }
}

/// A joint beyond its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeyondLimits<'a> {
    /// Its name.
    pub joint: &'a str,
    /// Its value, rad or metres; of a joint that mimics, what it comes to.
    pub value: f64,
    /// The least and the largest that it may have.
    pub limits: [f64; 2],
}

impl fmt::Display for BeyondLimits<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { joint, value, limits: [lower, upper] } = self;
        write!(f, "joint {joint:?} is at {value:e}, beyond its limits {lower:e} to {upper:e}")
    }
}

/// The child's frame, from the joint's at rest.
pub(super) fn moved(rest: &JointFrame, joint: &Joint, state: &[f64]) -> JointFrame {
    // The state has been counted.
    let value = |by: super::model::Drive| by.of(state).unwrap_or_default();
    match joint.motion {
        Motion::Fixed => *rest,
        Motion::Turns { axis, by } => rest.turned(axis, value(by)),
        Motion::Slides { axis, by } => rest.slid(axis * value(by)),
        Motion::Orients { first } => {
            let turn = DMat3::from_quat(quaternion(state, first).normalize());
            JointFrame { rotation: rest.rotation * turn, ..*rest }
        }
    }
}

#[cfg(test)]
mod tests;
