//! Numbers that depend on t, with their first and second derivative, over an interval of t.

use super::angle::sin_cos;
use super::interval::Interval;

/// Enclosures of f, f′ and f″ on one interval of t.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jet {
    pub(crate) value: Interval,
    pub(crate) first: Interval,
    pub(crate) second: Interval,
}

impl Jet {
    pub(crate) const ZERO: Self = Self::constant(Interval::ZERO);

    pub(crate) const fn constant(value: Interval) -> Self {
        Self { value, first: Interval::ZERO, second: Interval::ZERO }
    }

    pub(crate) fn add(self, other: Self) -> Self {
        Self {
            value: self.value.add(other.value),
            first: self.first.add(other.first),
            second: self.second.add(other.second),
        }
    }

    pub(crate) fn sub(self, other: Self) -> Self {
        self.add(other.scale(Interval::point(-1.0)))
    }

    /// Times a number that does not depend on t.
    pub(crate) fn scale(self, by: Interval) -> Self {
        Self { value: self.value.mul(by), first: self.first.mul(by), second: self.second.mul(by) }
    }

    pub(crate) fn mul(self, other: Self) -> Self {
        let two = Interval::point(2.0);
        Self {
            value: self.value.mul(other.value),
            first: self.first.mul(other.value).add(self.value.mul(other.first)),
            second: self
                .second
                .mul(other.value)
                .add(two.mul(self.first.mul(other.first)))
                .add(self.value.mul(other.second)),
        }
    }

    /// Its sine and its cosine, rad.
    pub(crate) fn sin_cos(self) -> [Self; 2] {
        let [sin, cos] = sin_cos(self.value);
        let (first, square) = (self.first, self.first.square());
        let of = |value: Interval, slope: Interval| Self {
            value,
            first: slope.mul(first),
            second: slope.mul(self.second).sub(value.mul(square)),
        };
        [of(sin, cos), of(cos, sin.neg())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_formula() {
        // f = t²·sin(3t): f′ = 2t sin + 3t² cos, f″ = 2 sin + 12 t cos − 9 t² sin.
        for t in [-1.3, 0.0, 0.4, 2.0] {
            let jet = |value: f64, first: f64| Jet {
                value: Interval::point(value),
                first: Interval::point(first),
                second: Interval::ZERO,
            };
            let (t_jet, angle) = (jet(t, 1.0), jet(3.0 * t, 3.0));
            let found = t_jet.mul(t_jet).mul(angle.sin_cos()[0]);
            let (s, c) = (3.0 * t).sin_cos();
            let expected = [
                t * t * s,
                2.0 * t * s + 3.0 * t * t * c,
                2.0 * s + 12.0 * t * c - 9.0 * t * t * s,
            ];
            for (found, expected) in [found.value, found.first, found.second].iter().zip(expected) {
                assert!(found.lo - 1e-14 <= expected && expected <= found.hi + 1e-14, "{t}");
                assert!(found.hi - found.lo < 1e-12, "{t}: {found:?}");
            }
        }
    }
}
