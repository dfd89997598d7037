//! The least reach of A − B over every direction that matters, filtered in f64, decided exactly.
//!
//! A facet of the difference of two polytopes is spanned by two edges of A, two of B, or one of
//! each, so its normal is among the vector products of two differences of vertices. Each such
//! direction bounds the depth from above and a facet's attains it: the least is the depth. Where
//! the two are apart, the least reach is the negative distance, and the nearest point may be on an
//! edge or a vertex too: their directions to the origin are added. Any further direction is
//! harmless, since every reach is at least the depth.

use crate::rounding::{exponent_above, point};
use crate::world::{Point, World, cross, dot, is_zero, minus};
use num_bigint::{BigInt, Sign};

/// reach / √square, in the world's unit.
#[derive(Clone, Debug)]
pub(crate) struct Least {
    pub(crate) reach: BigInt,
    pub(crate) square: BigInt,
}

impl Least {
    fn is_below(&self, other: &Self) -> bool {
        let square = |x: &Self, y: &Self| {
            let square = &x.reach * &x.reach * &y.square;
            if x.reach.sign() == Sign::Minus { -square } else { square }
        };
        square(self, other) < square(other, self)
    }
}

/// How a direction is made, so that its whole numbers are made only where f64 cannot drop it.
#[derive(Clone, Copy)]
enum Direction {
    Axis(usize),
    /// Normal to an edge and an axis.
    Beside(usize, usize),
    /// Normal to two edges.
    Facet(usize, usize),
    /// From a vertex of the difference to the origin.
    Vertex(usize),
    /// From the line through a vertex of the difference along an edge to the origin.
    Line(usize, usize),
}

/// The world, with all differences, and what f64 sees of them.
struct DirectionSearch<'a> {
    world: &'a World,
    edges: Vec<Point>,
    differences: Vec<Point>,
    seen_a: Vec<[f64; 3]>,
    seen_b: Vec<[f64; 3]>,
    seen_edges: Vec<[f64; 3]>,
    seen_differences: Vec<[f64; 3]>,
}

/// The least reach over all of them.
pub(crate) fn least_reach(world: &World) -> Least {
    let search = DirectionSearch::new(world);
    let edges = search.edges.len();
    let axes = (0..3).map(Direction::Axis);
    let beside = (0..edges).take(1).flat_map(|e| (0..3).map(move |k| Direction::Beside(e, k)));
    let facets = (0..edges).flat_map(|e| (0..e).map(move |f| Direction::Facet(e, f)));
    let least = search.least(None, axes.chain(beside).chain(facets));
    if least.reach.sign() == Sign::Plus {
        return least;
    }
    let vertices = 0..search.differences.len();
    let lines = vertices.clone().flat_map(|w| (0..edges).map(move |e| Direction::Line(w, e)));
    search.least(Some(least), vertices.map(Direction::Vertex).chain(lines))
}

/// Unit roundoff.
const U: f64 = f64::EPSILON / 2.0;

/// What a computed direction may be off by, as a length: a vector product of rounded vectors, each
/// component below 1, loses 8u a component; the second product of a line's, with a factor below
/// 3, some 50u.
const OFF: f64 = 64.0 * U;

/// What the reach of points below 1 along a computed direction of length 1 may be off by: 16u
/// doubled twice.
const ROUNDING: f64 = 64.0 * U;

impl<'a> DirectionSearch<'a> {
    fn new(world: &'a World) -> Self {
        let edges = edges(world);
        let differences = world.differences();
        // Counted from a vertex of A, so that nothing is lost far from the origin.
        let from = &world.a[0];
        let shifted =
            |points: &[Point]| -> Vec<Point> { points.iter().map(|p| minus(p, from)).collect() };
        let (a, b) = (shifted(&world.a), shifted(&world.b));
        let size = a.iter().chain(&b).filter_map(exponent_above).max().unwrap_or(0);
        let seen = |points: &[Point]| points.iter().map(|p| point(p, size)).collect();
        let direction = |p: &Point| point(p, exponent_above(p).unwrap_or(0));
        Self {
            seen_a: seen(&a),
            seen_b: seen(&b),
            seen_edges: edges.iter().map(direction).collect(),
            seen_differences: differences.iter().map(direction).collect(),
            world,
            edges,
            differences,
        }
    }

