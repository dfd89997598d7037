//! Lanes as the bits of a number: which are chosen, and what is written for them.

use super::super::frame::FramePair;
use super::super::packet::{LanesOf, PairPacket};
use dcd_simd::WIDTH;

/// Of these lanes those whose objects are both marked so.
#[inline(always)]
pub(super) fn marked(frames: FramePair<'_>, packet: &PairPacket, lanes: u32, mark: u8) -> u32 {
    let mut marked = 0;
    for lane in LanesOf(lanes) {
        let (a, b) = (frames.a.record(packet.a.0[lane]), frames.b.record(packet.b.0[lane]));
        marked |= u32::from(a.marks & b.marks & mark != 0) << lane;
    }
    marked
}

/// Of these lanes those whose objects are of like size: a box round the larger says little about one that is far smaller. Decides
/// what is tried, never an answer.
pub(super) fn are_alike(frames: FramePair<'_>, packet: &PairPacket, lanes: u32) -> u32 {
    let mut alike = 0;
    for lane in LanesOf(lanes) {
        let [a, b] = [frames.a.record(packet.a.0[lane]), frames.b.record(packet.b.0[lane])];
        let is_one = a.outer < LARGER * b.outer && b.outer < LARGER * a.outer;
        alike |= u32::from(is_one) << lane;
    }
    alike
}

/// See [`are_alike`]. No unit. Larger: boxes of terrains that prove nothing. Smaller: meshes beside small bodies take a search.
const LARGER: f32 = 8.0;

/// The mask of that many lanes.
#[inline(always)]
pub(super) fn used(lanes: usize) -> u32 {
    (1 << lanes) - 1
}

/// Writes which of a group of pairs touch; every entry is written, so that none is a branch.
#[inline(always)]
pub(super) fn mark(touching: &mut [bool], bits: u32) {
    for (lane, touches) in touching.iter_mut().take(WIDTH).enumerate() {
        *touches = bits >> lane & 1 == 1;
    }
}

/// Writes which pairs of a packet touch, without a branch; what was known of the others stays. Out of line: in every
/// stage it would be a tenth of the kernel.
#[inline(never)]
pub(super) fn scatter(touching: &mut [bool], packet: &PairPacket, bits: u32) {
    for lane in 0..WIDTH {
        if let Some(touches) = touching.get_mut(packet.number.0[lane] as usize) {
            *touches |= bits >> lane & 1 == 1;
        }
    }
}

#[inline(always)]
pub(super) fn count(bits: u32) -> u64 {
    bits.count_ones().into()
}
