//! What a sensor has seen: many points with radii, or the boxes of an occupancy grid.

use crate::RobotError;
use dcd_geom::{Aabb, Pose, PoseError, Shape, ShapeError};
use dcd_simd::WIDTH;
use glam::{DVec3, Vec3};
use std::ops::Range;

/// A point that a sensor has seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensedPoint {
    /// In the world, metres.
    pub centre: DVec3,
    /// How far round it something may be, metres.
    pub radius: f64,
}

/// Points with radii, or boxes of one size along the world's axes, in a uniform grid: made in time linear in their
/// number. [`StateChecker::sensed_hits`](crate::StateChecker::sensed_hits) checks against them.
///
/// ```
/// use dcd_robot::{SensedPoint, SensedWorld};
/// use dcd_geom::glam::DVec3;
/// let seen = SensedPoint { centre: DVec3::new(0.4, 0.0, 0.2), radius: 0.005 };
/// assert_eq!(SensedWorld::of_points(&[seen])?.len(), 1);
/// let bad = SensedPoint { radius: -1.0, ..seen };
/// let error = SensedWorld::of_points(&[seen, bad]).unwrap_err().to_string();
/// assert_eq!(error, "point 1: the radius is -1e0");
/// # Ok::<(), dcd_robot::RobotError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct SensedWorld {
    /// As they were given.
    points: Vec<SensedPoint>,
    /// Half the edges of the box at each point, metres.
    half_extents: DVec3,
    /// In the order of the cells: x, y, z, radius, and the largest coordinate, radius and box together, each rounded,
    /// padded for the lanes past the last.
    rows: [Vec<f32>; 5],
    /// Of each in that order its index.
    indices: Vec<u32>,
    /// Of each cell, x first, where its points begin, and the end of the last.
    starts: Vec<u32>,
    cells: Cells,
    /// The largest of their radii, metres.
    largest: f64,
}

/// Where the cells are.
#[derive(Clone, Copy, Debug, Default)]
struct Cells {
    min: Vec3,
    /// The least coordinates of all, cells or not: what is below the cells is in the first ones.
    least: Vec3,
    /// Cells a metre.
    density: f32,
    counts: [usize; 3],
}

impl Cells {
    /// For so many points in that box: fewer than four cells a point, whether they fill it, lie in a plane or in a line.
    fn of([min, max]: [DVec3; 2], least: DVec3, count: usize) -> Self {
        let (extent, each) = (max - min, 2.0 / count.max(1) as f64);
        let [x, y, z] = extent.to_array();
        let edge = libm::cbrt(x * y * z * each)
            .max((each * (x * y).max(y * z).max(z * x)).sqrt())
            .max(extent.max_element() * each);
        let density = if edge > 0.0 { (1.0 / edge) as f32 } else { 0.0 };
        let density = if density.is_finite() { density } else { 0.0 };
        let (min, least) = (min.as_vec3(), least.as_vec3());
        let mut cells = Self { min, least, density, counts: [1; 3] };
        let counts = (0..3).map(|axis| cells.place(axis, max.as_vec3()[axis], usize::MAX) + 1);
        let counts: Vec<usize> = counts.collect();
        // What the rounding of far points spreads out is one cell.
        if counts.iter().fold(1usize, |all, &n| all.saturating_mul(n)) <= 8 * count + 64 {
            cells.counts = [counts[0], counts[1], counts[2]];
        }
        cells
    }

    /// The cell of a coordinate, below `count`: never less for a larger one.
    fn place(&self, axis: usize, x: f32, count: usize) -> usize {
        // A cast saturates, and makes 0 of NaN.
        (((x - self.min[axis]) * self.density) as usize).min(count - 1)
    }

    fn of_point(&self, point: Vec3) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| self.place(axis, point[axis], self.counts[axis]));
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    fn all(&self) -> usize {
        self.counts.iter().product()
    }
}

impl SensedWorld {
    /// Of points with radii.
    ///
    /// # Errors
    /// A coordinate or a radius that is no number, a radius below 0, a point that reaches beyond
    /// [`Aabb::LIMIT`]: by the point's index. More than 2³² − 1 points.
    pub fn of_points(points: &[SensedPoint]) -> Result<Self, RobotError> {
        let mut world = Self::default();
        world.replace_points(points)?;
        Ok(world)
    }

    /// Of boxes of one size, edges along the world's axes: half their edges, and their middles, metres.
    ///
    /// # Errors
    /// Those of [`SensedWorld::of_points`]; half an edge that is no number or below 0.
    pub fn of_boxes(half_extents: DVec3, centres: &[DVec3]) -> Result<Self, RobotError> {
        let mut world = Self::default();
        world.replace_boxes(half_extents, centres)?;
        Ok(world)
    }

    /// Takes other points in place of all that there are. Memory is kept.
    ///
    /// # Errors
    /// Those of [`SensedWorld::of_points`]; nothing is changed then.
    pub fn replace_points(&mut self, points: &[SensedPoint]) -> Result<(), RobotError> {
        self.replace(DVec3::ZERO, points.iter().copied())
    }

