//! Where a robot's shapes are for the values of its joints.

use super::{Joint, Motion, Robot, RobotError};
use dcd_geom::Pose;
use glam::{DMat3, DVec3};

/// A frame in another: a point p of it is at R·p + t there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) rotation: DMat3,
    pub(super) translation: DVec3,
}

impl Frame {
    pub(super) const IDENTITY: Self = Self { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// URDF's: turned about x, then y, then z of the outer frame (roll, pitch, yaw; rad).
    pub(super) fn of_urdf(pose: &urdf_rs::Pose, user: &str) -> Result<Self, RobotError> {
        let numbers = pose.xyz.iter().chain(pose.rpy.iter());
        if let Some(&value) = numbers.clone().find(|x| !x.is_finite()) {
            return Err(RobotError::BadNumber { what: "origin", user: user.to_owned(), value });
        }
        let [roll, pitch, yaw] = *pose.rpy;
        let rotation = turn(DVec3::Z, yaw) * turn(DVec3::Y, pitch) * turn(DVec3::X, roll);
        Ok(Self { rotation, translation: DVec3::from_array(*pose.xyz) })
    }

    /// The frame that `inner` is in this one's outer frame.
    pub(super) fn then(&self, inner: &Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            translation: self.rotation * inner.translation + self.translation,
        }
    }

    fn turned(&self, axis: DVec3, angle: f64) -> Self {
        Self { rotation: self.rotation * turn(axis, angle), ..*self }
    }

    fn slid(&self, along: DVec3) -> Self {
        Self { translation: self.rotation * along + self.translation, ..*self }
    }
}

/// The rotation by an angle about an axis of unit length (Rodrigues): I + sin·K + (1 − cos)·K².
fn turn(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    let DVec3 { x, y, z } = axis;
    let cross =
        DMat3::from_cols(DVec3::new(0.0, z, -y), DVec3::new(-z, 0.0, x), DVec3::new(y, -x, 0.0));
    DMat3::IDENTITY + cross * sin + cross * cross * (1.0 - cos)
}

/// The joints, each behind the one that moves its parent link.
///
/// Refused if some link has two parents, or is on a ring.
pub(super) fn in_order(
    joints: Vec<Joint>,
    links: &[urdf_rs::Link],
) -> Result<Vec<Joint>, RobotError> {
    let refused = |link: usize| RobotError::NotATree { link: links[link].name.clone() };
    let mut is_child = vec![false; links.len()];
    for joint in &joints {
        if std::mem::replace(&mut is_child[joint.child], true) {
            return Err(refused(joint.child));
        }
    }
    let mut known: Vec<bool> = is_child.iter().map(|child| !child).collect();
    let (mut ordered, mut waiting) = (Vec::with_capacity(joints.len()), joints);
    while !waiting.is_empty() {
        let before = waiting.len();
        let (ready, rest): (Vec<_>, Vec<_>) =
            waiting.into_iter().partition(|joint| known[joint.parent]);
        if rest.len() == before {
            return Err(refused(rest[0].child));
        }
        ready.iter().for_each(|joint| known[joint.child] = true);
        ordered.extend(ready);
        waiting = rest;
    }
    Ok(ordered)
}

impl Robot {
    /// Where the parts are for these values of [`Robot::moved_joints`], the root link at the
    /// origin: one pose for each of [`Robot::parts`], in place of what was there.
    ///
    /// Limits are not asked for: a state beyond them has its place too.
    ///
    /// # Errors
    /// Another number of values than of moved joints; a value that is not finite or so large that
    /// a pose is not.
    pub fn place(&self, state: &[f64], poses: &mut Vec<Pose>) -> Result<(), RobotError> {
        self.check_state(state)?;
        let mut frames = vec![Frame::IDENTITY; self.links.len()];
        for joint in &self.joints {
            frames[joint.child] = moved(&frames[joint.parent].then(&joint.origin), joint, state);
        }
        poses.clear();
        for part in &self.parts {
            let Frame { rotation, translation } = frames[part.link].then(&part.origin);
            let pose = Pose::from_matrix(rotation, translation);
            let user = || format!("link {:?}", self.links[part.link].name);
            poses.push(pose.map_err(|error| RobotError::Pose { user: user(), error })?);
        }
        Ok(())
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

    fn check_state(&self, state: &[f64]) -> Result<(), RobotError> {
        let (expected, found) = (self.moved.len(), state.len());
        if expected != found {
            let user = format!("robot {:?}", self.name);
            return Err(RobotError::Count { what: "joint values", user, expected, found });
        }
        match self.moved.iter().zip(state).find(|(_, value)| !value.is_finite()) {
            None => Ok(()),
            Some((joint, &value)) => {
                let user = format!("joint {joint:?}");
                Err(RobotError::BadNumber { what: "value", user, value })
            }
        }
    }
}

/// The child's frame, from the joint's at rest.
fn moved(rest: &Frame, joint: &Joint, state: &[f64]) -> Frame {
    let value = |by: super::model::Drive| state[by.value] * by.factor + by.offset;
    match joint.motion {
        Motion::Fixed => *rest,
        Motion::Turns { axis, by } => rest.turned(axis, value(by)),
        Motion::Slides { axis, by } => rest.slid(axis * value(by)),
    }
}

#[cfg(test)]
mod tests;
