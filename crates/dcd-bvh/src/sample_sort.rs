//! Partitions keys into ordered pieces of like count, without sorting them.

use dcd_exec::Exec;
use dcd_geom::Splittable;

/// The most keys that are partitioned without the pool: some tens of microseconds of work.
pub(crate) const PARTED_AT_ONCE: usize = 4096;

/// How many keys a task deals: some microseconds of work.
const KEYS_PER_TASK: usize = 2048;

/// Into how many piles at most: tasks for many workers, and few enough that what a task deals to
/// each is a run of some length. A power of two.
const PILES: usize = 128;

/// About how many keys a pile has where there are fewer. Smaller: more splitters, which are serial
/// work while others fall asleep. Larger: fewer tasks.
const KEYS_PER_PILE: usize = 512;

/// How many keys are looked at for each splitter. Smaller: piles of unlike size. Larger: longer
/// serial work.
const SAMPLES: usize = 2;

/// Deals keys into piles by sampled splitters, as a sample sort does (W. Frazer and A. McKellar,
/// 1970), and cuts a pile only where a piece ends within it. Keeps its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampleSort {
    /// The keys of each task, pile by pile.
    dealt: Vec<u64>,
    /// For each task where its keys for each pile end.
    ends: Vec<Ends>,
    /// Where the piles end among all keys.
    piles: Vec<usize>,
    samples: Vec<u64>,
}

/// One task's keys for each pile end there.
#[derive(Clone, Copy, Debug)]
struct Ends([u16; PILES]);

impl Default for Ends {
    fn default() -> Self {
        Self([0; PILES])
    }
}

impl SampleSort {
    /// Fills the list with `key(0)`, `key(1)`, …, no two alike, in pieces of `piece`, each above the
    /// one before; the order within a piece is none in particular, and the same whatever `exec` is.
    /// O(n) for pieces of about a pile's size.
    pub(crate) fn part(
        &mut self,
        exec: Exec,
        (keys, piece): (&mut [u64], usize),
        key: impl Fn(usize) -> u64 + Sync,
    ) {
        if keys.len() <= PARTED_AT_ONCE {
            keys.iter_mut().zip(0..).for_each(|(k, i)| *k = key(i));
            return cut(keys, 0, piece);
        }
        let (splitters, piles) = self.split(keys.len(), &key);
        self.deal(exec, (keys, piles), |pile, i| {
            *pile = key(i);
            splitters.pile_of(*pile)
        });
        let Self { dealt, ends, piles, .. } = &*self;
        let whole = Piles { keys, ends: piles, first: 0 };
        exec.divide(whole, 1, |pile, Piles { keys, first, .. }| {
            gather(dealt, ends, pile, keys);
            cut(keys, first, piece);
        });
    }

    /// Splitters that make piles of like size of so many keys, and how many piles.
    fn split(&mut self, count: usize, key: impl Fn(usize) -> u64) -> (Splitters, usize) {
        let piles = (count / KEYS_PER_PILE).next_power_of_two().min(PILES);
        let samples = SAMPLES * piles;
        self.samples.clear();
        self.samples.extend((0..samples).map(|k| key(k * count / samples)));
        self.samples.sort_unstable();
        let mut above = [u64::MAX; PILES];
        for (splitter, sample) in above.iter_mut().zip(self.samples.chunks(SAMPLES).skip(1)) {
            *splitter = sample[0];
        }
        (Splitters(above), piles)
    }

