//! Temporal coherence: what was proved of a pair in an earlier step, for as long as it holds.

mod facts;
#[cfg(test)]
mod tests;
mod track;

use super::certificate::{Lasting, Proved};
use super::decide::{self, Slice};
use super::{append_contacts, frame, prepare};
use crate::{Findings, NarrowPhase, Report, Rung};
use dcd_geom::lanes::{Path, dispatch_on};
use dcd_geom::{Aabb, Divide, Pair, Scene, Shape, Stamp};
use facts::{Fact, Facts, Shelf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use track::Track;

/// Whether two objects touch, proved, for scenes that barely differ from step to step: the answers
/// of [`super::Overlap`], most of them from an earlier step's proofs.
///
/// A proof has room to spare: a distance that the points of both objects may travel together before
/// it no longer holds. Every object's way is summed up, and a pair is settled for as long as the
/// two ways since its proof are shorter than the room of it. So nothing is tried again, and nothing
/// is trusted: a fact expires before it can be wrong (docs/numerics.md, "coherence").
///
/// Costs some 200 bytes an object and 16 a candidate pair, and a first step that takes about twice
/// as long. Where more than half of the objects move by more than 1/128 of their radius in a step,
/// it does what [`super::Overlap`] does. What the [`Report`] counts as [`Rung::Remembered`] may
/// differ by some pairs from run to run on several threads; answers never do.
#[derive(Clone, Copy, Debug)]
pub struct Coherent {
    path: Path,
}

impl Default for Coherent {
    fn default() -> Self {
        Self { path: Path::best() }
    }
}

impl Coherent {
    /// On that path, or the portable one where this CPU does not have it. The answers are the same
    /// on every path; for tests and measurements.
    pub fn on(path: Path) -> Self {
        Self { path }
    }
}

/// All objects, ready for the lanes, and what outlasts a step.
#[derive(Debug, Default)]
pub struct Frame {
    lanes: frame::Frame,
    /// The shapes that everything remembered is about.
    shapes: Option<Arc<[Shape]>>,
    layout: Option<Stamp>,
    tracks: Vec<Track>,
    facts: Facts,
    /// How many objects move too fast for facts about them to last.
    restless: AtomicUsize,
    /// Whether some way has become so long that f32 no longer tells small rooms in it.
    worn: AtomicBool,
}

/// The frame's room for a range of the objects.
#[derive(Debug)]
pub struct Part<'f> {
    lanes: frame::Part<'f>,
    tracks: &'f mut [Track],
    ways: (&'f mut [Shelf], &'f mut [f32]),
    told: Told<'f>,
}

/// What all parts tell the frame.
#[derive(Clone, Copy, Debug)]
struct Told<'f> {
    restless: &'f AtomicUsize,
    worn: &'f AtomicBool,
}

impl Divide for Part<'_> {
    fn len(&self) -> usize {
        self.tracks.len()
    }

    fn split_at(self, middle: usize) -> (Self, Self) {
        let (lanes, later_lanes) = self.lanes.split_at(middle);
        let (tracks, later_tracks) = self.tracks.split_at_mut(middle);
        let (ways, later_ways) = self.ways.split_at(middle);
        let told = self.told;
        (
            Self { lanes, tracks, ways, told },
            Self { lanes: later_lanes, tracks: later_tracks, ways: later_ways, told },
        )
    }
}

/// Where more than one object in so many is restless, nothing is looked up nor kept: of two objects
/// that find each other at random three quarters of the pairs would be in vain. Larger: facts of
/// the others are lost. Smaller: more is looked up in vain.
const RESTLESS: usize = 2;

/// How many pairs ahead memory is asked for a fact. No effect on any result.
const AHEAD: usize = 24;

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    lanes: decide::Scratch,
    /// For each pair of the slice, whether it touches, as far as is known.
    touching: Vec<bool>,
    /// The pairs of which nothing is known.
    open: Vec<Pair>,
    /// Their numbers in the slice.
    numbers: Vec<u32>,
}

impl NarrowPhase for Coherent {
    type Answer = ();
    type Frame = Frame;
    type Part<'f> = Part<'f>;
    type Scratch = Scratch;

    fn growth(&self) -> Option<f64> {
        Some(0.0)
    }

