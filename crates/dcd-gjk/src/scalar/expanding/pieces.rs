//! What A − B has in a direction where a core is round: sums of points, discs and ellipsoids, whose reach is known with its
//! derivatives.

use crate::{Difference, Vertex};
use dcd_geom::Shape;
use dcd_geom::glam::{DMat3, DVec3};

/// The least part of a disc's or ellipsoid's radius that is seen along a direction for its farthest point to be known. No unit.
/// Smaller: points that rounding turns round a rim. Larger: more pairs that are searched to the end.
const SEEN: f64 = 1e-6;

/// A point, disc or ellipsoid of a core that its support is on, in the core's own frame, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Feature {
    centre: DVec3,
    half_axes: DVec3,
}

impl Feature {
    /// `None` of shapes whose surface is not known.
    fn of(shape: &Shape, support: DVec3) -> Option<Self> {
        match shape {
            Shape::Polytope(_) => Some(Self { centre: support, half_axes: DVec3::ZERO }),
            Shape::Ellipsoid(ellipsoid) => {
                Some(Self { centre: DVec3::ZERO, half_axes: ellipsoid.half_axes() })
            }
            Shape::Curved(curved) => {
                let [low, high] = curved.discs();
                let (z, radius) = if support.z > 0.0 { high } else { low };
                let half_axes = DVec3::new(radius, radius, 0.0);
                Some(Self { centre: DVec3::new(0.0, 0.0, z), half_axes })
            }
            _ => None,
        }
    }
}

/// A part of A − B: the sum of a feature of A and one of −B. World axes, scaled as the difference is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Piece {
    features: [Feature; 2],
    centre: DVec3,
    /// Of each of the two features the half axes: what makes it of a ball of radius 1.
    half_axes: [DMat3; 2],
}

/// How a piece lies in a unit direction n.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    /// The point that is farthest along n: the reach's derivative.
    pub(super) point: DVec3,
    /// How far that is: the reach.
    pub(super) reach: f64,
    /// How the reach of either feature bends.
    pub(super) bends: [Bend; 2],
    /// The same points in the two cores' own frames, metres.
    pub(super) witnesses: [DVec3; 2],
}

/// How far a feature reaches along n + t, t square to n, is at least what it does along n and its derivative times t, and
/// Σ(across·t)² / 2(length + radius·|t|).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bend {
    /// What its point moves along when n turns, by how round it is there.
    pub(super) across: [DVec3; 2],
    /// How far it reaches along n from its centre; 0 of a point, which does not bend.
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
            let DVec3 { x, y, z } = feature.half_axes * difference.scale();
            DMat3::from_cols(rotation.x_axis * x, rotation.y_axis * y, rotation.z_axis * z)
        };
        Some(Self {
            features,
            centre: difference.world(features[0].centre, features[1].centre),
            half_axes: [half_axes(of_a, features[0]), half_axes(of_b, features[1])],
        })
    }

    /// Whether it is of the same features.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        self.features == other.features
    }

    /// How it lies in a unit direction; `None` where that is along the axis of a disc.
    pub(super) fn seen(&self, n: DVec3) -> Option<Seen> {
        let mut seen = Seen { point: self.centre, ..Seen::default() };
        for side in 0..2 {
            let Feature { centre, half_axes } = self.features[side];
            seen.witnesses[side] = centre;
            if half_axes == DVec3::ZERO {
                continue;
            }
            let stretch = self.half_axes[side];
            let along = stretch.transpose() * n;
            let (length, radius) = (along.length(), longest(&stretch));
            // False for NaN.
            if !(length > SEEN * radius) {
                return None;
            }
            let along = along / length;
            let (e, f) = along.any_orthonormal_pair();
            seen.point += stretch * along;
            seen.bends[side] = Bend { across: [stretch * e, stretch * f], length, radius };
            // That of −B is the point of B farthest against n.
            seen.witnesses[side] += half_axes * if side == 0 { along } else { -along };
        }
        seen.reach = seen.point.dot(n);
        Some(seen)
    }
}

/// At least how long a matrix makes a unit vector: the root of the largest sum of a row of products of its columns.
fn longest(m: &DMat3) -> f64 {
    let columns = [m.x_axis, m.y_axis, m.z_axis];
    let row = |column: DVec3| columns.iter().map(|other| column.dot(*other).abs()).sum::<f64>();
    let most = columns.into_iter().map(row).fold(0.0, f64::max);
    most.sqrt() * (1.0 + 16.0 * f64::EPSILON)
}
