//! Planes between hulls that spheres leave near each other, found without posing a vertex.
//!
//! A direction is turned into each hull's own frame, where its vertices lie sixteen to a block: the largest
//! product is how far the hull reaches. A direction that does not part the hulls is mirrored by that between
//! the two points found (Chung and Wang, "Quick collision detection of polytopes in virtual environments",
//! 1996).

use super::Goal;
use super::links::BodyHull;
use super::one_link::{LinkPlace, LinkPlaces};
use super::prepared::Prepared;
use super::rounded_links::{Rounded, splat};
use super::sift::Found;
use dcd_pipeline::{Candidate, Other};
use dcd_simd::{Block, Kernel, Lanes, Row, WIDTH};
use glam::{Mat3, Vec3};

/// How many directions are tried. More: pairs that touch cost more. Fewer: more are left to the narrow phase. Of a robot's
/// pairs that spheres leave near each other the first parts 73 in a hundred, the second 15, the third to fifth together fewer
/// than one. No effect on any answer.
const DIRECTIONS: usize = 3;

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
    /// Whether the packet is a state alone.
    pub(super) is_alone: bool,
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
        let Self { prepared, rounded, first, open, is_alone, goal, found, planes, from } = self;
        let mut kept = from;
        for k in from..found.candidates.len() {
            let (candidate, towards) = found.candidates[k];
            let lane = (candidate.configuration - first) as usize;
            let is_wanted = goal == Goal::All || open >> lane & 1 == 1;
            if !is_wanted {
                continue;
            }
            let mut unknown = Vec3::ZERO;
            let last = planes.of(&candidate).unwrap_or(&mut unknown);
            let is_known = *last != Vec3::ZERO;
            let begin = if is_known { *last } else { unit(towards).unwrap_or(Vec3::X) };
            let direction = if is_alone {
                let placed = [rounded.one.world(), rounded.one.own()];
                direction_between(l, prepared, placed, (&candidate, begin))
            } else {
                let placed = [(&*rounded.world, lane), (&*rounded.own, lane)];
                direction_between(l, prepared, placed, (&candidate, begin))
            };
            *last = direction.unwrap_or_default();
            if *last == Vec3::ZERO {
                found.candidates[kept] = (candidate, towards);
                kept += 1;
            }
        }
        found.candidates.truncate(kept);
    }
}

/// A convex body in one state, by how far it reaches.
pub(super) trait Support {
    /// How far its core reaches in a direction of unit length, from its origin on.
    fn reach<L: Lanes>(&self, l: L, direction: Vec3) -> f32;

    /// The point there, in the world: found apart from the reach, which is enough for most pairs and half the work.
    fn point<L: Lanes>(&self, l: L, direction: Vec3) -> Vec3;

    /// In the world, metres.
    fn origin(&self) -> Vec3;

    /// What is swept round it and by how much a comparison may be off, metres.
    fn margin(&self) -> f32;
}

/// A hull where it is in one state: its blocks of vertices, R and t, what is swept round it and what may be off.
pub(super) struct PlacedHull<'a> {
    pub(super) blocks: &'a [Block],
    pub(super) rotation: Mat3,
    pub(super) translation: Vec3,
    pub(super) margin: f32,
}

impl<'a> PlacedHull<'a> {
    #[inline(always)]
    pub(super) fn on(hull: &'a BodyHull, link: impl LinkPlace) -> Self {
        let column = |k: usize| Vec3::new(link.number(k), link.number(k + 1), link.number(k + 2));
        Self {
            blocks: &hull.blocks,
            rotation: Mat3::from_cols(column(0), column(3), column(6)),
            translation: column(9),
            margin: hull.swept + link.margin(),
        }
    }
}

/// How far sixteen vertices are along a direction in their frame.
#[inline(always)]
fn along<L: Lanes>(l: L, Block([x, y, z]): &Block, direction: [L::F; 3]) -> L::F {
    let sum = l.mul_add(l.load(x), direction[0], l.mul(l.load(y), direction[1]));
    l.mul_add(l.load(z), direction[2], sum)
}

