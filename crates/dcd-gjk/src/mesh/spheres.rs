//! Sixteen triangles against the sphere inside a convex shape, the box inside it and the sphere round it. The
//! point of each triangle nearest to their centre resolves many triangles before any solver runs, and all of
//! them where the shape is a sphere (docs/numerics/proofs.md, "parts").

use super::bounds::{INNER_BOX, NEAREST, SHORTEST_AXIS, SMALLEST_SPHERE, SWEPT, TURNED, U, U64};
use super::relative_pose::RelativePose;
use super::side::{Parts, Side};
use crate::simd::vector::V3;
use dcd_geom::glam::{DVec3, Vec3};
use dcd_geom::{Shape, SupportMap, Triangles};
use dcd_simd::{Lanes, Row};

/// Two spheres round one centre in the first shape's axes: the second shape holds the inner one, the
/// outer one holds the second shape. The swept radii of both shapes are in them.
#[derive(Clone, Copy, Debug)]
pub(super) struct InnerOuterSpheres {
    pub(super) centre: DVec3,
    inner: f64,
    outer: f64,
    slack: f64,
    inside: Option<InnerBox>,
}

/// A box inside the second shape, round the same centre, in the first shape's axes.
#[derive(Clone, Copy, Debug)]
struct InnerBox {
    /// The directions of its edges.
    axes: [Vec3; 3],
    /// Half of them.
    half: DVec3,
    /// What the two matrices depart from rotations by, relative.
    departure: f64,
}

impl InnerBox {
    /// `None` where the shape has none, or a pose is too far from a rotation for its axes.
    fn of(relative: &RelativePose, shape: &Shape, departure: f64) -> Option<Self> {
        let obb = shape.as_polytope()?.obb()?;
        let half = obb.inner;
        let turned = relative.rotation * obb.axes;
        let axes = [turned.x_axis, turned.y_axis, turned.z_axis].map(|axis| axis.as_vec3());
        let says_something = half.min_element() > SMALLEST_SPHERE && departure < TURNED;
        says_something.then_some(Self { axes, half, departure })
    }

    /// The lanes whose point v, relative to the centre, is in the box, whatever it is off by.
    #[inline(always)]
    fn holds<L: Lanes>(&self, l: L, v: V3<L>, (size, rounding): (f64, f64)) -> u32 {
        let rounding = rounding + 1.01 * (INNER_BOX * U + 8.0 * self.departure) * size;
        let mut inside = l.mask(u32::MAX);
        for (axis, half) in self.axes.into_iter().zip(self.half.to_array()) {
            let axis = V3(l.splat(axis.x), l.splat(axis.y), l.splat(axis.z));
            let most = ((half - rounding) as f32).next_down();
            inside = l.and(inside, l.lt(l.abs(axis.dot(l, v)), l.splat(most)));
        }
        l.bits(inside)
    }
}

/// What is proved of a leaf's triangles.
#[derive(Clone, Copy, Default)]
pub(super) struct Decided {
    pub(super) touching: u32,
    pub(super) apart: u32,
    /// The squared distance of each from the centre, rounded: orders the search, part of no answer.
    pub(super) squares: Row,
}

