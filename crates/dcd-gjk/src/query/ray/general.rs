//! A ray and any convex shape: a point that moves, by conservative advancement, and a proof of depth behind.

use super::{Ray, RayHit};
use crate::epa::Scratch;
use crate::motion::{Impact, MovingShape, RigidMotion, time_of_impact};
use crate::query::local::UNDERFLOW;
use crate::{Depths, PairSolver, PosedShape, Verdict};
use dcd_geom::glam::DVec3;
use dcd_geom::{Pose, Shape};

/// How near a point comes before it counts as at the surface, relative to the shape's reach. Larger: wider brackets.
/// Smaller: grazing rays take more advances.
const NEAR: f64 = 1e-10;

/// How many points behind the surface are tried for one that is inside, each twice as far in as the one before.
const TRIES: i32 = 40;

/// What the rounding of a point of a ray costs. Unit: 2⁻⁵³ of the lengths that go into it.
const POINT: f64 = 16.0 * crate::UNIT;

/// The first hit; of a shape that is bounded and convex. Uncertain of one that has no inside.
pub(super) fn hit(ray: &Ray, posed: PosedShape<'_>) -> Option<RayHit> {
    let unknown = |t_lower: f64, t_upper: f64| RayHit {
        t: t_lower,
        t_lower,
        t_upper,
        is_certain: false,
        normal: DVec3::ZERO,
        facet: None,
        part: None,
    };
    let reach = posed.shape.reach();
    let speed = ray.direction().length();
    // About the shape's own origin, where its size counts and not how far it is from the world's. What the
    // difference loses is the radius of the sphere that moves in place of a point.
    let from = ray.origin() - posed.pose.translation();
    let away = from.length() + UNDERFLOW;
    let lost = POINT * away;
    // Nothing of the shape is farther along.
    let end = ray.max_t().min((away + 2.0 * reach) / speed * (1.0 + 1e-9));
    let (Ok(sphere), Ok(point), Ok(start), Ok(pose)) = (
        Shape::sphere(lost),
        Shape::sphere(0.0),
        Pose::from_translation(from),
        posed.pose.with_translation(DVec3::ZERO),
    ) else {
        return Some(unknown(0.0, end));
    };
    let posed = PosedShape { shape: posed.shape, pose: &pose };
    let motion = RigidMotion { linear: ray.direction(), ..RigidMotion::at_rest(start) };
    let still = RigidMotion::at_rest(pose);
    let moving = MovingShape { shape: &sphere, motion: &motion };
    let tolerance = NEAR * reach.max(f64::MIN_POSITIVE / NEAR) + lost;
    let target = MovingShape { shape: posed.shape, motion: &still };
    let (free_until, t, normal) = match time_of_impact(moving, target, end, tolerance) {
        Ok(Impact::Free) => return None,
        Ok(Impact::Hit { free_until, t, normal, .. }) => (free_until, t, -normal),
        Ok(Impact::Undecided { free_until }) => (free_until, free_until, DVec3::ZERO),
        Err(_) => return Some(unknown(0.0, end)),
    };
    let is_deep = |t: f64| {
        let place = from + ray.direction() * t;
        let Ok(pose) = Pose::from_translation(place) else { return false };
        let point = PosedShape { shape: &point, pose: &pose };
        let off = lost + POINT * (away + speed * t);
        match Depths.solve(point, posed, &mut Scratch::default()) {
            Verdict::Touching(found) => found.depth - found.error_bound > off,
            _ => false,
        }
    };
    let step = tolerance / speed;
    let behind = (0..TRIES).map(|k| t + step * 2f64.powi(k)).take_while(|&t| t <= end);
    let inside = std::iter::once(t).chain(behind).find(|&t| is_deep(t));
    let is_inside = free_until == 0.0 && inside == Some(0.0);
    let normal = if is_inside { DVec3::ZERO } else { normal };
    Some(match inside {
        Some(t_upper) => {
            let t = if is_inside { 0.0 } else { t.clamp(free_until, t_upper) };
            RayHit { t, t_upper, is_certain: true, normal, ..unknown(free_until, t_upper) }
        }
        None => RayHit { t, normal, ..unknown(free_until, end.max(free_until)) },
    })
}
