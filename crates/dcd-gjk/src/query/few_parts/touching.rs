//! The parts of two shapes of which the lanes know that they touch, and mostly how deep: those alone are placed, as they were given.

use super::{Framed, Given, Known, is_good, touch};
use crate::closed::Axes;
use crate::epa::{self, Depth};
use crate::query::manifold::depth_of_patch;
use crate::query::{Accuracy, CuboidPatch, depths};
use crate::simd::depth_of_cuboids;
use crate::{PosedShape, Verdict, mesh};
use dcd_geom::glam::DVec3;

/// Two parts that touch, and what the lanes found of them.
#[derive(Clone, Copy, Debug)]
pub struct PartContact<'a> {
    /// Which part of a, and which of b; 0 of a convex shape, its own only part.
    pub(crate) parts: [u32; 2],
    pub(crate) spheres: PartSpheres,
    pub(crate) found: FoundParts<'a>,
}

/// Spheres in two parts and round them, as they are placed: what rounding loses is counted. Metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartSpheres {
    /// From the centre of a's to that of b's.
    pub(crate) between: DVec3,
    /// The sum of the radii of those in the parts.
    pub(crate) inner: f64,
    /// The same of those round them.
    pub(crate) outer: f64,
}

/// What the lanes found of two parts, from a to b.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FoundParts<'a> {
    Nothing,
    /// How deep they overlap as they are placed.
    Depth(Depth),
    /// Of two cuboids the axes that may be the least.
    Axes(Axes),
    /// Of two cuboids where they touch.
    Patch(CuboidPatch<'a>),
}

/// For how many parts of a shape there is memory before they are looked at. Larger: memory for nothing. Smaller: more is asked for
/// later.
const FEW: usize = 8;

/// Pairs of parts of two shapes in an order that is one for (a, b) and (b, a).
pub(in crate::query) struct TouchingParts<'a> {
    framed: &'a Framed<'a>,
    /// In the world, in their order.
    wholes: [PosedShape<'a>; 2],
    is_swapped: bool,
    known: &'a [PartContact<'a>],
    /// Of each shape those that touch any of the other.
    parts: [Vec<Given<'a>>; 2],
}

