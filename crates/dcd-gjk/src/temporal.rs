//! Temporal coherence: what was proved of a pair in an earlier step, for as long as it holds.

mod facts;
#[cfg(test)]
mod tests;
mod track;

use crate::simd::axis::Axis;
use crate::simd::certificate::{CertifiedBounds, ClearanceBounds, ErrorBounds};
use crate::simd::decide::{self, Slice};
use crate::simd::{Purpose, append_contacts, frame, prepare};
use crate::{ContactSink, Method, NarrowPhase, Prepared, Report, Sides};
use dcd_geom::{Aabb, Pair, Revision, Scene, Splittable};
use dcd_simd::Path;
use facts::{Entry, Fact, Facts, Found, Slot};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use track::Track;

/// Whether two objects touch, proved, for scenes that barely differ from step to step: the answers
/// of [`crate::Overlap`], most of them from an earlier step's proofs.
///
/// A proof has clearance to spare: a distance that the points of both objects may travel together before
/// it no longer holds. The frame sums up how far each object has travelled, and a pair stays resolved as
/// long as the sum for both since its proof is less than the clearance. So a fact
/// expires before it can be wrong (docs/numerics/proofs.md, "coherence").
///
/// Where a pair must be decided again, the axis that separated it last is tried first. The
/// certificate decides as in every other step.
///
/// Costs some 200 bytes an object, 17 (dense scenes) to 40 (sparse ones) a candidate pair, and a
/// first step that takes three times as long, in sparse scenes four to five: it looks for proofs with more clearance than the
/// first that are found. Where more than half of the objects move by more than 1/40 of their radius in
/// a step (1/128 in sparse scenes), nothing new is kept, and what is known serves (dense scenes) until
/// it has faded; then it does what [`crate::Overlap`] does.
/// What the [`Report`] counts as [`Method::Remembered`] may differ by some pairs from run to run on
/// several threads; answers never do. Of curved shapes so near to touching that [`crate::Overlap`]
/// leaves them undecided it may still know.
///
/// ```
/// use dcd_pipeline::prelude::*;
/// let poses = [0.0, 0.9, 2.1].map(|x| Pose::from_translation(DVec3::X * x));
/// let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let scene = Scene::one_each(vec![Shape::sphere(0.5)?; 3], poses)?;
/// # let mut scene = scene;
/// let mut pipeline = Pipeline::with(WideTree::default(), Coherent::default());
/// for frame in 1..=60 {
///     scene.set_pose(2, Pose::from_translation(DVec3::X * (2.105 - 0.01 * f64::from(frame)))?)?;
///     let step = pipeline.step(&scene, Par::Serial);
///     assert_eq!(step.contact_count(), if frame <= 20 { 1 } else { 2 });
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
pub struct TemporalFrame {
    lanes: frame::SimdFrame,
    /// The shapes that everything remembered is about.
    shapes: Option<Revision>,
    layout: Option<Revision>,
    tracks: Vec<Track>,
    facts: Facts,
    /// How many objects move too fast for facts about them to last.
    restless: AtomicUsize,
    /// Whether looking up pairs pays even if too many do.
    still_pays: bool,
    /// Whether some way has become so long that f32 no longer resolves small clearances in it.
    worn: AtomicBool,
}

/// The frame's buffers for a range of the objects.
#[derive(Debug)]
pub struct Part<'f> {
    lanes: frame::Part<'f>,
    /// Whether the ways of all objects are still those that were written last, or have been written
    /// anew.
    kept: bool,
    tracks: &'f mut [Track],
    ways: (&'f mut [Entry], &'f mut [f32]),
    shared: Shared<'f>,
    /// How far an object must have moved to be restless, in its radius.
    restless: f64,
}

/// What all parts report to the frame.
#[derive(Clone, Copy, Debug)]
struct Shared<'f> {
    restless: &'f AtomicUsize,
    worn: &'f AtomicBool,
}

impl Splittable for Part<'_> {
    fn len(&self) -> usize {
        self.tracks.len()
    }

    fn split_at(self, middle: usize) -> (Self, Self) {
        let (lanes, later_lanes) = self.lanes.split_at(middle);
        let (tracks, later_tracks) = self.tracks.split_at_mut(middle);
        let (ways, later_ways) = self.ways.split_at(middle);
        let (kept, shared, restless) = (self.kept, self.shared, self.restless);
        let later = (later_lanes, later_tracks, later_ways);
        (
            Self { lanes, kept, tracks, ways, shared, restless },
            Self { lanes: later.0, kept, tracks: later.1, ways: later.2, shared, restless },
        )
    }
}

