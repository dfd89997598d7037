//! Configurations of a link set, asked against a world.

use super::set::ROW;
use super::worker::WorkerScratch;
use super::{LinkSet, StaticWorld};
use dcd_broad::ObstacleGrid;
use dcd_exec::{Exec, PerThread, Segments};
use dcd_geom::{Object, PackedSphereBounds, Pose, Scene, SceneError, SphereBounds};
use dcd_gjk::{NarrowPhase, Verdict};
use std::sync::atomic::{AtomicUsize, Ordering};

/// What a link touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Other {
    /// An obstacle, by its index in the scene that the world was made from.
    Obstacle(u32),
    /// A link of the same configuration, of smaller index.
    Link(u32),
}

/// Something that is not known to be apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<A> {
    /// Which configuration.
    pub configuration: u32,
    /// Which of its links.
    pub link: u32,
    /// What the link touches.
    pub other: Other,
    /// That they touch, with what was asked for, or that it could not be settled.
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

impl<'p, A: Copy + Send> Hits<'p, A> {
    /// In order.
    pub fn iter(&self) -> impl Iterator<Item = Hit<A>> + use<'p, A> {
        self.0.iter().flatten().copied()
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

/// How many configurations are taken up at once, at the least. Larger: more memory, which a checker
/// of few configurations fills in vain (half a millisecond at 128). Smaller: lanes that run empty.
const FEW: usize = 32;

/// How many are taken up at once, at the most, where every hit is asked for: lanes are full in any
/// case, so that fewer objects stay nearer. At most a row.
const MOST_OF_ALL: usize = 128;

/// Into how many rows a batch is cut, if it has enough configurations. Larger: shorter rows, whose
/// lanes run empty sooner. Smaller: threads wait for the last. No effect on any answer.
const ROWS: usize = 16;

/// Asks a world for a link set's configurations, on many threads, and keeps what that needs: for
/// each thread the obstacles as the narrow phase prepares them and room for 32 configurations, 128 or 512
/// from the first batch on that is large enough.
///
/// A link is prepared only where its [`SphereBounds`] is near something: an obstacle's box, or another
/// link's bound.
///
/// A batch is the poses of its configurations one after the other, one pose a link. The answers do
/// not depend on `exec` or on earlier batches. After the first batch a serial one of a like size
/// allocates nothing.
pub struct BatchChecker<'w, N: NarrowPhase = dcd_gjk::Overlap> {
    pub(super) world: &'w StaticWorld<N>,
    pub(super) link_set: LinkSet,
    /// The obstacles, then a row of objects for each link.
    pub(super) template: Scene,
    /// How many objects a row has: the configurations that are taken up at once, at most.
    pub(super) row: usize,
    /// For each link what its box comes from without its vertices, where that is known.
    pub(super) bounds: PackedSphereBounds,
    /// What stands near any place, for spheres as large as the links'.
    pub(super) obstacle_grid: ObstacleGrid,
    workers: PerThread<WorkerScratch<N>>,
    first: Vec<Option<Hit<N::Answer>>>,
    all: Segments<Hit<N::Answer>>,
}

impl<'w, N: NarrowPhase> BatchChecker<'w, N> {
    pub(super) fn new(world: &'w StaticWorld<N>, link_set: LinkSet) -> Result<Self, SceneError> {
        let row = FEW;
        let template = with_rows(world, &link_set, row)?;
        let aabb_margin = world.narrow.aabb_margin();
        let bound = |shape| Some(SphereBounds::of(shape)?.swept(aabb_margin?));
        let bounds: Vec<Option<SphereBounds>> = link_set.shapes.iter().map(bound).collect();
        let largest = bounds.iter().flatten().map(|bound| bound.largest_sphere(world.farthest()));
        let obstacle_grid = ObstacleGrid::new(&world.obstacle_bounds, largest.fold(0.0, f32::max));
        let bounds = PackedSphereBounds::new(bounds);
        let (workers, first, all) = (PerThread::default(), Vec::new(), Segments::default());
        let checker =
            Self { world, link_set, template, row, bounds, obstacle_grid, workers, first, all };
        // So that the first batch on this thread need not.
        checker.workers.with(|worker| worker.set_up(&checker));
        Ok(checker)
    }

