//! AABBs against a tree of static objects.

use crate::append::append_where;
use crate::{Aabb128, Mask128};
use dcd_bvh::WideBvh;
use dcd_exec::{Exec, Segments};
use dcd_geom::glam::Vec3;
use dcd_geom::{Aabb, Aabb16, Pair};
use dcd_simd::{IndexRow, Kernel, Lanes, Path, WIDTH, dispatch_on};

/// A wide tree over static AABBs, queried with other AABBs.
///
/// Each AABB has a name, the index of its object; pairs are reported by name.
///
/// ```
/// use dcd_broad::{IdentifiedAabbs, StaticTree};
/// use dcd_exec::{Exec, Par};
/// use dcd_geom::{Aabb, Pair, glam::Vec3};
/// let unit = |x: f32| Aabb { min: Vec3::new(x, 0.0, 0.0), max: Vec3::new(x + 1.0, 1.0, 1.0) };
/// let walls = [unit(0.0), unit(5.0)];
/// let mut tree = StaticTree::default();
/// tree.build(IdentifiedAabbs { aabbs: &walls, names: &[3, 4] }, Exec::from(Par::Serial));
/// let (moving, mut pairs) = ([unit(4.5)], Vec::new());
/// let query = IdentifiedAabbs { aabbs: &moving, names: &[9] };
/// tree.append_pairs(query, |_, _| true, &mut pairs);
/// assert_eq!(pairs, [Pair { i: 4, j: 9 }]);
/// ```
#[derive(Clone, Debug)]
pub struct StaticTree {
    tree: WideBvh,
    /// For each leaf the names of its AABBs; lanes past the end name any.
    names: Vec<IndexRow>,
    path: Path,
}

impl Default for StaticTree {
    fn default() -> Self {
        Self::on(Path::best())
    }
}

/// AABBs and as many names.
#[derive(Clone, Copy, Debug)]
pub struct IdentifiedAabbs<'a> {
    /// The AABBs, valid ones.
    pub aabbs: &'a [Aabb],
    /// The index of each AABB's object.
    pub names: &'a [u32],
}

/// How many AABBs a task queries: some tens of microseconds.
const BOXES_PER_TASK: usize = 256;

impl StaticTree {
    /// A tree on that path, or the portable one where this CPU does not have it. The pairs and their
    /// order are the same on every path; for tests and measurements.
    pub fn on(path: Path) -> Self {
        Self { tree: WideBvh::default(), names: Vec::new(), path }
    }

    /// The tree, over the AABBs in the order in which it was given them.
    pub fn tree(&self) -> &WideBvh {
        &self.tree
    }

    /// Builds the tree over static AABBs, in place of those before.
    pub fn build(&mut self, boxes: IdentifiedAabbs, exec: Exec) {
        self.tree.build(boxes.aabbs, exec);
        self.names.clear();
        // Lanes past the end are 0, which is an AABB wherever there is a leaf.
        let name = |id: u32| boxes.names[id as usize];
        self.names.extend(self.tree.ids().iter().map(|ids| IndexRow(ids.0.map(name))));
    }

    /// Replaces `out` by the pairs i < j of a query's name and a static name whose closed
    /// AABBs overlap and for which `keep(i, j)` holds: query by query, in the order
    /// of the tree. No name may be on both sides. The list does not depend on `exec`.
    pub fn pairs(
        &self,
        query: IdentifiedAabbs,
        keep: impl Fn(u32, u32) -> bool + Sync,
        exec: Exec,
        out: &mut Segments<Pair>,
    ) {
        let count = query.aabbs.len().min(query.names.len());
        out.fill(exec, count.div_ceil(BOXES_PER_TASK), |task, out| {
            let part = BOXES_PER_TASK * task..count.min(BOXES_PER_TASK * (task + 1));
            let query =
                IdentifiedAabbs { aabbs: &query.aabbs[part.clone()], names: &query.names[part] };
            self.append_pairs(query, &keep, out);
        });
    }

    /// Appends the same pairs to a list: for tasks of one's own.
    pub fn append_pairs(
        &self,
        query: IdentifiedAabbs,
        keep: impl Fn(u32, u32) -> bool,
        out: &mut Vec<Pair>,
    ) {
        append_where(out, keep, |out| self.append_all(query, out));
    }

    fn append_all(&self, query: IdentifiedAabbs, out: &mut Vec<Pair>) {
        dispatch_on(
            self.path,
            StaticTreeSearch { tree: &self.tree, names: &self.names, query, out },
        );
    }

