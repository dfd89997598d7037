//! Queries of a tree over parts: parts by ascending key.

use super::PartTree;
use dcd_simd::{ArrayVec, BoxTest, Kernel, Lanes, Path, Row, WIDTH, dispatch_on, nearest_first};

/// Which parts of a leaf whose boxes are near are worth a visit.
pub trait LeafFilter {
    /// Whether it is asked for the lanes alone whose boxes are near. If not, the boxes of leaves are not looked at, and all
    /// parts of a leaf have the key of the box round it, or 0 if there is no other leaf: for filters that are as sharp, and read other memory.
    const AFTER_BOXES: bool = true;

    /// Which of these lanes of a leaf's block, by its number, are to be visited. To be marked `#[inline(always)]`.
    fn keep<L: Lanes>(&self, l: L, leaf: usize, lanes: u32) -> u32;
}

/// All whose boxes are near.
struct Every;

impl LeafFilter for Every {
    #[inline(always)]
    fn keep<L: Lanes>(&self, _: L, _: usize, lanes: u32) -> u32 {
        lanes
    }
}

impl PartTree {
    /// Calls `visit(part, key)` for each part whose box has a key of at most the limit, nearer blocks first, and
    /// takes what it returns for the limit from then on; a negative one ends the search. The order depends on the
    /// tree and on the limits alone.
    pub fn visit(&self, test: &impl BoxTest, limit: f32, visit: &mut dyn FnMut(u32, f32) -> f32) {
        self.visit_filtered((test, &Every), limit, visit);
    }

    /// The same of the parts alone that a filter of the leaves keeps.
    pub fn visit_filtered(
        &self,
        (test, leaves): (&impl BoxTest, &impl LeafFilter),
        limit: f32,
        visit: &mut dyn FnMut(u32, f32) -> f32,
    ) {
        dispatch_on(Path::best(), Visit { tree: self, test, leaves, limit, visit });
    }
}

impl PartTree {
    /// Calls `visit(part)` for each part whose box has a key of at most the limit, while it returns true; in an order that
    /// depends on the tree and on the limit alone.
    pub fn visit_within(
        &self,
        test: &impl BoxTest,
        limit: f32,
        visit: &mut dyn FnMut(u32) -> bool,
    ) {
        dispatch_on(Path::best(), VisitWithin { tree: self, test, limit, visit });
    }
}

/// How many blocks wait in most searches: more take memory of the heap.
const WAITING: usize = 4 * WIDTH;

/// A stack whose first entries are in its own memory, so that most searches do not allocate. How high a tree is depends
/// on the parts: see how it is built.
#[derive(Default)]
struct Stack<T: Copy> {
    first: ArrayVec<T, WAITING>,
    more: Vec<T>,
}

impl<T: Copy> Stack<T> {
    #[inline(always)]
    fn push(&mut self, entry: T) {
        if self.first.len() < WAITING { self.first.push(entry) } else { self.more.push(entry) }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<T> {
        if self.more.is_empty() { self.first.pop() } else { self.more.pop() }
    }
}

struct VisitWithin<'a, T> {
    tree: &'a PartTree,
    test: &'a T,
    limit: f32,
    visit: &'a mut dyn FnMut(u32) -> bool,
}

impl<T: BoxTest> Kernel for VisitWithin<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { tree, test, limit, visit } = self;
        let mut stack = Stack::default();
        if !tree.blocks().is_empty() {
            stack.push(tree.root() as u32);
        }
        while let Some(number) = stack.pop() {
            let row = test.keys(l, &tree.blocks()[number as usize]);
            let mut met = l.bits(l.le(row, l.splat(limit)));
            let is_leaf = (number as usize) < tree.leaf_count();
            let below = &tree.below()[number as usize].0;
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                if !is_leaf {
                    stack.push(below[lane]);
                } else if !visit(below[lane]) {
                    return;
                }
            }
        }
    }
}

struct Visit<'a, T, F> {
    tree: &'a PartTree,
    test: &'a T,
    leaves: &'a F,
    limit: f32,
    visit: &'a mut dyn FnMut(u32, f32) -> f32,
}