/// Two shapes in the order that is one for (a, b) and (b, a), and whether that is the other.
pub(in crate::query) fn wholes_in_order<'a>(
    [a, b]: [PosedShape<'a>; 2],
) -> ([PosedShape<'a>; 2], bool) {
    let is_swapped = mesh::is_swapped(a, b);
    (if is_swapped { [b, a] } else { [a, b] }, is_swapped)
}

/// The depth of the deepest two parts, of those that are known to touch; `None` where one cannot be measured as it was given.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(in crate::query) fn depth_of_known(
    at: Accuracy,
    known: &mut [PartContact<'_>],
    sides: [PosedShape<'_>; 2],
    scratch: &mut epa::Scratch,
) -> Option<Depth> {
    let (wholes, is_swapped) = wholes_in_order(sides);
    let framed = Framed::round_first(wholes)?;
    let found = TouchingParts::of(&framed, (wholes, is_swapped), known)?.deepest(at, scratch)?;
    Some(if is_swapped { found.mirrored() } else { found })
}

impl<'a> TouchingParts<'a> {
    /// Of shapes in their order, and the contacts of their parts, which it brings into an order; `None` where a part is farther
    /// from where its compound has it than is allowed.
    pub(in crate::query) fn of(
        framed: &'a Framed<'a>,
        (wholes, is_swapped): ([PosedShape<'a>; 2], bool),
        known: &'a mut [PartContact<'_>],
    ) -> Option<Self> {
        let numbers = |contact: &PartContact<'_>| {
            let [a, b] = contact.parts;
            if is_swapped { [b, a] } else { [a, b] }
        };
        known.sort_unstable_by_key(numbers);
        let few = known.len().min(FEW);
        let mut parts = [Vec::with_capacity(few), Vec::with_capacity(few)];
        let seen = framed.sides();
        for contact in &*known {
            for (k, number) in numbers(contact).into_iter().enumerate() {
                if find(&parts[k], number).is_none() {
                    parts[k].push(Given::of(wholes[k].shape, seen[k].pose, number)?);
                }
            }
        }
        Some(Self { framed, wholes, is_swapped, known, parts })
    }

    /// How many contacts there are.
    pub(in crate::query) fn len(&self) -> usize {
        self.known.len()
    }

    /// The most that the pose of a part, or the product of both poses, is off a rotation.
    pub(in crate::query) fn deviation(&self) -> f64 {
        let all = self.parts.iter().flatten();
        all.map(|part| part.pose.deviation()).fold(0.0, f64::max)
    }

    /// The parts of the contact of that number.
    pub(in crate::query) fn pair(&self, number: usize) -> [u32; 2] {
        self.in_order(self.known[number].parts)
    }

    /// What is of a and of b, in the order of the wholes; and the other way round.
    fn in_order<T>(&self, [a, b]: [T; 2]) -> [T; 2] {
        if self.is_swapped { [b, a] } else { [a, b] }
    }

    /// The patch of the contact of that number, and its parts from a to b, if the lanes know it.
    pub(in crate::query) fn patch(
        &self,
        number: usize,
    ) -> Option<(CuboidPatch<'a>, [PosedShape<'_>; 2])> {
        let FoundParts::Patch(patch) = self.known[number].found else { return None };
        let (sides, _) = self.posed(self.pair(number))?;
        Some((patch, self.in_order(sides)))
    }

    pub(in crate::query) fn is_swapped(&self) -> bool {
        self.is_swapped
    }

    /// Two of the parts where they are seen, and by how much they are moved.
    pub(in crate::query) fn posed(&self, [j, k]: [u32; 2]) -> Option<([PosedShape<'_>; 2], f64)> {
        let (a, b) = (find(&self.parts[0], j)?, find(&self.parts[1], k)?);
        Some(([a.posed(), b.posed()], a.moved + b.moved + self.framed.lost()))
    }

    /// How deep the parts of the contact of that number overlap, where they are seen; `None` where that is not known.
    pub(in crate::query) fn depth(
        &self,
        at: Accuracy,
        number: usize,
        scratch: &mut epa::Scratch,
    ) -> Option<Depth> {
        let pair = self.pair(number);
        let (sides, moved) = self.posed(pair)?;
        let ordered = |found: Depth| if self.is_swapped { found.mirrored() } else { found };
        let given = match self.known[number].found {
            FoundParts::Nothing => None,
            FoundParts::Depth(found) => return Some(self.framed.seen(ordered(found))),
            FoundParts::Axes(axes) => {
                let axes = if self.is_swapped { axes.mirrored() } else { axes };
                depth_of_cuboids(axes, sides, at)
            }
            FoundParts::Patch(patch) => depth_of_patch(patch, self.in_order(sides)).map(ordered),
        };
        let moved_by = |found: Depth| {
            let error_bound = (found.error_bound + moved).next_up();
            let good = is_good(at, (found.depth, error_bound), sides, super::OF_SIZE[0]);
            good.then_some(Depth { error_bound, ..found })
        };
        given.and_then(moved_by).or_else(|| match touch(at, sides, moved, scratch) {
            Some(Known::Deep(found)) => Some(found),
            _ => self.placed_depth(at, pair, scratch),
        })
    }

    /// The same of the parts as they are placed.
    fn placed_depth(
        &self,
        at: Accuracy,
        pair: [u32; 2],
        scratch: &mut epa::Scratch,
    ) -> Option<Depth> {
        let pairs = mesh::pairs_of(self.wholes, &[pair]);
        let measured = pairs
            .first()?
            .measured_by(self.wholes, |[a, b]| depths::of_touching(at, a, b, scratch));
        match measured {
            Verdict::Touching(found) => Some(self.framed.seen(found)),
            _ => None,
        }
    }

    /// At least how far the two of that number reach past each other along a unit vector, from the first to the second, and the sum
    /// of the radii of spheres round them: metres.
    pub(in crate::query) fn least_reach(&self, number: usize, normal: DVec3) -> [f64; 2] {
        let PartSpheres { between, inner, outer } = self.known[number].spheres;
        let along = normal.dot(between);
        [inner - if self.is_swapped { -along } else { along }, outer]
    }

    /// The depth of the deepest parts, in the world, from the first shape to the second.
    pub(in crate::query) fn deepest(
        &self,
        at: Accuracy,
        scratch: &mut epa::Scratch,
    ) -> Option<Depth> {
        let (mut most, mut upper, mut lower): (Option<Depth>, f64, f64) = (None, 0.0, 0.0);
        // Those of which the lanes know most come first: of the others few may be deeper.
        let is_unknown = |number: usize| matches!(self.known[number].found, FoundParts::Nothing);
        let mut order: Vec<usize> = (0..self.len()).collect();
        order.sort_by_key(|&number| is_unknown(number));
        for number in order {
            let PartSpheres { between, outer, .. } = self.known[number].spheres;
            if is_unknown(number) && outer - between.length() < lower {
                continue;
            }
            let found = self.depth(at, number, scratch)?;
            upper = upper.max(found.depth + found.error_bound);
            lower = lower.max(found.depth - found.error_bound);
            if most.is_none_or(|most| found.depth > most.depth) {
                most = Some(found);
            }
        }
        let most = most?;
        // Another may be deeper than the deepest by its own bound.
        let above = (upper - most.depth).next_up().min(f64::MAX);
        Some(self.framed.depth(Depth { error_bound: most.error_bound.max(above), ..most }))
    }
}

fn find<'p, 'a>(parts: &'p [Given<'a>], number: u32) -> Option<&'p Given<'a>> {
    parts.iter().find(|part| part.number == number)
}
