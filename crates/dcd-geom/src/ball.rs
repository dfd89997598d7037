//! Balls inside and around a point set, in microseconds a shape.

use crate::support::farthest;
use glam::DVec3;
use std::sync::OnceLock;

/// A ball in a shape's own frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its centre.
    pub centre: DVec3,
    /// Its radius, at least 0.
    pub radius: f64,
}

/// Unit roundoff of f64.
const U: f64 = f64::EPSILON / 2.0;

/// How often the centre is pushed away from the nearest face. No unit. Fewer: smaller inner
/// balls, so that more pairs need a solver. More: microseconds a shape.
const PUSHES: usize = 32;

/// Of what is left to gain, how much one push takes; the step shrinks by the same factor.
const PUSH_DECAY: f64 = 0.85;

impl Ball {
    /// A ball that lies inside the hull of `points`, as large as a few microseconds can find.
    ///
    /// Sound for any points: its radius is proved, with rounding, and is 0 where the hull is flat
    /// or nothing could be proved. The surface is not known, so one is made: the support points in
    /// the directions of a subdivided octahedron, connected as those are. That is a closed cycle
    /// for any map of directions to points; if every triangle sees the centre on its inner side,
    /// every point of an open ball that misses all triangles has the centre's winding number and
    /// is inside the hull (docs/numerics.md, "inner balls").
    pub fn inside(points: &[DVec3]) -> Self {
        for sphere in spheres() {
            if let Some(ball) = inside_of(points, sphere) {
                return ball;
            }
        }
        let weight = 1.0 / points.len().max(1) as f64;
        let centre = points.iter().fold(DVec3::ZERO, |sum, &p| sum + p * weight);
        Self { centre, radius: 0.0 }
    }

    /// The smallest ball round `centre` that holds all `points`, its radius rounded up.
    pub fn around(centre: DVec3, points: &[DVec3]) -> Self {
        Self { centre, radius: reach(points.iter().map(|&p| p - centre)) }
    }
}

/// The largest length of the vectors, rounded up; scaled, so that no square over- or underflows.
pub(crate) fn reach(vectors: impl Iterator<Item = DVec3> + Clone) -> f64 {
    let largest = vectors.clone().fold(0.0, |m: f64, v| m.max(v.abs().max_element()));
    if largest == 0.0 {
        return 0.0;
    }
    let longest = vectors.fold(0.0, |m: f64, v| m.max((v / largest).length_squared()));
    // Subtraction, division, three squares, two sums, root and product: 6u, and room.
    (longest.sqrt() * (1.0 + 8.0 * U) * largest).next_up()
}

/// Directions on the unit sphere, and how they are connected: outward triangles.
struct Sphere {
    directions: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

/// The octahedron subdivided twice, once and not at all: 66, 18 and 6 directions. The finer is
/// tried first (0.90, 0.75 and 0.59 of the true inner radius on average).
fn spheres() -> &'static [Sphere; 3] {
    static SPHERES: OnceLock<[Sphere; 3]> = OnceLock::new();
    SPHERES.get_or_init(|| {
        let octahedron = Sphere {
            directions: [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|d| [d, -d]).collect(),
            triangles: (0..8)
                .map(|octant: usize| {
                    let [x, y, z] = [0, 1, 2].map(|axis| 2 * axis + (octant >> axis & 1));
                    // An odd number of negated axes turns the triangle round.
                    if octant.count_ones().is_multiple_of(2) { [x, y, z] } else { [x, z, y] }
                })
                .collect(),
        };
        let middle = subdivided(&octahedron);
        [subdivided(&middle), middle, octahedron]
    })
}

fn subdivided(coarse: &Sphere) -> Sphere {
    let mut directions = coarse.directions.clone();
    let mut middles = Vec::new();
    let mut middle = |a: usize, b: usize| {
        let edge = (a.min(b), a.max(b));
        if let Some(&(_, known)) = middles.iter().find(|(e, _)| *e == edge) {
            return known;
        }
        directions.push((directions[a] + directions[b]).normalize());
        middles.push((edge, directions.len() - 1));
        directions.len() - 1
    };
    let triangles = coarse.triangles.iter().flat_map(|&[a, b, c]| {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
    });
    let triangles = triangles.collect();
    Sphere { directions, triangles }
}

/// A triangle of the made surface: a corner and its inward normal, of unit length but for
/// rounding.
struct Face {
    corners: [DVec3; 3],
    inward: DVec3,
}

impl Face {
    fn new(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = (c - a).cross(b - a);
        let length = normal.length();
        // False for NaN too, which an overflow makes.
        (length > 0.0 && length.is_finite()).then(|| Self { corners, inward: normal / length })
    }

    /// How far `p` is on the inner side, approximately.
    fn height(&self, p: DVec3) -> f64 {
        self.inward.dot(p - self.corners[0])
    }

    /// Whether det(a − p, b − p, c − p) is surely positive: p is on the inner side.
    fn surely_sees(&self, p: DVec3) -> bool {
        let [a, b, c] = self.corners.map(|corner| corner - p);
        let (m, n) = (b.abs(), c.abs());
        let minors =
            DVec3::new(m.y * n.z + m.z * n.y, m.z * n.x + m.x * n.z, m.x * n.y + m.y * n.x);
        // Three rounded differences and five operations a term: 8u of the permanent, doubled.
        a.dot(b.cross(c)) > 16.0 * U * a.abs().dot(minors) + f64::MIN_POSITIVE
    }

