//! Where the search of a depth starts: a triangle by which the ray from the centre of A − B through the origin leaves it, sixteen
//! pairs at a time.
//!
//! Of a pair that is not deep it is nearly always the face that is nearest to the origin: what the search would find last. Where
//! that is [proved](NearestFace), nothing is left to search; else the search goes on from it, as it does from any triangle.

#[cfg(test)]
pub(super) mod tests;

use super::super::bounds::U;
use super::super::frame::{FramePair, Record, WHOLE};
use super::super::packet::{LanesOf, corner_of_vertices, vertices_of_corner};
use super::super::simplex::Vertex;
use super::super::support::{SupportScratch, reaches, supports};
use super::super::vector::V3;
use super::nearest_face::{Enclosed, NearestFace};
use dcd_geom::Pair;
use dcd_geom::glam::Vec3;
use dcd_simd::{IndexRow, Kernel, Lanes, Row, Unfused, WIDTH};

/// Three points of A − B: for each the numbers of its vertices in a and in b.
pub(super) type Triangle = [[u32; 2]; 3];

/// What is proposed for a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Proposal {
    pub(super) triangle: Triangle,
    /// What is known of it if it is proved to lie in the face that is nearest to the origin.
    pub(super) nearest: Option<NearestFace>,
}

/// Supports of a pair beyond the first two, of any and of one whose triangle may be proved to be the nearest: most portals lie in a
/// face by then. Fewer: triangles that are not the nearest, or not known to be. More: slow lanes hold up the others, and deep pairs
/// gain nothing by theirs.
const ROUNDS: [usize; 2] = [4, 6];

/// Of two objects whose spheres inside are both smaller than this part of those round them it is not tried to prove the triangle: of
/// plates and needles it succeeds with one pair in eight. No unit. Decides what is tried, never an answer.
const FAT: f32 = 0.125;

/// A pair is deep where the origin is farther before the portal's plane than this part of the way there from the centre: in one of
/// fifty such pairs the portal is the nearest face. No unit. Decides where a portal ends, never an answer.
const DEEP: f32 = 0.2;

/// How much farther a support must be for it to be another. Unit: u times the sum of the outer radii. Decides where a portal ends,
/// never an answer.
const CLOSE: f32 = 16.0;

/// Proposes a triangle for some of the pairs.
pub(super) struct Propose<'a> {
    frames: FramePair<'a>,
    pairs: &'a [Pair],
    /// Whether it is tried to prove that what is proposed is the nearest.
    proves: bool,
    scratch: &'a mut SupportScratch,
    found: &'a mut Vec<Option<Proposal>>,
}

impl<'a> Propose<'a> {
    /// All paths propose the same.
    pub(super) fn of(
        frames: FramePair<'a>,
        (pairs, proves): (&'a [Pair], bool),
        scratch: &'a mut SupportScratch,
        found: &'a mut Vec<Option<Proposal>>,
    ) -> Unfused<Self> {
        Unfused(Self { frames, pairs, proves, scratch, found })
    }
}

impl Kernel for Propose<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        self.found.clear();
        self.found.resize(self.pairs.len(), None);
        let (mut numbers, mut used) = ([0; WIDTH], 0);
        for number in 0..self.pairs.len() {
            if self.is_worth_it(self.pairs[number]) {
                numbers[used] = number;
                used += 1;
            }
            if used == WIDTH {
                self.sixteen(l, &numbers);
                used = 0;
            }
        }
        if used > 0 {
            self.sixteen(l, &numbers[..used]);
        }
    }
}

/// Up to sixteen pairs. c leads from the second object's centre to the first's; each pair is taken in the order in which the first
/// coordinate of c that is not 0 is positive, so that (a, b) and (b, a) propose alike.
struct Sixteen<L: Lanes> {
    a: IndexRow,
    b: IndexRow,
    c: V3<L>,
    /// 1 where that order is (a, b), −1 where it is (b, a).
    order: L::F,
    /// The sum of the radii of spheres that hold the cores, and of those inside: metres.
    size: L::F,
    inner: L::F,
    /// Whether it is tried to prove that what is proposed is the nearest.
    is_tried: L::M,
    used: usize,
}

