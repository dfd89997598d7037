//! GJK in f64 to the nearest point, with bounds on the distance from both sides.

use super::warm_start::warm_start;
use super::{Distance, UNIT, rounded_up, unit as of_unit_length};
use crate::certificate::{Bounds, combined_length};
use crate::closed::feature_normal::{ASIDE, HARDLY_APART, Tangents, normals};
use crate::gjk::{MAX_SUPPORTS, Simplex, start, unit};
use crate::supports::{InBlocks, lowest};
use crate::{Difference, PosedSupport, Reason, Verdict, Vertex};
use dcd_geom::glam::DVec3;
use dcd_geom::{Support, SupportMap};

/// How much farther away the next point may be by what its length loses. Unit: u, lengths below 1. Derived: 12. Larger: points that weights
/// of rounding make. Smaller: searches that end early.
const COMBINED: f64 = 16.0;

/// The nearest point found. Lengths are those of the difference.
#[derive(Clone, Copy)]
pub(crate) struct Approach {
    /// The vertices that span it.
    pub(crate) simplex: Simplex<f64>,
    /// Their weights, up to a common factor.
    pub(crate) weights: [f64; 4],
    /// From the origin to it, its largest component 1.
    pub(crate) direction: DVec3,
    /// Its distance from the origin, as computed.
    pub(crate) length: f64,
    /// At least the cores' distance.
    pub(crate) upper: f64,
    /// At most the cores' distance.
    pub(crate) lower: f64,
}

/// `gap` is how near its bounds have to come, as a length of the difference; 0 for all that f64 has. It is written over `near`,
/// one that [begins](Approach::begin), with a simplex to start from or without: a copy of it takes a tenth of a search.
///
/// # Errors
/// The verdict, where the cores surely overlap or nothing could be found.
pub(crate) fn approach<S: InBlocks>(
    difference: &Difference<'_, f64, S, S>,
    bounds: &Bounds<f64>,
    gap: f64,
    near: &mut Approach,
) -> Result<(), Verdict<()>> {
    let limits = [gap, f64::MAX];
    if near.simplex.vertices().is_empty() {
        warm_start(difference, &mut near.simplex);
    }
    let is_warm = !near.simplex.vertices().is_empty();
    near.search(difference, bounds, limits)?;
    if !is_warm || near.length >= HARDLY || near.lower > 0.0 {
        return Ok(());
    }
    // Begun where it ends, the search has tried no direction but that, which may be rounding: from afar it comes by others.
    let mut other = Approach::begin(difference);
    other.search(difference, bounds, limits)?;
    if other.lower > near.lower {
        *near = other;
    }
    Ok(())
}

/// The same from the nearest point of a simplex, if it has a vertex, and to where the cores are known to be at least
/// `enough` apart, which may be before there is a simplex.
pub(crate) fn approach_from<A: InBlocks, B: InBlocks>(
    difference: &Difference<'_, f64, A, B>,
    bounds: &Bounds<f64>,
    [gap, enough]: [f64; 2],
    first: Simplex<f64>,
) -> Result<Approach, Verdict<()>> {
    let mut near = Approach { simplex: first, ..Approach::begin(difference) };
    near.search(difference, bounds, [gap, enough])?;
    Ok(near)
}

impl Approach {
    /// Of nothing yet, along the line between the centres.
    pub(crate) fn begin<A: InBlocks, B: InBlocks>(difference: &Difference<'_, f64, A, B>) -> Self {
        Self::towards(start::<f64>(difference.middle()))
    }

    /// Comes to the nearest point of its simplex, whose bounds are not known yet; false where that has none.
    pub(super) fn come_to_nearest(&mut self) -> bool {
        let Some(near) = self.simplex.nearest() else { return false };
        self.simplex.keep(&near);
        self.weights = near.weights;
        true
    }

