//! The paper's tree in both versions, on boxes of every kind.

use dcd_bvh::{
    BinaryTree, BoundingTree, BuildThreshold, BuildTree, NodeContent, PaperTree, contract,
};
use dcd_exec::{Par, with_threads};
use dcd_geom::Aabb;
use glam::Vec3;
use proptest::prelude::*;
use std::num::NonZeroU32;

const PRESETS: [PaperTree; 2] = [PaperTree::as_written(), PaperTree::as_coded()];

fn boxed(centre: Vec3, half: Vec3) -> Aabb {
    Aabb { min: centre - half, max: centre + half }
}

/// Centres that fill [-3, 3]³ evenly: multiples of the powers of the plastic number's sibling in
/// three dimensions, modulo 1 (Roberts 2018).
fn scattered(count: u32) -> Vec<Aabb> {
    let steps =
        glam::DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_3);
    let place = |k: u32| ((steps * f64::from(k)).fract() * 6.0 - 3.0).as_vec3();
    (0..count).map(|k| boxed(place(k), Vec3::splat(0.5))).collect()
}

fn build(builder: &PaperTree, aabbs: &[Aabb]) -> BinaryTree {
    let mut tree = BinaryTree::default();
    builder.build(aabbs, Par::Serial.into(), &mut tree);
    tree
}

/// The depth of the deepest leaf, and the size of the largest.
fn depth_and_largest_leaf(tree: &BinaryTree) -> (u32, usize) {
    let mut stack: Vec<(u32, u32)> = tree.root().map(|root| (root, 0)).into_iter().collect();
    let mut found = (0, 0);
    while let Some((number, depth)) = stack.pop() {
        match tree.node(number).below {
            NodeContent::Nodes(children) => {
                stack.extend(children.iter().map(|&child| (child, depth + 1)))
            }
            NodeContent::Boxes(boxes) => found = (found.0.max(depth), found.1.max(boxes.len())),
        }
    }
    found
}

#[test]
fn the_contract_holds_on_degenerate_boxes() {
    let far = |x: f32| boxed(Vec3::new(x, 0.0, 0.0), Vec3::ONE);
    let families = [
        vec![],
        vec![far(0.0)],
        vec![far(0.0); 100],
        (0..100).map(|k| far(2.0 * k as f32)).collect(),
        (0..100).map(|k| boxed(Vec3::splat(k as f32), Vec3::ZERO)).collect(),
        (0..100).map(|k| far(1e30 * (k as f32 - 50.0))).collect(),
        (0..100).map(|k| far(if k % 2 == 0 { 1.0 } else { 1f32.next_up() })).collect(),
        vec![boxed(Vec3::ZERO, Vec3::splat(f32::MAX)), far(f32::MAX), far(-f32::MAX)],
    ];
    for aabbs in families {
        for preset in PRESETS {
            contract::tree(&preset, &aabbs).unwrap();
        }
    }
}

#[test]
fn the_same_array_at_any_thread_count() {
    let aabbs = scattered(20_000);
    for preset in PRESETS {
        contract::tree(&preset, &aabbs).unwrap();
        let serial = build(&preset, &aabbs);
        for threads in [1, 2, 3, 7] {
            let mut tree = BinaryTree::default();
            with_threads(threads, || preset.build(&aabbs, Par::Pool.into(), &mut tree)).unwrap();
            assert!(tree == serial, "{preset:?} on {threads} threads");
        }
    }
}

#[test]
fn where_work_is_shared_does_not_change_the_tree() {
    let aabbs = scattered(5000);
    for preset in PRESETS {
        let thresholds = [0, 100, usize::MAX].map(BuildThreshold::Objects);
        let trees =
            thresholds.map(|parallel_above| build(&PaperTree { parallel_above, ..preset }, &aabbs));
        assert!(trees.iter().all(|tree| *tree == trees[0]));
    }
}

#[test]
fn a_leaf_is_at_most_the_cutoff_where_centroids_differ() {
    let aabbs = scattered(3000);
    for cutoff in [1, 4, 16, 64, 256, 1024, 3000] {
        let leaf_cutoff = NonZeroU32::new(cutoff).unwrap();
        for preset in PRESETS {
            let tree = build(&PaperTree { leaf_cutoff, ..preset }, &aabbs);
            let (_, largest) = depth_and_largest_leaf(&tree);
            assert!(largest <= cutoff as usize && 4 * largest > cutoff as usize);
        }
    }
}

#[test]
fn equal_centroids_are_one_leaf() {
    let aabbs: Vec<Aabb> = (0..500).map(|k| boxed(Vec3::ONE, Vec3::splat(k as f32))).collect();
    for preset in PRESETS {
        assert_eq!(depth_and_largest_leaf(&build(&preset, &aabbs)), (0, 500));
    }
}

#[test]
fn one_slab_makes_half_of_the_scene_a_leaf_as_coded_and_not_as_written() {
    let mut aabbs = scattered(10_000);
    aabbs.push(boxed(Vec3::ZERO, Vec3::new(100.0, 100.0, 0.5)));
    let (_, as_coded) = depth_and_largest_leaf(&build(&PaperTree::as_coded(), &aabbs));
    let (_, as_written) = depth_and_largest_leaf(&build(&PaperTree::as_written(), &aabbs));
    assert!(as_coded > 4_900, "{as_coded}");
    assert!(as_written <= 4, "{as_written}");
    for preset in PRESETS {
        contract::tree(&preset, &aabbs).unwrap();
    }
}

#[test]
fn no_input_makes_the_tree_deeper_than_128_and_the_logarithm_of_the_boxes() {
    // As written: each halving of a spread over powers of two frees one centroid.
    let powers = (-149..127).flat_map(|k| {
        [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| boxed(axis * 2f64.powi(k) as f32, Vec3::ZERO))
    });
    // As coded: of boxes that begin at 0 the longest alone has its centroid at the middle.
    let nested = (1..20_000).map(|k| Aabb { min: Vec3::ZERO, max: Vec3::X * k as f32 });
    for (preset, aabbs) in PRESETS.into_iter().zip([powers.collect::<Vec<_>>(), nested.collect()]) {
        contract::tree(&preset, &aabbs).unwrap();
        let (depth, largest) = depth_and_largest_leaf(&build(&preset, &aabbs));
        let logarithm = aabbs.len().ilog2() + 1;
        assert!((128..=128 + logarithm).contains(&depth) && largest <= 4, "{depth} {largest}");
    }
}

/// Boxes on a coarse lattice, so that centroids coincide and faces touch, of widely varied size.
fn lattice_boxes() -> impl Strategy<Value = Vec<Aabb>> {
    let aabb = (prop::array::uniform3(-8i8..8), prop::array::uniform3(0u8..3), -60..60i32)
        .prop_map(|(centre, half, exponent)| {
            let scale = if exponent > 30 { 2f32.powi(exponent) } else { 1.0 };
            boxed(Vec3::from(centre.map(f32::from)) * scale, Vec3::from(half.map(f32::from)))
        });
    prop::collection::vec(aabb, 0..300)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn the_contract_holds_on_random_boxes(aabbs in lattice_boxes(), cutoff in 1u32..10) {
        let leaf_cutoff = NonZeroU32::new(cutoff).unwrap();
        for preset in PRESETS {
            prop_assert_eq!(contract::tree(&PaperTree { leaf_cutoff, ..preset }, &aabbs), Ok(()));
        }
    }
}
