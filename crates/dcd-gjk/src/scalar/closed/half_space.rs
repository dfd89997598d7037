//! Half-spaces against everything.
//!
//! A half-space n·x ≤ o at a pose is the set of all R·x + t, so with N = cof(R)·n it is
//! N·(y − t) ≤ o·det R: exact in terms of R, whatever R departs from a rotation by. A shape is
//! touched where its lowest point along N is. f64 decides with a bound; polytopes, cylinders,
//! cones and ellipsoids that are within it are judged exactly (docs/numerics/proofs.md, "half-spaces").

mod long_gap;

use super::binary::Binary;
use crate::UNIT;
use crate::epa::Depth;
use crate::exact::nearest_point::scaled;
use crate::simplex::{Scalar, Triple, cross, dot, minus, plus};
use crate::{Distance, DistanceResult, Method, PosedShape, Reason, Verdict};
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{HalfSpace, Pose, Shape, SupportMap, Vector};

/// How far a computed gap may be off. Unit: u·(|n|₁·(κ·reach + |δt|₁ + radii) + |o|). N loses 5u a
/// component, √3 of that in length, its rotation and its products 6u·√3: 19u, and 2u for the sums;
/// the offset 8u, the swept radii 13u. Smaller: wrong answers. Larger: more pairs judged exactly.
const GAP: f64 = 32.0;

/// Sizes below which underflow could show: their pairs are judged exactly.
const SMALLEST: f64 = 1e-280;

/// A half-space at a pose.
#[derive(Clone, Copy)]
struct Plane<'a> {
    half_space: &'a HalfSpace,
    pose: &'a Pose,
}

impl<'a> Plane<'a> {
    fn of(placed: PosedShape<'a>) -> Option<Self> {
        match placed.shape {
            Shape::HalfSpace(half_space) => Some(Self { half_space, pose: placed.pose }),
            _ => None,
        }
    }

    /// N and o·det R, rounded.
    fn rounded(self) -> (DVec3, f64) {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *self.pose.rotation();
        let n = self.half_space.normal();
        let cofactors = [y.cross(z), z.cross(x), x.cross(y)];
        let normal = cofactors[0] * n.x + cofactors[1] * n.y + cofactors[2] * n.z;
        (normal, self.half_space.offset() * x.dot(cofactors[0]))
    }

    /// The same in longer numbers.
    fn in_numbers<N: Scalar + From<f64>>(self) -> (Triple<N>, N) {
        let DMat3 { x_axis, y_axis, z_axis } = *self.pose.rotation();
        let [x, y, z] = [x_axis, y_axis, z_axis].map(numbers::<N>);
        let n = numbers::<N>(self.half_space.normal());
        let cofactors = [cross(&y, &z), cross(&z, &x), cross(&x, &y)];
        let along = |k: usize| cofactors[k].each_ref().map(|c| c.times(&n[k]));
        let normal = plus(&plus(&along(0), &along(1)), &along(2));
        (normal, dot(&x, &cofactors[0]).times(&self.half_space.offset().into()))
    }
}

fn numbers<N: From<f64>>(v: DVec3) -> Triple<N> {
    v.to_array().map(N::from)
}

fn binary(v: DVec3) -> Triple<Binary> {
    numbers(v)
}

/// How far the lowest point of a shape is above a plane, times |N|; what f64 knows of it.
struct Gap {
    value: f64,
    /// What `value` may be off by; NaN or infinite where nothing is known.
    error: f64,
    /// |N|.
    length: f64,
    normal: DVec3,
    /// The shape's lowest point, in its own frame, without its radius.
    lowest: DVec3,
}

impl Gap {
    fn of(plane: Plane<'_>, other: PosedShape<'_>) -> Self {
        let (normal, offset) = plane.rounded();
        let delta = other.pose.translation() - plane.pose.translation();
        let d = other.pose.rotation().transpose() * normal;
        let lowest = other.shape.support(-d).point;
        let radius = plane.half_space.swept_radius() + other.shape.radius();
        let length = normal.length();
        let value = (d.dot(lowest) + normal.dot(delta)) - offset - radius * length;
        let n = plane.half_space.normal().norm1();
        let reach = other.shape.reach() * (1.0 + other.pose.deviation());
        let size = n * (reach + delta.norm1() + radius) + plane.half_space.offset().abs();
        let support_error = 2.0 * other.shape.support_error() * d.norm1();
        // False for NaN.
        let in_range = n >= SMALLEST && size >= SMALLEST;
        let error = if in_range { GAP * UNIT * size + support_error } else { f64::INFINITY };
        Self { value, error, length, normal, lowest }
    }

