//! Pairs of robots whose answer is known.

use super::{LinkPair, PairReason, PairSearch, write_srdf};
use crate::{AllowedPairs, LinkShapes, Robot, Srdf};
use std::path::Path;

fn robot(text: &str) -> Robot {
    Robot::read(text, Path::new("."), LinkShapes::Hulls).unwrap()
}

fn link(name: &str, x: f64, size: f64) -> String {
    format!(
        "<link name=\"{name}\"><collision><origin xyz=\"{x} 0 0\"/><geometry><box size=\"{size} 0.1 0.1\"/></geometry></collision></link>"
    )
}

fn joint(parent: &str, child: &str, x: f64, limit: f64) -> String {
    format!(
        "<joint name=\"{parent}-{child}\" type=\"revolute\"><origin xyz=\"{x} 0 0\"/><axis xyz=\"0 0 1\"/>\
         <limit lower=\"-{limit}\" upper=\"{limit}\"/><parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
    )
}

/// Three bars of length 0.9 in a row, each turning by up to `limit` against the one before.
fn row(limit: f64) -> Robot {
    let links = ["a", "b", "c"].map(|name| link(name, 0.5, 0.9)).concat();
    robot(&format!(
        "<robot name=\"row &amp; more\">{links}{}{}</robot>",
        joint("a", "b", 1.0, limit),
        joint("b", "c", 1.0, limit)
    ))
}

fn reason(pairs: &[LinkPair], a: &str, b: &str) -> Option<PairReason> {
    pairs.iter().find(|pair| pair.links == [a, b]).map(|pair| pair.reason)
}

#[test]
fn what_cannot_reach_is_proved_and_what_can_is_left() {
    // Turned by at most 1.2 rad twice, the third bar stays clear of the first; by 3 rad it meets it.
    let short = PairSearch::default().run(&row(1.2)).unwrap();
    assert_eq!(reason(&short, "a", "c"), Some(PairReason::Never { proved: true }));
    assert_eq!(reason(&short, "a", "b"), Some(PairReason::Adjacent));
    let long = PairSearch::default().run(&row(3.0)).unwrap();
    assert_eq!((reason(&long, "a", "c"), long.len()), (None, 2));
}

#[test]
fn a_touching_state_that_no_sample_meets_is_found_by_the_search() {
    // No sample at all: only the state at rest, where they are apart.
    let found = PairSearch { samples: 0, ..PairSearch::default() }.run(&row(3.0)).unwrap();
    assert_eq!(reason(&found, "a", "c"), None);
    // And with one box for each pair nothing is proved.
    let found = PairSearch { samples: 1, nodes: 1, seed: 7 }.run(&row(1.2)).unwrap();
    assert_eq!(reason(&found, "a", "c"), Some(PairReason::Never { proved: false }));
}

#[test]
fn what_touches_always_and_what_touches_at_rest_are_distinguished() {
    // d is fixed to b and reaches into c, whatever turns about c's middle; e turns out of it.
    let links = [
        link("b", 0.0, 0.2),
        "<link name=\"none\"/>".to_owned(),
        link("c", 0.0, 0.5),
        link("d", 0.0, 0.3),
        link("e", 0.5, 0.9),
    ]
    .concat();
    let fixed = |parent: &str, child: &str| {
        format!(
            "<joint name=\"{child}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
        )
    };
    let robot = robot(&format!(
        "<robot name=\"r\">{links}{}{}{}{}</robot>",
        fixed("b", "none"),
        fixed("b", "d"),
        joint("none", "c", 0.3, 0.3),
        joint("none", "e", -0.6, 3.0)
    ));
    let found = PairSearch::default().run(&robot).unwrap();
    assert_eq!(reason(&found, "c", "d"), Some(PairReason::Always), "{found:?}");
    assert_eq!(reason(&found, "d", "e"), Some(PairReason::Default));
    assert_eq!(
        reason(&found, "b", "c"),
        Some(PairReason::Adjacent),
        "past the link without a shape"
    );
}

#[test]
fn links_that_nothing_moves_and_that_barely_part_are_no_proof_and_no_panic() {
    for (gap, proved) in [(1e-13, false), (0.1, true)] {
        let size = 1.0 - gap;
        let links = [link("a", 0.0, 1.0), "<link name=\"none\"/>".to_owned(), link("b", 1.0, size)];
        let fixed = |parent: &str, child: &str, x: f64| {
            format!(
                "<joint name=\"{child}\" type=\"fixed\"><origin xyz=\"{x} 0 0\"/>\
                 <parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
            )
        };
        // Both on a third link, so that no joint joins them.
        let far = link("base", -9.0, 1.0);
        let joints = [fixed("base", "none", 0.0), fixed("none", "a", 0.0), fixed("none", "b", 0.0)];
        let text = format!("<robot name=\"r\">{far}{}{}</robot>", links.concat(), joints.concat());
        let found = PairSearch::default().run(&robot(&text)).unwrap();
        assert_eq!(reason(&found, "a", "b"), Some(PairReason::Never { proved }), "{gap}");
    }
}

#[test]
fn what_slides_without_limits_is_left_to_be_checked() {
    let ways = [("planar", ""), ("floating", ""), ("prismatic", "<axis xyz=\"1 0 0\"/>")];
    for (kind, axis) in ways {
        for samples in [0, 1000] {
            let links = [link("wall", 3.0, 1.0), link("cart", 0.0, 0.3), link("arm", 0.0, 0.2)];
            let slide = format!(
                "<joint name=\"slide\" type=\"{kind}\">{axis}<parent link=\"wall\"/><child link=\"cart\"/></joint>"
            );
            let turn = joint("cart", "arm", 0.0, 1.0);
            let text = format!("<robot name=\"r\">{}{slide}{turn}</robot>", links.concat());
            let found = PairSearch { samples, ..PairSearch::default() }.run(&robot(&text)).unwrap();
            assert_eq!(reason(&found, "arm", "wall"), None, "{kind}");
            assert_eq!(found.len(), 2, "{kind}: {found:?}");
        }
    }
}

#[test]
fn without_a_sample_nothing_touches_always() {
    let text = format!(
        "<robot name=\"r\"><link name=\"base\"/>{}{}{}{}</robot>",
        link("a", 0.0, 1.0),
        link("b", 0.2, 1.0),
        joint("base", "a", 0.0, 1.0),
        joint("base", "b", 0.0, 1.0)
    );
    let of = |samples| PairSearch { samples, ..PairSearch::default() }.run(&robot(&text)).unwrap();
    assert_eq!(reason(&of(0), "a", "b"), Some(PairReason::Default));
    assert_eq!(reason(&of(10), "a", "b"), Some(PairReason::Always));
}

#[test]
fn an_srdf_that_is_written_is_read_again() {
    let pairs = PairSearch::default().run(&row(1.2)).unwrap();
    let text = write_srdf("row & \"more\"", &pairs);
    let srdf = Srdf::read(&text).unwrap();
    assert_eq!(srdf.robot, "row & \"more\"");
    assert_eq!(srdf.allowed.len(), pairs.len());
    for LinkPair { links: [a, b], .. } in &pairs {
        assert!(srdf.allowed.contains(a, b) && AllowedPairs::from_pairs(&pairs).contains(b, a));
    }
    assert!(text.contains("reason=\"Never\" proved=\"true\""), "{text}");
}
