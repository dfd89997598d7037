//! The support of sixteen objects in sixteen directions.

use super::frame::Frame;
use super::lot::{LanesOf, Side};
use super::vector::V3;
use dcd_geom::lanes::{IndexRow, Lanes, Row, WIDTH};

/// What [`supports`] writes on its way; kept, so that it need not be cleared.
#[derive(Clone, Debug, Default)]
pub(super) struct Desk {
    /// For each lane its vertices' values along its direction, sixteen at a time the largest.
    along: [Row; WIDTH],
    /// And the block that each came from.
    block_of: [IndexRow; WIDTH],
}

/// For each lane set in `live`, a farthest rotated vertex of that lane's object along its
/// direction, up to rounding and to the four bits that carry the winner's lane; other lanes are
/// unspecified.
#[inline(always)]
pub(super) fn supports<L: Lanes>(
    l: L,
    frame: &Frame,
    desk: &mut Desk,
    (side, directions): (&Side, V3<L>),
    live: u32,
) -> V3<L> {
    let mut d = [Row::default(); 3];
    directions.store(l, &mut d);
    for k in LanesOf(live) {
        let d = V3::<L>(l.splat(d[0].0[k]), l.splat(d[1].0[k]), l.splat(d[2].0[k]));
        let Some((head, tail)) = frame.blocks(side, k).split_first() else { continue };
        let mut best = V3::load(l, &head.0).dot(l, d);
        if !tail.is_empty() {
            let mut block_of = l.splat_u(0);
            let mut number = 0;
            for block in tail {
                number += 1;
                let value = V3::load(l, &block.0).dot(l, d);
                block_of = l.select_u(l.lt(best, value), l.splat_u(number), block_of);
                best = l.max(value, best);
            }
            l.store_u(block_of, &mut desk.block_of[k]);
        }
        l.store(l.tag(best), &mut desk.along[k]);
    }
    let mut winner = Row::default();
    l.store(l.largest_of_each(&desk.along), &mut winner);

    let mut points = [Row::default(); 3];
    for k in LanesOf(live) {
        let blocks = frame.blocks(side, k);
        let lane = (winner.0[k].to_bits() & 15) as usize;
        let number = if blocks.len() > 1 { desk.block_of[k].0[lane] as usize } else { 0 };
        if let Some(block) = blocks.get(number) {
            points[0].0[k] = block.0[0].0[lane];
            points[1].0[k] = block.0[1].0[lane];
            points[2].0[k] = block.0[2].0[lane];
        }
    }
    V3::load(l, &points)
}
