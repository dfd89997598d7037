//! What a search in f32 proves of a pair's depth, and what f64 makes of its end.

use super::super::bounds::U;
use super::super::cores::Core;
use super::search::{Cloud, LENGTH, OFF, REACH};
use super::surface::{Point, Surface};
use super::vectors::Bits;
use crate::difference::power_of_two_below_one;
use crate::distance::rounded_up;
use crate::epa::Depth;
use crate::expanding::{Ending, FACING, confirmed_depth, is_inside};
use crate::query::FoundDepth;
use crate::{Accuracy, Difference, PosedShape, PosedSupport, order};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Pose};
use dcd_simd::{Block, Lanes};

/// A hull with more blocks of vertices is searched in f64. Blocks of sixteen.
const BLOCKS: usize = 16;

/// How many faces may be the nearest to f32's knowledge: what is more goes to the search in f64. Two are the rule where
/// edges cross.
const MOST: usize = 8;

/// A bound of f32 above this, relative to the pair's size, is too wide, and so is the way between points that is as far from the
/// normal: the pair is measured in f64. No unit. Larger: worse bounds and points. Smaller: more pairs take microseconds.
pub(super) const WORST: f64 = 8e-6;

/// What the f64 arithmetic of a depth may be off by. Unit: 2⁻⁵³ of the pair's size. Weights 8, the rotations 12 for each
/// shape, differences and the product with the normal 8; and a margin.
const ROUNDED: f64 = 64.0 * f64::EPSILON / 2.0;

/// An object as the search reads it.
#[derive(Clone, Copy)]
pub(super) struct Side<'a> {
    pub(super) core: &'a Core,
    /// Its vertices in the world's axes, round its centre.
    pub(super) blocks: &'a [Block],
    pub(super) placed: PosedShape<'a>,
}

impl<'a> Side<'a> {
    /// Its core, of a polytope that the lanes know.
    #[inline(always)]
    fn polytope(&self) -> Option<&'a Polytope> {
        let polytope = self.placed.shape.as_polytope()?;
        (1..=BLOCKS).contains(&self.blocks.len()).then_some(polytope)
    }
}

