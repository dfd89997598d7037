//! Pairs of compounds resolved by their parts: first the likeliest pair of parts of each pair, then all pairs
//! of parts where that proved nothing, then in f64 what the lanes leave open. Where a measure follows, all pairs of parts at once:
//! it wants all that touch.

use super::certificate::CertifiedBounds;
use super::decide::{self, Decide, Left, Slice};
use super::expand::{Expand, Queue};
use super::scene_pairs::ScenePairs;
use super::touching_parts::TouchingParts;
use crate::{Method, Reason, Report, Verdict, certified};
use dcd_geom::Pair;
use dcd_geom::glam::Vec3;
use dcd_simd::dispatch_on;
use std::marker::PhantomData;

/// What is reused from slice to slice.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    queue: Queue,
    /// What is known of each of its questions.
    known: Vec<Known>,
    /// The pairs of parts that the lanes decide next, and the question of each.
    part_pairs: Vec<Pair>,
    question_of: Vec<u32>,
    /// What the lanes prove of them.
    touching: Vec<bool>,
    left: Vec<Left>,
    /// What they count, which are not pairs of objects.
    counts: Report,
    /// The pairs of parts that they leave open.
    doubts: Vec<Doubt>,
    /// The place and the question of those that stay undecided.
    undecided: Vec<[u32; 2]>,
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
    /// Their place among the pairs of parts that were decided last.
    place: u32,
    parts: Pair,
    /// See [`Left`].
    axes: [Vec3; 2],
}

/// Resolves the pairs of a slice with these numbers, all with parts, and writes which touch.
pub(super) fn judge(
    slice: &Slice<'_>,
    mut numbers: &[u32],
    lanes: &mut decide::Scratch,
    (touching, report): (&mut [bool], &mut Report),
) {
    let mut scratch = std::mem::take(&mut lanes.by_parts);
    let (frames, pairs) = (slice.frames(), slice.pairs);
    while !numbers.is_empty() {
        let queue = &mut scratch.queue;
        let expand = Expand { frames, pairs, numbers, margin: None, queue };
        let taken = dispatch_on(slice.path, expand);
        numbers = &numbers[taken..];
        slice.answer(&mut scratch, lanes);
        scratch.keep_touching(&mut lanes.touching_parts);
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
    /// Resolves every question in the queue.
    fn answer(&self, scratch: &mut Scratch, lanes: &mut decide::Scratch) {
        let scenes = [self.a.scene, self.b.scene];
        let objects = ScenePairs { frames: self.frames(), scenes, pairs: self.pairs };
        let are_all_wanted = lanes.touching_parts.is_wanted();
        scratch.begin();
        if are_all_wanted {
            scratch.take_all();
        } else {
            scratch.take_likeliest();
            self.decide_parts(scratch, lanes);
            scratch.take_rest();
        }
        self.decide_parts(scratch, lanes);
        for doubt in &scratch.doubts {
            let known = &mut scratch.known[doubt.question as usize];
            if known.touching && !are_all_wanted {
                continue;
            }
            let number = scratch.queue.questions[doubt.question as usize].number;
            let whole = objects.posed(self.pairs[number as usize]);
            let parts = objects.parts(doubt.parts);
            let axes = doubt.axes.map(|axis| axis.as_dvec3());
            let (verdict, method) = certified::overlap_of_parts_after(&axes, whole, parts);
            known.method = known.method.max(method);
            match verdict {
                Verdict::Apart => {}
                Verdict::Touching(()) => {
                    known.touching = true;
                    if are_all_wanted {
                        scratch.touching[doubt.place as usize] = true;
                    }
                }
                Verdict::Undecided(reason) => {
                    known.undecided = Some(reason);
                    scratch.undecided.push([doubt.place, doubt.question]);
                }
            }
        }
        if are_all_wanted {
            // Of objects that touch these are measured as well: the bound of a depth has to cover them.
            for &[place, question] in &scratch.undecided {
                if scratch.known[question as usize].touching {
                    scratch.touching[place as usize] = true;
                }
            }
        }
    }

    /// Decides the pairs of parts in the lanes. Notes what they prove, and lists as doubts what they do not.
    fn decide_parts(&self, scratch: &mut Scratch, lanes: &mut decide::Scratch) {
        let Scratch { part_pairs, question_of, touching, left, counts, known, doubts, .. } =
            scratch;
        let (bounds, frames, pairs) =
            (PhantomData::<CertifiedBounds>, self.frames(), &part_pairs[..]);
        lanes.lend(touching, left);
        dispatch_on(self.path, Decide { bounds, frames, pairs, scratch: lanes, report: counts });
        lanes.lend(touching, left);
        counts.clear();
        for (&question, &touches) in question_of.iter().zip(&*touching) {
            known[question as usize].touching |= touches;
        }
        doubts.extend(left.iter().map(|left| Doubt {
            question: question_of[left.number as usize],
            place: left.number,
            parts: part_pairs[left.number as usize],
            axes: left.axes,
        }));
    }
}

impl Scratch {
    /// Nothing is known of any question yet.
    fn begin(&mut self) {
        let none = Known { touching: false, undecided: None, method: Method::Portal };
        self.known.clear();
        self.known.resize(self.queue.questions.len(), none);
        self.doubts.clear();
        self.undecided.clear();
    }

    /// Takes one pair of parts for each question.
    fn take_likeliest(&mut self) {
        self.part_pairs.clone_from(&self.queue.first);
        self.question_of.clear();
        self.question_of.extend(0..self.queue.questions.len() as u32);
    }

    /// Takes all other pairs of the questions that those did not resolve.
    fn take_rest(&mut self) {
        self.part_pairs.clear();
        self.question_of.clear();
        let mut begin = 0;
        for ((number, question), known) in (0..).zip(&self.queue.questions).zip(&self.known) {
            let end = question.end as usize;
            if !known.touching {
                self.part_pairs.extend_from_slice(&self.queue.rest[begin..end]);
                self.question_of.resize(self.part_pairs.len(), number);
            }
            begin = end;
        }
    }
    /// Takes all pairs of each question.
    fn take_all(&mut self) {
        self.part_pairs.clear();
        self.question_of.clear();
        let mut begin = 0;
        for (number, question) in (0..).zip(&self.queue.questions) {
            let end = question.end as usize;
            self.part_pairs.push(self.queue.first[number as usize]);
            self.part_pairs.extend_from_slice(&self.queue.rest[begin..end]);
            self.question_of.resize(self.part_pairs.len(), number);
            begin = end;
        }
    }

    /// Hands on which pairs of parts touch, of those that were decided last, where that is wanted.
    fn keep_touching(&self, kept: &mut TouchingParts) {
        if !kept.is_wanted() {
            return;
        }
        let Self { part_pairs, question_of, touching, queue, .. } = self;
        let mut begin = 0;
        for of_one in question_of.chunk_by(|one, other| one == other) {
            let own = begin..begin + of_one.len();
            begin = own.end;
            let number = queue.questions[of_one[0] as usize].number;
            let parts = part_pairs[own.clone()].iter().zip(&touching[own]);
            let parts = parts.filter(|(_, touches)| **touches).map(|(&parts, _)| parts);
            kept.of_compounds.push(number, parts);
        }
    }
}
