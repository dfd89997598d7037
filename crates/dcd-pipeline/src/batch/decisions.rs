//! Pairs to be decided, and what is known of them.

use super::Obstacles;
use super::posed_links::PosedLinks;
use dcd_geom::{List, Pair};
use dcd_gjk::{ContactAnswer, ContactList, ContactSink, NarrowPhase, Report, Verdict};

/// What a link is checked against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Against {
    /// An obstacle, which is the first of a pair.
    Obstacles,
    /// A link of smaller number.
    Links,
}

/// Pairs of an object of a link with what it is checked against, and the answers.
pub(super) struct Decisions<N: NarrowPhase> {
    obstacles: Half<N::Answer>,
    links: Half<N::Answer>,
    scratch: N::Scratch,
}

/// Pairs with obstacles, or of two links.
struct Half<A: ContactAnswer> {
    pairs: Vec<Pair>,
    contacts: A::List,
    report: Report,
}

impl<A: ContactAnswer> Default for Half<A> {
    fn default() -> Self {
        Self { pairs: Vec::new(), contacts: A::List::default(), report: Report::default() }
    }
}

impl<A: ContactAnswer> Half<A> {
    fn sink(&mut self) -> (&[Pair], ContactSink<'_, A>) {
        let Self { pairs, contacts, report } = self;
        contacts.clear();
        report.clear();
        (pairs, ContactSink { contacts, report })
    }
}

impl<N: NarrowPhase> Default for Decisions<N> {
    fn default() -> Self {
        Self { obstacles: Half::default(), links: Half::default(), scratch: N::Scratch::default() }
    }
}

impl<N: NarrowPhase> Decisions<N> {
    pub(super) fn clear(&mut self) {
        self.obstacles.pairs.clear();
        self.links.pairs.clear();
    }

    /// The pairs that are to be decided.
    pub(super) fn pairs_mut(&mut self, against: Against) -> &mut Vec<Pair> {
        match against {
            Against::Obstacles => &mut self.obstacles.pairs,
            Against::Links => &mut self.links.pairs,
        }
    }

    /// Decides all pairs.
    pub(super) fn decide(&mut self, world: &Obstacles<N>, posed: &PosedLinks<N>) {
        let Self { obstacles, links, scratch } = self;
        let posed = posed.prepared();
        for (side, half) in [(world.prepared(), obstacles), (posed, links)] {
            let (pairs, mut sink) = half.sink();
            if !pairs.is_empty() {
                world.narrow.decide(side, posed, pairs, scratch, &mut sink);
            }
            half.report.sort();
        }
    }

    /// What is not known to be apart: contacts with obstacles, then of links, then what could not be
    /// decided in the same order.
    pub(super) fn hits(&self) -> impl Iterator<Item = (Against, Pair, Verdict<N::Answer>)> {
        let halves = [(Against::Obstacles, &self.obstacles), (Against::Links, &self.links)];
        let contacts = halves.into_iter().flat_map(|(against, half)| {
            let contacts = half.contacts.contacts(0..half.contacts.len());
            contacts.map(move |c| (against, c.pair, Verdict::Touching(c.answer)))
        });
        let undecided = halves.into_iter().flat_map(|(against, half)| {
            let undecided = half.report.undecided().iter();
            undecided.map(move |u| (against, u.pair, Verdict::Undecided(u.reason)))
        });
        contacts.chain(undecided)
    }
}
