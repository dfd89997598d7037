//! How far the cores of sixteen pairs are apart: GJK to the nearest points, with a bound from below that is
//! proved and the vertices that the nearest points lie between.

use super::bounds::{CLOSED, SHORTEST, U};
use super::certificate::{Certificate, CertifiedBounds, separates};
use super::first_stages::{Entry, Place, Resolved};
use super::frame::FramePair;
use super::obb::{self, ObbPairs};
use super::packet::{
    AFTER_NEAREST, AFTER_SPHERES, Corner, LanesOf, Number, PacketQueue, PairPacket, Vector, Whole,
    corner_of_vertices,
};
use super::portal::{ROUNDS, portal_holds_origin};
use super::simplex::{Nearest, Vertex, radii_reach};
use super::support::SupportScratch;
use super::vector::V3;
use dcd_geom::{Pair, Polytope};
use dcd_simd::{Kernel, Lanes, Path, Unfused, WIDTH, dispatch_on};

/// What the lanes found of a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Found {
    /// Nothing: the lanes do not know one of the shapes, or not at that size.
    #[default]
    Unknown,
    /// That they are farther apart than the margin.
    Beyond,
    /// The nearest points of the cores.
    Nearest(NearestPoints),
}

/// Three points of A − B whose weighted mean is nearest to the origin, or nearly so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NearestPoints {
    /// For each the numbers of its vertices in a and in b.
    pub(super) corners: [[u32; 2]; 3],
    /// The weights of the second and the third; the first has what they leave of 1.
    pub(super) weights: [f32; 2],
    /// At most the distance of the cores, metres: proved.
    pub(super) lower: f32,
}

impl NearestPoints {
    /// The numbers of the corners' vertices in the polytopes a and b.
    pub(super) fn corners_of(&self, polytopes: [&Polytope; 2]) -> [[u32; 2]; 3] {
        // The last block is filled up with the last vertex.
        let last = polytopes.map(|polytope| polytope.vertices().len() as u32 - 1);
        self.corners.map(|[of_a, of_b]| [of_a.min(last[0]), of_b.min(last[1])])
    }
}

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    entry: Entry,
    support_scratch: SupportScratch,
    boxes: ObbPairs,
    packet: PairPacket,
    /// What waits for its first support.
    first: PacketQueue<AFTER_SPHERES>,
    /// What waits for the next one.
    next: PacketQueue<AFTER_NEAREST>,
    /// For each pair of the slice what was found.
    pub(super) found: Vec<Found>,
}

/// Looks for the nearest points of each pair, all of which are known to be apart. The same bits on every path, for frames
/// prepared without fused operations.
pub(super) fn find(
    path: Path,
    frames: FramePair<'_>,
    (pairs, margin): (&[Pair], f64),
    scratch: &mut Scratch,
) {
    // Rounded up, so that no pair within the margin is left out.
    let margin = (margin as f32).next_up();
    scratch.found.clear();
    scratch.found.resize(pairs.len(), Found::Unknown);
    dispatch_on(path, Unfused(CoreSearch { frames, pairs, margin, scratch }));
}

struct CoreSearch<'a> {
    frames: FramePair<'a>,
    pairs: &'a [Pair],
    margin: f32,
    scratch: &'a mut Scratch,
}

impl Kernel for CoreSearch<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let mut first = 0;
        loop {
            let whole = if first < self.pairs.len() { Whole::Only } else { Whole::OrLast };
            if whole == Whole::Only {
                self.begin(l, first);
                first += WIDTH;
            }
            // The later stage first: so the earlier one finds space for what it hands on.
            loop {
                if self.scratch.next.has(whole) {
                    self.round(l);
                } else if self.scratch.first.has(whole) {
                    self.first_support(l);
                } else {
                    break;
                }
            }
            if whole == Whole::OrLast {
                break;
            }
        }
    }
}

