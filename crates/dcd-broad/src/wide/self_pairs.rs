//! The wide tree against itself: the AABBs of each leaf with themselves and with those of later leaves.
//!
//! A leaf's work passes queues, each step of which runs over all that waits for it: leaves whose union it reaches, its own AABBs
//! that reach another leaf's union, those that overlap some of the other's. How many come of one is known to no branch predictor;
//! what comes is written to the end of the next queue and counted, and no step branches on it.

use super::later;
use dcd_bvh::WideBvh;
use dcd_geom::Pair;
use dcd_simd::{ArrayVec, Kernel, LaneNumbers, Lanes, WIDTH};
use std::ops::Range;

/// The pairs of some leaves, with themselves and with the leaves after.
pub(super) struct SelfPairSearch<'a> {
    pub(super) tree: &'a WideBvh,
    pub(super) leaves: Range<usize>,
    pub(super) out: &'a mut Vec<Pair>,
}

/// How much a queue holds before what the last entry adds. No effect on any result. Larger: more of the nearest cache. Smaller: more loops that end at a number
/// that is not predicted.
const HELD: usize = 128;

/// Numbers that wait, in order.
type Queue = LaneNumbers<{ HELD + 2 * WIDTH }>;

/// An AABB of the leaf and those of another that it overlaps.
#[derive(Clone, Copy, Default)]
struct Hit {
    id: u32,
    leaf: u32,
    lanes: u32,
}

/// Those that wait for being appended: of the leaf itself, and of each AABB that waited one at most.
struct Hits {
    hits: [Hit; HELD + 2 * WIDTH],
    count: usize,
}

impl Default for Hits {
    fn default() -> Self {
        Self { hits: [Hit::default(); HELD + 2 * WIDTH], count: 0 }
    }
}

impl Hits {
    /// Written in any case, and kept if there are lanes.
    #[inline(always)]
    fn push(&mut self, hit: Hit) {
        self.hits[self.count] = hit;
        self.count += usize::from(hit.lanes != 0);
    }
}

/// What waits of a leaf.
#[derive(Default)]
struct Queues {
    /// Later leaves whose union it reaches.
    others: Queue,
    /// Sixteen times such a leaf, and the lane of an AABB that reaches its union.
    reaching: Queue,
    hits: Hits,
}

/// Height and number of the nodes still to be visited. A node is replaced by at most sixteen of the
/// level below, and a u32 counts the AABBs of at most eight levels.
type Stack = ArrayVec<(usize, usize), { 8 * WIDTH }>;

impl Kernel for SelfPairSearch<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let mut queues = Queues::default();
        let mut stack = Stack::default();
        for from in self.leaves.clone() {
            let around = self.tree.levels()[0][from / WIDTH].get(from % WIDTH);
            self.within(l, from, &mut queues.hits);
            if let Some(top) = self.tree.levels().len().checked_sub(1) {
                stack.push((top, 0));
            }
            while let Some((height, node)) = stack.pop() {
                let first = node * WIDTH;
                // Without those whose last leaf is this one or before.
                let before = (from + usize::from(height == 0)) >> (4 * height);
                let after = 0xffff << before.saturating_sub(first).min(WIDTH);
                let mut below = self.tree.levels()[height][node].overlaps(l, &around) & after;
                if height == 0 {
                    queues.others.push(l, below, first);
                    if !queues.others.has_room() {
                        l.call(Reach { search: &mut self, from, queues: &mut queues });
                    }
                    continue;
                }
                while below != 0 {
                    stack.push((height - 1, first + below.trailing_zeros() as usize));
                    below &= below - 1;
                }
            }
            l.call(Reach { search: &mut self, from, queues: &mut queues });
            l.call(Overlap { search: &mut self, from, queues: &mut queues });
        }
    }
}

impl SelfPairSearch<'_> {
    /// The pairs within a leaf.
    #[inline(always)]
    fn within<L: Lanes>(&mut self, l: L, leaf: usize, hits: &mut Hits) {
        let boxes = &self.tree.leaves()[leaf];
        for lane in 0..self.tree.boxes_in(leaf) {
            let lanes = boxes.overlaps(l, &boxes.get(lane)) & later(lane);
            hits.push(Hit { id: self.tree.ids()[leaf].0[lane], leaf: leaf as u32, lanes });
        }
    }
}

/// Which AABBs of a leaf reach the unions of the others that wait.
struct Reach<'a, 'b> {
    search: &'a mut SelfPairSearch<'b>,
    from: usize,
    queues: &'a mut Queues,
}

impl Kernel for Reach<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { search, from, queues } = self;
        let tree = search.tree;
        let boxes = &tree.leaves()[from];
        for k in 0..queues.others.len() {
            let other = queues.others[k] as usize;
            let node = &tree.levels()[0][other / WIDTH];
            let reaching = boxes.overlaps(l, &node.get(other % WIDTH));
            queues.reaching.push(l, reaching, other * WIDTH);
            if !queues.reaching.has_room() {
                l.call(Overlap { search: &mut *search, from, queues: &mut *queues });
            }
        }
        queues.others.clear();
    }
}

/// Which AABBs of other leaves those overlap that wait. Their pairs are appended, and those that waited for it.
struct Overlap<'a, 'b> {
    search: &'a mut SelfPairSearch<'b>,
    from: usize,
    queues: &'a mut Queues,
}

impl Kernel for Overlap<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { search: SelfPairSearch { tree, out, .. }, from, queues } = self;
        let Queues { reaching, hits, .. } = queues;
        let (boxes, ids) = (&tree.leaves()[from], &tree.ids()[from]);
        for &number in &**reaching {
            let (other, lane) = (number as usize / WIDTH, number as usize % WIDTH);
            let lanes = tree.leaves()[other].overlaps(l, &boxes.get(lane));
            hits.push(Hit { id: ids.0[lane], leaf: other as u32, lanes });
        }
        reaching.clear();
        for &Hit { id, leaf, lanes } in &hits.hits[..hits.count] {
            l.append_pairs(lanes, (id, l.load_u(&tree.ids()[leaf as usize])), out);
        }
        hits.count = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BroadPhase, WideTree};
    use dcd_exec::{Par, Segments};
    use dcd_geom::{Aabb, glam::Vec3};
    use dcd_simd::Path;

    #[test]
    fn where_leaves_reach_more_others_than_a_queue_holds_no_pair_is_lost() {
        // Boxes round one point: each leaf reaches all others.
        let count = (HELD as u32 + 24) * WIDTH as u32;
        let half = |k: u32, by: u32| 1.0 + (k * by % 97) as f32;
        let aabb = |k| {
            let half = Vec3::new(half(k, 31), half(k, 53), half(k, 71));
            Aabb { min: -half, max: half }
        };
        let aabbs: Vec<Aabb> = (0..count).map(aabb).collect();
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let (mut tree, mut pairs) = (WideTree::on(path), Segments::default());
            tree.build(&aabbs, Par::Serial.into());
            tree.pairs(&aabbs, |_, _| true, Par::Serial.into(), &mut pairs);
            let mut pairs: Vec<Pair> = pairs.iter().flatten().copied().collect();
            pairs.sort_unstable();
            let due = (0..count).flat_map(|i| (i + 1..count).map(move |j| Pair { i, j }));
            assert!(pairs.into_iter().eq(due), "{path:?}");
        }
    }
}