    fn lay_out<'f>(&self, scene: &Scene, frame: &'f mut Frame) -> Part<'f> {
        let same_shapes =
            frame.shapes.as_ref().is_some_and(|s| Arc::ptr_eq(s, scene.shared_shapes()));
        if !same_shapes {
            frame.shapes = Some(scene.shared_shapes().clone());
            frame.facts.forget();
        }
        if frame.layout != Some(scene.layout()) {
            frame.layout = Some(scene.layout());
            frame.tracks.resize(scene.len(), Track::default());
            frame.facts.make_shelves(scene.len());
        }
        if std::mem::take(frame.worn.get_mut()) {
            frame.facts.forget();
            frame.tracks.iter_mut().for_each(Track::start_again);
        }
        *frame.restless.get_mut() = 0;
        Part {
            lanes: frame.lanes.lay_out(scene),
            tracks: &mut frame.tracks,
            ways: frame.facts.ways_mut(),
            told: Told { restless: &frame.restless, worn: &frame.worn },
        }
    }

    fn prepare(&self, scene: &Scene, first: usize, part: Part<'_>, aabbs: &mut [Aabb]) {
        let (mut worn, mut restless) = (false, 0);
        let ways = part.ways.0.iter_mut().zip(part.ways.1);
        for (i, (track, (shelf, limit))) in (first..).zip(part.tracks.iter_mut().zip(ways)) {
            worn |= track.follow(scene, i);
            let way = track.way();
            way.write(shelf, limit);
            restless += usize::from(way.restless);
        }
        if worn {
            part.told.worn.store(true, Relaxed);
        }
        part.told.restless.fetch_add(restless, Relaxed);
        dispatch_on(self.path, prepare::Prepare { scene, first, part: part.lanes, aabbs });
    }

    fn foresee<'p>(&self, frame: &mut Frame, candidates: impl Iterator<Item = &'p [Pair]> + Clone) {
        frame.facts.make_room(candidates);
    }

    fn decide(
        &self,
        scene: &Scene,
        frame: &Frame,
        pairs: &[Pair],
        scratch: &mut Scratch,
        findings: &mut Findings<'_, ()>,
    ) {
        if frame.restless.load(Relaxed) * RESTLESS > scene.len() {
            let slice = Slice { path: self.path, scene, frame: &frame.lanes, pairs };
            slice.judge::<Proved>(&mut scratch.lanes, findings.report);
            return append_contacts(scratch.lanes.touching(), pairs, findings.contacts);
        }
        scratch.recall(&frame.facts, pairs, findings.report);
        let slice = Slice { path: self.path, scene, frame: &frame.lanes, pairs: &scratch.open };
        slice.judge::<Lasting>(&mut scratch.lanes, findings.report);
        scratch.remember(&frame.facts);
        append_contacts(&scratch.touching, pairs, findings.contacts);
    }
}

impl Scratch {
    /// Takes what is known of the pairs, and lists the others.
    fn recall(&mut self, facts: &Facts, pairs: &[Pair], report: &mut Report) {
        self.touching.resize(pairs.len(), false);
        self.open.resize(pairs.len(), Pair::default());
        self.numbers.resize(pairs.len(), 0);
        let mut end = 0;
        for (number, &pair) in pairs.iter().enumerate() {
            if let Some(&ahead) = pairs.get(number + AHEAD) {
                facts.look_ahead(ahead);
            }
            let known = facts.recall(pair);
            self.touching[number] = known == Some(Fact::Touching);
            // Written without a branch, which would be mispredicted for every few pairs.
            self.open[end] = pair;
            self.numbers[end] = number as u32;
            end += usize::from(known.is_none());
        }
        self.open.truncate(end);
        self.numbers.truncate(end);
        report.count(Rung::Remembered, (pairs.len() - end) as u64);
    }

    /// Keeps what the lanes proved of the others.
    fn remember(&mut self, facts: &Facts) {
        let found = self.lanes.touching().iter().zip(self.lanes.room());
        let asked = self.open.iter().zip(&self.numbers);
        for ((&pair, &number), (&touching, &room)) in asked.zip(found) {
            self.touching[number as usize] = touching;
            let fact = if touching { Fact::Touching } else { Fact::Apart };
            facts.remember(pair, fact, room);
        }
    }
}
