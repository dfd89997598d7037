//! The lists that contacts are kept in.

use crate::epa::Depth;
use crate::{Contact, Proximity};
use dcd_geom::{List, Pair};
use dcd_simd::prefetch;
use std::fmt::Debug;
use std::ops::Range;

/// An answer about a touching pair, which says how its contacts are kept: a large one that seldom fills its room in another form
/// than it is read in.
///
/// ```
/// use dcd_gjk::{Contact, ContactAnswer};
/// #[derive(Clone, Debug, Default)]
/// struct Heat(f64);
/// impl ContactAnswer for Heat {
///     type List = Vec<Contact<Self>>;
/// }
/// ```
pub trait ContactAnswer: Clone + Debug + Default + Send + Sync + 'static {
    /// The list.
    type List: ContactList<Self>;
}

/// The list that contacts with an answer are kept in.
pub type ContactsOf<A> = <A as ContactAnswer>::List;

/// Contacts in the order in which they are added. What is read is equal to what was written.
pub trait ContactList<A>: List + Debug + Sync {
    /// Adds a contact.
    fn push(&mut self, contact: Contact<A>);

    /// Adds a pair whose answer is the default one until it is written.
    fn push_pair(&mut self, pair: Pair);

    /// Has the answer of the contact of that number written, once, over a default one. Where `write` returns false, which is
    /// returned, any answer is left.
    ///
    /// # Panics
    /// There are not as many contacts.
    fn write(&mut self, number: usize, write: impl FnOnce(&mut A) -> bool) -> bool;

    /// Sets the answer of the contact of that number, once, over a default one.
    ///
    /// # Panics
    /// There are not as many contacts.
    fn set(&mut self, number: usize, answer: A);

    /// Takes contacts away by their numbers in rising order, counted from the `first`.
    fn take_away(&mut self, first: usize, numbers: &[u32]);

    /// Prefetches where the answer of the contact of that number will be written: a hint.
    fn prefetch(&self, number: usize);

    /// The pairs of the contacts of those numbers.
    fn pairs(&self, numbers: Range<usize>) -> impl Iterator<Item = Pair>;

    /// The contacts of those numbers.
    fn contacts(&self, numbers: Range<usize>) -> impl Iterator<Item = Contact<A>>;
}

impl ContactAnswer for () {
    type List = Vec<Contact<()>>;
}

impl ContactAnswer for Depth {
    type List = Vec<Contact<Self>>;
}

impl ContactAnswer for Proximity {
    type List = Vec<Contact<Self>>;
}

impl<A: ContactAnswer> ContactList<A> for Vec<Contact<A>> {
    #[inline(always)]
    fn push(&mut self, contact: Contact<A>) {
        self.push(contact);
    }

    #[inline(always)]
    fn push_pair(&mut self, pair: Pair) {
        self.push(Contact { pair, answer: A::default() });
    }

    #[inline(always)]
    fn write(&mut self, number: usize, write: impl FnOnce(&mut A) -> bool) -> bool {
        write(&mut self[number].answer)
    }

    #[inline]
    fn set(&mut self, number: usize, answer: A) {
        self[number].answer = answer;
    }

    fn take_away(&mut self, first: usize, numbers: &[u32]) {
        keep_others(self, first, numbers);
    }

    #[inline(always)]
    fn prefetch(&self, number: usize) {
        prefetch(&self[number..=number]);
    }

    fn pairs(&self, numbers: Range<usize>) -> impl Iterator<Item = Pair> {
        self[numbers].iter().map(|contact| contact.pair)
    }

    fn contacts(&self, numbers: Range<usize>) -> impl Iterator<Item = Contact<A>> {
        self[numbers].iter().cloned()
    }
}

/// Keeps the items but for those of these numbers in rising order, counted from the `first`.
#[cold]
pub(crate) fn keep_others<T>(list: &mut Vec<T>, first: usize, numbers: &[u32]) {
    let last = list.split_off(first);
    let mut left_out = numbers.iter().peekable();
    let kept = (0..).zip(last).filter(|(number, _)| left_out.next_if_eq(&number).is_none());
    list.extend(kept.map(|(_, item)| item));
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::motion::tests::Draw;

    /// All contacts, which are read in parts too.
    pub(crate) fn read<A: ContactAnswer + PartialEq>(
        list: &impl ContactList<A>,
    ) -> Vec<Contact<A>> {
        let contacts: Vec<_> = list.contacts(0..list.len()).collect();
        let second = list.len() / 2..list.len();
        assert!(list.contacts(second.clone()).eq(contacts[second.clone()].iter().cloned()));
        assert!(list.pairs(second.clone()).eq(contacts[second].iter().map(|contact| contact.pair)));
        contacts
    }

    /// Adds contacts at once, and pairs whose answers are written in another order or never, and takes some away; what it
    /// draws depends on the seed alone.
    fn fill<A: ContactAnswer + PartialEq>(
        list: &mut impl ContactList<A>,
        seed: u64,
        answer: impl Fn(&mut Draw) -> A,
    ) {
        let mut draw = Draw(seed);
        for k in 0..30 {
            list.push(Contact { pair: Pair::new(k, k + 1), answer: answer(&mut draw) });
        }
        let (first, count) = (list.len(), 40);
        (0..count as u32).for_each(|k| list.push_pair(Pair::new(k, k + 7)));
        for k in 0..count {
            // Each once: 17 and 40 have no common factor.
            let number = first + k * 17 % count;
            let (found, is_known) = (answer(&mut draw), draw.number() < 0.6);
            let write = |place: &mut A| {
                assert_eq!(*place, A::default());
                *place = if is_known { found } else { A::default() };
                is_known
            };
            if k % 3 == 0 {
                list.set(number, answer(&mut draw));
            } else {
                assert_eq!(list.write(number, write), is_known);
            }
        }
        list.take_away(first, &[0, 3, 4, 39]);
    }

    /// Compares a list with a `Vec`, which is one too. What it holds when it is emptied is looked at.
    pub(crate) fn is_read_as_written<A: ContactAnswer + PartialEq, L: ContactList<A>>(
        list: &mut L,
        answer: impl Fn(&mut Draw) -> A,
        is_emptied: impl Fn(&L),
    ) {
        let mut plain = Vec::new();
        for seed in 0..50 {
            fill(list, seed, &answer);
            fill(&mut plain, seed, &answer);
            assert_eq!(read(list), read(&plain), "{seed}");
            // What is behind other contacts, and what takes the place of others.
            if seed % 3 == 2 {
                list.clear();
                plain.clear();
                assert_eq!((list.len(), read(list)), (0, vec![]));
                is_emptied(list);
            }
        }
    }
}
