//! How far two parts reach past each other along a direction: at least their depth.

use super::bounds::U64;
use super::side::Part;
use crate::Verdict;
use crate::closed::{self, PosedCore, nearest_of_triangle};
use crate::epa::Depth;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Pose, Shape, SupportMap};

/// What a reach along a direction loses. Unit: u·m. Twelve and a half as [`gap_along`](crate::scalar::distance::gap_along)'s and 8u of
/// at most 2m for the length, and a margin. Larger: pairs that are measured for nothing. Smaller: bounds that do not hold.
const REACH: f64 = 40.0;

/// See `SUPPORT_ERROR` in certificate.rs.
const SUPPORT_ERROR: f64 = 1.7321;

/// Sizes of a pair, metres, whose squares and products stay clear of under- and overflow.
const SIZES: std::ops::Range<f64> = 1e-70..1e70;

/// How far from a triangle, relative to the pair's size, a sphere's centre must be for the direction from there to be
/// known. Larger: more pairs that need the triangle's normal as well. Smaller: directions that are rounding.
const CLEAR: f64 = 1e-6;

/// Two parts where they are.
pub(super) struct Couple<'a> {
    parts: [Part<'a>; 2],
    poses: [&'a Pose; 2],
    /// From the first's origin to the second's.
    delta: DVec3,
    /// m: at least the lengths that are computed with.
    size: f64,
}

/// A direction from the first shape to the second, as any of their parts see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Direction {
    /// World, of any length.
    world: DVec3,
    /// In the first's frame, and against it in the second's.
    local: [DVec3; 2],
    /// How far the second's origin is along it from the first's; metres times the length.
    delta: f64,
    length: f64,
}

/// How far a part reaches towards others of one shape along a direction.
#[derive(Clone, Copy)]
pub(super) struct SecondAlong {
    /// In the first's frame, of any length.
    direction: DVec3,
    /// Against the direction, from the first's origin; metres times the length.
    reach: f64,
    length: f64,
    /// Of both.
    radii: f64,
}

impl Direction {
    pub(super) fn world(&self) -> DVec3 {
        self.world
    }
}

impl SecondAlong {
    /// How far it and a triangle reach past each other, for [`Couple::slack`] of any of that shape's.
    #[inline]
    pub(super) fn of_triangle(&self, corners: &[DVec3; 3]) -> f64 {
        self.of(farthest(corners, self.direction))
    }

    /// The same of a first part that reaches so far along the direction.
    #[inline]
    fn of(&self, of_first: f64) -> f64 {
        (of_first + self.reach) / self.length + self.radii
    }
}

/// How long the longest edge of a triangle is.
#[inline]
pub(super) fn longest_edge([p, q, r]: [DVec3; 3]) -> f64 {
    let squares = [p.distance_squared(q), q.distance_squared(r), r.distance_squared(p)];
    squares[0].max(squares[1]).max(squares[2]).sqrt()
}

/// The most of x·d over a triangle.
#[inline]
fn farthest([p, q, r]: &[DVec3; 3], direction: DVec3) -> f64 {
    let (p, q, r) = (p.dot(direction), q.dot(direction), r.dot(direction));
    let most = if q > p { q } else { p };
    if r > most { r } else { most }
}

impl<'a> Couple<'a> {
    /// `None` for parts without supports, and for sizes near the ends of the range.
    // Made where it is kept: what is copied right after it has been written is waited for.
    #[inline(always)]
    pub(super) fn of(parts: [Part<'a>; 2], poses: [&'a Pose; 2]) -> Option<Self> {
        let delta = poses[1].translation() - poses[0].translation();
        let mut size = delta.abs().element_sum();
        for (part, pose) in parts.iter().zip(poses) {
            size += part.reach_of_core()? * (1.0 + pose.deviation());
        }
        let radius: f64 = parts.iter().map(Part::radius).sum();
        if !(SIZES.contains(&size) && radius < SIZES.end) {
            return None;
        }
        Some(Self { parts, poses, delta, size })
    }

