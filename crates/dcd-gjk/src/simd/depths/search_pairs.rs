//! Many pairs that are searched side by side, each to its end.

use super::super::frame::SimdFrame;
use super::super::scene_pairs::ScenePairs;
use super::answers::WriteDepth;
use super::confirm::{Ended, SearchedPair, Side};
use super::proposed::Proposal;
use super::search::{DepthSearch, Next};
use super::start::Starts;
use super::surface::{Point, Surface};
use crate::Accuracy;
use dcd_simd::{Kernel, Lanes, Path, dispatch_on};

/// How many pairs are searched side by side: the supports of one do not wait for the faces of another. No effect on any
/// result. Larger: surfaces that leave the nearest cache. Smaller: arithmetic that waits.
pub(super) const SEATS: usize = 8;

/// Searches the pairs.
pub(super) struct SearchPairs<'a> {
    pub(super) objects: ScenePairs<'a>,
    /// Their numbers among the touching ones.
    pub(super) numbers: &'a [u32],
    /// Which of them is searched next.
    pub(super) place: usize,
    pub(super) accuracy: Accuracy,
    pub(super) surfaces: &'a mut [Surface; SEATS],
    pub(super) starts: &'a mut Starts,
    /// What of each the search starts with, if something is proposed.
    pub(super) proposals: &'a [Option<Proposal>],
    /// The numbers of the swept pairs whose cores do not overlap, as far as f32 knows.
    pub(super) apart: &'a mut Vec<u32>,
    /// Whether the facets of a pair are read where its answer is written.
    pub(super) reads_facets: bool,
    /// Whether what the next pairs read is prefetched.
    pub(super) looks_ahead: bool,
    pub(super) answers: &'a mut dyn WriteDepth,
}

/// A pair that is being searched.
struct Seat<'a> {
    /// Its number among the touching ones.
    number: usize,
    pair: SearchedPair<'a>,
    search: DepthSearch,
    /// The support that was evaluated last.
    point: Point,
}

impl Kernel for SearchPairs<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let mut seats = [const { None }; SEATS];
        // What the answer of a pair reads and writes is prefetched when its search ends. It has come when that of the next
        // one ends: only then is the answer written.
        let mut last = None;
        loop {
            let mut is_idle = true;
            for (number, seat) in seats.iter_mut().enumerate() {
                if seat.is_none() {
                    *seat = self.next(l, number);
                }
                is_idle &= seat.is_none();
            }
            if is_idle {
                break;
            }
            for seat in seats.iter_mut().flatten() {
                seat.point = seat.search.support(l, &seat.pair.cloud);
            }
            for (place, surface) in seats.iter_mut().zip(&mut *self.surfaces) {
                let Some(seat) = place else { continue };
                let found = match seat.search.take(l, seat.point, surface) {
                    Next::Support => continue,
                    Next::Ended { nearest, reach } => {
                        self.answers.prefetch(seat.number);
                        if self.reads_facets && self.looks_ahead {
                            seat.pair.prefetch_half_edges(&seat.point);
                        }
                        let ended = Ended { surface, nearest, reach, farthest: seat.point };
                        seat.pair.depth(l, self.accuracy, &ended)
                    }
                    Next::Failed => None,
                };
                if found.is_none() && seat.pair.has_swept_polytopes() {
                    self.apart.push(seat.number as u32);
                    *place = None;
                    continue;
                }
                if let Some(before) = last.replace((seat.number, found)) {
                    self.answers.write(before.0, before.1.as_ref());
                }
                *place = None;
            }
        }
        if let Some((number, found)) = last {
            self.answers.write(number, found.as_ref());
        }
    }
}

impl<'a> SearchPairs<'a> {
    pub(super) fn search_on(self, path: Path) {
        dispatch_on(path, self);
    }

    /// The next pair that is to be searched, in the seat of that number; those before it are answered.
    #[inline(always)]
    fn next<L: Lanes>(&mut self, l: L, seat: usize) -> Option<Seat<'a>> {
        let ScenePairs { frames, pairs, .. } = self.objects;
        loop {
            let place = self.place;
            let (&pair, number) = (pairs.get(place)?, *self.numbers.get(place)? as usize);
            self.place += 1;
            let [a, b] = self.objects.posed(pair);
            if self.looks_ahead {
                self.objects.look_ahead(place, self.reads_facets);
            }
            let [of_a, of_b] = self.objects.cores(pair);
            let side = |core, frame: &'a SimdFrame, record: u32, placed| {
                let blocks = frame.blocks_of(frame.record(record));
                Side { core, blocks, placed }
            };
            let sides = [side(of_a, frames.a, pair.i, a), side(of_b, frames.b, pair.j, b)];
            if let Some(searched) = SearchedPair::of(sides, self.accuracy) {
                let accuracy = searched.sharpened(self.accuracy);
                let mut search = DepthSearch::new(&searched.cloud, accuracy);
                if !self.start_proposed(l, (&searched, place), (&mut search, seat)) {
                    let is_second = !frames.is_one();
                    let [points_a, points_b] = searched.in_order(searched.cloud.points.each_ref());
                    let of_a = self.starts.of(l, (pair.i, false), points_a);
                    let of_b = self.starts.of(l, (pair.j, is_second), points_b);
                    let extremes = searched.in_order([&of_a, &of_b]);
                    search.start(l, &searched.cloud, extremes, &mut self.surfaces[seat]);
                }
                return Some(Seat { number, pair: searched, search, point: Point::default() });
            }
            self.answers.write(number, None);
        }
    }

    /// Starts from the triangle that is proposed for the pair in that place; false where there is none, or a flat one.
    #[inline(always)]
    fn start_proposed<L: Lanes>(
        &mut self,
        l: L,
        (searched, place): (&SearchedPair<'_>, usize),
        (search, seat): (&mut DepthSearch, usize),
    ) -> bool {
        let Some(Some(proposal)) = self.proposals.get(place) else { return false };
        let [p, q, r] = proposal.triangle;
        let triangle = [searched.in_order(p), searched.in_order(q), searched.in_order(r)];
        search.start_proposed(l, &searched.cloud, triangle, &mut self.surfaces[seat])
    }
}
