//! Where an object is: a rotation and a translation, valid by construction.

use crate::PoseError;
use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

/// A rigid placement: a vertex v of the object's own frame is at R·v + t in the world.
///
/// The rotation is held as a matrix, made once. That matrix is the truth that every answer is
/// given for, whatever it was made from.
///
/// ```
/// use dcd_geom::glam::{DQuat, DVec3};
/// use dcd_geom::Pose;
/// let quarter = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
/// let pose = Pose::new(quarter, DVec3::new(1.0, 0.0, 0.0))?;
/// assert!(pose.apply(DVec3::X).distance(DVec3::new(1.0, 1.0, 0.0)) < 1e-15);
/// assert!(Pose::from_translation(DVec3::new(0.0, f64::NAN, 0.0)).is_err());
/// # Ok::<(), dcd_geom::PoseError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    rotation: DMat3,
    translation: DVec3,
    deviation: f64,
}

impl Pose {
    /// No rotation, no translation.
    pub const IDENTITY: Self =
        Self { rotation: DMat3::IDENTITY, translation: DVec3::ZERO, deviation: 0.0 };

    /// How far | |q|² − 1 |, or an entry of |RᵀR − I|, may be from 0. No unit. Wide enough for
    /// quaternions that were normalised in f32, far too small for a scaling to pass.
    pub const UNIT_TOLERANCE: f64 = 1e-6;

    /// A pose of a unit quaternion, which is normalised once more in f64, and a translation in metres.
    ///
    /// # Errors
    /// A number that is not finite, or a quaternion that is not of unit length.
    pub fn new(rotation: DQuat, translation: DVec3) -> Result<Self, PoseError> {
        finite(rotation.to_array().iter().chain(&translation.to_array()))?;
        let length_squared = rotation.length_squared();
        // NaN cannot come here; an overflow to infinity is refused.
        if (length_squared - 1.0).abs() > Self::UNIT_TOLERANCE {
            return Err(PoseError::NotUnit { length_squared });
        }
        let matrix = DMat3::from_quat(rotation.normalize());
        Ok(Self { rotation: matrix, translation, deviation: row_deviation(&matrix) })
    }

    /// Whether all bits of the two agree; 0 and −0 do not.
    pub(crate) fn is_identical(&self, other: &Self) -> bool {
        let bits = |pose: &Self| {
            let turn = pose.rotation.to_cols_array().map(f64::to_bits);
            (turn, pose.translation.to_array().map(f64::to_bits))
        };
        bits(self) == bits(other)
    }

    /// [`Pose::new`] of numbers in f32: the quaternion is widened without loss, then normalised in f64.
    ///
    /// # Errors
    /// Those of [`Pose::new`].
    pub fn from_f32(rotation: Quat, translation: Vec3) -> Result<Self, PoseError> {
        Self::new(rotation.as_dquat(), translation.as_dvec3())
    }

    /// A pose of a rotation matrix, which is taken as it is, and a translation in metres.
    ///
    /// # Errors
    /// A number that is not finite, or a matrix that is no rotation.
    pub fn from_matrix(rotation: DMat3, translation: DVec3) -> Result<Self, PoseError> {
        if !(rotation.is_finite() && translation.is_finite()) {
            finite(rotation.to_cols_array().iter().chain(&translation.to_array()))?;
        }
        let deviation = largest_entry(&gram_excess(&rotation));
        // Written so that what overflows is refused.
        if !(deviation <= Self::UNIT_TOLERANCE) {
            return Err(PoseError::NotOrthonormal { deviation });
        }
        let determinant = rotation.determinant();
        if !(determinant > 0.0) {
            return Err(PoseError::Mirrors { determinant });
        }
        Ok(Self { rotation, translation, deviation: row_deviation(&rotation) })
    }

