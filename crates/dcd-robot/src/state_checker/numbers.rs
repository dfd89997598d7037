//! What links are placed with: sixteen states in lanes, or one state alone, each operation rounded alike, so that a state's
//! frames do not depend on how many are placed together.

use dcd_simd::{Lanes, Row, WIDTH};

/// Operations on f32, IEEE and rounded to nearest.
pub(super) trait Numbers: Copy {
    type F: Copy;
    /// Yes or no.
    type M: Copy;
    fn splat(self, x: f32) -> Self::F;
    fn load(self, row: &Row) -> Self::F;
    fn store(self, a: Self::F, row: &mut Row);
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// a·b + c, rounded once or twice, as the lanes do.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    fn neg(self, a: Self::F) -> Self::F;
    fn abs(self, a: Self::F) -> Self::F;
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    fn select(self, mask: Self::M, yes: Self::F, no: Self::F) -> Self::F;
    /// The sine and the cosine of the angle in a row, by its number.
    fn sin_cos(self, rows: &[Row], number: usize) -> [Self::F; 2];
}

/// Sixteen states.
#[derive(Clone, Copy)]
pub(super) struct All<L>(pub(super) L);

/// Hands a method on to the lanes.
macro_rules! hand_on {
    ($($name:ident($($a:ident: $of:ty),*) $(-> $to:ty)?;)*) => {
        $(
            #[inline(always)]
            fn $name(self, $($a: $of),*) $(-> $to)? {
                self.0.$name($($a),*)
            }
        )*
    };
}

impl<L: Lanes> Numbers for All<L> {
    type F = L::F;
    type M = L::M;

    hand_on! {
        splat(x: f32) -> L::F;
        load(row: &Row) -> L::F;
        store(a: L::F, row: &mut Row);
        add(a: L::F, b: L::F) -> L::F;
        sub(a: L::F, b: L::F) -> L::F;
        mul(a: L::F, b: L::F) -> L::F;
        mul_add(a: L::F, b: L::F, c: L::F) -> L::F;
        neg(a: L::F) -> L::F;
        abs(a: L::F) -> L::F;
        lt(a: L::F, b: L::F) -> L::M;
        select(mask: L::M, yes: L::F, no: L::F) -> L::F;
    }

    #[inline(always)]
    fn sin_cos(self, rows: &[Row], number: usize) -> [L::F; 2] {
        sin_cos(self, self.load(&rows[number]))
    }
}

/// What moves the first sixteen joints of a state, and the sines and the cosines of that; of what slides they mean nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved {
    numbers: Row,
    sines: [Row; 2],
}

/// The state of one lane: the others' numbers stay what they were.
#[derive(Clone, Copy)]
pub(super) struct One<'a, L> {
    lanes: std::marker::PhantomData<L>,
    lane: usize,
    first: &'a Moved,
}

impl<'a, L: Lanes> One<'a, L> {
    /// With what [`One::moved`] has found.
    #[inline(always)]
    pub(super) fn with(_: L, lane: usize, first: &'a Moved) -> Self {
        Self { lanes: std::marker::PhantomData, lane: lane % WIDTH, first }
    }

    /// Those of sixteen angles of one state in the lanes, where a packet has one angle of sixteen states: a tenth less time
    /// for the links of a state alone than one after the other.
    #[inline(always)]
    pub(super) fn moved(l: L, by: L::F) -> Moved {
        let [mut numbers, mut sines, mut cosines] = [Row([0.0; WIDTH]); 3];
        let [sine, cosine] = sin_cos(All(l), by);
        l.store(by, &mut numbers);
        l.store(sine, &mut sines);
        l.store(cosine, &mut cosines);
        Moved { numbers, sines: [sines, cosines] }
    }

    /// What moves the joint of a row, by its number.
    #[inline(always)]
    pub(super) fn number(self, rows: &[Row], number: usize) -> f32 {
        if number < WIDTH { self.first.numbers.0[number] } else { self.load(&rows[number]) }
    }

    /// The sine and the cosine of one of the first sixteen angles.
    #[inline(always)]
    pub(super) fn first_sin_cos(self, number: usize) -> [f32; 2] {
        let [sines, cosines] = &self.first.sines;
        [sines.0[number % WIDTH], cosines.0[number % WIDTH]]
    }
}

impl<L: Lanes> Numbers for One<'_, L> {
    type F = f32;
    type M = bool;

    #[inline(always)]
    fn splat(self, x: f32) -> f32 {
        x
    }
    #[inline(always)]
    fn load(self, row: &Row) -> f32 {
        row.0[self.lane]
    }
    #[inline(always)]
    fn store(self, a: f32, row: &mut Row) {
        row.0[self.lane] = a;
    }
    #[inline(always)]
    fn add(self, a: f32, b: f32) -> f32 {
        a + b
    }
    #[inline(always)]
    fn sub(self, a: f32, b: f32) -> f32 {
        a - b
    }
    #[inline(always)]
    fn mul(self, a: f32, b: f32) -> f32 {
        a * b
    }
    #[inline(always)]
    fn mul_add(self, a: f32, b: f32, c: f32) -> f32 {
        mul_add::<L>(a, b, c)
    }
    #[inline(always)]
    fn neg(self, a: f32) -> f32 {
        -a
    }
    #[inline(always)]
    fn abs(self, a: f32) -> f32 {
        a.abs()
    }
    #[inline(always)]
    fn lt(self, a: f32, b: f32) -> bool {
        a < b
    }
    #[inline(always)]
    fn select(self, mask: bool, yes: f32, no: f32) -> f32 {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn sin_cos(self, rows: &[Row], number: usize) -> [f32; 2] {
        if number < WIDTH {
            return self.first_sin_cos(number);
        }
        sin_cos(self, self.load(&rows[number]))
    }
}

