//! What the pairs are made of.

use crate::random::Draw;
use dcd_geom::{Polytope, Pose};
use glam::{DMat3, DVec3};

/// A shape and where it is.
pub(super) type Placed = (Polytope, Pose);

/// Four to eight points in [−1, 1]³, stretched along the axes.
pub(super) fn cloud(draw: &mut Draw, stretch: DVec3) -> Vec<DVec3> {
    let count = draw.count(4..9);
    (0..count).map(|_| draw.point(-1.0, 1.0) * stretch).collect()
}

/// The hull of a cloud in the cube of half-width `size`.
pub(super) fn hull(draw: &mut Draw, size: f64) -> Option<Polytope> {
    Polytope::hull(cloud(draw, DVec3::splat(size))).ok()
}

/// A cuboid whose half extents are multiples of 1/8 up to 1.
pub(super) fn cuboid(draw: &mut Draw) -> Option<Polytope> {
    let half = DVec3::from_array([(); 3].map(|()| f64::from(1 + draw.count(0..8)) / 8.0));
    Polytope::cuboid(half).ok()
}

/// The corners of a cuboid in the cube of half-width `size`, or a cloud in it, alternating.
pub(super) fn box_or_hull(k: usize, draw: &mut Draw, size: f64) -> Option<Polytope> {
    match k % 2 {
        0 => hull(draw, size),
        _ => sized(&cuboid(draw)?, size),
    }
}

/// The shape, every length multiplied.
pub(super) fn sized(shape: &Polytope, by: f64) -> Option<Polytope> {
    let hull = Polytope::hull(shape.vertices().iter().map(|&v| v * by).collect()).ok()?;
    hull.rounded(shape.swept_radius() * by).ok()
}

/// Turned any way, there.
pub(super) fn turned(draw: &mut Draw, t: DVec3) -> Option<Pose> {
    Pose::new(draw.rotation(), t).ok()
}

/// Not turned, there.
pub(super) fn at(t: DVec3) -> Option<Pose> {
    Pose::from_translation(t).ok()
}

/// The same rotation at another translation.
pub(super) fn moved(pose: &Pose, t: DVec3) -> Option<Pose> {
    Pose::from_matrix(*pose.rotation(), t).ok()
}

/// A rotation that carries the axes to the axes, exactly.
pub(super) fn quarter_turns(draw: &mut Draw) -> DMat3 {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let first = draw.count(0..3) as usize;
    let second = (first + 1 + draw.count(0..2) as usize) % 3;
    let x = axes[first] * sign(draw);
    let y = axes[second] * sign(draw);
    DMat3::from_cols(x, y, x.cross(y))
}

/// 1 or −1.
pub(super) fn sign(draw: &mut Draw) -> f64 {
    if draw.count(0..2) == 0 { 1.0 } else { -1.0 }
}

/// A vector no longer than √3 and not near 0.
pub(super) fn direction(draw: &mut Draw) -> DVec3 {
    loop {
        let v = draw.point(-1.0, 1.0);
        if v.length_squared() > 0.1 {
            return v;
        }
    }
}

/// 10^exponent, the same on every machine.
pub(super) fn power_of_ten(exponent: i32) -> f64 {
    libm::exp10(f64::from(exponent))
}
