//! Where cuboids that are apart are nearest: sixteen pairs at a time, in f32.
//!
//! The axis of the widest gap proposes a point of each cuboid; from there each goes to the nearest of the other, a few
//! times. What no separation proves is left to f64 (docs/numerics/proofs.md, "cuboids in lanes").

use super::super::bounds::{SHORTEST, U};
use super::super::frame::{FramePair, Record};
use super::super::packet::LanesOf;
use super::super::vector::V3;
use super::projections::Projections;
use super::{CuboidPairs, Cuboids, Order, in_range, pick, pick_vector};
use crate::closed::{NearFeatures, distance_in_double_double, distance_in_f64};
use crate::{Accuracy, Distance, PosedShape, PosedSupport};
use dcd_geom::Pair;
use dcd_geom::glam::{DVec3, Vec3};
use dcd_simd::{Kernel, Lanes, Path, Row, Unfused, WIDTH, dispatch_on};

/// What a gap along an axis may be off by, times the axis's length. Unit: u·m. 36 for a direction, 42 for a product.
/// Smaller: false bounds.
pub(super) const GAP: f32 = 48.0;

/// How far both points together may be from their cuboids. Unit: u·m. Derived: 18, and 2 of margin.
/// Smaller: false bounds.
const POINTS: f32 = 24.0;

/// The squared sine below which edges are parallel, and their product no axis. No unit. Decides what is tried, never
/// an answer.
const PARALLEL: f32 = 1e-4;

/// How often a point goes from one cuboid to the other and back. Fewer: more pairs left to f64. More: all take longer.
const ROUNDS: usize = 3;

/// What the lanes found of a pair of cuboids.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) enum Found {
    /// Nothing: their size is out of range.
    #[default]
    Unknown,
    /// That they are farther apart than the margin.
    Beyond,
    /// Where they are nearest, or nearly so.
    Near(Near),
}

/// Two points, one of each cuboid, and what is proved of the distance. The first cuboid is b where they are swapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Near {
    pub(in super::super) features: NearFeatures,
    /// The points from the centres of their cuboids, world axes, metres.
    pub(in super::super) offsets: [[f32; 3]; 2],
    /// At most the distance, metres.
    pub(in super::super) lower: f32,
    /// How far the distance may be above that of the points, metres.
    pub(in super::super) off: f32,
    pub(in super::super) is_swapped: bool,
}

/// The most that the bound of a distance in f32 may be, relative to the distance. No unit. Larger: normals of cuboids that
/// all but touch that are not those of their faces. Smaller: more pairs are measured in f64.
const SURE: f64 = 1.0 / 16.0;

impl Near {
    /// The distance of the points that the lanes found; `None` of cuboids too near for f32.
    #[inline]
    pub(in super::super) fn distance_in_f32(
        &self,
        frames: FramePair<'_>,
        pair: Pair,
    ) -> Option<Distance> {
        let centre = |record: &Record| {
            let [x, y, z, _] = record.centre;
            DVec3::new(x, y, z)
        };
        let centres = [centre(frames.a.record(pair.i)), centre(frames.b.record(pair.j))];
        let [from_a, from_b] = if self.is_swapped { [1, 0] } else { [0, 1] }
            .map(|side| Vec3::from_array(self.offsets[side]).as_dvec3());
        // Exchanging the two only changes signs.
        let between = (centres[1] - centres[0]) + (from_b - from_a);
        let distance = between.length();
        let error_bound = (distance - f64::from(self.lower)).max(f64::from(self.off));
        // False for NaN.
        if !(error_bound <= SURE * distance) {
            return None;
        }
        let normal = between / distance;
        let (point_a, point_b) = (centres[0] + from_a, centres[1] + from_b);
        Some(Distance { distance, point_a, point_b, normal, error_bound })
    }

    /// Vertices of a and of b, by number, between which the points are.
    pub(in super::super) fn vertices(&self) -> [[u32; 2]; 3] {
        let vertices = self.features.vertices();
        if self.is_swapped { vertices.map(|[first, second]| [second, first]) } else { vertices }
    }

