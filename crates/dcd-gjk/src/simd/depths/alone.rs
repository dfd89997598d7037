//! The depth of one pair that is of no slice: the same search, and what a slice has prepared is prepared for it alone.

use super::super::cores::Core;
use super::super::prepare::Rotation;
use super::confirm::{BLOCKS, Ended, SearchedPair, Side};
use super::search::{DepthSearch, Next};
use super::start::extremes;
use super::surface::Surface;
use crate::query::FoundDepth;
use crate::{Accuracy, PosedShape};
use dcd_geom::Shape;
use dcd_simd::{Block, Kernel, Lanes, Unfused, WIDTH, dispatch};

/// The search of single pairs, and what a thread reuses from one to the next.
#[derive(Debug, Default)]
pub(crate) struct SearchAlone {
    surface: Surface,
    /// The vertices of a and of b, in the world's axes.
    blocks: [Vec<Block>; 2],
}

impl SearchAlone {
    /// How deep two shapes overlap, from a to b, known as well as the accuracy requires; `None` of shapes that are not searched in
    /// lanes, and where that finds no bound as good.
    ///
    /// (a, b) and (b, a) give the same bits, mirrored, and so does every path.
    pub(crate) fn depth(
        &mut self,
        accuracy: Accuracy,
        sides: [PosedShape<'_>; 2],
    ) -> Option<FoundDepth> {
        let are_polytopes = sides.iter().all(|side| side.shape.as_polytope().is_some());
        // Rims are known to f32 alone: nothing need be turned to see it.
        if accuracy != Accuracy::F32 && !are_polytopes {
            return None;
        }
        let Self { surface, blocks } = self;
        dispatch(Unfused(Search { accuracy, sides, surface, blocks }))
    }
}

struct Search<'a> {
    accuracy: Accuracy,
    sides: [PosedShape<'a>; 2],
    surface: &'a mut Surface,
    blocks: &'a mut [Vec<Block>; 2],
}

impl Kernel for Search<'_> {
    type Output = Option<FoundDepth>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Option<FoundDepth> {
        let Self { accuracy, sides: [a, b], surface, blocks: [of_a, of_b] } = self;
        let (core_a, core_b) = (prepared(l, a, of_a)?, prepared(l, b, of_b)?);
        let sides = [
            Side { core: &core_a, blocks: of_a, placed: a },
            Side { core: &core_b, blocks: of_b, placed: b },
        ];
        let pair = SearchedPair::of(sides, accuracy)?;
        let mut search = DepthSearch::new(&pair.cloud, pair.sharpened(accuracy));
        let [points_a, points_b] = &pair.cloud.points;
        let extremes = [&extremes(l, points_a), &extremes(l, points_b)];
        search.start(l, &pair.cloud, extremes, surface);
        loop {
            let farthest = search.support(l, &pair.cloud);
            match search.take(l, farthest, surface) {
                Next::Support => {}
                Next::Ended { nearest, reach } => {
                    return pair.depth(l, accuracy, &Ended { surface, nearest, reach, farthest });
                }
                Next::Failed => return None,
            }
        }
    }
}

/// The core of a polytope, cylinder or cone, and its vertices in the world's axes.
#[inline(always)]
fn prepared<L: Lanes>(l: L, side: PosedShape<'_>, blocks: &mut Vec<Block>) -> Option<Core> {
    blocks.clear();
    match side.shape {
        Shape::Polytope(polytope) => {
            let vertices = polytope.vertices();
            if vertices.len() > BLOCKS * WIDTH {
                return None;
            }
            let core = Core::of_polytope(polytope);
            match polytope.vertex_blocks() {
                [] => blocks.extend(Block::relative(vertices, core.centre)),
                known => blocks.extend_from_slice(known),
            }
            let rotation = Rotation::of(l, side.pose);
            for block in blocks {
                let own = *block;
                rotation.turn(l, &own, block);
            }
            Some(core)
        }
        // Its rims are known without vertices.
        Shape::Curved(curved) => Some(Core { outer: curved.reach(), ..Core::default() }),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
