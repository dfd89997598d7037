//! The bulk of a search: one GJK whose every proved direction moves the time on.
//!
//! A support along a direction proves a gap there; nothing closes it before a time that follows. The search goes on
//! from that time with the same vertices at their new places, so that it takes about as many supports as one
//! distance (for translations: van den Bergen, "Ray casting against general convex objects", 2004).

use super::{Closing, MovingShape};
use crate::certificate::{Bounds, combined_length};
use crate::distance::{Approach, Distance};
use crate::gjk::{Simplex, start, unit};
use crate::{Difference, PosedSupport, Vertex};
use dcd_geom::glam::DVec3;
use dcd_geom::{PoseError, Shape};

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
    let mut t = 0.0;
    let mut simplex = Simplex::<f64>::default();
    let mut supports = 0;
    while supports < SUPPORTS {
        let (pose_a, pose_b) = (a.motion.pose_at(t)?, b.motion.pose_at(t)?);
        let (posed_a, posed_b) =
            (PosedSupport::shape(a.shape, &pose_a), PosedSupport::shape(b.shape, &pose_b));
        let Some(difference) = Difference::new(posed_a, posed_b) else { break };
        let mut search = Search::of(&difference, simplex);
        let mut next = t;
        loop {
            supports += 1;
            let Some((gap, axis)) = search.support() else { return Ok(Advance::Until(next)) };
            let gap = gap - off;
            if gap > 0.0 {
                let speed = closing.along(axis);
                // A quotient and a sum, rounded down by more than they lose.
                let then = t + gap / speed * (1.0 - 1e-12);
                if speed <= 0.0 || then > until {
                    return Ok(Advance::Free);
                }
                next = next.max(then);
                if gap >= WORTH * search.distance() && gap > tolerance {
                    break;
                }
            }
            if search.distance() <= tolerance || supports >= SUPPORTS || !search.step() {
                break;
            }
        }
        if let Some(found) = search.apart([posed_a, posed_b])
            && found.upper() <= tolerance
        {
            return Ok(Advance::Near(t, found));
        }
        simplex = search.near.simplex;
        // Written so that NaN ends it.
        if !(next > t) {
            break;
        }
        t = next;
    }
    Ok(Advance::Until(t))
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

    /// The gap along the direction, metres, and the axis from a to b that it is along. `None` where that is no number.
    fn support(&mut self) -> Option<(f64, DVec3)> {
        let direction = self.near.direction;
        let (vertex, separation) = self.difference.lowest(direction);
        self.newest = Some(vertex);
        let lower = self.bounds.lower_bound(direction, separation);
        self.near.lower = self.near.lower.max(lower);
        let gap = (lower - self.bounds.swept_upper()).next_down() / self.difference.scale();
        gap.is_finite().then_some((gap, -direction))
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
