//! The point of a simplex nearest to the origin, in any arithmetic.
//!
//! One algorithm serves the floating-point solvers, double-double and exact integers: weights share
//! a divisor and nothing is divided, so that in exact arithmetic every decision is exact, and
//! numbers grow with the degree of the formulas alone.

use dcd_geom::Real;
use std::cmp::Ordering;

/// A number that adds and multiplies.
pub(crate) trait Scalar: Clone {
    fn zero() -> Self;
    fn one() -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    fn negated(&self) -> Self;
    /// Against 0; `None` for NaN.
    fn sign(&self) -> Option<Ordering>;
    /// Whether n₁/d₁ < n₂/d₂, for divisors of at least 0; false for NaN.
    fn ratio_is_less(n1: &Self, d1: &Self, n2: &Self, d2: &Self) -> bool;

    /// The inner product.
    #[inline]
    fn sum_of_products(a: &Triple<Self>, b: &Triple<Self>) -> Self {
        a[0].times(&b[0]).plus(&a[1].times(&b[1])).plus(&a[2].times(&b[2]))
    }
    /// ab − cd.
    #[inline]
    fn difference_of_products([a, b]: [&Self; 2], [c, d]: [&Self; 2]) -> Self {
        a.times(b).minus(&c.times(d))
    }
    fn is_positive(&self) -> bool {
        self.sign() == Some(Ordering::Greater)
    }
    fn is_negative(&self) -> bool {
        self.sign() == Some(Ordering::Less)
    }
}

impl<R: Real> Scalar for R {
    #[inline]
    fn zero() -> Self {
        R::ZERO
    }
    #[inline]
    fn one() -> Self {
        R::ONE
    }
    #[inline]
    fn plus(&self, other: &Self) -> Self {
        *self + *other
    }
    #[inline]
    fn minus(&self, other: &Self) -> Self {
        *self - *other
    }
    #[inline]
    fn times(&self, other: &Self) -> Self {
        *self * *other
    }
    #[inline]
    fn negated(&self) -> Self {
        -*self
    }
    #[inline]
    fn sign(&self) -> Option<Ordering> {
        self.partial_cmp(&R::ZERO)
    }
    #[inline]
    fn is_positive(&self) -> bool {
        *self > R::ZERO
    }
    #[inline]
    fn is_negative(&self) -> bool {
        *self < R::ZERO
    }
    /// By division: the products could underflow.
    #[inline]
    fn ratio_is_less(n1: &Self, d1: &Self, n2: &Self, d2: &Self) -> bool {
        *n1 / *d1 < *n2 / *d2
    }
}

/// x, y and z.
pub(crate) type Triple<T> = [T; 3];

#[inline]
pub(crate) fn plus<T: Scalar>(a: &Triple<T>, b: &Triple<T>) -> Triple<T> {
    [a[0].plus(&b[0]), a[1].plus(&b[1]), a[2].plus(&b[2])]
}

#[inline]
pub(crate) fn minus<T: Scalar>(a: &Triple<T>, b: &Triple<T>) -> Triple<T> {
    [a[0].minus(&b[0]), a[1].minus(&b[1]), a[2].minus(&b[2])]
}

#[inline]
pub(crate) fn negated<T: Scalar>(a: &Triple<T>) -> Triple<T> {
    [a[0].negated(), a[1].negated(), a[2].negated()]
}

#[inline]
pub(crate) fn dot<T: Scalar>(a: &Triple<T>, b: &Triple<T>) -> T {
    T::sum_of_products(a, b)
}

#[inline]
pub(crate) fn cross<T: Scalar>(a: &Triple<T>, b: &Triple<T>) -> Triple<T> {
    [
        T::difference_of_products([&a[1], &b[2]], [&a[2], &b[1]]),
        T::difference_of_products([&a[2], &b[0]], [&a[0], &b[2]]),
        T::difference_of_products([&a[0], &b[1]], [&a[1], &b[0]]),
    ]
}

#[inline]
pub(crate) fn determinant<T: Scalar>(a: &Triple<T>, b: &Triple<T>, c: &Triple<T>) -> T {
    dot(a, &cross(b, c))
}

#[inline]
pub(crate) fn norm1<R: Real>(a: &Triple<R>) -> R {
    a[0].abs() + a[1].abs() + a[2].abs()
}

