//! Partitions centres into ordered pieces of like count, without sorting them: by bins of equal width.

use dcd_geom::Aabb;
use glam::Vec4;

/// The most bins: their counts stay in the nearest cache. A power of two.
const BINS: usize = 256;

/// How many centres a bin has, about. Smaller: more bins, each of which costs what a centre does. Larger: more centres
/// beside the end of a piece, which are compared with each other.
const CENTRES_PER_BIN: usize = 2;

/// f32's numbers from this one on, to twice as many, are whole: their last bits are the number less it.
const WHOLE: f32 = 8_388_608.0;

/// What is exclusive-ored with a number so that its bits are those of an f32 that is not subnormal: the compiler may compute
/// with what is in the last lane, in vain but a hundred times as long of such.
const NORMAL: u32 = 0x4000_0000;

/// The centre of a box, and in its last coordinate the bits of the box's number: what one instruction moves.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Centre(Vec4);

impl Centre {
    #[inline(always)]
    pub(crate) fn of(aabb: &Aabb, number: usize) -> Self {
        Self(aabb.centre().extend(f32::from_bits(number as u32 ^ NORMAL)))
    }

    /// Where it is along that axis.
    #[inline(always)]
    pub(crate) fn at<const AXIS: usize>(&self) -> f32 {
        self.0[AXIS]
    }

    #[inline(always)]
    pub(crate) fn number(&self) -> u32 {
        self.0.w.to_bits() ^ NORMAL
    }

    /// In the order of the places along that axis; of equal ones the smaller number is first.
    #[inline(always)]
    pub(crate) fn key<const AXIS: usize>(&self) -> u64 {
        ordered(self.at::<AXIS>()) << 32 | u64::from(self.number())
    }
}

/// The bits of x, in the order of the numbers.
#[inline(always)]
fn ordered(x: f32) -> u64 {
    // The sum of a negative 0 and 0 is 0: places that are equal have equal keys.
    let bits = (x + 0.0).to_bits();
    u64::from(if bits >> 31 == 1 { !bits } else { bits | 1 << 31 })
}

/// So many intervals of equal width. What is beyond an end counts to the interval there. No place is in a lower interval
/// than one that is below it, for no operation below changes the order of two numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Intervals {
    low: f32,
    by_width: f32,
    last: f32,
}

impl Intervals {
    /// As many as `count`, at most 2²², from one place to another one.
    pub(crate) fn between(low: f32, high: f32, count: usize) -> Self {
        let last = (count - 1) as f32;
        // Of a width of 0, or one beyond f32's range, all are in one.
        let by_width = last / (high - low);
        Self { low, by_width: if by_width.is_finite() { by_width } else { 0.0 }, last }
    }

    /// The number of the interval that a place is in.
    #[inline(always)]
    pub(crate) fn of(&self, x: f32) -> usize {
        let place = (x - self.low) * self.by_width;
        // Written so that NaN, an infinite difference times 0, is 0.
        let place = if place > 0.0 { place } else { 0.0 };
        let place = if place < self.last { place } else { self.last };
        ((place + WHOLE).to_bits() - WHOLE.to_bits()) as usize
    }
}

/// Writes the centres in pieces of `piece`, each above the one before along that axis. The order within a piece is none in
/// particular, and depends on the order before alone. O(n) but where most are in few bins.
pub(crate) fn part<const AXIS: usize>(from: &[Centre], to: &mut [Centre], piece: usize) {
    if from.len() <= piece {
        return to.copy_from_slice(from);
    }
    let (low, high) = extent(from, Centre::at::<AXIS>);
    if low < high {
        part_between::<AXIS>((from, to), piece, (low, high), Centre::at::<AXIS>);
    } else {
        // All are at one place, as things are that stand on a floor: their numbers decide.
        let number = |centre: &Centre| centre.number() as f32;
        part_between::<AXIS>((from, to), piece, extent(from, number), number);
    }
}

/// [`part`] by bins between two places. `place` is in the order of the keys, but may be the same of several.
#[inline(always)]
fn part_between<const AXIS: usize>(
    (from, to): (&[Centre], &mut [Centre]),
    piece: usize,
    (low, high): (f32, f32),
    place: impl Fn(&Centre) -> f32,
) {
    let count = (from.len() / CENTRES_PER_BIN).next_power_of_two().min(BINS);
    let intervals = Intervals::between(low, high, count);
    let bin = |centre: &Centre| intervals.of(place(centre)) % BINS;
    let mut next = [0u32; BINS];
    from.iter().for_each(|centre| next[bin(centre)] += 1);
    let mut start = 0;
    for next in &mut next[..count] {
        (*next, start) = (start, start + *next);
    }
    for centre in from {
        let next = &mut next[bin(centre)];
        to[*next as usize] = *centre;
        *next += 1;
    }
    let (mut start, mut end_of_piece) = (0, piece);
    for end in next[..count].iter().map(|&end| end as usize) {
        if end_of_piece < end {
            cut::<AXIS>(&mut to[start..end], start, piece);
            end_of_piece = end.next_multiple_of(piece);
        }
        start = end;
    }
}

