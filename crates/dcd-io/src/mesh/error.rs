//! What can be wrong with a mesh file, always with the file, the element and the line.

use super::MeshFormat;
use crate::ReadError;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Why a mesh file was refused.
#[derive(Debug)]
#[non_exhaustive]
pub enum MeshError {
    /// A file could not be read at all.
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
        error: Box<MeshError>,
    },
    /// The name's ending belongs to no format that is read here.
    UnknownFormat {
        /// The ending, lower case, without the dot; empty where there is none.
        ending: String,
    },
    /// The file breaks the rules of its format, or holds what is not supported and could hide
    /// geometry.
    Refused {
        /// The format.
        format: MeshFormat,
        /// Where.
        place: MeshPlace,
        /// What is wrong, in words.
        problem: String,
    },
    /// A reader of a whole file refuses it: OBJ and PLY.
    Read(ReadError),
    /// There is no triangle in the file.
    Empty {
        /// The format.
        format: MeshFormat,
    },
}

/// A place in a mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshPlace {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(usize),
    /// An XML element.
    Element {
        /// Its tag, and its id where it has one.
        name: String,
        /// The line where it begins, counted from 1.
        line: usize,
    },
    /// A byte, counted from 0.
    Byte(usize),
    /// A path of JSON keys.
    Json(String),
}

impl MeshError {
    /// A refusal by one of our readers.
    pub(super) fn refused(
        format: MeshFormat,
        place: MeshPlace,
        problem: impl Into<String>,
    ) -> Self {
        Self::Refused { format, place, problem: problem.into() }
    }

    /// A file that cannot be read.
    pub(super) fn io(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Io { path: path.to_path_buf(), error }
    }

    /// The error with the file's path.
    pub(super) fn inside(self, path: &Path) -> Self {
        Self::InFile { path: path.to_path_buf(), error: Box::new(self) }
    }
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: {error}", crate::shown(path)),
            Self::InFile { path, error } => write!(f, "{}: {error}", crate::shown(path)),
            Self::UnknownFormat { ending } => write!(
                f,
                "a mesh file that ends in {ending:?} is not read here: STL (.stl), COLLADA (.dae), \
                 OBJ (.obj), glTF (.gltf, .glb) and PLY (.ply) are"
            ),
            Self::Refused { format, place: MeshPlace::File, problem } => {
                write!(f, "{format}: {problem}")
            }
            Self::Refused { format, place, problem } => write!(f, "{format}, {place}: {problem}"),
            Self::Read(error) => error.fmt(f),
            Self::Empty { format } => write!(f, "{format}: the file has no triangle"),
        }
    }
}

impl fmt::Display for MeshPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => write!(f, "the file"),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Element { name, line } => write!(f, "<{name}> in line {line}"),
            Self::Byte(at) => write!(f, "byte {at}"),
            Self::Json(path) => write!(f, "{path}"),
        }
    }
}

impl std::error::Error for MeshError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { error, .. } => Some(error),
            Self::InFile { error, .. } => Some(error),
            Self::Read(error) => Some(error),
            _ => None,
        }
    }
}
