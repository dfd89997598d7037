//! Which triangles of two meshes that are apart may be the nearest to each other.
//!
//! Blocks of both trees are met by the nearest boxes. A triangle of a leaf is measured against sixteen of another at once
//! in f32, unless their boxes or the direction between the nearest so far show that they are farther
//! (docs/numerics/proofs.md, "Nearest triangles").

use super::bounds::U64;
use super::descent::Bits;
use super::distance::{Open, What};
use super::nearest_triangle::{Found, Nearest};
use super::pair::Core;
use super::relative_pose::RelativePose;
use super::side::{Part, Side};
use super::triangle_gaps::TriangleGaps;
use super::triangles::{Leaves, interval, load_rows};
use super::{Scratch, touch};
use crate::Verdict;
use crate::distance::{Nearer, nearer};
use crate::simd::vector::V3;
use dcd_geom::glam::{DVec3, Vec3};
use dcd_geom::{Aabb16, Mesh};
use dcd_simd::{Block, Kernel, Lanes, Row, Unfused, WIDTH, dispatch};
use std::collections::VecDeque;

/// How near the bounds of a distance have to come, relative to the smaller mesh. Larger: the bound is above what the accuracy of
/// f32 promises. Smaller: more supports.
const GAP: f64 = 1e-6;

/// What a gap along a direction of unit length loses. Unit: u of the pair's size. Two turned directions 8, six products 8, their
/// sums 4; and a margin.
const ALONG: f64 = 64.0;

/// How many directions are kept; the oldest goes first. No unit. Smaller: triangles measured for nothing. Larger: more
/// directions to try each pair along. Never an answer.
const MOST: usize = 8;

