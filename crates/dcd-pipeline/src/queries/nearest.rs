//! The object nearest to a point.

use super::{Queries, QueryError, QueryFilter, check_finite, check_length};
use dcd_exec::Exec;
use dcd_geom::glam::DVec3;
use dcd_geom::{Pose, Shape};
use dcd_gjk::distance::distance_at;
use dcd_gjk::{Accuracy, DistanceResult, PosedShape};
use dcd_simd::PointDistance;

/// How many points a task takes: some tens of microseconds.
const POINTS_PER_TASK: usize = 16;

/// The object nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestObject {
    /// Its index.
    pub object: u32,
    /// How far the point is from it, metres; 0 inside.
    pub distance: f64,
    /// Proved: no nearer.
    pub lower: f64,
    /// Proved: no farther; infinite where nothing is known.
    pub upper: f64,
    /// The point of the object, world frame. The point itself where it is inside.
    pub point: DVec3,
}

impl Queries<'_> {
    /// The object nearest to a point among those within `max_distance` metres, which may be infinite: the least
    /// distance, of equal ones the least object. No object is proved nearer than its `lower`.
    ///
    /// # Errors
    /// A point that is out of range, a distance that is NaN or below 0.
    pub fn nearest(
        &self,
        point: DVec3,
        max_distance: f64,
        filter: &QueryFilter<'_>,
    ) -> Result<Option<NearestObject>, QueryError> {
        check_finite("point", 0, point)?;
        if max_distance != f64::INFINITY {
            check_length("distance", max_distance)?;
        }
        let (Ok(ball), Ok(at)) = (Shape::sphere(0.0), Pose::from_translation(point)) else {
            return Ok(None);
        };
        let ball = PosedShape { shape: &ball, pose: &at };
        let test = PointDistance::new(point);
        let mut nearest: Option<NearestObject> = None;
        let mut end = max_distance;
        self.visit(&test, test.key_of(end), &mut |object, _| {
            if filter.sees(self.scene, object) {
                let posed = PosedShape::of(self.scene, object);
                let found = near(object, ball, posed, point);
                let is_first = nearest.is_none_or(|known| {
                    found
                        .distance
                        .total_cmp(&known.distance)
                        .then(object.cmp(&known.object))
                        .is_lt()
                });
                if found.lower <= end && is_first {
                    nearest = Some(found);
                }
                end = end.min(found.upper);
            }
            test.key_of(end)
        });
        Ok(nearest.filter(|found| found.lower <= max_distance))
    }

    /// Replaces `nearest` by the object nearest to each point, in the order of the points.
    ///
    /// # Errors
    /// Those of [`Queries::nearest`], with the point's index; nothing is changed then.
    pub fn nearest_of_each<'e>(
        &self,
        points: &[DVec3],
        max_distance: f64,
        filter: &QueryFilter<'_>,
        exec: impl Into<Exec<'e>>,
        nearest: &mut Vec<Option<NearestObject>>,
    ) -> Result<(), QueryError> {
        points.iter().enumerate().try_for_each(|(k, &point)| check_finite("point", k, point))?;
        if max_distance != f64::INFINITY {
            check_length("distance", max_distance)?;
        }
        nearest.clear();
        nearest.resize(points.len(), None);
        exec.into().divide(&mut nearest[..], POINTS_PER_TASK, |first, nearest| {
            for (nearest, &point) in nearest.iter_mut().zip(&points[first..]) {
                // Checked above.
                *nearest = self.nearest(point, max_distance, filter).unwrap_or_default();
            }
        });
        Ok(())
    }
}

/// What is known of one object.
fn near(object: u32, ball: PosedShape<'_>, posed: PosedShape<'_>, point: DVec3) -> NearestObject {
    let within = |distance: f64, lower: f64, upper: f64, point: DVec3| NearestObject {
        object,
        distance,
        lower,
        upper,
        point,
    };
    match distance_at(Accuracy::F64, ball, posed).0 {
        DistanceResult::Touching => within(0.0, 0.0, 0.0, point),
        DistanceResult::Apart(found) => {
            let upper = if found.is_saturated() { f64::INFINITY } else { found.upper() };
            within(found.distance, found.lower(), upper, found.point_b)
        }
        DistanceResult::Interval { within: found, .. } => {
            within(0.0, 0.0, found.upper(), found.point_b)
        }
        DistanceResult::Undecided(_) => within(0.0, 0.0, f64::INFINITY, point),
    }
}
