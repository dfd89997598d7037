//! Half-spaces: the one shape without an end.

use crate::error::check_length;
use crate::{Aabb, Pose, ShapeError};
use glam::DVec3;

/// All points x with normal·x ≤ offset, rounded or not, in its own frame.
///
/// The plane's numbers are taken as they are: the normal need not be of unit length, and is the
/// truth that every answer is given for. With a pose it is the set of all R·x + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    normal: DVec3,
    offset: f64,
    /// The same at a normal of length 1, rounded: most questions begin with it.
    unit_normal: DVec3,
    unit_offset: f64,
    swept_radius: f64,
}

/// How long a normal's largest component may be, no unit: far more than any needs, and so little
/// that no product with one over- or underflows that is of use.
const NORMALS: std::ops::RangeInclusive<f64> = 1e-60..=1e60;

impl HalfSpace {
    /// All points x with normal·x ≤ offset: the normal points out of it, `offset` is its product
    /// with any point of the plane.
    ///
    /// # Errors
    /// A normal whose largest component is not within 1e±60 (0 and NaN are not), or an offset that
    /// is not finite.
    pub fn new(normal: DVec3, offset: f64) -> Result<Self, ShapeError> {
        let largest = normal.abs().max_element();
        if !(NORMALS.contains(&largest) && normal.is_finite() && offset.is_finite()) {
            return Err(ShapeError::BadPlane { normal, offset });
        }
        let length = normal.length();
        let (unit_normal, unit_offset) = (normal / length, offset / length);
        Ok(Self { normal, offset, unit_normal, unit_offset, swept_radius: 0.0 })
    }

    /// The half-space with a sphere of this radius swept round it, metres; replaces any other radius.
    ///
    /// # Errors
    /// A radius that is negative or not finite.
    pub fn rounded(self, radius: f64) -> Result<Self, ShapeError> {
        check_length("radius", radius)?;
        Ok(Self { swept_radius: radius, ..self })
    }

    /// Out of it, at any length.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// The normal's product with any point of the plane.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// [`HalfSpace::normal`] at length 1, rounded.
    pub fn unit_normal(&self) -> DVec3 {
        self.unit_normal
    }

    /// How far its plane is from the origin of its frame along the normal, metres, negative behind it: rounded.
    pub fn unit_offset(&self) -> f64 {
        self.unit_offset
    }

    /// The radius swept round it, metres.
    pub fn swept_radius(&self) -> f64 {
        self.swept_radius
    }

    /// An AABB that holds it as far as objects reach: ±[`Aabb::LIMIT`] but where its plane is normal
    /// to a world axis. A floor then meets in the tree what is near it, and not everything.
    pub fn aabb(&self, pose: &Pose) -> Aabb {
        let mut min = DVec3::splat(-Aabb::LIMIT);
        let mut max = DVec3::splat(Aabb::LIMIT);
        if let Some((axis, end)) = self.end(pose) {
            let end = end.clamp(-Aabb::LIMIT, Aabb::LIMIT);
            match axis {
                Axis::Up(k) => max[k] = end,
                Axis::Down(k) => min[k] = end,
            }
        }
        Aabb::outward(min, max)
    }

    /// Where it ends along the world axis that its plane is normal to, rounded away from it. Only
    /// where that coordinate of R·x + t depends on one component of x alone, exactly.
    fn end(&self, pose: &Pose) -> Option<(Axis, f64)> {
        let only = |v: DVec3| {
            let mut nonzero = (0..3).filter(|&k| v[k] != 0.0);
            nonzero.next().filter(|_| nonzero.next().is_none())
        };
        let j = only(self.normal)?;
        let k = (0..3).find(|&k| only(pose.rotation().row(k)) == Some(j))?;
        let (scale, t) = (pose.rotation().row(k)[j], pose.translation()[k]);
        let core = scale * (self.offset / self.normal[j]);
        // Two roundings of the core's, one for each sum.
        let margin = (core.abs() + t.abs() + self.swept_radius) * (4.0 * f64::EPSILON);
        let margin = margin + f64::MIN_POSITIVE;
        if (scale > 0.0) == (self.normal[j] > 0.0) {
            Some((Axis::Up(k), core + t + self.swept_radius + margin))
        } else {
            Some((Axis::Down(k), core + t - self.swept_radius - margin))
        }
        // An overflow's NaN says nothing of where it ends.
        .filter(|(_, end)| !end.is_nan())
    }
}

/// The side on which a half-space ends.
enum Axis {
    Up(usize),
    Down(usize),
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn a_plane_is_as_far_away_whatever_the_length_of_its_normal() {
        let normal = DVec3::new(0.36, -0.48, 0.8);
        for length in [1e-59, 0.25, 1.0, 3.0, 1e59] {
            let plane = HalfSpace::new(normal * length, -2.5 * length).unwrap();
            assert!(plane.unit_normal().distance(normal) < 1e-15, "{length}");
            assert!((plane.unit_offset() + 2.5).abs() < 1e-14, "{length}");
        }
    }

    #[test]
    fn a_plane_without_direction_or_place_is_refused() {
        for (normal, offset) in [
            (DVec3::ZERO, 0.0),
            (DVec3::splat(1e-61), 0.0),
            (DVec3::splat(1e61), 0.0),
            (DVec3::new(1.0, f64::NAN, 0.0), 0.0),
            (DVec3::new(f64::INFINITY, 0.0, 0.0), 0.0),
            (DVec3::Z, f64::NAN),
            (DVec3::Z, f64::NEG_INFINITY),
        ] {
            let refused = HalfSpace::new(normal, offset);
            assert!(matches!(refused, Err(ShapeError::BadPlane { .. })), "{normal} {offset}");
        }
        let bad = HalfSpace::new(DVec3::Z, 0.0).unwrap().rounded(-1.0);
        assert!(matches!(bad, Err(ShapeError::BadLength { what: "radius", .. })));
    }

    #[test]
    fn a_floor_ends_above_and_a_slope_nowhere() {
        let floor = HalfSpace::new(DVec3::Z * 3.0, 1.5).unwrap().rounded(0.25).unwrap();
        let limit = Aabb::LIMIT as f32;
        let at = Pose::from_translation(DVec3::new(5.0, 5.0, 10.0)).unwrap();
        let aabb = floor.aabb(&at);
        assert!(aabb.max.z >= 10.75 && aabb.max.z < 10.7501);
        assert!(aabb.max.x >= limit && aabb.max.y >= limit && aabb.min.z <= -limit);
        let ceiling = Pose::new(DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0), DVec3::ZERO).unwrap();
        let aabb = floor.aabb(&ceiling);
        assert!(aabb.min.z <= -0.75 && aabb.min.z > -0.7501 && aabb.max.z >= limit);
        let slope = Pose::new(DQuat::from_rotation_x(0.1), DVec3::ZERO).unwrap();
        let aabb = floor.aabb(&slope);
        assert!(aabb.min.max_element() <= -limit && aabb.max.min_element() >= limit);
    }
}
