//! Every tolerance of the scalar solvers, and the checks that use them. All are rounding bounds,
//! derived in docs/numerics/proofs.md; none is a matter of taste.
//!
//! Lengths here are those of a [`Difference`]: scaled so that the pair's size m is in [½, 1).

use crate::gjk::Simplex;
use crate::simplex::{Triple, cross, determinant, dot, minus, norm1};
use crate::{Difference, Vertex};
use dcd_geom::{Real, SupportMap, Vector};

/// The rounding bounds of one arithmetic, as multiples of its unit roundoff u.
#[derive(Clone, Copy, Debug)]
struct Constants {
    /// How far a computed separation d·w may be above the true one. Unit: u·m·|d|₁.
    /// Rᵀd loses 3, ·a 3, the first of the two sums 1; f32 rounds R and a first, 2 more. Tight:
    /// false separations were found at 5.99 (f64) and 7.98 (f32). Smaller: false apart. Larger:
    /// more undecided pairs. (docs/numerics/proofs.md, "separation")
    apart: f64,
    /// How far a component of a computed vertex w may be off. Unit: u·m. R·a loses 3, two sums 2;
    /// f32 rounds R and a first, 2 more. (docs/numerics/proofs.md, "vertices")
    vertex: f64,
    /// How much longer Σλw/Σλ may truly be than computed. Unit: u·m. √3 of `vertex` and 4 for the
    /// sum, rounded up with a margin. (docs/numerics/proofs.md, "distance")
    upper: f64,
    /// How much shorter than s/|d| the distance may truly be. Unit: u·m. √3 of `apart`, since
    /// |d|₁ ≤ √3·|d|. (docs/numerics/proofs.md, "distance")
    lower: f64,
}

const F64: Constants = Constants { apart: 7.01, vertex: 5.01, upper: 16.0, lower: 12.5 };

const F32: Constants = Constants { apart: 9.01, vertex: 7.01, upper: 20.0, lower: 16.0 };

/// How much a convex combination of vertices with dyadic weights loses beside its vertices' own
/// errors. Unit: u·m. Four products and three sums a component: at most 4, and a margin.
const COMBINED: f64 = 4.5;

/// |Rᵀd|₁ ≤ √3·|Rᵀd| ≤ √3·σ·|d| with σ ≤ 1 + 1e-6 the largest singular value of R: turns a
/// support error, which is stated per |d|₁ in the shape's frame, into one per |d|. No unit.
const SUPPORT_ERROR: f64 = 1.7321;

/// What a length |d| loses in its three squares, two sums and root, and the swept radii in their
/// sum and product with it: 6u, and a margin. Unit: u, relative.
const LENGTH: f64 = 8.0;

/// What a determinant x·(y × z) of three points loses: 5u of its permanent, and 1 for the
/// permanent's own evaluation. Unit: u·Σ|x_i|(|y_j z_k| + |y_k z_j|).
const DETERMINANT: f64 = 6.0;

/// What the normal of a face loses in two differences and a cross product: 4u of |e₁|₁·|e₂|₁,
/// doubled. Unit: u·|e₁|₁·|e₂|₁.
const NORMAL: f64 = 8.0;

/// How near to the origin, relative to m, a point of A − B must be for the simplex to count as
/// through the origin, where GJK's directions are rounding alone. Unit: u·m. Decides which of two
/// ways a pair is resolved, never an answer. Smaller: idle iterations. Larger: shallow gaps go the
/// longer way.
const THROUGH: f64 = 64.0;

/// The bounds of one pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds<R> {
    apart: R,
    apart_per_length: R,
    vertex: R,
    combined: R,
    upper: R,
    lower: R,
    radius: R,
    through: R,
}

