//! Where two cuboids that touch touch: the axis of the least overlap, and up to four corners of what they have in common
//! along it: sixteen pairs at a time, in f32.
//!
//! Seen along the normal, what one cuboid shows is a parallelogram, an edge or a corner, and the face of the other that
//! clips it a rectangle. Each corner of what they have in common is found by itself: those of the parallelogram, the
//! crossings of its edges with the sides and with the surface, those of the rectangle, and where its sides meet the surface.
//! What the bounds do not settle is left to f64 (docs/numerics/proofs.md, "cuboids in lanes").

use super::super::bounds::U;
use super::super::frame::FramePair;
use super::super::packet::LanesOf;
use super::super::vector::V3;
use super::overlap::Overlap;
use super::{CuboidPairs, Cuboids, Order, in_range, pick, pick_vector};
use dcd_geom::Pair;
use dcd_simd::{Kernel, Lanes, Path, Row, Unfused, WIDTH, dispatch_on};

/// The least cosine between a face's normal and the contact's for the face to lie in it.
const FACING: f32 = crate::query::FACING as f32;

/// The most that an edge may rise along the contact's normal, relative to its length.
const LEVEL: f32 = crate::query::LEVEL as f32;

/// How far a point may be from the surfaces of its cuboids. Unit: u·m; of crossing edges over the sine between them.
/// Derived: 40. Smaller: false bounds.
const POINTS: f32 = 64.0;

/// How far beside a side, or above the surface, a corner may be that counts as on it. Unit: u·m. Smaller: corners that
/// rounding loses. Larger: points beside their faces; [`POINTS`] counts it.
const SLACK: f32 = 16.0;

/// Corners that are no farther apart are one. Unit: u·m. Larger than twice [`SLACK`].
const APART: f32 = 64.0;

/// How far the deepest corner's depth may be from the least overlap. Unit: u·m. Decides who answers, never an answer.
const SAME: f32 = 192.0;

/// Half edges below this part of the largest are no solid's. Decides who answers, never an answer.
const SOLID: f32 = 1e-3;

/// The squared sine below which edges are left to f64. No unit. Decides who answers.
const CROSSING: f32 = 1e-2;

/// How many places there are for corners: four of the parallelogram, two on each of its edges, four of the rectangle, and
/// one on each of its sides.
const SLOTS: usize = 20;

/// What the lanes found of a pair of cuboids that touch.
#[derive(Clone, Copy, Debug, Default)]
pub struct CuboidPatch {
    /// See [`Manifold::error_bound`](crate::query::Manifold::error_bound).
    pub(crate) error_bound: f32,
    /// Whether the first cuboid is b.
    pub(crate) is_swapped: bool,
    /// The numbers of the first's edge and of the second's that make the normal; −1: none.
    pub(crate) edges: [i8; 2],
    /// Whether the normal, from the first to the second, is against that edge or product.
    pub(crate) is_back: bool,
    /// Whose face clips: 0 or 1.
    pub(crate) clips: u8,
    /// What the first shows, and the second.
    pub(crate) shown: [Shown; 2],
    /// One to four; 0 where nothing is known.
    pub(crate) count: u8,
    /// The deepest first.
    pub(crate) points: [PatchPoint; 4],
}

/// What a cuboid shows along the normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shown {
    pub(crate) kind: ShownKind,
    /// The axis that the face is normal to, or that the edge is along.
    pub(crate) axis: u8,
    /// The number of the farthest corner: a bit for each axis.
    pub(crate) corner: u8,
}

/// A face, an edge or a corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum ShownKind {
    #[default]
    Face,
    Edge,
    Vertex,
}

/// A point of the first cuboid where its face clips, else of the second, and how deep the two overlap there.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PatchPoint {
    /// From the first's centre, world axes, metres.
    pub(crate) offset: [f32; 3],
    pub(crate) depth: f32,
    /// The two that meet there: edges of what is clipped, from the corner of their number to the next, below 4; sides of the face
    /// below 8, at the high end of its first axis, the low end, of the second alike; 8: the surface.
    pub(crate) bounds: [u8; 2],
}

impl CuboidPatch {
    /// Whether anything was found.
    #[inline(always)]
    pub(crate) fn is_known(&self) -> bool {
        self.count > 0
    }
}

