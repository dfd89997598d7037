//! The default narrow phase: sixteen pairs at a time in f32, every answer with its certificate.
//!
//! A pair passes stages, each a small kernel that settles what it can prove and hands on the rest:
//! balls, twin boxes, the axis between the centres, the cone, a second point, the portal. Between
//! stages it waits on a belt until sixteen have come together. What the lanes cannot prove is
//! settled in f64, and what f64 cannot, exactly.

mod ahead;
mod bounds;
mod boxes;
mod certificate;
mod frame;
mod lot;
mod nearest;
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
use boxes::Boxes;
use certificate::{Proved, Trust, Trusted};
use dcd_geom::glam::Vec3;
use dcd_geom::lanes::{Kernel, Lanes, Path, WIDTH, dispatch_on};
use dcd_geom::{Aabb, Pair, Scene};
use lot::{AFTER_BALLS, AFTER_CONE, AFTER_SECOND_POINT, Belt, LanesOf, Lot, Number, Whole};
use opening::{Entry, Place};
use std::marker::PhantomData;
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

/// Whether two objects touch, as f32 has it: the same lanes without their certificate.
///
/// What it saves over [`Overlap`] is what a proof costs, next to nothing; what it risks is a wrong
/// answer where the gap or overlap is within rounding, some 1e-5 of the objects' size. A pair on
/// which f32 can gain no more is called touching. Answers may differ from CPU to CPU.
#[derive(Clone, Copy, Debug)]
pub struct OverlapUnproved {
    path: Path,
}

impl Default for OverlapUnproved {
    fn default() -> Self {
        Self { path: Path::best() }
    }
}

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// For each pair of the slice, whether it is known to touch.
    touching: Vec<bool>,
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

impl NarrowPhase for Overlap {
    type Answer = ();
    type Frame = Frame;
    type Part<'f> = Part<'f>;
    type Scratch = Scratch;

    fn growth(&self) -> Option<f64> {
        Some(0.0)
    }

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
        Slice { path: self.path, scene, frame, pairs }.judge::<Proved>(scratch, findings);
    }
}

impl NarrowPhase for OverlapUnproved {
    type Answer = ();
    type Frame = Frame;
    type Part<'f> = Part<'f>;
    type Scratch = Scratch;

    fn growth(&self) -> Option<f64> {
        Some(0.0)
    }

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
        Slice { path: self.path, scene, frame, pairs }.judge::<Trusted>(scratch, findings);
    }
}

/// Some pairs of a scene.
struct Slice<'a> {
    path: Path,
    scene: &'a Scene,
    frame: &'a Frame,
    pairs: &'a [Pair],
}

impl Slice<'_> {
    /// Lanes first, then one pair at a time what they leave: without a proof only shapes that have
    /// no vertices, and sizes that f32 has no room for.
    fn judge<T: Trust>(&self, scratch: &mut Scratch, findings: &mut Findings<'_, ()>) {
        let Self { path, scene, frame, pairs } = *self;
        let report = &mut *findings.report;
        let trust = PhantomData::<T>;
        dispatch_on(path, Decide { trust, frame, pairs, scratch, report });
        for left in &scratch.left {
            let number = left.number as usize;
            scratch.touching[number] = settle(scene, pairs[number], left.axes, findings.report);
        }
        append_contacts(&scratch.touching, pairs, findings.contacts);
    }
}

/// Appends the touching pairs in order, without a branch that half of the pairs would mispredict.
fn append_contacts(touching: &[bool], pairs: &[Pair], contacts: &mut Vec<Contact<()>>) {
    let mut end = contacts.len();
    contacts.resize(end + pairs.len(), Contact::default());
    for (&touches, &pair) in touching.iter().zip(pairs) {
        contacts[end].pair = pair;
        end += usize::from(touches);
    }
    contacts.truncate(end);
}

/// The later rungs for one pair that the lanes left open: the lanes' own axes in f64, then f64
/// from the start, then exact integers. Whether it is known to touch.
fn settle(scene: &Scene, pair: Pair, axes: [Vec3; 2], report: &mut Report) -> bool {
    let placed =
        |i: u32| Placed { shape: scene.shape(i as usize), pose: &scene.poses()[i as usize] };
    let (a, b) = (placed(pair.i), placed(pair.j));
    let (verdict, rung) = match (a.shape.as_polytope(), b.shape.as_polytope()) {
        (Some(in_a), Some(in_b)) => {
            let (a, b) = (Body::polytope(in_a, a.pose), Body::polytope(in_b, b.pose));
            certified::overlap_after(&axes.map(|axis| axis.as_dvec3()), a, b)
        }
        _ => certified::overlap_of(a, b),
    };
    match verdict {
        Verdict::Undecided(reason) => report.leave(pair, reason),
        Verdict::Apart | Verdict::Touching(()) => report.count(rung, 1),
    }
    verdict == Verdict::Touching(())
}

/// Settles what the lanes can of a slice of pairs.
struct Decide<'a, T> {
    /// What the answers are worth.
    trust: PhantomData<T>,
    frame: &'a Frame,
    pairs: &'a [Pair],
    scratch: &'a mut Scratch,
    report: &'a mut Report,
}