    /// Takes other boxes in place of all that there is. Memory is kept.
    ///
    /// # Errors
    /// Those of [`SensedWorld::of_boxes`]; nothing is changed then.
    pub fn replace_boxes(
        &mut self,
        half_extents: DVec3,
        centres: &[DVec3],
    ) -> Result<(), RobotError> {
        for value in half_extents.to_array() {
            if !(value >= 0.0 && value.is_finite()) {
                let (what, user) = ("half extent", "boxes".to_owned());
                return Err(RobotError::BadNumber { what, user, value });
            }
        }
        self.replace(
            half_extents,
            centres.iter().map(|&centre| SensedPoint { centre, radius: 0.0 }),
        )
    }

    /// Removes what has one of these indices; the others move up, in their order.
    pub fn remove(&mut self, indices: &[u32]) {
        let mut is_kept = vec![true; self.points.len()];
        for &index in indices {
            if let Some(kept) = is_kept.get_mut(index as usize) {
                *kept = false;
            }
        }
        let kept = self.points.iter().zip(&is_kept).filter(|(_, kept)| **kept);
        self.points = kept.map(|(point, _)| *point).collect();
        self.sort();
    }

    /// How many points or boxes there are.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// As they were given; of boxes their middles, with a radius of 0.
    pub fn points(&self) -> &[SensedPoint] {
        &self.points
    }

    /// Half the edges of the box at each point, metres.
    pub fn half_extents(&self) -> DVec3 {
        self.half_extents
    }

    /// What is seen there, as a shape at a pose, larger by so much, metres.
    ///
    /// # Errors
    /// None that was not refused before.
    pub(crate) fn shape(&self, index: usize, grown: f64) -> Result<(Shape, Pose), SensedError> {
        let SensedPoint { centre, radius } = self.points[index];
        let core = if self.half_extents == DVec3::ZERO {
            Shape::sphere(0.0)?
        } else {
            Shape::cuboid(self.half_extents)?
        };
        let radius = if grown == 0.0 { radius } else { (radius + grown).next_up() };
        Ok((core.rounded(radius)?, Pose::from_translation(centre)?))
    }

    fn replace(
        &mut self,
        half_extents: DVec3,
        points: impl Iterator<Item = SensedPoint> + Clone,
    ) -> Result<(), RobotError> {
        let mut count = 0;
        for (index, SensedPoint { centre, radius }) in points.clone().enumerate() {
            count = index + 1;
            let reach = centre.abs().max_element() + half_extents.max_element() + radius;
            // Written so that a NaN, which a maximum may drop, is refused.
            let is_known = centre.is_finite() && radius >= 0.0 && reach <= Aabb::LIMIT;
            if !is_known {
                let numbers = [("x", centre.x), ("y", centre.y), ("z", centre.z)];
                let bad = numbers.into_iter().find(|(_, x)| !(x.abs() <= Aabb::LIMIT));
                let (what, value) = match bad {
                    Some(bad) => bad,
                    None if (0.0..=Aabb::LIMIT).contains(&radius) => ("reach", reach),
                    None => ("radius", radius),
                };
                let user = format!("point {index}");
                return Err(RobotError::BadNumber { what, user, value });
            }
        }
        if u32::try_from(count).is_err() {
            return Err(RobotError::TooLarge { what: "sensed points", limit: u32::MAX as usize });
        }
        self.half_extents = half_extents;
        self.points.clear();
        self.points.extend(points);
        self.sort();
        Ok(())
    }