/// An object that has just moved farther than this is restless. Unit: its outer radius. Larger: facts
/// are kept that expire before they have paid for themselves. Smaller: some are lost that would have.
const RESTLESS: f64 = 1.0 / 40.0;

/// The same in scenes so sparse that what is not known costs more alone than among its neighbours:
/// most of it is waiting for vertices.
const RESTLESS_IF_SPARSE: f64 = 1.0 / 128.0;

/// Where more than one object in so many is restless, nothing new is kept: then proofs would not last.
/// Larger: facts of the others are lost. Smaller: more is kept in vain.
const MAX_RESTLESS: usize = 2;

/// How much clearance the first proofs of all pairs are to have, if a few supports more give it. Unit: the
/// pair's size m. Larger: more pairs are known in the next steps. Smaller: a faster first step. Later
/// proofs are content with what clearance they have, for most pairs that must be proved again have no more.
const CLEARANCE_AT_FIRST: f32 = 1.0 / 24.0;

/// How many pairs are found before the first of them is read: as many as keep memory busy. No effect
/// on any result.
const AT_ONCE: usize = 128;

impl TemporalFrame {
    /// Forgets all facts and lets all ways start from 0: those of every object, for who is not
    /// prepared in this step must count from where the others do.
    fn start_ways_again(&mut self) {
        self.facts.forget();
        let (entries, limits) = self.facts.ways_mut();
        for (track, (entry, limit)) in self.tracks.iter_mut().zip(entries.iter_mut().zip(limits)) {
            track.start_again();
            track.way().write(entry, limit);
        }
    }
}

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    lanes: decide::Scratch,
    /// For each pair of the slice, whether it touches, as far as is known.
    touching: Vec<bool>,
    /// The pairs of which nothing is known.
    open: Vec<Pair>,
    /// Their numbers in the slice, and where their facts belong.
    places: Vec<(u32, Slot)>,
}

impl NarrowPhase for Coherent {
    type Answer = ();
    type Frame = TemporalFrame;
    type Part<'f> = Part<'f>;
    type Scratch = Scratch;

    fn aabb_margin(&self) -> Option<f64> {
        Some(0.0)
    }

    fn fewest_pairs(&self, frame: &TemporalFrame) -> usize {
        frame.lanes.fewest_pairs()
    }

    fn constant_answer(&self) -> Option<()> {
        Some(())
    }

    fn layout<'f>(&self, scene: &Scene, sides: Sides, frame: &'f mut TemporalFrame) -> Part<'f> {
        let same_shapes = frame.shapes == Some(scene.shape_revision());
        if !same_shapes {
            frame.shapes = Some(scene.shape_revision());
            frame.facts.forget();
            // Limits are of the shapes before.
            frame.tracks.clear();
        }
        if frame.layout != Some(scene.layout()) {
            frame.layout = Some(scene.layout());
            frame.tracks.resize(scene.len(), Track::default());
            frame.facts.resize(scene.len());
        }
        if std::mem::take(frame.worn.get_mut()) {
            frame.start_ways_again();
        }
        *frame.restless.get_mut() = 0;
        frame.still_pays = frame.facts.still_pay();
        let dense = frame.facts.are_dense();
        Part {
            restless: if dense { RESTLESS } else { RESTLESS_IF_SPARSE },
            lanes: frame.lanes.layout(scene, sides, Purpose::Measure),
            kept: same_shapes,
            tracks: &mut frame.tracks,
            ways: frame.facts.ways_mut(),
            shared: Shared { restless: &frame.restless, worn: &frame.worn },
        }
    }

    fn keeps(&self, part: &Part<'_>) -> bool {
        part.kept && part.lanes.kept
    }

    fn prepare(&self, scene: &Scene, first: usize, part: Part<'_>, aabbs: &mut [Aabb]) {
        let (mut worn, mut restless) = (false, 0);
        let ways = part.ways.0.iter_mut().zip(part.ways.1);
        for (i, (track, (entry, limit))) in (first..).zip(part.tracks.iter_mut().zip(ways)) {
            worn |= track.follow(scene, part.lanes.cores.cores(), i);
            track.way().write(entry, limit);
            restless += usize::from(track.exceeds(part.restless));
        }
        if worn {
            part.shared.worn.store(true, Relaxed);
        }
        part.shared.restless.fetch_add(restless, Relaxed);
        prepare::prepare(self.path, prepare::Prepare { scene, first, part: part.lanes, aabbs });
    }

    fn begin_pairs<'p>(
        &self,
        frame: &mut TemporalFrame,
        candidates: impl Iterator<Item = &'p [Pair]> + Clone,
    ) {
        frame.facts.lay_out_tiles(candidates);
    }

    fn decide(
        &self,
        a: Prepared<'_, TemporalFrame>,
        b: Prepared<'_, TemporalFrame>,
        pairs: &[Pair],
        scratch: &mut Scratch,
        sink: &mut ContactSink<'_, ()>,
    ) {
        let frame = a.frame;
        let is_one = std::ptr::eq(frame, b.frame);
        let keeps = frame.restless.load(Relaxed) * MAX_RESTLESS <= a.scene.len();
        let [a, b] = [a, b].map(|side| Prepared { scene: side.scene, frame: &side.frame.lanes });
        let slice = Slice { path: self.path, a, b, pairs };
        if !is_one || !keeps && !frame.still_pays {
            slice.judge::<CertifiedBounds>(&mut scratch.lanes, sink.report);
            return append_contacts(scratch.lanes.touching(), pairs, sink.contacts);
        }
        scratch.recall(&frame.facts, pairs, sink.report);
        if keeps {
            scratch.hint(&frame.facts);
            scratch.judge_open::<ClearanceBounds>(slice, sink.report);
            scratch.remember(&frame.facts);
        } else {
            scratch.judge_open::<CertifiedBounds>(slice, sink.report);
        }
        scratch.take_answers();
        append_contacts(&scratch.touching, pairs, sink.contacts);
    }
}

