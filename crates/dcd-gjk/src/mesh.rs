//! Compounds and triangle meshes against anything: both trees are descended at once, and pairs of
//! parts are resolved until one touches, or all of them where every touching pair is wanted.
//!
//! Boxes and triangles are compared in f32 in the frame of the shape with more parts, with bounds
//! for all rounding (docs/numerics/proofs.md, "parts"); what that leaves open is resolved in f64 and, where
//! both parts are polytopes, in exact integers. So the answers are those of resolving every pair of parts.

mod body;
mod bounds;
mod cuboid;
mod deepest;
mod descent;
mod distance;
mod hull_axes;
mod may_be_deepest;
mod nearest_triangle;
mod on_body;
mod one_triangle;
mod pair;
mod per_part;
mod piercing;
mod pressed;
mod reach;
mod relative_pose;
mod separating_planes;
mod side;
mod spheres;
#[cfg(test)]
mod tests;
mod triangle_gaps;
mod triangles;
mod two_meshes;
mod two_triangles;

use crate::epa::Depth;
use crate::{Method, PosedShape, Reason, Verdict, order};
use dcd_geom::glam::Vec3;
use dcd_geom::{Aabb16, Shape};
use dcd_simd::{Block, IndexRow, Kernel, Lanes, Path, Unfused, dispatch, dispatch_on};
use descent::{Descent, Goal};
use distance::Open;
use per_part::PerPart;
use relative_pose::RelativePose;
use separating_planes::SeparatingPlanes;
use side::Side;
use std::collections::BinaryHeap;

pub use deepest::PartIndex;
pub(crate) use deepest::{
    AS_DEEP, Effort, PartPair, deepest, deepest_of, pairs_of, part_index, touching_parts,
};
pub use distance::distance;
pub(crate) use distance::{Limited, NearParts, distance_at, distance_of_nearest, nearer_than};
pub(crate) use may_be_deepest::may_be_deepest;
pub(crate) use nearest_triangle::distance_in_f32;
pub(crate) use on_body::{
    TouchingTriangle, deepest_by_formula, depth_in_sphere, touching_triangles, triangles_in_sphere,
};
pub(crate) use one_triangle::{OfTriangle, of_triangle};
pub(crate) use reach::Direction;

/// What is reused from pair to pair.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// The second tree's blocks in the first shape's frame, as far as they have been needed.
    blocks: Vec<Aabb16>,
    /// Which of them are.
    placed: Vec<bool>,
    /// The second mesh's triangles turned into the first shape's axes, likewise.
    corners: Vec<[Block; 3]>,
    turned: Vec<bool>,
    /// Beyond which nothing of a convex second shape is.
    planes: SeparatingPlanes,
    /// The vertices of a convex second shape, turned into the first shape's axes, relative to its middle.
    vertices: Vec<Vec3>,
    /// Pairs of blocks still to be compared.
    stack: Vec<[u32; 2]>,
    /// What is still to be looked at for a distance.
    open: BinaryHeap<Open>,
}

/// Whether two shapes touch, at least one of them a compound or a mesh, and the highest method that
/// was needed. Stops at the first touching pair of parts.
///
/// Never undecided where all parts are polytopes; else undecided if no pair touches and one is not
/// known. The same for (a, b) and (b, a).
pub fn overlap(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut Scratch,
) -> (Verdict<()>, Method) {
    search(Path::best(), [a, b], scratch, (Goal::Any, None, None))
}

/// The same on that path, or the portable one where this CPU does not have it; for tests and
/// measurements.
pub fn overlap_on(
    path: Path,
    [a, b]: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
) -> (Verdict<()>, Method) {
    search(path, [a, b], scratch, (Goal::Any, None, None))
}

