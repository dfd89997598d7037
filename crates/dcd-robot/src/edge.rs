//! Whether a robot's motion is free, proved for all of it and not for samples.
//!
//! An interval of the path is proved free of a pair if the gap at its middle is larger than anything can
//! close until its ends; else it is halved. Two bounds on how far parts move are tried: each joint's turn times
//! the distance that it carries a point (Schwarzer, Saha, Latombe 2005), joints that carry both parts
//! left out; and, along the direction in which the gap was found, the velocity at the middle with a bound
//! on the acceleration, which lets a link slide along an obstacle (docs/numerics/proofs.md, "edges").

mod bounding_volumes;
mod by_mover;
mod certificate;
mod groups;
mod path;
mod place;
mod reach;
mod rows;
mod search;
#[cfg(test)]
mod tests;

pub use certificate::{CertifiedPair, EdgeCertificate, SeparatingPlane};
pub(super) use path::Extents;
pub use path::JointPath;
pub(super) use reach::Chain;

use super::state_checker::covers::{Covers, is_one};
use super::{Obstacle, Robot, RobotError, StateChecker, Workcell};
use bounding_volumes::{BoundingVolumes, MOST_SPHERES};
use by_mover::ByMover;
use certificate::Pieces;
use dcd_exec::Exec;
use dcd_geom::Shape;
use groups::Groups;
use search::EdgeSearch;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Rounds a bound up: far more than its sums and products lose in f64, relative. No unit. Smaller: bounds below the truth.
const ROUNDED_UP: f64 = 1.0 + 1e-9;

/// Checks whether motions of a robot in its world are free.
///
/// ```
/// use dcd_robot::{AllowedPairs, EdgeAnswer, EdgeChecker, JointPath, Robot, Workcell, World};
/// use std::path::Path;
/// let guide = Path::new("../../docs/guide/arm"); // the guide's arm and its shelf
/// let robot = Robot::load(&guide.join("arm_description/urdf/arm.urdf"))?;
/// let world = World::load(&guide.join("shelf.yaml"), &robot, None)?;
/// let allowed = AllowedPairs::adjacent(&robot);
/// let checker = EdgeChecker::new(Workcell::new(robot, &world, &allowed)?);
/// let (beside, before) = (vec![0.6, 0.681, 1.897, -1.007, 0.04], vec![0.0, 0.681, 1.897, -1.007, 0.04]);
/// let edge = checker.check(&JointPath::Straight([beside, before]), 10_000)?;
/// assert!(matches!(edge.answer, EdgeAnswer::Free { clearance } if clearance > 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct EdgeChecker {
    cell: Workcell,
    /// For each object of the scene, then for each link that carries several, the part that moves it, and by which joints.
    movers: Vec<Option<(usize, Chain)>>,
    /// For each of those.
    volumes: Vec<Arc<BoundingVolumes>>,
    pairs: Arc<[EdgePair]>,
    groups: Arc<Groups>,
    /// The objects that stand still.
    obstacles: Range<u32>,
    /// For each of them.
    still: Vec<Still>,
    /// The same pairs by what moves, where obstacles are many.
    by_mover: Option<ByMover>,
    /// For hits; none of more objects than it counts.
    states: Option<Arc<StateChecker>>,
    /// Of each object, once a certificate is wanted; or an object that has none.
    pieces: OnceLock<Result<Arc<[Pieces]>, usize>>,
}

/// What bounds the rounding of an obstacle's place.
#[derive(Clone, Copy, Debug)]
struct Still {
    /// All lengths that go into its coordinates, metres.
    length: f64,
    /// [`Pose::deviation`](dcd_geom::Pose::deviation).
    deviation: f64,
}

/// Two objects that may not touch, a moving one first.
#[derive(Clone, Copy, Debug)]
struct EdgePair {
    objects: [u32; 2],
    /// How many moving joints carry both.
    common: u32,
}

/// The number of an object among those that move, or among those that do not.
#[derive(Clone, Copy, Debug)]
enum Number {
    Moves(usize),
    Still(usize),
}

/// Where a search ends that has found a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Before {
    /// At once.
    Anything,
    /// Where the path before the hit is proved free as far as it is.
    Hit,
}

/// What is known of an edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Whether it is free.
    pub answer: EdgeAnswer,
    /// Up to which t all of it is proved free; 1 for a free edge.
    pub free_until: f64,
    /// How many intervals were looked at; sixteen single states, which come first, and sixteen equal parts, which are compared
    /// together, are not counted.
    pub nodes: usize,
}

