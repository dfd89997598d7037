//! A slice of pairs on its way through the stages.

mod masks;
mod measured;
mod stages;

use super::axis::hinted;
use super::axis_aligned;
use super::by_parts;
use super::certificate::{ErrorBounds, KeptProof};
use super::expand;
use super::first_stages::{self, Entry, Place, Resolved};
use super::frame::{AXIS_ALIGNED, BOX, FramePair, LIVE, SimdFrame};
use super::kept_proofs::KeptProofs;
use super::kind_order::KindOrder;
use super::nearest_points::Found;
use super::obb::{self, ObbPairs};
use super::packet::{
    AFTER_CONE, AFTER_NEAREST, AFTER_SECOND_POINT, AFTER_SPHERES, LanesOf, Number, PacketQueue,
    PairPacket, Vector, Whole,
};
use super::portal;
use super::prefetch::Prefetch;
use super::simplex;
use super::straight::Straight;
use super::support::SupportScratch;
use super::touching_parts::TouchingParts;
use crate::{Method, PosedShape, Prepared, Report, Verdict, certified, mesh};
use dcd_geom::Pair;
use dcd_geom::glam::Vec3;
use dcd_simd::{Block, Kernel, Lanes, Path, WIDTH, dispatch_on};
use masks::{are_alike, count, mark, marked, scatter, used};
use measured::Measured;
use stages::Stage;
use std::marker::PhantomData;

/// What a thread reuses from slice to slice.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// For each pair of the slice, whether it is known to touch.
    touching: Vec<bool>,
    /// Where proofs are to last.
    kept: KeptProofs,
    /// Where distances are to be measured.
    pub(super) measured: Measured,
    left: Vec<Left>,
    left_order: KindOrder<Left>,
    ahead: Prefetch,
    support_scratch: SupportScratch,
    entry: Entry,
    boxes: ObbPairs,
    /// Where the later stages work.
    packet: PairPacket,
    /// What waits for the nearest points of spheres, capsules and cuboids.
    straight: Straight,
    /// What waits for the inner and outer OBBs.
    boxed: PacketQueue<AFTER_SPHERES>,
    /// What waits for the centre axis.
    axis: PacketQueue<AFTER_SPHERES>,
    /// What waits for the next support of rounded shapes.
    near: PacketQueue<AFTER_SECOND_POINT>,
    /// What waits for the next support of a search for nearest points.
    search: PacketQueue<AFTER_NEAREST>,
    /// What waits for the second point.
    second: PacketQueue<AFTER_CONE>,
    /// What waits for the next support.
    portal: PacketQueue<AFTER_SECOND_POINT>,
    /// For what is made of parts.
    pub(super) parts: mesh::Scratch,
    /// Which parts touch, where a measure of them follows.
    pub(super) touching_parts: TouchingParts,
    /// For those of them whose parts the lanes know.
    pub(super) by_parts: by_parts::Scratch,
    /// The numbers of the pairs of these.
    with_parts: Vec<u32>,
}

impl Scratch {
    /// For each pair of the slice judged last, whether it is known to touch.
    pub(crate) fn touching(&self) -> &[bool] {
        &self.touching
    }

    /// What was kept of them, if proofs are to last.
    pub(crate) fn kept(&self) -> &KeptProofs {
        &self.kept
    }

    /// Exchanges where the next answers are written, and what is left open.
    pub(super) fn lend(&mut self, touching: &mut Vec<bool>, left: &mut Vec<Left>) {
        std::mem::swap(&mut self.touching, touching);
        std::mem::swap(&mut self.left, left);
    }

    /// Exchanges where it is written what was found of the pairs that are measured.
    pub(super) fn lend_found(&mut self, found: &mut Vec<Found>) {
        std::mem::swap(&mut self.measured.found, found);
    }

    /// To be written before a slice is judged by proofs that are to last.
    pub(crate) fn kept_mut(&mut self) -> &mut KeptProofs {
        &mut self.kept
    }
}

/// After how many supports, from the second point on, a pair that has a proof keeps the clearance that
/// it has. Larger: more pairs are known in the next steps. Smaller: a faster first step.
const WIDENING: f32 = 4.0;

