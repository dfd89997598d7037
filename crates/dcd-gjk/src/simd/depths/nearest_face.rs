//! How far from the origin the boundary of A − B is at least, by a triangle of its points and the sphere inside it, sixteen pairs at
//! a time: where the triangle is the nearest part of that boundary, the depth is known and nothing is left to search.
//!
//! Triangle and sphere span a surface of eight triangles inside of A − B: the one; three that lead from its edges to points of the
//! sphere, each the farthest from the plane of an edge and the centre; three that lead from its corners to two of these; and the
//! three points themselves. That it winds round the origin is proved as of any surface (docs/numerics/proofs.md, "Depth by one
//! face").

#[cfg(test)]
mod tests;

use super::super::bounds::{SEPARATION, SIZE, U};
use super::super::frame::FramePair;
use super::super::scene_pairs::ScenePairs;
use super::super::vector::V3;
use super::answers::WriteDepth;
use super::confirm::WORST;
use super::proposed::{Proposal, Triangle, between, is_exchanged};
use super::search::{LENGTH, OFF};
use super::searched::Searched;
use super::surface::DETERMINANT;
use super::vectors::vertex;
use crate::distance::rounded_up;
use crate::epa::Depth;
use crate::query::FoundDepth;
use dcd_geom::Pair;
use dcd_geom::glam::{DVec3, Vec3};
use dcd_simd::{Kernel, Lanes, Path, dispatch_on};

/// How much nearer than computed a triangle may be, of points that are scaled to a size of 1 by a product: [`OFF`], and √3 for that
/// product. Unit: u. Smaller: a bound that is none.
const OFF_SCALED: f32 = OFF as f32 + 2.0;

/// The part of the inner radius that is taken: what its product with a unit vector gains, 7u, and a margin. Unit: 1. Larger: points
/// outside of the sphere.
const RADIUS: f32 = 1.0 - 16.0 * U;

/// A determinant that is not above this by more than rounding proves nothing: products of such edges underflow. Of points scaled to
/// a size of 1: no unit.
const LEAST: f32 = 1e-15;

/// How much nearer than the triangle another one may be, so that the triangle counts as the nearest. Unit: u·m. As the search has
/// it at the accuracy of f32: wider, worse bounds; smaller, more pairs that are searched.
const NEARER: f32 = 24.0;

/// How far the point of the triangle that the weights make may be from the foot of the origin on its plane. Unit: u·m, of the 1-norm.
/// Another part of the same face, beyond an edge, may hold the foot: the points that are reported would be off as far. Larger:
/// points beside the objects. Smaller: more pairs that are searched.
const ASIDE: f32 = 16.0;

/// The nearest face of A − B, of two objects in the order in which it is [proposed](super::proposed). Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NearestFace {
    /// Out of A − B; of length 1 but for rounding in f32.
    pub(super) normal: Vec3,
    /// How far along it the face is.
    pub(super) depth: f32,
    /// Between these is the pair's depth.
    pub(super) bounds: [f32; 2],
    /// The weights of the second and the third corner in the point nearest to the origin.
    pub(super) weights: [f32; 2],
    /// The vertices of a and of b that are farthest along the normal, and against it.
    pub(super) farthest: [u32; 2],
}

impl NearestFace {
    /// The depth of the pair whose face it is.
    #[inline(always)]
    fn depth(&self, triangle: Triangle, frames: FramePair<'_>, pair: Pair) -> Option<Depth> {
        let sides = [frames.a.record(pair.i), frames.b.record(pair.j)];
        let is_exchanged = is_exchanged(between(sides));
        let (first, blocks, side) = match is_exchanged {
            true => (sides[1], frames.b.blocks_of(sides[1]), 1),
            false => (sides[0], frames.a.blocks_of(sides[0]), 0),
        };
        let [p, q, r] = triangle.map(|corner| vertex(blocks, corner[side] as usize).as_dvec3());
        let [of_q, of_r] = self.weights.map(f64::from);
        let point = p + (q - p) * of_q + (r - p) * of_r;
        let point_a = DVec3::from_slice(&first.centre[..3]) + point;
        let normal = self.normal.as_dvec3().try_normalize()?;
        let depth = f64::from(self.depth);
        let [lower, upper] = self.bounds.map(f64::from);
        let error_bound = rounded_up((upper - depth).max(depth - lower));
        let point_b = point_a - normal * depth;
        let found = Depth { depth, normal, point_a, point_b, error_bound };
        Some(if is_exchanged { found.mirrored() } else { found })
    }
}

/// The pairs of which the nearest face is known.
#[derive(Debug, Default)]
pub(super) struct OfFaces {
    /// Their numbers among those that touch.
    numbers: Vec<u32>,
    pairs: Vec<Pair>,
    faces: Vec<(Triangle, NearestFace)>,
}

