//! Lanes that never fuse a product and a sum, so that every path gives the same bits.

use crate::{Block, IndexRow, Kernel, Lanes, Pair, Row, WIDTH};

/// A kernel whose answers are the same bits on every path: [`Lanes::mul_add`] rounds twice in it.
///
/// A product and a sum take two operations where one would do; all else is as fast.
#[derive(Clone, Copy, Debug)]
pub struct Unfused<K>(
    /// The kernel.
    pub K,
);

impl<K: Kernel> Kernel for Unfused<K> {
    type Output = K::Output;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> K::Output {
        lanes.run_unfused(self.0)
    }
}

/// The other lanes but for [`Lanes::mul_add`].
#[derive(Clone, Copy)]
pub(crate) struct Apart<L>(pub(crate) L);

/// Hands methods on to the lanes within.
macro_rules! hand_on {
    ($($name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        $(#[inline(always)]
        fn $name(self, $($argument: $type),*) $(-> $result)? {
            self.0.$name($($argument),*)
        })*
    };
}
pub(crate) use hand_on;

/// Hands on what is the same lane by lane, however many lanes there are.
macro_rules! hand_on_arithmetic {
    () => {
        hand_on! {
            splat(x: f32) -> L::F;
            add(a: L::F, b: L::F) -> L::F;
            sub(a: L::F, b: L::F) -> L::F;
            mul(a: L::F, b: L::F) -> L::F;
            div(a: L::F, b: L::F) -> L::F;
            min(a: L::F, b: L::F) -> L::F;
            max(a: L::F, b: L::F) -> L::F;
            abs(a: L::F) -> L::F;
            sqrt(a: L::F) -> L::F;
            lt(a: L::F, b: L::F) -> L::M;
            le(a: L::F, b: L::F) -> L::M;
            select(mask: L::M, yes: L::F, no: L::F) -> L::F;
            and(a: L::M, b: L::M) -> L::M;
            or(a: L::M, b: L::M) -> L::M;
            and_not(a: L::M, b: L::M) -> L::M;
            splat_d(x: f64) -> L::D;
            load_d(numbers: &[f64; $crate::WIDTH / 2]) -> L::D;
            store_d(a: L::D, numbers: &mut [f64; $crate::WIDTH / 2]);
            add_d(a: L::D, b: L::D) -> L::D;
            sub_d(a: L::D, b: L::D) -> L::D;
            mul_d(a: L::D, b: L::D) -> L::D;
            div_d(a: L::D, b: L::D) -> L::D;
            select_lt_d(a: L::D, b: L::D, yes: L::D, no: L::D) -> L::D;
            lt_d(a: L::D, b: L::D) -> u32;
            splat_u(x: u32) -> L::U;
            add_u(a: L::U, b: L::U) -> L::U;
            tag(a: L::F, mask: L::U, tag: L::U) -> L::F;
            tag_of(a: L::F, mask: L::U) -> L::U;
            neg(a: L::F) -> L::F;
        }

        #[inline(always)]
        fn sphere_pairs<S: AsRef<[f64; 4]>>(
            self,
            spheres: [&[S]; 2],
            pairs: &[$crate::Pair; $crate::WIDTH / 2],
        ) -> [L::D; 4] {
            self.0.sphere_pairs(spheres, pairs)
        }
    };
}
pub(crate) use hand_on_arithmetic;

impl<L: Lanes> Lanes for Apart<L> {
    type F = L::F;
    type U = L::U;
    type M = L::M;
    type D = L::D;
    const HALVES: bool = L::HALVES;

    #[inline(always)]
    fn mul_add(self, a: L::F, b: L::F, c: L::F) -> L::F {
        self.0.add(self.0.mul(a, b), c)
    }

    #[inline(always)]
    fn call<K: Kernel>(self, kernel: K) -> K::Output {
        self.0.call(Unfused(kernel))
    }

    hand_on_arithmetic! {}

    hand_on! {
        load_from(numbers: &[f32; WIDTH]) -> L::F;
        round_from(numbers: [&[f64; WIDTH / 2]; 2]) -> L::F;
        store_to(a: L::F, numbers: &mut [f32; WIDTH]);
        load_half(numbers: &[f32; WIDTH / 2]) -> L::F;
        load_points(points: [&[f32; 4]; WIDTH / 2]) -> [L::F; 3];
        store_half(a: L::F, numbers: &mut [f32; WIDTH / 2]);
        half_bits(mask: L::M) -> u32;
        bits(mask: L::M) -> u32;
        mask(bits: u32) -> L::M;
        load_from_u(numbers: &[u32; WIDTH]) -> L::U;
        store_to_u(a: L::U, numbers: &mut [u32; WIDTH]);
        lane_numbers() -> L::U;
        compress_to(keep: u32, a: L::F, to: &mut [f32; 2 * WIDTH], at: usize);
        compress_to_u(keep: u32, a: L::U, to: &mut [u32; 2 * WIDTH], at: usize);
        append_pairs(keep: u32, pair: (u32, L::U), to: &mut Vec<Pair>);
        largest_of_each(rows: &[Row; WIDTH]) -> L::F;
        largest(a: L::F) -> f32;
        transpose(rows: &[Row; WIDTH]) -> [L::F; WIDTH];
        pick(blocks: &[Block], first: L::U, number: L::U) -> [L::F; 3];
        load(row: &Row) -> L::F;
        store(a: L::F, row: &mut Row);
        load_u(row: &IndexRow) -> L::U;
        store_u(a: L::U, row: &mut IndexRow);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Path, dispatch_on};

    /// a·b + c, lane by lane.
    struct Sum<'a>([&'a Row; 3]);

    impl Kernel for Sum<'_> {
        type Output = Row;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Row {
            let [a, b, c] = self.0.map(
                #[inline(always)]
                |row| l.load(row),
            );
            let mut sum = Row::default();
            l.store(l.mul_add(a, b, c), &mut sum);
            sum
        }
    }

    #[test]
    fn a_product_and_a_sum_are_rounded_twice_on_every_path() {
        let a = Row(std::array::from_fn(|k| 1.0 + (k as f32 + 1.0) * f32::EPSILON));
        let c = Row(a.0.map(|x| -(x * x)));
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let sum = dispatch_on(path, Unfused(Sum([&a, &a, &c])));
            assert_eq!(sum, Row::default(), "{path:?}");
        }
    }
}
