//! Partitions centres along the first axis into ordered pieces of like count, without sorting them.

use crate::bins::{self, Centre, Intervals, cut};
use dcd_exec::Exec;
use dcd_geom::Splittable;

/// The most centres that are partitioned without the pool: some tens of microseconds of work.
pub(crate) const PARTED_AT_ONCE: usize = 4096;

/// How many centres a task deals: some microseconds of work.
const CENTRES_PER_TASK: usize = 2048;

/// Along that axis.
const AXIS: usize = 0;

/// Into how many piles at most: tasks for many workers, and few enough that what a task deals to
/// each is a run of some length. A power of two.
const PILES: usize = 128;

/// About how many centres a pile has where there are fewer. Smaller: more splitters, which are serial
/// work while others fall asleep. Larger: fewer tasks.
const CENTRES_PER_PILE: usize = 512;

/// How many centres are looked at for each splitter. Smaller: piles of unlike size. Larger: longer
/// serial work.
const SAMPLES: usize = 2;

/// Into how many intervals the splitters are sorted. More: memory. Fewer: centres that are compared with a splitter.
const INTERVALS: usize = 1024;

/// Deals centres into piles by sampled splitters, as a sample sort does (W. Frazer and A. McKellar,
/// 1970), and cuts a pile only where a piece ends within it. Keeps its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampleSort {
    /// For each task where its centres for each pile end.
    ends: Vec<Ends>,
    /// Where the piles end among all centres.
    piles: Vec<usize>,
    samples: Vec<Centre>,
}

/// One task's centres for each pile end there.
#[derive(Clone, Copy, Debug)]
struct Ends([u16; PILES]);

impl Default for Ends {
    fn default() -> Self {
        Self([0; PILES])
    }
}

impl SampleSort {
    /// Fills the first list with `centre(0)`, `centre(1)`, …, in pieces of `piece`, each above the one before; the order
    /// within a piece is none in particular, and the same whatever `exec` is. The second list is as long, and what is in it
    /// is lost. O(n) for pieces of about a pile's size.
    pub(crate) fn part(
        &mut self,
        exec: Exec,
        (centres, dealt): (&mut [Centre], &mut [Centre]),
        piece: usize,
        centre: impl Fn(usize) -> Centre + Sync,
    ) {
        if centres.len() <= PARTED_AT_ONCE {
            dealt.iter_mut().zip(0..).for_each(|(to, i)| *to = centre(i));
            return bins::part::<AXIS>(dealt, centres, piece);
        }
        let (splitters, piles) = self.split(centres.len(), &centre);
        self.deal(exec, (&mut *centres, &mut *dealt), piles, |i| {
            let centre = centre(i);
            (centre, splitters.pile_of(&centre))
        });
        let Self { ends, piles, .. } = &*self;
        let dealt = &*dealt;
        let whole = Piles { centres, ends: piles, first: 0 };
        exec.divide(whole, 1, |pile, Piles { centres, first, .. }| {
            gather(dealt, ends, pile, centres);
            cut::<AXIS>(centres, first, piece);
        });
    }

    /// Splitters that make piles of like size of so many centres, and how many piles.
    fn split(&mut self, count: usize, centre: impl Fn(usize) -> Centre) -> (Splitters, usize) {
        let piles = (count / CENTRES_PER_PILE).next_power_of_two().min(PILES);
        let samples = SAMPLES * piles;
        self.samples.clear();
        self.samples.extend((0..samples).map(|k| centre(k * count / samples)));
        self.samples.sort_unstable_by_key(Centre::key::<AXIS>);
        (Splitters::new(self.samples.iter().step_by(SAMPLES).skip(1)), piles)
    }

    /// Deals each task's centres to so many piles, and records where those end. `make` makes a centre and says its pile.
    fn deal(
        &mut self,
        exec: Exec,
        rows: (&mut [Centre], &mut [Centre]),
        piles: usize,
        make: impl Fn(usize) -> (Centre, usize) + Sync,
    ) {
        self.ends.resize(rows.0.len().div_ceil(CENTRES_PER_TASK), Ends::default());
        let each = Chunks { rows, ends: &mut self.ends };
        exec.divide(each, 1, |task, Chunks { rows: (centres, dealt), ends }| {
            let mut pile_of = [0u8; CENTRES_PER_TASK];
            let mut next = [0u16; PILES];
            let first = task * CENTRES_PER_TASK;
            for (k, (centre, pile)) in centres.iter_mut().zip(&mut pile_of).enumerate() {
                let (made, at) = make(first + k);
                (*centre, *pile) = (made, at as u8);
                next[at % PILES] += 1;
            }
            let mut start = 0;
            for next in &mut next {
                (*next, start) = (start, start + *next);
            }
            for (centre, &pile) in centres.iter().zip(&pile_of) {
                let next = &mut next[usize::from(pile) % PILES];
                dealt[usize::from(*next)] = *centre;
                *next += 1;
            }
            ends[0] = Ends(next);
        });
        self.piles.clear();
        self.piles.resize(piles, 0);
        for Ends(ends) in &self.ends {
            self.piles.iter_mut().zip(ends).for_each(|(sum, &end)| *sum += usize::from(end));
        }
    }
}

/// The least key that is above each pile but the last, ascending, and in which interval each is.
struct Splitters {
    above: [u64; PILES],
    /// How many are in the intervals before each one. An interval is as wide as the others, but without end at both ends.
    before: [u8; INTERVALS + 1],
    intervals: Intervals,
}

