//! What a point, a box, a sphere, any shape or a frustum holds or touches.

use super::{Queries, QueryError, QueryFilter, check_finite, order};
use dcd_exec::{Exec, Segments};
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Pose, PoseError, Shape, ShapeError};
use dcd_gjk::{PosedShape, Reason, Verdict, certified, mesh::Scratch};
use dcd_simd::PlaneSet;
use std::cell::OnceCell;
use std::fmt;

/// How many points a task looks up: some tens of microseconds.
const POINTS_PER_TASK: usize = 32;

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
        self.list_touching(region, filter, found);
    }

    /// Appends them.
    fn list_touching(
        &self,
        region: PosedShape<'_>,
        filter: &QueryFilter<'_>,
        found: &mut Vec<Found>,
    ) {
        let mut scratch = Scratch::default();
        self.list_by(&region.shape.aabb(region.pose), filter, found, |posed| {
            certified::overlap_with(region, posed, &mut scratch).0
        });
    }

    /// Appends those whose boxes meet one and that are not proved to be apart from the region, in ascending order.
    fn list_by(
        &self,
        aabb: &Aabb,
        filter: &QueryFilter<'_>,
        found: &mut Vec<Found>,
        mut overlap: impl FnMut(PosedShape<'_>) -> Verdict<()>,
    ) {
        let first = found.len();
        self.visit(aabb, 0.0, &mut |object, _| {
            if filter.sees(self.scene, object) {
                let verdict = overlap(PosedShape::of(self.scene, object));
                if verdict != Verdict::Apart {
                    found.push(Found { object, is_certain: verdict == Verdict::Touching(()) });
                }
            }
            0.0
        });
        found[first..].sort_unstable_by_key(|found| found.object);
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
        let region = BoxRegion::of([min, max])?;
        let mut scratch = Scratch::default();
        found.clear();
        self.list_by(&region.aabb(), filter, found, |posed| region.overlap(posed, &mut scratch));
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
        // All of them share it.
        let Ok(shape) = &Shape::sphere(0.0) else { return Ok(()) };
        let order = (points.len(), order::of_points(points, self.aabbs));
        order::list_each((exec.into(), POINTS_PER_TASK), order, found, |k, found| {
            // Checked above.
            if let Ok(pose) = &Pose::from_translation(points[k]) {
                self.list_touching(PosedShape { shape, pose }, filter, found);
            }
        });
        Ok(())
    }
}

/// A box, and two cuboids which are it but for rounding: making a hull of its corners takes longer than most queries.
struct BoxRegion {
    /// Holds it.
    outer: Shape,
    /// Is inside of it.
    inner: Shape,
    /// Of both.
    pose: Pose,
    corners: [DVec3; 2],
    /// The box itself, once that is needed.
    exact: OnceCell<Option<Shape>>,
}

impl BoxRegion {
    /// By its corners, in any order, which are in range.
    fn of([one, other]: [DVec3; 2]) -> Result<Self, RegionError> {
        let (low, high) = (one.min(other), one.max(other));
        let centre = (low + (high - low) * 0.5).clamp(low, high);
        let [below, above] = [centre - low, high - centre];
        // Each difference may be rounded either way.
        let most = below.max(above).to_array().map(f64::next_up);
        let least = below.min(above).to_array().map(|half| half.next_down().max(0.0));
        Ok(Self {
            outer: Shape::cuboid(DVec3::from_array(most))?,
            inner: Shape::cuboid(DVec3::from_array(least))?,
            pose: Pose::from_translation(centre)?,
            corners: [low, high],
            exact: OnceCell::new(),
        })
    }

    fn aabb(&self) -> Aabb {
        self.outer.aabb(&self.pose)
    }

    fn overlap(&self, other: PosedShape<'_>, scratch: &mut Scratch) -> Verdict<()> {
        let pose = &self.pose;
        let mut with =
            |shape| certified::overlap_with(PosedShape { shape, pose }, other, scratch).0;
        if with(&self.inner) == Verdict::Touching(()) {
            return Verdict::Touching(());
        }
        if with(&self.outer) == Verdict::Apart {
            return Verdict::Apart;
        }
        match self.exact() {
            Some(shape) => {
                let exact = PosedShape { shape, pose: &Pose::IDENTITY };
                certified::overlap_with(exact, other, scratch).0
            }
            None => Verdict::Undecided(Reason::Range),
        }
    }

    /// The hull of its corners.
    fn exact(&self) -> Option<&Shape> {
        let made = self.exact.get_or_init(|| {
            let [low, high] = self.corners;
            let pick = |k: usize, axis: usize| [low, high][k >> axis & 1][axis];
            let corner = |k: usize| DVec3::new(pick(k, 0), pick(k, 1), pick(k, 2));
            Shape::hull((0..8).map(corner).collect()).ok()
        });
        made.as_ref()
    }
}
