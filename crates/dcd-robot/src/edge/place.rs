//! A robot at one t of its path, and how its parts move near it.

use super::path::JointPath;
use super::reach::Lengths;
use super::{EdgeChecker, ROUNDED_UP};
use crate::kinematics::JointFrame;
use crate::{Drive, Motion, RobotError};
use dcd_geom::Pose;
use glam::{DMat3, DVec3};

/// How a link moves: a point p of it by `at_base` + `turn` × (p − base), a unit of t.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Twist {
    pub(super) turn: DVec3,
    pub(super) at_base: DVec3,
}

impl Twist {
    /// As seen from what moves so.
    pub(super) fn from(&self, other: &Self) -> Self {
        Self { turn: self.turn - other.turn, at_base: self.at_base - other.at_base }
    }

    /// The velocity of a point, given from the base.
    #[inline]
    pub(super) fn of(&self, from_base: DVec3) -> DVec3 {
        self.at_base + self.turn.cross(from_base)
    }
}

/// The robot at one t of one path.
#[derive(Default)]
pub(super) struct PlaceOnPath {
    pub(super) t: f64,
    state: Vec<f64>,
    rates: Vec<f64>,
    pub(super) poses: Vec<Pose>,
    frames: Vec<JointFrame>,
    /// Of each link.
    twists: Vec<Twist>,
    /// Of each joint that turns, in the world.
    axes: Vec<DVec3>,
}

impl PlaceOnPath {
    pub(super) fn go_to(
        &mut self,
        checker: &EdgeChecker,
        path: &JointPath,
        t: f64,
    ) -> Result<(), RobotError> {
        if self.t == t && !self.poses.is_empty() {
            return Ok(());
        }
        let robot = checker.robot();
        path.state_at(robot, t, &mut self.state);
        path.rates_at(t, &mut self.rates);
        self.frames = robot.link_frames(&self.state)?;
        robot.pose_parts(&self.frames, &mut self.poses)?;
        self.twists.clear();
        self.twists.resize(robot.links().len(), Twist::default());
        self.axes.clear();
        let base = robot.base.translation;
        for joint in robot.joints() {
            let mut twist = self.twists[joint.parent];
            let frame = &self.frames[joint.child];
            let rate = |by: Drive| self.rates[by.value] * by.factor;
            let turning = |turn: DVec3| Twist {
                turn: twist.turn + turn,
                // About the joint's own place.
                at_base: twist.at_base + (frame.translation - base).cross(turn),
            };
            let mut in_world = DVec3::ZERO;
            match joint.motion {
                Motion::Fixed => {}
                // Its own turn leaves its axis where it is.
                Motion::Turns { axis, by } => {
                    in_world = frame.rotation * axis;
                    twist = turning(in_world * rate(by));
                }
                Motion::Slides { axis, by } => {
                    twist.at_base += frame.rotation * axis * rate(by);
                }
                Motion::Orients { first } => {
                    let rest = self.frames[joint.parent].then(&joint.origin).rotation;
                    twist = turning(rest * path.turn(first));
                }
            }
            self.axes.push(in_world);
            self.twists[joint.child] = twist;
        }
        self.t = t;
        Ok(())
    }

    pub(super) fn twist(&self, link: usize) -> &Twist {
        &self.twists[link]
    }

    pub(super) fn rotation(&self, link: usize) -> &DMat3 {
        &self.frames[link].rotation
    }

    /// Where a link's frame is.
    pub(super) fn place(&self, link: usize) -> DVec3 {
        self.frames[link].translation
    }

    /// How far a point is from the axis of a joint, or from its place where it turns any way.
    fn arm(&self, joint: usize, child: usize, point: DVec3) -> f64 {
        let from = point - self.frames[child].translation;
        let axis = self.axes[joint];
        if axis == DVec3::ZERO { from.length() } else { from.cross(axis).length() }
    }
}

/// The largest speed and acceleration of a part's points within `half` of t to either side, against the frames
/// of the joints of its chain: an entry for each joint, and what comes from that one and those behind it.
#[derive(Clone, Debug, Default)]
pub(super) struct Local {
    pub(super) speed: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
    /// How far any point of it moves in the world.
    pub(super) moved: f64,
}

/// What [`Local`] is computed from, for one part.
pub(super) struct Near<'a> {
    /// Its chain's joints.
    pub(super) joints: &'a [u32],
    pub(super) lengths: &'a Lengths,
    /// For each joint how fast those before it turn together at most, and how fast that changes.
    pub(super) before: &'a [[f64; 2]],
    /// The sphere round it: its middle, and its radius with what the pose is off by.
    pub(super) middle: DVec3,
    pub(super) radius: f64,
    pub(super) twist: Twist,
    pub(super) half: f64,
    /// Whether joints keep their speeds.
    pub(super) is_even: bool,
}

impl Local {
    pub(super) fn set(&mut self, checker: &EdgeChecker, place: &PlaceOnPath, near: &Near<'_>) {
        let Near { joints, lengths, half, .. } = *near;
        let robot = checker.robot();
        let count = joints.len();
        self.speed.clear();
        self.speed.resize(count + 1, 0.0);
        self.acceleration.clear();
        self.acceleration.resize(count + 1, 0.0);
        let mut whole = 0.0;
        for k in (0..count).rev() {
            let index = joints[k] as usize;
            let joint = &robot.joints()[index];
            let (behind, turn) = (self.speed[k + 1], lengths.turn[k]);
            let mut speed = lengths.speed[k];
            if turn > 0.0 && near.radius.is_finite() {
                // Joints behind this one move the point to or from its axis, its own turn does not.
                let arm = place.arm(index, joint.child, near.middle) + near.radius + half * behind;
                speed = speed.min(turn * arm * ROUNDED_UP);
            }
            self.speed[k] = behind + speed;
            self.acceleration[k] =
                self.acceleration[k + 1] + lengths.change[k] + (speed + 2.0 * behind) * turn;
            // The same with how fast the joints before turn together in place of the sum of their turns.
            let [turns, changes] = near.before[k];
            let together = if near.is_even {
                turns.min(place.twist(joint.parent).turn.length() * ROUNDED_UP + half * changes)
            } else {
                turns
            };
            whole += lengths.change[k] + speed * (turn + 2.0 * together);
        }
        self.acceleration[0] = self.acceleration[0].min(whole);
        let base = robot.base.translation;
        let turning = near.radius * near.twist.turn.length();
        let now = near.twist.of(near.middle - base).length() + turning;
        let by_now = half * now * ROUNDED_UP + 0.5 * half * half * self.acceleration[0];
        self.moved = by_now.min(half * self.speed[0]) * ROUNDED_UP;
    }
}
