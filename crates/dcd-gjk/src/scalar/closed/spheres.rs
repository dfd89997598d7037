//! Sphere against sphere: the distance of two centres and two radii.
//!
//! A sphere's centre is its pose's translation, exactly, so that the difference of two centres loses one rounding
//! a component and its length a few, relative to itself: nothing here is relative to where the spheres are.
//! Exchanging the two mirrors every bit.

use super::{SIZES, UNIT};
use crate::double_double::{self, DoubleDouble, two_sum};
use crate::epa::Depth;
use crate::simplex::Scalar;
use crate::{Distance, DistanceResult, PosedShape, PosedSupport, Verdict};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Shape, Vector};
use dcd_simd::Lanes;

/// What the computed distance of two centres may be off by. Unit: u, relative. A square loses 2u and what its
/// component lost, twice; two sums, one u each; the root halves that and adds one: 4u.
const LENGTH: f64 = 5.0;

/// The same in double-double. Unit: its epsilon. The components are exact there.
const LONG_LENGTH: f64 = 8.0;

/// How far a bound in double-double may leave a distance or depth open, relative to itself: what is promised of a
/// certified distance. Smaller: pairs that all but touch are left to longer numbers.
const LONG_SHARP: f64 = 1e-12;

/// What a witness loses of its sphere's radius. Unit: u of the radius. The normal's length 6, the product 1. Smaller: manifolds
/// whose points are off their surfaces by more than the bound.
const SURFACE: f64 = 8.0;

/// A sphere in the world, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedSphere {
    pub(crate) centre: DVec3,
    pub(crate) radius: f64,
}

impl PlacedSphere {
    fn of(side: PosedSupport<'_, Polytope>) -> Self {
        Self { centre: side.pose.translation(), radius: side.map.swept_radius() }
    }
}

/// Two spheres.
#[derive(Clone, Copy)]
struct Spheres {
    /// From b's centre to a's, rounded, and its length.
    between: DVec3,
    length: f64,
    centres: [DVec3; 2],
    radii: [f64; 2],
}

/// A signed distance, below 0 where the spheres overlap, and what it may be off by.
#[derive(Clone, Copy)]
struct Gap {
    value: f64,
    error: f64,
}

/// Whether they touch, where f64 proves it.
pub(super) fn overlap(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
) -> Option<Verdict<()>> {
    let Gap { value, error } = Spheres::of([a, b].map(PlacedSphere::of))?.gap();
    if value < -error {
        Some(Verdict::Touching(()))
    } else {
        (value > error).then_some(Verdict::Apart)
    }
}

/// How far apart they are, if that is proved with a bound of at most `sharp` times itself (or [`LONG_SHARP`]), or that
/// they touch.
pub(super) fn distance(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    sharp: f64,
) -> Option<DistanceResult> {
    distance_of_spheres([a, b].map(PlacedSphere::of), sharp)
}

/// The same of spheres.
#[inline]
pub(crate) fn distance_of_spheres(
    spheres: [PlacedSphere; 2],
    sharp: f64,
) -> Option<DistanceResult> {
    let spheres = Spheres::of(spheres)?;
    let gap = spheres.gap();
    if gap.value < -gap.error {
        return Some(DistanceResult::Touching);
    }
    let Gap { value, error } = spheres.sharpened(gap, sharp)?;
    let is_proved = value > error;
    is_proved.then(|| {
        let (normal, point_a, point_b) = spheres.witnesses();
        let distance = Distance { distance: value, point_a, point_b, normal, error_bound: error };
        DistanceResult::Apart(distance)
    })
}

/// Whether they are proved to be farther apart than a margin, metres.
#[inline]
pub(crate) fn spheres_are_beyond(spheres: [PlacedSphere; 2], margin: f64) -> bool {
    Spheres::of(spheres).is_some_and(|spheres| {
        let Gap { value, error } = spheres.gap();
        // By a step of f64 more: so the exact difference is more than the margin. Of the radii grown by half of that each, of
        // which the exact answer is, the sum may be u of radii and margin more: the error has 2u of the length to spare.
        value - error > margin.next_up()
    })
}

/// Which of eight pairs of spheres are proved to be farther apart than a margin, metres, and which to touch, a bit each: by
/// squares, so that those are left that are within some 16u of either. Of each pair the difference of the centres and the sum of
/// the radii, as [`Lanes::sphere_pairs`] has them.
///
/// The sum of squares is within 5u of the true square of the distance: a difference loses u, which its square doubles, the
/// square u, two sums u each. That of the radii and the margin loses 2u, which its square doubles, the square u, the product and
/// the sum or difference below u each: 7u. The radii grown by half of the margin each, of which the exact answer is, are rounded
/// up by u, which the square doubles. 16u covers all. What underflows is less than the smallest normal number; no square
/// overflows, since nothing reaches beyond [`dcd_geom::Aabb::LIMIT`].
#[inline(always)]
pub(crate) fn compare_squares<L: Lanes>(
    l: L,
    [x, y, z, radii]: [L::D; 4],
    margin: f64,
) -> [u32; 2] {
    let squares = l.add_d(l.add_d(l.mul_d(x, x), l.mul_d(y, y)), l.mul_d(z, z));
    let least = l.splat_d(f64::MIN_POSITIVE);
    let reach = l.add_d(radii, l.splat_d(margin));
    let reach = l.mul_d(l.mul_d(reach, reach), l.splat_d(1.0 + 16.0 * UNIT));
    let within = l.mul_d(l.mul_d(radii, radii), l.splat_d(1.0 - 16.0 * UNIT));
    // Both are false for NaN.
    [l.lt_d(l.add_d(reach, least), squares), l.lt_d(squares, l.sub_d(within, least))]
}

