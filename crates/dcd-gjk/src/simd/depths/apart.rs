//! Swept pairs whose cores are apart, so that only their radii overlap: the nearest vertices of the cores sixteen pairs at a
//! time in f32, and f64 from there.

use super::super::nearest_points::{self, Found, NearestPoints};
use super::super::scene_pairs::ScenePairs;
use super::WriteDepth;
use super::confirm::has_formula;
use crate::expanding::depth_of_apart;
use crate::query::FoundDepth;
use crate::{Accuracy, PosedShape, PosedSupport};
use dcd_geom::Pair;
use dcd_simd::Path;

/// Who thinks that cores are apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Thought {
    /// [`are_cores_apart`](super::searched::are_cores_apart): where the lanes prove no distance, they are searched.
    ByRecords,
    /// The search of their depth, which found none: f64 decides.
    BySearch,
}

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

    /// Answers those that are listed, and calls `others` with the numbers of those that are not known to be apart. `facets` says
    /// whether the faces are read where an answer is written.
    pub(super) fn answer(
        &mut self,
        path: Path,
        (objects, facets): (ScenePairs<'_>, bool),
        (thought, accuracy): (Thought, Accuracy),
        answers: &mut dyn WriteDepth,
        mut others: impl FnMut(&mut dyn WriteDepth, u32),
    ) {
        let Self { numbers, pairs, nearest } = self;
        pairs.clear();
        pairs.extend(numbers.iter().map(|&number| objects.pairs[number as usize]));
        // Within the radii: none is beyond.
        nearest_points::find(path, objects.frames, (pairs, 0.0), nearest);
        let listed = ScenePairs { pairs, ..objects };
        let looks_ahead = !objects.have_few_shapes();
        for (place, (&number, found)) in numbers.iter().zip(&nearest.found).enumerate() {
            if looks_ahead {
                listed.look_ahead(place, facets);
            }
            let pair = listed.pairs[place];
            let depth = match found {
                Found::Nearest(points) if thought == Thought::BySearch || points.lower > 0.0 => {
                    depth_of(points, accuracy, objects.posed(pair))
                }
                _ => None,
            };
            match depth {
                Some(depth) => answers.write(number as usize, Some(&depth)),
                None => others(answers, number),
            }
        }
    }
}

fn depth_of(
    points: &NearestPoints,
    accuracy: Accuracy,
    [a, b]: [PosedShape<'_>; 2],
) -> Option<FoundDepth> {
    let (in_a, in_b) = (a.shape.as_polytope()?, b.shape.as_polytope()?);
    // Rounded cuboids: their records do not show it.
    if has_formula([in_a, in_b], true, accuracy) {
        return None;
    }
    let sides = [PosedSupport::polytope(in_a, a.pose), PosedSupport::polytope(in_b, b.pose)];
    depth_of_apart(accuracy, sides, points.corners_of([in_a, in_b]))
}
