//! A shape as bytes and from bytes.

use super::write::{numbers, words, write_pose};
use crate::ReadError;
use crate::bytes::{Cursor, Field};
use dcd_geom::{
    Compound, Curved, CurvedKind, HalfSpace, Kind, Mesh, Polytope, Pose, Shape, ShapeError,
};
use glam::{DMat3, DVec3};
use std::io::{self, Write};

/// What a shape's kind is called.
mod kind {
    pub(super) const HULL: u32 = 0;
    pub(super) const CUBOID: u32 = 1;
    pub(super) const SPHERE: u32 = 2;
    pub(super) const SEGMENT: u32 = 3;
    pub(super) const TRIANGLE: u32 = 4;
    pub(super) const CYLINDER: u32 = 5;
    pub(super) const CONE: u32 = 6;
    pub(super) const HALF_SPACE: u32 = 7;
    pub(super) const MESH: u32 = 8;
    pub(super) const COMPOUND: u32 = 9;
    pub(super) const ELLIPSOID: u32 = 10;
}

/// Bytes of a part of a compound, at least: a pose, a kind, a radius.
const LEAST_PART_BYTES: u64 = 12 * 8 + 4 + 8;

/// Writes one shape as a capture holds it (`docs/captures.md`): [`read_shape`] makes the same shape of it.
///
/// # Errors
/// Those of writing; a shape that is known by its support map alone, or has such a part, as
/// [`io::ErrorKind::Unsupported`].
pub fn write_shape(out: &mut impl Write, shape: &Shape) -> io::Result<()> {
    if kind_of(shape).is_none() {
        return Err(io::ErrorKind::Unsupported.into());
    }
    write(out, shape)
}

/// The shape that bytes begin with, and the bytes after it.
///
/// # Errors
/// Bytes that end early, an unknown kind, numbers that make no shape.
pub fn read_shape(bytes: &[u8]) -> Result<(Shape, &[u8]), ReadError> {
    let mut cursor = Cursor::new(bytes, 0);
    let shape = read(&mut cursor, 0)?;
    Ok((shape, &bytes[cursor.at()..]))
}

/// The kind's number; none for a shape that there is none for.
pub(super) fn kind_of(shape: &Shape) -> Option<u32> {
    Some(match shape {
        Shape::Polytope(polytope) => match polytope.kind() {
            Kind::Hull => kind::HULL,
            Kind::Cuboid { .. } => kind::CUBOID,
            Kind::Point => kind::SPHERE,
            Kind::Segment => kind::SEGMENT,
            Kind::Triangle => kind::TRIANGLE,
            _ => return None,
        },
        Shape::Curved(curved) => match curved.kind() {
            CurvedKind::Cylinder => kind::CYLINDER,
            CurvedKind::Cone => kind::CONE,
            _ => return None,
        },
        Shape::Ellipsoid(_) => kind::ELLIPSOID,
        Shape::HalfSpace(_) => kind::HALF_SPACE,
        Shape::Mesh(_) => kind::MESH,
        Shape::Compound(compound) => {
            let is_known = compound.parts().iter().all(|part| kind_of(&part.shape).is_some());
            return is_known.then_some(kind::COMPOUND);
        }
        _ => return None,
    })
}

pub(super) fn write(out: &mut impl Write, shape: &Shape) -> io::Result<()> {
    // None only if it was refused when the capture was made.
    let Some(kind) = kind_of(shape) else { return Ok(()) };
    words(out, &[kind])?;
    match shape {
        Shape::Polytope(polytope) => write_polytope(out, polytope),
        Shape::Curved(curved) => {
            numbers(out, &[curved.swept_radius(), curved.half_height(), curved.radius()])
        }
        Shape::Ellipsoid(ellipsoid) => {
            numbers(out, &[ellipsoid.swept_radius()])?;
            numbers(out, &ellipsoid.half_axes().to_array())
        }
        Shape::HalfSpace(half_space) => {
            numbers(out, &[half_space.swept_radius()])?;
            numbers(out, &half_space.normal().to_array())?;
            numbers(out, &[half_space.offset()])
        }
        Shape::Mesh(mesh) => write_mesh(out, mesh),
        Shape::Compound(compound) => {
            // Each part has a radius of its own.
            numbers(out, &[0.0])?;
            // A compound has no more parts than a u32 counts, a mesh no more vertices and triangles.
            words(out, &[compound.parts().len() as u32])?;
            compound.parts().iter().try_for_each(|part| {
                write_pose(out, &part.pose)?;
                write(out, &part.shape)
            })
        }
        _ => Ok(()),
    }
}

fn write_mesh(out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    numbers(out, &[mesh.swept_radius()])?;
    words(out, &[mesh.vertices().len() as u32, mesh.triangles().len() as u32])?;
    mesh.vertices().iter().try_for_each(|vertex| numbers(out, &vertex.to_array()))?;
    mesh.triangles().iter().try_for_each(|corners| words(out, corners))
}

