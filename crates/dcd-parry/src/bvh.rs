//! Parry's tree as a broad phase.

use crate::Library;
use crate::library::is_parallel;
use dcd_broad::BroadPhase;
use dcd_exec::{Exec, Segments};
use dcd_geom::{Aabb, Pair};
use parry3d::bounding_volume::Aabb as ParryAabb;

/// How many leaf pairs a task filters.
const PAIRS_PER_TASK: usize = 16 * 1024;

/// Parry's bounding volume hierarchy in f32, built anew by binning and traversed against itself.
#[derive(Default)]
pub struct ParryBvh {
    tree: <f32 as Library>::Tree,
    found: Vec<(u32, u32)>,
}

impl BroadPhase for ParryBvh {
    fn build(&mut self, aabbs: &[Aabb], _: Exec) {
        f32::build(aabbs.iter().map(|aabb| ParryAabb::new(aabb.min, aabb.max)), &mut self.tree);
    }

    fn pairs(
        &mut self,
        _: &[Aabb],
        keep: impl Fn(u32, u32) -> bool + Sync,
        exec: Exec,
        out: &mut Segments<Pair>,
    ) {
        let kept = |(a, b)| Some(Pair::new(a, b)).filter(|pair| keep(pair.i, pair.j));
        if is_parallel(exec) {
            self.found = f32::leaf_pairs_parallel(&self.tree);
            let chunks: Vec<_> = self.found.chunks(PAIRS_PER_TASK).collect();
            out.fill(exec, chunks.len(), |k, out| {
                out.extend(chunks[k].iter().copied().filter_map(kept));
            });
        } else {
            let tree = &mut self.tree;
            out.gather(|filler| {
                let list =
                    |out: &mut Vec<Pair>| f32::leaf_pairs(tree, |a, b| out.extend(kept((a, b))));
                vec![filler.segment(list)]
            });
        }
    }
}
