//! What the next pairs will read, asked for in time: in a large scene a step is as fast as memory
//! answers. Hints alone; no result depends on them.

use super::frame::{FramePair, SimdFrame};
use dcd_geom::Pair;
use dcd_simd::{WIDTH, prefetch};

/// How many objects are remembered as asked for. A power of two, several times those of a tile of
/// sixteen by sixteen objects.
const REMEMBERED: usize = 256;

/// An object, and above its 32 bits whether it is of the second frame of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Asked(u64);

/// No object.
const NONE: Asked = Asked(u64::MAX);

/// Marks the objects of the second frame.
const SECOND: u64 = 1 << 32;

impl Asked {
    #[inline(always)]
    fn object(self) -> u32 {
        self.0 as u32
    }

    #[inline(always)]
    fn frame(self, frames: FramePair<'_>) -> &SimdFrame {
        if self.0 & SECOND == 0 { frames.a } else { frames.b }
    }
}

/// Asks for the records of the pairs after the next, and for the vertices of the next.
#[derive(Clone, Debug)]
pub(super) struct Prefetch {
    /// The objects asked for last, so that those of a dense scene, which recur in pair after pair,
    /// are not asked for again. Forgets by overwriting.
    recent: [Asked; REMEMBERED],
    /// The objects whose records were asked for by the last call.
    new: [Asked; 2 * WIDTH],
    count: usize,
}

impl Default for Prefetch {
    fn default() -> Self {
        Self { recent: [NONE; REMEMBERED], new: [NONE; 2 * WIDTH], count: 0 }
    }
}

impl Prefetch {
    /// Asks for the vertices of the pairs of the last call, and for the records of these: at most
    /// sixteen.
    #[inline(always)]
    pub(super) fn look(&mut self, frames: FramePair<'_>, pairs: &[Pair]) {
        if frames.are_near() {
            return;
        }
        if !frames.have_vertices() {
            // A line or two an object: to ask again costs less than to remember.
            for pair in pairs {
                frames.a.ask_for(pair.i);
                frames.b.ask_for(pair.j);
            }
            return;
        }
        for asked in &self.new[..self.count] {
            let frame = asked.frame(frames);
            prefetch(frame.blocks_of(frame.record(asked.object())));
        }
        self.count = 0;
        let second = if frames.is_one() { 0 } else { SECOND };
        for pair in pairs {
            self.note(frames, Asked(pair.i.into()));
            self.note(frames, Asked(second | u64::from(pair.j)));
        }
    }

    #[inline(always)]
    fn note(&mut self, frames: FramePair<'_>, asked: Asked) {
        let slot = &mut self.recent[asked.0 as usize % REMEMBERED];
        if *slot != asked && self.count < self.new.len() {
            *slot = asked;
            prefetch(std::slice::from_ref(asked.frame(frames).record(asked.object())));
            self.new[self.count] = asked;
            self.count += 1;
        }
    }
}
