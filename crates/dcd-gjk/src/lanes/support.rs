//! The support of sixteen objects in sixteen directions.

use super::frame::Frame;
use super::lot::LanesOf;
use super::vector::V3;
use dcd_geom::lanes::{IndexRow, Lanes, Row, WIDTH};

/// For each lane set in `live`, a farthest rotated vertex of object k of `objects` along direction
/// k, up to rounding and to the four bits that carry the winner's lane; other lanes are 0.
#[inline(always)]
pub(super) fn supports<L: Lanes>(
    l: L,
    frame: &Frame,
    objects: &[u32; WIDTH],
    directions: V3<L>,
    live: u32,
) -> V3<L> {
    let mut rows = [Row::default(); 3];
    directions.store(l, &mut rows);
    let mut along = [l.splat(0.0); WIDTH];
    let mut winners = [IndexRow::default(); WIDTH];
    for k in LanesOf(live) {
        let blocks = frame.blocks(frame.record(objects[k]));
        let d = V3::<L>(l.splat(rows[0].0[k]), l.splat(rows[1].0[k]), l.splat(rows[2].0[k]));
        let Some((head, tail)) = blocks.split_first() else { continue };
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
            l.store_u(block_of, &mut winners[k]);
        }
        along[k] = l.tag(best);
    }
    let mut winner = Row::default();
    l.store(l.largest_of_each(&along), &mut winner);

    let mut points = [Row::default(); 3];
    for k in LanesOf(live) {
        let blocks = frame.blocks(frame.record(objects[k]));
        let lane = (winner.0[k].to_bits() & 15) as usize;
        let number = if blocks.len() > 1 { winners[k].0[lane] as usize } else { 0 };
        if let Some(block) = blocks.get(number) {
            points[0].0[k] = block.0[0].0[lane];
            points[1].0[k] = block.0[1].0[lane];
            points[2].0[k] = block.0[2].0[lane];
        }
    }
    V3::load(l, &points)
}
