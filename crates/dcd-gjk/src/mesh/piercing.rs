//! Two triangles in f64: whether an edge of one surely goes through the inside of the other.

use super::bounds::{PIERCING, SMALLEST_EXTENT, U64};
use dcd_geom::glam::DVec3;

type Triangle = [DVec3; 3];

/// Whether two triangles surely share a point. The corners are relative to one point, each
/// coordinate within 5.01·2⁻⁵³ of `size`, which is at least the length of every corner. False where
/// that is not proved, and for NaN.
pub(super) fn touch(a: &Triangle, b: &Triangle, size: f64) -> bool {
    let all = || a.iter().chain(b).copied();
    let low = all().fold(DVec3::INFINITY, DVec3::min);
    let high = all().fold(DVec3::NEG_INFINITY, DVec3::max);
    let extent = (high - low).max_element();
    if !(extent > SMALLEST_EXTENT * U64 * size) {
        return false;
    }
    let error = PIERCING * U64 * size * extent * extent;
    goes_through(a, b, error) || goes_through(b, a, error)
}

/// Whether an edge of the first triangle goes through the second.
fn goes_through(edges: &Triangle, face: &Triangle, error: f64) -> bool {
    let sides = edges.map(|point| sign(volume(point, face), error));
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        if sides[from] * sides[to] >= 0 {
            continue;
        }
        let [a, b, c] = face.map(|corner| corner - edges[from]);
        let along = edges[to] - edges[from];
        let turns = [(a, b), (b, c), (c, a)].map(|(x, y)| sign(determinant(along, x, y), error));
        if turns[0] != 0 && turns == [turns[0]; 3] {
            return true;
        }
    }
    false
}

/// Six times the volume between a point and a triangle, with its sign.
fn volume(point: DVec3, face: &Triangle) -> f64 {
    let [a, b, c] = face.map(|corner| corner - point);
    determinant(a, b, c)
}

fn determinant(x: DVec3, y: DVec3, z: DVec3) -> f64 {
    x.dot(y.cross(z))
}

/// 1 or −1 where the sign is sure, else 0.
fn sign(x: f64, error: f64) -> i8 {
    if x > error {
        1
    } else if x < -error {
        -1
    } else {
        0
    }
}
