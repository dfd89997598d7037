//! Both trees at once, sixteen boxes against one at a time.

use super::body::{Body, Proved};
use super::pair::Resolved;
use super::relative_pose::RelativePose;
use super::side::{Parts, Side};
use super::spheres::{Decided, InnerOuterSpheres};
use super::triangles::{Leaves, not_apart};
use super::{Next, Scratch, Tally, pair};
use crate::{Method, Verdict};
use dcd_geom::{Aabb, Aabb16, Mesh, Triangles};
use dcd_simd::{Block, Half, Kernel, Lanes, Row};
use std::cell::OnceCell;

/// How many blocks of a mesh are compared with the box round a convex shape alone, before planes of the shape are looked
/// for that separate. No unit. Never an answer. Larger: more leaves of dense meshes are compared with large boxes. Smaller:
/// planes that separate little.
const FEW: u32 = 12;

/// What the search finds.
pub(super) enum Goal<'a> {
    /// Whether any parts touch.
    Any,
    /// Which parts touch.
    All(&'a mut Vec<[u32; 2]>),
}

/// The search of two placed shapes, the first with a tree.
pub(super) struct Descent<'a, 'g> {
    pub(super) a: &'a Side<'a>,
    pub(super) b: &'a Side<'a>,
    pub(super) relative: &'a RelativePose,
    /// In and round the second shape, if it is convex, unless its own faces tell all; found when they are needed.
    spheres: OnceCell<Option<InnerOuterSpheres>>,
    /// The second shape, if it is convex and has vertices, and the first is a mesh.
    pub(super) body: Option<Body>,
    pub(super) scratch: &'a mut Scratch,
    pub(super) tally: &'a mut Tally<'g>,
}

// Where it is made: to move it takes as long as a block of boxes.
impl Kernel for &mut Descent<'_, '_> {
    type Output = Next;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Next {
        self.descend(l)
    }
}

impl Scratch {
    /// Sizes the buffers for a search against this shape.
    pub(super) fn begin(&mut self, b: &Side<'_>) {
        let blocks = b.tree().map_or(1, |tree| tree.blocks().len());
        let leaves = b.mesh().map_or(0, |mesh| mesh.leaves().len());
        self.stack.clear();
        self.placed.clear();
        self.placed.resize(blocks, false);
        self.turned.clear();
        self.turned.resize(leaves, false);
        // What is not placed or turned is not read.
        if self.blocks.len() < blocks {
            self.blocks.resize(blocks, Aabb16::EMPTY);
        }
        if self.corners.len() < leaves {
            self.corners.resize(leaves, [Block::default(); 3]);
        }
    }

    /// Brings a block of the second tree into the first frame, once.
    #[inline(always)]
    pub(super) fn place<L: Lanes>(
        &mut self,
        l: L,
        relative: &RelativePose,
        b: &Side<'_>,
        block: u32,
    ) {
        let block = block as usize;
        if std::mem::replace(&mut self.placed[block], true) {
            return;
        }
        let placed = &mut self.blocks[block];
        match b.tree() {
            Some(tree) => relative.place(l, &tree.blocks()[block], placed),
            None => *placed = relative.place_one(b),
        }
    }

    /// Turns the triangles of a leaf of the second mesh into the first axes, once.
    #[inline(always)]
    pub(super) fn turn<L: Lanes>(&mut self, l: L, relative: &RelativePose, mesh: &Mesh, leaf: u32) {
        let leaf = leaf as usize;
        if std::mem::replace(&mut self.turned[leaf], true) {
            return;
        }
        for corner in 0..3 {
            let from = &mesh.leaves()[leaf].corners[corner];
            relative.turn(l, from, &mut self.corners[leaf][corner]);
        }
    }
}

impl<'a, 'g> Descent<'a, 'g> {
    #[inline(always)]
    pub(super) fn of(
        [a, b]: [&'a Side<'a>; 2],
        relative: &'a RelativePose,
        scratch: &'a mut Scratch,
        tally: &'a mut Tally<'g>,
    ) -> Self {
        let body = a.mesh().and_then(|_| Body::of(relative, [a, b], &mut scratch.vertices));
        Self { a, b, relative, spheres: OnceCell::new(), body, scratch, tally }
    }