impl<L: Lanes> Sixteen<L> {
    /// The directions in which A and B are farthest where A − B, in that order, is farthest in this one.
    #[inline(always)]
    fn directions(&self, l: L, direction: V3<L>) -> (V3<L>, V3<L>) {
        let zero = l.splat(0.0);
        let d = V3(zero, zero, zero).plus(l, self.order, direction);
        (d, d.neg(l))
    }
}

/// From the centre of b to that of a.
#[inline(always)]
pub(super) fn between([a, b]: [&Record; 2]) -> [f32; 3] {
    [0, 1, 2].map(|axis| (a.centre[axis] - b.centre[axis]) as f32)
}

/// Whether a pair is taken as (b, a).
#[inline(always)]
pub(super) fn is_exchanged(between: [f32; 3]) -> bool {
    between < [0.0; 3]
}

/// Whether it may be proved of two objects which face is the nearest, and has a chance.
#[inline(always)]
fn may_be_proved(both: [&Record; 2]) -> bool {
    // Others reach beyond their vertices.
    let are_whole = both.iter().all(|record| record.marks & WHOLE != 0);
    are_whole && both.iter().any(|record| record.inner > FAT * record.size)
}

impl<'a> Propose<'a> {
    #[inline(always)]
    fn records(&self, pair: Pair) -> [&'a Record; 2] {
        [self.frames.a.record(pair.i), self.frames.b.record(pair.j)]
    }

    /// Whether the centres are farther apart than the spheres inside both reach: other pairs are deep. Swept ones may have cores that
    /// do not overlap.
    #[inline(always)]
    fn is_worth_it(&self, pair: Pair) -> bool {
        let [a, b] = self.records(pair);
        let ([x, y, z], inner) = (between([a, b]), a.inner + b.inner);
        let is_swept = (a.radius > 0.0) | (b.radius > 0.0);
        !is_swept & (x * x + y * y + z * z > inner * inner)
    }

    /// Brings together what the lanes need of the pairs of those numbers.
    #[inline(always)]
    fn gather<L: Lanes>(&self, l: L, numbers: &[usize]) -> Sixteen<L> {
        let (mut a, mut b) = (IndexRow::default(), IndexRow::default());
        let mut c = [Row::default(); 3];
        let (mut order, mut size, mut inner) = (Row::default(), Row::default(), Row::default());
        let mut tried = 0;
        for (lane, &number) in numbers.iter().enumerate().take(WIDTH) {
            let pair = self.pairs[number];
            let records = self.records(pair);
            let between = between(records);
            let sign = if is_exchanged(between) { -1.0 } else { 1.0 };
            (a.0[lane], b.0[lane], order.0[lane]) = (pair.i, pair.j, sign);
            let [one, other] = records;
            size.0[lane] = one.size + other.size;
            inner.0[lane] = one.inner + other.inner;
            tried |= u32::from(self.proves && may_be_proved(records)) << lane;
            for axis in 0..3 {
                c[axis].0[lane] = between[axis] * sign;
            }
        }
        let (c, order) = (V3::load(l, &c), l.load(&order));
        let (size, inner) = (l.load(&size), l.load(&inner));
        Sixteen { a, b, c, order, size, inner, is_tried: l.mask(tried), used: numbers.len() }
    }

    /// The point of the difference, in that order, that is farthest along a direction.
    #[inline(always)]
    fn farthest<L: Lanes>(&mut self, l: L, of: &Sixteen<L>, direction: V3<L>) -> Vertex<L> {
        let (to_a, to_b) = of.directions(l, direction);
        let (p, in_a) = supports(l, self.frames.a, self.scratch, (&of.a, to_a), of.used);
        let (q, in_b) = supports(l, self.frames.b, self.scratch, (&of.b, to_b), of.used);
        let at = of.c.plus(l, of.order, p.sub(l, q));
        Vertex { at, corner: corner_of_vertices(l, [in_a, in_b]) }
    }

    /// Proposes the portals of up to sixteen pairs.
    #[inline(always)]
    fn sixteen<L: Lanes>(&mut self, l: L, numbers: &[usize]) {
        let of = self.gather::<L>(l, numbers);
        let close = l.mul(of.size, l.splat(CLOSE * U));
        let mut portal = self.first_portal(l, &of);
        let [of_any, of_tried] = ROUNDS;
        for round in 0..of_tried {
            if round >= of_any {
                portal.leave_others(l, of.c, of.is_tried);
            }
            if l.bits(portal.open) == 0 {
                break;
            }
            let new = self.farthest(l, &of, portal.direction);
            portal.end(l, new, close);
            portal.take(l, new, of.c);
        }
        self.propose(l, (&of, &portal), numbers);
    }

