//! The contracts of this crate's traits, as tests that any backend can call.

use crate::{BoundingTree, BuildTree, Node, NodeContent};
use dcd_exec::Par;
use dcd_geom::Aabb;
pub use dcd_geom::contract::Violation;
use std::collections::HashSet;

/// Tests the contract of [`BuildTree`] on these AABBs: the tree keeps the contract of [`BoundingTree`], is
/// the same on the pool, and the same in the memory of a tree over other AABBs.
///
/// # Errors
/// The first breach.
pub fn tree<B: BuildTree>(builder: &B, aabbs: &[Aabb]) -> Result<(), Violation> {
    let mut used = B::Tree::default();
    validate(&used, &[]).map_err(within("the default tree"))?;
    let mut serial = B::Tree::default();
    builder.build(aabbs, Par::Serial.into(), &mut serial);
    validate(&serial, aabbs)?;
    let expected = listing(&serial);

    let mut pooled = B::Tree::default();
    builder.build(aabbs, Par::Pool.into(), &mut pooled);
    validate(&pooled, aabbs).map_err(within("on the pool"))?;
    if listing(&pooled) != expected {
        return Err(Violation("the tree that is made on the pool is another one".into()));
    }

    for others in [&aabbs[..aabbs.len().div_ceil(2)], &[], aabbs] {
        builder.build(others, Par::Serial.into(), &mut used);
        validate(&used, others).map_err(within("in used memory"))?;
    }
    if listing(&used) != expected {
        return Err(Violation("the tree that is made in used memory is another one".into()));
    }
    Ok(())
}

/// Tests the contract of [`BoundingTree`] on a tree over these AABBs.
///
/// # Errors
/// The first breach.
pub fn validate(tree: &impl BoundingTree, aabbs: &[Aabb]) -> Result<(), Violation> {
    let mut reached = vec![false; aabbs.len()];
    let mut numbers = HashSet::new();
    // Nodes to look at, with what all nodes above them have in common: an AABB below must be in it.
    let everything = Aabb { min: Aabb::EMPTY.max, max: Aabb::EMPTY.min };
    let mut stack: Vec<(u32, Aabb)> =
        tree.root().map(|root| (root, everything)).into_iter().collect();
    while let Some((number, above)) = stack.pop() {
        if !numbers.insert(number) {
            return Err(Violation(format!("node {number} is reached in two ways")));
        }
        let Node { aabb, below } = tree.node(number);
        let common = Aabb { min: above.min.max(aabb.min), max: above.max.min(aabb.max) };
        match below {
            NodeContent::Nodes([]) | NodeContent::Boxes([]) => {
                return Err(Violation(format!("nothing is below node {number}")));
            }
            NodeContent::Nodes(children) => {
                stack.extend(children.iter().map(|&child| (child, common)))
            }
            NodeContent::Boxes(boxes) => {
                for &index in boxes {
                    reach(index, &mut reached)?;
                    let aabb = aabbs[index as usize];
                    if !common.contains(&aabb) {
                        return Err(Violation(format!(
                            "box {index}, {aabb:?}, sticks out of node {number} or one above it, \
                             which share {common:?}"
                        )));
                    }
                }
            }
        }
    }
    match reached.iter().position(|&reached| !reached) {
        Some(index) => Err(Violation(format!("box {index} is in no leaf"))),
        None => Ok(()),
    }
}

fn reach(index: u32, reached: &mut [bool]) -> Result<(), Violation> {
    match reached.get_mut(index as usize) {
        None => Err(Violation(format!("a leaf names box {index} of {}", reached.len()))),
        Some(true) => Err(Violation(format!("box {index} is in two leaves"))),
        Some(reached) => {
            *reached = true;
            Ok(())
        }
    }
}

fn within(place: &str) -> impl Fn(Violation) -> Violation {
    move |Violation(breach)| Violation(format!("{place}: {breach}"))
}

/// A node without its number: how many nodes are below it, and which AABBs.
type Listed = (Aabb, usize, Vec<u32>);

