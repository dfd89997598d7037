//! The axis of the fifteen along which two cuboids overlap the least, in f32, with what is proved of the depth.

use super::super::bounds::U;
use super::super::vector::V3;
use super::nearest_features::GAP;
use super::projections::Projections;
use super::{Cuboids, pick_vector};
use dcd_simd::Lanes;

/// The squared sine below which the product of two edges proves nothing by itself. No unit. Larger: worse bounds.
const PARALLEL: f32 = 1e-8;

/// The squared sine from which on a product is long: e × g is, for each neighbour g of an edge f, where e × f is not. No
/// unit; below ½, since |e × g|² is at least 1 − |e × f|².
const LONG: f32 = 0.25;

/// What the sine of two edges may be off by. Unit: u.
const SINE: f32 = 16.0;

/// The largest bound with which the lanes answer, relative to the pair's size. No unit. Larger: worse bounds. Smaller: more
/// pairs left to f64.
const WORST: f32 = 6e-6;

/// Along which axis sixteen pairs overlap the least, and how deep.
pub(super) struct Overlap<L: Lanes> {
    /// The overlap along that axis.
    pub(super) value: L::F,
    /// How far the depth may be from it.
    pub(super) bound: L::F,
    /// The number of the first's edge and of the second's that make the axis; −1: none.
    pub(super) edges: [L::F; 2],
}

/// The least overlap so far.
struct Least<L: Lanes> {
    value: L::F,
    error: L::F,
    /// No overlap along the axes so far is below this.
    lower: L::F,
    edges: [L::F; 2],
}

impl<L: Lanes> Least<L> {
    /// Takes an axis if it is surely the least, or not surely the least but one of the faces'.
    #[inline(always)]
    fn offer(&mut self, l: L, [value, error, margin]: [L::F; 3], edges: [L::F; 2]) {
        let is_less = l.lt(l.add(value, margin), self.value);
        self.value = l.select(is_less, value, self.value);
        self.error = l.select(is_less, error, self.error);
        let [of_a, of_b] = self.edges;
        self.edges = [l.select(is_less, edges[0], of_a), l.select(is_less, edges[1], of_b)];
    }
}

impl<L: Lanes> Overlap<L> {
    #[inline(always)]
    pub(super) fn of(l: L, [a, b]: [&Cuboids<L>; 2], between: V3<L>, size: L::F) -> Self {
        let error = l.mul(size, l.splat(GAP * U));
        let axes = Projections::of(l, [a, b], between);
        let (none, zero) = (l.splat(-1.0), l.splat(0.0));
        let infinite = l.splat(f32::INFINITY);
        let mut least = Least { value: infinite, error, lower: infinite, edges: [none; 2] };
        for k in 0..3 {
            let overlap = axes.of_a(l, k).overlap(l);
            least.offer(l, [overlap, error, zero], [l.splat(k as f32), none]);
        }
        for k in 0..3 {
            let overlap = axes.of_b(l, k).overlap(l);
            least.offer(l, [overlap, error, zero], [none, l.splat(k as f32)]);
        }
        least.lower = l.sub(least.value, error);
        let mut products = [[zero; 2]; 9];
        for j in 0..3 {
            for k in 0..3 {
                let (product, squared) = axes.of_product(l, j, k);
                let overlap = product.overlap(l);
                let sine = l.sqrt(squared);
                let scale = l.div(l.splat(1.0), sine);
                let (value, own) = (l.mul(overlap, scale), l.mul(error, scale));
                let is_axis = l.lt(l.splat(PARALLEL), squared);
                let proved = l.select(is_axis, l.sub(value, own), l.splat(f32::NEG_INFINITY));
                let is_long = l.lt(l.splat(LONG), squared);
                least.lower = l.min(least.lower, l.select(is_long, proved, infinite));
                // Of edges that are nearly parallel the other axes prove as much, less how far the one reaches beside the other.
                let half = l.min(a.half[j], b.half[k]);
                let off = l.mul(l.add(sine, l.splat(SINE * U)), half);
                products[3 * j + k] = [off, proved];
                let value = l.select(is_axis, value, infinite);
                least.offer(l, [value, own, own], [l.splat(j as f32), l.splat(k as f32)]);
            }
        }
        // Those of the faces and the long products.
        let others = least.lower;
        let mut lower = others;
        for [off, own] in products {
            lower = l.min(lower, l.max(own, l.sub(others, off)));
        }
        let bound = l.max(least.error, l.sub(least.value, lower));
        Self { value: least.value, bound, edges: least.edges }
    }

    /// Whether that is as good as is asked.
    #[inline(always)]
    pub(super) fn is_known(&self, l: L, size: L::F) -> L::M {
        l.le(self.bound, l.mul(size, l.splat(WORST)))
    }

    /// The axis from the first to the second, of unit length, and where it is against its edge or product.
    #[inline(always)]
    pub(super) fn normal(&self, l: L, [a, b]: [&Cuboids<L>; 2], between: V3<L>) -> (V3<L>, L::M) {
        let [of_a, of_b] = self.edges;
        let zero = l.splat(0.0);
        let (has_a, has_b) = (l.le(zero, of_a), l.le(zero, of_b));
        let (e, f) = (pick_vector(l, of_a, a.axes), pick_vector(l, of_b, b.axes));
        let product = e.cross(l, f);
        let scale = l.div(l.splat(1.0), l.sqrt(product.dot(l, product)));
        let product = V3(l.mul(product.0, scale), l.mul(product.1, scale), l.mul(product.2, scale));
        let face = V3::select(l, has_a, e, f);
        let normal = V3::select(l, l.and(has_a, has_b), product, face);
        let is_back = l.lt(normal.dot(l, between), zero);
        (V3::select(l, is_back, normal.neg(l), normal), is_back)
    }
}
