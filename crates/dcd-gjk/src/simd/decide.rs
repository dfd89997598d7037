//! A slice of pairs on its way through the stages.

use super::ahead::Ahead;
use super::axis::hinted;
use super::boxes::{self, Boxes};
use super::by_parts::{self, ByParts};
use super::certificate::Trust;
use super::expand;
use super::frame::{BOX, Frame};
use super::kept::Kept;
use super::lot::{
    AFTER_BALLS, AFTER_CONE, AFTER_SECOND_POINT, Belt, LanesOf, Lot, Number, Vector, Whole,
};
use super::nearest;
use super::opening::{self, Entry, Place, Settled};
use super::portal;
use super::support::Desk;
use super::upright;
use crate::{Placed, Report, Rung, Verdict, certified, parts};
use dcd_geom::glam::Vec3;
use dcd_geom::lanes::{Block, Kernel, Lanes, Path, WIDTH, dispatch_on};
use dcd_geom::{Pair, Scene};
use std::marker::PhantomData;

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// For each pair of the slice, whether it is known to touch.
    touching: Vec<bool>,
    /// Where proofs are to last.
    kept: Kept,
    left: Vec<Left>,
    ahead: Ahead,
    desk: Desk,
    entry: Entry,
    boxes: Boxes,
    /// Where the later stages work.
    lot: Lot,
    /// What waits for the twin boxes.
    boxed: Belt<AFTER_BALLS>,
    /// What waits for the centre axis.
    axis: Belt<AFTER_BALLS>,
    /// What waits for the next support of rounded shapes.
    near: Belt<AFTER_SECOND_POINT>,
    /// What waits for the second point.
    second: Belt<AFTER_CONE>,
    /// What waits for the next support.
    portal: Belt<AFTER_SECOND_POINT>,
    /// For what is made of parts.
    pub(super) parts: parts::Scratch,
    /// For those of them whose parts the lanes know.
    pub(super) by_parts: by_parts::Scratch,
    /// The pairs of these.
    with_parts: Vec<Left>,
}

impl Scratch {
    /// For each pair of the slice judged last, whether it is known to touch.
    pub(crate) fn touching(&self) -> &[bool] {
        &self.touching
    }

    /// What was kept of them, if proofs are to last.
    pub(crate) fn kept(&self) -> &Kept {
        &self.kept
    }

    /// Exchanges where the next answers are written, and what is left open.
    pub(super) fn lend(&mut self, touching: &mut Vec<bool>, left: &mut Vec<Left>) {
        std::mem::swap(&mut self.touching, touching);
        std::mem::swap(&mut self.left, left);
    }

    /// To be written before a slice is judged by proofs that are to last.
    pub(crate) fn kept_mut(&mut self) -> &mut Kept {
        &mut self.kept
    }
}

/// After how many supports, from the second point on, a pair that has a proof is content with what room
/// it has. Larger: more pairs are known in the next steps. Smaller: a faster first step.
const WIDENING: f32 = 4.0;

/// A pair that the lanes leave open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Left {
    /// Its number in the slice.
    pub(super) number: u32,
    /// Between the centres, and where the search ended: perhaps one separates. World axes, from b
    /// to a.
    pub(super) axes: [Vec3; 2],
}

/// Some pairs of a scene.
pub struct Slice<'a> {
    pub(crate) path: Path,
    pub(crate) scene: &'a Scene,
    pub(crate) frame: &'a Frame,
    pub(crate) pairs: &'a [Pair],
}

