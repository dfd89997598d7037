//! The nearest points of two features, of which one at least is curved: Newton's method from where a search has come.
//!
//! Round a disc's rim GJK gains about a digit with two supports; half the squared distance of two features is smooth, so that
//! here each step doubles the digits. What comes out is a proposal: the pair's own bounds prove it, as any two points.

use super::approach::{Approach, approach as search, approach_from, proposed_by_features};
use super::warm_start::warm_start;
use crate::certificate::Bounds;
use crate::closed::curved::{self, NearestPoints};
use crate::closed::feature_normal::{HARDLY_APART, Tangents};
use crate::gjk::Simplex;
use crate::{Difference, PosedShape, Verdict, Vertex, closed};
use dcd_geom::glam::{DMat3, DVec2, DVec3};
use dcd_geom::{Curved, Shape, Support};

/// How often the places are corrected at most; four are usual. Fewer: proposals that the bounds refuse, and the search goes on.
const STEPS: usize = 8;

/// The largest correction, relative to the features, that is the last: what it leaves is about its square, and the distance is
/// off by the square of that. Larger: points that are not quite the nearest. Smaller: a step for nothing.
const SETTLED: f64 = 1e-6;

/// The same where the bounds need not come as near as f64 brings them.
const ROUGHLY_SETTLED: f64 = 1e-3;

/// What is added to the second derivatives, relative to themselves, so that parallel features have a solution. Larger: more
/// steps. Smaller: places that rounding has moved along such features.
const DAMPING: f64 = 1e-9;

/// How far the bounds of a search may be apart at its end. Unit: the pair's size. Larger: worse bounds beside points that all but
/// meet. Smaller: steps of Newton's for nothing.
const OPEN: f64 = 1e-12;

/// Where in a disc a place no longer belongs to its rim, for all that the search knows. Unit: the radius. Larger: rims that are taken for discs and
/// searched on. Smaller: steps of Newton's in vain.
const INSIDE: f64 = 0.9;

/// How near the bounds have to come before the nearest features of curved shapes are taken for known. Unit: the pair's size.
/// Larger: more proposals that the bounds refuse. Smaller: supports that a step of Newton's would have spared.
const FEATURES_ARE_KNOWN: f64 = 3e-3;

