//! Spheres, capsules and cuboids whose nearest points have a formula.
//!
//! The formula only proposes a point of each core; what is proved of the pair is what their
//! difference proves, as any point and as any direction (docs/numerics/proofs.md, "closed forms").

use super::{LENGTH, SEPARATION, SIZES, UNIT};
use crate::{Distance, DistanceResult, PosedSupport, Verdict};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Vector};

/// How far the proposed points' difference may be off. Unit: u·m. A component loses 5.01u as a
/// vertex's does and at most 5u for a point between two: √3 of that.
const POINT: f64 = 20.0;

/// See `lower` in certificate.rs. Unit: u·m.
const LOWER: f64 = 12.5;

/// A squared length of the difference, square metres, below which products with it could underflow.
const SHORTEST: f64 = 1e-280;

/// How far the bounds may leave a distance open, relative to itself: a tenth of what is promised.
const SHARP: f64 = 1e-13;

/// What is known of a pair from one point of each core.
struct Proposal<'a> {
    a: PosedSupport<'a, Polytope>,
    b: PosedSupport<'a, Polytope>,
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
    Proposal::of(a, b)?.verdict()
}

/// Their distance, if it is proved and as sharp as is promised.
pub(super) fn distance(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<DistanceResult> {
    let proposal = Proposal::of(a, b)?;
    if proposal.touches() {
        return Some(DistanceResult::Touching);
    }
    proposal.distance().map(DistanceResult::Apart)
}

impl<'a> Proposal<'a> {
    fn of(a: PosedSupport<'a, Polytope>, b: PosedSupport<'a, Polytope>) -> Option<Self> {
        let delta = a.pose.translation() - b.pose.translation();
        let reach = |body: PosedSupport<'_, Polytope>| body.reach * (1.0 + body.pose.deviation());
        let radius = a.map.swept_radius() + b.map.swept_radius();
        let size = reach(a) + reach(b) + delta.norm1();
        // False for NaN.
        if !(SIZES.contains(&size) && radius < SIZES.end) {
            return None;
        }
        let points = match (a.map.kind(), b.map.kind()) {
            (Kind::Cuboid { half_extents }, Kind::Point) => {
                let point = *b.map.vertices().first()?;
                let in_a = a.pose.rotation().transpose() * (*b.pose.rotation() * point - delta);
                [in_a.clamp(-half_extents, half_extents), point]
            }
            (Kind::Point, Kind::Cuboid { half_extents }) => {
                let point = *a.map.vertices().first()?;
                let in_b = b.pose.rotation().transpose() * (*a.pose.rotation() * point + delta);
                [point, in_b.clamp(-half_extents, half_extents)]
            }
            (Kind::Point | Kind::Segment, Kind::Point | Kind::Segment) => {
                let (from_a, along_a) = segment(a.map)?;
                let (from_b, along_b) = segment(b.map)?;
                let (turn_a, turn_b) = (*a.pose.rotation(), *b.pose.rotation());
                let between = (turn_a * from_a - turn_b * from_b) + delta;
                let [s, t] = parameters(turn_a * along_a, turn_b * along_b, between);
                [from_a + along_a * s, from_b + along_b * t]
            }
            _ => return None,
        };
        let w = (*a.pose.rotation() * points[0] - *b.pose.rotation() * points[1]) + delta;
        Some(Self { a, b, points, w, length: w.length(), delta, unit: UNIT * size, radius })
    }

    /// min over A − B of w·x. Rounded as a separation of vertices is.
    fn separation(&self) -> f64 {
        let low = lowest(self.a, self.w);
        let high = lowest(self.b, -self.w);
        self.w.dot(self.delta) + (low + high)
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

    fn distance(&self) -> Option<Distance> {
        let Self { a, b, unit, radius, length, .. } = *self;
        if !(length * length >= SHORTEST) {
            return None;
        }
        let distance = length - radius;
        let along = self.separation() / length;
        let relative = LENGTH * UNIT;
        let upper = length * (1.0 + relative) + POINT * unit - radius * (1.0 - relative);
        let lower = along - along.abs() * relative - LOWER * unit - radius * (1.0 + relative);
        // Two sums each, of numbers that are at most the length and the radius.
        let error = (upper - distance).max(distance - lower) + 4.0 * UNIT * (length + radius);
        if !(lower > 0.0 && error <= SHARP * distance) {
            return None;
        }
        let normal = self.w / -length;
        Some(Distance {
            distance,
            point_a: a.pose.apply(self.points[0]) + normal * a.map.swept_radius(),
            point_b: b.pose.apply(self.points[1]) - normal * b.map.swept_radius(),
            normal,
            error_bound: error,
        })
    }
}

/// A vertex, and from it to the other one.
fn segment(polytope: &Polytope) -> Option<(DVec3, DVec3)> {
    match *polytope.vertices() {
        [from] => Some((from, DVec3::ZERO)),
        [from, to] => Some((from, to - from)),
        _ => None,
    }
}

/// min over the core of d·R·x.
fn lowest(body: PosedSupport<'_, Polytope>, d: DVec3) -> f64 {
    let d = body.pose.rotation().transpose() * d;
    if let Kind::Cuboid { half_extents } = body.map.kind() {
        return -d.abs().dot(half_extents);
    }
    body.map.vertices().iter().fold(f64::INFINITY, |least, &v| least.min(d.dot(v)))
}

/// Where in [0, 1] along `u` and `v` the points `between + u·s` and `v·t` are nearest.
///
/// Source: Ericson, Real-Time Collision Detection, 2005, 5.1.9. Anything in [0, 1] is sound.
fn parameters(u: DVec3, v: DVec3, between: DVec3) -> [f64; 2] {
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
