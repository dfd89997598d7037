//! How far apart two cuboids are whose nearest features are known: evaluated once in f64, or in double-double.
//!
//! The features come from a search in f32 and prove nothing; what the points on them are worth is proved by a direction
//! square to all edges on which they are (docs/numerics/proofs.md, "nearest features of cuboids").

use super::long_points;
use super::segments::Proposal;
use super::{SIZES, UNIT};
use crate::double_double::{DoubleDouble, EPSILON, Sum};
use crate::{Distance, PosedSupport};
use dcd_geom::glam::DVec3;
use dcd_geom::{Kind, Polytope, Vector};

/// A point of each of two cuboids, near each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NearFeatures {
    /// Each in its cuboid's own frame, metres; infinite along an axis at whose end it is.
    pub(crate) places: [[f32; 3]; 2],
    /// Whether two edges cross there, if the point is on one of each.
    pub(crate) is_crossing: bool,
}

impl NearFeatures {
    /// Vertices of both by number, a bit for each axis, between which the points are or nearly so: the nearest of each, and from
    /// there along the edges and faces on which they are, as far as there is place.
    pub(crate) fn vertices(&self) -> [[u32; 2]; 3] {
        let nearest = self
            .places
            .map(|place| (0..3).map(|axis| u32::from(place[axis] >= 0.0) << axis).sum::<u32>());
        let (mut found, mut count) = ([nearest; 3], 1);
        for (side, place) in self.places.iter().enumerate() {
            for (axis, along) in place.iter().enumerate() {
                if along.is_finite() && count < found.len() {
                    found[count][side] ^= 1 << axis;
                    count += 1;
                }
            }
        }
        found
    }
}

/// The most that the bounds of a distance in f64 may differ by. Unit: u·m. See `NEAREST` in segments.rs.
const NEAREST: f64 = 64.0;

/// The least squared sine of two edges that cross. No unit. Smaller: places that rounding has moved.
const CROSSING: f64 = 1e-6;

/// How far a length and a separation per |d| in double-double may be off. Unit: [`EPSILON`]·m. Derived: 16.
const PADDING: f64 = 64.0;

/// How much of the distance the bounds in double-double may differ by, no unit: below an f64's last bit.
const CLOSED: f64 = f64::EPSILON / 16.0;

/// Two cuboids at their places, and a point of each in its own frame.
struct Near<'a> {
    sides: [PosedSupport<'a, Polytope>; 2],
    half: [DVec3; 2],
    points: [DVec3; 2],
    /// From b's centre to a's.
    delta: DVec3,
}

