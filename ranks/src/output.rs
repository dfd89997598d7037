//! The contacts as one file that all ranks write: whole, or not there at all.

use crate::detect::{Failure, agree};
use dcd_io::shown;
use dcd_mpi::Mpi;
use dcd_ranks::{SortedContacts, Transport};
use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file beside the output, which takes its name when all ranks have written their parts. On rank 0 alone.
pub(crate) struct Output {
    path: PathBuf,
    file: Option<NamedTempFile>,
}

impl Output {
    /// Makes it: before the work, so that a wrong path costs none. Collective.
    pub(crate) fn create(path: &Path, mpi: &Mpi) -> Result<Self, Failure> {
        let made = if mpi.rank() == 0 { beside(path).map(Some) } else { Ok(None) };
        let file =
            agree(mpi, made.map_err(|error| Failure::input(format!("{}: {error}", shown(path)))))?;
        Ok(Self { path: path.to_path_buf(), file })
    }

    /// u32 count, then u32 i, u32 j each, little endian: each rank its part, at its place. Collective.
    pub(crate) fn write(self, sorted: &SortedContacts, mpi: &Mpi) -> Result<(), Failure> {
        let failed = |error: io::Error| Failure::output(format!("{}: {error}", shown(&self.path)));
        let count = u32::try_from(sorted.total).map_err(|_| {
            failed(io::Error::other(format!(
                "{} contacts are more than a u32 counts",
                sorted.total
            )))
        });
        let count = agree(mpi, count)?;
        let name = self.file.as_ref().map(|file| file.path().as_os_str().as_bytes().to_vec());
        let name = mpi.all_gather(&name.unwrap_or_default()).swap_remove(0);
        let part = PathBuf::from(std::ffi::OsString::from_vec(name));
        agree(mpi, write_part(&part, sorted, count).map_err(failed))?;
        let done = match self.file {
            None => Ok(()),
            Some(file) => file
                .as_file()
                .sync_all()
                .and_then(|()| file.persist(&self.path).map(drop).map_err(|refused| refused.error)),
        };
        agree(mpi, done.map_err(|error| Failure::output(format!("{}: {error}", shown(&self.path)))))
    }
}

fn beside(path: &Path) -> io::Result<NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(found) if !found.is_file() => {
            return Err(io::Error::other("not a regular file: all ranks write into it at once"));
        }
        Ok(_) => drop(OpenOptions::new().write(true).open(path)?),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    tempfile::Builder::new()
        .prefix(".dcd-mpi")
        .suffix(".part")
        .permissions(std::fs::Permissions::from_mode(0o666))
        .tempfile_in(folder.unwrap_or(Path::new(".")))
}

/// Bytes of a contact, and of the count before all.
const CONTACT: u64 = 8;
const COUNT: u64 = 4;

fn write_part(path: &Path, sorted: &SortedContacts, count: u32) -> io::Result<()> {
    let file: File = OpenOptions::new().write(true).open(path)?;
    if sorted.places.start == 0 {
        file.write_all_at(&count.to_le_bytes(), 0)?;
    }
    let mut at = COUNT + CONTACT * sorted.places.start;
    for contacts in sorted.contacts.chunks(1 << 16) {
        // The digest has refused larger names.
        let bytes: Vec<u8> =
            contacts.as_flattened().iter().flat_map(|&name| (name as u32).to_le_bytes()).collect();
        file.write_all_at(&bytes, at)?;
        at += bytes.len() as u64;
    }
    file.sync_all()
}