/// A pair that the lanes leave open.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Left {
    /// Its number in the slice.
    pub(super) number: u32,
    /// Between the centres, and where the search ended: perhaps one separates. World axes, from b
    /// to a.
    pub(super) axes: [Vec3; 2],
}

/// Some pairs of an object of one side with one of the other.
pub struct Slice<'a> {
    pub(crate) path: Path,
    pub(crate) a: Prepared<'a, SimdFrame>,
    pub(crate) b: Prepared<'a, SimdFrame>,
    pub(crate) pairs: &'a [Pair],
}

impl<'a> Slice<'a> {
    pub(super) fn frames(&self) -> FramePair<'a> {
        FramePair { a: self.a.frame, b: self.b.frame }
    }

    /// Decides in lanes first, then one pair at a time what they leave open. `OverlapUnchecked` leaves open only
    /// shapes without vertices, and sizes outside f32's range.
    pub(crate) fn judge<T: ErrorBounds>(&self, scratch: &mut Scratch, report: &mut Report) {
        let Self { path, pairs, .. } = *self;
        let (bounds, frames) = (PhantomData::<T>, self.frames());
        dispatch_on(path, Decide { bounds, frames, pairs, scratch, report: &mut *report });
        self.judge_by_parts(scratch, report);
        scratch.left.retain(|left| {
            let number = left.number as usize;
            let Some((touch, method)) = axis_aligned::touch(frames, pairs[number]) else {
                return true;
            };
            report.count(method, 1);
            scratch.touching[number] = touch;
            false
        });
        // What is measured next comes in the order in which it is found.
        if scratch.touching_parts.is_wanted() {
            scratch.left_order.sort((frames, pairs), &mut scratch.left, |left| left.number);
        }
        for left in &scratch.left {
            let (kept, parts) = (&mut scratch.touching_parts, &mut scratch.parts);
            let known = Known { axes: left.axes, parts, kept };
            let touches = self.resolve(left.number, known, report);
            scratch.touching[left.number as usize] = touches;
        }
    }

    /// Takes out of the pairs left open those whose parts the lanes know, and resolves them.
    fn judge_by_parts(&self, scratch: &mut Scratch, report: &mut Report) {
        let frames = self.frames();
        if !frames.have_compounds() {
            return;
        }
        let mut with_parts = std::mem::take(&mut scratch.with_parts);
        let has_parts =
            |left: &mut Left| expand::has_parts(frames, self.pairs[left.number as usize]);
        with_parts.clear();
        with_parts.extend(scratch.left.extract_if(.., has_parts).map(|left| left.number));
        if scratch.touching_parts.is_wanted() {
            with_parts.sort_unstable();
        }
        let mut touching = std::mem::take(&mut scratch.touching);
        by_parts::judge(self, &with_parts, scratch, (&mut touching, report));
        (scratch.touching, scratch.with_parts) = (touching, with_parts);
    }

    /// The later methods for one pair that the lanes left open: the lanes' own axes in f64, then f64
    /// from the start, then exact integers. Whether it is known to touch.
    fn resolve(&self, number: u32, known: Known<'_>, report: &mut Report) -> bool {
        let Known { axes, parts, kept } = known;
        let pair = self.pairs[number as usize];
        let a = PosedShape::of(self.a.scene, pair.i);
        let b = PosedShape::of(self.b.scene, pair.j);
        let (verdict, method) = if kept.is_wanted() && mesh::are_mesh_and_polytope(a.shape, b.shape)
        {
            kept.search(self.path, (number, [a, b]), parts)
        } else if mesh::have_parts(a.shape, b.shape) {
            // No axis of the lanes is one of parts.
            mesh::overlap(a, b, parts)
        } else {
            let axes = axes.map(|axis| axis.as_dvec3());
            certified::overlap_with_after(&axes, a, b, parts)
        };
        match verdict {
            Verdict::Undecided(reason) => report.leave(pair, reason),
            Verdict::Apart | Verdict::Touching(()) => report.count(method, 1),
        }
        verdict == Verdict::Touching(())
    }
}

