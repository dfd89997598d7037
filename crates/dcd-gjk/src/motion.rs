//! When two moving shapes meet: a proved bracket, by conservative advancement.
//!
//! At a time t a gap is proved along a direction. Along that direction, kept fixed, both shapes' velocities
//! are bounded for all times, so that nothing can close the gap before a time that follows: the search goes
//! there, and no farther (Mirtich 1996; Zhang, Lee, Kim 2006). Nothing fast tunnels through anything thin.

use crate::UNIT;
use crate::distance::{Distance, DistanceResult, distance_at, gap_along};
use crate::{Accuracy, PosedShape, Verdict, certified, order};
use advance::Advance;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Pose, PoseError, Shape};
use dcd_simd::{prefetch, prefetch_lines};

/// A rigid motion with constant velocities: at a time t the centre has moved by `linear`·t, and the shape has
/// turned about it by |`angular`|·t round `angular`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    /// Where the shape is at t = 0.
    pub start: Pose,
    /// How the centre moves: metres a unit of t, world axes.
    pub linear: DVec3,
    /// How the shape turns: rad a unit of t, world axes.
    pub angular: DVec3,
    /// The point about which it turns, in the shape's own frame, metres: its centre of mass, say.
    pub centre: DVec3,
}

/// A shape and how it moves.
#[derive(Clone, Copy, Debug)]
pub struct MovingShape<'a> {
    /// The shape.
    pub shape: &'a Shape,
    /// Its motion.
    pub motion: &'a RigidMotion,
}

/// How many cache lines of a shape's vertices in f32 and in f64 are always prefetched: 32 vertices. Larger: more is that
/// most hulls do not have.
const PREFETCHED: [usize; 2] = [6, 12];

/// Up to which block of vertices larger shapes are prefetched as well. Larger: blocks displace each other.
const BLOCKS: usize = 4;

impl MovingShape<'_> {
    /// Prefetches what a search reads of the shape.
    fn prefetch(&self) {
        if let Shape::Polytope(polytope) = self.shape {
            let blocks = polytope.vertex_blocks();
            prefetch_lines::<{ PREFETCHED[0] }, _>(blocks);
            prefetch_lines::<{ PREFETCHED[1] }, _>(polytope.vertices());
            if let Some(rest) = blocks.get(2..blocks.len().min(BLOCKS)) {
                prefetch(rest);
            }
        }
    }
}

/// Whether and when two moving shapes meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Impact {
    /// Proved: they share no point at any time of the interval.
    Free,
    /// They meet, or come within the tolerance of each other.
    Hit {
        /// Proved: they share no point before; 0 for shapes that touch as they stand. As late as `t`: the search ends where it knows no more.
        free_until: f64,
        /// A time, not before that, at which they touch or are within the tolerance of each other.
        t: f64,
        /// Whether they are proved to touch at `t`.
        touches: bool,
        /// From a to b at `t`, of unit length; zero where they touch.
        normal: DVec3,
        /// The point of a nearest to b at `t`, but for the tolerance; world frame. Zero where they touch, as is the other: where, say
        /// [`Depths`](crate::Depths) and [`Manifolds`](crate::Manifolds) of the two as they stand then.
        point_a: DVec3,
        /// The point of b nearest to a, likewise.
        point_b: DVec3,
    },
    /// Proved free before; nothing is known of what comes then.
    Undecided {
        /// Until when.
        free_until: f64,
    },
}

/// How often a search may advance. Four to ten are usual; shapes that graze each other at the tolerance take
/// more. Smaller: more of these undecided.
const ADVANCES: usize = 1024;

/// What an f64 pose may be off by: a rotation of 48u and its angle's rounding of 4u of itself, two products
/// of 9u, three sums. Unit: u, of the lengths that go into it.
const POSE: f64 = 96.0;

impl RigidMotion {
    /// At rest there.
    pub fn at_rest(start: Pose) -> Self {
        Self { start, linear: DVec3::ZERO, angular: DVec3::ZERO, centre: DVec3::ZERO }
    }