/// Whether two convex parts touch, by index: what [`overlap`] makes of them, undecided where it is.
pub(crate) fn overlap_of_parts(
    [a, b]: [PosedShape<'_>; 2],
    [part_a, part_b]: [u32; 2],
) -> (Verdict<()>, Method) {
    let ([first, second], swapped) = in_order(a, b);
    let parts = if swapped { [part_b, part_a] } else { [part_a, part_b] };
    let found = pair::resolve([&first, &second], parts);
    (found.verdict, found.method)
}

/// Appends every touching pair of parts in ascending order: a part of `a` and one of `b`, by index;
/// a convex shape is its own part 0. The verdict is that of [`overlap`], but undecided if any pair
/// of parts is, since the list then may lack it.
pub fn touching(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut Scratch,
    pairs: &mut Vec<[u32; 2]>,
) -> (Verdict<()>, Method) {
    let first = pairs.len();
    let found = search(Path::best(), [a, b], scratch, (Goal::All(pairs), None, None));
    pairs[first..].sort_unstable();
    found
}

/// The same, and every pair of which that is not known: for a measure, whose bound then covers them.
pub(crate) fn touching_or_open(
    [a, b]: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
    pairs: &mut Vec<[u32; 2]>,
) {
    let first = pairs.len();
    let ([first_side, second], swapped) = in_order(a, b);
    let mut tally = Tally { swapped, lists_open: true, ..Tally::of(Goal::All(&mut *pairs)) };
    dispatch(Search { sides: [&first_side, &second], scratch, tally: &mut tally });
    pairs[first..].sort_unstable();
}

/// The same of a mesh and a polytope; appends what the search comes by of their depths as well: the same on every path, for
/// a measure begins with it.
pub(crate) fn touching_with_depths(
    path: Path,
    [a, b]: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
    Lists { pairs, depths, mut at_most }: Lists<'_>,
) -> (Verdict<()>, Method) {
    let bounded = at_most.as_ref().map_or(0, |list| list.len());
    let first = [pairs.len(), depths.len()];
    let bounds = at_most.as_deref_mut();
    let found = search(path, [a, b], scratch, (Goal::All(pairs), Some(depths), bounds));
    pairs[first[0]..].sort_unstable();
    depths[first[1]..].sort_unstable_by_key(|&(triangle, _)| triangle);
    if let Some(list) = at_most {
        list[bounded..].sort_unstable_by_key(|&(triangle, _)| triangle);
    }
    found
}

/// What is found of the parts of a mesh and a polytope that touch: see [`KnownParts`].
pub(crate) struct Lists<'a> {
    pub(crate) pairs: &'a mut Vec<[u32; 2]>,
    pub(crate) depths: &'a mut Vec<(u32, Depth)>,
    /// Where it is wanted.
    pub(crate) at_most: Option<&'a mut Vec<(u32, f32)>>,
}

/// What is known of the parts of a mesh and a polytope that touch.
#[derive(Clone, Copy, Debug, Default)]
pub struct KnownParts<'a> {
    /// Which they are: all that [`touching`] lists, in that order.
    pub parts: &'a [[u32; 2]],
    /// How deep some of the triangles are, from the mesh to the polytope, in rising order.
    pub depths: &'a [(u32, Depth)],
    /// Upper bounds of some depths, likewise: metres.
    pub at_most: &'a [(u32, f32)],
}

impl KnownParts<'_> {
    /// The depth of a triangle, if it is known.
    fn depth(&self, triangle: u32) -> Option<Depth> {
        find(self.depths, triangle)
    }

    /// An upper bound of how deep a triangle is, metres; infinite where that is not known.
    fn at_most(&self, triangle: u32) -> f64 {
        find(self.at_most, triangle).map_or(f64::INFINITY, f64::from)
    }
}

/// What is known of a triangle in a list in rising order.
fn find<T: Copy>(list: &[(u32, T)], triangle: u32) -> Option<T> {
    let place = list.binary_search_by_key(&triangle, |&(other, _)| other).ok()?;
    Some(list[place].1)
}

