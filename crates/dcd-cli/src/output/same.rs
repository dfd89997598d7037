//! Which paths are one file, however they are spelt.

use crate::failure::Failure;
use dcd_io::shown;
use std::fs::Metadata;
use std::io;
use std::path::{Path, PathBuf};

/// The name that stands for standard input.
const STANDARD_INPUT: &str = "-";

/// Checks that no output is an input or another output: by name, by link, or as a standard stream.
pub(crate) fn check_distinct(inputs: &[&Path], outputs: &[&Path]) -> Result<(), Failure> {
    let inputs: Vec<_> = inputs.iter().filter_map(|path| Place::of_input(path)).collect();
    let mut taken: Vec<(PathBuf, Place)> = Vec::new();
    if let Some(place) = Place::of(Path::new("/dev/stdout")) {
        taken.push((PathBuf::from("standard output"), place));
    }
    for &path in outputs {
        let Some(place) = Place::of(path) else { continue };
        let refused = |what: &str| Err(Failure::at(shown(path), what));
        if inputs.contains(&place) {
            return refused("it is an input: its content would be lost");
        }
        if let Some((other, _)) = taken.iter().find(|(_, other)| *other == place) {
            return refused(&format!("it is {} too: one would be lost", shown(other)));
        }
        taken.push((path.to_path_buf(), place));
    }
    Ok(())
}

/// What identifies a file.
#[derive(Debug, PartialEq, Eq)]
enum Place {
    /// A file that is there, by device and number.
    Node(u64, u64),
    /// One that is not there yet, or has no number, by its folder's real path and its name.
    Path(PathBuf),
}

impl Place {
    fn of_input(path: &Path) -> Option<Self> {
        let is_standard = path.as_os_str() == STANDARD_INPUT;
        Self::of(if is_standard { Path::new("/dev/stdin") } else { path })
    }

    /// None for what can be written to more than once, such as /dev/null, and for what cannot be
    /// found: opening it says why.
    fn of(path: &Path) -> Option<Self> {
        match std::fs::metadata(path) {
            Ok(found) if found.is_file() => {
                node(&found).or_else(|| path.canonicalize().ok().map(Self::Path))
            }
            Ok(_) => None,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
                let folder = parent.unwrap_or(Path::new(".")).canonicalize().ok()?;
                Some(Self::Path(folder.join(path.file_name()?)))
            }
            Err(_) => None,
        }
    }
}

#[cfg(unix)]
fn node(found: &Metadata) -> Option<Place> {
    use std::os::unix::fs::MetadataExt;
    Some(Place::Node(found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn node(_: &Metadata) -> Option<Place> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_itself_under_every_spelling_and_link() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a"), "").unwrap();
        std::fs::create_dir(at("sub")).unwrap();
        std::fs::hard_link(at("a"), at("hard")).unwrap();
        let mut same = vec![at("a"), at("./a"), at("sub/../a"), at("hard")];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("a", at("soft")).unwrap();
            std::os::unix::fs::symlink(".", at("here")).unwrap();
            same.extend([at("soft"), at("here/a"), at("here/soft")]);
        }
        for one in &same {
            for other in &same {
                assert!(check_distinct(&[one], &[other]).is_err(), "{one:?} {other:?}");
                assert!(check_distinct(&[], &[one, other]).is_err(), "{one:?} {other:?}");
            }
            assert!(check_distinct(&[one], &[&at("b"), &at("sub/b")]).is_ok());
        }
        let new = at("new");
        assert!(check_distinct(&[], &[&new, &at("sub/../new")]).is_err());
        assert!(check_distinct(&[], &[Path::new("/dev/null"), Path::new("/dev/null")]).is_ok());
    }
}
