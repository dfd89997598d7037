//! How deep two shapes overlap that are made of parts: as deep as their deepest two parts.

use super::reach::{Couple, Direction};
use super::side::{Part, Parts, Side};
use super::{Scratch, is_swapped, pair, touching_or_open};
use crate::epa::Depth;
use crate::{PosedShape, Reason, Verdict};
use dcd_geom::Shape;
use dcd_geom::glam::DVec3;
use std::cell::{Cell, OnceCell};

/// Which part of a shape.
// Numbered from one: `None` of an `Option` is all zeros then, so that an empty manifold is cleared and not copied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u32)]
pub enum PartIndex {
    /// Of a compound's parts.
    Part(u32) = 1,
    /// Of a mesh's triangles.
    Triangle(u32) = 2,
}

/// Two parts that touch, of a and of b; each in the frame of its whole.
pub(crate) struct PartPair<'s> {
    /// `None` for a convex shape, which is its own only part.
    pub(crate) parts: [Option<PartIndex>; 2],
    sides: [Part<'s>; 2],
    /// Of a triangle, which becomes a shape when it is first needed: most pairs need none.
    shapes: [OnceCell<Option<Box<Shape>>>; 2],
    /// The two in the order that is one for (a, b) and (b, a); `None` where their reach is not known.
    couple: Option<Couple<'s>>,
    /// Whether b is the first of these.
    swapped: bool,
    /// See [`PartPair::at_most`]: few pairs need it.
    at_most: OnceCell<f64>,
    /// The depth of a triangle and a sphere or capsule whose cores do not meet, in that order.
    nearest: Option<Depth>,
    /// How far they reach past each other along the direction that was asked for last, in that order.
    last_along: Cell<Option<(DVec3, f64)>>,
    /// At least the sum of the two diameters.
    diameters: OnceCell<f64>,
    /// What was measured of them.
    depth: OnceCell<Verdict<Depth>>,
    /// Whether no formula finds it.
    has_no_formula: Cell<bool>,
}

/// All pairs of parts that touch, or of which that is not known, in one order for (a, b) and (b, a).
pub(crate) fn touching_parts<'s>(
    a: PosedShape<'s>,
    b: PosedShape<'s>,
    scratch: &mut Scratch,
) -> Vec<PartPair<'s>> {
    let swapped = is_swapped(a, b);
    let (first, second) = if swapped { (b, a) } else { (a, b) };
    let mut pairs = Vec::new();
    touching_or_open([first, second], scratch, &mut pairs);
    if swapped {
        pairs.iter_mut().for_each(|parts| parts.reverse());
    }
    pairs_of([a, b], &pairs)
}

/// These pairs of a part of a and one of b, in their order.
pub(crate) fn pairs_of<'s>([a, b]: [PosedShape<'s>; 2], pairs: &[[u32; 2]]) -> Vec<PartPair<'s>> {
    let swapped = is_swapped(a, b);
    let sides = [Side::of(a), Side::of(b)];
    let of = |parts: &[u32; 2]| {
        let [side_a, side_b] = &sides;
        let [part_a, part_b] = [side_a.part(parts[0]), side_b.part(parts[1])];
        let couple = match swapped {
            true => Couple::of([part_b, part_a], [b.pose, a.pose]),
            false => Couple::of([part_a, part_b], [a.pose, b.pose]),
        };
        let nearest = couple.as_ref().and_then(Couple::by_nearest);
        PartPair {
            parts: [index(side_a, parts[0]), index(side_b, parts[1])],
            sides: [part_a, part_b],
            shapes: Default::default(),
            swapped,
            at_most: OnceCell::new(),
            nearest,
            couple,
            last_along: Cell::new(None),
            diameters: OnceCell::new(),
            depth: OnceCell::new(),
            has_no_formula: Cell::new(false),
        }
    };
    pairs.iter().map(of).collect()
}

/// Which part of a shape is its part of that number.
pub(crate) fn part_index(shape: &Shape, part: u32) -> Option<PartIndex> {
    match shape {
        Shape::Compound(_) => Some(PartIndex::Part(part)),
        Shape::Mesh(_) => Some(PartIndex::Triangle(part)),
        _ => None,
    }
}

