//! A scene to step through, again and again, each step timed and checked.

use std::cell::OnceCell;
use std::time::Duration;

use anyhow::{Result, anyhow, ensure};
use dcd_benches::{Digest, timing};
use dcd_geom::{Pair, Scene};
use dcd_pipeline::{Exec, Par, Pipeline, StageClock};
use dcd_scenes::SceneSpec;

use crate::record::STAGES;

/// The stages and the whole step.
pub(crate) const PARTS: [&str; STAGES + 1] = ["boxes", "build", "pairs", "narrow", "whole"];

/// Where the whole step stands in [`PARTS`].
pub(crate) const WHOLE: usize = STAGES;

/// A seeded scene, drawn when it is first needed.
#[derive(Debug)]
pub(crate) struct Case {
    spec: SceneSpec,
    scene: OnceCell<Scene>,
}

impl Case {
    /// The scene of that name.
    pub(crate) fn new(name: &str, objects: usize, seed: u64) -> Result<Self> {
        let spec = SceneSpec::parse(name)?.with_objects(objects).with_seed(seed);
        Ok(Self { spec, scene: OnceCell::new() })
    }

    /// Its name.
    pub(crate) fn name(&self) -> &'static str {
        self.spec.name()
    }

    /// How many objects it has.
    pub(crate) fn objects(&self) -> usize {
        self.spec.objects
    }

    /// Its key, unique within a run.
    pub(crate) fn key(&self) -> String {
        format!("{}/N={}", self.name(), self.objects())
    }

    /// The scene itself.
    pub(crate) fn scene(&self) -> Result<&Scene> {
        if let Some(scene) = self.scene.get() {
            return Ok(scene);
        }
        let scene = dcd_benches::draw(&self.spec)?;
        Ok(self.scene.get_or_init(|| scene))
    }
}

/// Our default pipeline on a scene. Every step must find what the first one found.
pub(crate) struct Runner<'s> {
    scene: &'s Scene,
    par: Par,
    pipeline: Pipeline,
    clock: StageClock,
    expected: Option<u64>,
    strayed: bool,
}

impl<'s> Runner<'s> {
    /// With buffers of its own.
    pub(crate) fn new(scene: &'s Scene, par: Par) -> Self {
        let (pipeline, clock) = (Pipeline::default(), StageClock::default());
        Self { scene, par, pipeline, clock, expected: None, strayed: false }
    }

    /// One step, as [`PARTS`].
    pub(crate) fn times(&mut self) -> [Duration; PARTS.len()] {
        let clock = std::mem::take(&mut self.clock);
        let whole = self.observed(Exec::observed(self.par, &clock));
        let [boxes, build, pairs, narrow] = clock.take();
        self.clock = clock;
        [boxes, build, pairs, narrow, whole]
    }

    /// One step whose observer is the caller's.
    pub(crate) fn observed(&mut self, exec: Exec<'_>) -> Duration {
        let (time, step) = timing::time(|| self.pipeline.step(self.scene, exec));
        let digest = Digest::of(step.contacts().map(|(i, j)| Pair { i, j })).list;
        self.strayed |= *self.expected.get_or_insert(digest) != digest;
        time
    }

    /// What it found is the same, in the same order, in each of its steps and in those of `other`.
    pub(crate) fn agrees_with(&self, other: &Self) -> Result<()> {
        let same = self.expected == other.expected;
        ensure!(
            same && !self.strayed && !other.strayed,
            "contacts or their order changed from step to step or with the number of threads"
        );
        Ok(())
    }
}

/// Runs `work` inside a pool of so many threads.
pub(crate) fn on_threads<T: Send>(
    threads: usize,
    work: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    dcd_exec::with_threads(threads, work).map_err(|error| anyhow!(error))?
}