    /// Deals each task's keys to so many piles, and records where those end. `make` writes a key and
    /// says its pile.
    fn deal(
        &mut self,
        exec: Exec,
        (keys, piles): (&mut [u64], usize),
        make: impl Fn(&mut u64, usize) -> usize + Sync,
    ) {
        self.dealt.resize(keys.len(), 0);
        self.ends.resize(keys.len().div_ceil(KEYS_PER_TASK), Ends::default());
        let rows = (keys, &mut self.dealt[..]);
        let each = Chunks { rows, ends: &mut self.ends };
        exec.divide(each, 1, |task, Chunks { rows: (keys, dealt), ends }| {
            let mut pile_of = [0u8; KEYS_PER_TASK];
            let mut next = [0u16; PILES];
            let first = task * KEYS_PER_TASK;
            for (k, (key, pile)) in keys.iter_mut().zip(&mut pile_of).enumerate() {
                let at = make(key, first + k) % PILES;
                *pile = at as u8;
                next[at] += 1;
            }
            let mut start = 0;
            for next in &mut next {
                (*next, start) = (start, start + *next);
            }
            for (&key, &pile) in keys.iter().zip(&pile_of) {
                let next = &mut next[usize::from(pile) % PILES];
                dealt[usize::from(*next)] = key;
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

/// The least key that is above each pile, ascending; from the last pile on above all keys.
struct Splitters([u64; PILES]);

impl Splitters {
    /// How many splitters are not above the key: by halving, as often whatever the number of piles,
    /// so that the loop is unrolled and has no branch.
    #[inline]
    fn pile_of(&self, key: u64) -> usize {
        let mut pile = 0;
        let mut step = PILES / 2;
        while step > 0 {
            pile += step * usize::from(self.0[(pile + step - 1) % PILES] <= key);
            step /= 2;
        }
        pile
    }
}

/// Brings together what the tasks dealt to a pile, in the order of the tasks.
fn gather(dealt: &[u64], ends: &[Ends], pile: usize, keys: &mut [u64]) {
    let mut to = keys;
    for (Ends(ends), dealt) in ends.iter().zip(dealt.chunks(KEYS_PER_TASK)) {
        let start = pile.checked_sub(1).map_or(0, |before| usize::from(ends[before]));
        let from = &dealt[start..usize::from(ends[pile])];
        let (here, rest) = to.split_at_mut(from.len());
        here.copy_from_slice(from);
        to = rest;
    }
}

/// Moves keys into pieces of that many, each above the one before. The keys are some of a longer
/// list's, from its `first` on, where the pieces are counted from that list's beginning.
pub(crate) fn cut(keys: &mut [u64], first: usize, piece: usize) {
    let (before, end) = (first / piece, (first + keys.len()).saturating_sub(1) / piece);
    if before < end {
        let middle = (before + end).div_ceil(2) * piece - first;
        keys.select_nth_unstable(middle);
        let (left, right) = keys.split_at_mut(middle);
        cut(left, first, piece);
        cut(right, first + middle, piece);
    }
}

/// What each task deals: [`KEYS_PER_TASK`] keys, their copies in piles and where those end.
struct Chunks<'a> {
    rows: (&'a mut [u64], &'a mut [u64]),
    ends: &'a mut [Ends],
}

impl Splittable for Chunks<'_> {
    fn len(&self) -> usize {
        self.ends.len()
    }

    fn split_at(self, middle: usize) -> (Self, Self) {
        let (left, right) = self.rows.split_at(middle * KEYS_PER_TASK);
        let (left_ends, right_ends) = self.ends.split_at_mut(middle);
        (Self { rows: left, ends: left_ends }, Self { rows: right, ends: right_ends })
    }
}

/// Some piles, one after the other.
struct Piles<'a> {
    keys: &'a mut [u64],
    /// Where each ends among all keys.
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
        let (left, right) = self.keys.split_at_mut(end - self.first);
        let left = Self { keys: left, ends: left_ends, first: self.first };
        (left, Self { keys: right, ends: right_ends, first: end })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_exec::Par;

    /// Keys in an order that looks like none, with few values above the number.
    fn scattered(i: usize, values: u64) -> u64 {
        ((i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) % values) << 32 | i as u64
    }

    #[test]
    fn pieces_hold_what_a_sort_would_put_there() {
        for count in [1, 16, 4096, 4097, 9000, 50_000, 90_000] {
            for piece in [16, 300, 5000, 60_000] {
                for values in [1, 3, 1 << 30] {
                    let mut sorted: Vec<u64> = (0..count).map(|i| scattered(i, values)).collect();
                    sorted.sort_unstable();
                    let mut parted = [Par::Serial, Par::Pool].map(|par| {
                        let mut keys = vec![0; count];
                        let key = |i| scattered(i, values);
                        SampleSort::default().part(par.into(), (&mut keys, piece), key);
                        keys
                    });
                    assert_eq!(parted[0], parted[1], "{count} {piece} {values}");
                    parted[0].chunks_mut(piece).for_each(<[u64]>::sort_unstable);
                    assert!(parted[0] == sorted, "{count} {piece} {values}");
                }
            }
        }
    }

    #[test]
    fn a_key_goes_to_the_pile_after_all_splitters_that_are_not_above_it() {
        for piles in [1, 2, 16, PILES] {
            let limit = |k: usize| if k + 1 < piles { 10 * k as u64 + 5 } else { u64::MAX };
            let splitters = Splitters(std::array::from_fn(limit));
            for key in 0..10 * PILES as u64 {
                let plain = splitters.0.iter().filter(|&&above| above <= key).count();
                assert_eq!(splitters.pile_of(key), plain, "{piles} {key}");
            }
        }
    }
}