/// The nodes of a valid tree, depth first.
fn listing(tree: &impl BoundingTree) -> Vec<Listed> {
    let mut nodes = Vec::new();
    let mut stack: Vec<u32> = tree.root().into_iter().collect();
    while let Some(number) = stack.pop() {
        let Node { aabb, below } = tree.node(number);
        match below {
            NodeContent::Nodes(children) => {
                nodes.push((aabb, children.len(), Vec::new()));
                stack.extend(children.iter().rev());
            }
            NodeContent::Boxes(boxes) => nodes.push((aabb, 0, boxes.to_vec())),
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_exec::Exec;
    use glam::Vec3;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Nodes by hand: an AABB, children, AABBs.
    struct ByHand(Vec<(Aabb, &'static [u32], &'static [u32])>);

    impl BoundingTree for ByHand {
        fn root(&self) -> Option<u32> {
            (!self.0.is_empty()).then_some(0)
        }
        fn node(&self, number: u32) -> Node<'_> {
            let (aabb, children, boxes) = self.0[number as usize];
            let below = if boxes.is_empty() {
                NodeContent::Nodes(children)
            } else {
                NodeContent::Boxes(boxes)
            };
            Node { aabb, below }
        }
    }

    fn span(min: f32, max: f32) -> Aabb {
        Aabb { min: Vec3::splat(min), max: Vec3::splat(max) }
    }

    #[test]
    fn each_breach_of_the_tree_contract_is_caught() {
        let aabbs = [span(0.0, 1.0), span(2.0, 3.0)];
        let all = span(0.0, 3.0);
        let good = ByHand(vec![(all, &[1, 2], &[]), (aabbs[0], &[], &[0]), (aabbs[1], &[], &[1])]);
        validate(&good, &aabbs).unwrap();
        let breaches: [(&str, ByHand); 7] = [
            ("in no leaf", ByHand(vec![])),
            ("in no leaf", ByHand(vec![(all, &[], &[1])])),
            ("two leaves", ByHand(vec![(all, &[], &[0, 1, 0])])),
            ("box 2 of 2", ByHand(vec![(all, &[], &[0, 1, 2])])),
            ("two ways", ByHand(vec![(all, &[1, 1], &[]), (all, &[], &[0, 1])])),
            ("nothing is below", ByHand(vec![(all, &[], &[])])),
            ("sticks out", ByHand(vec![(span(0.0, 2.5), &[1], &[]), (all, &[], &[0, 1])])),
        ];
        for (words, tree) in breaches {
            let Violation(breach) = validate(&tree, &aabbs).unwrap_err();
            assert!(breach.contains(words), "{breach}");
        }
    }

    /// One leaf of all AABBs, in another order each time.
    #[derive(Default)]
    struct Restless(AtomicUsize);

    #[derive(Default)]
    struct OneLeaf(Vec<u32>);

    impl BoundingTree for OneLeaf {
        fn root(&self) -> Option<u32> {
            (!self.0.is_empty()).then_some(0)
        }
        fn node(&self, _: u32) -> Node<'_> {
            Node { aabb: span(f32::MIN, f32::MAX), below: NodeContent::Boxes(&self.0) }
        }
    }

    impl BuildTree for Restless {
        type Tree = OneLeaf;
        fn build(&self, aabbs: &[Aabb], _: Exec, tree: &mut OneLeaf) {
            let turns = self.0.fetch_add(1, Ordering::Relaxed);
            tree.0 = (0..aabbs.len() as u32).collect();
            tree.0.rotate_left(turns.min(aabbs.len()));
        }
    }

    #[test]
    fn a_builder_that_makes_another_tree_each_time_is_caught() {
        let Violation(breach) = tree(&Restless::default(), &[span(0.0, 1.0); 9]).unwrap_err();
        assert!(breach.contains("another one"), "{breach}");
        tree(&Restless::default(), &[span(0.0, 1.0)]).unwrap();
    }
}
