//! The frames that a scene may name.

use super::kinematics::JointFrame;
use super::{Robot, RobotError, Srdf};
use dcd_geom::Pose;
use dcd_moveit::{Transform, TransformStamped, WithLine};
use glam::{DQuat, DVec3};
use std::collections::HashMap;

/// By how much two statements of one frame may differ, for an entry of R without a unit, for t in
/// metres: they are printed with some ten digits. Larger: a contradiction passes.
const SAME_FRAME: f64 = 1e-9;

/// Where frames are in the world: the robot's links at one state, what the virtual joint stands in,
/// and what a scene fixes.
pub(super) struct Frames<'a> {
    /// What the robot's root stands in, if the SRDF names it.
    model: Option<&'a str>,
    links: HashMap<&'a str, JointFrame>,
    fixed: HashMap<String, JointFrame>,
}

impl<'a> Frames<'a> {
    pub(super) fn of(
        robot: &'a Robot,
        srdf: Option<&'a Srdf>,
        state: &[f64],
    ) -> Result<Self, RobotError> {
        let placed = robot.link_frames(state)?;
        let links = robot.links().iter().map(|link| link.name.as_str()).zip(placed).collect();
        let joint = srdf.and_then(|srdf| srdf.virtual_joint.as_ref());
        Ok(Self { model: joint.map(|joint| joint.parent.as_str()), links, fixed: HashMap::new() })
    }

    /// The frame of that name, of which `user` speaks.
    pub(super) fn find(&self, name: &str, user: &str) -> Result<JointFrame, RobotError> {
        self.known(name).ok_or_else(|| RobotError::Unknown {
            what: "frame",
            name: name.to_owned(),
            user: user.to_owned(),
        })
    }

    fn known(&self, name: &str) -> Option<JointFrame> {
        let name = name.strip_prefix('/').unwrap_or(name);
        if name.is_empty() || Some(name) == self.model {
            return Some(JointFrame::IDENTITY);
        }
        self.links.get(name).or_else(|| self.fixed.get(name)).copied()
    }

    /// Where the link is, if there is one of that name.
    pub(super) fn link(&self, name: &str) -> Option<JointFrame> {
        self.links.get(name).copied()
    }

    /// Takes in a transform that a scene fixes. One that says of a known frame that it is elsewhere
    /// is refused.
    pub(super) fn fix(&mut self, said: &WithLine<TransformStamped>) -> Result<(), RobotError> {
        let TransformStamped { header, child_frame_id, transform } = &said.value;
        let user = format!("fixed frame {child_frame_id:?}");
        let place = || {
            let outer = self.find(&header.frame_id, &user)?;
            Ok(outer.then(&frame_of(transform, &user)?))
        };
        let frame = place().map_err(|error: RobotError| error.at_line(said.line))?;
        match self.known(child_frame_id) {
            Some(known) if !same(&known, &frame) => {
                let why = "it is a frame that is known, and elsewhere".to_owned();
                Err(RobotError::Refused { user, why }.at_line(said.line))
            }
            Some(_) => Ok(()),
            None => {
                let name = child_frame_id.strip_prefix('/').unwrap_or(child_frame_id);
                self.fixed.insert(name.to_owned(), frame);
                Ok(())
            }
        }
    }
}

fn same(a: &JointFrame, b: &JointFrame) -> bool {
    let entries = |frame: &JointFrame| frame.rotation.to_cols_array();
    let near = |(a, b): (f64, f64)| (a - b).abs() <= SAME_FRAME;
    a.translation.distance(b.translation) <= SAME_FRAME
        && entries(a).into_iter().zip(entries(b)).all(near)
}

/// A transform as a frame, with its numbers checked.
pub(super) fn frame_of(transform: &Transform, user: &str) -> Result<JointFrame, RobotError> {
    let Transform { translation, rotation } = transform;
    let pose = Pose::new(DQuat::from_array(rotation.0), DVec3::from_array(translation.0));
    let pose = pose.map_err(|error| RobotError::Pose { user: user.to_owned(), error })?;
    Ok(JointFrame::of_pose(&pose))
}