    /// Writes down what is found.
    #[inline(always)]
    fn propose<L: Lanes>(
        &mut self,
        l: L,
        (of, portal): (&Sixteen<L>, &Portal<L>),
        numbers: &[usize],
    ) {
        let mut corners = [Row::default(); 3];
        for (row, point) in corners.iter_mut().zip(&portal.corners) {
            l.store(point.corner, row);
        }
        let used = l.mask((1 << of.used) - 1);
        let whole = l.and(portal.is_whole, used);
        for lane in LanesOf(l.bits(whole)) {
            let [p, q, r] = &corners;
            let triangle = [p.0[lane], q.0[lane], r.0[lane]].map(vertices_of_corner);
            self.found[numbers[lane]] = Some(Proposal { triangle, nearest: None });
        }
        let ended = l.and_not(l.and_not(whole, portal.open), portal.is_left);
        let ended = l.and(ended, of.is_tried);
        if l.bits(ended) != 0 {
            self.prove(l, (of, portal), (ended, numbers));
        }
    }

    /// Writes down which portals lie in the nearest face, of those that end.
    #[inline(always)]
    fn prove<L: Lanes>(
        &mut self,
        l: L,
        (of, portal): (&Sixteen<L>, &Portal<L>),
        (ended, numbers): (L::M, &[usize]),
    ) {
        let enclosed = self.enclosed(l, (of, portal), numbers);
        let found = enclosed.nearest_face(l);
        let holds = l.and(ended, found.holds);
        if l.bits(holds) == 0 {
            return;
        }
        let (a, b) = of.directions(l, found.normal);
        let (in_a, in_b) = (
            reaches(l, self.frames.a, self.scratch, (&of.a, a), of.used),
            reaches(l, self.frames.b, self.scratch, (&of.b, b), of.used),
        );
        let upper = enclosed.upper(l, found.normal, l.add(in_a, in_b));
        let is_good = enclosed.is_good(l, found.distance, [found.lower, upper]);
        let holds = l.and(holds, is_good);
        let mut rows = [Row::default(); 9];
        let V3(x, y, z) = found.normal;
        let [second, third] = found.weights;
        let all = [x, y, z, found.distance, found.lower, upper, second, third, portal.farthest];
        for (row, numbers) in rows.iter_mut().zip(all) {
            l.store(numbers, row);
        }
        for lane in LanesOf(l.bits(holds)) {
            let [x, y, z, depth, lower, upper, second, third, farthest] =
                rows.map(|row| row.0[lane]);
            if let Some(proposal) = &mut self.found[numbers[lane]] {
                proposal.nearest = Some(NearestFace {
                    normal: Vec3::new(x, y, z),
                    depth,
                    bounds: [lower, upper],
                    weights: [second, third],
                    farthest: vertices_of_corner(farthest),
                });
            }
        }
    }

    /// What is proved to be inside of A − B.
    #[inline(always)]
    fn enclosed<L: Lanes>(
        &self,
        l: L,
        (of, portal): (&Sixteen<L>, &Portal<L>),
        numbers: &[usize],
    ) -> Enclosed<L> {
        let mut slack = Row::default();
        for (lane, &number) in numbers.iter().enumerate().take(WIDTH) {
            let [a, b] = self.records(self.pairs[number]);
            slack.0[lane] = a.slack + b.slack;
        }
        Enclosed {
            corners: portal.corners.map(|corner| corner.at),
            c: of.c,
            inner: of.inner,
            size: l.add(of.size, of.c.norm1(l)),
            slack: l.load(&slack),
        }
    }

