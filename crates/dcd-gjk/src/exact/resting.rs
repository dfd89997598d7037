//! What rests on what: faces that meet exactly in a plane across a world axis.
//!
//! A crate on a floor, a cup on a table: turned any way about the vertical, their faces share a
//! plane exactly, and no search in rounded numbers can prove a contact in it. Along such an axis
//! the heights are plain numbers, so that a sum of four decides exactly whether the planes coincide;
//! within the plane the faces overlap clearly, which f64 proves (docs/numerics/proofs.md, "resting").

use super::expansion::{exact_sign, filtered_sign};
use crate::UNIT;
use crate::{Difference, PosedSupport};
use dcd_geom::Polytope;
use dcd_geom::glam::{DMat3, DVec2, DVec3};
use std::cmp::Ordering;

/// How many supports the search within the plane may take. No unit. Four are the rule.
const MAX_SUPPORTS: usize = 16;

/// Where the first corner of the inner point is sought: a direction that no face likes. No unit.
const SKEW: DVec2 = DVec2::new(0.8125, 0.59375);

/// How far a vertex of the difference may be off, in u·m: as in certificate.rs. A mean of n of them,
/// mixed with two, loses n + 4 more.
const VERTEX: f64 = 5.01;

/// What a product of two points loses, in u of the sum of its two absolute products: 2, and 1 for
/// that sum's own.
const PRODUCT: f64 = 3.0;

/// Whether two polytopes without radii touch, where a plane across a world axis decides it; else `None`.
pub(crate) fn touch(
    a: PosedSupport<'_, Polytope>,
    b: PosedSupport<'_, Polytope>,
    difference: &Difference<'_, f64, Polytope, Polytope>,
) -> Option<bool> {
    // The difference has scaled the radii: one of the least floats may be 0 there.
    if a.map.swept_radius() > 0.0 || b.map.swept_radius() > 0.0 {
        return None;
    }
    let mut faces = None;
    for k in 0..3 {
        let (Some(in_a), Some(in_b)) = (Heights::of(a, k), Heights::of(b, k)) else { continue };
        let found = match (meeting(&in_a, &in_b), meeting(&in_b, &in_a)) {
            (Ordering::Greater, _) | (_, Ordering::Greater) => return Some(false),
            (Ordering::Equal, _) => [in_a.at(in_a.low), in_b.at(in_b.high)],
            (_, Ordering::Equal) => [in_a.at(in_a.high), in_b.at(in_b.low)],
            _ => continue,
        };
        // Along two axes they meet in an edge or a corner: there is no triangle to be found.
        if faces.is_some() {
            return None;
        }
        let [in_a, in_b] = found;
        faces = Some(Faces { difference, k, in_a, in_b });
    }
    faces?.overlap()
}

/// The vertices of a body along a world axis, exactly: ± one of their own coordinates, and t.
struct Heights<'a> {
    vertices: &'a [DVec3],
    column: usize,
    sign: f64,
    low: f64,
    high: f64,
    translation: f64,
}

impl<'a> Heights<'a> {
    /// If row k of R picks one coordinate.
    fn of(body: PosedSupport<'a, Polytope>, k: usize) -> Option<Self> {
        let column = picked(body.pose.rotation(), k)?;
        let sign = body.pose.rotation().col(column)[k];
        let vertices = body.map.vertices();
        let heights = vertices.iter().map(|v| sign * v[column]);
        let low = heights.clone().fold(f64::INFINITY, f64::min);
        let high = heights.fold(f64::NEG_INFINITY, f64::max);
        Some(Self { vertices, column, sign, low, high, translation: body.pose.translation()[k] })
    }

    /// The vertices at a height.
    fn at(&self, height: f64) -> Face<'a> {
        Face { vertices: self.vertices, column: self.column, coordinate: self.sign * height }
    }
}

/// The column that row k of R takes alone, as it is or negated.
fn picked(r: &DMat3, k: usize) -> Option<usize> {
    let row = r.row(k).abs();
    let column = (0..3).find(|&j| row[j] == 1.0)?;
    (row[(column + 1) % 3] == 0.0 && row[(column + 2) % 3] == 0.0).then_some(column)
}

