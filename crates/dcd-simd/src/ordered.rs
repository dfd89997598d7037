//! The smaller and the larger of two numbers in one instruction, where `f64::min` takes several.

/// The smaller; the first where either is NaN.
#[inline(always)]
pub fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The larger; the first where either is NaN.
#[inline(always)]
pub fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_those_of_the_standard_library_but_for_nan_which_leaves_the_first() {
        for a in [-1.0, 0.0, 2.5, f64::INFINITY, f64::NEG_INFINITY] {
            for b in [-2.0, 0.0, 2.5, f64::INFINITY] {
                assert_eq!((smaller(a, b), larger(a, b)), (a.min(b), a.max(b)));
            }
            assert_eq!((smaller(a, f64::NAN), larger(a, f64::NAN)), (a, a));
            assert!(smaller(f64::NAN, a).is_nan() && larger(f64::NAN, a).is_nan());
        }
    }
}
