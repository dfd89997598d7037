//! The points of an object that searches in f32 come to, of depths and of distances.

use super::vectors::{farthest, splat, vertex};
use crate::body::Body;
use crate::rims::Rims;
use dcd_geom::glam::{DMat3, DVec3, Mat3, Vec3};
use dcd_simd::{Block, Lanes};

/// The points of a core in the world's axes, round its centre, as f32 has them.
#[derive(Clone, Copy)]
pub(in crate::simd) enum Points<'a> {
    /// The vertices of a polytope.
    Vertices(&'a [Block]),
    /// A cylinder or cone, and the vertices of a hull inside it.
    Rims(TurnedRims, &'a [Block]),
}

impl<'a> Points<'a> {
    /// Of a core that is turned like that; `blocks` are its vertices, or those of a hull inside it.
    #[inline(always)]
    pub(in crate::simd) fn of(
        body: Body<'_>,
        (turn, centre): (&DMat3, DVec3),
        blocks: &'a [Block],
    ) -> Self {
        match body {
            Body::Polytope(_) => Self::Vertices(blocks),
            Body::Curved(curved) => {
                let rims = TurnedRims { rims: Rims::of(curved, centre), turn: turn.as_mat3() };
                Self::Rims(rims, blocks)
            }
        }
    }

    /// The one that is farthest along a direction, up to rounding, and its number.
    #[inline(always)]
    pub(super) fn farthest<L: Lanes>(&self, l: L, direction: Vec3) -> (Vec3, u32) {
        match self {
            Self::Vertices(blocks) => {
                let number = farthest(l, blocks, &splat(l, direction));
                (vertex(blocks, number), number as u32)
            }
            Self::Rims(rims, _) => rims.farthest(direction),
        }
    }

    /// The one for the vertex of that number in the lanes: it, or what is next to it.
    #[inline(always)]
    pub(in crate::simd) fn of_vertex(&self, number: u32) -> (Vec3, u32) {
        match self {
            Self::Vertices(blocks) => (vertex(blocks, number as usize), number),
            Self::Rims(rims, blocks) => rims.next_to(vertex(blocks, number as usize)),
        }
    }
}

/// The rims of a core in the world's axes.
#[derive(Clone, Copy)]
pub(in crate::simd) struct TurnedRims {
    rims: Rims,
    turn: Mat3,
}

impl TurnedRims {
    /// The point that is farthest along a direction, up to rounding, and its number: see [`Rims::farthest`]. Turning it loses what
    /// it does of a vertex.
    #[inline]
    pub(super) fn farthest(&self, direction: Vec3) -> (Vec3, u32) {
        let (point, number) = self.rims.farthest(self.back(direction));
        (self.turn * point, number)
    }

    /// See [`Rims::next_to`].
    fn next_to(&self, point: Vec3) -> (Vec3, u32) {
        let (point, number) = self.rims.next_to(self.back(point));
        (self.turn * point, number)
    }

    /// A vector of the world's axes in those of the shape.
    #[inline]
    fn back(&self, v: Vec3) -> Vec3 {
        let Mat3 { x_axis, y_axis, z_axis } = self.turn;
        Vec3::new(x_axis.dot(v), y_axis.dot(v), z_axis.dot(v))
    }
}
