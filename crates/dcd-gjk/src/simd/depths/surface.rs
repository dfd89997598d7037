//! A closed surface of triangles in f32 that grows point by point, sixteen faces an operation.
//!
//! Nothing is fused, so that every path gives the same bits.

use super::super::bounds::U;
use super::vectors::{Bits, cross, dot, load, norm1, select, splat, sub};
use dcd_geom::glam::{Vec3, Vec4};
use dcd_simd::{Block, Lanes, Row, WIDTH};

/// How many points the surface may have; hulls of tens of vertices need fifteen. More: pairs for the search in f64.
pub(super) const POINTS: usize = 32;

/// Space for faces, dead ones included, which are dropped when it is full: a bit each in a `u64`.
const FACES: usize = 64;

/// So many faces are measured at once: horizons with more edges are rare.
const HALF: usize = WIDTH / 2;

/// New faces are written sixteen at a time, from wherever they begin.
const WRITTEN: usize = FACES + WIDTH;

/// Space for the corners of the faces and of a horizon behind them: what is beyond begins again. A power of two.
const CORNERS: usize = 2 * FACES;

/// What a determinant (p − r) × (q − r) · r may be off by. Unit: u·|p − r|₁·|q − r|₁·|r|₁. Two differences 2,
/// the cross product 2.02, the dot product 3.01; and a margin for the bound's own rounding. Smaller: an origin that is outside.
pub(super) const DETERMINANT: f32 = 16.0;

/// A determinant that is not above this by more than rounding proves nothing: products of such edges underflow.
/// Unit: m³.
const LEAST: f32 = 1e-30;

/// A point of A − B, and which points of a and b make it, by number.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Point {
    pub(super) at: Vec3,
    pub(super) numbers: [u32; 2],
}

/// The surface: its faces in the order in which they were made, the dead among them.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Surface {
    /// How far along its normal a face's lowest corner is; infinite of a dead one.
    distances: [f32; WRITTEN],
    /// The faces' normals: their x, their y, their z.
    normals: [[f32; WRITTEN]; 3],
    /// Four numbers each, so that a place is a shift away.
    points: [[f32; 4]; POINTS],
    /// Which points of a and of b make each point.
    numbers: [[u32; 2]; POINTS],
    /// Of each face the corners, counter-clockwise seen from outside: a byte each, from the lowest.
    corners: [u32; CORNERS],
    count: usize,
    /// How many faces there are, dead ones included.
    faces: usize,
    /// A bit for each face: whether it surely has the origin on its inner side.
    inward: u64,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            distances: [f32::INFINITY; WRITTEN],
            normals: [[0.0; WRITTEN]; 3],
            points: [[0.0; 4]; POINTS],
            numbers: [[0; 2]; POINTS],
            corners: [0; CORNERS],
            count: 0,
            faces: 0,
            inward: 0,
        }
    }
}

/// Some of eight faces in the first lanes.
struct NewFaces<L: Lanes> {
    count: usize,
    /// Infinite in the other lanes.
    distances: L::F,
    normals: [L::F; 3],
    inward: u32,
}

/// Eight triangles in the first lanes, by their corners.
type Triangles<L> = (Corners<L>, Corners<L>, Corners<L>);

/// A corner of each.
type Corners<L> = [<L as Lanes>::F; 3];

impl Surface {
    /// The points that a face has for corners.
    #[inline(always)]
    pub(super) fn corners(&self, face: usize) -> [Point; 3] {
        numbers(self.corners[face]).map(|number| self.point(number))
    }

    #[inline(always)]
    fn point(&self, number: usize) -> Point {
        let [x, y, z, _] = self.points[number];
        Point { at: Vec3::new(x, y, z), numbers: self.numbers[number] }
    }

    /// At a number below [`POINTS`].
    #[inline(always)]
    fn set_point(&mut self, number: usize, Point { at: Vec3 { x, y, z }, numbers }: Point) {
        self.points[number] = [x, y, z, 0.0];
        self.numbers[number] = numbers;
    }