    /// Where the shape is at a time; at 0 the start itself, to the bit.
    ///
    /// # Errors
    /// A pose that is not finite.
    pub fn pose_at(&self, t: f64) -> Result<Pose, PoseError> {
        let Self { start, linear, angular, centre } = *self;
        if t == 0.0 {
            // What the centre adds and takes away again would round.
            return Ok(start);
        }
        if angular == DVec3::ZERO {
            return start.with_translation(start.translation() + linear * t);
        }
        let turned = rotation_from_scaled_axis(angular * t);
        let middle = start.apply(centre) + linear * t;
        let rotation = turned * *start.rotation();
        Pose::from_matrix(rotation, middle - rotation * centre)
    }

    /// How far a pose may be from the exact one, for a shape whose points are within `radius` of the centre: at t = 0, and by
    /// how much more a unit of t.
    fn deviation(&self, radius: f64) -> [f64; 2] {
        let arms = radius + 2.0 * length(self.centre);
        let at_start = self.start.translation().length() + arms;
        let per_time = speed(self.linear) + arms * speed(self.angular);
        [POSE * UNIT * at_start, POSE * UNIT * per_time]
    }
}

/// How far a search goes, and within what.
#[derive(Clone, Copy)]
struct Limits {
    until: f64,
    /// Metres.
    tolerance: f64,
    /// Twice what the poses of both are off by at t = 0, and a unit of t: metres.
    off: [f64; 2],
}

impl Limits {
    fn of([a, b]: [MovingShape<'_>; 2], closing: &Closing, until: f64, tolerance: f64) -> Self {
        let [of_a, of_b] = closing.radii;
        let ([at_a, per_a], [at_b, per_b]) = (a.motion.deviation(of_a), b.motion.deviation(of_b));
        Self { until, tolerance, off: [2.0 * (at_a + at_b), 2.0 * (per_a + per_b)] }
    }

    /// What a gap at that time may be off by, metres.
    fn off(&self, t: f64) -> f64 {
        self.off[0] + self.off[1] * t
    }

    /// Until when a gap lasts that is proved at a time, less what it is off by then, and closes at most at that speed: a
    /// quotient and a sum, rounded down with a margin. What poses are off by then is left of it.
    fn lasts(&self, from: f64, gap: f64, speed: f64) -> f64 {
        from + gap / (speed + self.off[1]) * (1.0 - 1e-12)
    }

    /// Whether shapes whose poses at that time are no farther apart are within the tolerance.
    fn are_near(&self, t: f64, apart: f64) -> bool {
        apart <= self.tolerance - self.off(t)
    }
}

/// The rotation by a vector's length in rad about its direction (Rodrigues): I + sin·K + (1 − cos)·K². By
/// libm's sine and cosine, the same on every machine.
pub fn rotation_from_scaled_axis(turn: DVec3) -> DMat3 {
    let angle = turn.length();
    match turn.try_normalize() {
        Some(axis) => rotation_from_axis_angle(axis, angle),
        None => DMat3::IDENTITY,
    }
}

/// The rotation by an angle in rad about an axis of unit length: see [`rotation_from_scaled_axis`].
pub fn rotation_from_axis_angle(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    rotation_from_sin_cos(axis, [sin, cos])
}

/// The rotation about an axis of unit length by the angle that has this sine and cosine: see
/// [`rotation_from_scaled_axis`].
pub fn rotation_from_sin_cos(axis: DVec3, [sin, cos]: [f64; 2]) -> DMat3 {
    // I + K·sin + K²·(1 − cos) with K the matrix of the cross product, written out.
    let (DVec3 { x, y, z }, versine) = (axis, 1.0 - cos);
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz) = (x * y * versine, x * z * versine, y * z * versine);
    DMat3::from_cols(
        DVec3::new(1.0 - (zz + yy) * versine, z * sin + xy, -y * sin + xz),
        DVec3::new(-z * sin + xy, 1.0 - (zz + xx) * versine, x * sin + yz),
        DVec3::new(y * sin + xz, -x * sin + yz, 1.0 - (yy + xx) * versine),
    )
}