impl InnerOuterSpheres {
    /// `None` where the second shape is not convex.
    pub(super) fn of(relative: &RelativePose, [a, b]: [&Side<'_>; 2]) -> Option<Self> {
        let Parts::One(shape) = b.parts else { return None };
        let sphere = shape.inner();
        let outer = match shape {
            Shape::Polytope(polytope) => polytope.outer_radius() + polytope.swept_radius(),
            other => other.reach() + sphere.centre.length(),
        };
        // Of a foreign map no point is known to be inside, not even its frame's origin.
        let known = if shape.centre_is_inside() { sphere.radius } else { f64::NEG_INFINITY };
        let (turn_a, turn_b) = (a.pose.deviation(), b.pose.deviation());
        let swept = a.radius() + shape.radius();
        let outer = (outer * (1.0 + turn_b) + a.radius()) * (1.0 + turn_a);
        let inner = (known * (1.0 - turn_b) + swept) * (1.0 - turn_a);
        Some(Self {
            centre: relative.rotation * sphere.centre + relative.offset,
            inner: inner * (1.0 - 16.0 * U64),
            outer: outer * (1.0 + 16.0 * U64),
            slack: relative.slack(),
            inside: InnerBox::of(relative, shape, turn_a + turn_b),
        })
    }

    /// Tests a leaf's triangles against both spheres. Also the nearest points, from their centre.
    #[inline(always)]
    pub(super) fn decide<L: Lanes>(&self, l: L, leaf: &Triangles) -> (Decided, V3<L>) {
        let offset = self.centre - leaf.centre;
        let size = leaf.radius + offset.length();
        let rounding = 1.01 * (NEAREST * U * size + 2.0 * self.slack);
        let centre = offset.as_vec3();
        let centre = V3(l.splat(centre.x), l.splat(centre.y), l.splat(centre.z));
        let [a, b, c] = &leaf.corners;
        let a = V3::load(l, &a.0).sub(l, centre);
        let b = V3::load(l, &b.0).sub(l, centre);
        let c = V3::load(l, &c.0).sub(l, centre);
        let v = nearest(l, [a, b, c]);
        let square = v.dot(l, v);

        let within = self.inner - rounding;
        let mut touching = if within > SMALLEST_SPHERE {
            let most = (within * within * (1.0 - 4.0 * U)) as f32;
            l.bits(l.lt(square, l.splat(most.next_down())))
        } else {
            0
        };
        if let Some(inside) = &self.inside {
            touching |= inside.holds(l, v, (size, rounding));
        }
        let beyond = ((self.outer + rounding) * (1.0 + SWEPT)) as f32;
        let least = 2.0 * SHORTEST_AXIS * size;
        let least = l.splat(least as f32 + f32::MIN_POSITIVE);
        let bound = l.mul_add(l.splat(beyond.next_up()), l.sqrt(square), least);
        let lowest = l.min(l.min(v.dot(l, a), v.dot(l, b)), v.dot(l, c));
        let apart = l.bits(l.lt(bound, lowest));

        let mut squares = Row::default();
        l.store(square, &mut squares);
        (Decided { touching, apart, squares }, v)
    }
}

/// The point of each triangle that is nearest to the origin, as f32 has it; for any triangle it is
/// a point of it to within rounding, or NaN.
#[inline(always)]
pub(super) fn nearest<L: Lanes>(l: L, triangle: [V3<L>; 3]) -> V3<L> {
    Flat::of(l, triangle).nearest(l, triangle[0])
}

/// What the nearest points of sixteen triangles have in common, from wherever they are sought.
pub(super) struct Flat<L: Lanes> {
    ab: V3<L>,
    ac: V3<L>,
    /// The products of the two: of the first with itself, with the second, and of that with itself.
    products: [L::F; 3],
    /// The determinant of these.
    area: L::F,
}

impl<L: Lanes> Flat<L> {
    #[inline(always)]
    pub(super) fn of(l: L, [a, b, c]: [V3<L>; 3]) -> Self {
        let (ab, ac) = (b.sub(l, a), c.sub(l, a));
        let [g11, g12, g22] = [ab.dot(l, ab), ab.dot(l, ac), ac.dot(l, ac)];
        let area = l.sub(l.mul(g11, g22), l.mul(g12, g12));
        Self { ab, ac, products: [g11, g12, g22], area }
    }

    /// The points nearest to the origin, where the first corners are there.
    #[inline(always)]
    pub(super) fn nearest(&self, l: L, a: V3<L>) -> V3<L> {
        let &Self { ab, ac, products: [g11, g12, g22], area } = self;
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let (h1, h2) = (l.neg(ab.dot(l, a)), l.neg(ac.dot(l, a)));

        // On the three edges, and in the middle where that is inside.
        let along = l.sub(l.add(l.sub(g11, g12), h2), h1);
        let t = share(l, along, l.add(l.sub(l.sub(g11, g12), g12), g22));
        let edges = [(share(l, h1, g11), zero), (zero, share(l, h2, g22)), (l.sub(one, t), t)];
        let s = l.div(l.sub(l.mul(h1, g22), l.mul(h2, g12)), area);
        let t = l.div(l.sub(l.mul(h2, g11), l.mul(h1, g12)), area);
        let inside = l.and(l.and(l.le(zero, s), l.le(zero, t)), l.le(l.add(s, t), one));

        let mut best = a;
        let mut least = a.dot(l, a);
        for (s, t) in edges {
            let other = a.plus(l, s, ab).plus(l, t, ac);
            let square = other.dot(l, other);
            let nearer = l.lt(square, least);
            best = V3::select(l, nearer, other, best);
            least = l.select(nearer, square, least);
        }
        let middle = a.plus(l, s, ab).plus(l, t, ac);
        let nearer = l.and(inside, l.lt(middle.dot(l, middle), least));
        V3::select(l, nearer, middle, best)
    }
}

/// x / y, between 0 and 1.
#[inline(always)]
fn share<L: Lanes>(l: L, x: L::F, y: L::F) -> L::F {
    l.min(l.max(l.div(x, y), l.splat(0.0)), l.splat(1.0))
}
