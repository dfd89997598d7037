//! The end of the search in double-double: the same steps, with about 106 bits.

use super::{Distance, rounded_up, unit, weighted};
use crate::PosedSupport;
use crate::double_double::{DoubleDouble, EPSILON};
use crate::exact::Number;
use crate::exact::grid::{Extent, Grid};
use crate::exact::nearest_point::scaled;
use crate::simplex::{Nearest, Scalar, Triple, dot, nearest};
use dcd_geom::Polytope;

/// How many steps the search may take here. No unit. It starts where f64 ended, so one or two are
/// the rule; what needs more goes to integers.
const MAX_STEPS: usize = 24;

/// How far a length or a separation per |d| may be off. Unit: relative to m < 1, absolute. The
/// roundings are those of the f64 bounds (7·√3 and 16) in units of [`EPSILON`], doubled.
const PADDING: f64 = 32.0 * EPSILON;

/// How much of the distance the two bounds may differ by, no unit: below an f64's last bit.
const CLOSED: f64 = f64::EPSILON / 16.0;

/// From a simplex of vertices by index, of two shapes that are apart. `None` where the bounds do
/// not close: the gap is below 106 bits, or the numbers leave f64's range.
pub(super) fn refined(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    scale: f64,
    hint: &[[u32; 2]],
) -> Option<Distance> {
    // The scale is a power of two.
    let unit_exponent = 1023 - (scale.to_bits() >> 52) as i32;
    let grid = Grid::<DoubleDouble>::new(a, b, &Extent::coarse(unit_exponent));
    let mut pairs: Vec<[usize; 2]> = hint.iter().map(|pair| pair.map(|k| k as usize)).collect();
    if pairs.is_empty() {
        pairs.push([0, 0]);
    }
    let mut points: Vec<Triple<DoubleDouble>> = pairs.iter().map(|&p| grid.point(p)).collect();
    let padding = DoubleDouble::from(PADDING);
    for _ in 0..MAX_STEPS {
        let near = nearest(&points)?;
        let upper = length(&points, &near)?.minus(grid.radius()).plus(&padding);
        let pair = grid.lowest(&near.direction);
        let vertex = grid.point(pair);
        let along =
            dot(&near.direction, &vertex).divided_by(dot(&near.direction, &near.direction).sqrt());
        let lower = along.minus(grid.radius()).minus(&padding);
        let gap = upper.minus(&lower).to_f64();
        if lower.is_positive() && gap <= CLOSED * lower.to_f64() {
            let distance = scaled(upper.to_f64(), i64::from(unit_exponent));
            return Some(answer(a, b, distance, &near, &pairs));
        }
        if pairs.contains(&pair) || near.count > 3 {
            return None;
        }
        let kept = &near.kept[..near.count];
        points = kept.iter().map(|&k| points[k]).chain([vertex]).collect();
        pairs = kept.iter().map(|&k| pairs[k]).chain([pair]).collect();
    }
    None
}

/// The length of Σλw/Σλ. `None` for NaN.
fn length(points: &[Triple<DoubleDouble>], near: &Nearest<DoubleDouble>) -> Option<DoubleDouble> {
    let mut sum = [DoubleDouble::zero(); 3];
    let mut total = DoubleDouble::zero();
    for (&k, weight) in near.kept.iter().zip(near.weights()) {
        sum = [0, 1, 2].map(|c| sum[c].plus(&points[k][c].times(weight)));
        total = total.plus(weight);
    }
    let v = sum.map(|x| x.divided_by(total));
    let length = dot(&v, &v).sqrt();
    (length.to_f64() >= 0.0).then_some(length)
}

fn answer(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    distance: f64,
    near: &Nearest<DoubleDouble>,
    pairs: &[[usize; 2]],
) -> Distance {
    let normal = unit(-DoubleDouble::rounded(&near.direction));
    let mut spanning = [[0; 2]; 4];
    let mut weights = [0.0; 4];
    let total: f64 = near.weights().iter().map(|weight| weight.to_f64()).sum();
    for (slot, (&k, weight)) in near.kept.iter().zip(near.weights()).enumerate() {
        spanning[slot] = pairs[k];
        weights[slot] = weight.to_f64() / total;
    }
    let [core_a, core_b] = weighted(a, b, &spanning[..near.count], &weights);
    Distance {
        distance,
        point_a: core_a + normal * a.map.swept_radius(),
        point_b: core_b - normal * b.map.swept_radius(),
        normal,
        // The gap, and the rounding of the distance to f64.
        error_bound: rounded_up(distance * (CLOSED + f64::EPSILON)),
    }
}
