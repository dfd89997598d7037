//! A triangle against the faces and edges of a hull, sixteen at a time.

use super::super::bounds::U;
use super::round::Round;
use crate::simd::vector::V3;
use dcd_geom::glam::Vec3;
use dcd_geom::{EdgeRow, FaceRow, FeatureRows};
use dcd_simd::{Block, Kernel, Lanes, Row};

/// What a plane's distance loses, but for the direction of a product of edges. Unit: u·s, u of f32, s at least the length of
/// every vector between the two shapes. A face 2 for its normal and offset, 5 for one dot product and 10 for
/// that with an edge, which is at most twice as long as a corner is far, 3 for the sums; a product 7 for the vector, 3 for
/// the dot product, 5 for the length and the quotient. Smaller: false lower bounds.
pub(super) const PLANE: f64 = 21.0;

/// What the direction of a product loses. Unit: u of the edge's length and the other's longest by the product's. The two
/// edges 4 and 2, twice the latter's length for a difference; the product 8; and twice the whole for a direction.
const PRODUCT: f64 = 32.0;

/// The square of a product's length below which it may lose to underflow. Unit: m⁴. Smaller: false lower bounds.
const SHORTEST: f32 = 1e-30;

/// Against a hull's faces and edges.
pub(super) struct HullAxes<'a> {
    pub(super) rows: &'a FeatureRows,
    /// A corner, from the hull's centre, and the other two from there.
    pub(super) corner: Vec3,
    pub(super) edges: [Vec3; 2],
    /// At least how long the longest edge is.
    pub(super) longest: f64,
    /// At least the length of every vector between the two.
    pub(super) size: f64,
}

/// The planes of A − B that are made of a face and a corner or of two edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planes {
    /// How far the nearest is from the origin, rounded; below 0 where the origin is beyond it.
    pub(super) nearest: f32,
    /// Which it is.
    pub(super) feature: Feature,
    /// At least how far all others are, but for [`PLANE`].
    pub(super) others: f32,
    /// The vertices at which the triangle's plane faces away from its normal, and along it; `None` where the way round a
    /// vertex goes round the triangle more than once.
    pub(super) vertices: Option<[u64; 2]>,
}

/// What a plane is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    /// A face, and a corner of the triangle.
    Face(usize, usize),
    /// An edge, and the edge between two corners.
    Edge(usize, [usize; 2]),
}

/// The nearest planes so far, in each lane.
struct Nearest<L: Lanes> {
    first: L::F,
    second: L::F,
    number: L::F,
}

impl<L: Lanes> Nearest<L> {
    #[inline(always)]
    fn add(&mut self, l: L, distance: L::F, number: L::F) {
        self.second = l.min(self.second, l.max(self.first, distance));
        let is_nearer = l.lt(distance, self.first);
        self.first = l.select(is_nearer, distance, self.first);
        self.number = l.select(is_nearer, number, self.number);
    }
}

/// The triangle in all lanes.
struct Splat<L: Lanes> {
    corner: V3<L>,
    edges: [V3<L>; 2],
    normal: V3<L>,
}

/// Which corner of the triangle is lowest along sixteen normals.
struct Lowest<L: Lanes> {
    /// How much lower than the first.
    below: L::F,
    is_second: L::M,
    is_third: L::M,
}

impl<L: Lanes> Splat<L> {
    /// The edges that lead against the triangle's normal, but for rounding.
    #[inline(always)]
    fn behind(&self, l: L, row: &EdgeRow) -> u32 {
        l.bits(l.lt(V3::load(l, &row.along.0).dot(l, self.normal), l.splat(0.0)))
    }

    /// The same bits for the same normal, whichever row has it.
    #[inline(always)]
    fn lowest(&self, l: L, normals: &Block) -> Lowest<L> {
        let normal = V3::load(l, &normals.0);
        let zero = l.splat(0.0);
        let [second, third] = [normal.dot(l, self.edges[0]), normal.dot(l, self.edges[1])];
        let is_second = l.lt(second, zero);
        let below = l.select(is_second, second, zero);
        let is_third = l.lt(third, below);
        Lowest { below: l.select(is_third, third, below), is_second, is_third }
    }
}