impl Shown {
    fn decode(code: f32) -> Self {
        let code = code as u8;
        let kind = match code % 4 {
            0 => ShownKind::Face,
            1 => ShownKind::Edge,
            _ => ShownKind::Vertex,
        };
        Self { kind, axis: code / 4 % 4, corner: code / 16 }
    }
}

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Scratch {
    packet: CuboidPairs,
    rows: Rows,
    /// For each pair what was found.
    pub(in super::super) found: Vec<CuboidPatch>,
}

/// What is found of sixteen pairs.
#[derive(Clone, Debug, Default)]
struct Rows {
    /// The bound, the two edges, whose face clips, what each shows, and how many points.
    header: [Row; 7],
    /// Of each point three coordinates, the depth and the bounds.
    points: [[Row; 5]; 4],
}

/// Looks at pairs of cuboids, all of which are known to touch. The same bits on every path.
pub(in super::super) fn find(
    path: Path,
    frames: FramePair<'_>,
    pairs: &[Pair],
    scratch: &mut Scratch,
) {
    scratch.found.clear();
    scratch.found.resize(pairs.len(), CuboidPatch::default());
    dispatch_on(path, Unfused(Search { frames, pairs, scratch }));
}

struct Search<'a> {
    frames: FramePair<'a>,
    pairs: &'a [Pair],
    scratch: &'a mut Scratch,
}

impl Kernel for Search<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Scratch { packet, rows, found } = self.scratch;
        for (pairs, found) in self.pairs.chunks(WIDTH).zip(found.chunks_mut(WIDTH)) {
            packet.read(self.frames, pairs, Order::ByCentres);
            let used = ((1u64 << pairs.len()) - 1) as u32;
            let (live, backward) = search(l, packet, rows);
            for lane in LanesOf(live & used) {
                found[lane] = rows.patch(lane, packet.swapped, backward);
            }
        }
    }
}

impl Rows {
    #[inline(always)]
    fn patch(&self, lane: usize, swapped: u32, backward: u32) -> CuboidPatch {
        let [error_bound, of_first, of_second, clips, first, second, count] = &self.header;
        let at = |row: &Row| row.0[lane];
        let mut points = [PatchPoint::default(); 4];
        for (point, [x, y, z, depth, bounds]) in points.iter_mut().zip(&self.points) {
            let bounds = at(bounds) as u8;
            *point = PatchPoint {
                offset: [at(x), at(y), at(z)],
                depth: at(depth),
                bounds: [bounds / 16, bounds % 16],
            };
        }
        CuboidPatch {
            error_bound: at(error_bound),
            is_swapped: swapped >> lane & 1 == 1,
            edges: [at(of_first) as i8, at(of_second) as i8],
            is_back: backward >> lane & 1 == 1,
            clips: at(clips) as u8,
            shown: [Shown::decode(at(first)), Shown::decode(at(second))],
            count: at(count) as u8,
            points,
        }
    }
}

