//! Two cuboids along the fifteen axes that can separate them, in lanes.

use super::super::vector::V3;
use super::Cuboids;
use super::nearest_features::{absolute, dot};
use dcd_simd::Lanes;

/// What the axes are compared by: sixteen pairs of cuboids, a and b.
pub(super) struct Projections<L: Lanes> {
    half: [[L::F; 3]; 2],
    /// From a's centre to b's along the edges of each.
    along: [[L::F; 3]; 2],
    /// The cosine of edge j of a and edge k of b, and its absolute value.
    cos: [[L::F; 3]; 3],
    abs: [[L::F; 3]; 3],
}

/// Along an axis: how far apart the centres are, and how far both reach together. Of a product times its length.
pub(super) struct Projected<L: Lanes> {
    pub(super) apart: L::F,
    pub(super) reach: L::F,
}

impl<L: Lanes> Projected<L> {
    #[inline(always)]
    pub(super) fn overlap(&self, l: L) -> L::F {
        l.sub(self.reach, self.apart)
    }

    #[inline(always)]
    pub(super) fn gap(&self, l: L) -> L::F {
        l.sub(self.apart, self.reach)
    }
}

impl<L: Lanes> Projections<L> {
    #[inline(always)]
    pub(super) fn of(l: L, [a, b]: [&Cuboids<L>; 2], between: V3<L>) -> Self {
        let cos = [b.along(l, a.axes[0]), b.along(l, a.axes[1]), b.along(l, a.axes[2])];
        let abs = [absolute(l, cos[0]), absolute(l, cos[1]), absolute(l, cos[2])];
        let along = [a.along(l, between), b.along(l, between)];
        Self { half: [a.half, b.half], along, cos, abs }
    }

    /// Along edge k of a.
    #[inline(always)]
    pub(super) fn of_a(&self, l: L, k: usize) -> Projected<L> {
        let [half_a, half_b] = self.half;
        let reach = l.add(half_a[k], dot(l, half_b, self.abs[k]));
        Projected { apart: l.abs(self.along[0][k]), reach }
    }

    /// Along edge k of b.
    #[inline(always)]
    pub(super) fn of_b(&self, l: L, k: usize) -> Projected<L> {
        let ([half_a, half_b], abs) = (self.half, &self.abs);
        let reach = l.add(half_b[k], dot(l, half_a, [abs[0][k], abs[1][k], abs[2][k]]));
        Projected { apart: l.abs(self.along[1][k]), reach }
    }

    /// Along the product of edge j of a and edge k of b; and its length, squared.
    #[inline(always)]
    pub(super) fn of_product(&self, l: L, j: usize, k: usize) -> (Projected<L>, L::F) {
        let Self { half: [half_a, half_b], along: [along_a, _], cos, abs } = self;
        let (p, q) = ((j + 1) % 3, (j + 2) % 3);
        let (r, s) = ((k + 1) % 3, (k + 2) % 3);
        let apart = l.sub(l.mul(along_a[q], cos[p][k]), l.mul(along_a[p], cos[q][k]));
        let of_a = l.mul_add(half_a[p], abs[q][k], l.mul(half_a[q], abs[p][k]));
        let of_b = l.mul_add(half_b[r], abs[j][s], l.mul(half_b[s], abs[j][r]));
        let squared = l.mul_add(cos[p][k], cos[p][k], l.mul(cos[q][k], cos[q][k]));
        (Projected { apart: l.abs(apart), reach: l.add(of_a, of_b) }, squared)
    }
}
