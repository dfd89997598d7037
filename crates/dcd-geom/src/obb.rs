//! Two OBBs on the same axes, one round a shape and one inside it: tighter than spheres for a shape that is
//! long or flat.

use crate::Pose;
use crate::sphere::{Sphere, Surface, extreme_points};
use glam::{DMat3, DVec3};

/// An OBB that holds a shape's core and one that the core holds, both round the centre of its inner
/// sphere, on the same axes. All in the shape's own frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObbBounds {
    /// The directions of the edges, as columns, orthonormal up to 1e-14.
    pub axes: DMat3,
    /// Half the edges of the OBB that holds the core, rounded up.
    pub outer: DVec3,
    /// Half the edges of the OBB inside the core, rounded down; 0 where none was found.
    pub inner: DVec3,
}

/// A shape gets its OBBs where its inner sphere is smaller than this share of its outer one: for others the
/// spheres and the axis between the centres decide as much. No unit. Larger: OBBs for round shapes, which
/// cost a stage and decide little. Smaller: more pairs of flat and long shapes need a solver.
const THIN: f64 = 0.5;

/// What the OBBs are grown and shrunk by, relative to the shape's size: three hundred times the
/// rounding of all that is computed for them.
const MARGIN: f64 = 1e-12;

/// The largest deviation of a pose from a rotation whose columns serve as axes.
const ORTHONORMAL: f64 = 1e-14;

/// How much of a turned OBB's shortest edge its inner OBB must keep. No unit. Larger: more OBBs far
/// from their compound's origin are taken for hulls. Smaller: inner OBBs that say little. Never an
/// answer.
const FAITHFUL: f64 = 0.999;

impl ObbBounds {
    /// The bounds of a cuboid round the origin with these half extents: both OBBs are the cuboid.
    pub(crate) fn of_cuboid(half_extents: DVec3) -> Self {
        Self { axes: DMat3::IDENTITY, outer: half_extents, inner: half_extents }
    }

    /// The bounds of the core with each of its points R·v + t rounded, round the rounded place of
    /// the centre; `size` is at least the length of any of these. `None` where an inner OBB is flat, or
    /// so small or so far from a rotation that rounding would show.
    ///
    /// Where no point is off by more than ε, a hull reaches along any unit n as far as the exact one
    /// less ε; an OBB in that with half edges shorter by ε reaches ε·|n|₁ ≥ ε less far, so the hull
    /// holds it. R is within its deviation of a rotation, R·v + t loses less than 8u of the size.
    pub fn rotated(&self, pose: &Pose, size: f64) -> Option<Self> {
        let off = 4.0 * pose.deviation() * size + MARGIN * size;
        let (outer, inner) = (self.outer + off, self.inner - off);
        // Written so that NaN has no OBBs.
        let thick = inner.min_element() > FAITHFUL * self.inner.min_element();
        let turned = pose.deviation() < ORTHONORMAL && outer.is_finite();
        (thick && turned).then_some(Self { axes: *pose.rotation() * self.axes, outer, inner })
    }

    /// Along the frame's own axes, with these half edges, for a shape with spheres of these radii
    /// inside and round it; `None` where it is too round to gain.
    pub fn axis_aligned(outer: DVec3, inner: DVec3, spheres: (f64, f64)) -> Option<Self> {
        let thin = spheres.0 < THIN * spheres.1 && outer.is_finite();
        thin.then_some(Self { axes: DMat3::IDENTITY, outer, inner })
    }

    /// Whether both are one OBB, so that the shape is that OBB.
    pub fn is_exact(&self) -> bool {
        self.inner == self.outer
    }

