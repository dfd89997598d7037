//! The depth of polytopes of which only what is swept round them overlaps.

use super::confirm::is_certified;
use super::{ExpandingSearch, Tolerance};
use crate::certificate::Bounds;
use crate::distance::from_vertices;
use crate::order::are_swapped;
use crate::query::{Accuracy, FoundDepth};
use crate::{Difference, PosedSupport};
use dcd_geom::Polytope;

/// The radii less the distance of the cores, which is searched from vertices of a and of b between which the nearest points
/// are thought to be: any are sound, good ones quick. With the vertices of both that are farthest along the normal. `None`
/// where the cores are not proved to be apart, or the bound is not as good as the accuracy requires.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(crate) fn depth_of_apart(
    accuracy: Accuracy,
    [a, b]: [PosedSupport<'_, Polytope>; 2],
    nearest: [[u32; 2]; 3],
) -> Option<FoundDepth> {
    if are_swapped(a, b) {
        in_order(accuracy, [b, a], nearest.map(|[a, b]| [b, a])).map(FoundDepth::mirrored)
    } else {
        in_order(accuracy, [a, b], nearest)
    }
}

fn in_order(
    accuracy: Accuracy,
    bodies: [PosedSupport<'_, Polytope>; 2],
    nearest: [[u32; 2]; 3],
) -> Option<FoundDepth> {
    let [a, b] = bodies;
    let difference = Difference::new(a, b)?;
    let search = ExpandingSearch { difference, bodies, tolerance: Tolerance::of(accuracy) };
    let bounds = Bounds::of(&search.difference);
    let near = from_vertices(&search.difference, &bounds, nearest).ok()?;
    let depth = search.of_nearest_points(&bounds, &near).filter(|_| near.lower > 0.0)?;
    // All that span the nearest point are as far along the normal, but for rounding.
    let farthest = near.simplex.vertices().first().map(|v| [v.a.feature, v.b.feature]);
    let is_good = accuracy != Accuracy::Certified || is_certified(&depth);
    is_good.then_some(FoundDepth { depth, farthest })
}
