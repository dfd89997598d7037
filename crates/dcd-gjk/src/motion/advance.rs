//! The bulk of a search: one GJK whose every proved direction moves the time on.
//!
//! A support along a direction proves a gap there; nothing closes it before a time that follows. The search goes on
//! from that time with the same vertices at their new places, so that it takes about as many supports as one
//! distance (for translations: van den Bergen, "Ray casting against general convex objects", 2004).
//!
//! A bound on the speed is slow where shapes turn: it is that of the point that closes fastest, and not of the one that
//! meets first. So a gap is also proved at a later time along the same direction; in between it is at least that of
//! the chord less what the paths bend.

use super::{Closing, Limits, MovingShape, cast};
use crate::certificate::{Bounds, combined_length};
use crate::distance::{Approach, Distance};
use crate::gjk::{Simplex, start, unit};
use crate::supports::lowest;
use crate::{Difference, PosedSupport, Vertex};
use dcd_geom::glam::DVec3;
use dcd_geom::{Pose, PoseError, Shape};

/// From which share of the known distance on a gap moves the time at once. No unit. Larger: more supports a time.
/// Smaller: more times. Decides the way, never the answer.
const WORTH: f64 = 0.8;

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

/// Until when nothing meets, as far as single directions prove it. The search ends where the shapes are within the tolerance.
///
/// Proved: at each time the gap along a direction, less what poses are off by then, over the closing speed along it.
pub(super) fn advance(
    [a, b]: [MovingShape<'_>; 2],
    closing: &Closing,
    limits: &Limits,
) -> Result<Advance, PoseError> {
    let &Limits { until, tolerance, .. } = limits;
    let mut t = match cast::cast([a, b], closing, limits) {
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
        let mut search = GjkAt::of(&difference);
        if let Some(tried) = leap.take() {
            supports += 1;
            let found = Support::along(&difference, &search.bounds, tried.direction);
            let gap = found.map_or(f64::NAN, |found| found.gap - limits.off(at));
            if !tried.is_proved_by(gap) {
                leap = tried.shorter(gap);
                t = if leap.is_some() { t } else { tried.otherwise };
                continue;
            }
            if tried.to >= until {
                return Ok(Advance::Free);
            }
            t = tried.to;
        }
        search.begin_from(simplex);
        let mut next = t;
        loop {
            supports += 1;
            let Some(Support { gap, vertex, .. }) = search.support() else {
                return Ok(Advance::Until(next));
            };
            let (gap, direction) = (gap - limits.off(t), search.near.direction);
            if gap > 0.0 {
                let speed = closing.along(-direction);
                let then = limits.lasts(t, gap, speed);
                if speed <= 0.0 || then > until {
                    return Ok(Advance::Free);
                }
                next = next.max(then);
                if gap >= WORTH * search.distance() && gap > tolerance {
                    let arms = [arm(a, &pose_a, vertex.a.point), arm(b, &pose_b, vertex.b.point)];
                    let rates = closing.rates(-direction, arms);
                    let ahead = Ahead { gap, rates, from: t, until, least: 0.5 * tolerance };
                    leap = ahead.leap(closing, direction, next);
                    break;
                }
            }
            if search.distance() <= tolerance || supports >= SUPPORTS || !search.step() {
                break;
            }
        }
        if leap.is_none()
            && search.distance() <= tolerance
            && let Some(found) = search.apart([posed_a, posed_b])
            && limits.are_near(t, found.upper())
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
///
/// With gaps g₀ and g₁ at the ends and paths whose second derivative along it is at most c, the gap at a share s of the
/// duration T between is at least (1 − s)·g₀ + s·g₁ − ½·c·T²·s·(1 − s): above 0 where ½·c·T² ≤ g₀ and g₁ > 0.
#[derive(Clone, Copy, Debug)]
struct Leap {
    direction: DVec3,
    from: f64,
    to: f64,
    /// The gap at its beginning, metres.
    gap: f64,
    /// The gap that is to be left, metres.
    left: f64,
    /// c: at most the second derivative of a distance along the direction.
    bending: f64,
    /// Until when the speed alone proves that nothing meets.
    otherwise: f64,
    /// How often it may become shorter.
    tries: u32,
}

/// Which part of a gap a leap leaves. Smaller: more leaps fail. Larger: more leaps. Decides the way, never the answer.
const LEFT: f64 = 1.0 / 512.0;

/// By what factor a leap leads farther than the speed, to be tried.
const FARTHER: f64 = 1.01;

/// How often a leap that fails is tried again with a shorter time.
const TRIES: u32 = 3;

impl Leap {
    /// Whether a gap at its end proves that there is one at all times between.
    fn is_proved_by(&self, gap: f64) -> bool {
        let duration = self.to - self.from;
        let bend = 0.5 * self.bending * duration * duration * (1.0 + 1e-12);
        // Written so that NaN is no proof.
        bend <= self.gap && gap > 0.0
    }

    /// One to where the chord of the gaps leads, after this one was not proved by that gap.
    fn shorter(&self, gap: f64) -> Option<Self> {
        let duration = self.to - self.from;
        let share = (self.gap - self.left) / (self.gap - gap);
        // Written so that NaN takes the other.
        let share = if gap < self.left { share } else { SHORTER };
        Self { to: self.from + share * duration, tries: self.tries.checked_sub(1)?, ..*self }
            .if_farther()
    }

    fn if_farther(self) -> Option<Self> {
        let Self { from, to, otherwise, .. } = self;
        (to - from > FARTHER * (otherwise - from) && to > from).then_some(self)
    }
}

/// By what factor a leap becomes shorter that leaves a gap but bends too much.
const SHORTER: f64 = 0.7;

/// What is known of the gap along a direction: metres, and metres a unit of time.
struct Ahead {
    gap: f64,
    /// At which it closes as far as the points go that are nearest now, and the derivative of that.
    rates: [f64; 2],
    from: f64,
    until: f64,
    /// The gap to be left at the least.
    least: f64,
}

impl Ahead {
    fn leap(&self, closing: &Closing, direction: DVec3, otherwise: f64) -> Option<Leap> {
        let bending = closing.bending(direction);
        if bending == 0.0 {
            return None;
        }
        let &Self { gap, rates: [rate, faster], from, until, least } = self;
        let left = (LEFT * gap).max(least).min(0.5 * gap);
        let way = gap - left;
        // The points of now close that way after this time, if they do: a quadratic.
        let root = (rate * rate + 2.0 * faster * way).sqrt();
        let sum = rate + root;
        let step = if sum > 0.0 { 2.0 * way / sum } else { f64::INFINITY };
        // No more bend than the gap's own change.
        let step = step.min((2.0 * way / bending).sqrt());
        let to = (from + step).min(until);
        Leap { direction, from, to, gap, left, bending, otherwise, tries: TRIES }.if_farther()
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
struct GjkAt<'a, 'b> {
    difference: &'a Difference<'b, f64, Shape, Shape>,
    bounds: Bounds<f64>,
    near: Approach,
    newest: Option<Vertex<f64>>,
    squared: f64,
}

impl<'a, 'b> GjkAt<'a, 'b> {
    fn of(difference: &'a Difference<'b, f64, Shape, Shape>) -> Self {
        Self {
            difference,
            bounds: Bounds::of(difference),
            near: Approach::towards(start::<f64>(difference.middle())),
            newest: None,
            squared: f64::MAX,
        }
    }

    /// Begins at vertices of an earlier time, which are vertices still.
    fn begin_from(&mut self, known: Simplex<f64>) {
        for vertex in known.vertices() {
            let w = self.difference.world(vertex.a.point, vertex.b.point);
            self.near.simplex.push(Vertex { w, ..*vertex });
        }
        if !self.near.simplex.vertices().is_empty() {
            self.narrow();
        }
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
    fn apart(&self, [a, b]: [PosedSupport<'_, Shape>; 2]) -> Option<Distance> {
        let is_apart = self.near.lower > self.bounds.swept_upper() && self.near.length < f64::MAX;
        is_apart.then(|| self.near.distance(&self.bounds, self.difference.scale(), (a, b)))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The least of a gap that bends as much as it may between two others, sampled.
    fn least(leap: &Leap, gap: f64) -> f64 {
        let duration = leap.to - leap.from;
        let bend = 0.5 * leap.bending * duration * duration;
        let at = |s: f64| (1.0 - s) * leap.gap + s * gap - bend * s * (1.0 - s);
        (0..=1000).map(|k| at(f64::from(k) / 1000.0)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_leap_is_proved_only_where_the_gap_cannot_close_on_its_way() {
        let direction = DVec3::X;
        let [mut proved, mut open] = [0; 2];
        for bending in [0.1, 1.0, 2.0, 8.0, 32.0] {
            for duration in [0.1, 0.5, 1.0, 2.0] {
                let leap = Leap {
                    direction,
                    from: 3.0,
                    to: 3.0 + duration,
                    gap: 1.0,
                    left: 0.01,
                    bending,
                    otherwise: 3.0,
                    tries: TRIES,
                };
                for gap in [-0.5, 0.0, 1e-9, 0.1, 1.0, f64::NAN] {
                    let is_proved = leap.is_proved_by(gap);
                    assert!(!is_proved || least(&leap, gap) > 0.0, "{bending} {duration} {gap}");
                    *(if is_proved { &mut proved } else { &mut open }) += 1;
                    let shorter = leap.shorter(gap).expect("the first try");
                    assert!(shorter.to > leap.from && shorter.to < leap.to, "{shorter:?}");
                }
            }
        }
        assert!(proved > 10 && open > 10, "{proved} {open}");
    }
}
