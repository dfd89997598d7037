//! The bulk of a search: one GJK whose every proved direction moves the time on.
//!
//! A support along a direction proves a gap there; nothing closes it before a time that follows. The search goes on
//! from that time with the same vertices at their new places, so that it takes about as many supports as one
//! distance (for translations: van den Bergen, "Ray casting against general convex objects", 2004).
//!
//! A bound on the speed is slow where shapes turn: it is that of the point that closes fastest, and not of the one that
//! meets first. So a gap is also proved at a later time along the same direction; in between it is at least that of
//! the chord less what the paths bend.

use super::supports::lowest;
use super::{Closing, MovingShape, cast};
use crate::certificate::{Bounds, combined_length};
use crate::distance::{Approach, Distance};
use crate::gjk::{Simplex, start, unit};
use crate::{Difference, PosedSupport, Vertex};
use dcd_geom::glam::DVec3;
use dcd_geom::{Pose, PoseError, Shape};

/// From which share of the known distance on a gap moves the time at once. No unit. Larger: more supports a time.
/// Smaller: more times. Decides the way, never the answer.
const WORTH: f64 = 0.5;

/// How many supports are taken. Hulls need some ten. Smaller: more is left to the slower loop behind.
const SUPPORTS: usize = 64;

/// How far single directions lead.
pub(super) enum Advance {
    /// Proved: nothing meets at any time.
    Free,
    /// Proved: nothing meets before this time.
    Until(f64),
    /// The same, and that the shapes are apart and within the tolerance there.
    Near(f64, Distance),
}

