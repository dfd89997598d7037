//! Compounds of few parts at the accuracies of f32 and f64: each part as it was given, at a pose of its own.
//!
//! A compound's answers are for its parts as it placed them, cuboids as hulls of eight points and cylinders by their
//! support maps. As they were given they have closed forms; what the products of two poses lose is a length, by which the
//! parts are moved at most, and by which a distance or a depth changes at most (docs/numerics/proofs.md, "Parts as they
//! were given"). What that leaves open is left to the parts as they are placed.

mod candidates;
mod framed;
mod side;
mod slab;
mod touching;

use super::{Accuracy, CERTIFIED, Feature, depths};
use crate::UNIT;
use crate::distance::{Distance, DistanceResult, distance_at, gap_along};
use crate::epa::{self, Depth};
use crate::mesh::{self, OfTriangle};
use crate::{PosedShape, PosedSupport, Verdict, certified, closed};
pub(crate) use candidates::may_be_nearest;
pub(super) use candidates::touching;
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Shape};
use dcd_simd::ArrayVec;
pub(super) use framed::Framed;
use side::{Frame, Given, Side};
pub(super) use side::{moved_in_frame, place};
pub use touching::PartContact;
pub(crate) use touching::{FoundParts, PartSpheres};
pub(super) use touching::{TouchingParts, depth_of_known, wholes_in_order};

/// The most parts of one shape, those of two make 1,024 pairs, each of which takes a comparison of spheres. More: the tree over them
/// is quicker.
pub(super) const MOST: usize = 32;

/// The most pairs of parts whose spheres meet. More: kilobytes of memory. Fewer: shapes of which the tree over their parts finds those
/// that touch.
const NEAR_PAIRS: usize = 128;

/// What a bound may be at the accuracy of f64, relative to the pair's size: what [`Accuracy::F64`] promises of a depth, and four times
/// what it does of a distance. Decides who answers. Smaller: more pairs by their placed parts.
const OF_SIZE: [f64; 2] = [256.0 * UNIT, 128.0 * UNIT];

/// The same, relative to a depth or distance.
const OF_LENGTH: f64 = 1e-10;

/// Two shapes that are made of few parts, or one of them and a convex one; in the order that is one for (a, b) and (b, a).
#[derive(Default)]
pub(super) struct Couple<'a> {
    a: Side<'a>,
    b: Side<'a>,
    /// By how much more a distance or a depth may be off than the parts are moved: metres.
    lost: f64,
}

/// Two shapes of which one is a compound, in the order that is one for (a, b) and (b, a); and whether that is the other.
fn in_order<'a>(a: PosedShape<'a>, b: PosedShape<'a>) -> Option<([PosedShape<'a>; 2], bool)> {
    let is_compound = |side: PosedShape<'_>| matches!(side.shape, Shape::Compound(_));
    (is_compound(a) || is_compound(b)).then(|| wholes_in_order([a, b]))
}

/// What is known of two parts.
enum Known {
    Apart,
    Deep(Depth),
}

