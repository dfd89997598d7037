//! Spheres and capsules against cylinders and cones.
//!
//! A cylinder or cone is a profile turned round its axis: three half-planes of a plane through that axis.
//! Outside, the nearest point is one of the profile; along a segment the derivative of half the squared
//! distance never falls, so that its root is where the two are nearest. What is proposed is proved by the
//! pair's own bounds, as any two points are. Inside, the three half-planes are how deep a point is.

use super::feature_normal::Tangents;
use super::profile::Profile;
use super::{SIZES, UNIT};
use crate::epa::Depth;
use crate::{PosedShape, PosedSupport};
use dcd_geom::glam::{DVec2, DVec3};
use dcd_geom::{Curved, CurvedKind, Kind, Polytope, Shape, Vector};

/// How often the place along a segment is narrowed at most; ten are usual. Fewer: proposals that the bounds
/// refuse, and a search in their place.
const NARROWINGS: usize = 48;

/// The part of its first value to which the derivative falls at the root: beyond, it is rounding.
const FLAT: f64 = 4.0 * UNIT;

/// How far a point may be off where it is compared with the profile. Unit: u·(reaches + |δt|₁). Two rotations
/// of 3u a component, two sums, √3 of that; the profile's normal and the products 12u more.
const INSIDE: f64 = 48.0;

/// A curved shape and what is seen of the other in its frame.
struct Seen<'a> {
    curved: &'a Curved,
    /// From one end of the other's core, and along it; a point has no length.
    from: DVec3,
    along: DVec3,
}

/// The curved shape, and the other as a point or segment.
struct Couple<'a> {
    round: PosedSupport<'a, Polytope>,
    curved: &'a Curved,
    at: PosedShape<'a>,
    /// Whether the curved one is the second.
    swapped: bool,
}

impl<'a> Couple<'a> {
    fn of(a: PosedShape<'a>, b: PosedShape<'a>) -> Option<Self> {
        let is_round = |polytope: &Polytope| matches!(polytope.kind(), Kind::Point | Kind::Segment);
        Self::of_any(a, b).filter(|couple| is_round(couple.round.map))
    }

    /// With any polytope in the other's place.
    fn of_any(a: PosedShape<'a>, b: PosedShape<'a>) -> Option<Self> {
        let (curved, at, other, swapped) = match (a.shape, b.shape) {
            (Shape::Curved(curved), Shape::Polytope(_)) => (curved, a, b, false),
            (Shape::Polytope(_), Shape::Curved(curved)) => (curved, b, a, true),
            _ => return None,
        };
        let polytope = other.shape.as_polytope()?;
        let round = PosedSupport::polytope(polytope, other.pose);
        Some(Self { round, curved, at, swapped })
    }

    /// At least the length of every vector from the one core to the other: metres.
    fn size(&self) -> f64 {
        let delta = self.round.pose.translation() - self.at.pose.translation();
        let reach = self.round.reach + self.at.shape.reach();
        reach * (1.0 + self.at.pose.deviation()) + delta.norm1()
    }

    /// The ends of the other's core.
    fn ends(&self) -> Option<[DVec3; 2]> {
        match *self.round.map.vertices() {
            [point] => Some([point; 2]),
            [from, to] => Some([from, to]),
            _ => None,
        }
    }

    fn seen(&self, [from, to]: [DVec3; 2]) -> Seen<'a> {
        let delta = self.round.pose.translation() - self.at.pose.translation();
        let back = self.at.pose.rotation().transpose();
        let turn = *self.round.pose.rotation();
        let first = back * (turn * from + delta);
        Seen { curved: self.curved, from: first, along: back * (turn * (to - from)) }
    }

    /// A point of the curved core and one between two of the other's that are perhaps the nearest.
    fn nearest(self, ends: [DVec3; 2]) -> Option<NearestPoints<'a>> {
        if !SIZES.contains(&self.size()) {
            return None;
        }
        let seen = self.seen(ends);
        let t = seen.nearest_place();
        let place = seen.from + seen.along * t;
        let on_curved = nearest(self.curved, place);
        if on_curved == place {
            return None;
        }
        let [from, to] = ends;
        let on_round = if from == to { from } else { from + (to - from) * t };
        let points = if self.swapped { [on_round, on_curved] } else { [on_curved, on_round] };
        let along = if 0.0 < t && t < 1.0 { seen.along } else { DVec3::ZERO };
        Some(NearestPoints { points, couple: self, place, along })
    }
}

