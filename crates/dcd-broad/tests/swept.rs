//! Real input of the n-body kind: boxes that a simulation's vertices and faces sweep in a frame.

use dcd_broad::{BroadPhase, SweepAndPrune, WideTree};
use dcd_exec::{Par, Segments};
use dcd_geom::Pair;
use dcd_io::{SweptBoxes, data, load_listed_pairs, load_ply};

fn pairs(phase: &mut impl BroadPhase, boxes: &[dcd_geom::Aabb]) -> Vec<Pair> {
    let mut out = Segments::default();
    phase.build(boxes, Par::Pool.into());
    phase.pairs(boxes, |_, _| true, Par::Pool.into(), &mut out);
    let mut pairs: Vec<_> = out.iter().flatten().copied().collect();
    pairs.sort_unstable();
    pairs
}

#[test]
fn every_listed_pair_of_swept_boxes_is_a_candidate() {
    let files = ["balls16_18.ply", "balls16_19.ply", "18vf.json"];
    let [Some(first), Some(second), Some(listed)] =
        files.map(|file| data::file(&format!("ccd-n-body/{file}")))
    else {
        println!("skipped: the n-body frames are not there");
        return;
    };
    let (first, second) = (load_ply(&first).unwrap(), load_ply(&second).unwrap());
    let swept = SweptBoxes::between(&first, &second).unwrap();
    let listed = load_listed_pairs(&listed).unwrap();
    assert_eq!(listed.len(), 9460);

    let found = pairs(&mut WideTree::default(), &swept.boxes);
    for ids in listed {
        let [a, b] = ids.map(|id| swept.index_of(id).unwrap() as u32);
        assert!(found.binary_search(&Pair::new(a, b)).is_ok(), "{ids:?}");
    }
    assert_eq!(pairs(&mut SweepAndPrune::default(), &swept.boxes), found);
}
