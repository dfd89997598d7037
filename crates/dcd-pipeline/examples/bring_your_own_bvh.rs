//! A tree of one's own behind the broad phase's trait: one node over all boxes.

use dcd_broad::TreePairs;
use dcd_bvh::{BoundingTree, BuildTree, Node, NodeContent};
use dcd_pipeline::geom::{Aabb, glam::DVec3};
use dcd_pipeline::{Exec, Overlap, Par, Pipeline, Pose, Scene, Shape};

struct OneNode;

#[derive(Default)]
struct Tree(Aabb, Vec<u32>);

impl BuildTree for OneNode {
    type Tree = Tree;
    fn build(&self, aabbs: &[Aabb], _: Exec, tree: &mut Tree) {
        tree.0 = aabbs.iter().fold(Aabb::EMPTY, |all, aabb| all.union(aabb));
        tree.1 = (0..).take(aabbs.len()).collect();
    }
}

impl BoundingTree for Tree {
    fn root(&self) -> Option<u32> {
        (!self.1.is_empty()).then_some(0)
    }
    fn node(&self, _: u32) -> Node<'_> {
        Node { aabb: self.0, below: NodeContent::Boxes(&self.1) }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let at = |k: u32| Pose::from_translation(DVec3::X * f64::from(k) * 0.9);
    let poses = (0..10).map(at).collect::<Result<_, _>>()?;
    let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 10], poses)?;
    let mut mine = Pipeline::with(TreePairs::new(OneNode), Overlap::default());
    assert_eq!(mine.step(&scene, Par::Serial).contact_count(), 9);
    dcd_bvh::contract::tree(&OneNode, mine.step(&scene, Par::Serial).aabbs())?;
    Ok(())
}
