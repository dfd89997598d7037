//! Checks configurations of a link set against a world.

use super::rows::{LinkRows, numbered};
use super::set::ROW;
use super::worker::WorkerScratch;
use super::{LinkSet, Obstacles, StaticWorld};
use dcd_broad::ObstacleGrid;
use dcd_exec::{Exec, PerThread, Segments};
use dcd_geom::{Filter, PackedSphereBounds, Pose, Scene, SceneError, SphereBounds};
use dcd_gjk::{NarrowPhase, Verdict};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What a link touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Other {
    /// An obstacle, by its index in the scene that the world was made from.
    Obstacle(u32),
    /// A link of the same configuration, of smaller index.
    Link(u32),
}

/// A pair that is not proved apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<A> {
    /// Which configuration.
    pub configuration: u32,
    /// Which of its links.
    pub link: u32,
    /// What the link touches.
    pub other: Other,
    /// That they touch, with what the query computes, or that it could not be decided.
    pub verdict: Verdict<A>,
}

impl<A> Hit<A> {
    /// Whether it is a proven contact.
    pub fn touches(&self) -> bool {
        matches!(self.verdict, Verdict::Touching(_))
    }
}

/// The hits of a batch. Borrows the batch checker's buffers.
#[derive(Debug)]
pub struct Hits<'p, A: Send>(&'p Segments<Hit<A>>);

impl<'p, A: Clone + Send> Hits<'p, A> {
    /// In order.
    pub fn iter(&self) -> impl Iterator<Item = Hit<A>> + use<'p, A> {
        self.0.iter().flatten().cloned()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// The fewest configurations that a task of a small batch takes. Larger: more memory, which a checker of few
/// configurations fills in vain (half a millisecond at 128). Smaller: lanes that run empty.
const FEW: usize = 32;

/// The fewest that a task takes of a batch that has as many, and the most if every hit is reported: lanes are full,
/// and the objects stay in cache. At most a row.
const MANY: usize = 128;

/// The number of rows of a batch, if it has enough configurations. Larger: shorter rows, whose
/// lanes run empty sooner. Smaller: threads wait for the last. No effect on any answer.
const ROWS: usize = 16;

/// Checks configurations of a link set against a world, on many threads, and keeps its buffers: for each
/// thread those of 32 configurations, 128 or 512 from the first batch on that is large enough. The world is
/// shared and can be replaced ([`BatchChecker::set_world`]).
///
/// A link is prepared only where its [`SphereBounds`] is near something: an obstacle's AABB, or another
/// link's bound.
///
/// A batch is the poses of its configurations one after the other, one pose a link. The answers do
/// not depend on `exec` or on earlier batches. After the first batch a serial one of a like size
/// allocates nothing.
///
/// ```
/// use dcd_pipeline::prelude::*;
/// use dcd_pipeline::{LinkSet, StaticWorld};
/// let shelf = Scene::one_each(vec![Shape::cuboid(DVec3::new(1.0, 1.0, 0.1))?], vec![Pose::IDENTITY])?;
/// let world = StaticWorld::new(&shelf, Overlap::default(), Par::Pool)?;
/// let mut checker = world.checker(LinkSet::new(vec![Shape::sphere(0.2)?, Shape::sphere(0.2)?]))?;
/// // Two configurations of two links each.
/// let heights = [0.25, 1.0, 0.5, 1.0];
/// let poses = heights.map(|z| Pose::from_translation(DVec3::Z * z));
/// let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let first = checker.first(&poses, Par::Pool)?;
/// assert!(first[0].as_ref().is_some_and(|hit| hit.touches()) && first[1].is_none());
/// let all = checker.all(&poses, Par::Pool)?;
/// assert_eq!(all.iter().map(|hit| (hit.configuration, hit.link)).collect::<Vec<_>>(), [(0, 0)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct BatchChecker<N: NarrowPhase = dcd_gjk::Overlap> {
    pub(super) world: Arc<Obstacles<N>>,
    pub(super) rows: LinkRows,
    /// Whether a link may not touch every obstacle.
    pub(super) filtered: bool,
    /// For each link the sphere bounds that give its AABB without its vertices, where they exist.
    pub(super) bounds: PackedSphereBounds,
    /// The obstacles near any point, for spheres as large as the links'.
    pub(super) obstacle_grid: ObstacleGrid,
    workers: PerThread<WorkerScratch<N>>,
    first: Vec<Option<Hit<N::Answer>>>,
    all: Segments<Hit<N::Answer>>,
}

impl<N: NarrowPhase> BatchChecker<N> {
    pub(super) fn new(
        StaticWorld(world): StaticWorld<N>,
        link_set: LinkSet,
    ) -> Result<Self, SceneError> {
        let rows = LinkRows::new(link_set, FEW)?;
        rows.check_count(&world)?;
        let bounds = bounds_of(&world, &rows.link_set);
        let obstacle_grid = grid_for(&world, &bounds);
        let filtered = has_filters(&world, &rows.link_set);
        let (workers, first, all) = (PerThread::default(), Vec::new(), Segments::default());
        let checker = Self { world, rows, filtered, bounds, obstacle_grid, workers, first, all };
        // Allocates now what the first batch on this thread needs.
        checker.workers.with(|worker| worker.open(&checker, 0..0));
        Ok(checker)
    }

    /// Replaces the obstacles. Costs a look-up grid over the new ones, and nothing for the
    /// links.
    ///
    /// # Errors
    /// More objects than a u32 counts; nothing is changed then.
    pub fn set_world(&mut self, StaticWorld(world): StaticWorld<N>) -> Result<(), SceneError> {
        self.rows.check_count(&world)?;
        if world.narrow.aabb_margin() != self.world.narrow.aabb_margin() {
            self.bounds = bounds_of(&world, &self.rows.link_set);
        }
        self.obstacle_grid = grid_for(&world, &self.bounds);
        self.filtered = has_filters(&world, &self.rows.link_set);
        self.world = world;
        Ok(())
    }

