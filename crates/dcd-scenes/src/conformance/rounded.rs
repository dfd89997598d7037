//! Shapes with a radius.

use super::bodies::{Placed, cloud, direction, hull, power_of_ten, turned};
use crate::random::Draw;
use dcd_geom::Polytope;
use glam::DVec3;

/// Spheres, capsules, rounded plates and hulls, of any scale; apart, tangent but for rounding,
/// exactly tangent, overlapping by the radii alone, and by the cores.
pub(super) fn rounded(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let scale = if k.is_multiple_of(5) { power_of_ten((k % 19) as i32 - 9) } else { 1.0 };
    if k % 6 == 5 {
        return tangent_spheres(k, draw);
    }
    let (a, b) = (body(k % 4, scale, draw)?, body(k / 4 % 4, scale, draw)?);
    let reach = a.reach() + b.reach() + a.swept_radius() + b.swept_radius();
    let spot = direction(draw) * reach * draw.between(0.2, 0.8);
    Some([(a, turned(draw, DVec3::ZERO)?), (b, turned(draw, spot)?)])
}

fn body(kind: usize, scale: f64, draw: &mut Draw) -> Option<Polytope> {
    let core = match kind {
        0 => Polytope::hull(vec![DVec3::ZERO]).ok()?,
        1 => Polytope::hull(vec![DVec3::NEG_Z * scale, DVec3::Z * scale]).ok()?,
        2 => Polytope::hull(cloud(draw, DVec3::new(scale, scale, 0.0))).ok()?,
        _ => hull(draw, scale)?,
    };
    core.rounded(draw.between(0.01, 0.5) * scale).ok()
}

/// Along 2, 3, 6, which is 7 long: tangent exactly, or off by an ulp of a radius.
fn tangent_spheres(k: usize, draw: &mut Draw) -> Option<[Placed; 2]> {
    let scale = libm::exp2(f64::from(draw.count(0..41)) - 20.0);
    let part = 0.5 + f64::from(draw.count(1..48)) / 8.0;
    let rest = match k % 3 {
        0 => 7.0 - part,
        1 => (7.0 - part).next_up(),
        _ => (7.0 - part).next_down(),
    };
    let sphere = |radius: f64| Polytope::sphere(radius * scale).ok();
    let spot = DVec3::new(2.0, 3.0, 6.0) * scale;
    Some([(sphere(part)?, turned(draw, DVec3::ZERO)?), (sphere(rest)?, turned(draw, spot)?)])
}