    #[inline]
    fn spheres(&self) -> Option<&InnerOuterSpheres> {
        let find = || match &self.body {
            Some(body) if body.is_cuboid() => None,
            _ => InnerOuterSpheres::of(self.relative, [self.a, self.b]),
        };
        self.spheres.get_or_init(find).as_ref()
    }
}

impl Descent<'_, '_> {
    /// From the roots down, until enough is known.
    #[inline(always)]
    fn descend<L: Lanes>(&mut self, l: L) -> Next {
        if self.a.mesh().is_some() && self.b.tree().is_none() {
            return self.descend_one(l);
        }
        self.scratch.begin(self.b);
        self.scratch.planes.begin(self.relative, [self.a, self.b]);
        self.scratch.stack.push([self.a.root(), self.b.root()]);
        while let Some(blocks) = self.scratch.stack.pop() {
            if self.compare(l, blocks) == Next::Stop {
                return Next::Stop;
            }
        }
        Next::Go
    }

    /// The same of a mesh and one convex shape, whose box needs no tree.
    #[inline(always)]
    fn descend_one<L: Lanes>(&mut self, l: L) -> Next {
        let Parts::Mesh(mesh) = self.a.parts else { return Next::Go };
        let tree = mesh.tree();
        let (blocks, below, leaves) = (tree.blocks(), tree.below(), tree.leaf_count());
        let around = match &self.body {
            Some(body) => self.relative.around_body(body),
            None => self.relative.around(self.b),
        };
        self.scratch.planes.clear();
        self.scratch.stack.clear();
        let mut count = 0;
        // Mostly one block below another: it is not put aside first.
        let mut next = Some(tree.root() as u32);
        loop {
            let block = match next.take() {
                Some(block) => block,
                None => match self.scratch.stack.pop() {
                    Some([block, _]) => block,
                    None => return Next::Go,
                },
            };
            count += 1;
            if count == FEW {
                self.scratch.planes.begin(self.relative, [self.a, self.b]);
            }
            let boxes = &blocks[block as usize];
            let hits = self.scratch.planes.boxes(l, boxes, boxes.overlaps(l, &around));
            if hits == 0 {
                continue;
            }
            if block as usize >= leaves {
                match hits & (hits - 1) {
                    0 => next = Some(below[block as usize].0[hits.trailing_zeros() as usize]),
                    _ => self.push(l, [block, 0], hits),
                }
                continue;
            }
            if self.parts_of_leaf(l, block, (0, hits)) == Next::Stop {
                return Next::Stop;
            }
        }
    }

    /// A block of each: pairs of what is below them, or, where both are leaves, pairs of parts.
    #[inline(always)]
    fn compare<L: Lanes>(&mut self, l: L, [block_a, block_b]: [u32; 2]) -> Next {
        self.scratch.place(l, self.relative, self.b, block_b);
        let Some(tree) = self.a.tree() else { return Next::Stop };
        let boxes = &tree.blocks()[block_a as usize];
        let around = &tree.unions()[block_a as usize];
        let (below_a, below_b) = (self.a.below(block_a), self.b.below(block_b));
        let (leaf_a, leaf_b) = (self.a.is_leaf(block_a), self.b.is_leaf(block_b));
        let mut met = 0;
        let mut leaves = None;
        let mut reaching = self.scratch.blocks[block_b as usize].overlaps(l, around);
        while reaching != 0 {
            let lane = reaching.trailing_zeros() as usize;
            reaching &= reaching - 1;
            let one = self.scratch.blocks[block_b as usize].get(lane);
            let hits = self.scratch.planes.boxes(l, boxes, boxes.overlaps(l, &one));
            let child_b = below_b.0[lane];
            match (leaf_a, leaf_b) {
                (true, true) => {
                    let at = Meeting { blocks: [block_a, block_b], lane, hits };
                    if hits != 0 && self.parts(l, at, &mut leaves) == Next::Stop {
                        return Next::Stop;
                    }
                }
                (true, false) if hits != 0 => self.scratch.stack.push([block_a, child_b]),
                (true, false) => {}
                (false, true) => met |= hits,
                (false, false) => {
                    for child in Bits(hits) {
                        self.scratch.stack.push([below_a.0[child], child_b]);
                    }
                }
            }
        }
        self.push(l, [block_a, block_b], met);
        Next::Go
    }

