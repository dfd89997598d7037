//! The list beside a `Vec` of contacts.

use super::*;
use crate::contact_list::tests::{is_read_as_written, read};
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

#[test]
fn what_is_read_is_what_was_written_in_any_order() {
    let is_emptied = |list: &ManifoldContacts| assert!(list.answers.points.is_empty());
    is_read_as_written(&mut ManifoldContacts::default(), answer, is_emptied);
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
