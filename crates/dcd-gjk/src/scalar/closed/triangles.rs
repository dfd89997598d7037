//! The nearest points of a triangle and a point or segment that does not pierce it.

use super::segments::{PosedCore, parameters};
use dcd_geom::Kind;
use dcd_geom::glam::DVec3;

/// A point of each core, in its own frame, that are the nearest but for rounding where the cores do not meet.
/// `delta` is from the second's origin to the first's.
///
/// Each is a combination of vertices whose weights are at least 0 and sum to 1 within 2u: it is within 5u of
/// the reach from its core.
pub(super) fn points(a: PosedCore<'_>, b: PosedCore<'_>, delta: DVec3) -> Option<[DVec3; 2]> {
    if a.kind != Kind::Triangle {
        return points(b, a, -delta).map(|[of_b, of_a]| [of_a, of_b]);
    }
    let (back, turn) = (a.pose.rotation().transpose(), *b.pose.rotation());
    let corners: [DVec3; 3] = a.vertices.try_into().ok()?;
    let seen = |v: DVec3| back * (turn * v - delta);
    match *b.vertices {
        [point] => Some([combined(corners, weights(corners, seen(point))), point]),
        [from, to] => {
            let ends = [seen(from), seen(to)];
            let (weights, t) = of_segment(corners, ends);
            Some([combined(corners, weights), from + (to - from) * t])
        }
        _ => None,
    }
}

/// The point of a triangle that is nearest to a point, but for rounding.
pub(crate) fn nearest(corners: [DVec3; 3], point: DVec3) -> DVec3 {
    combined(corners, weights(corners, point))
}

#[inline(always)]
fn combined([a, b, c]: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    a * u + b * v + c * w
}

/// The weights of the corners in the triangle's point that is nearest.
///
/// Source: Ericson, Real-Time Collision Detection, 2005, 5.1.5.
fn weights([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let share = |along: f64, rest: f64| (along / (along + rest)).clamp(0.0, 1.0);
    let [d1, d2] = [ab, ac].map(|edge| edge.dot(point - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let [d3, d4] = [ab, ac].map(|edge| edge.dot(point - b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let of_c = d1 * d4 - d3 * d2;
    if of_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = share(d1, -d3);
        return [1.0 - t, t, 0.0];
    }
    let [d5, d6] = [ab, ac].map(|edge| edge.dot(point - c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let of_b = d5 * d2 - d1 * d6;
    if of_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = share(d2, -d6);
        return [1.0 - t, 0.0, t];
    }
    let of_a = d3 * d6 - d5 * d4;
    if of_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = share(d4 - d3, d5 - d6);
        return [0.0, 1.0 - t, t];
    }
    let total = of_a + of_b + of_c;
    let v = (of_b / total).clamp(0.0, 1.0);
    let w = (of_c / total).clamp(0.0, 1.0 - v);
    [1.0 - v - w, v, w]
}

/// The same for a segment, and where on it the nearest point is: an end against the triangle, or the segment
/// against an edge.
#[inline(always)]
fn of_segment(corners: [DVec3; 3], [from, to]: [DVec3; 2]) -> ([f64; 3], f64) {
    let along = to - from;
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let [of_from, of_to] = [normal.dot(from - a), normal.dot(to - a)];
    // On one side of the plane the end that is nearer to it is the nearest of all, if it is over the inside of the triangle.
    let is_beside = of_from * of_to > 0.0;
    let is_inside = |[u, v, w]: [f64; 3]| u > 0.0 && v > 0.0 && w > 0.0;
    let first = weights(corners, from);
    if is_beside && of_from.abs() <= of_to.abs() && is_inside(first) {
        return (first, 0.0);
    }
    let last = weights(corners, to);
    if is_beside && of_to.abs() < of_from.abs() && is_inside(last) {
        return (last, 1.0);
    }
    let mut best = (first, 0.0);
    let mut least = apart(corners, best, from, along);
    let mut consider = (last, 1.0);
    for k in 0..4 {
        let square = apart(corners, consider, from, along);
        if square < least {
            (best, least) = (consider, square);
        }
        if k < 3 {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            let [s, t] = parameters(q - p, along, p - from);
            let mut weights = [0.0; 3];
            (weights[k], weights[(k + 1) % 3]) = (1.0 - s, s);
            consider = (weights, t);
        }
    }
    best
}

/// The squared distance of a point of a triangle from one of a segment.
#[inline(always)]
fn apart(corners: [DVec3; 3], (weights, t): ([f64; 3], f64), from: DVec3, along: DVec3) -> f64 {
    combined(corners, weights).distance_squared(from + along * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::tests::Draw;

    /// The least distance over the segment, whose distance from a triangle is convex along it: by thirds.
    fn least(corners: [DVec3; 3], [from, to]: [DVec3; 2]) -> f64 {
        let distance = |t: f64| {
            let on = from.lerp(to, t);
            nearest(corners, on).distance(on)
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..120 {
            let (first, second) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if distance(first) < distance(second) { high = second } else { low = first }
        }
        distance(low)
    }

    #[test]
    fn no_point_of_a_segment_is_nearer_to_a_triangle_than_those_that_are_found() {
        let mut draw = Draw(5);
        let [mut over, mut beside] = [0; 2];
        for round in 0..4000 {
            let corners = [0; 3].map(|_| draw.vector());
            let mut ends = [0; 2].map(|_| draw.vector() * [1.0, 0.3][round % 2]);
            if round % 3 == 0 {
                // On one side, and mostly over it.
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
                let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
                ends = ends.map(|end| middle + end * 0.3 + normal * (0.4 + draw.number() * 0.1));
            }
            let due = least(corners, ends);
            // One that pierces is another's.
            if due < 1e-9 {
                continue;
            }
            let (found, t) = of_segment(corners, ends);
            let distance = combined(corners, found).distance(ends[0].lerp(ends[1], t));
            assert!((distance - due).abs() < 1e-7, "{round}: {distance} {due}");
            let is_over = found.iter().all(|&weight| weight > 0.0);
            if is_over { over += 1 } else { beside += 1 }
        }
        assert!(over > 500 && beside > 500, "{over} {beside}");
    }
}
