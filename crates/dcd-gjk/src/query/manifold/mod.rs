//! Where touching pairs touch: up to four points of the patch that they share.
//!
//! The normal is that of the depth. Each shape shows a feature along it: a face that looks almost
//! that way, else an edge almost square to it, else a vertex. Seen along the normal, the two
//! features are polygons of a plane; what they have in common is clipped, every corner of it being
//! a point of both features, one above the other, and so with a depth of its own. Of the corners
//! that are at least 0 deep, the deepest is kept, and three that span the most.

mod clip;
mod feature;
mod reduce;

use super::{Accuracy, MeasureAt, depths};
use crate::epa::{self, Depth};
use crate::{Depths, Method, PairSolver, PosedShape, Verdict, order};
use clip::{Corner, Patch};
use dcd_geom::glam::DVec3;
use feature::View;

/// The points where two objects touch. World frame, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Manifold {
    /// From a to b, of unit length: the direction of the [`Depth`].
    pub normal: DVec3,
    points: [ManifoldPoint; 4],
    count: u8,
    /// How far a point may be outside its object, and its depth off what the objects are there:
    /// metres. The depth's own bound, and how flat a face is, about 1e-8 of the objects' size.
    pub error_bound: f64,
}

/// A point where two objects touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManifoldPoint {
    /// Of a's surface.
    pub point_a: DVec3,
    /// Of b's surface: `point_a − point_b` is `normal·depth`.
    pub point_b: DVec3,
    /// How deep the objects overlap here along the normal: at least 0, at most the pair's depth,
    /// and that at the first point.
    pub depth: f64,
    /// What of a it belongs to, and what of b: the same as long as the same features meet, so that
    /// a point is known again in the next frame.
    pub features: [Feature; 2],
}

/// A part of a polytope, by index into its vertices or [`dcd_geom::Facets`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Feature {
    /// The whole, for shapes that have no vertices.
    #[default]
    Surface,
    /// A vertex.
    Vertex(u32),
    /// Between two vertices, the smaller index first.
    Edge(u32, u32),
    /// A face.
    Face(u32),
}

impl Manifold {
    /// One to four, the deepest first.
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points[..usize::from(self.count)]
    }

    /// The same with a and b exchanged.
    fn mirrored(mut self) -> Self {
        for point in &mut self.points {
            (point.point_a, point.point_b) = (point.point_b, point.point_a);
            point.features.reverse();
        }
        Self { normal: -self.normal, ..self }
    }
}

/// The contact manifold of touching pairs: see [`Manifold`].
///
/// Between polytopes, rounded or not, up to four points; with any other shape the one point of the
/// [`Depth`]. Costs [`Depths`], two passes over each polytope's faces, and for each polytope once
/// a microsecond a vertex to find them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Manifolds;

/// What a thread reuses from pair to pair.
#[derive(Debug, Default)]
pub struct Scratch {
    depth: epa::Scratch,
    patch: Patch,
}

impl PairSolver for Manifolds {
    type Answer = Manifold;
    type Scratch = Scratch;

    fn method(&self) -> Method {
        Depths.method()
    }

    fn solve(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Scratch,
    ) -> Verdict<Manifold> {
        self.settle(a, b, scratch).0
    }

    fn measure(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Scratch,
    ) -> Verdict<Manifold> {
        self.measure_at(Accuracy::Certified, a, b, scratch)
    }

    fn settle(
        &self,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Scratch,
    ) -> (Verdict<Manifold>, Method) {
        let (verdict, method) = Depths.settle(a, b, &mut scratch.depth);
        (told(verdict, a, b, &mut scratch.patch), method)
    }
}

impl MeasureAt for Manifolds {
    fn measure_at(
        &self,
        accuracy: Accuracy,
        a: PosedShape<'_>,
        b: PosedShape<'_>,
        scratch: &mut Scratch,
    ) -> Verdict<Manifold> {
        let depth = depths::of_touching(accuracy, a, b, &mut scratch.depth);
        told(depth, a, b, &mut scratch.patch)
    }
}

fn told(
    verdict: Verdict<Depth>,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    patch: &mut Patch,
) -> Verdict<Manifold> {
    match verdict {
        Verdict::Apart => Verdict::Apart,
        Verdict::Undecided(reason) => Verdict::Undecided(reason),
        Verdict::Touching(depth) if order::is_swapped(a, b) => {
            Verdict::Touching(in_order(depth.mirrored(), b, a, patch).mirrored())
        }
        Verdict::Touching(depth) => Verdict::Touching(in_order(depth, a, b, patch)),
    }
}

/// How far from the witnesses' depth the deepest corner may be to stand for it, relative to the
/// shapes' size: faces are flat to a billionth. Larger: a deepest point that is not the deepest.
const SAME: f64 = 1e-9;

/// How flat the faces are, and how far two parallel edges may lean, as a part of the error bound;
/// relative to the shapes' size.
const FLAT: f64 = 1e-8;

fn in_order(depth: Depth, a: PosedShape<'_>, b: PosedShape<'_>, patch: &mut Patch) -> Manifold {
    let (Some(in_a), Some(in_b)) = (a.shape.as_polytope(), b.shape.as_polytope()) else {
        return of_one_point(depth, [Feature::Surface; 2]);
    };
    // World axes, counted from a's origin: what is far from the world's is none the worse.
    let view = View::along(depth.normal);
    let delta = b.pose.translation() - a.pose.translation();
    let seen_a = view.seen(in_a, a.pose.rotation(), DVec3::ZERO, 1.0);
    let seen_b = view.seen(in_b, b.pose.rotation(), delta, -1.0);
    let size = 2.0 * (in_a.outer_radius() + in_b.outer_radius());
    let radii = [in_a.swept_radius(), in_b.swept_radius()];
    let radius = radii[0] + radii[1];
    patch.of(&seen_a, &seen_b, -radius, size);

    let features = [seen_a.whole(), seen_b.whole()];
    let witness = of_one_point(depth, features);
    let error_bound = (depth.error_bound
        + FLAT * size
        + 8.0 * f64::EPSILON * (a.pose.translation().length() + b.pose.translation().length()))
    .min(f64::MAX);
    let deepest = patch.corners().iter().map(Corner::depth).fold(f64::NEG_INFINITY, f64::max);
    // False for NaN, which numbers near the end of their range make.
    let stands_for_all = deepest + radius >= depth.depth - SAME * size;
    let Some((kept, count)) = reduce::to_four(patch.corners()).filter(|_| stands_for_all) else {
        return Manifold { error_bound, ..witness };
    };
    let mut points = [ManifoldPoint::default(); 4];
    for (point, corner) in points.iter_mut().zip(&kept[..count]) {
        let [core_a, core_b] =
            corner.heights.map(|z| view.in_world(corner.at, z) + a.pose.translation());
        *point = ManifoldPoint {
            point_a: core_a + depth.normal * radii[0],
            point_b: core_b - depth.normal * radii[1],
            depth: (corner.depth() + radius).clamp(0.0, depth.depth),
            features: corner.features,
        };
    }
    points[0].depth = depth.depth;
    Manifold { normal: depth.normal, points, count: count as u8, error_bound }
}

/// The witnesses of the depth alone.
fn of_one_point(depth: Depth, features: [Feature; 2]) -> Manifold {
    let Depth { depth, normal, point_a, point_b, error_bound } = depth;
    let mut points = [ManifoldPoint::default(); 4];
    points[0] = ManifoldPoint { point_a, point_b, depth, features };
    Manifold { normal, points, count: 1, error_bound }
}
