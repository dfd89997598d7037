//! Several pairs of one scene, written where a step keeps their manifolds.

use super::super::corners::Corners;
use super::super::{ManifoldContacts, write_of_polytopes};
use super::{PAIRS, Packet, Shown, Way};
use crate::query::FoundPair;
use dcd_simd::{Kernel, Lanes};

/// Writes the manifolds of up to eight pairs; which of them are left, a bit each.
pub(in super::super) struct WriteSeveral<'a> {
    pub(in super::super) pairs: &'a [FoundPair<'a>],
    pub(in super::super) packet: &'a mut Packet,
    pub(in super::super) corners: &'a mut Corners,
    pub(in super::super) contacts: &'a mut ManifoldContacts,
}

impl Kernel for WriteSeveral<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) -> u32 {
        let (mut waiting, mut numbers) = ([const { None::<Shown<'_>> }; PAIRS], [0; PAIRS]);
        let (mut count, mut left) = (0, 0);
        self.packet.begin();
        for (k, pair) in self.pairs.iter().enumerate() {
            let Some(place) = waiting.get_mut(count) else {
                left |= self.alone(k);
                continue;
            };
            *place = Shown::of(pair);
            let Some(shown) = place else {
                left |= self.alone(k);
                continue;
            };
            match shown.way() {
                Way::Patch => {
                    shown.pack(count, self.packet);
                    numbers[count] = k;
                    count += 1;
                }
                Way::InOnePoint => {
                    shown.write_witnesses(self.contacts.writer());
                    self.contacts.keep_last(pair.number);
                }
                Way::Alone => left |= self.alone(k),
            }
        }
        if count == 0 {
            return left;
        }
        let sharp = self.packet.search(l, count);
        for (lane, place) in waiting[..count].iter().enumerate() {
            let Some(shown) = place else { continue };
            if sharp >> lane & 1 == 1 {
                left |= self.alone(numbers[lane]);
                continue;
            }
            shown.write(lane, self.packet, self.contacts.writer());
            self.contacts.keep_last(shown.pair.number);
        }
        left
    }
}

impl WriteSeveral<'_> {
    /// Writes the manifold of the pair of that number by itself; its bit where it is left.
    #[inline(never)]
    fn alone(&mut self, k: usize) -> u32 {
        let FoundPair { found, sides: [a, b], number } = &self.pairs[k];
        if write_of_polytopes(found, *a, *b, self.corners, self.contacts.writer()) {
            self.contacts.keep_last(*number);
            return 0;
        }
        1 << k
    }
}