/// How far apart two spheres are; `None` where it is not proved that they are apart and within a margin, metres, or not with a
/// bound of at most `sharp` times the distance.
#[inline(always)]
pub(crate) fn distance_within(
    spheres: [PlacedSphere; 2],
    margin: f64,
    sharp: f64,
) -> Option<Distance> {
    let spheres = Spheres::of(spheres)?;
    let Gap { value, error } = spheres.sharpened(spheres.gap(), sharp)?;
    // The upper bound is a step of f64 above the sum.
    let is_proved = value > error && value + error < margin;
    is_proved.then(|| {
        let (normal, point_a, point_b) = spheres.witnesses();
        Distance { distance: value, point_a, point_b, normal, error_bound: error }
    })
}

/// How deep they overlap, if the bound is at most `sharp` times the depth (or [`LONG_SHARP`]). They are known to touch, or the depth is
/// proved to be more than its bound.
pub(super) fn depth(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    sharp: f64,
) -> Option<Depth> {
    depth_of_spheres([a, b].map(PlacedSphere::of), sharp)
}

/// The same of spheres.
#[inline(always)]
pub(crate) fn depth_of_spheres(spheres: [PlacedSphere; 2], sharp: f64) -> Option<Depth> {
    let spheres = Spheres::of(spheres)?;
    let gap = spheres.gap();
    let Gap { value, error } = spheres.sharpened(gap, sharp)?;
    let is_proved = value < -error;
    is_proved.then(|| {
        let (normal, point_a, point_b) = spheres.witnesses();
        Depth { depth: -value, normal, point_a, point_b, error_bound: error }
    })
}

/// How far the witnesses of a depth may be off their spheres, in world coordinates: metres.
#[inline(always)]
pub(crate) fn off_surface([a, b]: [PlacedSphere; 2]) -> f64 {
    // A point is no farther than its centre and the radius.
    UNIT * ((SURFACE + 1.0) * (a.radius + b.radius) + 2.0 * (a.centre.norm1() + b.centre.norm1()))
}

/// [`depth_of_spheres`] of shapes; `None` of others.
#[inline]
pub(crate) fn depth_of_two_spheres(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    sharp: f64,
) -> Option<Depth> {
    depth_of_spheres(two_spheres(a, b)?, sharp)
}

/// Two spheres round the origins of their own frames; `None` of others.
#[inline]
pub(crate) fn two_spheres(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<[PlacedSphere; 2]> {
    let placed = |side: PosedShape<'_>| match side.shape {
        // Of a part that was moved the centre is elsewhere.
        Shape::Polytope(sphere) if *sphere.vertices() == [DVec3::ZERO] => {
            Some(PlacedSphere { centre: side.pose.translation(), radius: sphere.swept_radius() })
        }
        _ => None,
    };
    Some([placed(a)?, placed(b)?])
}

impl Gap {
    #[inline(always)]
    fn is_within(self, sharp: f64) -> bool {
        self.error <= sharp * self.value.abs()
    }
}

impl Spheres {
    /// `None` where squares could under- or overflow, and for spheres with one centre.
    #[inline(always)]
    fn of(spheres: [PlacedSphere; 2]) -> Option<Self> {
        let (centres, radii) = (spheres.map(|s| s.centre), spheres.map(|s| s.radius));
        let between = centres[0] - centres[1];
        let length = between.length();
        // False for NaN.
        let is_in_range = SIZES.contains(&length) && radii[0] + radii[1] < SIZES.end;
        is_in_range.then_some(Self { between, length, centres, radii })
    }

    #[inline(always)]
    fn gap(&self) -> Gap {
        let radius = self.radii[0] + self.radii[1];
        let value = self.length - radius;
        // The sum of the radii and the difference lose one u each; one covers this product.
        let error = UNIT * ((LENGTH + 2.0) * self.length + 3.0 * radius);
        Gap { value, error }
    }

    /// The same if its bound is good enough, else in double-double; `None` where that is not good enough either.
    #[inline(always)]
    fn sharpened(&self, gap: Gap, sharp: f64) -> Option<Gap> {
        if gap.is_within(sharp) {
            return Some(gap);
        }
        Some(self.long_gap()).filter(|gap| gap.is_within(LONG_SHARP))
    }

    #[cold]
    #[inline(never)]
    fn long_gap(self) -> Gap {
        let [a, b] = self.centres.map(|centre| centre.to_array());
        let squared = |k: usize| {
            let component = two_sum(a[k], -b[k]);
            component.times(&component)
        };
        let length = squared(0).plus(&squared(1)).plus(&squared(2)).sqrt();
        let radius = two_sum(self.radii[0], self.radii[1]);
        let value = length.minus(&radius);
        let lost = double_double::EPSILON
            * ((LONG_LENGTH + 2.0) * self.length + 3.0 * DoubleDouble::to_f64(radius));
        let value = value.to_f64();
        Gap { value, error: lost + 2.0 * UNIT * value.abs() }
    }

    /// The normal from a to b, and the point of each on the line through the centres.
    #[inline(always)]
    fn witnesses(&self) -> (DVec3, DVec3, DVec3) {
        let normal = self.between / -self.length;
        let [a, b] = self.centres;
        (normal, a + normal * self.radii[0], b - normal * self.radii[1])
    }
}
