//! Every broad phase keeps its contract, on boxes that were made here and on boxes that were not.

use dcd_broad::{
    BroadPhase, BruteForce, LeafPairs, SweepAndPrune, Traversal, TreePairs, Visits, WideTree,
    contract,
};
use dcd_bvh::{PaperTree, WideBuilder};
use dcd_exec::{Exec, Par, Segments, with_threads};
use dcd_geom::{Aabb, Pair};
use dcd_io::{data, load_boxes};
use dcd_scenes::SceneSpec;
use glam::Vec3;
use proptest::prelude::*;

/// Tests the contract of every phase, and that all but the paper's list the overlapping pairs alone.
fn every_phase_keeps_the_contract(aabbs: &[Aabb]) {
    let exact = [
        ("brute force", contract::broad_phase(&mut BruteForce, aabbs)),
        ("sweep", contract::broad_phase(&mut SweepAndPrune::default(), aabbs)),
        ("tree", contract::broad_phase(&mut TreePairs::new(PaperTree::default()), aabbs)),
        ("wide as a tree", contract::broad_phase(&mut TreePairs::new(WideBuilder), aabbs)),
        ("wide tree", contract::broad_phase(&mut WideTree::default(), aabbs)),
    ];
    for (phase, surplus) in exact {
        assert_eq!(surplus, Ok(0), "{phase}");
    }
    for visits in [Visits::Once, Visits::Twice] {
        for leaf_pairs in [LeafPairs::Tested, LeafPairs::Untested] {
            for max_depth in [0, 3, u32::MAX] {
                for builder in [PaperTree::as_written(), PaperTree::as_coded()] {
                    let traversal = Traversal { max_depth, visits, leaf_pairs };
                    let mut phase = TreePairs::new(builder).with(traversal);
                    let surplus = contract::broad_phase(&mut phase, aabbs);
                    assert!(surplus.is_ok(), "{traversal:?} {builder:?}: {surplus:?}");
                    assert!(leaf_pairs == LeafPairs::Untested || surplus == Ok(0));
                }
            }
        }
    }
}

fn boxed(centre: Vec3, half: Vec3) -> Aabb {
    Aabb { min: centre - half, max: centre + half }
}

fn list(phase: &mut impl BroadPhase, aabbs: &[Aabb], par: Par) -> Vec<Pair> {
    let mut out = Segments::default();
    phase.build(aabbs, par.into());
    phase.pairs(aabbs, |_, _| true, par.into(), &mut out);
    out.iter().flatten().copied().collect()
}

#[test]
fn no_box_and_one_box_are_legal_and_give_no_pair() {
    every_phase_keeps_the_contract(&[]);
    every_phase_keeps_the_contract(&[boxed(Vec3::ZERO, Vec3::ONE)]);
}

#[test]
fn identical_boxes_all_pair_up() {
    let aabbs = vec![boxed(Vec3::ONE, Vec3::ONE); 150];
    every_phase_keeps_the_contract(&aabbs);
    assert_eq!(list(&mut WideTree::default(), &aabbs, Par::Pool).len(), 150 * 149 / 2);
}

#[test]
fn touching_boxes_are_pairs_and_the_next_float_is_not() {
    let unit = |x: f32| Aabb { min: Vec3::new(x, 0.0, 0.0), max: Vec3::new(x + 1.0, 1.0, 1.0) };
    let row: Vec<Aabb> = (0..100).map(|k| unit(k as f32)).collect();
    every_phase_keeps_the_contract(&row);
    assert_eq!(list(&mut BruteForce, &row, Par::Serial).len(), 99);
    let gaps: Vec<Aabb> =
        row.iter().map(|b| Aabb { max: b.max.map(f32::next_down), ..*b }).collect();
    every_phase_keeps_the_contract(&gaps);
    assert!(list(&mut BruteForce, &gaps, Par::Serial).is_empty());
}

#[test]
fn boxes_without_extent_are_points_that_may_coincide() {
    let point = |k: u32| boxed(Vec3::new((k % 5) as f32, (k % 3) as f32, -0.0), Vec3::ZERO);
    let aabbs: Vec<Aabb> = (0..90).map(point).collect();
    every_phase_keeps_the_contract(&aabbs);
    assert_eq!(list(&mut WideTree::default(), &aabbs, Par::Serial).len(), 15 * (6 * 5 / 2));
}

