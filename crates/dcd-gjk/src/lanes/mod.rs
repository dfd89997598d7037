//! The default narrow phase: sixteen pairs at a time in f32, every answer with its certificate.
//!
//! A pair passes stages, each a small kernel that settles what it can prove and hands on the rest:
//! balls, the axis between the centres, the cone, a second point, the portal. What the lanes
//! cannot prove is settled in f64, and what f64 cannot, in exact integers.

mod ahead;
mod bounds;
mod certificate;
mod frame;
mod lot;
mod opening;
mod portal;
mod prepare;
mod support;
#[cfg(test)]
mod twins;
mod vector;

pub use frame::{Frame, Part};

use crate::{Body, Contact, Findings, NarrowPhase, Placed, Report, Rung, Verdict, certified};
use ahead::Ahead;
use dcd_geom::glam::Vec3;
use dcd_geom::lanes::{Kernel, Lanes, Path, WIDTH, dispatch_on};
use dcd_geom::{Aabb, Pair, Scene};
use lot::{AFTER_ROUND, AFTER_SECOND_POINT, LanesOf, Queue};
use opening::{Entry, Place};
use support::Desk;

/// Whether two objects touch, proved: the most reliable rung, and the default.
#[derive(Clone, Copy, Debug)]
pub struct Overlap {
    path: Path,
}

impl Default for Overlap {
    fn default() -> Self {
        Self { path: Path::best() }
    }
}

impl Overlap {
    /// On that path, or the portable one where this CPU does not have it. The answers are the same
    /// on every path; for tests and measurements.
    pub fn on(path: Path) -> Self {
        Self { path }
    }
}

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// What is known of each pair of the slice.
    known: Vec<Known>,
    queue: Queue,
    next: Queue,
    desk: Desk,
    left: Vec<Left>,
    ahead: Ahead,
}

/// A pair that the lanes leave open.
#[derive(Clone, Copy, Debug)]
struct Left {
    /// Its number in the slice.
    number: u32,
    /// Between the centres, and where the search ended: perhaps one separates. World axes, from b
    /// to a.
    axes: [Vec3; 2],
}

/// What is known of a pair so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Known {
    #[default]
    Open,
    Apart,
    Touching,
    Undecided,
}

impl NarrowPhase for Overlap {
    type Answer = ();
    type Frame = Frame;
    type Part<'f> = Part<'f>;
    type Scratch = Scratch;

    fn lay_out<'f>(&self, scene: &Scene, frame: &'f mut Frame) -> Part<'f> {
        frame.lay_out(scene)
    }

    fn prepare(&self, scene: &Scene, first: usize, part: Part<'_>, aabbs: &mut [Aabb]) {
        dispatch_on(self.path, prepare::Prepare { scene, first, part, aabbs });
    }

    fn decide(
        &self,
        scene: &Scene,
        frame: &Frame,
        pairs: &[Pair],
        scratch: &mut Scratch,
        findings: &mut Findings<'_, ()>,
    ) {
        scratch.known.clear();
        scratch.known.resize(pairs.len(), Known::Open);
        dispatch_on(self.path, Decide { frame, pairs, scratch, report: findings.report });
        for left in &scratch.left {
            let number = left.number as usize;
            scratch.known[number] = settle(scene, pairs[number], left.axes, findings.report);
        }
        append_contacts(&scratch.known, pairs, findings.contacts);
    }
}

/// Appends the touching pairs in order, without a branch that half of the pairs would mispredict.
fn append_contacts(known: &[Known], pairs: &[Pair], contacts: &mut Vec<Contact<()>>) {
    let mut end = contacts.len();
    contacts.resize(end + pairs.len(), Contact::default());
    for (known, &pair) in known.iter().zip(pairs) {
        contacts[end].pair = pair;
        end += usize::from(*known == Known::Touching);
    }
    contacts.truncate(end);
}

/// The later rungs for one pair that the lanes left open: the lanes' own axes in f64, then f64
/// from the start, then exact integers.
fn settle(scene: &Scene, pair: Pair, axes: [Vec3; 2], report: &mut Report) -> Known {
    let placed =
        |i: u32| Placed { shape: scene.shape(i as usize), pose: &scene.poses()[i as usize] };
    let (a, b) = (placed(pair.i), placed(pair.j));
    let (verdict, rung) = match (a.shape.as_polytope(), b.shape.as_polytope()) {
        (Some(in_a), Some(in_b)) => {
            let (a, b) = (Body::polytope(in_a, a.pose), Body::polytope(in_b, b.pose));
            if axes.iter().any(|axis| certified::are_apart_along(axis.as_dvec3(), a, b)) {
                (Verdict::Apart, Rung::F64)
            } else {
                certified::overlap(a, b)
            }
        }
        _ => certified::overlap_of(a, b),
    };
    match verdict {
        Verdict::Undecided(reason) => {
            report.leave(pair, reason);
            return Known::Undecided;
        }
        Verdict::Apart => report.count(rung, 1),
        Verdict::Touching(()) => report.count(rung, 1),
    }
    if verdict == Verdict::Apart { Known::Apart } else { Known::Touching }
}