    /// Goes on from where it stands: see [`approach_from`].
    fn search<A: InBlocks, B: InBlocks>(
        &mut self,
        difference: &Difference<'_, f64, A, B>,
        bounds: &Bounds<f64>,
        [gap, enough]: [f64; 2],
    ) -> Result<(), Verdict<()>> {
        let best = self;
        // The direction that `lower` is known by, and what the one that was tried last bounds.
        let (mut proved, mut last_lower) = (best.direction, -f64::MAX);
        let mut nearest_so_far = f64::MAX;
        for step in 0..MAX_SUPPORTS {
            let mut known = best.simplex.vertices().len();
            if step == 0 && known > 0 {
                // Of the first simplex the nearest point is not known yet.
                known = 0;
            } else {
                let (vertex, separation) = lowest(difference, best.direction);
                let along = separation / best.direction.length();
                last_lower = bounds.lower_bound_along(along);
                if last_lower > best.lower {
                    (best.lower, proved) = (last_lower, best.direction);
                }
                // The gap is closed to the last bit, or the vertex is nothing new.
                let is_closed =
                    best.length - along <= UNIT * best.length || best.upper - best.lower <= gap;
                if is_closed || best.lower >= enough || best.simplex.holds(&vertex) {
                    break;
                }
                best.simplex.push(vertex);
            }
            let Some(near) = best.simplex.nearest() else { break };
            let squared = near.square[0] / near.square[1];
            if !(squared < nearest_so_far) {
                best.simplex.truncate(known);
                break;
            }
            let vertices = best.simplex.vertices();
            let kept = near.kept[..near.count].iter().map(|&k| &vertices[k]);
            let length = combined_length(kept, near.weights());
            // Of a flat tetrahedron the weights may be rounding: the point that they make is farther away then.
            if known > 0 && length > best.length + COMBINED * UNIT {
                best.simplex.truncate(known);
                break;
            }
            nearest_so_far = squared;
            best.simplex.keep(&near);
            (best.weights, best.length) = (near.weights, length);
            best.upper = best.upper.min(bounds.upper_bound(best.length));
            if bounds.simplex_touches(&best.simplex) {
                return Err(Verdict::Touching(()));
            }
            match unit::<f64>(near.direction) {
                Some(next) if !bounds.passes_through(squared) => {
                    (best.direction, last_lower) = (next, -f64::MAX);
                }
                // Rounding is all that parts the simplex from the origin: its normal bounds how deep the
                // two overlap at most, if it does so better than what was tried before.
                Some(last) => {
                    let (_, separation) = lowest(difference, last);
                    let lower = bounds.lower_bound(last, separation);
                    if lower > best.lower {
                        (best.lower, best.direction, last_lower) = (lower, last, lower);
                    }
                    break;
                }
                None => break,
            }
        }
        // Of cores that are hardly apart the last direction may be rounding; along it the shapes would be deeper than is said.
        if best.length < HARDLY && best.lower - last_lower > TURNED * UNIT {
            best.direction = proved;
        }
        // Not even one vertex, though they are not known to be far: a foreign map answered NaN.
        let found = !best.simplex.vertices().is_empty() || best.lower >= enough;
        if found { Ok(()) } else { Err(Verdict::Undecided(Reason::WithinRounding)) }
    }
}

/// Below that length of the difference, which is no larger than 1, the direction of the nearest point may be turned by
/// rounding so far that the shapes reach more than 1e-8 farther along it. Larger: points that are not the nearest, beside each other.
const HARDLY: f64 = 1e-7;

/// How much less than the best the last direction may bound and be kept, for it is the nearest point's: u of the pair's size,
/// some of what a bound loses. Larger: depths that are exceeded along their normals. Smaller: normals of rounding.
const TURNED: f64 = 8.0;

/// What two points, one of each core and in its frame, prove, if their bounds are as near as a search's end:
/// within `gap`, or what f64 leaves.
pub(crate) fn proposed<S: InBlocks>(
    difference: &Difference<'_, f64, S, S>,
    bounds: &Bounds<f64>,
    gap: f64,
    points: [DVec3; 2],
) -> Option<Approach> {
    let proposal = Proposal::of(difference, points);
    proposal.along(difference, bounds, (gap, proposal.w))
}

/// The same of points that may all but meet: there the common normal of the features on which they are says more than the line
/// between them. The tangents are of these, world axes.
pub(super) fn proposed_by_features<S: InBlocks>(
    difference: &Difference<'_, f64, S, S>,
    bounds: &Bounds<f64>,
    gap: f64,
    (points, tangents): ([DVec3; 2], impl FnOnce() -> [Tangents; 2]),
) -> Option<Approach> {
    let proposal = Proposal::of(difference, points);
    let w = proposal.w;
    let by_line = proposal.along(difference, bounds, (gap, w));
    if by_line.is_some() || w.length() >= HARDLY_APART {
        return by_line;
    }
    // Along the normal points beside each other are not as far apart as they are, nor is what is swept round them.
    let is_along = |found: &Approach| {
        let n = of_unit_length(found.direction);
        let aside = (w - n * n.dot(w)).length();
        aside <= ASIDE * UNIT
    };
    normals(w, difference.size(), tangents())
        .filter_map(|normal| proposal.along(difference, bounds, (gap, normal)))
        .find(is_along)
}

/// A point of each core, in its own frame, and their difference.
struct Proposal {
    points: [DVec3; 2],
    w: DVec3,
}

impl Proposal {
    fn of<S: InBlocks>(difference: &Difference<'_, f64, S, S>, points: [DVec3; 2]) -> Self {
        let [point_a, point_b] = points;
        Self { points, w: difference.world(point_a, point_b) }
    }

