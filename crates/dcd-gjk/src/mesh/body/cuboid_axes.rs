//! A cuboid against sixteen triangles by their thirteen axes (docs/numerics/proofs.md, "Parts").

use super::{Body, Bounds, Plane, Proved, max3, min3, splat};
use crate::mesh::bounds::{CUBOID_CORNERS, CUBOID_DETERMINANT, CUBOID_HEIGHT, U, up};
use crate::simd::vector::V3;
use dcd_geom::glam::Vec3;
use dcd_simd::{Lanes, Row};

impl Body {
    /// A cuboid, by the triangle's normal, and whether the line from its middle to its farthest corner goes through the
    /// triangle.
    #[inline(always)]
    pub(super) fn by_farthest_corner<L: Lanes>(
        &self,
        l: L,
        bounds: &Bounds,
        corners: [V3<L>; 3],
        (axes, half): ([Vec3; 3], Vec3),
        open: u32,
    ) -> Proved {
        let plane = Plane::of(l, corners);
        let zero = l.splat(0.0);
        let (mut most, mut at) = (zero, V3(zero, zero, zero));
        for (axis, half) in axes.into_iter().zip(half.to_array()) {
            let (axis, half) = (splat(l, axis), l.splat(half));
            let along = plane.normal.dot(l, axis);
            most = l.mul_add(l.abs(along), half, most);
            at = at.plus(l, l.select(l.lt(along, zero), l.neg(half), half), axis);
        }
        let apart = open & bounds.beyond(l, l.sub(plane.low, most), plane.normal);
        if apart == open {
            return Proved { touching: 0, apart };
        }
        let lost = [CUBOID_HEIGHT, CUBOID_DETERMINANT];
        Proved { touching: self.pierced(l, (bounds, lost), corners, &plane, (most, at)), apart }
    }

    /// A cuboid, by its three axes, the triangle's normal and the nine products of edges.
    #[inline(always)]
    pub(super) fn by_axes<L: Lanes>(
        &self,
        l: L,
        bounds: &Bounds,
        (corners, at_most): ([V3<L>; 3], Option<&mut Row>),
        (axes, half): ([Vec3; 3], Vec3),
    ) -> Proved {
        let Bounds { size, far, .. } = *bounds;
        let [x, y, z] = axes;
        let axes = [splat(l, x), splat(l, y), splat(l, z)];
        let [p, q, r] = corners;
        let (p, q, r) = (turned(l, &axes, p), turned(l, &axes, q), turned(l, &axes, r));
        let half = splat(l, half);
        // What a corner is off, and an edge.
        let off = (CUBOID_CORNERS * U + self.departure) * far + 4.0 * self.slack;
        let off_edge = 2.02 * (off + U * far);
        let mut found = Axes { bounds, apart: l.mask(0), touching: l.mask(u32::MAX) };
        let sides = [
            found.add_side(l, [p.0, q.0, r.0], half.0),
            found.add_side(l, [p.1, q.1, r.1], half.1),
            found.add_side(l, [p.2, q.2, r.2], half.2),
        ];
        let edges = [q.sub(l, p), r.sub(l, q), p.sub(l, r)];
        let off_normal = 1.01 * size * (2.0 * off_edge + 8.0 * U * far);
        let second_order = (8.0 * size * off_edge * off_edge) as f32 + f32::MIN_POSITIVE;
        let both = l.add(edges[0].norm1(l), edges[1].norm1(l));
        let off_normal = l.mul_add(l.splat(up(off_normal)), both, l.splat(second_order));
        let normal = edges[0].cross(l, edges[1]);
        let of_normal = found.add_normal(l, normal, ([p, q, r], half), off_normal);
        if let Some(row) = at_most {
            let [s, t, u] = sides;
            let by_sides = bounds.at_most_along_unit(l, max3(l, s, t, u));
            l.store(l.min(bounds.at_most(l, of_normal, normal), by_sides), row);
        }
        // Of an edge both ends are at one height: one of them and the corner opposite.
        let off = l.splat(up(2.02 * size * off_edge));
        for (edge, from, opposite) in [(edges[0], p, r), (edges[1], q, p), (edges[2], r, q)] {
            found.add_product(
                l,
                (edge.1, edge.2),
                [(from.1, from.2), (opposite.1, opposite.2)],
                (half.1, half.2),
                off,
            );
            found.add_product(
                l,
                (edge.2, edge.0),
                [(from.2, from.0), (opposite.2, opposite.0)],
                (half.2, half.0),
                off,
            );
            found.add_product(
                l,
                (edge.0, edge.1),
                [(from.0, from.1), (opposite.0, opposite.1)],
                (half.0, half.1),
                off,
            );
        }
        Proved { touching: l.bits(found.touching), apart: l.bits(found.apart) }
    }
}

