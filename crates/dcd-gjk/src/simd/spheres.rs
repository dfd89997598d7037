//! Scenes of spheres: pairs are sorted by their squares in f64, sixteen at a time, and those that are not far apart answered from
//! there.

use super::frame::{FramePair, Record, spheres_of};
use crate::closed::{PlacedSphere, compare_squares};
use crate::{ContactAnswer, ContactSink, ContactsOf, Method};
use dcd_geom::Pair;
use dcd_simd::{Kernel, LaneNumbers, Lanes, Path, WIDTH, dispatch_on};

/// How many pairs are sorted before those that are near are measured: what was read of them is still in the nearest cache
/// then. No effect on any result.
const AT_ONCE: usize = 128;

/// How many pairs before it is read a record is prefetched, where scenes are large. No effect on any result.
const AHEAD: usize = 32;

/// What is made of spheres that may be near.
pub(super) trait MeasureSpheres {
    /// The answer.
    type Answer: ContactAnswer;

    /// Adds the contacts of all these pairs; or none, and returns false, where [`MeasureSpheres::measure`] is needed.
    fn measure_all(&self, near: &Near<'_>, contacts: &mut ContactsOf<Self::Answer>) -> bool;

    /// Adds the pair's contact; false where f64 does not say what it is, or that there is one.
    fn measure(&self, pair: NearPair, contacts: &mut ContactsOf<Self::Answer>) -> bool;

    /// Resolves a pair of which that is false. Out of line.
    fn resolve(&mut self, pair: Pair, sink: &mut ContactSink<'_, Self::Answer>);
}

/// A pair that is not proved to be far apart.
pub(super) struct NearPair {
    pub(super) pair: Pair,
    pub(super) spheres: [PlacedSphere; 2],
    /// Whether they are proved to touch.
    pub(super) touches: bool,
}

/// The pairs of some that are not proved to be far apart, in their order.
pub(super) struct Near<'a> {
    records: [&'a [Record]; 2],
    pairs: &'a [Pair],
    sorted: &'a Sorted,
}

impl<'a> Near<'a> {
    /// Each pair, and whether it is proved to touch.
    #[inline(always)]
    pub(super) fn pairs(&self) -> impl Iterator<Item = (Pair, bool)> + 'a {
        let Self { pairs, sorted, .. } = *self;
        sorted.near.iter().map(
            #[inline(always)]
            move |&number| {
                let number = number as usize;
                let sixteen = sorted.touching[number / WIDTH % SIXTEENS];
                (pairs[number], sixteen >> (number % WIDTH) & 1 == 1)
            },
        )
    }

    /// How many are not proved to touch.
    #[inline(always)]
    pub(super) fn count_of_open(&self) -> usize {
        self.sorted.open.len()
    }

    /// The spheres of those.
    #[inline(always)]
    pub(super) fn open(&self) -> impl Iterator<Item = Option<[PlacedSphere; 2]>> + 'a {
        let Self { records, pairs, sorted } = *self;
        sorted.open.iter().map(
            #[inline(always)]
            move |&number| spheres_of(records, pairs[number as usize]),
        )
    }
}