fn write_polytope(out: &mut impl Write, polytope: &Polytope) -> io::Result<()> {
    numbers(out, &[polytope.swept_radius()])?;
    match polytope.kind() {
        Kind::Point => Ok(()),
        Kind::Cuboid { half_extents } => numbers(out, &half_extents.to_array()),
        kind => {
            if kind == Kind::Hull {
                // A shape has no more vertices than a u32 counts.
                words(out, &[polytope.vertices().len() as u32])?;
            }
            polytope.vertices().iter().try_for_each(|vertex| numbers(out, &vertex.to_array()))
        }
    }
}

pub(super) fn read(cursor: &mut Cursor<'_>, index: usize) -> Result<Shape, ReadError> {
    let at = cursor.at();
    let field = Field { what: "shape", index };
    let kind = cursor.u32(field)?;
    let [radius] = cursor.f64s(field)?;
    let mut point = || cursor.f64s(field).map(DVec3::from_array);
    let core: Result<Shape, ShapeError> = match kind {
        kind::HULL => Shape::hull(read_vertices(cursor, index)?),
        kind::CUBOID => Shape::cuboid(point()?),
        kind::SPHERE => Shape::sphere(radius),
        kind::SEGMENT => Shape::segment(point()?, point()?),
        kind::TRIANGLE => Shape::triangle([point()?, point()?, point()?]),
        kind::CYLINDER | kind::CONE => {
            let [half_height, disc] = cursor.f64s(field)?;
            let make = if kind == kind::CONE { Curved::cone } else { Curved::cylinder };
            make(half_height, disc).map(Shape::from)
        }
        kind::ELLIPSOID => Shape::ellipsoid(point()?),
        kind::HALF_SPACE => {
            let normal = point()?;
            let [offset] = cursor.f64s(field)?;
            HalfSpace::new(normal, offset).map(Shape::from)
        }
        kind::MESH => read_mesh(cursor, index)?.map(Shape::from),
        kind::COMPOUND => {
            let parts = read_parts(cursor, index)?;
            let compound = Compound::new(parts).map(Shape::from);
            return compound.map_err(|error| ReadError::Shape { index, at, error });
        }
        tag => return Err(ReadError::UnknownKind { what: "shape", index, at, tag }),
    };
    let shape = core.and_then(|core| core.rounded(radius));
    shape.map_err(|error| ReadError::Shape { index, at, error })
}

fn read_mesh(cursor: &mut Cursor<'_>, index: usize) -> Result<Result<Mesh, ShapeError>, ReadError> {
    let field = Field { what: "triangles", index };
    let (vertices, triangles) = (cursor.u32(field)?, cursor.u32(field)?);
    let vertices = read_points(cursor, index, vertices)?;
    cursor.check_count(field, u64::from(triangles), 3 * 4)?;
    let mut corner = || cursor.u32(field);
    let triangles = (0..triangles).map(|_| Ok([corner()?, corner()?, corner()?]));
    Ok(Mesh::new(vertices, triangles.collect::<Result<_, ReadError>>()?))
}

/// The parts of a compound; one that is a compound itself is refused before it is read, so that no file nests deeply.
fn read_parts(cursor: &mut Cursor<'_>, index: usize) -> Result<Vec<(Shape, Pose)>, ReadError> {
    let field = Field { what: "parts", index };
    let count = cursor.u32(field)?;
    cursor.check_count(field, u64::from(count), LEAST_PART_BYTES)?;
    (0..count as usize)
        .map(|part| {
            let at = cursor.at();
            let rotation = DMat3::from_cols_array(&cursor.f64s(field)?);
            let translation = DVec3::from_array(cursor.f64s(field)?);
            let pose = Pose::from_matrix(rotation, translation);
            let pose = pose.map_err(|error| ReadError::PartPose { index, part, at, error })?;
            let at = cursor.at();
            if cursor.peek_u32() == Some(kind::COMPOUND) {
                let error = ShapeError::BadPart { part };
                return Err(ReadError::Shape { index, at, error });
            }
            Ok((read(cursor, index)?, pose))
        })
        .collect()
}

fn read_vertices(cursor: &mut Cursor<'_>, index: usize) -> Result<Vec<DVec3>, ReadError> {
    let count = cursor.u32(Field { what: "vertices", index })?;
    read_points(cursor, index, count)
}

fn read_points(cursor: &mut Cursor<'_>, index: usize, count: u32) -> Result<Vec<DVec3>, ReadError> {
    let field = Field { what: "vertices", index };
    cursor.check_count(field, u64::from(count), 3 * 8)?;
    (0..count).map(|_| cursor.f64s(field).map(DVec3::from_array)).collect()
}
