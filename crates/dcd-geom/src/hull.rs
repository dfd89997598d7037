//! The convex hull of a cloud of points, exactly.

mod orient;
mod quickhull;

pub(crate) use orient::ExactPoints;
pub(crate) use quickhull::{Triangle, surface};

use glam::DVec3;
use std::fmt;

/// What the points of a cloud span, exactly: a cloud whose rounding bends it is no plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// All points are at one place.
    Point,
    /// All are on one line.
    Line,
    /// All are in one plane.
    Plane,
    /// They have a volume.
    Solid,
}

/// The corners of a cloud's hull, and its surface where it has a volume.
///
/// A corner is a point of the cloud that is not in the hull of the others: the smallest set with the
/// same hull. Which points those are is decided exactly, without a tolerance, so that no point of
/// the cloud lies outside of any triangle's plane, by however little.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConvexHull {
    dimension: Dimension,
    corners: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

/// Why a cloud has no hull here.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum HullError {
    /// It has no point.
    Empty,
    /// A point holds NaN or infinity.
    NotFinite {
        /// Its index.
        index: usize,
        /// The first such number.
        value: f64,
    },
    /// It has more points than a u32 counts.
    TooMany {
        /// How many.
        count: usize,
    },
    /// From the highest bit of any coordinate to the lowest there are more than 688 binary places:
    /// numbers as far apart as 1 and 1e-191. Exact signs need three times as many.
    TooWide,
}

impl fmt::Display for HullError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the cloud has no point"),
            Self::NotFinite { index, value } => {
                write!(f, "point {index} holds {value}, not a finite number")
            }
            Self::TooMany { count } => write!(f, "{count} points are more than a u32 counts"),
            Self::TooWide => {
                write!(f, "the coordinates span more than 688 binary places, too many to be exact")
            }
        }
    }
}

impl std::error::Error for HullError {}

impl ConvexHull {
    /// The hull of any number of points, of any size that f64 holds, degenerate or not. The same for the same
    /// points everywhere. Costs some ten microseconds for a hundred points and grows little faster
    /// than their number; clouds made for it can take the square of it.
    ///
    /// # Errors
    /// No point, a number that is not finite, more points than a u32 counts, or coordinates that
    /// span more than 688 binary places.
    pub fn of(points: &[DVec3]) -> Result<Self, HullError> {
        check(points)?;
        let exact = ExactPoints::scaled(points).ok_or(HullError::TooWide)?;
        Ok(match Start::of(&exact) {
            Start::Point => Self::without_surface(Dimension::Point, vec![0]),
            Start::Line => Self::without_surface(Dimension::Line, ends(&exact)),
            Start::Plane(three) => Self::without_surface(Dimension::Plane, ring(&exact, three)),
            Start::Solid(four) => Self::solid(&exact, four),
        })
    }

    /// What the points span.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// The corners by index into the cloud, ascending; of equal points the first.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// The surface of a solid: closed, counter-clockwise seen from outside, by index into
    /// [`ConvexHull::corners`]. Empty for any other.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn without_surface(dimension: Dimension, mut corners: Vec<u32>) -> Self {
        corners.sort_unstable();
        Self { dimension, corners, triangles: Vec::new() }
    }

    fn solid(points: &ExactPoints, start: [u32; 4]) -> Self {
        let triangles = surface(points, start);
        let is_corner = quickhull::corners(points, &triangles);
        let corners: Vec<u32> =
            (0..points.len() as u32).filter(|&k| is_corner[k as usize]).collect();
        let on_surface = |k: &u32| is_corner[*k as usize];
        if !triangles.iter().flat_map(|triangle| &triangle.corners).all(on_surface) {
            // Some are in the middle of a face or edge. The hull of the corners alone has none.
            let Self { triangles, .. } = Self::of_corners(&points.only(&corners));
            return Self { dimension: Dimension::Solid, corners, triangles };
        }
        let mut number = vec![0; points.len()];
        for (new, &old) in (0..).zip(&corners) {
            number[old as usize] = new;
        }
        let renamed = |triangle: Triangle| triangle.corners.map(|k| number[k as usize]);
        let triangles = triangles.into_iter().map(renamed).collect();
        Self { dimension: Dimension::Solid, corners, triangles }
    }

    /// The hull of points that are all corners.
    fn of_corners(points: &ExactPoints) -> Self {
        let triangles = match Start::of(points) {
            Start::Solid(start) => surface(points, start),
            _ => Vec::new(),
        };
        let corners = (0..points.len() as u32).collect();
        let triangles = triangles.into_iter().map(|triangle| triangle.corners).collect();
        Self { dimension: Dimension::Solid, corners, triangles }
    }
}

