//! What is kept of a slice's pairs beside their answers, where proofs are to outlast the step.

use super::axis::Axis;
use super::bounds::U;
use super::packet::{LanesOf, Number, PairPacket};
use dcd_geom::glam::Vec3;
use dcd_simd::{Block, IndexRow, Lanes, Row, WIDTH};

/// For each pair of a slice an axis and the clearance of its proof.
#[derive(Clone, Debug, Default)]
pub(crate) struct KeptProofs {
    /// Written before the slice is decided: an axis to be tried first, or none. Afterwards also
    /// one by which the portal proved the two apart.
    pub(crate) axes: Vec<Axis>,
    /// The most clearance that a proof has: see [`super::certificate::Certificate`]. [`NO_PROOF`] where the
    /// lanes resolved nothing.
    clearance: Vec<f32>,
    /// In u of the pair's size m.
    wanted: f32,
}

/// Less than the clearance of any proof.
const NO_PROOF: f32 = -1.0;

impl KeptProofs {
    /// How far the objects of each pair may move together before what the lanes proved of it may no
    /// longer hold, metres; not above 0 where they proved nothing that lasts.
    pub(crate) fn clearance(&self) -> &[f32] {
        &self.clearance
    }

    /// How much clearance is looked for beyond the first proof. Unit: the pair's size m. 0: none.
    pub(crate) fn want(&mut self, clearance: f32) {
        self.wanted = clearance / U;
    }

    /// Before that many pairs are judged.
    #[inline(always)]
    pub(super) fn begin(&mut self, pairs: usize) {
        self.clearance.clear();
        self.clearance.resize(pairs, NO_PROOF);
    }

    /// Keeps the clearance of proofs just found where it is the most so far. Returns the lanes in which it is
    /// as much as is wanted.
    #[inline(always)]
    pub(super) fn note<L: Lanes>(
        &mut self,
        l: L,
        packet: &PairPacket,
        (clearance, proved): (L::F, u32),
    ) -> u32 {
        let mut row = Row::default();
        let found = l.max(clearance, l.splat(0.0));
        l.store(l.select(l.mask(proved), found, l.splat(NO_PROOF)), &mut row);
        self.keep_most(&packet.number, &row);
        if self.wanted == 0.0 {
            return proved;
        }
        let wanted = l.mul(packet.number(l, Number::Unit), l.splat(self.wanted));
        proved & !l.bits(l.lt(clearance, wanted))
    }

    /// Keeps the clearance of proofs just found that pairs are apart.
    #[inline(always)]
    pub(super) fn note_gaps<L: Lanes>(
        &mut self,
        l: L,
        packet: &PairPacket,
        (gap, apart): (L::F, u32),
    ) {
        if apart != 0 {
            let mut row = Row::default();
            l.store(l.select(l.mask(apart), gap, l.splat(NO_PROOF)), &mut row);
            self.keep_most(&packet.number, &row);
        }
    }

    /// Keeps these clearances where they are the most so far: without a branch, and without effect in lanes that have no
    /// proof. Out of line, as [`Self::proved`]: neither holds lanes, and every stage asks both.
    #[inline(never)]
    fn keep_most(&mut self, numbers: &IndexRow, found: &Row) {
        for (&number, &found) in numbers.0.iter().zip(&found.0) {
            if let Some(clearance) = self.clearance.get_mut(number as usize) {
                *clearance = clearance.max(found);
            }
        }
    }

    /// The lanes of which there is a proof but not yet the clearance that is wanted.
    #[inline(never)]
    pub(super) fn proved(&self, packet: &PairPacket) -> u32 {
        let mut proved = 0;
        if self.wanted > 0.0 {
            for lane in 0..WIDTH {
                let clearance = self.clearance.get(packet.number.0[lane] as usize);
                proved |=
                    u32::from(clearance.is_some_and(|&clearance| clearance > NO_PROOF)) << lane;
            }
        }
        proved
    }

    /// Keeps the axes that separated some pairs: against the directions in which they were found.
    #[inline(always)]
    pub(super) fn note_axes(&mut self, packet: &PairPacket, against: &Block, lanes: u32) {
        for lane in LanesOf(lanes) {
            let [x, y, z] = against.0.map(|row| -row.0[lane]);
            if let Some(axis) = self.axes.get_mut(packet.number.0[lane] as usize) {
                *axis = Axis::along(Vec3::new(x, y, z));
            }
        }
    }
}