    /// `None` where f64 cannot decide.
    fn touches(&self) -> Option<bool> {
        if self.value > self.error {
            Some(false)
        } else if self.value < -self.error {
            Some(true)
        } else {
            None
        }
    }
}

/// The exact gap of a shape whose core is the hull of points and discs, or an ellipsoid: A − ρ·√p − r·√q is its sign.
struct ExactGap {
    /// N·(lowest − t) − o·det R.
    above: Binary,
    /// ρ²p: what a disc or an ellipsoid reaches below its middle, times |N|, squared.
    disc: Binary,
    /// r²q, r the sum of the swept radii, q = |N|².
    swept: Binary,
    normal_squared: Binary,
}

impl ExactGap {
    /// The lowest of all; `None` for a shape that only its support map knows.
    fn of(plane: Plane<'_>, other: PosedShape<'_>) -> Option<Self> {
        let (normal, offset) = plane.in_numbers::<Binary>();
        let axes = other.pose.rotation();
        let d = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| dot(&normal, &binary(axis)));
        let delta = minus(&binary(other.pose.translation()), &binary(plane.pose.translation()));
        let base = dot(&normal, &delta).minus(&offset);
        let across = d[0].squared().plus(&d[1].squared());
        let normal_squared = dot(&normal, &normal);
        let radius =
            Binary::new(plane.half_space.swept_radius()).plus(&other.shape.radius().into());
        let swept = radius.squared().times(&normal_squared);
        let gap = |above: Binary, disc: Binary| Self {
            above: above.plus(&base),
            disc,
            swept: swept.clone(),
            normal_squared: normal_squared.clone(),
        };
        match other.shape {
            Shape::Polytope(polytope) => {
                let along = polytope.vertices().iter().map(|&v| dot(&d, &binary(v)));
                let lowest = along.reduce(|a, b| if b.minus(&a).is_negative() { b } else { a })?;
                Some(gap(lowest, Binary::zero()))
            }
            Shape::Curved(curved) => {
                let [low, high] = curved.discs().map(|(z, radius)| {
                    let disc = Binary::new(radius).squared().times(&across);
                    gap(d[2].times(&z.into()), disc)
                });
                // Either may be the lowest: touching if one does.
                Some(if low.touches() { low } else { high })
            }
            Shape::Ellipsoid(ellipsoid) => {
                // The lowest point is √(Σ (aᵢdᵢ)²) below the middle: a disc's radius in its place.
                let halves = binary(ellipsoid.half_axes());
                let squares = [0, 1, 2].map(|k| halves[k].times(&d[k]).squared());
                let below = squares[0].plus(&squares[1]).plus(&squares[2]);
                Some(gap(Binary::zero(), below))
            }
            _ => None,
        }
    }

    /// A ≤ √disc + √swept, by squaring twice.
    fn touches(&self) -> bool {
        if !self.above.is_positive() {
            return true;
        }
        let rest = self.above.squared().minus(&self.disc).minus(&self.swept);
        if !rest.is_positive() {
            return true;
        }
        let four = Binary::new(4.0);
        let product = self.disc.times(&self.swept).times(&four);
        !rest.squared().minus(&product).is_positive()
    }

    /// (A − r√q)/√q of a polytope, rounded a dozen times; negative where the shapes overlap, and
    /// for A > 0 as (A² − r²q)/(√q·(A + r√q)), which does not cancel.
    fn distance(&self) -> f64 {
        let root = |x: &Binary| {
            let (m, e) = x.to_float();
            let odd = e.rem_euclid(2);
            ((m * f64::from(1 + odd as i32)).sqrt(), (e - odd) / 2)
        };
        let (length, length_exponent) = root(&self.normal_squared);
        let (above, exponent) = self.above.to_float();
        let (swept, swept_exponent) = root(&self.swept);
        if !self.above.is_positive() {
            return scaled(above / length, exponent - length_exponent)
                - scaled(swept / length, swept_exponent - length_exponent);
        }
        let (top, top_exponent) = self.above.squared().minus(&self.swept).to_float();
        let sum = above + scaled(swept, swept_exponent - exponent);
        scaled(top / sum / length, top_exponent - exponent - length_exponent)
    }
}

