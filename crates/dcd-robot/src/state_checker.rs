//! Whether states are free, sixteen at a time.
//!
//! Sixteen states go through the lanes together: where the links are, in f32 and with a bound of how far from the
//! frames of [`Robot::place`](crate::Robot::place), the spheres round and in what they carry against the obstacles and
//! each other. Spheres prove most pairs apart and many to touch; only the pairs that are left are posed, where
//! [`Robot::place`](crate::Robot::place) has them, prepared and decided by the narrow phase. A robot of spheres among
//! boxes, cylinders and spheres is decided by the lanes but for what is within [`MARGIN`] and that bound.

mod alone;
mod body_pairs;
mod chain;
mod changes;
pub(crate) mod covers;
pub(crate) mod link_frames;
mod links;
mod numbers;
mod obstacle_tree;
mod one_link;
mod packed_aabbs;
mod places;
mod prepared;
mod rounded_links;
mod sensed;
mod separate;
mod sift;
mod solids;
#[cfg(test)]
mod tests;
mod worker;

pub(crate) use links::MESH_POINTS;
pub use sensed::SensedHit;

use crate::{Clearance, RobotError, Workcell};
use covers::Covers;
use dcd_exec::{Exec, PerThread, Segments};
use dcd_geom::{Aabb, Pair, SceneError};
use dcd_gjk::Verdict;
use dcd_pipeline::{PairDecider, StaticWorld};
use dcd_simd::Lanes;
use prepared::Prepared;
use std::sync::{Mutex, OnceLock};
use worker::{CHUNK, FEW, Refused, RefusedState, Worker, at, refused, with_chunk};

/// By how much spheres are compared larger, where they are to be apart, or smaller, where they are to touch. Unit:
/// metres a metre of the two sizes and places: 256 units of 2⁻²⁴, some four times what the roundings of frames,
/// centres and radii to f32 and the comparison itself come to (docs/numerics/proofs.md, "states in lanes").
/// Smaller: false answers. Larger: more is left to the narrow phase.
const MARGIN: f64 = 1.0 / (1 << 16) as f64;

/// How far what is compared in f32 may reach, metres. Beyond it a square may overflow: a box is near everything there,
/// a shape has no closed form, an inner radius proves no contact. Larger: false answers (docs/numerics/proofs.md,
/// "states in lanes"). Smaller: more is left to the narrow phase.
const FAR: f32 = 1e14;

/// How many configurations a [`PairDecider`] counts for each link.
const MOST_AT_ONCE: usize = 512;

/// How many clearances are a task. Larger: threads idle at the end. Smaller: tasks cost more than their work.
const CLEARANCES: usize = 4;

/// Sixteen spheres, each metres.
struct SpherePacket<L: Lanes> {
    centre: [L::F; 3],
    outer: L::F,
    inner: L::F,
    /// By how much a comparison may be off.
    margin: L::F,
}

impl<L: Lanes> Clone for SpherePacket<L> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<L: Lanes> Copy for SpherePacket<L> {}

/// Which hits of each state are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Goal {
    /// A hit.
    One,
    /// Every hit.
    All,
}

/// A pair of a state that is not known to be apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateHit {
    /// Which state.
    pub state: u32,
    /// The two objects of [`Workcell::scene`], i < j; [`Workcell::names_of`] has their names.
    pub pair: Pair,
    /// That they touch, or that the pair is undecided.
    pub verdict: Verdict<()>,
}

impl StateHit {
    /// Whether it is a proved contact.
    pub fn touches(&self) -> bool {
        matches!(self.verdict, Verdict::Touching(()))
    }
}

/// Checks states of a robot in its world: the robot against the obstacles and against itself, with what it
/// carries, padded where it is padded; pairs that may touch are left out.
///
/// A planner's threads share one (`&self`); memory is kept for each thread. The answers depend neither on the
/// threads nor on the other states.
///
/// ```
/// use dcd_robot::{AllowedPairs, LinkShapes, Robot, StateChecker, Workcell, World};
/// let urdf = r#"<robot name="pair">
///   <link name="base"><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
///   <link name="hand"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
///   <joint name="slide" type="prismatic"><parent link="base"/><child link="hand"/><axis xyz="1 0 0"/>
///     <limit lower="0" upper="2" effort="1" velocity="1"/></joint></robot>"#;
/// let robot = Robot::read(urdf, std::path::Path::new("."), LinkShapes::Hulls)?;
/// let cell = Workcell::new(robot, &World::default(), &AllowedPairs::default())?;
/// let checker = StateChecker::new(cell)?;
/// assert_eq!(checker.collides(&[[0.25], [0.35]], dcd_pipeline::Par::Serial)?, [true, false]);
/// # Ok::<(), dcd_robot::RobotError>(())
/// ```
#[derive(Debug)]
pub struct StateChecker {
    prepared: Prepared,
    /// Of a state alone and of many, whose links take sixty-four times the memory: made when the spheres first leave a pair
    /// to it, the obstacles' side for each cell.
    deciders: [OnceLock<PairDecider>; 2],
    world: OnceLock<StaticWorld>,
    /// Of other obstacles: its memory is used again.
    old_world: Mutex<Option<StaticWorld>>,
    workers: PerThread<Worker>,
    /// For clearances, whose robots move.
    moved_cells: PerThread<Option<Workcell>>,
}

