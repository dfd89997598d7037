//! Cylinders and cones: shapes whose surface is curved, and known by their support map.

use crate::error::check_length;
use crate::{ShapeError, Sphere, Support, SupportMap};
use glam::{DVec2, DVec3};

/// The kind of a curved shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CurvedKind {
    /// A cylinder.
    Cylinder,
    /// A cone, its apex up.
    Cone,
}

/// A cylinder or a cone round the z axis, its middle at the origin, rounded or not: the hull of a
/// disc at z = −h and one at z = h, of which a cone's upper one is a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curved {
    kind: CurvedKind,
    half_height: f64,
    /// The radii of the lower and the upper disc.
    radii: [f64; 2],
    swept_radius: f64,
}

/// How far a support may fall short, and how far it may be from the shape. Unit: u·(half height +
/// radius). The rim's point loses 6 of its radius, the choice of the disc 6 of the radius or 4 of the
/// half height: 12 (docs/numerics/proofs.md, "cylinders and cones"), and a margin. Smaller: false answers.
const SUPPORT_ERROR: f64 = 20.0;

impl Curved {
    /// All points with |z| ≤ `half_height` and x² + y² ≤ `radius`²; metres.
    ///
    /// # Errors
    /// A half height or radius that is negative or not finite.
    pub fn cylinder(half_height: f64, radius: f64) -> Result<Self, ShapeError> {
        Self::checked(CurvedKind::Cylinder, half_height, [radius, radius])
    }

    /// The hull of the point z = `half_height` and the disc of `radius` at z = −`half_height`;
    /// metres.
    ///
    /// # Errors
    /// A half height or radius that is negative or not finite.
    pub fn cone(half_height: f64, radius: f64) -> Result<Self, ShapeError> {
        Self::checked(CurvedKind::Cone, half_height, [radius, 0.0])
    }

    fn checked(kind: CurvedKind, half_height: f64, radii: [f64; 2]) -> Result<Self, ShapeError> {
        check_length("half height", half_height)?;
        check_length("radius", radii[0])?;
        Ok(Self { kind, half_height, radii, swept_radius: 0.0 })
    }

    /// The same core with a sphere of this radius swept round it, metres; replaces any other radius.
    ///
    /// # Errors
    /// A radius that is negative or not finite.
    pub fn rounded(self, radius: f64) -> Result<Self, ShapeError> {
        check_length("radius", radius)?;
        Ok(Self { swept_radius: radius, ..self })
    }

    /// Its kind.
    #[inline]
    pub fn kind(&self) -> CurvedKind {
        self.kind
    }

    /// Half its height, metres.
    #[inline]
    pub fn half_height(&self) -> f64 {
        self.half_height
    }

    /// The radius of its lower disc, metres.
    #[inline]
    pub fn radius(&self) -> f64 {
        self.radii[0]
    }

    /// The discs whose hull it is: z and radius, from below.
    #[inline]
    pub fn discs(&self) -> [(f64, f64); 2] {
        [(-self.half_height, self.radii[0]), (self.half_height, self.radii[1])]
    }

    /// The radius swept round the core, metres.
    #[inline]
    pub fn swept_radius(&self) -> f64 {
        self.swept_radius
    }

    /// A bound on how far any point of the core is from the origin, metres; infinite where no f64
    /// holds it.
    pub fn reach(&self) -> f64 {
        self.half_height.hypot(self.radii[0]) * (1.0 + 8.0 * f64::EPSILON)
    }

    /// The least and the largest v·d of its points v, the swept radius included, for a direction of
    /// length 1; both on the safe side by the error of a support.
    pub(crate) fn extent(&self, d: DVec3) -> (f64, f64) {
        let across = (d.x * d.x + d.y * d.y).sqrt();
        let [(z, r), (upper_z, upper_r)] = self.discs().map(|(z, r)| (d.z * z, across * r));
        // A root loses less than a support's quotients, and the products and sums no more.
        let margin = self.support_error() * d.abs().element_sum() + self.swept_radius;
        ((z - r).min(upper_z - upper_r) - margin, (z + r).max(upper_z + upper_r) + margin)
    }

