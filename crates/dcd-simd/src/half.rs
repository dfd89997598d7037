//! Eight of the sixteen lanes: half the registers, where there are several.

use crate::unfused::{hand_on, hand_on_arithmetic};
use crate::{IndexRow, Kernel, Lanes, Pair, Row, WIDTH};

/// How many lanes a half has.
const LANES: usize = WIDTH / 2;

/// Which eight of the lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// Lanes 0 to 7.
    First = 0,
    /// Lanes 8 to 15.
    Last = 1,
}

impl Half {
    /// The only half that has any of these bits; `None` where both have, and where neither has.
    #[inline(always)]
    pub fn only_of(bits: u32) -> Option<Self> {
        match [Self::First, Self::Last].map(|half| bits & half.bits() != 0) {
            [true, false] => Some(Self::First),
            [false, true] => Some(Self::Last),
            _ => None,
        }
    }

    /// The bits of its lanes.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        0xff << self.at()
    }

    /// Its first lane.
    #[inline(always)]
    fn at(self) -> usize {
        self as usize * LANES
    }

    #[inline(always)]
    fn of<T>(self, all: &[T; WIDTH]) -> &[T; LANES] {
        &all.as_chunks().0[self as usize]
    }

    #[inline(always)]
    fn of_mut<T>(self, all: &mut [T; WIDTH]) -> &mut [T; LANES] {
        &mut all.as_chunks_mut().0[self as usize]
    }
}

/// A kernel on one half of the lanes: see [`Lanes::run_half`].
struct InHalf<K>(Half, K);

impl<K: Kernel> Kernel for InHalf<K> {
    type Output = K::Output;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> K::Output {
        lanes.run_half(self.0, self.1)
    }
}

/// The lanes within, of which the first eight stand for one half.
#[derive(Clone, Copy)]
pub(crate) struct Eight<L>(pub(crate) L, pub(crate) Half);

impl<L: Lanes> Lanes for Eight<L> {
    type F = L::F;
    type U = L::U;
    type M = L::M;
    type D = L::D;
    const FUSED: bool = L::FUSED;