impl OfFaces {
    /// Takes those pairs out of the lists.
    pub(super) fn take(&mut self, searched: &mut Searched, proposals: &mut Vec<Option<Proposal>>) {
        let Searched { numbers, pairs, .. } = searched;
        self.numbers.clear();
        self.pairs.clear();
        self.faces.clear();
        let mut kept = 0;
        for place in 0..pairs.len().min(numbers.len()).min(proposals.len()) {
            let (pair, number, proposal) = (pairs[place], numbers[place], proposals[place]);
            if let Some(Proposal { triangle, nearest: Some(nearest) }) = proposal {
                self.numbers.push(number);
                self.pairs.push(pair);
                self.faces.push((triangle, nearest));
            } else {
                (pairs[kept], numbers[kept], proposals[kept]) = (pair, number, proposal);
                kept += 1;
            }
        }
        pairs.truncate(kept);
        numbers.truncate(kept);
        proposals.truncate(kept);
    }

    /// Answers them. `facets` says whether the faces are read where an answer is written.
    pub(super) fn answer_on(
        &self,
        path: Path,
        (objects, facets): (ScenePairs<'_>, bool),
        answers: &mut dyn WriteDepth,
    ) {
        let objects = ScenePairs { pairs: &self.pairs, ..objects };
        dispatch_on(path, AnswerFaces { of: self, objects, facets, answers });
    }
}

/// See [`OfFaces::answer_on`].
struct AnswerFaces<'a> {
    of: &'a OfFaces,
    objects: ScenePairs<'a>,
    facets: bool,
    answers: &'a mut dyn WriteDepth,
}

impl Kernel for AnswerFaces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { of: OfFaces { numbers, pairs, faces }, objects, facets, answers } = self;
        let looks_ahead = facets && !objects.have_few_shapes();
        let all = numbers.iter().zip(pairs).zip(faces).enumerate();
        for (place, ((&number, &pair), &(triangle, face))) in all {
            if looks_ahead {
                objects.look_ahead(place, true);
            }
            let farthest = if facets { objects.vertices(pair, face.farthest) } else { None };
            let depth = face.depth(triangle, objects.frames, pair);
            let found = depth.map(|depth| FoundDepth { depth, farthest });
            answers.write(number as usize, found.as_ref());
        }
    }
}

/// A triangle of computed points of A − B and a sphere inside it. Lengths in metres.
pub(super) struct Enclosed<L: Lanes> {
    /// Counter-clockwise, seen from where the origin is not.
    pub(super) corners: [V3<L>; 3],
    /// The sphere's centre.
    pub(super) c: V3<L>,
    /// Its radius, up to a rounding.
    pub(super) inner: L::F,
    /// The sum of the radii of spheres that hold both objects, and |c|₁.
    pub(super) size: L::F,
    /// What the centre may be off beside its rounding.
    pub(super) slack: L::F,
}

/// What a triangle proves.
pub(super) struct NearestFaces<L: Lanes> {
    /// Where it is the nearest.
    pub(super) holds: L::M,
    /// Out of A − B; of length 1 but for 4u.
    pub(super) normal: V3<L>,
    /// How far along it the triangle is, and how far the boundary of A − B at least: metres.
    pub(super) distance: L::F,
    pub(super) lower: L::F,
    /// The weights of the second and the third corner in the point nearest to the origin.
    pub(super) weights: [L::F; 2],
}

impl<L: Lanes> Enclosed<L> {
    /// Whether the triangle is the nearest, and what it proves then.
    #[inline(always)]
    pub(super) fn nearest_face(&self, l: L) -> NearestFaces<L> {
        let Self { corners, c, inner, size, slack } = self;
        let one = l.splat(1.0);
        let by_size = l.div(one, *size);
        let [p, q, r] = [
            scaled(l, corners[0], by_size),
            scaled(l, corners[1], by_size),
            scaled(l, corners[2], by_size),
        ];
        let c = scaled(l, *c, by_size);
        let radius = l.mul(l.mul(*inner, by_size), l.splat(RADIUS));
        let [over_pq, over_qr, over_rp] = [
            beyond(l, (c, radius), [q, p]),
            beyond(l, (c, radius), [r, q]),
            beyond(l, (c, radius), [p, r]),
        ];
        let mut others = clearance(l, [q, p, over_pq]);
        for triangle in [
            [r, q, over_qr],
            [p, r, over_rp],
            [p, over_rp, over_pq],
            [q, over_pq, over_qr],
            [r, over_qr, over_rp],
            [over_pq, over_rp, over_qr],
        ] {
            others = l.min(others, clearance(l, triangle));
        }
        let distance = clearance(l, [p, q, r]);
        let is_nearest = l.le(l.sub(distance, l.splat(NEARER * U)), others);
        let off = l.add(l.splat(OFF_SCALED * U), l.mul(l.mul(*slack, by_size), l.splat(2.0)));
        let least = l.mul(l.min(distance, others), l.splat(LENGTH as f32));
        let lower = l.sub(least, off);
        let in_range = l.and(l.lt(l.splat(SIZE.start), *size), l.lt(*size, l.splat(SIZE.end)));
        let holds = l.and(l.and(is_nearest, in_range), l.lt(l.splat(0.0), lower));
        let normal = q.sub(l, p).cross(l, r.sub(l, p));
        let normal = scaled(l, normal, l.div(one, l.sqrt(normal.dot(l, normal))));
        let weights = weights(l, [p, q, r], normal);
        let aside = aside(l, ([p, q, r], weights), scaled(l, normal, distance));
        let holds = l.and(holds, l.le(aside, l.splat(ASIDE * U)));
        let (distance, lower) = (l.mul(distance, *size), l.mul(lower, *size));
        NearestFaces { holds, normal, distance, lower, weights }
    }

