//! The slots of a scene that hold moving objects, as ranges: what is prepared in a step where the rest is known.

use dcd_geom::{Aabb, Motion, Scene, Splittable};
use std::ops::Range;

/// So many static objects between moving ones are prepared with them. Larger: more is done in vain.
/// Smaller: packets of sixteen that are not full.
const GAP: usize = 16;

/// Parts of a range of slots that hold all its moving objects, ascending.
pub(crate) fn moving_ranges(
    scene: &Scene,
    slots: Range<usize>,
) -> impl Iterator<Item = Range<usize>> {
    let moves = |&i: &usize| scene.motion(i) == Some(Motion::Moving);
    let mut moving = slots.filter(moves).peekable();
    std::iter::from_fn(move || {
        let first = moving.next()?;
        let mut end = first + 1;
        while let Some(next) = moving.next_if(|&next| next < end + GAP) {
            end = next + 1;
        }
        Some(first..end)
    })
}

/// Calls `then` with each range's share of what belongs to the slots from `first` on. The ranges ascend and
/// share nothing.
pub(crate) fn for_each_range<S: Splittable>(
    slots: S,
    first: usize,
    ranges: impl Iterator<Item = Range<usize>>,
    mut then: impl FnMut(Range<usize>, S),
) {
    let (mut rest, mut start) = (slots, first);
    for range in ranges {
        let (_, others) = rest.split_at(range.start - start);
        let (share, others) = others.split_at(range.len());
        (rest, start) = (others, range.end);
        then(range, share);
    }
}

/// Empties the AABBs of free slots, for a slice that begins at slot `first`.
pub(crate) fn empty_free_slots(scene: &Scene, first: usize, aabbs: &mut [Aabb]) {
    for (i, aabb) in (first..).zip(aabbs) {
        if scene.motion(i).is_none() {
            *aabb = Aabb::EMPTY;
        }
    }
}
