//! The files of an archive (tar, packed by bzip2), one after the other and never too much at once.

use bzip2::read::MultiBzDecoder;
use std::io::{self, Read};
use std::path::Path;

/// The largest file that is unpacked, bytes. Scenes and requests take some kilobytes; a YAML reader
/// takes a multiple of its text. Larger: more memory for one file.
pub const LARGEST_ENTRY: u64 = 16 << 20;

/// How many bytes an archive may unpack to in all, those of files that are passed over among them.
/// Some kilobytes of bzip2 unpack to gigabytes: larger lets such a file cost more time.
pub const LARGEST_ARCHIVE: u64 = 1 << 30;

/// Bounds on what an archive unpacks to, bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) entry: u64,
    pub(super) total: u64,
}

impl Default for Bounds {
    fn default() -> Self {
        Self { entry: LARGEST_ENTRY, total: LARGEST_ARCHIVE }
    }
}

/// Hands over each file of the archive that is wanted, as text, while the archive is unpacked: no more
/// than one is in memory. A link or folder of a wanted name is refused. Archives behind the first one's end are
/// read like it.
pub(super) fn each_file<E: From<io::Error>>(
    packed: impl Read,
    bounds: Bounds,
    wanted: impl Fn(&Path) -> bool,
    mut each: impl FnMut(&Path, &str) -> Result<(), E>,
) -> Result<(), E> {
    let unpacked = Bounded { inner: MultiBzDecoder::new(packed), left: bounds.total, bounds };
    let mut archive = tar::Archive::new(unpacked);
    archive.set_ignore_zeros(true);
    for entry in archive.entries()? {
        let entry = entry?;
        let path = entry.path()?.into_owned();
        if !wanted(&path) {
            continue;
        }
        if !entry.header().entry_type().is_file() {
            return Err(invalid(format!("{path:?} is no regular file")).into());
        }
        // The size in the header is no evidence: holes are not in the archive.
        let mut bytes = Vec::new();
        entry.take(bounds.entry + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > bounds.entry {
            return Err(too_large(&format!("{path:?} unpacks"), bounds.entry).into());
        }
        let text = String::from_utf8(bytes)
            .map_err(|error| invalid(format!("{path:?} is no UTF-8: {}", error.utf8_error())))?;
        each(&path, &text)?;
    }
    Ok(())
}

fn too_large(what: &str, most: u64) -> io::Error {
    invalid(format!("{what} to more than {most} bytes"))
}

fn invalid(what: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

/// A reader that fails where it has given all that it may.
struct Bounded<R> {
    inner: R,
    left: u64,
    bounds: Bounds,
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        match self.left.checked_sub(count as u64) {
            Some(left) => self.left = left,
            None => return Err(too_large("the archive unpacks", self.bounds.total)),
        }
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bzip2::Compression;
    use bzip2::read::BzEncoder;
    use std::path::PathBuf;

    /// An archive of files that hold so many spaces.
    fn archive(files: &[(&str, u64)]) -> Vec<u8> {
        let mut tar = tar::Builder::new(Vec::new());
        for &(name, size) in files {
            let mut header = tar::Header::new_gnu();
            header.set_size(size);
            header.set_mode(0o644);
            tar.append_data(&mut header, name, io::repeat(b' ').take(size)).unwrap();
        }
        packed(&tar.into_inner().unwrap())
    }

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut packed = Vec::new();
        BzEncoder::new(bytes, Compression::best()).read_to_end(&mut packed).unwrap();
        packed
    }

    fn files(archive: &[u8], bounds: Bounds) -> io::Result<Vec<(PathBuf, usize)>> {
        let mut found = Vec::new();
        let wanted = |path: &Path| path.extension().is_some_and(|kind| kind == "yaml");
        each_file(archive, bounds, wanted, |path, text| {
            found.push((path.to_path_buf(), text.len()));
            Ok::<_, io::Error>(())
        })?;
        Ok(found)
    }

    #[test]
    fn a_small_archive_that_unpacks_to_much_is_refused_by_entry_and_in_total() {
        let huge = archive(&[("a/scene1.yaml", LARGEST_ENTRY + 1)]);
        assert!(huge.len() < 10_000, "{}", huge.len());
        let refused = files(&huge, Bounds::default()).unwrap_err().to_string();
        assert!(refused.contains("scene1.yaml") && refused.contains("16777216"), "{refused}");
        let bounds = Bounds { entry: 1000, total: 20_000 };
        let many: Vec<_> = (0..30).map(|k| format!("a/scene{k}.yaml")).collect();
        let many: Vec<_> = many.iter().map(|name| (name.as_str(), 900)).collect();
        assert_eq!(files(&archive(&many[..9]), bounds).unwrap().len(), 9);
        let refused = files(&archive(&many), bounds).unwrap_err().to_string();
        assert!(refused.contains("the archive unpacks to more than 20000 bytes"), "{refused}");
    }

    #[test]
    fn what_is_passed_over_counts_and_is_no_way_round_the_bound() {
        let bounds = Bounds { entry: 1000, total: 20_000 };
        let passed = archive(&[("a/movie.bin", 50_000), ("a/scene1.yaml", 3)]);
        assert!(files(&passed, bounds).unwrap_err().to_string().contains("20000"));
        // A name that does not fit its header is an entry of its own.
        let long = format!("a/{}/scene1.yaml", "x".repeat(30_000));
        assert!(files(&archive(&[(&long, 3)]), bounds).unwrap_err().to_string().contains("20000"));
    }

    #[test]
    fn an_archive_in_several_streams_is_read_to_its_end() {
        let one = archive(&[("a/scene1.yaml", 3), ("a/request1.yaml", 4)]);
        let mut tar = Vec::new();
        MultiBzDecoder::new(&one[..]).read_to_end(&mut tar).unwrap();
        let (first, second) = tar.split_at(700);
        let two = [packed(first), packed(second)].concat();
        let names = files(&two, Bounds::default()).unwrap();
        assert_eq!(names, files(&one, Bounds::default()).unwrap());
        assert_eq!(names.len(), 2);
    }

    #[test]
    fn archives_behind_the_first_ones_end_are_read_and_what_is_none_is_refused() {
        let [one, two] = ["a/scene1.yaml", "a/request1.yaml"].map(|name| archive(&[(name, 3)]));
        let both = [one.clone(), two].concat();
        assert_eq!(files(&both, Bounds::default()).unwrap().len(), 2);
        let torn = [one, packed(&[b'x'; 512])].concat();
        assert!(files(&torn, Bounds::default()).is_err());
    }

    #[test]
    fn a_link_or_a_folder_of_a_wanted_name_is_refused() {
        for kind in [tar::EntryType::Link, tar::EntryType::Symlink, tar::EntryType::Directory] {
            let archive = |name: &str| {
                let mut tar = tar::Builder::new(Vec::new());
                let mut header = tar::Header::new_gnu();
                header.set_entry_type(kind);
                header.set_size(0);
                tar.append_link(&mut header, name, "a/scene1.yaml").unwrap();
                packed(&tar.into_inner().unwrap())
            };
            let refused = files(&archive("a/scene2.yaml"), Bounds::default()).unwrap_err();
            assert_eq!(refused.to_string(), "\"a/scene2.yaml\" is no regular file", "{kind:?}");
            assert!(files(&archive("a/latest"), Bounds::default()).unwrap().is_empty());
        }
    }
}
