//! Swept pairs whose cores are apart, so that only their radii overlap: the nearest vertices of the cores sixteen pairs at a
//! time in f32, and f64 from there.

use super::super::nearest_points::{self, Found};
use super::super::scene_pairs::ScenePairs;
use super::WriteDepth;
use crate::expanding::depth_of_apart;
use crate::query::FoundDepth;
use crate::{Accuracy, PosedShape, PosedSupport};
use dcd_geom::Pair;
use dcd_simd::Path;

/// The pairs of which that is thought, and what a thread reuses from slice to slice.
#[derive(Debug, Default)]
pub(super) struct ApartCores {
    /// Their numbers among those that touch.
    numbers: Vec<u32>,
    pairs: Vec<Pair>,
    nearest: nearest_points::Scratch,
}

impl ApartCores {
    /// The list of their numbers, empty.
    pub(super) fn begin(&mut self) -> &mut Vec<u32> {
        self.numbers.clear();
        &mut self.numbers
    }

    /// Answers those that are listed; without a depth where the cores are not apart.
    pub(super) fn answer(
        &mut self,
        path: Path,
        objects: ScenePairs<'_>,
        accuracy: Accuracy,
        answers: &mut dyn WriteDepth,
    ) {
        let Self { numbers, pairs, nearest } = self;
        pairs.clear();
        pairs.extend(numbers.iter().map(|&number| objects.pairs[number as usize]));
        // Within the radii: none is beyond.
        nearest_points::find(path, objects.frames, (pairs, 0.0), nearest);
        for ((&number, &pair), found) in numbers.iter().zip(&*pairs).zip(&nearest.found) {
            let sides = objects.posed(pair);
            let depth = depth_of(found, accuracy, sides);
            answers.write(number as usize, depth.as_ref());
        }
    }
}

fn depth_of(found: &Found, accuracy: Accuracy, [a, b]: [PosedShape<'_>; 2]) -> Option<FoundDepth> {
    let Found::Nearest(points) = found else { return None };
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    let sides = [PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose)];
    depth_of_apart(accuracy, sides, points.corners_of([in_a, in_b]))
}
