//! How near a robot's links are to anything, and how that changes with its joints.

use super::kinematics::{JointFrame, quaternion};
use super::{Joint, Motion, Robot, RobotError, Workcell};
use dcd_geom::{Aabb, Pair};
use dcd_gjk::epa::Scratch;
use dcd_gjk::query::Twist;
use dcd_gjk::{PairSolver, PosedShape, Proximities, Proximity, Verdict};
use glam::{DQuat, DVec3};

/// The signed distance of a link and what it may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// The two objects of [`Workcell::scene`], a and b of the proximity: the robot's first, of two of the robot's that of the
    /// earlier part. [`Workcell::names_of`] has their names in that order.
    pub objects: [u32; 2],
    /// Signed distance, bound, normal, points and derivatives with respect to both poses.
    pub proximity: Proximity,
    /// The derivative of the signed distance by each of [`Robot::variables`], metres a radian or metres a
    /// metre; for a quaternion's numbers that of the rotation that they normalise to. What
    /// [`Proximity::smoothness`] says of the poses holds here.
    pub gradient: Vec<f64>,
}

impl Workcell {
    /// The least signed distance of all pairs that are checked, links (padded ones by their padded shapes)
    /// and obstacles, at that state; moves the robot there. Its error bound covers every pair: the true
    /// least distance is within it, whichever pair that is of. `None`: there is no pair.
    ///
    /// # Errors
    /// Those of [`Workcell::set_state`]; a pair whose signed distance is not known, by its names: nothing is
    /// said of the rest then.
    pub fn clearance(&mut self, state: &[f64]) -> Result<Option<Clearance>, RobotError> {
        let found = self.nearest(state, f64::INFINITY, Keep::Least)?;
        Ok(found.into_iter().next())
    }

    /// The signed distances of all pairs within that many metres of each other, by their objects: what an
    /// optimiser keeps above 0. Moves the robot to the state.
    ///
    /// # Errors
    /// Those of [`Workcell::clearance`]; a margin that is negative or not a number.
    pub fn clearances(&mut self, state: &[f64], margin: f64) -> Result<Vec<Clearance>, RobotError> {
        if !(margin >= 0.0) {
            let (what, user) = ("margin", "a clearance".to_owned());
            return Err(RobotError::BadNumber { what, user, value: margin });
        }
        let mut found = self.nearest(state, margin, Keep::All)?;
        found.sort_unstable_by_key(|clearance| clearance.objects);
        Ok(found)
    }

    fn nearest(
        &mut self,
        state: &[f64],
        margin: f64,
        keep: Keep,
    ) -> Result<Vec<Clearance>, RobotError> {
        self.set_state(state)?;
        let refused = |error| RobotError::Shape { user: "a clearance's margin".to_owned(), error };
        let limit = margin.min(Aabb::LIMIT);
        let solver = Proximities::within(limit).map_err(refused)?;
        let mut scratch = Scratch::default();
        let mut found: Vec<([u32; 2], Proximity)> = Vec::new();
        let mut least = Least::default();
        for (gap, pair) in self.pairs_by_gap() {
            // No pair from here on is nearer than its boxes, which say nothing of depths.
            if gap > limit || keep == Keep::Least && gap > least.signed_distance().max(0.0) {
                break;
            }
            let objects = self.in_order(pair);
            let [a, b] = objects.map(|object| self.posed(object));
            match solver.solve(a, b, &mut scratch) {
                Verdict::Apart => {}
                Verdict::Touching(found_here) if keep == Keep::All => {
                    found.push((objects, found_here));
                }
                Verdict::Touching(found_here) => least.take(objects, found_here),
                Verdict::Undecided(reason) => return Err(self.unknown(objects, reason)),
            }
        }
        found.extend(least.with_its_bound());
        let frames = self.robot().link_frames(state)?;
        let above = self.robot().joints_above();
        let clearance = |(objects, proximity)| Clearance {
            objects,
            proximity,
            gradient: self.by_joints((state, &frames, &above), objects, &proximity),
        };
        Ok(found.into_iter().map(clearance).collect())
    }

    /// The pairs that are checked, each with a lower bound on its distance, ascending.
    fn pairs_by_gap(&self) -> Vec<(f64, Pair)> {
        let scene = self.scene();
        let aabbs: Vec<Aabb> = (0..scene.len()).map(|i| scene.aabb(i)).collect();
        let mut pairs = Vec::new();
        let mut add = |i: u32, j: u32| {
            if scene.allows(i, j) {
                pairs.push((gap_of(&aabbs[i as usize], &aabbs[j as usize]), Pair { i, j }));
            }
        };
        let mut movers = Vec::new();
        for j in 0..scene.len() as u32 {
            if self.part_of(j as usize).is_some() {
                (0..j).for_each(|i| add(i, j));
                movers.push(j);
            } else {
                movers.iter().for_each(|&i| add(i, j));
            }
        }
        pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        pairs
    }

