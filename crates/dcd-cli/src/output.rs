//! Files that the command writes: whole, or not there at all.
//!
//! What is written goes to a temporary file beside the output, which takes its name when all of it is
//! there. So a reader sees the old file or the new one, and a run that fails, is interrupted or
//! finds the disk full leaves what was there. Devices and pipes have no name to take: they are written
//! to as they are.

mod same;
mod signals;

use crate::failure::Failure;
use dcd_io::shown;
pub(crate) use same::check_distinct;
use std::ffi::OsString;
use std::fs::{File, OpenOptions, Permissions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// A file that is being written.
#[derive(Debug)]
pub(crate) struct Output {
    path: PathBuf,
    to: To,
}

#[derive(Debug)]
enum To {
    /// A file beside `target`, which takes its place.
    Beside { file: BufWriter<File>, name: TempPath, target: PathBuf },
    /// Neither a file nor a folder: a pipe, a device.
    Device(BufWriter<File>),
}

impl Output {
    /// Makes the temporary file: before the work, so that a wrong path costs none.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        let to = open(path).map_err(|error| Failure::at(shown(path), error))?;
        Ok(Self { path: path.to_path_buf(), to })
    }

    /// Checks that it is none of the files that turned out to be inputs after it was made.
    pub(crate) fn check_no_input(&self, inputs: &[PathBuf]) -> Result<(), Failure> {
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        check_distinct(&inputs, &[&self.path])
    }

    /// Writes into it.
    pub(crate) fn write(
        &mut self,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let out: &mut dyn Write = match &mut self.to {
            To::Beside { file, .. } => file,
            To::Device(file) => file,
        };
        content(out).and_then(|()| out.flush()).map_err(|error| named(&self.path, error))
    }

    /// Gives it its name: from now on it is there.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        let Self { path, to } = self;
        let To::Beside { file, name, target } = to else { return Ok(()) };
        let done = file.into_inner().map_err(io::IntoInnerError::into_error).and_then(|file| {
            // A name that outlives a loss of power must not stand for what does not.
            file.sync_all()?;
            let made = name.to_path_buf();
            signals::renamed(&made, || name.persist(&target).map_err(|refused| refused.error))
        });
        done.map(drop).map_err(|error| named(&path, error))
    }
}

fn named(path: &Path, error: io::Error) -> Failure {
    Failure::Output(io::Error::new(error.kind(), format!("{}: {error}", shown(path))))
}

fn open(path: &Path) -> io::Result<To> {
    let (target, permissions) = match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(found) if !found.is_file() => {
            let device = OpenOptions::new().write(true).open(path)?;
            return Ok(To::Device(BufWriter::new(device)));
        }
        // The file itself, so that links to it stay; and only if it may be written to.
        Ok(found) => {
            OpenOptions::new().write(true).open(path)?;
            (path.canonicalize()?, Some(found.permissions()))
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => (path.to_path_buf(), None),
        Err(error) => return Err(error),
    };
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut prefix = OsString::from(".");
    prefix.push(target.file_name().ok_or(io::ErrorKind::InvalidInput)?);
    // A name takes 255 bytes at most; what tempfile adds must fit too.
    let prefix = if prefix.len() > 200 { OsString::from(".dcd") } else { prefix };
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".part");
    if let Some(all) = everyone() {
        builder.permissions(all);
    }
    // What could not be made is the output to its user: the temporary name in the message says nothing.
    let file = signals::made(|| builder.tempfile_in(folder)).map_err(|error| error.kind())?;
    let (file, name) = file.into_parts();
    if let Some(permissions) = permissions {
        file.set_permissions(permissions)?;
    }
    Ok(To::Beside { file: BufWriter::new(file), name, target })
}

/// What a new file may be, less what the user's mask takes away.
#[cfg(unix)]
fn everyone() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn everyone() -> Option<Permissions> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn an_output_is_there_when_it_is_whole_and_not_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        fs::write(&path, "old").unwrap();
        let mut output = Output::create(&path).unwrap();
        output.write(|out| out.write_all(b"half of it")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        output.write(|out| out.write_all(b", and all")).unwrap();
        output.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"half of it, and all");
        assert_eq!(names(folder.path()), ["out"]);
    }

    #[test]
    fn an_output_that_fails_leaves_the_old_file_and_no_litter() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        fs::write(&path, "old").unwrap();
        let mut output = Output::create(&path).unwrap();
        let failed = output.write(|out| {
            out.write_all(&[1; 100_000])?;
            Err(io::ErrorKind::StorageFull.into())
        });
        let Err(Failure::Output(error)) = failed else { panic!("{failed:?}") };
        assert!(error.to_string().contains("out"), "{error}");
        drop(output);
        assert_eq!(
            (fs::read(&path).unwrap(), names(folder.path())),
            (b"old".to_vec(), vec!["out".into()])
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_a_mode_stays_and_a_device_stays_a_device() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink("file", &link).unwrap();
        let write = |path: &Path| {
            let mut output = Output::create(path).unwrap();
            output.write(|out| out.write_all(b"new")).unwrap();
            output.commit().unwrap();
        };
        write(&link);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
        write(Path::new("/dev/null"));
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        let mut full = Output::create(Path::new("/dev/full")).unwrap();
        assert!(matches!(full.write(|out| out.write_all(b"x")), Err(Failure::Output(_))));
        assert!(matches!(Output::create(folder.path()), Err(Failure::Input(_))));
    }
}
