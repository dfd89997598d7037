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

/// From which sine of its tilt on a face has a lowest point. The corners of one that is less tilted miss it by a tenth of that, times the
/// radius, at most. Smaller: corners that turn from frame to frame while the shape rests. Larger: depths that are short by more than what
/// their bound leaves.
const SEEN: f64 = 1e-9;

/// The rim's corners in their order.
const ROUND: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// What a cylinder or cone shows along a direction of its own frame.
pub(super) struct StandIn {
    pub(super) part: Part<'static>,
    discs: [(f64, f64); 2],
    /// Across the axis towards the direction.
    lowest: DVec2,
    is_up: bool,
}

impl StandIn {
    /// Corners of the face of a cylinder or cone that looks along a unit direction of its own frame, or else the line of
    /// its side that is the lowest, or the end of that line.
    pub(super) fn of(curved: &Curved, direction: DVec3) -> Self {
        let across = direction.truncate();
        // On a level face rounding alone would say which is the lowest, and another in each frame.
        let lowest =
            if across.length_squared() > SEEN * SEEN { across.normalize() } else { DVec2::X };
        let discs = curved.discs();
        let is_up = direction.z > 0.0;
        let made = |part| Self { part, discs, lowest, is_up };
        let (_, radius) = discs[usize::from(is_up)];
        if direction.z.abs() >= FACING && radius > 0.0 {
            let normal = DVec3::Z * direction.z.signum();
            return made(Part::Face { index: 0, normal, corners: &ROUND });
        }
        let [below, above] = discs.map(|(z, radius)| (lowest * radius).extend(z));
        let (length, rise) = (below.distance(above), direction.dot(above - below));
        if length > 0.0 && rise.abs() < LEVEL * length {
            return made(Part::Edge([0, 1]));
        }
        made(Part::Vertex(u32::from(rise > 0.0)))
    }

    /// One of its corners, in the shape's own frame.
    pub(super) fn corner(&self, k: u32) -> DVec3 {
        if let Part::Face { .. } = self.part {
            let (z, radius) = self.discs[usize::from(self.is_up)];
            // Counter-clockwise seen from outside.
            let k = if self.is_up { k as usize } else { RIM.len() - 1 - k as usize };
            return (RIM[k].rotate(self.lowest) * radius).extend(z);
        }
        let (z, radius) = self.discs[k as usize];
        (self.lowest * radius).extend(z)
    }
}

impl View {
    /// What a cylinder or cone shows: see [`StandIn`].
    pub(super) fn seen_curved(&self, curved: &Curved, placed: &Placed<'_>) -> Seen<'static> {
        let stand_in = StandIn::of(curved, self.towards(placed));
        let is_edge = matches!(stand_in.part, Part::Edge(_));
        let seen = self.shown(stand_in.part, placed, |k| stand_in.corner(k));
        if is_edge { seen.of_line() } else { seen }
    }
}
