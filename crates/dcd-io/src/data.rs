//! Where the real input is: a folder beside the workspace, which may be absent.

use std::path::{Path, PathBuf};

/// The data folder: the one that the environment variable `DCD_DATA` names; else `shared/data`
/// beside the workspace that this crate was compiled in, or beside the current directory or one
/// above it. None where there is no such folder; a wrong `DCD_DATA` is not passed over.
pub fn folder() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("DCD_DATA") {
        return existing(PathBuf::from(named));
    }
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).map(Path::to_path_buf);
    let current = std::env::current_dir().ok();
    let starts = workspace.iter().chain(&current);
    starts.flat_map(|start| start.ancestors()).find_map(|above| existing(above.join("shared/data")))
}

/// A file of the data folder by its path in there, if it exists.
pub fn file(path: &str) -> Option<PathBuf> {
    let file = folder()?.join(path);
    file.is_file().then_some(file)
}

fn existing(folder: PathBuf) -> Option<PathBuf> {
    folder.is_dir().then_some(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_absent_is_none() {
        assert_eq!(file("no/such/file"), None);
        assert_eq!(existing(PathBuf::from("no/such/folder")), None);
    }

    #[test]
    fn what_is_found_exists() {
        match folder() {
            Some(folder) => assert!(folder.is_dir()),
            None => println!("skipped: there is no data folder"),
        }
    }
}