/// What the later methods are handed beside a pair.
struct Known<'a> {
    axes: [Vec3; 2],
    parts: &'a mut mesh::Scratch,
    kept: &'a mut TouchingParts,
}

/// Resolves in lanes what can be resolved of a slice of pairs.
pub(super) struct Decide<'a, T> {
    /// Whether the answers carry error bounds.
    pub(super) bounds: PhantomData<T>,
    pub(super) frames: FramePair<'a>,
    pub(super) pairs: &'a [Pair],
    pub(super) scratch: &'a mut Scratch,
    pub(super) report: &'a mut Report,
}

impl<T: ErrorBounds> Kernel for Decide<'_, T> {
    type Output = ();

    /// Every stage hands on what it leaves open, and works whenever a whole packet has come together.
    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let pairs = self.pairs;
        self.scratch.touching.clear();
        self.scratch.touching.resize(pairs.len(), false);
        if T::KEEPS != KeptProof::Nothing {
            self.scratch.kept.begin(pairs.len());
        }
        if T::KEEPS == KeptProof::Gap {
            self.scratch.measured.begin(pairs.len());
        }
        self.scratch.left.clear();
        self.scratch.ahead.look(self.frames, pairs.chunks(WIDTH).next().unwrap_or_default());
        self.scratch.ahead.look(self.frames, pairs.chunks(WIDTH).nth(1).unwrap_or_default());
        let mut first = 0;
        loop {
            let whole = if first < pairs.len() { Whole::Only } else { Whole::OrLast };
            if whole == Whole::Only {
                self.open(l, first);
                first += WIDTH;
            }
            while let Some(stage) = self.scratch.latest_stage(whole) {
                match stage {
                    Stage::Portal => self.round(l),
                    Stage::SecondPoint => self.second_point(l),
                    Stage::Nearest => self.nearer(l),
                    Stage::Search => self.measure(l, stage),
                    Stage::CentreAxis if T::KEEPS == KeptProof::Gap => self.measure(l, stage),
                    Stage::CentreAxis => self.first_axis(l),
                    Stage::Obbs => self.obbs(l),
                    Stage::Straight => self.nearest_of_straight(l, whole),
                }
            }
            if whole == Whole::OrLast {
                break;
            }
        }
    }
}

