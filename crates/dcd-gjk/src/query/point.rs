//! How far a point is from a shape, and which point of it is nearest.
//!
//! A hull's spheres and face planes prove most of it: a point in the inner sphere is inside, the largest height above them is a lower bound, a point below all of them
//! is inside, and where the foot on the highest face is a point of the face, it is the nearest. What is nearest to an
//! edge or a corner goes the way of every distance ([`distance_at`]).

use super::local::{LocalPoint, ORTHONORMAL};
use crate::distance::distance_at;
use crate::{Accuracy, DistanceResult, PosedShape};
use dcd_geom::glam::DVec3;
use dcd_geom::{FacetPlanes, Polytope, Pose, Shape};
use dcd_simd::{Kernel, Lanes, WIDTH, dispatch};
use std::hint::select_unpredictable;

/// How far a point is from a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointDistance {
    /// Metres; 0 inside.
    pub distance: f64,
    /// Proved: no nearer.
    pub lower: f64,
    /// Proved: no farther; infinite where nothing is known.
    pub upper: f64,
    /// The point of the shape, world frame. The point itself where it is inside.
    pub nearest: DVec3,
}

impl PointDistance {
    /// Of a point of the shape.
    fn inside(point: DVec3) -> Self {
        Self { distance: 0.0, lower: 0.0, upper: 0.0, nearest: point }
    }
}