    /// One contact of each configuration that has any. Where nothing is known to touch, an undecided pair, if
    /// there is one.
    ///
    /// Which of several contacts is reported is not specified (the one that costs the least work); it does
    /// not depend on the other configurations of the batch.
    ///
    /// # Errors
    /// There is not one pose for each link of each configuration; more configurations than a u32
    /// counts; a pose out of range, by its index in the batch, unless another link of its
    /// configuration was found to touch before it was prepared.
    pub fn first<'e>(
        &mut self,
        poses: &[Pose],
        exec: impl Into<Exec<'e>>,
    ) -> Result<&[Option<Hit<N::Answer>>], SceneError> {
        let count = self.count(poses)?;
        let grain = self.grain(count, ROW)?;
        let mut first = std::mem::take(&mut self.first);
        first.clear();
        first.resize(count, None);
        let (refused, checker) = (Refused::default(), &*self);
        exec.into().divide(&mut first[..], grain, |start, found| {
            checker.workers.with(|worker| {
                worker.open(checker, start..start + found.len());
                refused.note(worker.find_first(checker, poses, found));
            });
        });
        self.first = first;
        refused.check(self, poses)?;
        Ok(&self.first)
    }

    /// Every pair that touches or is undecided, configuration by configuration: links with obstacles, in the
    /// order of the links and for each in that of the obstacles, then links with each other, then the
    /// undecided pairs.
    ///
    /// # Errors
    /// Those of [`BatchChecker::first`], and every pose out of range.
    pub fn all<'e>(
        &mut self,
        poses: &[Pose],
        exec: impl Into<Exec<'e>>,
    ) -> Result<Hits<'_, N::Answer>, SceneError> {
        let count = self.count(poses)?;
        let grain = self.grain(count, MANY)?;
        let mut all = std::mem::take(&mut self.all);
        let (refused, checker) = (Refused::default(), &*self);
        all.fill(exec.into(), count.div_ceil(grain), |task, out| {
            checker.workers.with(|worker| {
                let start = grain * task;
                worker.open(checker, start..count.min(start + grain));
                refused.note(worker.find_all(checker, poses));
                worker.append_all(checker, out);
            });
        });
        self.all = all;
        refused.check(self, poses)?;
        Ok(Hits(&self.all))
    }

    /// How many configurations a task takes; reserves memory for them.
    fn grain(&mut self, count: usize, most: usize) -> Result<usize, SceneError> {
        let least = if count < MANY { FEW } else { MANY };
        let grain = count.div_ceil(ROWS).clamp(least, most);
        if grain > self.rows.row {
            self.rows.lengthen(if grain > MANY { most } else { MANY })?;
        }
        Ok(grain)
    }

    /// Whether a link may touch an obstacle.
    pub(super) fn allows(&self, link: usize, obstacle: u32) -> bool {
        let obstacle = self.world.scene.filters()[obstacle as usize];
        self.rows.link_set.filters[link].allows(obstacle)
    }

    /// The number of configurations of these poses.
    fn count(&self, poses: &[Pose]) -> Result<usize, SceneError> {
        let links = self.rows.link_set.len();
        let count = poses.len().checked_div(links).unwrap_or(0);
        if count * links != poses.len() {
            return Err(SceneError::LengthsDiffer { shapes: links, poses: poses.len() });
        }
        let what = "configurations";
        u32::try_from(count).map(|_| count).map_err(|_| SceneError::TooMany { what, count })
    }
}

/// For each link the sphere bounds that give its AABB without its vertices, where they exist.
fn bounds_of<N: NarrowPhase>(world: &Obstacles<N>, link_set: &LinkSet) -> PackedSphereBounds {
    let aabb_margin = world.narrow.aabb_margin();
    let bound = |shape| Some(SphereBounds::of(shape)?.swept(aabb_margin?));
    PackedSphereBounds::new(link_set.shapes.iter().map(bound).collect())
}

/// A grid over the obstacles for spheres as large as the links'.
fn grid_for<N: NarrowPhase>(world: &Obstacles<N>, bounds: &PackedSphereBounds) -> ObstacleGrid {
    ObstacleGrid::new(&world.search().bounds, bounds.largest_sphere(world.farthest()))
}

/// Whether some filter may exclude a link with an obstacle.
fn has_filters<N: NarrowPhase>(world: &Obstacles<N>, link_set: &LinkSet) -> bool {
    world.filtered || link_set.filters.iter().any(|filter| *filter != Filter::ALL)
}

/// The first pose that an object cannot have, on any thread.
struct Refused(AtomicUsize);

impl Default for Refused {
    fn default() -> Self {
        Self(AtomicUsize::new(usize::MAX))
    }
}

impl Refused {
    fn note(&self, pose: Option<usize>) {
        if let Some(pose) = pose {
            self.0.fetch_min(pose, Ordering::Relaxed);
        }
    }

    /// The error with the reason of the refusal.
    fn check<N: NarrowPhase>(
        self,
        checker: &BatchChecker<N>,
        poses: &[Pose],
    ) -> Result<(), SceneError> {
        let object = self.0.into_inner();
        let Some(pose) = poses.get(object) else { return Ok(()) };
        let shape = &checker.rows.link_set.shapes[object % checker.rows.link_set.len()];
        // The same refusal as by the scene of links.
        let refused = Scene::one_each(vec![shape.clone()], vec![*pose]).map(drop);
        refused.map_err(|error| numbered(error, object))
    }
}