/// What the axes of a cuboid and a triangle say so far.
struct Axes<'a, L: Lanes> {
    bounds: &'a Bounds,
    apart: L::M,
    touching: L::M,
}

impl<L: Lanes> Axes<'_, L> {
    /// The normal of one of the cuboid's sides: the corners' coordinates along it, and its half edge.
    #[inline(always)]
    fn add_side(&mut self, l: L, [p, q, r]: [L::F; 3], half: L::F) -> L::F {
        let one = l.splat(1.0);
        self.add(l, (min3(l, p, q, r), max3(l, p, q, r)), half, (one, one), l.splat(0.0))
    }

    /// The triangle's normal.
    #[inline(always)]
    fn add_normal(
        &mut self,
        l: L,
        normal: V3<L>,
        ([p, q, r], half): ([V3<L>; 3], V3<L>),
        off: L::F,
    ) -> L::F {
        let (p, q, r) = (normal.dot(l, p), normal.dot(l, q), normal.dot(l, r));
        let reach = half.dot(l, V3(l.abs(normal.0), l.abs(normal.1), l.abs(normal.2)));
        let lengths = (normal.norm1(l), normal.dot(l, normal));
        self.add(l, (min3(l, p, q, r), max3(l, p, q, r)), reach, lengths, off)
    }

    /// The product (0, f, −e) of an edge (_, e, f) and the cuboid's first direction, or its like of another direction:
    /// from two corners' coordinates and the half edges along the other two.
    #[inline(always)]
    fn add_product(
        &mut self,
        l: L,
        (e, f): (L::F, L::F),
        [s, t]: [(L::F, L::F); 2],
        (g, h): (L::F, L::F),
        off: L::F,
    ) {
        let s = l.sub(l.mul(f, s.0), l.mul(e, s.1));
        let t = l.sub(l.mul(f, t.0), l.mul(e, t.1));
        let (abs_e, abs_f) = (l.abs(e), l.abs(f));
        let reach = l.mul_add(g, abs_f, l.mul(h, abs_e));
        let lengths = (l.add(abs_e, abs_f), l.mul_add(e, e, l.mul(f, f)));
        self.add(l, (l.min(s, t), l.max(s, t)), reach, lengths, off);
    }

    /// Takes in an axis d: the triangle's ends along it, the cuboid's reach, |d|₁ and d·d, and what the axis itself may
    /// be off in a reach. The gap between the two.
    #[inline(always)]
    fn add(
        &mut self,
        l: L,
        (low, high): (L::F, L::F),
        reach: L::F,
        (norm1, square): (L::F, L::F),
        off: L::F,
    ) -> L::F {
        let gap = l.sub(l.max(low, l.neg(high)), reach);
        let bound = l.mul(l.splat(self.bounds.per_norm1), norm1);
        let beyond = self.bounds.with_radius(l, bound, square);
        self.apart = l.or(self.apart, l.lt(beyond, gap));
        self.touching = l.and(self.touching, l.lt(l.add(bound, off), l.neg(gap)));
        gap
    }
}

/// In the frame of those axes.
#[inline(always)]
fn turned<L: Lanes>(l: L, [x, y, z]: &[V3<L>; 3], v: V3<L>) -> V3<L> {
    V3(x.dot(l, v), y.dot(l, v), z.dot(l, v))
}
