//! Which pairs of few parts may be the nearest or the deepest, as f64 knows the parts as they were given: only these, as they
//! are placed, need be certified.

use super::{Couple, Framed, Wanted, in_order};
use crate::PosedShape;
use crate::epa;
use crate::query::Accuracy;
use dcd_geom::{Kind, Shape};

/// The pairs of parts that touch, by index in an order that is one for (a, b) and (b, a), each with an upper bound of how deep:
/// metres. Where the deepest is wanted, those alone that may be it. `None` where that is not known at once, and where what
/// certifies a pair is as quick.
pub(in crate::query) fn touching(
    wanted: Wanted,
    [a, b]: [PosedShape<'_>; 2],
    scratch: &mut epa::Scratch,
) -> Option<Vec<([u32; 2], f64)>> {
    // A capsule's depth takes a search.
    let is_slow = |shape: &Shape| is_kind(shape, |kind| kind == Kind::Segment);
    if has_part(a.shape, is_slow) || has_part(b.shape, is_slow) {
        return None;
    }
    let (sides, swapped) = in_order(a, b)?;
    let framed = Framed::of(sides);
    let mut couple = Couple::default();
    couple.fill(&framed)?;
    let (mut found, mut least) = (Vec::new(), 0.0f64);
    couple.touching((Accuracy::F64, wanted), scratch, |[j, k], depth| {
        least = least.max(depth.depth - depth.error_bound);
        let pair = if swapped { [k, j] } else { [j, k] };
        found.push((pair, (depth.depth + depth.error_bound).next_up()));
    })?;
    if wanted == Wanted::Deepest {
        found.retain(|&(_, most)| most >= least);
    }
    (!found.is_empty()).then_some(found)
}

/// The pairs of parts of which one is the nearest, by index. `None` where parts may touch, and where what certifies a pair is as
/// quick.
pub(crate) fn may_be_nearest([a, b]: [PosedShape<'_>; 2]) -> Option<Vec<[u32; 2]>> {
    let is_slow =
        |shape: &Shape| !is_kind(shape, |kind| matches!(kind, Kind::Point | Kind::Cuboid { .. }));
    if has_part(a.shape, is_slow) || has_part(b.shape, is_slow) {
        return None;
    }
    let (sides, swapped) = in_order(a, b)?;
    let framed = Framed::of(sides);
    let mut couple = Couple::default();
    couple.fill(&framed)?;
    let (mut near, mut limit) = (Vec::new(), f64::INFINITY);
    couple.nearest(Accuracy::F64, |pair, _, found| {
        limit = limit.min((found.distance + found.error_bound).next_up());
        near.push((pair, found.distance - found.error_bound));
        Some(limit)
    })?;
    near.retain(|&(_, least)| least <= limit);
    let pair = |([j, k], _): ([u32; 2], f64)| if swapped { [k, j] } else { [j, k] };
    Some(near.into_iter().map(pair).collect())
}

/// Whether that is true of a shape, or of a part of it.
fn has_part(shape: &Shape, is: impl Fn(&Shape) -> bool) -> bool {
    match shape {
        Shape::Compound(compound) => compound.parts().iter().any(|part| is(&part.shape)),
        other => is(other),
    }
}

/// Whether it is a polytope of such a kind.
fn is_kind(shape: &Shape, is: impl Fn(Kind) -> bool) -> bool {
    shape.as_polytope().is_some_and(|polytope| is(polytope.kind()))
}
