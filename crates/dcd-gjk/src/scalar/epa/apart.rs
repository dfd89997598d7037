//! The distance of two cores that do not overlap, for the depth of the shapes swept
//! round them.
//!
//! GJK on the lattice: f64 only proposes the feature nearest the origin; its normal, the support
//! along it and so the lower bound are exact, and the upper bound is the length of a convex
//! combination with integer weights. A wrong proposal costs a step, never a bound.

use super::lattice::{Normal, Vertex, as_normal, cross, dot, length, minus, rounded, two_to};
use super::search::Viewer;
use super::start::{from_line_to_origin, negative};
use super::wide::Wide;
use super::witness::Weighted;
use crate::double_double::DoubleDouble;
use crate::simplex::{Nearest, Scalar, dot as dot_of, nearest};

/// Steps of the iteration; ten are usual. Bounds the time where f64 proposes the same features in
/// turn. Smaller: larger error bounds there.
const STEPS: usize = 128;

/// How far a vertex must be beyond the feature for another step, units. Below what the lattice
/// resolves, and well above the rounding of an edge's normal.
const BEYOND: f64 = 4.0;

/// The distance of the origin from the difference on the lattice, units.
pub(super) struct Gap {
    pub(super) lower: f64,
    pub(super) upper: f64,
    /// The direction in which `lower` separates: from A to B.
    pub(super) normal: Normal,
    /// normal·w at most; `lower` is −reach / |normal|, or 0.
    reach: Wide,
    /// Vertices times integer weights, and the sum of the weights: `upper` is the quotient's length.
    combination: ([Wide; 3], i128),
    corners: [Weighted; 4],
    count: usize,
}

impl Gap {
    /// The vertices whose mean is nearest the origin.
    pub(super) fn corners(&self) -> &[Weighted] {
        &self.corners[..self.count]
    }

    /// What is left of the radii, in units, when the lower bound is taken off, negative if nothing;
    /// `None` where nothing cancels or the radii are out of all proportion. Then the same of the upper
    /// bound, −∞ where there is none.
    ///
    /// With a bound √(p/q) for integers p and q, r − √(p/q) is (r²q − p) / (r√q + √p)√q, whose
    /// numerator is taken in double-double: no digit is lost where the shapes barely touch.
    pub(super) fn left_of(&self, radii: [f64; 2]) -> Option<[f64; 2]> {
        let r = DoubleDouble::from(radii[0]).plus(&radii[1].into());
        let left = |p: DoubleDouble, root_of_p: f64, q: DoubleDouble| {
            let root = q.to_f64().sqrt();
            let left = r.times(&r).times(&q).minus(&p);
            left.to_f64() / ((r.to_f64() * root + root_of_p) * root)
        };
        let (n, s) = (self.normal.map(leading), leading(self.reach));
        let above = left(s.times(&s), -s.to_f64(), dot_of(&n, &n));
        let (sum, weight) = (self.combination.0.map(leading), leading(self.combination.1.into()));
        let p = dot_of(&sum, &sum);
        let below = left(p, p.to_f64().sqrt(), weight.times(&weight));
        let below = if below.is_finite() { below } else { f64::NEG_INFINITY };
        (above.is_finite() && self.reach < Wide::ZERO).then_some([above, below])
    }

    /// Keeps the vertices that have a weight, and their combination if it is the nearest so far.
    fn keep(&mut self, simplex: &mut [Vertex; 4], near: &Nearest<f64>) -> usize {
        let known = *simplex;
        let total: f64 = near.weights().iter().sum();
        let steps = two_to(60);
        let mut corners = self.corners;
        let mut sum = [Wide::ZERO; 3];
        let (mut all, mut total_weight) = (0.0, 0);
        for (slot, (&index, &share)) in near.kept.iter().zip(near.weights()).enumerate() {
            simplex[slot] = known[index];
            corners[slot] = (known[index], share);
            let weight = (share / total * steps) as i128;
            all += weight as f64;
            total_weight += weight;
            for (sum, x) in sum.iter_mut().zip(known[index].w) {
                *sum = *sum + Wide::product(x, weight);
            }
        }
        let upper = length(&sum) / all;
        if upper < self.upper {
            (self.upper, self.corners, self.count) = (upper, corners, near.count);
            self.combination = (sum, total_weight);
        }
        near.count
    }
}

impl Viewer<'_> {
    /// Begins with the support along `normal`, which separates or nearly does.
    pub(super) fn gap(&mut self, normal: Normal) -> Gap {
        self.difference.drop_apexes();
        let first = self.difference.support(&normal);
        let reach = first.reach.to_f64() / length(&normal);
        let nowhere = (first.vertex, 0.0);
        let mut gap = Gap {
            lower: (-reach).max(0.0),
            upper: f64::INFINITY,
            normal,
            reach: first.reach,
            combination: ([Wide::ZERO; 3], 0),
            corners: [nowhere; 4],
            count: 0,
        };
        let mut simplex = [first.vertex; 4];
        let mut count = 1;
        for _ in 0..STEPS {
            let points = simplex.map(|vertex| rounded(&as_normal(vertex.w)).to_array());
            let Some(near) = nearest(&points[..count]) else {
                break;
            };
            count = gap.keep(&mut simplex, &near);
            // The combination is on hand: its length is a bound even if f64 errs in seeing the
            // origin inside a tetrahedron.
            let Some(towards) = from_simplex_to_origin(&simplex[..count]) else {
                break;
            };
            let support = self.difference.support(&towards);
            let lower = -support.reach.to_f64() / length(&towards);
            if lower > gap.lower {
                (gap.lower, gap.normal, gap.reach) = (lower, towards, support.reach);
            }
            let beyond = (support.reach - dot(&towards, simplex[0].w)).to_f64();
            if beyond <= BEYOND * length(&towards) || simplex[..count].contains(&support.vertex) {
                break;
            }
            simplex[count] = support.vertex;
            count += 1;
        }
        gap
    }
}

/// At right angles to the simplex, towards the origin; `None` if the origin is in its point, line
/// or plane.
fn from_simplex_to_origin(simplex: &[Vertex]) -> Option<Normal> {
    let normal = match *simplex {
        [p] => negative(&as_normal(p.w)),
        [p, q] => {
            let e = minus(q.w, p.w);
            if cross(p.w, e) == [Wide::ZERO; 3] {
                return None;
            }
            from_line_to_origin(p.w, e)
        }
        [p, q, r] => {
            let normal = cross(minus(q.w, p.w), minus(r.w, p.w));
            let offset = dot(&normal, p.w);
            if offset == Wide::ZERO {
                return None;
            }
            if offset > Wide::ZERO { negative(&normal) } else { normal }
        }
        _ => return None,
    };
    (normal != [Wide::ZERO; 3]).then_some(normal)
}

/// The leading 106 bits.
fn leading(x: Wide) -> DoubleDouble {
    let shift = x.bits().saturating_sub(106);
    let leading = x.shifted_down(shift);
    let high = leading as f64;
    let low = (leading - high as i128) as f64;
    let scale = two_to(shift as i32);
    DoubleDouble::from(high * scale).plus(&(low * scale).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leading_digits_of_long_integers_survive_a_cancellation() {
        let x = Wide::product((1 << 100) + 1, (1 << 90) + 3);
        let back = leading(x).minus(&leading(Wide::product(1 << 100, 1 << 90)));
        assert_eq!(back.to_f64(), 3.0 * two_to(100) + two_to(90));
    }
}
