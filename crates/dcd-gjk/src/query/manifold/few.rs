//! The manifolds of compounds by their parts as they were given: from the deepest pair of parts on, each with the pairs that meet along
//! its normal. Of few parts at the accuracies of f32 and f64; of more, and certified, where the lanes know which parts touch.
//!
//! The same manifolds as those of the parts as they are placed, to within what few_parts moves these by, which is in
//! their bounds.

use super::corners::Corners;
use super::feature::View;
use super::parts::{ALIKE, NEAR};
use super::patch_writer::InOrder;
use super::{
    Feature, Manifold, ManifoldSet, Scratch, cuboid_patch, few_on_plane, turned_by, write_of_two,
};
use crate::closed::is_sphere;
use crate::epa::Depth;
use crate::query::Accuracy;
use crate::query::few_parts::{
    self, Couple, Framed, PartContact, TouchingParts, Wanted, wholes_in_order,
};
use crate::{PosedShape, mesh};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Shape, Vector};

/// What the reach of two parts along a normal may be short by. Unit: u of their sizes and distance. Derived: 20.
const REACH: f64 = 32.0 * crate::UNIT;

/// How much more than their compounds' poses those of parts as they were given may be off rotations for a certified manifold.
/// Larger: wider bounds. Smaller: parts that are measured one by one as they are placed.
const TURNED: f64 = 1e-12;

/// A pair of parts that touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pair: [u32; 2],
    depth: Depth,
    /// Whether it belongs to no manifold yet.
    is_open: bool,
}

/// How a pair of parts belongs to a manifold.
#[derive(Clone, Copy, PartialEq)]
enum FramedMember {
    /// It is the deepest.
    Lead,
    /// Its own normal agrees.
    Alike,
    /// The manifold's normal and depth, and so much more, metres, separate it.
    Separated(f64),
}

/// Writes the manifolds of two shapes over a set of one empty manifold; false, and anything written, where it is not known at
/// once which parts touch, and how deep.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(super) fn write(
    at: Accuracy,
    sides: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
    set: &mut ManifoldSet,
) -> bool {
    let (sides, is_swapped) = wholes_in_order(sides);
    let is_known = write_in_order(at, sides, scratch, set).is_some();
    if is_known && is_swapped {
        set.mirror();
    }
    is_known
}

fn write_in_order(
    at: Accuracy,
    sides: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
    set: &mut ManifoldSet,
) -> Option<()> {
    if few_on_plane::write(at, sides, set.only_mut()?).is_some() {
        return Some(());
    }
    let Scratch { depth: memory, corners, of_few: found, .. } = scratch;
    let framed = Framed::of(sides);
    let mut couple = Couple::default();
    couple.fill(&framed)?;
    found.clear();
    couple.touching((at, Wanted::All), memory, |pair, depth| {
        found.push(Found { pair, depth, is_open: true });
    })?;
    if at == Accuracy::F32 {
        for Found { pair, depth, .. } in &mut *found {
            *depth = sharpened(couple.posed(*pair)?.0, *depth);
        }
    }
    FramedPatches { framed: &framed, parts: &couple, found, corners }.write_all(set)
}

