//! Compounds of few parts at the accuracies of f32 and f64: each part as it was given, at a pose of its own.
//!
//! A compound's answers are for its parts as it placed them, cuboids as hulls of eight points and cylinders by their
//! support maps. As they were given they have closed forms; what the products of two poses lose is a length, by which the
//! parts are moved at most, and by which a distance or a depth changes at most (docs/numerics/proofs.md, "Parts as they
//! were given"). What that leaves open is left to the parts as they are placed.

mod candidates;
mod framed;
mod slab;
mod touching;

use super::{Accuracy, CERTIFIED, Feature, depths};
use crate::distance::{Distance, DistanceResult, distance_at, gap_along};
use crate::epa::{self, Depth};
use crate::mesh::{self, OfTriangle};
use crate::{PosedShape, PosedSupport, Verdict, certified, closed};
pub(crate) use candidates::may_be_nearest;
pub(super) use candidates::touching;
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Part, Polytope, Pose, Shape, SupportMap};
pub(super) use framed::Framed;
use slab::Slab;
use std::cell::OnceCell;
pub use touching::PartContact;
pub(crate) use touching::{FoundParts, PartSpheres};
pub(super) use touching::{TouchingParts, depth_of_known, wholes_in_order};

/// The most parts of one shape, those of two make 1,024 pairs, each of which takes a comparison of spheres. More: the tree over them
/// is quicker.
pub(super) const MOST: usize = 32;

/// What moving a part to its place twice, or by a product of poses, loses. Unit: u of the part's reach and its place.
/// Derived: 32.
const PLACED: f64 = 34.0;

/// The same in the compound's own frame, of the part's reach and its place there. Derived: 8.
const IN_FRAME: f64 = 8.5;

/// The most that may be, relative to the part's reach: far from the origin rounding is more than the accuracy allows.
const NEAR: f64 = 1e-10;

/// What the height of a sphere's centre over a slab may be off. Relative to the lengths. Derived: 2.1 times
/// [`slab::TURNED`], and 24u. Smaller: parts that are missed.
const ABOVE: f64 = 4e-12;

/// What a bound may be at the accuracy of f64, relative to the pair's size: what [`Accuracy::F64`] promises of a depth, and four times
/// what it does of a distance. Decides who answers. Smaller: more pairs by their placed parts.
const OF_SIZE: [f64; 2] = [256.0 * UNIT, 128.0 * UNIT];

/// The same, relative to a depth or distance.
const OF_LENGTH: f64 = 1e-10;

/// Unit roundoff.
const UNIT: f64 = f64::EPSILON / 2.0;

/// A part, or a convex shape as its own only one.
struct Placed<'a> {
    whole: PosedShape<'a>,
    part: Option<&'a Part>,
    /// A sphere round it; of infinite radius for a half-space. World.
    centre: DVec3,
    radius: f64,
    slab: Option<Slab>,
    at: At<'a>,
}

/// Where a part is, and how far its points may be from those of the part that answers are given for, metres.
enum At<'a> {
    Known(&'a Pose, f64),
    /// Made when it is first needed; `None` where that is too far.
    Product(OnceCell<Option<(Pose, f64)>>),
}

/// Whose frame a shape's parts are seen in.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Frame {
    Own,
    Other,
}

/// How many parts of a shape are kept in place. Larger: kilobytes in which every pair marks all places as empty. Smaller: memory
/// that is asked for.
const IN_PLACE: usize = 8;

/// Those of one shape.
#[derive(Default)]
struct Parts<'a> {
    first: [Option<Placed<'a>>; IN_PLACE],
    others: Vec<Placed<'a>>,
}

/// Two shapes that are made of few parts, or one of them and a convex one; in the order that is one for (a, b) and (b, a).
#[derive(Default)]
pub(super) struct Couple<'a> {
    a: Parts<'a>,
    b: Parts<'a>,
    /// By how much more a distance or a depth may be off than the parts are moved: metres.
    lost: f64,
}

impl<'a> Placed<'a> {
    /// `None` for shapes that are known by their support maps alone.
    // Written where it is kept.
    #[inline(always)]
    fn of(whole: PosedShape<'a>, part: Option<&'a Part>, frame: Frame) -> Option<Self> {
        // As it was given: what was placed is in memory that nothing else reads.
        let shape = part.map_or(whole.shape, |part| &part.shape);
        let (middle, radius) = match shape {
            Shape::Polytope(polytope) => {
                (polytope.inner().centre, polytope.outer_radius() + polytope.swept_radius())
            }
            Shape::Curved(curved) => (DVec3::ZERO, curved.reach() + curved.swept_radius()),
            Shape::HalfSpace(_) => (DVec3::ZERO, f64::INFINITY),
            _ => return None,
        };
        let Some(part) = part else {
            let (centre, at) = (whole.pose.apply(middle), At::Known(whole.pose, 0.0));
            return Some(Self { whole, part, centre, radius, slab: Slab::of(whole), at });
        };
        let (middle, moved) = (part.pose.apply(middle), moved_in_frame(part)?);
        // What was placed is elsewhere by that, and so may the centre be.
        let radius = radius + 2.0 * moved;
        let (centre, at) = match frame {
            Frame::Own => (middle, At::Known(&part.pose, moved)),
            Frame::Other => (whole.pose.apply(middle), At::Product(OnceCell::new())),
        };
        Some(Self { whole, part: Some(part), centre, radius, slab: None, at })
    }