impl Slice<'_> {
    /// Lanes first, then one pair at a time what they leave: without a proof only shapes that have
    /// no vertices, and sizes that f32 has no room for.
    pub(crate) fn judge<T: Trust>(&self, scratch: &mut Scratch, report: &mut Report) {
        let Self { path, scene, frame, pairs } = *self;
        let trust = PhantomData::<T>;
        dispatch_on(path, Decide { trust, frame, pairs, scratch, report: &mut *report });
        self.judge_by_parts(scratch, report);
        for left in &scratch.left {
            let number = left.number as usize;
            let pair = pairs[number];
            scratch.touching[number] = match upright::touch(frame, pair) {
                Some((touch, rung)) => {
                    report.count(rung, 1);
                    touch
                }
                None => {
                    let known = Known { axes: left.axes, parts: &mut scratch.parts };
                    settle(scene, pair, known, report)
                }
            };
        }
    }

    /// Takes out of the pairs left open those whose parts the lanes know, and settles them.
    fn judge_by_parts(&self, scratch: &mut Scratch, report: &mut Report) {
        let Self { path, scene, frame, pairs } = *self;
        if !frame.has_compounds() {
            return;
        }
        let mut with_parts = std::mem::take(&mut scratch.with_parts);
        let has_parts = |left: &mut Left| expand::has_parts(frame, pairs[left.number as usize]);
        with_parts.clear();
        with_parts.extend(scratch.left.extract_if(.., has_parts));
        let mut touching = std::mem::take(&mut scratch.touching);
        let by_parts = ByParts { path, scene, frame, pairs };
        by_parts.judge(&with_parts, scratch, (&mut touching, report));
        (scratch.touching, scratch.with_parts) = (touching, with_parts);
    }
}

/// What the later rungs are handed beside a pair.
struct Known<'a> {
    axes: [Vec3; 2],
    parts: &'a mut parts::Scratch,
}

/// The later rungs for one pair that the lanes left open: the lanes' own axes in f64, then f64
/// from the start, then exact integers. Whether it is known to touch.
fn settle(
    scene: &Scene,
    pair: Pair,
    Known { axes, parts }: Known<'_>,
    report: &mut Report,
) -> bool {
    let placed =
        |i: u32| Placed { shape: scene.shape(i as usize), pose: &scene.poses()[i as usize] };
    let axes = axes.map(|axis| axis.as_dvec3());
    let (verdict, rung) =
        certified::overlap_with_after(&axes, placed(pair.i), placed(pair.j), parts);
    match verdict {
        Verdict::Undecided(reason) => report.leave(pair, reason),
        Verdict::Apart | Verdict::Touching(()) => report.count(rung, 1),
    }
    verdict == Verdict::Touching(())
}

/// Settles what the lanes can of a slice of pairs.
pub(super) struct Decide<'a, T> {
    /// What the answers are worth.
    pub(super) trust: PhantomData<T>,
    pub(super) frame: &'a Frame,
    pub(super) pairs: &'a [Pair],
    pub(super) scratch: &'a mut Scratch,
    pub(super) report: &'a mut Report,
}

impl<T: Trust> Kernel for Decide<'_, T> {
    type Output = ();

    /// Every stage hands on what it leaves open, and works whenever a whole lot has come together.
    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let pairs = self.pairs;
        self.scratch.touching.clear();
        self.scratch.touching.resize(pairs.len(), false);
        if T::KEEPS_ROOM {
            self.scratch.kept.begin(pairs.len());
        }
        self.scratch.left.clear();
        self.scratch.ahead.look(self.frame, pairs.chunks(WIDTH).next().unwrap_or_default());
        self.scratch.ahead.look(self.frame, pairs.chunks(WIDTH).nth(1).unwrap_or_default());
        let mut first = 0;
        loop {
            let whole = if first < pairs.len() { Whole::Only } else { Whole::OrLast };
            if whole == Whole::Only {
                self.open(l, first);
                first += WIDTH;
            }
            // The later stage first: so each finds room for what the earlier one hands on.
            loop {
                let Scratch { boxed, axis, near, second, portal, .. } = &*self.scratch;
                if portal.has(whole) {
                    self.round(l);
                } else if second.has(whole) {
                    self.second_point(l);
                } else if near.has(whole) {
                    self.nearer(l);
                } else if axis.has(whole) {
                    self.first_axis(l);
                } else if boxed.has(whole) {
                    self.twin_boxes(l);
                } else {
                    break;
                }
            }
            if whole == Whole::OrLast {
                break;
            }
        }
    }
}