/// The distance in f64, with the bound of the other closed forms; `None` where it is not as good.
pub(crate) fn distance_in_f64(
    sides: [PosedSupport<'_, Polytope>; 2],
    features: &NearFeatures,
) -> Option<Distance> {
    let near = Near::of(sides, features)?;
    let proposal = Proposal::of_points(sides[0].into(), sides[1].into(), near.points)?;
    proposal.distance_along(near.square_to_edges(proposal.difference()), NEAREST)
}

/// The distance in double-double, right to the last bit of an f64; `None` where the bounds do not close.
pub(crate) fn distance_in_double_double(
    sides: [PosedSupport<'_, Polytope>; 2],
    features: &NearFeatures,
) -> Option<Distance> {
    Near::of(sides, features)?.certified()
}

impl<'a> Near<'a> {
    /// The nearest points of the features, in f64.
    fn of(sides: [PosedSupport<'a, Polytope>; 2], features: &NearFeatures) -> Option<Self> {
        let half = |side: PosedSupport<'_, Polytope>| match side.map.kind() {
            Kind::Cuboid { half_extents } if side.map.swept_radius() == 0.0 => Some(half_extents),
            _ => None,
        };
        let half = [half(sides[0])?, half(sides[1])?];
        let place = |k: usize| {
            DVec3::from_array(features.places[k].map(f64::from)).clamp(-half[k], half[k])
        };
        let delta = sides[0].pose.translation() - sides[1].pose.translation();
        let mut near = Self { sides, half, points: [place(0), place(1)], delta };
        match features.is_crossing.then(|| near.edges()).flatten() {
            Some(edges) => near.cross(edges)?,
            None => {
                near.project(0);
                near.project(1);
            }
        }
        Some(near)
    }

    /// The axes along which a point may move.
    fn free(&self, side: usize) -> [bool; 3] {
        let (point, half) = (self.points[side].to_array(), self.half[side].to_array());
        [0, 1, 2].map(|k| point[k].abs() < half[k])
    }

    /// The one axis of each along which its point may move, if it is one of each.
    fn edges(&self) -> Option<[usize; 2]> {
        let one = |side: usize| match self.free(side) {
            [true, false, false] => Some(0),
            [false, true, false] => Some(1),
            [false, false, true] => Some(2),
            _ => None,
        };
        Some([one(0)?, one(1)?])
    }

    /// To where two edges cross, seen along their common normal.
    fn cross(&mut self, [j, k]: [usize; 2]) -> Option<()> {
        let [turn_a, turn_b] = self.sides.map(|side| *side.pose.rotation());
        let (e, f) = (turn_a.col(j), turn_b.col(k));
        let between = (turn_b * self.points[1] - turn_a * self.points[0]) - self.delta;
        let (cosine, along_e, along_f) = (e.dot(f), e.dot(between), f.dot(between));
        let squared = 1.0 - cosine * cosine;
        if !(squared >= CROSSING) {
            return None;
        }
        let s = (along_e - cosine * along_f) / squared;
        let r = (cosine * along_e - along_f) / squared;
        let [half_a, half_b] = self.half;
        self.points[0][j] = (self.points[0][j] + s).clamp(-half_a[j], half_a[j]);
        self.points[1][k] = (self.points[1][k] + r).clamp(-half_b[k], half_b[k]);
        Some(())
    }

    /// The side whose face or edge counts first, and the other: what is level with it there need not be exactly so.
    fn order(&self) -> [usize; 2] {
        let count = |side: usize| self.free(side).into_iter().filter(|is_free| *is_free).count();
        if count(1) > count(0) { [1, 0] } else { [0, 1] }
    }

    /// Up to two directions of edges that a normal of both features is square to: both of a face, or one of each cuboid.
    fn level(&self) -> ([DVec3; 2], usize) {
        let mut found = [DVec3::ZERO; 2];
        let mut count = 0;
        for side in self.order() {
            let free = self.free(side);
            for axis in (0..3).filter(|&axis| free[axis]) {
                if count < 2 {
                    found[count] = self.sides[side].pose.rotation().col(axis);
                    count += 1;
                }
            }
        }
        (found, count)
    }

    /// Moves the point of one side to the one nearest to the other's.
    fn project(&mut self, side: usize) {
        let other = 1 - side;
        let [turn, turned] = [side, other].map(|k| *self.sides[k].pose.rotation());
        let between = if side == 0 { -self.delta } else { self.delta };
        let from_centre = turned * self.points[other] + between;
        let half = self.half[side];
        self.points[side] = (turn.transpose() * from_centre).clamp(-half, half);
    }

    /// The part of a vector that is square to the features' edges.
    fn square_to_edges(&self, w: DVec3) -> DVec3 {
        let (edges, count) = self.level();
        let [s, r] = square_to(edges, edges.map(|edge| edge.dot(w)), count);
        w + edges[0] * s + edges[1] * r
    }

    fn certified(&self) -> Option<Distance> {
        let [a, b] = self.sides;
        let reach = |body: PosedSupport<'_, Polytope>| body.reach * (1.0 + body.pose.deviation());
        let size = reach(a) + reach(b) + self.delta.norm1();
        // False for NaN.
        if !SIZES.contains(&size) {
            return None;
        }
        let w = long_points::difference(self.sides.map(|side| side.pose), self.points);
        let (edges, count) = self.level();
        let [s, r] = square_to(edges, edges.map(|edge| along(edge, &w)), count);
        let (e, f) = (edges[0].to_array(), edges[1].to_array());
        let normal = [0, 1, 2].map(|c| {
            let mut sum = Sum::from(w[c]);
            sum.add_product(e[c], s);
            sum.add_product(f[c], r);
            sum.total()
        });
        let mut squared = Sum::default();
        for part in normal {
            squared.add_product(part.high, part.high);
            squared.add(2.0 * part.high * part.low);
        }
        let distance = squared.total().sqrt().to_f64();
        let moved = edges[0] * s + edges[1] * r;
        let lost = self.lost(&normal, distance)
            + 2.0 * (s * along(edges[0], &normal)).abs()
            + 2.0 * (r * along(edges[1], &normal)).abs()
            + moved.length_squared();
        let open = lost / distance * (1.0 + 16.0 * UNIT) + PADDING * EPSILON * size;
        // False for NaN.
        if !(distance * distance > SIZES.start && open <= CLOSED * distance) {
            return None;
        }
        let normal = DVec3::from_array(normal.map(|part| part.high)).normalize() * -1.0;
        let [point_a, point_b] = [0, 1].map(|k| self.sides[k].pose.apply(self.points[k]));
        let error_bound = crate::distance::rounded_up(distance * (CLOSED + f64::EPSILON));
        Some(Distance { distance, point_a, point_b, normal, error_bound })
    }

    /// How much farther than the points' difference the cuboids' reaches back along a normal, times its length.
    fn lost(&self, normal: &[DoubleDouble; 3], length: f64) -> f64 {
        let high = DVec3::from_array(normal.map(|part| part.high));
        let unsure = 8.0 * UNIT * length;
        let mut lost = 0.0;
        for (side, sense) in [(0, 1.0), (1, -1.0)] {
            let (point, half) = (self.points[side].to_array(), self.half[side].to_array());
            for k in 0..3 {
                let axis = self.sides[side].pose.rotation().col(k);
                // The points of a are the lowest along the normal, those of b the highest.
                let at_end = point[k].abs() == half[k];
                let outward = -sense * point[k].signum() * axis.dot(high);
                if at_end && outward > unsure {
                    continue;
                }
                let part = along(axis, normal).abs();
                lost += 2.0 * half[k] * (part + PADDING * EPSILON * length);
            }
        }
        lost
    }
}

/// What must be added along each of the first `count` edges for a vector to be square to them, given its products with them.
pub(crate) fn square_to([e, f]: [DVec3; 2], along: [f64; 2], count: usize) -> [f64; 2] {
    match count {
        0 => [0.0; 2],
        1 => [-along[0] / e.dot(e), 0.0],
        _ => {
            let (ee, ff, ef) = (e.dot(e), f.dot(f), e.dot(f));
            let determinant = ee * ff - ef * ef;
            // Parallel edges have the same normals.
            if determinant < CROSSING * (ee * ff) {
                return [-along[0] / ee, 0.0];
            }
            let s = (ef * along[1] - ff * along[0]) / determinant;
            [s, (ef * along[0] - ee * along[1]) / determinant]
        }
    }
}

/// axis·w, rounded once but for [`PADDING`].
fn along(axis: DVec3, w: &[DoubleDouble; 3]) -> f64 {
    let mut sum = Sum::default();
    for (x, part) in axis.to_array().into_iter().zip(w) {
        sum.add_product(x, part.high);
        sum.add(x * part.low);
    }
    sum.total().to_f64()
}
