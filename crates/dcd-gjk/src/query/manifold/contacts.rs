//! Contacts with their manifolds as a step keeps them: without the room that most do not fill.
//!
//! A manifold has room for four points, and most have one or two. Kept as they are, a step would write here and there in memory
//! that it does not read, and wait for every line of it; and several of one pair are memory of their own.

#[cfg(test)]
mod tests;

use super::feature_code::FeatureCode;
use super::patch_writer::{PatchWriter, Point};
use super::{Feature, Manifold, ManifoldPoint, ManifoldSet};
use crate::epa::Depth;
use crate::mesh::PartIndex;
use crate::{Contact, ContactAnswer, ContactList};
use dcd_geom::glam::DVec3;
use dcd_geom::{List, Pair};
use std::ops::Range;

/// Contacts with their manifolds. These are kept as their points, in lists that are written from their beginning to their end:
/// those of one manifold of shapes without parts, and those of all others.
#[derive(Clone, Debug, Default)]
pub struct ManifoldContacts {
    heads: Vec<Head>,
    answers: Answers,
    /// Where an answer is written before it is kept.
    written: ManifoldSet,
}

/// A contact.
#[derive(Clone, Copy, Debug)]
struct Head {
    pair: Pair,
    answer: Place,
}

/// Where an answer is. In one word, so that a contact is two.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place(usize);

/// The list that it is in, and its number there.
enum Location {
    /// It was not written: the default one.
    Nowhere,
    /// In the list of single manifolds without parts.
    One(usize),
    /// In that of all others.
    Set(usize),
}

/// The answers in the order in which they were written.
#[derive(Clone, Debug, Default)]
struct Answers {
    ones: Vec<One>,
    /// The points of these behind the first of each.
    rest: Vec<Point>,
    /// Where the patches of each other answer end; they begin where those of the one before it do.
    sets: Vec<usize>,
    patches: Vec<Patch>,
    points: Vec<ManifoldPoint>,
}

/// A manifold of shapes without parts.
#[derive(Clone, Copy, Debug)]
struct One {
    normal: DVec3,
    error_bound: f64,
    first: Point,
    /// Where its other points end; they begin where those of the one before it do.
    end: usize,
}

/// A manifold of an answer of any kind.
#[derive(Clone, Copy, Debug)]
struct Patch {
    normal: DVec3,
    error_bound: f64,
    parts: [Option<PartIndex>; 2],
    /// Where its points end, likewise.
    end: usize,
}

impl ContactAnswer for ManifoldSet {
    type List = ManifoldContacts;
}

impl ManifoldContacts {
    /// Adds the contact of two shapes without parts that touch in the witnesses of their depth.
    #[inline(always)]
    pub(super) fn push_one_point(&mut self, pair: Pair, depth: &Depth, features: [Feature; 2]) {
        let &Depth { depth, normal, point_a, point_b, error_bound } = depth;
        let features = features.map(FeatureCode::from);
        let first = Point { point_a, point_b, depth, features };
        let Self { heads, answers: Answers { ones, rest, .. }, .. } = self;
        heads.push(Head { pair, answer: Place::of_one(ones.len()) });
        ones.push(One { normal, error_bound, first, end: rest.len() });
    }
}

impl ManifoldContacts {
    /// Where the single manifold of shapes without parts is written that [`ManifoldContacts::keep_last`] then keeps.
    // Two functions, and no closure between them: a kernel calls both.
    #[inline(always)]
    pub(super) fn writer(&mut self) -> &mut impl PatchWriter {
        &mut self.answers
    }

    /// Has what was written last be the answer of the contact of that number, once, in place of a default one.
    ///
    /// # Panics
    /// There are not as many contacts.
    #[inline(always)]
    pub(super) fn keep_last(&mut self, number: usize) {
        self.heads[number].answer = Place::of_one(self.answers.ones.len() - 1);
    }
}

/// Of one manifold after the other.
impl PatchWriter for Answers {
    #[inline(always)]
    fn begin(&mut self, normal: DVec3, error_bound: f64, deepest: Point) {
        self.ones.push(One { normal, error_bound, first: deepest, end: self.rest.len() });
    }

    #[inline(always)]
    fn push(&mut self, point: Point) {
        self.rest.push(point);
        if let Some(last) = self.ones.last_mut() {
            last.end = self.rest.len();
        }
    }
}

impl Place {
    const NOWHERE: Self = Self(usize::MAX);

    // No list is so long that twice a number is too large.
    #[inline(always)]
    fn of_one(number: usize) -> Self {
        Self(2 * number)
    }

    #[inline(always)]
    fn of_set(number: usize) -> Self {
        Self(2 * number + 1)
    }

    fn location(self) -> Location {
        match self.0 {
            usize::MAX => Location::Nowhere,
            place if place % 2 == 0 => Location::One(place / 2),
            place => Location::Set(place / 2),
        }
    }
}

impl Answers {
    #[inline(always)]
    fn keep(&mut self, answer: &ManifoldSet) -> Place {
        match self.keep_one(answer) {
            Some(place) => place,
            None => self.keep_set(answer),
        }
    }