/// Whether two shapes touch of which at least one is a half-space; `None` where none is.
///
/// Exact for polytopes, cylinders, cones, ellipsoids and half-spaces, rounded or not; a foreign shape stays
/// undecided within the rounding of f64 and its support error.
pub fn overlap(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<(Verdict<()>, Method)> {
    let (touches, method) = match (Plane::of(a), Plane::of(b)) {
        (None, None) => return None,
        (Some(a), Some(b)) => planes_touch(a, b),
        (Some(plane), None) => touches(plane, b),
        (None, Some(plane)) => touches(plane, a),
    };
    let verdict = match touches {
        Some(true) => Verdict::Touching(()),
        Some(false) => Verdict::Apart,
        None => Verdict::Undecided(Reason::WithinRounding),
    };
    Some((verdict, method))
}

/// What f64 alone can prove; two half-spaces are judged exactly all the same.
pub(crate) fn overlap_in_f64(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<Verdict<()>> {
    let Some((plane, other, _)) = one_plane(a, b) else {
        return overlap(a, b).map(|(verdict, _)| verdict);
    };
    Some(match Gap::of(plane, other).touches() {
        Some(true) => Verdict::Touching(()),
        Some(false) => Verdict::Apart,
        None => Verdict::Undecided(Reason::WithinRounding),
    })
}

fn touches(plane: Plane<'_>, other: PosedShape<'_>) -> (Option<bool>, Method) {
    match Gap::of(plane, other).touches() {
        Some(touches) => (Some(touches), Method::F64),
        None => match ExactGap::of(plane, other) {
            Some(gap) => (Some(gap.touches()), Method::Exact),
            None => (None, Method::F64),
        },
    }
}

/// Two half-spaces share a point unless their normals are exactly opposite.
fn planes_touch(a: Plane<'_>, b: Plane<'_>) -> (Option<bool>, Method) {
    let ((in_a, _), (in_b, _)) = (a.rounded(), b.rounded());
    let [largest_a, largest_b] = [in_a, in_b].map(|n| n.abs().max_element());
    let (in_a, in_b) = (in_a / largest_a, in_b / largest_b);
    // Components of at most 1 that are off by less than 16u each. False for NaN.
    let tolerance = 128.0 * UNIT;
    if in_a.dot(in_b) > tolerance || in_a.cross(in_b).abs().max_element() > tolerance {
        let normal = |largest: f64| (SMALLEST..1.0 / SMALLEST).contains(&largest);
        if normal(largest_a) && normal(largest_b) {
            return (Some(true), Method::F64);
        }
    }
    (Some(exact_planes_touch(a, b)), Method::Exact)
}

/// With N_A·y ≤ c_A and N_B·y ≤ c_B opposite, they are apart by −c_B/|N_B| − c_A/|N_A|.
fn exact_planes_touch(a: Plane<'_>, b: Plane<'_>) -> bool {
    let (in_a, offset_a) = a.in_numbers::<Binary>();
    let (in_b, offset_b) = b.in_numbers::<Binary>();
    let parallel = cross(&in_a, &in_b).iter().all(Binary::is_zero);
    let product = dot(&in_a, &in_b);
    if !parallel || product.is_positive() {
        return true;
    }
    let delta = minus(&binary(b.pose.translation()), &binary(a.pose.translation()));
    // N_A·y ≤ o_A and N_B·(y − δ) ≤ o_B, both times what makes the normals equal and opposite:
    // x = N_A·(y): x ≤ o_A, and x ≥ N_A·δ + o_B·(N_A·N_B)/|N_B|².
    let squared_b = dot(&in_b, &in_b);
    let gap = dot(&in_a, &delta).minus(&offset_a).times(&squared_b).plus(&offset_b.times(&product));
    let radius = Binary::new(a.half_space.swept_radius()).plus(&b.half_space.swept_radius().into());
    let swept = radius.squared().times(&dot(&in_a, &in_a)).times(&squared_b.squared());
    !gap.is_positive() || !gap.squared().minus(&swept).is_positive()
}

/// The distance of two shapes of which one is a half-space and the other none; `None` else.
///
/// For polytopes as good as between two of them: within some ulps of itself. For others within 32u
/// of the pair's size and the support error.
pub fn distance(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<(DistanceResult, Method)> {
    distance_within(a, b, super::SHARP)
}

/// The same with a bound of at most `sharp` times the distance where the other is a polytope.
pub(crate) fn distance_within(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    sharp: f64,
) -> Option<(DistanceResult, Method)> {
    let (plane, other, side) = one_plane(a, b)?;
    let gap = Gap::of(plane, other);
    let (touches, method) = touches(plane, other);
    Some(match touches {
        None => {
            let Signed { value, error_bound, .. } = signed(&gap, plane, other, sharp);
            let (normal, [point_a, point_b]) = witnesses(&gap, other, value, side);
            let bound = |value: f64| (error_bound + value).next_up().clamp(0.0, f64::MAX);
            let depth = bound(-value);
            let error_bound = bound(value);
            let within = Distance { distance: 0.0, point_a, point_b, normal, error_bound };
            let reason = Reason::WithinRounding;
            (DistanceResult::Interval { reason, within, depth }, method)
        }
        Some(true) => (DistanceResult::Touching, method),
        Some(false) => {
            let mut known = signed(&gap, plane, other, sharp);
            // What is proved apart and no more is as far as longer numbers have it.
            if !(known.value > 0.0) {
                known = signed(&gap, plane, other, super::SHARP);
            }
            let Signed { value, error_bound, method } = known;
            let (normal, [point_a, point_b]) = witnesses(&gap, other, value, side);
            let distance = value.max(0.0);
            let found = Distance { distance, point_a, point_b, normal, error_bound };
            (DistanceResult::Apart(found), method)
        }
    })
}

/// How deep two shapes overlap of which one is a half-space and the other none; `None` else. The
/// shortest way out is along the plane's normal.
pub fn depth(a: PosedShape<'_>, b: PosedShape<'_>) -> Option<Verdict<Depth>> {
    depth_within(a, b, super::SHARP)
}

/// The same with a bound of at most `sharp` times the depth where the other is a polytope.
pub(crate) fn depth_within(
    a: PosedShape<'_>,
    b: PosedShape<'_>,
    sharp: f64,
) -> Option<Verdict<Depth>> {
    let (plane, other, side) = one_plane(a, b)?;
    let gap = Gap::of(plane, other);
    Some(match touches(plane, other).0 {
        None => Verdict::Undecided(Reason::WithinRounding),
        Some(false) => Verdict::Apart,
        Some(true) => {
            let Signed { value, error_bound, .. } = signed(&gap, plane, other, sharp);
            let (normal, [point_a, point_b]) = witnesses(&gap, other, value, side);
            let depth = (-value).max(0.0);
            Verdict::Touching(Depth { depth, normal, point_a, point_b, error_bound })
        }
    })
}

/// Which of the two is the half-space.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    A,
    B,
}

fn one_plane<'a>(
    a: PosedShape<'a>,
    b: PosedShape<'a>,
) -> Option<(Plane<'a>, PosedShape<'a>, Side)> {
    match (Plane::of(a), Plane::of(b)) {
        (Some(plane), None) => Some((plane, b, Side::A)),
        (None, Some(plane)) => Some((plane, a, Side::B)),
        _ => None,
    }
}

/// A gap in metres, negative for an overlap.
struct Signed {
    value: f64,
    error_bound: f64,
    method: Method,
}

/// A polytope's gap is taken in double-double where f64's may be off by more than `sharp` times itself, and exactly where that is
/// not as good. The largest number, with as large a bound, where it leaves the range of f64.
fn signed(gap: &Gap, plane: Plane<'_>, other: PosedShape<'_>, sharp: f64) -> Signed {
    let mut value = gap.value / gap.length;
    let mut error = gap.error / gap.length * (1.0 + 16.0 * UNIT) + 8.0 * UNIT * value.abs();
    let mut method = Method::F64;
    if !(error <= sharp * value.abs())
        && let Shape::Polytope(polytope) = other.shape
        && let Some(found) = long_gap::of(gap, plane, (polytope, other.pose))
            .or_else(|| ExactGap::of(plane, other).map(|gap| gap.distance()))
    {
        value = found;
        error = value.abs() * (16.0 * UNIT) + f64::from_bits(4);
        method = Method::Exact;
    }
    let error_bound = if value.is_finite() { error.min(f64::MAX) } else { f64::MAX };
    Signed { value: value.clamp(-f64::MAX, f64::MAX), error_bound, method }
}

/// The normal from a to b, and the points of a and b, world frame: the lowest point of the shape,
/// and the plane's next to it.
fn witnesses(gap: &Gap, other: PosedShape<'_>, value: f64, side: Side) -> (DVec3, [DVec3; 2]) {
    let outward = gap.normal / gap.length;
    let on_shape = other.pose.apply(gap.lowest) - outward * other.shape.radius();
    let on_plane = on_shape - outward * value;
    let (normal, points) = match side {
        Side::A => (outward, [on_plane, on_shape]),
        Side::B => (-outward, [on_shape, on_plane]),
    };
    (normal, points.map(|point| point.clamp(DVec3::MIN, DVec3::MAX)))
}
