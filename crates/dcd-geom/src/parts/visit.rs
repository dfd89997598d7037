//! Queries of a tree over parts: parts by ascending key.

use super::PartTree;
use dcd_simd::{BoxTest, Kernel, Lanes, Path, Row, WIDTH, dispatch_on, nearest_first};

/// Which parts of a leaf whose boxes are near are worth a visit.
pub trait LeafFilter {
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
        let mut stack: Vec<(f32, u32)> = Vec::with_capacity(4 * WIDTH);
        if !tree.blocks().is_empty() {
            stack.push((0.0, tree.root() as u32));
        }
        let (mut keys, mut lanes) = (Row::default(), [0; WIDTH]);
        while let Some((key, number)) = stack.pop() {
            if key > limit {
                continue;
            }
            let row = test.keys(l, &tree.blocks()[number as usize]);
            l.store(row, &mut keys);
            let met = l.bits(l.le(row, l.splat(limit)));
            let is_leaf = (number as usize) < tree.leaf_count();
            let met = if is_leaf && met != 0 { leaves.keep(l, number as usize, met) } else { met };
            let near = nearest_first(&keys, met, &mut lanes);
            let below = &tree.below()[number as usize].0;
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
