//! Intervals of real numbers with f64 ends, each operation rounded outward by one step of f64.

/// All real numbers from `lo` to `hi`; an end may be infinite, none is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interval {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
}

impl Interval {
    pub(crate) const ENTIRE: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
    pub(crate) const ZERO: Self = Self { lo: 0.0, hi: 0.0 };
    pub(crate) const ONE: Self = Self { lo: 1.0, hi: 1.0 };

    /// All reals where the ends are no ends: NaN, or in the wrong order.
    pub(crate) fn new(lo: f64, hi: f64) -> Self {
        if lo <= hi { Self { lo, hi } } else { Self::ENTIRE }
    }

    pub(crate) fn point(x: f64) -> Self {
        Self::new(x, x)
    }

    /// From −x to x.
    pub(crate) fn within(x: f64) -> Self {
        Self::new(-x, x)
    }

    /// Of ends that were rounded to the nearest f64: the truth is less than a step away.
    fn rounded(lo: f64, hi: f64) -> Self {
        Self::new(lo.next_down(), hi.next_up())
    }

    fn is(self, x: f64) -> bool {
        self.lo == x && self.hi == x
    }

    pub(crate) fn add(self, other: Self) -> Self {
        if self.is(0.0) {
            return other;
        }
        if other.is(0.0) {
            return self;
        }
        Self::rounded(self.lo + other.lo, self.hi + other.hi)
    }

    pub(crate) fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }

    pub(crate) fn sub(self, other: Self) -> Self {
        self.add(other.neg())
    }

    pub(crate) fn mul(self, other: Self) -> Self {
        // Of numbers, infinite ends stand for arbitrarily large ones: 0 times any is 0.
        if self.is(0.0) || other.is(0.0) {
            return Self::ZERO;
        }
        if self.is(1.0) {
            return other;
        }
        if other.is(1.0) {
            return self;
        }
        let products =
            [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        if products.iter().any(|x| x.is_nan()) {
            return Self::ENTIRE;
        }
        let lo = products.into_iter().fold(f64::INFINITY, f64::min);
        let hi = products.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Self::rounded(lo, hi)
    }

    pub(crate) fn square(self) -> Self {
        let product = self.mul(self);
        Self::new(product.lo.max(0.0), product.hi)
    }

    /// All reals where the divisor may be 0.
    pub(crate) fn div(self, other: Self) -> Self {
        if !(other.lo > 0.0 || other.hi < 0.0) {
            return Self::ENTIRE;
        }
        let quotients =
            [self.lo / other.lo, self.lo / other.hi, self.hi / other.lo, self.hi / other.hi];
        if quotients.iter().any(|x| x.is_nan()) {
            return Self::ENTIRE;
        }
        let lo = quotients.into_iter().fold(f64::INFINITY, f64::min);
        let hi = quotients.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Self::rounded(lo, hi)
    }

    /// The roots of what is not negative in it.
    pub(crate) fn sqrt(self) -> Self {
        let lo = self.lo.max(0.0).sqrt().next_down().max(0.0);
        Self::new(lo, self.hi.max(0.0).sqrt().next_up())
    }

    /// The largest absolute value.
    pub(crate) fn magnitude(self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// What both have in common; all reals where that is nothing, which cannot be.
    pub(crate) fn and(self, other: Self) -> Self {
        Self::new(self.lo.max(other.lo), self.hi.min(other.hi))
    }

    pub(crate) fn hull(self, other: Self) -> Self {
        Self::new(self.lo.min(other.lo), self.hi.max(other.hi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_holds_the_exact_result_and_little_else() {
        let mut draw = 1u64;
        let mut number = || {
            draw = draw
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let mantissa = ((draw >> 33) as i64 - (1 << 30)) as f64;
            mantissa * 2f64.powi((draw >> 11) as i32 % 20 - 10)
        };
        for _ in 0..20_000 {
            // 31 bits each: the product is exact in f64, the sum in an i128 of 2⁻²⁰.
            let (a, b) = (number(), number());
            let (x, y) = (Interval::point(a), Interval::point(b));
            let fixed = |x: f64| (x * 1_048_576.0) as i128;
            let sum = x.add(y);
            assert!(fixed(a) + fixed(b) <= fixed(sum.hi.next_up()) + 1, "{a} {b}");
            assert!(sum.lo <= a + b && a + b <= sum.hi && sum.hi - sum.lo <= (a + b).abs() * 1e-15);
            let product = x.mul(y);
            assert!(product.lo <= a * b && a * b <= product.hi, "{a} {b}");
            let root = x.square().sqrt();
            assert!(root.lo <= a.abs() && a.abs() <= root.hi, "{a}");
            if b != 0.0 {
                let back = product.div(y);
                assert!(back.lo <= a && a <= back.hi, "{a} {b}");
            }
        }
    }

    #[test]
    fn the_product_of_wide_ones_is_the_least_and_the_largest() {
        let x = Interval::new(-2.0, 3.0);
        let product = x.mul(Interval::new(-5.0, 7.0));
        assert!(product.lo < -15.0 && product.lo > -15.1 && product.hi > 21.0 && product.hi < 21.1);
        assert_eq!(x.square().lo, 0.0);
        assert_eq!(x.div(x), Interval::ENTIRE);
    }

    #[test]
    fn what_has_no_bound_is_everything_and_never_nothing() {
        let huge = Interval::point(f64::MAX);
        let over = huge.mul(huge);
        assert_eq!(over.hi, f64::INFINITY);
        assert_eq!(over.sub(over), Interval::ENTIRE);
        assert_eq!(Interval::point(f64::NAN), Interval::ENTIRE);
        assert_eq!(over.mul(Interval::new(-1.0, 1.0)).mul(Interval::ZERO), Interval::ZERO);
        assert_eq!(Interval::ENTIRE.mul(Interval::new(0.0, 1.0)), Interval::ENTIRE);
    }
}
