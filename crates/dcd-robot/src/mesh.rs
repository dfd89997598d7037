//! A mesh file of a URDF.

use super::RobotError;
use dcd_io::{RawMesh, load_obj};
use std::path::{Path, PathBuf};

/// The OBJ file of a robot, metres.
pub(super) fn load(path: &Path) -> Result<RawMesh, RobotError> {
    let kind = path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase());
    if kind != "obj" {
        let user = path.display().to_string();
        return Err(RobotError::Unsupported { what: "mesh format", kind, user });
    }
    load_obj(path).map_err(|error| RobotError::Syntax {
        what: "mesh",
        place: path.to_path_buf(),
        error: error.to_string(),
    })
}

/// The file of this name: from the folder, or from one above it, with and without the package's name.
pub(super) fn find(name: &str, folder: &Path) -> Result<PathBuf, RobotError> {
    let bare = name.strip_prefix("package://").or(name.strip_prefix("file://")).unwrap_or(name);
    let in_package = bare.split_once('/').map(|(_, rest)| rest);
    let inside = if name.starts_with("package://") { in_package } else { None };
    let places = || {
        folder.ancestors().flat_map(|above| {
            // The parent of a bare file name is empty: the current folder.
            let above = if above.as_os_str().is_empty() { Path::new(".") } else { above };
            [Some(bare), inside].into_iter().flatten().map(|name| above.join(name))
        })
    };
    let found = places().find(|path| path.is_file());
    found.ok_or_else(|| RobotError::NoMesh { name: name.to_owned(), place: folder.join(bare) })
}
