//! Those who take turns.

use std::time::Duration;

use dcd_benches::{Digest, timing};
use dcd_broad::BroadPhase;
use dcd_exec::Segments;
use dcd_geom::{Aabb, Pair, Scene};
use dcd_gjk::Overlap;
use dcd_parry::Ready;
use dcd_pipeline::{Exec, Par, Pipeline, StageClock};

/// Up to this many objects a step is so short that the clock's readings at its stages (some
/// hundred nanoseconds) would show: the whole is timed in a step of its own.
const SHORT: usize = 2_000;

/// What is timed of a step, in this order.
pub(crate) const PARTS: [&str; 6] = ["boxes", "build", "pairs", "broad", "narrow", "whole"];

/// Where the whole step stands in [`PARTS`].
pub(crate) const WHOLE: usize = PARTS.len() - 1;

/// One step: how long it took and what it found.
pub(crate) struct Run {
    pub(crate) time: Duration,
    pub(crate) digest: u64,
}

/// A pipeline that is ready to step through a scene, again and again from the start.
pub(crate) trait Rival {
    /// One step, timed without its digest.
    fn step(&mut self, exec: Exec<'_>) -> Run;
}

/// Ours, of any broad phase, with what it must find.
pub(crate) struct Ours<'s, B> {
    pub(crate) pipeline: Pipeline<B, Overlap>,
    pub(crate) scene: &'s Scene,
    /// The list for the default pipeline, whose order is a promise; the set for another order.
    pub(crate) digest: fn(Digest) -> u64,
}

impl<B: BroadPhase> Rival for Ours<'_, B> {
    fn step(&mut self, exec: Exec<'_>) -> Run {
        let (time, step) = timing::time(|| self.pipeline.step(self.scene, exec));
        let pairs = step.contacts().map(|(i, j)| Pair { i, j });
        Run { time, digest: (self.digest)(Digest::of(pairs)) }
    }
}

/// No broad phase: every pair there is goes to the narrow phase.
#[derive(Debug)]
pub(crate) struct EveryPair;

impl BroadPhase for EveryPair {
    fn build(&mut self, _: &[Aabb], _: Exec<'_>) {}

    fn pairs(
        &mut self,
        aabbs: &[Aabb],
        keep: impl Fn(u32, u32) -> bool + Sync,
        exec: Exec<'_>,
        out: &mut Segments<Pair>,
    ) {
        out.fill(exec, aabbs.len(), |task, out| {
            let i = task as u32;
            let later = i + 1..aabbs.len() as u32;
            out.extend(later.filter(|&j| keep(i, j)).map(|j| Pair { i, j }));
        });
    }
}

/// Parry's contacts come in an order that depends on its last tree.
impl Rival for &mut Ready<'_, f32> {
    fn step(&mut self, exec: Exec<'_>) -> Run {
        let (time, step) = timing::time(|| Ready::step(self, exec));
        Run { time, digest: Digest::of(step.contacts()).set }
    }
}

/// A rival on its turns: every step must find what is expected.
pub(crate) struct Turn<R> {
    rival: R,
    par: Par,
    objects: usize,
    expected: u64,
    strayed: bool,
    clock: StageClock,
}

impl<R: Rival> Turn<R> {
    /// Steps by `par` through a scene of so many objects.
    pub(crate) fn new(rival: R, par: Par, objects: usize, expected: u64) -> Self {
        Self { rival, par, objects, expected, strayed: false, clock: StageClock::default() }
    }

    /// The times of [`PARTS`].
    pub(crate) fn times(&mut self) -> [Duration; PARTS.len()] {
        let mut whole = self.run(Watched::ByClock);
        let [boxes, build, pairs, narrow] = self.clock.take();
        if self.objects <= SHORT {
            whole = self.run(Watched::Not);
        }
        [boxes, build, pairs, build + pairs, narrow, whole]
    }

    /// The time of the whole step alone.
    pub(crate) fn whole(&mut self) -> [Duration; 1] {
        [self.run(Watched::Not)]
    }

    /// Whether any step so far has found something else than expected.
    pub(crate) fn has_strayed(&self) -> bool {
        self.strayed
    }

    fn run(&mut self, watched: Watched) -> Duration {
        let exec = match watched {
            Watched::ByClock => Exec::observed(self.par, &self.clock),
            Watched::Not => self.par.into(),
        };
        let run = self.rival.step(exec);
        self.strayed |= run.digest != self.expected;
        run.time
    }
}

enum Watched {
    ByClock,
    Not,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reports scripted values, one a run.
    struct Scripted(Vec<u64>);

    impl Rival for Scripted {
        fn step(&mut self, _: Exec<'_>) -> Run {
            Run { time: Duration::from_millis(1), digest: self.0.remove(0) }
        }
    }

    #[test]
    fn without_a_broad_phase_every_pair_is_decided_once() {
        let mut out = Segments::default();
        let pair = |(i, j): (u32, u32)| Pair { i, j };
        EveryPair.pairs(&[Aabb::EMPTY; 4], |i, j| i + j != 3, Par::Serial.into(), &mut out);
        let pairs: Vec<Pair> = out.iter().flatten().copied().collect();
        assert_eq!(pairs, [(0, 1), (0, 2), (1, 3), (2, 3)].map(pair));
    }

    #[test]
    fn one_step_that_finds_something_else_is_not_forgotten() {
        let mut turn = Turn::new(Scripted(vec![5, 6, 5]), Par::Serial, usize::MAX, 5);
        let strayed = [(); 3].map(|()| {
            turn.times();
            turn.has_strayed()
        });
        assert_eq!(strayed, [false, true, true]);
    }
}
