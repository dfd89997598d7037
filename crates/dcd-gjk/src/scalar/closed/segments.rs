//! Spheres, capsules and cuboids whose nearest points have a formula.
//!
//! The formula only proposes a point of each core; what is proved of the pair is what their
//! difference proves, as any point and as any direction (docs/numerics/proofs.md, "closed forms").

use super::cuboid_nearest;
use super::long_points;
use super::triangles;
use super::{LENGTH, SEPARATION, SIZES, UNIT};
use crate::epa::Depth;
use crate::{Distance, DistanceResult, PosedSupport, Verdict};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Pose, Vector};

/// How far the proposed points' difference may be off. Unit: u·m. A component loses 5.01u as a
/// vertex's does and at most 5u for a point between two: √3 of that.
const POINT: f64 = 20.0;

/// See `lower` in certificate.rs. Unit: u·m.
const LOWER: f64 = 12.5;

/// The most that a distance of two boxes may be off for the points to be the nearest: [`POINT`], [`LOWER`] and the lengths.
/// Unit: u·m. Larger: worse distances. Smaller: more pairs that need the search.
const NEAREST: f64 = 64.0;

/// How near an end a point of a cuboid is at it. Unit: half an edge. Larger: more pairs of which another point is the nearest, and
/// that are searched; never an answer.
const AT_END: f64 = 1e-13;

/// A squared length of the difference, square metres, below which products with it could underflow.
const SHORTEST: f64 = 1e-280;

/// A core where it is, and the radius swept round it.
#[derive(Clone, Copy)]
pub(crate) struct PosedCore<'a> {
    pub(super) kind: Kind,
    pub(super) vertices: &'a [DVec3],
    pub(super) pose: &'a Pose,
    pub(super) radius: f64,
    /// At least the distance of every vertex from the origin of its own frame, metres.
    reach: f64,
}

impl<'a> PosedCore<'a> {
    /// Of a triangle.
    pub(crate) fn triangle(corners: &'a [DVec3; 3], radius: f64, pose: &'a Pose) -> Self {
        let [p, q, r] = corners.map(DVec3::length_squared);
        let reach = p.max(q).max(r).sqrt() * (1.0 + LENGTH * UNIT);
        Self { kind: Kind::Triangle, vertices: corners, pose, radius, reach }
    }

    /// Of a shape.
    pub(crate) fn polytope(map: &'a Polytope, pose: &'a Pose) -> Self {
        let (radius, reach) = (map.swept_radius(), map.reach());
        Self { kind: map.kind(), vertices: map.vertices(), pose, radius, reach }
    }
}

impl<'a> From<PosedSupport<'a, Polytope>> for PosedCore<'a> {
    fn from(side: PosedSupport<'a, Polytope>) -> Self {
        Self { reach: side.reach, ..Self::polytope(side.map, side.pose) }
    }
}

/// What is known of a pair from one point of each core.
pub(super) struct Proposal<'a> {
    a: PosedCore<'a>,
    b: PosedCore<'a>,
    /// The points, each in its own frame.
    points: [DVec3; 2],
    /// Their difference in world axes.
    w: DVec3,
    length: f64,
    delta: DVec3,
    /// u·m.
    unit: f64,
    /// The sum of the swept radii.
    radius: f64,
}

