//! A cylinder or cone as a profile turned round its axis: the point of it nearest to another.

use super::SIZES;
use super::feature_normal::Tangents;
use dcd_geom::Curved;
use dcd_geom::glam::{DVec2, DVec3};

/// The part of its size that a half height and a radius have at least, for a side to have a direction. No unit. Smaller: sides
/// that are rounding.
const PLAIN: f64 = 1e-6;

/// A cylinder or cone with a height and a radius.
#[derive(Clone, Copy)]
pub(super) struct Profile {
    /// The heights and the radii of its discs, from below.
    pub(super) heights: [f64; 2],
    pub(super) radii: [f64; 2],
    /// From the lower rim to the upper: outward and up.
    side: DVec2,
    /// Over the square of its length.
    per_square: f64,
}

/// Which part of a shape a point is on; of a disc and a rim, whether it is the upper one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Inside,
    Disc(usize),
    Side,
    /// An apex too.
    Rim(usize),
}

/// The point of a core nearest to another, or that one itself, inside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    pub(super) point: DVec3,
    pub(super) part: Part,
    /// The direction of the other from the axis, of unit length.
    pub(super) outward: DVec2,
    /// The point's distance from the axis over the other's.
    shrunk: f64,
}

impl Profile {
    /// `None` of a shape that is flat, or a needle.
    pub(super) fn of(curved: &Curved) -> Option<Self> {
        let [(low, low_radius), (high, high_radius)] = curved.discs();
        let size = high + low_radius;
        let least = PLAIN * size;
        // Of lengths whose products are none the formulas below would name points off the shape.
        if !(SIZES.contains(&size) && high > least && low_radius > least) {
            return None;
        }
        let side = DVec2::new(high_radius - low_radius, high - low);
        Some(Self {
            heights: [low, high],
            radii: [low_radius, high_radius],
            side,
            per_square: 1.0 / side.length_squared(),
        })
    }

    /// The point of the core that is nearest to one of its frame.
    #[inline(always)]
    pub(super) fn foot(&self, point: DVec3) -> Foot {
        let Self { heights: [low, high], radii: [radius, _], side, .. } = *self;
        let flat = point.truncate();
        let squared = flat.length_squared();
        let across = squared.sqrt();
        let outward = if across > 0.0 { flat / across } else { DVec2::X };
        let from_rim = DVec2::new(across - radius, point.z - low);
        let is_outside = side.perp_dot(from_rim) < 0.0;
        let share = from_rim.dot(side) * self.per_square;
        if is_outside && 0.0 < share && share < 1.0 {
            let there = DVec2::new(radius, low) + side * share;
            return Foot::new(there, outward, across, Part::Side);
        }
        let up = usize::from(if is_outside { share >= 1.0 } else { point.z > high });
        let (height, radius) = (self.heights[up], self.radii[up]);
        let is_between = low <= point.z && point.z <= high;
        if across > radius && (is_outside || !is_between) {
            return Foot::new(DVec2::new(radius, height), outward, across, Part::Rim(up));
        }
        let part = if is_between { Part::Inside } else { Part::Disc(up) };
        let z = point.z.clamp(low, high);
        Foot { point: flat.extend(z), part, outward, shrunk: 1.0 }
    }

    /// How much lower or higher than a foot the nearest rim is, and which.
    pub(super) fn nearest_rim(&self, foot: &Foot) -> (f64, usize) {
        let [low, high] = self.heights.map(|height| (height - foot.point.z).abs());
        if high < low { (high, 1) } else { (low, 0) }
    }

    /// The point of a rim that is nearest to another.
    pub(super) fn foot_on_rim(&self, point: DVec3, up: usize) -> Foot {
        let across = point.truncate().length();
        let outward = if across > 0.0 { point.truncate() / across } else { DVec2::X };
        let there = DVec2::new(self.radii[up], self.heights[up]);
        Foot::new(there, outward, across, Part::Rim(up))
    }