    /// Sorts the points into cells, by counting.
    fn sort(&mut self) {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0f64);
        let (min, max, largest) = self.points.iter().fold(none, |(min, max, largest), point| {
            (min.min(point.centre), max.max(point.centre), largest.max(point.radius))
        });
        let count = self.points.len();
        let is_some = count > 0;
        let (min, max) = if is_some { (min, max) } else { (DVec3::ZERO, DVec3::ZERO) };
        self.cells = Cells::of(usual_extent(&self.points, [min, max]), min, count);
        self.largest = largest;
        let box_size = self.half_extents.element_sum();
        let cells = self.cells;
        self.starts.clear();
        self.starts.resize(cells.all() + 1, 0);
        let cell_of = |point: &SensedPoint| cells.of_point(point.centre.as_vec3());
        for point in &self.points {
            self.starts[cell_of(point) + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        for row in &mut self.rows {
            row.clear();
            row.resize(count + WIDTH, 0.0);
        }
        self.indices.clear();
        self.indices.resize(count, 0);
        // Filled from each cell's start on, which so becomes the next one's; then moved back.
        for (index, point) in (0..).zip(&self.points) {
            let next = &mut self.starts[cell_of(point)];
            let at = *next as usize;
            *next += 1;
            let [x, y, z] = point.centre.as_vec3().to_array();
            let size = point.centre.abs().max_element() + point.radius + box_size;
            let numbers = [x, y, z, point.radius as f32, size as f32];
            for (row, number) in self.rows.iter_mut().zip(numbers) {
                row[at] = number;
            }
            self.indices[at] = index;
        }
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    /// How far any point's radius and box reach, metres.
    pub(crate) fn largest_reach(&self) -> f64 {
        self.largest + self.half_extents.max_element()
    }

    /// The index of what is at a place in the order of the cells.
    pub(crate) fn index(&self, place: usize) -> u32 {
        self.indices[place]
    }

    /// The rows of x, y, z, radius and size (the largest coordinate, radius and box together) in the order of the
    /// cells; sixteen more are there than points.
    pub(crate) fn rows(&self) -> [&[f32]; 5] {
        self.rows.each_ref().map(Vec::as_slice)
    }

    /// Ranges of places in the order of the cells that have every point within so much of another in each
    /// coordinate: as long as what is computed in f32 is within it.
    pub(crate) fn around(&self, centre: Vec3, reach: f32) -> impl Iterator<Item = Range<usize>> {
        let (min, max) = (centre - reach, centre + reach);
        // Of what is no number everything is near.
        let is_known = !(min.is_nan() || max.is_nan());
        let (min, max) = if is_known { (min, max) } else { (Vec3::NEG_INFINITY, Vec3::INFINITY) };
        let cells = self.cells;
        let span = |axis: usize| {
            let place = |x: f32| cells.place(axis, x, cells.counts[axis]);
            place(min[axis])..place(max[axis]) + 1
        };
        let is_outside = (0..3).any(|axis| max[axis] < cells.least[axis]);
        let [x, y, z] = [span(0), span(1), span(2)];
        let z = if is_outside { 0..0 } else { z };
        let rows = z.flat_map(move |z| y.clone().map(move |y| z * cells.counts[1] + y));
        rows.filter_map(move |row| {
            let first = row * cells.counts[0];
            let range = self.starts[first + x.start] as usize..self.starts[first + x.end] as usize;
            (!range.is_empty()).then_some(range)
        })
    }
}

/// Where most points are: a few far away, which all else would share a cell for, are left out of it. It depends on a
/// sample of the points; answers do not depend on it.
fn usual_extent(points: &[SensedPoint], [min, max]: [DVec3; 2]) -> [DVec3; 2] {
    /// How many points are looked at.
    const SAMPLE: usize = 256;
    /// One in so many of them may be beyond on each side.
    const BEYOND: usize = 64;
    let every = points.len().div_ceil(SAMPLE).max(1);
    let (mut low, mut high) = (min, max);
    for axis in 0..3 {
        let sample = points.iter().step_by(every).map(|point| point.centre[axis]);
        let mut sample: Vec<f64> = sample.collect();
        sample.sort_unstable_by(f64::total_cmp);
        let cut = sample.len().div_ceil(BEYOND);
        let Some(kept) = sample.get(cut..sample.len().saturating_sub(cut)) else { continue };
        if let (Some(first), Some(last)) = (kept.first(), kept.last()) {
            // Where points are spread evenly, all of them are in it.
            let about = 0.125 * (last - first);
            low[axis] = min[axis].max(first - about);
            high[axis] = max[axis].min(last + about);
        }
    }
    [low, high]
}

/// What is never met: all was refused before.
#[derive(Debug)]
pub(crate) enum SensedError {
    Shape(ShapeError),
    Pose(PoseError),
}

impl From<ShapeError> for SensedError {
    fn from(error: ShapeError) -> Self {
        Self::Shape(error)
    }
}

impl From<PoseError> for SensedError {
    fn from(error: PoseError) -> Self {
        Self::Pose(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a lattice of edge 1 round the origin.
    fn lattice() -> Vec<SensedPoint> {
        let at = |k: usize| (k % 12) as f64 / 11.0 - 0.5;
        let centres = (0..1728).map(|k| DVec3::new(at(k), at(k / 12), at(k / 144)));
        centres.map(|centre| SensedPoint { centre, radius: 0.0 }).collect()
    }

    /// How many points are looked at for what is within a tenth of a metre of the middle.
    fn looked_at(points: &[SensedPoint]) -> usize {
        let world = SensedWorld::of_points(points).unwrap();
        world.around(Vec3::ZERO, 0.1).map(|range| range.len()).sum()
    }

    #[test]
    fn points_far_away_do_not_widen_the_cells_of_the_others() {
        let mut points = lattice();
        let usual = looked_at(&points);
        assert!(usual < 200, "{usual}");
        for far in [DVec3::X * 1e6, DVec3::new(-1e5, 1e30, 3e4), DVec3::splat(-1e3)] {
            points.push(SensedPoint { centre: far, radius: 0.0 });
            assert!(looked_at(&points) <= 4 * usual, "{far}");
        }
    }

    #[test]
    fn a_point_far_away_is_found_where_it_is() {
        let mut points = lattice();
        for far in [DVec3::X * 1e6, DVec3::splat(-1e3), DVec3::Y * -7.0] {
            points.push(SensedPoint { centre: far, radius: 0.0 });
            let world = SensedWorld::of_points(&points).unwrap();
            let found = world.around(far.as_vec3(), 0.1).flatten();
            let mut found = found.map(|place| world.index(place) as usize);
            assert!(found.any(|index| index == points.len() - 1), "{far}");
        }
    }
}
