//! Contacts with their distances as a step keeps them: of those that touch there is nothing to keep.

use crate::contact_list::keep_others;
use crate::{Contact, ContactAnswer, ContactList, Distance};
use dcd_geom::{List, Pair};
use std::ops::Range;

/// Contacts with their distances: the distances alone, in a list of their own. In most scenes most of the pairs within a margin
/// touch.
#[derive(Clone, Debug, Default)]
pub struct DistanceContacts {
    heads: Vec<Head>,
    apart: Vec<Distance>,
}

/// A contact.
#[derive(Clone, Copy, Debug)]
struct Head {
    pair: Pair,
    /// Where its distance is; nowhere of a pair that touches.
    place: usize,
}

/// No place of a list.
const NOWHERE: usize = usize::MAX;

impl ContactAnswer for Option<Distance> {
    type List = DistanceContacts;
}

impl DistanceContacts {
    /// Adds a pair with a distance, unless it touches: without a branch, for no predictor knows which pairs do.
    #[inline(always)]
    pub(crate) fn push_unless(&mut self, touches: bool, pair: Pair, distance: Distance) {
        let Self { heads, apart } = self;
        let before = apart.len();
        heads.push(Head { pair, place: before | usize::from(touches).wrapping_neg() });
        // Written and taken back.
        apart.push(distance);
        apart.truncate(before + usize::from(!touches));
    }

    /// Adds a distance; where it is.
    fn keep(&mut self, answer: Option<Distance>) -> usize {
        let Some(distance) = answer else { return NOWHERE };
        self.apart.push(distance);
        self.apart.len() - 1
    }
}

impl List for DistanceContacts {
    fn len(&self) -> usize {
        self.heads.len()
    }

    fn clear(&mut self) {
        self.heads.clear();
        self.apart.clear();
    }
}

impl ContactList<Option<Distance>> for DistanceContacts {
    fn push(&mut self, Contact { pair, answer }: Contact<Option<Distance>>) {
        let place = self.keep(answer);
        self.heads.push(Head { pair, place });
    }

    #[inline]
    fn push_pair(&mut self, pair: Pair) {
        self.heads.push(Head { pair, place: NOWHERE });
    }

    fn write(&mut self, number: usize, write: impl FnOnce(&mut Option<Distance>) -> bool) -> bool {
        let mut answer = None;
        let is_written = write(&mut answer);
        self.heads[number].place = self.keep(answer);
        is_written
    }

    fn set(&mut self, number: usize, answer: Option<Distance>) {
        self.heads[number].place = self.keep(answer);
    }

    fn take_away(&mut self, first: usize, numbers: &[u32]) {
        keep_others(&mut self.heads, first, numbers);
    }

    /// Nothing: an answer is written at the end of a list.
    fn prefetch(&self, _: usize) {}

    fn pairs(&self, numbers: Range<usize>) -> impl Iterator<Item = Pair> {
        self.heads[numbers].iter().map(|head| head.pair)
    }

    fn contacts(&self, numbers: Range<usize>) -> impl Iterator<Item = Contact<Option<Distance>>> {
        let answer = |head: &Head| self.apart.get(head.place).copied();
        self.heads[numbers]
            .iter()
            .map(move |head| Contact { pair: head.pair, answer: answer(head) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact_list::tests::{is_read_as_written, read};
    use crate::motion::tests::Draw;

    fn distance(draw: &mut Draw) -> Distance {
        Distance {
            distance: draw.number(),
            point_a: draw.vector(),
            point_b: draw.vector(),
            normal: draw.vector(),
            error_bound: draw.number(),
        }
    }

    #[test]
    fn distances_are_read_as_they_were_written_in_any_order() {
        let mut list = DistanceContacts::default();
        let answer = |draw: &mut Draw| (draw.number() < 0.2).then(|| distance(draw));
        is_read_as_written(&mut list, answer, |list| assert!(list.apart.is_empty()));
    }

    #[test]
    fn what_touches_has_no_distance() {
        let mut draw = Draw(7);
        let (mut list, mut due) = (DistanceContacts::default(), Vec::new());
        for k in 0..200 {
            let (pair, found) = (Pair::new(k, 200), distance(&mut draw));
            let touches = draw.number() < 0.0;
            list.push_unless(touches, pair, found);
            due.push(Contact { pair, answer: (!touches).then_some(found) });
        }
        assert_eq!(read(&list), due);
        assert_eq!(list.apart.len(), due.iter().filter(|contact| contact.answer.is_some()).count());
    }
}
