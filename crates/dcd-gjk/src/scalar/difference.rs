//! The Minkowski difference of two placed cores, by its support function.

use dcd_geom::glam::DVec3;
use dcd_geom::{Matrix, Polytope, Pose, Real, Shape, Sphere, Support, SupportMap, Vector};

/// A support map at a pose, with a bound on how far its core reaches.
#[derive(Debug)]
pub struct PosedSupport<'a, S: ?Sized> {
    /// The shape.
    pub map: &'a S,
    /// Where it is.
    pub pose: &'a Pose,
    /// At least the distance of every point of the core from the origin of its own frame, metres.
    pub reach: f64,
    /// A point near the core's middle, in its own frame, metres: where searches start. Any finite
    /// point is sound, a good one is quick.
    pub centre: DVec3,
    /// The radius of a sphere round the centre that is inside the core, metres: 0 where only the centre
    /// itself is known to be inside, to within 4·2⁻⁵³ of `reach`; `None` where not even that is.
    pub inner: Option<f64>,
}

impl<S: ?Sized> Clone for PosedSupport<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: ?Sized> Copy for PosedSupport<'_, S> {}

impl<'a, S: ?Sized> PosedSupport<'a, S> {
    /// Any support map; six supports bound how far it reaches.
    pub fn new<R: Real>(map: &'a S, pose: &'a Pose) -> Self
    where
        S: SupportMap<R>,
    {
        let along = |axis: usize, sign: f64| {
            let mut d = [R::ZERO; 3];
            d[axis] = R::from_f64(sign);
            map.support(R::Vec3::new(d[0], d[1], d[2])).point.components()[axis].to_f64()
        };
        let low = DVec3::new(along(0, -1.0), along(1, -1.0), along(2, -1.0));
        let high = DVec3::new(along(0, 1.0), along(1, 1.0), along(2, 1.0));
        let corner = low.abs().max(high.abs()) + map.support_error().to_f64();
        // The box's half diagonal, and a margin for the rounding of its length. An overflow makes it
        // infinite, and the pair then has no difference.
        let reach = corner.x.hypot(corner.y).hypot(corner.z) * (1.0 + 1e-6);
        Self { map, pose, reach, centre: low * 0.5 + high * 0.5, inner: None }
    }
}

impl<'a> PosedSupport<'a, Polytope> {
    /// A polytope, whose reach is known.
    pub fn polytope(map: &'a Polytope, pose: &'a Pose) -> Self {
        let Sphere { centre, radius } = map.inner();
        Self { map, pose, reach: map.reach(), centre, inner: Some(radius) }
    }
}

impl<'a> PosedSupport<'a, Shape> {
    /// A shape of a scene, whose reach is known.
    pub fn shape(map: &'a Shape, pose: &'a Pose) -> Self {
        let Sphere { centre, radius } = map.inner();
        let inner = map.centre_is_inside().then_some(radius);
        Self { map, pose, reach: map.reach(), centre, inner }
    }
}

/// A − B for two placed cores: all points (R_A·a + t_A) − (R_B·b + t_B), in world axes.
///
/// Scaled by a power of two such that its size m is in [½, 1): no formula on it under- or
/// overflows, and every rounding bound is relative to 1 (docs/numerics/model.md, "scale").
#[derive(Debug)]
pub struct Difference<'a, R: Real, A: ?Sized, B: ?Sized> {
    a: &'a A,
    b: &'a B,
    rotation_a: R::Mat3,
    rotation_b: R::Mat3,
    delta: R::Vec3,
    middle: R::Vec3,
    inner: R,
    scale: R,
    size: R,
}

/// A vertex of the difference: a support of A against one of B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex<R: Real> {
    /// R_A·a − R_B·b + δt, scaled.
    pub w: R::Vec3,
    /// The support of A, in A's frame, metres (not scaled).
    pub a: Support<R>,
    /// The support of B, in B's frame, metres (not scaled).
    pub b: Support<R>,
}

impl<R: Real> Vertex<R> {
    /// Whether both stem from the same features.
    pub fn is_same(&self, other: &Self) -> bool {
        self.a.feature == other.a.feature && self.b.feature == other.b.feature
    }
}