    /// The distance in f64 or longer numbers, by the features that the lanes found.
    pub(in super::super) fn distance(
        &self,
        accuracy: Accuracy,
        [a, b]: [PosedShape<'_>; 2],
    ) -> Option<Distance> {
        let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
        let sides = [PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose)];
        let in_order = |sides| match accuracy {
            Accuracy::Certified => distance_in_double_double(sides, &self.features),
            _ => distance_in_f64(sides, &self.features),
        };
        match self.is_swapped {
            true => in_order([sides[1], sides[0]]).map(Distance::mirrored),
            false => in_order(sides),
        }
    }
}

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Scratch {
    pairs: CuboidPairs,
    rows: [Row; ROWS],
    /// For each pair what was found.
    pub(in super::super) found: Vec<Found>,
}

/// Six rows of places, six of offsets, and one each of lower bounds, of errors.
const ROWS: usize = 14;

/// Looks for the nearest points of pairs of cuboids, all of which are known to be apart. The same bits on every path.
pub(in super::super) fn find(
    path: Path,
    frames: FramePair<'_>,
    (pairs, margin): (&[Pair], f64),
    scratch: &mut Scratch,
) {
    // Rounded up, so that no pair within the margin is left out.
    let margin = (margin as f32).next_up();
    scratch.found.clear();
    scratch.found.resize(pairs.len(), Found::Unknown);
    dispatch_on(path, Unfused(CuboidFeatures { frames, pairs, margin, scratch }));
}

struct CuboidFeatures<'a> {
    frames: FramePair<'a>,
    pairs: &'a [Pair],
    margin: f32,
    scratch: &'a mut Scratch,
}

impl Kernel for CuboidFeatures<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Scratch { pairs: packet, rows, found } = self.scratch;
        for (pairs, found) in self.pairs.chunks(WIDTH).zip(found.chunks_mut(WIDTH)) {
            packet.read(self.frames, pairs, Order::ByCentres);
            let used = ((1u64 << pairs.len()) - 1) as u32;
            let (first, second, between, size) = packet.load(l);
            let live = used & in_range(l, size);
            let axis = Widest::of(l, [&first, &second], between, size);
            let beyond = l.bits(l.lt(l.splat(self.margin), axis.lower)) & live;
            for lane in LanesOf(beyond) {
                found[lane] = Found::Beyond;
            }
            let near = live & !beyond;
            if near == 0 {
                continue;
            }
            let points = Points::of(l, [&first, &second], between, &axis);
            let lower = points.lower(l, [&first, &second], between, size);
            points.store(l, [&first, &second], rows);
            l.store(l.max(axis.lower, lower), &mut rows[12]);
            l.store(l.mul(size, l.splat(POINTS * U)), &mut rows[13]);
            let crossing = l.bits(axis.is_product(l));
            for lane in LanesOf(near) {
                let at = |row: usize| rows[row].0[lane];
                let three = |row: usize| [at(row), at(row + 1), at(row + 2)];
                let features = NearFeatures {
                    places: [three(0), three(3)],
                    is_crossing: crossing >> lane & 1 == 1,
                };
                found[lane] = match at(12) > self.margin {
                    true => Found::Beyond,
                    false => Found::Near(Near {
                        features,
                        offsets: [three(6), three(9)],
                        lower: at(12),
                        off: at(13),
                        is_swapped: packet.swapped >> lane & 1 == 1,
                    }),
                };
            }
        }
    }
}

/// The axis of the widest gap: an edge of the first, of the second, or a product.
struct Widest<L: Lanes> {
    /// At most the gap.
    lower: L::F,
    /// The number of the first's edge and of the second's; −1: none.
    edges: [L::F; 2],
}