impl Splitters {
    /// Fewer than [`PILES`], ascending.
    fn new<'a>(splitters: impl ExactSizeIterator<Item = &'a Centre> + Clone) -> Self {
        let at = |splitter: Option<&Centre>| splitter.map_or(0.0, Centre::at::<AXIS>);
        let (low, high) = (at(splitters.clone().next()), at(splitters.clone().last()));
        let intervals = Intervals::between(low, high, INTERVALS);
        let (mut above, mut before) = ([u64::MAX; PILES], [0; INTERVALS + 1]);
        for (above, splitter) in above.iter_mut().zip(splitters) {
            *above = splitter.key::<AXIS>();
            before[intervals.of(splitter.at::<AXIS>()) + 1] += 1;
        }
        let mut sum = 0;
        for before in &mut before {
            sum += *before;
            *before = sum;
        }
        Self { above, before, intervals }
    }

    /// How many splitters are not above the centre. Those in the intervals before its own are not, those in the intervals behind
    /// are: only those in the same one are compared.
    #[inline(always)]
    fn pile_of(&self, centre: &Centre) -> usize {
        let interval = self.intervals.of(centre.at::<AXIS>()) % INTERVALS;
        let [first, end] = [self.before[interval], self.before[interval + 1]].map(usize::from);
        if first == end {
            return first;
        }
        let key = centre.key::<AXIS>();
        first + self.above[first..end].partition_point(|&above| above <= key)
    }
}

/// Brings together what the tasks dealt to a pile, in the order of the tasks.
fn gather(dealt: &[Centre], ends: &[Ends], pile: usize, centres: &mut [Centre]) {
    let mut to = centres;
    for (Ends(ends), dealt) in ends.iter().zip(dealt.chunks(CENTRES_PER_TASK)) {
        let start = pile.checked_sub(1).map_or(0, |before| usize::from(ends[before]));
        let from = &dealt[start..usize::from(ends[pile])];
        let (here, rest) = to.split_at_mut(from.len());
        here.copy_from_slice(from);
        to = rest;
    }
}

/// What each task deals: [`CENTRES_PER_TASK`] centres, their copies in piles and where those end.
struct Chunks<'a> {
    rows: (&'a mut [Centre], &'a mut [Centre]),
    ends: &'a mut [Ends],
}

impl Splittable for Chunks<'_> {
    fn len(&self) -> usize {
        self.ends.len()
    }

    fn split_at(self, middle: usize) -> (Self, Self) {
        let (left, right) = self.rows.split_at(middle * CENTRES_PER_TASK);
        let (left_ends, right_ends) = self.ends.split_at_mut(middle);
        (Self { rows: left, ends: left_ends }, Self { rows: right, ends: right_ends })
    }
}

/// Some piles, one after the other.
struct Piles<'a> {
    centres: &'a mut [Centre],
    /// Where each ends among all centres.
    ends: &'a [usize],
    /// Where the first begins.
    first: usize,
}

impl Splittable for Piles<'_> {
    fn len(&self) -> usize {
        self.ends.len()
    }

    fn split_at(self, middle: usize) -> (Self, Self) {
        let (left_ends, right_ends) = self.ends.split_at(middle);
        let end = left_ends.last().map_or(self.first, |&end| end);
        let (left, right) = self.centres.split_at_mut(end - self.first);
        let left = Self { centres: left, ends: left_ends, first: self.first };
        (left, Self { centres: right, ends: right_ends, first: end })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::tests::{SPREADS, centres};
    use dcd_exec::Par;

    #[test]
    fn pieces_hold_what_a_sort_would_put_there() {
        for count in [1, 16, 4096, 4097, 9000, 50_000, 90_000] {
            for piece in [16, 300, 5000, 60_000] {
                for spread in SPREADS {
                    let made = centres(count, spread);
                    let mut sorted: Vec<u64> = made.iter().map(Centre::key::<AXIS>).collect();
                    sorted.sort_unstable();
                    let mut parted = [Par::Serial, Par::Pool].map(|par| {
                        let mut lists = [(); 2].map(|()| vec![Centre::default(); count]);
                        let [centres, dealt] = &mut lists;
                        let rows = (&mut centres[..], &mut dealt[..]);
                        SampleSort::default().part(par.into(), rows, piece, |i| made[i]);
                        centres.iter().map(Centre::key::<AXIS>).collect::<Vec<_>>()
                    });
                    assert_eq!(parted[0], parted[1], "{count} {piece} {spread:?}");
                    parted[0].chunks_mut(piece).for_each(<[u64]>::sort_unstable);
                    assert!(parted[0] == sorted, "{count} {piece} {spread:?}");
                }
            }
        }
    }

    #[test]
    fn a_centre_goes_to_the_pile_after_all_splitters_that_are_not_above_it() {
        for count in [0, 1, 15, PILES - 1] {
            for spread in SPREADS {
                let mut splitters = centres(count, spread);
                splitters.sort_unstable_by_key(Centre::key::<AXIS>);
                let found = Splitters::new(splitters.iter());
                for centre in centres(3000, spread).iter().chain(&splitters) {
                    let is_above = |s: &&Centre| s.key::<AXIS>() <= centre.key::<AXIS>();
                    let plain = splitters.iter().filter(is_above).count();
                    assert_eq!(found.pile_of(centre), plain, "{count} {spread:?} {centre:?}");
                }
            }
        }
    }
}
