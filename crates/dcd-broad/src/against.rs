//! Boxes against a tree that stands still.

use dcd_bvh::{Sixteen, WideBvh};
use dcd_exec::{Exec, Segments};
use dcd_geom::lanes::{Kernel, Lanes, Path, WIDTH, dispatch_on};
use dcd_geom::{Aabb, Pair};

/// A wide tree over boxes that stay, asked for the boxes that other boxes overlap.
///
/// Each box has a name, the index of its object; pairs are told by name.
#[derive(Clone, Debug)]
pub struct StandingTree {
    tree: WideBvh,
    names: Vec<u32>,
    path: Path,
}

impl Default for StandingTree {
    fn default() -> Self {
        Self::on(Path::best())
    }
}

/// Boxes and their names, as many.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// The boxes, valid ones.
    pub aabbs: &'a [Aabb],
    /// The index of each box's object.
    pub names: &'a [u32],
}

/// How many boxes a task asks for: some tens of microseconds.
const BOXES_PER_TASK: usize = 256;

impl StandingTree {
    /// On that path, or the portable one where this CPU does not have it. The pairs and their
    /// order are the same on every path; for tests and measurements.
    pub fn on(path: Path) -> Self {
        Self { tree: WideBvh::default(), names: Vec::new(), path }
    }

    /// Takes in the boxes that stay, in place of those before.
    pub fn build(&mut self, boxes: Named, exec: Exec) {
        self.tree.build(boxes.aabbs, exec);
        self.names.clear();
        self.names.extend_from_slice(boxes.names);
    }

    /// Replaces `out` by the pairs i < j of a name asked for and a name that stays whose closed
    /// boxes overlap and for which `keep(i, j)` holds: box by box as they are asked, in the order
    /// of the tree. No name may be on both sides. The list does not depend on `exec`.
    pub fn pairs(
        &self,
        asked: Named,
        keep: impl Fn(u32, u32) -> bool + Sync,
        exec: Exec,
        out: &mut Segments<Pair>,
    ) {
        let count = asked.aabbs.len().min(asked.names.len());
        out.fill(exec, count.div_ceil(BOXES_PER_TASK), |task, out| {
            let part = BOXES_PER_TASK * task..count.min(BOXES_PER_TASK * (task + 1));
            let asked = Named { aabbs: &asked.aabbs[part.clone()], names: &asked.names[part] };
            self.append_pairs(asked, &keep, out);
        });
    }

    /// Appends the same pairs to a list: for tasks of one's own.
    pub fn append_pairs(&self, asked: Named, keep: impl Fn(u32, u32) -> bool, out: &mut Vec<Pair>) {
        let search = Search { tree: &self.tree, names: &self.names, asked, keep: &keep, out };
        dispatch_on(self.path, search);
    }
}

/// The pairs of some boxes with those of a tree.
struct Search<'a, K> {
    tree: &'a WideBvh,
    names: &'a [u32],
    asked: Named<'a>,
    keep: &'a K,
    out: &'a mut Vec<Pair>,
}

/// Height and number of the nodes still to be asked: at most sixteen for each level but the
/// lowest, and a u32 counts the boxes of at most eight levels.
type Stack = [(usize, usize); 8 * WIDTH];

impl<K: Fn(u32, u32) -> bool> Kernel for Search<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let Some(top) = self.tree.levels().len().checked_sub(1) else { return };
        let mut stack: Stack = [(0, 0); 8 * WIDTH];
        for k in 0..self.asked.aabbs.len() {
            let asked = Spread::of(l, &self.asked.aabbs[k]);
            stack[0] = (top, 0);
            let mut waiting = 1;
            while waiting > 0 {
                waiting -= 1;
                let (height, node) = stack[waiting];
                let mut below = asked.overlaps(l, &self.tree.levels()[height][node]);
                while below != 0 {
                    let child = node * WIDTH + below.trailing_zeros() as usize;
                    below &= below - 1;
                    if height > 0 {
                        stack[waiting] = (height - 1, child);
                        waiting += 1;
                    } else {
                        let hits = asked.overlaps(l, &self.tree.leaves()[child]);
                        self.emit(self.asked.names[k], child, hits);
                    }
                }
            }
        }
    }
}

