//! Reading numbers from bytes that may end at any place.

use crate::ReadError;
#[cfg(feature = "meshes")]
use std::{
    fs::File,
    io::{self, Read as _},
    path::Path,
};

/// Bytes of one mesh file, and of a file that it names. The largest scanned meshes have hundreds of
/// megabytes; a larger file would need tens of gigabytes once it is read.
#[cfg(feature = "meshes")]
pub(crate) const MESH_BYTES: u64 = 2 << 30;

/// Bytes of a `package.xml`: kilobytes are usual. Larger: no package.
#[cfg(feature = "meshes")]
pub(crate) const PACKAGE_BYTES: u64 = 1 << 20;

/// A whole file of at most so many bytes. A device or a pipe, which need not end, is no such file.
#[cfg(feature = "meshes")]
pub(crate) fn read_file(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let data = file.metadata()?;
    if !data.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
    }
    let too_large = || {
        let problem = format!("{limit} bytes are the limit of such a file");
        io::Error::new(io::ErrorKind::FileTooLarge, problem)
    };
    if data.len() > limit {
        return Err(too_large());
    }
    let mut bytes = Vec::with_capacity(data.len() as usize);
    // It may grow meanwhile.
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { Err(too_large()) } else { Ok(bytes) }
}

/// The text behind a byte order mark, if it begins with one.
pub(crate) fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

/// A place in a file.
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// What is being read, for the error.
#[derive(Clone, Copy)]
pub(crate) struct Field {
    pub(crate) what: &'static str,
    pub(crate) index: usize,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at: at.min(bytes.len()) }
    }

    /// How many bytes lie before it.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    pub(crate) fn is_at_end(&self) -> bool {
        self.rest().is_empty()
    }

    /// Checks, before anything is allocated for them, that so many records of at least so many bytes can
    /// follow.
    pub(crate) fn check_count(&self, field: Field, count: u64, size: u64) -> Result<(), ReadError> {
        let left = self.rest().len();
        let needed = count.saturating_mul(size);
        if needed <= left as u64 {
            return Ok(());
        }
        let Field { what, index } = field;
        Err(ReadError::Truncated { what, index, at: self.at, needed, left })
    }

    /// The next bytes.
    pub(crate) fn take<const N: usize>(&mut self, field: Field) -> Result<[u8; N], ReadError> {
        match self.rest().first_chunk::<N>() {
            Some(chunk) => {
                self.at += N;
                Ok(*chunk)
            }
            None => {
                let (Field { what, index }, left) = (field, self.rest().len());
                Err(ReadError::Truncated { what, index, at: self.at, needed: N as u64, left })
            }
        }
    }

    /// A number's bytes turned round to little endian.
    pub(crate) fn take_big<const N: usize>(&mut self, field: Field) -> Result<[u8; N], ReadError> {
        let mut bytes = self.take::<N>(field)?;
        bytes.reverse();
        Ok(bytes)
    }

    pub(crate) fn u32(&mut self, field: Field) -> Result<u32, ReadError> {
        self.take(field).map(u32::from_le_bytes)
    }

    /// The number that follows, without taking it.
    pub(crate) fn peek_u32(&self) -> Option<u32> {
        self.rest().first_chunk().map(|bytes| u32::from_le_bytes(*bytes))
    }

    pub(crate) fn f32s<const N: usize>(&mut self, field: Field) -> Result<[f32; N], ReadError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f32::from_le_bytes(self.take(field)?);
        }
        Ok(numbers)
    }

    pub(crate) fn f64s<const N: usize>(&mut self, field: Field) -> Result<[f64; N], ReadError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.take(field)?);
        }
        Ok(numbers)
    }

    /// Checks that the file ends here.
    pub(crate) fn end(&self) -> Result<(), ReadError> {
        match self.rest().len() {
            0 => Ok(()),
            left => Err(ReadError::Oversized { at: self.at, left }),
        }
    }
}

#[cfg(all(test, feature = "meshes"))]
mod tests {
    use super::read_file;

    #[test]
    fn a_file_is_read_up_to_its_limit_and_refused_beyond() {
        let path = std::env::temp_dir().join(format!("dcd-limit-{}", std::process::id()));
        std::fs::write(&path, b"four").unwrap();
        assert_eq!(read_file(&path, 4).unwrap(), b"four");
        let error = read_file(&path, 3).unwrap_err().to_string();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(error, "3 bytes are the limit of such a file");
    }

    #[test]
    fn a_folder_is_no_file() {
        assert!(read_file(&std::env::temp_dir(), 1 << 20).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_file_without_an_end_is_refused_at_once() {
        let error = read_file(std::path::Path::new("/dev/zero"), 1 << 40).unwrap_err();
        assert_eq!(error.to_string(), "not a regular file");
    }
}