    /// An OBB round points that are all within that distance of a place, and where its middle is; none is inside.
    pub(crate) fn round(points: &[DVec3], near: DVec3, radius: f64) -> Option<(DVec3, Self)> {
        let fit = |axes: DMat3| {
            let to_axes = axes.transpose();
            let along = points.iter().map(|&p| to_axes * (p - near));
            let ends = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let (low, high) = along.fold(ends, |(low, high), p| (low.min(p), high.max(p)));
            (axes, (low + high) / 2.0, (high - low) / 2.0)
        };
        let mean = points.iter().map(|&p| (p - near) / points.len() as f64).sum::<DVec3>() + near;
        let (axes, middle, half) = [DMat3::IDENTITY, principal_axes(points, mean)]
            .map(fit)
            .into_iter()
            .min_by(|a, b| surface_area(a.2).total_cmp(&surface_area(b.2)))?;
        let centre = near + axes * middle;
        let outer = half + MARGIN * (radius + near.abs().max_element());
        let is_finite = outer.is_finite() && centre.is_finite();
        is_finite.then_some((centre, Self { axes, outer, inner: DVec3::ZERO }))
    }

    /// The bounds of the hull of these points, round the centre of that sphere inside it; `None` where the hull
    /// is too round to gain, or its size overflows.
    pub(crate) fn of_hull(points: &[DVec3], inside: Sphere, outer_radius: f64) -> Option<Self> {
        if !(inside.radius < THIN * outer_radius) || !outer_radius.is_finite() {
            return None;
        }
        let chosen = extreme_points(points);
        let (axes, outer) = [DMat3::IDENTITY, principal_axes(&chosen, inside.centre)]
            .map(|axes| (axes, extent(points, &axes, inside.centre)))
            .into_iter()
            .min_by(|a, b| surface_area(a.1).total_cmp(&surface_area(b.1)))?;
        let outer = outer + MARGIN * outer_radius;
        let surface = Surface::around(&chosen);
        let inner = surface.and_then(|surface| largest_inside(&surface, inside, &axes, outer));
        let inner = (inner.unwrap_or(DVec3::ZERO) - MARGIN * outer_radius).max(DVec3::ZERO);
        outer.is_finite().then_some(Self { axes, outer, inner })
    }
}

/// How far the points reach along each axis, to either side of the centre.
fn extent(points: &[DVec3], axes: &DMat3, centre: DVec3) -> DVec3 {
    let to_axes = axes.transpose();
    points.iter().fold(DVec3::ZERO, |most, &p| most.max((to_axes * (p - centre)).abs()))
}

/// Half the surface of an OBB, in quarters: what the chance of being met grows with.
fn surface_area(half: DVec3) -> f64 {
    half.x * half.y + half.y * half.z + half.z * half.x
}

/// An OBB inside the surface: the outer one shrunk until it misses every face, then grown along one
/// axis after the other as far as it still does.
///
/// A convex region round the sphere's centre that meets no face lies inside the hull, as the sphere
/// does (docs/numerics/proofs.md, "inner spheres"); an OBB misses a face if it stays on the inner side of the
/// nearest of its corners.
fn largest_inside(
    surface: &Surface<'_>,
    inside: Sphere,
    axes: &DMat3,
    outer: DVec3,
) -> Option<DVec3> {
    if !(inside.radius > 0.0) {
        return None;
    }
    let faces: Vec<(DVec3, f64)> = surface
        .planes(inside.centre)
        .map(|(inward, clearance)| ((axes.transpose() * inward).abs(), clearance))
        .collect();
    let scale = faces.iter().fold(1.0, |s: f64, (n, clearance)| s.min(clearance / n.dot(outer)));
    let mut half = outer * scale;
    for axis in 0..3 {
        let along = DVec3::AXES[axis];
        let rest = half - half * along;
        let limit = faces.iter().fold(outer[axis], |limit: f64, (n, clearance)| {
            let free = clearance - n.dot(rest);
            if n[axis] * limit > free { free / n[axis] } else { limit }
        });
        half = rest + along * limit;
    }
    // False for NaN.
    (half.min_element() > 0.0 && half.is_finite()).then_some(half)
}

/// The directions in which the points spread most and least: the eigenvectors of their second
/// moments about the centre, by Jacobi's rotations.
fn principal_axes(points: &[DVec3], centre: DVec3) -> DMat3 {
    let size = points.iter().fold(0.0, |m: f64, &p| m.max((p - centre).abs().max_element()));
    let mut moments = DMat3::ZERO;
    for &p in points {
        let v = (p - centre) / size;
        moments += DMat3::from_cols(v * v.x, v * v.y, v * v.z);
    }
    let mut axes = DMat3::IDENTITY;
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let turn = annihilating(&moments, p, q);
            moments = turn.transpose() * moments * turn;
            axes *= turn;
        }
    }
    if axes.is_finite() { axes } else { DMat3::IDENTITY }
}

