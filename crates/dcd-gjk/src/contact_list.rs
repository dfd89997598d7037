//! The lists that contacts are kept in.

use crate::epa::Depth;
use crate::{Contact, Distance, Proximity};
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

impl ContactAnswer for Option<Distance> {
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
