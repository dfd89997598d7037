//! Prefetches what the next pairs read: in a large scene memory latency decides how fast a step is. Hints
//! alone; no result depends on them.

use super::frame::{FramePair, SimdFrame};
use dcd_geom::Pair;
use dcd_simd::{WIDTH, prefetch};

/// How many objects are remembered as prefetched. A power of two, several times those of a tile of
/// sixteen by sixteen objects.
const REMEMBERED: usize = 256;

/// An object, and above its 32 bits whether it is of the second frame of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FrameObject(u64);

/// No object.
const NONE: FrameObject = FrameObject(u64::MAX);

/// Marks the objects of the second frame.
const SECOND: u64 = 1 << 32;

impl FrameObject {
    #[inline(always)]
    fn index(self) -> u32 {
        self.0 as u32
    }

    #[inline(always)]
    fn frame(self, frames: FramePair<'_>) -> &SimdFrame {
        if self.0 & SECOND == 0 { frames.a } else { frames.b }
    }
}

/// Prefetches the records of the pairs after the next, and the vertices of the next.
#[derive(Clone, Debug)]
pub(super) struct Prefetch {
    /// The objects prefetched last, so that those of a dense scene, which recur in pair after pair,
    /// are not prefetched again. New entries overwrite old ones.
    recent: [FrameObject; REMEMBERED],
    /// The objects whose records the last call prefetched.
    new: [FrameObject; 2 * WIDTH],
    count: usize,
}

impl Default for Prefetch {
    fn default() -> Self {
        Self { recent: [NONE; REMEMBERED], new: [NONE; 2 * WIDTH], count: 0 }
    }
}

impl Prefetch {
    /// Prefetches the vertices of the pairs of the last call, and the records of these pairs: at most
    /// sixteen. Out of line: it holds no lanes.
    #[inline(never)]
    pub(super) fn look(&mut self, frames: FramePair<'_>, pairs: &[Pair]) {
        if frames.are_near() {
            return;
        }
        if !frames.have_vertices() {
            // A cache line or two an object: to prefetch again costs less than to remember.
            for pair in pairs {
                frames.a.prefetch(pair.i);
                frames.b.prefetch(pair.j);
            }
            return;
        }
        for object in &self.new[..self.count] {
            let frame = object.frame(frames);
            prefetch(frame.blocks_of(frame.record(object.index())));
        }
        self.count = 0;
        let second = if frames.is_one() { 0 } else { SECOND };
        for pair in pairs {
            self.note(frames, FrameObject(pair.i.into()));
            self.note(frames, FrameObject(second | u64::from(pair.j)));
        }
    }

    #[inline(always)]
    fn note(&mut self, frames: FramePair<'_>, object: FrameObject) {
        let slot = &mut self.recent[object.0 as usize % REMEMBERED];
        if *slot != object && self.count < self.new.len() {
            *slot = object;
            prefetch(std::slice::from_ref(object.frame(frames).record(object.index())));
            self.new[self.count] = object;
            self.count += 1;
        }
    }
}
