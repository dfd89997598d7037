//! Sixteen triangles against one: separating axes in f32, each with its bound.

use super::between::Between;
use super::bounds::{SEPARATION, SHORTEST, SWEPT, U};
use dcd_geom::Triangles;
use dcd_geom::lanes::{Block, Lanes};

/// What is the same for every pair of triangles of two leaves.
#[derive(Clone, Copy)]
pub(super) struct Leaves {
    /// From the first leaf's centre to the second's, in the first frame.
    offset: [f32; 3],
    /// What a separation must exceed per |d|₁ to be proved.
    bound: f32,
    /// The sum of the swept radii, enlarged: per |d|.
    radius: f32,
    /// And in any case.
    least: f32,
}

impl Leaves {
    /// Of a leaf of the first mesh and one of the second, with the sum of their swept radii.
    pub(super) fn of(between: &Between, a: &Triangles, b: &Triangles, radius: f64) -> Self {
        let offset = between.rotation * b.centre + between.offset - a.centre;
        let size = a.radius + b.radius + offset.length();
        // Coordinates relative to the centres are far smaller than the shapes, and so is what they
        // lose; 1 % is room for the stretch of the matrices and for the sums here.
        let bound = 1.01 * (SEPARATION * U * size + between.slack());
        let least = if radius > 0.0 { 2.0 * SHORTEST * size } else { 0.0 };
        Self {
            offset: offset.as_vec3().to_array(),
            bound: (bound as f32).next_up(),
            radius: ((radius * (1.0 + SWEPT)) as f32 * (1.0 + 2.0 * f32::EPSILON)).next_up(),
            least: least as f32 + f32::MIN_POSITIVE,
        }
    }
}

type Vector<L> = [<L as Lanes>::F; 3];

/// Which of the open lanes' triangles of the first leaf are not proved apart from triangle `lane`
/// of the second, whose corners were turned into the first axes.
#[inline(always)]
pub(super) fn not_apart<L: Lanes>(
    l: L,
    leaves: &Leaves,
    [a, b]: [&[Block; 3]; 2],
    (lane, open): (usize, u32),
) -> u32 {
    let zero = l.splat(0.0);
    let mut pa = [[zero; 3]; 3];
    let mut pb = [[zero; 3]; 3];
    for corner in 0..3 {
        for axis in 0..3 {
            pa[corner][axis] = l.load(&a[corner].0[axis]);
            pb[corner][axis] = l.splat(b[corner].0[axis].0[lane] + leaves.offset[axis]);
        }
    }
    let edges_a = edges(l, &pa);
    let edges_b = edges(l, &pb);
    let mut open = open;
    open &= !separated(l, leaves, cross(l, &edges_b[0], &edges_b[1]), [&pa, &pb]);
    if open == 0 {
        return 0;
    }
    open &= !separated(l, leaves, cross(l, &edges_a[0], &edges_a[1]), [&pa, &pb]);
    for edge_b in &edges_b {
        if open == 0 {
            return 0;
        }
        for edge_a in &edges_a {
            open &= !separated(l, leaves, cross(l, edge_a, edge_b), [&pa, &pb]);
        }
    }
    open
}

/// The lanes in which `d` separates the two triangles.
#[inline(always)]
fn separated<L: Lanes>(l: L, leaves: &Leaves, d: Vector<L>, [a, b]: [&[Vector<L>; 3]; 2]) -> u32 {
    let ([low_a, high_a], [low_b, high_b]) = (interval(l, &d, a), interval(l, &d, b));
    let gap = l.max(l.sub(low_a, high_b), l.sub(low_b, high_a));
    let norm = l.add(l.add(l.abs(d[0]), l.abs(d[1])), l.abs(d[2]));
    let mut bound = l.mul_add(l.splat(leaves.bound), norm, l.splat(leaves.least));
    if leaves.radius > f32::MIN_POSITIVE {
        let square = dot(l, &d, &d);
        bound = l.mul_add(l.splat(leaves.radius), l.sqrt(square), bound);
    }
    l.bits(l.lt(bound, gap))
}

#[inline(always)]
fn interval<L: Lanes>(l: L, d: &Vector<L>, points: &[Vector<L>; 3]) -> [L::F; 2] {
    let (x, y, z) = (dot(l, d, &points[0]), dot(l, d, &points[1]), dot(l, d, &points[2]));
    [l.min(l.min(x, y), z), l.max(l.max(x, y), z)]
}

#[inline(always)]
fn edges<L: Lanes>(l: L, corners: &[Vector<L>; 3]) -> [Vector<L>; 3] {
    let [a, b, c] = corners;
    [sub(l, b, a), sub(l, c, b), sub(l, a, c)]
}

#[inline(always)]
fn sub<L: Lanes>(l: L, a: &Vector<L>, b: &Vector<L>) -> Vector<L> {
    [l.sub(a[0], b[0]), l.sub(a[1], b[1]), l.sub(a[2], b[2])]
}

#[inline(always)]
fn dot<L: Lanes>(l: L, a: &Vector<L>, b: &Vector<L>) -> L::F {
    l.mul_add(a[2], b[2], l.mul_add(a[1], b[1], l.mul(a[0], b[0])))
}

#[inline(always)]
fn cross<L: Lanes>(l: L, a: &Vector<L>, b: &Vector<L>) -> Vector<L> {
    let component = |i: usize, j: usize| (a[i], b[j], a[j], b[i]);
    let [(a1, b2, a2, b1), (a2_, b0, a0, b2_), (a0_, b1_, a1_, b0_)] =
        [component(1, 2), component(2, 0), component(0, 1)];
    [
        l.sub(l.mul(a1, b2), l.mul(a2, b1)),
        l.sub(l.mul(a2_, b0), l.mul(a0, b2_)),
        l.sub(l.mul(a0_, b1_), l.mul(a1_, b0_)),
    ]
}
