//! What cylinders and cones show of themselves where they rest on a face or along a line, as polytopes.

use super::feature::FACING;
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

/// A polytope that shows along a direction what the shape shows, and how large the shape is.
pub(super) struct StandIn<'a> {
    pub(super) polytope: Cow<'a, Polytope>,
    pub(super) size: f64,
}

impl<'a> StandIn<'a> {
    /// The polytope itself; for a cylinder or cone corners of the face that looks along a direction of its own
    /// frame, of unit length, or else the line of its side that is the lowest; `None` for other shapes.
    pub(super) fn of(shape: &'a Shape, direction: DVec3) -> Option<Self> {
        match shape {
            Shape::Polytope(polytope) => {
                let size = polytope.outer_radius();
                Some(Self { polytope: Cow::Borrowed(polytope), size })
            }
            Shape::Curved(curved) => {
                let polytope = Cow::Owned(shown(curved, direction)?);
                Some(Self { polytope, size: curved.reach() })
            }
            _ => None,
        }
    }
}

fn shown(curved: &Curved, direction: DVec3) -> Option<Polytope> {
    let lowest = direction.truncate().try_normalize().unwrap_or(DVec2::X);
    let discs = curved.discs();
    let (height, radius) = discs[usize::from(direction.z > 0.0)];
    let polytope = if direction.z.abs() >= FACING && radius > 0.0 {
        let corner = |k: usize| (RIM[k].rotate(lowest) * radius).extend(height);
        // Counter-clockwise seen from outside.
        let corners = (0..RIM.len()).map(|k| if direction.z > 0.0 { k } else { RIM.len() - 1 - k });
        Polytope::polygon(corners.map(corner).collect(), DVec3::Z * direction.z.signum())
    } else {
        let mut ends = discs.map(|(z, radius)| (lowest * radius).extend(z)).to_vec();
        ends.dedup();
        Polytope::polygon(ends, DVec3::ZERO)
    };
    polytope.and_then(|shown| shown.rounded(curved.swept_radius())).ok()
}
