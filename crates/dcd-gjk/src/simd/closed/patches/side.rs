//! What a cuboid shows along a direction: a face, an edge or a corner; and where two edges cross.

use super::super::{Cuboids, pick, pick_vector};
use crate::simd::vector::V3;
use dcd_simd::Lanes;

/// The least cosine between a face's normal and the contact's for the face to lie in it.
pub(super) const FACING: f32 = crate::query::FACING as f32;

/// The most that an edge may rise along the contact's normal, relative to its length.
pub(super) const LEVEL: f32 = crate::query::LEVEL as f32;

/// Half edges below this part of the largest are no solid's. Decides who answers, never an answer.
pub(super) const SOLID: f32 = 1e-3;

/// The squared sine below which edges are left to f64. No unit. Decides who answers.
pub(super) const CROSSING: f32 = 1e-2;

impl<L: Lanes> Cuboids<L> {
    /// Whether no half edge is small beside another.
    #[inline(always)]
    pub(super) fn is_solid(&self, l: L) -> L::M {
        let [x, y, z] = self.half;
        let (least, most) = (l.min(x, l.min(y, z)), l.max(x, l.max(y, z)));
        l.lt(l.mul(most, l.splat(SOLID)), least)
    }
}

/// A cuboid, and what it shows along a direction.
pub(super) struct Side<L: Lanes> {
    pub(super) cuboid: Cuboids<L>,
    /// The direction's parts along its edges.
    pub(super) towards: [L::F; 3],
    pub(super) is_face: L::M,
    pub(super) is_edge: L::M,
    /// The axis that is the most along the direction, and the one that is the least.
    pub(super) most: L::F,
    pub(super) least: L::F,
    /// How much along the direction the first of them is.
    pub(super) along: L::F,
}

impl<L: Lanes> Side<L> {
    #[inline(always)]
    pub(super) fn of(l: L, cuboid: &Cuboids<L>, direction: V3<L>) -> Self {
        let towards = cuboid.along(l, direction);
        let (mut along, mut level) = (l.abs(towards[0]), l.abs(towards[0]));
        let (mut most, mut least) = (l.splat(0.0), l.splat(0.0));
        for (k, towards) in towards.iter().enumerate().skip(1) {
            let (here, number) = (l.abs(*towards), l.splat(k as f32));
            most = l.select(l.lt(along, here), number, most);
            least = l.select(l.lt(here, level), number, least);
            along = l.max(along, here);
            level = l.min(level, here);
        }
        let is_face = l.lt(l.splat(FACING), along);
        let is_edge = l.and_not(l.lt(level, l.splat(LEVEL)), is_face);
        Self { cuboid: *cuboid, towards, is_face, is_edge, most, least, along }
    }

    /// How square to the direction its face is; 0 where it is no face.
    #[inline(always)]
    pub(super) fn facing(&self, l: L) -> L::F {
        l.select(self.is_face, self.along, l.splat(0.0))
    }

    /// What it shows, as a number: see `Shown::decode` (found.rs).
    #[inline(always)]
    pub(super) fn code(&self, l: L) -> L::F {
        let kind = l.select(self.is_edge, l.splat(1.0), l.splat(2.0));
        let kind = l.select(self.is_face, l.splat(0.0), kind);
        let axis = l.select(self.is_edge, self.least, self.most);
        let mut code = l.add(kind, l.mul(axis, l.splat(4.0)));
        for (k, towards) in self.towards.iter().enumerate() {
            let is_high = l.le(l.splat(0.0), *towards);
            let bit = l.select(is_high, l.splat((16 << k) as f32), l.splat(0.0));
            code = l.add(code, bit);
        }
        code
    }

    #[inline(always)]
    pub(super) fn select(l: L, mask: L::M, [yes, no]: [&Self; 2]) -> Self {
        let mut cuboid = yes.cuboid;
        let mut towards = yes.towards;
        for (axis, other) in cuboid.axes.iter_mut().zip(no.cuboid.axes) {
            *axis = V3::select(l, mask, *axis, other);
        }
        for (half, other) in cuboid.half.iter_mut().zip(no.cuboid.half) {
            *half = l.select(mask, *half, other);
        }
        cuboid.case = l.select(mask, cuboid.case, no.cuboid.case);
        for (along, other) in towards.iter_mut().zip(no.towards) {
            *along = l.select(mask, *along, other);
        }
        Self {
            cuboid,
            towards,
            is_face: l.or(l.and(mask, yes.is_face), l.and_not(no.is_face, mask)),
            is_edge: l.or(l.and(mask, yes.is_edge), l.and_not(no.is_edge, mask)),
            most: l.select(mask, yes.most, no.most),
            least: l.select(mask, yes.least, no.least),
            along: l.select(mask, yes.along, no.along),
        }
    }

