//! The manifolds of shapes that are made of parts: from the deepest pair of parts on, each with the pairs that meet
//! along its normal.

use super::corners::Corners;
use super::feature::View;
use super::surface::{self, ManifoldOptions};
use super::{Feature, Manifold, ManifoldSet, Scratch};
use super::{mesh_on_plane, on_mesh};
use crate::epa::Depth;
use crate::mesh::{self, Effort, KnownParts, PartPair};
use crate::query::few_parts::{self, Wanted};
use crate::query::{Accuracy, depths};
use crate::{PosedShape, Reason, Verdict, epa};
use dcd_geom::Shape;

/// The least cosine between two normals that count as one: 1e-3 rad.
pub(super) const ALIKE: f64 = 1.0 - 5e-7;

/// At least the angle of that cosine, and a margin for normals that are known to 1e-4 rad.
pub(super) const ANGLE: f64 = 1.1e-3;

/// How much farther than a manifold's depth two parts may have to be moved along its normal and still belong to it,
/// relative to their diameters: what f32 vertices leave of a plane. The error bound counts it. Larger: wider bounds.
/// Smaller: needless manifolds of the triangles of one floor.
pub(super) const NEAR: f64 = 1e-6;

/// How the depth of a pair of parts is measured.
#[derive(Clone, Copy)]
pub(super) struct Measure {
    pub(super) accuracy: Accuracy,
    pub(super) options: ManifoldOptions,
}

/// The manifolds of two shapes of parts that touch.
pub(super) fn measure(
    how: Measure,
    sides: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
) -> Verdict<ManifoldSet> {
    // Written where it is returned.
    let mut answer = Verdict::Touching(ManifoldSet::default());
    if let Verdict::Touching(set) = &mut answer
        && let Verdict::Undecided(reason) = write(how, None, sides, scratch, set)
    {
        answer = Verdict::Undecided(reason);
    }
    answer
}

/// Writes them over what there was. Which parts of a mesh and a polytope touch may be known.
pub(super) fn write(
    how: Measure,
    touching: Option<KnownParts<'_>>,
    [a, b]: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
    set: &mut ManifoldSet,
) -> Verdict<()> {
    let is_swapped = mesh::is_swapped(a, b);
    let sides = if is_swapped { [b, a] } else { [a, b] };
    let how = how.about(sides);
    let mut known = std::mem::take(&mut scratch.known);
    known.clear();
    let touching = touching.map(|touching| {
        let in_order = |&[a, b]: &[u32; 2]| if is_swapped { [b, a] } else { [a, b] };
        known.extend(touching.parts.iter().map(in_order));
        KnownParts { parts: &known[..], ..touching }
    });
    set.begin_one();
    let written = write_in_order(how, touching, sides, (scratch, &mut *set));
    scratch.known = known;
    match written {
        Ok(()) => {
            if is_swapped {
                set.mirror();
            }
            Verdict::Touching(())
        }
        Err(reason) => Verdict::Undecided(reason),
    }
}

