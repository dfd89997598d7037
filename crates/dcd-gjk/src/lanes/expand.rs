//! A pair of compounds as pairs of their parts: those whose boxes overlap, the likeliest apart from
//! the others.

use super::compounds::Members;
use super::decide::Left;
use super::frame::Frame;
use dcd_geom::glam::DVec3;
use dcd_geom::lanes::{Kernel, Lanes, Row, WIDTH};
use dcd_geom::{Aabb, Pair, Sixteen};

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
/// Larger: lists that no near cache holds. Smaller: lots that are not full.
const ENOUGH: usize = 4096;

/// Whether a pair is one for [`Expand`].
#[inline(always)]
pub(super) fn has_parts(frame: &Frame, pair: Pair) -> bool {
    let known = |object| frame.members(object).is_some() || frame.is_live(object);
    let (i, j) = (frame.members(pair.i).is_some(), frame.members(pair.j).is_some());
    (i || j) && known(pair.i) && known(pair.j)
}

/// Fills a queue from the pairs left in a slice, all with parts; returns how many it took.
pub(super) struct Expand<'a> {
    pub(super) frame: &'a Frame,
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
                    hits.of_one(l, &a, (&ball_box(frame, pair.j), pair.j));
                    [pair.i, pair.j]
                }
                (None, Some(b)) => {
                    hits.of_one(l, &b, (&ball_box(frame, pair.i), pair.i));
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
    fn of_group<L: Lanes>(&mut self, l: L, group: (&Sixteen, u32), one: (&Aabb, u32)) {
        let depth = depths(l, group.0, one.0);
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

/// How far sixteen boxes overlap another, along the axis where they do least; negative where they do
/// not. The sign is exact: a difference of two numbers has that of the true one.
#[inline(always)]
fn depths<L: Lanes>(l: L, boxes: &Sixteen, one: &Aabb) -> L::F {
    let (min, max) = (one.min.to_array(), one.max.to_array());
    let mut depth = l.splat(f32::INFINITY);
    for axis in 0..3 {
        let high = l.min(l.load(&boxes.max[axis]), l.splat(max[axis]));
        let low = l.max(l.load(&boxes.min[axis]), l.splat(min[axis]));
        depth = l.min(depth, l.sub(high, low));
    }
    depth
}

/// A box round an object, from the ball round it.
#[inline(always)]
fn ball_box(frame: &Frame, object: u32) -> Aabb {
    let record = frame.record(object);
    let [x, y, z, _] = record.centre;
    let centre = DVec3::new(x, y, z);
    let reach = f64::from(record.outer) + f64::from(record.slack);
    Aabb::outward(centre - reach, centre + reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::Vec3;
    use dcd_geom::lanes::{Path, dispatch_on};

    struct Depths<'a>(&'a Sixteen, &'a Aabb);

    impl Kernel for Depths<'_> {
        type Output = Row;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Row {
            let mut row = Row::default();
            l.store(depths(l, self.0, self.1), &mut row);
            row
        }
    }

    /// The plain twin.
    fn depth(a: &Aabb, b: &Aabb) -> f32 {
        (a.max.min(b.max) - a.min.max(b.min)).min_element()
    }

    #[test]
    fn sixteen_depths_are_what_they_are_one_by_one_and_of_nothing_there_is_none() {
        let mut state = 1u32;
        let mut eighths = || {
            // The generator of Numerical Recipes.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 28) as f32 / 8.0
        };
        let mut seen = [0; 2];
        for _ in 0..200 {
            let mut draw = || {
                let min = Vec3::new(eighths(), eighths(), eighths());
                Aabb { min, max: min + Vec3::new(eighths(), eighths(), eighths()) }
            };
            let mut boxes = Sixteen::EMPTY;
            let drawn: Vec<Aabb> = (0..WIDTH - 1).map(|_| draw()).collect();
            drawn.iter().enumerate().for_each(|(k, aabb)| boxes.set(k, aabb));
            let one = draw();
            for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
                let row = dispatch_on(path, Depths(&boxes, &one)).0;
                assert_eq!(row[WIDTH - 1], f32::NEG_INFINITY);
                for (found, aabb) in row.iter().zip(&drawn) {
                    assert_eq!(*found, depth(aabb, &one));
                    assert_eq!(*found >= 0.0, aabb.overlaps(&one));
                    seen[usize::from(*found >= 0.0)] += 1;
                }
            }
        }
        assert!(seen.iter().all(|&count| count > 100), "{seen:?}");
    }
}
