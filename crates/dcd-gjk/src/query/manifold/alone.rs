//! Two convex shapes of which nothing is known but that they touch.

use super::corners::Corners;
use super::one_point::in_one_point;
use super::patch_writer::PatchWriter;
use super::{ManifoldContacts, Manifolds, Scratch, write_by_corners, write_of_polytopes};
use crate::epa::Depth;
use crate::query::{Accuracy, FoundDepth, MeasureAt, depths};
use crate::{ContactList, PosedShape, Verdict, closed};

/// What `answer` makes of the depth of two convex shapes, and of a shape on a half-space perhaps of its lowest vertex.
#[inline(always)]
pub(super) fn of_convex<T>(
    accuracy: Accuracy,
    [a, b]: [PosedShape<'_>; 2],
    Scratch { depth, corners, .. }: &mut Scratch,
    answer: impl FnOnce(&Depth, Option<u32>, &mut Corners) -> Verdict<T>,
) -> Verdict<T> {
    // The closed forms first: what they find is not moved before it is written.
    if let Some((gap, lowest)) = closed::level::gap_and_lowest(accuracy, a, b) {
        if let Some(found) = gap.depth() {
            return answer(&found, lowest, corners);
        }
    } else if let Some(found) = depths::by_frame(accuracy, a, b) {
        return answer(&found, None, corners);
    }
    match depths::without_frame(accuracy, a, b, depth) {
        Verdict::Apart => Verdict::Apart,
        Verdict::Undecided(reason) => Verdict::Undecided(reason),
        Verdict::Touching(found) => answer(&found, None, corners),
    }
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
    if a.shape.as_polytope().is_none() || b.shape.as_polytope().is_none() {
        let measured = solver.measure_at(accuracy, a, b, scratch);
        return measured.map(|answer| contacts.set(number, answer));
    }
    of_convex(accuracy, sides, scratch, |depth, _, corners| {
        write_of_polytopes_alone(depth, sides, corners, (contacts, number));
        Verdict::Touching(())
    })
}

/// The same of two polytopes of that depth: what [`of_depth`](super::of_depth) has.
fn write_of_polytopes_alone(
    depth: &Depth,
    [a, b]: [PosedShape<'_>; 2],
    corners: &mut Corners,
    (contacts, number): (&mut ManifoldContacts, usize),
) {
    let known = FoundDepth { depth: *depth, farthest: None };
    if let Some((features, error_bound)) = in_one_point(depth, [a, b]) {
        contacts.writer().write_witnesses(depth, features, error_bound);
    } else if !write_of_polytopes(&known, a, b, corners, contacts.writer()) {
        contacts.write(number, |set| {
            set.write_one(|found| {
                write_by_corners(depth, [a, b], corners, found);
                true
            })
        });
        return;
    }
    contacts.keep_last(number);
}