    #[inline(always)]
    fn load_from(self, numbers: &[f32; WIDTH]) -> L::F {
        self.0.load_half(self.1.of(numbers))
    }
    #[inline(always)]
    fn store_to(self, a: L::F, numbers: &mut [f32; WIDTH]) {
        self.0.store_half(a, self.1.of_mut(numbers));
    }
    #[inline(always)]
    fn bits(self, mask: L::M) -> u32 {
        self.0.half_bits(mask) << self.1.at()
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> L::M {
        self.0.mask(bits >> self.1.at())
    }
    #[inline(always)]
    fn round_from(self, numbers: [&[f64; LANES]; 2]) -> L::F {
        let half = numbers[self.1 as usize];
        self.0.round_from([half, half])
    }
    #[inline(always)]
    fn load_from_u(self, numbers: &[u32; WIDTH]) -> L::U {
        let half = self.1.of(numbers);
        let mut twice = IndexRow::default();
        twice.0[..LANES].copy_from_slice(half);
        twice.0[LANES..].copy_from_slice(half);
        self.0.load_u(&twice)
    }
    #[inline(always)]
    fn store_to_u(self, a: L::U, numbers: &mut [u32; WIDTH]) {
        let mut all = IndexRow::default();
        self.0.store_u(a, &mut all);
        *self.1.of_mut(numbers) = *Half::First.of(&all.0);
    }
    #[inline(always)]
    fn lane_numbers(self) -> L::U {
        self.0.add_u(self.0.lane_numbers(), self.0.splat_u(self.1.at() as u32))
    }
    #[inline(always)]
    fn compress_to(self, keep: u32, a: L::F, to: &mut [f32; 2 * WIDTH], at: usize) {
        self.0.compress_to((keep & self.1.bits()) >> self.1.at(), a, to, at);
    }
    #[inline(always)]
    fn compress_to_u(self, keep: u32, a: L::U, to: &mut [u32; 2 * WIDTH], at: usize) {
        self.0.compress_to_u((keep & self.1.bits()) >> self.1.at(), a, to, at);
    }
    #[inline(always)]
    fn append_pairs(self, keep: u32, pair: (u32, L::U), to: &mut Vec<Pair>) {
        self.0.append_pairs((keep & self.1.bits()) >> self.1.at(), pair, to);
    }
    #[inline(always)]
    fn largest_of_each(self, rows: &[Row; WIDTH]) -> L::F {
        let mut all = Row::default();
        self.0.store(self.0.largest_of_each(rows), &mut all);
        self.load(&all)
    }
    #[inline(always)]
    fn largest(self, a: L::F) -> f32 {
        let mut half = [0.0; LANES];
        self.0.store_half(a, &mut half);
        let mut twice = Row::default();
        twice.0[..LANES].copy_from_slice(&half);
        twice.0[LANES..].copy_from_slice(&half);
        self.0.largest(self.0.load(&twice))
    }

    #[inline(always)]
    fn call<K: Kernel>(self, kernel: K) -> K::Output {
        self.0.call(InHalf(self.1, kernel))
    }

    hand_on_arithmetic! {}

    hand_on! {
        mul_add(a: L::F, b: L::F, c: L::F) -> L::F;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Block, Path, dispatch_on};

    /// What lanes know of two rows: a quotient, where the first is smaller, the largest, the kept ones and the numbers.
    #[derive(Debug, PartialEq)]
    struct Known {
        quotient: Row,
        below: u32,
        masked: u32,
        largest: f32,
        kept: [f32; 2 * WIDTH],
        numbers: IndexRow,
    }

    struct Know<'a>([&'a Row; 2], u32);

    impl Kernel for Know<'_> {
        type Output = Known;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Known {
            let keep = self.1;
            let [a, b] = self.0.map(
                #[inline(always)]
                |row| l.load(row),
            );
            let (mut quotient, mut numbers) = (Row::default(), IndexRow::default());
            let mut kept = [-1.0; 2 * WIDTH];
            l.store(l.div(a, b), &mut quotient);
            l.store_u(l.lane_numbers(), &mut numbers);
            l.compress_to(keep, a, &mut kept, 0);
            kept[((keep & l.bits(l.mask(u32::MAX))).count_ones() as usize)..].fill(0.0);
            Known {
                quotient,
                below: l.bits(l.lt(a, b)),
                masked: l.bits(l.mask(keep)),
                largest: l.largest(a),
                kept,
                numbers,
            }
        }
    }

    struct KnowHalf<'a>(Half, Know<'a>);

    impl Kernel for KnowHalf<'_> {
        type Output = Known;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Known {
            l.run_half(self.0, self.1)
        }
    }

    #[test]
    fn half_of_the_lanes_know_what_all_know_of_them() {
        let a = Row(std::array::from_fn(|k| ((k * 7 + 3) % 16) as f32));
        let b = Row(std::array::from_fn(|k| ((k * 5 + 1) % 16) as f32 + 0.5));
        let keep = 0b0110_1001_1010_0111;
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            for half in [Half::First, Half::Last] {
                let found = dispatch_on(path, KnowHalf(half, Know([&a, &b], keep)));
                let at = half.at();
                let lanes = at..at + LANES;
                let of = |k: usize, x: f32| if lanes.contains(&k) { x } else { 0.0 };
                let mut kept = [0.0; 2 * WIDTH];
                let wanted = lanes.clone().filter(|k| keep >> k & 1 == 1).map(|k| a.0[k]);
                kept.iter_mut().zip(wanted).for_each(|(to, x)| *to = x);
                let below =
                    lanes.clone().filter(|&k| a.0[k] < b.0[k]).fold(0, |set, k| set | 1 << k);
                let due = Known {
                    quotient: Row(std::array::from_fn(|k| of(k, a.0[k] / b.0[k]))),
                    below,
                    masked: keep & half.bits(),
                    largest: lanes.clone().map(|k| a.0[k]).fold(f32::MIN, f32::max),
                    kept,
                    numbers: IndexRow(std::array::from_fn(|k| of(k, k as f32) as u32)),
                };
                assert_eq!(found, due, "{path:?} {half:?}");
            }
        }
    }

    /// What every method makes of some numbers, beside those that [`Known`] has.
    #[derive(Debug, Default, PartialEq)]
    struct Made {
        rows: Vec<Row>,
        indices: Vec<IndexRow>,
        bits: Vec<u32>,
        kept: Vec<u32>,
        pairs: Vec<Pair>,
    }

    struct Make<'a> {
        rows: &'a [Row; WIDTH],
        exact: &'a [f64; WIDTH],
        keep: u32,
    }

    impl Kernel for Make<'_> {
        type Output = Made;

        fn run<L: Lanes>(self, l: L) -> Made {
            let Self { rows, exact, keep } = self;
            let [a, b] = [l.load(&rows[0]), l.load(&rows[1])];
            let mask = l.mask(keep);
            let (below, least) = (l.lt(a, b), l.le(b, a));
            let (first, last) = exact.split_at(LANES);
            let halves = [first, last].map(|half| half.first_chunk::<LANES>().unwrap());
            let numbers = IndexRow(std::array::from_fn(|k| (k * k) as u32));
            let (numbers, low) = (l.load_u(&numbers), l.splat_u(0xf));
            let tagged = l.tag(l.abs(a), low, l.lane_numbers());
            let blocks = [[0, 1, 2], [3, 4, 5]].map(|of| Block(of.map(|k: usize| rows[k])));
            let mut made = Made::default();
            let lanes = [
                l.mul_add(a, b, a),
                l.min(a, b),
                l.max(a, b),
                l.sqrt(l.abs(l.neg(a))),
                l.sub(l.add(a, b), l.mul(a, b)),
                l.select(l.or(l.and_not(mask, below), l.and(mask, least)), a, b),
                l.round_from(halves),
                l.largest_of_each(rows),
                tagged,
            ];
            let picked = l.pick(&blocks, l.splat_u(0), l.add_u(l.lane_numbers(), low));
            for lanes in lanes.into_iter().chain(picked).chain(l.transpose(rows)) {
                let mut row = Row::default();
                l.store(lanes, &mut row);
                made.rows.push(row);
            }
            for lanes in [l.add_u(numbers, l.splat_u(3)), l.tag_of(tagged, low)] {
                let mut row = IndexRow::default();
                l.store_u(lanes, &mut row);
                made.indices.push(row);
            }
            made.bits = [mask, below, least].map(|mask| l.bits(mask)).to_vec();
            let mut kept = [0; 2 * WIDTH];
            l.compress_to_u(keep, numbers, &mut kept, 3);
            let count = (keep & l.bits(l.mask(u32::MAX))).count_ones() as usize;
            made.kept = kept[3..3 + count].to_vec();
            l.append_pairs(keep, (70, numbers), &mut made.pairs);
            made
        }
    }

    struct MakeHalf<'a>(Half, Make<'a>);

    impl Kernel for MakeHalf<'_> {
        type Output = Made;

        fn run<L: Lanes>(self, l: L) -> Made {
            l.run_half(self.0, self.1)
        }
    }

    /// What of it is of the lanes of one half.
    fn of_half(made: &Made, half: Half, keep: u32) -> Made {
        let lanes = half.at()..half.at() + LANES;
        let kept: Vec<usize> = (0..WIDTH).filter(|k| keep >> k & 1 == 1).collect();
        let is_own = |place: usize| lanes.contains(&kept[place]);
        let row = |row: &Row| {
            Row(std::array::from_fn(|k| if lanes.contains(&k) { row.0[k] } else { 0.0 }))
        };
        let indices = |row: &IndexRow| {
            IndexRow(std::array::from_fn(|k| if lanes.contains(&k) { row.0[k] } else { 0 }))
        };
        let places = || (0..kept.len()).filter(|&place| is_own(place));
        Made {
            rows: made.rows.iter().map(row).collect(),
            indices: made.indices.iter().map(indices).collect(),
            bits: made.bits.iter().map(|bits| bits & half.bits()).collect(),
            kept: places().map(|place| made.kept[place]).collect(),
            pairs: places().map(|place| made.pairs[place]).collect(),
        }
    }

    #[test]
    fn every_method_makes_of_half_of_the_lanes_what_it_makes_of_them_among_all() {
        let number = |k: usize| ((k * 37 + 11) % 64) as f32 * 0.37 - 9.0;
        let rows: [Row; WIDTH] =
            std::array::from_fn(|row| Row(std::array::from_fn(|k| number(row * WIDTH + k))));
        let exact: [f64; WIDTH] = std::array::from_fn(|k| f64::from(number(k)) / 3.0);
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            for keep in [0b0110_1001_1010_0111, 0xffff, 0x00ff, 0xf000] {
                let make = || Make { rows: &rows, exact: &exact, keep };
                let all = dispatch_on(path, make());
                for half in [Half::First, Half::Last] {
                    let found = dispatch_on(path, MakeHalf(half, make()));
                    assert_eq!(found, of_half(&all, half, keep), "{path:?} {half:?} {keep:x}");
                }
            }
        }
    }

    #[test]
    fn bits_of_one_half_are_known_as_such() {
        assert_eq!(Half::only_of(0x01), Some(Half::First));
        assert_eq!(Half::only_of(0x80ff & 0xff00), Some(Half::Last));
        assert_eq!([Half::only_of(0), Half::only_of(0x180)], [None, None]);
    }
}