/// A point of each of two cores that are perhaps the nearest.
pub(crate) struct NearestPoints<'a> {
    /// Each in its own frame.
    pub(crate) points: [DVec3; 2],
    couple: Couple<'a>,
    /// The point of the other core, and along the edge that it is on or zeros, in the curved one's frame.
    place: DVec3,
    along: DVec3,
}

impl NearestPoints<'_> {
    /// Those of the features that the points are on, world axes.
    pub(crate) fn tangents(&self) -> [Tangents; 2] {
        let of_round = Tangents { straight: [self.along, DVec3::ZERO], ..Tangents::default() };
        let of_curved = Profile::of(self.couple.curved)
            .map(|profile| profile.tangents(&profile.foot(self.place), 0.0))
            .unwrap_or_default();
        let turn = *self.couple.at.pose.rotation();
        let [of_curved, of_round] = [of_curved, of_round].map(|tangents| tangents.turned(turn));
        if self.couple.swapped { [of_round, of_curved] } else { [of_curved, of_round] }
    }
}

/// A point of each core that are perhaps the nearest; `None` where the pair is of other kinds, or the cores meet.
pub(crate) fn nearest_points<'a>(
    a: PosedShape<'a>,
    b: PosedShape<'a>,
) -> Option<NearestPoints<'a>> {
    let couple = Couple::of(a, b)?;
    let ends = couple.ends()?;
    couple.nearest(ends)
}

/// The same of a curved shape and an edge of a polytope, given by its ends.
pub(crate) fn nearest_points_to_edge<'a>(
    a: PosedShape<'a>,
    b: PosedShape<'a>,
    ends: [DVec3; 2],
) -> Option<NearestPoints<'a>> {
    Couple::of_any(a, b)?.nearest(ends)
}

/// How deep a sphere whose centre is in the core of a cylinder or cone overlaps it, within `relative` of
/// itself or `of_size` of the pair's size.
pub(crate) fn depth_of_centre(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    [relative, of_size]: [f64; 2],
) -> Option<Depth> {
    let couple = Couple::of(a, b)?;
    if couple.round.map.kind() != Kind::Point {
        return None;
    }
    let size = couple.size();
    let point = couple.seen(couple.ends()?).from;
    let Couple { round, curved, at, swapped } = couple;
    let stretch = at.pose.deviation();
    let (inside, outward) = way_out(curved, point);
    let radius = curved.swept_radius() + round.map.swept_radius();
    let depth = inside + radius;
    // A pose that is no rotation stretches the profile by half its deviation, and what is seen of it by all.
    let error = INSIDE * UNIT * size + 2.0 * stretch * at.shape.reach() + 8.0 * UNIT * depth;
    let is_good = inside > error && error <= (of_size * size).max(relative * depth);
    if !(is_good && SIZES.contains(&size)) {
        return None;
    }
    let normal = (*at.pose.rotation() * outward).normalize();
    let centre = round.pose.apply(*round.map.vertices().first()?);
    // Of the curved shape's surface, and of the sphere's far side.
    let on_curved = centre + normal * (inside + curved.swept_radius());
    let on_round = centre - normal * round.map.swept_radius();
    let found = Depth { depth, normal, point_a: on_curved, point_b: on_round, error_bound: error };
    let is_finite = found.depth.is_finite() && on_curved.is_finite() && on_round.is_finite();
    is_finite.then(|| if swapped { found.mirrored() } else { found })
}

