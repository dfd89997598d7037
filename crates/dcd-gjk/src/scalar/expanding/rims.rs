//! What A − B has in a direction where a core is a cylinder or a cone: sums of points and of the rims of discs, whose reach is
//! known with its derivatives.

use crate::{Difference, Vertex};
use dcd_geom::Shape;
use dcd_geom::glam::{DMat3, DVec2, DVec3};

/// The least part of a rim's radius that is seen across a direction for its farthest point to be known. No unit. Smaller: points that
/// rounding turns round the rim. Larger: more pairs that are searched to the end.
const ACROSS: f64 = 1e-6;

/// The point or the rim that a core's support is on, in the core's own frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Feature {
    centre: DVec3,
    /// 0 of a point.
    radius: f64,
}

impl Feature {
    /// `None` of shapes whose surface is not known.
    fn of(shape: &Shape, support: DVec3) -> Option<Self> {
        match shape {
            Shape::Polytope(_) => Some(Self { centre: support, radius: 0.0 }),
            Shape::Curved(curved) => {
                let [low, high] = curved.discs();
                let (z, radius) = if support.z > 0.0 { high } else { low };
                Some(Self { centre: DVec3::new(0.0, 0.0, z), radius })
            }
            _ => None,
        }
    }
}

/// A part of A − B: the sum of a feature of A and one of −B. World axes, scaled as the difference is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    features: [Feature; 2],
    centre: DVec3,
    /// Of each of the two rims the half axes; 0 of a point.
    rims: [[DVec3; 2]; 2],
}

impl Default for Piece {
    fn default() -> Self {
        let none = Feature { centre: DVec3::ZERO, radius: 0.0 };
        Self { features: [none; 2], centre: DVec3::ZERO, rims: [[DVec3::ZERO; 2]; 2] }
    }
}

/// How a piece lies in a unit direction n.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    /// The point that is farthest along n: the reach's derivative.
    pub(super) point: DVec3,
    /// How far that is: the reach.
    pub(super) reach: f64,
    /// How the reach of either rim bends.
    pub(super) bends: [Bend; 2],
    /// The same points in the two cores' own frames, metres.
    pub(super) witnesses: [DVec3; 2],
}

/// How far a rim reaches along n + t, t square to n, is at least what it does along n and its derivative times t, and
/// (across·t)² / 2(length + radius·|t|).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bend {
    /// What its point moves along when n turns, as long as the rim's radius.
    pub(super) across: DVec3,
    /// How far it reaches along n from its centre.
    pub(super) length: f64,
    /// At least how far it reaches along any direction.
    pub(super) radius: f64,
}

impl Piece {
    /// The piece that a vertex of the difference is on; `None` of shapes whose surface is not known.
    pub(super) fn of(
        difference: &Difference<'_, f64, Shape, Shape>,
        vertex: &Vertex<f64>,
    ) -> Option<Self> {
        let (a, b) = difference.maps();
        let features = [Feature::of(a, vertex.a.point)?, Feature::of(b, vertex.b.point)?];
        let [of_a, of_b] = difference.rotations();
        let half_axes = |rotation: DMat3, feature: Feature| {
            let radius = feature.radius * difference.scale();
            [rotation.x_axis * radius, rotation.y_axis * radius]
        };
        Some(Self {
            features,
            centre: difference.world(features[0].centre, features[1].centre),
            rims: [half_axes(of_a, features[0]), half_axes(of_b, features[1])],
        })
    }

    /// Whether it is of the same features.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        self.features == other.features
    }

    /// How it lies in a unit direction; `None` where that is along a rim's axis.
    pub(super) fn seen(&self, n: DVec3) -> Option<Seen> {
        let mut seen = Seen { point: self.centre, ..Seen::default() };
        for side in 0..2 {
            let Feature { centre, radius } = self.features[side];
            seen.witnesses[side] = centre;
            if radius == 0.0 {
                continue;
            }
            let [x, y] = self.rims[side];
            let across = DVec2::new(x.dot(n), y.dot(n));
            let length = across.length();
            let square = x.length_squared().max(y.length_squared()) + x.dot(y).abs();
            let most = square.sqrt() * (1.0 + 8.0 * f64::EPSILON);
            // False for NaN.
            if !(length > ACROSS * most) {
                return None;
            }
            let DVec2 { x: along_x, y: along_y } = across / length;
            seen.point += x * along_x + y * along_y;
            seen.bends[side] = Bend { across: y * along_x - x * along_y, length, radius: most };
            // That of −B is the point of B farthest against n.
            let sense = if side == 0 { radius } else { -radius };
            seen.witnesses[side] += DVec3::new(along_x * sense, along_y * sense, 0.0);
        }
        seen.reach = seen.point.dot(n);
        Some(seen)
    }
}