    /// Two points round the ray, and the direction square to both and to it.
    #[inline(always)]
    fn first_portal<L: Lanes>(&mut self, l: L, of: &Sixteen<L>) -> Portal<L> {
        let (c, zero) = (of.c, l.splat(0.0));
        let p = self.farthest(l, of, c.neg(l));
        // Towards the ray from there.
        let along = l.max(l.neg(l.div(c.dot(l, p.at), p.at.dot(l, p.at))), zero);
        let q = self.farthest(l, of, c.plus(l, along, p.at).neg(l));
        let normal = p.at.sub(l, c).cross(l, q.at.sub(l, c));
        let is_turned = l.lt(zero, normal.dot(l, c));
        let corners = [Vertex::select(l, is_turned, q, p), Vertex::select(l, is_turned, p, q), p];
        let direction = V3::select(l, is_turned, normal.neg(l), normal);
        let (open, is_whole) = (l.mask((1u32 << of.used) - 1), l.mask(0));
        Portal { corners, direction, is_whole, farthest: p.corner, open, is_left: l.mask(0) }
    }
}

/// Three corners round the ray, of which the third may not be known yet.
struct Portal<L: Lanes> {
    corners: [Vertex<L>; 3],
    /// Off the plane of the corners, or of the first two and c, on the side where the next corner is looked for.
    direction: V3<L>,
    /// Whether there are three.
    is_whole: L::M,
    /// Which vertices make a point that is farthest along the direction, where the portal ends.
    farthest: L::F,
    /// Whether there may be a better one, and it is looked for.
    open: L::M,
    /// Whether it is not looked for, though there may be one.
    is_left: L::M,
}

impl<L: Lanes> Portal<L> {
    /// Ends where nothing is farther along the direction than the corners are.
    #[inline(always)]
    fn end(&mut self, l: L, new: Vertex<L>, close: L::F) {
        let d = self.direction;
        let gain = new.at.sub(l, self.corners[0].at).dot(l, d);
        let is_face = l.le(gain, l.mul(close, l.sqrt(d.dot(l, d))));
        let ends = l.and(self.open, l.and(self.is_whole, is_face));
        self.farthest = l.select(ends, new.corner, self.farthest);
        self.open = l.and_not(self.open, ends);
    }

    /// Leaves as they are the deep ones, and those that it is not tried to prove.
    #[inline(always)]
    fn leave_others(&mut self, l: L, c: V3<L>, is_tried: L::M) {
        let (d, p) = (self.direction, self.corners[0].at);
        let whole_way = d.dot(l, p.sub(l, c));
        let is_deep = l.lt(l.mul(whole_way, l.splat(DEEP)), d.dot(l, p));
        let is_deep = l.and(self.is_whole, is_deep);
        let left = l.and(self.open, l.or(is_deep, l.and_not(self.open, is_tried)));
        self.open = l.and_not(self.open, left);
        self.is_left = l.or(self.is_left, left);
    }

    /// Puts a point in the place of a corner so that the ray stays between all, as far as rounding lets it.
    #[inline(always)]
    fn take(&mut self, l: L, new: Vertex<L>, c: V3<L>) {
        let (zero, all) = (l.splat(0.0), l.mask(u32::MAX));
        let Self { corners: [p0, p1, p2], is_whole, open, .. } = *self;
        let across = new.at.cross(l, c);
        let side0 = l.lt(zero, p0.at.dot(l, across));
        let side1 = l.lt(zero, p1.at.dot(l, across));
        let side2 = l.lt(zero, p2.at.dot(l, across));
        // Of the three wedges from the new point to the corners the one with the ray; before there are three, the side of the two on
        // which the ray is not.
        let not_two = l.or(l.and_not(all, is_whole), side2);
        let for_p0 = l.or(l.and(side0, side1), l.and_not(l.and_not(is_whole, side0), side2));
        let for_p1 = l.and_not(not_two, side0);
        let for_p2 = l.and(open, l.and_not(side0, side1));
        let p0 = Vertex::select(l, l.and(open, for_p0), new, p0);
        let p1 = Vertex::select(l, l.and(open, for_p1), new, p1);
        let p2 = Vertex::select(l, for_p2, new, p2);
        self.is_whole = l.or(is_whole, for_p2);
        let from = V3::select(l, self.is_whole, p0.at, c);
        let one = V3::select(l, self.is_whole, p1.at, p0.at).sub(l, from);
        let two = V3::select(l, self.is_whole, p2.at, p1.at).sub(l, from);
        self.direction = one.cross(l, two);
        self.corners = [p0, p1, p2];
    }
}
