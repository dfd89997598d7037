//! Rows that become columns.

use super::Avx2;
use crate::{Row, WIDTH};
use std::arch::x86_64::*;

impl Avx2 {
    /// Half h of register k is lane 4h + k of the four rows.
    #[inline(always)]
    fn transpose_four(self, a: __m256, b: __m256, c: __m256, d: __m256) -> [__m256; 4] {
        op!({
            let ab_low = _mm256_castps_pd(_mm256_unpacklo_ps(a, b));
            let ab_high = _mm256_castps_pd(_mm256_unpackhi_ps(a, b));
            let cd_low = _mm256_castps_pd(_mm256_unpacklo_ps(c, d));
            let cd_high = _mm256_castps_pd(_mm256_unpackhi_ps(c, d));
            [
                _mm256_castpd_ps(_mm256_unpacklo_pd(ab_low, cd_low)),
                _mm256_castpd_ps(_mm256_unpackhi_pd(ab_low, cd_low)),
                _mm256_castpd_ps(_mm256_unpacklo_pd(ab_high, cd_high)),
                _mm256_castpd_ps(_mm256_unpackhi_pd(ab_high, cd_high)),
            ]
        })
    }

    /// Lanes `lane` to `lane` + 7 of the eight rows from `row` on, as columns.
    #[inline(always)]
    pub(super) fn transpose_eight(
        self,
        rows: &[Row; WIDTH],
        row: usize,
        lane: usize,
    ) -> [__m256; 8] {
        let mut r = [op!(_mm256_setzero_ps()); 8];
        for k in 0..8 {
            let part = &rows[row + k].0[lane..lane + 8];
            // SAFETY: as above; eight f32 are read from wherever they are.
            r[k] = unsafe { _mm256_loadu_ps(part.as_ptr()) };
        }
        let (above, below) = (
            self.transpose_four(r[0], r[1], r[2], r[3]),
            self.transpose_four(r[4], r[5], r[6], r[7]),
        );
        let mut columns = r;
        for k in 0..4 {
            columns[k] = op!(_mm256_permute2f128_ps::<0x20>(above[k], below[k]));
            columns[k + 4] = op!(_mm256_permute2f128_ps::<0x31>(above[k], below[k]));
        }
        columns
    }

    /// The x, y and z of eight points.
    #[inline(always)]
    pub(super) fn eight_points(self, points: [&[f32; 4]; WIDTH / 2]) -> [__m256; 3] {
        let mut r = [op!(_mm256_setzero_ps()); 4];
        for k in 0..4 {
            // SAFETY: as above; four f32 are read from wherever they are, twice.
            r[k] = unsafe {
                let low = _mm_loadu_ps(points[k].as_ptr());
                _mm256_set_m128(_mm_loadu_ps(points[k + 4].as_ptr()), low)
            };
        }
        let [x, y, z, _] = self.transpose_four(r[0], r[1], r[2], r[3]);
        [x, y, z]
    }
}
