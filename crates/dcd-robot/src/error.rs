//! What can be wrong with a robot, its world or a state, always with the name and the value.

use dcd_geom::{PoseError, SceneError, ShapeError};
use dcd_io::{MeshError, MeshNotFound, shown};
use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a robot, a world or a state was refused.
#[derive(Debug)]
#[non_exhaustive]
pub enum RobotError {
    /// A file could not be read at all.
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// A file is not of its kind.
    Syntax {
        /// Which kind: "URDF", "SRDF", "scene", "request".
        what: &'static str,
        /// The file.
        place: PathBuf,
        /// What the reader says, with line and column where it knows them.
        error: String,
    },
    /// A text is not of its kind.
    NotOfKind {
        /// Which kind: see [`RobotError::Syntax`].
        what: &'static str,
        /// What the reader says, with line and column where it knows them.
        error: String,
    },
    /// Something is wrong on a line of a file.
    AtLine {
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        error: Box<RobotError>,
    },
    /// Something is wrong with one of several states.
    AtState {
        /// Which, from 0.
        state: usize,
        /// What is wrong.
        error: Box<RobotError>,
    },
    /// Something that is understood and refused, or not understood.
    Refused {
        /// Which element.
        user: String,
        /// Why.
        why: String,
    },
    /// More of something than is read.
    TooLarge {
        /// Of what.
        what: &'static str,
        /// The most that is read.
        limit: usize,
    },
    /// More than one link has no parent.
    Forest {
        /// Two of them.
        roots: [String; 2],
    },
    /// No link has a shape.
    NoShapes {
        /// The robot.
        robot: String,
    },
    /// Something is wrong inside a file.
    InFile {
        /// The file.
        place: PathBuf,
        /// What is wrong.
        error: Box<RobotError>,
    },
    /// A name that nothing has.
    Unknown {
        /// Of what: "link", "joint".
        what: &'static str,
        /// The name.
        name: String,
        /// Who uses it.
        user: String,
    },
    /// There is no obstacle in that place.
    NoSuchObstacle {
        /// The place that was asked for.
        place: usize,
        /// How many there are.
        obstacles: usize,
    },
    /// Two have the same name.
    Twice {
        /// Of what.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// The links and joints make no tree.
    NotATree {
        /// A link that no root leads to, or that has two parents.
        link: String,
    },
    /// Something that is not supported here.
    Unsupported {
        /// What: "joint type", "shape".
        what: &'static str,
        /// Its name in the file.
        kind: String,
        /// Who has it.
        user: String,
    },
    /// A mesh that is named is in none of the places where it could be.
    NoMesh {
        /// Who names it.
        user: String,
        /// Its name, and where it was looked for.
        error: MeshNotFound,
    },
    /// A mesh file is refused.
    Mesh {
        /// Who names it.
        user: String,
        /// What is wrong with it.
        error: MeshError,
    },
    /// A number that is not finite.
    NotANumber {
        /// What.
        what: String,
        /// Whose.
        user: String,
        /// The number.
        value: f64,
    },
    /// A number that is no number, or none that can be meant.
    BadNumber {
        /// What.
        what: &'static str,
        /// Whose.
        user: String,
        /// The number.
        value: f64,
    },
    /// Another number of something than there should be.
    Count {
        /// Of what.
        what: &'static str,
        /// Whose.
        user: String,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A shape is refused.
    Shape {
        /// Whose.
        user: String,
        /// What is wrong with it.
        error: ShapeError,
    },
    /// A pose is refused.
    Pose {
        /// Whose.
        user: String,
        /// What is wrong with it.
        error: PoseError,
    },
    /// Something reaches farther from the origin than [`dcd_geom::Aabb::LIMIT`].
    OutOfRange {
        /// What: a link, an obstacle.
        user: String,
        /// How far, in metres along an axis.
        reach: f64,
    },
    /// The scene is refused as a whole.
    Scene(SceneError),
}

impl RobotError {
    /// A file that cannot be read.
    pub(super) fn io(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Io { path: path.into(), error }
    }

    /// The same, said of a line, unless it says one already.
    pub(super) fn at_line(self, line: usize) -> Self {
        match self {
            Self::AtLine { .. } => self,
            error => Self::AtLine { line, error: Box::new(error) },
        }
    }

    /// What a scene refuses, said of what the object is where it is one.
    pub(super) fn of_scene(error: SceneError, user: impl FnOnce(usize) -> String) -> Self {
        match error {
            SceneError::OutOfRange { object, reach } => {
                Self::OutOfRange { user: user(object), reach }
            }
            error => Self::Scene(error),
        }
    }

    /// The same, said of a file.
    pub(super) fn inside(self, place: impl Into<PathBuf>) -> Self {
        Self::InFile { place: place.into(), error: Box::new(self) }
    }
}

impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: {error}", shown(path)),
            Self::Syntax { what, place, error } => {
                write!(f, "{}: no {what}: {}", shown(place), error.trim_end())
            }
            Self::NotOfKind { what, error } => write!(f, "no {what}: {}", error.trim_end()),
            Self::AtLine { line, error } => write!(f, "line {line}: {error}"),
            Self::AtState { state, error } => write!(f, "state {state}: {error}"),
            Self::Refused { user, why } => write!(f, "{user}: {why}"),
            Self::NoSuchObstacle { place, obstacles } => {
                write!(f, "no obstacle {place}: there are {obstacles} obstacles")
            }
            Self::TooLarge { what, limit } => write!(f, "more than {limit} {what}"),
            Self::Forest { roots: [a, b] } => {
                write!(f, "links {a:?} and {b:?} have no parent both: a robot has one root")
            }
            Self::NoShapes { robot } => {
                write!(f, "robot {robot:?} has no collision geometry: nothing of it could touch")
            }
            Self::InFile { place, error } => write!(f, "{}: {error}", shown(place)),
            Self::Unknown { what, name, user } => write!(f, "{user}: there is no {what} {name:?}"),
            Self::Twice { what, name } => write!(f, "there are two of {what} {name:?}"),
            Self::NotATree { link } => {
                write!(f, "link {link:?} is not on one way from one root")
            }
            Self::Unsupported { what, kind, user } => {
                write!(f, "{user}: {what} {kind:?} is not supported")
            }
            Self::NoMesh { user, error } => write!(f, "{user}: {error}"),
            Self::Mesh { user, error } => write!(f, "{user}: {error}"),
            Self::NotANumber { what, user, value } => write!(f, "{user}: the {what} is {value}"),
            Self::BadNumber { what, user, value } => write!(f, "{user}: the {what} is {value:e}"),
            Self::Count { what, user, expected, found } => {
                write!(f, "{user}: {found} {what}, not {expected}")
            }
            Self::Shape { user, error } => write!(f, "{user}: {error}"),
            Self::Pose { user, error } => write!(f, "{user}: {error}"),
            Self::OutOfRange { user, reach } => {
                write!(f, "{user}: reaches {reach:e} m, beyond the range of f32 boxes")
            }
            Self::Scene(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for RobotError {}
