//! The covering spheres of a link sixteen at a time, against an obstacle's solid or another link's, and supports of hulls.
//!
//! Plain f64 without fused multiply-add: the same bits on every SIMD path.

use super::ROUNDED_UP;
use super::bounding_volumes::Solid;
use crate::state_checker::covers::CoverSphere;
use dcd_geom::Pose;
use dcd_simd::{Kernel, Lanes, dispatch, larger, smaller};
use glam::{DMat3, DVec3};

/// How many spheres a row holds at most.
pub(super) const ROW: usize = 16;

type Row = [f64; ROW];

/// Coordinates of sixteen points.
type Points = [Row; 3];

/// Spheres that cover a shape, in its own frame, metres.
#[derive(Clone, Debug)]
pub(super) struct CoverRow {
    centre: Points,
    /// −∞ where there is none.
    outer: Row,
    /// Of the spheres inside of the shape; −∞ where none is known.
    inner: Row,
    count: usize,
}

/// Where the spheres of a moving link are, and how far each moves in half an interval.
#[derive(Clone, Debug, Default)]
pub(super) struct PlacedRow {
    centre: Points,
    moved: Row,
}

/// What spheres say of two bodies.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowGap {
    /// The least of their gaps, less what each moves; infinite where there is none.
    pub(super) least: f64,
    /// How far apart spheres inside of both are at the least; infinite where there are none.
    pub(super) upper: f64,
    /// From one to the other where the gap is least.
    pub(super) direction: DVec3,
}

/// How the points of a link move: p by `at_base` + `turn` × (p − base).
#[derive(Clone, Copy, Debug)]
pub(super) struct RowMotion {
    pub(super) base: DVec3,
    pub(super) turn: DVec3,
    pub(super) at_base: DVec3,
    pub(super) half: f64,
    /// What accelerations add, and what no point exceeds.
    pub(super) change: f64,
    pub(super) most: f64,
}

impl CoverRow {
    /// Of at most [`ROW`] spheres.
    pub(super) fn of(spheres: &[CoverSphere]) -> Self {
        let none = [f64::NEG_INFINITY; ROW];
        let count = spheres.len().min(ROW);
        let mut row = Self { centre: [[0.0; ROW]; 3], outer: none, inner: none, count };
        for (k, sphere) in spheres[..count].iter().enumerate() {
            for axis in 0..3 {
                row.centre[axis][k] = sphere.centre[axis];
            }
            row.outer[k] = sphere.outer;
            if sphere.inner > 0.0 {
                row.inner[k] = sphere.inner;
            }
        }
        row
    }

    /// Whether there is one alone, the sphere round all of the shape.
    pub(super) fn is_one(&self) -> bool {
        self.count == 1
    }

    /// The radius of the first one's inner sphere; −∞ where none is known.
    pub(super) fn inner(&self) -> f64 {
        self.inner[0]
    }

    /// The spheres where the shape is.
    pub(super) fn place(&self, pose: &Pose, motion: &RowMotion) -> PlacedRow {
        let mut placed = PlacedRow::default();
        dispatch(PlaceRow { row: self, pose, motion, placed: &mut placed });
        placed
    }

    /// Against a solid of finite size at a pose; the direction is in the world.
    pub(super) fn against_solid(
        &self,
        placed: &PlacedRow,
        (solid, pose): (&Solid, &Pose),
    ) -> RowGap {
        let inverse = pose.rotation().transpose();
        let from = pose.translation();
        let (least, upper, k) = dispatch(AgainstSolid { row: self, placed, inverse, from, solid });
        let local = inverse * (placed.point(k) - from);
        let direction = *pose.rotation() * (solid.nearest(local).1 - local);
        RowGap { least, upper, direction }
    }

    /// Against the spheres of another link, without what either moves.
    pub(super) fn against_row(&self, placed: &PlacedRow, other: (&Self, &PlacedRow)) -> RowGap {
        let (least, upper, [k, l]) = dispatch(AgainstRow { row: (self, placed), other });
        RowGap { least, upper, direction: other.1.point(l) - placed.point(k) }
    }
}

