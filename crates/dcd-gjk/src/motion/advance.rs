//! The bulk of a search: one GJK whose every proved direction moves the time on.
//!
//! A support along a direction proves a gap there; nothing closes it before a time that follows. The search goes on
//! from that time with the same vertices at their new places, so that it takes about as many supports as one
//! distance (for translations: van den Bergen, "Ray casting against general convex objects", 2004).

use super::{Closing, MovingShape};
use crate::certificate::{Bounds, combined_length};
use crate::gjk::{Simplex, start, unit};
use crate::{Difference, PosedSupport, Vertex};
use dcd_geom::glam::DVec3;
use dcd_geom::{PoseError, Shape};

/// From which share of the known distance on a gap moves the time at once. No unit. Larger: more supports a time.
/// Smaller: more times. Decides the way, never the answer.
const WORTH: f64 = 0.5;

/// How many supports are taken. Hulls need some ten. Smaller: more is left to the slower loop behind.
const SUPPORTS: usize = 64;

/// Until when nothing meets, as far as single directions prove it: `None` for all of the time. `off` is what poses
/// are off by, and the search ends where the shapes are within `tolerance`, metres.
///
/// Proved: at each time the gap along a direction, less `off`, over the closing speed along it.
pub(super) fn advance(
    [a, b]: [MovingShape<'_>; 2],
    closing: &Closing,
    [until, tolerance, off]: [f64; 3],
) -> Result<Option<f64>, PoseError> {
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
            let Some((gap, axis)) = search.support() else { return Ok(Some(next)) };
            let gap = gap - off;
            if gap > 0.0 {
                let speed = closing.along(axis);
                // A quotient and a sum, rounded down with room.
                let then = t + gap / speed * (1.0 - 1e-12);
                if speed <= 0.0 || then > until {
                    return Ok(None);
                }
                next = next.max(then);
                if gap >= WORTH * search.distance() {
                    break;
                }
            }
            if search.distance() <= tolerance || supports >= SUPPORTS || !search.step() {
                break;
            }
        }
        let is_near = search.distance() <= tolerance;
        simplex = search.simplex;
        // Written so that NaN ends it.
        if is_near || !(next > t) {
            return Ok(Some(next));
        }
        t = next;
    }
    Ok(Some(t))
}

/// GJK at one time.
struct Search<'a, 'b> {
    difference: &'a Difference<'b, f64, Shape, Shape>,
    bounds: Bounds<f64>,
    simplex: Simplex<f64>,
    direction: DVec3,
    newest: Option<Vertex<f64>>,
    squared: f64,
    length: f64,
}

impl<'a, 'b> Search<'a, 'b> {
    /// From vertices of an earlier time, which are vertices still.
    fn of(difference: &'a Difference<'b, f64, Shape, Shape>, known: Simplex<f64>) -> Self {
        let mut search = Self {
            difference,
            bounds: Bounds::of(difference),
            simplex: Simplex::default(),
            direction: start::<f64>(difference.middle()),
            newest: None,
            squared: f64::MAX,
            length: f64::MAX,
        };
        for vertex in known.vertices() {
            let w = difference.world(vertex.a.point, vertex.b.point);
            search.simplex.push(Vertex { w, ..*vertex });
        }
        if !search.simplex.vertices().is_empty() {
            search.narrow();
        }
        search
    }

    /// The gap along the direction, metres, and the axis from a to b that it is along. `None` where that is no number.
    fn support(&mut self) -> Option<(f64, DVec3)> {
        let (vertex, separation) = self.difference.lowest(self.direction);
        self.newest = Some(vertex);
        let lower = self.bounds.lower_bound(self.direction, separation);
        let gap = (lower - self.bounds.swept_upper()).next_down() / self.difference.scale();
        gap.is_finite().then_some((gap, -self.direction))
    }

    /// How far apart the shapes are at most, as computed, metres.
    fn distance(&self) -> f64 {
        (self.length - self.bounds.radius()) / self.difference.scale()
    }

    /// Takes the newest vertex in; whether it leads on.
    fn step(&mut self) -> bool {
        match self.newest.take() {
            Some(vertex) if !self.simplex.holds(&vertex) => {
                self.simplex.push(vertex);
                self.narrow()
            }
            _ => false,
        }
    }

    /// Keeps the vertices that span the point nearest to the origin; whether that came nearer and leaves a direction.
    fn narrow(&mut self) -> bool {
        let Some(near) = self.simplex.nearest() else { return false };
        let squared = near.square[0] / near.square[1];
        if !(squared < self.squared) {
            return false;
        }
        self.squared = squared;
        self.simplex.keep(&near);
        self.length = combined_length(self.simplex.vertices(), near.weights());
        match unit::<f64>(near.direction) {
            Some(next) if !self.bounds.passes_through(squared) => {
                self.direction = next;
                true
            }
            _ => false,
        }
    }
}