/// [`search`] of shapes of which one is no polytope: by points that a formula proposes, or that the search leads to.
pub(super) fn approach(
    difference: &Difference<'_, f64, Shape, Shape>,
    bounds: &Bounds<f64>,
    (gap, sides): (f64, [PosedShape<'_>; 2]),
    near: &mut Approach,
) -> Result<(), Verdict<()>> {
    let [a, b] = sides;
    let proposals = Proposals { difference, bounds, gap, sides };
    // Products of lengths in metres stay clear of underflow.
    if !closed::SIZES.contains(&(difference.size() / difference.scale())) {
        return search(difference, bounds, gap, near);
    }
    if let Some(found) = curved::nearest_points(a, b).and_then(|found| proposals.of_points(found)) {
        *near = found;
        return Ok(());
    }
    if !has_features(a.shape, b.shape) {
        return search(difference, bounds, gap, near);
    }
    if near.simplex.vertices().is_empty() {
        warm_start(difference, &mut near.simplex);
    }
    let is_warm = !near.simplex.vertices().is_empty();
    if near.come_to_nearest()
        && let Some(found) = proposals.of_features(near)
    {
        *near = found;
        return Ok(());
    }
    proposals.search_on(near)?;
    // Points of f32 are beside the supports of f64, and among both the search may come no nearer. From afar it does.
    let width = |of: &Approach| of.upper - of.lower;
    if is_warm
        && width(near) > gap.max(OPEN)
        && let Ok(other) = approach_from(difference, bounds, [gap, f64::MAX], Simplex::default())
        && width(&other) < width(near)
    {
        *near = other;
    }
    Ok(())
}

/// What is proposed of a pair, and proved by its bounds.
struct Proposals<'a, 'b> {
    difference: &'a Difference<'b, f64, Shape, Shape>,
    bounds: &'a Bounds<f64>,
    /// How near these have to come.
    gap: f64,
    sides: [PosedShape<'b>; 2],
}

impl Proposals<'_, '_> {
    fn of_points(&self, found: NearestPoints<'_>) -> Option<Approach> {
        let tangents = || found.tangents();
        proposed_by_features(self.difference, self.bounds, self.gap, (found.points, tangents))
    }

    /// By Newton's method, from where a search has come.
    fn of_features(&self, near: &Approach) -> Option<Approach> {
        let Self { difference, bounds, gap, sides } = *self;
        let [in_a, in_b] = nearest_features(near, (gap, sides))?;
        let turned =
            |of: &Feature<'_>, side: PosedShape<'_>| of.tangents().turned(*side.pose.rotation());
        let tangents = || [turned(&in_a, sides[0]), turned(&in_b, sides[1])];
        let points = [in_a.point(), in_b.point()];
        proposed_by_features(difference, bounds, gap, (points, tangents))
    }

    /// Searches on in f64, until the features are known, and where that does not help to the end.
    fn search_on(&self, near: &mut Approach) -> Result<(), Verdict<()>> {
        let Self { difference, bounds, gap, sides } = *self;
        search(difference, bounds, gap.max(FEATURES_ARE_KNOWN), near)?;
        if near.upper - near.lower <= gap {
            return Ok(());
        }
        if let Some(found) = self.of_features(near) {
            *near = found;
            return Ok(());
        }
        let last = approach_from(difference, bounds, [gap, f64::MAX], near.simplex)?
            .or_earlier(near, bounds, gap);
        // Where the search has come after all, features may be known that were not before.
        let is_open = last.length < HARDLY_APART && last.upper - last.lower > gap.max(OPEN);
        let of_edge = || self.of_points(nearest_points_to_edge(&last, sides)?);
        let proposed = || self.of_features(&last).or_else(of_edge);
        *near = is_open.then(proposed).flatten().unwrap_or(last);
        Ok(())
    }
}

/// Whether two shapes have features that are known here, one of them a curved one.
fn has_features(a: &Shape, b: &Shape) -> bool {
    matches!(
        (a, b),
        (Shape::Curved(_), Shape::Curved(_) | Shape::Polytope(_))
            | (Shape::Polytope(_), Shape::Curved(_))
    )
}

/// A feature of each shape and the place on it that are perhaps the nearest; `None` where the steps lead nowhere.
fn nearest_features<'a>(
    near: &Approach,
    (gap, [a, b]): (f64, [PosedShape<'a>; 2]),
) -> Option<[Feature<'a>; 2]> {
    let settled = if gap > 0.0 { ROUGHLY_SETTLED } else { SETTLED };
    let between = Between::of(a, b);
    let mut in_a = Feature::of(a.shape, near, |vertex| vertex.a)?;
    let mut in_b = Feature::of(b.shape, near, |vertex| vertex.b)?;
    for _ in 0..STEPS {
        let correction = between.correction(&in_a, &in_b)?;
        let moved = in_a
            .moved([correction[0], correction[1]])?
            .max(in_b.moved([correction[2], correction[3]])?);
        if moved <= settled {
            break;
        }
    }
    Some([in_a, in_b])
}

/// A point of a curved shape and one of the edge or corner of a polytope where the search has come, perhaps the nearest.
fn nearest_points_to_edge<'a>(
    near: &Approach,
    [a, b]: [PosedShape<'a>; 2],
) -> Option<NearestPoints<'a>> {
    let is_second = matches!(b.shape, Shape::Polytope(_));
    let flat = match is_second {
        true => Feature::of(b.shape, near, |vertex| vertex.b)?,
        false => Feature::of(a.shape, near, |vertex| vertex.a)?,
    };
    curved::nearest_points_to_edge(a, b, flat.edge()?)
}

/// The second shape's place in the frame of the first.
struct Between {
    turn: DMat3,
    delta: DVec3,
}

impl Between {
    fn of(a: PosedShape<'_>, b: PosedShape<'_>) -> Self {
        let back = a.pose.rotation().transpose();
        let delta = b.pose.translation() - a.pose.translation();
        Self { turn: back * *b.pose.rotation(), delta: back * delta }
    }

    /// Newton's step for half the squared distance of two features: two places of the first, two of the second. `None` where
    /// it curves the wrong way.
    fn correction(&self, a: &Feature<'_>, b: &Feature<'_>) -> Option<[f64; 4]> {
        let (in_a, in_b) = (a.derivatives(), b.derivatives());
        let w = in_a.point - (self.turn * in_b.point + self.delta);
        let [t0, t1] = in_a.tangents;
        let [t2, t3] = in_b.tangents.map(|tangent| -(self.turn * tangent));
        let seen = self.turn.transpose() * w;
        let mut second = [
            [t0.dot(t0) + in_a.bend.dot(w), t0.dot(t1), t0.dot(t2), t0.dot(t3)],
            [0.0, t1.dot(t1), t1.dot(t2), t1.dot(t3)],
            [0.0, 0.0, t2.dot(t2) - in_b.bend.dot(seen), t2.dot(t3)],
            [0.0, 0.0, 0.0, t3.dot(t3)],
        ];
        for (k, row) in second.iter_mut().enumerate() {
            // A place that is not free has no tangent, and stays.
            row[k] = if row[k] == 0.0 { 1.0 } else { row[k] * (1.0 + DAMPING) };
        }
        solved(second, [t0, t1, t2, t3].map(|tangent| -tangent.dot(w)))
    }
}

/// The solution of symmetric equations, given by their upper half; `None` unless they are positive definite.
fn solved(mut rows: [[f64; 4]; 4], mut right: [f64; 4]) -> Option<[f64; 4]> {
    let mut inverse = [0.0; 4];
    for k in 0..4 {
        let pivot = rows[k];
        // False for NaN.
        if !(pivot[k] > 0.0) {
            return None;
        }
        inverse[k] = 1.0 / pivot[k];
        for j in k + 1..4 {
            let part = pivot[j] * inverse[k];
            // Whole rows: below the diagonal nothing is read.
            rows[j] = [0, 1, 2, 3].map(|i| rows[j][i] - part * pivot[i]);
            right[j] -= part * right[k];
        }
    }
    for k in (0..4).rev() {
        right[k] *= inverse[k];
        for j in 0..k {
            right[j] -= rows[j][k] * right[k];
        }
    }
    Some(right)
}

/// What of a shape is near the other, and a place on it.
enum Feature<'a> {
    /// A corner, an edge or a face of `count` corners, those after them meaningless, and the weights of the second and third.
    Flat { corners: [DVec3; 3], weights: [f64; 2], count: usize },
    /// A rim or the side of a curved shape: the direction from its axis, of unit length, and how far up.
    Round { curved: &'a Curved, outward: DVec2, up: f64, is_rim: bool },
}

/// A place on a feature and its derivatives; tangents are 0 where it is not free.
struct Derivatives {
    point: DVec3,
    tangents: [DVec3; 2],
    /// The second derivative by the first tangent's place. The mixed one is along that tangent, which the distance is
    /// square to in the end: left out.
    bend: DVec3,
}

impl<'a> Feature<'a> {
    /// Where the search has come on a shape. Of a disc's inside nothing is known here: there the
    /// search has its normal, and ends.
    fn of(
        shape: &'a Shape,
        near: &Approach,
        of: impl Fn(&Vertex<f64>) -> Support<f64>,
    ) -> Option<Self> {
        let vertices = near.simplex.vertices();
        let total: f64 = near.weights[..vertices.len()].iter().sum();
        let weighted = vertices.iter().zip(near.weights).map(|(v, weight)| (of(v), weight / total));
        match shape {
            Shape::Curved(curved) => Self::of_curved(curved, weighted),
            Shape::Polytope(_) => {
                let mut known = [(0, DVec3::ZERO, 0.0); 4];
                let mut count = 0;
                for (support, weight) in weighted {
                    let same = known[..count].iter().position(|&(k, ..)| k == support.feature);
                    match same {
                        Some(slot) => known[slot].2 += weight,
                        None => {
                            known[count] = (support.feature, support.point, weight);
                            count += 1;
                        }
                    }
                }
                let corners = [known[0].1, known[1].1, known[2].1];
                let weights = [known[1].2, known[2].2];
                (count <= 3).then_some(Self::Flat { corners, weights, count })
            }
            _ => None,
        }
    }

    /// `None` inside of a disc.
    fn of_curved(
        curved: &'a Curved,
        weighted: impl Iterator<Item = (Support<f64>, f64)>,
    ) -> Option<Self> {
        let [(low, _), (high, _)] = curved.discs();
        let (mut mean, mut lowest, mut highest) = (DVec3::ZERO, f64::INFINITY, f64::NEG_INFINITY);
        for (Support { point, .. }, weight) in weighted {
            mean += point * weight;
            (lowest, highest) = (lowest.min(point.z), highest.max(point.z));
        }
        let is_rim = lowest == highest;
        let up = ((mean.z - low) / (high - low)).clamp(0.0, 1.0);
        let flat = mean.truncate();
        let radius = curved.discs()[usize::from(up > 0.5)].1;
        if is_rim && radius == 0.0 {
            return Some(Self::Flat { corners: [mean; 3], weights: [0.0; 2], count: 1 });
        }
        let is_inside = is_rim && flat.length_squared() < INSIDE * INSIDE * radius * radius;
        let round = Self::Round { curved, outward: flat.normalize_or(DVec2::X), up, is_rim };
        (!is_inside).then_some(round)
    }

    fn point(&self) -> DVec3 {
        self.derivatives().point
    }

    /// The ends of the edge of a polytope that the place is on or nearest to; of a corner twice the same.
    fn edge(&self) -> Option<[DVec3; 2]> {
        let Self::Flat { corners: [p, q, r], weights: [second, third], count } = *self else {
            return None;
        };
        let first = 1.0 - second - third;
        Some(match count {
            1 => [p, p],
            2 => [p, q],
            _ if first <= second.min(third) => [q, r],
            _ if second <= third => [p, r],
            _ => [p, q],
        })
    }

    fn tangents(&self) -> Tangents {
        let [first, second] = self.derivatives().tangents;
        match self {
            Self::Flat { .. } => Tangents { straight: [first, second], round: DVec3::ZERO },
            Self::Round { .. } => Tangents { straight: [second, DVec3::ZERO], round: first },
        }
    }

    fn derivatives(&self) -> Derivatives {
        match *self {
            Self::Flat { corners, weights: [x, y], count } => {
                let [p, q, r] = corners;
                let tangents = match count {
                    1 => [DVec3::ZERO; 2],
                    2 => [q - p, DVec3::ZERO],
                    _ => [q - p, r - p],
                };
                let point = match count {
                    1 => p,
                    2 => p * (1.0 - x) + q * x,
                    _ => p * (1.0 - x - y) + q * x + r * y,
                };
                Derivatives { point, tangents, bend: DVec3::ZERO }
            }
            Self::Round { curved, outward, up, is_rim } => {
                let [(low, low_radius), (high, high_radius)] = curved.discs();
                let at = |a: f64, b: f64| a * (1.0 - up) + b * up;
                let rim = outward * at(low_radius, high_radius);
                let along = if is_rim {
                    DVec3::ZERO
                } else {
                    (outward * (high_radius - low_radius)).extend(high - low)
                };
                Derivatives {
                    point: rim.extend(at(low, high)),
                    tangents: [rim.perp().extend(0.0), along],
                    bend: (-rim).extend(0.0),
                }
            }
        }
    }

    /// Moves the place, and returns how far, relative to the feature; `None` where that leaves it.
    fn moved(&mut self, [first, second]: [f64; 2]) -> Option<f64> {
        match self {
            Self::Flat { weights, .. } => {
                *weights = [weights[0] + first, weights[1] + second];
                let is_inside =
                    weights[0] >= 0.0 && weights[1] >= 0.0 && weights[0] + weights[1] <= 1.0;
                is_inside.then_some(first.abs().max(second.abs()))
            }
            Self::Round { outward, up, .. } => {
                // By the tangent in place of the angle: the same but for its cube.
                *outward = (*outward + outward.perp() * first).normalize();
                *up += second;
                (0.0..=1.0).contains(up).then_some(first.abs().max(second.abs()))
            }
        }
    }
}

#[cfg(test)]
mod tests;
