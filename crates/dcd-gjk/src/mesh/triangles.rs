//! Sixteen triangles against one: separating axes in f32, each with its bound.

use super::bounds::{SEPARATION, SHORTEST, SWEPT, U};
use super::relative_pose::RelativePose;
use crate::simd::vector::V3;
use dcd_geom::Triangles;
use dcd_geom::glam::Vec3;
use dcd_simd::{Block, Lanes};

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
    /// Of both, metres.
    size: f64,
}

impl Leaves {
    /// Of a leaf of the first mesh and one of the second, with the sum of their swept radii.
    pub(super) fn of(relative: &RelativePose, a: &Triangles, b: &Triangles, radius: f64) -> Self {
        let offset = relative.rotation * b.centre + relative.offset - a.centre;
        let size = a.radius + b.radius + offset.length();
        // Coordinates relative to the centres are far smaller than the shapes, and so is what they
        // lose; 1 % covers the stretch of the matrices and the sums here.
        let bound = 1.01 * (SEPARATION * U * size + relative.slack());
        let least = if radius > 0.0 { 2.0 * SHORTEST * size } else { 0.0 };
        Self {
            offset: offset.as_vec3().to_array(),
            bound: (bound as f32).next_up(),
            radius: ((radius * (1.0 + SWEPT)) as f32 * (1.0 + 2.0 * f32::EPSILON)).next_up(),
            least: least as f32 + f32::MIN_POSITIVE,
            size,
        }
    }

    /// What a separation must exceed to be proved, per |d|₁: metres.
    pub(super) fn bound(&self) -> f32 {
        self.bound
    }

    /// How large both are with what is between them: metres.
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// From the first leaf's centre to the second's.
    pub(super) fn offset(&self) -> Vec3 {
        Vec3::from_array(self.offset)
    }

    #[inline(always)]
    fn offset_in_lanes<L: Lanes>(&self, l: L) -> V3<L> {
        let [x, y, z] = self.offset;
        V3(l.splat(x), l.splat(y), l.splat(z))
    }
}

/// Which of the open lanes' triangles of the first leaf are not proved apart from triangle `lane`
/// of the second, whose corners were turned into the first axes.
#[inline(always)]
pub(super) fn not_apart<L: Lanes>(
    l: L,
    leaves: &Leaves,
    corners: [&[Block; 3]; 2],
    (lane, open): (usize, u32),
) -> u32 {
    let [pa, pb] = load(l, leaves, corners, lane);
    let (edges_a, edges_b) = (edges(l, &pa), edges(l, &pb));
    let mut open = open;
    open &= !separated(l, leaves, edges_b[0].cross(l, edges_b[1]), [&pa, &pb]);
    if open == 0 {
        return 0;
    }
    open &= !separated(l, leaves, edges_a[0].cross(l, edges_a[1]), [&pa, &pb]);
    for edge_b in &edges_b {
        if open == 0 {
            return 0;
        }
        for edge_a in &edges_a {
            open &= !separated(l, leaves, edge_a.cross(l, *edge_b), [&pa, &pb]);
        }
    }
    open
}

/// The triangles of the first leaf, and triangle `lane` of the second in every lane, from the first's centre.
#[inline(always)]
pub(super) fn load<L: Lanes>(
    l: L,
    leaves: &Leaves,
    [a, b]: [&[Block; 3]; 2],
    lane: usize,
) -> [[V3<L>; 3]; 2] {
    let offset = leaves.offset_in_lanes(l);
    let (mut of_a, mut of_b) = ([offset; 3], [offset; 3]);
    for corner in 0..3 {
        let [x, y, z] = &b[corner].0;
        let one = V3(l.splat(x.0[lane]), l.splat(y.0[lane]), l.splat(z.0[lane]));
        (of_a[corner], of_b[corner]) = (V3::load(l, &a[corner].0), one.add(l, offset));
    }
    [of_a, of_b]
}

/// The triangles of both leaves, from the first's centre.
#[inline(always)]
pub(super) fn load_rows<L: Lanes>(
    l: L,
    leaves: &Leaves,
    [a, b]: [&[Block; 3]; 2],
) -> [[V3<L>; 3]; 2] {
    let offset = leaves.offset_in_lanes(l);
    let (mut of_a, mut of_b) = ([offset; 3], [offset; 3]);
    for corner in 0..3 {
        of_a[corner] = V3::load(l, &a[corner].0);
        of_b[corner] = V3::load(l, &b[corner].0).add(l, offset);
    }
    [of_a, of_b]
}

/// The lanes in which `d` separates the two triangles.
#[inline(always)]
fn separated<L: Lanes>(l: L, leaves: &Leaves, d: V3<L>, [a, b]: [&[V3<L>; 3]; 2]) -> u32 {
    let ([low_a, high_a], [low_b, high_b]) = (interval(l, d, a), interval(l, d, b));
    let gap = l.max(l.sub(low_a, high_b), l.sub(low_b, high_a));
    let mut bound = l.mul_add(l.splat(leaves.bound), d.norm1(l), l.splat(leaves.least));
    if leaves.radius > f32::MIN_POSITIVE {
        bound = l.mul_add(l.splat(leaves.radius), l.sqrt(d.dot(l, d)), bound);
    }
    l.bits(l.lt(bound, gap))
}

/// The least and the greatest height of corners along a direction.
#[inline(always)]
pub(super) fn interval<L: Lanes>(l: L, d: V3<L>, points: &[V3<L>; 3]) -> [L::F; 2] {
    let (x, y, z) = (d.dot(l, points[0]), d.dot(l, points[1]), d.dot(l, points[2]));
    [l.min(l.min(x, y), z), l.max(l.max(x, y), z)]
}

/// From each corner to the next.
#[inline(always)]
pub(super) fn edges<L: Lanes>(l: L, [a, b, c]: &[V3<L>; 3]) -> [V3<L>; 3] {
    [b.sub(l, *a), c.sub(l, *b), a.sub(l, *c)]
}
