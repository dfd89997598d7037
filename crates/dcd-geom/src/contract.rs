//! The contracts of this crate's traits, as tests that any backend can call.

use crate::{Real, SupportMap, Vector};
use glam::DVec3;
use std::fmt;

/// A contract that was broken, and by what.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation(
    /// What was seen, in a sentence.
    pub String,
);

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Violation {}

/// How many directions [`support_map`] samples.
const DIRECTIONS: usize = 512;

/// Tests the contract of [`SupportMap`]: no known point of the core is farther along a direction than
/// the support there, but for the stated support error and the rounding of the comparison; the
/// radius and the error are finite and not negative; equal features are equal points.
///
/// `core` are points known to be of the core; the supports found are added to them.
///
/// # Errors
/// The first breach.
pub fn support_map<R: Real>(map: &impl SupportMap<R>, core: &[R::Vec3]) -> Result<(), Violation> {
    for (what, value) in [("radius", map.radius()), ("support error", map.support_error())] {
        if !(value >= R::ZERO && value <= R::MAX) {
            return Err(Violation(format!("the {what} is {value:?}")));
        }
    }
    let directions: Vec<R::Vec3> = directions().map(R::Vec3::from_dvec3).collect();
    let supports: Vec<_> = directions.iter().map(|&d| map.support(d)).collect();
    let known: Vec<R::Vec3> =
        core.iter().copied().chain(supports.iter().map(|s| s.point)).collect();
    for (&d, s) in directions.iter().zip(&supports) {
        let along = s.point.dot(d);
        for &p in &known {
            // Each dot product is off by at most 3u of the products' absolute sum.
            let rounding =
                (p.norm_max() + s.point.norm_max()) * R::from_f64(4.0) * R::UNIT_ROUNDOFF;
            let bound = along + (map.support_error() + rounding) * d.norm1();
            if !(p.dot(d) <= bound) {
                return Err(Violation(format!(
                    "along {d:?} the support {s:?} falls short of {p:?}"
                )));
            }
        }
        if let Some(other) = supports.iter().find(|o| o.feature == s.feature && o.point != s.point)
        {
            return Err(Violation(format!("feature {} is both {s:?} and {other:?}", s.feature)));
        }
    }
    let any = map.support(R::Vec3::ZERO).point;
    if any.components().iter().any(|x| !(x.abs() <= R::MAX)) {
        return Err(Violation(format!("a zero direction gives {any:?}")));
    }
    Ok(())
}

/// The axes and the diagonals, then a spiral of even steps in z, at lengths from 2⁻⁸ to 2⁸.
fn directions() -> impl Iterator<Item = DVec3> {
    let signs = [-1.0, 0.0, 1.0];
    let lattice = signs.into_iter().flat_map(move |x| {
        signs.into_iter().flat_map(move |y| signs.into_iter().map(move |z| DVec3::new(x, y, z)))
    });
    let golden_angle = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let spiral = (0..DIRECTIONS).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / DIRECTIONS as f64;
        let (sin, cos) = (golden_angle * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z) * 2f64.powi(k as i32 % 17 - 8)
    });
    lattice.filter(|&d| d != DVec3::ZERO).chain(spiral)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Polytope, Shape, Support};

    #[test]
    fn our_shapes_keep_the_contract_in_both_precisions() {
        let hull: Vec<DVec3> =
            directions().take(60).map(|d| d * DVec3::new(1.0, 2.0, 0.1)).collect();
        let shapes = [
            Polytope::hull(hull).unwrap(),
            Polytope::sphere(0.5).unwrap(),
            Polytope::cuboid(DVec3::new(1.0, 0.5, 0.25)).unwrap(),
            Polytope::hull(vec![DVec3::ONE; 3]).unwrap(),
        ];
        for shape in shapes {
            let f32s: Vec<_> = shape.vertices().iter().map(|v| v.as_vec3()).collect();
            support_map::<f64>(&shape, shape.vertices()).unwrap();
            support_map::<f32>(&shape, &f32s).unwrap();
            support_map::<f64>(&Shape::from(shape), &[]).unwrap();
        }
    }

    #[test]
    fn a_map_that_falls_short_is_caught() {
        struct Short;
        impl SupportMap<f64> for Short {
            fn support(&self, _: DVec3) -> Support<f64> {
                Support { point: DVec3::ZERO, feature: 0 }
            }
        }
        assert!(support_map(&Short, &[DVec3::X]).is_err());
        assert!(support_map(&Short, &[]).is_ok());
    }
}