/// Writes what is found of sixteen pairs. Returns the lanes of which something is, and those whose normal is against its
/// edge.
#[inline(always)]
fn search<L: Lanes>(l: L, packet: &CuboidPairs, rows: &mut Rows) -> (u32, u32) {
    let (first, second, between, size) = packet.load(l);
    let overlap = Overlap::of(l, [&first, &second], between, size);
    let (normal, backward) = overlap.normal(l, [&first, &second], between);
    let sides = [Side::of(l, &first, normal), Side::of(l, &second, normal.neg(l))];
    let unit = l.mul(size, l.splat(U));
    let [of_first, of_second] = [sides[0].facing(l), sides[1].facing(l)];
    let second_clips = l.lt(of_first, of_second);
    let has_face = l.or(sides[0].is_face, sides[1].is_face);
    let are_edges = l.and(sides[0].is_edge, sides[1].is_edge);
    let clip = Clip::of(l, [&sides[1], &sides[0]], second_clips, between);
    let mut slots = Slots::empty(l);
    clip.fill(l, l.mul(unit, l.splat(SLACK)), &mut slots);
    let near = l.mul(unit, l.splat(APART));
    let kept = slots.to_four(l, clip.plane_axes(l), near);
    let crossing = Crossing::of(l, &sides, between);
    for (k, (corner, rows)) in kept.corners.iter().zip(&mut rows.points).enumerate() {
        let mut offset = clip.in_world(l, [corner.x, corner.y]);
        let mut depth = corner.depth;
        if k == 0 {
            offset = V3::select(l, has_face, offset, crossing.offset);
            depth = overlap.value;
        }
        let zero = l.splat(0.0);
        let [x, y, z, of_depth, bounds] = rows;
        l.store(offset.0, x);
        l.store(offset.1, y);
        l.store(offset.2, z);
        l.store(l.max(l.min(depth, overlap.value), zero), of_depth);
        l.store(corner.bounds, bounds);
    }
    let one = l.splat(1.0);
    let points = l.mul(unit, l.splat(POINTS));
    let points = l.select(has_face, points, l.div(points, crossing.sine));
    let [error, edge_a, edge_b, clips, shown_a, shown_b, count] = &mut rows.header;
    l.store(l.add(overlap.bound, points), error);
    l.store(overlap.edges[0], edge_a);
    l.store(overlap.edges[1], edge_b);
    l.store(l.select(second_clips, one, l.splat(0.0)), clips);
    l.store(sides[0].code(l), shown_a);
    l.store(sides[1].code(l), shown_b);
    l.store(l.select(has_face, kept.count, one), count);
    // Cuboids whose centres are one have no order.
    let mut is_known = l.lt(l.splat(0.0), between.norm1(l));
    is_known = l.and(is_known, l.and(first.is_solid(l), second.is_solid(l)));
    is_known = l.and(is_known, overlap.is_known(l, size));
    let same = l.mul(unit, l.splat(SAME));
    let is_deepest = l.le(l.abs(l.sub(kept.corners[0].depth, overlap.value)), same);
    let is_crossing = l.and(are_edges, crossing.is_known);
    let by_face = l.and(has_face, is_deepest);
    is_known = l.and(is_known, l.or(by_face, l.and_not(is_crossing, has_face)));
    (l.bits(is_known) & in_range(l, size), l.bits(backward))
}

impl<L: Lanes> Cuboids<L> {
    /// Whether no half edge is small beside another.
    #[inline(always)]
    fn is_solid(&self, l: L) -> L::M {
        let [x, y, z] = self.half;
        let (least, most) = (l.min(x, l.min(y, z)), l.max(x, l.max(y, z)));
        l.lt(l.mul(most, l.splat(SOLID)), least)
    }
}

/// A cuboid, and what it shows along a direction.
struct Side<L: Lanes> {
    cuboid: Cuboids<L>,
    /// The direction's parts along its edges.
    towards: [L::F; 3],
    is_face: L::M,
    is_edge: L::M,
    /// The axis that is the most along the direction, and the one that is the least.
    most: L::F,
    least: L::F,
    /// How much along the direction the first of them is.
    along: L::F,
}

impl<L: Lanes> Side<L> {
    #[inline(always)]
    fn of(l: L, cuboid: &Cuboids<L>, direction: V3<L>) -> Self {
        let towards = cuboid.along(l, direction);
        let (mut along, mut level) = (l.abs(towards[0]), l.abs(towards[0]));
        let (mut most, mut least) = (l.splat(0.0), l.splat(0.0));
        for (k, towards) in towards.iter().enumerate().skip(1) {
            let (here, number) = (l.abs(*towards), l.splat(k as f32));
            most = l.select(l.lt(along, here), number, most);
            least = l.select(l.lt(here, level), number, least);
            along = l.max(along, here);
            level = l.min(level, here);
        }
        let is_face = l.lt(l.splat(FACING), along);
        let is_edge = l.and_not(l.lt(level, l.splat(LEVEL)), is_face);
        Self { cuboid: *cuboid, towards, is_face, is_edge, most, least, along }
    }

    /// How square to the direction its face is; 0 where it is no face.
    #[inline(always)]
    fn facing(&self, l: L) -> L::F {
        l.select(self.is_face, self.along, l.splat(0.0))
    }

    /// What it shows, as a number: see [`Shown::decode`].
    #[inline(always)]
    fn code(&self, l: L) -> L::F {
        let kind = l.select(self.is_edge, l.splat(1.0), l.splat(2.0));
        let kind = l.select(self.is_face, l.splat(0.0), kind);
        let axis = l.select(self.is_edge, self.least, self.most);
        let mut code = l.add(kind, l.mul(axis, l.splat(4.0)));
        for (k, towards) in self.towards.iter().enumerate() {
            let is_high = l.le(l.splat(0.0), *towards);
            let bit = l.select(is_high, l.splat((16 << k) as f32), l.splat(0.0));
            code = l.add(code, bit);
        }
        code
    }