    /// What they prove by a direction of any length.
    fn along<S: InBlocks>(
        &self,
        difference: &Difference<'_, f64, S, S>,
        bounds: &Bounds<f64>,
        (gap, direction): (f64, DVec3),
    ) -> Option<Approach> {
        let Self { points, w } = *self;
        let [point_a, point_b] = points;
        let direction = unit::<f64>(direction.to_array())?;
        let (_, separation) = lowest(difference, direction);
        let lower = bounds.lower_bound(direction, separation);
        let length = w.length();
        let upper = bounds.upper_bound(length) + PROPOSED * UNIT;
        debug_assert!(!(upper < lower), "points that are not of the cores: {points:?}");
        let is_close = lower > 0.0 && upper - lower <= gap.max(CLOSE * UNIT);
        let support = |point| Support { point, feature: 0 };
        let mut simplex = Simplex::default();
        simplex.push(Vertex { w, a: support(point_a), b: support(point_b) });
        let weights = [1.0, 0.0, 0.0, 0.0];
        is_close.then_some(Approach { simplex, weights, direction, length, upper, lower })
    }
}

/// How far a proposed point of each core may be from it beyond a support's error. Unit: u of the pair's size. A
/// point between two vertices loses 5u of the reach a component.
const PROPOSED: f64 = 9.0;

/// How near the bounds of a proposal have to come. Unit: u of the pair's size, which is below 1: what a search
/// leaves between supports with errors of 20u.
const CLOSE: f64 = 256.0;

impl Approach {
    /// Of nothing yet, along a direction whose largest component is 1.
    pub(crate) fn towards(direction: DVec3) -> Self {
        Self {
            simplex: Simplex::default(),
            weights: [0.0; 4],
            direction,
            length: f64::MAX,
            upper: f64::MAX,
            lower: -f64::MAX,
        }
    }

    /// With the bounds of an earlier search. That one is taken where both together prove the shapes apart and it bounds the
    /// distance from below better than rounding does, and by more than the gap that both may leave: along the direction of the later
    /// one the shapes would be nearer than is said. Where nothing is proved, the one whose points are nearer: no more than that is known of the distance.
    pub(super) fn or_earlier(self, earlier: &Self, bounds: &Bounds<f64>, gap: f64) -> Self {
        let (lower, upper) = (self.lower.max(earlier.lower), self.upper.min(earlier.upper));
        let is_earlier = match lower > bounds.swept_upper() {
            true => earlier.lower - self.lower > gap.max(TURNED * UNIT),
            false => earlier.length < self.length,
        };
        Self { lower, upper, ..if is_earlier { *earlier } else { self } }
    }

    /// The points of the two cores, world frame, metres.
    pub(crate) fn points<A: SupportMap<f64>, B: SupportMap<f64>>(
        &self,
        a: PosedSupport<'_, A>,
        b: PosedSupport<'_, B>,
    ) -> [DVec3; 2] {
        let total: f64 = self.weights[..self.simplex.vertices().len()].iter().sum();
        let sum = |point: fn(&Vertex<f64>) -> DVec3| {
            let vertices = self.simplex.vertices().iter().zip(self.weights);
            vertices
                .fold(DVec3::ZERO, |sum, (vertex, weight)| sum + point(vertex) * (weight / total))
        };
        [a.pose.apply(sum(|vertex| vertex.a.point)), b.pose.apply(sum(|vertex| vertex.b.point))]
    }

    /// Of swept shapes that the bounds prove apart.
    pub(crate) fn distance<A: SupportMap<f64>, B: SupportMap<f64>>(
        &self,
        bounds: &Bounds<f64>,
        scale: f64,
        bodies: (PosedSupport<'_, A>, PosedSupport<'_, B>),
    ) -> Distance {
        let radius = bounds.radius();
        let distance = self.length - radius;
        // The radii's own rounding is in swept_upper; 4 ulps for this function's arithmetic.
        let above = self.upper - radius * (1.0 - 8.0 * UNIT) - distance;
        let below = distance - (self.lower - bounds.swept_upper());
        let error = above.max(below) + 4.0 * f64::EPSILON * self.length;
        let error_bound = rounded_up(error / scale);
        Distance { distance: distance / scale, error_bound, ..self.witnesses(bodies) }.saturated()
    }

    /// Of shapes that the bounds do not prove apart: 0, and how far apart they are at most.
    pub(super) fn within<S: SupportMap<f64>>(
        &self,
        bounds: &Bounds<f64>,
        scale: f64,
        bodies: (PosedSupport<'_, S>, PosedSupport<'_, S>),
    ) -> Distance {
        let above = self.upper - bounds.radius() * (1.0 - 8.0 * UNIT);
        let error = above * (1.0 + 4.0 * f64::EPSILON);
        let error_bound = rounded_up(error / scale);
        Distance { distance: 0.0, error_bound, ..self.witnesses(bodies) }.saturated()
    }

    fn witnesses<A: SupportMap<f64>, B: SupportMap<f64>>(
        &self,
        (a, b): (PosedSupport<'_, A>, PosedSupport<'_, B>),
    ) -> Distance {
        let normal = of_unit_length(-self.direction);
        let [core_a, core_b] = self.points(a, b);
        let point_a = core_a + normal * a.map.radius();
        let point_b = core_b - normal * b.map.radius();
        Distance { normal, point_a, point_b, ..Distance::default() }
    }
}