#[test]
fn huge_coordinates_lose_no_pair() {
    let place = |k: i32| Vec3::new(k as f32, (k % 7) as f32, (k % 3) as f32) * 1e30;
    let mut aabbs: Vec<Aabb> = (-50..50).map(|k| boxed(place(k), Vec3::splat(1.5e30))).collect();
    aabbs.extend((0..50).map(|k| boxed(Vec3::X * k as f32, Vec3::ONE)));
    aabbs.push(boxed(Vec3::ZERO, Vec3::splat(f32::MAX)));
    every_phase_keeps_the_contract(&aabbs);
}

#[test]
fn one_slab_as_large_as_the_scene_loses_no_pair() {
    let mut aabbs = paper_boxes(600);
    aabbs.push(boxed(Vec3::ZERO, Vec3::new(100.0, 100.0, 0.5)));
    every_phase_keeps_the_contract(&aabbs);
}

#[test]
fn the_same_bytes_at_any_thread_count() {
    let aabbs = paper_boxes(1000);
    same_at_any_thread_count(BruteForce::default, &aabbs);
    same_at_any_thread_count(SweepAndPrune::default, &aabbs);
    same_at_any_thread_count(WideTree::default, &aabbs);
    same_at_any_thread_count(TreePairs::<PaperTree>::default, &aabbs);
    same_at_any_thread_count(TreePairs::paper_as_written, &aabbs);
    same_at_any_thread_count(TreePairs::paper_as_coded, &aabbs);
}

/// Compares the segments too: tasks that are cut from them must not depend on the schedule.
fn same_at_any_thread_count<B: BroadPhase>(fresh: impl Fn() -> B + Sync, aabbs: &[Aabb]) {
    let segments = |par| {
        let (mut phase, mut out, exec) = (fresh(), Segments::default(), Exec::from(par));
        phase.build(aabbs, exec);
        phase.pairs(aabbs, |i, j| (i ^ j) % 11 != 0, exec, &mut out);
        out.iter().map(<[Pair]>::to_vec).collect::<Vec<_>>()
    };
    let serial = segments(Par::Serial);
    for threads in [1, 2, 3, 7] {
        let pooled = with_threads(threads, || segments(Par::Pool)).unwrap();
        assert!(pooled == serial, "{} on {threads} threads", std::any::type_name::<B>());
    }
}

fn paper_boxes(count: usize) -> Vec<Aabb> {
    let scene = SceneSpec::paper().with_objects(count).scene().unwrap();
    (0..scene.len()).map(|i| scene.aabb(i)).collect()
}

#[test]
fn the_boxes_of_other_programs_have_as_many_pairs_as_their_makers_say() {
    for (name, pairs) in [("bounds01", 650), ("bounds03", 7155), ("32006GPUAABBs", 12)] {
        let Some(path) = data::file(&format!("aabbs/{name}.txt")) else {
            println!("skipped {name}: there is no data folder");
            continue;
        };
        let aabbs = load_boxes(&path).unwrap();
        let lists = [
            list(&mut BruteForce, &aabbs, Par::Pool),
            list(&mut SweepAndPrune::default(), &aabbs, Par::Pool),
            list(&mut WideTree::default(), &aabbs, Par::Pool),
            list(&mut TreePairs::new(PaperTree::as_written()), &aabbs, Par::Pool),
            list(&mut TreePairs::new(PaperTree::as_coded()), &aabbs, Par::Pool),
        ];
        for mut list in lists {
            assert_eq!(list.len(), pairs, "{name}");
            list.sort_unstable();
            list.dedup();
            assert_eq!(list.len(), pairs, "{name}");
        }
        if aabbs.len() < 1000 {
            every_phase_keeps_the_contract(&aabbs);
        }
    }
}

/// Boxes on a coarse lattice, so that faces touch and boxes coincide; some much larger.
fn lattice_boxes() -> impl Strategy<Value = Vec<Aabb>> {
    let half = (prop::array::uniform3(0u8..3), 0u32..8).prop_map(|(half, grow)| {
        Vec3::from(half.map(f32::from)) * if grow == 0 { 8.0 } else { 0.5 }
    });
    let aabb = (prop::array::uniform3(-6i8..6), half)
        .prop_map(|(centre, half)| boxed(Vec3::from(centre.map(f32::from)), half));
    prop::collection::vec(aabb, 0..200)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..Default::default() })]

    #[test]
    fn every_phase_keeps_the_contract_on_random_boxes(aabbs in lattice_boxes()) {
        every_phase_keeps_the_contract(&aabbs);
    }
}