    /// The point of a rim in a direction from the axis, of unit length.
    #[inline(always)]
    pub(super) fn on_rim(&self, outward: DVec2, up: usize) -> DVec3 {
        (outward * self.radii[up]).extend(self.heights[up])
    }

    /// A point of the side: that share of the way up, in a direction from the axis, of unit length.
    pub(super) fn on_side(&self, outward: DVec2, share: f64) -> DVec3 {
        let there = DVec2::new(self.radii[0], self.heights[0]) + self.side * share;
        (outward * there.x).extend(there.y)
    }

    /// From the lower rim up the side, in a direction from the axis.
    #[inline(always)]
    pub(super) fn up_the_side(&self, outward: DVec2) -> DVec3 {
        (outward * self.side.x).extend(self.side.y)
    }

    /// Along the part of the surface on which a point is; of one on a disc that is so near to the rim, metres, along that.
    pub(super) fn tangents(&self, foot: &Foot, edge: f64) -> Tangents {
        let round = foot.outward.perp().extend(0.0);
        let to_rim = |up: usize| (self.radii[up] - foot.point.truncate().length()).abs();
        match foot.part {
            Part::Inside => Tangents::default(),
            Part::Disc(up) if to_rim(up) < edge => Tangents { round, ..Tangents::default() },
            Part::Disc(_) => Tangents { straight: [DVec3::X, DVec3::Y], round: DVec3::ZERO },
            Part::Side => {
                Tangents { straight: [self.up_the_side(foot.outward), DVec3::ZERO], round }
            }
            Part::Rim(up) if self.radii[up] > 0.0 => Tangents { round, ..Tangents::default() },
            Part::Rim(_) => Tangents::default(),
        }
    }

    /// How much of a side's normal is along the axis: its sine.
    pub(super) fn rise(&self) -> f64 {
        -self.side.x * self.per_square.sqrt()
    }

    /// The farthest point along a direction.
    pub(super) fn farthest(&self, direction: DVec3) -> DVec3 {
        let flat = direction.truncate();
        let across = flat.length();
        let [low, high] = [0, 1].map(|k| direction.z * self.heights[k] + across * self.radii[k]);
        let up = usize::from(high > low);
        let outward = if across > 0.0 { flat / across } else { DVec2::ZERO };
        self.on_rim(outward, up)
    }

    /// How the height above a side changes with the angle of a circle of such a radius, and how that does, both over the radius; a
    /// point of it, and the directions along it and from its centre. `None` where the foot is on no side. The height, unlike its
    /// square, has a plain minimum however small it is.
    #[inline(always)]
    pub(super) fn bends(
        &self,
        foot: &Foot,
        [point, tangent, away]: [DVec3; 3],
        radius: f64,
    ) -> Option<[f64; 2]> {
        if foot.part != Part::Side {
            return None;
        }
        let slant = DVec2::new(self.side.y, -self.side.x) * self.per_square.sqrt();
        let normal = (foot.outward * slant.x).extend(slant.y);
        let round = foot.outward.perp_dot(tangent.truncate());
        let bend = slant.x * round * round / point.truncate().length();
        Some([normal.dot(tangent), radius * bend - normal.dot(away)])
    }

    /// How much the foot moves along with what it is nearest to: the share of a movement of length 1, by its square.
    #[inline(always)]
    pub(super) fn follows(&self, foot: &Foot, direction: DVec3) -> f64 {
        let flat = direction.truncate();
        let round = foot.outward.perp_dot(flat);
        let round = foot.shrunk * round * round;
        match foot.part {
            Part::Inside => 1.0,
            Part::Disc(_) => flat.length_squared(),
            Part::Rim(_) => round,
            Part::Side => {
                let along = self.up_the_side(foot.outward).dot(direction);
                round + along * along * self.per_square
            }
        }
    }
}

impl Foot {
    #[inline(always)]
    fn new(there: DVec2, outward: DVec2, across: f64, part: Part) -> Self {
        let point = (outward * there.x).extend(there.y);
        Self { point, part, outward, shrunk: there.x / across }
    }
}
