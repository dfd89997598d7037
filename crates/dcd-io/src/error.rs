//! What can be wrong with a file, always with its place and value.

use dcd_geom::{PoseError, SceneError, ShapeError};
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Why a file was refused. Indices count from 0, lines from 1, `at` is a byte offset.
#[derive(Debug)]
#[non_exhaustive]
pub enum ReadError {
    /// The file could not be read at all.
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// Something is wrong inside a file.
    InFile {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        error: Box<ReadError>,
    },
    /// The file ends before what it promises: it is cut short, or a count in it is wrong.
    Truncated {
        /// What should stand there.
        what: &'static str,
        /// The index of the record.
        index: usize,
        /// The byte offset where it should start.
        at: usize,
        /// How many bytes it takes.
        needed: u64,
        /// How many there are.
        left: usize,
    },
    /// Bytes are left behind the last record.
    Oversized {
        /// Where they start.
        at: usize,
        /// How many.
        left: usize,
    },
    /// A record has no point.
    Empty {
        /// What kind of record.
        what: &'static str,
        /// Its index.
        index: usize,
    },
    /// A number is NaN or infinite.
    NotFinite {
        /// The kind of record.
        what: &'static str,
        /// Its index.
        index: usize,
        /// The number.
        value: f64,
    },
    /// An index points nowhere.
    OutOfBounds {
        /// What refers.
        what: &'static str,
        /// Its index.
        index: usize,
        /// What it refers to.
        target: i64,
        /// How many of those there are.
        count: usize,
    },
    /// A line holds another number of fields than it should.
    Fields {
        /// The line.
        line: usize,
        /// How many it should hold.
        expected: usize,
        /// How many it holds.
        found: usize,
    },
    /// A field is no number.
    NotANumber {
        /// The line.
        line: usize,
        /// The field in it, from 0.
        field: usize,
        /// What stands there.
        text: String,
    },
    /// An AABB's smallest coordinate is above its largest.
    InsideOut {
        /// The line.
        line: usize,
        /// The axis: 0, 1, 2.
        axis: usize,
        /// The smallest coordinate.
        min: f32,
        /// The largest.
        max: f32,
    },
    /// A header line means nothing here, or stands in the wrong place.
    Header {
        /// The line.
        line: usize,
        /// What stands there.
        text: String,
    },
    /// The file lacks something.
    Missing {
        /// What.
        what: &'static str,
    },
    /// A face is no triangle.
    NotATriangle {
        /// The face.
        face: usize,
        /// How many corners it has.
        corners: u64,
    },
    /// A list has a negative length.
    Negative {
        /// The element that holds it.
        index: usize,
        /// The length.
        length: i64,
    },
    /// Two frames that belong together do not.
    FramesDiffer {
        /// The kind of record.
        what: &'static str,
        /// The first frame's number of them; of a face, its index.
        first: usize,
        /// The second's.
        second: usize,
    },
    /// The text is no OBJ.
    Obj {
        /// What is wrong with it.
        message: String,
    },
    /// The text is not JSON of the right kind.
    Json(serde_json::Error),
    /// The file begins with other bytes than its kind does.
    Signature {
        /// What it should begin with.
        expected: [u8; 8],
        /// What it begins with.
        found: [u8; 8],
    },
    /// The file is of a version that is not read here.
    Version {
        /// The file's.
        found: u32,
        /// The one that is read.
        known: u32,
    },
    /// A record is of a kind that is not known.
    UnknownKind {
        /// What kind of record.
        what: &'static str,
        /// Its index.
        index: usize,
        /// Where it starts.
        at: usize,
        /// What names its kind.
        tag: u32,
    },
    /// A record does not carry the number that its place gives it.
    Misplaced {
        /// What kind of record.
        what: &'static str,
        /// The number that its place gives it.
        index: usize,
        /// Where it starts.
        at: usize,
        /// The number that it carries.
        found: u32,
    },
    /// A shape is refused.
    Shape {
        /// Its index.
        index: usize,
        /// Where it starts.
        at: usize,
        /// What is wrong with it.
        error: ShapeError,
    },
    /// A pose is refused.
    Pose {
        /// The frame.
        frame: usize,
        /// The object in it.
        object: usize,
        /// Where the pose starts.
        at: usize,
        /// What is wrong with it.
        error: PoseError,
    },
    /// The pose of a compound's part is refused.
    PartPose {
        /// The compound's index.
        index: usize,
        /// The part in it.
        part: usize,
        /// Where the pose starts.
        at: usize,
        /// What is wrong with it.
        error: PoseError,
    },
    /// The scene is refused as a whole.
    Scene {
        /// The frame's index.
        frame: usize,
        /// What is wrong with it.
        error: SceneError,
    },
}