/// Settles what the lanes can of a slice of pairs.
struct Decide<'a> {
    frame: &'a Frame,
    pairs: &'a [Pair],
    scratch: &'a mut Scratch,
    report: &'a mut Report,
}

impl Kernel for Decide<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        self.open(l);
        self.rounds(l);
    }
}

impl Decide<'_> {
    /// Balls, axis, cone and the second point for every pair; the one in seven that is left is queued.
    /// The stages are not closed up between: it costs more to move a pair than to carry it along.
    #[inline(always)]
    fn open<L: Lanes>(&mut self, l: L) {
        let mut entry = Entry::default();
        let Scratch { known, queue, desk, left, ahead, .. } = &mut *self.scratch;
        let mut at = Place { frame: self.frame, desk };
        queue.clear();
        left.clear();
        let mut later = self.pairs.chunks(WIDTH);
        ahead.look(self.frame, later.next().unwrap_or_default());
        ahead.look(self.frame, later.next().unwrap_or_default());
        for (group, pairs) in self.pairs.chunks(WIDTH).enumerate() {
            ahead.look(self.frame, later.next().unwrap_or_default());
            entry.read(self.frame, pairs, (group * WIDTH) as u32);
            let balls = entry.balls(l);
            let mut open = entry.live & !(balls.apart | balls.touching);
            let axis = entry.centre_axis(l, &mut at, open);
            open &= !axis;
            let mut cone = entry.cone(l, open);
            open &= !cone;
            let second = portal::second_point(l, &mut at, &mut entry.lot, open);
            open &= !second;
            cone |= second;

            let known = &mut known[group * WIDTH..];
            mark(known, balls.apart | axis, balls.touching | cone);
            self.report.count(Rung::Balls, count(balls.apart | balls.touching));
            self.report.count(Rung::CentreAxis, count(axis));
            self.report.count(Rung::Cone, count(cone));
            for lane in LanesOf(!entry.live & (u32::MAX >> (32 - pairs.len()))) {
                left.push(Left { number: entry.lot.number.0[lane], axes: [Vec3::ZERO; 2] });
            }
            for lane in LanesOf(open) {
                queue.push::<AFTER_SECOND_POINT>(&entry.lot, lane);
            }
        }
    }

    /// Support after support, the lots closed up after each.
    #[inline(always)]
    fn rounds<L: Lanes>(&mut self, l: L) {
        let Scratch { known, queue, next, desk, left, .. } = &mut *self.scratch;
        let mut at = Place { frame: self.frame, desk };
        for _ in 0..portal::ROUNDS {
            if queue.is_empty() {
                break;
            }
            next.clear();
            for k in 0..queue.lots() {
                let (lot, open) = queue.lot(k);
                let (settled, stuck) = portal::round(l, &mut at, lot, open);
                let apart = settled.apart & !settled.touching;
                for lane in LanesOf(apart) {
                    known[lot.number.0[lane] as usize] = Known::Apart;
                }
                for lane in LanesOf(settled.touching) {
                    known[lot.number.0[lane] as usize] = Known::Touching;
                }
                self.report.count(Rung::Portal, count(apart | settled.touching));
                for lane in LanesOf(stuck) {
                    left.push(Left { number: lot.number.0[lane], axes: lot.axes(lane) });
                }
                for lane in LanesOf(open & !(apart | settled.touching | stuck)) {
                    next.push::<AFTER_ROUND>(lot, lane);
                }
            }
            std::mem::swap(queue, next);
        }
        for k in 0..queue.lots() {
            let (lot, open) = queue.lot(k);
            for lane in LanesOf(open) {
                left.push(Left { number: lot.number.0[lane], axes: lot.axes(lane) });
            }
        }
    }
}

/// Writes what is known of a group of pairs; every entry is written, so that none is a branch.
#[inline(always)]
fn mark(known: &mut [Known], apart: u32, touching: u32) {
    for (lane, known) in known.iter_mut().take(WIDTH).enumerate() {
        let is = |bits: u32| bits >> lane & 1 == 1;
        *known = if is(apart) {
            Known::Apart
        } else if is(touching) {
            Known::Touching
        } else {
            Known::Open
        };
    }
}

#[inline(always)]
fn count(bits: u32) -> u64 {
    bits.count_ones().into()
}