    #[inline(always)]
    pub(super) fn distance(&self, face: usize) -> f32 {
        self.distances[face]
    }

    #[inline(always)]
    pub(super) fn normal(&self, face: usize) -> Vec3 {
        let [x, y, z] = &self.normals;
        Vec3::new(x[face], y[face], z[face])
    }

    /// How many times sixteen faces are looked at: two at the least, for whether there is more than one is not predicted.
    /// What is no face is as far as a dead one.
    #[inline(always)]
    fn rows(&self) -> usize {
        self.faces.div_ceil(WIDTH).clamp(2, FACES / WIDTH)
    }

    /// The faces that are no farther than that, as bits.
    #[inline(always)]
    pub(super) fn within<L: Lanes>(&self, l: L, limit: f32) -> u64 {
        self.all_within(l, l.splat(limit))
    }

    /// The same; every lane has the limit.
    #[inline(always)]
    fn all_within<L: Lanes>(&self, l: L, limit: L::F) -> u64 {
        let mut within = self.no_farther(l, 0, limit) | self.no_farther(l, 1, limit);
        for row in 2..self.rows() {
            within |= self.no_farther(l, row, limit);
        }
        within
    }

    /// Those of the sixteen faces of that row.
    #[inline(always)]
    fn no_farther<L: Lanes>(&self, l: L, row: usize, limit: L::F) -> u64 {
        let distance = l.load_from(&rows(&self.distances)[row]);
        u64::from(l.bits(l.le(distance, limit))) << (row * WIDTH)
    }

    /// The faces of which it is not known that they have the origin on their inner side, as bits.
    #[inline(always)]
    pub(super) fn doubtful<L: Lanes>(&self, l: L) -> u64 {
        self.within(l, f32::MAX) & !self.inward
    }