/// When two shapes meet from t = 0 on until `until`, to within `tolerance` metres: at a hit they touch or are that near.
/// A tolerance below some 1e-13 of their size, of how far they are from the world's origin and of how far they have moved
/// and turned by then leaves them undecided where they come near. Shapes that come that near and never touch may be free or hit;
/// those that touch are never free. Of compounds, meshes and half-spaces too: for those any gap counts, whatever its
/// direction, so that what slides along them may need more advances than a search has, and be undecided. So is a half-space that
/// turns, and what moves by less than some 1e-150 a unit of t where it comes near. An `until` or a tolerance that is no number
/// proves nothing; before an `until` below 0 nothing is met.
///
/// ```
/// use dcd_geom::{Pose, Shape, glam::DVec3};
/// use dcd_gjk::motion::{Impact, MovingShape, RigidMotion, time_of_impact};
/// let (ball, wall) = (Shape::sphere(0.1)?, Shape::cuboid(DVec3::new(0.001, 5.0, 5.0))?);
/// let fast = RigidMotion {
///     linear: DVec3::X * 1000.0,
///     ..RigidMotion::at_rest(Pose::from_translation(DVec3::X * -2.0)?)
/// };
/// let still = RigidMotion::at_rest(Pose::IDENTITY);
/// let (ball, wall) = (MovingShape { shape: &ball, motion: &fast }, MovingShape { shape: &wall, motion: &still });
/// let Impact::Hit { t, .. } = time_of_impact(ball, wall, 1.0, 1e-6)? else { panic!() };
/// assert!((t - 1.899e-3).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A motion that leaves the range of f64 on the way, or that starts at a pose which is hardly a rotation and, turned, is none.
pub fn time_of_impact(
    a: MovingShape<'_>,
    b: MovingShape<'_>,
    until: f64,
    tolerance: f64,
) -> Result<Impact, PoseError> {
    if until < 0.0 {
        return Ok(Impact::Free);
    }
    [a, b].iter().for_each(MovingShape::prefetch);
    let closing = Closing::of(a, b);
    let limits = &Limits::of([a, b], &closing, until, tolerance);
    // Two unbounded shapes have no distance here.
    if !a.shape.is_bounded() && !b.shape.is_bounded() && overlap_at_start([a, b]) {
        return Ok(met(0.0));
    }
    let mut t = match first_advance([a, b], &closing, limits)? {
        Advance::Free => return Ok(Impact::Free),
        Advance::Until(t) => t,
        Advance::Near(t, found) => return Ok(near_miss(t, &found)),
    };
    for _ in 0..ADVANCES {
        let (pose_a, pose_b) = (a.motion.pose_at(t)?, b.motion.pose_at(t)?);
        let posed_a = PosedShape { shape: a.shape, pose: &pose_a };
        let posed_b = PosedShape { shape: b.shape, pose: &pose_b };
        let found = match distance_at(Accuracy::F64, posed_a, posed_b).0 {
            DistanceResult::Apart(found) => found,
            DistanceResult::Interval { within, .. } if !limits.are_near(t, within.upper()) => {
                return Ok(Impact::Undecided { free_until: t });
            }
            DistanceResult::Interval { within, .. } => within,
            DistanceResult::Touching => return Ok(met(t)),
            DistanceResult::Undecided(_) => return Ok(Impact::Undecided { free_until: t }),
        };
        if limits.are_near(t, found.upper()) {
            return Ok(near_miss(t, &found));
        }
        let (gap, speed) = match gap_along(posed_a, posed_b, found.normal) {
            Some(gap) => (gap, closing.along(found.normal)),
            None => (found.lower(), closing.at_most()),
        };
        let gap = gap - limits.off(t);
        if !(gap > 0.0) {
            return Ok(Impact::Undecided { free_until: t });
        }
        let next = limits.lasts(t, gap, speed);
        if speed <= 0.0 || next > until {
            return Ok(Impact::Free);
        }
        if !(next > t) {
            return Ok(Impact::Undecided { free_until: t });
        }
        t = next;
    }
    Ok(Impact::Undecided { free_until: t })
}