impl<L: Lanes> Lowest<L> {
    /// From the triangle's first corner.
    #[inline(always)]
    fn at(&self, l: L, [second, third]: [V3<L>; 2]) -> V3<L> {
        let zero = V3(l.splat(0.0), l.splat(0.0), l.splat(0.0));
        V3::select(l, self.is_third, third, V3::select(l, self.is_second, second, zero))
    }

    /// The lanes in which it is the second, and the third.
    #[inline(always)]
    fn bits(&self, l: L) -> [u32; 2] {
        let third = l.bits(self.is_third);
        [l.bits(self.is_second) & !third, third]
    }

    /// Which it is, as a number.
    #[inline(always)]
    fn number(&self, l: L) -> L::F {
        let of_two = l.select(self.is_second, l.splat(1.0), l.splat(0.0));
        l.select(self.is_third, l.splat(2.0), of_two)
    }
}

impl Kernel for HullAxes<'_> {
    type Output = Planes;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Planes {
        let [second, third] = self.edges;
        let edges = [splat(l, second), splat(l, third)];
        let triangle =
            Splat { corner: splat(l, self.corner), edges, normal: splat(l, second.cross(third)) };
        let far = l.splat(f32::INFINITY);
        let mut nearest = Nearest { first: far, second: far, number: l.splat(0.0) };
        for (k, row) in self.rows.faces.iter().enumerate() {
            let (distance, corner) = of_faces(l, &triangle, row);
            // As an edge from that corner to itself.
            nearest.add(l, distance, l.mul_add(l.splat(5.0), corner, l.splat(16.0 * k as f32)));
        }
        let product = ((PRODUCT * U * self.size * self.longest) as f32).next_up();
        let mut round = Round::default();
        for (k, row) in self.rows.edges.iter().enumerate() {
            let sides = [triangle.lowest(l, &row.left), triangle.lowest(l, &row.right)];
            let way = Way::of([sides[0].bits(l), sides[1].bits(l)], triangle.behind(l, row));
            if way.open == 0 {
                continue;
            }
            round.add(self.rows, k, way.forth_and_back());
            let edges = Edges { triangle: &triangle, product, row };
            let place = l.splat(16.0 * k as f32);
            edges.add(l, [&sides[0], &sides[1]], (&way, place), &mut nearest);
        }
        nearest.planes(l, round.vertices())
    }
}

#[inline(always)]
fn splat<L: Lanes>(l: L, v: Vec3) -> V3<L> {
    V3(l.splat(v.x), l.splat(v.y), l.splat(v.z))
}

/// How far the planes of faces and the triangle's lowest corners are, and which these are.
#[inline(always)]
fn of_faces<L: Lanes>(l: L, triangle: &Splat<L>, row: &FaceRow) -> (L::F, L::F) {
    let lowest = triangle.lowest(l, &row.normals);
    let along = V3::load(l, &row.normals.0).dot(l, triangle.corner);
    (l.sub(l.load(&row.offsets), l.add(along, lowest.below)), lowest.number(l))
}

/// A row of edges and the triangle.
struct Edges<'a, L: Lanes> {
    triangle: &'a Splat<L>,
    /// What the product of a direction with an edge loses by its length.
    product: f32,
    row: &'a EdgeRow,
}