    #[inline(always)]
    fn select(l: L, mask: L::M, [yes, no]: [&Self; 2]) -> Self {
        let numbers = |yes: [L::F; 3], no: [L::F; 3]| {
            [
                l.select(mask, yes[0], no[0]),
                l.select(mask, yes[1], no[1]),
                l.select(mask, yes[2], no[2]),
            ]
        };
        let masks = |yes: L::M, no: L::M| l.or(l.and(mask, yes), l.and_not(no, mask));
        let axis = |k: usize| V3::select(l, mask, yes.cuboid.axes[k], no.cuboid.axes[k]);
        Self {
            cuboid: Cuboids {
                axes: [axis(0), axis(1), axis(2)],
                half: numbers(yes.cuboid.half, no.cuboid.half),
            },
            towards: numbers(yes.towards, no.towards),
            is_face: masks(yes.is_face, no.is_face),
            is_edge: masks(yes.is_edge, no.is_edge),
            most: l.select(mask, yes.most, no.most),
            least: l.select(mask, yes.least, no.least),
            along: l.select(mask, yes.along, no.along),
        }
    }

    /// Its axes, half edges and parts of the direction, from the axis of that number on.
    #[inline(always)]
    fn from_axis(&self, l: L, number: L::F) -> ([V3<L>; 3], [L::F; 3], [L::F; 3]) {
        let turned = |[x, y, z]: [L::F; 3]| {
            [pick(l, number, [x, y, z]), pick(l, number, [y, z, x]), pick(l, number, [z, x, y])]
        };
        let [x, y, z] = self.cuboid.axes;
        let axes = [
            pick_vector(l, number, [x, y, z]),
            pick_vector(l, number, [y, z, x]),
            pick_vector(l, number, [z, x, y]),
        ];
        (axes, turned(self.cuboid.half), turned(self.towards))
    }
}

/// A number with the sign of another.
#[inline(always)]
fn signed<L: Lanes>(l: L, x: L::F, sign: L::F) -> L::F {
    l.select(l.le(l.splat(0.0), sign), x, l.neg(x))
}

/// A point as it is seen from the face that clips: along its sides, and how far under it.
type Seen<L> = [<L as Lanes>::F; 3];

#[inline(always)]
fn sum<L: Lanes>(l: L, x: Seen<L>, y: Seen<L>) -> Seen<L> {
    [l.add(x[0], y[0]), l.add(x[1], y[1]), l.add(x[2], y[2])]
}

#[inline(always)]
fn difference<L: Lanes>(l: L, x: Seen<L>, y: Seen<L>) -> Seen<L> {
    [l.sub(x[0], y[0]), l.sub(x[1], y[1]), l.sub(x[2], y[2])]
}

/// The point that is that share of the way from one to another.
#[inline(always)]
fn between<L: Lanes>(l: L, from: Seen<L>, to: Seen<L>, share: L::F) -> Seen<L> {
    let [x, y, z] = difference(l, to, from);
    [l.mul_add(x, share, from[0]), l.mul_add(y, share, from[1]), l.mul_add(z, share, from[2])]
}

/// A face that clips, and what it clips.
struct Clip<L: Lanes> {
    /// The face's normal, and its sides.
    axes: [V3<L>; 3],
    /// Half of the sides.
    half: [L::F; 2],
    /// The middle of the face from the first cuboid's centre, world axes.
    middle: V3<L>,
    /// The direction's parts along the face's normal and sides.
    towards: [L::F; 3],
    /// The parallelogram's middle, and half its edges.
    clipped: Seen<L>,
    edges: [Seen<L>; 2],
    is_face: L::M,
    is_vertex: L::M,
    is_edge: L::M,
}