/// Whether the bound of a length is as good as required: how large a part of the pair's size it may be.
fn is_good(
    at: Accuracy,
    (length, error): (f64, f64),
    sides: [PosedShape<'_>; 2],
    of_size: f64,
) -> bool {
    match at {
        Accuracy::F32 => return true,
        Accuracy::F64 => {}
        Accuracy::Certified => return error <= CERTIFIED * length,
    }
    let reach = |side: PosedShape<'_>| Some(side.shape.reach()).filter(|reach| reach.is_finite());
    let size = sides.into_iter().filter_map(reach).sum::<f64>() + length;
    error <= (of_size * size).max(OF_LENGTH * length)
}

/// Whether two parts touch, and how deep; `None` where what they are moved by leaves it open.
fn touch(
    at: Accuracy,
    [in_a, in_b]: [PosedShape<'_>; 2],
    moved: f64,
    scratch: &mut epa::Scratch,
) -> Option<Known> {
    let deep = |found: Depth| {
        let error_bound = (found.error_bound + moved).next_up();
        let is_known = found.depth > error_bound
            && is_good(at, (found.depth, error_bound), [in_a, in_b], OF_SIZE[0]);
        is_known.then_some(Known::Deep(Depth { error_bound, ..found }))
    };
    let found = if let Some(gap) = closed::gap(at, in_a, in_b) {
        if gap.is_beyond(moved) {
            return Some(Known::Apart);
        }
        gap.depth()
    } else {
        match mesh::of_triangle(in_a, in_b, depths::tolerance(at)) {
            Some(OfTriangle::Apart(gap)) if gap > moved => return Some(Known::Apart),
            Some(OfTriangle::Deep(found)) => Some(found),
            _ => depths::by_formula(at, in_a, in_b),
        }
    };
    if let Some(known) = found.and_then(deep) {
        return Some(known);
    }
    if let (Shape::Polytope(core_a), Shape::Polytope(core_b)) = (in_a.shape, in_b.shape) {
        let cores =
            [PosedSupport::polytope(core_a, in_a.pose), PosedSupport::polytope(core_b, in_b.pose)];
        if closed::cuboids_are_beyond(cores[0], cores[1], moved) {
            return Some(Known::Apart);
        }
    }
    match certified::overlap_of(in_a, in_b).0 {
        Verdict::Touching(()) => match depths::of_touching(at, in_a, in_b, scratch) {
            Verdict::Touching(found) => deep(found),
            _ => None,
        },
        Verdict::Apart => match distance_at(at, in_a, in_b).0 {
            DistanceResult::Apart(found) if found.lower() > moved => Some(Known::Apart),
            _ => None,
        },
        Verdict::Undecided(_) => None,
    }
}

/// Which parts are of interest.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    All,
    /// Those that may be deeper than what was found before.
    Deepest,
}

impl<'a> Couple<'a> {
    /// Takes two shapes in place of none: `None` of meshes, and of other shapes than [`Side::fill`] has.
    // Not made of them: it is large, and would be copied.
    pub(super) fn fill(&mut self, framed: &'a Framed<'_>) -> Option<()> {
        let [a, b] = framed.sides();
        if matches!(a.shape, Shape::Mesh(_)) || matches!(b.shape, Shape::Mesh(_)) {
            return None;
        }
        self.a.fill(a, if framed.is_own() { Frame::Own } else { Frame::Other })?;
        self.b.fill(b, Frame::Other)?;
        self.lost = framed.lost();
        Some(())
    }

    /// All pairs of parts, by number, and how far apart the spheres round them are at the least.
    fn gaps(&self) -> impl Iterator<Item = ([u32; 2], f64)> {
        let pairs =
            (0..self.a.len() as u32).flat_map(|j| (0..self.b.len() as u32).map(move |k| [j, k]));
        pairs.map(|pair| (pair, self.a.gap(&self.b, pair) - self.lost))
    }

    /// Lists those that are not apart by that; `None` where more than a quarter of them need a search, or one is of a kind that few
    /// formulas know. The bounds that are known of placed parts spare more of these than given parts are quicker.
    fn list_near(&self, near: &mut ArrayVec<([u32; 2], f64), NEAR_PAIRS>) -> Option<()> {
        let is_hull = |shape: &Shape| match shape {
            Shape::Polytope(polytope) => Some(polytope.kind() == Kind::Hull),
            Shape::HalfSpace(_) => Some(false),
            _ => None,
        };
        near.extend(self.gaps().filter(|(_, gap)| !(*gap > 0.0)));
        for &([j, k], _) in near.iter() {
            self.a.prefetch(j);
            self.b.prefetch(k);
        }
        let mut searched = 0;
        for &([j, k], _) in near.iter() {
            let are_hulls = [is_hull(self.a.shape(j)?)?, is_hull(self.b.shape(k)?)?];
            searched += usize::from(are_hulls == [true; 2]);
        }
        // Where the list is full there may be more.
        (4 * searched <= near.len() && near.len() < NEAR_PAIRS).then_some(())
    }

    /// Finds the pairs of parts that touch, by number, each with its depth from the first to the second. `None` where that
    /// is not known at once.
    pub(super) fn touching(
        &mut self,
        (at, wanted): (Accuracy, Wanted),
        scratch: &mut epa::Scratch,
        mut found: impl FnMut([u32; 2], Depth),
    ) -> Option<()> {
        let (mut near, mut deepest) = (ArrayVec::new(), 0.0);
        self.list_near(&mut near)?;
        for &(pair, gap) in near.iter() {
            if wanted == Wanted::Deepest && -gap < deepest {
                continue;
            }
            let (sides, moved) = self.look_at(pair)?;
            if let Known::Deep(depth) = touch(at, sides, moved, scratch)? {
                deepest = (depth.depth - depth.error_bound).max(deepest);
                found(pair, depth);
            }
        }
        Some(())
    }

    /// Two parts by number, where they are and as they were given; and by how much they are moved. `None` where that is too much.
    fn look_at(&mut self, pair: [u32; 2]) -> Option<([PosedShape<'_>; 2], f64)> {
        let [j, k] = pair;
        self.a.look_at(j)?;
        self.b.look_at(k)?;
        self.posed(pair)
    }

    /// The same of two that touch.
    pub(super) fn posed(&self, [j, k]: [u32; 2]) -> Option<([PosedShape<'_>; 2], f64)> {
        let (a, b): (&Given<'_>, &Given<'_>) = (self.a.get(j)?, self.b.get(k)?);
        Some(([a.posed(), b.posed()], a.moved + b.moved + self.lost))
    }
}

/// The name of a feature of a part as it was given, where its compound has placed it: faces are listed in another order
/// there. `None` of a face that it has not.
pub(super) fn name(whole: PosedShape<'_>, part: u32, feature: Feature) -> Option<Feature> {
    let (Shape::Compound(compound), Feature::Face(face)) = (whole.shape, feature) else {
        return Some(feature);
    };
    Some(Feature::Face(compound.parts().get(part as usize)?.placed_face(face)?))
}

/// The depth of the deepest two parts; `None` where it is not known at once.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(super) fn depth(
    at: Accuracy,
    [a, b]: [PosedShape<'_>; 2],
    scratch: &mut epa::Scratch,
) -> Option<Depth> {
    let (sides, swapped) = in_order(a, b)?;
    let framed = Framed::of(sides);
    let mut couple = Couple::default();
    couple.fill(&framed)?;
    let (mut deepest, mut upper): (Option<Depth>, f64) = (None, 0.0);
    couple.touching((at, Wanted::Deepest), scratch, |_, depth| {
        upper = upper.max(depth.depth + depth.error_bound);
        if deepest.is_none_or(|most| depth.depth > most.depth) {
            deepest = Some(depth);
        }
    })?;
    let most = deepest?;
    // Another may be deeper than the deepest by its own bound.
    let above = (upper - most.depth).next_up().min(f64::MAX);
    let found = framed.depth(Depth { error_bound: most.error_bound.max(above), ..most });
    Some(if swapped { found.mirrored() } else { found })
}

/// The distance of the nearest two parts; `None` where it is not known at once, or they touch.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(super) fn distance(at: Accuracy, [a, b]: [PosedShape<'_>; 2]) -> Option<Distance> {
    let (sides, swapped) = in_order(a, b)?;
    let framed = Framed::of(sides);
    let mut couple = Couple::default();
    couple.fill(&framed)?;
    let mut nearest: Option<Distance> = None;
    let mut lower = f64::INFINITY;
    couple.nearest(at, |_, sides, found| {
        let is_known = found.distance > found.error_bound
            && is_good(at, (found.distance, found.error_bound), sides, OF_SIZE[1]);
        if !is_known {
            return None;
        }
        lower = lower.min(found.distance - found.error_bound);
        let is_nearest = nearest.is_none_or(|nearest| found.distance < nearest.distance);
        Some(if is_nearest { nearest.insert(found).distance } else { nearest?.distance })
    })?;
    let nearest = nearest?;
    // Another may be nearer than the nearest by its own bound.
    let below = (nearest.distance - lower).next_up();
    let found =
        framed.distance(Distance { error_bound: nearest.error_bound.max(below), ..nearest });
    Some(if swapped { found.mirrored() } else { found })
}

impl Couple<'_> {
    /// Hands on the pairs of parts that may be the nearest, by number, where they are and how far apart, with what they are moved by
    /// in the bound, the nearest spheres first. `met` returns from which distance on another is of no interest. `None` where it
    /// returns that, and where a pair is not known to be apart.
    fn nearest(
        &mut self,
        at: Accuracy,
        mut met: impl FnMut([u32; 2], [PosedShape<'_>; 2], Distance) -> Option<f64>,
    ) -> Option<()> {
        let mut gaps: Vec<([u32; 2], f64)> = self.gaps().collect();
        let (mut nearest, mut limit): (Option<Distance>, f64) = (None, f64::INFINITY);
        for first in 0..gaps.len() {
            // The nearest spheres first: few need the others.
            let least = (first..gaps.len()).min_by(|&j, &k| gaps[j].1.total_cmp(&gaps[k].1))?;
            gaps.swap(first, least);
            let (pair, gap) = gaps[first];
            if gap > limit {
                break;
            }
            let (sides, moved) = self.look_at(pair)?;
            if nearest.is_some_and(|found| are_beyond(sides, moved, (found.normal, limit))) {
                continue;
            }
            let DistanceResult::Apart(found) = distance_at(at, sides[0], sides[1]).0 else {
                return None;
            };
            let found = Distance { error_bound: (found.error_bound + moved).next_up(), ..found };
            limit = met(pair, sides, found)?;
            if nearest.is_none_or(|nearest| found.distance < nearest.distance) {
                nearest = Some(found);
            }
        }
        Some(())
    }
}

/// Whether two parts that are moved by so much are no nearer than a limit, as the normal of others shows: one support of
/// each in place of a search. False of spheres and capsules, whose distances mostly take a formula.
fn are_beyond([a, b]: [PosedShape<'_>; 2], moved: f64, (normal, limit): (DVec3, f64)) -> bool {
    let is_round = |side: PosedShape<'_>| {
        let kind = side.shape.as_polytope().map(Polytope::kind);
        matches!(kind, Some(Kind::Point | Kind::Segment))
    };
    let gap = || gap_along(a, b, normal);
    !is_round(a) && !is_round(b) && gap().is_some_and(|gap| (gap - moved).next_down() >= limit)
}

#[cfg(test)]
mod tests;
