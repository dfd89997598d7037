//! Polytopes, cylinders and cones by the numbers of their points.

use crate::rims;
use dcd_geom::glam::DVec3;
use dcd_geom::{Curved, Polytope, Shape, Support};

/// A core as it was given, and its points by the numbers that searches in f32 give them.
#[derive(Clone, Copy)]
pub(crate) enum Body<'a> {
    Polytope(&'a Polytope),
    Curved(&'a Curved),
}

impl<'a> Body<'a> {
    /// That of a polytope, cylinder or cone.
    #[inline(always)]
    pub(crate) fn of(shape: &'a Shape) -> Option<Self> {
        match shape {
            Shape::Polytope(polytope) => Some(Self::Polytope(polytope)),
            Shape::Curved(curved) => Some(Self::Curved(curved)),
            _ => None,
        }
    }

    /// The point of that number in its own frame. The last block is filled up with the last vertex.
    #[inline(always)]
    pub(crate) fn point(self, number: u32) -> DVec3 {
        match self {
            Self::Polytope(polytope) => {
                let vertices = polytope.vertices();
                vertices[(number as usize).min(vertices.len() - 1)]
            }
            Self::Curved(curved) => rims::point(curved, number),
        }
    }

    /// The same as the search in f64 knows it.
    #[inline(always)]
    pub(crate) fn support(self, number: u32) -> Support<f64> {
        match self {
            Self::Polytope(polytope) => {
                let feature = number.min(polytope.vertices().len() as u32 - 1);
                Support { point: polytope.vertices()[feature as usize], feature }
            }
            Self::Curved(_) => Support::of_point(self.point(number)),
        }
    }

    #[inline(always)]
    pub(crate) fn as_polytope(self) -> Option<&'a Polytope> {
        match self {
            Self::Polytope(polytope) => Some(polytope),
            Self::Curved(_) => None,
        }
    }

    #[inline(always)]
    pub(crate) fn reach(self) -> f64 {
        match self {
            Self::Polytope(polytope) => polytope.reach(),
            Self::Curved(curved) => curved.reach(),
        }
    }

    #[inline(always)]
    pub(crate) fn swept_radius(self) -> f64 {
        match self {
            Self::Polytope(polytope) => polytope.swept_radius(),
            Self::Curved(curved) => curved.swept_radius(),
        }
    }
}
