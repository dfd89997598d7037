//! Exact judgement of pairs on which two answers differ.

use dcd_geom::{Pair, Scene, Shape};
use dcd_gjk::{DistanceResult, PosedShape, PosedSupport, Verdict, certified, distance, epa};
use serde::Serialize;

/// The truth of a pair.
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
pub(super) struct Judged {
    pub(super) truth: Truth,
    /// How far the surfaces are from each other, metres: the gap, or the depth of an overlap. Of
    /// meshes it is not computed.
    pub(super) metres: Option<f64>,
}

/// Judges a pair by exact arithmetic, or for curved shapes by the certificate of f64; a mesh
/// triangle by triangle.
pub(super) fn judge_pair(scene: &Scene, pair: Pair) -> Judged {
    let [i, j] = [pair.i as usize, pair.j as usize];
    let placed = |k: usize| PosedShape { shape: scene.shape(k), pose: &scene.poses()[k] };
    let (a, b) = (placed(i), placed(j));
    let (in_a, in_b) = (pieces(a.shape), pieces(b.shape));
    let each = in_a.iter().flat_map(|a| in_b.iter().map(move |b| (a, b)));
    let truths = each.map(|(of_a, of_b)| {
        truth(PosedShape { shape: of_a, ..a }, PosedShape { shape: of_b, ..b })
    });
    let truth = truths.fold(Truth::Apart, |so_far, this| match (so_far, this) {
        (Truth::Touching, _) | (_, Truth::Touching) => Truth::Touching,
        (Truth::Open, _) | (_, Truth::Open) => Truth::Open,
        (Truth::Apart, Truth::Apart) => Truth::Apart,
    });
    Judged { truth, metres: if truth == Truth::Touching { depth(a, b) } else { gap(a, b) } }
}

/// The convex pieces of a shape.
fn pieces(shape: &Shape) -> Vec<Shape> {
    let Shape::Mesh(mesh) = shape else { return vec![shape.clone()] };
    let corners = (0..mesh.triangles().len()).filter_map(|k| mesh.corners(k));
    // The corners of a mesh are finite, and so make triangles.
    corners.filter_map(|corners| Shape::triangle(corners).ok()).collect()
}

fn truth(a: PosedShape<'_>, b: PosedShape<'_>) -> Truth {
    match (a.shape, b.shape) {
        (Shape::Polytope(in_a), Shape::Polytope(in_b)) => {
            let [a, b] =
                [PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose)];
            if certified::overlap_exactly(a, b) { Truth::Touching } else { Truth::Apart }
        }
        _ => match certified::overlap_of(a, b).0 {
            Verdict::Touching(()) => Truth::Touching,
            Verdict::Apart => Truth::Apart,
            Verdict::Undecided(_) => Truth::Open,
        },
    }
}

fn gap(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<f64> {
    match distance::distance(a, b).0 {
        DistanceResult::Apart(found) => Some(found.distance),
        _ => None,
    }
}

fn depth(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<f64> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let [a, b] = [PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose)];
    Some(epa::depth_of_overlap(a, b, &mut epa::Scratch::default()).depth)
}