/// Whether an edge is free.
#[derive(Clone, Debug, PartialEq)]
pub enum EdgeAnswer {
    /// Proved: no configuration of it touches.
    Free {
        /// No configuration comes nearer to anything than that, metres; infinite where nothing could be met.
        clearance: f64,
    },
    /// Proved: a configuration of it touches.
    Hit {
        /// Which: the state that [`JointPath::state_at`] gives for it, at the poses of [`Robot::place`].
        t: f64,
        /// The objects of the scene that touch there.
        pair: [u32; 2],
    },
    /// Neither.
    Undecided {
        /// The first interval of t that is not known to be free.
        t: [f64; 2],
        /// A pair that could touch in it.
        pair: [u32; 2],
        /// Why it was not halved again.
        reason: EdgeReason,
    },
}

/// Why an interval was left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EdgeReason {
    /// The budget of intervals was spent.
    Budget,
    /// It is shorter than 2⁻⁴⁰: the gap there is within the rounding.
    Short,
}

impl EdgeReason {
    /// The reason in words.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Budget => "the budget of intervals is spent",
            Self::Short => "no gap is proved however short the interval",
        }
    }
}

impl EdgeChecker {
    /// For the robot of a work cell, with what it carries, among its obstacles; pairs that may touch are
    /// left out.
    pub fn new(cell: Workcell) -> Self {
        let mut covers = Covers::default();
        let states = StateChecker::with_covers(cell.clone(), &mut covers).ok();
        Self::with(cell, states, &[], &mut covers)
    }

    /// Checks in another cell from now on. Shapes that both cells hold are not prepared again: of the same robot,
    /// the obstacles alone.
    pub fn set_cell(&mut self, cell: Workcell) {
        let states = self.states.take().and_then(Arc::into_inner);
        let states = match states {
            Some(mut states) => states.set_cell(cell.clone()).ok().map(|()| states),
            None => StateChecker::new(cell.clone()).ok(),
        };
        self.renew(cell, states);
    }

    /// Checks among other obstacles from now on: [`Workcell::set_obstacles`]. Nothing of the robot is prepared again, unless a clone of this
    /// checker shares it.
    ///
    /// # Errors
    /// Those of [`Workcell::set_obstacles`]; nothing is changed then.
    pub fn set_obstacles(&mut self, obstacles: &[Obstacle]) -> Result<(), RobotError> {
        let mut cell = self.cell.clone();
        cell.set_obstacles(obstacles)?;
        let states = self.states.take().and_then(Arc::into_inner);
        let states = match states {
            Some(mut states) => states.set_obstacles(obstacles).ok().map(|()| states),
            None => StateChecker::new(cell.clone()).ok(),
        };
        self.renew(cell, states);
        Ok(())
    }

    /// Takes another cell and what checks its states.
    fn renew(&mut self, cell: Workcell, states: Option<StateChecker>) {
        let scene = self.cell.scene();
        let moving = (0..scene.len()).filter(|&i| self.movers[i].is_some());
        let held = moving.map(|i| (scene.shape(i).clone(), self.volumes[i].clone()));
        let held: Vec<(Shape, Arc<BoundingVolumes>)> = held.collect();
        *self = Self::with(cell, states, &held, &mut Covers::default());
    }