    /// The direction of the edge that it shows, half of it, and its middle from the cuboid's own centre.
    #[inline(always)]
    pub(super) fn edge(&self, l: L) -> (V3<L>, L::F, V3<L>) {
        let zero = l.splat(0.0);
        let Turned { axes: [e, v, w], half, along } = self.turned(l, self.least);
        let at_v = signed(l, half[1], along[1]);
        let at_w = signed(l, half[2], along[2]);
        (e, half[0], V3(zero, zero, zero).plus(l, at_v, v).plus(l, at_w, w))
    }

    /// Its axes from the one of that number on.
    #[inline(always)]
    pub(super) fn turned(&self, l: L, number: L::F) -> Turned<L> {
        let [x, y, z] = self.cuboid.axes;
        let axes = [
            pick_vector(l, number, [x, y, z]),
            pick_vector(l, number, [y, z, x]),
            pick_vector(l, number, [z, x, y]),
        ];
        let half = turned(l, number, self.cuboid.half);
        Turned { axes, half, along: turned(l, number, self.towards) }
    }
}

/// The axes of a cuboid from one of them on, half of its edges along them, and how much of the direction is along them.
pub(super) struct Turned<L: Lanes> {
    pub(super) axes: [V3<L>; 3],
    pub(super) half: [L::F; 3],
    pub(super) along: [L::F; 3],
}

/// Three numbers from the one of that index on.
#[inline(always)]
fn turned<L: Lanes>(l: L, number: L::F, [x, y, z]: [L::F; 3]) -> [L::F; 3] {
    [pick(l, number, [x, y, z]), pick(l, number, [y, z, x]), pick(l, number, [z, x, y])]
}

/// A number with the sign of another.
#[inline(always)]
pub(super) fn signed<L: Lanes>(l: L, x: L::F, sign: L::F) -> L::F {
    l.select(l.le(l.splat(0.0), sign), x, l.neg(x))
}

/// Where an edge of the first crosses one of the second.
pub(super) struct Crossing<L: Lanes> {
    /// On the first's edge, from its centre, world axes.
    pub(super) offset: V3<L>,
    pub(super) sine: L::F,
    /// Whether the edges are not nearly parallel, and the crossing is on both.
    pub(super) is_known: L::M,
}

impl<L: Lanes> Crossing<L> {
    /// Of no edges.
    #[inline(always)]
    pub(super) fn none(l: L) -> Self {
        let zero = l.splat(0.0);
        Self { offset: V3(zero, zero, zero), sine: zero, is_known: l.mask(0) }
    }

    /// Of the edges that the sides show; beyond their ends they have the slack, over the sine between them.
    #[inline(always)]
    pub(super) fn of(l: L, sides: &[Side<L>; 2], apart: V3<L>, slack: L::F) -> Self {
        let (e, half_e, middle) = sides[0].edge(l);
        let (f, half_f, of_second) = sides[1].edge(l);
        let between = of_second.add(l, apart).sub(l, middle);
        let cosine = e.dot(l, f);
        let squared = l.sub(l.splat(1.0), l.mul(cosine, cosine));
        let (along_e, along_f) = (e.dot(l, between), f.dot(l, between));
        let on_e = l.div(l.sub(along_e, l.mul(cosine, along_f)), squared);
        let on_f = l.div(l.sub(l.mul(cosine, along_e), along_f), squared);
        let sine = l.sqrt(squared);
        let slack = l.div(slack, sine);
        let are_on =
            l.and(l.le(l.abs(on_e), l.add(half_e, slack)), l.le(l.abs(on_f), l.add(half_f, slack)));
        let is_known = l.and(are_on, l.lt(l.splat(CROSSING), squared));
        Self { offset: middle.plus(l, on_e, e), sine, is_known }
    }
}
