//! The distance of two polytopes whose nearest features f64 has found: evaluated once in double-double.
//!
//! Nothing is believed of the search: a point of the simplex proves how far apart they are at most, and the direction to
//! it, square to the simplex, how far at least (docs/numerics/proofs.md, "Nearest features of polytopes").

use super::approach::Approach;
use super::{Distance, UNIT, rounded_up, unit, weighted};
use crate::PosedSupport;
use crate::closed::{SIZES, square_to};
use crate::double_double::{DoubleDouble, EPSILON, Sum, two_sum};
use crate::simplex::{Scalar, Triple, dot, minus};
use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Vector};

/// How far a length and a separation per |d| may be off. Unit: [`EPSILON`]·m. Derived: 90. Smaller: distances outside their bounds.
const PADDING: f64 = 128.0;

/// How much of the distance the two bounds may differ by, no unit: below an f64's last bit. Larger: worse bounds.
const CLOSED: f64 = f64::EPSILON / 16.0;

/// What the difference of two vertices' products with a direction may be off in f64. Unit: u·|d|·reach. Derived: 21.
/// Smaller: vertices that are missed. Larger: more of them in double-double.
const LEVEL: f64 = 32.0;

/// What a sum of a product and its corrections loses: u, relative to its terms. Derived: 9.
const CORRECTED: f64 = 12.0;

/// How often a point is corrected at most: once where the distance is above 1e-7 of the size, twice down to 1e-12 of it.
const CORRECTIONS: usize = 3;

/// Two vertices of the difference seen from a third; those that there are not are at it.
struct Edges {
    /// What each shape has in them, world axes.
    of_sides: [[Triple<DoubleDouble>; 2]; 2],
    whole: [Triple<DoubleDouble>; 2],
    rounded: [DVec3; 2],
}

/// One side, as a support of the difference needs it.
struct Side<'a> {
    body: PosedSupport<'a, Polytope>,
    /// The vertices of the simplex, by number, and the first of them in world axes.
    known: [usize; 3],
    first: Triple<DoubleDouble>,
    /// 1 for a, whose least vertex counts; −1 for b.
    sense: f64,
}

/// The distance, by the simplex and the weights where the search has ended. `None` where the bounds do not close: it is not at the
/// nearest features, others are level with them, or the gap is below 1e-12 of the size.
pub(super) fn distance(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    near: &Approach,
) -> Option<Distance> {
    let vertices = near.simplex.vertices();
    let count = vertices.len();
    let reach = |body: PosedSupport<'_, Polytope>| body.reach * (1.0 + body.pose.deviation());
    let between = a.pose.translation() - b.pose.translation();
    let size = reach(a) + reach(b) + between.norm1();
    // False for NaN.
    if !(SIZES.contains(&size) && (1..=3).contains(&count)) {
        return None;
    }
    let pair = |k: usize| [vertices[k].a.feature as usize, vertices[k].b.feature as usize];
    let pairs = [0, 1, 2].map(|k| pair(if k < count { k } else { 0 }));
    let sides = [Side::of(a, pairs.map(|[k, _]| k), 1.0), Side::of(b, pairs.map(|[_, k]| k), -1.0)];
    let edges = Edges::of(&sides);
    let mut weights = whole_weights(&near.weights[..count])?;
    let mut point = moved(first_point(&sides), &edges, weights);
    let mut left = weights[0].min(weights[1]).min(1.0 - weights[0] - weights[1]);
    if count < 3 {
        left = if count == 1 { 1.0 } else { weights[0].min(1.0 - weights[0]) };
    }
    for _ in 0..CORRECTIONS {
        let parts = edges.of_sides.map(|of_edge| of_edge.map(|edge| along(&point, &edge)));
        let steps = square_to(edges.rounded, parts.map(|[of_a, of_b]| of_a - of_b), count - 1);
        // The corrected point is one of the simplex too. False for NaN.
        left -= 2.0 * (steps[0].abs() + steps[1].abs());
        if !(left > 0.0 || count == 1) {
            return None;
        }
        point = moved(point, &edges, steps);
        weights = [weights[0] + steps[0], weights[1] + steps[1]];
        let length = dot(&point, &point).sqrt();
        let lost = lost(&sides, &edges, &point, (parts, steps));
        let radii = two_sum(a.map.swept_radius(), b.map.swept_radius());
        let distance = length.minus(&radii).to_f64();
        let open = lost / length.to_f64() * (1.0 + 16.0 * UNIT) + PADDING * EPSILON * size;
        if distance * distance > SIZES.start && open <= CLOSED * (distance - open) {
            let normal = unit(-DVec3::from_array(point.map(|part| part.high)));
            let all = [1.0 - weights[0] - weights[1], weights[0], weights[1]];
            let [core_a, core_b] = weighted(a, b, &pairs[..count], &all);
            return Some(Distance {
                distance,
                point_a: core_a + normal * a.map.swept_radius(),
                point_b: core_b - normal * b.map.swept_radius(),
                normal,
                // The gap, and the rounding of the distance to f64.
                error_bound: rounded_up(distance * (CLOSED + f64::EPSILON)),
            });
        }
    }
    None
}

