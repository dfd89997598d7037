//! Joints of several values, as joints of one value each with links without shapes between them.

use super::MovedJoint;
use super::kinematics::JointFrame;
use super::urdf::{Described, DescribedJoint, DescribedLink, Kind};
use glam::DVec3;

/// How a joint of several values moves, step by step, with the ends of the steps' names: as MoveIt names values.
const PLANAR: [(Kind, DVec3, &str); 3] = [
    (Kind::Slides, DVec3::X, "x"),
    (Kind::Slides, DVec3::Y, "y"),
    (Kind::Turns, DVec3::Z, "theta"),
];
const FLOATING: [(Kind, DVec3, &str); 4] = [
    (Kind::Slides, DVec3::X, "trans_x"),
    (Kind::Slides, DVec3::Y, "trans_y"),
    (Kind::Slides, DVec3::Z, "trans_z"),
    (Kind::Orients, DVec3::X, "rot"),
];

/// The same robot with joints of one value, or of one quaternion.
pub(super) fn expanded(mut read: Described) -> Described {
    let joints = std::mem::take(&mut read.joints);
    let mut values = 0;
    for joint in joints {
        let (steps, count): (&[_], _) = match joint.kind {
            Kind::Planar => (&PLANAR, 3),
            Kind::Floating => (&FLOATING, 7),
            Kind::Fixed => (&[], 0),
            _ => (&[], usize::from(joint.mimic.is_none())),
        };
        if count > 0 {
            let name = joint.name.clone();
            read.moved_joints.push(MovedJoint { name, values: values..values + count });
            values += count;
        }
        if steps.is_empty() {
            read.joints.push(joint);
        } else {
            expand(joint, steps, &mut read);
        }
    }
    read
}

fn expand(joint: DescribedJoint, steps: &[(Kind, DVec3, &str)], read: &mut Described) {
    let (mut parent, mut origin) = (joint.parent, joint.origin);
    for (k, &(kind, axis, end)) in steps.iter().enumerate() {
        let name = format!("{}/{end}", joint.name);
        let child = if k + 1 == steps.len() {
            joint.child.clone()
        } else {
            let link =
                DescribedLink { name: name.clone(), line: joint.line, collisions: Vec::new() };
            read.links.push(link);
            name.clone()
        };
        read.joints.push(DescribedJoint {
            name,
            line: joint.line,
            kind,
            parent,
            child: child.clone(),
            origin,
            axis,
            mimic: None,
            limits: None,
        });
        (parent, origin) = (child, JointFrame::IDENTITY);
    }
}
