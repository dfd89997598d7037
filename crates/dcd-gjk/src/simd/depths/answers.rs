//! Where the answers of touching pairs are written: of polytopes several at once, as many as the solver looks at together.

use super::super::CuboidPatch;
use super::super::scene_pairs::ScenePairs;
use super::straight::CoreContact;
use crate::epa::Depth;
use crate::query::{FoundDepth, FoundPair, MeasureDepth};
use crate::{ContactList, ContactsOf, PosedShape, Verdict};
use dcd_simd::{ArrayVec, Path};

/// The most pairs that are answered together.
const MOST: usize = 8;

/// Where the answers of touching pairs are written.
pub(super) struct Answers<'a, S: MeasureDepth> {
    /// The pairs.
    pub(super) objects: ScenePairs<'a>,
    pub(super) to: Contacts<'a, S>,
    /// Those that are answered next.
    pub(super) waiting: ArrayVec<FoundPair<'a>, MOST>,
}

/// The contacts, and who writes their answers.
pub(super) struct Contacts<'a, S: MeasureDepth> {
    pub(super) path: Path,
    pub(super) solver: &'a S,
    pub(super) scratch: &'a mut S::Scratch,
    /// One for each pair from the `first` on, whose answers are to be written.
    pub(super) contacts: &'a mut ContactsOf<S::Answer>,
    pub(super) first: usize,
    /// The numbers of those that stay empty.
    pub(super) left: &'a mut Vec<u32>,
}

/// Where the answer of two polytopes is written. What searches them knows no more of a question, so that it is compiled
/// here, once, and not by every crate that names a solver.
pub(super) trait WriteDepth {
    /// Writes the answer of the pair of that number, of that depth; without a depth it is left to the solver.
    fn write(&mut self, number: usize, found: Option<&FoundDepth>);

    /// Prefetches where the answer of the pair of that number will be written: a hint.
    fn prefetch(&self, number: usize);
}

impl<S: MeasureDepth> Answers<'_, S> {
    /// Writes the answer of two spheres of that depth.
    #[inline(always)]
    pub(super) fn write_spheres(&mut self, number: u32, depth: &Depth, off_surface: f64) {
        let Contacts { solver, contacts, first, .. } = &mut self.to;
        contacts.write(*first + number as usize, |answer| {
            solver.measure_spheres(depth, off_surface, answer);
            true
        });
    }

    /// Writes the answer of two cuboids with that patch; false where the depth is needed.
    #[inline(always)]
    pub(super) fn write_patch(
        &mut self,
        number: u32,
        patch: CuboidPatch<'_>,
        sides: [PosedShape<'_>; 2],
    ) -> bool {
        let Contacts { solver, contacts, first, .. } = &mut self.to;
        solver.measure_cuboids(patch, sides, (contacts, *first + number as usize))
    }

    /// Writes the answer of two shapes whose cores are known to be nearest there; what is not known is left to the solver.
    #[inline(always)]
    pub(super) fn write_contact(&mut self, number: u32, found: Option<CoreContact<'_>>) {
        let Contacts { solver, contacts, first, left, .. } = &mut self.to;
        let is_written = match &found {
            Some(found) => solver.measure_cores(found, (contacts, *first + number as usize)),
            None => false,
        };
        if !is_written {
            left.push(number);
        }
    }

    /// Writes the answers that wait. Needed behind the last pair.
    pub(super) fn end(&mut self) {
        // A solver may make memory for what it is asked.
        if !self.waiting.is_empty() {
            self.to.write_all(&self.waiting);
            self.waiting = ArrayVec::new();
        }
    }
}

impl<S: MeasureDepth> Contacts<'_, S> {
    /// Writes the answers of those pairs.
    #[inline(always)]
    fn write_all(&mut self, pairs: &[FoundPair<'_>]) {
        let Self { path, solver, scratch, contacts, first, left } = self;
        let unwritten = solver.measure_polytopes(*path, pairs, scratch, contacts);
        for (k, pair) in pairs.iter().enumerate() {
            if unwritten >> k & 1 == 0 {
                continue;
            }
            let FoundPair { found, sides: [a, b], number } = *pair;
            match solver.measure_depth(found.depth, a, b, scratch) {
                Verdict::Touching(measured) => contacts.set(number, measured),
                _ => left.push((number - *first) as u32),
            }
        }
    }
}

impl<S: MeasureDepth> WriteDepth for Answers<'_, S> {
    fn write(&mut self, number: usize, found: Option<&FoundDepth>) {
        let Some(&found) = found else { return self.to.left.push(number as u32) };
        let sides = self.objects.posed(self.objects.pairs[number]);
        let pair = FoundPair { found, sides, number: self.to.first + number };
        // One alone does not wait: it would be written twice and read in between.
        if S::TOGETHER <= 1 {
            return self.to.write_all(&[pair]);
        }
        self.waiting.push(pair);
        if self.waiting.len() >= S::TOGETHER.min(MOST) {
            self.end();
        }
    }

    fn prefetch(&self, number: usize) {
        self.to.contacts.prefetch(self.to.first + number);
    }
}
