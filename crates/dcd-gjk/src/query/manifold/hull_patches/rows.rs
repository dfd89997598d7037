//! Eight pairs as lanes read and write them.

use dcd_geom::glam::{DMat3, DVec3};
use dcd_simd::{Lanes, WIDTH};

/// How many pairs are looked at together.
pub(in super::super) const PAIRS: usize = WIDTH / 2;

/// The most corners of a face: the ends of a cylinder in a game have some twenty. Larger: memory. Smaller: faces of many corners that
/// go pair by pair, twice as slowly.
pub(super) const CORNERS: usize = 24;

/// How many places there are for corners of a patch: where each edge of what is clipped comes in and goes out, the corners of
/// the face that clips, and one on each of its sides.
pub(super) const SLOTS: usize = 4 * CORNERS;

/// A number of each pair.
pub(super) type Eight = [f64; PAIRS];

/// A vector of each pair.
pub(super) type Vector<L> = [<L as Lanes>::D; 3];

/// What one side of each pair shows: a face or an edge.
#[derive(Clone, Debug, Default)]
pub(super) struct HullOutlines {
    /// The columns of its rotation.
    pub(super) turn: [[Eight; 3]; 3],
    /// The face's normal in its own frame, then as it is seen; of an edge nothing that counts.
    pub(super) normal: [Eight; 3],
    /// Its corners in its own frame, then as they are seen: in order round the face, and the first again for those that others
    /// have more.
    pub(super) corners: [[Eight; 3]; CORNERS],
    /// The last of each in the same way.
    pub(super) last: [Eight; 3],
    /// How many each has, and the most of them.
    pub(super) count: Eight,
    pub(super) most: usize,
    /// Of the side from each corner to the next three numbers: a, b and c of a·x + b·y + c, which is none below 0 inside.
    pub(super) lines: [[Eight; 3]; CORNERS],
    /// How far the clipped one's corners are under the face that clips; and those of that face over the other one.
    pub(super) depths: [Eight; CORNERS],
}

/// A place of each patch, which may be a corner of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slot {
    /// Where, square to the normal.
    pub(super) x: Eight,
    pub(super) y: Eight,
    /// How deep: −∞ of what is no corner.
    pub(super) depth: Eight,
    /// What makes it a corner: see [`super::CORNER`].
    pub(super) by: Eight,
}

/// Places of patches.
#[derive(Clone, Debug)]
pub(super) struct Slots(pub(super) [Slot; SLOTS]);

impl Default for Slots {
    fn default() -> Self {
        Self([Slot::default(); SLOTS])
    }
}

/// The corners that stand for all.
#[derive(Clone, Debug, Default)]
pub(super) struct Kept {
    /// By number.
    pub(super) slots: [Eight; 4],
    pub(super) depths: [Eight; 4],
    /// From the origin of the shape that clips, world axes, on the plane of its face.
    pub(super) offsets: [[Eight; 3]; 4],
    pub(super) count: Eight,
}

/// Eight pairs, and what is found of them.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Packet {
    /// Out of the face that clips, of unit length, world axes.
    pub(super) normal: [Eight; 3],
    /// From the origin of the shape that clips to that of the other, world axes.
    pub(super) apart: [Eight; 3],
    /// How large both are, and both swept radii.
    pub(super) size: Eight,
    pub(super) radius: Eight,
    pub(super) clips: HullOutlines,
    pub(super) clipped: HullOutlines,
    /// Of what goes on along an edge or a side: values of lines at its start.
    pub(super) values: [Eight; CORNERS],
    pub(super) slots: Slots,
    pub(super) kept: Kept,
    /// The pairs of which a face has a sharp corner: a bit each.
    pub(super) sharp: u32,
}

impl HullOutlines {
    /// Writes the one of that lane: its rotation, its face's normal, its corners.
    #[inline(always)]
    pub(super) fn write(
        &mut self,
        lane: usize,
        rotation: &DMat3,
        normal: DVec3,
        (corners, vertices): (&[u32], &[DVec3]),
    ) {
        write(&mut self.turn[0], lane, rotation.x_axis);
        write(&mut self.turn[1], lane, rotation.y_axis);
        write(&mut self.turn[2], lane, rotation.z_axis);
        write(&mut self.normal, lane, normal);
        for (row, &corner) in self.corners.iter_mut().zip(corners) {
            write(row, lane, vertices[corner as usize]);
        }
        if let Some(&last) = corners.last() {
            write(&mut self.last, lane, vertices[last as usize]);
        }
        self.count[lane] = corners.len() as f64;
        self.most = self.most.max(corners.len());
    }

    /// Writes the first corners of those of so many pairs again that have fewer than others.
    #[inline(always)]
    pub(super) fn fill(&mut self, pairs: usize) {
        for lane in 0..pairs.min(PAIRS) {
            for corner in self.count[lane] as usize..self.most {
                for axis in 0..3 {
                    self.corners[corner][axis][lane] = self.corners[0][axis][lane];
                }
            }
        }
    }
}

/// Writes a vector of that lane.
#[inline(always)]
pub(super) fn write(rows: &mut [Eight; 3], lane: usize, vector: DVec3) {
    let [x, y, z] = rows;
    (x[lane], y[lane], z[lane]) = (vector.x, vector.y, vector.z);
}

#[inline(always)]
pub(super) fn load<L: Lanes>(l: L, [x, y, z]: &[Eight; 3]) -> Vector<L> {
    [l.load_d(x), l.load_d(y), l.load_d(z)]
}

#[inline(always)]
pub(super) fn store<L: Lanes>(l: L, [x, y, z]: Vector<L>, rows: &mut [Eight; 3]) {
    l.store_d(x, &mut rows[0]);
    l.store_d(y, &mut rows[1]);
    l.store_d(z, &mut rows[2]);
}

#[inline(always)]
pub(super) fn sum<L: Lanes>(l: L, a: Vector<L>, b: Vector<L>) -> Vector<L> {
    [l.add_d(a[0], b[0]), l.add_d(a[1], b[1]), l.add_d(a[2], b[2])]
}

#[inline(always)]
pub(super) fn dot<L: Lanes>(l: L, a: Vector<L>, b: Vector<L>) -> L::D {
    l.add_d(l.add_d(l.mul_d(a[0], b[0]), l.mul_d(a[1], b[1])), l.mul_d(a[2], b[2]))
}

/// The sum of three vectors, so many times each.
#[inline(always)]
pub(super) fn mix<L: Lanes>(l: L, [p, q, r]: [Vector<L>; 3], times: Vector<L>) -> Vector<L> {
    [
        dot(l, [p[0], q[0], r[0]], times),
        dot(l, [p[1], q[1], r[1]], times),
        dot(l, [p[2], q[2], r[2]], times),
    ]
}

#[inline(always)]
pub(super) fn min<L: Lanes>(l: L, a: L::D, b: L::D) -> L::D {
    l.select_lt_d(a, b, a, b)
}

#[inline(always)]
pub(super) fn abs<L: Lanes>(l: L, a: L::D) -> L::D {
    let zero = l.splat_d(0.0);
    l.select_lt_d(a, zero, l.sub_d(zero, a), a)
}
