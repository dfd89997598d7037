//! What a point, a box, a sphere, any shape or a frustum holds or touches.

use super::{Queries, QueryError, QueryFilter, check_finite};
use dcd_exec::{Exec, Segments};
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Pose, PoseError, Shape, ShapeError};
use dcd_gjk::{PosedShape, Verdict, certified, mesh::Scratch};
use dcd_simd::PlaneSet;
use std::fmt;

/// An object in a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// Its index.
    pub object: u32,
    /// Whether it is proved to touch the region. If not, neither that nor the contrary is: only of foreign shapes,
    /// cylinders, cones and ellipsoids within the rounding of f64.
    pub is_certain: bool,
}

/// Why a region was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum RegionError {
    /// A length or a plane.
    Shape {
        /// Of which plane, else 0.
        index: usize,
        /// What is wrong.
        error: ShapeError,
    },
    /// A place.
    Pose(PoseError),
    /// A point.
    Query(QueryError),
}

impl fmt::Display for RegionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape { index, error } => write!(f, "region {index}: {error}"),
            Self::Pose(error) => error.fmt(f),
            Self::Query(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for RegionError {}

impl From<ShapeError> for RegionError {
    fn from(error: ShapeError) -> Self {
        Self::Shape { index: 0, error }
    }
}

impl From<PoseError> for RegionError {
    fn from(error: PoseError) -> Self {
        Self::Pose(error)
    }
}

impl From<QueryError> for RegionError {
    fn from(error: QueryError) -> Self {
        Self::Query(error)
    }
}

impl Queries<'_> {
    /// Replaces `found` by the objects that touch a shape, in ascending order.
    pub fn touching(
        &self,
        region: PosedShape<'_>,
        filter: &QueryFilter<'_>,
        found: &mut Vec<Found>,
    ) {
        found.clear();
        let mut scratch = Scratch::default();
        let aabb = region.shape.aabb(region.pose);
        self.visit(&aabb, 0.0, &mut |object, _| {
            if filter.sees(self.scene, object) {
                let posed = PosedShape::of(self.scene, object);
                let (verdict, _) = certified::overlap_with(region, posed, &mut scratch);
                if verdict != Verdict::Apart {
                    found.push(Found { object, is_certain: verdict == Verdict::Touching(()) });
                }
            }
            0.0
        });
        found.sort_unstable_by_key(|found| found.object);
    }

    /// Replaces `found` by the objects that contain a point, boundaries included, in ascending order.
    ///
    /// # Errors
    /// A coordinate that is not finite or beyond [`Aabb::LIMIT`].
    pub fn at_point(
        &self,
        point: DVec3,
        filter: &QueryFilter<'_>,
        found: &mut Vec<Found>,
    ) -> Result<(), RegionError> {
        self.in_sphere(point, 0.0, filter, found)
    }

    /// Replaces `found` by the objects that touch a sphere, metres, in ascending order.
    ///
    /// # Errors
    /// A centre out of range, a radius that is negative or not finite.
    pub fn in_sphere(
        &self,
        centre: DVec3,
        radius: f64,
        filter: &QueryFilter<'_>,
        found: &mut Vec<Found>,
    ) -> Result<(), RegionError> {
        check_finite("point", 0, centre)?;
        let (shape, pose) = (Shape::sphere(radius)?, Pose::from_translation(centre)?);
        self.touching(PosedShape { shape: &shape, pose: &pose }, filter, found);
        Ok(())
    }

    /// Replaces `found` by the objects that touch a box, by its corners, in ascending order. The objects themselves,
    /// not their boxes.
    ///
    /// # Errors
    /// A corner out of range.
    pub fn in_box(
        &self,
        [min, max]: [DVec3; 2],
        filter: &QueryFilter<'_>,
        found: &mut Vec<Found>,
    ) -> Result<(), RegionError> {
        check_finite("point", 0, min)?;
        check_finite("point", 1, max)?;
        let pick =
            |bit: usize, axis: usize| if bit >> axis & 1 == 0 { min[axis] } else { max[axis] };
        let corner = |k: usize| DVec3::new(pick(k, 0), pick(k, 1), pick(k, 2));
        let shape = Shape::hull((0..8).map(corner).collect())?;
        self.touching(PosedShape { shape: &shape, pose: &Pose::IDENTITY }, filter, found);
        Ok(())
    }

    /// Replaces `found` by the objects that touch each of some half-spaces n·x ≤ d, given by normals (outward, of any
    /// length) and offsets, in ascending order: a camera's frustum by its planes. An object that touches each and
    /// not what they have in common, beside an edge of the frustum, is among them; for an exact answer see
    /// [`Queries::touching`] with the hull of its corners.
    ///
    /// # Errors
    /// The first plane that is none: see [`dcd_geom::HalfSpace::new`].
    pub fn in_planes(
        &self,
        planes: &[(DVec3, f64)],
        filter: &QueryFilter<'_>,
        found: &mut Vec<Found>,
    ) -> Result<(), RegionError> {
        let shape = |(index, &(normal, offset)): (usize, &(DVec3, f64))| {
            Shape::half_space(normal, offset).map_err(|error| RegionError::Shape { index, error })
        };
        let shapes = planes.iter().enumerate().map(shape).collect::<Result<Vec<_>, _>>()?;
        // Of unit length, so that f32 holds them; what that loses is in the test's slack.
        let units: Vec<_> = planes.iter().map(|&(n, d)| (n / n.length(), d / n.length())).collect();
        let units: Vec<_> = units.into_iter().filter(|(_, d)| d.abs() <= Aabb::LIMIT).collect();
        found.clear();
        let mut scratch = Scratch::default();
        self.visit(&PlaneSet { planes: &units }, 0.0, &mut |object, _| {
            if filter.sees(self.scene, object) {
                let posed = PosedShape::of(self.scene, object);
                let mut is_certain = true;
                let is_out = shapes.iter().any(|shape| {
                    let plane = PosedShape { shape, pose: &Pose::IDENTITY };
                    let (verdict, _) = certified::overlap_with(plane, posed, &mut scratch);
                    is_certain &= verdict == Verdict::Touching(());
                    verdict == Verdict::Apart
                });
                if !is_out {
                    found.push(Found { object, is_certain });
                }
            }
            0.0
        });
        found.sort_unstable_by_key(|found| found.object);
        Ok(())
    }

    /// Replaces `found` by what contains each of some points, that of point k in segment k.
    ///
    /// # Errors
    /// The first point that is out of range; nothing is changed then.
    pub fn at_points<'e>(
        &self,
        points: &[DVec3],
        filter: &QueryFilter<'_>,
        exec: impl Into<Exec<'e>>,
        found: &mut Segments<Found>,
    ) -> Result<(), QueryError> {
        points.iter().enumerate().try_for_each(|(k, &point)| check_finite("point", k, point))?;
        found.fill(exec.into(), points.len(), |k, out| {
            let mut found = Vec::new();
            // Checked above.
            if self.at_point(points[k], filter, &mut found).is_ok() {
                out.append(&mut found);
            }
        });
        Ok(())
    }
}