impl<T: BoxTest, F: LeafFilter> Kernel for Visit<'_, T, F> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { tree, test, leaves, mut limit, visit } = self;
        // The key of a block's box, and its number.
        let mut stack = Stack::default();
        if !tree.blocks().is_empty() {
            stack.push((0.0, tree.root() as u32));
        }
        let (mut keys, mut lanes) = (Row::default(), [0; WIDTH]);
        while let Some((key, number)) = stack.pop() {
            if key > limit {
                continue;
            }
            let (block, below) = (number as usize, &tree.below()[number as usize].0);
            let is_leaf = block < tree.leaf_count();
            if is_leaf && !F::AFTER_BOXES {
                let mut kept = leaves.keep(l, block, tree.filled(block));
                while kept != 0 && key <= limit {
                    limit = visit(below[kept.trailing_zeros() as usize % WIDTH], key);
                    kept &= kept - 1;
                }
                continue;
            }
            let row = test.keys(l, &tree.blocks()[block]);
            l.store(row, &mut keys);
            let met = l.bits(l.le(row, l.splat(limit)));
            let met = if is_leaf && met != 0 { leaves.keep(l, block, met) } else { met };
            let near = nearest_first(&keys, met, &mut lanes);
            if !is_leaf {
                // The nearest on top.
                for &lane in lanes[..near].iter().rev() {
                    stack.push((keys.0[lane as usize], below[lane as usize]));
                }
                continue;
            }
            for &lane in &lanes[..near] {
                let key = keys.0[lane as usize];
                if key <= limit {
                    limit = visit(below[lane as usize], key);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Aabb;
    use dcd_simd::PointDistance;
    use glam::{DVec3, Vec3};

    #[test]
    fn the_parts_within_a_limit_are_those_whose_boxes_are_and_the_visit_ends_where_it_is_told() {
        let at = |k: usize| {
            let t = k as f32;
            let centre = Vec3::new((t * 0.37).sin(), (t * 0.73).cos(), (t * 0.11).sin()) * 3.0;
            Aabb { min: centre - 0.1, max: centre + 0.2 }
        };
        for count in [1, 16, 17, 300, 2000] {
            let boxes: Vec<Aabb> = (0..count).map(at).collect();
            let tree = PartTree::over(&boxes);
            for (k, distance) in [0.0, 0.4, 1.5, 20.0].into_iter().enumerate() {
                let point = DVec3::new(k as f64 - 1.0, 0.5, 0.2);
                let test = PointDistance::new(point);
                let limit = test.key_of(distance);
                let mut met = Vec::new();
                tree.visit_within(&test, limit, &mut |part| {
                    met.push(part);
                    true
                });
                met.sort_unstable();
                let mut due = Vec::new();
                tree.visit(&test, limit, &mut |part, _| {
                    due.push(part);
                    limit
                });
                due.sort_unstable();
                assert_eq!(met, due, "{count} {distance}");
                let near = |aabb: &Aabb| {
                    point.clamp(aabb.min.as_dvec3(), aabb.max.as_dvec3()).distance(point)
                };
                let is_met = |part: u32| met.binary_search(&part).is_ok();
                for (part, aabb) in (0..).zip(&boxes) {
                    assert!(is_met(part) || near(aabb) > distance, "{count} {distance} {part}");
                    assert!(!is_met(part) || near(aabb) < distance + 1e-3, "{part}");
                }
                let mut calls = 0;
                tree.visit_within(&test, limit, &mut |_| {
                    calls += 1;
                    calls < 2
                });
                assert_eq!(calls, met.len().min(2));
            }
        }
    }

    /// All lanes that there are, without their boxes.
    struct Unboxed;

    impl LeafFilter for Unboxed {
        const AFTER_BOXES: bool = false;

        fn keep<L: Lanes>(&self, _: L, _: usize, lanes: u32) -> u32 {
            lanes
        }
    }

    #[test]
    fn a_filter_that_is_asked_without_boxes_sees_every_part_of_a_leaf_once_until_the_end() {
        for count in [1, 15, 16, 17, 300, 2000] {
            let point = |k: usize| Vec3::new((k % 7) as f32, (k % 11) as f32, (k % 13) as f32);
            let boxes: Vec<Aabb> =
                (0..count).map(|k| Aabb { min: point(k), max: point(k) }).collect();
            let tree = PartTree::over(&boxes);
            let test = PointDistance::new(DVec3::splat(3.0));
            let limit = test.key_of(1e3);
            let mut met = Vec::new();
            tree.visit_filtered((&test, &Unboxed), limit, &mut |part, _| {
                met.push(part as usize);
                limit
            });
            met.sort_unstable();
            assert!(met.into_iter().eq(0..count), "{count}");
            let mut calls = 0;
            tree.visit_filtered((&test, &Unboxed), limit, &mut |_, _| {
                calls += 1;
                -1.0
            });
            assert_eq!(calls, 1);
        }
    }
}
