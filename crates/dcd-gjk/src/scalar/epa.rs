//! Penetration depth of polytopes, rounded or not, with a bound that holds.
//!
//! The depth of two overlapping shapes is the shortest way by which moving one of them parts
//! them: the least reach h(n) of C = A − B over all unit directions n. The expanding polytope
//! algorithm (van den Bergen 2001) holds an inner polytope P ⊂ C of vertices found so far, evaluates
//! C's reach along the normal of P's nearest face, and adds the vertex found. Two bounds close
//! in: every h(n) is at least the depth, and the plane of P nearest the origin is at most the depth
//! away.
//!
//! What usually breaks it is rounding: a face turned inside out, an origin that is outside the
//! first tetrahedron, a normal of a sliver. Here nothing on the way is rounded. The vertices of
//! both bodies are rounded once to a lattice of 2⁻⁸² of the pair's size, and from there on P,
//! its normals, what a new vertex sees and which vertex is farthest are exact integers of at most
//! 256 bits; f64 orders the faces and measures what was found. So:
//! - P is convex and closed at every step, coplanar and collinear vertices included;
//! - a step adds a vertex of a finite set that lies strictly outside P, so the search ends;
//! - distances are signed: an origin outside P is only a face with a negative distance, which is
//!   expanded first, until it is inside or a face's plane separates it from all of C. The first
//!   tetrahedron needs no overlap, and needs no other solver;
//! - a flat C has depth 0 and is distinguished from a thin one by exact rank;
//! - the bounds have no term relative to the pair's size but the lattice's, about 1e-23 of it, so
//!   depths far below the rounding of f64 are right in nearly all their digits.
//!
//! docs/numerics/proofs.md, "depth", derives the bounds.

mod answer;
mod apart;
mod hull;
mod lattice;
mod rival;
mod search;
mod start;
mod wide;
mod witness;

use crate::expanding::Surface;
use crate::simd::SearchAlone;
use crate::{PosedSupport, Verdict, exact, order};
use answer::{Answer, Certainty};
use apart::Gap;
use dcd_geom::Polytope;
use dcd_geom::glam::DVec3;
use hull::Hull;
use lattice::LatticeDifference;
use search::{Bounds, GROWTHS, Separated, Viewer};

/// How deep two shapes overlap, where, and what that is worth. World frame, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Depth {
    /// The length of the shortest translation that parts the shapes but for touching; 0 for
    /// shapes that just touch. Never negative, always finite.
    pub depth: f64,
    /// The direction of that translation for b, of unit length but for rounding: from a to b. It has no bound of its
    /// own: along it the shapes part a little later than after `depth + error_bound`, of rounded shapes up to some
    /// 1e-7 of their size.
    pub normal: DVec3,
    /// The point of a that is deepest in b: `point_a − point_b` is `normal·depth`, but for the
    /// rounding of world coordinates, on a curved surface for how far the chords of a search are inside of it, and for what a
    /// search leaves of its nearest points where cores hardly overlap, of flat hulls and of needles: some 1e-9 of the size, and at
    /// [`Accuracy::F32`](crate::query::Accuracy), there also of shapes far from the origins of their own frames, some 1e-6. The bound
    /// of a manifold counts it, this one's does not.
    pub point_a: DVec3,
    /// The point of b that is deepest in a.
    pub point_b: DVec3,
    /// The true depth is within `depth ± error_bound`. Finite; `f64::MAX` marks a depth that is
    /// known from below alone.
    pub error_bound: f64,
}

impl Depth {
    /// Whether the shapes overlap more deeply than f64, or a bound in f64, can express.
    pub fn is_saturated(&self) -> bool {
        self.error_bound == f64::MAX
    }

    /// How far the witnesses are from differing by it along its normal, metres.
    pub(crate) fn missed(&self) -> f64 {
        (self.point_a - self.point_b - self.normal * self.depth).length()
    }

    /// At most the true depth: at least 0, finite; 0 where the depth
    /// [is saturated](Self::is_saturated).
    pub fn lower(&self) -> f64 {
        (self.depth - self.error_bound).next_down().max(0.0)
    }

    /// At least the true depth, unless it [is saturated](Self::is_saturated). Finite.
    pub fn upper(&self) -> f64 {
        (self.depth + self.error_bound).next_up().min(f64::MAX)
    }

    /// The same with the shapes' parts exchanged.
    pub(crate) fn mirrored(self) -> Self {
        Self { normal: -self.normal, point_a: self.point_b, point_b: self.point_a, ..self }
    }
}

/// Memory that one query leaves to the next: after a few, a query allocates nothing.
#[derive(Debug, Default)]
pub struct Scratch {
    hull: Hull,
    dots: Vec<f64>,
    pub(crate) surface: Surface,
    /// Made where it is first of use: it is large.
    in_lanes: Option<Box<SearchAlone>>,
}

