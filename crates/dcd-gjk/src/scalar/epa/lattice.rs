//! Two placed polytopes rounded to a common lattice, and their difference on it, exactly.

use super::wide::Wide;
use crate::PosedSupport;
use crate::UNIT;
use dcd_geom::glam::DVec3;
use dcd_geom::{Matrix, Polytope, Vector};

/// A point or a vector of the lattice, in its units.
pub(super) type Point = [i128; 3];

/// A direction: a vector product of two lattice vectors, or anything as short.
pub(super) type Normal = [Wide; 3];

/// A coordinate of the difference has fewer bits than this, an apex one more. Three factors of a
/// determinant and its sum of six must fit in 255 bits: edges have 84, normals 169, and
/// 169 + 83 + 2 = 254.
pub(super) const POINT_BITS: i32 = 82;

/// The bits that a world coordinate of either body may have before the other is subtracted.
const WORLD_BITS: i32 = 120;

/// How far a lattice vertex of the difference may be from the true one, in units: half a unit for
/// each of three products and a translation, of two bodies, in each of three coordinates (4·√3),
/// and a margin for the comparison.
pub(super) const SLACK: f64 = 8.0;

/// Marks a vertex that belongs to no body.
const APEX: u32 = u32::MAX;

/// A vertex of the difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Vertex {
    pub(super) w: Point,
    /// The vertex of A.
    pub(super) a: u32,
    /// The vertex of B.
    pub(super) b: u32,
}

impl Vertex {
    /// Whether it was added and is no vertex of the bodies.
    pub(super) fn is_apex(&self) -> bool {
        self.a == APEX
    }
}

/// A farthest vertex, and how far it is: the largest n·w.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    pub(super) vertex: Vertex,
    pub(super) reach: Wide,
}

/// A − B on the lattice, known by its exact support function.
pub(super) struct LatticeDifference<'a> {
    a: LatticeBody<'a>,
    b: LatticeBody<'a>,
    /// A lattice coordinate of k is k·2^unit metres.
    unit: i32,
    /// Points added so that a flat difference has an inside (see `start`).
    apexes: [Option<Vertex>; 3],
    inexact: bool,
    dots: &'a mut Vec<f64>,
}

impl<'a> LatticeDifference<'a> {
    pub(super) fn new(
        a: PosedSupport<'a, Polytope>,
        b: PosedSupport<'a, Polytope>,
        dots: &'a mut Vec<f64>,
    ) -> Self {
        let unit = unit(a, b);
        let body = |body| LatticeBody::new(body, unit);
        Self { a: body(a), b: body(b), unit, apexes: [None; 3], inexact: false, dots }
    }

    pub(super) fn unit(&self) -> i32 {
        self.unit
    }

    /// How far the support function may be from the true one, units: 0 as long as every vertex
    /// that it returned lies on the lattice.
    pub(super) fn slack(&self) -> f64 {
        if self.inexact { SLACK } else { 0.0 }
    }

    /// Adds a point to the difference, at most three times.
    pub(super) fn add_apex(&mut self, w: Point) -> Vertex {
        let apex = Vertex { w, a: APEX, b: APEX };
        if let Some(free) = self.apexes.iter_mut().find(|slot| slot.is_none()) {
            *free = Some(apex);
        }
        apex
    }

    /// Takes the added points away again.
    pub(super) fn drop_apexes(&mut self) {
        self.apexes = [None; 3];
    }

    /// Whether the difference is flat, so that points were added to it.
    pub(super) fn is_flat(&self) -> bool {
        self.apexes[0].is_some()
    }

    /// The points of A and of B, world frame, whose difference a vertex is.
    pub(super) fn corners(&self, vertex: &Vertex) -> [Point; 2] {
        [self.a.point(vertex.a as usize).0, self.b.point(vertex.b as usize).0]
    }

