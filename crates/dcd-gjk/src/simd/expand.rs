//! A pair of compounds as pairs of their parts: those whose boxes overlap or are within a margin, the likeliest to touch
//! apart from the others.

use super::compounds::Members;
use super::frame::{FramePair, SimdFrame};
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Aabb16, Pair};
use dcd_simd::{Kernel, Lanes, Row, WIDTH};

/// Two objects, one of them a compound at least, and where their pairs of parts are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Question {
    /// The pair's number in its slice.
    pub(super) number: u32,
    /// One past its pairs in [`Queue::rest`], which begin where the last question's end.
    pub(super) end: u32,
}

/// Pairs of parts, by their records, of some pairs of objects.
#[derive(Clone, Debug, Default)]
pub(super) struct Queue {
    pub(super) questions: Vec<Question>,
    /// For each question the pair of parts whose boxes overlap most, or are the nearest.
    pub(super) first: Vec<Pair>,
    /// All the others.
    pub(super) rest: Vec<Pair>,
    /// At most how far apart those of `first` and of `rest` are, metres; none where no margin is given.
    pub(super) gaps: [Vec<f32>; 2],
    /// How many pairs of objects there are of whose parts no boxes overlap, or are within the margin.
    pub(super) apart: u64,
}

impl Queue {
    pub(super) fn clear(&mut self) {
        self.questions.clear();
        self.first.clear();
        self.rest.clear();
        self.gaps.iter_mut().for_each(Vec::clear);
        self.apart = 0;
    }
}

/// When so many pairs of parts have come together they are resolved before there are more. No unit.
/// Larger: lists that no near cache holds. Smaller: packets that are not full.
const ENOUGH: usize = 4096;

/// Whether a pair is one for [`Expand`].
#[inline(always)]
pub(super) fn has_parts(frames: FramePair<'_>, pair: Pair) -> bool {
    let FramePair { a, b } = frames;
    let (i, j) = (a.members(pair.i).is_some(), b.members(pair.j).is_some());
    match (i, j) {
        (false, false) => false,
        (true, true) => true,
        (true, false) => b.is_live(pair.j),
        (false, true) => a.is_live(pair.i),
    }
}

/// Fills a queue from pairs of a slice, all with parts; returns how many it took.
pub(super) struct Expand<'a> {
    pub(super) frames: FramePair<'a>,
    pub(super) pairs: &'a [Pair],
    /// Which of them, by their numbers.
    pub(super) numbers: &'a [u32],
    /// How far apart boxes may be, metres; `None`: those alone that overlap.
    pub(super) margin: Option<f32>,
    pub(super) queue: &'a mut Queue,
}

impl Kernel for Expand<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> usize {
        let Self { frames: FramePair { a, b }, pairs, numbers, margin, queue } = self;
        queue.clear();
        for (taken, &number) in numbers.iter().enumerate() {
            if queue.rest.len() >= ENOUGH {
                return taken;
            }
            let pair = pairs[number as usize];
            let begin = queue.rest.len();
            let [gap_of_first, gaps] = &mut queue.gaps;
            let mut hits = Hits {
                pairs: &mut queue.rest,
                gaps: margin.map(|margin| (margin, &mut *gaps)),
                deepest: f32::NEG_INFINITY,
                at: begin,
            };
            match (a.members(pair.i), b.members(pair.j)) {
                (Some(a), Some(b)) => hits.all(l, &a, &b),
                (Some(parts), None) => {
                    let one = One { aabb: sphere_box(b, pair.j), record: pair.j, is_first: false };
                    hits.of_one(l, &parts, &one);
                }
                (None, Some(parts)) => {
                    let one = One { aabb: sphere_box(a, pair.i), record: pair.i, is_first: true };
                    hits.of_one(l, &parts, &one);
                }
                (None, None) => {}
            }
            let likeliest = hits.at;
            if queue.rest.len() == begin {
                queue.apart += 1;
                continue;
            }
            queue.first.push(queue.rest.swap_remove(likeliest));
            if margin.is_some() {
                gap_of_first.push(gaps.swap_remove(likeliest));
            }
            let end = queue.rest.len() as u32;
            queue.questions.push(Question { number, end });
        }
        numbers.len()
    }
}

