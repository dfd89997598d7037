//! The slowest obvious version: every direction that a facet of A − B can have, in integers of
//! any length.
//!
//! A facet of the difference of two polytopes is spanned by two edges of A, two of B, or one of
//! each, so its normal is among the vector products of two differences of vertices. Each such
//! direction bounds the depth from above and a facet's attains it: the least is the depth. Where
//! the two are apart, the least reach is the negative distance, and the nearest point may be on an
//! edge or a vertex too: their directions to the origin are added. Shares no code and no method
//! with the crate.

use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose};
use num_bigint::{BigInt, Sign};

type Point = [BigInt; 3];

/// reach / √square · 2^exponent: the signed depth, negative for the distance of cores apart.
pub(super) struct Truth {
    reach: BigInt,
    square: BigInt,
    exponent: i32,
}

impl Truth {
    /// Of a difference that is more than a segment, or apart.
    pub(super) fn of(a: (&Polytope, &Pose), b: (&Polytope, &Pose)) -> Self {
        let exponent = [a, b].map(|(map, pose)| scale(map, pose)).into_iter().min().unwrap();
        let [a, b] = [a, b].map(|(map, pose)| world(map, pose, exponent));
        let edges: Vec<Point> = [&a, &b].into_iter().flat_map(|points| edges(points)).collect();
        let facets = edges.iter().enumerate();
        let facets = facets.flat_map(|(k, e)| edges[..k].iter().map(move |f| cross(e, f)));
        let mut least = least(None, facets, (&a, &b), exponent);
        // A flat difference has 0 along its normal, whether the origin is in it or beside it.
        if least.as_ref().is_none_or(|least| least.reach.sign() != Sign::Plus) {
            let vertices: Vec<Point> =
                a.iter().flat_map(|p| b.iter().map(move |q| minus(p, q))).collect();
            let from_edges =
                vertices.iter().flat_map(|w| edges.iter().map(move |e| cross(e, &cross(w, e))));
            least = self::least(least, vertices.iter().cloned(), (&a, &b), exponent);
            least = self::least(least, from_edges, (&a, &b), exponent);
        }
        least.expect("a difference that is not a point")
    }

    /// The signed depth with a radius: reach/√square + r, by the difference of the squares where
    /// the sum cancels.
    pub(super) fn rounded_by(&self, radius: f64) -> f64 {
        if self.touches() {
            return self.value() + radius;
        }
        let r = Self::number(radius, self.exponent);
        let left = &r.reach * &r.reach * &self.square - &self.reach * &self.reach * &r.square;
        // left / (√r.square·√square)² over the sum of the two lengths.
        let (left, e) = leading(&left);
        let (square, f) = leading(&(&r.square * &self.square));
        let sum = (radius - self.value()) / 2f64.powi(self.exponent);
        left / square / sum * 2f64.powi(e - f + self.exponent)
    }

    /// Whether the shapes touch.
    pub(super) fn touches(&self) -> bool {
        self.reach.sign() != Sign::Minus
    }

    /// To all digits of f64.
    pub(super) fn value(&self) -> f64 {
        let (reach, e) = leading(&self.reach);
        let (square, f) = leading(&self.square);
        // An even exponent for the root.
        let (square, f) = if f % 2 == 0 { (square, f) } else { (square * 2.0, f - 1) };
        reach / square.sqrt() * 2f64.powi(e - f / 2 + self.exponent)
    }

    /// Whether the depth lies between two numbers, exactly.
    pub(super) fn is_within(&self, low: f64, high: f64) -> bool {
        // Lengths in the oracle's unit, times a power of two that makes them integers.
        let low = Self::number(low, self.exponent);
        let high = Self::number(high, self.exponent);
        !self.is_below(&low) && !high.is_below(self)
    }

    fn number(x: f64, exponent: i32) -> Self {
        let (reach, e) = integer(x);
        let shift = e - exponent;
        let one = BigInt::from(1);
        if shift >= 0 {
            Self { reach: reach << shift, square: one, exponent }
        } else {
            Self { reach, square: one << (-2 * shift), exponent }
        }
    }

    fn is_below(&self, other: &Self) -> bool {
        let square = |x: &Self, y: &Self| {
            let square = &x.reach * &x.reach * &y.square;
            if x.reach.sign() == Sign::Minus { -square } else { square }
        };
        square(self, other) < square(other, self)
    }
}

/// The least of what is known and the reaches along both senses of the directions.
fn least(
    known: Option<Truth>,
    directions: impl Iterator<Item = Point>,
    (a, b): (&[Point], &[Point]),
    exponent: i32,
) -> Option<Truth> {
    let mut least = known;
    for n in directions {
        let square = dot(&n, &n);
        if square.sign() == Sign::NoSign {
            continue;
        }
        let extent = |points: &[Point]| {
            let along: Vec<BigInt> = points.iter().map(|p| dot(&n, p)).collect();
            (along.iter().min().unwrap().clone(), along.iter().max().unwrap().clone())
        };
        let ((a_min, a_max), (b_min, b_max)) = (extent(a), extent(b));
        for reach in [a_max - b_min, b_max - a_min] {
            let truth = Truth { reach, square: square.clone(), exponent };
            if least.as_ref().is_none_or(|least| truth.is_below(least)) {
                least = Some(truth);
            }
        }
    }
    least
}

