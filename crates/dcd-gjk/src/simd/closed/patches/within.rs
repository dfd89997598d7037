//! Where a point lies in a parallelogram, and which part of an edge is within a rectangle.

use super::clip::Clip;
use dcd_simd::Lanes;

/// A place as parts of the parallelogram's half edges.
pub(super) struct Shares<L: Lanes> {
    /// How much a step along x and one along y is.
    pub(super) along_x: [L::F; 2],
    pub(super) along_y: [L::F; 2],
    /// Within these the place is in the parallelogram.
    pub(super) limit: [L::F; 2],
}

impl<L: Lanes> Shares<L> {
    #[inline(always)]
    pub(super) fn of(l: L, clip: &Clip<L>, slack: L::F) -> Self {
        let [u, v] = clip.edges;
        let one = l.splat(1.0);
        let inverse = l.div(one, l.sub(l.mul(u[0], v[1]), l.mul(u[1], v[0])));
        let along_x = [l.mul(v[1], inverse), l.neg(l.mul(u[1], inverse))];
        let along_y = [l.neg(l.mul(v[0], inverse)), l.mul(u[0], inverse)];
        let mut limit = [one; 2];
        for k in 0..2 {
            limit[k] = l.mul_add(slack, l.add(l.abs(along_x[k]), l.abs(along_y[k])), one);
        }
        Self { along_x, along_y, limit }
    }

    #[inline(always)]
    pub(super) fn at(&self, l: L, clip: &Clip<L>, [x, y]: [L::F; 2]) -> [L::F; 2] {
        let (x, y) = (l.sub(x, clip.clipped[0]), l.sub(y, clip.clipped[1]));
        let [x_u, x_v] = self.along_x;
        let [y_u, y_v] = self.along_y;
        [l.mul_add(x, x_u, l.mul(y, y_u)), l.mul_add(x, x_v, l.mul(y, y_v))]
    }

    /// False for NaN, which parallel edges make.
    #[inline(always)]
    pub(super) fn are_within(&self, l: L, [a, b]: [L::F; 2]) -> L::M {
        l.and(l.le(l.abs(a), self.limit[0]), l.le(l.abs(b), self.limit[1]))
    }
}

/// The part of an edge that is within the bounds.
pub(super) struct Run<L: Lanes> {
    /// From 0 at its one end to 1 at the other.
    pub(super) range: [L::F; 2],
    /// The number of the bound at which each end of the part is.
    pub(super) by: [L::F; 2],
    /// Whether it is one: the edge's own end is not within.
    pub(super) is_used: [L::M; 2],
}

impl<L: Lanes> Run<L> {
    /// Of an edge whose ends are that far within each bound; beyond it below the limit.
    #[inline(always)]
    pub(super) fn of(l: L, [from, to]: [&[L::F; 5]; 2], limit: L::F) -> Self {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let (mut range, mut by) = ([zero, one], [zero; 2]);
        let none = l.lt(one, zero);
        let (mut from_is_out, mut to_is_out, mut is_out) = (none, none, none);
        for bound in 0..5 {
            let (here, there) = (from[bound], to[bound]);
            let (here_out, there_out) = (l.lt(here, limit), l.lt(there, limit));
            let share = l.div(here, l.sub(here, there));
            let number = l.splat(bound as f32);
            let raises = l.and(l.and_not(here_out, there_out), l.lt(range[0], share));
            range[0] = l.select(raises, share, range[0]);
            by[0] = l.select(raises, number, by[0]);
            let lowers = l.and(l.and_not(there_out, here_out), l.lt(share, range[1]));
            range[1] = l.select(lowers, share, range[1]);
            by[1] = l.select(lowers, number, by[1]);
            is_out = l.or(is_out, l.and(here_out, there_out));
            from_is_out = l.or(from_is_out, here_out);
            to_is_out = l.or(to_is_out, there_out);
        }
        let is_some = l.and_not(l.le(range[0], range[1]), is_out);
        let is_used = [l.and(is_some, from_is_out), l.and(is_some, to_is_out)];
        Self { range, by, is_used }
    }
}
