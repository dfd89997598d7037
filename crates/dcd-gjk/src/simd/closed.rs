//! Pairs of cuboids in packets of sixteen, from what is prepared of them: the axis or the features first, in f32.

pub(super) mod depths;
pub(super) mod nearest_features;
mod overlap;
pub(super) mod patches;
mod projections;
#[cfg(test)]
mod tests;

use super::bounds::SIZE;
use super::frame::{BOX, FramePair, NEARLY_BOX, Record};
use super::vector::V3;
use dcd_geom::Pair;
use dcd_simd::{Lanes, Row, WIDTH};

/// Whether the lanes know both objects as cuboids without a swept radius, or parts of compounds that are such but for what f64
/// rounds.
#[inline(always)]
pub(super) fn are_cuboids(frames: FramePair<'_>, pair: Pair) -> bool {
    let is_one = |record: &Record| record.marks & (BOX | NEARLY_BOX) != 0;
    is_one(frames.a.record(pair.i)) && is_one(frames.b.record(pair.j))
}

/// Which cuboid of a pair is the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// That of the pair.
    AsGiven,
    /// That of the centres, which differ wherever two cuboids are apart.
    ByCentres,
}

/// Sixteen pairs of cuboids as they are read.
#[derive(Clone, Debug, Default)]
pub(super) struct CuboidPairs {
    first: [Row; WIDTH],
    second: [Row; WIDTH],
    /// From the first centre to the second, and the sum of the sizes.
    between: [Row; WIDTH],
    /// The lanes whose first cuboid is b.
    swapped: u32,
}

impl CuboidPairs {
    /// Reads at most sixteen pairs.
    #[inline(always)]
    fn read(&mut self, frames: FramePair<'_>, pairs: &[Pair], order: Order) {
        self.swapped = 0;
        for (lane, pair) in pairs.iter().enumerate().take(WIDTH) {
            let (a, b) = (frames.a.record(pair.i), frames.b.record(pair.j));
            let swapped = order == Order::ByCentres && is_behind(a, b);
            let boxes = [&frames.a.boxes(pair.i).numbers, &frames.b.boxes(pair.j).numbers];
            self.first[lane] = *boxes[usize::from(swapped)];
            self.second[lane] = *boxes[usize::from(!swapped)];
            let sense = if swapped { -1.0 } else { 1.0 };
            let between = &mut self.between[lane].0;
            for (k, between) in between.iter_mut().enumerate().take(3) {
                *between = ((b.centre[k] - a.centre[k]) * sense) as f32;
            }
            between[3] = a.size + b.size;
            self.swapped |= u32::from(swapped) << lane;
        }
    }

    /// The two sides, from the first centre to the second, and the pair's size.
    #[inline(always)]
    fn load<L: Lanes>(&self, l: L) -> (Cuboids<L>, Cuboids<L>, V3<L>, L::F) {
        let [x, y, z, sizes, ..] = l.transpose(&self.between);
        let between = V3(x, y, z);
        let size = l.add(sizes, between.norm1(l));
        (Cuboids::load(l, &self.first), Cuboids::load(l, &self.second), between, size)
    }
}

/// Whether b comes first by the centres.
#[inline(always)]
pub(super) fn is_behind(a: &Record, b: &Record) -> bool {
    let ([x, y, z, _], [u, v, w, _]) = (a.centre, b.centre);
    (u < x) | ((u == x) & ((v < y) | ((v == y) & (w < z))))
}

/// The lanes whose size is in f32's range.
#[inline(always)]
fn in_range<L: Lanes>(l: L, size: L::F) -> u32 {
    l.bits(l.and(l.lt(l.splat(SIZE.start), size), l.lt(size, l.splat(SIZE.end))))
}

/// One side of sixteen pairs: the directions of the edges in the world, and half their lengths.
#[derive(Clone, Copy)]
struct Cuboids<L: Lanes> {
    axes: [V3<L>; 3],
    half: [L::F; 3],
    /// How these compare: see [`case_of`](crate::query::case_of). 31 where that does not tell.
    case: L::F,
}

impl<L: Lanes> Cuboids<L> {
    /// The half edges are the means of those rounded up and down.
    #[inline(always)]
    fn load(l: L, boxes: &[Row; WIDTH]) -> Self {
        let [ax, ay, az, bx, by, bz, cx, cy, cz, ox, oy, oz, ix, iy, iz, case] = l.transpose(boxes);
        let axes = [V3(ax, ay, az), V3(bx, by, bz), V3(cx, cy, cz)];
        Self { axes, half: [mean(l, ox, ix), mean(l, oy, iy), mean(l, oz, iz)], case }
    }

    /// A vector's part along each edge.
    #[inline(always)]
    fn along(&self, l: L, v: V3<L>) -> [L::F; 3] {
        let [a, b, c] = self.axes;
        [a.dot(l, v), b.dot(l, v), c.dot(l, v)]
    }

    /// From the centre to a place in the cuboid's own frame, in the world.
    #[inline(always)]
    fn in_world(&self, l: L, place: [L::F; 3]) -> V3<L> {
        let [a, b, c] = self.axes;
        let zero = l.splat(0.0);
        V3(zero, zero, zero).plus(l, place[2], c).plus(l, place[1], b).plus(l, place[0], a)
    }

    /// The place of the cuboid nearest to a point, which is given from its centre.
    #[inline(always)]
    fn nearest(&self, l: L, point: V3<L>) -> [L::F; 3] {
        let mut place = self.along(l, point);
        for (place, half) in place.iter_mut().zip(self.half) {
            *place = l.max(l.min(*place, half), l.neg(half));
        }
        place
    }

    /// The corner farthest along a direction, by the direction's parts along the edges.
    #[inline(always)]
    fn corner(&self, l: L, along: [L::F; 3]) -> [L::F; 3] {
        let mut place = self.half;
        for (place, along) in place.iter_mut().zip(along) {
            let is_low = l.lt(along, l.splat(0.0));
            *place = l.select(is_low, l.neg(*place), *place);
        }
        place
    }
}

#[inline(always)]
fn mean<L: Lanes>(l: L, x: L::F, y: L::F) -> L::F {
    l.mul(l.add(x, y), l.splat(0.5))
}

/// Of three, the one with the number in each lane; the last for numbers above.
#[inline(always)]
fn pick<L: Lanes>(l: L, number: L::F, [x, y, z]: [L::F; 3]) -> L::F {
    let (is_x, is_y) = (l.lt(number, l.splat(0.5)), l.lt(number, l.splat(1.5)));
    l.select(is_x, x, l.select(is_y, y, z))
}

/// The same of vectors.
#[inline(always)]
fn pick_vector<L: Lanes>(l: L, number: L::F, [x, y, z]: [V3<L>; 3]) -> V3<L> {
    V3(
        pick(l, number, [x.0, y.0, z.0]),
        pick(l, number, [x.1, y.1, z.1]),
        pick(l, number, [x.2, y.2, z.2]),
    )
}
