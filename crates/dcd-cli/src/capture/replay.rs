//! `dcd detect --capture`: a step for each frame of a file.

use crate::detect::{digest, fnv1a};
use crate::failure::Failure;
use crate::memory;
use crate::output::Output;
use crate::precision::Precision;
use crate::progress::Progress;
use crate::stepper::{Stepper, on_threads, stepper};
use dcd_geom::{Pair, Scene};
use dcd_io::{Capture, GlbScene, place_frame, shown};
use dcd_pipeline::{Par, Question};
use serde::Serialize;
use std::fmt::Write;
use std::fs::File;
use std::io;
use std::path::Path;
use std::time::Instant;

/// How the frames are stepped.
#[derive(Clone, Copy)]
pub(crate) struct Replay {
    pub(crate) precision: Precision,
    /// At least 1; 1 is serial.
    pub(crate) threads: usize,
}

/// What one step found.
#[derive(Debug, Serialize)]
pub(super) struct ReplayedFrame {
    frame: usize,
    pairs: usize,
    contacts: usize,
    /// Touching pairs with a sensor, which are not among the contacts.
    sensed: usize,
    undecided: usize,
    ms: f64,
    digest: String,
    /// The objects of contacts and of undecided pairs.
    #[serde(skip)]
    touching: Vec<u32>,
}

/// What all found.
#[derive(Serialize)]
pub(crate) struct Replayed {
    objects: usize,
    threads: usize,
    precision: Precision,
    /// Of the whole capture: FNV-1a over the frames' digests in order.
    digest: String,
    ms: f64,
    frames: Vec<ReplayedFrame>,
}

impl Replay {
    /// Steps through the file's frames with one pipeline, as the recorded program did; draws them, if a file
    /// is named for it.
    pub(crate) fn run(self, path: &Path, glb: Option<&Path>) -> Result<Replayed, Failure> {
        let place = shown(path);
        let file = File::open(path).map_err(|error| Failure::at(&place, error))?;
        let bytes = memory::read(&place, file)?;
        let capture = Capture::read(&bytes).map_err(|error| Failure::at(&place, error))?;
        drop(bytes);
        // Before the work, so that a wrong path costs none.
        let glb = glb.map(Output::create).transpose()?;
        let frames = self.frames(&capture)?;
        if let Some(mut file) = glb {
            file.write(|to| draw(&capture, &frames, to))?;
            file.commit()?;
        }
        let bytes = frames.iter().flat_map(|frame| frame.digest.bytes());
        Ok(Replayed {
            objects: capture.scene().len(),
            threads: self.threads,
            precision: self.precision,
            digest: format!("{:016x}", fnv1a(bytes)),
            ms: frames.iter().map(|frame| frame.ms).sum(),
            frames,
        })
    }

    /// Steps through all frames.
    pub(super) fn frames(self, capture: &Capture) -> Result<Vec<ReplayedFrame>, Failure> {
        let mut stepper = stepper(capture.scene(), self.precision, Question::default())?;
        on_threads(self.threads, |par| steps(capture, &mut *stepper, par))?
    }
}

/// Frames a second in an animation.
const RATE: f64 = 60.0;

/// Writes a capture and what was found in its frames as an animation.
pub(super) fn draw(
    capture: &Capture,
    found: &[ReplayedFrame],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let mut glb = GlbScene::new(capture.scene());
    for (k, (poses, found)) in capture.frames().zip(found).enumerate() {
        glb.frame(k as f64 / RATE, poses, found.touching.iter().copied(), Vec::new())?;
    }
    glb.write(out)
}

fn steps(
    capture: &Capture,
    stepper: &mut dyn Stepper,
    par: Par,
) -> Result<Vec<ReplayedFrame>, Failure> {
    let mut scene: Scene = capture.scene().clone();
    let mut frames = Vec::with_capacity(capture.frame_count());
    let progress = Progress::over(capture.frame_count() as u64, "frames");
    for (frame, poses) in capture.frames().enumerate() {
        progress.step();
        place_frame(&mut scene, poses)
            .map_err(|error| Failure::at(format_args!("frame {frame}"), error))?;
        let begun = Instant::now();
        let step = stepper.step(&scene, par.into());
        let ms = begun.elapsed().as_secs_f64() * 1e3;
        // In the step's own order, so that the digest sees it.
        let contacts: Vec<Pair> = step.contacts().map(|(i, j)| Pair::new(i, j)).collect();
        let undecided = step.report().undecided().iter().map(|undecided| undecided.pair);
        let mut touching: Vec<u32> =
            contacts.iter().copied().chain(undecided).flat_map(|pair| [pair.i, pair.j]).collect();
        touching.sort_unstable();
        touching.dedup();
        frames.push(ReplayedFrame {
            frame,
            pairs: step.candidate_count(),
            contacts: contacts.len(),
            sensed: step.sensor_pairs().count(),
            undecided: step.report().undecided().len(),
            ms,
            digest: format!("{:016x}", digest(&contacts)),
            touching,
        });
    }
    Ok(frames)
}

impl Replayed {
    pub(crate) fn json(&self) -> String {
        // Strings and finite numbers alone: nothing in it can fail.
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }

    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "frame    pairs contacts undecided         ms digest");
        for ReplayedFrame { frame, pairs, contacts, undecided, ms, digest, .. } in &self.frames {
            let _ = writeln!(
                text,
                "{frame:>5} {pairs:>8} {contacts:>8} {undecided:>9} {ms:>10.3} {digest}"
            );
        }
        let Self { objects, threads, ms, digest, frames, precision } = self;
        let (precision, count) = (precision.name(), frames.len());
        let _ = writeln!(
            text,
            "{count} frames of {objects} objects, precision {precision}, {threads} threads: {ms:.3} ms, \
             digest {digest}"
        );
        text
    }
}