    fn with(
        cell: Workcell,
        states: Option<StateChecker>,
        held: &[(Shape, Arc<BoundingVolumes>)],
        covers: &mut Covers,
    ) -> Self {
        let robot = cell.robot();
        let mut parent_joint = vec![None; robot.links().len()];
        for (index, joint) in robot.joints().iter().enumerate() {
            parent_joint[joint.child] = Some(index);
        }
        let scene = cell.scene();
        let mover = |i: usize| {
            let part = cell.part_of(i)?;
            let moved = (&robot.parts()[part], scene.shape(i));
            Some((part, Chain::of(robot, moved, &parent_joint)))
        };
        let mut movers: Vec<_> = (0..scene.len()).map(mover).collect();
        let volumes = |i: usize| {
            let shape = scene.shape(i);
            if movers[i].is_none() {
                // An obstacle is compared by the solid round it.
                return Arc::new(BoundingVolumes::of(shape, 1, covers));
            }
            let known = held.iter().find(|(known, _)| is_one(known, shape));
            let new = || Arc::new(BoundingVolumes::of(shape, MOST_SPHERES, covers));
            known.map_or_else(new, |(_, volumes)| volumes.clone())
        };
        let mut volumes: Vec<_> = (0..scene.len()).map(volumes).collect();
        let mut pairs = Vec::new();
        for i in 0..scene.len() as u32 {
            let Some((_, chain)) = &movers[i as usize] else { continue };
            for j in 0..scene.len() as u32 {
                let other = movers[j as usize].as_ref();
                // Two moving ones once.
                if (other.is_some() && j <= i) || !scene.allows(i, j) {
                    continue;
                }
                let common = other.map_or(0, |(_, other)| {
                    let both = chain.joints.iter().zip(&other.joints);
                    both.take_while(|(a, b)| a == b).count() as u32
                });
                pairs.push(EdgePair { objects: [i, j], common });
            }
        }
        let groups = Groups::of(robot, &mut movers, &mut volumes, &pairs);
        let still = cell.obstacles().map(|i| {
            let pose = &scene.poses()[i];
            let length = volumes[i].reach + pose.translation().length();
            Still { length, deviation: pose.deviation() }
        });
        let still = still.collect();
        let is_many = states.as_ref().is_some_and(StateChecker::has_obstacle_tree);
        let unbounded = cell.obstacles().filter(|&i| !volumes[i].whole.outer.is_finite());
        let by_mover = || ByMover::of((&pairs, &groups), cell.obstacles(), unbounded.collect());
        let by_mover = is_many.then(by_mover).filter(|by_mover| by_mover.len() > 0);
        let obstacles = cell.obstacles();
        let obstacles = obstacles.start as u32..obstacles.end as u32;
        let (states, pieces) = (states.map(Arc::new), OnceLock::new());
        let (pairs, groups) = (pairs.into(), Arc::new(groups));
        Self { movers, volumes, pairs, groups, obstacles, still, by_mover, states, pieces, cell }
    }

    /// The work cell.
    pub fn cell(&self) -> &Workcell {
        &self.cell
    }

    /// Whether the path is free, by at most `budget` intervals: the same answer at each call, whatever
    /// else runs. Before a hit the path is proved free to within 2⁻⁷ of t, or as far as the budget lasts and gaps are not
    /// below a micrometre.
    ///
    /// # Errors
    /// A control point that is no state of the robot; a state on the way in which a part is out of range.
    pub fn check(&self, path: &JointPath, budget: usize) -> Result<Edge, RobotError> {
        path.check(self.robot())?;
        EdgeSearch::new(self, path, (budget, Before::Hit)).run()
    }

    /// The same where only the existence of a hit counts: nothing is proved of what is before it, so that its
    /// [`Edge::free_until`] is 0.
    ///
    /// # Errors
    /// Those of [`EdgeChecker::check`].
    pub fn check_any(&self, path: &JointPath, budget: usize) -> Result<Edge, RobotError> {
        path.check(self.robot())?;
        EdgeSearch::new(self, path, (budget, Before::Anything)).run()
    }

    /// [`EdgeChecker::check`] of each path, in their order: the same answers at any number of threads.
    pub fn check_all<'e>(
        &self,
        paths: &[JointPath],
        budget: usize,
        exec: impl Into<Exec<'e>>,
    ) -> Vec<Result<Edge, RobotError>> {
        let mut found: Vec<Option<Result<Edge, RobotError>>> = paths.iter().map(|_| None).collect();
        exec.into().divide(&mut found[..], 1, |start, found| {
            for (path, found) in paths[start..].iter().zip(found) {
                *found = Some(self.check(path, budget));
            }
        });
        found.into_iter().flatten().collect()
    }

    /// The objects of a pair, as [`EdgePair::objects`] has them.
    fn in_order(&self, [i, j]: [u32; 2]) -> [u32; 2] {
        let is_mover = |i: u32| self.movers[i as usize].is_some();
        if is_mover(i.min(j)) || !is_mover(i.max(j)) {
            [i.min(j), i.max(j)]
        } else {
            [i.max(j), i.min(j)]
        }
    }

    /// An obstacle's number, or that of what moves among all that does.
    #[inline]
    fn number(&self, object: u32) -> Number {
        let Range { start, end } = self.obstacles;
        if object < start {
            Number::Moves(object as usize)
        } else if object < end {
            Number::Still((object - start) as usize)
        } else {
            Number::Moves((object - (end - start)) as usize)
        }
    }

    fn robot(&self) -> &Robot {
        self.cell.robot()
    }
}
