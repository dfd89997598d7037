//! What a rank brings along.

use crate::{RankError, Transport};
use dcd_geom::glam::DVec3;
use dcd_geom::{Aabb, Pose, Scene, Shape};

/// An object of the whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Its name: no other body of any rank has it. Contacts are told by it, the smaller first.
    pub name: u64,
    /// Its shape's index in the share.
    pub shape: u32,
    /// Where it is.
    pub pose: Pose,
}

/// Some of the objects, whichever: they are moved to where they belong.
#[derive(Clone, Debug, Default)]
pub struct Share {
    /// The shapes, each with a name; one name is one shape, on all ranks.
    pub shapes: Vec<(u64, Shape)>,
    /// The bodies that place them.
    pub bodies: Vec<Body>,
}

impl Share {
    /// The objects of a scene of moving objects: body k is named `first` + k, and `shape_name` names the shapes.
    pub fn of_scene(scene: &Scene, first: u64, shape_name: impl Fn(usize) -> u64) -> Self {
        let shapes = scene.shapes().iter().enumerate();
        let shapes = shapes.map(|(k, shape)| (shape_name(k), shape.clone())).collect();
        let bodies = scene.poses().iter().enumerate().map(|(k, &pose)| Body {
            name: first + k as u64,
            shape: scene.shape_index(k),
            pose,
        });
        Self { shapes, bodies: bodies.collect() }
    }

    /// That every body has a shape.
    pub(crate) fn check(&self) -> Result<(), RankError> {
        let shapes = self.shapes.len();
        let lost = self.bodies.iter().find(|body| body.shape as usize >= shapes);
        match lost {
            None => Ok(()),
            Some(&Body { name, shape, .. }) => {
                Err(RankError::NoSuchShape { body: name, shape: shape as usize, shapes })
            }
        }
    }
}

/// A box round a shape in its own frame, from which a box in the world is made at the cost of a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    centre: DVec3,
    half: DVec3,
    radius: f64,
}

/// By how much of its coordinates and its size a box is grown: f64 and f32 round by less, and so do the boxes
/// of every narrow phase, which lie inside of it.
const SLACK: f64 = 1.0 / (1u64 << 20) as f64;

impl Bounds {
    /// Of a polytope; of another shape, which no message holds, nothing.
    pub(crate) fn of(shape: &Shape) -> Option<Self> {
        let polytope = shape.as_polytope()?;
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (min, max) = polytope
            .vertices()
            .iter()
            .fold(nothing, |(min, max), &vertex| (min.min(vertex), max.max(vertex)));
        let centre = min + (max - min) * 0.5;
        Some(Self {
            centre,
            half: (max - centre).max(centre - min),
            radius: polytope.swept_radius(),
        })
    }

    /// A box that holds the shape at that pose, and all within `grown` metres of it. The same on all ranks.
    #[inline]
    pub(crate) fn aabb(&self, pose: &Pose, grown: f64) -> Aabb {
        let turn = pose.rotation();
        let centre = pose.apply(self.centre);
        let [x, y, z] = self.half.to_array();
        let half = turn.x_axis.abs() * x + turn.y_axis.abs() * y + turn.z_axis.abs() * z;
        // R may be a rotation up to some 1e-6, by which a sphere is no sphere.
        let half = half + self.radius * (1.0 + pose.deviation()) + grown;
        let size = centre.abs().max_element() + half.max_element() + self.centre.length();
        let half = half + size * SLACK;
        Aabb { min: (centre - half).as_vec3(), max: (centre + half).as_vec3() }
    }
}

/// What `result` is on this rank, if it is no error on any: else the first rank's error, in words.
pub(crate) fn agree<T>(
    transport: &impl Transport,
    result: Result<T, RankError>,
) -> Result<T, RankError> {
    let own = result.as_ref().err().map(ToString::to_string).unwrap_or_default();
    let all = transport.all_gather(own.as_bytes());
    let failed = all.iter().position(|message| !message.is_empty());
    match (result, failed) {
        (Ok(value), None) => Ok(value),
        (Err(error), _) => Err(error),
        (Ok(_), Some(rank)) => {
            let message = String::from_utf8_lossy(&all[rank]).into_owned();
            Err(RankError::Elsewhere { rank, message })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcd_geom::glam::DQuat;

    #[test]
    fn the_box_holds_the_shapes_own_wherever_it_is() {
        let points = vec![DVec3::ZERO, DVec3::X * 3.0, DVec3::Y, DVec3::new(0.2, 0.3, -2.0)];
        let shapes = [
            Shape::hull(points).unwrap(),
            Shape::sphere(0.3).unwrap(),
            Shape::capsule(0.5, 0.25).unwrap(),
            Shape::cuboid(DVec3::new(0.01, 2.0, 30.0)).unwrap(),
        ];
        for (k, shape) in shapes.iter().enumerate() {
            let bounds = Bounds::of(shape).unwrap();
            for turn in 0..50 {
                let angle = f64::from(turn) * 0.4;
                let axis = DVec3::new(angle.sin(), 1.0, angle.cos()).normalize();
                let spot = DVec3::new(angle, -angle, 1.0) * [1.0, 1e-3, 1e5, 1e9][k];
                let pose = Pose::new(DQuat::from_axis_angle(axis, angle), spot).unwrap();
                let (outer, inner) = (bounds.aabb(&pose, 0.5), shape.aabb(&pose));
                assert!(outer.min.cmplt(inner.min).all() && outer.max.cmpgt(inner.max).all());
            }
        }
    }
}