    /// Where bounds of the distance along the normal are good enough.
    #[inline(always)]
    pub(super) fn is_good(&self, l: L, distance: L::F, [lower, upper]: [L::F; 2]) -> L::M {
        let error = l.max(l.sub(upper, distance), l.sub(distance, lower));
        l.le(error, l.mul(self.size, l.splat(WORST as f32)))
    }

    /// How far A − B reaches along a vector of length 1, at most, if the supports of its vertices come to that: metres.
    #[inline(always)]
    pub(super) fn upper(&self, l: L, normal: V3<L>, supports: L::F) -> L::F {
        let reach = l.add(supports, self.c.dot(l, normal));
        let off = l.add(l.mul(self.size, l.splat(SEPARATION * U)), self.slack);
        let reach = l.add(reach, l.mul(off, normal.norm1(l)));
        l.mul(reach, l.splat(2.0 - LENGTH as f32))
    }
}

/// k·v.
#[inline(always)]
fn scaled<L: Lanes>(l: L, v: V3<L>, k: L::F) -> V3<L> {
    V3(l.mul(v.0, k), l.mul(v.1, k), l.mul(v.2, k))
}

/// The point of a sphere that is farthest from the plane of its centre and an edge, on the left of the edge as it is seen from the
/// far side: a point that is no number where the three are on a line.
#[inline(always)]
fn beyond<L: Lanes>(l: L, (c, radius): (V3<L>, L::F), [p, q]: [V3<L>; 2]) -> V3<L> {
    let normal = p.sub(l, c).cross(l, q.sub(l, c));
    c.plus(l, l.div(radius, l.sqrt(normal.dot(l, normal))), normal)
}

/// How far a triangle is from the origin at least, along its normal; below 0 where it is not sure that the origin is on its
/// inner side.
#[inline(always)]
fn clearance<L: Lanes>(l: L, [p, q, r]: [V3<L>; 3]) -> L::F {
    let (from_p, from_q) = (p.sub(l, r), q.sub(l, r));
    let normal = from_p.cross(l, from_q);
    let volume = normal.dot(l, r);
    let product = l.mul(l.mul(from_p.norm1(l), from_q.norm1(l)), r.norm1(l));
    let rounding = l.add(l.mul(product, l.splat(DETERMINANT * U)), l.splat(LEAST));
    let lowest = l.min(volume, l.min(normal.dot(l, p), normal.dot(l, q)));
    let distance = l.div(lowest, l.sqrt(normal.dot(l, normal)));
    l.select(l.lt(rounding, volume), distance, l.splat(-1.0))
}

/// The weights of the second and the third corner in the point of a triangle by which a vector leaves it, or the nearest of them
/// that are none below 0.
#[inline(always)]
fn weights<L: Lanes>(l: L, [p, q, r]: [V3<L>; 3], along: V3<L>) -> [L::F; 2] {
    let zero = l.splat(0.0);
    let of_p = l.max(q.cross(l, r).dot(l, along), zero);
    let of_q = l.max(r.cross(l, p).dot(l, along), zero);
    let of_r = l.max(p.cross(l, q).dot(l, along), zero);
    let sum = l.add(of_p, l.add(of_q, of_r));
    [l.div(of_q, sum), l.div(of_r, sum)]
}

/// How far the point of a triangle with these weights is from another one: the 1-norm. No number where the weights are none.
#[inline(always)]
fn aside<L: Lanes>(
    l: L,
    ([p, q, r], [second, third]): ([V3<L>; 3], [L::F; 2]),
    foot: V3<L>,
) -> L::F {
    let point = p.plus(l, second, q.sub(l, p)).plus(l, third, r.sub(l, p));
    point.sub(l, foot).norm1(l)
}