    /// Puts blocks below one of the first tree before the same block of the second: the one nearest
    /// to the middle of a convex second shape is looked at first, for it is likeliest to touch; where
    /// all are wanted the order does not count.
    #[inline(always)]
    fn push<L: Lanes>(&mut self, l: L, [block_a, block_b]: [u32; 2], mut met: u32) {
        let below = self.a.below(block_a);
        if met & met.wrapping_sub(1) == 0 || matches!(self.tally.goal, Goal::All(_)) {
            self.scratch.stack.extend(Bits(met).map(|child| [below.0[child], block_b]));
            return;
        }
        let mut gaps = Row::default();
        let middle = match &self.body {
            Some(body) => Some(body.middle),
            None => self.spheres().map(|spheres| spheres.centre),
        };
        if let (Some(tree), Some(middle)) = (self.a.tree(), middle) {
            let centre = middle.as_vec3();
            let centre = Aabb { min: centre, max: centre };
            l.store(tree.blocks()[block_a as usize].gaps(l, &centre), &mut gaps);
        }
        while let Some(child) = Bits(met).max_by(|&j, &k| gaps.0[j].total_cmp(&gaps.0[k])) {
            met &= !(1 << child);
            self.scratch.stack.push([below.0[child], block_b]);
        }
    }

    /// One part of the second leaf against those of the first whose boxes it meets.
    #[inline(always)]
    fn parts<L: Lanes>(&mut self, l: L, at: Meeting, leaves: &mut Option<Leaves>) -> Next {
        let Meeting { blocks: [block_a, block_b], lane, hits } = at;
        let part_b = self.b.below(block_b).0[lane];
        if let (Some(mesh_a), Some(mesh_b)) = (self.a.mesh(), self.b.mesh()) {
            let below = self.a.below(block_a);
            let leaf_a = &mesh_a.leaves()[block_a as usize];
            let radius = mesh_a.swept_radius() + mesh_b.swept_radius();
            let leaf_b = &mesh_b.leaves()[block_b as usize];
            let leaves =
                leaves.get_or_insert_with(|| Leaves::of(self.relative, leaf_a, leaf_b, radius));
            self.scratch.turn(l, self.relative, mesh_b, block_b);
            let corners = [&leaf_a.corners, &self.scratch.corners[block_b as usize]];
            for lane in Bits(not_apart(l, leaves, corners, (lane, hits))) {
                let pair = [below.0[lane], part_b];
                let resolved = pair::resolve_triangles(self.relative, [self.a, self.b], pair);
                if self.tally.file(pair, (resolved.verdict, resolved.method)) == Next::Stop {
                    return Next::Stop;
                }
            }
            return Next::Go;
        }
        self.parts_of_leaf(l, block_a, (part_b, hits))
    }

    /// One part, of no mesh against a mesh, against those of a leaf whose boxes it meets.
    #[inline(always)]
    fn parts_of_leaf<L: Lanes>(&mut self, l: L, block_a: u32, (part_b, hits): (u32, u32)) -> Next {
        let below = self.a.below(block_a);
        let mut open = self.beside_planes(l, block_a, hits);
        let mut squares = Row::default();
        let mut at_most = Row([f32::INFINITY; dcd_simd::WIDTH]);
        if let (1.., Parts::Mesh(mesh)) = (open, self.a.parts) {
            let wanted = self.tally.at_most.is_some().then_some(&mut at_most);
            let Decided { touching, apart, squares: found } =
                self.in_lanes(l, (&mesh.leaves()[block_a as usize], open), wanted);
            for lane in Bits(touching & open) {
                let known = (Verdict::Touching(()), Method::Portal);
                self.tally.bound(below.0[lane], at_most.0[lane]);
                if self.tally.file([below.0[lane], part_b], known) == Next::Stop {
                    return Next::Stop;
                }
            }
            open &= !(touching | apart);
            squares = found;
        }
        // The nearest to the middle first: if any touches, it is likely the one.
        while let Some(lane) = Bits(open).min_by(|&j, &k| squares.0[j].total_cmp(&squares.0[k])) {
            open &= !(1 << lane);
            let pair = [below.0[lane], part_b];
            let Resolved { verdict, method, axis, depth } = pair::resolve([self.a, self.b], pair);
            self.tally.keep(pair[0], depth);
            if verdict == Verdict::Touching(()) {
                self.tally.bound(pair[0], at_most.0[lane]);
            }
            if self.tally.file(pair, (verdict, method)) == Next::Stop {
                return Next::Stop;
            }
            if let Some(axis) = axis {
                let along = self.a.pose.rotation().transpose() * axis;
                self.scratch.planes.add(self.relative, [self.a, self.b], along);
                open = self.beside_planes(l, block_a, open);
            }
        }
        Next::Go
    }

