//! Links made larger by a scene's `link_padding` and `link_scale`.

use super::world::Padding;
use dcd_geom::{CurvedKind, Kind, Shape, ShapeError};
use glam::DVec3;

impl Padding {
    /// The shape scaled, and then grown by the padding on all sides, never by less than MoveIt grows
    /// it: boxes and cylinders stay what they are; all else becomes what is within the padding of it.
    /// Boxes and cylinders are scaled about their middle, hulls and meshes about the mean of their
    /// vertices.
    pub(super) fn applied(&self, shape: &Shape) -> Result<Shape, ShapeError> {
        let Self { scale, padding, against_robot: _ } = *self;
        match shape {
            Shape::Polytope(polytope) => match polytope.kind() {
                Kind::Cuboid { half_extents } if polytope.swept_radius() == 0.0 => {
                    Shape::cuboid(half_extents * scale + padding)
                }
                _ => {
                    let radius = polytope.swept_radius() * scale + padding;
                    Shape::hull(scaled(polytope.vertices(), scale))?.rounded(radius)
                }
            },
            Shape::Curved(curved) => {
                let (half, radius) = (curved.half_height() * scale, curved.radius() * scale);
                match curved.kind() {
                    CurvedKind::Cylinder => Shape::cylinder(half + padding, radius + padding),
                    CurvedKind::Cone => Shape::cone(half, radius)?.rounded(padding),
                    _ => Err(ShapeError::BadLength { what: "padding", value: padding }),
                }
            }
            Shape::Mesh(mesh) => {
                let vertices = scaled(mesh.vertices(), scale);
                Shape::mesh(vertices, mesh.triangles().to_vec())?.rounded(padding)
            }
            Shape::Ellipsoid(ellipsoid) => {
                let radius = ellipsoid.swept_radius() * scale + padding;
                Shape::ellipsoid(ellipsoid.half_axes() * scale)?.rounded(radius)
            }
            other => other.swept(padding),
        }
    }
}

fn scaled(vertices: &[DVec3], scale: f64) -> Vec<DVec3> {
    if scale == 1.0 {
        return vertices.to_vec();
    }
    let middle = vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64;
    vertices.iter().map(|&vertex| middle + (vertex - middle) * scale).collect()
}