impl PlacedHull<'_> {
    /// A direction in the hull's frame, in all lanes.
    #[inline(always)]
    fn turned<L: Lanes>(&self, l: L, direction: Vec3) -> [L::F; 3] {
        splat(l, self.rotation.transpose() * direction)
    }
}

impl Support for PlacedHull<'_> {
    #[inline(always)]
    fn reach<L: Lanes>(&self, l: L, direction: Vec3) -> f32 {
        let direction = self.turned(l, direction);
        let mut best = l.splat(f32::NEG_INFINITY);
        for block in self.blocks {
            best = l.max(along(l, block, direction), best);
        }
        l.largest(best)
    }

    #[inline(always)]
    fn point<L: Lanes>(&self, l: L, direction: Vec3) -> Vec3 {
        let direction = self.turned(l, direction);
        let (mut best, mut number) = (l.splat(f32::NEG_INFINITY), l.splat(0.0));
        let (mut at, one) = (number, l.splat(1.0));
        for block in self.blocks {
            let along = along(l, block, direction);
            let is_farther = l.lt(best, along);
            best = l.select(is_farther, along, best);
            at = l.select(is_farther, number, at);
            number = l.add(number, one);
        }
        let mut blocks = Row([0.0; WIDTH]);
        l.store(at, &mut blocks);
        // Of lanes that are as far the first; of NaN, which part nothing, any.
        let lane = l.bits(l.le(l.splat(l.largest(best)), best)).trailing_zeros() as usize % WIDTH;
        let vertex = self.blocks[blocks.0[lane] as usize].point(lane);
        self.rotation * vertex + self.translation
    }

    fn origin(&self) -> Vec3 {
        self.translation
    }

    fn margin(&self) -> f32 {
        self.margin
    }
}

/// The direction across a plane that is found between the two bodies of a candidate; of what has no support here none.
#[inline(always)]
fn direction_between<L: Lanes, P: LinkPlaces>(
    l: L,
    prepared: &Prepared,
    [world, own]: [P; 2],
    (candidate, begin): (&Candidate, Vec3),
) -> Option<Vec3> {
    let (links, placed) = match (candidate.other, &prepared.own_links) {
        (Other::Link(_), Some(own_links)) => (&**own_links, own),
        _ => (&*prepared.world_links, world),
    };
    let moved = |body: u32| {
        let hull = prepared.hulls[body as usize].as_ref()?;
        let slot = links.binary_search_by_key(&hull.link, |link| link.link).ok()?;
        Some(PlacedHull::on(hull, placed.at(slot)))
    };
    let hull = moved(candidate.link)?;
    match candidate.other {
        Other::Obstacle(number) => {
            let solid = &prepared.solids[number as usize];
            if solid.is_closed() {
                return across_gap(l, &solid, &hull, begin);
            }
            let still = PlacedHull {
                blocks: solid.corners(&prepared.corners)?,
                rotation: Mat3::IDENTITY,
                translation: Vec3::ZERO,
                margin: solid.reach(),
            };
            across_gap(l, &still, &hull, begin)
        }
        Other::Link(other) => across_gap(l, &moved(other)?, &hull, begin),
    }
}

/// The direction across a plane that is found between the two, beginning with one of unit length from the first to the
/// second. The value of the farthest product counts, whichever vertex it is of (docs/numerics/proofs.md, "states in
/// lanes").
#[inline(always)]
pub(super) fn across_gap<L: Lanes>(
    l: L,
    a: &impl Support,
    b: &impl Support,
    mut direction: Vec3,
) -> Option<Vec3> {
    let margin = a.margin() + b.margin();
    for tried in 1..=DIRECTIONS {
        let (of_a, of_b) = (a.reach(l, direction), b.reach(l, -direction));
        let gap = direction.dot(b.origin() - a.origin()) - of_b - of_a;
        // Written so that a NaN parts nothing, nor an infinite gap: a rotation of NaN reaches nowhere.
        if gap > margin && gap < f32::INFINITY {
            // What mirrors have stretched would add up from state to state.
            return if tried == 1 { Some(direction) } else { unit(direction) };
        }
        if tried < DIRECTIONS {
            direction = mirrored(direction, b.point(l, -direction) - a.point(l, direction))?;
        }
    }
    None
}