impl<'a, R, A, B> Difference<'a, R, A, B>
where
    R: Real,
    A: SupportMap<R> + ?Sized,
    B: SupportMap<R> + ?Sized,
{
    /// Of two bodies. `None` if the pair's size leaves the range in which no product of a vertex
    /// and a direction over- or underflows noticeably: 2^±900 m in f64, 2^±96 m in f32.
    pub fn new(a: PosedSupport<'a, A>, b: PosedSupport<'a, B>) -> Option<Self> {
        let delta = a.pose.translation() - b.pose.translation();
        let reach = |body_reach: f64, pose: &Pose| body_reach * (1.0 + pose.deviation());
        let inner = |side: Option<f64>, pose: &Pose| Some(side? * (1.0 - pose.deviation()));
        // One centre that may be outside of its core makes the sum of both no point of the difference.
        let inner = inner(a.inner, a.pose).zip(inner(b.inner, b.pose));
        let inner = inner.map_or(0.0, |(of_a, of_b)| of_a + of_b);
        let size = reach(a.reach, a.pose) + reach(b.reach, b.pose) + Vector::norm1(delta);
        let scale = power_of_two_below_one(size)?;
        let wide = R::UNIT_ROUNDOFF.to_f64() < 1e-10;
        let largest = if wide { WIDEST_F64 } else { WIDEST_F32 };
        if !(largest.recip() <= scale && scale <= largest) {
            return None;
        }
        let (rotation_a, rotation_b) = (a.pose.rotation(), b.pose.rotation());
        let middle = (*rotation_a * a.centre - *rotation_b * b.centre) + delta;
        Some(Self {
            a: a.map,
            b: b.map,
            rotation_a: R::Mat3::from_dmat3(*rotation_a),
            rotation_b: R::Mat3::from_dmat3(*rotation_b),
            delta: R::Vec3::from_dvec3(delta * scale),
            middle: R::Vec3::from_dvec3(middle * scale),
            inner: R::from_f64(inner * scale),
            scale: R::from_f64(scale),
            // Rounded up with a margin: the sum above has three roundings of its own.
            size: R::from_f64(size * scale * (1.0 + 8.0 * f64::EPSILON))
                * (R::ONE + R::UNIT_ROUNDOFF * R::from_f64(2.0)),
        })
    }

    /// The vertex lowest along `direction` (world axes), and the separation there: the computed
    /// minimum of d·w over A − B, to which every bound refers. Scaled.
    #[inline]
    pub fn lowest(&self, direction: R::Vec3) -> (Vertex<R>, R) {
        let d_a = self.rotation_a.transform_transposed(direction);
        let d_b = self.rotation_b.transform_transposed(direction);
        let (a, b) = (self.a.support(-d_a), self.b.support(d_b));
        let (along_a, along_b) = (d_a.dot(a.point * self.scale), d_b.dot(b.point * self.scale));
        let separation = direction.dot(self.delta) + (along_a - along_b);
        (Vertex { w: self.world(a.point, b.point), a, b }, separation)
    }

    /// The vertex farthest along `direction` (world axes), up to rounding and support errors.
    pub fn support(&self, direction: R::Vec3) -> Vertex<R> {
        let a = self.a.support(self.rotation_a.transform_transposed(direction));
        let b = self.b.support(self.rotation_b.transform_transposed(-direction));
        Vertex { w: self.world(a.point, b.point), a, b }
    }

    /// The difference's point for a point of A and one of B, scaled.
    #[inline]
    pub fn world(&self, a: R::Vec3, b: R::Vec3) -> R::Vec3 {
        let a = self.rotation_a.transform(a * self.scale);
        let b = self.rotation_b.transform(b * self.scale);
        (a - b) + self.delta
    }

    /// A world direction in the frames of A and B: Rᵀd of each.
    #[inline]
    pub(crate) fn to_local(&self, direction: R::Vec3) -> [R::Vec3; 2] {
        let of_a = self.rotation_a.transform_transposed(direction);
        [of_a, self.rotation_b.transform_transposed(direction)]
    }

    /// The separation s = min over A − B of d·w, evaluated as d·δt + min (Rᵀd)·a − max (Rᵀd)·b on
    /// the supports of `vertex`, which was found along −d. Scaled.
    pub fn separation(&self, direction: R::Vec3, vertex: &Vertex<R>) -> R {
        let d_a = self.rotation_a.transform_transposed(direction);
        let d_b = self.rotation_b.transform_transposed(direction);
        let a = d_a.dot(vertex.a.point * self.scale);
        let b = d_b.dot(vertex.b.point * self.scale);
        direction.dot(self.delta) + (a - b)
    }

    /// The rotations of A and B.
    pub(crate) fn rotations(&self) -> [R::Mat3; 2] {
        [self.rotation_a, self.rotation_b]
    }

    /// The pair's size m, scaled: κ_A·r_A + κ_B·r_B + |δt|₁, in [½, 1) but for rounding up.
    pub fn size(&self) -> R {
        self.size
    }

    /// The power of two by which every length here is multiplied.
    pub fn scale(&self) -> R {
        self.scale
    }

    /// δt, scaled: a point near the difference's middle where both shapes are near their origins.
    pub fn delta(&self) -> R::Vec3 {
        self.delta
    }

    /// The difference of the two bodies' centres, scaled: where searches start.
    pub fn middle(&self) -> R::Vec3 {
        self.middle
    }

    /// The radius of a sphere round the middle that is inside the difference, to within rounding;
    /// scaled. 0 where none is known.
    pub fn inner(&self) -> R {
        self.inner
    }

    /// The sum of the radii swept round the cores, scaled.
    pub fn radius(&self) -> R {
        (self.a.radius() + self.b.radius()) * self.scale
    }

    /// The sum of the support errors, scaled.
    pub fn support_error(&self) -> R {
        (self.a.support_error() + self.b.support_error()) * self.scale
    }
}