fn check(points: &[DVec3]) -> Result<(), HullError> {
    if points.is_empty() {
        return Err(HullError::Empty);
    }
    // The last number stands for no point.
    if points.len() >= u32::MAX as usize {
        return Err(HullError::TooMany { count: points.len() });
    }
    for (index, point) in points.iter().enumerate() {
        if let Some(&value) = point.to_array().iter().find(|x| !x.is_finite()) {
            return Err(HullError::NotFinite { index, value });
        }
    }
    Ok(())
}

/// The initial simplex: what the points span, and points that span it.
enum Start {
    Point,
    Line,
    Plane([u32; 3]),
    Solid([u32; 4]),
}

impl Start {
    /// Points far apart: the farthest from an end, from their line, from their plane. Where rounding
    /// may have chosen badly, any that is not on the line or in the plane.
    fn of(points: &ExactPoints) -> Self {
        let indices = || 0..points.len() as u32;
        // Sums of absolute values, whose squares would leave the range.
        let size = |v: DVec3| v.abs().element_sum();
        let first = points.get(0);
        let p = farthest(points, |k| size(points.get(k) - first));
        let base = points.get(p);
        let q = farthest(points, |k| size(points.get(k) - base));
        if points.get(q) == base {
            return Self::Point;
        }
        let along = points.get(q) - base;
        let r = farthest(points, |k| size(along.cross(points.get(k) - base)));
        let is_off = |&k: &u32| !points.is_straight([p, q, k]);
        let Some(r) = Some(r).filter(is_off).or_else(|| indices().find(is_off)) else {
            return Self::Line;
        };
        let plane = points.plane([p, q, r]);
        let is_one = |k| k == p || k == q || k == r;
        let s = farthest(points, |k| if is_one(k) { 0.0 } else { points.height(k, &plane).abs() });
        match points.height(s, &plane) {
            0.0 => Self::Plane([p, q, r]),
            // The fourth below the first three.
            height if height < 0.0 => Self::Solid([p, q, r, s]),
            _ => Self::Solid([p, r, q, s]),
        }
    }
}

/// The first of the points that are farthest.
fn farthest(points: &ExactPoints, off: impl Fn(u32) -> f64) -> u32 {
    let off = (0..points.len() as u32).map(|k| (off(k), k));
    off.fold((0.0, 0), |best, next| if next.0 > best.0 { next } else { best }).1
}

/// The first and the last of points on a line.
fn ends(points: &ExactPoints) -> Vec<u32> {
    let at = |k: u32| points.get(k).to_array();
    let indices = 1..points.len() as u32;
    let first = indices.clone().fold(0, |best, k| if at(k) < at(best) { k } else { best });
    let last = indices.fold(0, |best, k| if at(k) > at(best) { k } else { best });
    vec![first, last]
}

/// The corners of points in a plane, of which three are not on a line: those of a pyramid over them,
/// but for its apex.
fn ring(points: &ExactPoints, [p, q, r]: [u32; 3]) -> Vec<u32> {
    let apex = points.len() as u32;
    let area = |axis: &usize| points.turn([p, q, r], *axis);
    let steepest = (0..3).max_by(|j, k| area(j).abs().total_cmp(&area(k).abs())).unwrap_or(0);
    // Along an axis that is not in the plane, so that the other coordinates stay as they are.
    let largest = (0..apex).fold(0.0f64, |most, k| most.max(points.get(k).abs().max_element()));
    let mut above = points.get(p);
    above[steepest] = if above[steepest] > 0.0 { -largest } else { largest };
    let pyramid = points.with(above);
    let start = match pyramid.height(apex, &pyramid.plane([p, q, r])) {
        height if height < 0.0 => [p, q, r, apex],
        _ => [p, r, q, apex],
    };
    let is_corner = quickhull::corners(&pyramid, &surface(&pyramid, start));
    (0..apex).filter(|&k| is_corner[k as usize]).collect()
}