    /// The pose with another translation, metres.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn with_translation(self, translation: DVec3) -> Result<Self, PoseError> {
        if !translation.is_finite() {
            finite(translation.to_array().iter())?;
        }
        Ok(Self { translation, ..self })
    }

    /// A translation in metres, without rotation.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn from_translation(translation: DVec3) -> Result<Self, PoseError> {
        finite(translation.to_array().iter())?;
        Ok(Self { translation, ..Self::IDENTITY })
    }

    /// R.
    #[inline]
    pub fn rotation(&self) -> &DMat3 {
        &self.rotation
    }

    /// t, in metres.
    #[inline]
    pub fn translation(&self) -> DVec3 {
        self.translation
    }

    /// A bound on the ∞-norm of R·Rᵀ − I, so that every singular value of R lies within
    /// 1 ± deviation and every row's length is at most 1 + deviation.
    #[inline]
    pub fn deviation(&self) -> f64 {
        self.deviation
    }

    /// The pose of what is at `inner` in the frame of this one: x ↦ R·(R'·x + t') + t. Products are rounded, and a
    /// rotation comes out as far from one as both are together, and some 2⁻⁵⁰ more.
    ///
    /// # Errors
    /// A number that overflows, or rotations that are too far from one together.
    pub fn compose(&self, inner: &Self) -> Result<Self, PoseError> {
        Self::from_matrix(self.rotation * inner.rotation, self.apply(inner.translation))
    }

    /// The pose of this one's outer frame as seen in its own: x ↦ Rᵀ·(x − t), rounded. The inverse of a rotation is its
    /// transpose; what this one is off a rotation, [`Pose::deviation`], the result misses of being its inverse.
    ///
    /// # Errors
    /// A number that overflows.
    ///
    /// ```
    /// use dcd_geom::Pose;
    /// use dcd_geom::glam::{DQuat, DVec3};
    /// let gripper = Pose::new(DQuat::from_rotation_z(0.5), DVec3::new(1.0, 2.0, 3.0))?;
    /// let part = Pose::new(DQuat::from_rotation_x(0.3), DVec3::new(1.0, 2.5, 3.0))?;
    /// // Where the part is in the gripper, and back.
    /// let carried = gripper.inverse()?.compose(&part)?;
    /// let again = gripper.compose(&carried)?;
    /// assert!(again.apply(DVec3::ONE).distance(part.apply(DVec3::ONE)) < 1e-14);
    /// # Ok::<(), dcd_geom::PoseError>(())
    /// ```
    pub fn inverse(&self) -> Result<Self, PoseError> {
        let back = self.rotation.transpose();
        Self::from_matrix(back, back * -self.translation)
    }

    /// R·v + t, rounded.
    #[inline]
    pub fn apply(&self, v: DVec3) -> DVec3 {
        self.rotation * v + self.translation
    }
}

/// A pose as {"R": rows of the matrix, "t": translation}; what is read is checked as
/// [`Pose::from_matrix`] checks it, and is the same pose bit for bit where the format keeps f64.
#[cfg(feature = "serde")]
mod serial {
    use super::{DMat3, DVec3, Pose};
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    #[derive(Serialize, Deserialize)]
    #[serde(rename = "Pose", deny_unknown_fields)]
    struct Written {
        #[serde(rename = "R")]
        rows: [[f64; 3]; 3],
        t: [f64; 3],
    }

    impl Serialize for Pose {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            let rows = self.rotation.transpose().to_cols_array_2d();
            Written { rows, t: self.translation.to_array() }.serialize(serializer)
        }
    }

    impl<'de> Deserialize<'de> for Pose {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            let Written { rows, t } = Written::deserialize(deserializer)?;
            let rotation = DMat3::from_cols_array_2d(&rows).transpose();
            Self::from_matrix(rotation, DVec3::from_array(t)).map_err(D::Error::custom)
        }
    }

    #[cfg(test)]
    mod tests {
        use super::Pose;
        use glam::{DQuat, DVec3};

        #[test]
        fn a_pose_is_read_back_bit_for_bit() {
            let rotation = DQuat::from_xyzw(0.1, -0.2, 0.3, 0.9).normalize();
            let pose = Pose::new(rotation, DVec3::new(1e-300, -0.1, 3e9)).unwrap();
            let text = serde_json::to_string(&pose).unwrap();
            assert_eq!(serde_json::from_str::<Pose>(&text).unwrap(), pose);
        }

        #[test]
        fn what_is_no_pose_is_refused_with_its_value() {
            let scaled = r#"{"R": [[2, 0, 0], [0, 2, 0], [0, 0, 2]], "t": [0, 0, 0]}"#;
            let error = serde_json::from_str::<Pose>(scaled).unwrap_err().to_string();
            assert!(error.contains("3e0"), "{error}");
            let extra = r#"{"R": [[1,0,0],[0,1,0],[0,0,1]], "t": [0,0,0], "scale": 2}"#;
            assert!(serde_json::from_str::<Pose>(extra).is_err());
        }
    }
}

fn finite<'a>(mut numbers: impl Iterator<Item = &'a f64>) -> Result<(), PoseError> {
    match numbers.find(|x| !x.is_finite()) {
        Some(&value) => Err(PoseError::NotFinite { value }),
        None => Ok(()),
    }
}

/// MᵀM − I, which is symmetric: three squares and three products of columns.
fn gram_excess(m: &DMat3) -> DMat3 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *m;
    let (xy, xz, yz) = (x.dot(y), x.dot(z), y.dot(z));
    DMat3::from_cols(
        DVec3::new(x.dot(x) - 1.0, xy, xz),
        DVec3::new(xy, y.dot(y) - 1.0, yz),
        DVec3::new(xz, yz, z.dot(z) - 1.0),
    )
}

/// The largest entry of such a matrix. Where a product of two columns overflows, so does a square, so that no
/// NaN hides it.
fn largest_entry(m: &DMat3) -> f64 {
    let diagonal = DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
    let others = DVec3::new(m.x_axis.y, m.x_axis.z, m.y_axis.z);
    diagonal.abs().max(others.abs()).max_element()
}