impl Scratch {
    /// The search in lanes, and the surface of the one in f64.
    pub(crate) fn searches(&mut self) -> (&mut SearchAlone, &mut Surface) {
        (&mut **self.in_lanes.get_or_insert_default(), &mut self.surface)
    }
}

/// Whether two placed polytopes touch, and how deep.
///
/// Every answer is proved, exact touching included: where the bounds of the depth leave it open,
/// the exact method decides. Never undecided; a depth that overflows is `f64::MAX`, marked by a
/// bound of `f64::MAX` (see [`Depth::is_saturated`]).
/// The answer for (b, a) is that for (a, b), mirrored bit for bit. Costs microseconds for hulls of
/// tens of vertices.
pub fn depth(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    scratch: &mut Scratch,
) -> Verdict<Depth> {
    let (depth, certainty) = in_canonical_order(a, b, scratch);
    match certainty {
        Certainty::Apart => Verdict::Apart,
        Certainty::Touching => Verdict::Touching(depth),
        _ if exact::touches(a, b, &[]) => Verdict::Touching(depth),
        _ => Verdict::Apart,
    }
}

/// How deep two placed polytopes overlap that are known to touch: always a depth.
///
/// For pairs that do not touch, against what was promised, the depth is 0 and the bound has no
/// meaning; a depth that overflows is the largest number.
pub fn depth_of_overlap(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    scratch: &mut Scratch,
) -> Depth {
    in_canonical_order(a, b, scratch).0
}

/// Whether the direction of least depth is the only one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// Any other is deeper, by more than a billionth of the depth of the rounded shapes; or its
    /// likes are a cone round it.
    Alone,
    /// Another is as good to within that, or which is better is unknown.
    Rivalled,
}

/// The depth of a pair known to touch, and whether its direction is the only one. Of a pair that is
/// apart, whether the direction of its distance is.
pub(crate) fn depth_and_direction(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    scratch: &mut Scratch,
) -> (Depth, Direction) {
    let mut direction = Direction::Rivalled;
    let radius = a.map.swept_radius() + b.map.swept_radius();
    let swapped = order::are_swapped(a, b);
    let (a, b) = if swapped { (b, a) } else { (a, b) };
    let (depth, _) = solve(a, b, scratch, |viewer, hull, outcome| {
        direction = match outcome {
            Outcome::Overlap(bounds) => viewer.direction(hull, bounds, radius),
            Outcome::Gap(gap) => viewer.direction_across(hull, gap, radius),
        };
    });
    (if swapped { depth.mirrored() } else { depth }, direction)
}

fn in_canonical_order(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    scratch: &mut Scratch,
) -> (Depth, Certainty) {
    if order::are_swapped(a, b) {
        let (depth, certainty) = solve(b, a, scratch, |_, _, _| {});
        (depth.mirrored(), certainty)
    } else {
        solve(a, b, scratch, |_, _, _| {})
    }
}

/// What the search ended with.
enum Outcome<'a> {
    /// Cores that overlap, or touch within rounding.
    Overlap(&'a Bounds),
    /// Cores that are apart, or touch within rounding.
    Gap(&'a Gap),
}

/// `inspect` sees the outcome with the search as it ended; its hull is used up after.
fn solve(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    scratch: &mut Scratch,
    mut inspect: impl FnMut(&mut Viewer<'_>, &mut Hull, Outcome<'_>),
) -> (Depth, Certainty) {
    let Scratch { hull, dots, .. } = scratch;
    let mut viewer = Viewer::new(LatticeDifference::new(a, b, dots));
    let radii = [a.map.swept_radius(), b.map.swept_radius()];
    let radius = radii[0] + radii[1];
    let centre = a.pose.apply(a.map.inner().centre) - b.pose.apply(b.map.inner().centre);
    let found =
        viewer.tetrahedron(centre).and_then(|corners| viewer.expand(corners, hull, GROWTHS));
    let answer = match found {
        Ok(bounds) if bounds.enclosed || radius == 0.0 => {
            let answer = Answer::of_overlap(&viewer.difference, hull, bounds, radius);
            inspect(&mut viewer, hull, Outcome::Overlap(&bounds));
            answer
        }
        Ok(bounds) => {
            let gap = viewer.gap(bounds.normal);
            let answer = Answer::of_gap(&viewer.difference, &gap, bounds.upper, radii);
            inspect(&mut viewer, hull, Outcome::Gap(&gap));
            answer
        }
        Err(Separated { normal }) => {
            let gap = viewer.gap(normal);
            let answer = match radius {
                0.0 => Answer::apart(&viewer.difference, normal, &gap),
                _ => Answer::of_gap(&viewer.difference, &gap, 0.0, radii),
            };
            inspect(&mut viewer, hull, Outcome::Gap(&gap));
            answer
        }
    };
    answer.in_world(viewer.difference.unit(), radii)
}
