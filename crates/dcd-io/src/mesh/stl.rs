//! STL, text and binary.
//!
//! Our own reader: of the kept crates the best (`stl_io`) takes every file that begins with "solid"
//! for text, ends at the first `endsolid` although a file may hold several solids, refuses a normal
//! that is not finite, and names no line.

use super::triangles::Welder;
use super::{MeshError, MeshFormat, MeshPlace, MeshWarning, TriangleMesh};
use glam::DVec3;

/// Bytes in front of the triangles of a binary file: 80 of any kind, and their count.
const HEADER: usize = 84;

/// Bytes of a triangle: a normal and three corners of f32 coordinates, and two bytes of any kind.
const RECORD: usize = 50;

/// Bytes of the normal and the corners alone.
const CORNERS: usize = 48;

/// Reads the triangles of all solids of a file; normals are passed over.
pub(super) fn read(bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    // Many a binary file begins with "solid" too, so that its length decides first.
    let records = bytes.get(HEADER..).unwrap_or_default();
    let fitting = (records.len() / RECORD) as u64;
    let behind = records.len() % RECORD;
    match count(bytes) {
        Some(count) if u64::from(count) == fitting && behind < CORNERS => binary(records),
        _ if is_text(bytes) => text(bytes),
        Some(count) => {
            let problem = format!(
                "the header counts {count} triangles, but {} bytes behind it hold {fitting}{}",
                records.len(),
                if behind < CORNERS { "" } else { " and the corners of another" }
            );
            Err(refused(MeshPlace::Byte(80), problem))
        }
        None => Err(refused(
            MeshPlace::File,
            format!(
                "{} bytes are neither text that begins with \"solid\" nor a binary header",
                bytes.len()
            ),
        )),
    }
}

fn refused(place: MeshPlace, problem: impl Into<String>) -> MeshError {
    MeshError::refused(MeshFormat::Stl, place, problem)
}

/// The count of triangles in a binary file's header.
fn count(bytes: &[u8]) -> Option<u32> {
    let field = bytes.get(80..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*field))
}

/// Whether a file that is not binary by its length claims to be text.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let solid = start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // A binary file that is cut short has zeros in its first records.
    solid && !bytes[..bytes.len().min(4096)].contains(&0)
}

/// Fewer bytes than a triangle's may be left behind the last record.
fn binary(records: &[u8]) -> Result<TriangleMesh, MeshError> {
    let mut welder = Welder::with_capacity(records.len() / RECORD);
    for (index, record) in records.chunks_exact(RECORD).enumerate() {
        let number = |k: usize| {
            let at = 12 + 4 * k;
            f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
        };
        let numbers: [f32; 9] = std::array::from_fn(number);
        if let Some(k) = numbers.iter().position(|x| !x.is_finite()) {
            let place = MeshPlace::Byte(HEADER + index * RECORD + 12 + 4 * k);
            let problem = format!("a corner of triangle {index} holds {:e}", numbers[k]);
            return Err(refused(place, problem));
        }
        let corner = |k: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| f64::from(numbers[3 * k + axis]));
            DVec3::new(x, y, z)
        };
        if !welder.triangle([0, 1, 2].map(corner)) {
            return Err(refused(MeshPlace::File, "more vertices than a u32 counts"));
        }
    }
    let bytes = records.len() % RECORD;
    if bytes > 0 {
        welder.mesh.warnings.push(MeshWarning::Behind { bytes });
    }
    Ok(welder.mesh)
}

fn text(bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    // Names alone may be other than ASCII.
    let text = String::from_utf8_lossy(bytes);
    let mut words = Words::of(text.trim_start_matches('\u{feff}'));
    let mut welder = Welder::default();
    while words.peek().is_some() {
        words.expect("solid")?;
        words.name()?;
        while words.next_is("facet") {
            let corners = facet(&mut words)?;
            if !welder.triangle(corners) {
                return Err(words.refused("more vertices than a u32 counts"));
            }
        }
        words.expect("endsolid")?;
        words.name()?;
    }
    Ok(welder.mesh)
}

fn facet(words: &mut Words<'_>) -> Result<[DVec3; 3], MeshError> {
    words.expect("facet")?;
    words.expect("normal")?;
    // Nothing depends on the normal, which is often wrong or no number.
    for _ in 0..3 {
        words.any("a coordinate of the normal")?;
    }
    words.expect("outer")?;
    words.expect("loop")?;
    let mut corners = [DVec3::ZERO; 3];
    for corner in &mut corners {
        words.expect("vertex")?;
        *corner = DVec3::new(words.number()?, words.number()?, words.number()?);
    }
    words.expect("endloop")?;
    words.expect("endfacet")?;
    Ok(corners)
}

/// The words of a text and the lines that they stand in.
struct Words<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    /// What is left of the present line, counted from 1.
    rest: std::str::SplitAsciiWhitespace<'a>,
    line: usize,
    /// The line of the word that was taken last.
    taken: usize,
    next: Option<&'a str>,
}

impl<'a> Words<'a> {
    fn of(text: &'a str) -> Self {
        let rest = "".split_ascii_whitespace();
        let mut words =
            Self { lines: text.lines().enumerate(), rest, line: 0, taken: 0, next: None };
        words.advance();
        words
    }

    fn advance(&mut self) {
        self.taken = self.line;
        loop {
            self.next = self.rest.next();
            if self.next.is_some() {
                return;
            }
            let Some((index, line)) = self.lines.next() else { return };
            (self.line, self.rest) = (index + 1, line.split_ascii_whitespace());
        }
    }

    fn peek(&self) -> Option<&'a str> {
        self.next
    }

    fn next_is(&self, word: &str) -> bool {
        self.next.is_some_and(|next| next.eq_ignore_ascii_case(word))
    }

    fn refused(&self, problem: impl Into<String>) -> MeshError {
        refused(MeshPlace::Line(self.line), problem)
    }

    fn any(&mut self, what: &str) -> Result<&'a str, MeshError> {
        let word = self.next.ok_or_else(|| self.refused(format!("the file ends before {what}")))?;
        self.advance();
        Ok(word)
    }

    fn expect(&mut self, word: &str) -> Result<(), MeshError> {
        if self.next_is(word) {
            self.advance();
            return Ok(());
        }
        Err(match self.next {
            Some(found) => self.refused(format!("{found:?} stands where {word:?} should")),
            None => self.refused(format!("the file ends before {word:?}")),
        })
    }

    fn number(&mut self) -> Result<f64, MeshError> {
        let line = self.line;
        let word = self.any("a coordinate")?;
        match word.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(refused(MeshPlace::Line(line), format!("{word:?} is no finite number"))),
        }
    }

    /// Passes over a solid's name, which goes on to the end of its line and may be none.
    fn name(&mut self) -> Result<(), MeshError> {
        let line = self.taken;
        while self.line == line && self.next.is_some() {
            // A triangle in here would be passed over with the name.
            if self.next_is("facet") || self.next_is("vertex") {
                return Err(self.refused("a facet stands in the line of a solid's name"));
            }
            self.advance();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
