//! Sorts the judged pairs of a slice by how they are measured, and lets the lanes search. Without a branch that half of the
//! pairs would mispredict; what touches passes by all that is for the others.

use super::super::Scratch as Yes;
use super::super::closed::{are_cuboids, nearest_features as of_cuboids};
use super::super::expand::has_parts;
use super::super::frame::{FramePair, LIVE, SPHERE, STRAIGHT_CORE, WHOLE};
use super::super::nearest_points::{self, Found};
use super::super::straight::CoreForm;
use super::by_parts::ByParts;
use crate::Accuracy;
use dcd_geom::Pair;
use dcd_simd::Path;

/// The pairs of a slice by how they are measured, and what the lanes found of them.
#[derive(Debug, Default)]
pub(super) struct Sorted {
    /// How each pair of the slice is measured.
    pub(super) kinds: Vec<Kind>,
    /// The numbers of the pairs of which more is read than that: all but those of [`Kind::Beyond`].
    pub(super) read: Vec<u32>,
    pub(super) searched: Searched,
    /// The pairs of [`Kind::Formula`].
    pub(super) formulas: Vec<Pair>,
    /// Of the pairs of [`Kind::Cuboids`].
    pub(super) of_cuboids: of_cuboids::Scratch,
    /// Of the pairs of [`Kind::Parts`].
    pub(super) by_parts: ByParts,
    /// The numbers of the pairs that neither touch nor are proved to be beyond the margin.
    open: Vec<u32>,
    /// The pairs of [`Kind::Cuboids`].
    cuboids: Vec<Pair>,
}

/// The pairs of which the nearest vertices are looked for.
#[derive(Debug, Default)]
pub(super) struct Searched {
    /// For each pair of the slice what was found.
    pub(super) found: Vec<Found>,
    /// The numbers in the slice of those that are not proved to be beyond the margin.
    pub(super) near: Vec<u32>,
    /// These pairs.
    pub(super) measured: Vec<Pair>,
    /// The numbers of all of them.
    numbers: Vec<u32>,
    /// The numbers of those of which the judgement found nothing.
    rest: Vec<u32>,
    /// These pairs.
    open: Vec<Pair>,
    nearest: nearest_points::Scratch,
}

/// How a pair is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Not at all: it is known to touch.
    Touching,
    /// By the two centres of spheres.
    Spheres,
    /// By the nearest faces, edges or corners of cuboids.
    Cuboids,
    /// By a formula, at the accuracy of f32: spheres, capsules and cuboids.
    Formula,
    /// By its parts, which the lanes know.
    Parts,
    /// By the search for nearest vertices.
    Searched,
    /// Not at all: it is proved to be beyond the margin, by what proved it apart or by that search.
    Beyond,
}

impl Kind {
    /// By what is known of the pair; what is open is [`Kind::Searched`].
    #[inline(always)]
    fn known(touches: bool, is_clear: bool) -> Self {
        let of_apart = if is_clear { Self::Beyond } else { Self::Searched };
        if touches { Self::Touching } else { of_apart }
    }

    /// Of a pair that is open, at an accuracy.
    #[inline(always)]
    fn of_open(frames: FramePair<'_>, pair: Pair, accuracy: Accuracy) -> Self {
        let (are_cuboids, are_spheres) =
            (are_cuboids(frames, pair), frames.spheres(pair).is_some());
        let has_formula =
            accuracy == Accuracy::F32 && CoreForm::of_pair(frames, pair) != CoreForm::Others;
        let of_others = if has_formula { Self::Formula } else { Self::Searched };
        let of_others = if are_spheres { Self::Spheres } else { of_others };
        let has_parts = frames.have_compounds() && has_parts(frames, pair);
        let of_others = if has_parts { Self::Parts } else { of_others };
        if are_cuboids { Self::Cuboids } else { of_others }
    }
}

