//! How far apart two polytopes are, exactly, and then rounded once.

use super::grid::{Extent, Grid};
use super::integer::{Integer, Large, Number};
use super::{ExactGjk, nearest};
use crate::PosedSupport;
use crate::simplex::{Nearest, Scalar, dot};
use dcd_geom::Polytope;
use dcd_geom::glam::DVec3;

/// The exact nearest point of the cores' difference, rounded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exact {
    /// The distance less the swept radii, metres, within 2⁻⁴⁹ of itself.
    pub(crate) distance: f64,
    /// From the origin to the nearest point, its largest component near 1.
    pub(crate) direction: DVec3,
    /// The vertices that span the nearest point.
    pub(crate) pairs: [[usize; 2]; 3],
    /// Their weights, which sum to 1; 0 beyond the last.
    pub(crate) weights: [f64; 3],
}

/// Of two that share no point; `None` where the cores do.
pub(crate) fn closest(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    hint: &[[u32; 2]],
) -> Option<Exact> {
    let extent = Extent::of(a, b);
    let mut search = ExactGjk::<Large>::new(Grid::new(a, b, &extent), hint);
    loop {
        let near = nearest(&search.points)?;
        if near.count > 3 || !near.square[0].is_positive() {
            return None;
        }
        let pair = search.grid.lowest(&near.direction);
        let vertex = search.grid.point(pair);
        let known = dot(&near.direction, &search.points[near.kept[0]]);
        // No vertex is beyond the plane through the nearest point: it is the difference's.
        if !dot(&near.direction, &vertex).minus(&known).is_negative() {
            return Some(rounded(&search, &near, i64::from(extent.unit())));
        }
        search.step(&near, pair, vertex);
    }
}

fn rounded(search: &ExactGjk<'_, Large>, near: &Nearest<Large>, unit: i64) -> Exact {
    let [numerator, divisor] = &near.square;
    let excess = numerator.minus(&search.radius_squared.times(divisor));
    let length = root(numerator, divisor);
    let (radius, exponent) = search.grid.radius().to_float();
    // |v| − R as (|v|² − R²) / (|v| + R), which does not cancel: |v| + R at |v|'s exponent.
    let sum = length.0 + scaled(radius, exponent - length.1);
    let (top, top_exponent) = excess.to_float();
    let (below, below_exponent) = divisor.to_float();
    let distance = scaled(top / below / sum, top_exponent - below_exponent - length.1 + unit);
    let mut pairs = [search.pairs[near.kept[0]]; 3];
    let mut weights = [0.0; 3];
    let bits = near.weights().iter().map(Integer::bits).max().unwrap_or(0);
    let drop = bits.saturating_sub(62);
    for (slot, (&k, weight)) in near.kept.iter().zip(near.weights()).enumerate() {
        pairs[slot] = search.pairs[k];
        weights[slot] = weight.high(drop) as f64;
    }
    let total: f64 = weights.iter().sum();
    let weights = weights.map(|weight| weight / total);
    Exact { distance, direction: Number::rounded(&near.direction), pairs, weights }
}

/// m and e with m·2^e = √(numerator / divisor).
fn root(numerator: &Large, divisor: &Large) -> (f64, i64) {
    let ((top, top_exponent), (below, below_exponent)) = (numerator.to_float(), divisor.to_float());
    let (ratio, exponent) = (top / below, top_exponent - below_exponent);
    let odd = exponent.rem_euclid(2);
    ((ratio * f64::from(1 + odd as i32)).sqrt(), (exponent - odd) / 2)
}

/// x·2^e, infinite or denormal where f64 ends.
pub(crate) fn scaled(x: f64, exponent: i64) -> f64 {
    let mut rest = exponent.clamp(-5000, 5000) as i32;
    let mut x = x;
    while rest != 0 && x != 0.0 && x.is_finite() {
        let step = rest.clamp(-1000, 1000);
        x *= 2f64.powi(step);
        rest -= step;
    }
    x
}
