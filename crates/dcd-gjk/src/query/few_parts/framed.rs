//! A compound and another shape as the compound sees them: its parts are where it has them, and need no products of poses.

use crate::PosedShape;
use crate::UNIT;
use crate::distance::Distance;
use crate::epa::Depth;
use dcd_geom::glam::{DMat3, DVec3};
use dcd_geom::{Kind, Pose, Shape};

/// The largest deviation of a compound's pose whose frame is taken: what is seen there is as long as it is but for rounding.
/// Larger: normals that are not of unit length.
const TURNED: f64 = 1e-12;

/// What seeing the other shape from the compound's frame loses. Unit: u of both shapes' reach and their distance. Derived: 9.2.
const SEEN: f64 = 9.5;

/// The same, for what the compound's pose is off a rotation by. Unit: [`tilt`], times the same. Derived: 0.52.
const TILTED: f64 = 0.53;

/// What a row of RᵀR − I loses. Unit: u. Three entries of three products: derived 9.1.
const GRAM: f64 = 10.0;

/// Two shapes, the first in its own frame, if it is a compound; else both in the world.
pub(in crate::query) struct Framed<'a> {
    shapes: [&'a Shape; 2],
    poses: [Pose; 2],
    frame: Frame,
    /// By how much more a distance or a depth may be off than in the frame: metres.
    lost: f64,
}

/// Whose frame two shapes are seen in.
enum Frame {
    World,
    /// That of a compound at this pose.
    Own(Pose),
    /// The world's axes, round this place.
    Round(DVec3),
}

impl<'a> Framed<'a> {
    pub(in crate::query) fn of([a, b]: [PosedShape<'a>; 2]) -> Self {
        let shapes = [a.shape, b.shape];
        let in_world =
            || Self { shapes, poses: [*a.pose, *b.pose], frame: Frame::World, lost: 0.0 };
        if !matches!(a.shape, Shape::Compound(_)) || !(a.pose.deviation() <= TURNED) {
            return in_world();
        }
        let turn = a.pose.rotation().transpose();
        let place = turn * (b.pose.translation() - a.pose.translation());
        let seen = match is_round(b.shape) {
            true => Pose::from_translation(place),
            false => Pose::from_matrix(turn * *b.pose.rotation(), place),
        };
        let Ok(seen) = seen else { return in_world() };
        let extent = match b.shape {
            // Turned round its own origin, a plane is off at the compound too.
            Shape::HalfSpace(half_space) => half_space.unit_offset().abs() + place.length(),
            other => other.reach(),
        };
        let size = a.shape.reach() + extent + place.length();
        let lost = (SEEN * UNIT + TILTED * tilt(a.pose.rotation())) * size;
        Self { shapes, poses: [Pose::IDENTITY, seen], frame: Frame::Own(*a.pose), lost }
    }

    /// Two shapes in the world's axes, round the first one's origin.
    pub(in crate::query) fn round_first([a, b]: [PosedShape<'a>; 2]) -> Option<Self> {
        let place = b.pose.translation() - a.pose.translation();
        let poses =
            [a.pose.with_translation(DVec3::ZERO).ok()?, b.pose.with_translation(place).ok()?];
        let frame = Frame::Round(a.pose.translation());
        let lost = 2.0 * UNIT * place.length();
        Some(Self { shapes: [a.shape, b.shape], poses, frame, lost })
    }

    /// The two where they are seen.
    pub(in crate::query) fn sides(&self) -> [PosedShape<'_>; 2] {
        [0, 1].map(|k| PosedShape { shape: self.shapes[k], pose: &self.poses[k] })
    }

    /// Whether the first is in its own frame.
    pub(super) fn is_own(&self) -> bool {
        matches!(self.frame, Frame::Own(_))
    }

    pub(in crate::query) fn lost(&self) -> f64 {
        self.lost
    }

    /// A normal of the frame, in the world: of unit length, also where poses are hardly rotations.
    #[inline]
    pub(in crate::query) fn turned(&self, normal: DVec3) -> DVec3 {
        let turned = match &self.frame {
            Frame::Own(pose) => *pose.rotation() * normal,
            Frame::World | Frame::Round(_) => normal,
        };
        turned.normalize_or(turned)
    }

    /// A point of the frame, in the world.
    #[inline]
    pub(in crate::query) fn placed(&self, point: DVec3) -> DVec3 {
        match &self.frame {
            Frame::World => point,
            Frame::Own(pose) => pose.apply(point),
            Frame::Round(place) => point + *place,
        }
    }

    /// What a point of the world may be off beside one of the frame: metres.
    pub(in crate::query) fn rounded(&self) -> f64 {
        let far = match &self.frame {
            Frame::World => return 0.0,
            Frame::Own(pose) => pose.translation(),
            Frame::Round(place) => *place,
        };
        8.0 * f64::EPSILON * (far.length() + self.shapes[0].reach())
    }

    /// A depth of the world, seen round the first shape's origin: [`Framed::round_first`].
    pub(super) fn seen(&self, found: Depth) -> Depth {
        let Frame::Round(from) = self.frame else { return found };
        Depth { point_a: found.point_a - from, point_b: found.point_b - from, ..found }
    }

    pub(super) fn depth(&self, found: Depth) -> Depth {
        let Depth { depth, normal, point_a, point_b, error_bound } = found;
        let [point_a, point_b] = [point_a, point_b].map(|point| self.placed(point));
        Depth { depth, normal: self.turned(normal), point_a, point_b, error_bound }
    }

    pub(super) fn distance(&self, found: Distance) -> Distance {
        let Distance { distance, point_a, point_b, normal, error_bound } = found;
        let [point_a, point_b] = [point_a, point_b].map(|point| self.placed(point));
        Distance { distance, point_a, point_b, normal: self.turned(normal), error_bound }
    }
}

/// At least the norm of RᵀR − I, without what a pose's deviation has to spare.
fn tilt(&DMat3 { x_axis: x, y_axis: y, z_axis: z }: &DMat3) -> f64 {
    let squares = DVec3::new(x.dot(x), y.dot(y), z.dot(z)) - DVec3::ONE;
    let products = DVec3::new(x.dot(y), x.dot(z), y.dot(z));
    squares.abs().max_element() + 2.0 * products.abs().max_element() + GRAM * UNIT
}

/// Whether it is a sphere round its own origin, which is the same however it is turned.
fn is_round(shape: &Shape) -> bool {
    let Shape::Polytope(polytope) = shape else { return false };
    polytope.kind() == Kind::Point && polytope.vertices() == [DVec3::ZERO]
}