/// The least and the largest place of at least one centre.
#[inline(always)]
fn extent(centres: &[Centre], place: impl Fn(&Centre) -> f32) -> (f32, f32) {
    let first = Vec4::splat(place(&centres[0]));
    let (mut low, mut high) = (first, first);
    let (fours, others) = centres.as_chunks::<4>();
    let all = fours.iter().map(|four| [0, 1, 2, 3].map(|k| place(&four[k])));
    let rest = others.iter().map(|centre| [place(centre); 4]);
    for places in all.chain(rest).map(Vec4::from_array) {
        (low, high) = (low.min(places), high.max(places));
    }
    (low.min_element(), high.max_element())
}

/// Moves centres into pieces of that many, each above the one before. They are some of a longer list's, from its `first`
/// on, where the pieces are counted from that list's beginning.
pub(crate) fn cut<const AXIS: usize>(centres: &mut [Centre], first: usize, piece: usize) {
    let (before, end) = (first / piece, (first + centres.len()).saturating_sub(1) / piece);
    if before < end {
        let middle = (before + end).div_ceil(2) * piece - first;
        centres.select_nth_unstable_by_key(middle, Centre::key::<AXIS>);
        let (left, right) = centres.split_at_mut(middle);
        cut::<AXIS>(left, first, piece);
        cut::<AXIS>(right, first + middle, piece);
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use glam::Vec3;

    /// How centres are spread.
    #[derive(Clone, Copy, Debug)]
    pub(crate) enum Spread {
        Even,
        /// In three places along each axis.
        Equal,
        /// In one, which is 0 of one sign or the other.
        One,
        /// Half of them in two places far from each other, so that the bins are of no use.
        Clusters,
        /// As far apart as f32 reaches, and further than a difference does.
        Endless,
    }

    pub(crate) const SPREADS: [Spread; 5] =
        [Spread::Even, Spread::Equal, Spread::One, Spread::Clusters, Spread::Endless];

    /// Boxes' centres in an order that looks like none.
    pub(crate) fn centres(count: usize, spread: Spread) -> Vec<Centre> {
        let number = |k: usize| (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        let place = |k: usize| {
            let even = number(k) as f32 / 1e4 - 800.0;
            match spread {
                Spread::Even => even,
                Spread::Equal => (number(k) % 3) as f32,
                Spread::One => 0.0 * even,
                Spread::Clusters if k.is_multiple_of(2) => even,
                Spread::Clusters => even * 1e-5 + if k % 4 == 1 { 1e30 } else { -1e-20 },
                Spread::Endless => even * 3.8e35,
            }
        };
        let at = |i: usize| Vec3::new(place(3 * i), place(3 * i + 1), place(3 * i + 2));
        let boxed = |i: usize| Aabb { min: at(i), max: at(i) };
        (0..count).map(|i| Centre::of(&boxed(i), i)).collect()
    }

    fn check<const AXIS: usize>(count: usize, piece: usize, spread: Spread) {
        let from = centres(count, spread);
        let mut to = vec![Centre::default(); count];
        part::<AXIS>(&from, &mut to, piece);
        let keys = |centres: &[Centre]| centres.iter().map(Centre::key::<AXIS>).collect::<Vec<_>>();
        let (mut sorted, mut parted) = (keys(&from), keys(&to));
        sorted.sort_unstable();
        parted.chunks_mut(piece).for_each(<[u64]>::sort_unstable);
        assert!(sorted == parted, "axis {AXIS}, {count} {piece} {spread:?}");
    }

    #[test]
    fn pieces_hold_what_a_sort_would_put_there() {
        for count in [1, 2, 15, 16, 17, 100, 128, 1152, 5000] {
            for piece in [1, 16, 128, 500] {
                for spread in SPREADS {
                    check::<0>(count, piece, spread);
                    check::<1>(count, piece, spread);
                    check::<2>(count, piece, spread);
                }
            }
        }
    }

    #[test]
    fn no_place_is_in_a_lower_interval_than_one_below_it() {
        for spread in SPREADS {
            for count in [1, 2, 64, 1024] {
                let mut places: Vec<f32> =
                    centres(2000, spread).iter().map(Centre::at::<0>).collect();
                places.sort_unstable_by(f32::total_cmp);
                // Some are beyond both ends.
                let intervals = Intervals::between(places[500], places[1500], count);
                let found: Vec<usize> = places.iter().map(|&x| intervals.of(x)).collect();
                assert!(found.is_sorted(), "{count} {spread:?}");
                assert!(found.iter().all(|&k| k < count), "{count} {spread:?}");
            }
        }
    }
}