/// The value of a cell, made at the first use.
fn made<T>(
    cell: &OnceLock<T>,
    make: impl FnOnce() -> Result<T, SceneError>,
) -> Result<&T, SceneError> {
    match cell.get() {
        Some(held) => Ok(held),
        None => make().map(|new| cell.get_or_init(|| new)),
    }
}

impl StateChecker {
    /// For the robot of a work cell, with what it carries, among its obstacles.
    ///
    /// # Errors
    /// More than 2³² objects, each body counted 512 times.
    pub fn new(cell: Workcell) -> Result<Self, RobotError> {
        Self::with_covers(cell, &mut Covers::default())
    }

    /// The same with covers that are known, and will be.
    pub(crate) fn with_covers(cell: Workcell, covers: &mut Covers) -> Result<Self, RobotError> {
        Self::check_count(&cell)?;
        Ok(Self {
            prepared: Prepared::of(cell, covers),
            deciders: Default::default(),
            world: OnceLock::new(),
            old_world: Mutex::default(),
            workers: PerThread::default(),
            moved_cells: PerThread::default(),
        })
    }

    /// Checks in another cell from now on. Where the robot and what it carries are clones of those that there
    /// were, padded alike, only the obstacles are prepared.
    ///
    /// # Errors
    /// Those of [`StateChecker::new`]; nothing is changed then.
    pub fn set_cell(&mut self, cell: Workcell) -> Result<(), RobotError> {
        Self::check_count(&cell)?;
        if self.prepared.has_robot_of(&cell) {
            self.prepared.exchange(cell);
            self.forget_obstacles();
        } else {
            *self = Self::new(cell)?;
        }
        Ok(())
    }

    /// Refuses more objects than a u32 counts.
    fn check_count(cell: &Workcell) -> Result<(), RobotError> {
        Self::check_objects(cell.scene().len())
    }

    fn check_objects(objects: usize) -> Result<(), RobotError> {
        let count = objects.saturating_mul(MOST_AT_ONCE);
        let too_many = |_| RobotError::Scene(SceneError::TooMany { what: "objects", count });
        u32::try_from(count).map(drop).map_err(too_many)
    }

    /// What decides pairs of so many states, and the obstacles prepared for it.
    fn decider(&self, states: usize) -> Result<(&PairDecider, &StaticWorld), SceneError> {
        let [alone, many] = &self.deciders;
        let (decider, most) = if states == 1 { (alone, 1) } else { (many, CHUNK) };
        let new = || PairDecider::new(self.prepared.link_set(), most);
        Ok((made(decider, new)?, made(&self.world, || self.new_world())?))
    }

    /// The cell, its robot in whatever state.
    pub fn cell(&self) -> &Workcell {
        &self.prepared.cell
    }

    /// Whether obstacles are so many that a tree knows which are near.
    pub(crate) fn has_obstacle_tree(&self) -> bool {
        self.prepared.tree.is_some()
    }

    /// Lists which obstacles' boxes, as pairs of a box by its place and of an obstacle, by its place too, overlap which of these boxes, in any
    /// order. None where no tree knows.
    pub(crate) fn list_obstacles(&self, aabbs: &[Aabb], listed: &mut Vec<[u32; 2]>) -> Option<()> {
        let Prepared { tree, aabbs: of, .. } = &self.prepared;
        tree.as_ref()?.list_overlaps(aabbs, of, listed);
        Some(())
    }

    /// Computes where the links are and nothing else: what every query begins with, for measurements.
    ///
    /// # Errors
    /// Those of [`StateChecker::collides`] but for links out of range.
    #[doc(hidden)]
    pub fn place_links<S: AsRef<[f64]>>(&self, states: &[S]) -> Result<(), RobotError> {
        self.workers.with(|worker| {
            let mut chunks = states.chunks(CHUNK).enumerate();
            chunks.try_for_each(|(chunk, states)| {
                let placed = with_chunk(states, |states| worker.place(&self.prepared, states));
                placed.map_err(|error| refused(at(chunk * CHUNK, error)))
            })
        })
    }

