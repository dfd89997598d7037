//! The shapes of collision objects.

use super::frames::Frames;
use super::kinematics::JointFrame;
use super::{Obstacle, RobotError, world};
use dcd_geom::{Pose, PoseError, Shape};
use dcd_moveit::{CollisionObject, Mesh, Pose as PoseMessage, SolidPrimitive};
use glam::{DQuat, DVec3};

/// The object's shapes with their poses in the world.
pub(super) fn obstacles(
    object: &CollisionObject,
    frames: &Frames<'_>,
) -> Result<Vec<Obstacle>, RobotError> {
    let user = format!("object {:?}", object.id);
    let refused = |why: &str| Err(RobotError::Refused { user: user.clone(), why: why.to_owned() });
    if !object.planes.is_empty() {
        return refused("planes are not supported");
    }
    let outer = frames.find(&object.header.frame_id, &user)?;
    let pose = |error| RobotError::Pose { user: user.clone(), error };
    // What is in the world's own frame keeps its pose bit for bit.
    let outer = (outer != JointFrame::IDENTITY).then(|| outer.pose().map_err(pose)).transpose()?;
    let lists = [
        ("primitive poses", object.primitives.len(), &object.primitive_poses),
        ("mesh poses", object.meshes.len(), &object.mesh_poses),
    ];
    for (what, expected, poses) in lists {
        let found = poses.len();
        if expected != found {
            return Err(RobotError::Count { what, user, expected, found });
        }
    }
    let primitives = object.primitives.iter().map(|primitive| of_primitive(primitive, &user));
    let meshes = object.meshes.iter().map(|mesh| of_mesh(mesh, &user));
    let places = object.primitive_poses.iter().chain(&object.mesh_poses);
    let placed = primitives.chain(meshes).zip(places).map(|(shape, place)| {
        let own = checked(place).map_err(pose)?;
        let inner = match &object.pose {
            None => own,
            Some(outer) => checked(outer).map_err(pose)?.compose(&own).map_err(pose)?,
        };
        let in_world = match &outer {
            None => inner,
            Some(outer) => outer.compose(&inner).map_err(pose)?,
        };
        Ok(Obstacle { name: object.id.clone(), shape: shape?, pose: in_world })
    });
    placed.collect()
}

fn checked(place: &PoseMessage) -> Result<Pose, PoseError> {
    Pose::new(DQuat::from_array(place.orientation.0), DVec3::from_array(place.position.0))
}

fn of_primitive(primitive: &SolidPrimitive, user: &str) -> Result<Shape, RobotError> {
    // By name, or by the number that shape_msgs/SolidPrimitive has for it.
    let (kind, expected) = match primitive.kind.0.to_lowercase().as_str() {
        "box" | "1" => ("box", 3),
        "sphere" | "2" => ("sphere", 1),
        "cylinder" | "3" => ("cylinder", 2),
        "cone" | "4" => ("cone", 2),
        _ => {
            let (kind, user) = (primitive.kind.0.clone(), user.to_owned());
            return Err(RobotError::Unsupported { what: "shape", kind, user });
        }
    };
    let shape = match (kind, &primitive.dimensions[..]) {
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

fn of_mesh(mesh: &Mesh, user: &str) -> Result<Shape, RobotError> {
    let vertices = mesh.vertices.iter().map(|point| DVec3::from_array(point.0)).collect();
    let triangle = |corners: &Vec<u32>| {
        <[u32; 3]>::try_from(&corners[..]).map_err(|_| RobotError::Count {
            what: "corners of a triangle",
            user: user.to_owned(),
            expected: 3,
            found: corners.len(),
        })
    };
    let triangles = mesh.triangles.iter().map(|corners| triangle(&corners.0));
    let shape = Shape::mesh(vertices, triangles.collect::<Result<_, _>>()?);
    shape.map_err(|error| RobotError::Shape { user: user.to_owned(), error })
}