impl<R: Real> Bounds<R> {
    pub(crate) fn of<A, B>(difference: &Difference<'_, R, A, B>) -> Self
    where
        A: SupportMap<R> + ?Sized,
        B: SupportMap<R> + ?Sized,
    {
        let constants = if R::UNIT_ROUNDOFF.to_f64() < F64_AND_F32 { F64 } else { F32 };
        let unit = R::UNIT_ROUNDOFF * difference.size();
        let times = |k: f64| R::from_f64(k) * unit;
        let support_error = R::from_f64(SUPPORT_ERROR) * difference.support_error();
        let radius = difference.radius();
        let vertex = times(constants.vertex) + support_error;
        Self {
            apart: times(constants.apart),
            apart_per_length: radius * (R::ONE + R::from_f64(LENGTH) * R::UNIT_ROUNDOFF)
                + support_error,
            vertex,
            combined: vertex + times(COMBINED),
            upper: times(constants.upper) + support_error + support_error,
            lower: times(constants.lower) + support_error,
            radius,
            through: times(THROUGH) + support_error,
        }
    }

    /// Whether a computed separation s along d, |d|∞ in [½, 1], proves the shapes apart.
    /// False for NaN.
    #[inline]
    pub(crate) fn proves_apart(&self, d: R::Vec3, s: R) -> bool {
        // The length is a root: computed only where the cores alone are apart.
        let cores = self.apart * d.norm1();
        s > cores && s > cores + self.apart_per_length * d.length()
    }

    /// Whether the cores' difference ends so near to the origin, or before it, that no simplex in
    /// it can be certified to hold it.
    pub(crate) fn is_shallow(&self, d: R::Vec3, s: R) -> bool {
        s > -(self.vertex * d.norm1())
    }

    /// Whether a point of the cores' difference whose computed distance from the origin is
    /// `distance` proves that the swept shapes touch. False for NaN.
    pub(crate) fn proves_swept_touching(&self, distance: R) -> bool {
        let below = R::ONE - R::from_f64(LENGTH) * R::UNIT_ROUNDOFF;
        self.radius > R::ZERO && self.upper_bound(distance) <= self.radius * below
    }

    /// At least the true length of Σλw/Σλ, from its computed length.
    pub(crate) fn upper_bound(&self, length: R) -> R {
        length * (R::ONE + R::from_f64(LENGTH) * R::UNIT_ROUNDOFF) + self.upper
    }

    /// At most the radius of a sphere round the origin that is inside the difference, from that of one
    /// inside a surface of computed vertices: moved to the true ones, no point of the surface comes
    /// nearer by more than a vertex is off.
    pub(crate) fn least_reach(&self, inner: R) -> R {
        (inner - self.upper).max(R::ZERO)
    }

    /// At most the cores' distance, from a computed separation s along d; may be negative.
    pub(crate) fn lower_bound(&self, d: R::Vec3, s: R) -> R {
        self.lower_bound_along(s / d.length())
    }

    /// The same from s / |d| as computed.
    #[inline]
    pub(crate) fn lower_bound_along(&self, along: R) -> R {
        along - along.abs() * (R::from_f64(LENGTH) * R::UNIT_ROUNDOFF) - self.lower
    }

    /// Whether the hull of four points, each a computed vertex or a convex combination of four,
    /// surely holds the origin.
    pub(crate) fn four_combined_points_touch(&self, points: &[Triple<R>; 4]) -> bool {
        four_points_hold_origin(points, self.combined)
    }

    /// Whether the origin is so near to the simplex that its direction is rounding alone.
    pub(crate) fn passes_through(&self, squared_distance: R) -> bool {
        !(squared_distance > self.through * self.through)
    }

    /// Whether the hull of a simplex of four vertices surely holds the origin.
    pub(crate) fn simplex_touches(&self, simplex: &Simplex<R>) -> bool {
        simplex.vertices().len() == 4 && four_points_hold_origin(&simplex.points(), self.vertex)
    }

    /// At least the sum of the swept radii.
    pub(crate) fn swept_upper(&self) -> R {
        self.radius * (R::ONE + R::from_f64(LENGTH) * R::UNIT_ROUNDOFF)
    }

    /// The sum of the swept radii.
    pub(crate) fn radius(&self) -> R {
        self.radius
    }
}

/// A number between the two unit roundoffs, to distinguish the arithmetics.
const F64_AND_F32: f64 = 1e-10;

/// Whether the hull of four points p_k holds the origin for every p_k within `error` of the given
/// one in each component: each face sees the whole cube round the origin on its inner side.
/// False for NaN.
pub(crate) fn four_points_hold_origin<R: Real>(points: &[Triple<R>; 4], error: R) -> bool {
    let [p0, p1, p2, p3] = points;
    let faces = [[p1, p2, p3], [p0, p3, p2], [p0, p1, p3], [p0, p2, p1]];
    let volumes = faces.map(|[x, y, z]| determinant(x, y, z));
    let mirrored = !(volumes[0] > R::ZERO);
    faces.iter().zip(volumes).all(|(&[x, y, z], volume)| {
        let volume = if mirrored { -volume } else { volume };
        volume > face_error(x, y, z, error)
    })
}

/// How far det(x, y, z) may be from the determinant seen from any point of the cube.
fn face_error<R: Real>(x: &Triple<R>, y: &Triple<R>, z: &Triple<R>, error: R) -> R {
    let unit = R::UNIT_ROUNDOFF;
    let [x0, x1, x2] = x.map(R::abs);
    let [y0, y1, y2] = y.map(R::abs);
    let [z0, z1, z2] = z.map(R::abs);
    let permanent = x0 * (y1 * z2 + y2 * z1) + x1 * (y2 * z0 + y0 * z2) + x2 * (y0 * z1 + y1 * z0);
    let (e1, e2) = (minus(y, x), minus(z, x));
    let normal = norm1(&cross(&e1, &e2));
    let normal_error = R::from_f64(NORMAL) * unit * norm1(&e1) * norm1(&e2);
    R::from_f64(DETERMINANT) * unit * permanent
        + R::from_f64(1.01) * error * (normal + normal_error)
        + R::MIN_POSITIVE
}

/// The length of Σλw/Σλ for any weights λ ≥ 0.
pub(crate) fn combined_length<'v, R: Real + 'v>(
    points: impl IntoIterator<Item = &'v Vertex<R>>,
    weights: &[R],
) -> R {
    // Weights are volumes and may be tiny: scaled, so that no square of the sum underflows.
    let largest = weights.iter().fold(R::ZERO, |m, &weight| m.max(weight));
    let mut sum = [R::ZERO; 3];
    let mut total = R::ZERO;
    for (vertex, &weight) in points.into_iter().zip(weights) {
        let weight = weight / largest;
        let w = vertex.w.components();
        sum = [sum[0] + w[0] * weight, sum[1] + w[1] * weight, sum[2] + w[2] * weight];
        total = total + weight;
    }
    dot(&sum, &sum).sqrt() / total
}

#[cfg(test)]
mod tests;
