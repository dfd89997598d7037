//! What a search in f32 proves of a pair's depth, and what f64 makes of its end.

use super::super::bounds::U;
use super::super::cores::Core;
use super::points::Points;
use super::search::{Cloud, LENGTH, OFF, REACH};
use super::surface::{Point, Surface};
use super::vectors::Bits;
use crate::body::Body;
use crate::difference::power_of_two_below_one;
use crate::distance::{gap_along, rounded_up};
use crate::epa::Depth;
use crate::expanding::{Ending, FACING, confirmed_depth, is_inside};
use crate::query::FoundDepth;
use crate::{Accuracy, Difference, PosedShape, PosedSupport, order};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope};
use dcd_simd::{Block, Lanes};

/// A hull with more blocks of vertices is searched in f64. Blocks of sixteen.
pub(super) const BLOCKS: usize = 16;

/// How many faces may be the nearest to f32's knowledge: what is more goes to the search in f64. Two are the rule where
/// edges cross.
const MOST: usize = 8;

/// A bound of f32 above this, relative to the pair's size, is too wide, and so is the way between points that is as far from the
/// normal: the pair is measured in f64. No unit. Larger: worse bounds and points. Smaller: more pairs take microseconds.
pub(super) const WORST: f64 = 8e-6;

/// What the f64 arithmetic of a depth may be off by. Unit: 2⁻⁵³ of the pair's size. Weights 8, the rotations 12 for each
/// shape, differences and the product with the normal 8; and a margin.
const ROUNDED: f64 = 64.0 * crate::UNIT;

/// An object as the search reads it.
#[derive(Clone, Copy)]
pub(super) struct Side<'a> {
    pub(super) core: &'a Core,
    /// Its vertices in the world's axes, round its centre: of a cylinder or cone those of a hull inside it, of which proposals
    /// are made.
    pub(super) blocks: &'a [Block],
    pub(super) placed: PosedShape<'a>,
}

impl<'a> Side<'a> {
    /// Its core, of a polytope, cylinder or cone that the lanes know.
    #[inline(always)]
    fn body(&self) -> Option<Body<'a>> {
        let body = Body::of(self.placed.shape)?;
        let is_known = match body {
            Body::Polytope(_) => (1..=BLOCKS).contains(&self.blocks.len()),
            Body::Curved(_) => true,
        };
        is_known.then_some(body)
    }
}

/// A pair in its order by content, of which the cores are searched.
pub(super) struct SearchedPair<'a> {
    pub(super) cloud: Cloud<'a>,
    bodies: [Body<'a>; 2],
    sides: [PosedShape<'a>; 2],
    is_swapped: bool,
    /// Whether a radius is swept round either: the depth is that of the cores and the radii.
    is_swept: bool,
    /// Metres: the pair's size.
    size: f64,
    /// The difference's lengths by metres: a power of two.
    scale: f64,
}

/// Where a direction leaves A − B.
struct Leaving {
    /// The points of a and of b there, turned but not moved.
    turned: [DVec3; 2],
    /// From that of b to that of a.
    way: DVec3,
}

/// The end of a search.
pub(super) struct Ended<'a> {
    pub(super) surface: &'a Surface,
    pub(super) nearest: usize,
    /// How far A − B reaches along the nearest face's normal, as f32 has it.
    pub(super) reach: f32,
    /// The point where it does.
    pub(super) farthest: Point,
}

