//! A pair of compounds as pairs of their parts: those whose boxes overlap, the likeliest apart from
//! the others.

use super::compounds::Members;
use super::decide::Left;
use super::frame::SimdFrame;
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Aabb16, Pair};
use dcd_simd::{Kernel, Lanes, Row, WIDTH};

/// Two objects, one of them a compound at least, and where their pairs of parts are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Question {
    /// The pair's number in its slice.
    pub(super) number: u32,
    /// The objects, in the order in which their parts are in a pair.
    pub(super) objects: [u32; 2],
    /// One past its pairs in [`Queue::rest`], which begin where the last question's end.
    pub(super) end: u32,
}

/// Pairs of parts, by their records, of some pairs of objects.
#[derive(Clone, Debug, Default)]
pub(super) struct Queue {
    pub(super) questions: Vec<Question>,
    /// For each question the pair of parts whose boxes overlap most.
    pub(super) first: Vec<Pair>,
    /// All the others.
    pub(super) rest: Vec<Pair>,
    /// How many pairs of objects there are of whose parts no boxes overlap.
    pub(super) apart: u64,
}

impl Queue {
    pub(super) fn clear(&mut self) {
        self.questions.clear();
        self.first.clear();
        self.rest.clear();
        self.apart = 0;
    }
}

/// When so many pairs of parts have come together they are settled before there are more. No unit.
/// Larger: lists that no near cache holds. Smaller: packets that are not full.
const ENOUGH: usize = 4096;

/// Whether a pair is one for [`Expand`].
#[inline(always)]
pub(super) fn has_parts(frame: &SimdFrame, pair: Pair) -> bool {
    let known = |object| frame.members(object).is_some() || frame.is_live(object);
    let (i, j) = (frame.members(pair.i).is_some(), frame.members(pair.j).is_some());
    (i || j) && known(pair.i) && known(pair.j)
}

/// Fills a queue from the pairs left in a slice, all with parts; returns how many it took.
pub(super) struct Expand<'a> {
    pub(super) frame: &'a SimdFrame,
    pub(super) pairs: &'a [Pair],
    pub(super) left: &'a [Left],
    pub(super) queue: &'a mut Queue,
}

impl Kernel for Expand<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> usize {
        let Self { frame, pairs, left, queue } = self;
        queue.clear();
        for (taken, left) in left.iter().enumerate() {
            if queue.rest.len() >= ENOUGH {
                return taken;
            }
            let pair = pairs[left.number as usize];
            let begin = queue.rest.len();
            let mut hits = Hits { pairs: &mut queue.rest, deepest: f32::NEG_INFINITY, at: begin };
            let objects = match (frame.members(pair.i), frame.members(pair.j)) {
                (Some(a), Some(b)) => {
                    hits.all(l, &a, &b);
                    [pair.i, pair.j]
                }
                (Some(a), None) => {
                    hits.of_one(l, &a, (&sphere_box(frame, pair.j), pair.j));
                    [pair.i, pair.j]
                }
                (None, Some(b)) => {
                    hits.of_one(l, &b, (&sphere_box(frame, pair.i), pair.i));
                    [pair.j, pair.i]
                }
                (None, None) => [pair.i, pair.j],
            };
            let likeliest = hits.at;
            if queue.rest.len() == begin {
                queue.apart += 1;
                continue;
            }
            queue.first.push(queue.rest.swap_remove(likeliest));
            let end = queue.rest.len() as u32;
            queue.questions.push(Question { number: left.number, objects, end });
        }
        left.len()
    }
}

/// The pairs of parts of one pair of objects, and which is likeliest to touch.
struct Hits<'a> {
    pairs: &'a mut Vec<Pair>,
    /// How far its boxes overlap, metres.
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
                let mut reaching = boxes.overlaps(l, around);
                while reaching != 0 {
                    let lane = reaching.trailing_zeros();
                    reaching &= reaching - 1;
                    let record = b.first + (group * WIDTH) as u32 + lane;
                    let one = (&boxes.get(lane as usize), record);
                    self.of_group(l, (&a.groups[of_a], a.first + (of_a * WIDTH) as u32), one);
                }
            }
        }
    }

    /// Of a compound and one object.
    #[inline(always)]
    fn of_one<L: Lanes>(&mut self, l: L, a: &Members<'_>, one: (&Aabb, u32)) {
        for (group, boxes) in a.groups.iter().enumerate() {
            self.of_group(l, (boxes, a.first + (group * WIDTH) as u32), one);
        }
    }

    #[inline(always)]
    fn of_group<L: Lanes>(&mut self, l: L, group: (&Aabb16, u32), one: (&Aabb, u32)) {
        let depth = group.0.depths(l, one.0);
        let mut met = l.bits(l.le(l.splat(0.0), depth));
        let mut depths = Row::default();
        l.store(depth, &mut depths);
        while met != 0 {
            let lane = met.trailing_zeros();
            met &= met - 1;
            if depths.0[lane as usize] > self.deepest {
                self.deepest = depths.0[lane as usize];
                self.at = self.pairs.len();
            }
            self.pairs.push(Pair { i: group.1 + lane, j: one.1 });
        }
    }
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
