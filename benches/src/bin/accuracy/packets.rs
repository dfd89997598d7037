//! The narrow phases that resolve a scene's pairs in packets, run on a subject's pairs.

use dcd_geom::{Aabb, List, Pair};
use dcd_gjk::{
    Accuracy, ContactList, ContactSink, ContactsOf, Depths, Manifolds, NarrowPhase, Overlap,
    OverlapUnchecked, Prepared, Report, Sides, SimdDepths, SimdDistances,
};

use crate::precision::{Query, Said, deepest};
use crate::subject::Subject;

/// A narrow phase that has a subject's objects prepared.
pub(crate) trait Packets {
    /// What it says of the pairs, in their order.
    fn run(&mut self, subject: &Subject, pairs: &[u32], said: &mut Vec<Said>);
}

/// Yes or no, with certificates or without.
pub(crate) fn overlap(subject: &Subject, checked: bool) -> Box<dyn Packets> {
    let touching = |(): &()| Said::Touching;
    if checked {
        prepared(Overlap::default(), subject, touching)
    } else {
        prepared(OverlapUnchecked::default(), subject, touching)
    }
}

/// What `dcd_pipeline::AnyPipeline` runs for that question at that accuracy.
pub(crate) fn numbers(query: Query, accuracy: Accuracy, subject: &Subject) -> Box<dyn Packets> {
    match query {
        Query::YesNo => overlap(subject, true),
        Query::Distance => {
            let margin = margin(subject);
            let said = |found: &Option<dcd_gjk::Distance>| {
                found.map_or(Said::Touching, |found| Said::Measured(found.distance))
            };
            prepared(SimdDistances::within(margin, accuracy).expect(IN_RANGE), subject, said)
        }
        Query::Depth => {
            let said = |found: &dcd_gjk::epa::Depth| Said::Measured(found.depth);
            prepared(SimdDepths::new(Depths, accuracy), subject, said)
        }
        Query::Manifold => {
            prepared(SimdDepths::new(Manifolds::default(), accuracy), subject, deepest)
        }
    }
}

/// See [`margin`].
const IN_RANGE: &str = "a margin above 0 and not above the limit";

/// Twice the size of the largest pair in the scene: no pair is farther apart.
fn margin(subject: &Subject) -> f64 {
    let inside =
        (0..subject.pairs.len() as u32).filter(|&k| subject.in_scene[k as usize].is_some());
    let largest = inside.map(|k| subject.size(k)).fold(1.0, f64::max);
    (2.0 * largest).min(Aabb::LIMIT)
}

fn prepared<N: NarrowPhase + 'static>(
    narrow: N,
    subject: &Subject,
    said: fn(&N::Answer) -> Said,
) -> Box<dyn Packets> {
    let mut frame = N::Frame::default();
    let scene = &subject.scene;
    let part = narrow.layout(scene, Sides::One, &mut frame);
    narrow.prepare(scene, 0, part, &mut vec![Aabb::default(); scene.len()]);
    Box::new(PreparedPhase { narrow, frame, scratch: N::Scratch::default(), said })
}

struct PreparedPhase<N: NarrowPhase> {
    narrow: N,
    frame: N::Frame,
    scratch: N::Scratch,
    said: fn(&N::Answer) -> Said,
}

impl<N: NarrowPhase> Packets for PreparedPhase<N> {
    /// Pairs that no scene takes, since no f32 AABB holds them, are open.
    fn run(&mut self, subject: &Subject, pairs: &[u32], said: &mut Vec<Said>) {
        let in_scene: Vec<Pair> =
            pairs.iter().filter_map(|&k| subject.in_scene[k as usize]).collect();
        let (mut contacts, mut report) = (ContactsOf::<N::Answer>::default(), Report::default());
        let sink = &mut ContactSink { contacts: &mut contacts, report: &mut report };
        let side = Prepared { scene: &subject.scene, frame: &self.frame };
        self.narrow.decide(side, side, &in_scene, &mut self.scratch, sink);
        let mut contacts = contacts.contacts(0..contacts.len()).peekable();
        report.sort();
        let is_open =
            |pair| report.undecided().binary_search_by_key(&pair, |open| open.pair).is_ok();
        said.extend(pairs.iter().map(|&k| match subject.in_scene[k as usize] {
            None => Said::Open,
            // Contacts come in the order of the pairs.
            Some(pair) => match contacts.next_if(|contact| contact.pair == pair) {
                Some(contact) => (self.said)(&contact.answer),
                None if is_open(pair) => Said::Open,
                None => Said::Apart,
            },
        }));
    }
}
