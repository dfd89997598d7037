//! Why a share cannot be taken in.

use dcd_geom::{PoseError, SceneError, ShapeError};
use std::fmt;

/// Why objects cannot be spread over ranks.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RankError {
    /// A shape that no message holds: known by its support map alone, or with such a part.
    Foreign {
        /// The shape's name.
        shape: u64,
    },
    /// A body whose shape is not in its share.
    NoSuchShape {
        /// The body's name.
        body: u64,
        /// The shape's index in the share.
        shape: usize,
        /// How many shapes there are.
        shapes: usize,
    },
    /// Two shapes of one name.
    TwoShapes {
        /// The name.
        shape: u64,
    },
    /// Two bodies of one name.
    Twice {
        /// The name.
        body: u64,
    },
    /// An object of a scene has what ranks do not know of, and would be lost.
    Unsupported {
        /// Its index.
        object: usize,
        /// What: "a static object", "a filter", "a sensor", "an ignored pair".
        what: &'static str,
    },
    /// An object of a scene whose name would be more than a u64 counts.
    NoName {
        /// Its index.
        object: usize,
        /// The name of the object of index 0.
        first: u64,
    },
    /// A message that this version did not write.
    Message {
        /// Whose.
        sender: usize,
    },
    /// Contacts without error bounds, [`dcd_pipeline::Precision::Fast`]: they depend on which pairs are decided
    /// together, and so on the number of ranks.
    Unchecked,
    /// A margin that no pipeline takes.
    Margin(ShapeError),
    /// Shapes that a scene refuses.
    Shapes(SceneError),
    /// A body that a scene refuses.
    Scene {
        /// The body's name.
        body: u64,
        /// Why.
        error: SceneError,
    },
    /// A pose that is none.
    Pose {
        /// The body's name.
        body: u64,
        /// Why.
        error: PoseError,
    },
    /// A body that this rank does not own.
    NotOwned {
        /// The body's name.
        body: u64,
    },
    /// The ghosts are not those of the bodies as they stand.
    NotRefreshed,
    /// Another rank's error.
    Elsewhere {
        /// Which rank's.
        rank: usize,
        /// What it says.
        message: String,
    },
    /// A name above what a u32 counts, which a file cannot hold.
    Name {
        /// The name.
        name: u64,
    },
}

impl fmt::Display for RankError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Foreign { shape } => {
                write!(
                    f,
                    "shape {shape}: it is known by its support map alone, which no message holds"
                )
            }
            Self::NoSuchShape { body, shape, shapes } => {
                write!(f, "object {body}: there is no shape {shape} among {shapes}")
            }
            Self::TwoShapes { shape } => write!(f, "shape {shape} is two different shapes"),
            Self::Twice { body } => write!(f, "object {body} is there twice"),
            Self::Unsupported { object, what } => {
                write!(f, "object {object}: {what}, which ranks do not know of")
            }
            Self::NoName { object, first } => {
                write!(
                    f,
                    "object {object}: its name, {first} + {object}, is more than a u64 counts"
                )
            }
            Self::Message { sender } => {
                write!(f, "rank {sender} sent a message that this version does not write")
            }
            Self::Unchecked => {
                write!(f, "contacts without error bounds would depend on the number of ranks")
            }
            Self::Margin(error) => error.fmt(f),
            Self::Shapes(error) => write!(f, "shapes: {error}"),
            Self::Scene { body, error } => write!(f, "object {body}: {error}"),
            Self::Pose { body, error } => write!(f, "object {body}: {error}"),
            Self::Elsewhere { rank, message } => write!(f, "rank {rank}: {message}"),
            Self::NotRefreshed => {
                write!(f, "bodies have moved, or are new, since the last refresh: refresh first")
            }
            Self::NotOwned { body } => write!(f, "object {body} is not owned by this rank"),
            Self::Name { name } => write!(f, "object {name} is more than a u32 counts"),
        }
    }
}

impl std::error::Error for RankError {}
