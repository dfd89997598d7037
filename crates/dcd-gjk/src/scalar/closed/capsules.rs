//! Two capsules, and a capsule and a cuboid, rounded or not, at the accuracy of f32: the nearest points of their cores, and
//! what one evaluation of them proves.
//!
//! The general way bounds the distance from below by supports of both shapes. Of segments how far an end reaches past
//! the points along their difference is a product, and so the bound costs two (docs/numerics/proofs.md, "Capsules in f64").

use super::centred::{DEVIATION, largest_deviation};
use super::gap::Gap;
use super::segments::{parameters, segment};
use super::{SIZES, UNIT};
use crate::query::Accuracy;
use crate::{PosedShape, order};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Shape, Vector};

/// How far the gap of two capsules may be off, and how far past the points an end may reach. Unit: u·m. Derived: 58.
const LOST: f64 = 72.0;

/// The same of a capsule and a cuboid. Derived: 83.
const IN_FRAME: f64 = 96.0;

/// How often the place along a segment that is nearest to a box is narrowed at most; four are usual. Fewer: places that are
/// not the nearest, and the general way.
const NARROWINGS: usize = 16;

/// How far two are apart, negative where they overlap; `None` of other kinds, where their cores may meet, and where the
/// points are not surely the nearest.
///
/// (a, b) and (b, a) give the same bits, mirrored.
#[inline]
pub(super) fn gap_of(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<Gap> {
    let (Shape::Polytope(in_a), Shape::Polytope(in_b)) = (a.shape, b.shape) else { return None };
    match (in_a.kind(), in_b.kind()) {
        (Kind::Segment, Kind::Segment) if order::is_swapped(a, b) => {
            gap_between((in_b, b), (in_a, a), true)
        }
        (Kind::Segment, Kind::Segment) => gap_between((in_a, a), (in_b, b), false),
        (Kind::Segment, Kind::Cuboid { half_extents }) => {
            gap_beside((in_a, a), (in_b, half_extents, b), false)
        }
        (Kind::Cuboid { half_extents }, Kind::Segment) => {
            gap_beside((in_b, b), (in_a, half_extents, a), true)
        }
        _ => None,
    }
}

/// Of two capsules.
#[inline(always)]
fn gap_between(
    (in_a, a): (&Polytope, PosedShape<'_>),
    (in_b, b): (&Polytope, PosedShape<'_>),
    swapped: bool,
) -> Option<Gap> {
    let ((from_a, along_a), (from_b, along_b)) = (placed(in_a, a)?, placed(in_b, b)?);
    let delta = a.pose.translation() - b.pose.translation();
    let reach =
        |core: &Polytope, side: PosedShape<'_>| core.reach() * (1.0 + side.pose.deviation());
    let size = reach(in_a, a) + reach(in_b, b) + delta.norm1();
    let [radius_a, radius_b] = [in_a.swept_radius(), in_b.swept_radius()];
    let radius = radius_a + radius_b;
    // False for NaN.
    if !(SIZES.contains(&size) && radius < SIZES.end) {
        return None;
    }
    let between = (from_a - from_b) + delta;
    let [s, t] = parameters(along_a, along_b, between);
    let w = (between + along_a * s) - along_b * t;
    let length = w.length();
    // How far an end of a is beyond its point against w, and one of b along it; times the length.
    let (rise_a, rise_b) = (w.dot(along_a), w.dot(along_b));
    let beyond_a = (s * rise_a).max((s - 1.0) * rise_a);
    let beyond_b = ((1.0 - t) * rise_b).max(-t * rise_b);
    let lost = LOST * UNIT * (size + radius);
    // Written so that NaN proves nothing.
    if !(length > 2.0 * lost && beyond_a + beyond_b <= lost * length) {
        return None;
    }
    let error = lost + (beyond_a + beyond_b) / length;
    let normal = w / -length;
    let point_a = (a.pose.translation() + (from_a + along_a * s)) + normal * radius_a;
    let point_b = (b.pose.translation() + (from_b + along_b * t)) - normal * radius_b;
    Some(Gap::new((length - radius, error), normal, [point_a, point_b], swapped))
}

/// Of a capsule and a cuboid with those half-extents, in whose frame the capsule is seen.
#[inline(always)]
fn gap_beside(
    (core, capsule): (&Polytope, PosedShape<'_>),
    (cuboid, half, other): (&Polytope, DVec3, PosedShape<'_>),
    swapped: bool,
) -> Option<Gap> {
    let deviation = other.pose.deviation();
    if !(deviation <= largest_deviation(Accuracy::F32)?) {
        return None;
    }
    let (from, along) = placed(core, capsule)?;
    let delta = capsule.pose.translation() - other.pose.translation();
    let radius = core.swept_radius() + cuboid.swept_radius();
    let reach = core.reach() * (1.0 + capsule.pose.deviation());
    let size = reach + cuboid.reach() + delta.norm1() + radius;
    // False for NaN.
    if !SIZES.contains(&size) {
        return None;
    }
    let rotation = other.pose.rotation();
    let seen = |v: DVec3| {
        DVec3::new(rotation.x_axis.dot(v), rotation.y_axis.dot(v), rotation.z_axis.dot(v))
    };
    let (seen_from, seen_along) = (seen(from + delta), seen(along));
    let (s, away) = nearest_place(seen_from, seen_along, half)?;
    let length = away.length();
    let rise = away.dot(seen_along);
    let beyond = (s * rise).max((s - 1.0) * rise);
    let lost = (IN_FRAME * UNIT + DEVIATION * deviation) * size;
    // Written so that NaN proves nothing.
    if !(length > 2.0 * lost && beyond <= lost * length) {
        return None;
    }
    let value = length - radius;
    let normal = *rotation * (away / -length);
    let place = capsule.pose.translation() + (from + along * s);
    let on_capsule = place + normal * core.swept_radius();
    let on_cuboid = on_capsule + normal * value;
    let error = lost + beyond / length;
    Some(Gap::new((value, error), normal, [on_capsule, on_cuboid], swapped))
}

/// Where in [0, 1] along a segment it is nearest to a box round the origin, and how far from there the box is; `None` where
/// it is inside. The derivative of half the squared distance is linear between the planes of the box, and never falls.
#[inline(always)]
fn nearest_place(from: DVec3, along: DVec3, half: DVec3) -> Option<(f64, DVec3)> {
    let away = |t: f64| {
        let point = from + along * t;
        point - point.clamp(-half, half)
    };
    let (at_start, at_end) = (away(0.0), away(1.0));
    let (slope_start, slope_end) = (at_start.dot(along), at_end.dot(along));
    if !(slope_start < 0.0) {
        return Some((0.0, at_start));
    }
    if !(slope_end > 0.0) {
        return Some((1.0, at_end));
    }
    let (mut low, mut high) = (0.0, 1.0);
    let mut t = slope_start / (slope_start - slope_end);
    let mut here = away(t);
    for _ in 0..NARROWINGS {
        if here == DVec3::ZERO {
            return None;
        }
        let slope = here.dot(along);
        if slope < 0.0 {
            low = t;
        } else {
            high = t;
        }
        let outside = DVec3::select(here.cmpeq(DVec3::ZERO), DVec3::ZERO, along);
        let next = t - slope / outside.dot(outside);
        let next = if low < next && next < high { next } else { 0.5 * (low + high) };
        // Nothing is left but rounding.
        if (next - t).abs() <= UNIT {
            break;
        }
        t = next;
        here = away(t);
    }
    Some((t, here))
}

/// An end of a core, and from it to the other one: world axes, from the shape's origin.
#[inline(always)]
fn placed(core: &Polytope, side: PosedShape<'_>) -> Option<(DVec3, DVec3)> {
    let (from, along) = segment(core.vertices())?;
    let turn = *side.pose.rotation();
    Some((turn * from, turn * along))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distance::distance;
    use crate::motion::tests::Draw;
    use crate::query::{Accuracy, MeasureAt};
    use crate::{Depths, DistanceResult, Verdict};
    use dcd_geom::Pose;
    use dcd_geom::glam::DQuat;

    /// Side by side, end to end, crossing, of no length, nearly parallel, and far from the world's origin; two capsules, or one
    /// and a cuboid.
    fn pair(draw: &mut Draw, k: usize) -> ([Shape; 2], [Pose; 2]) {
        let cuboid = |draw: &mut Draw, k: usize| {
            let half = draw.vector().abs() * 0.4 + 0.01;
            let swept = if k.is_multiple_of(3) { 0.1 } else { 0.0 };
            Shape::cuboid(half).unwrap().rounded(swept).unwrap()
        };
        let capsule = |draw: &mut Draw, k: usize| {
            let half = if k.is_multiple_of(11) { 1e-9 } else { draw.vector().x.abs() + 0.01 };
            Shape::capsule(half, draw.vector().x.abs() * 0.4 + 0.01).unwrap()
        };
        let shapes = match k / 36 % 4 {
            0 => [capsule(draw, k), cuboid(draw, k)],
            1 => [cuboid(draw, k), capsule(draw, k)],
            _ => [capsule(draw, k), capsule(draw, k / 11)],
        };
        let far = draw.vector() * [0.0, 0.0, 1e4][k % 3];
        let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
        let tilt = draw.vector() * [0.0, 1e-9, 1e-4, 3.0][k / 3 % 4];
        let at = match k / 12 % 3 {
            0 => draw.vector() * 0.6,
            1 => turn * DVec3::X * 0.3,
            _ => turn * DVec3::new(0.0, 0.2, draw.vector().x),
        };
        let turned = DQuat::from_scaled_axis(tilt) * turn;
        (shapes, [Pose::new(turn, far).unwrap(), Pose::new(turned, far + at).unwrap()])
    }

    #[test]
    fn capsules_are_as_far_apart_or_as_deep_as_the_certified_way_finds() {
        let mut draw = Draw(23);
        let [mut deep, mut apart, mut open] = [[0; 2]; 3];
        for k in 0..20_000 {
            let (shapes, poses) = pair(&mut draw, k);
            let [a, b] = [0, 1].map(|k| PosedShape { shape: &shapes[k], pose: &poses[k] });
            let kind = usize::from(k / 36 % 4 < 2);
            let (Some(gap), Some(back)) = (gap_of(a, b), gap_of(b, a)) else {
                assert!(gap_of(a, b).is_none() && gap_of(b, a).is_none(), "{k}");
                open[kind] += 1;
                continue;
            };
            if let Some(found) = gap.depth() {
                assert_eq!(Some(found), back.depth().map(|found| found.mirrored()), "{k}");
                let due = Depths.measure_at(Accuracy::Certified, a, b, &mut Default::default());
                let Verdict::Touching(due) = due else { panic!("{k}: {found:?}") };
                let off = (found.depth - due.depth).abs();
                assert!(off <= found.error_bound + due.error_bound, "{k}: {found:?} {due:?}");
                assert!(found.error_bound < 2e-13 * (2.0 + poses[0].translation().length()));
                let between = found.point_a - found.point_b - found.normal * found.depth;
                assert!(between.length() < 1e-11, "{k}: {found:?}");
                deep[kind] += 1;
                continue;
            }
            let gap = gap_of(a, b).and_then(Gap::distance);
            let Some(DistanceResult::Apart(found)) = gap else { continue };
            let DistanceResult::Apart(due) = distance(a, b).0 else { panic!("{k}: {found:?}") };
            let off = (found.distance - due.distance).abs();
            assert!(off <= found.error_bound + due.error_bound, "{k}: {found:?} {due:?}");
            apart[kind] += 1;
        }
        let is_tried = |kind: usize| deep[kind] > 2000 && apart[kind] > 1000 && open[kind] < 6000;
        assert!(is_tried(0) && is_tried(1), "{deep:?} {apart:?} {open:?}");
    }
}