impl<L: Lanes> Clip<L> {
    /// Of the second and first side, by whether the second clips.
    #[inline(always)]
    fn of(l: L, sides: [&Side<L>; 2], second_clips: L::M, apart: V3<L>) -> Self {
        let zero = l.splat(0.0);
        let none = V3(zero, zero, zero);
        let clips = Side::select(l, second_clips, sides);
        let other = Side::select(l, second_clips, [sides[1], sides[0]]);
        let place = V3::select(l, second_clips, apart, none);
        let to_other = V3::select(l, second_clips, apart.neg(l), apart);
        let (axes, [half, half_p, half_q], towards) = clips.from_axis(l, clips.most);
        let plane = signed(l, half, towards[0]);
        // What is clipped, from the first axis of its face or edge on.
        let after = l.select(l.lt(other.most, l.splat(1.5)), l.add(other.most, l.splat(1.0)), zero);
        let from = l.select(other.is_edge, other.least, after);
        let ([u, v, w], [half_u, half_v, half_w], along) = other.from_axis(l, from);
        let all = l.le(zero, zero);
        let is_vertex = l.and_not(all, l.or(other.is_face, other.is_edge));
        let mut middle = to_other.plus(l, signed(l, half_w, along[2]), w);
        let at_v = l.select(other.is_face, zero, signed(l, half_v, along[1]));
        let at_u = l.select(is_vertex, signed(l, half_u, along[0]), zero);
        middle = middle.plus(l, at_v, v).plus(l, at_u, u);
        let half_u = l.select(is_vertex, zero, half_u);
        let half_v = l.select(other.is_face, half_v, zero);
        let mut clip = Self {
            axes,
            half: [half_p, half_q],
            middle: place.plus(l, plane, axes[0]),
            towards,
            clipped: [zero; 3],
            edges: [[zero; 3]; 2],
            is_face: other.is_face,
            is_vertex,
            is_edge: other.is_edge,
        };
        clip.clipped = clip.seen(l, middle, plane);
        clip.edges = [
            clip.seen(l, none.plus(l, half_u, u), zero),
            clip.seen(l, none.plus(l, half_v, v), zero),
        ];
        clip
    }

    /// A point from the centre of the cuboid that clips, moved along the normal into a plane of the face; for a plane at 0
    /// the same of a direction.
    #[inline(always)]
    fn seen(&self, l: L, point: V3<L>, plane: L::F) -> Seen<L> {
        let [normal, p, q] = self.axes;
        let [upright, along_p, along_q] = self.towards;
        let above = l.div(l.sub(normal.dot(l, point), plane), upright);
        let below = l.neg(above);
        [
            l.mul_add(below, along_p, p.dot(l, point)),
            l.mul_add(below, along_q, q.dot(l, point)),
            below,
        ]
    }

    /// A point of the face from the first cuboid's centre, world axes.
    #[inline(always)]
    fn in_world(&self, l: L, [x, y]: [L::F; 2]) -> V3<L> {
        let [_, p, q] = self.axes;
        self.middle.plus(l, x, p).plus(l, y, q)
    }

    /// What makes coordinates along the sides those square to the normal: x times the first less y times the second, and y
    /// times the third.
    #[inline(always)]
    fn plane_axes(&self, l: L) -> [L::F; 3] {
        let [upright, along_p, along_q] = self.towards;
        let length = l.sqrt(l.sub(l.splat(1.0), l.mul(along_p, along_p)));
        [length, l.div(l.mul(along_p, along_q), length), l.div(upright, length)]
    }

