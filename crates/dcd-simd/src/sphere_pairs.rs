//! Pairs of spheres in f64, four at a time, on CPUs with AVX2.

use crate::Pair;
use std::arch::x86_64::*;

/// The differences of the centres' x, y and z and the sums of the radii of four pairs.
///
/// # Safety
/// The CPU has AVX2.
#[inline(always)]
pub(crate) unsafe fn four<S: AsRef<[f64; 4]>>(
    spheres: [&[S]; 2],
    [a, b, c, d]: &[Pair; 4],
) -> [__m256d; 4] {
    // SAFETY: as above.
    unsafe {
        let (a, b) = (between(spheres, *a), between(spheres, *b));
        let (c, d) = (between(spheres, *c), between(spheres, *d));
        let (xz_ab, yr_ab) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
        let (xz_cd, yr_cd) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
        [
            _mm256_permute2f128_pd::<0x20>(xz_ab, xz_cd),
            _mm256_permute2f128_pd::<0x20>(yr_ab, yr_cd),
            _mm256_permute2f128_pd::<0x31>(xz_ab, xz_cd),
            _mm256_permute2f128_pd::<0x31>(yr_ab, yr_cd),
        ]
    }
}

/// The same of one pair, in a row.
///
/// # Safety
/// The CPU has AVX2.
#[inline(always)]
unsafe fn between<S: AsRef<[f64; 4]>>([a, b]: [&[S]; 2], pair: Pair) -> __m256d {
    let (a, b) = (a[pair.i as usize].as_ref(), b[pair.j as usize].as_ref());
    // SAFETY: as above; four f64 are read from wherever they are.
    unsafe {
        let (a, b) = (_mm256_loadu_pd(a.as_ptr()), _mm256_loadu_pd(b.as_ptr()));
        // A radius less the negative of another is their sum, bit for bit.
        _mm256_sub_pd(a, _mm256_xor_pd(b, _mm256_setr_pd(0.0, 0.0, 0.0, -0.0)))
    }
}

/// Which of four are less, a bit each.
///
/// # Safety
/// The CPU has AVX2.
#[inline(always)]
pub(crate) unsafe fn less(a: __m256d, b: __m256d) -> i32 {
    // SAFETY: as above.
    unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a, b)) }
}