    /// What lanes prove of the open triangles of a leaf: by a body's own faces and vertices, and by spheres in it and
    /// round it. Writes an upper bound of how deep each is, where that is wanted and a body's faces tell.
    ///
    /// Out of line: it is needed at two places.
    #[inline(always)]
    fn in_lanes<L: Lanes>(
        &self,
        l: L,
        (leaf, open): (&Triangles, u32),
        at_most: Option<&mut Row>,
    ) -> Decided {
        l.call(InLanes { search: self, leaf, open, at_most })
    }

    #[inline(always)]
    fn decide_leaf<L: Lanes>(
        &self,
        l: L,
        (leaf, open): (&Triangles, u32),
        at_most: Option<&mut Row>,
    ) -> Decided {
        let vertices = &self.scratch.vertices;
        let mut decided = Decided::default();
        if let (Some(body), Goal::Any) = (&self.body, &self.tally.goal)
            && body.is_cuboid()
        {
            let Proved { touching, apart } = body.decide_at_once(l, (leaf, open));
            decided = Decided { touching, apart, ..decided };
            if self.is_enough(open, &decided) {
                return decided;
            }
        }
        if let Some(body) = &self.body {
            let Proved { touching, apart } = body.decide(l, (leaf, open), vertices, at_most);
            decided.touching |= touching;
            decided.apart |= apart;
            if body.is_cuboid() || self.is_enough(open, &decided) {
                return decided;
            }
        }
        let Some(spheres) = self.spheres() else { return decided };
        let (by_spheres, near) = spheres.decide(l, leaf);
        decided = Decided {
            touching: decided.touching | by_spheres.touching,
            apart: decided.apart | by_spheres.apart,
            squares: by_spheres.squares,
        };
        match &self.body {
            Some(body) if !self.is_enough(open, &decided) => {
                decided.apart |= body.beside(l, leaf, (vertices, near));
            }
            _ => {}
        }
        decided
    }

    /// Whether no more of a leaf needs to be known.
    #[inline(always)]
    fn is_enough(&self, open: u32, decided: &Decided) -> bool {
        let is_found = matches!(self.tally.goal, Goal::Any) && open & decided.touching != 0;
        is_found || open & !(decided.touching | decided.apart) == 0
    }

    /// Which of the open parts of a leaf of the first shape no separating plane shuts out.
    #[inline(always)]
    fn beside_planes<L: Lanes>(&self, l: L, block: u32, open: u32) -> u32 {
        match self.a.parts {
            Parts::Mesh(mesh) => {
                self.scratch.planes.triangles(l, &mesh.leaves()[block as usize], open)
            }
            Parts::Compound(compound) => {
                self.scratch.planes.boxes(l, &compound.tree().blocks()[block as usize], open)
            }
            Parts::One(_) => open,
        }
    }
}

/// [`Descent::in_lanes`], in half of the lanes where a half takes less and has all open triangles, as it mostly does.
struct InLanes<'a, 'd, 'g> {
    search: &'a Descent<'d, 'g>,
    leaf: &'a Triangles,
    open: u32,
    at_most: Option<&'a mut Row>,
}

impl Kernel for InLanes<'_, '_, '_> {
    type Output = Decided;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Decided {
        match Half::only_of(self.open) {
            Some(half) if L::HALVES => l.run_half(half, AllLanes(self)),
            _ => AllLanes(self).run(l),
        }
    }
}

/// [`InLanes`] in all of the lanes that there are.
struct AllLanes<'a, 'd, 'g>(InLanes<'a, 'd, 'g>);

impl Kernel for AllLanes<'_, '_, '_> {
    type Output = Decided;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Decided {
        let InLanes { search, leaf, open, at_most } = self.0;
        search.decide_leaf(l, (leaf, open), at_most)
    }
}

/// A lane of the second leaf, and the lanes of the first that it meets.
struct Meeting {
    blocks: [u32; 2],
    lane: usize,
    hits: u32,
}

/// The numbers of the bits that are set.
pub(super) struct Bits(pub(super) u32);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros();
        (self.0 != 0).then(|| {
            self.0 &= self.0 - 1;
            lane as usize
        })
    }
}