impl<T: Trust> Kernel for Decide<'_, T> {
    type Output = ();

    /// Every stage hands on what it leaves open, and works whenever a whole lot has come together.
    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let pairs = self.pairs;
        self.scratch.touching.clear();
        self.scratch.touching.resize(pairs.len(), false);
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
                    self.centre_axis(l);
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
        let Scratch { touching, left, ahead, entry, boxed, axis, .. } = &mut *self.scratch;
        let later = self.pairs.get(first + 2 * WIDTH..).unwrap_or_default();
        ahead.look(self.frame, &later[..later.len().min(WIDTH)]);
        let pairs = &self.pairs[first..self.pairs.len().min(first + WIDTH)];
        entry.read(self.frame, pairs, first as u32);
        let balls = entry.balls::<L, T>(l);
        mark(&mut touching[first..], balls.touching);
        self.report.count(Rung::Balls, count(balls.apart | balls.touching));
        let open = entry.live & !(balls.apart | balls.touching);
        let to_axis = if self.frame.has_vertices() { open & !entry.boxed } else { 0 };
        let to_boxes = open & entry.boxed;
        let to_left = used(pairs.len()) & !(entry.live & !open | to_boxes | to_axis);
        for lane in LanesOf(to_left) {
            left.push(Left { number: entry.lot.number.0[lane], axes: [Vec3::ZERO; 2] });
        }
        boxed.push(l, &entry.lot, to_boxes);
        axis.push(l, &entry.lot, to_axis);
    }

    /// A box round and a box inside each.
    #[inline(always)]
    fn twin_boxes<L: Lanes>(&mut self, l: L) {
        let Scratch { touching, left, boxes, lot, boxed, axis, .. } = &mut *self.scratch;
        let taken = boxed.take(l, lot);
        let (settled, aligned) = boxes::twin_boxes::<L, T>(l, self.frame, boxes, (lot, taken));
        let open = used(taken);
        scatter(touching, lot, settled.touching & open);
        self.report.count(Rung::Boxes, count((settled.apart | settled.touching) & open));
        let open = open & !(settled.apart | settled.touching);
        let handed_on = match (self.frame.has_vertices(), T::HANDS_ON) {
            (false, _) => open,
            (true, true) => open & aligned,
            (true, false) => 0,
        };
        for lane in LanesOf(handed_on) {
            // The closed form of boxes needs no axis.
            left.push(Left { number: lot.number.0[lane], axes: [Vec3::ZERO; 2] });
        }
        axis.push(l, lot, open & !handed_on);
    }

    /// The axis between the centres, and the cone.
    #[inline(always)]
    fn centre_axis<L: Lanes>(&mut self, l: L) {
        let Scratch { touching, desk, lot, axis, near, second, .. } = &mut *self.scratch;
        let taken = axis.take(l, lot);
        let open = used(taken);
        let mut at = Place { frame: self.frame, desk };
        let apart = opening::centre_axis::<L, T>(l, &mut at, lot, taken) & open;
        let cone = opening::cone::<L, T>(l, lot) & open & !apart;
        scatter(touching, lot, cone);
        self.report.count(Rung::CentreAxis, count(apart));
        self.report.count(Rung::Cone, count(cone));
        let open = open & !(apart | cone);
        let rounded = l.bits(l.lt(l.splat(0.0), lot.number(l, Number::Radius)));
        second.push(l, lot, open & !rounded);
        if open & rounded != 0 {
            nearest::begin(l, lot);
            near.push(l, lot, open & rounded);
        }
    }

    /// A nearer point of two cores. Where there is none they overlap, as a portal may prove.
    #[inline(always)]
    fn nearer<L: Lanes>(&mut self, l: L) {
        let Scratch { touching, desk, lot, near, second, .. } = &mut *self.scratch;
        let taken = near.take(l, lot);
        let open = used(taken);
        let mut at = Place { frame: self.frame, desk };
        let (settled, stuck) = nearest::round::<L, T>(l, &mut at, lot, taken);
        scatter(touching, lot, settled.touching & open);
        self.report.count(Rung::Portal, count((settled.apart | settled.touching) & open));
        second.push(l, lot, stuck & open);
        near.push(l, lot, open & !(settled.apart | settled.touching | stuck));
    }

    /// The cone of two points.
    #[inline(always)]
    fn second_point<L: Lanes>(&mut self, l: L) {
        let Scratch { touching, desk, lot, second, portal, .. } = &mut *self.scratch;
        let taken = second.take(l, lot);
        let mut at = Place { frame: self.frame, desk };
        let cone = portal::second_point::<L, T>(l, &mut at, lot, taken) & used(taken);
        scatter(touching, lot, cone);
        self.report.count(Rung::Cone, count(cone));
        portal.push(l, lot, used(taken) & !cone);
    }

    /// One support, and what follows.
    #[inline(always)]
    fn round<L: Lanes>(&mut self, l: L) {
        let Scratch { touching, left, desk, lot, portal, .. } = &mut *self.scratch;
        let taken = portal.take(l, lot);
        let open = used(taken);
        let mut at = Place { frame: self.frame, desk };
        let (mut settled, mut stuck) = portal::round::<L, T>(l, &mut at, lot, taken);
        if !T::HANDS_ON {
            settled.touching |= stuck;
            stuck = 0;
        }
        scatter(touching, lot, settled.touching & open);
        self.report.count(Rung::Portal, count((settled.apart | settled.touching) & open));
        for lane in LanesOf(stuck & open) {
            left.push(Left { number: lot.number.0[lane], axes: lot.axes(lane) });
        }
        portal.push(l, lot, open & !(settled.apart | settled.touching | stuck));
    }
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
