//! The shapes of a scene.

use crate::error::check_length;
use crate::{
    Aabb, Compound, Curved, Ellipsoid, HalfSpace, Mesh, Polytope, Pose, ShapeError, Sphere,
    Support, SupportMap,
};
use glam::{DVec3, Vec3};
use std::fmt;
use std::sync::Arc;

/// A shape in its own frame, checked when it is made: convex, or made of convex parts.
///
/// ```
/// use dcd_geom::glam::DVec3;
/// use dcd_geom::{Pose, Shape};
/// let can = Shape::cylinder(0.06, 0.033)?; // half its height, its radius; it stands along z
/// let lid = Shape::hull(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z])?.rounded(0.01)?;
/// let above = Pose::from_translation(DVec3::Z * 0.06)?;
/// let both = Shape::compound(vec![(can, Pose::IDENTITY), (lid, above)])?;
/// assert!(!both.is_convex());
/// let error = Shape::sphere(-1.0).unwrap_err();
/// assert!(error.to_string().contains("-1"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
#[non_exhaustive]
pub enum Shape {
    /// A hull of points, rounded or not: what the lanes are for. Clones share it.
    Polytope(Arc<Polytope>),
    /// A cylinder or a cone, rounded or not: in the lanes by a hull inside it, where that leaves the
    /// answer open one support at a time in f64.
    Curved(Curved),
    /// An ellipsoid, rounded or not: in the lanes as cylinders and cones are.
    Ellipsoid(Ellipsoid),
    /// A half-space, rounded or not: closed forms alone.
    HalfSpace(HalfSpace),
    /// A foreign shape, one support at a time in f64.
    Custom(Arc<dyn SupportMap<f64>>),
    /// Convex parts, each with a place of its own.
    Compound(Arc<Compound>),
    /// A surface of triangles.
    Mesh(Arc<Mesh>),
}

impl Shape {
    /// The convex hull of points in the shape's own frame, metres: [`Polytope::hull`]. Points inside of it
    /// cost time; [`crate::ConvexHull`] drops them.
    ///
    /// # Errors
    /// Those of [`Polytope::hull`].
    pub fn hull(vertices: Vec<DVec3>) -> Result<Self, ShapeError> {
        Polytope::hull(vertices).map(Self::from)
    }

    /// A sphere round the origin, metres: [`Polytope::sphere`].
    ///
    /// # Errors
    /// Those of [`Polytope::sphere`].
    pub fn sphere(radius: f64) -> Result<Self, ShapeError> {
        Polytope::sphere(radius).map(Self::from)
    }

    /// A cuboid round the origin, edges along the axes, by half its edges, metres: [`Polytope::cuboid`].
    ///
    /// # Errors
    /// Those of [`Polytope::cuboid`].
    pub fn cuboid(half_extents: DVec3) -> Result<Self, ShapeError> {
        Polytope::cuboid(half_extents).map(Self::from)
    }

    /// A capsule along the z axis, its middle at the origin, metres; `half_height` is to the centre of
    /// an end's sphere, so that it reaches to ±(`half_height` + `radius`): [`Polytope::capsule`].
    ///
    /// # Errors
    /// Those of [`Polytope::capsule`].
    pub fn capsule(half_height: f64, radius: f64) -> Result<Self, ShapeError> {
        Polytope::capsule(half_height, radius).map(Self::from)
    }

    /// The segment between two points, metres: [`Polytope::segment`]. With a radius, a capsule anywhere.
    ///
    /// # Errors
    /// Those of [`Polytope::segment`].
    pub fn segment(from: DVec3, to: DVec3) -> Result<Self, ShapeError> {
        Polytope::segment(from, to).map(Self::from)
    }

    /// The triangle between three points, both sides of it, metres: [`Polytope::triangle`].
    ///
    /// # Errors
    /// Those of [`Polytope::triangle`].
    pub fn triangle(corners: [DVec3; 3]) -> Result<Self, ShapeError> {
        Polytope::triangle(corners).map(Self::from)
    }

    /// A cylinder along the z axis, its middle at the origin, metres: [`Curved::cylinder`].
    ///
    /// # Errors
    /// Those of [`Curved::cylinder`].
    pub fn cylinder(half_height: f64, radius: f64) -> Result<Self, ShapeError> {
        Curved::cylinder(half_height, radius).map(Self::Curved)
    }

