//! One of the two shapes: its parts, and the tree over them.

use super::ITSELF;
use crate::PosedShape;
use dcd_geom::glam::{DVec3, Vec3};
use dcd_geom::{Aabb, Compound, Mesh, PartTree, Pose, Shape, SupportMap};
use dcd_simd::IndexRow;

/// A placed shape as its parts.
pub(super) struct Side<'a> {
    pub(super) parts: Parts<'a>,
    pub(super) pose: &'a Pose,
    /// At least the distance of every point, and of every box's corner, from the origin of the
    /// shape's frame.
    pub(super) reach: f64,
}

#[derive(Clone, Copy)]
pub(super) enum Parts<'a> {
    /// A convex shape.
    One(&'a Shape),
    Compound(&'a Compound),
    Mesh(&'a Mesh),
}

/// A part, in the frame of its shape.
#[derive(Clone, Copy)]
pub(super) enum Part<'a> {
    Shape(&'a Shape),
    /// Three corners, at most so far from the origin, and a swept radius.
    Triangle {
        corners: [DVec3; 3],
        reach: f64,
        radius: f64,
    },
}

impl<'a> Side<'a> {
    #[inline(always)]
    pub(super) fn of(placed: PosedShape<'a>) -> Self {
        let (parts, reach) = match placed.shape {
            Shape::Compound(compound) => (Parts::Compound(compound), compound.tree().reach()),
            Shape::Mesh(mesh) => (Parts::Mesh(mesh), mesh.tree().reach() + mesh.swept_radius()),
            convex => (Parts::One(convex), convex.reach()),
        };
        Self { parts, pose: placed.pose, reach }
    }

    pub(super) fn count(&self) -> u32 {
        match self.parts {
            Parts::One(_) => 1,
            Parts::Compound(compound) => compound.parts().len() as u32,
            Parts::Mesh(mesh) => mesh.triangles().len() as u32,
        }
    }

    /// The tree over the parts; a convex shape needs none.
    pub(super) fn tree(&self) -> Option<&'a PartTree> {
        match self.parts {
            Parts::One(_) => None,
            Parts::Compound(compound) => Some(compound.tree()),
            Parts::Mesh(mesh) => Some(mesh.tree()),
        }
    }

    pub(super) fn mesh(&self) -> Option<&'a Mesh> {
        match self.parts {
            Parts::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }

    pub(super) fn root(&self) -> u32 {
        self.tree().map_or(0, |tree| tree.root() as u32)
    }

    pub(super) fn is_leaf(&self, block: u32) -> bool {
        self.tree().is_none_or(|tree| (block as usize) < tree.leaf_count())
    }

    /// What the boxes of a block stand for.
    pub(super) fn below(&self, block: u32) -> &'a IndexRow {
        self.tree().map_or(&ITSELF, |tree| &tree.below()[block as usize])
    }

    /// Swept round the parts and not in the tree's boxes.
    pub(super) fn radius(&self) -> f64 {
        self.mesh().map_or(0.0, Mesh::swept_radius)
    }

    pub(super) fn part(&self, k: u32) -> Part<'a> {
        match self.parts {
            Parts::One(shape) => Part::Shape(shape),
            Parts::Compound(compound) => Part::Shape(compound.parts()[k as usize].placed()),
            Parts::Mesh(mesh) => Part::Triangle {
                corners: mesh.corners(k as usize).unwrap_or_default(),
                reach: mesh.reach(),
                radius: mesh.swept_radius(),
            },
        }
    }
}

/// The smallest and largest coordinate of a convex shape along each of three directions, rounded.
pub(super) fn extent(shape: &Shape, rows: [DVec3; 3], stretch: f64) -> (DVec3, DVec3) {
    if let Shape::Polytope(polytope) = shape {
        let [x, y, z] = rows;
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &v in polytope.vertices() {
            let along = DVec3::new(x.dot(v), y.dot(v), z.dot(v));
            (min, max) = (min.min(along), max.max(along));
        }
        let radius = polytope.swept_radius() * stretch;
        return (min - radius, max + radius);
    }
    let along = |d: DVec3| {
        let error = shape.support_error() * d.abs().element_sum();
        d.dot(shape.support(d).point) + error + shape.radius() * stretch
    };
    (-DVec3::from_array(rows.map(|d| along(-d))), DVec3::from_array(rows.map(along)))
}

/// An f32 box of these corners, larger on every side by `margin`, which covers their rounding.
#[inline(always)]
pub(super) fn grown(min: DVec3, max: DVec3, margin: f32) -> Aabb {
    Aabb { min: min.as_vec3() - Vec3::splat(margin), max: max.as_vec3() + Vec3::splat(margin) }
}