/// Jacobi's method doubles its digits from sweep to sweep; the axes need no more than a few.
const SWEEPS: usize = 6;

/// The rotation in the plane of axes p and q that makes the symmetric m's entry (p, q) vanish.
fn annihilating(m: &DMat3, p: usize, q: usize) -> DMat3 {
    let off = m.col(q)[p];
    if off == 0.0 {
        return DMat3::IDENTITY;
    }
    let theta = (m.col(q)[q] - m.col(p)[p]) / (2.0 * off);
    let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    let mut turn = DMat3::IDENTITY;
    turn.col_mut(p)[p] = cosine;
    turn.col_mut(q)[q] = cosine;
    turn.col_mut(q)[p] = sine;
    turn.col_mut(p)[q] = -sine;
    turn
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points in a box by a linear congruence, turned.
    fn cloud(count: usize, size: DVec3, turn: DMat3) -> Vec<DVec3> {
        let mut state = 7u64;
        let mut unit = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        (0..count).map(|_| turn * (DVec3::new(unit(), unit(), unit()) * size)).collect()
    }

    fn boxes(points: &[DVec3]) -> (Sphere, ObbBounds) {
        let inside = Sphere::inside(points);
        let outer_radius = Sphere::around(inside.centre, points).radius;
        (inside, ObbBounds::of_hull(points, inside, outer_radius).unwrap())
    }

    #[test]
    fn the_outer_box_holds_every_point_and_the_hull_every_corner_of_the_inner() {
        let turn = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(1.1);
        for (count, size) in [
            (60, DVec3::new(0.2, 0.2, 4.0)),
            (80, DVec3::new(2.0, 2.0, 0.05)),
            (12, DVec3::new(1.0, 0.1, 3.0)),
            (500, DVec3::new(1.0, 0.1, 3.0)),
        ] {
            let points = cloud(count, size, turn);
            let (inside, reference) = boxes(&points);
            for &p in &points {
                let local = (reference.axes.transpose() * (p - inside.centre)).abs();
                assert!(local.cmple(reference.outer).all());
            }
            assert!(reference.inner.min_element() > 0.0, "{size}");
            for k in 0..8u32 {
                let sign = |bit: u32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let corner = reference.inner * DVec3::new(sign(0), sign(1), sign(2));
                assert!(is_inside(&points, inside.centre + reference.axes * corner), "{size} {k}");
            }
        }
    }

    #[test]
    fn a_box_round_points_holds_them_wherever_they_are_and_fits_a_turned_box() {
        let turn = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(1.1);
        for (size, far) in [
            (DVec3::new(1.0, 0.4, 3.0), 0.0),
            (DVec3::new(1.0, 0.5, 0.0), 10.0),
            (DVec3::new(5.0, 0.0, 0.0), 1e6),
            (DVec3::ZERO, 1.0),
        ] {
            let place = DVec3::new(far, -far, 0.5 * far);
            let points: Vec<DVec3> =
                cloud(400, size, turn).into_iter().map(|p| p + place).collect();
            let (near, radius) = (place + 0.1 * size, 2.0 * size.length());
            let (centre, obb) = ObbBounds::round(&points, near, radius).unwrap();
            for &p in &points {
                let local = (obb.axes.transpose() * (p - centre)).abs();
                assert!(local.cmple(obb.outer).all(), "{size} {far}: {local} {obb:?}");
            }
            // A cloud's principal axes are nearly those of its box.
            let [area, own] = [surface_area(obb.outer), surface_area(0.5 * size)];
            assert!(area <= 1.3 * own + 1e-5, "{size} {far}: {area} {own}");
        }
    }

    /// Whether no direction separates p from the points, by many directions and the gradient: the
    /// point of the hull nearest to p is p.
    fn is_inside(points: &[DVec3], p: DVec3) -> bool {
        // Frank and Wolfe's method, from the first point; ends at p or proves that it is outside.
        let mut nearest = points[0];
        for _ in 0..20000 {
            let d = p - nearest;
            if d.length() < 1e-4 {
                return true;
            }
            let farthest = points
                .iter()
                .copied()
                .fold(points[0], |best, q| if q.dot(d) > best.dot(d) { q } else { best });
            if farthest.dot(d) < p.dot(d) {
                return false;
            }
            let step = farthest - nearest;
            nearest += step * (d.dot(step) / step.length_squared()).clamp(0.0, 1.0);
        }
        // Slow to converge, but no direction separates.
        true
    }

    #[test]
    fn a_turned_box_has_boxes_as_good_as_its_own() {
        let half = DVec3::new(0.3, 0.5, 2.0);
        let turn = glam::DQuat::from_rotation_z(0.4) * glam::DQuat::from_rotation_x(1.1);
        for place in [DVec3::ZERO, DVec3::new(3.0, -20.0, 7.0), DVec3::new(0.0, 3e7, 0.0)] {
            let pose = Pose::new(turn, place).unwrap();
            let reference =
                ObbBounds::of_cuboid(half).rotated(&pose, half.length() + place.length()).unwrap();
            let size = 4.0 + place.length();
            assert!(
                (reference.outer - reference.inner).max_element() < 1e-11 * size,
                "{reference:?}"
            );
            for corner in [half, -half, half * DVec3::new(1.0, -1.0, 1.0)] {
                let local = (reference.axes.transpose() * (pose.apply(corner) - place)).abs();
                assert!(local.cmple(reference.outer).all() && local.cmpge(reference.inner).all());
            }
        }
    }

    #[test]
    fn flat_boxes_far_ones_and_those_that_are_stretched_are_taken_for_hulls() {
        let half = DVec3::ONE;
        let of = |half: DVec3, pose: &Pose| {
            ObbBounds::of_cuboid(half).rotated(pose, half.length() + pose.translation().length())
        };
        assert_eq!(of(DVec3::new(1.0, 0.0, 1.0), &Pose::IDENTITY), None);
        assert_eq!(of(half, &Pose::from_translation(DVec3::X * 1e10).unwrap()), None);
        let stretched = Pose::from_matrix(DMat3::IDENTITY * (1.0 + 1e-8), DVec3::ZERO).unwrap();
        assert_eq!(of(half, &stretched), None);
    }

    #[test]
    fn a_needle_has_boxes_along_it_and_a_round_hull_has_none() {
        let turn = DMat3::from_rotation_y(0.7);
        let (_, reference) = boxes(&cloud(200, DVec3::new(0.2, 0.2, 4.0), turn));
        let most = reference.outer.max_element();
        assert!(most < 2.2 && reference.outer.min_element() < 0.15, "{reference:?}");
        assert!(reference.inner.max_element() > 0.5, "{reference:?}");
        let round = cloud(200, DVec3::ONE, turn);
        let inside = Sphere::inside(&round);
        let outer = Sphere::around(inside.centre, &round).radius;
        assert_eq!(ObbBounds::of_hull(&round, inside, outer), None);
    }

    #[test]
    fn flat_sets_have_an_outer_box_alone_and_the_largest_ones_finite_ones() {
        let flat = cloud(50, DVec3::new(1.0, 1.0, 0.0), DMat3::from_rotation_x(0.3));
        let (_, reference) = boxes(&flat);
        assert!(
            reference.inner == DVec3::ZERO && reference.outer.min_element() < 1e-9,
            "{reference:?}"
        );
        let huge: Vec<DVec3> = flat.iter().map(|&p| p * f64::MAX).collect();
        let inside = Sphere::inside(&huge);
        let outer = Sphere::around(inside.centre, &huge).radius;
        let reference = ObbBounds::of_hull(&huge, inside, outer);
        assert!(
            reference.is_none_or(
                |reference| reference.outer.is_finite() && reference.inner == DVec3::ZERO
            )
        );
    }
}