impl<L: Lanes> Widest<L> {
    #[inline(always)]
    fn of(l: L, [a, b]: [&Cuboids<L>; 2], between: V3<L>, size: L::F) -> Self {
        let error = l.mul(size, l.splat(GAP * U));
        let axes = Projections::of(l, [a, b], between);
        let none = l.splat(-1.0);
        let mut widest = Self { lower: l.splat(f32::NEG_INFINITY), edges: [none; 2] };
        for k in 0..3 {
            let gap = l.sub(axes.of_a(l, k).gap(l), error);
            widest.offer(l, gap, [l.splat(k as f32), none]);
            let gap = l.sub(axes.of_b(l, k).gap(l), error);
            widest.offer(l, gap, [none, l.splat(k as f32)]);
        }
        for j in 0..3 {
            for k in 0..3 {
                let (product, squared) = axes.of_product(l, j, k);
                let gap = l.div(l.sub(product.gap(l), error), l.sqrt(squared));
                let is_axis = l.lt(l.splat(PARALLEL), squared);
                let gap = l.select(is_axis, gap, l.splat(f32::NEG_INFINITY));
                widest.offer(l, gap, [l.splat(j as f32), l.splat(k as f32)]);
            }
        }
        widest
    }

    #[inline(always)]
    fn offer(&mut self, l: L, gap: L::F, edges: [L::F; 2]) {
        let is_wider = l.lt(self.lower, gap);
        self.lower = l.select(is_wider, gap, self.lower);
        let [of_a, of_b] = self.edges;
        self.edges = [l.select(is_wider, edges[0], of_a), l.select(is_wider, edges[1], of_b)];
    }

    #[inline(always)]
    fn is_product(&self, l: L) -> L::M {
        let zero = l.splat(0.0);
        l.and(l.le(zero, self.edges[0]), l.le(zero, self.edges[1]))
    }
}

#[inline(always)]
pub(super) fn absolute<L: Lanes>(l: L, [x, y, z]: [L::F; 3]) -> [L::F; 3] {
    [l.abs(x), l.abs(y), l.abs(z)]
}

/// A direction without its parts along the edges that a place is on and not at the end of.
#[inline(always)]
fn square_to_edges<L: Lanes>(
    l: L,
    mut axis: V3<L>,
    (side, place): (&Cuboids<L>, [L::F; 3]),
) -> V3<L> {
    for ((edge, half), place) in side.axes.into_iter().zip(side.half).zip(place) {
        let along = edge.dot(l, axis);
        let is_free = l.lt(l.abs(place), half);
        let along = l.select(is_free, along, l.splat(0.0));
        axis = axis.plus(l, l.neg(along), edge);
    }
    axis
}

#[inline(always)]
pub(super) fn dot<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> L::F {
    l.mul_add(a[0], b[0], l.mul_add(a[1], b[1], l.mul(a[2], b[2])))
}

/// A point of each cuboid, in its own frame and from its centre in world axes.
struct Points<L: Lanes> {
    places: [[L::F; 3]; 2],
    offsets: [V3<L>; 2],
}

impl<L: Lanes> Points<L> {
    #[inline(always)]
    fn of(l: L, [a, b]: [&Cuboids<L>; 2], between: V3<L>, axis: &Widest<L>) -> Self {
        let mut point = proposed(l, [a, b], between, axis);
        let mut places = [a.half, b.half];
        let mut offsets = [point; 2];
        for _ in 0..ROUNDS {
            places[1] = b.nearest(l, point.sub(l, between));
            offsets[1] = b.in_world(l, places[1]);
            places[0] = a.nearest(l, offsets[1].add(l, between));
            offsets[0] = a.in_world(l, places[0]);
            point = offsets[0];
        }
        Self { places, offsets }
    }