    fn posed(&self, object: u32) -> PosedShape<'_> {
        let (scene, object) = (self.scene(), object as usize);
        PosedShape { shape: scene.shape(object), pose: &scene.poses()[object] }
    }

    fn unknown(&self, [a, b]: [u32; 2], reason: dcd_gjk::Reason) -> RobotError {
        let [a, b] = self.names_of((a, b));
        let user = format!("the signed distance of {a:?} and {b:?}");
        RobotError::Refused { user, why: format!("it is not known: {reason:?}") }
    }

    /// The derivative by each variable: what each joint above either object moves it by.
    fn by_joints(&self, placed: Placed<'_>, [a, b]: [u32; 2], proximity: &Proximity) -> Vec<f64> {
        let mut gradient = vec![0.0; placed.0.len()];
        for (object, twist) in [(a, proximity.gradient.a), (b, proximity.gradient.b)] {
            let Some(part) = self.part_of(object as usize) else { continue };
            let link = self.robot().parts()[part].link;
            let origin = self.scene().poses()[object as usize].translation();
            add_gradient(placed, (link, origin, twist), &mut gradient);
        }
        gradient
    }
}

/// Which pairs are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Keep {
    Least,
    All,
}

/// The least of signed distances, each known to within its own bound.
#[derive(Default)]
struct Least {
    found: Option<([u32; 2], Proximity)>,
    /// No true distance is below this, metres.
    lower: Option<f64>,
}

impl Least {
    fn signed_distance(&self) -> f64 {
        self.found.map_or(f64::INFINITY, |(_, proximity)| proximity.signed_distance)
    }

    fn take(&mut self, objects: [u32; 2], proximity: Proximity) {
        // A step outward is more than a difference's rounding, here and below.
        let lower = (proximity.signed_distance - proximity.error_bound).next_down();
        self.lower = Some(self.lower.map_or(lower, |least| least.min(lower)));
        if proximity.signed_distance < self.signed_distance() {
            self.found = Some((objects, proximity));
        }
    }

    /// The least with a bound that reaches down to what any other may be; where f64 does not hold it, `f64::MAX`.
    fn with_its_bound(self) -> Option<([u32; 2], Proximity)> {
        let (objects, mut proximity) = self.found?;
        let down = (proximity.signed_distance - self.lower?).next_up();
        proximity.error_bound = proximity.error_bound.max(down).min(f64::MAX);
        Some((objects, proximity))
    }
}

/// What the rounding of a gap between boxes may add to it. No unit.
const ROUNDED: f64 = 1.0 - 16.0 * f64::EPSILON;

/// How far two boxes are apart at the least, metres.
fn gap_of(a: &Aabb, b: &Aabb) -> f64 {
    let (below, above) = (a.min.as_dvec3() - b.max.as_dvec3(), b.min.as_dvec3() - a.max.as_dvec3());
    below.max(above).max(DVec3::ZERO).length() * ROUNDED
}

/// A state, the frames of all links there, and the joint above each.
type Placed<'a> = (&'a [f64], &'a [JointFrame], &'a [Option<&'a Joint>]);

impl Robot {
    /// For each link the joint that it hangs on.
    fn joints_above(&self) -> Vec<Option<&Joint>> {
        let mut above = vec![None; self.links().len()];
        self.joints().iter().for_each(|joint| above[joint.child] = Some(joint));
        above
    }
}

/// Adds what a change of each variable changes by moving something rigid on a link, whose frame has that
/// origin in the world and whose derivative is that twist.
fn add_gradient(
    (state, frames, above): Placed<'_>,
    (link, origin, twist): (usize, DVec3, Twist),
    gradient: &mut [f64],
) {
    let mut link = link;
    // A tree: each step leads nearer to the root.
    while let Some(joint) = above[link] {
        let rest = frames[joint.parent].then(&joint.origin);
        let turned_by = |axis: DVec3| {
            let moved = axis.cross(origin - rest.translation);
            twist.translation.dot(moved) + twist.rotation.dot(axis)
        };
        match joint.motion {
            Motion::Fixed => {}
            Motion::Turns { axis, by } => {
                gradient[by.value] += by.factor * turned_by(rest.rotation * axis);
            }
            Motion::Slides { axis, by } => {
                let along = rest.rotation * axis;
                gradient[by.value] += by.factor * twist.translation.dot(along);
            }
            Motion::Orients { first } => {
                let q = quaternion(state, first).normalize();
                for k in 0..4 {
                    let mut change = [0.0; 4];
                    change[k] = 1.0;
                    let spin = (DQuat::from_array(change) * q.conjugate()).xyz() * 2.0;
                    gradient[first + k] += turned_by(rest.rotation * spin);
                }
            }
        }
        link = joint.parent;
    }
}

#[cfg(test)]
mod tests;