/// Whether one is a mesh and the other a polytope: their touching triangles are worth keeping for a measure, and their
/// order is one for (a, b) and (b, a).
pub(crate) fn are_mesh_and_polytope(a: &Shape, b: &Shape) -> bool {
    matches!((a, b), (Shape::Mesh(_), Shape::Polytope(_)) | (Shape::Polytope(_), Shape::Mesh(_)))
}

/// Whether either is made of parts.
pub(crate) fn have_parts(a: &Shape, b: &Shape) -> bool {
    !(a.is_convex() && b.is_convex())
}

/// What is listed of the parts that touch, and of the depths of a mesh's triangles.
type Wanted<'a> = (Goal<'a>, Option<&'a mut Vec<(u32, Depth)>>, Option<&'a mut Vec<(u32, f32)>>);

fn search(
    path: Path,
    [a, b]: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
    (goal, depths, at_most): Wanted<'_>,
) -> (Verdict<()>, Method) {
    let ([first, second], swapped) = in_order(a, b);
    let mut tally = Tally { depths, at_most, swapped, ..Tally::of(goal) };
    let has_depths = tally.depths.is_some();
    let search = Search { sides: [&first, &second], scratch, tally: &mut tally };
    // What bounds depths, and which the lanes leave to formulas that find them, is not to differ from path to path.
    match has_depths {
        true => dispatch_on(path, Unfused(search)),
        false => dispatch_on(path, search),
    }
    tally.answer()
}

/// Whether two shapes touch that are in their order.
fn touch(sides: [&Side<'_>; 2], scratch: &mut Scratch) -> Verdict<()> {
    let mut tally = Tally::of(Goal::Any);
    dispatch(Search { sides, scratch, tally: &mut tally });
    tally.answer().0
}

/// The search of two shapes in their order, of which the first is made of parts.
struct Search<'a, 'g> {
    sides: [&'a Side<'a>; 2],
    scratch: &'a mut Scratch,
    tally: &'a mut Tally<'g>,
}

impl Kernel for Search<'_, '_> {
    type Output = ();

    // What a search begins with takes as long as the search: so it has the path's instructions too.
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { sides: [a, b], scratch, tally } = self;
        let Some(relative) = &RelativePose::of(a, b) else { return each(a, b, tally) };
        match per_part::parts_of([a, b]) {
            Some(compound) => {
                PerPart { sides: [a, b], compound, relative, scratch, tally }.run(l);
            }
            None => {
                l.call(&mut Descent::of([a, b], relative, scratch, tally));
            }
        }
    }
}

/// The two as their parts, and whether they were exchanged: a mesh comes first, then the one with more
/// parts, for the other's boxes are those that are turned, and one with a tree before one without;
/// else an order by content.
#[inline(always)]
fn in_order<'a>(a: PosedShape<'a>, b: PosedShape<'a>) -> ([Side<'a>; 2], bool) {
    let swapped = is_swapped(a, b);
    let (first, second) = if swapped { (b, a) } else { (a, b) };
    ([Side::of(first), Side::of(second)], swapped)
}

/// Whether (a, b) is the other way round than the pair is solved in.
#[inline]
pub(crate) fn is_swapped(a: PosedShape<'_>, b: PosedShape<'_>) -> bool {
    // Mostly one of the two is a mesh.
    match (a.shape, b.shape) {
        (Shape::Mesh(_), Shape::Mesh(_)) => {}
        (Shape::Mesh(_), _) => return false,
        (_, Shape::Mesh(_)) => return true,
        _ => {}
    }
    // Whether it is a mesh, how many parts it has, and whether there is a tree over them.
    let rank = |shape: &Shape| match shape {
        Shape::Mesh(mesh) => (true, mesh.triangles().len(), true),
        Shape::Compound(compound) => (false, compound.parts().len(), true),
        _ => (false, 1, false),
    };
    rank(b.shape).cmp(&rank(a.shape)).then_with(|| order::placed(a, b)).is_gt()
}