/// All differences of two points, without the zero ones.
fn edges(points: &[Point]) -> Vec<Point> {
    let mut edges = Vec::new();
    for (k, p) in points.iter().enumerate() {
        edges.extend(points[..k].iter().filter(|q| *q != p).map(|q| minus(p, q)));
    }
    edges
}

/// The exponent at which every coordinate of R·v + t is an integer.
fn scale(map: &Polytope, pose: &Pose) -> i32 {
    let least = |numbers: &mut dyn Iterator<Item = f64>| {
        numbers.filter(|x| *x != 0.0).map(|x| integer(x).1).min().unwrap_or(0)
    };
    let rotation = least(&mut pose.rotation().to_cols_array().into_iter());
    let vertices = least(&mut map.vertices().iter().flat_map(|v| v.to_array()));
    let translation = least(&mut pose.translation().to_array().into_iter());
    translation.min(rotation + vertices)
}

fn world(map: &Polytope, pose: &Pose, exponent: i32) -> Vec<Point> {
    let at = |(m, e): (BigInt, i32)| if m.sign() == Sign::NoSign { m } else { m << (e - exponent) };
    let place = |v: &DVec3| {
        [0, 1, 2].map(|k| {
            let row = pose.rotation().row(k).to_array();
            let products = row.into_iter().zip(v.to_array()).map(|(r, x)| {
                let ((r, e), (x, f)) = (integer(r), integer(x));
                at((r * x, e + f))
            });
            products.fold(at(integer(pose.translation()[k])), |sum, product| sum + product)
        })
    };
    map.vertices().iter().map(place).collect()
}

/// x = m·2^e with m odd.
fn integer(x: f64) -> (BigInt, i32) {
    if x == 0.0 {
        return (BigInt::ZERO, 0);
    }
    let bits = x.to_bits();
    let biased = (bits >> 52 & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let (m, e) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    let zeros = m.trailing_zeros();
    let m = BigInt::from(m >> zeros);
    (if x < 0.0 { -m } else { m }, e + zeros as i32)
}

/// x as m·2^e with m an f64 of about 60 bits.
fn leading(x: &BigInt) -> (f64, i32) {
    let excess = (x.bits() as i32 - 60).max(0);
    let top: i64 = (x >> excess).try_into().expect("60 bits");
    (top as f64, excess)
}

fn minus(p: &Point, q: &Point) -> Point {
    [0, 1, 2].map(|k| &p[k] - &q[k])
}

fn dot(p: &Point, q: &Point) -> BigInt {
    &p[0] * &q[0] + &p[1] * &q[1] + &p[2] * &q[2]
}

fn cross(p: &Point, q: &Point) -> Point {
    [(1, 2), (2, 0), (0, 1)].map(|(j, k)| &p[j] * &q[k] - &p[k] * &q[j])
}

#[test]
fn the_oracle_is_right_where_the_depth_is_known_by_hand() {
    let cube = Polytope::cuboid(DVec3::splat(0.5)).unwrap();
    for (x, depth) in [(0.75, 0.25), (0.25, 0.75), (0.0, 1.0), (1.0, 0.0)] {
        let there = Pose::from_translation(DVec3::new(x, 0.0, 0.0)).unwrap();
        let truth = Truth::of((&cube, &Pose::IDENTITY), (&cube, &there));
        assert_eq!(truth.value(), depth);
        assert!(truth.is_within(depth, depth) && truth.touches());
        assert!(
            !truth.is_within(depth.next_up(), 9.0) && !truth.is_within(-9.0, depth.next_down())
        );
    }
    // The plane x + y + z = 1 is 1/√3 from the corner at the origin.
    let corner = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let corner = Polytope::hull(corner.to_vec()).unwrap();
    let point = Polytope::hull(vec![DVec3::splat(0.25)]).unwrap();
    let truth = Truth::of((&corner, &Pose::IDENTITY), (&point, &Pose::IDENTITY));
    assert!((truth.value() - 0.25 / 3f64.sqrt()).abs() < 1e-16);
    let there = Pose::from_translation(DVec3::new(0.0, 0.0, 3.0)).unwrap();
    let apart = Truth::of((&cube, &Pose::IDENTITY), (&cube, &there));
    assert!(!apart.touches());
    assert_eq!(apart.value(), -2.0);
    // Corner to corner along (2, 3, 6) / 7.
    let there = Pose::from_translation(DVec3::new(3.0, 4.0, 7.0)).unwrap();
    let apart = Truth::of((&cube, &Pose::IDENTITY), (&cube, &there));
    assert_eq!((apart.value(), apart.rounded_by(7.5)), (-7.0, 0.5));
    assert_eq!(apart.rounded_by(7f64.next_up()), 4.0 * f64::EPSILON);
}