impl Seen<'_> {
    /// Half the derivative of the squared distance, by the place along the segment.
    fn slope(&self, t: f64) -> f64 {
        let place = self.from + self.along * t;
        (place - nearest(self.curved, place)).dot(self.along)
    }

    /// Where in [0, 1] the segment is nearest: the root of the slope, between two places at which it has
    /// different signs (regula falsi; an end that stays counts half, after the Illinois method).
    fn nearest_place(&self) -> f64 {
        if self.along == DVec3::ZERO {
            return 0.0;
        }
        let (mut low, mut high) = (0.0, 1.0);
        let (mut at_low, mut at_high) = (self.slope(low), self.slope(high));
        if !(at_low < 0.0) {
            return low;
        }
        if !(at_high > 0.0) {
            return high;
        }
        let flat = FLAT * (at_high - at_low);
        let mut last_side = 0;
        for _ in 0..NARROWINGS {
            let t = (low * at_high - high * at_low) / (at_high - at_low);
            let t = if low < t && t < high { t } else { 0.5 * (low + high) };
            if !(low < t && t < high) {
                break;
            }
            let here = self.slope(t);
            if here.abs() <= flat {
                return t;
            }
            if here < 0.0 {
                (low, at_low) = (t, here);
                if last_side == -1 {
                    at_high *= 0.5;
                }
                last_side = -1;
            } else {
                (high, at_high) = (t, here);
                if last_side == 1 {
                    at_low *= 0.5;
                }
                last_side = 1;
            }
        }
        if at_high < -at_low { high } else { low }
    }
}

/// The nearest point of the core to a point of its frame: that point itself where it is inside.
pub(super) fn nearest(curved: &Curved, point: DVec3) -> DVec3 {
    let flat = point.truncate();
    let across = flat.length();
    let [(low, low_radius), (high, high_radius)] = curved.discs();
    let (across_there, z) = match curved.kind() {
        CurvedKind::Cylinder => (across.min(low_radius), point.z.clamp(low, high)),
        _ => {
            // From the rim to the apex.
            let side = DVec2::new(high_radius - low_radius, high - low);
            let from_rim = DVec2::new(across - low_radius, point.z - low);
            let is_outside = side.perp_dot(from_rim) < 0.0;
            if !is_outside {
                // Below the base the side's line goes on beyond the rim; that of a needle, or of a point, has no inner side.
                (across.min(low_radius), point.z.clamp(low, high))
            } else {
                let s = from_rim.dot(side) / side.length_squared();
                if s > 0.0 {
                    let s = s.min(1.0);
                    (low_radius + side.x * s, low + side.y * s)
                } else {
                    (across.min(low_radius), low)
                }
            }
        }
    };
    if across_there == across {
        return DVec3::new(flat.x, flat.y, z);
    }
    (flat * (across_there / across)).extend(z)
}

/// How far a point of the core is from the nearest of its faces, negative outside, and that face's outward
/// direction.
fn way_out(curved: &Curved, point: DVec3) -> (f64, DVec3) {
    let across = point.truncate().length();
    let outward = if across > 0.0 { point.truncate() / across } else { DVec2::X };
    let [(low, low_radius), (high, high_radius)] = curved.discs();
    let slant = DVec2::new(high - low, low_radius - high_radius).normalize_or(DVec2::X);
    let to_side = slant.x * (low_radius - across) - slant.y * (point.z - low);
    let mut best = (to_side, (outward * slant.x).extend(slant.y));
    for (distance, direction) in [(point.z - low, -DVec3::Z), (high - point.z, DVec3::Z)] {
        // A cone's apex is no face.
        let is_face = direction.z < 0.0 || high_radius > 0.0;
        if is_face && distance < best.0 {
            best = (distance, direction);
        }
    }
    best
}
