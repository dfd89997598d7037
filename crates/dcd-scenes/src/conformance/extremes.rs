//! The ends of the range of numbers, and shapes on which searches cycle.

use super::bodies::{Placed, box_or_hull, moved, power_of_ten, turned};
use crate::random::Draw;
use dcd_geom::{Polytope, Pose};
use glam::DVec3;

/// Prisms over regular polygons of this many corners: their faces are planes but for rounding.
const CORNERS: [u32; 4] = [5, 6, 7, 8];

/// A prism over a regular polygon and another, or itself; coaxial, shifted, tilted by almost
/// nothing, or with corners off by almost nothing.
pub(super) fn cycling(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let off = power_of_ten(-8 - (k % 9) as i32);
    let a = prism(CORNERS[k % 4], 0.0, draw)?;
    let b = prism(CORNERS[k / 4 % 4], off, draw)?;
    let at_a = match k % 3 {
        0 => Pose::IDENTITY,
        _ => turned(draw, DVec3::ZERO)?,
    };
    let local = match k % 5 {
        0 => DVec3::ZERO,
        1 => DVec3::Z * (2.0 + off),
        2 => DVec3::Z * (2.0 - off),
        3 => DVec3::new(draw.between(-2.0, 2.0), 0.0, 0.0),
        _ => draw.point(-1.0, 1.0) * DVec3::new(2.0, 2.0, off),
    };
    Some([(a, at_a), (b, moved(&at_a, *at_a.rotation() * local)?)])
}

/// A prism of height 2 round z, its corners off by up to `off`.
fn prism(corners: u32, off: f64, draw: &mut Draw) -> Option<Polytope> {
    let mut points = Vec::new();
    for corner in 0..corners {
        let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(corners);
        let (y, x) = libm::sincos(angle);
        for z in [-1.0, 1.0] {
            points.push(DVec3::new(x, y, z) + draw.point(-1.0, 1.0) * off);
        }
    }
    Polytope::hull(points).ok()
}

/// Shapes of 1e-300 down to multiples of the least number.
pub(super) fn denormal(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let least = f64::from_bits(1);
    let size = match k % 5 {
        0 => 1e-300,
        1 => 1e-308,
        2 => 1e-315,
        3 => 64.0 * least,
        _ => 4.0 * least,
    };
    let (a, b) = (box_or_hull(k, draw, size)?, box_or_hull(k / 2, draw, size)?);
    let spot = draw.point(-1.5, 1.5) * size;
    let at_b = match k % 3 {
        0 => moved(&Pose::IDENTITY, spot)?,
        _ => turned(draw, spot)?,
    };
    Some([(a, Pose::IDENTITY), (b, at_b)])
}

/// Shapes of 1e150 up to a quarter of the largest number; also beside one that is small.
pub(super) fn huge(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let size = match k % 4 {
        0 => 1e150,
        1 => 1e250,
        2 => 1e300,
        _ => f64::MAX / 16.0,
    };
    let beside = if k % 5 == 4 { 1.0 } else { size };
    let (a, b) = (box_or_hull(k, draw, size)?, box_or_hull(k / 2, draw, beside)?);
    let spot = draw.point(-1.2, 1.2) * size;
    Some([(a, turned(draw, DVec3::ZERO)?), (b, turned(draw, spot)?)])
}