/// Meets the triangles of two meshes of which one pair is the nearest. `None` of other shapes, where it is open whether they
/// touch, and where two triangles could not be measured.
pub(super) fn meet(
    sides: [&Side<'_>; 2],
    relative: &RelativePose,
    scratch: &mut Scratch,
    nearest: &mut Nearest,
) -> Option<Found> {
    let [a, b] = sides;
    let meshes = [a.mesh()?, b.mesh()?];
    match touch(sides, scratch) {
        Verdict::Touching(()) => return Some(Found::Touching),
        Verdict::Undecided(_) => return None,
        Verdict::Apart => {}
    }
    let lost = ALONG * U64 * relative.size() + (a.radius() + b.radius()) * (1.0 + 8.0 * U64);
    let gap = 2.0 * GAP * a.reach.min(b.reach);
    let mut directions = VecDeque::with_capacity(MOST);
    for parts in nearest_triangles((sides, meshes), relative, scratch, nearest.limit()) {
        let [of_a, of_b] = [a.part(parts[0]), b.part(parts[1])];
        let (Part::Triangle { corners: in_a, .. }, Part::Triangle { corners: in_b, .. }) =
            (&of_a, &of_b)
        else {
            return None;
        };
        let gaps = directions.iter().map(|direction: &Direction| direction.gap(in_a, in_b));
        let lower = gaps.fold(f64::NEG_INFINITY, f64::max) - lost;
        let limit = nearest.limit();
        if lower >= limit - nearest.close() * relative.size() {
            nearest.pass(lower);
            continue;
        }
        let (core_a, core_b) = (Core::of(&of_a)?, Core::of(&of_b)?);
        let along = match nearer(core_a.body(a.pose), core_b.body(b.pose), [gap, limit]) {
            Nearer::Apart(found) => {
                nearest.add(parts, found);
                found.normal
            }
            Nearer::Beyond(direction) => direction,
            Nearer::Touching => return Some(Found::Touching),
            Nearer::Unknown => return None,
        };
        directions.truncate(MOST - 1);
        directions.push_front(Direction::of(sides, along));
    }
    Some(Found::Apart)
}

/// A direction from the first mesh to the second, of unit length but for rounding.
struct Direction {
    /// Seen from each.
    own: [DVec3; 2],
    /// How far along it the second's origin is from the first's: metres.
    offset: f64,
}

impl Direction {
    fn of([a, b]: [&Side<'_>; 2], direction: DVec3) -> Self {
        let own = [a, b].map(|side| side.pose.rotation().transpose() * direction);
        Self { own, offset: direction.dot(b.pose.translation() - a.pose.translation()) }
    }

    /// How far apart two triangles are along it; rounded.
    fn gap(&self, a: &[DVec3; 3], b: &[DVec3; 3]) -> f64 {
        let [of_a, of_b] = self.own;
        let heights = |own: DVec3, corners: &[DVec3; 3]| corners.map(|corner| own.dot(corner));
        let most = heights(of_a, a).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let least = heights(of_b, b).into_iter().fold(f64::INFINITY, f64::min);
        self.offset + (least - most)
    }
}

/// Pairs of triangles of two meshes of which no two intersect: one of them is the nearest, unless it is at least `far` away,
/// metres. By at most how far apart they are, the nearest first. The same on every path.
fn nearest_triangles(
    (sides, meshes): ([&Side<'_>; 2], [&Mesh; 2]),
    relative: &RelativePose,
    scratch: &mut Scratch,
    far: f64,
) -> Vec<[u32; 2]> {
    // Lengths in the first axes are longer and shorter than the world's by so much: of two pairs each way.
    let stretch = relative.stretch().powi(4) as f32 * (1.0 + 16.0 * f32::EPSILON);
    // Swept radii are not among what is measured here.
    let far = far + sides[0].radius() + sides[1].radius();
    let (limit, found) = ((far as f32).next_up() * stretch, Vec::new());
    let search = Search { sides, meshes, relative, scratch, stretch, limit, axis: None, found };
    let Search { mut found, limit, .. } = dispatch(Unfused(search));
    found.retain(|one| one.lower <= limit);
    found.sort_unstable_by(|one, other| {
        one.lower.total_cmp(&other.lower).then(one.parts.cmp(&other.parts))
    });
    found.into_iter().map(|one| one.parts).collect()
}

/// A pair of triangles by index, and at most how far apart it is, metres.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    lower: f32,
    parts: [u32; 2],
}

struct Search<'a> {
    sides: [&'a Side<'a>; 2],
    meshes: [&'a Mesh; 2],
    relative: &'a RelativePose,
    scratch: &'a mut Scratch,
    /// By what factor a length in the first axes may have to be larger than another to be so in the world.
    stretch: f32,
    /// What is farther apart is not the nearest: metres of the first axes.
    limit: f32,
    /// From the second to the first, between the nearest so far.
    axis: Option<Vec3>,
    found: Vec<Candidate>,
}

impl<'a> Kernel for Search<'a> {
    type Output = Self;

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) -> Self {
        let [a, b] = self.sides;
        self.scratch.begin(b);
        self.scratch.open.clear();
        let roots = What::Blocks([a.root(), b.root()]);
        self.scratch.open.push(Open { lower: 0.0, what: roots });
        while let Some(Open { lower, what }) = self.scratch.open.pop() {
            if lower > self.limit {
                break;
            }
            let What::Blocks(blocks) = what else { continue };
            if a.is_leaf(blocks[0]) && b.is_leaf(blocks[1]) {
                self.measure(l, blocks);
            } else {
                let limit = self.limit.into();
                self.scratch.expand(l, self.relative, (self.sides, blocks), limit);
            }
        }
        self
    }
}

impl Search<'_> {
    /// Measures the triangles of two leaves: first those of the second that reach farthest towards the first.
    #[inline(always)]
    fn measure<L: Lanes>(&mut self, l: L, [leaf_a, leaf_b]: [u32; 2]) {
        let ([a, b], [mesh_a, mesh_b]) = (self.sides, self.meshes);
        self.scratch.place(l, self.relative, b, leaf_b);
        self.scratch.turn(l, self.relative, mesh_b, leaf_b);
        let own = &mesh_a.leaves()[leaf_a as usize];
        let leaves = Leaves::of(self.relative, own, &mesh_b.leaves()[leaf_b as usize], 0.0);
        let corners = [own.corners, self.scratch.corners[leaf_b as usize]];
        let corners = corners.each_ref();
        let boxes = &a.tree().map_or(&Aabb16::EMPTY, |tree| &tree.blocks()[leaf_a as usize]);
        let others = self.scratch.blocks[leaf_b as usize];
        let axis = self.axis.unwrap_or_else(|| -leaves.offset());
        let mut beside = Beside::of(l, &leaves, corners, axis);
        // Boxes of nothing are NaN here.
        let valid = (0..WIDTH).filter(|&lane| others.get(lane).is_valid());
        let mut left = valid.fold(0u32, |left, lane| left | 1 << lane);
        while let Some(lane) = beside.farthest(left) {
            left &= !(1 << lane);
            // The boxes of lanes without a triangle are infinitely far; their triangles are the first once more.
            let limit = self.limit.min(f32::MAX);
            let beyond = beside.farther(l, lane, limit);
            if beyond == 0xffff {
                // So are those that reach less far.
                break;
            }
            let open = !beyond & l.bits(l.le(boxes.gaps(l, &others.get(lane)), l.splat(limit)));
            if open == 0 {
                continue;
            }
            let gaps = TriangleGaps::of(l, &leaves, corners, lane);
            if self.take(l, &gaps, open)
                && let Some(axis) = self.axis
            {
                beside = Beside::of(l, &leaves, corners, axis);
            }
            let mut lowers = Row::default();
            l.store(gaps.lower, &mut lowers);
            let near = open & l.bits(l.le(gaps.lower, l.splat(self.limit)));
            for k in Bits(near) {
                let parts = [a.below(leaf_a).0[k], b.below(leaf_b).0[lane]];
                self.found.push(Candidate { lower: lowers.0[k], parts });
            }
        }
    }

    /// Takes in that no more than this is the least distance. Whether that is less than what was known.
    #[inline(always)]
    fn take<L: Lanes>(&mut self, l: L, gaps: &TriangleGaps<L>, open: u32) -> bool {
        let far = l.select(l.mask(open), gaps.upper, l.splat(f32::INFINITY));
        let (mut uppers, mut direction) = (Row::default(), [Row::default(); 3]);
        l.store(l.mul(far, l.splat(self.stretch)), &mut uppers);
        let mut nearest = 0;
        for k in 1..WIDTH {
            if uppers.0[k] < uppers.0[nearest] {
                nearest = k;
            }
        }
        // False for NaN.
        if !(uppers.0[nearest] < self.limit) {
            return false;
        }
        self.limit = uppers.0[nearest];
        gaps.direction.store(l, &mut direction);
        let [x, y, z] = &direction;
        self.axis = Some(Vec3::new(x.0[nearest], y.0[nearest], z.0[nearest]));
        true
    }
}

/// How far the triangles of two leaves reach along a direction.
struct Beside {
    /// The least height of the first's, and the greatest of the second's.
    low: Row,
    high: Row,
    /// What both lose, and the direction's length.
    lost: f32,
    length: f32,
}

impl Beside {
    #[inline(always)]
    fn of<L: Lanes>(l: L, leaves: &Leaves, corners: [&[Block; 3]; 2], axis: Vec3) -> Self {
        let [a, b] = load_rows(l, leaves, corners);
        let direction = V3(l.splat(axis.x), l.splat(axis.y), l.splat(axis.z));
        let ([least, _], [_, most]) = (interval(l, direction, &a), interval(l, direction, &b));
        let (mut low, mut high) = (Row::default(), Row::default());
        l.store(least, &mut low);
        l.store(most, &mut high);
        let lost = leaves.bound() * axis.abs().element_sum() * (1.0 + 4.0 * f32::EPSILON);
        Self { low, high, lost, length: axis.length() * (1.0 + 4.0 * f32::EPSILON) }
    }

    /// The triangle of the second leaf that reaches farthest towards the first, of those.
    #[inline(always)]
    fn farthest(&self, left: u32) -> Option<usize> {
        Bits(left).max_by(|&j, &k| self.high.0[j].total_cmp(&self.high.0[k]))
    }

    /// The lanes of the first leaf that are farther from a triangle of the second than that.
    #[inline(always)]
    fn farther<L: Lanes>(&self, l: L, lane: usize, limit: f32) -> u32 {
        let gap = l.sub(l.load(&self.low), l.splat(self.high.0[lane]));
        let beyond = (limit * self.length + self.lost) * (1.0 + 4.0 * f32::EPSILON);
        l.bits(l.lt(l.splat(beyond), gap))
    }
}
