//! What the paper's two presets give on the paper's scene.

use dcd_broad::{BroadPhase, LeafPairs, SweepAndPrune, Traversal, TreePairs, Visits};
use dcd_bvh::PaperTree;
use dcd_exec::{Par, Segments};
use dcd_geom::{Aabb, Pair};
use dcd_scenes::SceneSpec;
use glam::Vec3;
use std::num::NonZeroU32;

fn paper_boxes(count: usize) -> Vec<Aabb> {
    let scene = SceneSpec::paper().with_objects(count).scene().unwrap();
    (0..scene.len()).map(|i| scene.aabb(i)).collect()
}

fn list(phase: &mut impl BroadPhase, aabbs: &[Aabb]) -> Vec<Pair> {
    let mut out = Segments::default();
    phase.build(aabbs, Par::Pool.into());
    phase.pairs(aabbs, |_, _| true, Par::Pool.into(), &mut out);
    out.iter().flatten().copied().collect()
}

fn sorted(mut pairs: Vec<Pair>) -> Vec<Pair> {
    pairs.sort_unstable();
    pairs
}

#[test]
fn a_thousand_objects_give_about_the_candidates_of_figure_3() {
    // Its scene and ours are two draws of one distribution.
    const PUBLISHED: f64 = 50_517.0;
    let aabbs = paper_boxes(1000);
    let overlapping = list(&mut SweepAndPrune::default(), &aabbs).len();
    for (name, mut phase) in
        [("as written", TreePairs::paper_as_written()), ("as coded", TreePairs::paper_as_coded())]
    {
        let candidates = list(&mut phase, &aabbs).len();
        println!("{name}: {candidates} candidates, of which {overlapping} overlap");
        assert!((0.9..1.1).contains(&(candidates as f64 / PUBLISHED)));
        assert!(candidates > 2 * overlapping);
    }
}

#[test]
fn larger_leaves_make_more_candidates_unless_each_is_tested() {
    let aabbs = paper_boxes(500);
    let counts = |leaf_pairs| {
        [1, 4, 16, 64, 256, 1024].map(|cutoff| {
            let leaf_cutoff = NonZeroU32::new(cutoff).unwrap();
            let builder = PaperTree { leaf_cutoff, ..PaperTree::as_written() };
            let traversal = Traversal { leaf_pairs, ..Traversal::PAPER };
            list(&mut TreePairs::new(builder).with(traversal), &aabbs).len()
        })
    };
    let tested = counts(LeafPairs::Tested);
    assert!(tested.iter().all(|&count| count == tested[0]), "{tested:?}");
    let untested = counts(LeafPairs::Untested);
    assert_eq!(untested[0], tested[0]);
    assert_eq!(untested[5], 500 * 499 / 2);
    assert!(untested.is_sorted(), "{untested:?}");
}

#[test]
fn visiting_nodes_once_or_twice_gives_the_same_candidates() {
    let aabbs = paper_boxes(500);
    for leaf_pairs in [LeafPairs::Tested, LeafPairs::Untested] {
        for builder in [PaperTree::as_written(), PaperTree::as_coded()] {
            let [once, twice] = [Visits::Once, Visits::Twice].map(|visits| {
                let traversal = Traversal { visits, leaf_pairs, ..Traversal::PAPER };
                sorted(list(&mut TreePairs::new(builder).with(traversal), &aabbs))
            });
            assert_eq!(once, twice);
        }
    }
}

#[test]
fn a_stable_partition_gives_the_same_candidates_as_another() {
    let aabbs = paper_boxes(3000);
    let [stable, unstable] = [PaperTree::as_written().partition, PaperTree::as_coded().partition]
        .map(|partition| {
            let builder = PaperTree { partition, ..PaperTree::as_written() };
            let traversal = Traversal::PAPER;
            sorted(list(&mut TreePairs::new(builder).with(traversal), &aabbs))
        });
    assert!(stable == unstable);
}

#[test]
fn one_slab_spoils_the_candidates_as_coded_and_not_as_written() {
    let mut aabbs = paper_boxes(2000);
    let surplus = |aabbs: &[Aabb]| {
        let overlapping = list(&mut SweepAndPrune::default(), aabbs).len();
        [PaperTree::as_written(), PaperTree::as_coded()].map(|builder| {
            let traversal = Traversal::PAPER;
            let candidates = list(&mut TreePairs::new(builder).with(traversal), aabbs);
            (candidates.len() - overlapping) as f64 / overlapping as f64
        })
    };
    let [written_before, coded_before] = surplus(&aabbs);
    aabbs.push(Aabb { min: Vec3::new(-100.0, -100.0, -0.5), max: Vec3::new(100.0, 100.0, 0.5) });
    let [written, coded] = surplus(&aabbs);
    println!("surplus: written {written_before} -> {written}, coded {coded_before} -> {coded}");
    assert!(written < 2.0 * written_before && coded > 5.0 * coded_before);
}
