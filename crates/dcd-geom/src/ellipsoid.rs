//! Ellipsoids, known by their support map and by the equation of their surface.

use crate::error::check_length;
use crate::{ShapeError, Sphere, Support, SupportMap};
use glam::DVec3;

/// An ellipsoid round the origin, its axes along those of its frame, rounded or not: all points with
/// (x/a)² + (y/b)² + (z/c)² ≤ 1. With an axis of 0 it is flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    half_axes: DVec3,
    swept_radius: f64,
}

/// How far a support may fall short, and how far a coordinate of it may be from the shape. Unit: u times the
/// longest half axis. A coordinate loses 4.5 (docs/numerics/proofs.md, "ellipsoids"), and a margin. Smaller:
/// false answers.
const SUPPORT_ERROR: f64 = 8.0;

impl Ellipsoid {
    /// By half its axes, metres.
    ///
    /// # Errors
    /// A half axis that is negative or not finite.
    pub fn new(half_axes: DVec3) -> Result<Self, ShapeError> {
        half_axes.to_array().into_iter().try_for_each(|half| check_length("half axis", half))?;
        Ok(Self { half_axes, swept_radius: 0.0 })
    }

    /// The same core with a sphere of this radius swept round it, metres; replaces any other radius.
    ///
    /// # Errors
    /// A radius that is negative or not finite.
    pub fn rounded(self, radius: f64) -> Result<Self, ShapeError> {
        check_length("radius", radius)?;
        Ok(Self { swept_radius: radius, ..self })
    }

    /// Half its axes, metres.
    pub fn half_axes(&self) -> DVec3 {
        self.half_axes
    }

    /// The radius swept round the core, metres.
    pub fn swept_radius(&self) -> f64 {
        self.swept_radius
    }

    /// A bound on how far any point of the core, and any support, is from the origin, metres; infinite where
    /// no f64 holds it.
    pub fn reach(&self) -> f64 {
        self.half_axes.max_element() * (1.0 + 8.0 * f64::EPSILON)
    }

    /// The largest sphere round the origin inside the core.
    pub fn inner(&self) -> Sphere {
        Sphere { centre: DVec3::ZERO, radius: self.half_axes.min_element() }
    }
}

impl SupportMap<f64> for Ellipsoid {
    fn support(&self, direction: DVec3) -> Support<f64> {
        let largest = direction.abs().max_element();
        let stretched = self.half_axes * (direction / largest);
        // Divided by the largest, so that no square leaves the range.
        let scaled = stretched / stretched.abs().max_element();
        let length = scaled.length();
        // A direction along which it is flat, or none at all: the middle is as far as any other point.
        let point = if length > 0.0 { self.half_axes * (scaled / length) } else { DVec3::ZERO };
        Support::of_point(point)
    }

    fn radius(&self) -> f64 {
        self.swept_radius
    }

    fn support_error(&self) -> f64 {
        SUPPORT_ERROR * (f64::EPSILON / 2.0) * self.half_axes.max_element() + f64::MIN_POSITIVE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: [[f64; 3]; 7] = [
        [1.0, 1.0, 1.0],
        [3.0, 0.5, 1.0],
        [1e-3, 40.0, 2.0],
        [1.0, 2.0, 0.0],
        [0.0, 0.0, 5.0],
        [0.0, 0.0, 0.0],
        [1e150, 1e-150, 1.0],
    ];

    /// Points of its surface, a little inside.
    fn surface(half: DVec3) -> Vec<DVec3> {
        let point = |k: u32| {
            let (sine, cosine) = (f64::from(k) * 2.399963).sin_cos();
            let z = 1.0 - (f64::from(k) + 0.5) / 50.0;
            let across = (1.0 - z * z).sqrt();
            half * DVec3::new(across * cosine, across * sine, z) * (1.0 - 1e-15)
        };
        (0..100).map(point).collect()
    }

    #[test]
    fn ellipsoids_keep_the_contract_of_support_maps() {
        for half in SIZES.map(DVec3::from_array) {
            let shape = Ellipsoid::new(half).unwrap();
            crate::contract::support_map::<f64>(&shape, &surface(half)).unwrap();
        }
    }

    #[test]
    fn supports_are_on_the_surface_and_as_far_as_the_formula_says() {
        for half in SIZES.map(DVec3::from_array) {
            let shape = Ellipsoid::new(half).unwrap();
            let error = shape.support_error();
            for direction in surface(DVec3::ONE) {
                let point = shape.support(direction).point;
                let [x, y, z] = (half * direction).to_array();
                let far = x.hypot(y).hypot(z);
                let along = direction.dot(point);
                assert!((along - far).abs() <= 2.0 * error * direction.abs().element_sum());
                assert!(point.abs().cmple(half + error).all() && point.length() <= shape.reach());
            }
        }
    }

    #[test]
    fn bad_lengths_are_refused_with_their_value() {
        for bad in [-1.0, f64::INFINITY, f64::NAN] {
            for half in [DVec3::new(bad, 1.0, 1.0), DVec3::new(1.0, 1.0, bad)] {
                let refused = Ellipsoid::new(half);
                assert!(matches!(refused, Err(ShapeError::BadLength { what: "half axis", .. })));
            }
            let round = Ellipsoid::new(DVec3::ONE).unwrap().rounded(bad);
            assert!(matches!(round, Err(ShapeError::BadLength { what: "radius", .. })));
        }
    }
}