/// A part or an object that is its own, beside sixteen parts of the other object.
struct One {
    aabb: Aabb,
    record: u32,
    /// Whether it is of the pair's first object.
    is_first: bool,
}

/// The pairs of parts of one pair of objects, and which is likeliest to touch.
struct Hits<'a> {
    pairs: &'a mut Vec<Pair>,
    /// How far apart boxes may be, and at most how far apart those are that were found: metres.
    gaps: Option<(f32, &'a mut Vec<f32>)>,
    /// How far its boxes overlap, metres; less than 0 where they do not.
    deepest: f32,
    /// Where it is.
    at: usize,
}

impl Hits<'_> {
    /// Of two compounds.
    #[inline(always)]
    fn all<L: Lanes>(&mut self, l: L, a: &Members<'_>, b: &Members<'_>) {
        for (group, boxes) in b.groups.iter().enumerate() {
            for (of_a, around) in a.unions.iter().enumerate() {
                let mut reaching = match &self.gaps {
                    None => boxes.overlaps(l, around),
                    Some((margin, _)) => within(l, boxes.gaps(l, around), *margin),
                };
                while reaching != 0 {
                    let lane = reaching.trailing_zeros();
                    reaching &= reaching - 1;
                    let record = b.first + (group * WIDTH) as u32 + lane;
                    let one = One { aabb: boxes.get(lane as usize), record, is_first: false };
                    self.of_group(l, (&a.groups[of_a], a.first + (of_a * WIDTH) as u32), &one);
                }
            }
        }
    }

    /// Of a compound and one object.
    #[inline(always)]
    fn of_one<L: Lanes>(&mut self, l: L, parts: &Members<'_>, one: &One) {
        for (group, boxes) in parts.groups.iter().enumerate() {
            self.of_group(l, (boxes, parts.first + (group * WIDTH) as u32), one);
        }
    }

    #[inline(always)]
    fn of_group<L: Lanes>(&mut self, l: L, group: (&Aabb16, u32), one: &One) {
        let depth = group.0.depths(l, &one.aabb);
        let (mut depths, mut gaps) = (Row::default(), Row::default());
        l.store(depth, &mut depths);
        let mut met = match &self.gaps {
            None => l.bits(l.le(l.splat(0.0), depth)),
            Some((margin, _)) => {
                let gap = group.0.gaps(l, &one.aabb);
                l.store(gap, &mut gaps);
                within(l, gap, *margin)
            }
        };
        while met != 0 {
            let lane = met.trailing_zeros();
            met &= met - 1;
            if depths.0[lane as usize] > self.deepest {
                self.deepest = depths.0[lane as usize];
                self.at = self.pairs.len();
            }
            if let Some((_, list)) = &mut self.gaps {
                list.push(gaps.0[lane as usize]);
            }
            let part = group.1 + lane;
            self.pairs.push(match one.is_first {
                true => Pair { i: one.record, j: part },
                false => Pair { i: part, j: one.record },
            });
        }
    }
}

/// The lanes whose gap is at most that.
#[inline(always)]
fn within<L: Lanes>(l: L, gap: L::F, margin: f32) -> u32 {
    l.bits(l.le(gap, l.splat(margin)))
}

/// A box round an object, from the sphere round it.
#[inline(always)]
fn sphere_box(frame: &SimdFrame, object: u32) -> Aabb {
    let record = frame.record(object);
    let [x, y, z, _] = record.centre;
    let centre = DVec3::new(x, y, z);
    let reach = f64::from(record.outer) + f64::from(record.slack);
    Aabb::outward(centre - reach, centre + reach)
}