/// Resolves pairs of spheres.
pub(super) fn decide<M: MeasureSpheres>(
    path: Path,
    (frames, pairs, margin): (FramePair<'_>, &[Pair], f64),
    measure: M,
    sink: &mut ContactSink<'_, M::Answer>,
) {
    let left = dispatch_on(path, Decide { frames, pairs, margin, measure, sink: &mut *sink });
    sink.report.count(Method::Spheres, (pairs.len() - left) as u64);
}

/// The contacts of spheres.
struct Decide<'a, 'b, M: MeasureSpheres> {
    frames: FramePair<'a>,
    pairs: &'a [Pair],
    /// Metres.
    margin: f64,
    measure: M,
    sink: &'a mut ContactSink<'b, M::Answer>,
}

impl<M: MeasureSpheres> Kernel for Decide<'_, '_, M> {
    /// How many pairs were not resolved in f64.
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> usize {
        let Self { frames, pairs, margin, mut measure, sink } = self;
        let mut sorted = Sorted::default();
        let mut left = 0;
        for (number, chunk) in pairs.chunks(AT_ONCE).enumerate() {
            let later = pairs.get(number * AT_ONCE + AHEAD..).unwrap_or_default();
            sorted.sort(l, frames, (chunk, later), margin);
            let records = [frames.a.records(), frames.b.records()];
            let near = Near { records, pairs: chunk, sorted: &sorted };
            if measure.measure_all(&near, sink.contacts) {
                continue;
            }
            for (pair, touches) in near.pairs() {
                let spheres = spheres_of(records, pair);
                let found = spheres.map(|spheres| NearPair { pair, spheres, touches });
                if !found.is_some_and(|found| measure.measure(found, sink.contacts)) {
                    measure.resolve(pair, sink);
                    left += 1;
                }
            }
        }
        left
    }
}

/// How many groups of sixteen are sorted at once.
const SIXTEENS: usize = AT_ONCE / WIDTH;

/// The numbers of the pairs that are near.
#[derive(Default)]
struct Sorted {
    near: LaneNumbers<{ AT_ONCE + 2 * WIDTH }>,
    /// Those that are not proved to touch.
    open: LaneNumbers<{ AT_ONCE + 2 * WIDTH }>,
    /// Which of all are, sixteen by sixteen.
    touching: [u32; SIXTEENS],
}

impl Sorted {
    /// Sorts at most [`AT_ONCE`] pairs; `later` ones are prefetched.
    #[inline(always)]
    fn sort<L: Lanes>(
        &mut self,
        l: L,
        frames: FramePair<'_>,
        (pairs, later): (&[Pair], &[Pair]),
        margin: f64,
    ) {
        self.near.clear();
        self.open.clear();
        let records = [frames.a.records(), frames.b.records()];
        let mut later = if frames.are_near() { &[] } else { later }.chunks(WIDTH);
        let mut filled = [Pair::default(); AT_ONCE];
        let sixteens = filled_up(pairs, &mut filled).as_chunks().0;
        for (number, sixteen) in sixteens.iter().enumerate() {
            for pair in later.next().unwrap_or_default() {
                frames.a.prefetch(pair.i);
                frames.b.prefetch(pair.j);
            }
            let [beyond, touching] = compare_sixteen(l, records, sixteen, margin);
            let first = number * WIDTH;
            let near = !beyond & (0xffff >> WIDTH.saturating_sub(pairs.len() - first));
            self.touching[number % SIXTEENS] = touching;
            self.near.push(l, near, first);
            self.open.push(l, near & !touching, first);
        }
    }
}

/// [`compare_squares`] of sixteen pairs.
#[inline(always)]
fn compare_sixteen<L: Lanes>(
    l: L,
    records: [&[Record]; 2],
    pairs: &[Pair; WIDTH],
    margin: f64,
) -> [u32; 2] {
    let mut found = [0; 2];
    for (half, eight) in pairs.as_chunks().0.iter().enumerate() {
        let [beyond, touching] = compare_squares(l, l.sphere_pairs(records, eight), margin);
        found[0] |= beyond << (half * WIDTH / 2);
        found[1] |= touching << (half * WIDTH / 2);
    }
    found
}

/// At most [`AT_ONCE`] pairs, with the last of them repeated up to a number of sixteens.
#[inline(always)]
fn filled_up<'a>(pairs: &'a [Pair], filled: &'a mut [Pair; AT_ONCE]) -> &'a [Pair] {
    let Some(last) = pairs.last().filter(|_| !pairs.len().is_multiple_of(WIDTH)) else {
        return pairs;
    };
    filled.fill(*last);
    filled[..pairs.len()].copy_from_slice(pairs);
    &filled[..pairs.len().next_multiple_of(WIDTH)]
}
