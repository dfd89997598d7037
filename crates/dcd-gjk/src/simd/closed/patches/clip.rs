//! The corners of what a face has in common with what another cuboid shows it: a rectangle and a parallelogram.

use super::corners::{Corner, Corners, SLOTS};
use super::side::{Side, Turned, signed};
use super::within::{Run, Shares};
use crate::simd::vector::V3;
use dcd_simd::Lanes;

/// A point as it is seen from the face that clips: along its sides, and how far under it.
pub(super) type Seen<L> = [<L as Lanes>::F; 3];

#[inline(always)]
pub(super) fn sum<L: Lanes>(l: L, x: Seen<L>, y: Seen<L>) -> Seen<L> {
    [l.add(x[0], y[0]), l.add(x[1], y[1]), l.add(x[2], y[2])]
}

#[inline(always)]
pub(super) fn difference<L: Lanes>(l: L, x: Seen<L>, y: Seen<L>) -> Seen<L> {
    [l.sub(x[0], y[0]), l.sub(x[1], y[1]), l.sub(x[2], y[2])]
}

/// The point that is that share of the way from one to another.
#[inline(always)]
pub(super) fn between<L: Lanes>(l: L, from: Seen<L>, to: Seen<L>, share: L::F) -> Seen<L> {
    let [x, y, z] = difference(l, to, from);
    [l.mul_add(x, share, from[0]), l.mul_add(y, share, from[1]), l.mul_add(z, share, from[2])]
}

/// What makes coordinates along a face's sides those square to a direction, by its parts along the face's normal and sides: x
/// times the first less y times the second, and y times the third.
#[inline(always)]
pub(super) fn flat<L: Lanes>(l: L, [upright, along_p, along_q]: [L::F; 3]) -> [L::F; 3] {
    let length = l.sqrt(l.sub(l.splat(1.0), l.mul(along_p, along_p)));
    [length, l.div(l.mul(along_p, along_q), length), l.div(upright, length)]
}

/// A face that clips, and what it clips.
pub(super) struct Clip<L: Lanes> {
    /// The face's normal, and its sides.
    pub(super) axes: [V3<L>; 3],
    /// Half of the sides.
    pub(super) half: [L::F; 2],
    /// The middle of the face from the first cuboid's centre, world axes.
    pub(super) middle: V3<L>,
    /// The direction's parts along the face's normal and sides.
    pub(super) towards: [L::F; 3],
    /// See [`flat`].
    pub(super) flat: [L::F; 3],
    /// The parallelogram's middle, and half its edges.
    pub(super) clipped: Seen<L>,
    pub(super) edges: [Seen<L>; 2],
    pub(super) is_face: L::M,
    pub(super) is_vertex: L::M,
    pub(super) is_edge: L::M,
}

impl<L: Lanes> Clip<L> {
    /// Of the second and first side, by whether the second clips.
    #[inline(always)]
    pub(super) fn of(l: L, sides: [&Side<L>; 2], second_clips: L::M, apart: V3<L>) -> Self {
        let zero = l.splat(0.0);
        let none = V3(zero, zero, zero);
        let clips = Side::select(l, second_clips, sides);
        let other = Side::select(l, second_clips, [sides[1], sides[0]]);
        let place = V3::select(l, second_clips, apart, none);
        let to_other = V3::select(l, second_clips, apart.neg(l), apart);
        let Turned { axes, half: [half, half_p, half_q], along: towards } =
            clips.turned(l, clips.most);
        let plane = signed(l, half, towards[0]);
        // What is clipped, from the first axis of its face or edge on.
        let after = l.select(l.lt(other.most, l.splat(1.5)), l.add(other.most, l.splat(1.0)), zero);
        let from = l.select(other.is_edge, other.least, after);
        let Turned { axes: [u, v, w], half: [half_u, half_v, half_w], along } =
            other.turned(l, from);
        let all = l.le(zero, zero);
        let is_vertex = l.and_not(all, l.or(other.is_face, other.is_edge));
        let mut middle = to_other.plus(l, signed(l, half_w, along[2]), w);
        let at_v = l.select(other.is_face, zero, signed(l, half_v, along[1]));
        let at_u = l.select(is_vertex, signed(l, half_u, along[0]), zero);
        middle = middle.plus(l, at_v, v).plus(l, at_u, u);
        let half_u = l.select(is_vertex, zero, half_u);
        let half_v = l.select(other.is_face, half_v, zero);
        let mut clip = Self {
            axes,
            half: [half_p, half_q],
            middle: place.plus(l, plane, axes[0]),
            towards,
            flat: flat(l, towards),
            clipped: [zero; 3],
            edges: [[zero; 3]; 2],
            is_face: other.is_face,
            is_vertex,
            is_edge: other.is_edge,
        };
        clip.clipped = clip.seen(l, middle, plane);
        clip.edges = [
            clip.seen(l, none.plus(l, half_u, u), zero),
            clip.seen(l, none.plus(l, half_v, v), zero),
        ];
        clip
    }

    /// A point from the centre of the cuboid that clips, moved along the normal into a plane of the face; for a plane at 0
    /// the same of a direction.
    #[inline(always)]
    pub(super) fn seen(&self, l: L, point: V3<L>, plane: L::F) -> Seen<L> {
        let [normal, p, q] = self.axes;
        let [upright, along_p, along_q] = self.towards;
        let above = l.div(l.sub(normal.dot(l, point), plane), upright);
        let below = l.neg(above);
        [
            l.mul_add(below, along_p, p.dot(l, point)),
            l.mul_add(below, along_q, q.dot(l, point)),
            below,
        ]
    }

