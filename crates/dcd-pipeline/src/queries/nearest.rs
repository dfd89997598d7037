//! The object nearest to a point.

use super::{Queries, QueryError, QueryFilter, Search, check_finite, check_length, order};
use dcd_exec::Exec;
use dcd_geom::glam::DVec3;
use dcd_gjk::PosedShape;
use dcd_gjk::query::point::{PointDistance, nearest_point};
use dcd_simd::PointDistance as BoxDistance;

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

/// What is known of the object nearest to a point.
struct NearestSearch<'a> {
    queries: &'a Queries<'a>,
    point: DVec3,
    test: &'a BoxDistance,
    filter: &'a QueryFilter<'a>,
    nearest: Option<NearestObject>,
    /// Proved: nothing is nearer, of what has been measured.
    lower: f64,
    /// What is farther is not the nearest, metres.
    end: f64,
}

impl Search for NearestSearch<'_> {
    /// Measures an object. Returns whether it holds the point.
    fn meet(&mut self, object: u32) -> bool {
        let scene = self.queries.scene;
        if !self.filter.sees(scene, object) {
            return false;
        }
        let posed = PosedShape::of(scene, object);
        let Some(found) = nearest_point(self.point, posed, self.end) else { return false };
        let PointDistance { distance, lower, upper, nearest: point } = found;
        let is_first = self.nearest.is_none_or(|known| {
            distance.total_cmp(&known.distance).then(object.cmp(&known.object)).is_lt()
        });
        if is_first {
            self.nearest = Some(NearestObject { object, distance, lower, upper, point });
        }
        self.lower = self.lower.min(lower);
        self.end = self.end.min(upper);
        distance == 0.0
    }

    fn limit(&self) -> f32 {
        self.test.key_of(self.end)
    }
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
        let (test, end) = (&BoxDistance::new(point), max_distance);
        let (nearest, lower) = (None, f64::INFINITY);
        let mut search = NearestSearch { queries: self, point, test, filter, nearest, lower, end };
        self.meet_nearest(test, &mut search);
        let NearestSearch { nearest, lower, .. } = search;
        let nearest = nearest.map(|found| NearestObject { lower, ..found });
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
        let order = (points.len(), order::of_points(points, self.aabbs));
        order::answer_each((exec.into(), POINTS_PER_TASK), order, nearest, |k| {
            // Checked above.
            self.nearest(points[k], max_distance, filter).unwrap_or_default()
        });
        Ok(())
    }
}