/// Writes the manifolds of two shapes over a set of one empty manifold, of which it is known which parts touch; false, and
/// anything written, where one cannot be measured as it was given.
///
/// (a, b) and (b, a) give the same bits, mirrored.
pub(super) fn write_known(
    at: Accuracy,
    known: &mut [PartContact<'_>],
    sides: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
    set: &mut ManifoldSet,
) -> bool {
    let (wholes, is_swapped) = wholes_in_order(sides);
    let is_known = write_known_in_order(at, (wholes, is_swapped), known, (scratch, set)).is_some();
    if is_known && is_swapped {
        set.mirror();
    }
    is_known
}

fn write_known_in_order(
    at: Accuracy,
    (wholes, is_swapped): ([PosedShape<'_>; 2], bool),
    known: &mut [PartContact<'_>],
    (scratch, set): (&mut Scratch, &mut ManifoldSet),
) -> Option<()> {
    let Scratch { depth: memory, corners, of_few: found, .. } = scratch;
    let framed = Framed::round_first(wholes)?;
    let parts = TouchingParts::of(&framed, (wholes, is_swapped), known)?;
    // The bound counts what poses are off rotations; parts as they are placed have that of their compound alone.
    let of_wholes: f64 = wholes.iter().map(|whole| whole.pose.deviation()).sum();
    if at == Accuracy::Certified && !(parts.deviation() <= of_wholes + TURNED) {
        return None;
    }
    found.clear();
    for number in 0..parts.len() {
        let (pair, depth) = (parts.pair(number), parts.depth(at, number, memory)?);
        let depth = match at {
            Accuracy::F32 => sharpened(parts.posed(pair)?.0, depth),
            _ => depth,
        };
        found.push(Found { pair, depth, is_open: true });
    }
    FramedPatches { framed: &framed, parts: &parts, found, corners }.write_all(set)
}

/// Where the parts are that touch.
trait Parts {
    /// Two of them, and by how much they are moved: metres.
    fn posed(&self, pair: [u32; 2]) -> Option<([PosedShape<'_>; 2], f64)>;

    /// Whether [`rest`] has nothing of those of that number, as far as the spheres in them show.
    fn surely_reach_beyond(&self, number: usize, depth: &Depth) -> bool;

    /// Writes the manifold of those of that number alone, if the lanes know where they touch; false, and nothing written,
    /// where they do not.
    fn write_patch(&self, number: usize, manifold: &mut Manifold) -> bool;
}

impl Parts for Couple<'_> {
    fn posed(&self, pair: [u32; 2]) -> Option<([PosedShape<'_>; 2], f64)> {
        Couple::posed(self, pair)
    }

    fn surely_reach_beyond(&self, _: usize, _: &Depth) -> bool {
        false
    }

    fn write_patch(&self, _: usize, _: &mut Manifold) -> bool {
        false
    }
}

impl Parts for TouchingParts<'_> {
    fn posed(&self, pair: [u32; 2]) -> Option<([PosedShape<'_>; 2], f64)> {
        TouchingParts::posed(self, pair)
    }

    fn surely_reach_beyond(&self, number: usize, depth: &Depth) -> bool {
        let [reach, outer] = self.least_reach(number, depth.normal);
        // The diameters are twice the spheres'; and a margin.
        reach > depth.depth + 4.0 * NEAR * outer
    }

    fn write_patch(&self, number: usize, manifold: &mut Manifold) -> bool {
        let Some((patch, sides)) = self.patch(number) else { return false };
        let writer = &mut InOrder { writer: manifold, is_swapped: self.is_swapped() };
        cuboid_patch::write(patch, sides, writer)
    }
}

/// Takes a manifold from a frame to the world.
fn place(manifold: &mut Manifold, framed: &Framed<'_>) {
    manifold.normal = framed.turned(manifold.normal);
    manifold.error_bound = (manifold.error_bound + framed.rounded()).min(f64::MAX);
    for point in &mut *manifold.points {
        point.point_a = framed.placed(point.point_a);
        point.point_b = framed.placed(point.point_b);
    }
}

/// The pairs of parts that touch, and what their manifolds are made with.
struct FramedPatches<'a, P> {
    framed: &'a Framed<'a>,
    parts: &'a P,
    found: &'a mut [Found],
    corners: &'a mut Corners,
}

impl<P: Parts> FramedPatches<'_, P> {
    fn write_all(&mut self, set: &mut ManifoldSet) -> Option<()> {
        let (lead, depth) = self.deepest()?;
        self.write(lead, &depth, set.only_mut()?)?;
        while let Some((lead, depth)) = self.deepest() {
            let left = self.found.iter().filter(|found| found.is_open).count();
            set.push_with(left, |manifold| self.write(lead, &depth, manifold))?;
        }
        set.all_mut().iter_mut().for_each(|manifold| place(manifold, self.framed));
        Some(())
    }

    /// The first of the deepest pairs that are open, and its depth, whose bound counts that another may be deeper.
    fn deepest(&self) -> Option<(usize, Depth)> {
        let open = || self.found.iter().enumerate().filter(|(_, found)| found.is_open);
        let (mut lead, first) = open().next()?;
        let (mut most, mut upper) = (first.depth, 0.0f64);
        for (k, Found { depth, .. }) in open() {
            upper = upper.max(depth.depth + depth.error_bound);
            if depth.depth > most.depth {
                (lead, most) = (k, *depth);
            }
        }
        let above = (upper - most.depth).next_up().min(f64::MAX);
        Some((lead, Depth { error_bound: most.error_bound.max(above), ..most }))
    }

    /// Writes the manifold of a pair over an empty one, with all open pairs that belong to it: none of these is open then.
    fn write(&mut self, lead: usize, depth: &Depth, manifold: &mut Manifold) -> Option<()> {
        let belongs =
            |k: usize| k != lead && self.found[k].is_open && self.member(k, lead, depth).is_some();
        if (0..self.found.len()).any(belongs) {
            return self.write_several(lead, depth, manifold);
        }
        let Found { pair, is_open, .. } = &mut self.found[lead];
        *is_open = false;
        let (posed, moved) = self.parts.posed(*pair)?;
        if self.parts.write_patch(lead, manifold) {
            // What another may be deeper by is in the bound of the depth.
            manifold.error_bound = manifold.error_bound.max(depth.error_bound);
        } else {
            write_of_two(depth, posed, self.corners, manifold);
        }
        manifold.error_bound = (manifold.error_bound + moved).min(f64::MAX);
        let sides = self.framed.sides();
        let parts = [0, 1].map(|k| mesh::part_index(sides[k].shape, pair[k]));
        manifold.parts = parts;
        for point in &mut *manifold.points {
            let [of_a, of_b] = point.features;
            let name = |k: usize, feature| few_parts::name(sides[k], pair[k], feature);
            point.features = [name(0, of_a)?, name(1, of_b)?];
            point.parts = parts;
        }
        Some(())
    }

    /// The same of several pairs, by the corners of all.
    fn write_several(&mut self, lead: usize, depth: &Depth, manifold: &mut Manifold) -> Option<()> {
        let view = View::along(depth.normal);
        let sides = self.framed.sides();
        self.corners.clear();
        let (mut features, mut rest) = (Default::default(), 0.0f64);
        let (mut most_moved, mut most_turned) = (0.0f64, 0.0f64);
        for k in 0..self.found.len() {
            let Found { pair, depth: own, is_open } = self.found[k];
            let member = if is_open { self.member(k, lead, depth) } else { None };
            let Some(member) = member else { continue };
            self.found[k].is_open = false;
            let (posed, moved) = self.parts.posed(pair)?;
            most_moved = most_moved.max(moved);
            most_turned =
                posed.iter().map(|side| side.pose.deviation()).sum::<f64>().max(most_turned);
            let before = self.corners.len();
            let is_bounded = posed.iter().all(|side| side.shape.is_bounded());
            // A sphere has no corners; of the deepest pair the size and the features count.
            if member == FramedMember::Lead || !(is_bounded && posed.into_iter().any(is_sphere)) {
                let whole = self.add_corners(&view, depth, (&own, posed));
                features = if member == FramedMember::Lead { whole } else { features };
            }
            if let FramedMember::Separated(more) = member {
                rest = rest.max(more);
            } else if self.corners.len() == before {
                self.corners.add_witness(&view, &own, sides[0].pose.translation());
            }
            self.corners.are_of(k as u32, before);
        }
        let of_points = self.corners.write(&view, depth, sides, features, manifold);
        // Of the sides' poses it is counted; the parts have others.
        let turned = turned_by(most_turned, (depth, self.corners.size(), sides));
        manifold.error_bound = (manifold.error_bound + rest + most_moved + turned).min(f64::MAX);
        let [a, b] = sides;
        let parts = |[j, k]: [u32; 2]| [mesh::part_index(a.shape, j), mesh::part_index(b.shape, k)];
        manifold.parts = parts(self.found[lead].pair);
        for (point, number) in manifold.points.iter_mut().zip(of_points) {
            let [j, k] = self.found[number.map_or(lead, |number| number as usize)].pair;
            let [of_a, of_b] = point.features;
            point.features = [few_parts::name(a, j, of_a)?, few_parts::name(b, k, of_b)?];
            point.parts = parts([j, k]);
        }
        Some(())
    }

    /// Adds what a pair's features have in common along the normal, unless they are deeper there than the deepest:
    /// such parts meet along another. Returns what the two show as wholes.
    fn add_corners(
        &mut self,
        view: &View,
        depth: &Depth,
        (own, posed): (&Depth, [PosedShape<'_>; 2]),
    ) -> [Feature; 2] {
        let before = self.corners.len();
        self.corners.note(posed);
        // The planes of half-spaces are the pair's own; what is seen is seen along the deepest's normal.
        let seen = Depth { normal: depth.normal, ..*own };
        let whole = match posed.iter().all(|side| side.shape.is_bounded()) {
            true => self.corners.add(view, &seen, posed),
            false => self.corners.add_on_plane(view, &seen, posed),
        };
        let from = posed[0].pose.translation() - self.framed.sides()[0].pose.translation();
        self.corners.shift(before, view.of(from));
        self.corners.drop_if_deeper(before, depth);
        whole
    }

    /// How a pair belongs to the manifold of the deepest, if it does.
    fn member(&self, k: usize, lead: usize, depth: &Depth) -> Option<FramedMember> {
        if k == lead {
            return Some(FramedMember::Lead);
        }
        let Found { pair, depth: own, .. } = &self.found[k];
        if own.normal.dot(depth.normal) >= ALIKE {
            return Some(FramedMember::Alike);
        }
        if self.parts.surely_reach_beyond(k, depth) {
            return None;
        }
        let (posed, _) = self.parts.posed(*pair)?;
        rest(posed, depth).map(FramedMember::Separated)
    }
}

/// By how much more than a depth two parts must be moved along its normal to come apart, if that is hardly more; `None` also
/// of half-spaces.
fn rest(sides: [PosedShape<'_>; 2], depth: &Depth) -> Option<f64> {
    let Reach { along, lost, diameters } = Reach::of(sides, depth.normal)?;
    let more = along + lost - depth.depth;
    (more <= NEAR * diameters).then(|| more.max(0.0))
}

/// A bound that f64 has, relative to the parts' diameters: what is known as well is not looked at again. No bound depends on it.
const KNOWN: f64 = 1e-12;

/// At least the sum of the diameters of two polytopes; `None` of other shapes.
fn diameters_of([a, b]: [PosedShape<'_>; 2]) -> Option<f64> {
    let of = |shape: &Shape| {
        let polytope = shape.as_polytope()?;
        Some(2.0 * (polytope.outer_radius() + polytope.swept_radius()))
    };
    Some(of(a.shape)? + of(b.shape)?)
}

/// How far two polytopes reach past each other along a unit vector: metres.
struct Reach {
    along: f64,
    /// What that is off by at most.
    lost: f64,
    /// At least the sum of the two diameters.
    diameters: f64,
}

impl Reach {
    /// `None` of other shapes.
    fn of([a, b]: [PosedShape<'_>; 2], normal: DVec3) -> Option<Self> {
        let (Shape::Polytope(in_a), Shape::Polytope(in_b)) = (a.shape, b.shape) else {
            return None;
        };
        let delta = b.pose.translation() - a.pose.translation();
        let radius = in_a.swept_radius() + in_b.swept_radius();
        let of_a = farthest(in_a, a.pose.rotation().transpose() * normal);
        let of_b = farthest(in_b, b.pose.rotation().transpose() * -normal);
        let along = (of_a + of_b) - normal.dot(delta) + radius;
        let lost = REACH * (in_a.reach() + in_b.reach() + delta.norm1() + radius);
        Some(Self { along, lost, diameters: diameters_of([a, b])? })
    }
}

/// A depth that f32 alone knows, as far as f64 sees its parts reach past each other along its normal: the corners of a patch are as deep as
/// that, and parts that rest on one plane are of one patch. The bound counts how far it is from what was.
fn sharpened(sides: [PosedShape<'_>; 2], found: Depth) -> Depth {
    let is_sharp = |diameters: f64| found.error_bound <= KNOWN * diameters;
    if diameters_of(sides).is_none_or(is_sharp) {
        return found;
    }
    let Some(Reach { along, lost, .. }) = Reach::of(sides, found.normal) else { return found };
    let depth = along.max(0.0);
    let error_bound = found.error_bound + (depth - found.depth).abs() + lost;
    Depth { depth, error_bound, ..found }
}

/// The most of x·d over a core, in its own frame.
fn farthest(core: &Polytope, direction: DVec3) -> f64 {
    if let Kind::Cuboid { half_extents } = core.kind() {
        return direction.abs().dot(half_extents);
    }
    let along = core.vertices().iter().map(|vertex| vertex.dot(direction));
    along.fold(f64::NEG_INFINITY, f64::max)
}