    /// The vertex farthest along `normal`, exactly; the first among equals.
    pub(super) fn support(&mut self, normal: &Normal) -> Support {
        let approximate = approximate(normal);
        let opposite = normal.map(|x| -x);
        let a = self.a.farthest(normal, approximate, self.dots);
        let b = self.b.farthest(&opposite, -approximate, self.dots);
        self.inexact |= a.inexact || b.inexact;
        let vertex = Vertex { w: minus(a.point, b.point), a: a.index, b: b.index };
        let mut best = Support { vertex, reach: dot(normal, vertex.w) };
        for &vertex in self.apexes.iter().flatten() {
            let reach = dot(normal, vertex.w);
            if reach > best.reach {
                best = Support { vertex, reach };
            }
        }
        best
    }
}

/// A vertex of one body that was found farthest.
struct Farthest {
    index: u32,
    point: Point,
    inexact: bool,
}

struct LatticeBody<'a> {
    body: PosedSupport<'a, Polytope>,
    rows: [[Dyadic; 3]; 3],
    translation: [Dyadic; 3],
    unit: i32,
}

impl<'a> LatticeBody<'a> {
    fn new(body: PosedSupport<'a, Polytope>, unit: i32) -> Self {
        let rotation = body.pose.rotation();
        let rows = [0, 1, 2].map(|k| rotation.row(k).to_array().map(Dyadic::new));
        let translation = body.pose.translation().to_array().map(Dyadic::new);
        Self { body, rows, translation, unit }
    }

    /// R·v + t on the lattice, and whether it had to be rounded.
    fn point(&self, index: usize) -> (Point, bool) {
        let v = self.body.map.vertices()[index].to_array().map(Dyadic::new);
        let mut inexact = false;
        let mut term = |mantissa, exponent| {
            let (x, rounded) = on_lattice(mantissa, exponent - self.unit);
            inexact |= rounded;
            x
        };
        let point = [0, 1, 2].map(|k| {
            let t = self.translation[k];
            let start = term(t.mantissa.into(), t.exponent);
            self.rows[k].iter().zip(&v).fold(start, |sum, (r, v)| {
                let product = i128::from(r.mantissa) * i128::from(v.mantissa);
                sum + term(product, r.exponent + v.exponent)
            })
        });
        (point, inexact)
    }

    /// The vertex farthest along `normal`: sought in f64 along `direction`, which is the same but
    /// for its length and rounding, then on the lattice among those that f64 cannot
    /// order.
    fn farthest(&self, normal: &Normal, direction: DVec3, dots: &mut Vec<f64>) -> Farthest {
        let local = self.body.pose.rotation().transform_transposed(direction);
        dots.clear();
        dots.extend(self.body.map.vertices().iter().map(|&v| Vector::dot(local, v)));
        let largest = dots.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // The direction's rounding, Rᵀd and ·v are 9 roundings, the lattice's is 2 units a
        // coordinate; underflow adds at most half of the least number six times. Doubled, for two
        // vertices are compared, and again for a margin.
        let reach = self.body.map.reach();
        let error = Vector::norm1(direction) * (18.0 * UNIT * reach + 4.0 * two_to(self.unit))
            + f64::from_bits(16);
        let surely_less = largest - 2.0 * error;
        let mut best: Option<Farthest> = None;
        let mut any_inexact = false;
        for (index, &along) in (0u32..).zip(dots.iter()) {
            // An infinite error leaves every vertex a candidate.
            if along < surely_less {
                continue;
            }
            let (point, inexact) = self.point(index as usize);
            any_inexact |= inexact;
            let farther = |than: &Farthest| dot(normal, minus(point, than.point)) > Wide::ZERO;
            if best.as_ref().is_none_or(farther) {
                best = Some(Farthest { index, point, inexact });
            }
        }
        let best = best.unwrap_or(Farthest { index: 0, point: [0; 3], inexact: true });
        Farthest { inexact: any_inexact || best.inexact, ..best }
    }
}

/// A number of f64 as mantissa·2^exponent, exactly.
#[derive(Clone, Copy)]
struct Dyadic {
    mantissa: i64,
    exponent: i32,
}

impl Dyadic {
    fn new(x: f64) -> Self {
        let bits = x.to_bits();
        let biased = (bits >> 52 & 0x7ff) as i32;
        let fraction = (bits & ((1 << 52) - 1)) as i64;
        let (mantissa, exponent) =
            if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
        Self { mantissa: if x < 0.0 { -mantissa } else { mantissa }, exponent }
    }
}