    /// The least of what is known and the reaches along both senses of the directions.
    fn least(&self, known: Option<Least>, directions: impl Iterator<Item = Direction>) -> Least {
        let mut open = Vec::new();
        let mut bound = f64::INFINITY;
        for direction in directions {
            let (low, high) = self.seen_reach(direction);
            if low <= bound {
                bound = bound.min(high);
                open.push((low, direction));
            }
        }
        let mut least = known;
        for (_, direction) in open.into_iter().filter(|&(low, _)| low <= bound) {
            let n = self.direction(direction);
            let square = dot(&n, &n);
            if square.sign() == Sign::NoSign {
                continue;
            }
            for reach in self.reaches(&n) {
                let found = Least { reach, square: square.clone() };
                if least.as_ref().is_none_or(|least| found.is_below(least)) {
                    least = Some(found);
                }
            }
        }
        // The axes are always among the first directions.
        least.unwrap_or(Least { reach: BigInt::ZERO, square: BigInt::from(1) })
    }

    fn direction(&self, direction: Direction) -> Point {
        let axis = |k: usize| [0, 1, 2].map(|j| BigInt::from(i32::from(j == k)));
        match direction {
            Direction::Axis(k) => axis(k),
            Direction::Beside(e, k) => cross(&self.edges[e], &axis(k)),
            Direction::Facet(e, f) => cross(&self.edges[e], &self.edges[f]),
            Direction::Vertex(w) => self.differences[w].clone(),
            Direction::Line(w, e) => {
                cross(&self.edges[e], &cross(&self.differences[w], &self.edges[e]))
            }
        }
    }

    /// max n·w and max −n·w over A − B.
    fn reaches(&self, n: &Point) -> [BigInt; 2] {
        let extent = |points: &[Point]| {
            let mut along = points.iter().map(|p| dot(n, p));
            let first = along.next().unwrap_or_default();
            along.fold((first.clone(), first), |(low, high), x| {
                if x < low {
                    (x, high)
                } else if x > high {
                    (low, x)
                } else {
                    (low, high)
                }
            })
        };
        let ((a_low, a_high), (b_low, b_high)) = (extent(&self.world.a), extent(&self.world.b));
        [a_high - b_low, b_high - a_low]
    }

    /// Bounds of the lesser reach in f64.
    fn seen_reach(&self, direction: Direction) -> (f64, f64) {
        let n = match direction {
            Direction::Axis(k) => [0, 1, 2].map(|j| f64::from(i32::from(j == k))),
            Direction::Beside(..) => [0.0; 3],
            Direction::Facet(e, f) => seen_cross(&self.seen_edges[e], &self.seen_edges[f]),
            Direction::Vertex(w) => self.seen_differences[w],
            Direction::Line(w, e) => {
                let (w, e) = (&self.seen_differences[w], &self.seen_edges[e]);
                seen_cross(e, &seen_cross(w, e))
            }
        };
        let length = seen_dot(&n, &n).sqrt();
        // Written so that a direction lost to rounding is decided exactly.
        if !(length > 4.0 * OFF) {
            return (f64::NEG_INFINITY, f64::INFINITY);
        }
        let extent = |points: &[[f64; 3]]| {
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                let along = seen_dot(&n, p);
                (low.min(along), high.max(along))
            })
        };
        let ((a_low, a_high), (b_low, b_high)) = (extent(&self.seen_a), extent(&self.seen_b));
        let reach = (a_high - b_low).min(b_high - a_low) / length;
        // Points of A − B are shorter than 4; a direction turns by at most 4/3·OFF / length.
        let off = 16.0 * OFF / length + ROUNDING;
        (reach - off, reach + off)
    }
}

/// All differences of two points of one body, each direction and length once, without zero.
fn edges(world: &World) -> Vec<Point> {
    let mut edges = Vec::new();
    for points in [&world.a, &world.b] {
        for (k, p) in points.iter().enumerate() {
            edges.extend(points[..k].iter().map(|q| minus(p, q)).filter(|e| !is_zero(e)));
        }
    }
    for e in &mut edges {
        let first = e.iter().find(|x| x.sign() != Sign::NoSign);
        if first.is_some_and(|x| x.sign() == Sign::Minus) {
            *e = [0, 1, 2].map(|k| -&e[k]);
        }
    }
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn seen_dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn seen_cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