    /// The same of another triangle of the first's mesh, which all lengths count already.
    #[inline(always)]
    pub(super) fn take_triangle(&mut self, other: [DVec3; 3]) {
        if let Part::Triangle { corners, .. } = &mut self.parts[0] {
            *corners = other;
        }
    }

    #[inline]
    pub(super) fn parts(&self) -> &[Part<'a>; 2] {
        &self.parts
    }

    pub(super) fn poses(&self) -> [&'a Pose; 2] {
        self.poses
    }

    /// From the first's origin to the second's, metres.
    pub(super) fn delta(&self) -> DVec3 {
        self.delta
    }

    /// m: at least the lengths that are computed with, metres.
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// Whether a depth's bound is at most a part `relative` of it or `of_size` of the pair's size.
    #[inline]
    pub(super) fn is_good(&self, [relative, of_size]: [f64; 2]) -> impl Fn(&Depth) -> bool + use<> {
        let most_open = of_size * self.size;
        move |found| found.error_bound <= (relative * found.depth).max(most_open)
    }

    /// The depth of a triangle and a sphere or capsule whose cores do not meet, from the first to the second; `None` of
    /// others.
    pub(super) fn by_nearest(&self) -> Option<Depth> {
        closed::depth_of_cores(self.round()?, closed::AS_F64)
    }

    /// Whether a triangle and a sphere or capsule touch, where their nearest points prove it; and from the second's to
    /// the first's, world.
    pub(super) fn verdict_by_nearest(&self) -> Option<(Verdict<()>, DVec3)> {
        closed::overlap_of_cores(self.round()?)
    }

    /// The cores of a triangle and of a sphere or capsule.
    #[inline(always)]
    fn round(&self) -> Option<[PosedCore<'_>; 2]> {
        let core = |k: usize| match &self.parts[k] {
            Part::Triangle { corners, radius, .. } => {
                Some(PosedCore::triangle(corners, *radius, self.poses[k]))
            }
            Part::Shape(shape) => {
                let core = shape.as_polytope()?;
                let is_round = matches!(core.kind(), Kind::Point | Kind::Segment);
                is_round.then(|| PosedCore::polytope(core, self.poses[k]))
            }
        };
        let is_triangle = self.parts.each_ref().map(|part| matches!(part, Part::Triangle { .. }));
        (is_triangle[0] != is_triangle[1]).then(|| Some([core(0)?, core(1)?]))?
    }

    /// An upper bound of how deep they overlap: how far they reach past each other from a triangle's point that is nearest to a
    /// sphere's centre, or along the normals of a triangle and of a box; infinite where none is a triangle.
    pub(super) fn most(&self) -> f64 {
        let mut least = f64::INFINITY;
        for k in 0..2 {
            let Part::Triangle { corners: [p, q, r], .. } = self.parts[k] else { continue };
            if let Some(direction) = self.off_nearest(k) {
                least = least.min(self.most_along(direction));
                if direction.length() > CLEAR * self.size {
                    continue;
                }
            }
            let normal = *self.poses[k].rotation() * (q - p).cross(r - p);
            // Along it or against it: whichever is the shorter way.
            least = least.min(self.most_along(normal)).min(self.most_along(-normal));
            // A small triangle that is deep inside a box leaves it by a face of the box.
            if self.parts[1 - k].is_cuboid() {
                let DMat3 { x_axis, y_axis, z_axis } = *self.poses[1 - k].rotation();
                for axis in [x_axis, y_axis, z_axis] {
                    least = least.min(self.most_along(axis)).min(self.most_along(-axis));
                }
            }
        }
        least
    }