/// The sign of the gap between the upper one's bottom and the lower one's top.
fn meeting(upper: &Heights<'_>, lower: &Heights<'_>) -> Ordering {
    let gap = [upper.low, -lower.high, upper.translation, -lower.translation];
    filtered_sign(gap).unwrap_or_else(|| exact_sign(gap))
}

/// The vertices of a hull that share a coordinate.
#[derive(Clone, Copy)]
struct Face<'a> {
    vertices: &'a [DVec3],
    column: usize,
    coordinate: f64,
}

impl Face<'_> {
    fn vertices(&self) -> impl Iterator<Item = DVec3> {
        self.vertices.iter().copied().filter(|v| v[self.column] == self.coordinate)
    }

    /// The vertex farthest along a direction of the shape's own frame.
    fn farthest(&self, direction: DVec3) -> DVec3 {
        let best = self
            .vertices()
            .map(|v| (v.dot(direction), v))
            .reduce(|best, next| if next.0 > best.0 { next } else { best });
        best.map_or(DVec3::ZERO, |(_, v)| v)
    }

    /// The mean of the vertices, and how many there are.
    fn mean(&self) -> (DVec3, f64) {
        let (sum, count) = self.vertices().fold((DVec3::ZERO, 0.0), |(s, n), v| (s + v, n + 1.0));
        (sum / count, count)
    }
}

/// A face of A and one of B in one plane across axis k.
struct Faces<'a> {
    difference: &'a Difference<'a, f64, Polytope, Polytope>,
    k: usize,
    in_a: Face<'a>,
    in_b: Face<'a>,
}

impl Faces<'_> {
    /// Whether they surely overlap: a triangle of points of their difference holds the origin by more than
    /// its rounding.
    fn overlap(&self) -> Option<bool> {
        let ((mean_a, count_a), (mean_b, count_b)) = (self.in_a.mean(), self.in_b.mean());
        let error = (VERTEX + count_a + count_b + 4.0) * UNIT * self.difference.size();
        // Off the middle, where the origin often is, and off every symmetry. The weights sum to 1.
        let mean = self.flat(self.difference.world(mean_a, mean_b));
        let corners = [SKEW, SKEW.perp()].map(|d| self.farthest(d));
        let inner = mean * 0.5 + corners[0] * 0.3125 + corners[1] * 0.1875;
        let side = inner.perp();
        let mut portal = [self.farthest(side), self.farthest(-side)];
        for _ in 0..MAX_SUPPORTS {
            let [p, q] = portal;
            if holds_origin([inner, p, q], error) {
                return Some(true);
            }
            let across = (q - p).perp();
            let outward = if across.dot(p - inner) > 0.0 { across } else { -across };
            let next = self.farthest(outward);
            if !((next - p).dot(outward) > 0.0) {
                return None;
            }
            let replaced = usize::from(next.dot(side) <= 0.0);
            portal[replaced] = next;
        }
        None
    }

    /// The point of the faces' difference farthest along a direction within the plane.
    fn farthest(&self, direction: DVec2) -> DVec2 {
        let mut world = DVec3::ZERO;
        world[(self.k + 1) % 3] = direction.x;
        world[(self.k + 2) % 3] = direction.y;
        let [local_a, local_b] = self.difference.to_local(world);
        let (a, b) = (self.in_a.farthest(local_a), self.in_b.farthest(-local_b));
        self.flat(self.difference.world(a, b))
    }

    fn flat(&self, w: DVec3) -> DVec2 {
        DVec2::new(w[(self.k + 1) % 3], w[(self.k + 2) % 3])
    }
}

/// Whether the hull of three points, each known to `error` a component, surely holds the origin:
/// every edge sees the whole square round it on its inner side. False for NaN.
fn holds_origin(points: [DVec2; 3], error: f64) -> bool {
    let [p, q, r] = points;
    let turned = if p.perp_dot(q) > 0.0 { 1.0 } else { -1.0 };
    [(p, q), (q, r), (r, p)].into_iter().all(|(x, y)| {
        let magnitude = (x.x * y.y).abs() + (x.y * y.x).abs();
        let edge = (y - x).abs().element_sum() + 4.0 * UNIT;
        let bound = PRODUCT * UNIT * magnitude + 1.01 * error * edge + f64::MIN_POSITIVE;
        turned * x.perp_dot(y) > bound
    })
}

#[cfg(test)]
mod tests;