impl<T: Trust> Decide<'_, T> {
    /// Reads sixteen pairs and tries their balls.
    #[inline(always)]
    fn open<L: Lanes>(&mut self, l: L, first: usize) {
        let Scratch { touching, kept, left, ahead, entry, boxed, axis, .. } = &mut *self.scratch;
        let later = self.pairs.get(first + 2 * WIDTH..).unwrap_or_default();
        ahead.look(self.frame, &later[..later.len().min(WIDTH)]);
        let pairs = &self.pairs[first..self.pairs.len().min(first + WIDTH)];
        entry.read::<T>(self.frame, pairs, first as u32);
        let balls = entry.balls::<L, T>(l);
        mark(&mut touching[first..], balls.touching);
        self.report.count(Rung::Balls, count(balls.all()));
        let open = entry.live & !balls.all();
        let mut narrow = 0;
        if T::KEEPS_ROOM {
            narrow = balls.all() & !kept.note(l, &entry.lot, (balls.room, balls.all()));
        }
        let to_axis = if self.frame.has_vertices() { (open | narrow) & !entry.boxed } else { 0 };
        let to_boxes = open & entry.boxed;
        let to_left = used(pairs.len()) & !(balls.all() | to_boxes | to_axis);
        for lane in LanesOf(to_left) {
            left.push(Left { number: entry.lot.number.0[lane], axes: [Vec3::ZERO; 2] });
        }
        boxed.push(l, &entry.lot, to_boxes);
        axis.push(l, &entry.lot, to_axis);
    }

    /// A box round and a box inside each.
    #[inline(always)]
    fn twin_boxes<L: Lanes>(&mut self, l: L) {
        let Scratch { left, boxes, lot, boxed, .. } = &mut *self.scratch;
        let taken = boxed.take(l, lot);
        let (settled, aligned) = boxes::twin_boxes::<L, T>(l, self.frame, boxes, (lot, taken));
        let open = used(taken) & !settled.all();
        let handed_on = match (self.frame.has_vertices(), T::HANDS_ON) {
            (false, _) => open,
            // A round or a hull between its boxes is not them.
            (true, true) => are_boxes(self.frame, lot, open & aligned),
            (true, false) => 0,
        };
        for lane in LanesOf(handed_on) {
            // The closed form of boxes needs no axis.
            left.push(Left { number: lot.number.0[lane], axes: [Vec3::ZERO; 2] });
        }
        self.settle(l, Rung::Boxes, settled, used(taken));
        self.scratch.axis.push(l, &self.scratch.lot, open & !handed_on);
    }

    /// The axis between the centres, or one that separated before, and the cone.
    #[inline(always)]
    fn first_axis<L: Lanes>(&mut self, l: L) {
        let Scratch { desk, lot, axis, kept, .. } = &mut *self.scratch;
        let taken = axis.take(l, lot);
        let mut at = Place { frame: self.frame, desk };
        let mut first = lot.vector(l, Vector::C);
        if T::KEEPS_ROOM {
            first = hinted(l, &kept.axes, (lot, taken), first);
        }
        let apart = opening::first_axis::<L, T>(l, &mut at, (lot, taken), first);
        let apart = Settled::apart(l, apart);
        let cone = Settled::touching(l, opening::cone::<L, T>(l, lot)).but(apart);
        let done = self.settle(l, Rung::CentreAxis, apart, used(taken))
            | self.settle(l, Rung::Cone, cone, used(taken));
        let Scratch { lot, near, second, .. } = &mut *self.scratch;
        let open = used(taken) & !done;
        let rounded = l.bits(l.lt(l.splat(0.0), lot.number(l, Number::Radius)));
        // Nearer points also show how far two are apart.
        let to_near = open & (rounded | apart.all());
        second.push(l, lot, open & !to_near);
        if to_near != 0 {
            nearest::begin(l, lot);
            near.push(l, lot, to_near);
        }
    }

    /// A nearer point of two cores. Where there is none they overlap, as a portal may prove.
    #[inline(always)]
    fn nearer<L: Lanes>(&mut self, l: L) {
        let Scratch { desk, lot, near, .. } = &mut *self.scratch;
        let taken = near.take(l, lot);
        let mut at = Place { frame: self.frame, desk };
        let (settled, stuck) = nearest::round::<L, T>(l, &mut at, lot, taken);
        let done = self.settle(l, Rung::Portal, settled, used(taken));
        let (proved, enough) = self.narrow(l);
        let Scratch { lot, near, second, .. } = &mut *self.scratch;
        second.push(l, lot, stuck & used(taken) & !proved);
        near.push(l, lot, used(taken) & !(done | stuck | enough));
    }

    /// The cone of two points.
    #[inline(always)]
    fn second_point<L: Lanes>(&mut self, l: L) {
        let Scratch { desk, lot, second, .. } = &mut *self.scratch;
        let taken = second.take(l, lot);
        let mut at = Place { frame: self.frame, desk };
        let cone = portal::second_point::<L, T>(l, &mut at, lot, taken);
        let cone = Settled::touching(l, cone);
        let done = self.settle(l, Rung::Cone, cone, used(taken));
        self.scratch.portal.push(l, &self.scratch.lot, used(taken) & !done);
    }

    /// One support, and what follows.
    #[inline(always)]
    fn round<L: Lanes>(&mut self, l: L) {
        let Scratch { desk, lot, portal, .. } = &mut *self.scratch;
        let taken = portal.take(l, lot);
        let mut at = Place { frame: self.frame, desk };
        let mut against = Block::default();
        if T::KEEPS_ROOM {
            lot.vector(l, Vector::D).store(l, &mut against.0);
        }
        let (mut settled, mut stuck) = portal::round::<L, T>(l, &mut at, lot, taken);
        if !T::HANDS_ON {
            settled.touching |= stuck;
            stuck = 0;
        }
        let done = self.settle(l, Rung::Portal, settled, used(taken));
        let (proved, enough) = self.narrow(l);
        let Scratch { left, lot, portal, kept, .. } = &mut *self.scratch;
        for lane in LanesOf(stuck & used(taken) & !proved) {
            left.push(Left { number: lot.number.0[lane], axes: lot.axes(lane) });
        }
        if T::KEEPS_ROOM {
            kept.note_axes(lot, &against, settled.apart & used(taken));
        }
        portal.push(l, lot, used(taken) & !(done | stuck | enough));
    }

    /// Notes what a stage settled of the lanes in use. Returns those that need no other stage.
    #[inline(always)]
    fn settle<L: Lanes>(&mut self, l: L, rung: Rung, settled: Settled<L>, used: u32) -> u32 {
        let Scratch { touching, kept, lot, .. } = &mut *self.scratch;
        let proved = settled.all() & used;
        scatter(touching, lot, settled.touching & used);
        if !T::KEEPS_ROOM {
            self.report.count(rung, count(proved));
            return proved;
        }
        self.report.count(rung, count(proved & !kept.proved(lot)));
        kept.note(l, lot, (settled.room, proved))
    }

    /// The lanes that have a proof but not the room that is wanted, and those of them that have taken
    /// [`WIDENING`] supports.
    #[inline(always)]
    fn narrow<L: Lanes>(&self, l: L) -> (u32, u32) {
        if !T::KEEPS_ROOM {
            return (0, 0);
        }
        let proved = self.scratch.kept.proved(&self.scratch.lot);
        let round = self.scratch.lot.number(l, Number::Round);
        (proved, proved & l.bits(l.le(l.splat(WIDENING), round)))
    }
}