    /// As it was given.
    fn shape(&self) -> &Shape {
        self.part.map_or(self.whole.shape, |part| &part.shape)
    }

    /// As it was given, where it is; and by how much it is moved.
    fn posed(&self) -> Option<(PosedShape<'_>, f64)> {
        let shape = self.shape();
        let (pose, moved) = match &self.at {
            &At::Known(pose, moved) => (pose, moved),
            At::Product(made) => {
                let made = made.get_or_init(|| place(self.whole.pose, self.part?)).as_ref()?;
                (&made.0, made.1)
            }
        };
        Some((PosedShape { shape, pose }, moved))
    }

    /// At most how far apart two are, as the spheres round them show, or a sphere and a slab.
    fn gap(&self, other: &Self) -> f64 {
        let of_slab = match (self.slab, other.slab) {
            (Some(slab), None) => other.gap_beside(slab),
            (None, Some(slab)) => self.gap_beside(slab),
            _ => f64::NEG_INFINITY,
        };
        let far = self.centre.abs().element_sum() + other.centre.abs().element_sum();
        let radii = (self.radius + other.radius) * (1.0 + 1e-5);
        let of_spheres = self.centre.distance(other.centre) - radii - 64.0 * UNIT * far;
        // A sphere round a half-space says nothing.
        if of_spheres > of_slab { of_spheres } else { of_slab }
    }

    /// The same of the sphere and a slab.
    fn gap_beside(&self, Slab { outward, low, high, far }: Slab) -> f64 {
        let height = outward.dot(self.centre);
        let lost = ABOVE * (far + self.centre.abs().element_sum());
        (height - high).max(low - height) - self.radius * (1.0 + 1e-5) - lost
    }
}

/// Where a part of a compound is, and how far that may be from where the compound has it.
pub(super) fn place(whole: &Pose, part: &Part) -> Option<(Pose, f64)> {
    let turned = *whole.rotation() * *part.pose.rotation();
    let pose = Pose::from_matrix(turned, whole.apply(part.pose.translation())).ok()?;
    let reach = part.reach();
    let size = reach + part.pose.translation().length() + pose.translation().length();
    // Of a curved part that was moved the support map is what answers are given for.
    let moved = PLACED * UNIT * size + 2.0 * part.placed().support_error();
    (moved <= NEAR * reach).then_some((pose, moved))
}

/// How far a part may be from where its compound has it, in the compound's frame. `None` where that is too far.
pub(super) fn moved_in_frame(part: &Part) -> Option<f64> {
    let reach = part.reach();
    let size = reach + part.pose.translation().length();
    // Of a curved part that was moved the support map is what answers are given for.
    let moved = IN_FRAME * UNIT * size + 2.0 * part.placed().support_error();
    (moved <= NEAR * reach).then_some(moved)
}

impl<'a> Parts<'a> {
    /// `None` of shapes that are neither convex nor compounds, and of too many.
    fn fill(&mut self, side: PosedShape<'a>, frame: Frame) -> Option<()> {
        let Self { first, others } = self;
        let Shape::Compound(compound) = side.shape else {
            first[0] = Some(Placed::of(side, None, frame).filter(|_| side.shape.is_convex())?);
            return Some(());
        };
        let parts = compound.parts();
        if parts.len() > MOST {
            return None;
        }
        for (slot, part) in first.iter_mut().zip(parts) {
            *slot = Some(Placed::of(side, Some(part), frame)?);
        }
        for part in parts.iter().skip(IN_PLACE) {
            others.push(Placed::of(side, Some(part), frame)?);
        }
        Some(())
    }

    /// How many have no formula with each other, and with most others one; `None` where some have none.
    fn count_hulls(&self) -> Option<usize> {
        let is_hull = |(_, part): (u32, &Placed<'_>)| match part.shape() {
            Shape::Polytope(polytope) => Some(polytope.kind() == Kind::Hull),
            Shape::HalfSpace(_) => Some(false),
            _ => None,
        };
        self.all().map(is_hull).try_fold(0, |count, is_one| Some(count + usize::from(is_one?)))
    }

