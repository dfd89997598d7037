//! Vectors of sixteen lanes as the search for depths computes with them: nothing is fused, so that every path gives the same bits.

use dcd_geom::glam::Vec3;
use dcd_simd::{Block, Lanes, Row, WIDTH};

/// Sixteen points.
#[inline(always)]
pub(super) fn load<L: Lanes>(l: L, Block([x, y, z]): &Block) -> [L::F; 3] {
    [l.load(x), l.load(y), l.load(z)]
}

/// The same point sixteen times.
#[inline(always)]
pub(super) fn splat<L: Lanes>(l: L, Vec3 { x, y, z }: Vec3) -> [L::F; 3] {
    [l.splat(x), l.splat(y), l.splat(z)]
}

/// The vertex of that number; not a number where there is none.
#[inline(always)]
pub(in crate::simd) fn vertex(blocks: &[Block], number: usize) -> Vec3 {
    blocks.get(number / WIDTH).map_or(Vec3::NAN, |block| block.point(number % WIDTH))
}

/// How far vertices are in some direction.
pub(super) trait Heights<L: Lanes> {
    /// Those of a block.
    fn of(&self, l: L, block: &Block) -> L::F;
}

/// Along this vector.
impl<L: Lanes> Heights<L> for [L::F; 3] {
    #[inline(always)]
    fn of(&self, l: L, block: &Block) -> L::F {
        dot(l, load(l, block), *self)
    }
}

/// Along an axis, or against it.
pub(super) enum Axis {
    Along(usize),
    Against(usize),
}

impl<L: Lanes> Heights<L> for Axis {
    #[inline(always)]
    fn of(&self, l: L, Block(rows): &Block) -> L::F {
        match *self {
            Self::Along(axis) => l.load(&rows[axis]),
            Self::Against(axis) => l.neg(l.load(&rows[axis])),
        }
    }
}

/// The number of the vertex that is farthest; among equals the first of the first lane that has one.
#[inline(always)]
pub(super) fn farthest<L: Lanes>(l: L, blocks: &[Block], heights: &impl Heights<L>) -> usize {
    let Some(first) = blocks.first() else { return 0 };
    // Most hulls have one block or two, and which is not predicted: of one the first is looked at again.
    let second = usize::from(blocks.len() > 1);
    let (one, other) = (heights.of(l, first), heights.of(l, &blocks[second]));
    let mut best = l.max(one, other);
    if blocks.len() <= 2 {
        let top = l.splat(l.largest(best));
        let (of_one, of_other) = (l.bits(l.le(top, one)), l.bits(l.le(top, other)));
        let lane = (of_one | of_other).trailing_zeros() as usize % WIDTH;
        let block = usize::from(of_one >> lane & 1 == 0);
        return block * WIDTH + lane;
    }
    let mut of_block = l.select(l.lt(one, other), bits(l, 1), bits(l, 0));
    for (number, block) in (2..).zip(&blocks[2..]) {
        let height = heights.of(l, block);
        of_block = l.select(l.lt(best, height), bits(l, number), of_block);
        best = l.max(best, height);
    }
    let top = l.splat(l.largest(best));
    let lane = l.bits(l.le(top, best)).trailing_zeros() as usize % WIDTH;
    let mut numbers = Row([0.0; WIDTH]);
    l.store(of_block, &mut numbers);
    (numbers.0[lane].to_bits() as usize).min(blocks.len() - 1) * WIDTH + lane
}

/// A block's number sixteen times, as bits: no arithmetic is done on them.
#[inline(always)]
fn bits<L: Lanes>(l: L, number: usize) -> L::F {
    l.splat(f32::from_bits(number as u32))
}

/// Not fused.
#[inline(always)]
pub(super) fn dot<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> L::F {
    l.add(l.add(l.mul(a[0], b[0]), l.mul(a[1], b[1])), l.mul(a[2], b[2]))
}

/// `yes` where the mask is set, else `no`.
#[inline(always)]
pub(super) fn select<L: Lanes>(l: L, mask: L::M, yes: [L::F; 3], no: [L::F; 3]) -> [L::F; 3] {
    [l.select(mask, yes[0], no[0]), l.select(mask, yes[1], no[1]), l.select(mask, yes[2], no[2])]
}

#[inline(always)]
pub(super) fn sub<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [l.sub(a[0], b[0]), l.sub(a[1], b[1]), l.sub(a[2], b[2])]
}

/// Not fused.
#[inline(always)]
pub(super) fn cross<L: Lanes>(l: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [
        l.sub(l.mul(a[1], b[2]), l.mul(a[2], b[1])),
        l.sub(l.mul(a[2], b[0]), l.mul(a[0], b[2])),
        l.sub(l.mul(a[0], b[1]), l.mul(a[1], b[0])),
    ]
}

#[inline(always)]
pub(super) fn norm1<L: Lanes>(l: L, a: [L::F; 3]) -> L::F {
    l.add(l.add(l.abs(a[0]), l.abs(a[1])), l.abs(a[2]))
}

/// The numbers of the set bits, from the lowest.
pub(super) struct Bits(pub(super) u64);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let bit = self.0.trailing_zeros() as usize % u64::BITS as usize;
        self.0 &= self.0 - 1;
        Some(bit)
    }
}
