//! How joints hang together: in which order links are placed, and which value moves what. All of it
//! in time linear in the number of joints, however long their chains are.

use super::names::Names;
use super::urdf::{DescribedJoint, DescribedLink, Kind};
use super::{Joint, RobotError, model::Drive};

/// The joints, each behind the one that moves its parent link, and the link that has no parent.
pub(super) struct Tree {
    pub(super) joints: Vec<Joint>,
    pub(super) root: usize,
}

/// Orders joints by their distance from the root, those of one distance as they came.
///
/// Refused if there is more than one root, or some link has two parents or is on a ring.
pub(super) fn in_order(
    mut joints: Vec<Joint>,
    links: &[DescribedLink],
) -> Result<Tree, RobotError> {
    let mut is_child = vec![false; links.len()];
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    let not_a_tree = |link: usize| {
        RobotError::NotATree { link: links[link].name.clone() }.at_line(links[link].line)
    };
    for joint in &joints {
        if std::mem::replace(&mut is_child[joint.child], true) {
            return Err(not_a_tree(joint.child));
        }
        below[joint.parent].push(joint.child);
    }
    let mut roots = (0..links.len()).filter(|&link| !is_child[link]);
    let root = match (roots.next(), roots.next()) {
        (Some(root), None) => root,
        (Some(a), Some(b)) => {
            let roots = [a, b].map(|link| links[link].name.clone());
            return Err(RobotError::Forest { roots }.at_line(links[b].line));
        }
        // Without a root every link is on a ring, if there is one at all.
        (None, _) if links.is_empty() => return Ok(Tree { joints, root: 0 }),
        (None, _) => return Err(not_a_tree(0)),
    };
    let mut distance = vec![usize::MAX; links.len()];
    distance[root] = 0;
    let mut reached = vec![root];
    let mut next = 0;
    while let Some(&link) = reached.get(next) {
        for &child in &below[link] {
            distance[child] = distance[link] + 1;
            reached.push(child);
        }
        next += 1;
    }
    if let Some(lost) = distance.iter().position(|&steps| steps == usize::MAX) {
        return Err(not_a_tree(lost));
    }
    joints.sort_by_key(|joint| distance[joint.child]);
    Ok(Tree { joints, root })
}

/// What moves the joints of a file.
pub(super) struct Drives {
    /// The joints with a value of their own, in the file's order.
    pub(super) moved: Vec<String>,
    /// For each joint what moves it; none for those that are fixed.
    pub(super) by: Vec<Option<Drive>>,
}

/// Follows joints that mimic others to the one that has a value.
pub(super) fn drives(joints: &[DescribedJoint], names: &Names<'_>) -> Result<Drives, RobotError> {
    let mut drives = Drives { moved: Vec::new(), by: vec![None; joints.len()] };
    for (joint, by) in joints.iter().zip(&mut drives.by) {
        if joint.kind != Kind::Fixed && joint.mimic.is_none() {
            *by = Some(Drive { value: drives.moved.len(), factor: 1.0, offset: 0.0 });
            match joint.kind {
                Kind::Orients => {
                    let named = ["x", "y", "z", "w"].map(|end| format!("{}_{end}", joint.name));
                    if let Some(name) = named.iter().find(|name| names.find(name).is_some()) {
                        let (what, name) = ("joint or value", name.clone());
                        return Err(RobotError::Twice { what, name }.at_line(joint.line));
                    }
                    drives.moved.extend(named);
                }
                _ => drives.moved.push(joint.name.clone()),
            }
        }
    }
    let mut on_the_way = vec![false; joints.len()];
    for first in 0..joints.len() {
        let mut way = Vec::new();
        let (mut at, mut user) = (first, first);
        while let Some(mimic) = joints[at].mimic.as_ref().filter(|_| drives.by[at].is_none()) {
            if std::mem::replace(&mut on_the_way[at], true) {
                let user = format!("joint {:?}", joints[at].name);
                let why = "it mimics itself, by way of others".to_owned();
                return Err(RobotError::Refused { user, why }.at_line(joints[at].line));
            }
            way.push((at, mimic));
            user = at;
            at = names.find(&mimic.leader).ok_or_else(|| no_leader(&joints[user]))?;
        }
        let Some(mut by) = drives.by[at] else {
            if way.is_empty() {
                continue;
            }
            return Err(no_leader(&joints[user]));
        };
        for (follower, mimic) in way.into_iter().rev() {
            let (factor, offset) = (mimic.factor, mimic.offset);
            by = Drive {
                value: by.value,
                factor: by.factor * factor,
                offset: by.offset * factor + offset,
            };
            drives.by[follower] = Some(by);
        }
    }
    Ok(drives)
}

fn no_leader(joint: &DescribedJoint) -> RobotError {
    let name = joint.mimic.as_ref().map_or_else(String::new, |mimic| mimic.leader.clone());
    let user = format!("joint {:?}", joint.name);
    RobotError::Unknown { what: "moved joint", name, user }.at_line(joint.line)
}