impl Searched {
    /// Looks for the nearest vertices of those pairs of which none are known.
    fn find(&mut self, path: Path, frames: FramePair<'_>, (pairs, margin): (&[Pair], f64)) {
        let Self { found, near, measured, numbers, rest, open, nearest } = self;
        let is_open = |number: &u32| {
            let pair = pairs[*number as usize];
            matches!(found[*number as usize], Found::Unknown) & are_searched(frames, pair)
        };
        choose(numbers.iter().map(|number| (*number, is_open(number))), rest);
        if frames.have_vertices() && !rest.is_empty() {
            // Without vertices they are spheres and cuboids, which have a formula.
            open.clear();
            open.extend(rest.iter().map(|&number| pairs[number as usize]));
            nearest_points::find(path, frames, (open, margin), nearest);
            for (&number, &of_open) in rest.iter().zip(&nearest.found) {
                found[number as usize] = of_open;
            }
        }
        let is_near = |number: &u32| !matches!(found[*number as usize], Found::Beyond);
        choose(numbers.iter().map(|number| (*number, is_near(number))), near);
        measured.clear();
        measured.extend(near.iter().map(|&number| pairs[number as usize]));
    }
}

impl Sorted {
    /// Sorts the pairs of a slice that was judged, with the gaps of its proofs.
    pub(super) fn sort(
        &mut self,
        path: Path,
        frames: FramePair<'_>,
        (judged, pairs, margin, accuracy): (&mut Yes, &[Pair], f64, Accuracy),
    ) {
        let Self { kinds, open, read, formulas, searched, cuboids, of_cuboids, by_parts } = self;
        // Rounded up, so that no pair within the margin is left out.
        let far = (margin as f32).next_up();
        let known = judged.touching().iter().zip(judged.kept().clearance());
        kinds.clear();
        kinds.extend(known.map(|(&touches, &gap)| Kind::known(touches, gap > far)));
        choose((0..).zip(kinds.iter().map(|&kind| kind == Kind::Searched)), open);
        for &number in &*open {
            kinds[number as usize] = Kind::of_open(frames, pairs[number as usize], accuracy);
        }
        let sorted = &*kinds;
        let of_kind =
            |kind: Kind| open.iter().map(move |&number| (number, sorted[number as usize] == kind));
        let pairs_of =
            |kind| of_kind(kind).map(|(number, is_one)| (pairs[number as usize], is_one));
        choose(pairs_of(Kind::Formula), formulas);
        choose(pairs_of(Kind::Cuboids), cuboids);
        choose(pairs_of(Kind::Parts), &mut by_parts.pairs);
        of_cuboids::find(path, frames, (cuboids, margin), of_cuboids);
        choose(of_kind(Kind::Searched), &mut searched.numbers);
        judged.lend_found(&mut searched.found);
        searched.find(path, frames, (pairs, margin));
        for &number in &searched.numbers {
            let is_beyond = matches!(searched.found[number as usize], Found::Beyond);
            kinds[number as usize] = if is_beyond { Kind::Beyond } else { Kind::Searched };
        }
        choose((0..).zip(kinds.iter().map(|&kind| kind != Kind::Beyond)), read);
    }
}

/// Whether the vertices of two objects lead to their nearest points. What is more than its vertices has a formula beside a sphere or
/// capsule, and beside its like.
#[inline(always)]
fn are_searched(frames: FramePair<'_>, pair: Pair) -> bool {
    let [a, b] = [frames.a.record(pair.i).marks, frames.b.record(pair.j).marks];
    let (both, either) = (a & b, a | b);
    let is_polytope = (either & WHOLE != 0) & (either & (SPHERE | STRAIGHT_CORE) == 0);
    (both & WHOLE != 0) | ((both & LIVE != 0) & is_polytope)
}

/// Lists the items that are chosen, without a branch.
#[inline]
fn choose<T: Copy + Default>(items: impl Iterator<Item = (T, bool)>, chosen: &mut Vec<T>) {
    chosen.clear();
    let (_, most) = items.size_hint();
    chosen.resize(most.unwrap_or(0) + 1, T::default());
    let mut count = 0;
    for (item, is_chosen) in items {
        chosen[count] = item;
        count += usize::from(is_chosen);
    }
    chosen.truncate(count);
}