    /// A cone along the z axis, its apex at z = `half_height`, its base at z = −`half_height`, metres:
    /// [`Curved::cone`].
    ///
    /// # Errors
    /// Those of [`Curved::cone`].
    pub fn cone(half_height: f64, radius: f64) -> Result<Self, ShapeError> {
        Curved::cone(half_height, radius).map(Self::Curved)
    }

    /// An ellipsoid round the origin by half its axes, which are those of its frame, metres: [`Ellipsoid::new`].
    ///
    /// # Errors
    /// Those of [`Ellipsoid::new`].
    pub fn ellipsoid(half_axes: DVec3) -> Result<Self, ShapeError> {
        Ellipsoid::new(half_axes).map(Self::Ellipsoid)
    }

    /// All points x with `normal`·x ≤ `offset` (metres times the normal's length; it need not be of
    /// length 1): [`HalfSpace::new`]. The ground below z = 0 has the normal z and the offset 0.
    ///
    /// # Errors
    /// Those of [`HalfSpace::new`].
    pub fn half_space(normal: DVec3, offset: f64) -> Result<Self, ShapeError> {
        HalfSpace::new(normal, offset).map(Self::HalfSpace)
    }

    /// The same core with a sphere of this radius swept round it, metres; replaces any other radius,
    /// a sphere's and a capsule's own among them.
    ///
    /// # Errors
    /// A radius that is negative or not finite.
    pub fn rounded(self, radius: f64) -> Result<Self, ShapeError> {
        match self {
            Self::Polytope(polytope) => {
                Arc::unwrap_or_clone(polytope).rounded(radius).map(Self::from)
            }
            Self::Curved(curved) => curved.rounded(radius).map(Self::Curved),
            Self::Ellipsoid(ellipsoid) => ellipsoid.rounded(radius).map(Self::Ellipsoid),
            Self::HalfSpace(half_space) => half_space.rounded(radius).map(Self::HalfSpace),
            Self::Custom(map) => {
                check_length("radius", radius)?;
                Ok(Self::Custom(Arc::new(Rounded { map, radius })))
            }
            Self::Compound(parts) => parts.rounded(radius).map(Self::from),
            Self::Mesh(mesh) => Arc::unwrap_or_clone(mesh).rounded(radius).map(Self::from),
        }
    }

    /// Shapes, each at a pose in the compound's own frame: [`Compound::new`].
    ///
    /// # Errors
    /// Those of [`Compound::new`].
    pub fn compound(parts: Vec<(Self, Pose)>) -> Result<Self, ShapeError> {
        Compound::new(parts).map(|compound| Self::Compound(Arc::new(compound)))
    }

