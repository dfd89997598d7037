//! The pairs that the lanes search, in an order in which neighbours are alike.

use super::super::frame::{BOX, FramePair, Record, SPHERE, STRAIGHT_CORE, SimdFrame, WHOLE};
use super::super::straight::CoreForm;
use crate::Accuracy;
use dcd_geom::Pair;
use dcd_geom::glam::DVec3;

/// The pairs that are searched: those of like shapes together, for what one of them takes the next one does, so that its
/// branches are predicted. Of like shapes the first comes first.
#[derive(Debug, Default)]
pub(super) struct Searched {
    /// Their numbers among those that touch.
    pub(super) numbers: Vec<u32>,
    /// The pairs, in the order of their numbers there.
    pub(super) pairs: Vec<Pair>,
    /// The numbers by what they are pairs of: with a cuboid, with a capsule, and others.
    alike: [Vec<u32>; 3],
}

impl Searched {
    /// Forgets all.
    pub(super) fn begin(&mut self) {
        self.alike.iter_mut().for_each(Vec::clear);
    }

    /// Takes in the pair of that number among those that touch.
    #[inline(always)]
    pub(super) fn push(&mut self, frames: FramePair<'_>, (number, pair): (u32, Pair)) {
        let either = frames.a.record(pair.i).marks | frames.b.record(pair.j).marks;
        let of_others = if either & STRAIGHT_CORE != 0 { 1 } else { 2 };
        let like = if either & BOX != 0 { 0 } else { of_others };
        self.alike[like].push(number);
    }

    /// Brings the lists together. Needed behind the last of the pairs that touch: these.
    pub(super) fn end(&mut self, touching: &[Pair]) {
        let Self { numbers, pairs, alike } = self;
        numbers.clear();
        alike.iter().for_each(|alike| numbers.extend(alike));
        pairs.clear();
        pairs.extend(numbers.iter().map(|&number| touching[number as usize]));
    }
}

/// Whether the lanes search a pair, as far as the records show: both have vertices, all of one's own or, at the accuracy of f32,
/// of a hull inside it, and no formula is known.
/// [`SearchedPair::of`](super::confirm::SearchedPair::of) finds the others out.
#[inline(always)]
pub(super) fn may_be_searched(frames: FramePair<'_>, pair: Pair, accuracy: Accuracy) -> bool {
    let (a, b) = (frames.a.record(pair.i), frames.b.record(pair.j));
    a.blocks > 0
        && b.blocks > 0
        && (accuracy == Accuracy::F32 || are_whole(frames, pair))
        && !has_formula(a, b, accuracy)
}

/// Whether the vertices that the lanes have are those of the cores, and not of hulls inside them.
#[inline(always)]
pub(super) fn are_whole(frames: FramePair<'_>, pair: Pair) -> bool {
    frames.a.record(pair.i).marks & frames.b.record(pair.j).marks & WHOLE != 0
}

/// Whether a pair surely has a formula, by what is prepared of both: straight cores with a radius, with each other or a cuboid;
/// at the accuracy of f32 also a sphere and any other.
#[inline(always)]
fn has_formula(a: &Record, b: &Record, accuracy: Accuracy) -> bool {
    let is_of_sphere = accuracy == Accuracy::F32 && (a.marks | b.marks) & SPHERE != 0;
    let is_swept = a.radius > 0.0 || b.radius > 0.0;
    is_swept && (is_of_sphere || CoreForm::of(a, b) != CoreForm::Others)
}

/// Whether only the radii of a searched pair are likely to overlap, and not the cores: these are swept, and no segment or centre
/// of one is within the sphere inside the other. Decides what is tried first; either way what is not found is tried the other.
#[inline(always)]
pub(super) fn are_cores_apart(frames: FramePair<'_>, pair: Pair) -> bool {
    let (a, b) = (frames.a.record(pair.i), frames.b.record(pair.j));
    if !(a.radius > 0.0 || b.radius > 0.0) {
        return false;
    }
    let centre = |record: &Record| DVec3::from_slice(&record.centre[..3]);
    let c = centre(b) - centre(a);
    // Hardly ever both.
    let end = end(frames.a, a) + end(frames.b, b);
    let square = end.length_squared();
    let share = if square > 0.0 { (c.dot(end) / square).clamp(-1.0, 1.0) } else { 0.0 };
    let inner = |record: &Record| f64::from(record.inner - record.radius);
    (c - end * share).length() > inner(a) + inner(b)
}

/// From the middle of a straight core to one of its ends; zero of others.
#[inline(always)]
fn end(frame: &SimdFrame, record: &Record) -> DVec3 {
    if record.marks & STRAIGHT_CORE == 0 {
        return DVec3::ZERO;
    }
    frame.blocks()[record.first as usize].point(0).as_dvec3()
}

#[cfg(test)]
mod tests;
