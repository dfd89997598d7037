//! A lower bound of how deep cores overlap of which one is a cylinder, a cone or an ellipsoid, where Newton's method has found a depth
//! (docs/numerics/proofs.md, "Depth of curved cores").
//!
//! A surface of triangles is near a curved one only where it is fine. Here it has to be so only far from the depth's normal: near
//! it the pieces of A − B themselves reach far enough.

use super::least_reach::{self, Least};
use super::pieces::{Piece, Seen};
use super::surface::Surface;
use super::{ExpandingSearch, UNIT};
use crate::Vertex;
use crate::certificate::Bounds;
use crate::epa::Depth;
use crate::supports::lowest;
use dcd_geom::Shape;
use dcd_geom::glam::{DVec2, DVec3};
use dcd_simd::ArrayVec;

/// How far the nearest face may be from the best direction's reach, relative to that, for a first try; each after it has a
/// quarter. Larger: tries that prove nothing. Smaller: points that the surface would not have needed.
pub(super) const FIRST: f64 = 0.05;

/// What the next try has of that.
pub(super) const NEXT: f64 = 0.25;

/// How often a piece is added that reaches farther than those that were known. Fewer: searches that go on.
const ROUNDS: usize = 4;

/// The largest tangent of the angle within which the pieces are to reach far enough. No unit. The chords below are then no shorter
/// than their angles by more than a part in fifty, the angle's tangent no longer by more than that. Derived.
const WIDEST: f64 = 0.25;

/// What makes a tangent of two chords. Derived: 1.035.
const TO_TANGENT: f64 = 1.04;

/// The smallest tangent: below it the quotients are rounding. Larger: nothing but a needless part of the sphere.
const NARROWEST: f64 = 1e-6;

/// The least second derivative that counts as one, lengths below 1. What is divided by it is the square of a slope of 1e-10 at most.
/// Smaller: bounds that rounding makes. Larger: more pairs that are searched to the end.
const BENT: f64 = 1e-6;

/// What a slope takes from the reach, times its square over the second derivative. Derived: a half, and what rounding takes from
/// second derivatives of no less than [`BENT`].
const TILT: f64 = 0.51;

/// How far what is computed of the pieces may be off. Unit: u, lengths below 1. Derived: 40. Smaller: false bounds.
const LOST: f64 = 128.0;

/// How much farther than the pieces the difference may reach along the normal: more is another piece's. Unit: u. Larger: wider
/// bounds. Smaller: rounds for rounding.
const SAME: f64 = 64.0;

impl ExpandingSearch<'_, Shape> {
    /// The depth, if it is proved as well as the accuracy requires; from a direction, the vertices of the nearest face, and the surface.
    pub(super) fn by_pieces(
        &self,
        bounds: &Bounds<f64>,
        surface: &Surface,
        (nearest, direction): (&[Vertex<f64>; 3], DVec3),
    ) -> Option<Depth> {
        let (least, reach, upper) = self.least_reach(bounds, nearest, direction)?;
        let lower = bounds.least_reach(local_bound(&least, surface)?);
        let [a, b] = self.bodies;
        let at = |side: usize| {
            let [p, q] = &least.seen;
            p.witnesses[side] * least.weights[0] + q.witnesses[side] * least.weights[1]
        };
        let points = || [a.pose.apply(at(0)), b.pose.apply(at(1))];
        self.depth_between(bounds, [lower, reach, upper], points, least.normal)
    }

    /// Where the difference reaches least, as far as its pieces there are known; how far it does, and at most.
    fn least_reach(
        &self,
        bounds: &Bounds<f64>,
        nearest: &[Vertex<f64>; 3],
        direction: DVec3,
    ) -> Option<(Least, f64, f64)> {
        let mut pieces = ArrayVec::<Piece, { least_reach::MOST }>::new();
        for vertex in nearest {
            let piece = Piece::of(&self.difference, vertex)?;
            if !pieces.iter().any(|other| other.is_same(&piece)) {
                pieces.push(piece);
            }
        }
        let mut from = direction;
        for _ in 0..ROUNDS {
            let least = least_reach::least(&pieces, from)?;
            let (vertex, separation) = lowest(&self.difference, -least.normal);
            let reach = -separation / least.normal.length();
            if reach - least.reach() <= SAME * UNIT {
                let upper = -bounds.lower_bound(-least.normal, separation);
                return Some((least, reach, upper));
            }
            let piece = Piece::of(&self.difference, &vertex)?;
            if pieces.len() == least_reach::MOST || pieces.iter().any(|other| other.is_same(&piece))
            {
                return None;
            }
            pieces.push(piece);
            from = least.normal;
        }
        None
    }
}