impl<'a, R: Real, A: ?Sized, B: ?Sized> Difference<'a, R, A, B> {
    /// The support maps of A and B.
    pub(crate) fn maps(&self) -> (&'a A, &'a B) {
        (self.a, self.b)
    }
}

/// The largest scale in f64, and the reciprocal of the smallest. No unit. Products of a vertex and
/// a direction stay below 2¹⁰²⁴, and what they lose to underflow, 2⁻¹⁰⁷⁵, is far below 2⁻⁵³·m.
const WIDEST_F64: f64 = f64::from_bits((1023 + 900) << 52);

/// The same in f32: below 2¹²⁸, and 2⁻¹⁵⁰ far below 2⁻²⁴·m.
const WIDEST_F32: f64 = f64::from_bits((1023 + 96) << 52);

/// The power of two that brings x into [½, 1); 1 for 0. `None` where it or x is not a normal number.
#[inline]
pub(crate) fn power_of_two_below_one(x: f64) -> Option<f64> {
    if x == 0.0 {
        return Some(1.0);
    }
    if !x.is_normal() || x < 0.0 {
        return None;
    }
    let exponent = (x.to_bits() >> 52 & 0x7ff) as i64 - 1022;
    let biased = 1023 - exponent;
    (1..=2046).contains(&biased).then(|| f64::from_bits((biased as u64) << 52))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::DQuat;

    #[test]
    fn the_scale_brings_every_size_below_one() {
        for x in [1.0, 0.99, 3.7, 1e-300, 1e300, 2f64.powi(-1000)] {
            let s = power_of_two_below_one(x).unwrap();
            assert!((0.5..1.0).contains(&(x * s)), "{x}");
        }
        assert_eq!(power_of_two_below_one(0.0), Some(1.0));
        assert_eq!(power_of_two_below_one(f64::INFINITY), None);
    }

    #[test]
    fn supports_of_two_cubes_are_the_corners_of_their_difference() {
        let cube = Polytope::cuboid(DVec3::splat(0.5)).unwrap();
        let here = Pose::IDENTITY;
        let there = Pose::new(DQuat::IDENTITY, DVec3::new(3.0, 0.0, 0.0)).unwrap();
        let (a, b) = (PosedSupport::polytope(&cube, &here), PosedSupport::polytope(&cube, &there));
        let difference = Difference::<f64, _, _>::new(a, b).unwrap();
        let x = difference.support(DVec3::X);
        assert_eq!(x.w.x / difference.scale(), -2.0);
        assert_eq!(difference.separation(-DVec3::X, &x) / difference.scale(), 2.0);
        assert!(difference.size() >= 0.5 && difference.size() <= 1.0 + 1e-15);
    }
}
