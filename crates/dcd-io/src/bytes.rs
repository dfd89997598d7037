//! Reading numbers from bytes that may end at any place.

use crate::ReadError;

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

    /// That so many records of at least so many bytes can still follow: asked before anything is
    /// allocated for them.
    pub(crate) fn room(&self, field: Field, count: u64, size: u64) -> Result<(), ReadError> {
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

    /// That the file ends here.
    pub(crate) fn end(&self) -> Result<(), ReadError> {
        match self.rest().len() {
            0 => Ok(()),
            left => Err(ReadError::Oversized { at: self.at, left }),
        }
    }
}