/// Until when nothing meets, as far as single directions prove it. `off` is what poses are off by, and the search
/// ends where the shapes are within `tolerance`, metres.
///
/// Proved: at each time the gap along a direction, less `off`, over the closing speed along it.
pub(super) fn advance(
    [a, b]: [MovingShape<'_>; 2],
    closing: &Closing,
    [until, tolerance, off]: [f64; 3],
) -> Result<Advance, PoseError> {
    let mut t = match cast::cast([a, b], closing, [until, tolerance, off])? {
        None => 0.0,
        Some(Advance::Until(t)) => t,
        Some(found) => return Ok(found),
    };
    let mut simplex = Simplex::<f64>::default();
    let mut supports = 0;
    let mut leap: Option<Leap> = None;
    while supports < SUPPORTS {
        let at = leap.map_or(t, |leap| leap.to);
        let (pose_a, pose_b) = (a.motion.pose_at(at)?, b.motion.pose_at(at)?);
        let (posed_a, posed_b) =
            (PosedSupport::shape(a.shape, &pose_a), PosedSupport::shape(b.shape, &pose_b));
        let Some(difference) = Difference::new(posed_a, posed_b) else { break };
        if let Some(leap) = leap.take() {
            supports += 1;
            let found = Support::along(&difference, &Bounds::of(&difference), leap.direction);
            if !found.is_some_and(|found| found.gap - off > leap.bend) {
                t = leap.otherwise;
                continue;
            }
            if leap.to >= until {
                return Ok(Advance::Free);
            }
            t = leap.to;
        }
        let mut search = Search::of(&difference, simplex);
        let mut next = t;
        loop {
            supports += 1;
            let Some(Support { gap, vertex, .. }) = search.support() else {
                return Ok(Advance::Until(next));
            };
            let (gap, direction) = (gap - off, search.near.direction);
            if gap > 0.0 {
                let speed = closing.along(-direction);
                // A quotient and a sum, rounded down by more than they lose.
                let then = t + gap / speed * (1.0 - 1e-12);
                if speed <= 0.0 || then > until {
                    return Ok(Advance::Free);
                }
                next = next.max(then);
                if gap >= WORTH * search.distance() && gap > tolerance {
                    let arms = [arm(a, &pose_a, vertex.a.point), arm(b, &pose_b, vertex.b.point)];
                    let rate = closing.rate(-direction, arms);
                    let ahead = Ahead { gap, rate, from: t, until, least: 0.5 * tolerance };
                    leap = ahead.leap(closing, direction, next);
                    break;
                }
            }
            if search.distance() <= tolerance || supports >= SUPPORTS || !search.step() {
                break;
            }
        }
        if leap.is_none()
            && let Some(found) = search.apart([posed_a, posed_b])
            && found.upper() <= tolerance
        {
            return Ok(Advance::Near(t, found));
        }
        simplex = search.near.simplex;
        // Written so that NaN ends it.
        if leap.is_none() && !(next > t) {
            break;
        }
        if leap.is_none() {
            t = next;
        }
    }
    Ok(Advance::Until(leap.map_or(t, |leap| leap.otherwise)))
}

/// From the centre of a motion to a point of the shape at a pose.
fn arm(side: MovingShape<'_>, pose: &Pose, point: DVec3) -> DVec3 {
    *pose.rotation() * (point - side.motion.centre)
}

/// A gap along a direction that is to be proved at a later time as well.
#[derive(Clone, Copy)]
struct Leap {
    direction: DVec3,
    to: f64,
    /// What the gaps at both ends have to exceed, metres: how far the paths bend off their chords between them.
    bend: f64,
    /// Until when the speed alone proves that nothing meets.
    otherwise: f64,
}

/// What is known of the gap along a direction: metres, and metres a unit of time.
struct Ahead {
    gap: f64,
    /// At which it closes as far as the points go that are nearest now.
    rate: f64,
    from: f64,
    until: f64,
    /// The gap to be left at the least.
    least: f64,
}

/// Which part of a gap a leap leaves. Smaller: more leaps fail. Larger: more leaps. Decides the way, never the answer.
const LEFT: f64 = 1.0 / 32.0;

/// By what factor a leap leads farther than the speed, to be tried.
const FARTHER: f64 = 1.1;

impl Ahead {
    fn leap(&self, closing: &Closing, direction: DVec3, otherwise: f64) -> Option<Leap> {
        let bending = closing.bending(direction);
        if bending == 0.0 {
            return None;
        }
        let &Self { gap, rate, from, until, least } = self;
        let whole = (until - from).min(if rate > 0.0 { gap / rate } else { f64::INFINITY });
        // A point's path bends by half of that at the most, most often by less.
        let left = (LEFT * gap).max(least) + 0.25 * bending * whole * whole;
        let to_left = if rate > 0.0 { (gap - left) / rate } else { f64::INFINITY };
        // A quarter of the gap for the bend.
        let step = to_left.min((2.0 * gap / bending).sqrt());
        let to = (from + step).min(until);
        let is_farther = to - from > FARTHER * (otherwise - from) && to > from;
        let duration = to - from;
        let bend = 0.125 * bending * duration * duration * (1.0 + 1e-12);
        (is_farther && gap > bend).then_some(Leap { direction, to, bend, otherwise })
    }
}

/// A support along a direction, and what it proves.
struct Support {
    vertex: Vertex<f64>,
    /// At most the distance of the cores, scaled.
    lower: f64,
    /// At most the gap of the shapes along the direction, metres.
    gap: f64,
}

impl Support {
    /// `None` where the gap is no number.
    fn along(
        difference: &Difference<'_, f64, Shape, Shape>,
        bounds: &Bounds<f64>,
        direction: DVec3,
    ) -> Option<Self> {
        let (vertex, separation) = lowest(difference, direction);
        let lower = bounds.lower_bound(direction, separation);
        let gap = (lower - bounds.swept_upper()).next_down() / difference.scale();
        gap.is_finite().then_some(Self { vertex, lower, gap })
    }
}

/// GJK at one time.
struct Search<'a, 'b> {
    difference: &'a Difference<'b, f64, Shape, Shape>,
    bounds: Bounds<f64>,
    near: Approach,
    newest: Option<Vertex<f64>>,
    squared: f64,
}

impl<'a, 'b> Search<'a, 'b> {
    /// From vertices of an earlier time, which are vertices still.
    fn of(difference: &'a Difference<'b, f64, Shape, Shape>, known: Simplex<f64>) -> Self {
        let mut search = Self {
            difference,
            bounds: Bounds::of(difference),
            near: Approach::towards(start::<f64>(difference.middle())),
            newest: None,
            squared: f64::MAX,
        };
        for vertex in known.vertices() {
            let w = difference.world(vertex.a.point, vertex.b.point);
            search.near.simplex.push(Vertex { w, ..*vertex });
        }
        if !search.near.simplex.vertices().is_empty() {
            search.narrow();
        }
        search
    }

    /// Along the direction to the nearest point known.
    fn support(&mut self) -> Option<Support> {
        let found = Support::along(self.difference, &self.bounds, self.near.direction)?;
        self.newest = Some(found.vertex);
        self.near.lower = self.near.lower.max(found.lower);
        Some(found)
    }

    /// How far apart the shapes are at most, as computed, metres.
    fn distance(&self) -> f64 {
        (self.near.length - self.bounds.radius()) / self.difference.scale()
    }

    /// How far apart the shapes are, where they are proved to be.
    fn apart(&self, bodies: [PosedSupport<'_, Shape>; 2]) -> Option<Distance> {
        let is_apart = self.near.lower > self.bounds.swept_upper() && self.near.length < f64::MAX;
        is_apart.then(|| self.near.distance(&self.bounds, self.difference.scale(), bodies))
    }

    /// Takes the newest vertex in; whether it leads on.
    fn step(&mut self) -> bool {
        match self.newest.take() {
            Some(vertex) if !self.near.simplex.holds(&vertex) => {
                self.near.simplex.push(vertex);
                self.narrow()
            }
            _ => false,
        }
    }

    /// Keeps the vertices that span the point nearest to the origin; whether that came nearer and leaves a direction.
    fn narrow(&mut self) -> bool {
        let Some(found) = self.near.simplex.nearest() else { return false };
        let squared = found.square[0] / found.square[1];
        if !(squared < self.squared) {
            self.near.simplex.pop();
            return false;
        }
        self.squared = squared;
        self.near.simplex.keep(&found);
        self.near.weights = found.weights;
        self.near.length = combined_length(self.near.simplex.vertices(), found.weights());
        self.near.upper = self.near.upper.min(self.bounds.upper_bound(self.near.length));
        match unit::<f64>(found.direction) {
            Some(next) if !self.bounds.passes_through(squared) => {
                self.near.direction = next;
                true
            }
            _ => false,
        }
    }
}
