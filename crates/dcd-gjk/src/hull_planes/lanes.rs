//! A segment or cuboid against the faces and edges of a hull, sixteen at a time.

use super::U32;
use super::round::Round;
use crate::simd::vector::V3;
use dcd_geom::glam::Vec3;
use dcd_geom::{EdgeRow, FaceRow, FeatureRows};
use dcd_simd::{ArrayVec, Block, Kernel, Lanes, Row};

/// What a plane's distance loses, but for the direction of a product of edges. Unit: u·s, u of f32, s at least the length of
/// every vector between the two shapes. Of a triangle: a face 2 for its normal and offset, 5 for one dot product and 10 for
/// that with an edge, which is at most twice as long as a corner is far, 3 for the sums; a product 7 for the vector, 3 for
/// the dot product, 5 for the length and the quotient. Of a cuboid 13 and 18. Smaller: false lower bounds.
pub(crate) const PLANE: f64 = 21.0;

/// What the direction of a product loses. Unit: u of the edge's length and the other's longest by the product's. Of a
/// triangle: the two edges 4 and 2, twice the latter's length for a difference; the product 8; and twice the whole for a
/// direction. Of a cuboid, whose axes have length 1: 17.
pub(crate) const PRODUCT: f64 = 32.0;

/// The square of a product's length below which it may lose to underflow. Unit: m⁴, m² with an axis. Smaller: false lower
/// bounds.
pub(crate) const SHORTEST: f32 = 1e-30;

/// How far a normal may be along an axis and still count as square to it, so that edges along the axis have no product with it.
/// More than what it loses, 5u of f32. Larger: lower bounds that are less. Smaller: more pairs that are searched.
const LEVEL: f32 = 4.0 * f32::EPSILON;

/// How much farther than the nearest plane those are that count as near: so many times what a distance loses, for a product's
/// is less than it is by what its direction loses. Larger: more planes that are evaluated in f64. Smaller: more pairs whose
/// planes are looked through twice.
const NEAR: f64 = 4.0;

/// How many rows of planes there are at most: a closed surface of 64 vertices has eight rows of faces and twelve of edges.
const MOST: usize = 44;

/// A body that reaches by half lengths along axes that are square to each other, in the frame of a hull: a cuboid along
/// three, a segment along the first.
pub(super) struct CuboidPlanes<'a, const AXES: usize> {
    pub(super) rows: &'a FeatureRows,
    /// From the hull's centre.
    pub(super) centre: Vec3,
    /// Three of unit length, right-handed.
    pub(super) axes: [Vec3; 3],
    pub(super) half: [f32; 3],
    /// At least the length of every vector between the two.
    pub(super) size: f64,
    /// Written over.
    pub(super) planes: &'a mut Planes,
}

/// The planes of A − B that are made of a face and a corner or of two edges.
#[derive(Debug, Default)]
pub(super) struct Planes {
    rows: ArrayVec<PlaneRow, MOST>,
    /// Of each row of faces and edges that has planes.
    ways: ArrayVec<Way, MOST>,
    /// The ways of the lowest corner along [`EDGES`], round the vertices.
    pub(super) rounds: [Round; EDGES.len()],
    /// How far the nearest is, but for what [`PLANE`] counts; below 0 where the origin is beyond it.
    nearest: f32,
}

/// Sixteen planes.
#[derive(Clone, Copy, Debug)]
struct PlaneRow {
    /// From the origin, but for what [`PLANE`] counts; below 0 where the origin is beyond one.
    distances: Row,
    /// Which are about as near as the nearest.
    near: u16,
    /// Of edges: along which axis the body's edges are.
    axis: Option<u8>,
    /// Of which row of faces or edges they are, and what its way is.
    row: u8,
    way: u8,
}

/// What a plane is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    /// A face, and the corner of the body that is on those sides of the middle.
    Face { face: usize, is_above: [bool; 3] },
    /// An edge of the hull and one of the body, along that axis and on those sides of the others' middle; along its own, whether
    /// the way goes forth.
    Edge { edge: usize, axis: usize, is_above: [bool; 3] },
    /// A vertex of the hull, and a side of the cuboid.
    Side { vertex: usize, axis: usize, is_above: bool },
}

/// Edges of a cuboid, by the axis along which they are and on which sides of the others: those between the side above along
/// the first axis and its neighbours, and one that leads to the side below. What a way round a vertex of the hull encloses
/// follows from how often it takes these five.
pub(super) const EDGES: [(usize, [bool; 3]); 5] = [
    (2, [true, true, false]),
    (2, [true, false, false]),
    (1, [true, false, true]),
    (1, [true, false, false]),
    (2, [false, true, false]),
];

