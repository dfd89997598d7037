//! Links that carry several objects, by a sphere round all of them: what is far from a link is far from each.

use super::bounding_volumes::BoundingVolumes;
use super::reach::Chain;
use super::{EdgePair, ROUNDED_UP};
use crate::Robot;
use crate::kinematics::JointFrame;
use crate::state_checker::covers::{CoverSphere, STRETCH};
use glam::DVec3;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// Pairs of what two links carry, or a link and one object.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// Of the links, by numbers behind the objects', or the object.
    pub(super) pair: EdgePair,
    /// Its members among those of all groups.
    pub(super) members: Range<usize>,
}

/// The pairs, those of which there are several in groups.
#[derive(Clone, Debug, Default)]
pub(super) struct Groups {
    pub(super) groups: Vec<Group>,
    /// Pairs, group by group.
    pub(super) members: Vec<u32>,
    /// The pairs that are in none.
    pub(super) single: Vec<u32>,
}

/// What moves with a link and bounds several objects.
type Carried = (Option<(usize, Chain)>, Arc<BoundingVolumes>);

impl Groups {
    /// Of pairs of objects. Adds the links that carry several objects to what moves.
    pub(super) fn of(
        robot: &Robot,
        movers: &mut Vec<Option<(usize, Chain)>>,
        volumes: &mut Vec<Arc<BoundingVolumes>>,
        pairs: &[EdgePair],
    ) -> Self {
        let mut on_link: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, mover) in movers.iter().enumerate() {
            if let Some((part, _)) = mover {
                on_link.entry(robot.parts()[*part].link).or_default().push(i);
            }
        }
        let mut stands_for: Vec<u32> = (0..movers.len() as u32).collect();
        for objects in on_link.values().filter(|objects| objects.len() > 1) {
            let carried = objects.iter().filter_map(|&i| {
                let (part, chain) = movers[i].as_ref()?;
                Some((*part, chain, &volumes[i].whole))
            });
            let Some((mover, bounds)) = around(robot, &carried.collect::<Vec<_>>()) else {
                continue;
            };
            objects.iter().for_each(|&i| stands_for[i] = movers.len() as u32);
            movers.push(mover);
            volumes.push(bounds);
        }
        let mut groups = Self::default();
        let mut of_links: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for (number, pair) in (0..).zip(pairs) {
            let [a, b] = pair.objects.map(|object| stands_for[object as usize]);
            if a == b {
                groups.single.push(number);
            } else {
                of_links.entry([a, b]).or_default().push(number);
            }
        }
        for (objects, members) in of_links {
            match members[..] {
                [one] => groups.single.push(one),
                [first, ..] => {
                    let pair = EdgePair { objects, ..pairs[first as usize] };
                    groups.add(pair, members);
                }
                [] => {}
            }
        }
        groups
    }

    /// Adds a group of these pairs.
    pub(super) fn add(&mut self, pair: EdgePair, members: impl IntoIterator<Item = u32>) {
        let first = self.members.len();
        self.members.extend(members);
        self.groups.push(Group { pair, members: first..self.members.len() });
    }

    /// A group's pairs.
    pub(super) fn members_of(&self, group: &Group) -> &[u32] {
        &self.members[group.members.clone()]
    }
}

/// A sphere round what a link carries, each by its part, its chain and the sphere round it, as an object of the first's
/// part. None of what has no end.
fn around(robot: &Robot, carried: &[(usize, &Chain, &CoverSphere)]) -> Option<Carried> {
    let origin = |part: usize| &robot.parts()[part].origin;
    let spheres = carried.iter().map(|&(part, _, whole)| {
        let JointFrame { rotation, translation } = *origin(part);
        (rotation * whole.centre + translation, whole.outer * (1.0 + STRETCH))
    });
    let spheres: Vec<(DVec3, f64)> = spheres.collect();
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = spheres.iter().fold(none, |(min, max), &(centre, radius)| {
        (min.min(centre - radius), max.max(centre + radius))
    });
    let middle = 0.5 * min + 0.5 * max;
    let reach = |&(centre, radius): &(DVec3, f64)| middle.distance(centre) + radius;
    // The link's frame stretches the ways between them too.
    let outer = spheres.iter().map(reach).fold(0.0, f64::max) * (1.0 + STRETCH) * ROUNDED_UP;
    let &(part, chain, _) = carried.first()?;
    let first = origin(part);
    let centre = first.rotation.inverse() * (middle - first.translation);
    let extent = carried.iter().map(|(_, chain, _)| chain.reach()).fold(0.0, f64::max);
    let whole = CoverSphere { centre, outer, inner: f64::NEG_INFINITY };
    let is_finite = outer.is_finite() && centre.is_finite();
    is_finite
        .then(|| (Some((part, chain.with_extent(extent))), Arc::new(BoundingVolumes::round(whole))))
}