    /// A point of the face from the first cuboid's centre, world axes.
    #[inline(always)]
    pub(super) fn in_world(&self, l: L, [x, y]: [L::F; 2]) -> V3<L> {
        let [_, p, q] = self.axes;
        self.middle.plus(l, x, p).plus(l, y, q)
    }

    /// Adds a point: a corner of the pairs of which it is used.
    #[inline(always)]
    pub(super) fn add(
        &self,
        l: L,
        corners: &mut Corners<L>,
        [x, y, depth]: Seen<L>,
        bounds: L::F,
        is_used: L::M,
    ) {
        let [length, across, upright] = self.flat;
        let flat = [l.sub(l.mul(x, length), l.mul(y, across)), l.mul(y, upright)];
        if l.bits(is_used) != 0 && corners.count < SLOTS {
            let depth = l.select(is_used, depth, l.splat(f32::NEG_INFINITY));
            corners.corners[corners.count] = Corner { x, y, flat, depth, bounds };
            corners.count += 1;
        }
    }

    /// How far a point is within each bound: below 0 where it is beyond.
    #[inline(always)]
    pub(super) fn inside(&self, l: L, [x, y, depth]: Seen<L>) -> [L::F; 5] {
        let [half_x, half_y] = self.half;
        [l.sub(half_x, x), l.add(half_x, x), l.sub(half_y, y), l.add(half_y, y), depth]
    }

    /// Finds the corners of what the face has in common with what it clips.
    #[inline(always)]
    pub(super) fn fill(&self, l: L, slack: L::F, corners: &mut Corners<L>) {
        let [u, v] = self.edges;
        let (low, high) = (difference(l, self.clipped, v), sum(l, self.clipped, v));
        let points =
            [difference(l, low, u), sum(l, low, u), sum(l, high, u), difference(l, high, u)];
        let inside = [
            self.inside(l, points[0]),
            self.inside(l, points[1]),
            self.inside(l, points[2]),
            self.inside(l, points[3]),
        ];
        let limit = l.neg(slack);
        let is_corner = [
            l.or(self.is_vertex, l.or(self.is_edge, self.is_face)),
            l.or(self.is_edge, self.is_face),
            self.is_face,
            self.is_face,
        ];
        for from in 0..4 {
            let to = (from + 1) % 4;
            let mut is_within = is_corner[from];
            for bound in inside[from] {
                is_within = l.and(is_within, l.le(limit, bound));
            }
            let is_edge = if from == 0 { is_corner[1] } else { self.is_face };
            let run = Run::of(l, [&inside[from], &inside[to]], limit);
            let of_edge = l.splat((16 * from + 4) as f32);
            // Where the edge comes in, unless it begins there: both are one place in the list.
            let entry = between(l, points[from], points[to], run.range[0]);
            let mut point = points[from];
            for k in 0..3 {
                point[k] = l.select(is_within, point[k], entry[k]);
            }
            let own = l.splat((17 * from) as f32);
            let bounds = l.select(is_within, own, l.add(run.by[0], of_edge));
            let is_used = l.or(is_within, l.and(is_edge, run.is_used[0]));
            self.add(l, corners, point, bounds, is_used);
            let exit = between(l, points[from], points[to], run.range[1]);
            let is_used = l.and(is_edge, run.is_used[1]);
            self.add(l, corners, exit, l.add(run.by[1], of_edge), is_used);
        }
        self.fill_rectangle(l, slack, corners);
    }

    /// The corners of the rectangle that are within the parallelogram, and where its sides meet the surface within.
    #[inline(always)]
    pub(super) fn fill_rectangle(&self, l: L, slack: L::F, corners: &mut Corners<L>) {
        let shares = Shares::of(l, self, slack);
        let [half_x, half_y] = self.half;
        let (low_x, low_y) = (l.neg(half_x), l.neg(half_y));
        let places = [[half_x, half_y], [low_x, half_y], [low_x, low_y], [half_x, low_y]];
        let zero = l.splat(0.0);
        let (mut within, mut points) = ([l.lt(zero, zero); 4], [[zero; 3]; 4]);
        for k in 0..4 {
            let at = shares.at(l, self, places[k]);
            let [x, y] = places[k];
            let [u, v] = self.edges;
            let depth = l.mul_add(at[0], u[2], l.mul_add(at[1], v[2], self.clipped[2]));
            (within[k], points[k]) = (shares.are_within(l, at), [x, y, depth]);
        }
        const SIDES: [u8; 4] = [4 * 16 + 6, 5 * 16 + 6, 5 * 16 + 7, 4 * 16 + 7];
        const TO_NEXT: [u8; 4] = [6 * 16 + 8, 5 * 16 + 8, 7 * 16 + 8, 4 * 16 + 8];
        for k in 0..4 {
            let (point, next) = (points[k], points[(k + 1) % 4]);
            let is_deep = l.le(l.neg(slack), point[2]);
            let is_used = l.and(l.and(within[k], self.is_face), is_deep);
            self.add(l, corners, point, l.splat(f32::from(SIDES[k])), is_used);
            let (is_above, next_above) = (l.lt(point[2], zero), l.lt(next[2], zero));
            let crosses = l.or(l.and_not(is_above, next_above), l.and_not(next_above, is_above));
            // What rests is under the surface as a whole.
            if l.bits(crosses) == 0 {
                continue;
            }
            let share = l.div(point[2], l.sub(point[2], next[2]));
            let crossing = between(l, point, next, share);
            let at = shares.at(l, self, [crossing[0], crossing[1]]);
            let is_used = l.and(l.and(crosses, self.is_face), shares.are_within(l, at));
            self.add(l, corners, crossing, l.splat(f32::from(TO_NEXT[k])), is_used);
        }
    }
}
