//! Along which of the fifteen axes two cuboids that touch may overlap the least: sixteen pairs at a time, in f32.
//!
//! An axis is left out where it surely overlaps more than another; f64 measures along the others
//! (docs/numerics/proofs.md, "cuboids in lanes").

use super::super::bounds::U;
use super::super::frame::FramePair;
use super::nearest_features::GAP;
use super::projections::Projections;
use super::{CuboidPairs, Order, in_range};
use crate::closed::Axes;
use dcd_geom::Pair;
use dcd_simd::{Kernel, Lanes, Path, Row, WIDTH, dispatch_on};

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Scratch {
    packet: CuboidPairs,
    /// The pairs to look at.
    pub(in super::super) pairs: Vec<Pair>,
    /// For each pair the axes that may be the least.
    pub(in super::super) axes: Vec<Axes>,
}

/// Looks at all pairs of the scratch, which are of cuboids.
pub(in super::super) fn find(path: Path, frames: FramePair<'_>, scratch: &mut Scratch) {
    let Scratch { packet, pairs, axes } = scratch;
    axes.clear();
    axes.resize(pairs.len(), Axes::ALL);
    dispatch_on(path, CuboidDepths { frames, packet, pairs, axes });
}

struct CuboidDepths<'a> {
    frames: FramePair<'a>,
    packet: &'a mut CuboidPairs,
    pairs: &'a [Pair],
    axes: &'a mut [Axes],
}

impl Kernel for CuboidDepths<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { frames, packet, pairs, axes } = self;
        for (pairs, axes) in pairs.chunks(WIDTH).zip(axes.chunks_mut(WIDTH)) {
            packet.read(frames, pairs, Order::AsGiven);
            let mut row = Row::default();
            let live = least_axes(l, packet, &mut row);
            for (lane, axes) in axes.iter_mut().enumerate() {
                if live >> lane & 1 == 1 {
                    *axes = Axes(row.0[lane] as u16);
                }
            }
        }
    }
}

/// Writes the axes as a number: one bit each, in the order of [`Axes`]. Returns the lanes for which that is known.
#[inline(always)]
fn least_axes<L: Lanes>(l: L, packet: &CuboidPairs, row: &mut Row) -> u32 {
    let (a, b, between, size) = packet.load(l);
    let error = l.mul(size, l.splat(GAP * U));
    let projections = Projections::of(l, [&a, &b], between);
    let mut lower = [l.splat(0.0); 15];
    let mut least = l.splat(f32::INFINITY);
    for k in 0..3 {
        let overlap = projections.of_a(l, k).overlap(l);
        lower[k] = l.sub(overlap, error);
        least = l.min(least, l.add(overlap, error));
        let overlap = projections.of_b(l, k).overlap(l);
        lower[3 + k] = l.sub(overlap, error);
        least = l.min(least, l.add(overlap, error));
    }
    for j in 0..3 {
        for k in 0..3 {
            let (product, squared) = projections.of_product(l, j, k);
            let overlap = product.overlap(l);
            let scale = l.div(l.splat(1.0), l.sqrt(squared));
            // Of parallel edges neither is a number, and no comparison holds.
            lower[6 + 3 * j + k] = l.mul(l.sub(overlap, error), scale);
            let upper = l.mul(l.add(overlap, error), scale);
            least = l.select(l.lt(upper, least), upper, least);
        }
    }
    let mut axes = l.splat(0.0);
    for (number, lower) in lower.iter().enumerate() {
        let is_more = l.lt(least, *lower);
        let bit = l.select(is_more, l.splat(0.0), l.splat((1u32 << number) as f32));
        axes = l.add(axes, bit);
    }
    l.store(axes, row);
    in_range(l, size)
}
