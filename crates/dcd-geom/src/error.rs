//! What can be wrong with input, always with the value and, where there are many, the index.

use glam::DVec3;
use std::fmt;

/// Why a pose was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PoseError {
    /// A rotation or translation holds NaN or infinity.
    NotFinite {
        /// The first such number.
        value: f64,
    },
    /// | |q|² − 1 | is above [`crate::Pose::UNIT_TOLERANCE`]; a zero quaternion is one such.
    NotUnit {
        /// |q|².
        length_squared: f64,
    },
    /// The matrix is no rotation: the largest entry of |RᵀR − I| is above
    /// [`crate::Pose::UNIT_TOLERANCE`].
    NotOrthonormal {
        /// That largest entry.
        deviation: f64,
    },
    /// The matrix mirrors: its determinant is not positive.
    Mirrors {
        /// The determinant.
        determinant: f64,
    },
}

impl fmt::Display for PoseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { value } => write!(f, "the pose holds {value:e}, not a finite number"),
            Self::NotUnit { length_squared } => {
                write!(f, "the quaternion has |q|² = {length_squared:e}, not 1")
            }
            Self::NotOrthonormal { deviation } => {
                write!(f, "the matrix is no rotation: |RᵀR − I| has an entry of {deviation:e}")
            }
            Self::Mirrors { determinant } => {
                write!(f, "the matrix is no rotation: its determinant is {determinant:e}")
            }
        }
    }
}

impl std::error::Error for PoseError {}

/// Why a shape was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ShapeError {
    /// There is no point at all.
    Empty,
    /// A vertex holds NaN or infinity.
    NotFinite {
        /// The vertex's index.
        vertex: usize,
        /// The first such number in it.
        value: f64,
    },
    /// A radius, half extent or half height is negative, NaN or infinite.
    BadLength {
        /// Which: "radius", "half extent", "half height".
        what: &'static str,
        /// What was given.
        value: f64,
    },
    /// More vertices than a u32 counts.
    TooManyVertices {
        /// How many.
        count: usize,
    },
    /// A half-space's plane has no direction, one far too long or too short, or a number that is not
    /// finite.
    BadPlane {
        /// The normal given.
        normal: DVec3,
        /// The offset given.
        offset: f64,
    },
    /// More parts or triangles than a u32 counts.
    TooManyParts {
        /// How many.
        count: usize,
    },
    /// A part of a compound is itself made of parts, or has no end.
    BadPart {
        /// The part's index.
        part: usize,
    },
    /// A vertex of a part leaves the range of f64 where the part stands.
    PartNotFinite {
        /// The part's index.
        part: usize,
        /// The vertex's index in the part.
        vertex: usize,
        /// What a coordinate became.
        value: f64,
    },
    /// A triangle names a vertex that the mesh does not have.
    NoSuchVertex {
        /// The triangle's index.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the shape has no point"),
            Self::NotFinite { vertex, value } => {
                write!(f, "vertex {vertex} holds {value:e}, not a finite number")
            }
            Self::BadLength { what, value } => {
                write!(f, "the {what} is {value:e}, not a finite length of at least 0")
            }
            Self::TooManyVertices { count } => {
                write!(f, "{count} vertices are more than a u32 counts")
            }
            Self::BadPlane { normal, offset } => {
                let [x, y, z] = normal.to_array();
                write!(f, "normal [{x:e}, {y:e}, {z:e}] and offset {offset:e} make no plane")
            }
            Self::TooManyParts { count } => write!(f, "{count} parts are more than a u32 counts"),
            Self::BadPart { part } => write!(f, "part {part} is not convex and bounded"),
            Self::PartNotFinite { part, vertex, value } => {
                write!(f, "vertex {vertex} of part {part} is at {value:e} in its place")
            }
            Self::NoSuchVertex { triangle, vertex, vertices } => {
                write!(f, "triangle {triangle} names vertex {vertex}, but there are {vertices}")
            }
        }
    }
}

impl std::error::Error for ShapeError {}

pub(crate) fn check_length(what: &'static str, value: f64) -> Result<(), ShapeError> {
    // Written so that NaN is refused.
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(ShapeError::BadLength { what, value })
    }
}

/// Why a scene, or a change of one, was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SceneError {
    /// There is not one pose for each shape.
    LengthsDiffer {
        /// How many shapes.
        shapes: usize,
        /// How many poses.
        poses: usize,
    },
    /// A bulk change needs one value for each slot.
    SlotsDiffer {
        /// How many values were given.
        given: usize,
        /// How many slots there are.
        slots: usize,
    },
    /// An object names a shape that the scene does not have.
    NoSuchShape {
        /// The object's index.
        object: usize,
        /// The shape it names.
        shape: u32,
        /// How many there are.
        shapes: usize,
    },
    /// There is no object of that index.
    NoSuchObject {
        /// The requested index.
        object: usize,
        /// How many there are.
        objects: usize,
    },
    /// More objects or shapes than a u32 counts.
    TooMany {
        /// Which: "objects", "shapes".
        what: &'static str,
        /// How many.
        count: usize,
    },
    /// An object reaches farther from the origin than [`crate::Aabb::LIMIT`].
    OutOfRange {
        /// The object's index.
        object: usize,
        /// How far it reaches, in metres along an axis.
        reach: f64,
    },
    /// The object that a handle was given for has been removed.
    StaleHandle {
        /// The handle.
        handle: crate::Handle,
    },
    /// A pair needs two different objects.
    SelfPair {
        /// The object named twice.
        object: usize,
    },
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LengthsDiffer { shapes, poses } => {
                write!(f, "{shapes} shapes, but {poses} poses")
            }
            Self::SlotsDiffer { given, slots } => {
                write!(f, "{given} values for a scene of {slots} slots")
            }
            Self::NoSuchShape { object, shape, shapes } => {
                write!(f, "object {object} names shape {shape}, but there are {shapes} shapes")
            }
            Self::NoSuchObject { object, objects } => {
                write!(f, "no object {object}: there are {objects} objects")
            }
            Self::TooMany { what, count } => {
                write!(f, "{count} {what} are more than a u32 counts")
            }
            Self::OutOfRange { object, reach } => {
                write!(f, "object {object} reaches {reach:e} m, beyond the range of f32 boxes")
            }
            Self::StaleHandle { handle } => {
                let crate::Handle { index, generation } = handle;
                write!(f, "the object of slot {index}, generation {generation}, has been removed")
            }
            Self::SelfPair { object } => {
                write!(f, "object {object} is named twice: a pair is of two")
            }
        }
    }
}

impl std::error::Error for SceneError {}