    /// For each state whether it is not proved free: whether any pair touches or is undecided.
    ///
    /// # Errors
    /// A state with another number of values than the robot has, or that
    /// [`Robot::place`](crate::Robot::place) refuses; a link out of range: by the state's index.
    pub fn collides<'e, S: AsRef<[f64]> + Sync>(
        &self,
        states: &[S],
        exec: impl Into<Exec<'e>>,
    ) -> Result<Vec<bool>, RobotError> {
        Ok(self.first(states, exec)?.iter().map(Option::is_some).collect())
    }

    /// Whether a state is proved free: what [`StateChecker::collides`] has of it alone, without its list, as a planner asks of
    /// one state after another. No memory is allocated once a thread has had a few.
    ///
    /// # Errors
    /// Those of [`StateChecker::collides`], without an index.
    pub fn is_free(&self, state: &[f64]) -> Result<bool, RobotError> {
        let mut first = [None];
        let found = self.workers.with(|worker| worker.first(self, (0, &[state]), &mut first));
        found.map(|()| first[0].is_none()).map_err(|(_, error)| error)
    }

    /// For each state one contact, if it has any: the one that was found first, always the same. Where nothing is
    /// known to touch, an undecided pair, if there is one.
    ///
    /// # Errors
    /// Those of [`StateChecker::collides`].
    pub fn first<'e, S: AsRef<[f64]> + Sync>(
        &self,
        states: &[S],
        exec: impl Into<Exec<'e>>,
    ) -> Result<Vec<Option<StateHit>>, RobotError> {
        let mut first = vec![None; self.count(states)?];
        if first.len() <= CHUNK {
            self.few(states, |worker, states| worker.first(self, (0, states), &mut first))?;
            return Ok(first);
        }
        let refusals = Refused::default();
        let exec = exec.into().serial_below(states.len(), FEW);
        exec.divide(&mut first[..], CHUNK, |start, first| {
            self.workers.with(|worker| {
                let states = &states[start..start + first.len()];
                let found = with_chunk(states, |states| worker.first(self, (start, states), first));
                found.unwrap_or_else(|(state, error)| refusals.note(state, error));
            });
        });
        refusals.check()?;
        Ok(first)
    }

    /// Every pair that touches or is undecided, state by state, in the order of the objects.
    ///
    /// # Errors
    /// Those of [`StateChecker::collides`].
    pub fn all<'e, S: AsRef<[f64]> + Sync>(
        &self,
        states: &[S],
        exec: impl Into<Exec<'e>>,
    ) -> Result<Vec<StateHit>, RobotError> {
        let count = self.count(states)?;
        if count <= CHUNK {
            return self.few(states, |worker, states| {
                worker.all(self, (0, states))?;
                Ok(worker.hits.clone())
            });
        }
        let refusals = Refused::default();
        let exec = exec.into().serial_below(count, FEW);
        let mut all = Segments::default();
        all.fill(exec, count.div_ceil(CHUNK), |task, out| {
            self.workers.with(|worker| {
                let start = task * CHUNK;
                let states = &states[start..count.min(start + CHUNK)];
                let found = with_chunk(states, |states| worker.all(self, (start, states)));
                found.unwrap_or_else(|(state, error)| refusals.note(state, error));
                out.extend_from_slice(&worker.hits);
            });
        });
        refusals.check()?;
        Ok(all.iter().flatten().copied().collect())
    }

    /// For each state the least signed distance of all pairs, as [`Workcell::clearance`] has it; `None`
    /// where there is no pair.
    ///
    /// # Errors
    /// Those of [`Workcell::clearance`], by the state's index.
    pub fn clearances<'e, S: AsRef<[f64]> + Sync>(
        &self,
        states: &[S],
        exec: impl Into<Exec<'e>>,
    ) -> Result<Vec<Option<Clearance>>, RobotError> {
        let mut least = vec![None; self.count(states)?];
        let refusals = Refused::default();
        exec.into().divide(&mut least[..], CLEARANCES, |start, least| {
            self.moved_cells.with(|cell| {
                let held = cell.take().filter(|cell| cell.has_obstacles_of(self.cell()));
                let cell = cell.insert(held.unwrap_or_else(|| self.cell().clone()));
                for (state, least) in (start..).zip(least) {
                    match cell.clearance(states[state].as_ref()) {
                        Ok(found) => *least = found,
                        Err(error) => refusals.note(state, error),
                    }
                }
            });
        });
        refusals.check()?;
        Ok(least)
    }

    /// Works on few states, on the thread that asks: a state alone takes less time than tasks and the lists of threads.
    fn few<S: AsRef<[f64]>, R>(
        &self,
        states: &[S],
        work: impl FnOnce(&mut Worker, &[&[f64]]) -> Result<R, RefusedState>,
    ) -> Result<R, RobotError> {
        let done = self.workers.with(|worker| with_chunk(states, |states| work(worker, states)));
        done.map_err(refused)
    }

    /// How many states there are.
    fn count<S>(&self, states: &[S]) -> Result<usize, RobotError> {
        let (what, count) = ("states", states.len());
        let too_many = |_| RobotError::Scene(SceneError::TooMany { what, count });
        u32::try_from(count).map(|_| count).map_err(too_many)
    }
}
