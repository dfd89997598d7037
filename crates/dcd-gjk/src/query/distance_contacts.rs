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
    /// Adds pairs, each of which touches or not, and the distances of the others, of which there are so many, in their order.
    /// Nothing is added, and false returned, where there are fewer.
    #[inline(always)]
    pub(crate) fn extend(
        &mut self,
        pairs: impl Iterator<Item = (Pair, bool)>,
        others: usize,
        distances: impl Iterator<Item = Distance>,
    ) -> bool {
        let Self { heads, apart } = self;
        let mut place = apart.len();
        apart.reserve(others);
        apart.extend(distances);
        if apart.len() != place + others {
            apart.truncate(place);
            return false;
        }
        // Without a branch, for no predictor knows which pairs touch.
        heads.extend(pairs.map(
            #[inline(always)]
            |(pair, touches)| {
                let head = Head { pair, place: place | usize::from(touches).wrapping_neg() };
                place += usize::from(!touches);
                head
            },
        ));
        true
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
    fn pairs_that_touch_are_added_without_a_distance_and_none_where_one_is_missing() {
        let mut draw = Draw(7);
        let (mut list, mut due) = (DistanceContacts::default(), Vec::new());
        for k in 0..30 {
            let pairs: Vec<(Pair, bool)> =
                (0..k).map(|i| (Pair::new(i, 200), draw.number() < 0.0)).collect();
            let others = pairs.iter().filter(|(_, touches)| !touches).count();
            let found: Vec<Distance> = (0..others).map(|_| distance(&mut draw)).collect();
            let mut add = |found: &[Distance]| {
                list.extend(pairs.iter().copied(), others, found.iter().copied())
            };
            if let Some((_, fewer)) = found.split_last() {
                assert!(!add(fewer));
            }
            assert!(add(&found));
            let mut found = found.into_iter();
            let answer = |(pair, touches)| Contact {
                pair,
                answer: if touches { None } else { found.next() },
            };
            due.extend(pairs.into_iter().map(answer));
        }
        assert_eq!(read(&list), due);
        assert_eq!(list.apart.len(), due.iter().filter(|contact| contact.answer.is_some()).count());
    }
}
