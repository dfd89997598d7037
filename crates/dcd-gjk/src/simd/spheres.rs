//! Scenes of spheres: what is far apart goes by its squares in f64, the rest is measured where its answer is written.

use super::frame::{FramePair, Record, spheres_of};
use crate::closed::{PlacedSphere, squares_are_beyond};
use crate::{ContactAnswer, ContactSink, ContactsOf, Method};
use dcd_geom::Pair;
use dcd_simd::{Kernel, Lanes, Path, dispatch_on};

/// How many pairs are sorted before those that are near are measured: what was read of them is still in the nearest cache
/// then. No effect on any result.
const AT_ONCE: usize = 128;

/// How many pairs before it is read a record is prefetched, where scenes are large. No effect on any result.
const AHEAD: usize = 32;

/// What is made of two spheres that may be near.
pub(super) trait MeasureSpheres {
    /// The answer.
    type Answer: ContactAnswer;

    /// Adds the pair's contact; false where f64 does not say what it is, or that there is one.
    fn measure(
        &self,
        spheres: [PlacedSphere; 2],
        pair: Pair,
        contacts: &mut ContactsOf<Self::Answer>,
    ) -> bool;

    /// Resolves a pair of which that is false. Out of line.
    fn resolve(&mut self, pair: Pair, sink: &mut ContactSink<'_, Self::Answer>);
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

/// The contacts of spheres. A kernel for the CPU's instructions alone.
struct Decide<'a, 'b, M: MeasureSpheres> {
    frames: FramePair<'a>,
    pairs: &'a [Pair],
    /// Metres.
    margin: f64,
    measure: M,
    sink: &'a mut ContactSink<'b, M::Answer>,
}

impl<M: MeasureSpheres> Kernel for Decide<'_, '_, M> {
    /// How many pairs were resolved by themselves.
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> usize {
        let Self { frames, pairs, margin, mut measure, sink } = self;
        let records = [frames.a.records(), frames.b.records()];
        let prefetched = if frames.are_near() { &[] } else { pairs };
        let mut near = [Pair::default(); AT_ONCE];
        let mut left = 0;
        for (number, chunk) in pairs.chunks(AT_ONCE).enumerate() {
            let mut count = 0;
            let later = prefetched.get(number * AT_ONCE + AHEAD..).unwrap_or_default();
            for (place, &pair) in chunk.iter().enumerate() {
                if let Some(later) = later.get(place) {
                    frames.a.prefetch(later.i);
                    frames.b.prefetch(later.j);
                }
                // Written whether it is near or not: a branch that no predictor knows costs more.
                near[count] = pair;
                count += usize::from(!are_beyond(records, pair, margin));
            }
            for &pair in &near[..count] {
                let spheres = spheres_of(records, pair);
                if !spheres.is_some_and(|both| measure.measure(both, pair, sink.contacts)) {
                    measure.resolve(pair, sink);
                    left += 1;
                }
            }
        }
        left
    }
}

/// Whether they are proved to be farther apart than a margin; never of what are no spheres.
#[inline(always)]
fn are_beyond(records: [&[Record]; 2], pair: Pair, margin: f64) -> bool {
    spheres_of(records, pair).is_some_and(|both| squares_are_beyond(both, margin))
}