    /// A sphere inside the core, rounded down: the largest one but for rounding.
    pub fn inner(&self) -> Sphere {
        let Self { half_height, radii: [radius, _], .. } = *self;
        let (height, inner) = match self.kind {
            CurvedKind::Cylinder => (0.0, half_height.min(radius)),
            CurvedKind::Cone => {
                // The inradius of the triangle with base 2r and height 2h: area over half the
                // circumference. Divided by the larger side, so that nothing overflows.
                let largest = half_height.max(radius);
                if largest == 0.0 {
                    return Sphere { centre: DVec3::ZERO, radius: 0.0 };
                }
                let (h, r) = (2.0 * (half_height / largest), radius / largest);
                let inner = r * h / (r + h.hypot(r)) * (1.0 - 32.0 * f64::EPSILON) * largest;
                (inner - half_height, inner)
            }
        };
        // The centre's own rounding is at most an ulp of the half height.
        let radius = (inner - half_height * f64::EPSILON).max(0.0);
        Sphere { centre: DVec3::new(0.0, 0.0, height), radius }
    }
}

impl SupportMap<f64> for Curved {
    fn support(&self, direction: DVec3) -> Support<f64> {
        let (across, DVec2 { x, y }) = length_and_direction(direction.truncate());
        let [low, high] = self.discs();
        let along = |(z, radius): (f64, f64)| direction.z * z + across * radius;
        let (z, radius) = if along(high) > along(low) { high } else { low };
        let point = DVec3::new(radius * x, radius * y, z);
        Support::of_point(point)
    }

    fn radius(&self) -> f64 {
        self.swept_radius
    }

    fn support_error(&self) -> f64 {
        SUPPORT_ERROR * (f64::EPSILON / 2.0) * (self.half_height + self.radii[0])
    }
}

/// The length of a vector, and the vector at unit length: both 0 of none, for a direction along the axis has no x and y.
/// Any point of the rim will do there, and the middle is the same in every such direction.
#[inline]
fn length_and_direction(v: DVec2) -> (f64, DVec2) {
    let squared = v.x * v.x + v.y * v.y;
    if (1e-200..1e200).contains(&squared) {
        let length = squared.sqrt();
        return (length, v / length);
    }
    // The squares under- or overflow, or nearly.
    let largest = v.x.abs().max(v.y.abs());
    let scaled = v / largest;
    let length = scaled.length();
    if length > 0.0 { (length * largest, scaled / length) } else { (0.0, DVec2::ZERO) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curved_shapes_keep_the_contract_of_support_maps() {
        let rim = |k: u32, r: f64, z: f64| {
            let angle = f64::from(k) * 0.1;
            DVec3::new(r * angle.cos(), r * angle.sin(), z) * (1.0 - 1e-15)
        };
        for (h, r) in [(1.0, 0.5), (1e-3, 1e-3), (0.01, 7.0), (1e3, 1e-3), (0.0, 1.0), (1.0, 0.0)] {
            let cylinder = Curved::cylinder(h, r).unwrap();
            let points: Vec<_> = (0..63).flat_map(|k| [rim(k, r, h), rim(k, r, -h)]).collect();
            crate::contract::support_map::<f64>(&cylinder, &points).unwrap();
            let cone = Curved::cone(h, r).unwrap();
            let points: Vec<_> = (0..63).map(|k| rim(k, r, -h)).chain([DVec3::Z * h]).collect();
            crate::contract::support_map::<f64>(&cone, &points).unwrap();
        }
    }

    #[test]
    fn the_inner_sphere_is_inside_and_touches_the_side() {
        let cylinder = Curved::cylinder(2.0, 0.5).unwrap().inner();
        assert!(cylinder.radius <= 0.5 && cylinder.radius > 0.5 * (1.0 - 1e-14));
        // Base 6 and height 4 make sides of 5: the inradius is 12 / 8.
        let cone = Curved::cone(2.0, 3.0).unwrap().inner();
        assert!(cone.radius <= 1.5 && cone.radius > 1.5 * (1.0 - 1e-13));
        assert!((cone.centre.z + 0.5).abs() < 1e-13);
        for (h, r) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1e300, 1e300), (1e-300, 1e-300)] {
            let sphere = Curved::cone(h, r).unwrap().inner();
            assert!(sphere.radius >= 0.0 && sphere.radius <= h.min(r) && sphere.centre.is_finite());
        }
    }

    #[test]
    fn bad_lengths_are_refused_with_their_value() {
        for bad in [-1.0, f64::INFINITY, f64::NAN] {
            for refused in [Curved::cylinder(bad, 1.0), Curved::cone(bad, 1.0)] {
                assert!(matches!(refused, Err(ShapeError::BadLength { what: "half height", .. })));
            }
            for refused in [Curved::cylinder(1.0, bad), Curved::cone(1.0, bad)] {
                assert!(matches!(refused, Err(ShapeError::BadLength { what: "radius", .. })));
            }
            let round = Curved::cone(1.0, 1.0).unwrap().rounded(bad);
            assert!(matches!(round, Err(ShapeError::BadLength { what: "radius", .. })));
        }
    }
}