/// mantissa·2^shift rounded to the nearest integer, and whether it had to be rounded. The
/// lattice's unit is such that a shift upward fits.
fn on_lattice(mantissa: i128, shift: i32) -> (i128, bool) {
    if mantissa == 0 {
        (0, false)
    } else if shift >= 0 {
        (mantissa << shift, false)
    } else if shift < -120 {
        // A product has 106 bits.
        (0, true)
    } else {
        let rounded = (mantissa + (1 << (-shift - 1))) >> -shift;
        (rounded, rounded << -shift != mantissa)
    }
}

/// The exponent of the lattice's unit: the finest at which every vertex of the difference has
/// `POINT_BITS` bits and every world coordinate `WORLD_BITS`.
fn unit(a: PosedSupport<'_, Polytope>, b: PosedSupport<'_, Polytope>) -> i32 {
    let (a_centre, b_centre) = (a.map.inner().centre, b.map.inner().centre);
    let apart = a.pose.apply(a_centre) - b.pose.apply(b_centre);
    let position = |body: &PosedSupport<'_, Polytope>| {
        Vector::norm1(body.pose.translation()) + body.map.reach() + body.map.outer_radius()
    };
    let position = position(&a) + position(&b);
    // Ten roundings of `position` in `apart`, the excess of R's norm over 1 (at most 3e-6), and
    // what the lattice itself rounds.
    let extent = (Vector::norm1(apart) + a.map.outer_radius() + b.map.outer_radius()) * 1.0001
        + position * (32.0 * UNIT);
    (exponent(extent) - POINT_BITS).max(exponent(position * 1.0001) - WORLD_BITS)
}

/// The least e with x < 2^e; above that of every sum of ours where x overflowed.
fn exponent(x: f64) -> i32 {
    if !x.is_finite() {
        1030
    } else if x == 0.0 {
        -1074
    } else {
        let dyadic = Dyadic::new(x);
        dyadic.exponent + 64 - dyadic.mantissa.leading_zeros() as i32
    }
}

/// 2^exponent; 0 or infinity where that is out of range.
pub(super) fn two_to(exponent: i32) -> f64 {
    match exponent {
        ..-1074 => 0.0,
        -1074..-1022 => f64::from_bits(1 << (exponent + 1074)),
        -1022..=1023 => f64::from_bits(((exponent + 1023) as u64) << 52),
        _ => f64::INFINITY,
    }
}

/// x·2^exponent, exactly unless it leaves the normal numbers. |exponent| below 2000.
pub(super) fn scaled(x: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    x * two_to(half) * two_to(exponent - half)
}

pub(super) fn minus(p: Point, q: Point) -> Point {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

pub(super) fn cross(p: Point, q: Point) -> Normal {
    let minor = |j: usize, k: usize| Wide::product(p[j], q[k]) - Wide::product(p[k], q[j]);
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

#[inline]
pub(super) fn dot(n: &Normal, p: Point) -> Wide {
    n[0].times(p[0]) + n[1].times(p[1]) + n[2].times(p[2])
}

/// The components rounded to f64.
pub(super) fn rounded(n: &Normal) -> DVec3 {
    DVec3::from_array(n.map(Wide::to_f64))
}

/// The Euclidean length, to within 8·2⁻⁵³ of itself.
pub(super) fn length(n: &Normal) -> f64 {
    Vector::length(rounded(n))
}

/// The same direction with at most `bits` bits a component, rounded down; zero stays zero.
pub(super) fn shortened(n: &Normal, bits: u32) -> Point {
    let longest = n.iter().map(|x| x.bits()).max().unwrap_or(0);
    n.map(|x| x.shifted_down(longest.saturating_sub(bits)))
}

/// The point as a direction.
pub(super) fn as_normal(p: Point) -> Normal {
    p.map(Wide::from)
}

/// The same direction with a largest component near 2⁻¹⁰, so that no product with a vertex
/// overflows.
fn approximate(n: &Normal) -> DVec3 {
    let n = rounded(n);
    let largest = n.abs().max_element();
    n * two_to(-10 - exponent(largest))
}