/// What is known of a simplex's point nearest to the origin.
#[derive(Clone, Debug)]
pub(crate) struct Nearest<T> {
    /// How many of the points span it: the smallest face that holds it.
    pub(crate) count: usize,
    /// Which, by index.
    pub(crate) kept: [usize; 4],
    /// Their weights, at least 0, up to a common factor.
    pub(crate) weights: [T; 4],
    /// Points from the origin to it, at any length: normal to the face to within rounding, however
    /// near the face is. 0 where the simplex holds the origin.
    pub(crate) direction: Triple<T>,
    /// Its squared distance as a fraction.
    pub(crate) square: [T; 2],
}

impl<T: Scalar> Nearest<T> {
    fn is_nearer_than(&self, other: &Self) -> bool {
        let ([n1, d1], [n2, d2]) = (&self.square, &other.square);
        T::ratio_is_less(n1, d1, n2, d2)
    }

    /// The weights of the points it kept.
    pub(crate) fn weights(&self) -> &[T] {
        &self.weights[..self.count]
    }
}

/// The nearest point of the hull of one to four points; more are not looked at.
///
/// Points may coincide and be collinear or coplanar.
pub(crate) fn nearest<T: Scalar>(points: &[Triple<T>]) -> Option<Nearest<T>> {
    match points.len() {
        0 => None,
        1 => Some(of_point(points, 0)),
        2 => Some(of_segment(points, [0, 1])),
        3 => Some(of_triangle(points, [0, 1, 2])),
        _ => Some(of_tetrahedron(points)),
    }
}

fn of_point<T: Scalar>(points: &[Triple<T>], k: usize) -> Nearest<T> {
    let p = &points[k];
    Nearest {
        count: 1,
        kept: [k, 0, 0, 0],
        weights: [T::one(), T::zero(), T::zero(), T::zero()],
        direction: p.clone(),
        square: [dot(p, p), T::one()],
    }
}

fn of_segment<T: Scalar>(points: &[Triple<T>], [i, j]: [usize; 2]) -> Nearest<T> {
    let (a, b) = (&points[i], &points[j]);
    let edge = minus(b, a);
    let (weight_a, weight_b) = (dot(b, &edge), dot(a, &edge).negated());
    if !weight_a.is_positive() {
        return of_point(points, j);
    }
    if !weight_b.is_positive() {
        return of_point(points, i);
    }
    let across = cross(a, &edge);
    Nearest {
        count: 2,
        kept: [i, j, 0, 0],
        weights: [weight_a, weight_b, T::zero(), T::zero()],
        // a|e|² − e(a·e), without its cancellation along the edge.
        direction: cross(&edge, &across),
        square: [dot(&across, &across), dot(&edge, &edge)],
    }
}

fn of_triangle<T: Scalar>(points: &[Triple<T>], [i, j, k]: [usize; 3]) -> Nearest<T> {
    let (a, b, c) = (&points[i], &points[j], &points[k]);
    let normal = cross(&minus(b, a), &minus(c, a));
    let weights =
        [determinant(&normal, b, c), determinant(&normal, c, a), determinant(&normal, a, b)];
    let opposite = [[j, k], [k, i], [i, j]];
    let mut best: Option<Nearest<T>> = None;
    for (weight, edge) in weights.iter().zip(opposite) {
        // An edge sees the origin on its outer side; all three where the triangle is degenerate.
        if !weight.is_positive() {
            let found = of_segment(points, edge);
            if best.as_ref().is_none_or(|best| found.is_nearer_than(best)) {
                best = Some(found);
            }
        }
    }
    if let Some(best) = best {
        return best;
    }
    let height = dot(&normal, a);
    let [weight_a, weight_b, weight_c] = weights;
    let direction = match height.sign() {
        Some(Ordering::Greater) => normal.clone(),
        Some(Ordering::Less) => negated(&normal),
        _ => [T::zero(), T::zero(), T::zero()],
    };
    Nearest {
        count: 3,
        kept: [i, j, k, 0],
        weights: [weight_a, weight_b, weight_c, T::zero()],
        direction,
        square: [height.times(&height), dot(&normal, &normal)],
    }
}