    /// Which of the AABBs of a row, out of those that `which` has, overlap any
    /// static one.
    pub fn reached(&self, query: &Aabb128, which: Mask128) -> Mask128 {
        dispatch_on(self.path, Reach { tree: &self.tree, query, which })
    }
}

/// Which AABBs of a row overlap any of a tree.
struct Reach<'a> {
    tree: &'a WideBvh,
    query: &'a Aabb128,
    which: Mask128,
}

impl Kernel for Reach<'_> {
    type Output = Mask128;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Mask128 {
        let mut reached = 0;
        for (k, boxes) in self.query.boxes.iter().enumerate() {
            let which = (self.which >> (k * WIDTH)) as u32 & 0xffff;
            if which != 0 {
                reached |= Mask128::from(self.sixteen(l, boxes, which)) << (k * WIDTH);
            }
        }
        reached
    }
}

impl Reach<'_> {
    /// Which of sixteen AABBs overlap any: at the top all at once, below one by one.
    #[inline(always)]
    fn sixteen<L: Lanes>(&self, l: L, boxes: &Aabb16, which: u32) -> u32 {
        let Some((top, below)) = self.tree.levels().split_last() else { return 0 };
        let children = below.last().map_or(self.tree.leaves().len(), Vec::len);
        let mut open = which;
        for child in 0..children.min(WIDTH) {
            let union = Spread::<L>::lane(l, &top[0], child);
            let mut near = open & union.overlaps(l, boxes);
            while near != 0 {
                let k = near.trailing_zeros() as usize;
                near &= near - 1;
                let query = Spread::lane(l, boxes, k);
                if self.any_below(l, child, &query) {
                    open &= !(1 << k);
                }
            }
        }
        which & !open
    }

    /// Whether an AABB overlaps any below a child of the top.
    #[inline(always)]
    fn any_below<L: Lanes>(&self, l: L, child: usize, query: &Spread<L>) -> bool {
        let height = self.tree.levels().len() - 1;
        if height == 0 {
            return query.overlaps(l, &self.tree.leaves()[child]) != 0;
        }
        let mut walk = Walk::from(height, child as u32);
        while let Some(leaf) = walk.next(l, self.tree, query) {
            if query.overlaps(l, &self.tree.leaves()[leaf]) != 0 {
                return true;
            }
        }
        false
    }
}

/// An AABB without infinite sides, which would overlap the empty AABBs that fill up a leaf.
#[inline(always)]
fn finite(aabb: &Aabb) -> Aabb {
    Aabb { min: aabb.min.max(Vec3::MIN), max: aabb.max.min(Vec3::MAX) }
}

/// Finds the pairs of query AABBs with those of a tree.
struct StaticTreeSearch<'a> {
    tree: &'a WideBvh,
    names: &'a [IndexRow],
    query: IdentifiedAabbs<'a>,
    out: &'a mut Vec<Pair>,
}

impl Kernel for StaticTreeSearch<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        for k in 0..self.query.aabbs.len() {
            let query = Spread::of(l, &finite(&self.query.aabbs[k]));
            let mut walk = Walk::from(self.tree.levels().len(), 0);
            while let Some(leaf) = walk.next(l, self.tree, &query) {
                let hits = query.overlaps(l, &self.tree.leaves()[leaf]);
                self.emit(l, self.query.names[k], leaf, hits);
            }
        }
    }
}

/// A depth-first traversal, from leaf to leaf that an AABB may overlap.
struct Walk {
    /// Above which level it begins, and on which one it is, from the lowest.
    start: usize,
    height: usize,
    /// Where it begins.
    root: u32,
    /// Where it is on each level, and which of the children there it has still to see. A u32 counts
    /// the AABBs of at most eight levels.
    nodes: [u32; 8],
    children: [u32; 8],
}

impl Walk {
    /// A walk from the node of that number on the level below that height.
    #[inline(always)]
    fn from(start: usize, root: u32) -> Self {
        Self { start, height: start, root, nodes: [0; 8], children: [0; 8] }
    }

