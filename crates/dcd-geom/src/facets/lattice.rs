//! The hull of points in triangles, on a lattice.
//!
//! The points are rounded once to a lattice of 2⁻³⁸ of their extent, which separates deviations from a line
//! or plane that are rounding from larger ones; on it every decision is exact.

use crate::hull::{ExactPoints, Triangle, surface};
use glam::DVec3;

type Point = [i128; 3];

/// The bits of a lattice coordinate. Differences have one more, a determinant three times that and
/// three for its sum: 3·40 + 3 = 123 of 127.
const BITS: i32 = 38;

/// How far points may be off a line or plane that the lattice's rounding may have brought off it,
/// units: √3 halves each of three or four points. Smaller: flat shapes with a rim of slivers.
const ROUNDED: f64 = 4.0;

/// What the points span.
pub(super) enum Hull {
    Solid(Vec<Triangle>),
    /// A plane with this unit normal.
    Flat {
        normal: DVec3,
    },
    Segment([u32; 2]),
    Point(u32),
}

/// The hull of at least one point; of none, an invalid index.
pub(super) fn hull(vertices: &[DVec3]) -> Hull {
    let points = on_lattice(vertices);
    let start = match Start::of(&points) {
        Start::Solid(start) => start,
        Start::Flat([p, q, r]) => {
            let [p, q, r] = [p, q, r].map(|k| points[k as usize]);
            let normal = cross(minus(q, p), minus(r, p)).map(|x| x as f64);
            return Hull::Flat { normal: DVec3::from_array(normal).normalize() };
        }
        Start::Segment(ends) => return Hull::Segment(ends),
        Start::Point(only) => return Hull::Point(only),
    };
    let whole = |p: &Point| DVec3::from_array(p.map(|x| x as f64));
    let exact = ExactPoints::in_range(points.iter().map(whole).collect());
    Hull::Solid(surface(&exact, start))
}

fn on_lattice(vertices: &[DVec3]) -> Vec<Point> {
    let low = vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    // Halved first: the difference of two numbers may overflow.
    let (middle, half) = (low * 0.5 + high * 0.5, (high * 0.5 - low * 0.5).max_element());
    let steps = f64::from(2).powi(BITS);
    let on_axis = |x: f64| if half > 0.0 { (x / half * steps).round() as i128 } else { 0 };
    vertices.iter().map(|&v| (v - middle).to_array().map(on_axis)).collect()
}

/// The initial simplex.
enum Start {
    Solid([u32; 4]),
    Flat([u32; 3]),
    Segment([u32; 2]),
    Point(u32),
}

impl Start {
    /// Points far apart: the farthest from the first, from their line, from their plane. What is
    /// off by no more than the lattice's rounding is on it.
    fn of(points: &[Point]) -> Self {
        let [Some(first), ..] = [points.first(), None] else { return Self::Point(0) };
        let indices = || 0..points.len() as u32;
        let at = |k: u32| minus(points[k as usize], *first);
        let square = |v: Point| v.iter().map(|&x| (x as f64) * (x as f64)).sum::<f64>();
        let farthest = |off: &dyn Fn(u32) -> f64| {
            indices().max_by(|&j, &k| off(j).total_cmp(&off(k)).then(k.cmp(&j)))
        };
        let Some(p) = farthest(&|k| square(at(k))).filter(|&k| at(k) != [0; 3]) else {
            return Self::Point(0);
        };
        // From an end, so that a segment's two are found.
        let at = |k: u32| minus(points[k as usize], points[p as usize]);
        let q = farthest(&|k| square(at(k))).unwrap_or(0);
        let off_line = |k: u32| cross(at(q), at(k));
        let length = |v: Point| square(v).sqrt();
        let is_off = |&k: &u32| length(off_line(k)) > ROUNDED * length(at(q));
        let Some(r) = farthest(&|k| square(off_line(k))).filter(is_off) else {
            return Self::Segment([p, q]);
        };
        let normal = off_line(r);
        let thin = ROUNDED * length(normal);
        let off_plane = |k: u32| dot(normal, at(k));
        let highest = indices().max_by_key(|&k| (off_plane(k).abs(), std::cmp::Reverse(k)));
        match highest.filter(|&k| off_plane(k).abs() as f64 > thin) {
            // The fourth below the first three.
            Some(s) if off_plane(s) < 0 => Self::Solid([p, q, r, s]),
            Some(s) => Self::Solid([p, r, q, s]),
            None => Self::Flat([p, q, r]),
        }
    }
}

fn minus(p: Point, q: Point) -> Point {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

fn cross(p: Point, q: Point) -> Point {
    let minor = |j: usize, k: usize| p[j] * q[k] - p[k] * q[j];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn dot(p: Point, q: Point) -> i128 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}
