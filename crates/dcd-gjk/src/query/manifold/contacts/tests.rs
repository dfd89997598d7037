//! The list beside a `Vec` of contacts, which is one too.

use super::*;
use crate::mesh::PartIndex;
use crate::motion::tests::Draw;

/// In [0, 1).
fn unit(draw: &mut Draw) -> f64 {
    draw.number() * 0.5 + 0.5
}

/// A manifold of so many points.
fn manifold(draw: &mut Draw, points: usize, kind: Drawn) -> Manifold {
    let mut number = || (unit(draw) * 9.0) as u32;
    let parts = [None, Some(PartIndex::Triangle(number()))];
    let features = [
        [Feature::Surface, Feature::Vertex(number())],
        [Feature::Edge(number(), u32::MAX), Feature::Face(number())],
    ];
    let mut found =
        Manifold { normal: draw.vector(), error_bound: unit(draw), ..Default::default() };
    for k in 0..points {
        found.points.push(ManifoldPoint {
            point_a: draw.vector(),
            point_b: draw.vector(),
            depth: unit(draw),
            features: features[k % 2],
            parts: if kind == Drawn::OfParts && k + 1 == points { parts } else { [None; 2] },
        });
    }
    found.parts = if kind == Drawn::OfWholeParts { parts } else { [None; 2] };
    found
}

/// Whether a manifold is of parts: of none, one point of parts alone, or the whole alone.
#[derive(Clone, Copy, PartialEq)]
enum Drawn {
    Plain,
    OfParts,
    OfWholeParts,
}

/// An answer of any kind.
fn answer(draw: &mut Draw) -> ManifoldSet {
    let count = |draw: &mut Draw| 1 + (unit(draw) * 4.0) as usize;
    let points = count(draw);
    match (unit(draw) * 8.0) as usize {
        0 => ManifoldSet::default(),
        1 => manifold(draw, points, Drawn::OfParts).into(),
        2 => manifold(draw, points, Drawn::OfWholeParts).into(),
        3 => manifold(draw, 0, Drawn::Plain).into(),
        4 => {
            let mut set = ManifoldSet::default();
            for _ in 0..count(draw) {
                let points = count(draw);
                set.push(manifold(draw, points, Drawn::Plain));
            }
            set
        }
        _ => manifold(draw, points, Drawn::Plain).into(),
    }
}

fn read<L: ContactList<ManifoldSet>>(list: &L) -> Vec<Contact<ManifoldSet>> {
    let contacts: Vec<_> = list.contacts(0..list.len()).collect();
    assert!(list.pairs(0..list.len()).eq(contacts.iter().map(|contact| contact.pair)));
    let second = list.len() / 2..list.len();
    assert!(list.contacts(second.clone()).eq(contacts[second.clone()].iter().cloned()));
    assert!(list.pairs(second.clone()).eq(contacts[second].iter().map(|contact| contact.pair)));
    contacts
}

/// Adds contacts at once, and pairs whose answers are written in another order or never, and takes some away; what it draws
/// depends on the seed alone.
fn fill<L: ContactList<ManifoldSet>>(list: &mut L, seed: u64) {
    let mut draw = Draw(seed);
    for k in 0..30 {
        let pair = Pair::new(k, k + 1);
        list.push(Contact { pair, answer: answer(&mut draw) });
    }
    let (first, count) = (list.len(), 40);
    (0..count as u32).for_each(|k| list.push_pair(Pair::new(k, k + 7)));
    for k in 0..count {
        // Each once: 17 and 40 have no common factor.
        let number = first + k * 17 % count;
        let (found, is_known) = (answer(&mut draw), unit(&mut draw) < 0.8);
        let write = |place: &mut ManifoldSet| {
            assert_eq!(*place, ManifoldSet::default());
            *place = if is_known { found } else { ManifoldSet::default() };
            is_known
        };
        assert_eq!(list.write(number, write), is_known);
    }
    list.take_away(first, &[0, 3, 4, 39]);
}

#[test]
fn what_is_read_is_what_was_written_in_any_order() {
    let (mut kept, mut plain) = (ManifoldContacts::default(), Vec::new());
    for seed in 0..50 {
        fill(&mut kept, seed);
        fill(&mut plain, seed);
        assert_eq!(read(&kept), read(&plain), "{seed}");
        // What is behind other contacts, and what takes the place of others.
        if seed % 3 == 2 {
            List::clear(&mut kept);
            plain.clear();
            assert_eq!((List::len(&kept), read(&kept)), (0, vec![]));
            // What owns memory has given it back.
            assert!(kept.answers.whole.is_empty());
        }
    }
}

#[test]
fn a_contact_of_one_point_is_the_one_that_is_measured() {
    let mut draw = Draw(3);
    let mut list = ManifoldContacts::default();
    let mut due = Vec::new();
    for k in 0..9 {
        let (pair, features) = (Pair::new(k, 9), [Feature::Vertex(k), Feature::Surface]);
        if k % 3 == 1 {
            due.push(Contact { pair, answer: manifold(&mut draw, 3, Drawn::Plain).into() });
            ContactList::push(&mut list, due[due.len() - 1].clone());
            continue;
        }
        let depth = Depth {
            depth: unit(&mut draw),
            normal: draw.vector(),
            point_a: draw.vector(),
            point_b: draw.vector(),
            error_bound: unit(&mut draw),
        };
        list.push_one_point(pair, &depth, features);
        let mut found = Manifold::default();
        super::super::write_one_point(&depth, features, &mut found);
        due.push(Contact { pair, answer: found.into() });
    }
    assert_eq!(read(&list), due);
}