    /// The next leaf whose union the AABB overlaps.
    #[inline(always)]
    fn next<L: Lanes>(&mut self, l: L, tree: &WideBvh, query: &Spread<L>) -> Option<usize> {
        if self.height == self.start {
            self.enter(l, tree, query, self.root)?;
        }
        loop {
            let children = &mut self.children[self.height];
            let first = self.nodes[self.height] << WIDTH.trailing_zeros();
            if *children == 0 {
                self.height += 1;
                if self.height == self.start {
                    return None;
                }
            } else if self.height == 0 {
                let child = first + children.trailing_zeros();
                *children &= *children - 1;
                return Some(child as usize);
            } else {
                // The last one first, as from a stack.
                let last = u32::BITS - 1 - children.leading_zeros();
                *children ^= 1 << last;
                self.enter(l, tree, query, first + last)?;
            }
        }
    }

    /// Goes down to a node. `None` where there is no level below.
    #[inline(always)]
    fn enter<L: Lanes>(
        &mut self,
        l: L,
        tree: &WideBvh,
        query: &Spread<L>,
        node: u32,
    ) -> Option<()> {
        self.height = self.height.checked_sub(1)?;
        self.nodes[self.height] = node;
        self.children[self.height] = query.overlaps(l, &tree.levels()[self.height][node as usize]);
        Some(())
    }
}

impl StaticTreeSearch<'_> {
    /// Appends the pairs of one name with the lanes `hits` of a leaf.
    #[inline(always)]
    fn emit<L: Lanes>(&mut self, l: L, query: u32, leaf: usize, hits: u32) {
        l.append_pairs(hits, (query, l.load_u(&self.names[leaf])), self.out);
    }
}

/// One AABB in every lane.
#[derive(Clone, Copy)]
struct Spread<L: Lanes> {
    min: [L::F; 3],
    max: [L::F; 3],
}

impl<L: Lanes> Spread<L> {
    #[inline(always)]
    fn of(l: L, aabb: &Aabb) -> Self {
        let (min, max) = (aabb.min, aabb.max);
        Self {
            min: [l.splat(min.x), l.splat(min.y), l.splat(min.z)],
            max: [l.splat(max.x), l.splat(max.y), l.splat(max.z)],
        }
    }

    /// One of sixteen.
    #[inline(always)]
    fn lane(l: L, boxes: &Aabb16, k: usize) -> Self {
        let [min, max] = [&boxes.min, &boxes.max];
        Self {
            min: [l.splat(min[0].0[k]), l.splat(min[1].0[k]), l.splat(min[2].0[k])],
            max: [l.splat(max[0].0[k]), l.splat(max[1].0[k]), l.splat(max[2].0[k])],
        }
    }

