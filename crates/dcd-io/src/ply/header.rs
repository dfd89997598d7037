//! The header of a PLY file: what elements follow, of what properties.

use crate::ReadError;

pub(super) struct Header {
    pub(super) endian: Endian,
    pub(super) elements: Vec<Element>,
    /// How many bytes it takes, its last line's end included.
    pub(super) length: usize,
}

#[derive(Clone, Copy)]
pub(super) enum Endian {
    Little,
    Big,
}

pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    /// At least one, so that the file's length bounds `count`.
    pub(super) properties: Vec<Property>,
    line: usize,
}

pub(super) struct Property {
    name: String,
    pub(super) kind: Kind,
}

#[derive(Clone, Copy)]
pub(super) enum Kind {
    Scalar(Scalar),
    /// A length, an integer, and so many items.
    List {
        length: Scalar,
        item: Scalar,
    },
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Header {
    pub(super) fn read(bytes: &[u8]) -> Result<Self, ReadError> {
        let mut endian = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut length = 0;
        for (index, raw) in bytes.split_inclusive(|&byte| byte == b'\n').enumerate() {
            length += raw.len();
            let line = index + 1;
            let text = String::from_utf8_lossy(raw.trim_ascii());
            let words: Vec<&str> = text.split_ascii_whitespace().collect();
            let refused = || ReadError::Header { line, text: text.chars().take(80).collect() };
            match words[..] {
                ["ply"] if line == 1 => {}
                _ if line == 1 => return Err(refused()),
                ["format", "binary_little_endian", "1.0"] => endian = Some(Endian::Little),
                ["format", "binary_big_endian", "1.0"] => endian = Some(Endian::Big),
                [] | ["comment" | "obj_info", ..] => {}
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| refused())?;
                    elements.push(Element { name: name.into(), count, properties: vec![], line });
                }
                ["property", ref of @ .., name] => {
                    let property =
                        Property { name: name.into(), kind: kind(of).ok_or_else(refused)? };
                    elements.last_mut().ok_or_else(refused)?.properties.push(property);
                }
                ["end_header"] if raw.ends_with(b"\n") => {
                    let endian = endian.ok_or(ReadError::Missing { what: "line \"format\"" })?;
                    check(&elements)?;
                    return Ok(Self { endian, elements, length });
                }
                _ => return Err(refused()),
            }
        }
        Err(ReadError::Missing { what: "line \"end_header\"" })
    }
}

/// What the list of corners is called.
pub(super) const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

impl Element {
    /// The place of a property that has one of these names.
    pub(super) fn property(&self, names: &[&str], what: &'static str) -> Result<usize, ReadError> {
        let found = self.properties.iter().position(|p| names.contains(&p.name.as_str()));
        found.ok_or(ReadError::Missing { what })
    }
}

impl Kind {
    /// How many bytes it takes at least.
    pub(super) fn smallest(self) -> u64 {
        match self {
            Self::Scalar(scalar) | Self::List { length: scalar, .. } => scalar.size(),
        }
    }
}

impl Scalar {
    /// Bytes.
    pub(super) fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }
}

fn kind(words: &[&str]) -> Option<Kind> {
    match words {
        [scalar] => Scalar::named(scalar).map(Kind::Scalar),
        ["list", length, item] => {
            let length = Scalar::named(length)?;
            let counts = !matches!(length, Scalar::F32 | Scalar::F64);
            counts.then_some(Kind::List { length, item: Scalar::named(item)? })
        }
        _ => None,
    }
}

/// Checks that no element is passed over that could hide triangles, and that each is what its names say.
fn check(elements: &[Element]) -> Result<(), ReadError> {
    for (index, element) in elements.iter().enumerate() {
        let Element { name, count, properties, line } = element;
        let refused = |text| Err(ReadError::Header { line: *line, text });
        if properties.is_empty() {
            return refused(format!("element {name}, of no property"));
        }
        if elements[..index].iter().any(|before| before.name == *name) {
            return refused(format!("a second element {name}"));
        }
        let is_twice = |k: &usize| properties[..*k].iter().any(|p| p.name == properties[*k].name);
        if let Some(twice) = (0..properties.len()).find(is_twice) {
            return refused(format!("element {name}, with two of {}", properties[twice].name));
        }
        let corners =
            |p: &Property| matches!(p.kind, Kind::List { .. }) && CORNERS.contains(&&*p.name);
        if name != "face" && *count > 0 && properties.iter().any(corners) {
            return refused(format!("element {name}, which is made of vertices"));
        }
        if properties.iter().filter(|property| corners(property)).count() > 1 {
            return refused(format!("element {name}, with two lists of corners"));
        }
    }
    Ok(())
}