impl<'a> SearchedPair<'a> {
    /// `None` of shapes that are not searched, and of pairs outside f32's range.
    #[inline(always)]
    pub(super) fn of([a, b]: [Side<'a>; 2], accuracy: Accuracy) -> Option<Self> {
        let bodies = [a.body()?, b.body()?];
        let is_swept = bodies.iter().any(|body| body.swept_radius() > 0.0);
        let is_searched = match bodies.map(Body::as_polytope) {
            [Some(in_a), Some(in_b)] => !has_formula([in_a, in_b], is_swept, accuracy),
            in_sides => are_searched_by_rims(in_sides, is_swept, accuracy),
        };
        if !is_searched {
            return None;
        }
        let is_swapped = order::is_swapped(a.placed, b.placed);
        let (a, b) = if is_swapped { (b, a) } else { (a, b) };
        let bodies = if is_swapped { [bodies[1], bodies[0]] } else { bodies };
        let poses = [a.placed.pose, b.placed.pose];
        let stretch = [1.0 + poses[0].deviation(), 1.0 + poses[1].deviation()];
        let apart = poses[0].translation() - poses[1].translation();
        let reach = bodies[0].reach() * stretch[0] + bodies[1].reach() * stretch[1];
        let size = reach + apart.abs().element_sum();
        let scale = power_of_two_below_one(size)?;
        (1e-24..1e24).contains(&scale).then_some(())?;
        let centres = *poses[0].rotation() * a.core.centre - *poses[1].rotation() * b.core.centre;
        let middle = (centres + apart) * scale;
        let outer = (a.core.outer * stretch[0] + b.core.outer * stretch[1]) * scale;
        let m = outer + middle.abs().element_sum();
        // Much above 1 only for shapes far from their own origins; far below, f64 sees more than f32.
        (2f64.powi(-20)..4.0).contains(&m).then_some(())?;
        let [body_a, body_b] = bodies;
        let cloud = Cloud {
            points: [
                Points::of(body_a, (poses[0].rotation(), a.core.centre), a.blocks),
                Points::of(body_b, (poses[1].rotation(), b.core.centre), b.blocks),
            ],
            scale: scale as f32,
            middle: middle.as_vec3(),
            unit: U * (m as f32 * (1.0 + 4.0 * U)),
        };
        let sides = [a.placed, b.placed];
        Some(Self { cloud, bodies, sides, is_swapped, is_swept, size, scale })
    }

    /// What is of a and of b, in the order of the search.
    #[inline(always)]
    pub(super) fn in_order<T>(&self, [a, b]: [T; 2]) -> [T; 2] {
        if self.is_swapped { [b, a] } else { [a, b] }
    }

    /// Whether they are polytopes of which one has a radius: their cores may be apart, and f64 is the one to say so.
    #[inline(always)]
    pub(super) fn has_swept_polytopes(&self) -> bool {
        self.is_swept && !self.cloud.is_round()
    }

    /// How well the search and its end have to know the depth. The cores of swept polytopes are measured in f64 even where
    /// f32 would do: the bounds are those of the search that they have pair by pair.
    #[inline(always)]
    pub(super) fn sharpened(&self, accuracy: Accuracy) -> Accuracy {
        let is_sharpened = self.has_swept_polytopes() && accuracy == Accuracy::F32;
        if is_sharpened { Accuracy::F64 } else { accuracy }
    }

    /// The depth, known as well as the accuracy requires.
    #[inline(always)]
    pub(super) fn depth<L: Lanes>(
        &self,
        l: L,
        accuracy: Accuracy,
        ended: &Ended<'_>,
    ) -> Option<FoundDepth> {
        let unit = f64::from(self.cloud.unit);
        let off = OFF * unit;
        let least = f64::from(ended.surface.distance(ended.nearest));
        let limit = least + 2.0 * off;
        // Rounded down: what is beyond is farther than the limit.
        let near = Bits(ended.surface.within(l, (limit as f32).next_up()));
        let holds_origin =
            least * LENGTH > off && all_inward(ended.surface, ended.surface.doubtful(l));
        let found = match self.sharpened(accuracy) {
            Accuracy::F32 => {
                let lower = if holds_origin { least * LENGTH - off } else { 0.0 };
                let farthest = self.vertices(&ended.farthest);
                let depth = match farthest {
                    Some(_) => {
                        let upper = f64::from(ended.reach) * (2.0 - LENGTH) + REACH * unit;
                        self.bounded(ended, near, [lower, upper])?
                    }
                    None => self.by_reach(ended, near, lower)?,
                };
                FoundDepth { depth, farthest }
            }
            accuracy => {
                let others = holds_origin.then_some(limit * LENGTH - off);
                self.confirmed(accuracy, ended.surface, near, others)?
            }
        };
        Some(if self.is_swapped { found.mirrored() } else { found })
    }

    /// Prefetches what is around the vertices of a and of b that make a point.
    #[inline(always)]
    pub(super) fn prefetch_half_edges(&self, point: &Point) {
        if let (Some([a, b]), Some([of_a, of_b])) = (self.polytopes(), self.vertices(point)) {
            a.prefetch_half_edges(of_a);
            b.prefetch_half_edges(of_b);
        }
    }

    /// Both, if they are polytopes.
    #[inline(always)]
    fn polytopes(&self) -> Option<[&'a Polytope; 2]> {
        let [a, b] = self.bodies;
        Some([a.as_polytope()?, b.as_polytope()?])
    }

    /// The vertices of a and of b that make a point, if both are polytopes.
    #[inline(always)]
    fn vertices(&self, point: &Point) -> Option<[u32; 2]> {
        let ([a, b], [of_a, of_b]) = (self.polytopes()?, point.numbers);
        // The last block is filled up with the last vertex.
        let last = |polytope: &Polytope| polytope.vertices().len() as u32 - 1;
        Some([of_a.min(last(a)), of_b.min(last(b))])
    }

    /// Measures the faces that may be the nearest in f64.
    fn confirmed(
        &self,
        accuracy: Accuracy,
        surface: &Surface,
        near: Bits,
        others: Option<f64>,
    ) -> Option<FoundDepth> {
        let mut faces = [[[0; 2]; 3]; MOST];
        let mut count = 0;
        for face in near {
            *faces.get_mut(count)? = surface.corners(face).map(|corner| corner.numbers);
            count += 1;
        }
        let ([a, b], [of_a, of_b]) = (self.polytopes()?, self.sides);
        let bodies = [PosedSupport::polytope(a, of_a.pose), PosedSupport::polytope(b, of_b.pose)];
        let difference = Difference::new(bodies[0], bodies[1])?;
        confirmed_depth(difference, bodies, accuracy, &Ending { faces: &faces[..count], others })
    }

    /// The depth along the nearest face's normal, with f32's bounds of it.
    #[inline(always)]
    fn bounded(&self, ended: &Ended<'_>, near: Bits, [lower, upper]: [f64; 2]) -> Option<Depth> {
        let normal = ended.surface.normal(ended.nearest).as_dvec3().try_normalize()?;
        let leaving = self.leaving_along(ended, near, normal)?;
        let depth = normal.dot(leaving.way).max(0.0);
        let (lower, upper) = (lower / self.scale, upper / self.scale);
        self.found((normal, depth), (upper - depth).max(depth - lower), &leaving)
    }

    /// The same of a pair of which one is a cylinder or cone: how far A − B reaches along that normal is known in f64, and the
    /// depth is no less than f32's bound from below, that of the cores and their radii. `None` where only the radii may overlap.
    fn by_reach(&self, ended: &Ended<'_>, near: Bits, lower: f64) -> Option<Depth> {
        let ([a, b], radii) = (self.sides, self.bodies.map(Body::swept_radius));
        if self.is_swept && !(lower > 0.0) {
            return None;
        }
        let normal = ended.surface.normal(ended.nearest).as_dvec3().try_normalize()?;
        let leaving = self.leaving_along(ended, near, normal)?;
        let (depth, swept) = ((-gap_along(a, b, normal)?).max(0.0), radii[0] + radii[1]);
        let of_cores = depth - swept;
        let found = self.found((normal, of_cores), of_cores - lower / self.scale, &leaving)?;
        Some(Depth {
            depth,
            point_a: found.point_a + normal * radii[0],
            point_b: found.point_b - normal * radii[1],
            ..found
        })
    }

    /// Where the nearest face's normal leaves the surface.
    #[inline(always)]
    fn leaving_along(&self, ended: &Ended<'_>, near: Bits, normal: DVec3) -> Option<Leaving> {
        let along = ended.surface.normal(ended.nearest);
        // The face by which the normal leaves the surface.
        let mut best = (f32::NEG_INFINITY, ended.nearest);
        for face in near {
            let [p, q, r] = ended.surface.corners(face).map(|corner| corner.at);
            // Seen edge on, the volumes are rounding.
            let area = (q - p).cross(r - p);
            if !(area.dot(along) > FACING as f32 * area.length() * along.length()) {
                continue;
            }
            let volumes = [q.cross(r).dot(along), r.cross(p).dot(along), p.cross(q).dot(along)];
            let [x, y, z] = volumes;
            let least = x.min(y).min(z) / (x + y + z);
            if least > best.0 {
                best = (least, face);
            }
        }
        self.leaving(ended.surface.corners(best.1), normal)
    }

    /// The depth of the cores along a normal, off by so much but for the arithmetic in f64, if that is good enough.
    #[inline(always)]
    fn found(&self, (normal, depth): (DVec3, f64), error: f64, leaving: &Leaving) -> Option<Depth> {
        let error_bound = rounded_up(error.max(0.0) + ROUNDED * self.size);
        // Where the normal leaves by none of these faces, the points are beside it.
        let is_along = (leaving.way - normal * depth).length() <= WORST * self.size;
        let is_good = is_along && error_bound <= WORST * self.size && normal.is_finite();
        let [a, b] = self.sides;
        is_good.then(|| Depth {
            depth,
            normal,
            point_a: a.pose.translation() + leaving.turned[0],
            point_b: b.pose.translation() + leaving.turned[1],
            error_bound,
        })
    }

    /// Where a direction leaves a triangle of A − B.
    #[inline(always)]
    fn leaving(&self, corners: [Point; 3], direction: DVec3) -> Option<Leaving> {
        let [pose_a, pose_b] = [self.sides[0].pose, self.sides[1].pose];
        let apart = pose_a.translation() - pose_b.translation();
        let (mut of_a, mut of_b, mut world) =
            ([DVec3::ZERO; 3], [DVec3::ZERO; 3], [DVec3::ZERO; 3]);
        for k in 0..3 {
            let [a, b] = corners[k].numbers;
            of_a[k] = *pose_a.rotation() * self.bodies[0].point(a);
            of_b[k] = *pose_b.rotation() * self.bodies[1].point(b);
            world[k] = ((of_a[k] - of_b[k]) + apart) * self.scale;
        }
        let [p, q, r] = world;
        let volumes = DVec3::new(
            q.cross(r).dot(direction),
            r.cross(p).dot(direction),
            p.cross(q).dot(direction),
        );
        let weights = volumes.max(DVec3::ZERO);
        let sum = weights.element_sum();
        if !(sum > 0.0) {
            return None;
        }
        let weights = weights / sum;
        let DVec3 { x, y, z } = weights;
        let mean_a = of_a[0] * x + of_a[1] * y + of_a[2] * z;
        let mean_b = of_b[0] * x + of_b[1] * y + of_b[2] * z;
        Some(Leaving { turned: [mean_a, mean_b], way: (mean_a - mean_b) + apart })
    }
}

/// Whether the lanes search a pair of which one is a cylinder or cone, by its rims; of the others their polytopes are given. Not of
/// one with a swept point: that has a formula.
#[inline(always)]
fn are_searched_by_rims(
    polytopes: [Option<&Polytope>; 2],
    is_swept: bool,
    accuracy: Accuracy,
) -> bool {
    let has_point = polytopes.into_iter().flatten().any(|polytope| polytope.kind() == Kind::Point);
    accuracy == Accuracy::F32 && !(is_swept && has_point)
}

/// Whether two polytopes have a closed form: two cuboids; if a radius is swept round one also points and segments, and at
/// the accuracy of f32 a point and any other.
#[inline(always)]
pub(super) fn has_formula(polytopes: [&Polytope; 2], is_swept: bool, accuracy: Accuracy) -> bool {
    let [one, other] = polytopes.map(Polytope::kind);
    if is_swept && accuracy == Accuracy::F32 && (one == Kind::Point || other == Kind::Point) {
        return true;
    }
    [one, other].iter().all(|kind| match kind {
        Kind::Cuboid { .. } => true,
        Kind::Point | Kind::Segment => is_swept,
        _ => false,
    })
}

/// Whether every face surely has the origin on its inner side: f64 looks at those that f32 is not sure of.
fn all_inward(surface: &Surface, doubtful: u64) -> bool {
    Bits(doubtful).all(|face| is_inside(surface.corners(face).map(|point| point.at.as_dvec3())))
}