fn of_tetrahedron<T: Scalar>(points: &[Triple<T>]) -> Nearest<T> {
    let (p0, p1, p2, p3) = (&points[0], &points[1], &points[2], &points[3]);
    let (far, near) = (cross(p2, p3), cross(p0, p1));
    let volumes =
        [dot(p1, &far), dot(p0, &far).negated(), dot(p3, &near), dot(p2, &near).negated()];
    let whole = volumes[0].plus(&volumes[1]).plus(&volumes[2]).plus(&volumes[3]);
    let side = whole.sign();
    let mut best: Option<Nearest<T>> = None;
    for (volume, face) in volumes.iter().zip([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]) {
        let flat = !whole.is_positive() && !whole.is_negative();
        // A face sees the origin on its outer side, or on its plane; all where it is flat.
        if flat || volume.sign() != side {
            let found = of_triangle(points, face);
            if found.count == 3 && !flat {
                // The normal of a face that sees the origin is normal to the whole: no other is
                // nearer.
                return found;
            }
            if best.as_ref().is_none_or(|best| found.is_nearer_than(best)) {
                best = Some(found);
            }
        }
    }
    let inside = || Nearest {
        count: 4,
        kept: [0, 1, 2, 3],
        weights: volumes
            .map(|volume| if side == Some(Ordering::Less) { volume.negated() } else { volume }),
        direction: [T::zero(), T::zero(), T::zero()],
        square: [T::zero(), T::one()],
    };
    best.unwrap_or_else(inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point_of(near: &Nearest<f64>, points: &[Triple<f64>]) -> Triple<f64> {
        let total: f64 = near.weights().iter().sum();
        let mut sum = [0.0; 3];
        for (&k, weight) in near.kept.iter().zip(near.weights()) {
            sum = plus(&sum, &points[k].map(|x| x * weight / total));
        }
        sum
    }

    #[test]
    fn a_segment_keeps_its_end_or_its_middle() {
        let points = [[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let near = nearest(&points).unwrap();
        assert_eq!((near.count, point_of(&near, &points)), (2, [0.0, 1.0, 0.0]));
        let points = [[2.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let near = nearest(&points).unwrap();
        assert_eq!((near.count, near.kept[0], near.square), (1, 1, [2.0, 1.0]));
    }

    #[test]
    fn a_triangle_keeps_its_face_edge_or_corner() {
        let at = |x: f64, y: f64, z: f64| {
            let points = [[x, y, z], [x + 3.0, y, z], [x, y + 3.0, z]];
            let near = nearest(&points).unwrap();
            (near.count, point_of(&near, &points))
        };
        assert_eq!(at(-1.0, -1.0, 2.0), (3, [0.0, 0.0, 2.0]));
        assert_eq!(at(-1.0, 1.0, 2.0), (2, [0.0, 1.0, 2.0]));
        assert_eq!(at(1.0, 1.0, 2.0), (1, [1.0, 1.0, 2.0]));
        assert_eq!(at(-2.0, -2.0, 0.0), (2, [-0.5, -0.5, 0.0].map(|x: f64| x + 0.0)));
    }

    #[test]
    fn a_tetrahedron_holds_the_origin_or_keeps_a_face() {
        let corners = |s: f64| {
            [[0.0; 3], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]].map(|p| p.map(|x| x + s))
        };
        assert_eq!(nearest(&corners(-0.5)).unwrap().count, 4);
        let outside = corners(-2.0);
        let near = nearest(&outside).unwrap();
        assert_eq!(near.count, 3);
        assert!(point_of(&near, &outside).iter().all(|x| (x + 1.0).abs() < 1e-15));
        let beside = corners(1.0);
        assert_eq!(point_of(&nearest(&beside).unwrap(), &beside), [1.0; 3]);
    }

    #[test]
    fn degenerate_simplices_have_a_nearest_point() {
        let p = [1.0, 2.0, 2.0];
        let line = [[1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 3.0, 0.0], [1.0, 5.0, 0.0]];
        let flat = [[1.0, -1.0, -1.0], [1.0, 2.0, -1.0], [1.0, -1.0, 2.0], [1.0, 2.0, 2.0]];
        for (points, length) in [(vec![p; 2], 3.0), (vec![p; 3], 3.0), (vec![p; 4], 3.0)] {
            assert_eq!(nearest(&points).unwrap().square[0].sqrt(), length);
        }
        for points in [&line[..3], &line[..], &flat[..]] {
            assert_eq!(point_of(&nearest(points).unwrap(), points), [1.0, 0.0, 0.0]);
        }
    }

    #[test]
    fn nan_ends_it_too() {
        let nan = [[f64::NAN; 3]; 4];
        for count in 1..=4 {
            assert!(!(nearest(&nan[..count]).unwrap().square[0] >= 0.0));
        }
    }
}