    /// Finds the corners of what the face has in common with what it clips.
    #[inline(always)]
    fn fill(&self, l: L, slack: L::F, slots: &mut Slots<L>) {
        let [u, v] = self.edges;
        let (low, high) = (difference(l, self.clipped, v), sum(l, self.clipped, v));
        let points =
            [difference(l, low, u), sum(l, low, u), sum(l, high, u), difference(l, high, u)];
        let inside = |[x, y, depth]: Seen<L>| {
            let [half_x, half_y] = self.half;
            [l.sub(half_x, x), l.add(half_x, x), l.sub(half_y, y), l.add(half_y, y), depth]
        };
        let inside = [inside(points[0]), inside(points[1]), inside(points[2]), inside(points[3])];
        let limit = l.neg(slack);
        let is_corner = [
            l.or(self.is_vertex, l.or(self.is_edge, self.is_face)),
            l.or(self.is_edge, self.is_face),
            self.is_face,
            self.is_face,
        ];
        for (k, point) in points.into_iter().enumerate() {
            let mut is_within = is_corner[k];
            for bound in inside[k] {
                is_within = l.and(is_within, l.le(limit, bound));
            }
            // A single corner is the deepest, wherever rounding puts it.
            let is_used = if k == 0 { l.or(is_within, self.is_vertex) } else { is_within };
            slots.set(l, k, point, l.splat((17 * k) as f32), is_used);
        }
        for from in 0..4 {
            let to = (from + 1) % 4;
            let is_edge = if from == 0 { is_corner[1] } else { self.is_face };
            let ends = [(points[from], inside[from]), (points[to], inside[to])];
            let run = Run::of(l, [&ends[0].1, &ends[1].1], limit);
            for end in 0..2 {
                let point = between(l, points[from], points[to], run.range[end]);
                let bounds = l.add(run.by[end], l.splat((16 * from + 4) as f32));
                let is_used = l.and(is_edge, run.is_used[end]);
                slots.set(l, 4 + 2 * from + end, point, bounds, is_used);
            }
        }
        self.fill_rectangle(l, slack, slots);
    }

    /// The corners of the rectangle that are within the parallelogram, and where its sides meet the surface within.
    #[inline(always)]
    fn fill_rectangle(&self, l: L, slack: L::F, slots: &mut Slots<L>) {
        let ([x, y, depth], [u, v]) = (self.clipped, self.edges);
        let one = l.splat(1.0);
        let inverse = l.div(one, l.sub(l.mul(u[0], v[1]), l.mul(u[1], v[0])));
        // Along the edges, as parts of them: how much a step along x and one along y is.
        let along_x = [l.mul(v[1], inverse), l.neg(l.mul(u[1], inverse))];
        let along_y = [l.neg(l.mul(v[0], inverse)), l.mul(u[0], inverse)];
        let limit = |k: usize| l.mul_add(slack, l.add(l.abs(along_x[k]), l.abs(along_y[k])), one);
        let limit = [limit(0), limit(1)];
        let at = |px: L::F, py: L::F| {
            let (px, py) = (l.sub(px, x), l.sub(py, y));
            let along = |k: usize| l.mul_add(px, along_x[k], l.mul(py, along_y[k]));
            [along(0), along(1)]
        };
        // False for NaN, which parallel edges make.
        let is_within = |[a, b]: [L::F; 2]| {
            let within = l.and(l.le(l.abs(a), limit[0]), l.le(l.abs(b), limit[1]));
            l.and(within, self.is_face)
        };
        let [half_x, half_y] = self.half;
        let (low_x, low_y) = (l.neg(half_x), l.neg(half_y));
        let places = [[half_x, half_y], [low_x, half_y], [low_x, low_y], [half_x, low_y]];
        let see = |[px, py]: [L::F; 2]| {
            let [a, b] = at(px, py);
            ([a, b], [px, py, l.mul_add(a, u[2], l.mul_add(b, v[2], depth))])
        };
        let seen = [see(places[0]), see(places[1]), see(places[2]), see(places[3])];
        let zero = l.splat(0.0);
        for k in 0..4 {
            let (along, point) = seen[k];
            let is_deep = l.le(l.neg(slack), point[2]);
            let (sides, to_next) = ([4 * 16 + 6, 5 * 16 + 6, 5 * 16 + 7, 4 * 16 + 7], [6, 5, 7, 4]);
            let is_used = l.and(is_within(along), is_deep);
            slots.set(l, 12 + k, point, l.splat(sides[k] as f32), is_used);
            let (_, next) = seen[(k + 1) % 4];
            let share = l.div(point[2], l.sub(point[2], next[2]));
            let crossing = between(l, point, next, share);
            let (is_above, next_above) = (l.lt(point[2], zero), l.lt(next[2], zero));
            let crosses = l.or(l.and_not(is_above, next_above), l.and_not(next_above, is_above));
            let is_used = l.and(crosses, is_within(at(crossing[0], crossing[1])));
            slots.set(l, 16 + k, crossing, l.splat((16 * to_next[k] + 8) as f32), is_used);
        }
    }
}

/// The part of an edge that is within the bounds.
struct Run<L: Lanes> {
    /// From 0 at its one end to 1 at the other.
    range: [L::F; 2],
    /// The number of the bound at which each end of the part is.
    by: [L::F; 2],
    /// Whether it is one: the edge's own end is not within.
    is_used: [L::M; 2],
}