impl PlacedRow {
    fn point(&self, k: usize) -> DVec3 {
        DVec3::new(self.centre[0][k], self.centre[1][k], self.centre[2][k])
    }
}

struct PlaceRow<'a> {
    row: &'a CoverRow,
    pose: &'a Pose,
    motion: &'a RowMotion,
    placed: &'a mut PlacedRow,
}

impl Kernel for PlaceRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { row, pose, motion, placed } = self;
        let [x, y, z] = pose.rotation().to_cols_array_2d();
        let (t, RowMotion { base, turn, at_base, half, .. }) = (pose.translation(), *motion);
        let turning = turn.length();
        let [cx, cy, cz] = &row.centre;
        for k in 0..ROW {
            let at = |i: usize| x[i] * cx[k] + y[i] * cy[k] + z[i] * cz[k] + t[i];
            let (px, py, pz) = (at(0), at(1), at(2));
            (placed.centre[0][k], placed.centre[1][k], placed.centre[2][k]) = (px, py, pz);
            let (dx, dy, dz) = (px - base.x, py - base.y, pz - base.z);
            let vx = at_base.x + (turn.y * dz - turn.z * dy);
            let vy = at_base.y + (turn.z * dx - turn.x * dz);
            let vz = at_base.z + (turn.x * dy - turn.y * dx);
            let now = (vx * vx + vy * vy + vz * vz).sqrt() + row.outer[k] * turning;
            let moved = half * now * ROUNDED_UP + motion.change;
            placed.moved[k] = smaller(motion.most, moved) * ROUNDED_UP;
        }
    }
}

struct AgainstSolid<'a> {
    row: &'a CoverRow,
    placed: &'a PlacedRow,
    inverse: DMat3,
    from: DVec3,
    solid: &'a Solid,
}

impl Kernel for AgainstSolid<'_> {
    /// The least gap, the least distance of an inner sphere, and which sphere has the least gap.
    type Output = (f64, f64, usize);

    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // plain loops over rows are those that are vectorised
    fn run<L: Lanes>(self, _: L) -> (f64, f64, usize) {
        let Self { row, placed, inverse, from, solid } = self;
        let [mx, my, mz] = inverse.to_cols_array_2d();
        let [cx, cy, cz] = &placed.centre;
        let mut far = [0.0; ROW];
        let local = |k: usize| {
            let (x, y, z) = (cx[k] - from.x, cy[k] - from.y, cz[k] - from.z);
            let at = |i: usize| mx[i] * x + my[i] * y + mz[i] * z;
            [at(0), at(1), at(2)]
        };
        match *solid {
            Solid::Box { middle, half, swept } => {
                for k in 0..ROW {
                    let [x, y, z] = local(k);
                    let x = larger(0.0, (x - middle.x).abs() - half.x);
                    let y = larger(0.0, (y - middle.y).abs() - half.y);
                    let z = larger(0.0, (z - middle.z).abs() - half.z);
                    far[k] = (x * x + y * y + z * z).sqrt() - swept;
                }
            }
            Solid::Cylinder { half, radius, swept } => {
                for k in 0..ROW {
                    let [x, y, z] = local(k);
                    let side = larger(0.0, (x * x + y * y).sqrt() - radius);
                    let end = larger(0.0, z.abs() - half);
                    far[k] = (side * side + end * end).sqrt() - swept;
                }
            }
        }
        let (mut gap, mut upper) = ([0.0; ROW], [0.0; ROW]);
        for k in 0..ROW {
            // Outer and inner radii of −∞ make infinite gaps.
            gap[k] = far[k] - row.outer[k] - placed.moved[k];
            upper[k] = far[k] - row.inner[k];
        }
        let (least, k) = first_least(&gap);
        (least, least_of(&upper), k)
    }
}

struct AgainstRow<'a> {
    row: (&'a CoverRow, &'a PlacedRow),
    other: (&'a CoverRow, &'a PlacedRow),
}