    /// A surface of triangles, both sides of them, by vertices in metres and three indices a triangle:
    /// [`Mesh::new`]. It has no inside: a shape that floats within touches nothing.
    ///
    /// # Errors
    /// Those of [`Mesh::new`].
    pub fn mesh(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self, ShapeError> {
        Mesh::new(vertices, triangles).map(|mesh| Self::Mesh(Arc::new(mesh)))
    }

    /// [`Shape::hull`] of points in f32, which f64 holds without loss.
    ///
    /// # Errors
    /// Those of [`Polytope::hull`].
    pub fn hull_from_f32(vertices: &[Vec3]) -> Result<Self, ShapeError> {
        Self::hull(vertices.iter().map(|v| v.as_dvec3()).collect())
    }

    /// [`Shape::mesh`] of vertices in f32, which f64 holds without loss.
    ///
    /// # Errors
    /// Those of [`Mesh::new`].
    pub fn mesh_from_f32(vertices: &[Vec3], triangles: Vec<[u32; 3]>) -> Result<Self, ShapeError> {
        Self::mesh(vertices.iter().map(|v| v.as_dvec3()).collect(), triangles)
    }

    /// A shape known by its support map alone.
    ///
    /// # Errors
    /// A radius, support error or support point that is not finite, along the six axes.
    pub fn custom(map: Arc<dyn SupportMap<f64>>) -> Result<Self, ShapeError> {
        for (what, value) in [("radius", map.radius()), ("support error", map.support_error())] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(ShapeError::BadLength { what, value });
            }
        }
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|d| [d, -d]);
        for (vertex, point) in axes.map(|d| map.support(d).point).enumerate() {
            if let Some(&value) = point.to_array().iter().find(|x| !x.is_finite()) {
                return Err(ShapeError::NotFinite { vertex, value });
            }
        }
        Ok(Self::Custom(map))
    }

    /// Whether it is one convex shape, and no compound or mesh.
    pub fn is_convex(&self) -> bool {
        !matches!(self, Self::Compound(_) | Self::Mesh(_))
    }

    /// The polytope, if it is one.
    pub fn as_polytope(&self) -> Option<&Polytope> {
        match self {
            Self::Polytope(polytope) => Some(polytope),
            _ => None,
        }
    }

    /// Whether it has an end in every direction: all but half-spaces.
    pub fn is_bounded(&self) -> bool {
        !matches!(self, Self::HalfSpace(_))
    }

    /// Whether the centre of [`Shape::inner`] is a point of the core, to within 2.02·2⁻⁵³ of
    /// [`Shape::reach`]: of all but compounds, meshes, half-spaces and foreign maps.
    pub fn centre_is_inside(&self) -> bool {
        matches!(self, Self::Polytope(_) | Self::Curved(_) | Self::Ellipsoid(_))
    }

    /// A sphere inside the core; of radius 0 where none is known. Its centre is then inside if
    /// [`Shape::centre_is_inside`] says so.
    pub fn inner(&self) -> Sphere {
        match self {
            Self::Polytope(polytope) => polytope.inner(),
            Self::Curved(curved) => curved.inner(),
            Self::Ellipsoid(ellipsoid) => ellipsoid.inner(),
            _ => Sphere { centre: DVec3::ZERO, radius: 0.0 },
        }
    }

    /// A bound on how far any point of the shape is from the origin of its own frame, metres;
    /// infinite for a half-space.
    pub fn reach(&self) -> f64 {
        match self {
            Self::Polytope(polytope) => polytope.reach() + polytope.swept_radius(),
            Self::Curved(curved) => curved.reach() + curved.swept_radius(),
            Self::Ellipsoid(ellipsoid) => ellipsoid.reach() + ellipsoid.swept_radius(),
            Self::HalfSpace(_) => f64::INFINITY,
            Self::Compound(compound) => compound.reach(),
            Self::Mesh(mesh) => mesh.reach() + mesh.swept_radius(),
            Self::Custom(_) => {
                let (min, max) = self.extent(&Pose::IDENTITY);
                min.abs().max(max.abs()).length()
            }
        }
    }

    /// The shape with a sphere of this radius swept round it, metres: what is within it of the
    /// shape. Added to a radius that the shape has, with one rounding.
    ///
    /// # Errors
    /// A radius that is negative or not finite, by itself or when added.
    pub fn swept(&self, radius: f64) -> Result<Self, ShapeError> {
        check_length("radius", radius)?;
        if let Self::Compound(compound) = self {
            return compound.swept(radius).map(Self::from);
        }
        self.clone().rounded(self.radius() + radius)
    }

    /// An AABB round the shape at this pose, rounded outward: the scalar reference of what a narrow phase
    /// computes in lanes. For a half-space see [`HalfSpace::aabb`].
    pub fn aabb(&self, pose: &Pose) -> Aabb {
        if let Self::HalfSpace(half_space) = self {
            return half_space.aabb(pose);
        }
        let (min, max) = self.extent(pose);
        // Rotating loses at most 3u of the reach a component, adding the translation one u more
        // of what comes out; 8u covers the row norm's excess over 1.
        let u = f64::EPSILON / 2.0;
        let size = min.abs().max(max.abs());
        let t = pose.translation();
        let slack = (size + size.max_element()) * (8.0 * u) + (size + t.abs()) * (2.0 * u);
        Aabb::outward(min + t - slack, max + t + slack)
    }

    /// The smallest and largest coordinates of R·shape, rounded, without the translation.
    fn extent(&self, pose: &Pose) -> (DVec3, DVec3) {
        let rotation = pose.rotation();
        let around = |points: &[DVec3], radius: f64| {
            let mut min = DVec3::INFINITY;
            let mut max = DVec3::NEG_INFINITY;
            for &v in points {
                let world = *rotation * v;
                min = min.min(world);
                max = max.max(world);
            }
            (min - radius, max + radius)
        };
        match self {
            Self::Polytope(polytope) => around(polytope.vertices(), polytope.swept_radius()),
            Self::Mesh(mesh) => around(mesh.points(), mesh.swept_radius()),
            Self::Compound(compound) => {
                let extents = compound.parts().iter().map(|part| part.placed().extent(pose));
                extents.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), (min, max)| {
                    (low.min(min), high.max(max))
                })
            }
            Self::Curved(curved) => {
                let rows = rotation.transpose();
                let [x, y, z] = [rows.x_axis, rows.y_axis, rows.z_axis].map(|d| curved.extent(d));
                (DVec3::new(x.0, y.0, z.0), DVec3::new(x.1, y.1, z.1))
            }
            map => {
                let to_local = rotation.transpose();
                let along = |d: DVec3| {
                    let local = to_local * d;
                    let reach = local.dot(map.support(local).point);
                    reach + map.support_error() * local.abs().element_sum() + map.radius()
                };
                let max = DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z));
                let min = -DVec3::new(along(-DVec3::X), along(-DVec3::Y), along(-DVec3::Z));
                (min, max)
            }
        }
    }
}

