//! Planes between hulls that spheres leave near each other, found without posing a vertex.
//!
//! A direction is turned into each hull's own frame, where its vertices lie sixteen to a block: the largest
//! product is how far the hull reaches. A direction that does not part the hulls is mirrored by that between
//! the two points found (Chung and Wang, "Quick collision detection of polytopes in virtual environments",
//! 1996).

use super::Goal;
use super::links::{BodyHull, LinkSpheres};
use super::prepared::Prepared;
use super::rounded_links::{Rounded, RoundedLink};
use super::sift::Found;
use dcd_pipeline::{Candidate, Other};
use dcd_simd::{Block, Kernel, Lanes, Row, WIDTH};
use glam::{Mat3, Vec3};

/// How many directions are tried. More: pairs that touch cost more. Fewer: more are left to the narrow phase.
const DIRECTIONS: usize = 5;

/// The direction of the last separating plane of each pair: a direction that separates in one state often does
/// so in the next. Kept for one chunk alone, so that no answer depends on earlier queries.
#[derive(Clone, Debug, Default)]
pub(super) struct Planes {
    /// By the body's number, then the other's: bodies first, then the first [`LASTING`] obstacles. Zero where
    /// none is known.
    directions: Vec<Vec3>,
    row: usize,
}

/// How many obstacles have planes that last for each body, and the most bodies that have any. More: more memory is cleared for a chunk.
const LASTING: usize = 32;

impl Planes {
    /// Forgets all directions and sizes the table for so many bodies, or for none where they are too many.
    pub(super) fn clear(&mut self, bodies: usize) {
        let bodies = if bodies <= LASTING { bodies } else { 0 };
        self.row = bodies + LASTING;
        self.directions.clear();
        self.directions.resize(bodies * self.row, Vec3::ZERO);
    }

    fn of(&mut self, candidate: &Candidate) -> Option<&mut Vec3> {
        let column = match candidate.other {
            Other::Link(other) => other as usize,
            Other::Obstacle(number) => (self.row - LASTING).checked_add(number as usize)?,
        };
        let place = candidate.link as usize * self.row + column;
        if column < self.row { self.directions.get_mut(place) } else { None }
    }
}

/// Drops the candidates of a packet that a plane parts.
pub(super) struct Separate<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) rounded: &'a Rounded,
    /// The number of the packet's first state, and the states that have no hit yet.
    pub(super) first: u32,
    pub(super) open: u32,
    pub(super) goal: Goal,
    pub(super) found: &'a mut Found,
    pub(super) planes: &'a mut Planes,
    /// Where the packet's candidates begin.
    pub(super) from: usize,
}

impl Kernel for Separate<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { prepared, rounded, first, open, goal, found, planes, from } = self;
        let mut kept = from;
        for k in from..found.candidates.len() {
            let (candidate, towards) = found.candidates[k];
            let lane = (candidate.configuration - first) as usize;
            let is_wanted = goal == Goal::All || open >> lane & 1 == 1;
            let hulls = if is_wanted { hulls(prepared, rounded, &candidate, lane) } else { None };
            let parted = hulls.is_some_and(
                #[inline(always)]
                |hulls| {
                    let mut unknown = Vec3::ZERO;
                    let last = planes.of(&candidate).unwrap_or(&mut unknown);
                    let begin = if *last == Vec3::ZERO { towards } else { *last };
                    let found = across_gap(l, &hulls, begin);
                    *last = found.unwrap_or_default();
                    found.is_some()
                },
            );
            if is_wanted && !parted {
                found.candidates[kept] = (candidate, towards);
                kept += 1;
            }
        }
        found.candidates.truncate(kept);
    }
}

/// A hull where it is in one state: its blocks of vertices, R and t, what is swept round it and what may be off.
pub(super) struct PlacedHull<'a> {
    pub(super) blocks: &'a [Block],
    pub(super) rotation: Mat3,
    pub(super) translation: Vec3,
    pub(super) margin: f32,
}

