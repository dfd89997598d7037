//! The manifold of shapes that are made of parts: the points of all parts that meet along the normal of the
//! deepest two.

use super::feature::View;
use super::{Manifold, Scratch};
use crate::epa::Depth;
use crate::mesh::{self, Deepest, PartPair};
use crate::query::{Accuracy, depths};
use crate::{PosedShape, Verdict};

/// The least cosine between two normals that count as one: 1e-3 rad.
const ALIKE: f64 = 1.0 - 5e-7;

pub(super) fn measure(
    accuracy: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut Scratch,
) -> Verdict<Manifold> {
    if !mesh::is_swapped(a, b) {
        return in_order(accuracy, a, b, scratch);
    }
    match in_order(accuracy, b, a, scratch) {
        Verdict::Touching(manifold) => Verdict::Touching(manifold.mirrored()),
        other => other,
    }
}

fn in_order(
    accuracy: Accuracy,
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    scratch: &mut Scratch,
) -> Verdict<Manifold> {
    let pairs = mesh::touching_parts(a, b);
    let (mut deepest, mut index) = (Deepest::default(), 0);
    let mut found = Vec::with_capacity(pairs.len());
    for pair in &pairs {
        let [in_a, in_b] = posed(pair, a, b);
        match depths::of_touching(accuracy, in_a, in_b, &mut scratch.depth) {
            Verdict::Touching(depth) => {
                if deepest.add(depth) {
                    index = found.len();
                }
                found.push((pair, depth));
            }
            Verdict::Apart => {}
            Verdict::Undecided(reason) => return Verdict::Undecided(reason),
        }
    }
    let depth = deepest.depth();
    let view = View::along(depth.normal);
    let corners = &mut scratch.corners;
    corners.clear();
    let mut features = Default::default();
    for (k, (pair, of_pair)) in found.iter().enumerate() {
        let sides = posed(pair, a, b);
        let before = corners.len();
        // The planes of half-spaces are the pair's own; what is seen is seen along the deepest's normal.
        let whole = corners.add(&view, &Depth { normal: depth.normal, ..*of_pair }, sides);
        if k == index {
            features = whole;
        }
        if corners.len() == before && of_pair.normal.dot(depth.normal) >= ALIKE {
            corners.add_witness(&view, of_pair, a.pose.translation());
        }
        // Parts that reach deeper along this normal meet along another.
        if corners.deepest_after(before) > depth.depth + corners.tolerance() {
            corners.truncate(before);
        }
    }
    let manifold = corners.manifold(&view, depth, [a, b], features);
    let parts = found.get(index).map_or([None; 2], |(pair, _)| pair.parts);
    Verdict::Touching(Manifold { parts, ..manifold })
}

/// The two parts where their wholes are.
fn posed<'p>(pair: &'p PartPair<'_>, a: PosedShape<'p>, b: PosedShape<'p>) -> [PosedShape<'p>; 2] {
    let [in_a, in_b] = &pair.shapes;
    [PosedShape { shape: in_a, pose: a.pose }, PosedShape { shape: in_b, pose: b.pose }]
}