    /// Keeps a single manifold of shapes without parts; `None` of any other answer.
    #[inline(always)]
    fn keep_one(&mut self, answer: &ManifoldSet) -> Option<Place> {
        let [only] = &**answer else { return None };
        let (first, others) = only.points.split_first()?;
        let has_parts = |point: &ManifoldPoint| point.parts != [None; 2];
        if only.parts != [None; 2] || only.points.iter().any(has_parts) {
            return None;
        }
        let &Manifold { normal, error_bound, .. } = only;
        self.rest.extend(others.iter().map(Point::of));
        let (first, end) = (Point::of(first), self.rest.len());
        self.ones.push(One { normal, error_bound, first, end });
        Some(Place::of_one(self.ones.len() - 1))
    }

    #[inline]
    fn keep_set(&mut self, answer: &[Manifold]) -> Place {
        for &Manifold { normal, error_bound, parts, ref points } in answer {
            self.points.extend_from_slice(points);
            self.patches.push(Patch { normal, error_bound, parts, end: self.points.len() });
        }
        self.sets.push(self.patches.len());
        Place::of_set(self.sets.len() - 1)
    }

    /// An answer as it was.
    fn at(&self, place: Place) -> ManifoldSet {
        match place.location() {
            Location::Nowhere => ManifoldSet::default(),
            Location::Set(number) => {
                let start = start(&self.sets, number, |&end| end);
                let mut found = ManifoldSet::default();
                (start..self.sets[number]).for_each(|patch| found.push(self.patch(patch)));
                found
            }
            Location::One(number) => {
                let One { normal, error_bound, first, end } = &self.ones[number];
                let start = start(&self.ones, number, |one| one.end);
                let points = std::iter::once(first).chain(&self.rest[start..*end]);
                let mut found =
                    Manifold { normal: *normal, error_bound: *error_bound, ..Default::default() };
                found.points.extend(points.map(Point::read));
                found.into()
            }
        }
    }

    /// A manifold as it was.
    fn patch(&self, number: usize) -> Manifold {
        let Patch { normal, error_bound, parts, end } = self.patches[number];
        let start = start(&self.patches, number, |patch| patch.end);
        let mut found = Manifold { normal, error_bound, parts, ..Default::default() };
        found.points.extend(self.points[start..end].iter().copied());
        found
    }

    fn clear(&mut self) {
        let Self { ones, rest, sets, patches, points } = self;
        ones.clear();
        rest.clear();
        sets.clear();
        patches.clear();
        points.clear();
    }
}

/// Where what is of one in a list begins: where that of the one before it ends.
fn start<T>(list: &[T], number: usize, end: impl Fn(&T) -> usize) -> usize {
    number.checked_sub(1).map_or(0, |before| end(&list[before]))
}

impl Point {
    #[inline(always)]
    fn of(&ManifoldPoint { point_a, point_b, depth, features, parts: _ }: &ManifoldPoint) -> Self {
        Self { point_a, point_b, depth, features: features.map(FeatureCode::from) }
    }

    fn read(&self) -> ManifoldPoint {
        let &Self { point_a, point_b, depth, features } = self;
        let features = features.map(Feature::from);
        ManifoldPoint { point_a, point_b, depth, features, parts: [None; 2] }
    }
}

impl List for ManifoldContacts {
    fn len(&self) -> usize {
        self.heads.len()
    }

    fn clear(&mut self) {
        self.heads.clear();
        self.answers.clear();
    }
}

impl ContactList<ManifoldSet> for ManifoldContacts {
    fn push(&mut self, Contact { pair, answer }: Contact<ManifoldSet>) {
        let answer = self.answers.keep(&answer);
        self.heads.push(Head { pair, answer });
    }

    #[inline(always)]
    fn push_pair(&mut self, pair: Pair) {
        self.heads.push(Head { pair, answer: Place::NOWHERE });
    }

    #[inline(always)]
    fn write(&mut self, number: usize, write: impl FnOnce(&mut ManifoldSet) -> bool) -> bool {
        let Self { heads, answers, written } = self;
        written.clear();
        let is_written = write(written);
        if is_written {
            heads[number].answer = answers.keep(written);
        }
        is_written
    }

    fn set(&mut self, number: usize, answer: ManifoldSet) {
        self.heads[number].answer = self.answers.keep(&answer);
    }

    fn take_away(&mut self, first: usize, numbers: &[u32]) {
        crate::contact_list::keep_others(&mut self.heads, first, numbers);
    }

    /// Nothing: an answer is written at the end of a list.
    fn prefetch(&self, _: usize) {}

    fn pairs(&self, numbers: Range<usize>) -> impl Iterator<Item = Pair> {
        self.heads[numbers].iter().map(|head| head.pair)
    }

    fn contacts(&self, numbers: Range<usize>) -> impl Iterator<Item = Contact<ManifoldSet>> {
        let contact =
            |head: &Head| Contact { pair: head.pair, answer: self.answers.at(head.answer) };
        self.heads[numbers].iter().map(contact)
    }
}
