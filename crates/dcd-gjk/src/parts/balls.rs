//! Sixteen triangles beside the ball inside a convex shape and the ball round it: the point of each
//! nearest to their centre tells much before any solver is asked, and of spheres all
//! (docs/numerics.md, "parts").

use super::between::Between;
use super::bounds::{NEAREST, SHORTEST_AXIS, SMALLEST_BALL, SWEPT, U, U64};
use super::side::{Parts, Side};
use dcd_geom::glam::DVec3;
use dcd_geom::lanes::{Lanes, Row};
use dcd_geom::{Shape, SupportMap, Triangles};

/// Two balls round one centre in the first shape's axes: the second shape holds the inner one, the
/// outer one holds the second shape. The swept radii of both shapes are in them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balls {
    pub(super) centre: DVec3,
    inner: f64,
    outer: f64,
    slack: f64,
}

/// What the balls tell of a leaf's triangles.
pub(super) struct Told {
    pub(super) touching: u32,
    pub(super) apart: u32,
    /// The squared distance of each from the centre, about: in no answer.
    pub(super) squares: Row,
}

type Vector<L> = [<L as Lanes>::F; 3];

impl Balls {
    /// `None` where the second shape is not convex.
    pub(super) fn of(between: &Between, [a, b]: [&Side<'_>; 2]) -> Option<Self> {
        let Parts::One(shape) = b.parts else { return None };
        let inner = shape.inner();
        let outer = match shape {
            Shape::Polytope(polytope) => polytope.outer_radius() + polytope.swept_radius(),
            other => other.reach() + inner.centre.length(),
        };
        let (turn_a, turn_b) = (a.pose.deviation(), b.pose.deviation());
        let swept = a.radius() + shape.radius();
        let outer = (outer * (1.0 + turn_b) + a.radius()) * (1.0 + turn_a);
        let inner = (inner.radius * (1.0 - turn_b) + swept) * (1.0 - turn_a);
        Some(Self {
            centre: between.rotation * shape.inner().centre + between.offset,
            inner: inner * (1.0 - 16.0 * U64),
            outer: outer * (1.0 + 16.0 * U64),
            slack: between.slack(),
        })
    }

    /// Holds a leaf's triangles against both.
    #[inline(always)]
    pub(super) fn told<L: Lanes>(&self, l: L, leaf: &Triangles) -> Told {
        let offset = self.centre - leaf.centre;
        let size = leaf.radius + offset.length();
        let rounding = 1.01 * (NEAREST * U * size + 2.0 * self.slack);
        let centre = offset.as_vec3().to_array();
        let corners = leaf.corners.each_ref().map(|corner| {
            [0, 1, 2].map(|axis| l.sub(l.load(&corner.0[axis]), l.splat(centre[axis])))
        });
        let v = nearest(l, &corners);
        let square = dot(l, &v, &v);

        let within = self.inner - rounding;
        let touching = if within > SMALLEST_BALL {
            let most = (within * within * (1.0 - 4.0 * U)) as f32;
            l.bits(l.lt(square, l.splat(most.next_down())))
        } else {
            0
        };
        let beyond = ((self.outer + rounding) * (1.0 + SWEPT)) as f32;
        let least = 2.0 * SHORTEST_AXIS * size;
        let least = l.splat(least as f32 + f32::MIN_POSITIVE);
        let bound = l.mul_add(l.splat(beyond.next_up()), l.sqrt(square), least);
        let along = corners.map(|corner| dot(l, &v, &corner));
        let lowest = l.min(l.min(along[0], along[1]), along[2]);
        let apart = l.bits(l.lt(bound, lowest));

        let mut squares = Row::default();
        l.store(square, &mut squares);
        Told { touching, apart, squares }
    }
}

/// The point of each triangle that is nearest to the origin, as f32 has it; for any triangle it is
/// a point of it to within rounding, or NaN.
#[inline(always)]
fn nearest<L: Lanes>(l: L, [a, b, c]: &[Vector<L>; 3]) -> Vector<L> {
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    let (ab, ac) = (sub(l, b, a), sub(l, c, a));
    let (g11, g12, g22) = (dot(l, &ab, &ab), dot(l, &ab, &ac), dot(l, &ac, &ac));
    let (h1, h2) = (l.neg(dot(l, &ab, a)), l.neg(dot(l, &ac, a)));
    let share = |x: L::F, y: L::F| l.min(l.max(l.div(x, y), zero), one);

    // On the three edges, and in the middle where that is inside.
    let along = l.sub(l.add(l.sub(g11, g12), h2), h1);
    let t = share(along, l.add(l.sub(l.sub(g11, g12), g12), g22));
    let edges = [(share(h1, g11), zero), (zero, share(h2, g22)), (l.sub(one, t), t)];
    let area = l.sub(l.mul(g11, g22), l.mul(g12, g12));
    let s = l.div(l.sub(l.mul(h1, g22), l.mul(h2, g12)), area);
    let t = l.div(l.sub(l.mul(h2, g11), l.mul(h1, g12)), area);
    let inside = l.and(l.and(l.le(zero, s), l.le(zero, t)), l.le(l.add(s, t), one));

    let point = |(s, t): (L::F, L::F)| {
        [0, 1, 2].map(|axis| l.mul_add(t, ac[axis], l.mul_add(s, ab[axis], a[axis])))
    };
    let mut best = *a;
    let mut least = dot(l, a, a);
    for weights in edges {
        let other = point(weights);
        let square = dot(l, &other, &other);
        let nearer = l.lt(square, least);
        best = choose(l, nearer, &other, &best);
        least = l.select(nearer, square, least);
    }
    let middle = point((s, t));
    let nearer = l.and(inside, l.lt(dot(l, &middle, &middle), least));
    choose(l, nearer, &middle, &best)
}

#[inline(always)]
fn choose<L: Lanes>(l: L, mask: L::M, yes: &Vector<L>, no: &Vector<L>) -> Vector<L> {
    [0, 1, 2].map(|axis| l.select(mask, yes[axis], no[axis]))
}

#[inline(always)]
fn sub<L: Lanes>(l: L, a: &Vector<L>, b: &Vector<L>) -> Vector<L> {
    [l.sub(a[0], b[0]), l.sub(a[1], b[1]), l.sub(a[2], b[2])]
}

#[inline(always)]
fn dot<L: Lanes>(l: L, a: &Vector<L>, b: &Vector<L>) -> L::F {
    l.mul_add(a[2], b[2], l.mul_add(a[1], b[1], l.mul(a[0], b[0])))
}
