//! Vectors of sixteen lanes as the search for depths computes with them: nothing is fused, so that every path gives the same bits.

use dcd_geom::glam::Vec3;
use dcd_simd::{Block, Lanes};

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

/// A block's number sixteen times, as bits: no arithmetic is done on them.
#[inline(always)]
pub(super) fn bits<L: Lanes>(l: L, number: usize) -> L::F {
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