impl Planes {
    /// Whether it has room for the planes of such rows.
    pub(super) fn has_room(rows: &FeatureRows) -> bool {
        rows.faces.len() + 3 * rows.edges.len() <= MOST
    }

    /// Hands on what the nearest planes are made of, and up to where these are all.
    pub(super) fn each_near(&self, lost: f64, mut found: impl FnMut(Feature)) -> f64 {
        for row in &*self.rows {
            self.each_of(row, row.near, &mut found);
        }
        f64::from(self.nearest) + (NEAR - 1.0) * lost
    }

    /// Hands on what those planes are made of that are at most so far, or nowhere to be found.
    pub(super) fn each_within(&self, most: f32, mut found: impl FnMut(Feature)) {
        for row in &*self.rows {
            let mut near = 0;
            for (lane, distance) in row.distances.0.iter().enumerate() {
                // Written so that NaN is near.
                near |= u16::from(!(*distance > most)) << lane;
            }
            self.each_of(row, near, &mut found);
        }
    }

    #[inline(always)]
    fn each_of(&self, row: &PlaneRow, mut set: u16, found: &mut impl FnMut(Feature)) {
        while set != 0 {
            let lane = set.trailing_zeros() as usize;
            set &= set - 1;
            let number = 16 * usize::from(row.row) + lane;
            let way = &self.ways[usize::from(row.way)];
            found(match row.axis.map(usize::from) {
                Some(axis) => Feature::Edge { edge: number, axis, is_above: way.sides(axis, lane) },
                None => {
                    let is_above = way.left.map(|set| set >> lane & 1 != 0);
                    Feature::Face { face: number, is_above }
                }
            });
        }
    }
}

/// The axes in all lanes.
struct Splat<L: Lanes, const AXES: usize> {
    centre: V3<L>,
    axes: [V3<L>; 3],
    half: [L::F; 3],
}

impl<L: Lanes, const AXES: usize> Splat<L, AXES> {
    /// How far sixteen normals are along the axes: the same bits for the same normal, whichever row has it.
    #[inline(always)]
    fn along(&self, l: L, normals: &Block) -> [L::F; AXES] {
        let normal = V3::load(l, &normals.0);
        let mut along = [l.splat(0.0); AXES];
        for (along, axis) in along.iter_mut().zip(self.axes) {
            *along = normal.dot(l, axis);
        }
        along
    }

    /// The lanes in which the lowest corner is above the middle along an axis.
    #[inline(always)]
    fn is_above(&self, l: L, along: L::F) -> L::M {
        l.lt(along, l.splat(-LEVEL))
    }

    /// The planes of a row of faces and their lowest corners.
    #[inline(always)]
    fn of_faces(&self, l: L, row: &FaceRow, way: &mut Way) -> L::F {
        let along = self.along(l, &row.normals);
        let to_centre = V3::load(l, &row.normals.0).dot(l, self.centre);
        let mut distance = l.sub(l.load(&row.offsets), to_centre);
        for (k, along) in along.into_iter().enumerate() {
            let above = self.is_above(l, along);
            let below = l.select(above, l.neg(along), along);
            distance = l.mul_add(below, self.half[k], distance);
            way.left[k] = l.bits(above) as u16;
        }
        distance
    }

    /// Vectors in the body's frame.
    #[inline(always)]
    fn seen(&self, l: L, v: V3<L>) -> [L::F; 3] {
        [v.dot(l, self.axes[0]), v.dot(l, self.axes[1]), v.dot(l, self.axes[2])]
    }
}

/// The way of the lowest corner from the left sides of sixteen edges to their right sides, along one axis after another, as sets of
/// lanes; of faces, their corners alone.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Way {
    /// In which it is above the middle on the left side, and on the right.
    pub(super) left: [u16; 3],
    pub(super) right: [u16; 3],
    /// In which it changes sides along an axis before it does along the next: of two at once the lower is the first.
    pub(super) before: [u16; 3],
}

impl Way {
    /// In which it changes sides along an axis.
    #[inline(always)]
    pub(super) fn open(&self, axis: usize) -> u16 {
        self.left[axis] ^ self.right[axis]
    }

    /// In which it is above the middle along one axis while it changes sides along another.
    #[inline(always)]
    fn above(&self, axis: usize, at: usize) -> u16 {
        let [next, _] = others(axis);
        let is_past = if next == at { self.before[axis] } else { !self.before[at] };
        self.left[axis] ^ (self.open(axis) & is_past)
    }

    /// In which it takes [`EDGES`], and in which of these it goes back.
    #[inline(always)]
    pub(super) fn taken(&self) -> [(u16, u16); EDGES.len()] {
        let [of_second, of_third] = [self.open(1), self.open(2)];
        let [first, third] = [self.above(0, 1) & of_second, self.above(2, 1)];
        let [other, second] = [self.above(0, 2), self.above(1, 2) & of_third];
        let along_third = other & of_third;
        [
            (other & second, self.left[2]),
            (along_third & !second, self.left[2]),
            (first & third, self.left[1]),
            (first & !third, self.left[1]),
            (second & !other, self.left[2]),
        ]
    }