/// Writes the manifolds over a set of one empty manifold.
fn write_in_order(
    how: Measure,
    touching: Option<KnownParts<'_>>,
    sides: [PosedShape<'_>; 2],
    (scratch, set): (&mut Scratch, &mut ManifoldSet),
) -> Result<(), Reason> {
    let Scratch { depth: memory, corners, parts, on_mesh, on_plane, .. } = scratch;
    if how.options == ManifoldOptions::default()
        && let Some(found) = mesh_on_plane::measure(how.accuracy, sides, (on_plane, &mut *memory))
    {
        *set = found;
        return Ok(());
    }
    let lent = (on_mesh, &mut *parts, &mut *corners, &mut *memory);
    if how.options == ManifoldOptions::default()
        && on_mesh::write(how.accuracy, sides, touching, lent, set).is_some()
    {
        return Ok(());
    }
    write_pair_by_pair(how, touching, sides, (scratch, set))
}

/// The same in the general way, of any shapes.
pub(super) fn write_pair_by_pair(
    how: Measure,
    touching: Option<KnownParts<'_>>,
    sides: [PosedShape<'_>; 2],
    (scratch, set): (&mut Scratch, &mut ManifoldSet),
) -> Result<(), Reason> {
    let Scratch { depth: memory, corners, parts, .. } = scratch;
    *set = ManifoldSet::default();
    let mut pairs = match touching {
        Some(touching) => mesh::pairs_of(sides, touching.parts),
        None => touching_few(how.accuracy, sides, memory)
            .unwrap_or_else(|| mesh::touching_parts(sides[0], sides[1], parts)),
    };
    if how.options != ManifoldOptions::default() {
        // What bounds a depth does not bound one along another normal.
        pairs.iter_mut().for_each(PartPair::forget_bound);
    }
    let open = vec![true; pairs.len()];
    let mut patches = Patches { how, sides, pairs: &pairs, open, memory, corners };
    loop {
        let Patches { memory, open, .. } = &mut patches;
        let still_open = (0..pairs.len()).filter(|&k| open[k]);
        let depth = |pair: &PartPair<'_>, effort| how.measured_by(effort, pair, sides, memory);
        match mesh::deepest_of(&pairs, still_open, depth)? {
            Some((lead, depth)) => set.push(patches.patch(lead, depth)),
            None => break,
        }
    }
    // The shapes touch, but which of their parts do is within rounding.
    if pairs.is_empty() { Err(Reason::WithinRounding) } else { Ok(()) }
}

/// The pairs of few parts that touch, with what f64 knows of their depths: most of them are less deep than others, and not
/// certified.
fn touching_few<'s>(
    accuracy: Accuracy,
    sides: [PosedShape<'s>; 2],
    memory: &mut epa::Scratch,
) -> Option<Vec<PartPair<'s>>> {
    // Over a plane a part is certified as soon as f64 knows it.
    if accuracy != Accuracy::Certified || !sides.iter().all(|side| side.shape.is_bounded()) {
        return None;
    }
    let found = few_parts::touching(Wanted::All, sides, memory)?;
    let parts: Vec<[u32; 2]> = found.iter().map(|&(parts, _)| parts).collect();
    let mut pairs = mesh::pairs_of(sides, &parts);
    for (pair, (_, at_most)) in pairs.iter_mut().zip(found) {
        pair.bound(at_most);
    }
    Some(pairs)
}

impl Measure {
    /// Without the options where these change nothing: they are about one mesh and what is none.
    fn about(self, sides: [PosedShape<'_>; 2]) -> Self {
        let [a, b] = sides.map(|side| matches!(side.shape, Shape::Mesh(_)));
        let options = if a != b { self.options } else { ManifoldOptions::default() };
        Self { options, ..self }
    }

    /// The depth of a pair of parts that touch; apart where a mesh's surface does not touch there.
    fn measured(
        self,
        pair: &PartPair<'_>,
        sides: [PosedShape<'_>; 2],
        memory: &mut epa::Scratch,
    ) -> Verdict<Depth> {
        let found = self.measured_by(Effort::Whole, pair, sides, memory);
        found.unwrap_or(Verdict::Undecided(Reason::Range))
    }

    /// The same with that effort: `None` where it does not find it.
    fn measured_by(
        self,
        effort: Effort,
        pair: &PartPair<'_>,
        sides: [PosedShape<'_>; 2],
        memory: &mut epa::Scratch,
    ) -> Option<Verdict<Depth>> {
        pair.depth_by(effort, || {
            match depths::of_parts(self.accuracy, effort, pair, sides, memory)? {
                Verdict::Touching(depth) => Some(
                    surface::taken(self.options, pair, sides, depth)
                        .map_or(Verdict::Apart, Verdict::Touching),
                ),
                other => Some(other),
            }
        })
    }
}

/// The pairs of parts that touch, and those that belong to no manifold yet.
struct Patches<'a, 's> {
    how: Measure,
    sides: [PosedShape<'s>; 2],
    pairs: &'a [PartPair<'s>],
    open: Vec<bool>,
    memory: &'a mut epa::Scratch,
    corners: &'a mut Corners,
}

/// A manifold's depth, and its normal as pairs of parts see it, where their reach is known.
type AlongNormal<'d> = (&'d Depth, Option<&'d mesh::Direction>);

/// How a pair of parts belongs to a manifold.
enum Member {
    /// Its own normal agrees.
    Alike(Depth),
    /// The manifold's normal and depth, and so much more, metres, separate it.
    Separated(f64),
}

impl Patches<'_, '_> {
    /// The manifold of an open pair that is as deep as any, with all open pairs that belong to it: none of these is
    /// open then.
    fn patch(&mut self, lead: usize, depth: Depth) -> Manifold {
        let view = View::along(depth.normal);
        self.corners.clear();
        let direction = self.pairs[lead].direction(depth.normal);
        let along = (&depth, direction.as_ref());
        let (mut features, mut rest) = (Default::default(), 0.0f64);
        for k in 0..self.pairs.len() {
            let member = match self.open[k] {
                true if k == lead => Some(Member::Alike(depth)),
                true => self.member(k, along),
                false => None,
            };
            let Some(member) = member else { continue };
            self.open[k] = false;
            let before = self.corners.len();
            let pair = &self.pairs[k];
            // A sphere has no corners; of the deepest pair the size and the features count.
            let is_seen = || surface::is_seen(self.how.options, pair, self.sides, depth.normal);
            if k == lead || !pair.has_no_corners() && is_seen() {
                let whole = self.add_corners(&view, &depth, k);
                features = if k == lead { whole } else { features };
            }
            let own = match member {
                Member::Alike(own) => Some(own),
                Member::Separated(more) => {
                    rest = rest.max(more);
                    None
                }
            };
            if self.corners.len() == before
                && let Some(own) = own.or_else(|| self.alike(k, along))
            {
                self.corners.add_witness(&view, &own, self.sides[0].pose.translation());
            }
            self.corners.are_of(k as u32, before);
        }
        let mut manifold = Manifold::default();
        let of_points = self.corners.write(&view, &depth, self.sides, features, &mut manifold);
        manifold.error_bound = (manifold.error_bound + rest).min(f64::MAX);
        manifold.parts = self.pairs[lead].parts;
        for (point, pair) in manifold.points.iter_mut().zip(of_points) {
            point.parts = self.pairs[pair.map_or(lead, |pair| pair as usize)].parts;
        }
        manifold
    }

    /// Whether an open pair belongs to the manifold of that depth.
    fn member(&mut self, k: usize, along: AlongNormal<'_>) -> Option<Member> {
        let (depth, direction) = along;
        if let Some(rest) = self.pairs[k].along(direction).rest(depth.depth, NEAR) {
            return Some(Member::Separated(rest));
        }
        self.alike(k, along).map(Member::Alike)
    }

    /// A pair's own depth, if its normal agrees with that one's.
    fn alike(&mut self, k: usize, (depth, direction): AlongNormal<'_>) -> Option<Depth> {
        let pair = &self.pairs[k];
        if !pair.along(direction).may_be_within(ANGLE) {
            return None;
        }
        match self.how.measured(pair, self.sides, self.memory) {
            Verdict::Touching(own) => Some(own).filter(|own| own.normal.dot(depth.normal) >= ALIKE),
            _ => None,
        }
    }

    /// Adds what a pair's features have in common along the normal, unless they are deeper there than the deepest:
    /// such parts meet along another. Returns what the two show as wholes.
    fn add_corners(&mut self, view: &View, depth: &Depth, k: usize) -> [Feature; 2] {
        let pair = &self.pairs[k];
        let before = self.corners.len();
        if let Some([of_a, of_b]) = &pair.triangles(self.sides)
            && let Some(whole) = self.corners.add_triangles(view, [of_a, of_b])
        {
            self.corners.drop_if_deeper(before, depth);
            return whole;
        }
        let [a, b] = self.sides;
        let Some(sides) = pair.posed(a, b) else { return Default::default() };
        self.corners.note(sides);
        // The planes of half-spaces are the pair's own; what is seen is seen along the deepest's normal.
        let is_bounded = sides.iter().all(|side| side.shape.is_bounded());
        let of_plane = match is_bounded {
            true => *depth,
            false => match self.how.measured(pair, self.sides, self.memory) {
                Verdict::Touching(own) => own,
                _ => *depth,
            },
        };
        let whole = self.corners.add(view, &Depth { normal: depth.normal, ..of_plane }, sides);
        self.corners.drop_if_deeper(before, depth);
        whole
    }
}