/// The least square of what a direction is mirrored by, m²: far above what squares lose where they underflow. Larger:
/// hulls so near each other are left to the narrow phase.
const LEAST_SQUARE: f32 = 1e-30;

/// Mirrored at the plane across a vector of any length: as long as it was, within 20 roundings.
#[inline(always)]
fn mirrored(direction: Vec3, across: Vec3) -> Option<Vec3> {
    let square = across.length_squared();
    // Written so that of a NaN there is none.
    (square > LEAST_SQUARE).then(|| direction - across * (2.0 * across.dot(direction) / square))
}

/// Of unit length, however short or long it was: a length whose square underflows would be wrong.
pub(super) fn unit(direction: Vec3) -> Option<Vec3> {
    (direction / direction.abs().max_element()).try_normalize()
}

/// For the indices of blocks to be exact as f32.
pub(super) const MOST_BLOCKS: usize = 1 << 20;

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_simd::{Path, dispatch_on};
    use glam::DVec3;

    /// How far a hull reaches along a direction, and its point there.
    struct Farthest<'a>(&'a PlacedHull<'a>, Vec3);

    impl Kernel for Farthest<'_> {
        type Output = (f32, Vec3);

        fn run<L: Lanes>(self, l: L) -> (f32, Vec3) {
            let Self(hull, direction) = self;
            (hull.reach(l, direction), hull.point(l, direction))
        }
    }

    #[test]
    fn a_hull_reaches_as_far_as_its_farthest_vertex_and_its_point_is_there() {
        let mut number = 7u32;
        let mut draw = || {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(number >> 8) / f64::from(1 << 23) - 1.0
        };
        for count in (1..80).chain([160, 400]) {
            let mut vector = || DVec3::new(draw(), draw(), draw());
            let vertices: Vec<DVec3> = (0..count).map(|_| vector()).collect();
            let blocks: Vec<Block> = Block::relative(&vertices, DVec3::ZERO).collect();
            let (axis, translation) = (vector().normalize().as_vec3(), vector().as_vec3());
            let rotation = Mat3::from_axis_angle(axis, 2.0);
            let hull = PlacedHull { blocks: &blocks, rotation, translation, margin: 0.0 };
            let direction = vector().normalize();
            let from_origin = |v: &DVec3| direction.dot(rotation.as_dmat3() * *v);
            let exact = vertices.iter().map(from_origin).fold(f64::NEG_INFINITY, f64::max);
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let (reach, point) = dispatch_on(path, Farthest(&hull, direction.as_vec3()));
                let of_point = direction.dot((point - translation).as_dvec3());
                for ours in [f64::from(reach), of_point] {
                    assert!((ours - exact).abs() < 1e-6, "{path:?}, {count}: {ours}, {exact}");
                }
            }
        }
    }

    #[test]
    fn a_mirrored_direction_stays_as_long_as_its_bound_says() {
        let mut number = 1u32;
        let mut draw = || {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (number >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let mut most = 0.0f64;
        for size in [1e-14, 1e-7, 1.0, 1e9] {
            for _ in 0..20_000 {
                let mut vector = || Vec3::new(draw(), draw(), draw());
                let Some(before) = unit(vector()) else { continue };
                let across = vector() * size;
                let Some(after) = mirrored(before, across) else { continue };
                let (before, after) = (before.as_dvec3(), after.as_dvec3());
                let exact = before.reflect(across.as_dvec3().normalize());
                let off = exact.distance(after).max((after.length() - before.length()).abs());
                most = most.max(off * f64::from(1 << 24));
            }
        }
        assert!(most < 20.0 && most > 1.0, "{most} roundings");
        assert_eq!(mirrored(Vec3::X, Vec3::splat(1e-16)), None);
        assert_eq!(mirrored(Vec3::X, Vec3::NAN), None);
    }
}
