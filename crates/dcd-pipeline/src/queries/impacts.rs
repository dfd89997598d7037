//! When the moving objects of a scene meet: swept boxes in a tree, then the time of impact of each pair.

use super::QueryError;
use super::casts::{check_motion, check_times, time_of};
use dcd_broad::{BroadPhase, WideTree};
use dcd_exec::{Exec, Segments};
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Pair, Scene};
use dcd_gjk::motion::{Impact, MovingShape, RigidMotion, time_of_impact};

/// How many boxes a task sweeps: some tens of microseconds.
const BOXES_PER_TASK: usize = 64;

/// How an object moves, about a point of its own. World axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity {
    /// Of the centre: metres a unit of time.
    pub linear: DVec3,
    /// About it: rad a unit of time.
    pub angular: DVec3,
    /// The point about which it turns, in the object's own frame, metres.
    pub centre: DVec3,
}

/// A pair that meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairImpact {
    /// i < j; `a` of the impact is i.
    pub pair: Pair,
    /// When and where. Never [`Impact::Free`].
    pub impact: Impact,
}

/// Finds the pairs that meet while their objects move; keeps its memory.
#[derive(Debug, Default)]
pub struct Impacts {
    motions: Vec<RigidMotion>,
    boxes: Vec<Aabb>,
    tree: WideTree,
    pairs: Segments<Pair>,
    candidates: Vec<Pair>,
    found: Vec<Option<PairImpact>>,
    impacts: Vec<PairImpact>,
}

impl Impacts {
    /// With no memory yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// All pairs that the scene's filters allow and that meet from t = 0 to `until`, by time (of what is undecided by
    /// when it is known to be free until) and then by pair. A pair that touches as it stands has t = 0; one that comes
    /// within `tolerance` metres and does not touch may be listed or not. Pairs that are not listed are proved free:
    /// nothing fast tunnels. One velocity a slot; static objects have one as well, which may be 0.
    ///
    /// The list does not depend on `exec`.
    ///
    /// # Errors
    /// Not one velocity a slot, a number that is not finite with its slot, a time or tolerance that is negative or not
    /// finite.
    pub fn find<'e>(
        &mut self,
        scene: &Scene,
        velocities: &[Velocity],
        [until, tolerance]: [f64; 2],
        exec: impl Into<Exec<'e>>,
    ) -> Result<&[PairImpact], QueryError> {
        let exec = exec.into();
        check_times(until, tolerance)?;
        if velocities.len() != scene.len() {
            return Err(QueryError::LengthsDiffer { given: velocities.len(), slots: scene.len() });
        }
        self.motions.clear();
        self.motions.extend(velocities.iter().zip(scene.poses()).map(|(v, &start)| {
            let &Velocity { linear, angular, centre } = v;
            RigidMotion { start, linear, angular, centre }
        }));
        let motions = &self.motions;
        motions.iter().enumerate().try_for_each(|(i, motion)| check_motion(i, motion))?;
        let moving = |i: usize| MovingShape { shape: scene.shape(i), motion: &motions[i] };
        self.boxes.clear();
        self.boxes.resize(scene.len(), Aabb::EMPTY);
        exec.divide(&mut self.boxes[..], BOXES_PER_TASK, |first, boxes| {
            for (i, aabb) in (first..).zip(boxes) {
                // Half of the tolerance on either side would do for a near miss.
                if scene.motion(i).is_some() {
                    let Aabb { min, max } = moving(i).swept_aabb(until);
                    let (min, max) = (min.as_dvec3() - tolerance, max.as_dvec3() + tolerance);
                    let limit = DVec3::splat(Aabb::LIMIT);
                    *aabb = Aabb::outward(min.max(-limit), max.min(limit));
                }
            }
        });
        self.tree.build(&self.boxes, exec);
        self.tree.pairs(&self.boxes, |i, j| scene.allows(i, j), exec, &mut self.pairs);
        self.pairs.join_into(exec, &mut self.candidates);
        let candidates = &self.candidates;
        self.found.clear();
        self.found.resize(candidates.len(), None);
        exec.divide(&mut self.found[..], 1, |first, found| {
            for (found, &pair) in found.iter_mut().zip(&candidates[first..]) {
                let (a, b) = (moving(pair.i as usize), moving(pair.j as usize));
                // A motion that leaves the range is known to be free nowhere.
                let impact = time_of_impact(a, b, until, tolerance)
                    .unwrap_or(Impact::Undecided { free_until: 0.0 });
                *found = (impact != Impact::Free).then_some(PairImpact { pair, impact });
            }
        });
        self.impacts.clear();
        self.impacts.extend(self.found.iter().flatten());
        self.impacts.sort_unstable_by(|x, y| {
            let time = time_of(&x.impact).total_cmp(&time_of(&y.impact));
            time.then((x.pair.i, x.pair.j).cmp(&(y.pair.i, y.pair.j)))
        });
        Ok(&self.impacts)
    }
}