    /// For each configuration one contact, if it has any. Where nothing is known to touch, a pair that
    /// could not be settled, if there is one.
    ///
    /// Which of several contacts is told is not specified, but that it is the one that is found with
    /// the least work; it is always the same, whatever other configurations are asked with it.
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
                worker.open(checker, start, found.len());
                refused.note(worker.find_first(checker, poses, found));
            });
        });
        self.first = first;
        refused.check(self, poses)?;
        Ok(&self.first)
    }

    /// Every pair that touches or could not be settled, configuration by configuration: its links
    /// with the obstacles, in the order of the links and for each in that of the obstacles, then its
    /// links with each other, then what could not be settled.
    ///
    /// # Errors
    /// Those of [`BatchChecker::first`], and every pose out of range.
    pub fn all<'e>(
        &mut self,
        poses: &[Pose],
        exec: impl Into<Exec<'e>>,
    ) -> Result<Hits<'_, N::Answer>, SceneError> {
        let count = self.count(poses)?;
        let grain = self.grain(count, MOST_OF_ALL)?;
        let mut all = std::mem::take(&mut self.all);
        let (refused, checker) = (Refused::default(), &*self);
        all.fill(exec.into(), count.div_ceil(grain), |task, out| {
            checker.workers.with(|worker| {
                let start = grain * task;
                worker.open(checker, start, grain.min(count - start));
                refused.note(worker.settle_all(checker, poses));
                worker.append_all(checker, out);
            });
        });
        self.all = all;
        refused.check(self, poses)?;
        Ok(Hits(&self.all))
    }

    /// How many of so many configurations are taken up at once, and room for them.
    fn grain(&mut self, count: usize, most: usize) -> Result<usize, SceneError> {
        let grain = count.div_ceil(ROWS).clamp(FEW, most);
        if grain > self.row {
            (self.template, self.row) = (with_rows(self.world, &self.link_set, most)?, most);
        }
        Ok(grain)
    }

    /// The slot at which a link's row begins.
    pub(super) fn row_of(&self, link: usize) -> usize {
        self.world.obstacles.len() + self.row * link
    }

    /// Whether a link may touch an obstacle.
    pub(super) fn allows(&self, link: usize, obstacle: u32) -> bool {
        let obstacle = self.world.obstacles.filters()[obstacle as usize];
        self.link_set.filters[link].allows(obstacle)
    }

    /// How many configurations these poses are.
    fn count(&self, poses: &[Pose]) -> Result<usize, SceneError> {
        let links = self.link_set.len();
        let count = poses.len().checked_div(links).unwrap_or(0);
        if count * links != poses.len() {
            return Err(SceneError::LengthsDiffer { shapes: links, poses: poses.len() });
        }
        let what = "configurations";
        u32::try_from(count).map(|_| count).map_err(|_| SceneError::TooMany { what, count })
    }
}

/// The obstacles, then a row of that many objects for each link.
fn with_rows<N: NarrowPhase>(
    world: &StaticWorld<N>,
    link_set: &LinkSet,
    row: usize,
) -> Result<Scene, SceneError> {
    let mut template = world.obstacles.clone();
    let shapes = template.add_shapes(link_set.shapes.iter().cloned())?;
    for (link, (shape, &filter)) in shapes.zip(&link_set.filters).enumerate() {
        let object = Object { filter, ..Object::new(shape, Pose::IDENTITY) };
        for _ in 0..row {
            template.insert(object).map_err(|error| match error {
                SceneError::OutOfRange { reach, .. } => {
                    SceneError::OutOfRange { object: link, reach }
                }
                other => other,
            })?;
        }
    }
    Ok(template)
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

    /// Says why it was refused.
    fn check<N: NarrowPhase>(
        self,
        checker: &BatchChecker<'_, N>,
        poses: &[Pose],
    ) -> Result<(), SceneError> {
        let object = self.0.into_inner();
        let Some(pose) = poses.get(object) else { return Ok(()) };
        let slot = checker.row_of(object % checker.link_set.len());
        match checker.template.clone().set_pose(slot, *pose) {
            Err(SceneError::OutOfRange { reach, .. }) => {
                Err(SceneError::OutOfRange { object, reach })
            }
            other => other,
        }
    }
}