/// a·b + c, rounded once or twice, as the lanes do: one instruction where they have one, since it is inlined where they are.
#[inline(always)]
pub(super) fn mul_add<L: Lanes>(a: f32, b: f32, c: f32) -> f32 {
    if L::FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// π/2 to 17 bits, so that it times a small whole number is exact, and the rest.
const QUARTER: [f32; 2] = [1.570_785_5, 1.080_433_4e-5];

/// What added and subtracted rounds to a whole number: 1.5 · 2²³.
const WHOLE: f32 = 12_582_912.0;

/// The sine and the cosine of an angle up to `MOST_TURNED` (chain.rs) from 0, within three roundings of those of the angle in
/// f32: by Taylor's series of what it is beyond a multiple of a right angle.
#[inline(always)]
fn sin_cos<L: Numbers>(l: L, angle: L::F) -> [L::F; 2] {
    let quarters = whole(l, l.mul(angle, l.splat(std::f32::consts::FRAC_2_PI)));
    let x = l.mul_add(quarters, l.splat(-QUARTER[0]), angle);
    let x = l.mul_add(quarters, l.splat(-QUARTER[1]), x);
    let square = l.mul(x, x);
    let mut sine = l.splat(1.0 / 362_880.0);
    for term in [-1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0] {
        sine = l.mul_add(sine, square, l.splat(term));
    }
    let sine = l.mul_add(l.mul(x, square), sine, x);
    let mut cosine = l.splat(1.0 / 40_320.0);
    for term in [-1.0 / 720.0, 1.0 / 24.0, -0.5] {
        cosine = l.mul_add(cosine, square, l.splat(term));
    }
    let cosine = l.mul_add(square, cosine, l.splat(1.0));
    // quarters = 2·halves + odd, halves = 2·turns + flipped.
    let halves = whole(l, l.mul_add(quarters, l.splat(0.5), l.splat(-0.25)));
    let turns = whole(l, l.mul_add(halves, l.splat(0.5), l.splat(-0.25)));
    let is_odd = l.lt(l.add(halves, halves), quarters);
    let is_flipped = l.lt(l.add(turns, turns), halves);
    let sign = l.select(is_flipped, l.splat(-1.0), l.splat(1.0));
    [
        l.mul(sign, l.select(is_odd, cosine, sine)),
        l.mul(sign, l.select(is_odd, l.neg(sine), cosine)),
    ]
}

/// To the nearest whole number, of what is small.
#[inline(always)]
fn whole<L: Numbers>(l: L, x: L::F) -> L::F {
    l.sub(l.add(x, l.splat(WHOLE)), l.splat(WHOLE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_simd::{Kernel, Path, dispatch_on};

    /// The sine and the cosine of each row's angle in a lane, of one state and of sixteen.
    struct Both<'a>(&'a [Row], usize);

    impl Kernel for Both<'_> {
        type Output = Vec<[[f32; 2]; 2]>;

        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let Self(rows, lane) = self;
            let mut angles = Row([0.0; WIDTH]);
            angles.0.iter_mut().zip(rows).for_each(|(angle, row)| *angle = row.0[lane]);
            let moved = One::moved(l, l.load(&angles));
            let of_row = |number: usize| {
                let [sine, cosine] = All(l).sin_cos(rows, number);
                let mut all = [Row([0.0; WIDTH]); 2];
                l.store(sine, &mut all[0]);
                l.store(cosine, &mut all[1]);
                let one = One::with(l, lane, &moved).sin_cos(rows, number);
                [one, all.map(|row| row.0[lane])]
            };
            (0..rows.len()).map(of_row).collect()
        }
    }

    #[test]
    fn sines_of_one_state_are_those_of_sixteen_bit_for_bit() {
        for count in [0, 1, 7, 16, 17, 40] {
            let angle = |joint: usize| (joint * joint) as f32 * 0.37 % 16.0 - 8.0;
            let row = |joint| Row(std::array::from_fn(|lane| angle(joint + lane)));
            let rows: Vec<Row> = (0..count).map(row).collect();
            let paths = || Path::ALL.into_iter().filter(|path| path.is_available());
            for (path, lane) in paths().flat_map(|path| [0, 1, 15].map(|lane| (path, lane))) {
                let found = dispatch_on(path, Both(&rows, lane));
                for (joint, [one, all]) in found.into_iter().enumerate() {
                    let bits = |pair: [f32; 2]| pair.map(f32::to_bits);
                    assert_eq!(bits(one), bits(all), "{path:?}, joint {joint} of {count}");
                    let angle = f64::from(rows[joint].0[lane]);
                    let off = [f64::from(one[0]) - angle.sin(), f64::from(one[1]) - angle.cos()];
                    assert!(off.iter().all(|off| off.abs() < 3e-7), "{path:?}, {angle}: {off:?}");
                }
            }
        }
    }
}
