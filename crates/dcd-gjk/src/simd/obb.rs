//! Inner and outer OBBs: two objects that each have a box round and a box inside them, on their own axes.

use super::bounds::{OBB, PARALLEL, U};
use super::certificate::{Certificate, ErrorBounds};
use super::first_stages::Resolved;
use super::frame::FramePair;
use super::packet::{Number, PairPacket, Vector};
use super::vector::V3;
use dcd_simd::{Lanes, Row, WIDTH};

/// The boxes of sixteen pairs, pair by pair; kept, so that it need not be cleared.
#[derive(Clone, Debug, Default)]
pub(super) struct ObbPairs {
    a: [Row; WIDTH],
    b: [Row; WIDTH],
}

/// One side of sixteen pairs: three directions of edges, half the edges of the outer boxes and of
/// the inner.
struct Side<L: Lanes> {
    axes: [V3<L>; 3],
    outer: [L::F; 3],
    inner: [L::F; 3],
}

impl<L: Lanes> Side<L> {
    /// Both sides of the first pairs.
    #[inline(always)]
    fn both(
        l: L,
        frames: FramePair<'_>,
        boxes: &mut ObbPairs,
        (packet, used): (&PairPacket, usize),
    ) -> [Self; 2] {
        for k in 0..used.min(WIDTH) {
            boxes.a[k] = frames.a.boxes(packet.a.0[k]).numbers;
            boxes.b[k] = frames.b.boxes(packet.b.0[k]).numbers;
        }
        [Self::load(l, &boxes.a), Self::load(l, &boxes.b)]
    }

    #[inline(always)]
    fn load(l: L, boxes: &[Row; WIDTH]) -> Self {
        let [ax, ay, az, bx, by, bz, cx, cy, cz, outer @ .., ix, iy, iz, _] = l.transpose(boxes);
        let axes = [V3(ax, ay, az), V3(bx, by, bz), V3(cx, cy, cz)];
        Self { axes, outer, inner: [ix, iy, iz] }
    }
}

/// What the axes tried so far leave possible.
struct Tally<L: Lanes> {
    bound: L::F,
    apart: L::M,
    touching: L::M,
    /// The clearance of a separation, and of an overlap: see [`super::certificate::Certificate`].
    apart_by: L::F,
    touching_by: L::F,
}

impl<L: Lanes> Tally<L> {
    /// One axis no longer than 1: how far apart the centres are along it, and how far the outer and
    /// the inner boxes reach. `skip`: no axis at all.
    #[inline(always)]
    fn try_axis(&mut self, l: L, distance: L::F, (outer, inner): (L::F, L::F), skip: L::M) {
        let distance = l.abs(distance);
        // A shorter axis has more clearance than this.
        let gap = l.sub(l.sub(distance, outer), self.bound);
        self.apart_by = l.select(skip, self.apart_by, l.max(self.apart_by, gap));
        let depth = l.sub(l.sub(inner, distance), self.bound);
        self.touching_by = l.select(skip, self.touching_by, l.min(self.touching_by, depth));
        let apart = l.lt(l.add(outer, self.bound), distance);
        self.apart = l.or(self.apart, l.and_not(apart, skip));
        let overlap = l.lt(l.add(distance, self.bound), inner);
        self.touching = l.and(self.touching, l.or(overlap, skip));
    }
}