    /// From the point of a triangle that is nearest to the other part's centre, if that is a sphere, from the first to
    /// the second.
    fn off_nearest(&self, triangle: usize) -> Option<DVec3> {
        let other = 1 - triangle;
        let Part::Triangle { corners, .. } = self.parts[triangle] else { return None };
        let centre = self.parts[other].centre_of_sphere()?;
        let sense = if triangle == 0 { 1.0 } else { -1.0 };
        let rotation = self.poses[triangle].rotation();
        let in_world = *self.poses[other].rotation() * centre + self.delta * sense;
        let seen = rotation.transpose() * in_world;
        Some(*rotation * (seen - nearest_of_triangle(corners, seen)) * sense)
    }

    /// How far they reach past each other along a direction from the first to the second; rounded.
    pub(super) fn along(&self, direction: DVec3) -> f64 {
        self.along_direction(&self.direction(direction))
    }

    /// The same along one that any pair of parts of the two shapes has seen.
    pub(super) fn along_direction(&self, direction: &Direction) -> f64 {
        let second = self.second_towards(direction);
        second.of(self.parts[0].farthest(second.direction))
    }

    pub(super) fn direction(&self, world: DVec3) -> Direction {
        let [turn_a, turn_b] = self.poses.map(Pose::rotation);
        Direction {
            world,
            local: [turn_a.transpose() * world, turn_b.transpose() * -world],
            delta: world.dot(self.delta),
            length: world.length(),
        }
    }

    /// What the second reaches towards the first along a direction from there.
    pub(super) fn second_along(&self, direction: DVec3) -> SecondAlong {
        self.second_towards(&self.direction(direction))
    }

    #[inline(always)]
    fn second_towards(&self, direction: &Direction) -> SecondAlong {
        let &Direction { local: [in_a, in_b], delta, length, .. } = direction;
        SecondAlong {
            direction: in_a,
            reach: self.parts[1].farthest(in_b) - delta,
            length,
            radii: self.parts[0].radius() + self.parts[1].radius(),
        }
    }

    /// What rounding, and supports that are not exact, may have cost.
    pub(super) fn slack(&self) -> f64 {
        let [a, b] = &self.parts;
        let support_error = a.support_error() + b.support_error();
        REACH * U64 * (self.size + (a.radius() + b.radius())) + 2.0 * SUPPORT_ERROR * support_error
    }

    /// At least that; infinite for no direction.
    pub(super) fn most_along(&self, direction: DVec3) -> f64 {
        self.at_most_by(direction, self.along(direction))
    }

    /// The same, from their reach [`along`](Self::along) it.
    pub(super) fn at_most_by(&self, direction: DVec3, reach: f64) -> f64 {
        let most = reach + self.slack();
        // A direction whose square underflows, or that is not finite, proves nothing.
        let is_known = SIZES.contains(&direction.length()) && most.is_finite();
        if is_known { most } else { f64::INFINITY }
    }

    /// At least the sum of the two diameters; [`Couple::slack`] is known.
    #[inline(always)]
    pub(super) fn diameters(&self, slack: f64) -> f64 {
        self.diameters_with(self.parts[1].diameter(), slack)
    }

    /// The same where [`Couple::second_diameter`] is known, of any triangles of one mesh.
    #[inline(always)]
    pub(super) fn diameters_with(&self, second: f64, slack: f64) -> f64 {
        (self.parts[0].diameter() + second) * (1.0 + REACH * U64) + slack
    }

    pub(super) fn second_diameter(&self) -> f64 {
        self.parts[1].diameter()
    }
}