    /// On which sides of the middle a lane's edge along an axis is; along that axis, whether the way goes forth.
    pub(super) fn sides(&self, axis: usize, lane: usize) -> [bool; 3] {
        let [j, k] = others(axis);
        let mut is_above = [false; 3];
        is_above[axis] = self.left[axis] >> lane & 1 == 0;
        is_above[j] = self.above(j, axis) >> lane & 1 != 0;
        is_above[k] = self.above(k, axis) >> lane & 1 != 0;
        is_above
    }
}

impl<const AXES: usize> Kernel for CuboidPlanes<'_, AXES> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let [x, y, z] = self.axes;
        let body = Splat::<L, AXES> {
            centre: splat(l, self.centre),
            axes: [splat(l, x), splat(l, y), splat(l, z)],
            half: [l.splat(self.half[0]), l.splat(self.half[1]), l.splat(self.half[2])],
        };
        let mut search = Search { planes: self.planes, nearest: l.splat(f32::INFINITY) };
        for (k, row) in self.rows.faces.iter().enumerate() {
            let mut way = Way::default();
            let distance = body.of_faces(l, row, &mut way);
            search.add(l, distance, None, k);
            search.planes.ways.push(way);
        }
        let product = l.splat(((PRODUCT * U32 * self.size) as f32).next_up());
        for (k, row) in self.rows.edges.iter().enumerate() {
            let sides = Sides::of(l, &body, row);
            let way = sides.way(l);
            if way.open(0) | way.open(1) | way.open(2) == 0 {
                continue;
            }
            let edges = Edges::of(l, &body, row, product);
            search.add_products::<0, AXES>(l, &edges, (&sides, &way), k);
            if AXES == 3 {
                search.add_products::<1, AXES>(l, &edges, (&sides, &way), k);
                search.add_products::<2, AXES>(l, &edges, (&sides, &way), k);
                for (round, (edges, back)) in search.planes.rounds.iter_mut().zip(way.taken()) {
                    if edges != 0 {
                        round.add(self.rows, k, [edges & !back, edges & back].map(u32::from));
                    }
                }
            }
            search.planes.ways.push(way);
        }
        search.note_near(l, (NEAR * PLANE * U32 * self.size) as f32);
    }
}

/// The planes so far, and how far the nearest is in each lane.
struct Search<'a, L: Lanes> {
    planes: &'a mut Planes,
    nearest: L::F,
}

impl<L: Lanes> Search<'_, L> {
    /// Adds sixteen planes, of a row of faces or edges.
    #[inline(always)]
    fn add(&mut self, l: L, distance: L::F, axis: Option<u8>, row: usize) {
        self.nearest = l.min(self.nearest, distance);
        let way = self.planes.ways.len() as u8;
        let row = PlaneRow { distances: Row::default(), near: 0, axis, row: row as u8, way };
        self.planes.rows.push(row);
        if let Some(row) = self.planes.rows.last_mut() {
            l.store(distance, &mut row.distances);
        }
    }

    /// Adds the planes of edges and the body's edges along an axis, if there are any.
    #[inline(always)]
    fn add_products<const AXIS: usize, const AXES: usize>(
        &mut self,
        l: L,
        edges: &Edges<L>,
        (sides, way): (&Sides<L, AXES>, &Way),
        row: usize,
    ) {
        if way.open(AXIS) != 0 {
            let distance = edges.distance::<AXIS, AXES>(l, sides);
            self.add(l, distance, Some(AXIS as u8), row);
        }
    }

    /// Notes which planes are at most so much farther than the nearest.
    #[inline(always)]
    fn note_near(&mut self, l: L, farther: f32) {
        self.planes.nearest = -l.largest(l.neg(self.nearest));
        let most = l.splat(self.planes.nearest + farther);
        for row in &mut *self.planes.rows {
            row.near = !l.bits(l.lt(most, l.load(&row.distances))) as u16;
        }
    }
}

/// Where the lowest corners on both sides of sixteen edges are.
struct Sides<L: Lanes, const AXES: usize> {
    is_above: [[L::M; AXES]; 2],
    /// From the middle along each axis, on the left side and the right.
    at: [[L::F; AXES]; 2],
    /// Whether it changes sides along an axis before it does along the next.
    before: [L::M; AXES],
}