/// Those of the second and third vertex, so that with that of the first, none below 0, they make exactly 1.
fn whole_weights(weights: &[f64]) -> Option<[f64; 2]> {
    let total: f64 = weights.iter().sum();
    // A multiple of 2⁻⁵² up to 1: so is what the sum of two lacks to 1.
    let whole = |k: usize| weights.get(k).map_or(0.0, |weight| (weight / total + 1.0) - 1.0);
    let both = [whole(1), whole(2)];
    let are_weights = both.iter().all(|weight| (0.0..=1.0).contains(weight));
    (are_weights && both[0] + both[1] <= 1.0).then_some(both)
}

/// The difference of the two first vertices.
fn first_point(sides: &[Side<'_>; 2]) -> Triple<DoubleDouble> {
    let [a, b] = sides;
    let [from_a, from_b] = [a, b].map(|side| side.body.pose.translation().to_array());
    [0, 1, 2].map(|c| {
        let seen = a.first[c].minus(&b.first[c]);
        two_sum(from_a[c], -from_b[c]).plus(&seen)
    })
}

impl<'a> Side<'a> {
    fn of(body: PosedSupport<'a, Polytope>, known: [usize; 3], sense: f64) -> Self {
        let first = turned(body, known[0]);
        Self { body, known, first, sense }
    }

    /// A vertex as it is seen from the first.
    fn seen(&self, k: usize) -> Triple<DoubleDouble> {
        if k == self.known[0] {
            return [DoubleDouble::from(0.0); 3];
        }
        minus(&turned(self.body, k), &self.first)
    }

    /// How much farther than the first vertex one outside of the simplex reaches, at most; 0 where none does.
    fn others_beyond(&self, point: &Triple<DoubleDouble>) -> f64 {
        let direction = DVec3::from_array(point.map(|part| part.high)) * self.sense;
        let local = self.body.pose.rotation().transpose() * direction;
        let vertices = self.body.map.vertices();
        let level = local.dot(vertices[self.known[0]])
            + LEVEL * UNIT * direction.length() * self.body.reach;
        let mut most = 0.0f64;
        for (k, vertex) in vertices.iter().enumerate() {
            // Written so that NaN is looked at.
            if !(local.dot(*vertex) > level) && !self.known.contains(&k) {
                most = most.max(-self.sense * along(point, &self.seen(k)));
            }
        }
        most
    }
}

impl Edges {
    fn of(sides: &[Side<'_>; 2]) -> Self {
        let of_edge = |k: usize| [0, 1].map(|side: usize| sides[side].seen(sides[side].known[k]));
        let of_sides = [of_edge(1), of_edge(2)];
        let whole = [0, 1].map(|k: usize| minus(&of_sides[k][0], &of_sides[k][1]));
        let rounded = whole.map(|edge| DVec3::from_array(edge.map(|part| part.high)));
        Self { of_sides, whole, rounded }
    }
}

/// How much less than its square any vertex of the difference may have along a point: `along` is what the edges' parts had before
/// it was moved by `steps` of the edges.
fn lost(
    sides: &[Side<'_>; 2],
    edges: &Edges,
    point: &Triple<DoubleDouble>,
    (along, steps): ([[f64; 2]; 2], [f64; 2]),
) -> f64 {
    let [first, second] = edges.rounded;
    let way = first * steps[0] + second * steps[1];
    let far = first.length() * steps[0].abs() + second.length() * steps[1].abs();
    let mut lost = 0.0;
    let mut beyond = [0.0f64; 2];
    for (of_edge, along) in edges.of_sides.iter().zip(along) {
        let mut parts = [0.0; 2];
        for (side, part) in of_edge.iter().enumerate() {
            let part = DVec3::from_array(part.map(|x| x.high));
            let unsure = CORRECTED * UNIT * (along[side].abs() + far * part.length());
            parts[side] = along[side] + way.dot(part);
            beyond[side] = beyond[side].max(unsure - sides[side].sense * parts[side]);
            lost += unsure;
        }
        lost += (parts[0] - parts[1]).abs();
    }
    let others = [0, 1].map(|side: usize| sides[side].others_beyond(point).max(beyond[side]));
    lost + others[0] + others[1]
}

/// R·v of a vertex.
fn turned(body: PosedSupport<'_, Polytope>, k: usize) -> Triple<DoubleDouble> {
    let columns = body.pose.rotation().to_cols_array_2d();
    let vertex = body.map.vertices()[k].to_array();
    [0, 1, 2].map(|c| {
        let mut sum = Sum::default();
        for (column, x) in columns.iter().zip(vertex) {
            sum.add_product(column[c], x);
        }
        sum.total()
    })
}

/// A point moved by so much of each edge.
fn moved(point: Triple<DoubleDouble>, edges: &Edges, steps: [f64; 2]) -> Triple<DoubleDouble> {
    [0, 1, 2].map(|c| {
        let mut sum = Sum::from(point[c]);
        for (edge, step) in edges.whole.iter().zip(steps) {
            sum.add_long_product(&edge[c], &DoubleDouble::from(step));
        }
        sum.total()
    })
}

/// The product, rounded to f64.
fn along(a: &Triple<DoubleDouble>, b: &Triple<DoubleDouble>) -> f64 {
    dot(a, b).to_f64()
}

#[cfg(test)]
mod tests;
