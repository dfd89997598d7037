//! A closed surface of triangles in f32 that grows point by point, sixteen faces an operation.
//!
//! Nothing is fused, so that every path gives the same bits.

use super::super::bounds::U;
use dcd_simd::{Block, Lanes, Row, WIDTH};

/// How many points the surface may have; hulls of tens of vertices need fifteen. More: pairs for the search in f64.
pub(super) const POINTS: usize = 32;

/// A closed surface of triangles has two faces a point, less four: the points' 60 and some to spare.
const BLOCKS: usize = 4;

/// Space for the faces.
const FACES: usize = BLOCKS * WIDTH;

/// What a determinant (q − p) × (r − p) · p may be off by. Unit: u·|q − p|₁·|r − p|₁·|p|₁. Two differences 2,
/// the cross product 2.02, the dot product 3.01; and a margin for the bound's own rounding. Smaller: an origin that is outside.
const DETERMINANT: f32 = 16.0;

/// A determinant that is not above this by more than rounding proves nothing: products of such edges underflow.
/// Unit: m³.
const LEAST: f32 = 1e-30;

/// A point of A − B, and which vertices of a and b make it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Point {
    pub(crate) at: [f32; 3],
    pub(crate) vertices: [u32; 2],
}

/// An edge between what a new point sees and what it does not, as the seen face runs along it.
#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    from: u8,
    to: u8,
    /// The edge of the hidden face that runs along it the other way.
    hidden: u8,
}

/// The surface. An edge is a number: four times its face's, and which of the face's three it is.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    points: [Point; POINTS],
    count: usize,
    /// Of each face the corners: its edge k runs from corner k to corner k + 1.
    corners: [[u8; 3]; FACES],
    /// For each edge the one that runs along it the other way.
    across: [u8; 4 * FACES],
    /// How many places for faces are or were in use.
    faces: usize,
    /// The faces' normals: x, y and z of sixteen.
    normals: [Block; BLOCKS],
    /// How far along its normal a face's lowest corner is; infinite in an empty place.
    distances: [Row; BLOCKS],
    /// A bit for each face: whether it surely has the origin on its inner side.
    inward: u64,
    horizon: [Edge; WIDTH],
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            points: [Point::default(); POINTS],
            count: 0,
            corners: [[0; 3]; FACES],
            across: [0; 4 * FACES],
            faces: 0,
            normals: [Block::default(); BLOCKS],
            distances: [Row([f32::INFINITY; WIDTH]); BLOCKS],
            inward: 0,
            horizon: [Edge::default(); WIDTH],
        }
    }
}

impl Surface {
    pub(super) fn faces(&self) -> usize {
        self.faces
    }

    /// The points that a face has for corners.
    pub(super) fn corners(&self, face: usize) -> [Point; 3] {
        let [p, q, r] = self.corners[face];
        [self.points[usize::from(p)], self.points[usize::from(q)], self.points[usize::from(r)]]
    }

    pub(super) fn distance(&self, face: usize) -> f32 {
        self.distances[face / WIDTH].0[face % WIDTH]
    }

    pub(super) fn normal(&self, face: usize) -> [f32; 3] {
        let Block([x, y, z]) = &self.normals[face / WIDTH];
        let lane = face % WIDTH;
        [x.0[lane], y.0[lane], z.0[lane]]
    }

    /// The faces of which it is not known that they have the origin on their inner side.
    pub(super) fn doubtful(&self) -> u64 {
        !self.inward & (u64::MAX >> (64 - self.faces.clamp(1, FACES)))
    }