impl<L: Lanes, const AXES: usize> Sides<L, AXES> {
    #[inline(always)]
    fn of(l: L, body: &Splat<L, AXES>, row: &EdgeRow) -> Self {
        let along = [body.along(l, &row.left), body.along(l, &row.right)];
        let zero = l.splat(0.0);
        let mut is_above = [[l.lt(zero, zero); AXES]; 2];
        let mut at = [[zero; AXES]; 2];
        let mut share = [zero; AXES];
        let mut before = [l.lt(zero, zero); AXES];
        for k in 0..AXES {
            for side in 0..2 {
                let half = body.half[k];
                is_above[side][k] = body.is_above(l, along[side][k]);
                at[side][k] = l.select(is_above[side][k], half, l.neg(half));
            }
            // Where the normal between the two is square to the axis; of no meaning where both are on one side. One number for
            // each axis: whatever is rounded, there is an order of all.
            share[k] = l.div(along[0][k], l.sub(along[0][k], along[1][k]));
        }
        if AXES == 3 {
            // Of two that are equal the lower axis is the first.
            before[0] = l.le(share[0], share[1]);
            before[1] = l.le(share[1], share[2]);
            before[2] = l.lt(share[2], share[0]);
        }
        Self { is_above, at, before }
    }

    #[inline(always)]
    fn way(&self, l: L) -> Way {
        let mut way = Way::default();
        for k in 0..AXES {
            way.left[k] = l.bits(self.is_above[0][k]) as u16;
            way.right[k] = l.bits(self.is_above[1][k]) as u16;
            way.before[k] = l.bits(self.before[k]) as u16;
        }
        way
    }

    /// Where the corner is along one axis while it changes sides along another.
    #[inline(always)]
    fn at<const AXIS: usize, const ALONG: usize>(&self, l: L) -> L::F {
        let [left, right] = [self.at[0][AXIS], self.at[1][AXIS]];
        if others(AXIS)[0] == ALONG {
            l.select(self.before[AXIS], right, left)
        } else {
            l.select(self.before[ALONG], left, right)
        }
    }
}

#[inline(always)]
fn splat<L: Lanes>(l: L, v: Vec3) -> V3<L> {
    V3(l.splat(v.x), l.splat(v.y), l.splat(v.z))
}

/// A row of edges, seen in the body's frame.
struct Edges<L: Lanes> {
    /// From where they begin to their ends.
    edge: [L::F; 3],
    /// From the body's middle to where they begin.
    from: [L::F; 3],
    /// What a plane's distance loses by the direction of a product, times the product's length.
    lost: L::F,
}

impl<L: Lanes> Edges<L> {
    #[inline(always)]
    fn of<const AXES: usize>(l: L, body: &Splat<L, AXES>, row: &EdgeRow, product: L::F) -> Self {
        Self {
            edge: body.seen(l, V3::load(l, &row.along.0)),
            from: body.seen(l, V3::load(l, &row.from.0).sub(l, body.centre)),
            lost: l.mul(product, l.load(&row.lengths)),
        }
    }

    /// At least how far the planes of the edges and the body's edges along an axis are, but for what [`PLANE`] counts; infinitely
    /// far where there is none.
    #[inline(always)]
    fn distance<const AXIS: usize, const AXES: usize>(&self, l: L, sides: &Sides<L, AXES>) -> L::F {
        let Self { edge, from, lost } = self;
        let [j, k] = others(AXIS);
        let square = l.mul_add(edge[j], edge[j], l.mul(edge[k], edge[k]));
        let (mut from_j, mut from_k) = (from[j], from[k]);
        if AXES == 3 {
            let [at_j, at_k] = match AXIS {
                0 => [sides.at::<1, 0>(l), sides.at::<2, 0>(l)],
                1 => [sides.at::<2, 1>(l), sides.at::<0, 1>(l)],
                _ => [sides.at::<0, 2>(l), sides.at::<1, 2>(l)],
            };
            (from_j, from_k) = (l.sub(from_j, at_j), l.sub(from_k, at_k));
        }
        // The product with the axis, by what leads from the one edge to the other.
        let product = l.sub(l.mul(edge[k], from_j), l.mul(edge[j], from_k));
        let [left, right] = [sides.is_above[0][AXIS], sides.is_above[1][AXIS]];
        let product = l.select(left, l.neg(product), product);
        let distance = l.div(l.sub(product, *lost), l.sqrt(square));
        // Written so that a product of no length, or of NaN, proves nothing.
        let is_long = l.lt(l.splat(SHORTEST), square);
        let distance = l.select(is_long, distance, l.splat(f32::NEG_INFINITY));
        let is_open = l.or(l.and_not(left, right), l.and_not(right, left));
        l.select(is_open, distance, l.splat(f32::INFINITY))
    }
}

/// The other two axes, so that the three are in order.
#[inline(always)]
pub(super) fn others(axis: usize) -> [usize; 2] {
    [[1, 2], [2, 0], [0, 1]][axis]
}