impl Part<'_> {
    /// Of a part that has supports: at least the distance of its core's points from its frame's origin.
    fn reach_of_core(&self) -> Option<f64> {
        match self {
            Self::Triangle { reach, .. } => Some(*reach),
            Self::Shape(shape) => (shape.is_convex() && shape.is_bounded()).then(|| shape.reach()),
        }
    }

    pub(super) fn radius(&self) -> f64 {
        match self {
            Self::Triangle { radius, .. } => *radius,
            Self::Shape(shape) => shape.radius(),
        }
    }

    fn support_error(&self) -> f64 {
        match self {
            Self::Triangle { .. } => 0.0,
            Self::Shape(shape) => shape.support_error(),
        }
    }

    /// The most of x·d over the core, in its own frame.
    fn farthest(&self, direction: DVec3) -> f64 {
        match self {
            Self::Triangle { corners, .. } => farthest(corners, direction),
            Self::Shape(shape) => match shape.as_polytope().map(|core| (core.kind(), core)) {
                Some((Kind::Cuboid { half_extents }, _)) => direction.abs().dot(half_extents),
                Some((Kind::Point | Kind::Segment, core)) => core
                    .vertices()
                    .iter()
                    .fold(f64::NEG_INFINITY, |most, v| most.max(v.dot(direction))),
                _ => shape.support(direction).point.dot(direction),
            },
        }
    }

    #[inline(always)]
    fn diameter(&self) -> f64 {
        let core = match self {
            Self::Triangle { corners: [p, q, r], .. } => longest_edge([*p, *q, *r]),
            Self::Shape(shape) => match shape.as_polytope() {
                Some(core) => 2.0 * core.outer_radius(),
                None => 2.0 * shape.reach(),
            },
        };
        core + 2.0 * self.radius()
    }

    /// Whether it is a sphere.
    pub(super) fn is_sphere(&self) -> bool {
        self.centre_of_sphere().is_some()
    }

    fn is_cuboid(&self) -> bool {
        self.kind().is_some_and(|kind| matches!(kind, Kind::Cuboid { .. }))
    }

    pub(super) fn is_hull(&self) -> bool {
        self.kind() == Some(Kind::Hull)
    }

    /// Of a polytope.
    fn kind(&self) -> Option<Kind> {
        let Self::Shape(Shape::Polytope(core)) = self else { return None };
        Some(core.kind())
    }

    fn centre_of_sphere(&self) -> Option<DVec3> {
        let Self::Shape(Shape::Polytope(core)) = self else { return None };
        (core.kind() == Kind::Point).then(|| core.vertices().first().copied())?
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{Depths, PairSolver, PosedShape, Verdict};
    use dcd_geom::Polytope;
    use dcd_geom::glam::DQuat;

    /// In [−1, 1).
    fn draw(state: &mut u64) -> f64 {
        *state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Each component so.
    pub(in crate::mesh) fn vector(state: &mut u64) -> DVec3 {
        DVec3::new(draw(state), draw(state), draw(state))
    }

    #[test]
    fn no_pair_is_deeper_than_its_bound_and_a_spheres_bound_is_its_depth() {
        let kinds = [
            Shape::sphere(0.5).unwrap(),
            Shape::capsule(0.4, 0.3).unwrap(),
            Shape::cuboid(DVec3::new(0.3, 0.5, 0.4)).unwrap(),
            Shape::cylinder(0.4, 0.3).unwrap(),
        ];
        let (mut state, mut touching, mut spheres) = (7, 0, 0);
        for round in 0..4000 {
            let shape = &kinds[round % kinds.len()];
            let corners = [0; 3].map(|_| vector(&mut state) * 0.4);
            let triangle = Shape::from(Polytope::mesh_triangle(corners).unwrap());
            let far = if round % 3 == 0 { vector(&mut state) * 1e6 } else { DVec3::ZERO };
            let mut pose = || {
                let turn = DQuat::from_scaled_axis(vector(&mut state) * 3.0);
                Pose::new(turn, far + vector(&mut state) * 0.4).unwrap()
            };
            let poses = [pose(), pose()];
            let sides = [&triangle, shape];
            let [a, b] = [0, 1].map(|k| PosedShape { shape: sides[k], pose: &poses[k] });
            let Verdict::Touching(found) = Depths.solve(a, b, &mut Default::default()) else {
                continue;
            };
            touching += 1;
            let part = Part::Triangle { corners, reach: triangle.reach(), radius: 0.0 };
            let parts = [part, Part::Shape(shape)];
            for order in [[0, 1], [1, 0]] {
                let couple = Couple::of(order.map(|k| parts[k]), order.map(|k| &poses[k])).unwrap();
                let most = couple.most();
                assert!(found.depth - found.error_bound <= most, "{round}: {found:?}, {most}");
                let sense = if order[0] == 0 { 1.0 } else { -1.0 };
                let least = couple.along(found.normal * sense) - couple.slack();
                let along = [least, couple.diameters(couple.slack())];
                assert!(along[0] <= found.depth + found.error_bound + 1e-7, "{round}: {along:?}");
                assert!(found.depth <= along[1], "{round}: {along:?}");
                if round % kinds.len() == 0 && most < 0.499 {
                    spheres += 1;
                    let slack = 1e-12 + 1e-14 * far.length();
                    assert!(most <= found.depth + found.error_bound + slack, "{round}: {most}");
                }
            }
        }
        assert!(touching > 1500 && spheres > 300, "{touching}, {spheres}");
    }

    #[test]
    fn what_is_round_is_as_deep_as_its_nearest_points_say() {
        let kinds = [Shape::sphere(0.5).unwrap(), Shape::capsule(0.4, 0.3).unwrap()];
        let (mut state, mut touching, mut apart) = (17, 0, 0);
        for round in 0..3000 {
            let shape = &kinds[round % 2];
            let mut corners = [0; 3].map(|_| vector(&mut state));
            match round / 2 % 4 {
                // A needle, a segment, and a point.
                0 => corners[2] = corners[0].lerp(corners[1], 0.5) + vector(&mut state) * 1e-12,
                1 => corners[2] = corners[1],
                2 if round % 3 == 0 => corners = [corners[0]; 3],
                _ => {}
            }
            let far = if round % 5 == 0 { vector(&mut state) * 1e5 } else { DVec3::ZERO };
            let mut pose = || {
                let turn = DQuat::from_scaled_axis(vector(&mut state) * 3.0);
                Pose::new(turn, far + vector(&mut state)).unwrap()
            };
            let poses = [pose(), pose()];
            // A hull has no formula: the search judges.
            let triangle = Shape::hull(corners.to_vec()).unwrap();
            let [a, b] = [(&triangle, &poses[0]), (shape, &poses[1])]
                .map(|(shape, pose)| PosedShape { shape, pose });
            let due = Depths.solve(a, b, &mut Default::default());
            let parts = [
                Part::Triangle { corners, reach: triangle.reach(), radius: 0.0 },
                Part::Shape(shape),
            ];
            for order in [[0, 1], [1, 0]] {
                let sense = if order[0] == 0 { 1.0 } else { -1.0 };
                let couple = Couple::of(order.map(|k| parts[k]), order.map(|k| &poses[k])).unwrap();
                match couple.verdict_by_nearest() {
                    Some((Verdict::Touching(()), _)) => {
                        assert!(matches!(due, Verdict::Touching(_)), "{round}");
                    }
                    Some(_) => {
                        assert!(matches!(due, Verdict::Apart), "{round}");
                        apart += 1;
                    }
                    None => {}
                }
                let (Some(found), Verdict::Touching(due)) = (couple.by_nearest(), &due) else {
                    continue;
                };
                let bound = found.error_bound + due.error_bound;
                assert!((found.depth - due.depth).abs() <= bound, "{round}: {found:?} {due:?}");
                let most = couple.along(found.normal) + couple.slack();
                assert!(found.depth - found.error_bound <= most, "{round}: {found:?} {most}");
                assert!(
                    most <= found.depth + found.error_bound + 1e-9,
                    "{round}: {found:?} {most}"
                );
                let slack = 1e-13 * (1.0 + far.length());
                let between = found.point_a - found.point_b - found.normal * found.depth;
                assert!(between.length() <= slack + 1e-12, "{round}: {found:?}");
                assert!(found.normal.dot(due.normal) * sense > 0.0 || due.depth < 1e-6, "{round}");
                touching += 1;
            }
        }
        assert!(touching > 400 && apart > 4000, "{touching} {apart}");
    }
}