/// How far a point of the world is from a shape. `None` only where that is proved to be more than `limit`, metres,
/// which may be infinite.
///
/// ```
/// use dcd_geom::{Pose, Shape, glam::DVec3};
/// use dcd_gjk::PosedShape;
/// use dcd_gjk::query::point::nearest_point;
/// let (shape, pose) = (Shape::cuboid(DVec3::ONE)?, Pose::IDENTITY);
/// let posed = PosedShape { shape: &shape, pose: &pose };
/// let found = nearest_point(DVec3::X * 3.0, posed, f64::INFINITY).unwrap();
/// assert!(found.lower <= 2.0 && 2.0 <= found.upper && found.upper - found.lower < 1e-12);
/// assert_eq!(nearest_point(DVec3::X * 3.0, posed, 1.5), None);
/// # Ok::<(), dcd_geom::ShapeError>(())
/// ```
pub fn nearest_point(point: DVec3, posed: PosedShape<'_>, limit: f64) -> Option<PointDistance> {
    if let Shape::Polytope(polytope) = posed.shape
        && posed.pose.deviation() <= ORTHONORMAL
    {
        match by_planes(point, posed.pose, polytope, limit) {
            Outcome::Beyond => return None,
            Outcome::Known(found) => return Some(found),
            Outcome::Open => {}
        }
    }
    let (Ok(sphere), Ok(at)) = (Shape::sphere(0.0), Pose::from_translation(point)) else {
        // Of a point that is not finite nothing is known.
        return Some(PointDistance { upper: f64::INFINITY, ..PointDistance::inside(point) });
    };
    let sphere = PosedShape { shape: &sphere, pose: &at };
    let within = |distance: f64, lower: f64, upper: f64, nearest: DVec3| {
        (lower <= limit).then_some(PointDistance { distance, lower, upper, nearest })
    };
    match distance_at(Accuracy::F64, sphere, posed).0 {
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

/// Cores in a smaller sphere, metres, are searched: squares of lengths near them lose digits to underflow. Smaller: points that are
/// far off and called inside. Larger: more searches.
const SMALLEST: f64 = 1e-70;

/// Cores that are larger, or so far away, metres, are searched: squares of their lengths leave the range of f64. Larger: points that are
/// inside and called beyond.
const LARGEST: f64 = 1e150;

/// What planes know of a point.
enum Outcome {
    /// Proved: farther than the limit.
    Beyond,
    /// All of it.
    Known(PointDistance),
    /// Not enough.
    Open,
}

/// By the spheres round and inside of a polytope, then by the planes of its faces. Of a pose that keeps lengths to within what the
/// margin holds.
fn by_planes(point: DVec3, pose: &Pose, polytope: &Polytope, limit: f64) -> Outcome {
    let radius = polytope.swept_radius();
    if polytope.outer_radius() < SMALLEST {
        return Outcome::Open;
    }
    let LocalPoint { point: local, margin, .. } =
        LocalPoint::of(point, pose, polytope.reach() + radius);
    if !(local.abs().max_element() + polytope.reach() <= LARGEST) {
        return Outcome::Open;
    }
    let beyond = |least: f64| least - radius - margin > limit;
    let inner = polytope.inner();
    let from_centre = (local - inner.centre).length();
    if beyond(from_centre - polytope.outer_radius()) {
        return Outcome::Beyond;
    }
    if from_centre + margin <= inner.radius {
        return Outcome::Known(PointDistance::inside(point));
    }
    let planes = polytope.planes();
    if planes.is_empty() {
        return Outcome::Open;
    }
    let Heights { highest, face, is_below_inner } = Heights::of(local, planes, margin);
    if beyond(highest) {
        return Outcome::Beyond;
    }
    if !planes.has_inside() {
        return Outcome::Open;
    }
    if is_below_inner {
        return Outcome::Known(PointDistance::inside(point));
    }
    // The foot, moved in by what proves that it is a point of the core.
    let normal = planes.normal(face);
    let height = normal.dot(local) - planes.inner[face] + 4.0 * margin;
    let foot = local - normal * height;
    let (lower, upper) = (highest - radius - margin, height - radius + margin);
    if !(lower > 0.0) || !Heights::of(foot, planes, margin).is_below_inner {
        return Outcome::Open;
    }
    Outcome::Known(PointDistance {
        distance: 0.5 * (lower + upper),
        lower,
        upper,
        nearest: pose.apply(foot + normal * radius),
    })
}

/// A point above the planes of faces.
pub(crate) struct Heights {
    /// Above the outer planes the largest, rounded.
    pub(crate) highest: f64,
    /// Of which plane.
    pub(crate) face: usize,
    /// Whether the point is below every inner plane by more than the margin.
    pub(crate) is_below_inner: bool,
}

/// How many planes are compared at once.
const CHUNK: usize = WIDTH / 2;

impl Heights {
    pub(crate) fn of(point: DVec3, planes: &FacetPlanes, margin: f64) -> Self {
        dispatch(HeightsOf { point, planes, margin })
    }

    /// Takes in the plane of that number, by the point's height above the outer one and what the inner one leaves of the margin.
    #[inline(always)]
    fn take(&mut self, face: usize, [height, room]: [f64; 2]) {
        let is_higher = height > self.highest;
        self.highest = select_unpredictable(is_higher, height, self.highest);
        self.face = select_unpredictable(is_higher, face, self.face);
        self.is_below_inner &= room > 0.0;
    }
}

/// [`Heights`], eight planes at a time.
struct HeightsOf<'a> {
    point: DVec3,
    planes: &'a FacetPlanes,
    margin: f64,
}

impl Kernel for HeightsOf<'_> {
    type Output = Heights;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Heights {
        let Self { point, planes, margin } = self;
        let FacetPlanes { normals: [nx, ny, nz], outer, inner, .. } = planes;
        let mut found = Heights { highest: f64::NEG_INFINITY, face: 0, is_below_inner: true };
        let [x, y, z] = point.to_array().map(|x| l.splat_d(x));
        let lost = l.splat_d(margin);
        let eights = [nx, ny, nz, outer, inner].map(|numbers| numbers.as_chunks::<CHUNK>().0);
        let [of_x, of_y, of_z, of_outer, of_inner] = eights;
        for j in 0..of_outer.len() {
            let flat = l.add_d(l.mul_d(l.load_d(&of_x[j]), x), l.mul_d(l.load_d(&of_y[j]), y));
            let along = l.add_d(flat, l.mul_d(l.load_d(&of_z[j]), z));
            let (mut heights, mut rooms) = ([0.0; CHUNK], [0.0; CHUNK]);
            l.store_d(l.sub_d(along, l.load_d(&of_outer[j])), &mut heights);
            l.store_d(l.sub_d(l.sub_d(l.load_d(&of_inner[j]), lost), along), &mut rooms);
            for k in 0..CHUNK {
                found.take(CHUNK * j + k, [heights[k], rooms[k]]);
            }
        }
        for k in CHUNK * of_outer.len()..planes.len() {
            let along = nx[k] * point.x + ny[k] * point.y + nz[k] * point.z;
            found.take(k, [along - outer[k], inner[k] - margin - along]);
        }
        found
    }
}

#[cfg(test)]
mod tests;