fn index(side: &Side<'_>, part: u32) -> Option<PartIndex> {
    match side.parts {
        Parts::One(_) => None,
        Parts::Compound(_) => Some(PartIndex::Part(part)),
        Parts::Mesh(_) => Some(PartIndex::Triangle(part)),
    }
}

impl PartPair<'_> {
    /// The two parts where their wholes are; `None` for a triangle that is no shape.
    pub(crate) fn posed<'p>(
        &'p self,
        a: PosedShape<'p>,
        b: PosedShape<'p>,
    ) -> Option<[PosedShape<'p>; 2]> {
        let shape = |k: usize| match self.sides[k] {
            Part::Shape(shape) => Some(shape),
            triangle => {
                let make = || pair::to_shape(triangle).map(|made| Box::new(made.into_owned()));
                self.shapes[k].get_or_init(make).as_deref()
            }
        };
        let (in_a, in_b) = (shape(0)?, shape(1)?);
        Some([PosedShape { shape: in_a, pose: a.pose }, PosedShape { shape: in_b, pose: b.pose }])
    }

    /// Two triangles where their wholes are, with their swept radii: world axes, from a's origin. `None` of others.
    pub(crate) fn triangles(&self, [a, b]: [PosedShape<'_>; 2]) -> Option<[([DVec3; 3], f64); 2]> {
        let [
            Part::Triangle { corners: in_a, radius: radius_a, .. },
            Part::Triangle { corners: in_b, radius: radius_b, .. },
        ] = self.sides
        else {
            return None;
        };
        let delta = b.pose.translation() - a.pose.translation();
        let in_a = in_a.map(|corner| *a.pose.rotation() * corner);
        let in_b = in_b.map(|corner| *b.pose.rotation() * corner + delta);
        Some([(in_a, radius_a), (in_b, radius_b)])
    }

    /// Its depth, if it is known or `measure` finds it with that effort.
    pub(crate) fn depth_by(
        &self,
        effort: Effort,
        measure: impl FnOnce() -> Option<Verdict<Depth>>,
    ) -> Option<Verdict<Depth>> {
        if let Some(known) = self.depth.get() {
            return Some(*known);
        }
        if effort == Effort::Formula && self.has_no_formula.get() {
            return None;
        }
        let found = measure();
        self.has_no_formula.set(found.is_none());
        found.map(|found| *self.depth.get_or_init(|| found))
    }

    /// What a solver of two convex shapes says of it. It is asked in the order of the wholes: equal parts at one place have none.
    pub(crate) fn measured_by(
        &self,
        [a, b]: [PosedShape<'_>; 2],
        measure: impl FnOnce([PosedShape<'_>; 2]) -> Verdict<Depth>,
    ) -> Verdict<Depth> {
        // Checked corners are finite, and a hull of three is never refused.
        let Some([a, b]) = self.posed(a, b) else { return Verdict::Undecided(Reason::Range) };
        if self.swapped { measure([b, a]).map(Depth::mirrored) } else { measure([a, b]) }
    }

    /// It is known to be at most so deep, metres: the same for (a, b) and (b, a).
    pub(crate) fn bound(&mut self, at_most: f64) {
        self.at_most = OnceCell::from(at_most);
    }

    /// Nothing is known of its depth any more.
    pub(crate) fn forget_bound(&mut self) {
        self.at_most = OnceCell::from(f64::INFINITY);
    }

    /// An upper bound of how deep they overlap, metres; the same for (a, b) and (b, a).
    fn at_most(&self) -> f64 {
        *self.at_most.get_or_init(|| match (self.depth.get(), &self.nearest, &self.couple) {
            (Some(Verdict::Touching(found)), ..) | (_, Some(found), _) => {
                (found.depth + found.error_bound).next_up()
            }
            (_, None, Some(couple)) => couple.most(),
            (_, None, None) => f64::INFINITY,
        })
    }

    /// Whether one of the two is a sphere, which has no face and no edge, and the other is bounded.
    pub(crate) fn has_no_corners(&self) -> bool {
        let is_bounded = |part: &Part<'_>| match part {
            Part::Triangle { .. } => true,
            Part::Shape(shape) => shape.is_bounded(),
        };
        self.sides.iter().any(Part::is_sphere) && self.sides.iter().all(is_bounded)
    }

    /// A normal from a to b as one from the first to the second.
    fn in_order(&self, normal: DVec3) -> DVec3 {
        if self.swapped { -normal } else { normal }
    }

    /// Its depth where a part is a sphere, a capsule or a cuboid, or pressed into the face of a triangle, or where both are
    /// triangles, with a bound of at most a part `relative` of it or `of_size` of the pair's size.
    pub(crate) fn by_formula(&self, good: [f64; 2]) -> Option<Depth> {
        let couple = self.couple.as_ref()?;
        let is_good = couple.is_good(good);
        let nearest = self.nearest.filter(&is_good);
        let found = nearest.or_else(|| couple.by_formula(None, is_good))?;
        Some(if self.swapped { found.mirrored() } else { found })
    }

    /// A normal from a to b as all pairs of parts of the same two shapes see it; `None` where their reach is not known.
    pub(crate) fn direction(&self, normal: DVec3) -> Option<Direction> {
        Some(self.couple.as_ref()?.direction(self.in_order(normal)))
    }

    /// What is proved of the pair along a normal from a to b.
    pub(crate) fn along(&self, direction: Option<&Direction>) -> Along {
        let reach = self.couple.as_ref().zip(direction).map(|(couple, direction)| {
            let slack = couple.slack();
            let least = self.reach_along(couple, direction) - slack;
            let diameters = self.diameters.get_or_init(|| couple.diameters(slack));
            Reach { least, slack, diameters: *diameters }
        });
        Along { reach, at_most: self.at_most() }
    }

    /// An upper bound of how deep they overlap, as known from a normal from a to b: metres.
    fn most_along(&self, normal: DVec3) -> f64 {
        self.couple.as_ref().map_or(f64::INFINITY, |couple| {
            let direction = couple.direction(self.in_order(normal));
            couple.at_most_by(direction.world(), self.reach_along(couple, &direction))
        })
    }

    /// [`Couple::along`], which is the same as long as the direction is.
    fn reach_along(&self, couple: &Couple<'_>, direction: &Direction) -> f64 {
        match self.last_along.get() {
            Some((last, reach)) if last == direction.world() => reach,
            _ => {
                let reach = couple.along_direction(direction);
                self.last_along.set(Some((direction.world(), reach)));
                reach
            }
        }
    }
}

/// How two parts that touch lie along a normal.
#[derive(Clone, Copy)]
pub(crate) struct Along {
    /// `None` where it is not known.
    reach: Option<Reach>,
    /// At least their depth.
    at_most: f64,
}

/// How far two parts reach past each other along a normal, metres.
#[derive(Clone, Copy)]
struct Reach {
    /// Moved apart by less along the normal they touch; by twice the slack more they do not.
    least: f64,
    slack: f64,
    /// At least the sum of the two diameters.
    diameters: f64,
}

impl Along {
    /// By how much more than a depth the two must be moved along the normal at the most to come apart, if it is, but for rounding, at
    /// most a part `near` of the diameters.
    pub(crate) fn rest(&self, depth: f64, near: f64) -> Option<f64> {
        let Reach { least, slack, diameters } = self.reach.as_ref()?;
        let rest = least - depth;
        (rest <= near * diameters).then(|| (rest + 2.0 * slack).max(0.0))
    }

    /// Whether their depth may be along a direction that is within `angle`, radians, of the normal.
    ///
    /// Along two such directions the reach differs by at most the angle's share of the two diameters, since the
    /// parts have a point in common.
    pub(crate) fn may_be_within(&self, angle: f64) -> bool {
        let may_be = |reach: &Reach| reach.least <= self.at_most + angle * reach.diameters;
        self.reach.as_ref().is_none_or(may_be)
    }
}

/// How much deeper than the deepest a pair of parts may be that is not measured, relative to its depth. Larger:
/// a wider bound. Smaller: triangles in one plane, equally deep but for rounding, are all measured.
pub(crate) const AS_DEEP: f64 = 1e-11;

/// How a depth is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    /// By a formula, if there is one.
    Formula,
    /// By whatever it takes.
    Whole,
}

/// The greatest of the depths of all touching pairs of parts, each as `depth` says, and the pair's index. Pairs that are
/// surely no deeper are not measured.
///
/// Moving the shapes apart by it along its normal separates those two parts, and maybe not the
/// others: it bounds from below what separates the whole. Mirrored for (b, a), bit for bit.
///
/// # Errors
/// Why a pair could not be measured; or that none is known to touch.
pub(crate) fn deepest(
    pairs: &[PartPair<'_>],
    depth: impl FnMut(&PartPair<'_>, Effort) -> Option<Verdict<Depth>>,
) -> Result<(usize, Depth), Reason> {
    deepest_of(pairs, 0..pairs.len(), depth)?.ok_or(Reason::WithinRounding)
}

/// The same of some pairs, by index; `None` where none of them is known to touch.
///
/// # Errors
/// Why a pair could not be measured.
pub(crate) fn deepest_of(
    pairs: &[PartPair<'_>],
    numbers: impl IntoIterator<Item = usize>,
    mut depth: impl FnMut(&PartPair<'_>, Effort) -> Option<Verdict<Depth>>,
) -> Result<Option<(usize, Depth)>, Reason> {
    let (mut deepest, mut index) = (Deepest::default(), 0);
    // What a formula finds is mostly the deepest, and its normal bounds the others.
    let mut others = Vec::new();
    for k in numbers {
        match depth(&pairs[k], Effort::Formula) {
            Some(Verdict::Touching(found)) if deepest.add(found) => index = k,
            Some(Verdict::Touching(_) | Verdict::Apart) => {}
            _ => others.push((pairs[k].at_most(), k)),
        }
    }
    // What may be the deepest first; the first of equals stays the first.
    others.sort_by(|(p, _), (q, _)| q.total_cmp(p));
    for (at_most, k) in others {
        if deepest.is_as_deep_as(at_most) {
            break;
        }
        let normal = deepest.most.map(|most| most.normal);
        if normal.is_some_and(|n| deepest.is_as_deep_as(pairs[k].most_along(n))) {
            continue;
        }
        match depth(&pairs[k], Effort::Whole) {
            Some(Verdict::Touching(found)) if deepest.add(found) => index = k,
            Some(Verdict::Undecided(reason)) => return Err(reason),
            _ => {}
        }
    }
    Ok(deepest.depth().map(|depth| (index, depth)))
}

/// The greatest of several depths, the first of equals.
#[derive(Default)]
pub(super) struct Deepest {
    most: Option<Depth>,
    upper: f64,
}

impl Deepest {
    /// Whether it is the greatest so far.
    pub(super) fn add(&mut self, found: Depth) -> bool {
        self.upper = self.upper.max(found.depth + found.error_bound);
        let is_most = self.most.is_none_or(|most| found.depth > most.depth);
        if is_most {
            self.most = Some(found);
        }
        is_most
    }

    /// The normal of the greatest.
    pub(super) fn normal(&self) -> Option<DVec3> {
        self.most.map(|most| most.normal)
    }

    /// Whether a pair that is at most so deep changes neither the greatest nor its bound.
    pub(super) fn bounds(&self, at_most: f64) -> bool {
        // Written so that NaN is not bounded.
        self.most.is_some_and(|most| at_most <= most.depth + most.error_bound)
    }

    /// Whether a pair that is at most so deep needs not be measured; if so it counts.
    fn is_as_deep_as(&mut self, at_most: f64) -> bool {
        let is = self.most.is_some_and(|most| at_most <= most.depth * (1.0 + AS_DEEP));
        if is {
            self.upper = self.upper.max(at_most);
        }
        is
    }

    pub(super) fn depth(&self) -> Option<Depth> {
        let most = self.most?;
        // Another may be deeper than the deepest by its own bound.
        let above = (self.upper - most.depth).next_up().min(f64::MAX);
        Some(Depth { error_bound: most.error_bound.max(above), ..most })
    }
}