impl ReadError {
    /// Reads a whole file and names it in whatever goes wrong.
    pub(crate) fn within<T>(
        path: &Path,
        read: impl FnOnce(&[u8]) -> Result<T, Self>,
    ) -> Result<T, Self> {
        let bytes = std::fs::read(path);
        let bytes = bytes.map_err(|error| Self::Io { path: path.to_path_buf(), error })?;
        let named = |error| Self::InFile { path: path.to_path_buf(), error: Box::new(error) };
        read(&bytes).map_err(named)
    }
}

/// A path as it stands in a message: no control character of a name reaches a terminal.
pub fn shown(path: &Path) -> String {
    let escaped = |c: char| if c.is_control() { c.escape_debug().to_string() } else { c.into() };
    path.to_string_lossy().chars().map(escaped).collect()
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: {error}", shown(path)),
            Self::InFile { path, error } => write!(f, "{}: {error}", shown(path)),
            Self::Truncated { what, index, at, needed, left } => write!(
                f,
                "from byte {at} on {needed} bytes are needed for the {what} of record {index}, but {left} \
                 are left"
            ),
            Self::Oversized { at, left } => {
                write!(f, "{left} bytes are left behind the last record, from byte {at} on")
            }
            Self::Empty { what, index } => write!(f, "{what} {index} has no point"),
            Self::NotFinite { what, index, value } => {
                write!(f, "{what} {index} holds {value:e}, not a finite number")
            }
            Self::OutOfBounds { what, index, target, count } => {
                write!(f, "{what} {index} refers to {target}, but there are {count}")
            }
            Self::Fields { line, expected, found } => {
                write!(f, "line {line} holds {found} fields, not {expected}")
            }
            Self::NotANumber { line, field, text } => {
                write!(f, "line {line}, field {field}: {text:?} is no number")
            }
            Self::InsideOut { line, axis, min, max } => {
                write!(f, "line {line}: on axis {axis} the box goes from {min:e} to {max:e}")
            }
            Self::PartPose { index, part, at, error } => {
                write!(f, "shape {index}, part {part} at byte {at}: {error}")
            }
            Self::Header { line, text } => write!(f, "line {line} of the header: {text:?}"),
            Self::Missing { what } => write!(f, "there is no {what}"),
            Self::NotATriangle { face, corners } => {
                write!(f, "face {face} has {corners} corners, not 3")
            }
            Self::Negative { index, length } => {
                write!(f, "element {index} holds a list of length {length}")
            }
            Self::FramesDiffer { what, first, second } => {
                write!(f, "the frames differ in {what}: {first} and {second}")
            }
            Self::Obj { message } => write!(f, "no OBJ: {message}"),
            Self::Json(error) => error.fmt(f),
            Self::Signature { expected, found } => {
                let [expected, found] = [expected, found].map(|bytes| bytes.escape_ascii());
                write!(f, "the file begins with \"{found}\", not \"{expected}\"")
            }
            Self::Version { found, known } => {
                write!(f, "the file is of version {found}, not {known}")
            }
            Self::UnknownKind { what, index, at, tag } => {
                write!(f, "{what} {index}, at byte {at}, is of the unknown kind {tag}")
            }
            Self::Misplaced { what, index, at, found } => {
                write!(f, "{what} {index}, at byte {at}, carries the number {found}")
            }
            Self::Shape { index, at, error } => {
                write!(f, "shape {index}, at byte {at}: {error}")
            }
            Self::Pose { frame, object, at, error } => {
                write!(f, "frame {frame}, object {object}, at byte {at}: {error}")
            }
            Self::Scene { frame, error } => write!(f, "frame {frame}: {error}"),
        }
    }
}

impl std::error::Error for ReadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { error, .. } => Some(error),
            Self::InFile { error, .. } => Some(error),
            Self::Json(error) => Some(error),
            _ => None,
        }
    }
}
