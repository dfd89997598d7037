//! The one query that a solver makes of a shape.

mod scan;

use crate::{Real, Vector};
use glam::DVec3;
use std::sync::Arc;

pub(crate) use scan::FarthestVertex;

/// A farthest point of a shape's core in some direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support<R: Real> {
    /// The point, in the shape's own frame, metres.
    pub point: R::Vec3,
    /// What it belongs to: the index of a vertex, or any number by which the same point is known
    /// again ([`Support::of_point`] makes one). Two supports of one shape with the same feature are the same point.
    pub feature: u32,
}

impl Support<f64> {
    /// A point of a curved surface, which has no vertices to count: its feature is a mix of all bits of its coordinates
    /// (the finaliser of splitmix64), so that two of the few points of a simplex share one once in 2³².
    pub fn of_point(point: DVec3) -> Self {
        let mix = |hash: u64, x: f64| {
            // −0.0 is the point that 0.0 is.
            let mut z = (hash ^ (x + 0.0).to_bits()).wrapping_add(0x9e37_79b9_7f4a_7c15);
            z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            z ^ z >> 31
        };
        let hash = mix(mix(mix(0, point.x), point.y), point.z);
        Self { point, feature: (hash >> 32) as u32 }
    }
}

/// A convex shape known by its support function: a core, and a sphere swept round it.
///
/// The shape is the Minkowski sum of its core and a sphere of [`SupportMap::radius`], placed as
/// (R·core + t) ⊕ sphere(radius): the radius is a length of the world.
///
/// # Contract
/// For every finite `direction`, `support(direction).point` is a point of the core, and no point
/// of the core is farther along `direction` by more than [`SupportMap::support_error`] times the
/// sum of the direction's absolute components. A zero direction gives any point of the core.
/// [`crate::contract::support_map`] tests it.
///
/// ```
/// use dcd_geom::glam::DVec3;
/// use dcd_geom::{Shape, Support, SupportMap};
/// use std::sync::Arc;
/// /// A flat hexagon.
/// struct Hexagon([DVec3; 6]);
/// impl SupportMap<f64> for Hexagon {
///     fn support(&self, direction: DVec3) -> Support<f64> {
///         let Self(corners) = self;
///         let along = |k: &usize| direction.dot(corners[*k]);
///         let k = (0..6).max_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or(0);
///         Support { point: corners[k], feature: k as u32 }
///     }
/// }
/// let corners = [0.0f64, 1.0, 2.0, 3.0, 4.0, 5.0].map(|k| (k * std::f64::consts::FRAC_PI_3).sin_cos());
/// let hexagon = Hexagon(corners.map(|(y, x)| DVec3::new(x, y, 0.0)));
/// let tile = Shape::custom(Arc::new(hexagon))?;
/// assert!(tile.is_convex());
/// # Ok::<(), dcd_geom::ShapeError>(())
/// ```
pub trait SupportMap<R: Real>: Send + Sync {
    /// A farthest point of the core along `direction`, which need not be of unit length; both in
    /// the shape's own frame.
    fn support(&self, direction: R::Vec3) -> Support<R>;

    /// The radius of the sphere swept round the core, metres, at least 0.
    fn radius(&self) -> R {
        R::ZERO
    }

    /// How far a support may fall short, metres (see the contract). 0 for a shape whose core is the
    /// hull of the points it returns and whose maximum is over rounded dot products: that
    /// rounding is in every solver's own bound.
    fn support_error(&self) -> R {
        R::ZERO
    }
}

impl<R: Real, S: SupportMap<R> + ?Sized> SupportMap<R> for &S {
    fn support(&self, direction: R::Vec3) -> Support<R> {
        (**self).support(direction)
    }
    fn radius(&self) -> R {
        (**self).radius()
    }
    fn support_error(&self) -> R {
        (**self).support_error()
    }
}

impl<R: Real, S: SupportMap<R> + ?Sized> SupportMap<R> for Arc<S> {
    fn support(&self, direction: R::Vec3) -> Support<R> {
        (**self).support(direction)
    }
    fn radius(&self) -> R {
        (**self).radius()
    }
    fn support_error(&self) -> R {
        (**self).support_error()
    }
}

/// [`farthest`] of so few that their number is known to the compiler: in a third of the instructions.
#[inline(always)]
fn farthest_of<R: Real, const N: usize>(points: [DVec3; N], direction: R::Vec3) -> Support<R> {
    let points = points.map(R::Vec3::from_dvec3);
    let along = points.map(|point| point.dot(direction));
    let (mut most, mut found) = (-R::MAX, Support { point: points[0], feature: 0 });
    for k in 0..N {
        let is_farther = along[k] > most;
        most = if is_farther { along[k] } else { most };
        let feature = if is_farther { k as u32 } else { found.feature };
        found = Support { point: if is_farther { points[k] } else { found.point }, feature };
    }
    found
}

/// How many maxima [`farthest`] keeps: a comparison then waits for the fourth before it, not for the last one.
const CHAINS: usize = 4;

/// The farthest of `points`, the first among equals.
///
/// Returns the index and the point; `points` must not be empty, else the origin comes back.
#[inline]
pub(crate) fn farthest<R: Real>(points: &[DVec3], direction: R::Vec3) -> Support<R> {
    match *points {
        [a, b] => return farthest_of([a, b], direction),
        [a, b, c] => return farthest_of([a, b, c], direction),
        _ => {}
    }
    let mut most = [-R::MAX; CHAINS];
    let mut at = [0u64; CHAINS];
    let fours = points.chunks_exact(CHAINS);
    let rest = fours.remainder();
    let mut first = 0;
    for four in fours {
        for c in 0..CHAINS {
            let along = R::Vec3::from_dvec3(four[c]).dot(direction);
            // Two selections and no branch: which one is farthest cannot be predicted.
            let is_farther = along > most[c];
            most[c] = if is_farther { along } else { most[c] };
            at[c] = if is_farther { first + c as u64 } else { at[c] };
        }
        first += CHAINS as u64;
    }
    for (c, &point) in rest.iter().enumerate() {
        let along = R::Vec3::from_dvec3(point).dot(direction);
        let is_farther = along > most[c];
        most[c] = if is_farther { along } else { most[c] };
        at[c] = if is_farther { first + c as u64 } else { at[c] };
    }
    let (mut farthest, mut best) = (most[0], at[0]);
    for c in 1..CHAINS {
        let is_farther = most[c] > farthest || (most[c] == farthest && at[c] < best);
        farthest = if is_farther { most[c] } else { farthest };
        best = if is_farther { at[c] } else { best };
    }
    let best = best as usize;
    let point = points.get(best).map_or(R::Vec3::ZERO, |&point| R::Vec3::from_dvec3(point));
    Support { point, feature: best as u32 }
}
