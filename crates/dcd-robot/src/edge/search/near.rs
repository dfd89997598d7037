//! The pairs that a search takes up where obstacles are many: those that come near anywhere on the path.
//!
//! What moves is in a box that holds its sphere in all slices of the path; an obstacle whose box is farther from that than the distance of
//! some pair at some place of the path bounds no clearance (docs/numerics/proofs.md, "Near obstacles").

#[cfg(test)]
mod tests;

use super::super::by_mover::ByMover;
use super::super::groups::{Group, Groups};
use super::super::{EdgePair, ROUNDED_UP};
use super::EdgeSearch;
use crate::RobotError;
use dcd_geom::Aabb;
use dcd_gjk::distance::{DistanceResult, in_f64};
use glam::DVec3;
use std::sync::Arc;

/// How much smaller a distance has to be for near obstacles to be listed once more by it. No unit. Larger: lists that are hardly shorter.
/// Smaller: longer ones. No effect on what is proved.
const WORTH_LISTING: f64 = 0.75;

/// The part of all pairs with obstacles above which all are taken: a choice would cost more than it saves. No unit.
const MOST: f64 = 0.5;

/// The distance that is tried first where nothing moves and no other is known, metres. Larger, smaller: another number of lists. No effect on
/// what is proved.
const LEAST: f64 = 1e-3;

impl EdgeSearch<'_> {
    /// Leaves out the pairs with obstacles that are proved farther apart, on all of the path until there, than some pair is somewhere on
    /// it; before a hit, all that are proved apart.
    pub(super) fn keep_near_pairs(&mut self, end: f64) -> Result<(), RobotError> {
        let Some(by_mover) = &self.checker.by_mover else { return Ok(()) };
        // Where a link is out of range the search says so.
        let Some(mut spheres) = self.spheres(end) else { return Ok(()) };
        let boxes = by_mover.movers.iter().map(|mover| self.swept(mover.object, &mut spheres));
        let boxes: Option<Vec<[DVec3; 2]>> = boxes.collect();
        self.spheres = Some(spheres);
        let Some(boxes) = boxes else { return Ok(()) };
        let mut near = Vec::new();
        let distance = if self.hit.is_some() {
            self.list_near(by_mover, (&boxes, 0.0), &mut near).map(|()| f64::INFINITY)
        } else {
            self.at.go_to(self.checker, self.path, 0.5 * end)?;
            self.list_nearest(by_mover, &boxes, &mut near)
        };
        let Some(distance) = distance else { return Ok(()) };
        near.extend(&by_mover.own);
        by_mover.sort(&mut near);
        self.keep_pairs(&near);
        self.note(distance);
        Ok(())
    }

    /// Lists what is nearer than some distance, which some pair has where the robot is; none where that is most of all.
    fn list_nearest(
        &self,
        by_mover: &ByMover,
        boxes: &[[DVec3; 2]],
        near: &mut Vec<u32>,
    ) -> Option<f64> {
        let size = |[min, max]: &[DVec3; 2]| (*max - *min).max_element();
        let largest = boxes.iter().map(size).fold(LEAST, f64::max);
        // The distance of some pair.
        let mut known = self.nearest_of(&by_mover.own);
        let mut distance = known.unwrap_or(largest);
        loop {
            self.list_near(by_mover, (boxes, distance), near)?;
            match self.nearest_of(near) {
                Some(nearer) if known.is_none_or(|known| nearer < WORTH_LISTING * known) => {
                    (known, distance) = (Some(nearer), nearer);
                }
                _ if known.is_some() => return Some(distance),
                _ => distance *= 2.0,
            }
        }
    }

    /// Lists the groups and the pairs in none with an obstacle that may come as near as that on the path; none where these are most of
    /// all.
    fn list_near(
        &self,
        by_mover: &ByMover,
        (boxes, distance): (&[[DVec3; 2]], f64),
        near: &mut Vec<u32>,
    ) -> Option<()> {
        let grown = distance * ROUNDED_UP;
        let aabbs = boxes.iter().map(|&[min, max]| {
            let aabb = Aabb::outward(min - grown, max + grown);
            // Written so that a NaN is near everything.
            let is_known = aabb.min.is_finite() && aabb.max.is_finite();
            if is_known { aabb } else { Aabb::EVERYTHING }
        });
        let aabbs: Vec<Aabb> = aabbs.collect();
        let mut listed = Vec::new();
        self.checker.states.as_ref()?.list_obstacles(&aabbs, &mut listed)?;
        let is_most = |count: usize| count as f64 > MOST * by_mover.len() as f64;
        if is_most(listed.len()) {
            return None;
        }
        near.clear();
        near.extend(listed.iter().filter_map(|&[mover, obstacle]| {
            by_mover.get(&by_mover.movers[mover as usize], obstacle)
        }));
        for mover in &by_mover.movers {
            let unbounded = by_mover.unbounded.iter();
            near.extend(unbounded.filter_map(|&obstacle| by_mover.get(mover, obstacle)));
        }
        by_mover.sort(near);
        (!is_most(near.len())).then_some(())
    }

    /// A distance that some of these pairs has where the robot is, of what is about the nearest; none where there is none that has an end.
    fn nearest_of(&self, open: &[u32]) -> Option<f64> {
        let far = |&open: &u32| Some((self.far(open), open)).filter(|(far, _)| far.is_finite());
        let (_, nearest) = open.iter().filter_map(far).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let pair = match self.group(nearest) {
            Some(group) => {
                let members = self.groups.members_of(group).iter();
                let far = |&pair: &u32| self.far(pair);
                *members.min_by(|j, k| far(j).total_cmp(&far(k)))?
            }
            None => nearest,
        };
        let pair = &self.pairs[pair as usize];
        let distance = self.distance_at_most(pair);
        // Not NaN either.
        (distance > 0.0 && distance.is_finite()).then_some(distance)
    }

    /// At least the distance of a pair where the robot is.
    fn distance_at_most(&self, pair: &EdgePair) -> f64 {
        let off = self.off(pair);
        let is_mesh = |object: u32| self.checker.volumes[object as usize].hull.is_some();
        // A mesh's distance may cost as much as all that is saved.
        if !pair.objects.into_iter().any(is_mesh) {
            let [a, b] = pair.objects.map(|object| self.posed(object));
            if let DistanceResult::Apart(found) = in_f64(a, b) {
                return found.upper() + off;
            }
        }
        let [(a, in_a), (b, in_b)] = pair.objects.map(|object| {
            let whole = &self.checker.volumes[object as usize].whole;
            (self.pose(object).apply(whole.centre), whole.outer)
        });
        (a.distance(b) + in_a + in_b) * ROUNDED_UP + off
    }

    /// Searches these groups and pairs in none alone, in their order.
    fn keep_pairs(&mut self, open: &[u32]) {
        let (mut pairs, mut groups) = (Vec::with_capacity(open.len()), Groups::default());
        for &open in open {
            let first = pairs.len() as u32;
            match self.group(open) {
                Some(group) => {
                    let members = self.groups.members_of(group);
                    pairs.extend(members.iter().map(|&pair| self.pairs[pair as usize]));
                    let Group { pair, .. } = *group;
                    groups.add(pair, first..pairs.len() as u32);
                }
                None => {
                    pairs.push(self.pairs[open as usize]);
                    groups.single.push(first);
                }
            }
        }
        (self.pairs, self.groups) = (pairs.into(), Arc::new(groups));
    }
}