/// Every part of one against every part of the other: where lengths leave the range of f32.
fn each(a: &Side<'_>, b: &Side<'_>, tally: &mut Tally<'_>) {
    for part_a in 0..a.count() {
        for part_b in 0..b.count() {
            let pair::Resolved { verdict, method, .. } = pair::resolve([a, b], [part_a, part_b]);
            if tally.file([part_a, part_b], (verdict, method)) == Next::Stop {
                return;
            }
        }
    }
}

/// What is known so far.
struct Tally<'a> {
    goal: Goal<'a>,
    /// The depths of triangles, where they are wanted.
    depths: Option<&'a mut Vec<(u32, Depth)>>,
    /// An upper bound of how deep they are, likewise.
    at_most: Option<&'a mut Vec<(u32, f32)>>,
    /// Whether the caller's first shape is our second.
    swapped: bool,
    /// Whether pairs are listed too of which it is not known.
    lists_open: bool,
    touching: bool,
    undecided: Option<Reason>,
    method: Method,
}

/// Whether the search goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    Go,
    Stop,
}

impl<'a> Tally<'a> {
    /// Of nothing yet; no depths are wanted.
    fn of(goal: Goal<'a>) -> Self {
        Self {
            goal,
            depths: None,
            at_most: None,
            swapped: false,
            lists_open: false,
            touching: false,
            undecided: None,
            method: Method::Portal,
        }
    }
}

impl Tally<'_> {
    /// Takes in the verdict on a pair of parts.
    fn file(&mut self, [a, b]: [u32; 2], (verdict, method): (Verdict<()>, Method)) -> Next {
        self.method = self.method.max(method);
        match verdict {
            Verdict::Apart => Next::Go,
            Verdict::Undecided(reason) => {
                self.undecided = self.undecided.or(Some(reason));
                if self.lists_open { self.list([a, b]) } else { Next::Go }
            }
            Verdict::Touching(()) => {
                self.touching = true;
                self.list([a, b])
            }
        }
    }

    /// Lists a pair, or ends the search where any will do.
    fn list(&mut self, [a, b]: [u32; 2]) -> Next {
        let Goal::All(pairs) = &mut self.goal else { return Next::Stop };
        pairs.push(if self.swapped { [b, a] } else { [a, b] });
        Next::Go
    }

    /// Takes in the depth of a triangle, if it is known.
    fn keep(&mut self, triangle: u32, depth: Option<Depth>) {
        if let (Some(depths), Some(depth)) = (&mut self.depths, depth) {
            depths.push((triangle, depth));
        }
    }

    /// Takes in an upper bound of how deep a triangle is that touches, metres, where that is wanted.
    #[inline(always)]
    fn bound(&mut self, triangle: u32, at_most: f32) {
        if let Some(list) = &mut self.at_most {
            list.push((triangle, at_most));
        }
    }

    /// How many pairs are listed.
    fn listed(&self) -> usize {
        match &self.goal {
            Goal::Any => 0,
            Goal::All(pairs) => pairs.len(),
        }
    }

    /// Says of which part of the second shape the pairs behind the first so many are, which were found as of its only one.
    fn are_of(&mut self, part: u32, listed: usize) {
        if let Goal::All(pairs) = &mut self.goal {
            let second = usize::from(!self.swapped);
            pairs[listed..].iter_mut().for_each(|pair| pair[second] = part);
        }
    }

    fn answer(self) -> (Verdict<()>, Method) {
        let known = match self.goal {
            Goal::Any => self.touching,
            Goal::All(_) => false,
        };
        let verdict = match self.undecided {
            Some(reason) if !known => Verdict::Undecided(reason),
            _ if self.touching => Verdict::Touching(()),
            _ => Verdict::Apart,
        };
        (verdict, self.method)
    }
}

/// Of a convex shape: itself, its own part 0.
const ITSELF: IndexRow = IndexRow([0; dcd_simd::WIDTH]);
