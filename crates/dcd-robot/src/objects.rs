//! The shapes of collision objects.

use super::frames::Frames;
use super::kinematics::JointFrame;
use super::message::{MeshMessage, ObjectMessage, Place, Primitive};
use super::{Obstacle, RobotError, world};
use dcd_geom::{Pose, PoseError, Shape};
use glam::{DQuat, DVec3};

impl ObjectMessage {
    /// The object's shapes with their poses in the world.
    pub(super) fn obstacles(&self, frames: &Frames<'_>) -> Result<Vec<Obstacle>, RobotError> {
        let user = format!("object {:?}", self.id);
        let refused =
            |why: &str| Err(RobotError::Refused { user: user.clone(), why: why.to_owned() });
        if !self.planes.is_empty() {
            return refused("planes are not supported");
        }
        let outer = frames.find(&self.header.frame_id, &user)?;
        let pose = |error| RobotError::Pose { user: user.clone(), error };
        // What is in the world's own frame keeps its pose bit for bit.
        let outer =
            (outer != JointFrame::IDENTITY).then(|| outer.pose().map_err(pose)).transpose()?;
        let lists = [
            ("primitive poses", self.primitives.len(), &self.primitive_poses),
            ("mesh poses", self.meshes.len(), &self.mesh_poses),
        ];
        for (what, expected, poses) in lists {
            let found = poses.len();
            if expected != found {
                return Err(RobotError::Count { what, user, expected, found });
            }
        }
        let primitives = self.primitives.iter().map(|primitive| primitive.shape(&user));
        let meshes = self.meshes.iter().map(|mesh| mesh.shape(&user));
        let places = self.primitive_poses.iter().chain(&self.mesh_poses);
        let placed = primitives.chain(meshes).zip(places).map(|(shape, place)| {
            let own = place.checked().map_err(pose)?;
            let inner = match &self.pose {
                None => own,
                Some(outer) => composed(&outer.checked().map_err(pose)?, &own).map_err(pose)?,
            };
            let in_world = match &outer {
                None => inner,
                Some(outer) => composed(outer, &inner).map_err(pose)?,
            };
            Ok(Obstacle { name: self.id.clone(), shape: shape?, pose: in_world })
        });
        placed.collect()
    }

    /// Whether it has no shape at all.
    pub(super) fn is_bare(&self) -> bool {
        self.primitives.is_empty() && self.meshes.is_empty() && self.planes.is_empty()
    }
}

impl Place {
    fn checked(&self) -> Result<Pose, PoseError> {
        Pose::new(DQuat::from_array(self.orientation.0), DVec3::from_array(self.position.0))
    }
}

pub(super) fn composed(outer: &Pose, inner: &Pose) -> Result<Pose, PoseError> {
    let rotation = *outer.rotation() * *inner.rotation();
    Pose::from_matrix(rotation, outer.apply(inner.translation()))
}

impl Primitive {
    fn shape(&self, user: &str) -> Result<Shape, RobotError> {
        // By name, or by the number that shape_msgs/SolidPrimitive has for it.
        let (kind, expected) = match self.kind.0.to_lowercase().as_str() {
            "box" | "1" => ("box", 3),
            "sphere" | "2" => ("sphere", 1),
            "cylinder" | "3" => ("cylinder", 2),
            "cone" | "4" => ("cone", 2),
            _ => {
                let (kind, user) = (self.kind.0.clone(), user.to_owned());
                return Err(RobotError::Unsupported { what: "shape", kind, user });
            }
        };
        let shape = match (kind, &self.dimensions[..]) {
            ("box", &[x, y, z]) => Shape::cuboid(DVec3::new(x, y, z) * 0.5),
            ("cylinder", &[height, radius]) => world::cylinder(height, radius),
            ("cone", &[height, radius]) => Shape::cone(height * 0.5, radius),
            ("sphere", &[radius]) => Shape::sphere(radius),
            (kind, dimensions) => {
                let (what, user) = ("dimensions", format!("{user}: {kind}"));
                let found = dimensions.len();
                return Err(RobotError::Count { what, user, expected, found });
            }
        };
        shape.map_err(|error| RobotError::Shape { user: user.to_owned(), error })
    }
}

impl MeshMessage {
    fn shape(&self, user: &str) -> Result<Shape, RobotError> {
        let vertices = self.vertices.iter().map(|point| DVec3::from_array(point.0)).collect();
        let triangle = |corners: &Vec<u32>| {
            <[u32; 3]>::try_from(&corners[..]).map_err(|_| RobotError::Count {
                what: "corners of a triangle",
                user: user.to_owned(),
                expected: 3,
                found: corners.len(),
            })
        };
        let triangles = self.triangles.iter().map(|corners| triangle(&corners.0));
        let mesh = Shape::mesh(vertices, triangles.collect::<Result<_, _>>()?);
        mesh.map_err(|error| RobotError::Shape { user: user.to_owned(), error })
    }
}