/// Rejects if one of the fifteen axes of two boxes separates the outer ones, accepts if none
/// separates the inner ones (Gottschalk, Lin and Manocha 1996). Also returns which pairs have parallel
/// edges: those that stay open just touch, and no other lane stage can decide them.
#[inline(always)]
pub(super) fn obbs<L: Lanes, T: ErrorBounds>(
    l: L,
    frames: FramePair<'_>,
    boxes: &mut ObbPairs,
    (packet, used): (&PairPacket, usize),
) -> (Resolved<L>, u32) {
    let [a, b] = Side::both(l, frames, boxes, (packet, used));
    let c = packet.vector(l, Vector::C);
    let zero = l.splat(0.0);

    // The cosines between the edges, and the centres' difference along each.
    let mut cos = [[zero; 3]; 3];
    let mut abs = [[zero; 3]; 3];
    let (mut along_a, mut along_b) = ([zero; 3], [zero; 3]);
    for i in 0..3 {
        along_a[i] = a.axes[i].dot(l, c);
        along_b[i] = b.axes[i].dot(l, c);
        for j in 0..3 {
            cos[i][j] = a.axes[i].dot(l, b.axes[j]);
            abs[i][j] = l.abs(cos[i][j]);
        }
    }

    let bound = T::rounding(l, rounding(l, packet));
    let none = l.mask(0);
    let mut tally = Tally {
        bound,
        apart: none,
        touching: l.mask(u32::MAX),
        apart_by: zero,
        touching_by: l.splat(f32::MAX),
    };
    for i in 0..3 {
        let outer = l.add(a.outer[i], dot3(l, b.outer, abs[i]));
        let inner = l.add(a.inner[i], dot3(l, b.inner, abs[i]));
        tally.try_axis(l, along_a[i], (outer, inner), none);
        let column = [abs[0][i], abs[1][i], abs[2][i]];
        let outer = l.add(b.outer[i], dot3(l, a.outer, column));
        let inner = l.add(b.inner[i], dot3(l, a.inner, column));
        tally.try_axis(l, along_b[i], (outer, inner), none);
    }
    let mut aligned = l.mask(u32::MAX);
    for i in 0..3 {
        let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
        let mut has_parallel = none;
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            let distance = l.sub(l.mul(along_a[i2], cos[i1][j]), l.mul(along_a[i1], cos[i2][j]));
            let of_a = [abs[i2][j], abs[i1][j]];
            let of_b = [abs[i][j2], abs[i][j1]];
            let outer = [a.outer[i1], a.outer[i2], b.outer[j1], b.outer[j2]];
            let inner = [a.inner[i1], a.inner[i2], b.inner[j1], b.inner[j2]];
            let reaches = (reach(l, outer, of_a, of_b), reach(l, inner, of_a, of_b));
            let crossing = l.max(l.max(of_a[0], of_a[1]), l.max(of_b[0], of_b[1]));
            let parallel = l.le(crossing, l.splat(PARALLEL * U));
            tally.try_axis(l, distance, reaches, parallel);
            has_parallel = l.or(has_parallel, parallel);
        }
        aligned = l.and(aligned, has_parallel);
    }
    let apart = Certificate::new(l, tally.apart, tally.apart_by, l.splat(1.0));
    let touching = Certificate::new(l, tally.touching, tally.touching_by, l.splat(1.0));
    let resolved = Resolved::by(l, apart, touching, u32::MAX);
    (resolved, l.bits(aligned))
}

/// How far what is compared along an axis may be off.
#[inline(always)]
fn rounding<L: Lanes>(l: L, packet: &PairPacket) -> L::F {
    let size =
        l.mul_add(packet.number(l, Number::Radius), l.splat(U), packet.number(l, Number::Unit));
    let slack = l.mul(packet.number(l, Number::Slack), l.splat(4.0));
    l.mul_add(size, l.splat(OBB), slack)
}

/// Rejects if one of the six faces of two boxes separates the outer ones: less than [`obbs`], at a fifth of the cost.
#[inline(always)]
pub(super) fn faces<L: Lanes>(
    l: L,
    frames: FramePair<'_>,
    boxes: &mut ObbPairs,
    (packet, used): (&PairPacket, usize),
) -> Resolved<L> {
    let [a, b] = Side::both(l, frames, boxes, (packet, used));
    let c = packet.vector(l, Vector::C);
    let gap = l.max(gap_of_faces(l, c, [&a, &b]), gap_of_faces(l, c, [&b, &a]));
    let clearance = l.sub(gap, rounding(l, packet));
    let apart = Certificate::new(l, l.lt(l.splat(0.0), clearance), clearance, l.splat(1.0));
    Resolved::apart(l, apart)
}

/// How far two outer boxes are apart at most along the normals of the first one's faces; below 0 they overlap along all.
#[inline(always)]
fn gap_of_faces<L: Lanes>(l: L, c: V3<L>, [one, other]: [&Side<L>; 2]) -> L::F {
    let [x, y, z] = other.axes;
    let mut most = l.splat(f32::MIN);
    for i in 0..3 {
        let axis = one.axes[i];
        let cos = [l.abs(axis.dot(l, x)), l.abs(axis.dot(l, y)), l.abs(axis.dot(l, z))];
        let outer = l.add(one.outer[i], dot3(l, other.outer, cos));
        most = l.max(most, l.sub(l.abs(axis.dot(l, c)), outer));
    }
    most
}

/// How far two edges of each box reach along a cross product, given the sines that they count with.
#[inline(always)]
fn reach<L: Lanes>(l: L, half: [L::F; 4], of_a: [L::F; 2], of_b: [L::F; 2]) -> L::F {
    let a = l.mul_add(half[0], of_a[0], l.mul(half[1], of_a[1]));
    l.add(a, l.mul_add(half[2], of_b[0], l.mul(half[3], of_b[1])))
}

#[inline(always)]
fn dot3<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> L::F {
    l.mul_add(a[0], b[0], l.mul_add(a[1], b[1], l.mul(a[2], b[2])))
}
