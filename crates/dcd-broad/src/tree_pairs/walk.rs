//! Algorithm 3: two nodes meet, then their children.

use super::block::{Block, Corner, Visit};
use super::run::Run;
use super::{DEEPEST_SHARED, LeafPairs, Traversal, Visits};
use dcd_bvh::{BoundingTree, Node, NodeContent};
use dcd_exec::{Exec, Filler, PerThread, Span};
use dcd_geom::{Aabb, Pair};

/// What all tasks of a traversal share.
pub(super) struct Walk<'w, T, K> {
    pub(super) tree: &'w T,
    pub(super) aabbs: &'w [Aabb],
    pub(super) keep: &'w K,
    pub(super) traversal: Traversal,
    pub(super) exec: Exec<'w>,
    pub(super) stacks: &'w PerThread<Vec<Visit>>,
    pub(super) filler: &'w Filler<'w, Vec<Pair>>,
}

impl<T: BoundingTree, K: Fn(u32, u32) -> bool + Sync> Walk<'_, T, K> {
    /// Writes all candidates; returns their spans, in order.
    pub(super) fn gather(&self) -> Vec<Span> {
        let root = self.tree.root().map(|root| Visit { a: root, b: root });
        root.map(|visit| self.meet(visit, 0).into_spans().collect()).unwrap_or_default()
    }

    /// Shares the meetings below between two tasks while both nodes are inner ones and not too
    /// deep. What needs no task of its own is a segment.
    fn meet(&self, visit: Visit, depth: u32) -> Run {
        let (a, b) = (self.tree.node(visit.a), self.tree.node(visit.b));
        let mut run = Run::default();
        if !a.aabb.overlaps(&b.aabb) {
            return run;
        }
        match (a.below, b.below) {
            (NodeContent::Nodes(rows), NodeContent::Nodes(columns)) if depth < self.max_depth() => {
                let (upper, lower) = Block { rows, columns, corner: self.corner(visit) }.halves();
                let (first, second) = self
                    .exec
                    .join(|| self.meet_all(upper, depth + 1), || self.meet_all(lower, depth + 1));
                run = first;
                run.append(second);
            }
            _ => run.push(self.filler.segment(|out| {
                self.stacks.with(|stack| self.descend(visit, stack, out));
            })),
        }
        run
    }

    fn meet_all(&self, block: Block, depth: u32) -> Run {
        block.visits().fold(Run::default(), |mut run, visit| {
            run.append(self.meet(visit, depth));
            run
        })
    }

    /// The same, in one task and with a stack of its own: trees may be deep.
    fn descend(&self, from: Visit, stack: &mut Vec<Visit>, out: &mut Vec<Pair>) {
        stack.push(from);
        while let Some(visit) = stack.pop() {
            let (a, b) = (self.tree.node(visit.a), self.tree.node(visit.b));
            if !a.aabb.overlaps(&b.aabb) {
                continue;
            }
            if let (NodeContent::Boxes(rows), NodeContent::Boxes(columns)) = (a.below, b.below) {
                self.list(Block { rows, columns, corner: self.corner(visit) }, out);
                continue;
            }
            let (rows, columns) = (children(&a, &visit.a), children(&b, &visit.b));
            let block = Block { rows, columns, corner: self.corner(visit) };
            stack.extend(block.visits().rev());
        }
    }

    /// Lists the candidates of two leaves.
    fn list(&self, leaves: Block, out: &mut Vec<Pair>) {
        let listed = leaves.visits().filter(|&Visit { a: i, b: j }| match self.traversal.visits {
            Visits::Once => i != j,
            Visits::Twice => i < j,
        });
        for Visit { a, b } in listed {
            let pair = Pair::new(a, b);
            let is_candidate = match self.traversal.leaf_pairs {
                LeafPairs::Tested => self.aabbs[a as usize].overlaps(&self.aabbs[b as usize]),
                LeafPairs::Untested => true,
            };
            if is_candidate && (self.keep)(pair.i, pair.j) {
                out.push(pair);
            }
        }
    }

    /// A node that meets itself has each two of its children meet in one order or in both.
    fn corner(&self, visit: Visit) -> Corner {
        match self.traversal.visits {
            Visits::Once if visit.a == visit.b => Corner::Triangle,
            _ => Corner::Square,
        }
    }

    fn max_depth(&self) -> u32 {
        self.traversal.max_depth.min(DEEPEST_SHARED)
    }
}

/// The children of an inner node; a leaf stays itself while the other node is taken apart.
fn children<'t>(node: &Node<'t>, number: &'t u32) -> &'t [u32] {
    match node.below {
        NodeContent::Nodes(children) => children,
        NodeContent::Boxes(_) => std::slice::from_ref(number),
    }
}
