//! The list beside a `Vec` of contacts.

use super::super::patch_writer::InOrder;
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

/// The points of a manifold, in the order in which they are drawn, of a pair or of the same in the other order.
fn write(drawn: &Manifold, is_swapped: bool, writer: &mut impl PatchWriter) {
    let writer = &mut InOrder { writer, is_swapped };
    let (deepest, others) = drawn.points.split_first().unwrap();
    writer.begin(drawn.normal, drawn.error_bound, Point::of(deepest));
    others.iter().for_each(|point| writer.push(Point::of(point)));
}

#[test]
fn a_manifold_that_is_written_in_its_place_is_the_same_by_itself() {
    let mut draw = Draw(4);
    let mut list = ManifoldContacts::default();
    let pair = |k: u32| Pair::new(k, k + 9);
    let mut due: Vec<_> =
        (0..40).map(|k| Contact { pair: pair(k), answer: ManifoldSet::default() }).collect();
    (0..40).for_each(|k| list.push_pair(pair(k)));
    for k in 0..40 {
        // Each once: 17 and 40 have no common factor. Some stay default ones, some are written as a whole.
        let number = k * 17 % 40;
        let points = 1 + (unit(&mut draw) * 4.0) as usize;
        let drawn = manifold(&mut draw, points, Drawn::Plain);
        let is_swapped = k % 2 == 1;
        let mut found = Manifold::default();
        write(&drawn, is_swapped, &mut found);
        let mut mirrored = drawn;
        if is_swapped {
            mirrored.mirror();
        }
        assert_eq!(found, mirrored);
        match k % 5 {
            0 => continue,
            1 => list.set(number, found.into()),
            _ => {
                write(&drawn, is_swapped, list.writer());
                list.keep_last(number);
            }
        }
        due[number].answer = found.into();
    }
    assert_eq!(read(&list), due);
}
