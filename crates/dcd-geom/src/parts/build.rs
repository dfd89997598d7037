//! How a tree over parts is built: from the top, by the surface areas of what a cut leaves.

use super::tree::PartTree;
use crate::Aabb;
use dcd_simd::WIDTH;
use glam::Vec3;

/// Fills an empty tree.
pub(super) fn build(boxes: &[Aabb], tree: &mut PartTree) {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut cutter = Cutter { boxes, after: Vec::new() };
    let mut inner = Vec::new();
    let mut leaves = Vec::new();
    gather(&mut cutter, &mut order, &mut inner, &mut leaves);
    for leaf in &leaves {
        tree.push(leaf.iter().map(|&part| (boxes[part as usize], part)));
    }
    tree.end_of_leaves();
    // What was gathered last is lowest: so every block is appended after those below it.
    let mut numbers = vec![0; inner.len()];
    for (k, children) in inner.iter().enumerate().rev() {
        let entries: Vec<_> = children
            .iter()
            .map(|child| {
                let number = match *child {
                    Child::Leaf(leaf) => leaf as u32,
                    Child::Inner(inner) => numbers[inner],
                };
                (tree.unions()[number as usize], number)
            })
            .collect();
        numbers[k] = tree.push(entries.into_iter());
    }
}

/// The child of a block, by its index in one of two lists.
enum Child {
    Leaf(usize),
    Inner(usize),
}

/// Cuts the parts into blocks, upper ones first.
fn gather<'a>(
    cutter: &mut Cutter<'_>,
    order: &'a mut [u32],
    inner: &mut Vec<Vec<Child>>,
    leaves: &mut Vec<&'a [u32]>,
) -> Child {
    if order.len() <= WIDTH {
        leaves.push(order);
        return Child::Leaf(leaves.len() - 1);
    }
    let place = inner.len();
    inner.push(Vec::new());
    let groups = cutter.sixteen(order);
    let children: Vec<_> =
        groups.into_iter().map(|group| gather(cutter, group, inner, leaves)).collect();
    inner[place] = children;
    Child::Inner(place)
}

struct Cutter<'a> {
    boxes: &'a [Aabb],
    /// Scratch: the area round all parts from each place on.
    after: Vec<f32>,
}

impl Cutter<'_> {
    /// Cuts more than sixteen parts into at most sixteen groups: the group that is likeliest to be
    /// met and has most below it is cut in two, again and again.
    fn sixteen<'a>(&mut self, order: &'a mut [u32]) -> Vec<&'a mut [u32]> {
        let mut groups = vec![order];
        while groups.len() < WIDTH {
            let weight = |group: &[u32]| {
                if group.len() <= WIDTH { 0.0 } else { self.area(group) * group.len() as f32 }
            };
            let weights: Vec<f32> = groups.iter().map(|group| weight(group)).collect();
            // Ties, as where nothing has an area: the larger, so that none is cut again and again.
            let heaviest =
                (0..groups.len()).filter(|&k| groups[k].len() > WIDTH).max_by(|&j, &k| {
                    let larger = || groups[j].len().cmp(&groups[k].len());
                    weights[j].total_cmp(&weights[k]).then_with(larger)
                });
            let Some(heaviest) = heaviest else { break };
            let group = groups.swap_remove(heaviest);
            let (left, right) = self.halves(group);
            groups.push(left);
            groups.push(right);
        }
        groups
    }

    /// Cuts in two where the sum of surface area times number is least, after a multiple of sixteen
    /// parts: so no leaf but the last is left half empty.
    fn halves<'a>(&mut self, group: &'a mut [u32]) -> (&'a mut [u32], &'a mut [u32]) {
        let mut best = Cut { cost: f32::INFINITY, at: middle(group.len()) };
        let mut best_axis = 0;
        for axis in 0..3 {
            self.sort(group, axis);
            let cut = self.cheapest(group);
            if cut.cost < best.cost {
                (best, best_axis) = (cut, axis);
            }
        }
        if best_axis != 2 {
            self.sort(group, best_axis);
        }
        group.split_at_mut(best.at.min(group.len() - 1))
    }

    fn sort(&self, group: &mut [u32], axis: usize) {
        let centre = |k: u32| self.boxes[k as usize].centre()[axis];
        group.sort_unstable_by(|&j, &k| centre(j).total_cmp(&centre(k)).then(j.cmp(&k)));
    }

    /// The best cut of the sorted group: of those with [`LOPSIDED`] on either side the cheapest, the
    /// nearest to the middle of equals; one nearer an end where that costs at most half of the whole.
    ///
    /// So a cut either leaves a fixed part on each side, or the larger side has at most
    /// 1/2 · 16/15 of the area: no path of the tree has more than log₂ n of the one and, an f32 having
    /// 277 powers of two, 306 of the other. Without the rule parts at one place, whose cuts all cost
    /// the same, would lose sixteen a cut.
    fn cheapest(&mut self, group: &[u32]) -> Cut {
        self.after.clear();
        self.after.resize(group.len(), 0.0);
        let mut all = Aabb::EMPTY;
        for (k, &part) in group.iter().enumerate().rev() {
            all = all.union(&self.boxes[part as usize]);
            self.after[k] = surface(&all);
        }
        let whole = self.after[0] * group.len() as f32;
        let (half, least) = (middle(group.len()), group.len() / LOPSIDED);
        let mut all = Aabb::EMPTY;
        let mut any = Cut { cost: f32::INFINITY, at: half };
        let mut even = any;
        for (k, &part) in group.iter().enumerate() {
            if k > 0 && k % WIDTH == 0 {
                let cost = surface(&all) * k as f32 + self.after[k] * (group.len() - k) as f32;
                let nearer = cost == even.cost && k.abs_diff(half) < even.at.abs_diff(half);
                if k.min(group.len() - k) >= least && (cost < even.cost || nearer) {
                    even = Cut { cost, at: k };
                }
                if cost < any.cost {
                    any = Cut { cost, at: k };
                }
            }
            all = all.union(&self.boxes[part as usize]);
        }
        // Where the whole has no area there is nothing to gain.
        if any.cost <= 0.5 * whole && whole > 0.0 { any } else { even }
    }

    fn area(&self, group: &[u32]) -> f32 {
        let all = group.iter().fold(Aabb::EMPTY, |all, &k| all.union(&self.boxes[k as usize]));
        surface(&all)
    }
}

/// A split of a group, and its cost.
#[derive(Clone, Copy)]
struct Cut {
    cost: f32,
    at: usize,
}

/// The part of a group that a cut leaves on either side unless it is worth more: one in so many.
/// Larger: deeper trees over parts at one place. Smaller: worse cuts of ordinary surfaces.
const LOPSIDED: usize = 16;

/// The multiple of sixteen next above half.
fn middle(count: usize) -> usize {
    count.div_ceil(2 * WIDTH) * WIDTH
}

/// Half of an AABB's surface.
fn surface(aabb: &Aabb) -> f32 {
    let Vec3 { x, y, z } = aabb.max - aabb.min;
    x * y + y * z + z * x
}
