//! What cylinders and cones show of themselves where they rest on a face or along a line.

use super::facing::{FACING, LEVEL, Part};
use super::feature::{Placed, Seen, View};
use dcd_geom::Curved;
use dcd_geom::glam::{DVec2, DVec3};
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

/// The rim's corners in their order.
const ROUND: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

impl View {
    /// Corners of the face of a cylinder or cone that looks the way it is seen, or else the line of its side that is
    /// the lowest, or the end of that line.
    pub(super) fn seen_curved(&self, curved: &Curved, placed: &Placed<'_>) -> Seen<'static> {
        let direction = self.towards(placed);
        let lowest = direction.truncate().try_normalize().unwrap_or(DVec2::X);
        let discs = curved.discs();
        let is_up = direction.z > 0.0;
        let (height, radius) = discs[usize::from(is_up)];
        if direction.z.abs() >= FACING && radius > 0.0 {
            let normal = DVec3::Z * direction.z.signum();
            let face = Part::Face { index: 0, normal, corners: &ROUND };
            return self.shown(face, placed, |k| {
                // Counter-clockwise seen from outside.
                let k = if is_up { k as usize } else { RIM.len() - 1 - k as usize };
                (RIM[k].rotate(lowest) * radius).extend(height)
            });
        }
        let end = |k: u32| {
            let (z, radius) = discs[k as usize];
            (lowest * radius).extend(z)
        };
        let (below, above) = (end(0), end(1));
        let (length, rise) = (below.distance(above), direction.dot(above - below));
        if length > 0.0 && rise.abs() < LEVEL * length {
            return self.shown(Part::Edge([0, 1]), placed, end).of_line();
        }
        self.shown(Part::Vertex(u32::from(rise > 0.0)), placed, end)
    }
}