    /// A lower bound on the distance from `p` to the triangle, up to rounding.
    fn clearance(&self, p: DVec3) -> f64 {
        let along = self.corners.map(|corner| self.inward.dot(p - corner));
        along.into_iter().fold(f64::INFINITY, f64::min) / self.inward.length()
    }
}

fn inside_of(points: &[DVec3], sphere: &Sphere) -> Option<Ball> {
    let extreme: Vec<u32> = sphere
        .directions
        .iter()
        .map(|&d| farthest::<f64>(points.iter().copied(), d).feature)
        .collect();
    let mut faces = Vec::with_capacity(sphere.triangles.len());
    for triangle in &sphere.triangles {
        let [a, b, c] = triangle.map(|k| extreme[k]);
        // A triangle with a repeated corner is no part of the cycle.
        if a != b && b != c && c != a {
            faces.push(Face::new([a, b, c].map(|k| points[k as usize]))?);
        }
    }
    let centre = deepest(&faces)?;
    let radius = proved_radius(&faces, centre)?;
    Some(Ball { centre, radius })
}

/// A point far from all faces: from their mean, pushed away from the nearest one again and again,
/// by steps that shrink.
fn deepest(faces: &[Face]) -> Option<DVec3> {
    let weight = 1.0 / (3 * faces.len()).max(1) as f64;
    let mut centre =
        faces.iter().flat_map(|face| face.corners).fold(DVec3::ZERO, |sum, p| sum + p * weight);
    let nearest = |p: DVec3| {
        faces.iter().map(|face| (face.height(p), face.inward)).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (mut height, mut inward) = nearest(centre)?;
    let (mut best, mut best_height) = (centre, height);
    let mut step = 0.25 * height.abs();
    for _ in 0..PUSHES {
        centre += inward * step;
        (height, inward) = nearest(centre)?;
        if height > best_height {
            (best, best_height) = (centre, height);
        }
        step *= PUSH_DECAY;
    }
    Some(best)
}

/// The radius of a ball round `centre` that surely misses every face, if every face surely sees
/// the centre on its inner side.
fn proved_radius(faces: &[Face], centre: DVec3) -> Option<f64> {
    let mut clearance = f64::INFINITY;
    for face in faces {
        if !face.surely_sees(centre) {
            return None;
        }
        clearance = clearance.min(face.clearance(centre));
    }
    let size = reach(faces.iter().flat_map(|face| face.corners).map(|p| p - centre));
    let radius = clearance * (1.0 - 8.0 * U) - 5.0 * U * size * (1.0 + 8.0 * U);
    // False for NaN and for no face at all.
    (radius > 0.0 && radius.is_finite()).then_some(radius)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Vec<DVec3> {
        (0..8).map(|k| DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64)).collect()
    }

    #[test]
    fn the_spheres_are_closed_and_outward() {
        for (sphere, count) in spheres().iter().zip([66, 18, 6]) {
            assert_eq!(sphere.directions.len(), count);
            for &[a, b, c] in &sphere.triangles {
                let [pa, pb, pc] = [a, b, c].map(|k| sphere.directions[k]);
                assert!(pa.dot(pb.cross(pc)) > 0.0);
                for edge in [[b, a], [c, b], [a, c]] {
                    let across = |t: &&[usize; 3]| (0..3).any(|k| [t[k], t[(k + 1) % 3]] == edge);
                    assert_eq!(sphere.triangles.iter().filter(across).count(), 1);
                }
            }
        }
    }

    #[test]
    fn the_inner_ball_of_a_cube_is_inside_and_large() {
        let ball = Ball::inside(&cube());
        let walls = ball.centre.min(DVec3::ONE - ball.centre).min_element();
        assert!(ball.radius <= walls && ball.radius > 0.2, "{ball:?}");
    }

    #[test]
    fn the_inner_ball_of_an_octahedron_is_inside_and_large() {
        let points: Vec<DVec3> = spheres()[2].directions.clone();
        let ball = Ball::inside(&points);
        // |x| + |y| + |z| ≤ 1 holds at the ball's farthest point along (1, 1, 1).
        let farthest = ball.centre.abs().element_sum() + ball.radius * 3f64.sqrt();
        assert!(farthest <= 1.0 && ball.radius > 0.5, "{ball:?}");
    }

    #[test]
    fn flat_collinear_single_and_huge_sets_have_an_inner_ball_of_zero() {
        let flat: Vec<DVec3> = cube().into_iter().map(|p| p * DVec3::new(1.0, 1.0, 0.0)).collect();
        let line: Vec<DVec3> = (0..5).map(|k| DVec3::new(1.0, 2.0, 3.0) * k as f64).collect();
        let huge: Vec<DVec3> = cube().into_iter().map(|p| p * f64::MAX).collect();
        for points in [flat, line, vec![DVec3::ONE], huge] {
            let ball = Ball::inside(&points);
            assert_eq!(ball.radius, 0.0);
            assert!(ball.centre.is_finite());
        }
    }

    #[test]
    fn the_outer_ball_holds_every_point() {
        let points = cube();
        let ball = Ball::around(DVec3::splat(0.3), &points);
        assert!(points.iter().all(|p| p.distance(ball.centre) <= ball.radius));
        assert!(ball.radius < 3f64.sqrt() * 0.7 + 1e-12);
    }
}