/// At most the radius of a sphere round the origin inside of what the surface and the pieces span; `None` where they do not say.
fn local_bound(least: &Least, surface: &Surface) -> Option<f64> {
    let reach = least.reach();
    let chords = surface.beyond(reach, least.normal, WIDEST / TO_TANGENT)?;
    let tangent = (TO_TANGENT * chords).max(NARROWEST);
    // False for NaN.
    if !(reach > 0.0 && tangent <= WIDEST) {
        return None;
    }
    let (e, f) = least.normal.any_orthonormal_pair();
    let [p, q] = least.seen.each_ref().map(|seen| Near::of(seen, [e, f], tangent));
    let [of_p, of_q] = least.weights;
    let first = p.first * of_p + q.first * of_q;
    let second = p.second.times(of_p).plus(q.second.times(of_q));
    let apart = p.first - q.first;
    let steep = apart.length();
    let bends_apart = p.second.plus(q.second.times(-1.0)).norm();
    let reach_apart = (least.seen[0].reach - least.seen[1].reach).abs();
    // Any share of the smaller weight will do.
    [1.0, 0.25, 1.0 / 16.0].into_iter().find_map(|share| {
        let share = share * of_p.min(of_q);
        let ridge = if share > 0.0 { 2.0 * steep * share / tangent } else { 0.0 };
        let across = if steep > 0.0 { apart / steep } else { DVec2::ZERO };
        let all = Symmetric::scalar(-(reach + share * bends_apart));
        let bent = second.plus(all).plus(Symmetric::square(across).times(ridge)).least();
        (bent > BENT).then(|| {
            reach - share * reach_apart - TILT * first.length_squared() / bent - LOST * UNIT
        })
    })
}

/// How a piece lies near a direction, in the plane square to it.
struct Near {
    first: DVec2,
    /// It bends at least so much, up to that tangent.
    second: Symmetric,
}

impl Near {
    fn of(seen: &Seen, [e, f]: [DVec3; 2], tangent: f64) -> Self {
        let mut second = Symmetric::scalar(0.0);
        for bend in &seen.bends {
            if bend.length > 0.0 {
                let most = bend.length + bend.radius * tangent;
                for across in bend.across {
                    let across = DVec2::new(across.dot(e), across.dot(f));
                    second = second.plus(Symmetric::square(across).times(1.0 / most));
                }
            }
        }
        Self { first: DVec2::new(seen.point.dot(e), seen.point.dot(f)), second }
    }
}

/// A symmetric matrix of two rows: xx, xy, yy.
#[derive(Clone, Copy)]
struct Symmetric([f64; 3]);

impl Symmetric {
    fn scalar(value: f64) -> Self {
        Self([value, 0.0, value])
    }

    /// v·vᵀ.
    fn square(v: DVec2) -> Self {
        Self([v.x * v.x, v.x * v.y, v.y * v.y])
    }

    fn plus(self, other: Self) -> Self {
        Self([0, 1, 2].map(|k| self.0[k] + other.0[k]))
    }

    fn times(self, factor: f64) -> Self {
        Self(self.0.map(|value| value * factor))
    }

    /// At least how long it makes a unit vector.
    fn norm(self) -> f64 {
        let [xx, xy, yy] = self.0;
        (xx * xx + 2.0 * xy * xy + yy * yy).sqrt()
    }

    /// The smaller eigenvalue.
    fn least(self) -> f64 {
        let [xx, xy, yy] = self.0;
        let half = 0.5 * (xx - yy);
        0.5 * (xx + yy) - (half * half + xy * xy).sqrt()
    }
}
