//! What the benches are fed with, made outside of every timer.

#![allow(dead_code)] // each bench takes what it needs

use dcd_broad::{BroadPhase, WideTree};
use dcd_exec::{Par, Segments};
use dcd_geom::{Aabb, Pair, Scene};
use dcd_scenes::SceneSpec;

/// Dense enough for the paper's share of contacts, small enough for a few milliseconds a stage.
pub(crate) fn scene() -> Scene {
    SceneSpec::paper().with_objects(2_000).scene().expect("a drawn scene is in range")
}

/// The AABB of each object.
pub(crate) fn aabbs(scene: &Scene) -> Vec<Aabb> {
    (0..scene.len()).map(|i| scene.aabb(i)).collect()
}

/// The pairs of overlapping AABBs, in the order of the default pipeline.
pub(crate) fn candidates(scene: &Scene) -> Vec<Pair> {
    let aabbs = aabbs(scene);
    let mut tree = WideTree::default();
    tree.build(&aabbs, Par::Serial.into());
    let mut pairs = Segments::default();
    tree.pairs(&aabbs, |_, _| true, Par::Serial.into(), &mut pairs);
    pairs.iter().flatten().copied().collect()
}
