//! Pairs of compounds resolved by their parts: first the likeliest pair of parts of each, then all of
//! those that this leaves open, then what the lanes do.

use super::certificate::CertifiedBounds;
use super::decide::{self, Decide, Left, Slice};
use super::expand::{Expand, Queue};
use super::frame::SimdFrame;
use crate::{Method, PosedShape, Prepared, Reason, Report, Verdict, certified};
use dcd_geom::glam::Vec3;
use dcd_geom::{Pair, Shape};
use dcd_simd::dispatch_on;
use std::marker::PhantomData;

/// What is reused from slice to slice.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    queue: Queue,
    /// What is known of each of its questions.
    known: Vec<Known>,
    /// The pairs of parts that are asked of the lanes, and for which question.
    asked: Vec<Pair>,
    asked_for: Vec<u32>,
    /// What the lanes say of them.
    touching: Vec<bool>,
    left: Vec<Left>,
    /// What they count, which are not pairs of objects.
    counts: Report,
    /// The pairs of parts that they leave open.
    doubts: Vec<Doubt>,
}

/// What is known of two objects.
#[derive(Clone, Copy, Debug)]
struct Known {
    touching: bool,
    undecided: Option<Reason>,
    method: Method,
}

/// Two parts of which nothing is proved yet.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    question: u32,
    parts: Pair,
    /// See [`Left`].
    axes: [Vec3; 2],
}

/// Resolves these of a slice's pairs, all with parts, and writes which touch.
pub(super) fn judge(
    slice: &Slice<'_>,
    mut left: &[Left],
    lanes: &mut decide::Scratch,
    (touching, report): (&mut [bool], &mut Report),
) {
    let mut scratch = std::mem::take(&mut lanes.by_parts);
    let (frames, pairs) = (slice.frames(), slice.pairs);
    while !left.is_empty() {
        let queue = &mut scratch.queue;
        let taken = dispatch_on(slice.path, Expand { frames, pairs, left, queue });
        left = &left[taken..];
        slice.answer(&mut scratch, lanes);
        report.count(Method::Portal, scratch.queue.apart);
        for (question, known) in scratch.queue.questions.iter().zip(&scratch.known) {
            touching[question.number as usize] = known.touching;
            match known.undecided {
                Some(reason) if !known.touching => {
                    report.leave(pairs[question.number as usize], reason);
                }
                _ => report.count(known.method, 1),
            }
        }
    }
    lanes.by_parts = scratch;
}

impl Slice<'_> {
    /// Finds out what there is to be known of every question in the queue.
    fn answer(&self, scratch: &mut Scratch, lanes: &mut decide::Scratch) {
        scratch.ask_the_likeliest();
        self.ask(scratch, lanes);
        scratch.ask_the_rest();
        self.ask(scratch, lanes);
        for doubt in &scratch.doubts {
            let known = &mut scratch.known[doubt.question as usize];
            if known.touching {
                continue;
            }
            let number = scratch.queue.questions[doubt.question as usize].number;
            let Pair { i, j } = self.pairs[number as usize];
            let (a, b) = (placed(self.a, i, doubt.parts.i), placed(self.b, j, doubt.parts.j));
            let axes = doubt.axes.map(|axis| axis.as_dvec3());
            let (verdict, method) = certified::overlap_with_after(&axes, a, b, &mut lanes.parts);
            known.method = known.method.max(method);
            match verdict {
                Verdict::Apart => {}
                Verdict::Touching(()) => known.touching = true,
                Verdict::Undecided(reason) => known.undecided = Some(reason),
            }
        }
    }

    /// Asks the lanes, notes what they prove, and keeps what they do not.
    fn ask(&self, scratch: &mut Scratch, lanes: &mut decide::Scratch) {
        let Scratch { asked, asked_for, touching, left, counts, known, doubts, .. } = scratch;
        let (trust, frames, pairs) = (PhantomData::<CertifiedBounds>, self.frames(), &asked[..]);
        lanes.lend(touching, left);
        dispatch_on(self.path, Decide { trust, frames, pairs, scratch: lanes, report: counts });
        lanes.lend(touching, left);
        counts.clear();
        for (&question, &touches) in asked_for.iter().zip(&*touching) {
            known[question as usize].touching |= touches;
        }
        doubts.extend(left.iter().map(|left| Doubt {
            question: asked_for[left.number as usize],
            parts: asked[left.number as usize],
            axes: left.axes,
        }));
    }
}

/// An object's part, by its record; or the object, which is its own.
fn placed(side: Prepared<'_, SimdFrame>, object: u32, record: u32) -> PosedShape<'_> {
    let whole = PosedShape::of(side.scene, object);
    let part = side.frame.place_of(object, record).and_then(|place| {
        let cores = side.frame.cores();
        let first = cores.cores()[side.scene.shape_of()[object as usize] as usize].first_part;
        let number = cores.parts()[(first + place) as usize].part as usize;
        match whole.shape {
            Shape::Compound(compound) => Some(compound.parts()[number].placed()),
            _ => None,
        }
    });
    PosedShape { shape: part.unwrap_or(whole.shape), ..whole }
}

impl Scratch {
    /// One pair of parts for each question, of which nothing is known.
    fn ask_the_likeliest(&mut self) {
        let none = Known { touching: false, undecided: None, method: Method::Portal };
        self.known.clear();
        self.known.resize(self.queue.questions.len(), none);
        self.doubts.clear();
        self.asked.clone_from(&self.queue.first);
        self.asked_for.clear();
        self.asked_for.extend(0..self.queue.questions.len() as u32);
    }

    /// All others of the questions that are not resolved by that.
    fn ask_the_rest(&mut self) {
        self.asked.clear();
        self.asked_for.clear();
        let mut begin = 0;
        for ((number, question), known) in (0..).zip(&self.queue.questions).zip(&self.known) {
            let end = question.end as usize;
            if !known.touching {
                self.asked.extend_from_slice(&self.queue.rest[begin..end]);
                self.asked_for.resize(self.asked.len(), number);
            }
            begin = end;
        }
    }
}
