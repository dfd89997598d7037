//! How deep two shapes overlap that are made of parts: as deep as their deepest two parts.

use super::side::Side;
use super::{Scratch, in_order, pair, touching};
use crate::epa::Depth;
use crate::{PosedShape, Verdict};

/// The greatest of the depths of all touching pairs of parts, each as `depth` says; the default
/// where no pair is known to touch.
///
/// Moving the shapes apart by it along its normal separates those two parts, and maybe not the
/// others: it bounds from below what separates the whole. Mirrored for (b, a), bit for bit.
pub(crate) fn deepest(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    mut depth: impl FnMut(PosedShape<'_>, PosedShape<'_>) -> Verdict<Depth>,
) -> Verdict<Depth> {
    let (_, swapped) = in_order(a, b);
    // One order for both, so that of equals the same is taken.
    let (first, second) = if swapped { (b, a) } else { (a, b) };
    let mut pairs = Vec::new();
    // What is undecided is not in the list, and counts as apart.
    let _ = touching(first, second, &mut Scratch::default(), &mut pairs);
    let (side_a, side_b) = (Side::of(a), Side::of(b));
    let mut most: Option<Depth> = None;
    let mut upper: f64 = 0.0;
    for [part_a, part_b] in pairs {
        let [part_a, part_b] = if swapped { [part_b, part_a] } else { [part_a, part_b] };
        let (Some(in_a), Some(in_b)) =
            (pair::to_shape(side_a.part(part_a)), pair::to_shape(side_b.part(part_b)))
        else {
            continue;
        };
        let in_a = PosedShape { shape: &in_a, pose: a.pose };
        let found = match depth(in_a, PosedShape { shape: &in_b, pose: b.pose }) {
            Verdict::Touching(found) => found,
            Verdict::Apart => continue,
            Verdict::Undecided(reason) => return Verdict::Undecided(reason),
        };
        upper = upper.max(found.depth + found.error_bound);
        if most.is_none_or(|most: Depth| found.depth > most.depth) {
            most = Some(found);
        }
    }
    let most = most.unwrap_or_default();
    // Another pair may be deeper than the deepest by its own bound.
    let above = (upper - most.depth).next_up().min(f64::MAX);
    Verdict::Touching(Depth { error_bound: most.error_bound.max(above), ..most })
}