impl CoreSearch<'_> {
    /// Reads sixteen pairs and lets go of those whose spheres or boxes are farther apart than the margin.
    #[inline(always)]
    fn begin<L: Lanes>(&mut self, l: L, first: usize) {
        let pairs = &self.pairs[first..self.pairs.len().min(first + WIDTH)];
        let Scratch { entry, boxes, first: queue, found, .. } = &mut *self.scratch;
        entry.read::<CertifiedBounds>(self.frames, pairs, first as u32);
        let spheres = entry.spheres::<L, CertifiedBounds>(l);
        let live = entry.live;
        let mut beyond = beyond_by(l, spheres, self.margin) & live;
        let packet = &mut entry.packet;
        if entry.boxed & live & !beyond != 0 {
            let tried = obb::faces(l, self.frames, boxes, (&*packet, pairs.len()));
            beyond |= beyond_by(l, tried, self.margin) & entry.boxed & live;
        }
        put_apart(found, packet, beyond);
        queue.push(l, packet, live & !beyond);
    }

    /// The first point of each is the support along the axis between the centres.
    #[inline(always)]
    fn first_support<L: Lanes>(&mut self, l: L) {
        let Scratch { support_scratch, packet, first, next, found, .. } = &mut *self.scratch;
        let taken = first.take(l, packet);
        let used = (1u32 << taken) - 1;
        let mut at = Place { frames: self.frames, support_scratch };
        let d = packet.vector(l, Vector::C).neg(l);
        let apart = Resolved::apart(l, begin(l, &mut at, (packet, taken), d));
        let beyond = beyond_by(l, apart, self.margin) & used;
        put_apart(found, packet, beyond);
        next.push(l, packet, used & !beyond);
    }

    /// One support towards the origin: the pair is beyond the margin, or its nearest point is as near as it
    /// gets, or there is a nearer one.
    #[inline(always)]
    fn round<L: Lanes>(&mut self, l: L) {
        let Scratch { support_scratch, packet, next, found, .. } = &mut *self.scratch;
        let taken = next.take(l, packet);
        let used = (1u32 << taken) - 1;
        let mut at = Place { frames: self.frames, support_scratch };
        let step = Step::of(l, &mut at, packet, taken);
        let beyond = beyond_by(l, step.apart(l), self.margin) & used;
        put_apart(found, packet, beyond);
        let done = step.done & used & !beyond;
        put_nearest(found, packet, done);
        step.keep(l, packet);
        next.push(l, packet, used & !(beyond | done));
    }
}

/// The first support, in a direction. Whether the pair is apart by the axis against it.
#[inline(always)]
pub(super) fn begin<L: Lanes>(
    l: L,
    at: &mut Place<'_>,
    (packet, used): (&mut PairPacket, usize),
    d: V3<L>,
) -> Certificate<L> {
    packet.set_number(l, Number::Lower, l.splat(0.0));
    let new = support(l, at, packet, (d, used));
    let axis = d.neg(l);
    let apart = look_along(l, packet, axis, new.at);
    let (zero, one) = (l.splat(0.0), [new; 3]);
    keep(l, packet, one, [zero; 2]);
    let lengths = l.mul(axis.dot(l, axis), new.at.dot(l, new.at));
    let is_normal = l.lt(l.mul(l.splat(NORMAL), l.sqrt(lengths)), axis.dot(l, new.at));
    packet.set_number(l, Number::Round, l.select(is_normal, zero, l.splat(TILTED)));
    let tilted = tilted(l, axis, (l.splat(TILT[0]), new.at));
    turn(l, packet, new.at, V3::select(l, is_normal, tilted, new.at));
    apart
}

/// What one more support shows, towards the origin.
pub(super) struct Step<L: Lanes> {
    apart: Certificate<L>,
    new: Vertex<L>,
    nearest: Nearest<L>,
    axis: V3<L>,
    /// The lanes whose nearest point was as near as it gets, or as near as supports in reason make it.
    pub(super) done: u32,
}

