//! What the search of a depth reads of an object.

use super::rims::{self, Rims};
use super::vectors::{farthest, splat, vertex};
use dcd_geom::glam::{DMat3, DVec3, Vec3};
use dcd_geom::{Curved, Polytope};
use dcd_simd::{Block, Lanes};

/// The points of a core in the world's axes, round its centre, as f32 has them.
#[derive(Clone, Copy)]
pub(super) enum Points<'a> {
    /// The vertices of a polytope.
    Vertices(&'a [Block]),
    /// A cylinder or cone, and the vertices of a hull inside it.
    Rims(Rims, &'a [Block]),
}

impl Points<'_> {
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
    pub(super) fn of_vertex(&self, number: u32) -> (Vec3, u32) {
        match self {
            Self::Vertices(blocks) => (vertex(blocks, number as usize), number),
            Self::Rims(rims, blocks) => rims.next_to(vertex(blocks, number as usize)),
        }
    }
}

/// A core as it was given, whose points have the same numbers.
#[derive(Clone, Copy)]
pub(super) enum Body<'a> {
    Polytope(&'a Polytope),
    Curved(&'a Curved),
}

impl<'a> Body<'a> {
    /// Its points, turned; `blocks` are its vertices or those of a hull inside it.
    #[inline(always)]
    pub(super) fn points(
        self,
        (turn, centre): (&'a DMat3, DVec3),
        blocks: &'a [Block],
    ) -> Points<'a> {
        match self {
            Self::Polytope(_) => Points::Vertices(blocks),
            Self::Curved(curved) => Points::Rims(Rims::of(curved, turn, centre), blocks),
        }
    }

    /// The point of that number in its own frame. The last block is filled up with the last vertex.
    #[inline(always)]
    pub(super) fn point(self, number: u32) -> DVec3 {
        match self {
            Self::Polytope(polytope) => {
                let vertices = polytope.vertices();
                vertices[(number as usize).min(vertices.len() - 1)]
            }
            Self::Curved(curved) => rims::point(curved, number),
        }
    }

    #[inline(always)]
    pub(super) fn as_polytope(self) -> Option<&'a Polytope> {
        match self {
            Self::Polytope(polytope) => Some(polytope),
            Self::Curved(_) => None,
        }
    }

    #[inline(always)]
    pub(super) fn reach(self) -> f64 {
        match self {
            Self::Polytope(polytope) => polytope.reach(),
            Self::Curved(curved) => curved.reach(),
        }
    }

    #[inline(always)]
    pub(super) fn swept_radius(self) -> f64 {
        match self {
            Self::Polytope(polytope) => polytope.swept_radius(),
            Self::Curved(curved) => curved.swept_radius(),
        }
    }
}
