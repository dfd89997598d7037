//! The exact judge on placed polytopes, and pairs to judge.
#![allow(dead_code, unreachable_pub)] // each test binary uses its part

pub mod cases;

use dcd_geom::glam::DVec3;
use dcd_geom::{Polytope, Pose};
use dcd_gjk::PosedSupport;
use dcd_judge::Side;

/// A polytope somewhere.
#[derive(Clone, Debug)]
pub struct PosedShape {
    pub shape: Polytope,
    pub pose: Pose,
}

impl PosedShape {
    pub fn hull(vertices: Vec<DVec3>, pose: Pose) -> Self {
        Self { shape: Polytope::hull(vertices).unwrap(), pose }
    }

    pub fn body(&self) -> PosedSupport<'_, Polytope> {
        PosedSupport::polytope(&self.shape, &self.pose)
    }

    pub fn side(&self) -> Side<'_> {
        (&self.shape, &self.pose)
    }

    /// The same, with every length of its own frame and its translation multiplied.
    pub fn scaled(&self, by: f64) -> Self {
        let vertices = self.shape.vertices().iter().map(|&v| v * by).collect();
        let shape = Polytope::hull(vertices).unwrap();
        let shape = shape.rounded(self.shape.swept_radius() * by).unwrap();
        let t = self.pose.translation() * by;
        Self { shape, pose: Pose::from_matrix(*self.pose.rotation(), t).unwrap() }
    }

    pub fn moved_to(&self, t: DVec3) -> Self {
        let pose = Pose::from_matrix(*self.pose.rotation(), t).unwrap();
        Self { shape: self.shape.clone(), pose }
    }
}

/// Whether the shapes, radii included, share a point.
pub fn touches(a: &PosedShape, b: &PosedShape) -> bool {
    dcd_judge::touches(a.side(), b.side())
}

/// Whether the distance of two shapes that are apart, radii taken off, is in low..=high, exactly.
pub fn distance_is_in(a: &PosedShape, b: &PosedShape, low: f64, high: f64) -> bool {
    dcd_judge::distance_is_in(a.side(), b.side(), low, high)
}
