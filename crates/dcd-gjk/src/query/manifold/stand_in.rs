//! Polytopes that stand for curved shapes where these rest on a face or along a line.

use dcd_geom::glam::{DVec2, DVec3};
use dcd_geom::{Curved, Polytope, Shape};
use std::borrow::Cow;
use std::f64::consts::FRAC_1_SQRT_2 as H;

/// The corners that stand for a rim, from the lowest on. Fewer: a resting face loses more of its area.
const RIM: [DVec2; 8] = [
    DVec2::new(1.0, 0.0),
    DVec2::new(H, H),
    DVec2::new(0.0, 1.0),
    DVec2::new(-H, H),
    DVec2::new(-1.0, 0.0),
    DVec2::new(-H, -H),
    DVec2::new(0.0, -1.0),
    DVec2::new(H, -H),
];

/// The polytope itself; for a cylinder or cone the hull of points of its rims, of which one is the lowest
/// along a direction of its own frame; `None` for other shapes.
pub(super) fn stand_in(shape: &Shape, direction: DVec3) -> Option<Cow<'_, Polytope>> {
    match shape {
        Shape::Polytope(polytope) => Some(Cow::Borrowed(polytope)),
        Shape::Curved(curved) => of_rims(curved, direction).map(Cow::Owned),
        _ => None,
    }
}

fn of_rims(curved: &Curved, direction: DVec3) -> Option<Polytope> {
    let lowest = direction.truncate().try_normalize().unwrap_or(DVec2::X);
    let mut points = Vec::with_capacity(2 * RIM.len());
    for (height, radius) in curved.discs() {
        let corners = if radius > 0.0 { RIM.len() } else { 1 };
        let rim = RIM[..corners].iter().map(|corner| corner.rotate(lowest) * radius);
        points.extend(rim.map(|corner| corner.extend(height)));
    }
    Polytope::hull(points).and_then(|hull| hull.rounded(curved.swept_radius())).ok()
}