    /// Which of sixteen AABBs overlap it; empty AABBs never do.
    #[inline(always)]
    fn overlaps(&self, l: L, boxes: &Aabb16) -> u32 {
        let mut all = l.le(l.load(&boxes.min[0]), self.max[0]);
        all = l.and(all, l.le(self.min[0], l.load(&boxes.max[0])));
        for axis in 1..3 {
            all = l.and(all, l.le(l.load(&boxes.min[axis]), self.max[axis]));
            all = l.and(all, l.le(self.min[axis], l.load(&boxes.max[axis])));
        }
        l.bits(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_exec::Par;

    /// AABBs on a spiral, of many sizes, some touching others exactly.
    fn boxes(count: usize, turn: f32) -> Vec<Aabb> {
        let at = |k: usize| {
            let t = k as f32;
            let centre = Vec3::new((t * turn).sin() * t, (t * 0.73).cos() * t, t % 17.0) * 0.1;
            let half = Vec3::new(0.5 + t % 3.0, 0.5, 0.25);
            Aabb { min: (centre - half).floor(), max: (centre + half).ceil() }
        };
        (0..count).map(at).collect()
    }

    /// Brute force, in the order of the queries.
    fn expected(stay: IdentifiedAabbs, query: IdentifiedAabbs) -> Vec<(u32, Pair)> {
        let mut pairs = Vec::new();
        for (a, &i) in query.aabbs.iter().zip(query.names) {
            let hits = stay.aabbs.iter().zip(stay.names).filter(|(b, _)| a.overlaps(b));
            pairs.extend(hits.map(|(_, &j)| (i, Pair::new(i, j))));
        }
        pairs
    }

    #[test]
    fn each_overlap_is_reported_once_box_by_box_on_every_path_and_at_every_size() {
        for (stay, queried) in
            [(0, 5), (5, 0), (1, 1), (16, 40), (17, 300), (300, 600), (5000, 700)]
        {
            let (stays, queries) = (boxes(stay, 0.37), boxes(queried, 0.61));
            // Static names are odd, queries even.
            let odd: Vec<u32> = (0..stay as u32).map(|k| 2 * k + 1).collect();
            let even: Vec<u32> = (0..queried as u32).map(|k| 2 * k).collect();
            let stays = IdentifiedAabbs { aabbs: &stays, names: &odd };
            let queries = IdentifiedAabbs { aabbs: &queries, names: &even };
            let expected = expected(stays, queries);
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let mut tree = StaticTree::on(path);
                tree.build(stays, Par::Serial.into());
                for par in [Par::Serial, Par::Pool] {
                    let mut out = Segments::default();
                    tree.pairs(queries, |_, _| true, par.into(), &mut out);
                    let reported: Vec<Pair> = out.iter().flatten().copied().collect();
                    let who = |pair: &Pair| if pair.i.is_multiple_of(2) { pair.i } else { pair.j };
                    assert!(reported.iter().map(who).is_sorted(), "the boxes are out of order");
                    let mut reported: Vec<_> =
                        reported.iter().map(|pair| (who(pair), *pair)).collect();
                    reported.sort_unstable();
                    let mut expected = expected.clone();
                    expected.sort_unstable();
                    assert_eq!(reported, expected, "{stay} and {queried} on {path:?}");
                }
            }
        }
    }

    #[test]
    fn a_box_is_reached_where_it_has_a_pair_on_every_path_and_at_every_size() {
        for stay in [0, 1, 17, 300, 5000] {
            let (stays, queries) = (boxes(stay, 0.37), boxes(stay / 2 + 64, 0.61));
            let queries = &queries[queries.len() - 64..];
            let names: Vec<u32> = (0..stay as u32).collect();
            let mut row = Aabb128::default();
            queries.iter().enumerate().for_each(|(k, aabb)| row.set(k, aabb));
            let which = 0xffff_f0f0_ffff_0ff3;
            let meets = |k: &usize| stays.iter().any(|stay| stay.overlaps(&queries[*k]));
            let due = (0..64).filter(meets).fold(0, |bits, k| bits | 1 << k) & which;
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let mut tree = StaticTree::on(path);
                tree.build(IdentifiedAabbs { aabbs: &stays, names: &names }, Par::Serial.into());
                assert_eq!(tree.reached(&row, which), due, "{stay} on {path:?}");
            }
        }
    }

    #[test]
    fn a_box_without_an_end_meets_every_box_once() {
        for count in [1, 7, 16, 100] {
            let at = |k: u32| Vec3::splat(k as f32);
            let boxes: Vec<Aabb> =
                (0..count).map(|k| Aabb { min: at(k), max: at(k) + Vec3::ONE }).collect();
            let names: Vec<u32> = (0..count).collect();
            let mut tree = StaticTree::default();
            tree.build(IdentifiedAabbs { aabbs: &boxes, names: &names }, Exec::from(Par::Serial));
            let query = [Aabb::EVERYTHING, Aabb::EMPTY];
            let query = IdentifiedAabbs { aabbs: &query, names: &[1000, 1001] };
            let mut pairs = Vec::new();
            tree.append_pairs(query, |_, _| true, &mut pairs);
            pairs.sort_unstable();
            let all: Vec<Pair> = (0..count).map(|i| Pair { i, j: 1000 }).collect();
            assert_eq!(pairs, all);
        }
    }

    #[test]
    fn a_refused_pair_is_not_reported_and_keep_sees_ascending_indices() {
        let boxes = vec![Aabb { min: Vec3::ZERO, max: Vec3::ONE }; 40];
        let names: Vec<u32> = (0..40).collect();
        let mut tree = StaticTree::default();
        tree.build(
            IdentifiedAabbs { aabbs: &boxes[..20], names: &names[20..] },
            Par::Serial.into(),
        );
        let mut out = Vec::new();
        let keep = |i: u32, j: u32| {
            assert!(i < 20 && j >= 20);
            (i + j).is_multiple_of(3)
        };
        tree.append_pairs(
            IdentifiedAabbs { aabbs: &boxes[..20], names: &names[..20] },
            keep,
            &mut out,
        );
        assert_eq!(out.len(), (0..400).filter(|k| (k / 20 + 20 + k % 20) % 3 == 0).count());
        assert!(out.iter().all(|pair| (pair.i + pair.j).is_multiple_of(3)));
    }
}
