//! Who is right where two answers differ.

use dcd_geom::{Pair, Scene, Shape};
use dcd_gjk::{Body, DistanceResult, Placed, Verdict, certified, distance, epa};
use serde::Serialize;

/// What is true of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Truth {
    Touching,
    Apart,
    /// Neither is proved: a curved shape within the rounding of f64.
    Open,
}

/// A pair on which two answers differ.
#[derive(Debug, Serialize)]
pub(super) struct Settled {
    pub(super) truth: Truth,
    /// How far the surfaces are from each other, metres: the gap, or the depth of an overlap.
    pub(super) metres: Option<f64>,
}

/// Settles a pair by exact arithmetic, or for curved shapes by the certificate of f64.
pub(super) fn settle(scene: &Scene, pair: Pair) -> Settled {
    let [i, j] = [pair.i as usize, pair.j as usize];
    let placed = |k: usize| Placed { shape: scene.shape(k), pose: &scene.poses()[k] };
    let (a, b) = (placed(i), placed(j));
    let truth = match (a.shape, b.shape) {
        (Shape::Polytope(in_a), Shape::Polytope(in_b)) => {
            let [a, b] = [Body::polytope(in_a, a.pose), Body::polytope(in_b, b.pose)];
            if certified::overlap_exactly(a, b) { Truth::Touching } else { Truth::Apart }
        }
        _ => match certified::overlap_of(a, b).0 {
            Verdict::Touching(()) => Truth::Touching,
            Verdict::Apart => Truth::Apart,
            Verdict::Undecided(_) => Truth::Open,
        },
    };
    Settled { truth, metres: if truth == Truth::Touching { depth(a, b) } else { gap(a, b) } }
}

fn gap(a: Placed<'_>, b: Placed<'_>) -> Option<f64> {
    match distance::distance(a, b).0 {
        DistanceResult::Apart(found) => Some(found.distance),
        _ => None,
    }
}

fn depth(a: Placed<'_>, b: Placed<'_>) -> Option<f64> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let [a, b] = [Body::polytope(in_a, a.pose), Body::polytope(in_b, b.pose)];
    Some(epa::depth_of_overlap(a, b, &mut epa::Scratch::default()).depth)
}
