//! Trees that nobody here made: of many children, of one child, and deeper than any stack.

use dcd_broad::{LeafPairs, Traversal, TreePairs, Visits, contract};
use dcd_bvh::{BoundingTree, BuildTree, Node, NodeContent};
use dcd_exec::Exec;
use dcd_geom::Aabb;
use glam::Vec3;

/// Nodes in any shape: a box, and numbers of nodes or of boxes.
#[derive(Default)]
struct Nodes(Vec<(Aabb, Vec<u32>, Vec<u32>)>);

impl BoundingTree for Nodes {
    fn root(&self) -> Option<u32> {
        (!self.0.is_empty()).then_some(0)
    }
    fn node(&self, number: u32) -> Node<'_> {
        let (aabb, children, boxes) = &self.0[number as usize];
        let below =
            if boxes.is_empty() { NodeContent::Nodes(children) } else { NodeContent::Boxes(boxes) };
        Node { aabb: *aabb, below }
    }
}

/// Cuts the list of boxes in `ways` parts, and each of them again, down to leaves of three; with
/// one way, puts a node round one node and cuts that in two.
struct Ways(usize);

impl Ways {
    fn subtree(&self, aabbs: &[Aabb], boxes: Vec<u32>, nodes: &mut Nodes) -> u32 {
        let number = nodes.0.len();
        let whole = |aabb: Aabb, &i: &u32| aabb.union(&aabbs[i as usize]);
        nodes.0.push((boxes.iter().fold(Aabb::EMPTY, whole), vec![], vec![]));
        if boxes.len() <= 3 {
            nodes.0[number].2 = boxes;
            return number as u32;
        }
        let parts = if self.0 == 1 && number.is_multiple_of(2) { 1 } else { self.0.max(2) };
        let parts = boxes.chunks(boxes.len().div_ceil(parts));
        nodes.0[number].1 = parts.map(|part| self.subtree(aabbs, part.to_vec(), nodes)).collect();
        number as u32
    }
}

impl BuildTree for Ways {
    type Tree = Nodes;
    fn build(&self, aabbs: &[Aabb], _: Exec, tree: &mut Nodes) {
        tree.0.clear();
        if !aabbs.is_empty() {
            self.subtree(aabbs, (0..aabbs.len() as u32).collect(), tree);
        }
    }
}

/// Each node has one box on its left and all later ones on its right: as deep as there are boxes.
struct Chain;

impl BuildTree for Chain {
    type Tree = Nodes;
    fn build(&self, aabbs: &[Aabb], _: Exec, tree: &mut Nodes) {
        let count = aabbs.len();
        tree.0.clear();
        tree.0.resize(2 * count, Default::default());
        let mut rest = Aabb::EMPTY;
        for (k, aabb) in aabbs.iter().enumerate().rev() {
            rest = rest.union(aabb);
            let children = [count + k, k + 1].map(|number| number as u32);
            let below = if k + 1 < count { &children[..] } else { &children[..1] };
            tree.0[k] = (rest, below.to_vec(), vec![]);
            tree.0[count + k] = (*aabb, vec![], vec![k as u32]);
        }
    }
}

fn row(count: usize) -> Vec<Aabb> {
    let corner = |k: usize| Vec3::X * k as f32;
    (0..count).map(|k| Aabb { min: corner(k), max: corner(k) + Vec3::new(1.5, 1.0, 1.0) }).collect()
}

#[test]
fn the_contract_holds_over_trees_of_any_number_of_children() {
    let aabbs = row(500);
    for ways in [1, 2, 3, 8, 16] {
        dcd_bvh::contract::tree(&Ways(ways), &aabbs).unwrap();
        for visits in [Visits::Once, Visits::Twice] {
            for leaf_pairs in [LeafPairs::Tested, LeafPairs::Untested] {
                let traversal = Traversal { max_depth: 4, visits, leaf_pairs };
                let mut phase = TreePairs::new(Ways(ways)).with(traversal);
                let surplus = contract::broad_phase(&mut phase, &aabbs).unwrap();
                assert_eq!(surplus > 0, leaf_pairs == LeafPairs::Untested);
            }
        }
    }
}

#[test]
fn a_tree_as_deep_as_there_are_boxes_overflows_no_stack() {
    let aabbs = row(20_000);
    dcd_bvh::contract::tree(&Chain, &aabbs).unwrap();
    let traversal = Traversal { max_depth: u32::MAX, ..Traversal::default() };
    let mut phase = TreePairs::new(Chain).with(traversal);
    assert_eq!(contract::broad_phase(&mut phase, &aabbs), Ok(0));
}