impl<'a> PlacedHull<'a> {
    pub(super) fn on(hull: &'a BodyHull, link: &RoundedLink, lane: usize) -> Self {
        let number = |k: usize| link.frame[k].0[lane];
        let column = |k: usize| Vec3::new(number(k), number(k + 1), number(k + 2));
        Self {
            blocks: &hull.blocks,
            rotation: Mat3::from_cols(column(0), column(3), column(6)),
            translation: column(9),
            margin: hull.swept + link.margin.0[lane],
        }
    }

    /// How far it reaches in a direction, from its translation on, and its point there.
    #[inline(always)]
    fn reach<L: Lanes>(&self, l: L, direction: Vec3) -> (f32, Vec3) {
        let Vec3 { x, y, z } = self.rotation.transpose() * direction;
        let (x, y, z) = (l.splat(x), l.splat(y), l.splat(z));
        let (mut best, mut block) = (l.splat(f32::NEG_INFINITY), l.splat(0.0));
        for (number, Block(rows)) in self.blocks.iter().enumerate() {
            let along = l.mul_add(l.load(&rows[0]), x, l.mul(l.load(&rows[1]), y));
            let along = l.mul_add(l.load(&rows[2]), z, along);
            let is_farther = l.lt(best, along);
            best = l.select(is_farther, along, best);
            block = l.select(is_farther, l.splat(number as f32), block);
        }
        let most = l.largest(best);
        let mut blocks = Row([0.0; WIDTH]);
        l.store(block, &mut blocks);
        // Of lanes that are as far the first; of NaN, which part nothing, any.
        let farthest = l.bits(l.le(l.splat(most), best)).trailing_zeros() as usize % WIDTH;
        let vertex = self.blocks[blocks.0[farthest] as usize].point(farthest);
        (most, self.rotation * vertex + self.translation)
    }
}

/// The two hulls of a candidate, if both are hulls.
fn hulls<'a>(
    prepared: &'a Prepared,
    rounded: &Rounded,
    candidate: &Candidate,
    lane: usize,
) -> Option<[PlacedHull<'a>; 2]> {
    let moved = |links: &[LinkSpheres], rounded: &[RoundedLink], body: u32| {
        let hull = prepared.hulls[body as usize].as_ref()?;
        let slot = links.binary_search_by_key(&hull.link, |link| link.link).ok()?;
        Some(PlacedHull::on(hull, &rounded[slot], lane))
    };
    match candidate.other {
        Other::Obstacle(number) => {
            let solid = &prepared.solids[number as usize];
            let still = PlacedHull {
                blocks: solid.corners(&prepared.corners)?,
                rotation: Mat3::IDENTITY,
                translation: Vec3::ZERO,
                margin: solid.reach(),
            };
            Some([still, moved(&prepared.world_links, rounded.world(), candidate.link)?])
        }
        Other::Link(other) => {
            let (links, rounded) = (prepared.own_links(), rounded.own(prepared));
            Some([moved(links, rounded, other)?, moved(links, rounded, candidate.link)?])
        }
    }
}

/// The direction across a plane that is found between the two, beginning with one from the first to the second.
/// The value of the farthest product counts, whichever vertex it is of (docs/numerics/proofs.md, "states in
/// lanes").
#[inline(always)]
pub(super) fn across_gap<L: Lanes>(
    l: L,
    [a, b]: &[PlacedHull<'_>; 2],
    towards: Vec3,
) -> Option<Vec3> {
    let mut direction = unit(towards).unwrap_or(Vec3::X);
    let margin = a.margin + b.margin;
    for _ in 0..DIRECTIONS {
        let (of_a, p) = a.reach(l, direction);
        let (of_b, q) = b.reach(l, -direction);
        let gap = direction.dot(b.translation - a.translation) - of_b - of_a;
        // Written so that a NaN parts nothing, nor an infinite gap: a rotation of NaN reaches nowhere.
        if gap > margin && gap < f32::INFINITY {
            return Some(direction);
        }
        let mirrored = unit(q - p).map(|across| direction - across * (2.0 * across.dot(direction)));
        direction = mirrored.and_then(unit)?;
    }
    None
}

/// Of unit length, however short or long it was: a length whose square underflows would be wrong.
fn unit(direction: Vec3) -> Option<Vec3> {
    (direction / direction.abs().max_element()).try_normalize()
}

/// For the indices of blocks to be exact as f32.
pub(super) const MOST_BLOCKS: usize = 1 << 20;
