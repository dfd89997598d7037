//! Hulls of few vertices inside and round a polytope, for scenes that trade accuracy for time.
//!
//! A scene of outer hulls misses no contact, one of inner hulls reports none that is not there, and
//! [`InnerOuter`] queries both and reports where they differ.
//!
//! It stands beside the solvers because it uses them: how far a point is from a hull, with a bound,
//! and at the end, exactly, whether the outer hull holds every vertex. A hull library would give
//! neither.

mod inner;
mod inner_outer;
mod outer;

use crate::{DistanceResult, PosedSupport, certified, distance};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose};
use std::fmt;

pub use inner_outer::InnerOuter;

/// What a simpler hull may cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// How far, in metres, a hull should be from the shape at most.
    pub tolerance: f64,
    /// How many vertices a hull may have at most.
    pub vertices: usize,
}

impl Budget {
    /// The fewest vertices that a budget may allow: those of a box.
    pub const FEWEST: usize = 8;
}

/// A polytope between two simpler ones. All three have the same swept radius.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// Contains the shape, exactly.
    pub outer: Polytope,
    /// At least the Hausdorff distance of `outer` and the shape, metres.
    pub outer_distance: f64,
    /// Lies inside the shape: the hull of some of its vertices.
    pub inner: Polytope,
    /// At least the Hausdorff distance of `inner` and the shape, metres.
    pub inner_distance: f64,
}

impl Simplified {
    /// Whether both are within that many metres of the shape.
    pub fn is_within(&self, tolerance: f64) -> bool {
        self.outer_distance <= tolerance && self.inner_distance <= tolerance
    }
}

/// Why a shape was not simplified.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SimplifyError {
    /// The tolerance is negative, NaN or infinite.
    Tolerance {
        /// What was given.
        value: f64,
    },
    /// Fewer vertices than [`Budget::FEWEST`].
    TooFewVertices {
        /// How many were given.
        vertices: usize,
    },
    /// The shape is too large or too small, in metres, for its planes' products.
    Size {
        /// How far a vertex is from the middle.
        size: f64,
    },
}

impl fmt::Display for SimplifyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tolerance { value } => {
                write!(f, "the tolerance is {value:e}, not a finite length of at least 0")
            }
            Self::TooFewVertices { vertices } => {
                write!(f, "{vertices} vertices are fewer than {}", Budget::FEWEST)
            }
            Self::Size { size } => write!(f, "the shape's size of {size:e} m is out of range"),
        }
    }
}

impl std::error::Error for SimplifyError {}

/// Sizes, metres, whose squares and their products stay clear of under- and overflow.
const SIZES: std::ops::Range<f64> = 1e-70..1e70;

/// The simplest hulls inside and round a shape that a greedy search finds within the tolerance.
///
/// What holds always: `inner` ⊂ shape ⊂ `outer`, exactly; the two distances are true bounds; and
/// neither hull has more vertices than the budget. Where that many vertices do not suffice, the
/// number of vertices wins and the tolerance is missed: the distances say by how much. Searches
/// stop as soon as the tolerance is met, so that a wide one gives few vertices.
///
/// Costs the budget's vertices times the shape's, at about a microsecond; made for once a shape.
/// Inside: the vertex farthest from the hull so far is added, again and again. Round it: of a box,
/// the corner farthest from the shape is cut off by the plane between the two.
///
/// # Errors
/// A tolerance that is no length, too few vertices, a shape beyond 1e±70 m.
pub fn simplify(shape: &Polytope, budget: Budget) -> Result<Simplified, SimplifyError> {
    let Budget { tolerance, vertices } = budget;
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        return Err(SimplifyError::Tolerance { value: tolerance });
    }
    if vertices < Budget::FEWEST {
        return Err(SimplifyError::TooFewVertices { vertices });
    }
    let size = shape.outer_radius();
    let itself = Near { points: distinct(shape.vertices()), distance: 0.0 };
    if size == 0.0 || itself.points.len() <= 1 {
        return Ok(between(shape, itself.clone(), itself));
    }
    if !SIZES.contains(&size) || !(shape.reach() < SIZES.end) {
        return Err(SimplifyError::Size { size });
    }
    // Distances of the swept shapes are those of their cores.
    let Ok(core) = Polytope::hull(itself.points.clone()) else {
        return Ok(between(shape, itself.clone(), itself));
    };
    let inner = inner::within(&core, budget);
    let mut outer = outer::round(&core, budget);
    let fits = itself.points.len() <= vertices;
    if fits && (outer.distance > tolerance || outer.points.len() >= itself.points.len()) {
        outer = itself;
    }
    Ok(between(shape, inner, outer))
}

/// Points whose hull is near a shape, and how near: a bound from above, metres.
#[derive(Clone)]
struct Near {
    points: Vec<DVec3>,
    distance: f64,
}

fn between(shape: &Polytope, inner: Near, outer: Near) -> Simplified {
    let hull = |near: &Near| {
        let made = Polytope::hull(near.points.clone());
        // Finite points and a radius that was one already: never refused.
        made.and_then(|hull| hull.rounded(shape.swept_radius())).unwrap_or_else(|_| shape.clone())
    };
    Simplified {
        outer: hull(&outer),
        outer_distance: outer.distance,
        inner: hull(&inner),
        inner_distance: inner.distance,
    }
}

/// Each point once, in the order given.
fn distinct(points: &[DVec3]) -> Vec<DVec3> {
    let mut seen = std::collections::HashSet::with_capacity(points.len());
    // −0.0 is 0.0.
    let bits = |p: &DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    points.iter().copied().filter(|p| seen.insert(bits(p))).collect()
}

/// At least how far a point is from a core, and the direction from the core to it; 0 and no
/// direction for one that is in it.
fn beyond(point: DVec3, core: &Polytope) -> (f64, DVec3) {
    let Ok(alone) = Polytope::hull(vec![point]) else { return (f64::MAX, DVec3::ZERO) };
    let (a, b) = (
        PosedSupport::polytope(core, &Pose::IDENTITY),
        PosedSupport::polytope(&alone, &Pose::IDENTITY),
    );
    match distance::of_polytopes(a, b).0 {
        DistanceResult::Apart(found) => (found.upper(), found.normal),
        _ => (0.0, DVec3::ZERO),
    }
}

/// Whether a core holds every point, exactly.
fn holds_all(core: &Polytope, points: &[DVec3]) -> bool {
    points.iter().all(|&point| {
        Polytope::hull(vec![point]).is_ok_and(|alone| {
            let core = PosedSupport::polytope(core, &Pose::IDENTITY);
            certified::overlap_exactly(core, PosedSupport::polytope(&alone, &Pose::IDENTITY))
        })
    })
}
