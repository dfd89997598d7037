//! The manifold of shapes that are made of parts: the points of all parts that meet along the normal of the
//! deepest two.

use super::feature::View;
use super::{Manifold, Scratch};
use crate::epa::Depth;
use crate::mesh::{self, PartPair};
use crate::query::{Accuracy, depths};
use crate::{PosedShape, Verdict};

/// The least cosine between two normals that count as one: 1e-3 rad.
const ALIKE: f64 = 1.0 - 5e-7;

/// At least the angle of that cosine, and room for normals that are known to 1e-4 rad.
const ANGLE: f64 = 1.1e-3;

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
    let Scratch { depth: memory, corners } = scratch;
    let mut measured = |pair: &PartPair<'_>| {
        pair.depth_by([a, b], |[a, b]| depths::of_touching(accuracy, a, b, memory))
    };
    let (index, depth) = match mesh::deepest(&pairs, &mut measured) {
        Ok(found) => found,
        Err(reason) => return Verdict::Undecided(reason),
    };
    let view = View::along(depth.normal);
    corners.clear();
    let mut features = Default::default();
    for (k, pair) in pairs.iter().enumerate() {
        let before = corners.len();
        // A sphere has no corners; of the deepest pair the size and the features count.
        if k == index || !pair.has_no_corners() {
            let Some(sides) = pair.posed(a, b) else { continue };
            // The planes of half-spaces are the pair's own; what is seen is seen along the deepest's normal.
            let is_bounded = sides.iter().all(|side| side.shape.is_bounded());
            let of_plane = if is_bounded { depth } else { of(measured(pair)).unwrap_or(depth) };
            let whole = corners.add(&view, &Depth { normal: depth.normal, ..of_plane }, sides);
            if k == index {
                features = whole;
            }
        }
        if corners.len() == before {
            let of_pair = if k == index {
                Some(depth)
            } else if pair.may_meet_along(depth.normal, ANGLE, [a, b]) {
                of(measured(pair))
            } else {
                None
            };
            if let Some(of_pair) = of_pair.filter(|d| d.normal.dot(depth.normal) >= ALIKE) {
                corners.add_witness(&view, &of_pair, a.pose.translation());
            }
        }
        // Parts that reach deeper along this normal meet along another.
        if corners.deepest_after(before) > depth.depth + corners.tolerance() {
            corners.truncate(before);
        }
    }
    let manifold = corners.manifold(&view, depth, [a, b], features);
    let parts = pairs.get(index).map_or([None; 2], |pair| pair.parts);
    Verdict::Touching(Manifold { parts, ..manifold })
}

/// A depth that is known.
fn of(verdict: Verdict<Depth>) -> Option<Depth> {
    match verdict {
        Verdict::Touching(depth) => Some(depth),
        _ => None,
    }
}