    /// Starts over with a tetrahedron, whose last corner is above the plane of the others as they go round
    /// counter-clockwise. `None` where a face has no area to rounding.
    #[inline(always)]
    pub(super) fn start<L: Lanes>(&mut self, l: L, corners: [Point; 4]) -> Option<()> {
        self.points[..4].copy_from_slice(&corners);
        self.count = 4;
        self.distances = [Row([f32::INFINITY; WIDTH]); BLOCKS];
        self.faces = 4;
        self.inward = 0;
        // The base, and on each of its edges, the other way round, a side.
        self.corners[..4].copy_from_slice(&[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
        self.across[..3].copy_from_slice(&[4 * 3, 4 * 2, 4]);
        for side in 0..3u8 {
            let (edge, next, last) = (4 * (side + 1), (side + 1) % 3, (side + 2) % 3);
            let at = usize::from(edge);
            // 1 → 0 is the base's third edge, 2 → 1 its second, 0 → 2 its first.
            self.across[at] = 2 - side;
            self.across[at + 1] = 4 * (next + 1) + 2;
            self.across[at + 2] = 4 * (last + 1) + 1;
        }
        let mut rims = [Edge::default(); WIDTH];
        for (rim, [from, to, _]) in rims.iter_mut().zip(&self.corners[1..4]) {
            (rim.from, rim.to) = (*from, *to);
        }
        self.horizon = rims;
        self.measure(l, 3, 3, 0b1110)?;
        self.horizon[0] = Edge { from: 0, to: 2, hidden: 0 };
        self.measure(l, 1, 1, 0b0001)
    }

    /// The face whose plane is nearest along its normal: the lowest number among equals.
    #[inline(always)]
    pub(super) fn nearest<L: Lanes>(&self, l: L) -> usize {
        let used = self.faces.div_ceil(WIDTH).clamp(1, BLOCKS);
        let mut least = l.load(&self.distances[0]);
        for row in &self.distances[1..used] {
            least = l.min(least, l.load(row));
        }
        let least = l.splat(-l.largest(l.neg(least)));
        for (block, row) in self.distances[..used].iter().enumerate() {
            let hit = l.bits(l.le(l.load(row), least));
            if hit != 0 {
                return block * WIDTH + hit.trailing_zeros() as usize;
            }
        }
        0
    }

    /// Takes away the faces that a point sees, which are one patch, `seen` among them, and adds the cone over the
    /// patch's boundary. `None` where the faces exceed the space, where rounding makes that boundary more than one simple
    /// cycle, or where a new face has no area.
    #[inline(always)]
    pub(super) fn insert<L: Lanes>(
        &mut self,
        l: L,
        point: Point,
        (seen, clear): (usize, f32),
    ) -> Option<()> {
        if self.count >= POINTS {
            return None;
        }
        let visible = self.visible(l, point.at, clear) | 1 << seen;
        let edges = self.find_horizon(visible)?;
        let new = self.count;
        self.points[new] = point;
        self.count += 1;
        // A cone has two faces more than the patch that it covers, less two for each point that it swallows.
        let gone = visible.count_ones() as usize;
        let more = edges.saturating_sub(gone);
        if more > 2 || self.faces + 2 > FACES {
            return None;
        }
        let taken = visible | ((1 << more) - 1) << self.faces;
        self.faces += more;
        self.connect(edges, taken, new as u8);
        self.drop_after(edges, taken);
        self.measure(l, edges, new, taken)
    }

    /// Marks the places after the first so many of `taken` as empty.
    #[inline(always)]
    fn drop_after(&mut self, edges: usize, taken: u64) {
        let mut rest = taken;
        for _ in 0..edges {
            rest &= rest.wrapping_sub(1);
        }
        while rest != 0 {
            let face = rest.trailing_zeros() as usize % FACES;
            rest &= rest - 1;
            self.distances[face / WIDTH].0[face % WIDTH] = f32::INFINITY;
            self.inward |= 1 << face;
        }
    }

    /// A bit for each face that a point is beyond by more than `clear`.
    #[inline(always)]
    fn visible<L: Lanes>(&self, l: L, at: [f32; 3], clear: f32) -> u64 {
        let at = splat(l, at);
        let clear = l.splat(clear);
        let used = self.faces.div_ceil(WIDTH).clamp(1, BLOCKS);
        let mut visible = 0;
        for block in 0..used {
            let height = dot(l, load(l, &self.normals[block]), at);
            let plane = l.add(l.load(&self.distances[block]), clear);
            visible |= u64::from(l.bits(l.lt(plane, height))) << (block * WIDTH);
        }
        visible
    }

    /// Lists the edges round the visible faces in the order of a walk along them; returns how many there are.
    #[inline(always)]
    fn find_horizon(&mut self, visible: u64) -> Option<usize> {
        let mut edges = [Edge { from: 0, to: 0, hidden: 0 }; 3 * FACES];
        let mut starting = [u8::MAX; POINTS];
        let mut count = 0;
        let mut rest = visible;
        while rest != 0 {
            let face = rest.trailing_zeros() as usize % FACES;
            rest &= rest - 1;
            let [p, q, r] = self.corners[face];
            let (ends, first) = ([p, q, r, p], 4 * face);
            for k in 0..3 {
                let hidden = self.across[first + k];
                edges[count] = Edge { from: ends[k], to: ends[k + 1], hidden };
                // What is not kept is written over: no branch.
                count += usize::from(visible >> (hidden / 4) & 1 == 0);
            }
        }
        if !(3..=WIDTH).contains(&count) {
            return None;
        }
        for (number, edge) in edges[..count].iter().enumerate() {
            starting[usize::from(edge.from) % POINTS] = number as u8;
        }
        // Two edges that start at one point, or two cycles, make the walk too short.
        let mut number = 0;
        for walked in 0..count {
            if walked > 0 && number == 0 {
                return None;
            }
            if number >= count {
                return None;
            }
            let edge = edges[number];
            self.horizon[walked] = edge;
            number = usize::from(starting[usize::from(edge.to) % POINTS]);
        }
        (number == 0).then_some(count)
    }

    /// Makes the faces of the cone over the horizon, in the places whose bits `taken` has.
    #[inline(always)]
    fn connect(&mut self, edges: usize, taken: u64, apex: u8) {
        let mut places = [0u8; WIDTH];
        let mut rest = taken;
        for place in &mut places[..edges] {
            *place = rest.trailing_zeros() as u8 % FACES as u8;
            rest &= rest.wrapping_sub(1);
        }
        for k in 0..edges {
            let Edge { from, to, hidden } = self.horizon[k];
            let face = usize::from(places[k]);
            let next = places[if k + 1 == edges { 0 } else { k + 1 }];
            let last = places[if k == 0 { edges - 1 } else { k - 1 }];
            self.corners[face] = [from, to, apex];
            self.across[4 * face] = hidden;
            self.across[4 * face + 1] = 4 * next + 2;
            self.across[4 * face + 2] = 4 * last + 1;
            self.across[usize::from(hidden)] = 4 * places[k];
        }
    }

    /// Planes of the triangles over the first edges of the horizon and an apex, written to the places whose bits
    /// `taken` has. `None` where one has no area.
    #[inline(always)]
    fn measure<L: Lanes>(&mut self, l: L, edges: usize, apex: usize, taken: u64) -> Option<()> {
        let (mut from, mut to) = (Block::default(), Block::default());
        for (k, edge) in self.horizon[..edges].iter().enumerate() {
            let start = &self.points[usize::from(edge.from) % POINTS].at;
            let end = &self.points[usize::from(edge.to) % POINTS].at;
            for (axis, (&start, &end)) in start.iter().zip(end).enumerate() {
                from.0[axis].0[k] = start;
                to.0[axis].0[k] = end;
            }
        }
        let (p, q) = (load(l, &from), load(l, &to));
        let r = splat(l, self.points[apex].at);
        let (e, f) = (sub(l, q, p), sub(l, r, p));
        let n = cross(l, e, f);
        let squared = dot(l, n, n);
        let used = (1u32 << edges) - 1;
        if l.bits(l.lt(l.splat(LEAST), squared)) & used != used {
            return None;
        }
        let volume = dot(l, n, p);
        let error = l.mul(l.mul(norm1(l, e), norm1(l, f)), norm1(l, p));
        let error = l.add(l.mul(error, l.splat(DETERMINANT * U)), l.splat(LEAST));
        let inward = l.bits(l.lt(error, volume));
        let shrink = l.div(l.splat(1.0), l.sqrt(squared));
        let n = [l.mul(n[0], shrink), l.mul(n[1], shrink), l.mul(n[2], shrink)];
        let lowest = l.min(l.min(dot(l, n, p), dot(l, n, q)), dot(l, n, r));
        let (mut normals, mut distances) = (Block::default(), Row::default());
        l.store(n[0], &mut normals.0[0]);
        l.store(n[1], &mut normals.0[1]);
        l.store(n[2], &mut normals.0[2]);
        l.store(lowest, &mut distances);
        let mut rest = taken;
        for k in 0..edges {
            let face = rest.trailing_zeros() as usize % FACES;
            rest &= rest.wrapping_sub(1);
            let (block, lane) = (face / WIDTH, face % WIDTH);
            for axis in 0..3 {
                self.normals[block].0[axis].0[lane] = normals.0[axis].0[k];
            }
            self.distances[block].0[lane] = distances.0[k];
            self.inward = self.inward & !(1 << face) | u64::from(inward >> k & 1) << face;
        }
        Some(())
    }
}

/// Sixteen points.
#[inline(always)]
pub(super) fn load<L: Lanes>(l: L, block: &Block) -> [L::F; 3] {
    [l.load(&block.0[0]), l.load(&block.0[1]), l.load(&block.0[2])]
}

/// The same point sixteen times.
#[inline(always)]
pub(super) fn splat<L: Lanes>(l: L, point: [f32; 3]) -> [L::F; 3] {
    [l.splat(point[0]), l.splat(point[1]), l.splat(point[2])]
}

/// Not fused.
#[inline(always)]
pub(super) fn dot<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> L::F {
    l.add(l.add(l.mul(a[0], b[0]), l.mul(a[1], b[1])), l.mul(a[2], b[2]))
}

#[inline(always)]
fn sub<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [l.sub(a[0], b[0]), l.sub(a[1], b[1]), l.sub(a[2], b[2])]
}

/// Not fused.
#[inline(always)]
fn cross<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [
        l.sub(l.mul(a[1], b[2]), l.mul(a[2], b[1])),
        l.sub(l.mul(a[2], b[0]), l.mul(a[0], b[2])),
        l.sub(l.mul(a[0], b[1]), l.mul(a[1], b[0])),
    ]
}

#[inline(always)]
fn norm1<L: Lanes>(l: L, a: [L::F; 3]) -> L::F {
    l.add(l.add(l.abs(a[0]), l.abs(a[1])), l.abs(a[2]))
}