    /// Starts over with a tetrahedron, whose last corner is above the plane of the others as they go round
    /// counter-clockwise. `None` where a face has no area to rounding.
    #[inline(always)]
    pub(super) fn start<L: Lanes>(&mut self, l: L, corners: [Point; 4]) -> Option<()> {
        for (k, &point) in corners.iter().enumerate() {
            self.set_point(k, point);
        }
        self.count = 4;
        (self.faces, self.inward) = (0, 0);
        self.distances = [f32::INFINITY; WRITTEN];
        let faces = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]];
        let none = Row([0.0; WIDTH]);
        let mut blocks = [Block([none; 3]), Block([none; 3]), Block([none; 3])];
        for (k, face) in faces.iter().enumerate() {
            self.corners[k] = packed(*face);
            for (side, &corner) in face.iter().enumerate() {
                let Vec3 { x, y, z } = corners[corner].at;
                let Block(rows) = &mut blocks[side];
                (rows[0].0[k], rows[1].0[k], rows[2].0[k]) = (x, y, z);
            }
        }
        let [p, q, r] = &blocks;
        let new = self.measured(l, (load(l, p), load(l, q), load(l, r)), 4)?;
        self.append(l, &new)
    }

    /// Starts over with an octahedron, whose corners are farthest along x, y, z, −x, −y and −z: three numbers and a 0 each. Which
    /// points of a and b make them is yet to be [said](Surface::set_numbers). `None` where a corner is above the plane of a face by
    /// more than `clear`, or a face has no area to rounding.
    #[inline(always)]
    pub(super) fn start_round<L: Lanes>(
        &mut self,
        l: L,
        corners: &[Vec4; 6],
        clear: f32,
    ) -> Option<()> {
        self.points[..6].copy_from_slice(&corners.map(|at| at.to_array()));
        self.count = 6;
        (self.faces, self.inward) = (0, 0);
        self.distances = [f32::INFINITY; WRITTEN];
        self.corners[..OCTAHEDRON.len()].copy_from_slice(&OCTAHEDRON);
        let [back_x, back_y, back_z, odd] = OCTANTS;
        let (back_x, back_y) = (l.mask(back_x), l.mask(back_y));
        let (back_z, odd) = (l.mask(back_z), l.mask(odd));
        let at = |k: usize| splat(l, corners[k].truncate());
        let x = select(l, back_x, at(3), at(0));
        let (y, z) = (select(l, back_y, at(4), at(1)), select(l, back_z, at(5), at(2)));
        let triangles = (x, select(l, odd, z, y), select(l, odd, y, z));
        let new = self.measured(l, triangles, OCTAHEDRON.len())?;
        self.append(l, &new)?;
        let [nx, ny, nz] = &self.normals;
        let normal = [l.load_half(from(nx, 0)), l.load_half(from(ny, 0)), l.load_half(from(nz, 0))];
        let plane = l.add(l.load_half(from(&self.distances, 0)), l.splat(clear));
        let mut highest = dot(l, normal, at(0));
        for k in 1..6 {
            highest = l.max(highest, dot(l, normal, at(k)));
        }
        (l.half_bits(l.le(highest, plane)) == OF_OCTAHEDRON).then_some(())
    }

    /// Which points of a and of b make the corners of an octahedron.
    #[inline(always)]
    pub(super) fn set_numbers(&mut self, numbers: [[u32; 2]; 6]) {
        self.numbers[..6].copy_from_slice(&numbers);
    }

    /// The face whose plane is nearest along its normal: the lowest number among equals.
    #[inline(always)]
    pub(super) fn nearest<L: Lanes>(&self, l: L) -> usize {
        self.within(l, -l.largest(l.neg(self.least(l)))).trailing_zeros() as usize % FACES
    }

    /// The least distance of every sixteenth face.
    #[inline(always)]
    fn least<L: Lanes>(&self, l: L) -> L::F {
        let distances = rows(&self.distances);
        let mut least = l.min(l.load_from(&distances[0]), l.load_from(&distances[1]));
        for row in &distances[2..self.rows()] {
            least = l.min(least, l.load_from(row));
        }
        least
    }

    /// Takes away the faces that a point sees by more than `clear`, and adds the cone over their boundary. Returns the
    /// nearest face then, as [`Surface::nearest`] has it. `None` where it sees none, where the faces exceed the space, where
    /// rounding makes two edges of that boundary start at one point, or where a new face has no area.
    #[inline(always)]
    pub(super) fn insert<L: Lanes>(&mut self, l: L, point: Point, clear: f32) -> Option<usize> {
        if self.count >= POINTS {
            return None;
        }
        if self.faces > FACES - WIDTH {
            self.drop_dead(self.within(l, f32::MAX));
        }
        let (visible, least) = self.remove_visible(l, point.at, clear);
        let edges = self.find_horizon(visible, self.count)?;
        self.set_point(self.count, point);
        self.count += 1;
        let apex = splat(l, point.at);
        let new = self.measured(l, self.cone(l, apex), edges.min(HALF))?;
        if edges <= HALF {
            // Before they are written, for what has just been written is waited for.
            let nearest = self.nearest_with(l, least, &new);
            self.append(l, &new)?;
            return Some(nearest);
        }
        self.append(l, &new)?;
        let new = self.measured(l, self.cone(l, apex), edges - HALF)?;
        self.append(l, &new)?;
        Some(self.nearest(l))
    }

    /// [`Surface::nearest`] of the faces, of every sixteenth of which the least distance is given, and of those that are new.
    #[inline(always)]
    fn nearest_with<L: Lanes>(&self, l: L, least: L::F, new: &NewFaces<L>) -> usize {
        // What is not of the first lanes is left out.
        let infinite = l.splat(f32::INFINITY);
        let distances = l.select(l.mask((1 << HALF) - 1), new.distances, infinite);
        let least = l.splat(-l.largest(l.neg(l.min(least, distances))));
        let of_new = u64::from(l.half_bits(l.le(distances, least))) << self.faces;
        (self.all_within(l, least) | of_new).trailing_zeros() as usize % FACES
    }

    /// The triangles over the next eight edges of the horizon.
    #[inline(always)]
    fn cone<L: Lanes>(&self, l: L, apex: Corners<L>) -> Triangles<L> {
        let edges: &[u32; HALF] = self.corners[self.faces..].first_chunk().unwrap_or(&[0; HALF]);
        let starts = edges.map(|edge| &self.points[edge as usize % POINTS]);
        let ends = edges.map(|edge| &self.points[(edge >> 8) as usize % POINTS]);
        (l.load_points(starts), l.load_points(ends), apex)
    }

    /// Marks the faces that a point is beyond by more than `clear` as dead. Returns them, as bits, and the least distance of
    /// every sixteenth of the others.
    #[inline(always)]
    fn remove_visible<L: Lanes>(&mut self, l: L, at: Vec3, clear: f32) -> (u64, L::F) {
        let (at, clear) = (splat(l, at), l.splat(clear));
        let (first, least) = self.remove_beyond(l, 0, (at, clear));
        let (second, others) = self.remove_beyond(l, 1, (at, clear));
        let (mut visible, mut least) = (first | second, l.min(least, others));
        for row in 2..self.rows() {
            let (beyond, others) = self.remove_beyond(l, row, (at, clear));
            (visible, least) = (visible | beyond, l.min(least, others));
        }
        (visible, least)
    }

    /// The same of the sixteen faces of that row.
    #[inline(always)]
    fn remove_beyond<L: Lanes>(
        &mut self,
        l: L,
        row: usize,
        (at, clear): (Corners<L>, L::F),
    ) -> (u64, L::F) {
        let [x, y, z] = [rows(&self.normals[0]), rows(&self.normals[1]), rows(&self.normals[2])];
        let normal = [l.load_from(&x[row]), l.load_from(&y[row]), l.load_from(&z[row])];
        let distances = &mut self.distances.as_chunks_mut().0[row];
        let distance = l.load_from(distances);
        let is_beyond = l.lt(l.add(distance, clear), dot(l, normal, at));
        let kept = l.select(is_beyond, l.splat(f32::INFINITY), distance);
        l.store_to(kept, distances);
        (u64::from(l.bits(is_beyond)) << (row * WIDTH), kept)
    }

    /// Writes down the corners of the cone over the edges round faces that are gone, behind the other faces. Returns how many
    /// edges there are.
    #[inline(always)]
    fn find_horizon(&mut self, gone: u64, apex: usize) -> Option<usize> {
        // For each point those to which an edge of a face runs from it, as bits.
        let mut runs_to = [0u32; POINTS];
        for face in Bits(gone) {
            let [p, q, r] = numbers(self.corners[face]);
            runs_to[p] |= 1 << q;
            runs_to[q] |= 1 << r;
            runs_to[r] |= 1 << p;
        }
        // An edge is on the boundary if none runs the other way.
        let apex = packed([0, 0, apex]);
        let (mut starting, mut end) = (0u32, self.faces);
        for face in Bits(gone) {
            let corners = self.corners[face];
            let [p, q, r] = numbers(corners);
            let ends = [corners & 0xFFFF, corners >> 8, corners >> 16 | (corners & 0xFF) << 8];
            for ([from, to], ends) in [[p, q], [q, r], [r, p]].into_iter().zip(ends) {
                let outer = runs_to[to] >> from & 1 ^ 1;
                // The next one writes over what is inside: no branch.
                self.corners[end % CORNERS] = ends | apex;
                starting |= outer << from;
                end += outer as usize;
            }
        }
        // Where no two start at one point, no two end at one: each edge of the surface stays one.
        let edges = end - self.faces;
        let is_simple = starting.count_ones() as usize == edges;
        let has_space = edges <= WIDTH && end <= FACES;
        (is_simple && has_space && edges > 0).then_some(edges)
    }

    /// Closes the gaps that dead faces left; the others are given, as bits.
    #[cold]
    fn drop_dead(&mut self, alive: u64) {
        let (mut kept, mut inward) = (0, 0);
        for face in Bits(alive) {
            self.distances[kept] = self.distances[face];
            self.corners[kept] = self.corners[face];
            for axis in &mut self.normals {
                axis[kept] = axis[face];
            }
            inward |= (self.inward >> face & 1) << kept;
            kept += 1;
        }
        self.distances[kept..].fill(f32::INFINITY);
        (self.faces, self.inward) = (kept, inward);
    }

    /// So many of eight triangles as faces. `None` where one has no area.
    #[inline(always)]
    fn measured<L: Lanes>(
        &self,
        l: L,
        triangles: Triangles<L>,
        faces: usize,
    ) -> Option<NewFaces<L>> {
        let (p, q, r) = triangles;
        let (e, f) = (sub(l, p, r), sub(l, q, r));
        let n = cross(l, e, f);
        let squared = dot(l, n, n);
        let used = (1u32 << faces) - 1;
        if l.half_bits(l.lt(l.splat(LEAST), squared)) & used != used {
            return None;
        }
        let volume = dot(l, n, r);
        let error = l.mul(l.mul(norm1(l, e), norm1(l, f)), norm1(l, r));
        let error = l.add(l.mul(error, l.splat(DETERMINANT * U)), l.splat(LEAST));
        let inward = l.half_bits(l.lt(error, volume)) & used;
        let shrink = l.div(l.splat(1.0), l.sqrt(squared));
        let n = [l.mul(n[0], shrink), l.mul(n[1], shrink), l.mul(n[2], shrink)];
        let lowest = l.min(l.min(dot(l, n, p), dot(l, n, q)), dot(l, n, r));
        let distances = l.select(l.mask(used), lowest, l.splat(f32::INFINITY));
        Some(NewFaces { count: faces, distances, normals: n, inward })
    }

    /// Appends faces, whose corners are written down already. `None` where there is no space.
    #[inline(always)]
    fn append<L: Lanes>(&mut self, l: L, new: &NewFaces<L>) -> Option<()> {
        let (first, n) = (self.faces, new.normals);
        l.store_half(new.distances, self.distances[first..].first_chunk_mut()?);
        let [x, y, z] = &mut self.normals;
        l.store_half(n[0], x[first..].first_chunk_mut()?);
        l.store_half(n[1], y[first..].first_chunk_mut()?);
        l.store_half(n[2], z[first..].first_chunk_mut()?);
        let below = (1u64 << first) - 1;
        self.inward = self.inward & below | u64::from(new.inward) << first;
        self.faces += new.count;
        Some(())
    }
}