impl<T: ErrorBounds> Decide<'_, T> {
    /// Reads sixteen pairs and tries their spheres.
    #[inline(always)]
    fn open<L: Lanes>(&mut self, l: L, first: usize) {
        let Scratch { touching, kept, left, ahead, entry, straight, boxed, axis, .. } =
            &mut *self.scratch;
        let later = self.pairs.get(first + 2 * WIDTH..).unwrap_or_default();
        ahead.look(self.frames, &later[..later.len().min(WIDTH)]);
        let pairs = &self.pairs[first..self.pairs.len().min(first + WIDTH)];
        entry.read::<T>(self.frames, pairs, first as u32);
        let spheres = entry.spheres::<L, T>(l);
        mark(&mut touching[first..], spheres.touching);
        self.report.count(Method::Spheres, count(spheres.all()));
        let open = entry.live & !spheres.all();
        let mut narrow = 0;
        match T::KEEPS {
            KeptProof::Nothing => {}
            KeptProof::Gap => kept.note_gaps(l, &entry.packet, (spheres.clearance, spheres.apart)),
            KeptProof::Clearance => {
                let noted = (spheres.clearance, spheres.all());
                narrow = spheres.all() & !kept.note(l, &entry.packet, noted);
            }
        }
        let to_formulas = match T::HANDS_ON && self.frames.have_straight_cores() {
            true => straight.push(l, self.frames, (&entry.packet, open | narrow)),
            false => 0,
        };
        let to_axis = if self.frames.have_vertices() { (open | narrow) & !entry.boxed } else { 0 };
        let to_axis = to_axis & !to_formulas;
        // Their closed form costs less than the boxes and leaves none open; but its proof is not one that lasts.
        let closed =
            T::HANDS_ON && T::KEEPS != KeptProof::Clearance && entry.marks & AXIS_ALIGNED != 0;
        let upright =
            if closed { marked(self.frames, &entry.packet, open, AXIS_ALIGNED) } else { 0 };
        // Of meshes the boxes are worth while where neither object is far larger: a terrain's hold all that is near it.
        let is_tried = T::HANDS_ON && T::KEEPS != KeptProof::Clearance;
        let alone = match is_tried && entry.boxed_alone != 0 {
            true => are_alike(self.frames, &entry.packet, entry.boxed_alone),
            false => 0,
        };
        let to_boxes = open & entry.boxed & !(upright | to_formulas) | alone;
        let to_left = used(pairs.len()) & !(spheres.all() | to_boxes | to_axis | to_formulas);
        for lane in LanesOf(to_left) {
            left.push(Left { number: entry.packet.number.0[lane], axes: [Vec3::ZERO; 2] });
        }
        boxed.push(l, &entry.packet, to_boxes);
        axis.push(l, &entry.packet, to_axis);
    }

    /// The nearest points of spheres, capsules and cuboids.
    #[inline(always)]
    fn nearest_of_straight<L: Lanes>(&mut self, l: L, whole: Whole) {
        let Scratch { packet, straight, .. } = &mut *self.scratch;
        let (taken, resolved) = straight.resolve(l, self.frames, packet, whole);
        let done = self.resolve(l, Method::Portal, resolved, used(taken));
        self.scratch.axis.push(l, &self.scratch.packet, used(taken) & !done);
    }

    /// A box round and a box inside each.
    #[inline(always)]
    fn obbs<L: Lanes>(&mut self, l: L) {
        let Scratch { left, boxes, packet, boxed, .. } = &mut *self.scratch;
        let taken = boxed.take(l, packet);
        let (resolved, aligned) = obb::obbs::<L, T>(l, self.frames, boxes, (packet, taken));
        let open = used(taken) & !resolved.all();
        let handed_on = match (self.frames.have_vertices(), T::HANDS_ON) {
            (false, _) => open,
            // A round or a hull between its boxes is not them.
            (true, true) => marked(self.frames, packet, open & aligned, BOX),
            (true, false) => 0,
        };
        // No stage but this knows a mesh.
        let handed_on = match T::HANDS_ON && self.frames.have_parts() {
            true => handed_on | open & !marked(self.frames, packet, open, LIVE),
            false => handed_on,
        };
        for lane in LanesOf(handed_on) {
            // The closed form of boxes needs no axis.
            left.push(Left { number: packet.number.0[lane], axes: [Vec3::ZERO; 2] });
        }
        self.resolve(l, Method::Obbs, resolved, used(taken));
        self.scratch.axis.push(l, &self.scratch.packet, open & !handed_on);
    }

    /// The axis between the centres, or one that separated before, and the cone.
    #[inline(always)]
    fn first_axis<L: Lanes>(&mut self, l: L) {
        let Scratch { support_scratch, packet, axis, kept, .. } = &mut *self.scratch;
        let taken = axis.take(l, packet);
        let mut at = Place { frames: self.frames, support_scratch };
        let mut first = packet.vector(l, Vector::C);
        if T::KEEPS == KeptProof::Clearance {
            first = hinted(l, &kept.axes, (packet, taken), first);
        }
        let apart = first_stages::first_axis::<L, T>(l, &mut at, (packet, taken), first);
        let apart = Resolved::apart(l, apart);
        let cone = Resolved::touching(l, first_stages::cone::<L, T>(l, packet)).but(apart);
        let done = self.resolve(l, Method::CentreAxis, apart, used(taken))
            | self.resolve(l, Method::Cone, cone, used(taken));
        let Scratch { packet, near, second, .. } = &mut *self.scratch;
        let open = used(taken) & !done;
        let rounded = l.bits(l.lt(l.splat(0.0), packet.number(l, Number::Radius)));
        // Nearer points also show how far two are apart.
        let to_near = open & (rounded | apart.all());
        second.push(l, packet, open & !to_near);
        if to_near != 0 {
            simplex::begin(l, packet);
            near.push(l, packet, to_near);
        }
    }

    /// A nearer point of two cores. Where there is none they overlap, as a portal may prove.
    #[inline(always)]
    fn nearer<L: Lanes>(&mut self, l: L) {
        let Scratch { support_scratch, packet, near, .. } = &mut *self.scratch;
        let taken = near.take(l, packet);
        let mut at = Place { frames: self.frames, support_scratch };
        let (resolved, stuck) = simplex::round::<L, T>(l, &mut at, packet, taken);
        let done = self.resolve(l, Method::Portal, resolved, used(taken));
        let (proved, enough) = self.narrow(l);
        let Scratch { packet, near, second, .. } = &mut *self.scratch;
        second.push(l, packet, stuck & used(taken) & !proved);
        near.push(l, packet, used(taken) & !(done | stuck | enough));
    }

    /// The cone of two points.
    #[inline(always)]
    fn second_point<L: Lanes>(&mut self, l: L) {
        let Scratch { support_scratch, packet, second, .. } = &mut *self.scratch;
        let taken = second.take(l, packet);
        let mut at = Place { frames: self.frames, support_scratch };
        let cone = portal::second_point::<L, T>(l, &mut at, packet, taken);
        let cone = Resolved::touching(l, cone);
        let done = self.resolve(l, Method::Cone, cone, used(taken));
        self.scratch.portal.push(l, &self.scratch.packet, used(taken) & !done);
    }

    /// One support, and what follows.
    #[inline(always)]
    fn round<L: Lanes>(&mut self, l: L) {
        let Scratch { support_scratch, packet, portal, .. } = &mut *self.scratch;
        let taken = portal.take(l, packet);
        let mut at = Place { frames: self.frames, support_scratch };
        let mut against = Block::default();
        if T::KEEPS == KeptProof::Clearance {
            packet.vector(l, Vector::D).store(l, &mut against.0);
        }
        let (mut resolved, mut stuck) = portal::round::<L, T>(l, &mut at, packet, taken);
        if !T::HANDS_ON {
            resolved.touching |= stuck;
            stuck = 0;
        }
        let done = self.resolve(l, Method::Portal, resolved, used(taken));
        let (proved, enough) = self.narrow(l);
        let Scratch { left, packet, portal, kept, .. } = &mut *self.scratch;
        for lane in LanesOf(stuck & used(taken) & !proved) {
            left.push(Left { number: packet.number.0[lane], axes: packet.axes(lane) });
        }
        if T::KEEPS == KeptProof::Clearance {
            kept.note_axes(packet, &against, resolved.apart & used(taken));
        }
        portal.push(l, packet, used(taken) & !(done | stuck | enough));
    }

    /// Records what a stage resolved of the lanes in use. Returns the lanes that need no other stage.
    #[inline(always)]
    fn resolve<L: Lanes>(&mut self, l: L, method: Method, resolved: Resolved<L>, used: u32) -> u32 {
        let Scratch { touching, kept, packet, .. } = &mut *self.scratch;
        let proved = resolved.all() & used;
        scatter(touching, packet, resolved.touching & used);
        if T::KEEPS != KeptProof::Clearance {
            self.report.count(method, count(proved));
            if T::KEEPS == KeptProof::Gap {
                kept.note_gaps(l, packet, (resolved.clearance, resolved.apart & used));
            }
            return proved;
        }
        self.report.count(method, count(proved & !kept.proved(packet)));
        kept.note(l, packet, (resolved.clearance, proved))
    }

    /// The lanes whose proof has less clearance than wanted, and those of them that have taken
    /// [`WIDENING`] supports.
    #[inline(always)]
    fn narrow<L: Lanes>(&self, l: L) -> (u32, u32) {
        if T::KEEPS != KeptProof::Clearance {
            return (0, 0);
        }
        let proved = self.scratch.kept.proved(&self.scratch.packet);
        let round = self.scratch.packet.number(l, Number::Round);
        (proved, proved & l.bits(l.le(l.splat(WIDENING), round)))
    }
}
