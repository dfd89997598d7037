//! The corners of points in a plane, in order round it.

use glam::DVec3;

/// How far a point must be outside the line of its neighbours to be a corner, relative to the
/// product of the edges' lengths: the rounding of a cross product, and a margin. Larger: lost corners
/// of finely cut rims. Smaller: corners in the middle of edges.
const STRAIGHT: f64 = 1e-12;

/// The corners of the hull of some vertices in a plane with that normal, counter-clockwise seen
/// from where it points. By sorting along one axis of the plane and walking both sides (Andrew
/// 1979).
pub(super) fn corners(vertices: &[DVec3], members: &[u32], normal: DVec3) -> Vec<u32> {
    let (p, q) = normal.any_orthonormal_pair();
    let middle = members.first().map_or(DVec3::ZERO, |&k| vertices[k as usize]);
    let flat = |k: u32| {
        let v = vertices[k as usize] - middle;
        [v.dot(p), v.dot(q)]
    };
    let mut points: Vec<Flat> = members.iter().map(|&k| (k, flat(k))).collect();
    points.sort_by(|(_, v), (_, w)| v[0].total_cmp(&w[0]).then(v[1].total_cmp(&w[1])));
    points.dedup_by(|(_, v), (_, w)| v == w);
    let mut ring = side(points.iter().copied());
    ring.pop();
    let mut back = side(points.iter().rev().copied());
    back.pop();
    ring.extend(back);
    let mut indices: Vec<u32> = without_straight(ring).into_iter().map(|(k, _)| k).collect();
    if indices.is_empty() {
        indices.extend(members.first());
    }
    indices
}

/// Drops what is in the middle of an edge. The walk keeps both its ends whatever they are, and
/// where an edge is square to the axis its middle may be sorted before its end.
fn without_straight(mut ring: Vec<Flat>) -> Vec<Flat> {
    let mut k = 0;
    let mut good = 0;
    while good < ring.len() && ring.len() > 3 {
        let count = ring.len();
        let [v, w, x] = [k + count - 1, k, k + 1].map(|k| ring[k % count].1);
        if turns_left(v, w, x) {
            (k, good) = ((k + 1) % count, good + 1);
        } else {
            ring.remove(k);
            // The one before has another neighbour now.
            (k, good) = ((k + count - 2) % (count - 1), 0);
        }
    }
    ring
}

/// A vertex and where it is in the plane.
type Flat = (u32, [f64; 2]);

fn turns_left(v: [f64; 2], w: [f64; 2], x: [f64; 2]) -> bool {
    let (e, f) = ([w[0] - v[0], w[1] - v[1]], [x[0] - w[0], x[1] - w[1]]);
    let threshold = STRAIGHT * e[0].hypot(e[1]) * f[0].hypot(f[1]);
    e[0] * f[1] - e[1] * f[0] > threshold
}

/// From the first to the last point, turning left at each.
fn side(points: impl Iterator<Item = Flat>) -> Vec<Flat> {
    let mut kept: Vec<Flat> = Vec::new();
    for point in points {
        while let [.., (_, v), (_, w)] = kept[..] {
            if turns_left(v, w, point.1) {
                break;
            }
            kept.pop();
        }
        kept.push(point);
    }
    kept
}
