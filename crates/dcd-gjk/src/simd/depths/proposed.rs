//! Where the search of a depth starts: a triangle by which the ray from the centre of A − B through the origin leaves it, sixteen
//! pairs at a time.
//!
//! Of a pair that is not deep it is nearly always the face that is nearest to the origin: what the search would find last. It is
//! proposed and no more: nothing is proved of it, and the search goes on from any triangle.

#[cfg(test)]
mod tests;

use super::super::bounds::U;
use super::super::frame::FramePair;
use super::super::packet::{LanesOf, corner_of_vertices, vertices_of_corner};
use super::super::simplex::Vertex;
use super::super::support::{SupportScratch, supports};
use super::super::vector::V3;
use dcd_geom::Pair;
use dcd_simd::{IndexRow, Kernel, Lanes, Row, Unfused, WIDTH};

/// Three points of A − B: for each the numbers of its vertices in a and in b.
pub(super) type Triangle = [[u32; 2]; 3];

/// Supports of a pair beyond the first two: most portals lie in a face by then. Fewer: triangles that are not the nearest. More:
/// slow lanes hold up the others, and deep pairs gain nothing by theirs.
const ROUNDS: usize = 4;

/// How much farther a support must be for it to be another. Unit: u times the sum of the outer radii. Decides where a portal ends,
/// never an answer.
const CLOSE: f32 = 16.0;

/// Proposes a triangle for some of the pairs.
pub(super) struct Propose<'a> {
    frames: FramePair<'a>,
    pairs: &'a [Pair],
    scratch: &'a mut SupportScratch,
    found: &'a mut Vec<Option<Triangle>>,
}

impl<'a> Propose<'a> {
    /// All paths propose the same.
    pub(super) fn of(
        frames: FramePair<'a>,
        pairs: &'a [Pair],
        scratch: &'a mut SupportScratch,
        found: &'a mut Vec<Option<Triangle>>,
    ) -> Unfused<Self> {
        Unfused(Self { frames, pairs, scratch, found })
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
    size: L::F,
    used: usize,
}

impl Propose<'_> {
    /// From the centre of b to that of a.
    #[inline(always)]
    fn between(&self, pair: Pair) -> [f32; 3] {
        let (a, b) = (self.frames.a.record(pair.i), self.frames.b.record(pair.j));
        [0, 1, 2].map(|axis| (a.centre[axis] - b.centre[axis]) as f32)
    }

    /// Whether the centres are farther apart than the spheres inside both reach: other pairs are deep. Swept ones may have cores that
    /// do not overlap.
    #[inline(always)]
    fn is_worth_it(&self, pair: Pair) -> bool {
        let (a, b) = (self.frames.a.record(pair.i), self.frames.b.record(pair.j));
        let ([x, y, z], inner) = (self.between(pair), a.inner + b.inner);
        let is_swept = (a.radius > 0.0) | (b.radius > 0.0);
        !is_swept & (x * x + y * y + z * z > inner * inner)
    }

    /// Brings together what the lanes need of the pairs of those numbers.
    #[inline(always)]
    fn gather<L: Lanes>(&self, l: L, numbers: &[usize]) -> Sixteen<L> {
        let (mut a, mut b) = (IndexRow::default(), IndexRow::default());
        let mut c = [Row::default(); 3];
        let (mut order, mut size) = (Row::default(), Row::default());
        for (lane, &number) in numbers.iter().enumerate().take(WIDTH) {
            let pair = self.pairs[number];
            let between = self.between(pair);
            let sign = if between < [0.0; 3] { -1.0 } else { 1.0 };
            (a.0[lane], b.0[lane], order.0[lane]) = (pair.i, pair.j, sign);
            size.0[lane] = self.frames.a.record(pair.i).outer + self.frames.b.record(pair.j).outer;
            for axis in 0..3 {
                c[axis].0[lane] = between[axis] * sign;
            }
        }
        let (c, order, size) = (V3::load(l, &c), l.load(&order), l.load(&size));
        Sixteen { a, b, c, order, size, used: numbers.len() }
    }

    /// The point of the difference, in that order, that is farthest along a direction.
    #[inline(always)]
    fn farthest<L: Lanes>(&mut self, l: L, of: &Sixteen<L>, direction: V3<L>) -> Vertex<L> {
        let zero = l.splat(0.0);
        let d = V3(zero, zero, zero).plus(l, of.order, direction);
        let (p, in_a) = supports(l, self.frames.a, self.scratch, (&of.a, d), of.used);
        let (q, in_b) = supports(l, self.frames.b, self.scratch, (&of.b, d.neg(l)), of.used);
        let at = of.c.plus(l, of.order, p.sub(l, q));
        Vertex { at, corner: corner_of_vertices(l, [in_a, in_b]) }
    }

    /// Proposes the portals of up to sixteen pairs.
    #[inline(always)]
    fn sixteen<L: Lanes>(&mut self, l: L, numbers: &[usize]) {
        let of = self.gather::<L>(l, numbers);
        let close = l.mul(of.size, l.splat(CLOSE * U));
        let mut portal = self.first_portal(l, &of);
        for _ in 0..ROUNDS {
            let new = self.farthest(l, &of, portal.direction);
            portal.end(l, new, close);
            if l.bits(portal.open) == 0 {
                break;
            }
            portal.take(l, new, of.c);
        }
        let mut corners = [Row::default(); 3];
        for (row, point) in corners.iter_mut().zip(&portal.corners) {
            l.store(point.corner, row);
        }
        for lane in LanesOf(l.bits(portal.is_whole) & ((1 << of.used) - 1)) {
            let [p, q, r] = &corners;
            let vertices = [p.0[lane], q.0[lane], r.0[lane]].map(vertices_of_corner);
            self.found[numbers[lane]] = Some(vertices);
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
        Portal { corners, direction, is_whole, open }
    }
}

/// Three corners round the ray, of which the third may not be known yet.
struct Portal<L: Lanes> {
    corners: [Vertex<L>; 3],
    /// Off the plane of the corners, or of the first two and c, on the side where the next corner is looked for.
    direction: V3<L>,
    /// Whether there are three.
    is_whole: L::M,
    /// Whether there may be a better one.
    open: L::M,
}

impl<L: Lanes> Portal<L> {
    /// Ends where nothing is farther along the direction than the corners are.
    #[inline(always)]
    fn end(&mut self, l: L, new: Vertex<L>, close: L::F) {
        let d = self.direction;
        let gain = new.at.sub(l, self.corners[0].at).dot(l, d);
        let is_face = l.le(gain, l.mul(close, l.sqrt(d.dot(l, d))));
        self.open = l.and_not(self.open, l.and(self.is_whole, is_face));
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
