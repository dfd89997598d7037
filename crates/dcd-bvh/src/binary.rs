//! A binary tree in one array.

use crate::{BoundingTree, Node, NodeContent};
use dcd_geom::Aabb;

/// A binary tree over AABBs: a flat array of nodes, and the list of AABBs that its leaves share.
///
/// A node whose AABBs are split at place m of the list has its children at 2m − 1 and 2m. That
/// place is no other node's, so that the array, like the tree, depends on the AABBs alone. Where a
/// leaf has several AABBs, places stay empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BinaryTree {
    nodes: Vec<BinaryNode>,
    indices: Vec<u32>,
}

/// A place of the array: a node, or empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BinaryNode {
    /// Contains all AABBs below; [`Aabb::EMPTY`] in an empty place.
    pub(crate) aabb: Aabb,
    pub(crate) content: Content,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Content {
    /// An inner node: where its children are.
    Nodes([u32; 2]),
    /// A leaf: where its AABBs are in the list. An empty place has none.
    Boxes { first: u32, count: u32 },
}

impl BinaryNode {
    const UNUSED: Self = Self { aabb: Aabb::EMPTY, content: Content::Boxes { first: 0, count: 0 } };
}

impl BinaryTree {
    /// Reserves a tree over so many AABBs: their indices in order, and empty places.
    pub(crate) fn reserve(&mut self, boxes: usize) -> (&mut [u32], &mut [BinaryNode]) {
        self.indices.clear();
        self.indices.extend(0..boxes as u32);
        self.nodes.clear();
        self.nodes.resize((2 * boxes).saturating_sub(1), BinaryNode::UNUSED);
        (&mut self.indices, &mut self.nodes)
    }
}

/// A number that no node has gives a leaf without AABBs that overlaps nothing.
impl BoundingTree for BinaryTree {
    fn root(&self) -> Option<u32> {
        (!self.nodes.is_empty()).then_some(0)
    }

    fn node(&self, number: u32) -> Node<'_> {
        let node = self.nodes.get(number as usize).unwrap_or(&BinaryNode::UNUSED);
        let below = match &node.content {
            Content::Nodes(children) => NodeContent::Nodes(children),
            &Content::Boxes { first, count } => {
                let boxes = first as usize..first as usize + count as usize;
                NodeContent::Boxes(self.indices.get(boxes).unwrap_or_default())
            }
        };
        Node { aabb: node.aabb, below }
    }
}
