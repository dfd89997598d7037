//! The fast broad phase: the wide tree against itself, sixteen AABBs at a time.

mod self_pairs;

use crate::BroadPhase;
use crate::append::append_where;
use dcd_bvh::WideBvh;
use dcd_exec::{Exec, Segments};
use dcd_geom::{Aabb, Pair};
use dcd_simd::{Kernel, Lanes, Path, WIDTH, dispatch_on};
use self_pairs::SelfPairSearch;

/// Candidate pairs from a [`WideBvh`], each leaf tested with itself and with later leaves.
///
/// Lists exactly the overlapping pairs. Their order is that of the tree: tiles of sixteen objects
/// against sixteen, so that a narrow phase finds what it reads in the nearest cache.
///
/// ```
/// use dcd_broad::{BroadPhase, WideTree};
/// use dcd_exec::{Exec, Par, Segments};
/// use dcd_geom::{Aabb, Pair, glam::Vec3};
/// let unit = |x: f32| Aabb { min: Vec3::new(x, 0.0, 0.0), max: Vec3::new(x + 1.0, 1.0, 1.0) };
/// let boxes = [unit(0.0), unit(1.0), unit(2.5)]; // closed: the first two touch
/// let (mut phase, mut pairs) = (WideTree::default(), Segments::default());
/// phase.build(&boxes, Exec::from(Par::Serial));
/// phase.pairs(&boxes, |_, _| true, Exec::from(Par::Serial), &mut pairs);
/// assert_eq!(pairs.iter().flatten().copied().collect::<Vec<_>>(), [Pair { i: 0, j: 1 }]);
/// ```
#[derive(Clone, Debug)]
pub struct WideTree {
    tree: WideBvh,
    /// Whether the tree is that of the boxes taken in last: of a few there is none.
    is_current: bool,
    path: Path,
}

impl Default for WideTree {
    fn default() -> Self {
        Self::on(Path::best())
    }
}

impl WideTree {
    /// A tree on that path, or the portable one where this CPU does not have it. The pairs and their
    /// order are the same on every path; for tests and measurements.
    pub fn on(path: Path) -> Self {
        Self { tree: WideBvh::default(), is_current: false, path }
    }

    fn append_few(&self, aabbs: &[Aabb], out: &mut Vec<Pair>) {
        dispatch_on(self.path, Few { aabbs, out });
    }

    /// The pairs of task number `task`.
    fn append_task(&self, task: usize, out: &mut Vec<Pair>) {
        let first = task * LEAVES_PER_TASK;
        let last = self.tree.leaves().len().min(first + LEAVES_PER_TASK);
        dispatch_on(self.path, SelfPairSearch { tree: &self.tree, leaves: first..last, out });
    }
}

/// How many leaves a task tests. Larger: fewer tasks to share. A scene of sixteen times as many
/// objects is searched without the pool.
const LEAVES_PER_TASK: usize = 16;

impl BroadPhase for WideTree {
    fn build(&mut self, aabbs: &[Aabb], exec: Exec) {
        self.is_current = aabbs.len() > WIDTH;
        if self.is_current {
            self.tree.build(aabbs, exec);
        }
    }

    fn tree(&self) -> Option<&WideBvh> {
        self.is_current.then_some(&self.tree)
    }

    fn pairs(
        &mut self,
        aabbs: &[Aabb],
        keep: impl Fn(u32, u32) -> bool + Sync,
        exec: Exec,
        out: &mut Segments<Pair>,
    ) {
        let this = &*self;
        if aabbs.len() <= WIDTH {
            // A tree of one leaf would take longer to build than to search.
            out.fill(exec, usize::from(!aabbs.is_empty()), |_, out| {
                append_where(out, &keep, |out| this.append_few(aabbs, out));
            });
            return;
        }
        let tasks = this.tree.leaves().len().div_ceil(LEAVES_PER_TASK);
        out.fill(exec, tasks, |task, out| {
            append_where(out, &keep, |out| this.append_task(task, out));
        });
    }
}

/// The pairs among at most sixteen AABBs, in ascending order.
struct Few<'a> {
    aabbs: &'a [Aabb],
    out: &'a mut Vec<Pair>,
}

impl Kernel for Few<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { aabbs, out } = self;
        let last = aabbs.len().min(WIDTH);
        // In registers, since the round trip through memory would stall. The first AABB is never read.
        let mut min = [l.splat(f32::INFINITY); 3];
        let mut max = [l.splat(f32::NEG_INFINITY); 3];
        for (lane, aabb) in aabbs[..last].iter().enumerate().skip(1) {
            let here = l.mask(1 << lane);
            min[0] = l.select(here, l.splat(aabb.min.x), min[0]);
            min[1] = l.select(here, l.splat(aabb.min.y), min[1]);
            min[2] = l.select(here, l.splat(aabb.min.z), min[2]);
            max[0] = l.select(here, l.splat(aabb.max.x), max[0]);
            max[1] = l.select(here, l.splat(aabb.max.y), max[1]);
            max[2] = l.select(here, l.splat(aabb.max.z), max[2]);
        }
        for (i, aabb) in aabbs[..last.saturating_sub(1)].iter().enumerate() {
            let mut all = l.le(min[0], l.splat(aabb.max.x));
            all = l.and(all, l.le(l.splat(aabb.min.x), max[0]));
            all = l.and(all, l.le(min[1], l.splat(aabb.max.y)));
            all = l.and(all, l.le(l.splat(aabb.min.y), max[1]));
            all = l.and(all, l.le(min[2], l.splat(aabb.max.z)));
            all = l.and(all, l.le(l.splat(aabb.min.z), max[2]));
            let mut hits = l.bits(all) & later(i);
            while hits != 0 {
                out.push(Pair { i: i as u32, j: hits.trailing_zeros() });
                hits &= hits - 1;
            }
        }
    }
}

/// The lanes after that one.
#[inline(always)]
fn later(lane: usize) -> u32 {
    0xffff & u32::MAX << (lane + 1)
}
