//! What the next pairs will read, asked for in time: in a large scene a step is as fast as memory
//! answers. Hints alone; no result depends on them.

use super::frame::SimdFrame;
use dcd_geom::Pair;
use dcd_simd::{WIDTH, prefetch};

/// How many objects are remembered as asked for. A power of two, several times those of a tile of
/// sixteen by sixteen objects.
const REMEMBERED: usize = 256;

/// Asks for the records of the pairs after the next, and for the vertices of the next.
#[derive(Clone, Debug)]
pub(super) struct Prefetch {
    /// The objects asked for last, so that those of a dense scene, which recur in pair after pair,
    /// are not asked for again. Forgets by overwriting.
    recent: [u32; REMEMBERED],
    /// The objects whose records were asked for by the last call.
    new: [u32; 2 * WIDTH],
    count: usize,
}

impl Default for Prefetch {
    fn default() -> Self {
        Self { recent: [u32::MAX; REMEMBERED], new: [0; 2 * WIDTH], count: 0 }
    }
}

impl Prefetch {
    /// Asks for the vertices of the pairs of the last call, and for the records of these: at most
    /// sixteen.
    #[inline(always)]
    pub(super) fn look(&mut self, frame: &SimdFrame, pairs: &[Pair]) {
        if frame.is_near() {
            return;
        }
        if !frame.has_vertices() {
            // A line or two an object: to ask again costs less than to remember.
            for pair in pairs {
                frame.ask_for(pair.i);
                frame.ask_for(pair.j);
            }
            return;
        }
        for &object in &self.new[..self.count] {
            prefetch(frame.blocks_of(frame.record(object)));
        }
        self.count = 0;
        for pair in pairs {
            self.note(frame, pair.i);
            self.note(frame, pair.j);
        }
    }

    #[inline(always)]
    fn note(&mut self, frame: &SimdFrame, object: u32) {
        let slot = &mut self.recent[object as usize % REMEMBERED];
        if *slot != object && self.count < self.new.len() {
            *slot = object;
            prefetch(std::slice::from_ref(frame.record(object)));
            self.new[self.count] = object;
            self.count += 1;
        }
    }
}
