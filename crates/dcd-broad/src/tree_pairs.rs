//! A tree against itself.

mod block;
mod run;
mod walk;

use crate::BroadPhase;
use block::Visit;
use dcd_bvh::{BuildTree, PaperTree};
use dcd_exec::{Exec, Par, PerThread, Segments};
use dcd_geom::{Aabb, Pair};
use walk::Walk;

/// Finds pairs by traversing any tree against itself, as algorithms 2 and 3 of the ParustDCD
/// paper do. The list is the same at any number of threads.
///
/// ```
/// use dcd_broad::{LeafPairs, Traversal, TreePairs};
/// use dcd_bvh::PaperTree;
/// let ours = TreePairs::new(PaperTree::default()); // or a tree of one's own
/// let theirs = TreePairs::paper_as_written();
/// assert_eq!(ours.traversal.leaf_pairs, LeafPairs::Tested);
/// assert_eq!(theirs.traversal.leaf_pairs, LeafPairs::Untested);
/// ```
#[derive(Debug, Default)]
pub struct TreePairs<B: BuildTree> {
    /// Makes the tree.
    pub builder: B,
    /// How the tree is walked.
    pub traversal: Traversal,
    tree: B::Tree,
    stacks: PerThread<Vec<Visit>>,
    unjoined: Segments<Pair>,
}

/// How a tree is walked against itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traversal {
    /// Above which depth two inner nodes share their combinations between two tasks; below, one
    /// task walks on alone. More than 32 count as 32.
    pub max_depth: u32,
    /// How often two nodes meet.
    pub visits: Visits,
    /// Which pairs of two overlapping leaves are candidates.
    pub leaf_pairs: LeafPairs,
}

/// How often two different nodes meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visits {
    /// Once, in one of the two orders.
    Once,
    /// In both orders, as in the paper; half of what is found is dropped at the leaves.
    Twice,
}

/// Which pairs of two overlapping leaves are candidates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeafPairs {
    /// Those whose own AABBs overlap.
    Tested,
    /// All: the candidates then depend on the tree, and larger leaves make more.
    Untested,
}

/// Bounds the recursion, whose every level may hold a stack frame of the thread pool too.
const DEEPEST_SHARED: u32 = 32;

impl Traversal {
    /// Algorithm 3, with the parameter of section 3.4. The text of the algorithm and the code agree
    /// here: it starts from the pair of the root with itself, takes all four combinations of two
    /// nodes' children, thus meets each two nodes in both orders, and pushes every i < j of two
    /// overlapping leaves. The prose calls a candidate a pair of overlapping AABBs; whoever wants
    /// that sets [`LeafPairs::Tested`].
    pub const PAPER: Self =
        Self { max_depth: 16, visits: Visits::Twice, leaf_pairs: LeafPairs::Untested };
}

/// Each two nodes once, each candidate tested; shared down to depth 8, which is 256 tasks of two
/// combinations each. On the paper's 10,000 hulls, where depth 16 is a task for every two leaves,
/// depth 16 takes half as long again on one thread.
impl Default for Traversal {
    fn default() -> Self {
        Self { max_depth: 8, visits: Visits::Once, leaf_pairs: LeafPairs::Tested }
    }
}

impl TreePairs<PaperTree> {
    /// The paper's broad phase as its text has it: [`PaperTree::as_written`], walked by
    /// [`Traversal::PAPER`].
    pub fn paper_as_written() -> Self {
        Self::new(PaperTree::as_written()).with(Traversal::PAPER)
    }

    /// The paper's broad phase as its code has it: [`PaperTree::as_coded`], walked by
    /// [`Traversal::PAPER`].
    pub fn paper_as_coded() -> Self {
        Self::new(PaperTree::as_coded()).with(Traversal::PAPER)
    }
}

impl<B: BuildTree> TreePairs<B> {
    /// A broad phase over the trees of `builder`, with the default traversal.
    pub fn new(builder: B) -> Self {
        Self {
            builder,
            traversal: Traversal::default(),
            tree: B::Tree::default(),
            stacks: PerThread::default(),
            unjoined: Segments::default(),
        }
    }

    /// The same with another traversal.
    pub fn with(self, traversal: Traversal) -> Self {
        Self { traversal, ..self }
    }

    /// The tree over the AABBs of the last build.
    pub fn tree(&self) -> &B::Tree {
        &self.tree
    }
}

impl<B: BuildTree> BroadPhase for TreePairs<B> {
    fn build(&mut self, aabbs: &[Aabb], exec: Exec) {
        self.builder.build(aabbs, exec, &mut self.tree);
    }

    fn pairs(
        &mut self,
        aabbs: &[Aabb],
        keep: impl Fn(u32, u32) -> bool + Sync,
        exec: Exec,
        out: &mut Segments<Pair>,
    ) {
        let Self { tree, stacks, traversal, unjoined, .. } = self;
        out.gather(|filler| {
            Walk { tree, aabbs, keep: &keep, traversal: *traversal, exec, stacks, filler }.gather()
        });
        // The threads' buffers become one list, as in algorithm 2: how many runs there are depends
        // on the schedule, and whoever cuts the list into tasks must not see it.
        if out.iter().nth(1).is_some() {
            std::mem::swap(out, unjoined);
            out.fill(Par::Serial.into(), 1, |_, list| unjoined.join_into(exec, list));
        }
    }
}