impl<L: Lanes> Run<L> {
    /// Of an edge whose ends are that far within each bound; beyond it below the limit.
    #[inline(always)]
    fn of(l: L, [from, to]: [&[L::F; 5]; 2], limit: L::F) -> Self {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let (mut range, mut by) = ([zero, one], [zero; 2]);
        let none = l.lt(one, zero);
        let (mut from_is_out, mut to_is_out, mut is_out) = (none, none, none);
        for bound in 0..5 {
            let (here, there) = (from[bound], to[bound]);
            let (here_out, there_out) = (l.lt(here, limit), l.lt(there, limit));
            let share = l.div(here, l.sub(here, there));
            let number = l.splat(bound as f32);
            let raises = l.and(l.and_not(here_out, there_out), l.lt(range[0], share));
            range[0] = l.select(raises, share, range[0]);
            by[0] = l.select(raises, number, by[0]);
            let lowers = l.and(l.and_not(there_out, here_out), l.lt(share, range[1]));
            range[1] = l.select(lowers, share, range[1]);
            by[1] = l.select(lowers, number, by[1]);
            is_out = l.or(is_out, l.and(here_out, there_out));
            from_is_out = l.or(from_is_out, here_out);
            to_is_out = l.or(to_is_out, there_out);
        }
        let is_some = l.and_not(l.le(range[0], range[1]), is_out);
        let is_used = [l.and(is_some, from_is_out), l.and(is_some, to_is_out)];
        Self { range, by, is_used }
    }
}

/// A corner: its place along the sides, its depth, and the bounds that meet there.
#[derive(Clone, Copy)]
struct Corner<L: Lanes> {
    x: L::F,
    y: L::F,
    depth: L::F,
    bounds: L::F,
}

impl<L: Lanes> Corner<L> {
    #[inline(always)]
    fn select(l: L, mask: L::M, yes: Self, no: Self) -> Self {
        Self {
            x: l.select(mask, yes.x, no.x),
            y: l.select(mask, yes.y, no.y),
            depth: l.select(mask, yes.depth, no.depth),
            bounds: l.select(mask, yes.bounds, no.bounds),
        }
    }
}

/// The corners that may be; of those that are not the depth is −∞.
struct Slots<L: Lanes>([Corner<L>; SLOTS]);

/// The corners that stand for all, and how many they are.
struct Kept<L: Lanes> {
    corners: [Corner<L>; 4],
    count: L::F,
}

impl<L: Lanes> Slots<L> {
    #[inline(always)]
    fn empty(l: L) -> Self {
        let zero = l.splat(0.0);
        Self([Corner { x: zero, y: zero, depth: l.splat(f32::NEG_INFINITY), bounds: zero }; SLOTS])
    }

    #[inline(always)]
    fn set(&mut self, l: L, k: usize, [x, y, depth]: Seen<L>, bounds: L::F, is_used: L::M) {
        let depth = l.select(is_used, depth, l.splat(f32::NEG_INFINITY));
        self.0[k] = Corner { x, y, depth, bounds };
    }