impl Scratch {
    /// Takes what is known of the pairs, and lists the others.
    fn recall(&mut self, facts: &Facts, pairs: &[Pair], report: &mut Report) {
        self.touching.resize(pairs.len(), false);
        self.open.resize(pairs.len(), Pair::default());
        self.places.resize(pairs.len(), (0, Slot::default()));
        let mut end = 0;
        let mut reader = facts.reader();
        let mut found = [Found::default(); AT_ONCE];
        let mut numbers = 0..;
        for (pairs, touching) in pairs.chunks(AT_ONCE).zip(self.touching.chunks_mut(AT_ONCE)) {
            for (found, &pair) in found.iter_mut().zip(pairs) {
                *found = reader.find(pair);
            }
            for ((touching, &pair), (found, number)) in
                touching.iter_mut().zip(pairs).zip(found.iter().zip(&mut numbers))
            {
                let known = facts.recall(found);
                *touching = known == Some(Fact::Touching);
                // Written without a branch, which would be mispredicted for every few pairs.
                self.open[end] = pair;
                self.places[end] = (number, found.slot);
                end += usize::from(known.is_none());
            }
        }
        self.open.truncate(end);
        self.places.truncate(end);
        report.count(Method::Remembered, (pairs.len() - end) as u64);
        facts.count(pairs.len(), pairs.len() - end);
    }

    /// Passes the lanes the axes to be tried first for the others, and how much clearance is wanted.
    fn hint(&mut self, facts: &Facts) {
        let kept = self.lanes.kept_mut();
        kept.want(if facts.are_new() { CLEARANCE_AT_FIRST } else { 0.0 });
        kept.axes.clear();
        kept.axes.extend(self.places.iter().map(|&(_, slot)| facts.axis(slot)));
    }

    /// Decides the others of a slice in the lanes.
    fn judge_open<T: ErrorBounds>(&mut self, slice: Slice<'_>, report: &mut Report) {
        Slice { pairs: &self.open, ..slice }.judge::<T>(&mut self.lanes, report);
    }

    /// Keeps what the lanes proved of the others.
    fn remember(&self, facts: &Facts) {
        let kept = self.lanes.kept();
        let found = self.lanes.touching().iter().zip(kept.clearance());
        let undecided = self.open.iter().zip(&self.places).zip(&kept.axes);
        for (((&pair, &(_, slot)), &axis), (&touching, &clearance)) in undecided.zip(found) {
            let fact = if touching { Fact::Touching } else { Fact::Apart };
            facts.remember((pair, slot), fact, clearance);
            if axis != Axis::default() {
                facts.keep_axis(slot, fact, axis);
            }
        }
    }

    /// Writes the answers of the others to their places.
    fn take_answers(&mut self) {
        for (&(number, _), &touching) in self.places.iter().zip(self.lanes.touching()) {
            self.touching[number as usize] = touching;
        }
    }
}