impl<L: Lanes> Step<L> {
    #[inline(always)]
    pub(super) fn of(l: L, at: &mut Place<'_>, packet: &mut PairPacket, used: usize) -> Self {
        let d = packet.vector(l, Vector::D);
        let new = support(l, at, packet, (d, used));
        let axis = d.neg(l);
        let apart = look_along(l, packet, axis, new.at);
        let last = [
            Vertex { at: packet.vector(l, Vector::P0), corner: packet.corner(l, Corner::C0) },
            Vertex { at: packet.vector(l, Vector::P1), corner: packet.corner(l, Corner::C1) },
            Vertex { at: packet.vector(l, Vector::P2), corner: packet.corner(l, Corner::C2) },
        ];
        let nearest = Nearest::of(l, new, last);
        let v = packet.vector(l, Vector::Nearest);
        // Over the axis's length: how much farther along it v is than the support, and than any point.
        let gap = axis.dot(l, v.sub(l, new.at));
        let unit = packet.number(l, Number::Unit);
        let close = l.le(gap, l.mul(l.mul(unit, l.splat(CLOSED)), l.sqrt(axis.dot(l, axis))));
        let gains = l.lt(nearest.squared, v.dot(l, v));
        let round = packet.number(l, Number::Round);
        // Beyond a tilted direction there may be no nearer point, and yet one towards the origin.
        let towards = l.bits(l.le(l.splat(TILTED), round));
        let spent = l.bits(l.le(l.splat(ROUNDS), round));
        let done = (l.bits(close) | !l.bits(gains)) & towards | spent;
        Self { apart, new, nearest, axis, done }
    }

    /// Which lanes it shows to be apart, and by how much.
    #[inline(always)]
    pub(super) fn apart(&self, l: L) -> Resolved<L> {
        Resolved::apart(l, self.apart)
    }

    /// Which lanes it shows to touch: the cores are no farther apart than the radii, or the points that the nearest lies between
    /// hold the origin, with a sphere inside A − B.
    #[inline(always)]
    pub(super) fn touching(&self, l: L, packet: &PairPacket) -> Certificate<L> {
        let near = radii_reach::<L, CertifiedBounds>(l, packet, self.nearest.squared);
        let points = [self.new.at, self.nearest.p.at, self.nearest.q.at];
        let c = packet.vector(l, Vector::C);
        let held = portal_holds_origin::<L, CertifiedBounds>(l, packet, c, points);
        Certificate { holds: l.or(near.holds, held.holds), clearance: l.splat(0.0) }
    }

    /// Keeps the nearest point, and chooses the next direction.
    #[inline(always)]
    pub(super) fn keep(self, l: L, packet: &mut PairPacket) {
        let Self { new, nearest, axis, .. } = self;
        let round = packet.number(l, Number::Round);
        packet.set_number(l, Number::Round, l.add(round, l.splat(1.0)));
        keep(l, packet, [new, nearest.p, nearest.q], nearest.weights);
        let direction = nearest.direction(l, new);
        let tilted = tilted(l, axis, (l.splat(TILT[1]), direction));
        let is_first = l.lt(round, l.splat(1.0));
        turn(l, packet, nearest.point, V3::select(l, is_first, tilted, direction));
    }
}

/// How many directions after the first are tilted. No unit.
const TILTED: f32 = TILT.len() as f32;

/// How far these directions are tilted: the last one, of length 1, and that much of the direction from the origin to the
/// nearest point. No unit.
///
/// Two that are near each other face along the normal there, and the axis between the centres is more nearly that than the
/// direction of a first vertex beside the origin. So the next vertices are those round the foot of the origin in the plane
/// of the first. Decides which supports are evaluated, never a bound: hulls of thirty vertices take six in place of seven, or two
/// in place of three where they are beyond the margin. Larger: the vertices of GJK. Smaller: the first vertex again.
const TILT: [f32; 2] = [0.5, 0.8];

/// The cosine of the first vertex with the axis below which that is no normal, and no direction is tilted: long objects side by
/// side. No unit. Larger: more supports for others. Smaller: more for these.
const NORMAL: f32 = -0.5;