    /// The deepest; the farthest from it, seen along the normal; the one that spans the largest triangle with both; and the
    /// one farthest outside of that triangle. Of corners in line the ends.
    #[inline(always)]
    fn to_four(&self, l: L, axes: [L::F; 3], near: L::F) -> Kept<L> {
        let at = |corner: &Corner<L>| {
            let [length, across, upright] = axes;
            let x = l.sub(l.mul(corner.x, length), l.mul(corner.y, across));
            [x, l.mul(corner.y, upright)]
        };
        let from = |point: [L::F; 2], origin: [L::F; 2]| {
            [l.sub(point[0], origin[0]), l.sub(point[1], origin[1])]
        };
        let cross = |p: [L::F; 2], q: [L::F; 2]| l.sub(l.mul(p[0], q[1]), l.mul(p[1], q[0]));
        let squared = |p: [L::F; 2]| l.mul_add(p[0], p[0], l.mul(p[1], p[1]));
        let least = l.splat(f32::NEG_INFINITY);
        let first = self.most(l, |corner| corner.depth).0;
        let origin = at(&first);
        let is_used = |corner: &Corner<L>| l.lt(least, corner.depth);
        let if_used = |corner: &Corner<L>, value| l.select(is_used(corner), value, least);
        let (second, span) =
            self.most(l, |corner| if_used(corner, squared(from(at(corner), origin))));
        let base = from(at(&second), origin);
        let (third, off_line) =
            self.most(l, |corner| if_used(corner, l.abs(cross(base, from(at(corner), origin)))));
        // Counter-clockwise.
        let side = cross(base, from(at(&third), origin));
        let (end, start) = (at(&third), at(&second));
        let to_third = from(end, start);
        let back = from(origin, end);
        let (fourth, outside) = self.most(l, |corner| {
            let point = at(corner);
            let beyond = [
                cross(base, from(point, origin)),
                cross(to_third, from(point, start)),
                cross(back, from(point, end)),
            ];
            let beyond = l.max(signed_by(l, beyond[0], side), {
                l.max(signed_by(l, beyond[1], side), signed_by(l, beyond[2], side))
            });
            if_used(corner, beyond)
        });
        let (last, _) =
            self.most(l, |corner| if_used(corner, squared(from(at(corner), at(&second)))));
        let near_squared = l.mul(near, near);
        let level = l.mul(near, l.sqrt(squared(base)));
        let has_second = l.lt(near_squared, span);
        let is_wide = l.and(has_second, l.lt(level, off_line));
        let has_fourth = l.and(is_wide, l.lt(level, outside));
        // In line: the other end, unless the deepest is it.
        let has_last = l.lt(near_squared, squared(from(at(&last), origin)));
        let third = Corner::select(l, is_wide, third, last);
        let has_third = l.or(is_wide, l.and(has_second, has_last));
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let count_of = |mask: L::M| l.select(mask, one, zero);
        let count = l.add(l.add(one, count_of(has_second)), {
            l.add(count_of(has_third), count_of(has_fourth))
        });
        Kept { corners: [first, second, third, fourth], count }
    }

    /// The first corner with the largest value, and that.
    #[inline(always)]
    fn most(&self, l: L, value: impl Fn(&Corner<L>) -> L::F) -> (Corner<L>, L::F) {
        let Self(corners) = self;
        let (mut best, mut most) = (corners[0], value(&corners[0]));
        for corner in &corners[1..] {
            let value = value(corner);
            let is_more = l.lt(most, value);
            best = Corner::select(l, is_more, *corner, best);
            most = l.max(most, value);
        }
        (best, most)
    }
}

/// How far outside of an edge of the triangle: against the sense in which the triangle goes round.
#[inline(always)]
fn signed_by<L: Lanes>(l: L, x: L::F, sense: L::F) -> L::F {
    l.select(l.lt(l.splat(0.0), sense), l.neg(x), x)
}

/// Where an edge of the first crosses one of the second.
struct Crossing<L: Lanes> {
    /// On the first's edge, from its centre, world axes.
    offset: V3<L>,
    sine: L::F,
    is_known: L::M,
}

impl<L: Lanes> Crossing<L> {
    #[inline(always)]
    fn of(l: L, sides: &[Side<L>; 2], apart: V3<L>) -> Self {
        let zero = l.splat(0.0);
        // The edge's axis, half of it, and its middle from the cuboid's own centre.
        let edge = |side: &Side<L>| {
            let ([e, v, w], [half, half_v, half_w], along) = side.from_axis(l, side.least);
            let middle = V3(zero, zero, zero).plus(l, signed(l, half_v, along[1]), v).plus(
                l,
                signed(l, half_w, along[2]),
                w,
            );
            (e, half, middle)
        };
        let (e, half, middle) = edge(&sides[0]);
        let (f, _, of_second) = edge(&sides[1]);
        let between = of_second.add(l, apart).sub(l, middle);
        let cosine = e.dot(l, f);
        let squared = l.sub(l.splat(1.0), l.mul(cosine, cosine));
        let (along_e, along_f) = (e.dot(l, between), f.dot(l, between));
        let along = l.div(l.sub(along_e, l.mul(cosine, along_f)), squared);
        let along = l.max(l.min(along, half), l.neg(half));
        let is_known = l.lt(l.splat(CROSSING), squared);
        Self { offset: middle.plus(l, along, e), sine: l.sqrt(squared), is_known }
    }
}
