//! The two number types of the solvers.

use glam::{DMat3, DVec3, Mat3, Vec3};
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// f32 or f64: what a solver computes in. Sealed.
pub trait Real:
    sealed::Sealed
    + Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// Three of them: glam's `Vec3` or `DVec3`.
    type Vec3: Vector<Self>;
    /// Three by three: glam's `Mat3` or `DMat3`.
    type Mat3: Matrix<Self>;
    /// Half the distance from 1 to the next number: 2⁻²⁴ or 2⁻⁵³.
    const UNIT_ROUNDOFF: Self;
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// The largest finite number.
    const MAX: Self;
    /// The smallest positive normal number.
    const MIN_POSITIVE: Self;

    /// The nearest number of this type.
    fn from_f64(x: f64) -> Self;
    /// Without loss.
    fn to_f64(self) -> f64;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Correctly rounded square root.
    fn sqrt(self) -> Self;
    /// The larger; the other one where one is NaN.
    fn max(self, other: Self) -> Self;
    /// The smaller; the other one where one is NaN.
    fn min(self, other: Self) -> Self;
}

/// What a solver needs of a vector of three.
pub trait Vector<R: Real>:
    Copy
    + Debug
    + Default
    + PartialEq
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<R, Output = Self>
    + 'static
{
    /// The origin.
    const ZERO: Self;
    /// The vector of three components.
    fn new(x: R, y: R, z: R) -> Self;
    /// The three components.
    fn components(self) -> [R; 3];
    /// Each component rounded to the nearest.
    fn from_dvec3(v: DVec3) -> Self;
    /// Without loss.
    fn to_dvec3(self) -> DVec3;
    /// x·x' + y·y' + z·z', summed from the left, never fused.
    fn dot(self, other: Self) -> R;
    /// Cross product, never fused.
    fn cross(self, other: Self) -> Self;
    /// Sum of the absolute components.
    fn norm1(self) -> R {
        let [x, y, z] = self.components();
        x.abs() + y.abs() + z.abs()
    }
    /// The largest absolute component.
    fn norm_max(self) -> R {
        let [x, y, z] = self.components();
        x.abs().max(y.abs()).max(z.abs())
    }
    /// Euclidean length; overflows and underflows with its square.
    fn length(self) -> R {
        self.dot(self).sqrt()
    }
}

/// What a solver needs of a matrix of three by three.
pub trait Matrix<R: Real>: Copy + Debug + Send + Sync + 'static {
    /// Each entry rounded to the nearest.
    fn from_dmat3(m: DMat3) -> Self;
    /// M·v.
    fn transform(&self, v: R::Vec3) -> R::Vec3;
    /// Mᵀ·v.
    fn transform_transposed(&self, v: R::Vec3) -> R::Vec3;
}

macro_rules! implement {
    ($real:ty, $vec:ty, $mat:ty, $vec_from:expr, $vec_to:expr, $mat_from:expr) => {
        impl Real for $real {
            type Vec3 = $vec;
            type Mat3 = $mat;
            const UNIT_ROUNDOFF: Self = <$real>::EPSILON / 2.0;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const MAX: Self = <$real>::MAX;
            const MIN_POSITIVE: Self = <$real>::MIN_POSITIVE;
            #[inline]
            fn from_f64(x: f64) -> Self {
                x as $real
            }
            #[inline]
            fn to_f64(self) -> f64 {
                self.into()
            }
            #[inline]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline]
            fn max(self, other: Self) -> Self {
                self.max(other)
            }
            #[inline]
            fn min(self, other: Self) -> Self {
                self.min(other)
            }
        }

        impl Vector<$real> for $vec {
            const ZERO: Self = <$vec>::ZERO;
            #[inline]
            fn new(x: $real, y: $real, z: $real) -> Self {
                <$vec>::new(x, y, z)
            }
            #[inline]
            fn components(self) -> [$real; 3] {
                self.to_array()
            }
            #[inline]
            fn from_dvec3(v: DVec3) -> Self {
                $vec_from(v)
            }
            #[inline]
            fn to_dvec3(self) -> DVec3 {
                $vec_to(self)
            }
            #[inline]
            fn dot(self, other: Self) -> $real {
                self.x * other.x + self.y * other.y + self.z * other.z
            }
            #[inline]
            fn cross(self, other: Self) -> Self {
                <$vec>::new(
                    self.y * other.z - self.z * other.y,
                    self.z * other.x - self.x * other.z,
                    self.x * other.y - self.y * other.x,
                )
            }
        }

        impl Matrix<$real> for $mat {
            #[inline]
            fn from_dmat3(m: DMat3) -> Self {
                $mat_from(m)
            }
            #[inline]
            fn transform(&self, v: $vec) -> $vec {
                self.x_axis * v.x + self.y_axis * v.y + self.z_axis * v.z
            }
            #[inline]
            fn transform_transposed(&self, v: $vec) -> $vec {
                <$vec>::new(
                    Vector::dot(self.x_axis, v),
                    Vector::dot(self.y_axis, v),
                    Vector::dot(self.z_axis, v),
                )
            }
        }
    };
}

implement!(f32, Vec3, Mat3, |v: DVec3| v.as_vec3(), |v: Vec3| v.as_dvec3(), |m: DMat3| m.as_mat3());
implement!(f64, DVec3, DMat3, |v| v, |v| v, |m| m);