    /// The gap that a plane square to the line of the points and to the edges and faces on which they are proves.
    #[inline(always)]
    fn lower(&self, l: L, [a, b]: [&Cuboids<L>; 2], between: V3<L>, size: L::F) -> L::F {
        let mut axis = self.offsets[1].sub(l, self.offsets[0]).add(l, between);
        axis = square_to_edges(l, axis, (a, self.places[0]));
        axis = square_to_edges(l, axis, (b, self.places[1]));
        let reach_a = dot(l, a.half, absolute(l, a.along(l, axis)));
        let reach_b = dot(l, b.half, absolute(l, b.along(l, axis)));
        let gap = l.sub(axis.dot(l, between), l.add(reach_a, reach_b));
        let length = l.sqrt(axis.dot(l, axis));
        let error = l.mul(size, l.splat(GAP * U));
        let lower = l.sub(l.div(gap, length), error);
        let is_long = l.lt(l.splat(SHORTEST), axis.norm1(l));
        l.select(is_long, lower, l.splat(0.0))
    }

    /// Writes them down, places on a face or beyond as infinite.
    #[inline(always)]
    fn store(&self, l: L, sides: [&Cuboids<L>; 2], rows: &mut [Row; ROWS]) {
        let infinite = l.splat(f32::INFINITY);
        for number in 0..2 {
            for k in 0..3 {
                let (place, half) = (self.places[number][k], sides[number].half[k]);
                let high = l.select(l.le(half, place), infinite, place);
                let is_low = l.le(place, l.neg(half));
                l.store(l.select(is_low, l.neg(infinite), high), &mut rows[3 * number + k]);
            }
            let V3(x, y, z) = self.offsets[number];
            l.store(x, &mut rows[6 + 3 * number]);
            l.store(y, &mut rows[7 + 3 * number]);
            l.store(z, &mut rows[8 + 3 * number]);
        }
    }
}

/// Where the second cuboid is nearest to the first, by the axis of the widest gap, from the first's centre: a corner, a
/// point of an edge, or a corner of the first itself where that is nearest to a face.
#[inline(always)]
fn proposed<L: Lanes>(l: L, [a, b]: [&Cuboids<L>; 2], between: V3<L>, axis: &Widest<L>) -> V3<L> {
    let [of_a, of_b] = axis.edges;
    let zero = l.splat(0.0);
    let (has_a, has_b) = (l.le(zero, of_a), l.le(zero, of_b));
    let is_product = l.and(has_a, has_b);
    let (e, f) = (pick_vector(l, of_a, a.axes), pick_vector(l, of_b, b.axes));
    let face = V3::select(l, has_a, e, f);
    let normal = V3::select(l, is_product, e.cross(l, f), face);
    let is_back = l.lt(normal.dot(l, between), zero);
    let normal = V3::select(l, is_back, normal.neg(l), normal);
    let mut corners = [a.corner(l, a.along(l, normal)), b.corner(l, b.along(l, normal.neg(l)))];
    // The middles of the edges of a product.
    for (number, corner) in axis.edges.into_iter().zip(&mut corners) {
        for (k, place) in corner.iter_mut().enumerate() {
            let is_above = l.lt(l.splat(k as f32 - 0.5), number);
            let here = l.and(is_above, l.lt(number, l.splat(k as f32 + 0.5)));
            *place = l.select(l.and(here, is_product), zero, *place);
        }
    }
    let (in_a, in_b) = (a.in_world(l, corners[0]), b.in_world(l, corners[1]).add(l, between));
    let apart = in_b.sub(l, in_a);
    let (cosine, along_e, along_f) = (e.dot(l, f), e.dot(l, apart), f.dot(l, apart));
    let squared = l.sub(l.splat(1.0), l.mul(cosine, cosine));
    let along = l.div(l.sub(l.mul(cosine, along_e), along_f), squared);
    let half = pick(l, of_b, b.half);
    let along = l.max(l.min(along, half), l.neg(half));
    let on_edge = in_b.plus(l, along, f);
    let of_b_alone = l.and_not(has_b, has_a);
    let at_corner = V3::select(l, of_b_alone, in_a, in_b);
    V3::select(l, is_product, on_edge, at_corner)
}
