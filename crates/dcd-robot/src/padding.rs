//! Links made larger by a scene's `link_padding` and `link_scale`.

use super::world::Padding;
use dcd_geom::{CurvedKind, Kind, Pose, Shape, ShapeError};
use glam::DVec3;

impl Padding {
    /// The shape scaled, and then grown by the padding on all sides, never by less than MoveIt pads
    /// it: boxes and cylinders stay what they are; a cone becomes what is within the padding of it and the cone that is longer and
    /// wider by it; all else becomes what is within the padding of it.
    /// Boxes, cylinders and cones are scaled about their middle, hulls and meshes about the mean of their
    /// vertices (MoveIt: of all vertices of the mesh that a hull was made of), each part of a compound like a shape of its own. What
    /// is swept round a shape is scaled with it.
    pub(super) fn applied(&self, shape: &Shape) -> Result<Shape, ShapeError> {
        let Self { scale, padding, against_robot: _ } = *self;
        // Written so that NaN is refused. Smaller shapes would miss what the link meets.
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(ShapeError::BadLength { what: "scale", value: scale });
        }
        if !(padding >= 0.0 && padding.is_finite()) {
            return Err(ShapeError::BadLength { what: "padding", value: padding });
        }
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
                let swept = curved.swept_radius() * scale;
                match curved.kind() {
                    CurvedKind::Cylinder => {
                        Shape::cylinder(half + padding, radius + padding)?.rounded(swept)
                    }
                    CurvedKind::Cone => {
                        let round = Shape::cone(half, radius)?.rounded(swept + padding)?;
                        if padding == 0.0 {
                            return Ok(round);
                        }
                        let longer = Shape::cone(half + padding, radius + padding)?;
                        let both = [round, longer.rounded(swept)?];
                        Shape::compound(both.map(|cone| (cone, Pose::IDENTITY)).to_vec())
                    }
                    _ => Err(ShapeError::BadLength { what: "padding", value: padding }),
                }
            }
            Shape::Mesh(mesh) => {
                let vertices = scaled(mesh.vertices(), scale);
                let radius = mesh.swept_radius() * scale + padding;
                Shape::mesh(vertices, mesh.triangles().to_vec())?.rounded(radius)
            }
            Shape::Ellipsoid(ellipsoid) => {
                let radius = ellipsoid.swept_radius() * scale + padding;
                Shape::ellipsoid(ellipsoid.half_axes() * scale)?.rounded(radius)
            }
            Shape::Compound(compound) => {
                let mut parts = Vec::with_capacity(compound.parts().len());
                for part in compound.parts() {
                    match self.applied(&part.shape)? {
                        // All of a cone's stand where it stood.
                        Shape::Compound(grown) => {
                            let own = grown.parts().iter();
                            parts.extend(own.map(|own| (own.shape.clone(), part.pose)));
                        }
                        grown => parts.push((grown, part.pose)),
                    }
                }
                Shape::compound(parts)
            }
            // A half-space, scaled about a point of its plane, is what it was.
            other => other.swept(padding),
        }
    }

    /// Whether it has a meaning for a shape: what is known by its support map alone has no scale.
    pub(super) fn suits(&self, shape: &Shape) -> bool {
        self.scale == 1.0 || !matches!(shape, Shape::Custom(_))
    }
}