/// The octants whose x, whose y and whose z are negative, and those with an odd number of these, as bits.
const OCTANTS: [u32; 4] = [0b1010_1010, 0b1100_1100, 0b1111_0000, 0b1001_0110];

/// A bit for each face of an octahedron.
const OF_OCTAHEDRON: u32 = 0xFF;

/// The corners of an octahedron's faces, octant by octant, of points farthest along x, y, z, −x, −y, −z.
const OCTAHEDRON: [u32; 8] = [
    packed([0, 1, 2]),
    packed([3, 2, 1]),
    packed([0, 2, 4]),
    packed([3, 4, 2]),
    packed([0, 5, 1]),
    packed([3, 1, 5]),
    packed([0, 4, 5]),
    packed([3, 5, 4]),
];

/// Three corners in one number.
#[inline(always)]
const fn packed([p, q, r]: [usize; 3]) -> u32 {
    (p | q << 8 | r << 16) as u32
}

/// The corners' numbers.
#[inline(always)]
const fn numbers(corners: u32) -> [usize; 3] {
    let corners = corners as usize;
    [corners % POINTS, corners >> 8 & (POINTS - 1), corners >> 16 & (POINTS - 1)]
}

/// Eight numbers from the `first` on.
#[inline(always)]
fn from<const N: usize>(numbers: &[f32; N], first: usize) -> &[f32; HALF] {
    numbers[first..].first_chunk().unwrap_or(&[f32::NAN; HALF])
}

/// Of each sixteen faces sixteen numbers.
#[inline(always)]
fn rows(numbers: &[f32; WRITTEN]) -> &[[f32; WIDTH]] {
    numbers.as_chunks().0
}

#[cfg(test)]
mod tests;
