//! The numbers of a cuboid's faces, from how its half edges compare.

use super::facing::FACING;
use dcd_geom::Polytope;
use dcd_simd::{larger, smaller};

/// The number of a box's face along axis `k` or against it: its index into [`dcd_geom::Facets`]. `None` where it is not
/// one of six.
#[inline(always)]
pub(super) fn face_number(
    polytope: &Polytope,
    half: [f64; 3],
    k: usize,
    is_forward: bool,
) -> Option<u32> {
    case_of(half)
        .and_then(|case| number_in(case, k, is_forward))
        .or_else(|| listed_number(polytope, k, is_forward))
}

/// The same where it is known how the half edges compare: see [`case_of`]. `None` of a larger number.
#[inline(always)]
pub(super) fn number_in(case: u32, k: usize, is_forward: bool) -> Option<u32> {
    let numbers = NUMBERS.get(case as usize)?;
    Some(numbers[(2 * k + usize::from(is_forward)) % 8].into())
}

/// The same from the list of the faces.
#[cold]
fn listed_number(polytope: &Polytope, k: usize, is_forward: bool) -> Option<u32> {
    let facets = polytope.facets().facets();
    let sense = if is_forward { 1.0 } else { -1.0 };
    let found = (0u32..).zip(facets).find(|(_, facet)| facet.normal[k] * sense > FACING);
    Some(found?.0)
}

/// How far apart, relative to the largest, half edges must be for the order of the faces to be known, if they are not
/// equal; and the least half edge, relative to the largest.
const DISTINCT: [f64; 2] = [1e-6, 1e-3];

/// The largest half edges of boxes whose faces' order is known: squared areas stay clear of under- and overflow.
const SIZES: std::ops::Range<f64> = 1e-60..1e60;

/// How the half edges of a box compare, as the digits of [`NUMBERS`]: the order of its faces hangs on nothing else, which
/// saves a search for the hull. `None` where rounding could play a part.
#[inline(always)]
pub(crate) fn case_of([x, y, z]: [f64; 3]) -> Option<u32> {
    let (most, least) = (larger(z, larger(y, x)), smaller(z, smaller(y, x)));
    let [apart, thin] = DISTINCT;
    let is_sure = |v: f64, w: f64| (v == w) | ((v - w).abs() > apart * most);
    // False for NaN.
    let is_known = SIZES.contains(&most) & (least > thin * most);
    if !(is_known & is_sure(x, y) & is_sure(x, z) & is_sure(y, z)) {
        return None;
    }
    let digit = |v: f64, w: f64| 1 + u32::from(v > w) - u32::from(v < w);
    Some(9 * digit(x, y) + 3 * digit(x, z) + digit(y, z))
}

/// The numbers of the faces against the first axis, along it, against the second, and so on; eight of six, so that no index
/// is too large. By how the half edges compare: x with y, x with z, y with z; 0 for less, 1 for equal, 2 for greater, as three
/// digits.
static NUMBERS: [[u8; 8]; 27] = {
    let mut numbers = [[0; 8]; 27];
    let mut case = 0;
    while case < 27 {
        let order = order_of([case / 9, case / 3 % 3, case % 3]);
        let mut number = 0;
        while number < 6 {
            let name = order[number];
            let axis = name.to_ascii_lowercase() - b'x';
            numbers[case][(2 * axis + name.is_ascii_uppercase() as u8) as usize] = number as u8;
            number += 1;
        }
        case += 1;
    }
    numbers
};

/// The order in which [`dcd_geom::Facets`] has the six faces: x is that against the first axis, X that along it. Of numbers that
/// cannot compare so, any.
const fn order_of(compared: [usize; 3]) -> &'static [u8; 6] {
    match compared {
        [0, 0, 0] => b"XxYyzZ",
        [0, 0, 1] => b"xXYzyZ",
        [0, 0, 2] => b"xXzZYy",
        [0, 1, 2] => b"xzXZYy",
        [0, 2, 2] => b"zZxXYy",
        [1, 0, 0] => b"YXyxzZ",
        [1, 1, 1] => b"XyzYxZ",
        [1, 2, 2] => b"zZXyYx",
        [2, 0, 0] => b"YyXxzZ",
        [2, 1, 0] => b"yYXzxZ",
        [2, 2, 0] => b"yYzZXx",
        [2, 2, 1] => b"yzYZXx",
        _ => b"zZyYXx",
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use dcd_geom::glam::DVec3;

    /// Repeatable numbers from 0 to 1.
    pub(in super::super) struct Draw(pub(in super::super) u64);

    impl Draw {
        pub(in super::super) fn unit(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_041);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }

        fn below(&mut self, count: usize) -> usize {
            (self.unit() * count as f64) as usize
        }
    }

    /// Half edges that are equal, nearly equal or apart, thin or not, from tiny to huge.
    fn half_edges(draw: &mut Draw) -> [f64; 3] {
        let mut half = [(); 3].map(|()| 0.1 + draw.unit());
        let near = [1.0, 1.0 + 1e-15, 1.0 - 1e-9, 1.0 + 1.1e-6, 1.0 + 1e-4][draw.below(5)];
        let (j, k) = (draw.below(3), draw.below(3));
        match draw.below(4) {
            0 => half[j] = half[k] * near,
            1 => half = [half[0]; 3],
            _ => {}
        }
        half[draw.below(3)] *= [1.0, 1.0, 1e-2, 2e-3, 1e-5][draw.below(5)];
        half[draw.below(3)] *= [1.0, 1.0, 1e-2][draw.below(3)];
        let size = [1.0, 1e-5, 1e6, 1e-59, 1e58][draw.below(5)];
        half.map(|x| x * size)
    }

    #[test]
    fn faces_have_the_numbers_of_the_facets_of_the_hull() {
        let (mut draw, mut known) = (Draw(81), [0; 2]);
        for _ in 0..20_000 {
            let half = half_edges(&mut draw);
            let Some(case) = case_of(half) else {
                known[0] += 1;
                continue;
            };
            known[1] += 1;
            let cuboid = Polytope::cuboid(DVec3::from_array(half)).unwrap();
            let facets = cuboid.facets().facets();
            assert_eq!(facets.len(), 6, "{half:?}");
            for (k, is_forward) in (0..6).map(|k| (k / 2, k % 2 == 1)) {
                let sense = if is_forward { 1.0 } else { -1.0 };
                let number = number_in(case, k, is_forward).unwrap();
                let normal = facets[number as usize].normal;
                assert!(normal[k] * sense > 0.99, "{half:?} {facets:?} {k} {number}");
            }
        }
        assert!(known.into_iter().all(|count| count > 2000), "{known:?}");
    }
}