impl Kernel for AgainstRow<'_> {
    /// The least gap, the least distance of inner spheres, and which spheres have the least gap. The centres are to be finite: a gap
    /// that is no number is passed over.
    type Output = (f64, f64, [usize; 2]);

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> (f64, f64, [usize; 2]) {
        let ((row, at), (other, other_at)) = (self.row, self.other);
        let [ox, oy, oz] = &other_at.centre;
        let (mut least, mut upper, mut nearest) = (f64::INFINITY, f64::INFINITY, [0; 2]);
        for k in 0..row.count {
            let (x, y, z) = (at.centre[0][k], at.centre[1][k], at.centre[2][k]);
            let (outer, inner) = (row.outer[k], row.inner[k]);
            let (mut gap, mut within) = ([0.0; ROW], [0.0; ROW]);
            for l in 0..ROW {
                let (dx, dy, dz) = (ox[l] - x, oy[l] - y, oz[l] - z);
                let length = (dx * dx + dy * dy + dz * dz).sqrt();
                gap[l] = length - outer - other.outer[l];
                within[l] = length - inner - other.inner[l];
            }
            upper = smaller(upper, least_of(&within));
            let least_here = least_of(&gap);
            if least_here < least {
                (least, nearest) = (least_here, [k, first_least(&gap).1]);
            }
        }
        (least, larger(0.0, upper), nearest)
    }
}

/// How many points [`Farthest`] takes at once.
pub(super) const POINTS_AT_ONCE: usize = 16;

/// The largest d·p of points p, for two directions d.
pub(super) struct Farthest<'a> {
    /// Coordinates, [`POINTS_AT_ONCE`] of x, then of y, then of z.
    pub(super) points: &'a [[[f64; POINTS_AT_ONCE]; 3]],
    pub(super) directions: [DVec3; 2],
}

impl Kernel for Farthest<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> [f64; 2] {
        let [d, e] = self.directions;
        let (mut most_d, mut most_e) =
            ([f64::NEG_INFINITY; POINTS_AT_ONCE], [f64::NEG_INFINITY; POINTS_AT_ONCE]);
        for [x, y, z] in self.points {
            // One loop for both: shorter ones are unrolled before they can be vectorised.
            for k in 0..POINTS_AT_ONCE {
                let (x, y, z) = (x[k], y[k], z[k]);
                let (at_d, at_e) = (x * d.x + y * d.y + z * d.z, x * e.x + y * e.y + z * e.z);
                most_d[k] = larger(most_d[k], at_d);
                most_e[k] = larger(most_e[k], at_e);
            }
        }
        let (mut far_d, mut far_e) = (most_d[0], most_e[0]);
        for k in 1..POINTS_AT_ONCE {
            far_d = larger(far_d, most_d[k]);
            far_e = larger(far_e, most_e[k]);
        }
        [far_d, far_e]
    }
}

#[inline(always)]
fn least_of(row: &Row) -> f64 {
    let mut eight = [0.0; 8];
    for k in 0..8 {
        eight[k] = smaller(row[k + 8], row[k]);
    }
    let mut four = [0.0; 4];
    for k in 0..4 {
        four[k] = smaller(eight[k + 4], eight[k]);
    }
    smaller(smaller(four[3], four[1]), smaller(four[2], four[0]))
}