/// Of these lanes those whose objects are their boxes.
#[inline(always)]
fn are_boxes(frame: &Frame, lot: &Lot, lanes: u32) -> u32 {
    let mut boxes = 0;
    for lane in LanesOf(lanes) {
        let (a, b) = (frame.record(lot.a.0[lane]), frame.record(lot.b.0[lane]));
        boxes |= u32::from(a.marks & b.marks & BOX != 0) << lane;
    }
    boxes
}

/// The mask of that many lanes.
#[inline(always)]
fn used(lanes: usize) -> u32 {
    (1 << lanes) - 1
}

/// Writes which of a group of pairs touch; every entry is written, so that none is a branch.
#[inline(always)]
fn mark(touching: &mut [bool], bits: u32) {
    for (lane, touches) in touching.iter_mut().take(WIDTH).enumerate() {
        *touches = bits >> lane & 1 == 1;
    }
}

/// Writes which pairs of a lot touch, without a branch; what was known of the others stays.
#[inline(always)]
fn scatter(touching: &mut [bool], lot: &Lot, bits: u32) {
    for lane in 0..WIDTH {
        if let Some(touches) = touching.get_mut(lot.number.0[lane] as usize) {
            *touches |= bits >> lane & 1 == 1;
        }
    }
}

#[inline(always)]
fn count(bits: u32) -> u64 {
    bits.count_ones().into()
}
