//! Penetration depth in f64: the expanding polytope with floating-point numbers, and a bound that holds
//! whatever they lost on the way.
//!
//! As in [`epa`](crate::epa) a polytope inside A − B grows towards the face nearest the origin; here its planes
//! are rounded, and nothing is believed of them. When the search ends the surface is looked at as it
//! is: it is closed, since it only ever loses a patch and gains the cone over the patch's boundary. If
//! every triangle surely has the origin on its inner side, the surface winds round it, and the sphere
//! that reaches the nearest triangle is inside A − B: a lower bound (docs/numerics/proofs.md, "Depth in f64").
//! The reach along any direction is an upper one. Where f64 leaves too much of a certified depth open, the nearest faces
//! are measured again in double-double. A search that ends without a good bound returns nothing, and the caller runs the
//! exact one.
//!
//! Works on support maps, so that cylinders, cones and foreign shapes need no sampling. Where a core is a cylinder, a cone or an
//! ellipsoid, Newton's method ends the search (`least_reach`), and its end is proved by [`local_bound`].

mod confirm;
mod least_reach;
mod local_bound;
mod pieces;
mod shallow;
mod surface;
mod swept;
#[cfg(test)]
mod tests;

use crate::UNIT;
use crate::certificate::Bounds;
use crate::closed::curved;
use crate::distance::{Approach, approach, proposed, rounded_up};
use crate::epa::Depth;
use crate::gjk::unit;
use crate::query::{Accuracy, FoundDepth};
use crate::supports::{InBlocks, lowest};
use crate::{Difference, PosedShape, PosedSupport, Vertex, order};
use confirm::is_certified;
pub(crate) use confirm::{Ending, FACING, confirmed_depth};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Shape};
pub(crate) use surface::{Surface, is_inside};
pub(crate) use swept::depth_of_apart;

/// How often the polytope may grow: hulls of tens of vertices need ten, a cylinder against a cone a
/// hundred. Smaller: more pairs of finely cut or curved shapes left to the exact search.
const GROWTHS: usize = 256;

/// How far the first tetrahedron must be from flat, relative to the pair's size: 2⁻²⁰, so that its planes
/// mean something. Smaller: more sliver faces. Larger: more thin pairs left to the exact search.
const FAT: f64 = 1.0 / (1u64 << 20) as f64;

/// What is promised of the depth of curved shapes, relative to it: a surface of points on both ends in triangles
/// so small that rounding tilts them. Smaller: more pairs left to the search by samples.
const CURVED: f64 = 1e-9;

/// When a search ends, and what its bound may be.
#[derive(Clone, Copy, Debug)]
struct Tolerance {
    /// Relative to the depth.
    relative: f64,
    /// Relative to the pair's size.
    of_size: f64,
    /// Relative to the depth, where the search ends by itself.
    at_end: f64,
    /// The least depth, relative to the pair's size.
    least: f64,
}

/// A certified depth of polytopes below this part of the pair's size is measured in double-double, or searched exactly:
/// what f64's roundings of some u of the size leave of it is more than the exact search's 2⁻⁴² of the depth. Larger: more
/// pairs that take microseconds more. Smaller: shallow depths with fewer digits.
pub(crate) const SHALLOW: f64 = 1.0 / 512.0;

impl Tolerance {
    fn of(accuracy: Accuracy) -> Self {
        match accuracy {
            // A tenth of what the best f32 lanes are promised to reach.
            Accuracy::F32 => Self { relative: 0.0, of_size: 1e-6, at_end: 0.0, least: 0.0 },
            Accuracy::F64 => {
                Self { relative: 1e-10, of_size: 256.0 * UNIT, at_end: 1e-10, least: 0.0 }
            }
            Accuracy::Certified => Self { least: SHALLOW, ..Self::of(Accuracy::F64) },
        }
    }

    /// Lengths of a difference, which is no larger than 1.
    fn admits(self, error: f64, depth: f64) -> bool {
        error <= self.of_size.max(self.relative * depth)
    }