/// The ∞-norm (largest sum of a row) of R·Rᵀ − I, plus what its own evaluation may be wrong by:
/// each entry is three products and four sums of terms at most 1 + 1e-6, so 8·2⁻⁵³ an entry and
/// three entries a row, doubled.
fn row_deviation(r: &DMat3) -> f64 {
    // By the matrix alone, however the pose was made: a pose that is written and read is the same.
    if *r == DMat3::IDENTITY {
        return 0.0;
    }
    let excess = gram_excess(&r.transpose());
    let row = |v: DVec3| v.x.abs() + v.y.abs() + v.z.abs();
    row(excess.x_axis).max(row(excess.y_axis)).max(row(excess.z_axis)) + 48.0 * (f64::EPSILON / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_quaternion_is_refused_with_its_length() {
        let zero = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
        assert_eq!(Pose::new(zero, DVec3::ZERO), Err(PoseError::NotUnit { length_squared: 0.0 }));
    }

    #[test]
    fn an_unnormalised_quaternion_is_refused_and_an_f32_one_is_not() {
        let long = DQuat::from_xyzw(0.0, 0.0, 0.0, 1.001);
        assert!(matches!(Pose::new(long, DVec3::ZERO), Err(PoseError::NotUnit { .. })));
        let f32_unit = DQuat::from_xyzw(0.6f32 as f64, 0.0, 0.8f32 as f64, 0.0);
        assert!(Pose::new(f32_unit, DVec3::ZERO).is_ok());
    }

    #[test]
    fn a_pose_of_f32_numbers_is_that_of_the_same_numbers_in_f64() {
        let (q, t) = (Quat::from_xyzw(0.6, 0.0, 0.8, 0.0), Vec3::new(0.1, -2.0, 1e30));
        assert_eq!(Pose::from_f32(q, t), Pose::new(q.as_dquat(), t.as_dvec3()));
        assert!(Pose::from_f32(Quat::from_xyzw(0.0, 0.0, 0.0, 1.01), t).is_err());
    }

    #[test]
    fn nan_and_infinity_are_refused_with_their_value() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let t = DVec3::new(0.0, bad, 0.0);
            assert!(matches!(Pose::new(DQuat::IDENTITY, t), Err(PoseError::NotFinite { .. })));
            assert!(matches!(Pose::from_translation(t), Err(PoseError::NotFinite { .. })));
            let q = DQuat::from_xyzw(bad, 0.0, 0.0, 1.0);
            assert!(matches!(Pose::new(q, DVec3::ZERO), Err(PoseError::NotFinite { .. })));
            let m = DMat3::from_cols(DVec3::X, DVec3::new(0.0, bad, 0.0), DVec3::Z);
            assert!(matches!(Pose::from_matrix(m, DVec3::ZERO), Err(PoseError::NotFinite { .. })));
        }
    }

    #[test]
    fn a_matrix_that_scales_shears_or_mirrors_is_refused() {
        let scale = DMat3::from_diagonal(DVec3::splat(2.0));
        assert!(matches!(
            Pose::from_matrix(scale, DVec3::ZERO),
            Err(PoseError::NotOrthonormal { .. })
        ));
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(1e-3, 1.0, 0.0), DVec3::Z);
        assert!(matches!(
            Pose::from_matrix(shear, DVec3::ZERO),
            Err(PoseError::NotOrthonormal { .. })
        ));
        let mirror = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
        assert!(matches!(Pose::from_matrix(mirror, DVec3::ZERO), Err(PoseError::Mirrors { .. })));
        let huge = DMat3::from_diagonal(DVec3::splat(1e200));
        assert!(Pose::from_matrix(huge, DVec3::ZERO).is_err());
    }

    #[test]
    fn deviation_bounds_the_matrix_of_a_quaternion() {
        let pose = Pose::new(DQuat::from_xyzw(0.1, 0.2, 0.3, 0.4).normalize(), DVec3::ONE).unwrap();
        assert!(pose.deviation() < 1e-14 && pose.deviation() > 0.0);
    }

    #[test]
    fn poses_are_composed_and_inverted_as_their_points_are_moved() {
        let turns = [[0.1, -0.7, 0.3, 0.9], [0.5, 0.5, -0.5, 0.5], [0.0, 0.0, 0.0, 1.0]];
        let places = [[3.0, -2.0, 0.25], [0.0, 1e3, -7.0], [1e-3, 0.0, 0.0]];
        let point = DVec3::new(0.3, -1.1, 2.7);
        for turn in turns.map(|q| DQuat::from_array(q).normalize()) {
            for place in places.map(DVec3::from_array) {
                let outer = Pose::new(turn, place).unwrap();
                let inner = Pose::new(turn * turn, DVec3::new(0.4, 5.0, -1.0)).unwrap();
                let both = outer.compose(&inner).unwrap();
                let due = outer.apply(inner.apply(point));
                assert!(both.apply(point).distance(due) < 1e-12, "{turn} {place}");
                let back = outer.inverse().unwrap();
                assert!(back.apply(outer.apply(point)).distance(point) < 1e-12, "{turn} {place}");
                assert!(outer.apply(back.apply(point)).distance(point) < 1e-12, "{turn} {place}");
            }
        }
        let far = Pose::from_translation(DVec3::X * 1e308).unwrap();
        assert!(far.compose(&far).is_err());
    }
}