impl<L: Lanes> Edges<'_, L> {
    /// Adds the planes of the products along the way between the lowest corners, in the lanes that have one.
    #[inline(always)]
    fn add(
        &self,
        l: L,
        [left, right]: [&Lowest<L>; 2],
        (way, place): (&Way, L::F),
        nearest: &mut Nearest<L>,
    ) {
        let far = l.splat(f32::INFINITY);
        let [from, to] = [left.at(l, self.triangle.edges), right.at(l, self.triangle.edges)];
        let [first, last] = [left.number(l), right.number(l)];
        let four = l.splat(4.0);
        let (mut next, mut next_number) = (to, last);
        if way.by_third != 0 {
            let between = Lowest {
                below: far,
                is_second: l.mask(!(way.left[0] | way.right[0])),
                is_third: l.mask(!(way.left[1] | way.right[1])),
            };
            // The numbers of the three are 3 together.
            let middle = between.at(l, self.triangle.edges);
            let number = l.sub(l.splat(3.0), l.add(first, last));
            let is_between = l.mask(way.by_third);
            let distance = l.select(is_between, self.distance(l, middle, to), far);
            nearest.add(l, distance, l.add(place, l.mul_add(four, number, last)));
            next = V3::select(l, is_between, middle, next);
            next_number = l.select(is_between, number, next_number);
        }
        let distance = l.select(l.mask(way.open), self.distance(l, from, next), far);
        nearest.add(l, distance, l.add(place, l.mul_add(four, first, next_number)));
    }

    /// At least how far the planes of the products with the edges between those corners are, but for [`PLANE`].
    #[inline(always)]
    fn distance(&self, l: L, from: V3<L>, to: V3<L>) -> L::F {
        let Self { triangle, product, row } = self;
        let direction = V3::load(l, &row.along.0).cross(l, to.sub(l, from));
        let vector = V3::load(l, &row.from.0).sub(l, triangle.corner).sub(l, from);
        let square = direction.dot(l, direction);
        let lost = l.mul(l.splat(*product), l.load(&row.lengths));
        let distance = l.div(l.sub(direction.dot(l, vector), lost), l.sqrt(square));
        // Written so that a product of no length, or of NaN, proves nothing.
        l.select(l.lt(l.splat(SHORTEST), square), distance, l.splat(f32::NEG_INFINITY))
    }
}

/// The way of the lowest corner from the left sides of sixteen edges to their right sides.
struct Way {
    /// The lanes whose lowest corner is the second, and the third.
    left: [u32; 2],
    right: [u32; 2],
    /// Those in which it changes.
    open: u32,
    /// Those of them in which it goes by the third of the three corners.
    by_third: u32,
}

impl Way {
    /// Edges that lead against the triangle's normal go by the third corner where the way is once round it, and the
    /// others where it is not. Where this is rounding either way is one.
    #[inline(always)]
    fn of([left, right]: [[u32; 2]; 2], behind: u32) -> Self {
        let open = (left[0] ^ right[0]) | (left[1] ^ right[1]);
        let [first_left, first_right] = [!(left[0] | left[1]), !(right[0] | right[1])];
        let is_round = first_left & right[0] | left[0] & right[1] | left[1] & first_right;
        Self { left, right, open, by_third: open & !(is_round ^ behind) }
    }

    /// The lanes in which it goes from the first corner to the second, and back.
    #[inline(always)]
    fn forth_and_back(&self) -> [u32; 2] {
        let Self { left, right, open, by_third } = self;
        let [first_left, first_right] = [!(left[0] | left[1]), !(right[0] | right[1])];
        let direct = open & !by_third;
        [
            direct & first_left & right[0]
                | by_third & (first_left & right[1] | left[1] & right[0]),
            direct & left[0] & first_right
                | by_third & (right[1] & left[0] | left[1] & first_right),
        ]
    }
}

impl<L: Lanes> Nearest<L> {
    #[inline(always)]
    fn planes(&self, l: L, vertices: Option<[u64; 2]>) -> Planes {
        let least = -l.largest(l.neg(self.first));
        let lane = l.bits(l.le(self.first, l.splat(least))).trailing_zeros() & 15;
        let rest = l.select(l.mask(1 << lane), self.second, self.first);
        let mut numbers = Row::default();
        l.store(self.number, &mut numbers);
        let number = numbers.0[lane as usize] as usize;
        let [place, corners] = [number / 16 * 16 + lane as usize, number % 16];
        let feature = match [corners / 4, corners % 4] {
            [corner, same] if corner == same => Feature::Face(place, corner),
            ends => Feature::Edge(place, ends),
        };
        Planes { nearest: least, feature, others: -l.largest(l.neg(rest)), vertices }
    }
}