/// The last axis, of length 1, tilted by that much towards a point.
#[inline(always)]
fn tilted<L: Lanes>(l: L, last: V3<L>, (much, point): (L::F, V3<L>)) -> V3<L> {
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    let (length, to_point) = (l.sqrt(last.dot(l, last)), l.sqrt(point.dot(l, point)));
    let unit = V3(zero, zero, zero).plus(l, l.div(one, length), last);
    unit.plus(l, l.div(much, to_point), point)
}

/// Which lanes a stage found apart by more than the margin.
#[inline(always)]
pub(super) fn beyond_by<L: Lanes>(l: L, stage: Resolved<L>, margin: f32) -> u32 {
    stage.apart & l.bits(l.lt(l.splat(margin), stage.clearance))
}

/// The support along a direction.
#[inline(always)]
fn support<L: Lanes>(
    l: L,
    at: &mut Place<'_>,
    packet: &PairPacket,
    (direction, used): (V3<L>, usize),
) -> Vertex<L> {
    let (point, vertices) = at.farthest_numbered(l, packet, direction, used);
    Vertex { at: point, corner: corner_of_vertices(l, vertices) }
}

/// Evaluates the support against an axis: raises the lower bound of the distance, and returns whether it proves that the
/// pair is apart.
#[inline(always)]
fn look_along<L: Lanes>(l: L, packet: &mut PairPacket, axis: V3<L>, w: V3<L>) -> Certificate<L> {
    let norm1 = axis.norm1(l);
    let rounding = l.mul(norm1, packet.number(l, Number::Separation));
    let length = l.mul(l.sqrt(axis.dot(l, axis)), l.splat(1.0 + 8.0 * U));
    let lower = l.mul(l.div(l.sub(axis.dot(l, w), rounding), length), l.splat(1.0 - 8.0 * U));
    let before = packet.number(l, Number::Lower);
    let is_more = l.and(l.lt(before, lower), l.lt(l.splat(SHORTEST), norm1));
    packet.set_number(l, Number::Lower, l.select(is_more, lower, before));
    separates::<L, CertifiedBounds>(l, packet, axis, w)
}

/// Writes down the nearest point, and against which axis the next support is evaluated.
#[inline(always)]
fn turn<L: Lanes>(l: L, packet: &mut PairPacket, nearest: V3<L>, axis: V3<L>) {
    packet.set_vector(l, Vector::Nearest, nearest);
    packet.set_vector(l, Vector::D, axis.neg(l));
}

/// Writes down the points and the weights of the second and third.
#[inline(always)]
fn keep<L: Lanes>(l: L, packet: &mut PairPacket, points: [Vertex<L>; 3], weights: [L::F; 2]) {
    let [p0, p1, p2] = points;
    packet.set_vector(l, Vector::P0, p0.at);
    packet.set_vector(l, Vector::P1, p1.at);
    packet.set_vector(l, Vector::P2, p2.at);
    packet.set_corner(l, Corner::C0, p0.corner);
    packet.set_corner(l, Corner::C1, p1.corner);
    packet.set_corner(l, Corner::C2, p2.corner);
    packet.set_number(l, Number::Second, weights[0]);
    packet.set_number(l, Number::Third, weights[1]);
}

#[inline(always)]
pub(super) fn put_apart(found: &mut [Found], packet: &PairPacket, lanes: u32) {
    for lane in LanesOf(lanes) {
        found[packet.number.0[lane] as usize] = Found::Beyond;
    }
}

#[inline(always)]
pub(super) fn put_nearest(found: &mut [Found], packet: &PairPacket, lanes: u32) {
    for lane in LanesOf(lanes) {
        found[packet.number.0[lane] as usize] = Found::Nearest(NearestPoints {
            corners: [Corner::C0, Corner::C1, Corner::C2].map(|c| packet.corner_of(lane, c)),
            weights: [Number::Second, Number::Third].map(|k| packet.number_of(lane, k)),
            lower: packet.number_of(lane, Number::Lower),
        });
    }
}