    /// Whether the bound of a search that has ended is good enough.
    fn admits_at_end(self, error: f64, depth: f64) -> bool {
        error <= self.of_size.max(self.at_end * depth)
    }

    /// Whether a depth and its bound are good enough.
    fn is_met(self, depth: f64, error: f64) -> bool {
        depth >= self.least && self.admits_at_end(error, depth)
    }

    /// For curved shapes: what the search that would come next gives, a hundred times as slow.
    fn of_curved(self) -> Self {
        Self { at_end: CURVED.max(self.at_end), least: 0.0, ..self }
    }
}

/// How deep two convex shapes overlap that are known to touch; `None` where f64 finds no bound as good
/// as the accuracy requires, and for shapes without a support map. Where no formula tells and no radii alone overlap, `in_lanes` is
/// asked first.
///
/// (a, b) and (b, a) give the same bits, mirrored, if they do of `in_lanes`.
pub(crate) fn depth_of_overlap(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    accuracy: Accuracy,
    surface: &mut Surface,
    in_lanes: impl FnOnce([PosedShape<'_>; 2]) -> Option<FoundDepth>,
) -> Option<FoundDepth> {
    let has_support = |shape: &Shape| shape.is_convex() && shape.is_bounded();
    if !has_support(a.shape) || !has_support(b.shape) {
        return None;
    }
    let tolerance = Tolerance::of(accuracy);
    let swapped = order::is_swapped(a, b);
    let (a, b) = if swapped { (b, a) } else { (a, b) };
    let found = match (a.shape, b.shape) {
        (Shape::Polytope(in_a), Shape::Polytope(in_b)) => depth_of_polytopes(
            [PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose)],
            accuracy,
            surface,
            || in_lanes([a, b]),
        ),
        _ => {
            let bodies =
                [PosedSupport::shape(a.shape, a.pose), PosedSupport::shape(b.shape, b.pose)];
            let tolerance = tolerance.of_curved();
            let of_centre = curved::depth_of_centre(a, b, [tolerance.relative, tolerance.of_size]);
            of_centre.map(FoundDepth::from).or_else(|| {
                let points = curved::nearest_points(a, b).map(|found| found.points);
                // For f32's few digits the points of the surface cost no more.
                let finish: Option<Finish<Shape>> = match accuracy {
                    Accuracy::F32 => None,
                    _ => Some(by_pieces),
                };
                let in_lanes = || in_lanes([a, b]);
                of_supports(bodies, tolerance, points, in_lanes, (surface, finish))
            })
        }
    }?;
    Some(if swapped { found.mirrored() } else { found })
}

/// What may prove a depth before the surface is fine, from the vertices of its nearest face and the best direction so far.
type Finish<S> = fn(
    &ExpandingSearch<'_, S>,
    &Bounds<f64>,
    &Surface,
    (&[Vertex<f64>; 3], DVec3),
) -> Option<Depth>;

/// See [`ExpandingSearch::by_pieces`].
fn by_pieces(
    search: &ExpandingSearch<'_, Shape>,
    bounds: &Bounds<f64>,
    surface: &Surface,
    from: (&[Vertex<f64>; 3], DVec3),
) -> Option<Depth> {
    search.by_pieces(bounds, surface, from)
}

/// Of cores that may overlap what is quicker `first`.
fn of_supports<S: InBlocks>(
    bodies: [PosedSupport<'_, S>; 2],
    tolerance: Tolerance,
    points: Option<[DVec3; 2]>,
    first: impl FnOnce() -> Option<FoundDepth>,
    (surface, finish): (&mut Surface, Option<Finish<S>>),
) -> Option<FoundDepth> {
    let [a, b] = bodies;
    let difference = Difference::new(a, b)?;
    let search = ExpandingSearch { difference, bodies, tolerance };
    let bounds = Bounds::of(&search.difference);
    if bounds.radius() > 0.0 {
        let known = points.and_then(|points| proposed(&search.difference, &bounds, 0.0, points));
        let mut near = known.unwrap_or_else(|| Approach::begin(&search.difference));
        let is_found =
            known.is_some() || approach(&search.difference, &bounds, 0.0, &mut near).is_ok();
        if is_found {
            // Where they may overlap, by no more than that direction shows: its bound counts it.
            let found = search.of_nearest_points(&bounds, &near);
            if near.lower > 0.0 || found.is_some() {
                return found.map(FoundDepth::from);
            }
        }
    }
    first().or_else(|| search.of_overlapping_cores(&bounds, surface, finish).map(FoundDepth::from))
}

/// [`depth_of_overlap`] of polytopes in the order that they are given in: where f64 leaves too much open, in double-double.
fn depth_of_polytopes(
    bodies: [PosedSupport<'_, Polytope>; 2],
    accuracy: Accuracy,
    surface: &mut Surface,
    in_lanes: impl FnOnce() -> Option<FoundDepth>,
) -> Option<FoundDepth> {
    let tolerance = Tolerance::of(accuracy);
    let found = of_supports(bodies, tolerance, None, in_lanes, (&mut *surface, None));
    let found = found.filter(|found| are_along(&found.depth, bodies));
    let is_sharp = bodies.iter().all(|body| body.map.swept_radius() == 0.0);
    if accuracy != Accuracy::Certified || !is_sharp {
        return found;
    }
    found.filter(|found| is_certified(&found.depth)).or_else(|| {
        let difference = Difference::new(bodies[0], bodies[1])?;
        let search = ExpandingSearch { difference, bodies, tolerance: Tolerance::of(accuracy) };
        let found = search.depth_by_surface(&Bounds::of(&search.difference), surface);
        found.map(FoundDepth::from)
    })
}

/// How far the points of a depth may be from differing by it along its normal, relative to the pair's size: the end of a search that
/// did not come round the origin may be far from them. Larger: points beside the objects. Smaller: more pairs that are searched exactly.
const ASIDE: f64 = 1e-5;

/// Whether they are no farther, but for what rounding takes of their places.
fn are_along(found: &Depth, bodies: [PosedSupport<'_, Polytope>; 2]) -> bool {
    let reach = bodies.iter().map(|body| body.map.reach() + body.map.swept_radius()).sum::<f64>();
    let far = bodies.iter().map(|body| body.pose.translation().length()).sum::<f64>();
    found.missed() <= ASIDE * reach + 16.0 * UNIT * far
}

struct ExpandingSearch<'a, S> {
    difference: Difference<'a, f64, S, S>,
    bodies: [PosedSupport<'a, S>; 2],
    tolerance: Tolerance,
}

impl<S: InBlocks> ExpandingSearch<'_, S> {
    /// Only what is swept round them overlaps, or hardly more: the radii, less the cores' distance, which is between its bounds;
    /// the lower one is negative by as much as cores overlap at most.
    fn of_nearest_points(&self, bounds: &Bounds<f64>, near: &Approach) -> Option<Depth> {
        let depth = (bounds.radius() - near.length).max(0.0);
        let error = (near.upper - near.length).max(near.length - near.lower)
            + (bounds.swept_upper() - bounds.radius());
        let [a, b] = self.bodies;
        self.depth_of(depth, error, near.points(a, b), -near.direction)
    }

    fn of_overlapping_cores(
        &self,
        bounds: &Bounds<f64>,
        surface: &mut Surface,
        finish: Option<Finish<S>>,
    ) -> Option<Depth> {
        let mut next_try = local_bound::FIRST;
        surface.clear();
        surface.start(self.tetrahedron()?).or_else(|| surface.forget())?;
        let (mut reach, mut upper, mut normal) = (f64::MAX, f64::MAX, DVec3::ZERO);
        for _ in 0..GROWTHS {
            let nearest = surface.nearest();
            let (direction, distance) = surface.plane(nearest);
            let direction = unit::<f64>(direction.to_array())?;
            let (vertex, separation) = lowest(&self.difference, -direction);
            let along = -separation / direction.length();
            let most = -bounds.lower_bound(-direction, separation);
            if most < upper {
                (reach, upper, normal) = (along, most, direction);
            }
            // Done, or the vertex is nothing new.
            if self.tolerance.admits(reach - distance, reach) || surface.holds(&vertex) {
                break;
            }
            if let Some(finish) = finish
                && reach - distance <= next_try * reach
            {
                let from = (&surface.vertices(nearest), normal);
                if let Some(found) = finish(self, bounds, surface, from) {
                    return Some(found);
                }
                next_try *= local_bound::NEXT;
            }
            surface.insert(vertex, nearest).or_else(|| surface.forget())?;
        }
        let lower = bounds.least_reach(surface.inner_radius());
        self.depth_between(
            bounds,
            [lower, reach, upper],
            || surface.witnesses(normal, self.bodies),
            normal,
        )
    }

    /// The depth of cores that reach at least so far along every direction, and along one so far, and at most so far.
    fn depth_between(
        &self,
        bounds: &Bounds<f64>,
        [lower, reach, upper]: [f64; 3],
        points: impl FnOnce() -> [DVec3; 2],
        direction: DVec3,
    ) -> Option<Depth> {
        // Of cores that may be apart the radii overlap less than their sum.
        if bounds.radius() > 0.0 && !(lower > 0.0) {
            return None;
        }
        let depth = reach.max(0.0) + bounds.radius();
        let error =
            (upper - reach.max(0.0)).max(reach - lower) + (bounds.swept_upper() - bounds.radius());
        self.depth_of(depth, error, points(), direction)
    }

    /// In metres, if the bound is as good as required. `points` are of the cores.
    fn depth_of(
        &self,
        depth: f64,
        error: f64,
        points: [DVec3; 2],
        direction: DVec3,
    ) -> Option<Depth> {
        self.depth_within(self.tolerance, depth, error, points, direction)
    }

    /// The same within another tolerance.
    fn depth_within(
        &self,
        tolerance: Tolerance,
        depth: f64,
        error: f64,
        points: [DVec3; 2],
        direction: DVec3,
    ) -> Option<Depth> {
        if !tolerance.is_met(depth, error) {
            return None;
        }
        let scale = self.difference.scale();
        let [a, b] = self.bodies;
        let normal = direction.normalize();
        let found = Depth {
            depth: depth / scale,
            normal,
            point_a: points[0] + normal * a.map.radius(),
            point_b: points[1] - normal * b.map.radius(),
            error_bound: rounded_up((error + 8.0 * UNIT * depth) / scale),
        };
        // What leaves the range is left to the exact search.
        let numbers = [found.depth, found.error_bound];
        let vectors = [found.normal, found.point_a, found.point_b];
        let is_finite =
            numbers.iter().all(|x| x.is_finite()) && vectors.iter().all(|v| v.is_finite());
        is_finite.then_some(found)
    }

    /// Four points of the difference that are far from one plane, each a support towards the origin.
    fn tetrahedron(&self) -> Option<[Vertex<f64>; 4]> {
        let farthest = |direction: DVec3| {
            let direction = unit::<f64>(direction.to_array())?;
            Some(lowest(&self.difference, -direction).0)
        };
        let v0 = farthest(-self.difference.middle()).or_else(|| farthest(DVec3::X))?;
        let v1 = farthest(-v0.w).or_else(|| farthest(-DVec3::X))?;
        let edge = v1.w - v0.w;
        if edge.length() < FAT {
            return None;
        }
        let off_line = edge.cross(v0.w).cross(edge);
        let square = if off_line.length() > FAT * edge.length_squared() {
            -off_line
        } else {
            edge.any_orthogonal_vector()
        };
        let v2 = [square, -square].into_iter().find_map(|direction| {
            let vertex = farthest(direction)?;
            let fat = edge.cross(vertex.w - v0.w).length() >= FAT * edge.length();
            fat.then_some(vertex)
        })?;
        let normal = edge.cross(v2.w - v0.w);
        let inward = if normal.dot(v0.w) > 0.0 { -normal } else { normal };
        let v3 = [inward, -inward].into_iter().find_map(|direction| {
            let vertex = farthest(direction)?;
            let height = direction.dot(vertex.w - v0.w) / direction.length();
            (height >= FAT).then_some(vertex)
        })?;
        Some([v0, v1, v2, v3])
    }
}