/// A half-space has no support map, nor has what is not convex: their points are NaN, of which no
/// solver's comparison proves anything.
impl SupportMap<f64> for Shape {
    fn support(&self, direction: DVec3) -> Support<f64> {
        match self {
            Self::Polytope(polytope) => polytope.support(direction),
            Self::Curved(curved) => curved.support(direction),
            Self::Ellipsoid(ellipsoid) => ellipsoid.support(direction),
            Self::HalfSpace(_) => Support { point: DVec3::NAN, feature: 0 },
            Self::Custom(map) => map.support(direction),
            Self::Compound(_) | Self::Mesh(_) => Support { point: DVec3::NAN, feature: 0 },
        }
    }

    #[inline]
    fn radius(&self) -> f64 {
        match self {
            Self::Polytope(polytope) => polytope.swept_radius(),
            Self::Curved(curved) => curved.swept_radius(),
            Self::Ellipsoid(ellipsoid) => ellipsoid.swept_radius(),
            Self::HalfSpace(half_space) => half_space.swept_radius(),
            Self::Custom(map) => map.radius(),
            Self::Compound(_) => 0.0,
            Self::Mesh(mesh) => mesh.swept_radius(),
        }
    }

    fn support_error(&self) -> f64 {
        match self {
            Self::Polytope(_) | Self::HalfSpace(_) | Self::Compound(_) | Self::Mesh(_) => 0.0,
            Self::Curved(curved) => curved.support_error(),
            Self::Ellipsoid(ellipsoid) => ellipsoid.support_error(),
            Self::Custom(map) => map.support_error(),
        }
    }
}

/// A foreign map with another radius.
struct Rounded {
    map: Arc<dyn SupportMap<f64>>,
    radius: f64,
}

impl SupportMap<f64> for Rounded {
    fn support(&self, direction: DVec3) -> Support<f64> {
        self.map.support(direction)
    }
    fn radius(&self) -> f64 {
        self.radius
    }
    fn support_error(&self) -> f64 {
        self.map.support_error()
    }
}

impl From<Compound> for Shape {
    fn from(compound: Compound) -> Self {
        Self::Compound(Arc::new(compound))
    }
}

impl From<Mesh> for Shape {
    fn from(mesh: Mesh) -> Self {
        Self::Mesh(Arc::new(mesh))
    }
}

impl From<Polytope> for Shape {
    fn from(polytope: Polytope) -> Self {
        Self::Polytope(Arc::new(polytope))
    }
}

impl From<Curved> for Shape {
    fn from(curved: Curved) -> Self {
        Self::Curved(curved)
    }
}

impl From<Ellipsoid> for Shape {
    fn from(ellipsoid: Ellipsoid) -> Self {
        Self::Ellipsoid(ellipsoid)
    }
}

impl From<HalfSpace> for Shape {
    fn from(half_space: HalfSpace) -> Self {
        Self::HalfSpace(half_space)
    }
}

impl fmt::Debug for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Polytope(polytope) => polytope.fmt(f),
            Self::Curved(curved) => curved.fmt(f),
            Self::Ellipsoid(ellipsoid) => ellipsoid.fmt(f),
            Self::HalfSpace(half_space) => half_space.fmt(f),
            Self::Custom(_) => f.write_str("Custom(..)"),
            Self::Compound(compound) => compound.fmt(f),
            Self::Mesh(mesh) => mesh.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests;
