//! The support of sixteen objects in sixteen directions.

use super::frame::Frame;
use super::vector::V3;
use dcd_geom::lanes::{IndexRow, Lanes, Row, WIDTH};

/// For each lane set in `live`, a farthest rotated vertex of object k of `objects` along direction
/// k, up to rounding and to the four bits that carry the winner's lane; other lanes are 0.
///
/// The directions are given in memory, since each is spread over a register of its own.
#[inline(always)]
pub(super) fn supports<L: Lanes>(
    l: L,
    frame: &Frame,
    objects: &[u32; WIDTH],
    directions: &[Row; 3],
    live: u32,
) -> [Row; 3] {
    let mut along = [l.splat(0.0); WIDTH];
    let mut winners = [IndexRow::default(); WIDTH];
    for k in lanes_of(live) {
        let blocks = frame.blocks(frame.record(objects[k]));
        let d = V3::<L>(
            l.splat(directions[0].0[k]),
            l.splat(directions[1].0[k]),
            l.splat(directions[2].0[k]),
        );
        let Some((head, tail)) = blocks.split_first() else { continue };
        let mut best = V3::load(l, &head.0).dot(l, d);
        if !tail.is_empty() {
            let mut block_of = l.splat_u(0);
            for (number, block) in (1u32..).zip(tail) {
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
    for k in lanes_of(live) {
        let blocks = frame.blocks(frame.record(objects[k]));
        let lane = (winner.0[k].to_bits() & 15) as usize;
        let number = if blocks.len() > 1 { winners[k].0[lane] as usize } else { 0 };
        if let Some(block) = blocks.get(number) {
            for (row, source) in points.iter_mut().zip(&block.0) {
                row.0[k] = source.0[lane];
            }
        }
    }
    points
}

/// The numbers of the set bits, from the lowest.
#[inline(always)]
pub(super) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = bits.trailing_zeros();
            bits &= bits.wrapping_sub(1);
            (lane < WIDTH as u32).then_some(lane as usize)
        },
    )
}