/// Whether two shapes are proved to overlap as they stand.
fn overlap_at_start(sides: [MovingShape<'_>; 2]) -> bool {
    let [a, b] = sides.map(|side| PosedShape { shape: side.shape, pose: &side.motion.start });
    certified::overlap_of(a, b).0 == Verdict::Touching(())
}

/// They are proved to touch.
fn met(t: f64) -> Impact {
    let (normal, point_a, point_b) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    Impact::Hit { free_until: t, t, touches: true, normal, point_a, point_b }
}

/// Within the tolerance of each other, and no proof that they touch.
fn near_miss(t: f64, found: &Distance) -> Impact {
    let &Distance { normal, point_a, point_b, .. } = found;
    Impact::Hit { free_until: t, t, touches: false, normal, point_a, point_b }
}

/// [`advance::advance`] of a pair in its canonical order; nothing of shapes that it is not for.
fn first_advance(
    [a, b]: [MovingShape<'_>; 2],
    closing: &Closing,
    limits: &Limits,
) -> Result<Advance, PoseError> {
    let has_support = |shape: &Shape| shape.is_convex() && shape.is_bounded();
    if !has_support(a.shape) || !has_support(b.shape) {
        return Ok(Advance::Until(0.0));
    }
    let (posed_a, posed_b) = (
        PosedShape { shape: a.shape, pose: &a.motion.start },
        PosedShape { shape: b.shape, pose: &b.motion.start },
    );
    if order::is_swapped(posed_a, posed_b) {
        Ok(match advance::advance([b, a], &closing.mirrored(), limits)? {
            Advance::Near(t, found) => Advance::Near(t, found.mirrored()),
            other => other,
        })
    } else {
        advance::advance([a, b], closing, limits)
    }
}

/// How fast two shapes close at most.
struct Closing {
    /// Of a against b.
    linear: DVec3,
    angular: [DVec3; 2],
    radii: [f64; 2],
}

impl Closing {
    fn of(a: MovingShape<'_>, b: MovingShape<'_>) -> Self {
        // Without a zero below 0, by which alone it may differ from what `mirrored` makes of (b, a): bits hang on it.
        let linear = a.motion.linear - b.motion.linear + DVec3::ZERO;
        let angular = [a, b].map(|side| side.motion.angular);
        Self { linear, angular, radii: [a, b].map(|side| radius(&side)) }
    }

    /// Whether a shape turns.
    fn turns(&self) -> bool {
        self.angular.iter().any(|&w| w != DVec3::ZERO)
    }

    /// Of b against a.
    fn mirrored(&self) -> Self {
        let ([a, b], [of_a, of_b]) = (self.angular, self.radii);
        Self { linear: DVec3::ZERO - self.linear, angular: [b, a], radii: [of_b, of_a] }
    }

    /// Along a fixed direction from a to b: a point at ρ from the centre moves along it by ω × ρ, which is at most
    /// its distance times |n × ω|, whenever.
    fn along(&self, normal: DVec3) -> f64 {
        let n = normal.normalize();
        if !self.turns() {
            return n.dot(self.linear) + 64.0 * UNIT * speed(self.linear);
        }
        let turning: f64 =
            self.angular.iter().zip(&self.radii).map(|(w, r)| speed(n.cross(*w)) * r).sum();
        let sizes = speed(self.linear) + self.turning();
        // What cancels is rounded by parts of the speeds themselves.
        n.dot(self.linear) + turning + 64.0 * UNIT * sizes
    }

    /// Along a direction at the instant, of the points at those arms from the two centres, and the derivative of that; as
    /// computed.
    fn rates(&self, axis: DVec3, arms: [DVec3; 2]) -> [f64; 2] {
        let ([of_a, of_b], [arm_a, arm_b]) = (self.angular, arms);
        let (a, b) = (of_a.cross(arm_a), of_b.cross(arm_b));
        let rate = axis.dot(self.linear + a - b);
        let faster = axis.dot(of_a.cross(a) - of_b.cross(b));
        [rate / axis.length(), faster / axis.length()]
    }

    /// At most the second derivative along a fixed direction of the distance of two points, one of each: a point at ρ
    /// from the centre has n·(ω × (ω × ρ)) = −(n × ω)·(ω × ρ).
    fn bending(&self, axis: DVec3) -> f64 {
        let n = axis.normalize();
        let of_side = |(w, r): (&DVec3, &f64)| {
            let fast = speed(*w);
            // What cancels in the product is rounded by parts of its factors.
            (speed(n.cross(*w)) + 64.0 * UNIT * fast) * fast * r
        };
        let bending = self.angular.iter().zip(&self.radii).map(of_side).sum::<f64>();
        let hidden = if bending > 0.0 { f64::MIN_POSITIVE } else { 0.0 };
        bending * (1.0 + 64.0 * UNIT) + hidden
    }

    /// In any direction.
    fn at_most(&self) -> f64 {
        (speed(self.linear) + self.turning()) * (1.0 + 64.0 * UNIT)
    }

    fn turning(&self) -> f64 {
        self.angular.iter().zip(&self.radii).map(|(w, r)| speed(*w) * r).sum()
    }
}

/// The length of a vector that is often zero, which takes no root.
fn length(v: DVec3) -> f64 {
    if v == DVec3::ZERO { 0.0 } else { v.length() }
}

/// What an underflow of squares hides, and more: of lengths in metres, of speeds in metres or rad a unit of t. Larger: motions not as
/// slow that are undecided. Smaller: shapes that are said to be free and meet.
const UNDERFLOW: f64 = 1e-150;

/// At most how fast that is, but for rounding: squares of slow motions underflow.
fn speed(v: DVec3) -> f64 {
    if v == DVec3::ZERO { 0.0 } else { v.length() + UNDERFLOW }
}

/// Within which distance of the centre all points of the core are, metres; its pose may stretch it a little. 0
/// of what does not turn and has no end: only the bounds of a turning shape use it. What is swept round the core is a ball,
/// which turns into itself.
fn radius(side: &MovingShape<'_>) -> f64 {
    let RigidMotion { start, centre, angular, .. } = side.motion;
    if !side.shape.is_bounded() && *angular == DVec3::ZERO {
        return 0.0;
    }
    let own = match side.shape.as_polytope() {
        // Where it counts, the farthest vertex itself.
        Some(polytope) if *angular != DVec3::ZERO && *centre != DVec3::ZERO => {
            let far = polytope.vertices().iter().map(|v| v.distance_squared(*centre));
            far.fold(0.0, f64::max).sqrt()
        }
        _ => core_reach(side.shape) + length(*centre),
    };
    own * (1.0 + start.deviation()) * (1.0 + 16.0 * UNIT) + UNDERFLOW
}

/// How far the core of a shape reaches from the origin of its own frame, at most: metres.
fn core_reach(shape: &Shape) -> f64 {
    match shape {
        Shape::Polytope(polytope) => polytope.reach(),
        Shape::Curved(curved) => curved.reach(),
        Shape::Ellipsoid(ellipsoid) => ellipsoid.reach(),
        Shape::Mesh(mesh) => mesh.reach(),
        other => other.reach(),
    }
}

mod advance;
mod cast;
mod ray_frame;
mod swept;
#[cfg(test)]
pub(crate) mod tests;
