//! A shape as bytes and from bytes.

use super::write::{numbers, words};
use crate::ReadError;
use crate::bytes::{Cursor, Field};
use dcd_geom::{Curved, CurvedKind, HalfSpace, Kind, Polytope, Shape, ShapeError};
use glam::DVec3;
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
        Shape::HalfSpace(_) => kind::HALF_SPACE,
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
        Shape::HalfSpace(half_space) => {
            numbers(out, &[half_space.swept_radius()])?;
            numbers(out, &half_space.normal().to_array())?;
            numbers(out, &[half_space.offset()])
        }
        _ => Ok(()),
    }
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
        kind::HALF_SPACE => {
            let normal = point()?;
            let [offset] = cursor.f64s(field)?;
            HalfSpace::new(normal, offset).map(Shape::from)
        }
        tag => return Err(ReadError::UnknownKind { what: "shape", index, at, tag }),
    };
    let shape = core.and_then(|core| core.rounded(radius));
    shape.map_err(|error| ReadError::Shape { index, at, error })
}

fn read_vertices(cursor: &mut Cursor<'_>, index: usize) -> Result<Vec<DVec3>, ReadError> {
    let field = Field { what: "vertices", index };
    let count = cursor.u32(field)?;
    cursor.check_count(field, u64::from(count), 3 * 8)?;
    (0..count).map(|_| cursor.f64s(field).map(DVec3::from_array)).collect()
}
