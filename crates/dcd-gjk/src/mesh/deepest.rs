//! How deep two shapes overlap that are made of parts: as deep as their deepest two parts.

use super::side::{Parts, Side};
use super::{Scratch, in_order, pair, touching};
use crate::epa::Depth;
use crate::{PosedShape, Verdict};
use dcd_geom::Shape;
use std::borrow::Cow;

/// Which part of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PartIndex {
    /// Of a compound's parts.
    Part(u32),
    /// Of a mesh's triangles.
    Triangle(u32),
}

/// Two parts that touch, of a and of b; each in the frame of its whole.
pub(crate) struct PartPair<'s> {
    /// `None` for a convex shape, which is its own only part.
    pub(crate) parts: [Option<PartIndex>; 2],
    pub(crate) shapes: [Cow<'s, Shape>; 2],
}

/// Whether (a, b) is the other way round than the pair is solved in.
pub(crate) fn is_swapped(a: PosedShape<'_>, b: PosedShape<'_>) -> bool {
    in_order(a, b).1
}

/// All pairs of parts that are known to touch, in one order for (a, b) and (b, a).
pub(crate) fn touching_parts<'s>(a: PosedShape<'s>, b: PosedShape<'s>) -> Vec<PartPair<'s>> {
    let (_, swapped) = in_order(a, b);
    let (first, second) = if swapped { (b, a) } else { (a, b) };
    let mut pairs = Vec::new();
    // What is undecided is not in the list, and counts as apart.
    let _ = touching(first, second, &mut Scratch::default(), &mut pairs);
    let sides = [Side::of(a), Side::of(b)];
    let of = |mut parts: [u32; 2]| {
        if swapped {
            parts.reverse();
        }
        let [side_a, side_b] = &sides;
        let shapes =
            [pair::to_shape(side_a.part(parts[0]))?, pair::to_shape(side_b.part(parts[1]))?];
        Some(PartPair { parts: [index(side_a, parts[0]), index(side_b, parts[1])], shapes })
    };
    pairs.into_iter().filter_map(of).collect()
}

fn index(side: &Side<'_>, part: u32) -> Option<PartIndex> {
    match side.parts {
        Parts::One(_) => None,
        Parts::Compound(_) => Some(PartIndex::Part(part)),
        Parts::Mesh(_) => Some(PartIndex::Triangle(part)),
    }
}

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
    let mut deepest = Deepest::default();
    for PartPair { shapes: [in_a, in_b], .. } in touching_parts(a, b) {
        let in_a = PosedShape { shape: &in_a, pose: a.pose };
        match depth(in_a, PosedShape { shape: &in_b, pose: b.pose }) {
            Verdict::Touching(found) => deepest.add(found),
            Verdict::Apart => continue,
            Verdict::Undecided(reason) => return Verdict::Undecided(reason),
        };
    }
    Verdict::Touching(deepest.depth())
}

/// The greatest of several depths, the first of equals.
#[derive(Default)]
pub(crate) struct Deepest {
    most: Option<Depth>,
    upper: f64,
}

impl Deepest {
    /// Whether it is the greatest so far.
    pub(crate) fn add(&mut self, found: Depth) -> bool {
        self.upper = self.upper.max(found.depth + found.error_bound);
        let is_most = self.most.is_none_or(|most| found.depth > most.depth);
        if is_most {
            self.most = Some(found);
        }
        is_most
    }

    pub(crate) fn depth(&self) -> Depth {
        let most = self.most.unwrap_or_default();
        // Another may be deeper than the deepest by its own bound.
        let above = (self.upper - most.depth).next_up().min(f64::MAX);
        Depth { error_bound: most.error_bound.max(above), ..most }
    }
}
