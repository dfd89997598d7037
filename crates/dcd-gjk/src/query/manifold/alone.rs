//! Two convex shapes of which nothing is known but that they touch.

use super::corners::Corners;
use super::on_plane::Resting;
use super::one_point::{in_one_point, of_one_point, of_sphere};
use super::patch_writer::PatchWriter;
use super::{
    Manifold, ManifoldContacts, ManifoldSet, Manifolds, Scratch, upright, write_by_corners,
    write_of_polytopes,
};
use crate::closed::is_sphere;
use crate::epa::Depth;
use crate::query::depths::{self, Searched};
use crate::query::{Accuracy, FoundDepth, MeasureAt};
use crate::{ContactList, PosedShape, Verdict, closed, mesh, order};
use dcd_geom::glam::DVec3;

/// What is known of two convex shapes beside their depth.
#[derive(Clone, Copy)]
pub(super) enum Known {
    Nothing,
    /// Of a shape on a half-space perhaps the lowest vertex, up to rounding.
    Lowest(Option<u32>),
    /// Where a sphere is from the other shape, in that one's frame: of unit length.
    Outward(DVec3),
    /// Of two polytopes vertices that are farthest along the normal: see [`FoundDepth::farthest`].
    Farthest([u32; 2]),
}

impl Known {
    /// A depth with the vertices that are known to be farthest.
    fn with(self, depth: &Depth) -> FoundDepth {
        let farthest = match self {
            Self::Farthest(farthest) => Some(farthest),
            _ => None,
        };
        FoundDepth { depth: *depth, farthest }
    }
}

/// What `answer` makes of the depth of two convex shapes, and of what else is known of them.
#[inline(always)]
pub(super) fn of_convex<T>(
    (accuracy, searched): (Accuracy, Searched),
    [a, b]: [PosedShape<'_>; 2],
    Scratch { depth, corners, .. }: &mut Scratch,
    answer: impl FnOnce(&Depth, Known, &mut Corners) -> Verdict<T>,
) -> Verdict<T> {
    // The closed forms first: what they find is not moved before it is written.
    if let Some((gap, lowest)) = closed::level::gap_and_lowest(accuracy, a, b) {
        if let Some(found) = gap.depth() {
            return answer(&found, Known::Lowest(lowest), corners);
        }
    } else if is_sphere(a) != is_sphere(b)
        && let Some((gap, outward)) = closed::centred::gap_and_outward(accuracy, a, b)
    {
        if let Some(found) = gap.depth() {
            return answer(&found, Known::Outward(outward), corners);
        }
    } else if let Some(found) = depths::by_frame(accuracy, a, b) {
        return answer(&found, Known::Nothing, corners);
    }
    match depths::without_frame((accuracy, searched), a, b, depth) {
        Verdict::Apart => Verdict::Apart,
        Verdict::Undecided(reason) => Verdict::Undecided(reason),
        Verdict::Touching(FoundDepth { depth, farthest }) => {
            answer(&depth, farthest.map_or(Known::Nothing, Known::Farthest), corners)
        }
    }
}

/// The manifold of that depth.
// Inlined: what is known decides what is done.
#[inline(always)]
pub(super) fn of_depth(
    depth: &Depth,
    [a, b]: [PosedShape<'_>; 2],
    known: Known,
    corners: &mut Corners,
) -> Verdict<ManifoldSet> {
    let only = match known {
        Known::Nothing | Known::Farthest(_) => in_one_point(depth, [a, b]),
        Known::Lowest(_) => of_sphere(depth, [a, b], None),
        Known::Outward(outward) => of_sphere(depth, [a, b], Some(outward)),
    };
    if let Some(only) = only {
        return of_one_point(depth, only);
    }
    of_more_points(depth, [a, b], known, corners)
}

/// The same of shapes that may touch in more than one point.
fn of_more_points(
    depth: &Depth,
    [a, b]: [PosedShape<'_>; 2],
    known: Known,
    corners: &mut Corners,
) -> Verdict<ManifoldSet> {
    let lowest = match known {
        Known::Lowest(lowest) => lowest,
        _ => None,
    };
    written(|found| {
        let is_seen =
            Resting::seen(depth, [a, b], lowest, |resting| match resting.in_one_point(depth) {
                Some((features, bound)) => found.write_witnesses(depth, features, bound),
                None => resting.write(depth, found),
            });
        if is_seen.is_none() {
            write_by_corners(&known.with(depth), [a, b], corners, found);
        }
    })
}

/// One manifold, empty and then written.
#[inline]
fn written(write: impl FnOnce(&mut Manifold)) -> Verdict<ManifoldSet> {
    let mut answer = Verdict::Touching(ManifoldSet::empty_one());
    if let Verdict::Touching(set) = &mut answer
        && let Some(found) = set.only_mut()
    {
        write(found);
    }
    answer
}

/// Writes the manifold of two objects where a step keeps it, of two polytopes mostly without a copy.
pub(super) fn write(
    solver: &Manifolds,
    accuracy: Accuracy,
    sides: [PosedShape<'_>; 2],
    scratch: &mut Scratch,
    (contacts, number): (&mut ManifoldContacts, usize),
) -> Verdict<()> {
    let [a, b] = sides;
    let how = (accuracy, Searched::InLanes);
    if mesh::have_parts(a.shape, b.shape) {
        let measured = solver.measure_at(accuracy, a, b, scratch);
        return measured.map(|answer| contacts.set(number, answer));
    }
    if a.shape.as_polytope().is_none() || b.shape.as_polytope().is_none() {
        let measured = of_convex(how, sides, scratch, |depth, known, corners| {
            of_depth(depth, sides, known, corners)
        });
        return measured.map(|answer| contacts.set(number, answer));
    }
    if let Some(depth) = depths::upright(a, b)
        && upright::write(&depth, sides, usize::from(order::is_swapped(a, b)), contacts.writer())
    {
        contacts.keep_last(number);
        return Verdict::Touching(());
    }
    of_convex(how, sides, scratch, |depth, known, corners| {
        write_of_polytopes_alone((depth, known), sides, corners, (contacts, number));
        Verdict::Touching(())
    })
}

/// The same of two polytopes of that depth: what [`of_depth`] has.
fn write_of_polytopes_alone(
    (depth, known): (&Depth, Known),
    [a, b]: [PosedShape<'_>; 2],
    corners: &mut Corners,
    (contacts, number): (&mut ManifoldContacts, usize),
) {
    let only = match known {
        Known::Outward(outward) => of_sphere(depth, [a, b], Some(outward)),
        _ => in_one_point(depth, [a, b]),
    };
    let known = known.with(depth);
    if let Some((features, error_bound)) = only {
        contacts.writer().write_witnesses(depth, features, error_bound);
    } else if !write_of_polytopes(&known, a, b, corners, contacts.writer()) {
        contacts.write(number, |set| {
            set.write_one(|found| {
                write_by_corners(&known, [a, b], corners, found);
                true
            })
        });
        return;
    }
    contacts.keep_last(number);
}