/// Whether two polytopes of these kinds touch; `None` where there is no formula for them, or it
/// leaves the answer open.
pub(super) fn overlap(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<Verdict<()>> {
    Proposal::of(a.into(), b.into())?.verdict()
}

/// The same of cores, and from the second's nearest point to the first's: world.
pub(crate) fn overlap_of_cores([a, b]: [PosedCore<'_>; 2]) -> Option<(Verdict<()>, DVec3)> {
    let proposal = Proposal::of(a, b)?;
    proposal.verdict().map(|verdict| (verdict, proposal.w))
}

/// Their distance, if it is proved and its bound at most `sharp` times itself.
pub(super) fn distance(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    sharp: f64,
) -> Option<DistanceResult> {
    let proposal = Proposal::of(a.into(), b.into())?;
    if proposal.touches() {
        return Some(DistanceResult::Touching);
    }
    proposal.distance(sharp).map(DistanceResult::Apart)
}

/// How deep two that touch overlap, if their cores do not and the bound is at most `sharp` times the depth:
/// what the distance of the cores leaves of the radii.
pub(super) fn depth(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    sharp: f64,
) -> Option<Depth> {
    depth_of_cores([a.into(), b.into()], sharp)
}

/// The same as [`depth`], of cores.
pub(crate) fn depth_of_cores([a, b]: [PosedCore<'_>; 2], sharp: f64) -> Option<Depth> {
    Proposal::of(a, b)?.depth(sharp)
}

/// The distance of two boxes whose nearest points an axis proposes, if its bound is what f64 promises.
pub(super) fn distance_of_cuboids(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<Distance> {
    let proposal = Proposal::of_cuboids(a, b)?;
    proposal.distance(f64::INFINITY).filter(|found| found.error_bound <= NEAREST * proposal.unit)
}

/// The same where its bound is to be at most `sharp` times itself: in double-double.
pub(super) fn long_distance_of_cuboids(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    sharp: f64,
) -> Option<Distance> {
    let [in_a, in_b] = cuboid_nearest::points(a, b)?;
    let (a, b) = (PosedCore::from(a), PosedCore::from(b));
    let points = [at_ends(a.kind, in_a), at_ends(b.kind, in_b)];
    Proposal::at(a, b, points, size_of(a, b)).long_distance(sharp)
}

/// A point of a cuboid that is at the ends where it is but for rounding.
fn at_ends(kind: Kind, point: DVec3) -> DVec3 {
    let Kind::Cuboid { half_extents } = kind else { return point };
    let is_end = point.abs().cmpge(half_extents * (1.0 - AT_END));
    DVec3::select(is_end, half_extents.copysign(point), point)
}

/// The pair's size m.
fn size_of(a: PosedCore<'_>, b: PosedCore<'_>) -> f64 {
    let reach = |body: PosedCore<'_>| body.reach * (1.0 + body.pose.deviation());
    reach(a) + reach(b) + (a.pose.translation() - b.pose.translation()).norm1()
}

impl<'a> Proposal<'a> {
    // Made where it is kept: what is copied right after it has been written is waited for.
    #[inline(always)]
    fn of(a: PosedCore<'a>, b: PosedCore<'a>) -> Option<Self> {
        let delta = a.pose.translation() - b.pose.translation();
        let radius = a.radius + b.radius;
        let size = size_of(a, b);
        // False for NaN.
        if !(SIZES.contains(&size) && radius < SIZES.end) {
            return None;
        }
        let points = match (a.kind, b.kind) {
            (Kind::Cuboid { half_extents }, Kind::Point) => {
                let point = *b.vertices.first()?;
                let in_a = a.pose.rotation().transpose() * (*b.pose.rotation() * point - delta);
                [in_a.clamp(-half_extents, half_extents), point]
            }
            (Kind::Point, Kind::Cuboid { half_extents }) => {
                let point = *a.vertices.first()?;
                let in_b = b.pose.rotation().transpose() * (*a.pose.rotation() * point + delta);
                [point, in_b.clamp(-half_extents, half_extents)]
            }
            (Kind::Point | Kind::Segment, Kind::Point | Kind::Segment) => {
                let (from_a, along_a) = segment(a.vertices)?;
                let (from_b, along_b) = segment(b.vertices)?;
                let (turn_a, turn_b) = (*a.pose.rotation(), *b.pose.rotation());
                let between = (turn_a * from_a - turn_b * from_b) + delta;
                let [s, t] = parameters(turn_a * along_a, turn_b * along_b, between);
                [from_a + along_a * s, from_b + along_b * t]
            }
            (Kind::Triangle, Kind::Point | Kind::Segment)
            | (Kind::Point | Kind::Segment, Kind::Triangle) => triangles::points(a, b, delta)?,
            _ => return None,
        };
        Some(Self::at(a, b, points, size))
    }

    /// Two boxes that are apart, by points that are perhaps the nearest.
    fn of_cuboids(a: PosedSupport<'a, Polytope>, b: PosedSupport<'a, Polytope>) -> Option<Self> {
        let points = cuboid_nearest::points(a, b)?;
        let (a, b) = (a.into(), b.into());
        Some(Self::at(a, b, points, size_of(a, b)))
    }

    /// Any points, each in its own frame; `None` out of range.
    pub(super) fn of_points(
        a: PosedCore<'a>,
        b: PosedCore<'a>,
        points: [DVec3; 2],
    ) -> Option<Self> {
        let size = size_of(a, b);
        // False for NaN.
        SIZES.contains(&size).then(|| Self::at(a, b, points, size))
    }

    #[inline(always)]
    fn at(a: PosedCore<'a>, b: PosedCore<'a>, points: [DVec3; 2], size: f64) -> Self {
        let delta = a.pose.translation() - b.pose.translation();
        let radius = a.radius + b.radius;
        let w = (*a.pose.rotation() * points[0] - *b.pose.rotation() * points[1]) + delta;
        Self { a, b, points, w, length: w.length(), delta, unit: UNIT * size, radius }
    }

    /// The points' difference, world axes.
    pub(super) fn difference(&self) -> DVec3 {
        self.w
    }

    /// min over A − B of w·x. Rounded as a separation of vertices is.
    fn separation(&self) -> f64 {
        self.separation_along(self.w)
    }

    fn separation_along(&self, direction: DVec3) -> f64 {
        let low = lowest(self.a, direction);
        let high = lowest(self.b, -direction);
        direction.dot(self.delta) + (low + high)
    }

    /// The distance, bounded from below along a direction, if the bound is at most so many units.
    pub(super) fn distance_along(&self, direction: DVec3, most: f64) -> Option<Distance> {
        let length = direction.length();
        let bounds = self.bounds(self.separation_along(direction) / length)?;
        // False for NaN.
        self.within(bounds, most * self.unit)
    }

    fn touches(&self) -> bool {
        let upper = self.length * (1.0 + LENGTH * UNIT) + POINT * self.unit;
        upper <= self.radius * (1.0 - LENGTH * UNIT)
    }

    fn verdict(&self) -> Option<Verdict<()>> {
        if self.touches() {
            return Some(Verdict::Touching(()));
        }
        let above = 1.0 + LENGTH * UNIT;
        let needed = SEPARATION * self.unit * self.w.norm1() + self.radius * above * self.length;
        let apart = self.length * self.length >= SHORTEST && self.separation() > needed;
        apart.then_some(Verdict::Apart)
    }

    fn distance(&self, sharp: f64) -> Option<Distance> {
        let found = self.within(self.signed_distance()?, sharp * (self.length - self.radius));
        found.or_else(|| self.long_distance(sharp))
    }

    /// The same in double-double.
    fn long_distance(&self, sharp: f64) -> Option<Distance> {
        let (distance, error_bound) = self.long_gap(sharp).filter(|&(gap, _)| gap > 0.0)?;
        let (normal, point_a, point_b) = self.witnesses();
        Some(Distance { distance, point_a, point_b, normal, error_bound })
    }

    /// The cores' distance less the radii, and its bound, where they are apart and f64 is not good enough.
    fn long_gap(&self, sharp: f64) -> Option<(f64, f64)> {
        let Self { a, b, points, unit, .. } = *self;
        sharp.is_finite().then(|| long_points::gap([a, b], points, unit / UNIT)).flatten()
    }

    /// The distance by its bounds, if what they leave open is at most `most` metres.
    fn within(&self, [lower, upper]: [f64; 2], most: f64) -> Option<Distance> {
        let distance = self.length - self.radius;
        let error_bound = self.error_of(distance, [lower, upper]);
        // False for NaN.
        if !(lower > 0.0 && error_bound <= most) {
            return None;
        }
        let (normal, point_a, point_b) = self.witnesses();
        Some(Distance { distance, point_a, point_b, normal, error_bound })
    }

    fn depth(&self, sharp: f64) -> Option<Depth> {
        let bounds = self.signed_distance()?;
        // The cores are apart.
        let is_apart = bounds[0] + self.radius * (1.0 - LENGTH * UNIT) > 0.0;
        let mut depth = (self.radius - self.length).max(0.0);
        let mut error_bound = self.error_of(-depth, bounds);
        if !(is_apart && error_bound <= sharp * depth) {
            let (gap, of_gap) = self.long_gap(sharp).filter(|&(gap, _)| gap < 0.0)?;
            (depth, error_bound) = (-gap, of_gap);
        }
        let (normal, point_a, point_b) = self.witnesses();
        Some(Depth { depth, normal, point_a, point_b, error_bound })
    }

    /// At most and at least the cores' distance less the radii; `None` where the points are too near for a bound.
    fn signed_distance(&self) -> Option<[f64; 2]> {
        self.bounds(self.separation() / self.length)
    }

    /// The same by the gap that a direction shows.
    fn bounds(&self, along: f64) -> Option<[f64; 2]> {
        let Self { unit, radius, length, .. } = *self;
        if !(length * length >= SHORTEST) {
            return None;
        }
        let relative = LENGTH * UNIT;
        let upper = length * (1.0 + relative) + POINT * unit - radius * (1.0 - relative);
        let lower = along - along.abs() * relative - LOWER * unit - radius * (1.0 + relative);
        Some([lower, upper])
    }

    /// How far the truth may be from a value, by the bounds. Two sums each, of numbers that are at most the
    /// length and the radius.
    fn error_of(&self, value: f64, [lower, upper]: [f64; 2]) -> f64 {
        (upper - value).max(value - lower) + 4.0 * UNIT * (self.length + self.radius)
    }

    /// The normal from a to b, and a point of each swept shape on the line through the cores' nearest ones.
    fn witnesses(&self) -> (DVec3, DVec3, DVec3) {
        let Self { a, b, points, .. } = *self;
        let normal = self.w / -self.length;
        let point_a = a.pose.apply(points[0]) + normal * a.radius;
        (normal, point_a, b.pose.apply(points[1]) - normal * b.radius)
    }
}

/// A vertex, and from it to the other one.
pub(super) fn segment(vertices: &[DVec3]) -> Option<(DVec3, DVec3)> {
    match *vertices {
        [from] => Some((from, DVec3::ZERO)),
        [from, to] => Some((from, to - from)),
        _ => None,
    }
}

/// min over the core of d·R·x.
fn lowest(body: PosedCore<'_>, d: DVec3) -> f64 {
    let d = body.pose.rotation().transpose() * d;
    if let Kind::Cuboid { half_extents } = body.kind {
        return -d.abs().dot(half_extents);
    }
    body.vertices.iter().fold(f64::INFINITY, |least, &v| least.min(d.dot(v)))
}

/// Where in [0, 1] along `u` and `v` the points `between + u·s` and `v·t` are nearest.
///
/// Source: Ericson, Real-Time Collision Detection, 2005, 5.1.9. Anything in [0, 1] is sound.
pub(super) fn parameters(u: DVec3, v: DVec3, between: DVec3) -> [f64; 2] {
    let (uu, vv, uv) = (u.dot(u), v.dot(v), u.dot(v));
    let (ub, vb) = (u.dot(between), v.dot(between));
    // A quotient of zeros, for a point or parallel segments, is any place at all.
    let clamped = |x: f64| if x > 0.0 { x.min(1.0) } else { 0.0 };
    let s = clamped((uv * vb - ub * vv) / (uu * vv - uv * uv));
    let t = (uv * s + vb) / vv;
    if t > 1.0 {
        [clamped((uv - ub) / uu), 1.0]
    } else if t >= 0.0 {
        [s, t]
    } else {
        [clamped(-ub / uu), 0.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_those_of_the_nearest_points() {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        assert_eq!(parameters(x, y, z - x * 0.25 + y * 0.5), [0.25, 0.5]);
        assert_eq!(parameters(x, y, z + x), [0.0, 0.0]);
        assert_eq!(parameters(x, y, z - x * 2.0 + y * 2.0), [1.0, 1.0]);
        assert_eq!(parameters(x, DVec3::ZERO, z - x * 0.25), [0.25, 0.0]);
        assert_eq!(parameters(DVec3::ZERO, y, z + y * 0.25), [0.0, 0.25]);
        assert_eq!(parameters(DVec3::ZERO, DVec3::ZERO, z), [0.0, 0.0]);
        let [s, t] = parameters(x, x, z + x * 0.5);
        assert!((s + 0.5 - t).abs() < 1e-15 && s <= 0.5);
    }
}
