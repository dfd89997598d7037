//! How a tree over parts is built: from the top, by the surface areas of what a cut leaves.

use super::tree::PartTree;
use crate::Aabb;
use crate::lanes::WIDTH;
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

/// What stands below a block, by its place in one of two lists.
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
            // NaN and ties: the last is as good as any.
            let heaviest = (0..groups.len())
                .filter(|&k| groups[k].len() > WIDTH)
                .max_by(|&j, &k| weight(groups[j]).total_cmp(&weight(groups[k])));
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
        let mut best = (f32::INFINITY, 0, group.len().div_ceil(2 * WIDTH) * WIDTH);
        for axis in 0..3 {
            self.sort(group, axis);
            if let Some((cost, at)) = self.cheapest(group)
                && cost < best.0
            {
                best = (cost, axis, at);
            }
        }
        if best.1 != 2 {
            self.sort(group, best.1);
        }
        group.split_at_mut(best.2.min(group.len() - 1))
    }

    fn sort(&self, group: &mut [u32], axis: usize) {
        let centre = |k: u32| self.boxes[k as usize].centre()[axis];
        group.sort_unstable_by(|&j, &k| centre(j).total_cmp(&centre(k)).then(j.cmp(&k)));
    }

    /// The least cost of a cut of the sorted group, and where.
    fn cheapest(&mut self, group: &[u32]) -> Option<(f32, usize)> {
        self.after.clear();
        self.after.resize(group.len(), 0.0);
        let mut all = Aabb::EMPTY;
        for (k, &part) in group.iter().enumerate().rev() {
            all = all.union(&self.boxes[part as usize]);
            self.after[k] = surface(&all);
        }
        let mut all = Aabb::EMPTY;
        let mut best: Option<(f32, usize)> = None;
        for (k, &part) in group.iter().enumerate() {
            if k > 0 && k % WIDTH == 0 {
                let cost = surface(&all) * k as f32 + self.after[k] * (group.len() - k) as f32;
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, k));
                }
            }
            all = all.union(&self.boxes[part as usize]);
        }
        best
    }

    fn area(&self, group: &[u32]) -> f32 {
        let all = group.iter().fold(Aabb::EMPTY, |all, &k| all.union(&self.boxes[k as usize]));
        surface(&all)
    }
}

/// Half of a box's surface.
fn surface(aabb: &Aabb) -> f32 {
    let Vec3 { x, y, z } = aabb.max - aabb.min;
    x * y + y * z + z * x
}
