//! Queries of the wide tree: boxes by ascending key.

use crate::WideBvh;
use dcd_simd::{ArrayVec, BoxTest, Kernel, Lanes, Path, Row, WIDTH, dispatch_on, nearest_first};

/// More than ever wait: a u32 counts the boxes of at most eight levels, and a node is replaced by at most sixteen, so that
/// they are 121 at most.
const STACK: usize = 8 * WIDTH;

/// A node to be entered: the key of its box, its number, and its height above the leaves.
type Entry = (f32, u32, u32);

impl WideBvh {
    /// Calls `visit(index, key)` for each box whose key is at most the limit and finite, nearer nodes first, and takes what it
    /// returns for the limit from then on; a negative one ends the search. The order depends on the tree and on
    /// the limits alone. Does not allocate.
    pub fn visit(&self, test: &impl BoxTest, limit: f32, visit: &mut dyn FnMut(u32, f32) -> f32) {
        self.visit_on(Path::best(), test, limit, visit);
    }

    /// The same on that path, or the portable one where this CPU does not have it; for tests and measurements.
    pub fn visit_on(
        &self,
        path: Path,
        test: &impl BoxTest,
        limit: f32,
        visit: &mut dyn FnMut(u32, f32) -> f32,
    ) {
        // Mostly a scene has a tree of moving and one of static objects, and one of the two is empty.
        if !self.leaves().is_empty() {
            dispatch_on(path, Visit { tree: self, test, limit, visit });
        }
    }
}

struct Visit<'a, T> {
    tree: &'a WideBvh,
    test: &'a T,
    limit: f32,
    visit: &'a mut dyn FnMut(u32, f32) -> f32,
}

impl<T: BoxTest> Kernel for Visit<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { tree, test, limit, visit } = self;
        // An infinite key is that of the empty boxes that fill up a row.
        let mut limit = limit.min(f32::MAX);
        let mut stack = ArrayVec::<Entry, STACK>::new();
        stack.push((0.0, 0, tree.levels().len() as u32));
        let (mut keys, mut lanes) = (Row::default(), [0; WIDTH]);
        while let Some((key, node, height)) = stack.pop() {
            if key > limit {
                continue;
            }
            let boxes = match height {
                0 => &tree.leaves()[node as usize],
                height => &tree.levels()[height as usize - 1][node as usize],
            };
            let row = test.keys(l, boxes);
            l.store(row, &mut keys);
            let met = l.bits(l.le(row, l.splat(limit)));
            let near = nearest_first(&keys, met, &mut lanes);
            if height > 0 {
                let child = |&lane: &u8| {
                    let number = node * WIDTH as u32 + u32::from(lane);
                    (keys.0[lane as usize % WIDTH], number, height - 1)
                };
                // The nearest on top.
                stack.extend(lanes[..near].iter().rev().map(child));
                continue;
            }
            for &lane in &lanes[..near] {
                let key = keys.0[lane as usize];
                if key <= limit {
                    limit = visit(tree.ids()[node as usize].0[lane as usize], key).min(f32::MAX);
                }
            }
        }
    }
}