impl<K: Fn(u32, u32) -> bool> Search<'_, K> {
    /// Appends the pairs of one name with the lanes `hits` of a leaf.
    #[inline(always)]
    fn emit(&mut self, asked: u32, leaf: usize, mut hits: u32) {
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let stays = self.names[self.tree.ids()[leaf].0[lane] as usize];
            let pair = Pair::new(asked, stays);
            if (self.keep)(pair.i, pair.j) {
                self.out.push(pair);
            }
        }
    }
}

/// One box in every lane.
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

    /// Which of sixteen boxes overlap it; empty boxes never do.
    #[inline(always)]
    fn overlaps(&self, l: L, boxes: &Sixteen) -> u32 {
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
    use glam::Vec3;

    /// Boxes on a spiral, of many sizes, some touching others exactly.
    fn boxes(count: usize, turn: f32) -> Vec<Aabb> {
        let at = |k: usize| {
            let t = k as f32;
            let centre = Vec3::new((t * turn).sin() * t, (t * 0.73).cos() * t, t % 17.0) * 0.1;
            let half = Vec3::new(0.5 + t % 3.0, 0.5, 0.25);
            Aabb { min: (centre - half).floor(), max: (centre + half).ceil() }
        };
        (0..count).map(at).collect()
    }

    /// The plainest judge, in the order of the boxes asked.
    fn expected(stay: Named, asked: Named) -> Vec<(u32, Pair)> {
        let mut pairs = Vec::new();
        for (a, &i) in asked.aabbs.iter().zip(asked.names) {
            let hits = stay.aabbs.iter().zip(stay.names).filter(|(b, _)| a.overlaps(b));
            pairs.extend(hits.map(|(_, &j)| (i, Pair::new(i, j))));
        }
        pairs
    }

    #[test]
    fn each_overlap_is_told_once_box_by_box_on_every_path_and_at_every_size() {
        for (stay, ask) in [(0, 5), (5, 0), (1, 1), (16, 40), (17, 300), (300, 600), (5000, 700)] {
            let (stays, asks) = (boxes(stay, 0.37), boxes(ask, 0.61));
            // Odd names stay, even ones ask.
            let odd: Vec<u32> = (0..stay as u32).map(|k| 2 * k + 1).collect();
            let even: Vec<u32> = (0..ask as u32).map(|k| 2 * k).collect();
            let stays = Named { aabbs: &stays, names: &odd };
            let asks = Named { aabbs: &asks, names: &even };
            let expected = expected(stays, asks);
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let mut tree = StandingTree::on(path);
                tree.build(stays, Par::Serial.into());
                for par in [Par::Serial, Par::Pool] {
                    let mut out = Segments::default();
                    tree.pairs(asks, |_, _| true, par.into(), &mut out);
                    let told: Vec<Pair> = out.iter().flatten().copied().collect();
                    let who = |pair: &Pair| if pair.i.is_multiple_of(2) { pair.i } else { pair.j };
                    assert!(told.iter().map(who).is_sorted(), "the boxes are out of order");
                    let mut told: Vec<_> = told.iter().map(|pair| (who(pair), *pair)).collect();
                    told.sort_unstable();
                    let mut expected = expected.clone();
                    expected.sort_unstable();
                    assert_eq!(told, expected, "{stay} and {ask} on {path:?}");
                }
            }
        }
    }

    #[test]
    fn a_refused_pair_is_not_told_and_is_asked_for_in_ascending_order() {
        let boxes = vec![Aabb { min: Vec3::ZERO, max: Vec3::ONE }; 40];
        let names: Vec<u32> = (0..40).collect();
        let mut tree = StandingTree::default();
        tree.build(Named { aabbs: &boxes[..20], names: &names[20..] }, Par::Serial.into());
        let mut out = Vec::new();
        let keep = |i: u32, j: u32| {
            assert!(i < 20 && j >= 20);
            (i + j).is_multiple_of(3)
        };
        tree.append_pairs(Named { aabbs: &boxes[..20], names: &names[..20] }, keep, &mut out);
        assert_eq!(out.len(), (0..400).filter(|k| (k / 20 + 20 + k % 20) % 3 == 0).count());
        assert!(out.iter().all(|pair| (pair.i + pair.j).is_multiple_of(3)));
    }
}