    /// With their numbers.
    fn all(&self) -> impl Iterator<Item = (u32, &Placed<'a>)> {
        (0..).zip(self.first.iter().map_while(Option::as_ref).chain(&self.others))
    }

    fn get(&self, number: u32) -> Option<&Placed<'a>> {
        let number = number as usize;
        match self.first.get(number) {
            Some(slot) => slot.as_ref(),
            None => self.others.get(number - IN_PLACE),
        }
    }
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
    /// Takes two shapes in place of what there was: `None`, and nothing of use, of meshes, and of other shapes than
    /// [`Parts::fill`] has.
    fn take(&mut self, framed: &'a Framed<'_>) -> Option<()> {
        let [a, b] = framed.sides();
        if matches!(a.shape, Shape::Mesh(_)) || matches!(b.shape, Shape::Mesh(_)) {
            return None;
        }
        self.a.fill(a, if framed.is_own() { Frame::Own } else { Frame::Other })?;
        self.b.fill(b, Frame::Other)?;
        self.lost = framed.lost();
        Some(())
    }

    /// The same; `None` also of parts of which more than a quarter of the pairs need a search. The bounds that are known of placed
    /// parts spare more of these than given parts are quicker.
    pub(super) fn fill(&mut self, framed: &'a Framed<'_>) -> Option<()> {
        self.take(framed)?;
        let searched = self.a.count_hulls()? * self.b.count_hulls()?;
        let all = self.a.all().count() * self.b.all().count();
        (4 * searched <= all).then_some(())
    }

    /// Finds the pairs of parts that touch, by index, each with its depth from the first to the second. `None` where that
    /// is not known at once.
    pub(super) fn touching(
        &self,
        (at, wanted): (Accuracy, Wanted),
        scratch: &mut epa::Scratch,
        mut found: impl FnMut([u32; 2], Depth),
    ) -> Option<()> {
        let mut deepest = 0.0;
        for (j, part_a) in self.a.all() {
            for (k, part_b) in self.b.all() {
                let gap = part_a.gap(part_b) - self.lost;
                if gap > 0.0 || wanted == Wanted::Deepest && -gap < deepest {
                    continue;
                }
                let ((in_a, moved_a), (in_b, moved_b)) = (part_a.posed()?, part_b.posed()?);
                let moved = moved_a + moved_b + self.lost;
                if let Known::Deep(depth) = touch(at, [in_a, in_b], moved, scratch)? {
                    deepest = (depth.depth - depth.error_bound).max(deepest);
                    found([j, k], depth);
                }
            }
        }
        Some(())
    }

    /// Two parts by index, where they are and as they were given; and by how much they are moved.
    pub(super) fn posed(&self, [j, k]: [u32; 2]) -> Option<([PosedShape<'_>; 2], f64)> {
        let (part_a, part_b) = (self.a.get(j)?, self.b.get(k)?);
        let ((in_a, moved_a), (in_b, moved_b)) = (part_a.posed()?, part_b.posed()?);
        Some(([in_a, in_b], moved_a + moved_b + self.lost))
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
    couple.take(&framed)?;
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
    /// Hands on the pairs of parts that may be the nearest, by index, where they are and how far apart, with what they are moved by
    /// in the bound, the nearest spheres first. `met` returns from which distance on another is of no interest. `None` where it
    /// returns that, and where a pair is not known to be apart.
    fn nearest(
        &self,
        at: Accuracy,
        mut met: impl FnMut([u32; 2], [PosedShape<'_>; 2], Distance) -> Option<f64>,
    ) -> Option<()> {
        let mut gaps = Vec::with_capacity(self.a.all().count() * self.b.all().count());
        for (j, part_a) in self.a.all() {
            let gap = |(k, part_b)| (part_a.gap(part_b) - self.lost, [j, k], [part_a, part_b]);
            gaps.extend(self.b.all().map(gap));
        }
        let (mut nearest, mut limit): (Option<Distance>, f64) = (None, f64::INFINITY);
        for first in 0..gaps.len() {
            // The nearest spheres first: few need the others.
            let least = (first..gaps.len()).min_by(|&j, &k| gaps[j].0.total_cmp(&gaps[k].0))?;
            gaps.swap(first, least);
            let (gap, pair, [part_a, part_b]) = gaps[first];
            if gap > limit {
                break;
            }
            let ((in_a, moved_a), (in_b, moved_b)) = (part_a.posed()?, part_b.posed()?);
            let moved = moved_a + moved_b + self.lost;
            if nearest.is_some_and(|found| are_beyond([in_a, in_b], moved, (found.normal, limit))) {
                continue;
            }
            let DistanceResult::Apart(found) = distance_at(at, in_a, in_b).0 else {
                return None;
            };
            let found = Distance { error_bound: (found.error_bound + moved).next_up(), ..found };
            limit = met(pair, [in_a, in_b], found)?;
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