/// The least and the first that is as small.
#[inline(always)]
fn first_least(row: &Row) -> (f64, usize) {
    let least = least_of(row);
    (least, row.iter().position(|&x| x == least).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::super::tests::Draw;
    use super::*;
    use glam::DQuat;

    fn spheres(draw: &mut Draw, count: usize) -> Vec<CoverSphere> {
        let sphere = |k: usize| CoverSphere {
            centre: draw.vector(),
            outer: 0.1 + 0.01 * k as f64,
            inner: if k.is_multiple_of(3) { f64::NEG_INFINITY } else { 0.05 },
        };
        (0..count).map(sphere).collect()
    }

    fn pose(draw: &mut Draw) -> Pose {
        let turn = DQuat::from_scaled_axis(draw.vector() * 3.0);
        Pose::new(turn, draw.vector() * 2.0).unwrap()
    }

    /// The least of all, with the direction there.
    fn least(gaps: impl Iterator<Item = (f64, DVec3)>) -> (f64, DVec3) {
        gaps.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }

    fn assert_near(found: &RowGap, (gap, direction): (f64, DVec3), upper: f64) {
        assert!((found.least - gap).abs() < 1e-12, "{found:?}: {gap}");
        assert!(found.direction.distance(direction) < 1e-12, "{found:?}: {direction}");
        assert!(found.upper == upper || (found.upper - upper).abs() < 1e-12, "{found:?}: {upper}");
    }

    #[test]
    fn sixteen_spheres_are_as_far_as_each_alone() {
        let mut draw = Draw::new();
        for k in 0..200 {
            let (own, other) = (spheres(&mut draw, 1 + k % ROW), spheres(&mut draw, 1 + k % 7));
            let [own_pose, other_pose, solid_pose] = [0; 3].map(|_| pose(&mut draw));
            let motion = RowMotion {
                base: draw.vector(),
                turn: draw.vector(),
                at_base: draw.vector(),
                half: 0.1,
                change: 0.01,
                most: 0.2,
            };
            let still = RowMotion { most: 0.0, ..motion };
            let (row, other_row) = (CoverRow::of(&own), CoverRow::of(&other));
            let placed = row.place(&own_pose, &motion);
            let other_placed = other_row.place(&other_pose, &still);
            let half = draw.vector().abs() * 0.5;
            let solid = if usize::is_multiple_of(k, 2) {
                Solid::Box { middle: draw.vector(), half, swept: 0.01 }
            } else {
                Solid::Cylinder { half: half.x, radius: half.y, swept: 0.02 }
            };
            let at = |sphere: &CoverSphere| own_pose.apply(sphere.centre);
            let local =
                |p: DVec3| solid_pose.rotation().transpose() * (p - solid_pose.translation());
            let one = |sphere: &CoverSphere| {
                let (far, near) = solid.nearest(local(at(sphere)));
                let from_base = at(sphere) - motion.base;
                let speed = (motion.at_base + motion.turn.cross(from_base)).length();
                let now = speed + sphere.outer * motion.turn.length();
                let moved = (0.1 * now * ROUNDED_UP + 0.01).min(0.2);
                let direction = *solid_pose.rotation() * (near - local(at(sphere)));
                (far - sphere.outer - moved, direction)
            };
            let inside = own.iter().filter(|sphere| sphere.inner > 0.0);
            let upper = inside.map(|s| solid.nearest(local(at(s))).0 - s.inner);
            let upper = upper.fold(f64::INFINITY, f64::min);
            let found = row.against_solid(&placed, (&solid, &solid_pose));
            // What is swept is within what `ROUNDED_UP` adds.
            let wanted = least(own.iter().map(one));
            assert!((found.least - wanted.0).abs() < 1e-9, "{found:?}: {wanted:?}");
            assert_near(&RowGap { least: wanted.0, ..found }, wanted, upper);

            let pairs = || own.iter().flat_map(|a| other.iter().map(move |b| (a, b)));
            let between = |(a, b): (&CoverSphere, &CoverSphere)| {
                let between = other_pose.apply(b.centre) - at(a);
                (between.length() - a.outer - b.outer, between)
            };
            let inside = pairs().filter(|(a, b)| a.inner > 0.0 && b.inner > 0.0);
            let upper = inside.map(|(a, b)| {
                let apart = other_pose.apply(b.centre).distance(at(a));
                (apart - a.inner - b.inner).max(0.0)
            });
            let upper = upper.fold(f64::INFINITY, f64::min);
            let found = row.against_row(&placed, (&other_row, &other_placed));
            assert_near(&found, least(pairs().map(between)), upper);
        }
    }
}