/// A pair of polytopes in its order by content, of which the cores are searched.
pub(super) struct SearchedPair<'a> {
    pub(super) cloud: Cloud<'a>,
    polytopes: [&'a Polytope; 2],
    poses: [&'a Pose; 2],
    is_swapped: bool,
    /// Whether a radius is swept round either: the depth is that of the cores and the radii.
    is_swept: bool,
    /// Metres: the pair's size.
    size: f64,
    /// The difference's lengths by metres: a power of two.
    scale: f64,
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
        let polytopes = [a.polytope()?, b.polytope()?];
        let is_swept = polytopes.iter().any(|polytope| polytope.swept_radius() > 0.0);
        if has_formula(polytopes, is_swept, accuracy) {
            return None;
        }
        let is_swapped = order::is_swapped(a.placed, b.placed);
        let (a, b) = if is_swapped { (b, a) } else { (a, b) };
        let polytopes = if is_swapped { [polytopes[1], polytopes[0]] } else { polytopes };
        let poses = [a.placed.pose, b.placed.pose];
        let stretch = [1.0 + poses[0].deviation(), 1.0 + poses[1].deviation()];
        let apart = poses[0].translation() - poses[1].translation();
        let reach = polytopes[0].reach() * stretch[0] + polytopes[1].reach() * stretch[1];
        let size = reach + apart.abs().element_sum();
        let scale = power_of_two_below_one(size)?;
        (1e-24..1e24).contains(&scale).then_some(())?;
        let centres = *poses[0].rotation() * a.core.centre - *poses[1].rotation() * b.core.centre;
        let middle = (centres + apart) * scale;
        let outer = (a.core.outer * stretch[0] + b.core.outer * stretch[1]) * scale;
        let m = outer + middle.abs().element_sum();
        // Much above 1 only for shapes far from their own origins; far below, f64 sees more than f32.
        (2f64.powi(-20)..4.0).contains(&m).then_some(())?;
        let cloud = Cloud {
            blocks: [a.blocks, b.blocks],
            scale: scale as f32,
            middle: middle.as_vec3(),
            unit: U * (m as f32 * (1.0 + 4.0 * U)),
        };
        Some(Self { cloud, polytopes, poses, is_swapped, is_swept, size, scale })
    }

    /// What is of a and of b, in the order of the search.
    #[inline(always)]
    pub(super) fn in_order<T>(&self, [a, b]: [T; 2]) -> [T; 2] {
        if self.is_swapped { [b, a] } else { [a, b] }
    }

    /// Whether the depth is that of the cores and the radii: without one the cores may be apart.
    #[inline(always)]
    pub(super) fn is_swept(&self) -> bool {
        self.is_swept
    }

    /// How well the search and its end have to know the depth. The cores of swept polytopes are measured in f64 even where
    /// f32 would do: the bounds are those of the search that they have pair by pair.
    #[inline(always)]
    pub(super) fn sharpened(&self, accuracy: Accuracy) -> Accuracy {
        if self.is_swept && accuracy == Accuracy::F32 { Accuracy::F64 } else { accuracy }
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
                let upper = f64::from(ended.reach) * (2.0 - LENGTH) + REACH * unit;
                let depth = self.bounded(ended, near, [lower, upper])?;
                FoundDepth { depth, farthest: Some(self.vertices(&ended.farthest)) }
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
        for (polytope, vertex) in self.polytopes.into_iter().zip(self.vertices(point)) {
            polytope.prefetch_half_edges(vertex);
        }
    }

    /// The vertices of a and of b that make a point.
    #[inline(always)]
    fn vertices(&self, point: &Point) -> [u32; 2] {
        let [of_a, of_b] = point.vertices;
        // The last block is filled up with the last vertex.
        let last = |polytope: &Polytope| polytope.vertices().len() as u32 - 1;
        let [a, b] = self.polytopes;
        [of_a.min(last(a)), of_b.min(last(b))]
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
            *faces.get_mut(count)? = surface.corners(face).map(|corner| corner.vertices);
            count += 1;
        }
        let [a, b] = self.polytopes;
        let bodies =
            [PosedSupport::polytope(a, self.poses[0]), PosedSupport::polytope(b, self.poses[1])];
        let difference = Difference::new(bodies[0], bodies[1])?;
        confirmed_depth(difference, bodies, accuracy, &Ending { faces: &faces[..count], others })
    }

    /// The depth along the nearest face's normal, with f32's bounds of it.
    #[inline(always)]
    fn bounded(&self, ended: &Ended<'_>, near: Bits, [lower, upper]: [f64; 2]) -> Option<Depth> {
        let along = ended.surface.normal(ended.nearest);
        let normal = along.as_dvec3().try_normalize()?;
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
        let [turned_a, turned_b] = self.leaving(ended.surface.corners(best.1), normal)?;
        let [t_a, t_b] = [self.poses[0].translation(), self.poses[1].translation()];
        let way = (turned_a - turned_b) + (t_a - t_b);
        let depth = normal.dot(way).max(0.0);
        let (lower, upper) = (lower / self.scale, upper / self.scale);
        let error_bound = rounded_up((upper - depth).max(depth - lower) + ROUNDED * self.size);
        // Where the normal leaves by none of these faces, the points are beside it.
        let is_along = (way - normal * depth).length() <= WORST * self.size;
        let is_good = is_along && error_bound <= WORST * self.size && normal.is_finite();
        is_good.then(|| Depth {
            depth,
            normal,
            point_a: t_a + turned_a,
            point_b: t_b + turned_b,
            error_bound,
        })
    }

    /// The points of a and of b, turned but not moved, where a direction leaves a triangle of A − B.
    #[inline(always)]
    fn leaving(&self, corners: [Point; 3], direction: DVec3) -> Option<[DVec3; 2]> {
        let [turn_a, turn_b] = [self.poses[0].rotation(), self.poses[1].rotation()];
        let apart = self.poses[0].translation() - self.poses[1].translation();
        let (mut of_a, mut of_b, mut world) =
            ([DVec3::ZERO; 3], [DVec3::ZERO; 3], [DVec3::ZERO; 3]);
        for k in 0..3 {
            let [a, b] = corners[k].vertices;
            of_a[k] = *turn_a * vertex(self.polytopes[0], a);
            of_b[k] = *turn_b * vertex(self.polytopes[1], b);
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
        Some([mean_a, mean_b])
    }
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

/// That vertex: the last block is filled up with the last one.
#[inline(always)]
fn vertex(polytope: &Polytope, number: u32) -> DVec3 {
    let vertices = polytope.vertices();
    vertices[(number as usize).min(vertices.len() - 1)]
}

/// Whether every face surely has the origin on its inner side: f64 looks at those that f32 is not sure of.
fn all_inward(surface: &Surface, doubtful: u64) -> bool {
    Bits(doubtful).all(|face| is_inside(surface.corners(face).map(|point| point.at.as_dvec3())))
}