fn scaled(vertices: &[DVec3], scale: f64) -> Vec<DVec3> {
    if scale == 1.0 {
        return vertices.to_vec();
    }
    let middle = vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64;
    vertices.iter().map(|&vertex| middle + (vertex - middle) * scale).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::{Curved, Pose, SupportMap};
    use glam::DQuat;
    use std::sync::Arc;

    /// Another method is the box in many turns: that of the padded shape is that of the shape, scaled about the middle of
    /// what is symmetric, and the padding on all sides; of boxes and cylinders at most their corners' more.
    #[test]
    fn every_shape_is_scaled_and_grown_with_what_is_swept_round_it() {
        let half = DVec3::new(0.3, 0.2, 0.1);
        let corners = || {
            (0..8u8).map(|k| {
                let sign = |bit: u8| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
                half * DVec3::new(sign(0), sign(1), sign(2))
            })
        };
        let part = |x: f64| {
            (Shape::cylinder(0.2, 0.1).unwrap(), Pose::from_translation(DVec3::X * x).unwrap())
        };
        let triangles = vec![[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]];
        let shapes = [
            Shape::cuboid(half),
            Shape::sphere(0.2),
            Shape::capsule(0.3, 0.1),
            Shape::cylinder(0.3, 0.2),
            Shape::cone(0.3, 0.2),
            Shape::ellipsoid(half),
            Shape::hull(corners().collect()),
            Shape::mesh(corners().collect(), triangles),
            Shape::compound(vec![part(0.0), part(0.4)]),
        ];
        for shape in shapes.map(Result::unwrap) {
            for (swept, scale, padding) in
                [(0.0, 1.0, 0.02), (0.05, 1.0, 0.02), (0.05, 1.5, 0.0), (0.05, 0.5, 0.01)]
            {
                let shape = shape.swept(swept).unwrap();
                let padded =
                    Padding { scale, padding, against_robot: false }.applied(&shape).unwrap();
                for k in 0..40 {
                    let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.7, -0.2) * f64::from(k));
                    let pose = Pose::new(turn, DVec3::ZERO).unwrap();
                    let of = |shape: &Shape| shape.aabb(&pose).max.as_dvec3();
                    let due = match &shape {
                        // Each part about its own middle.
                        Shape::Compound(compound) => {
                            let parts = compound.parts().iter().map(|part| {
                                let own = part.shape.aabb(&pose).max.as_dvec3() * scale + padding;
                                own + pose.apply(part.pose.translation())
                            });
                            parts.fold(DVec3::NEG_INFINITY, DVec3::max)
                        }
                        shape => of(shape) * scale + padding,
                    };
                    let more = of(&padded) - due;
                    assert!(more.min_element() > -1e-6, "{shape:?} {scale} {padding}: {more}");
                    assert!(
                        more.max_element() < padding + 1e-6,
                        "{shape:?} {scale} {padding}: {more}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_padded_cone_holds_what_moveit_makes_of_it() {
        let cone = Shape::cone(0.05, 0.05).unwrap();
        let padded = Padding { padding: 0.02, ..Padding::NONE }.applied(&cone).unwrap();
        // Its rim, which is farther from the cone than the padding.
        let of_moveit = Shape::cone(0.07, 0.07).unwrap();
        for turn in 0..20 {
            let pose = Pose::new(DQuat::from_rotation_y(0.3 * f64::from(turn)), DVec3::ZERO);
            let [grown, due] =
                [&padded, &of_moveit].map(|shape| shape.aabb(pose.as_ref().unwrap()));
            assert!(grown.contains(&due), "{turn}");
        }
        let part = (cone, Pose::from_translation(DVec3::X).unwrap());
        let held = Shape::compound(vec![part]).unwrap();
        let held = Padding { padding: 0.02, ..Padding::NONE }.applied(&held).unwrap();
        let Shape::Compound(held) = held else { panic!("{held:?}") };
        assert_eq!(held.parts().len(), 2);
    }

    #[test]
    fn a_support_map_is_grown_and_has_no_scale() {
        let custom = Shape::Custom(Arc::new(Curved::cylinder(0.3, 0.2).unwrap()));
        let grown = Padding { padding: 0.1, ..Padding::NONE }.applied(&custom).unwrap();
        assert_eq!(grown.radius(), 0.1);
        let scaled = Padding { scale: 1.5, ..Padding::NONE };
        let floor = Shape::half_space(DVec3::Z, 0.5).unwrap();
        assert!(Padding::NONE.suits(&custom) && scaled.suits(&floor) && !scaled.suits(&custom));
    }
}
