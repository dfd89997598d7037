//! How a pair stands in JSON, and what can still be read from a line that is broken.

use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, MapAccess, Visitor};
use std::fmt;

pub(super) struct PairLine {
    pub(super) name: Option<String>,
    pub(super) a: Vec<[Number; 3]>,
    pub(super) pose_a: PoseValue,
    pub(super) b: Vec<[Number; 3]>,
    pub(super) pose_b: PoseValue,
}

pub(super) struct PoseValue {
    /// Three rows.
    pub(super) matrix: Option<[[Number; 3]; 3]>,
    pub(super) q: Option<[Number; 4]>,
    pub(super) t: [Number; 3],
}

impl<'de> Deserialize<'de> for PairLine {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(PairVisitor)
    }
}

struct PairVisitor;

impl<'de> Visitor<'de> for PairVisitor {
    type Value = PairLine;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a pair")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<PairLine, M::Error> {
        let (mut name, mut a, mut pose_a, mut b, mut pose_b) = (None, None, None, None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "name" => once(&mut map, "name", &mut name)?,
                "a" => once(&mut map, "a", &mut a)?,
                "pose_a" => once(&mut map, "pose_a", &mut pose_a)?,
                "b" => once(&mut map, "b", &mut b)?,
                "pose_b" => once(&mut map, "pose_b", &mut pose_b)?,
                other => pass_over(&mut map, other, &["name", "a", "pose_a", "b", "pose_b"])?,
            }
        }
        Ok(PairLine {
            name: name.flatten(),
            a: a.ok_or_else(|| M::Error::missing_field("a"))?,
            pose_a: pose_a.ok_or_else(|| M::Error::missing_field("pose_a"))?,
            b: b.ok_or_else(|| M::Error::missing_field("b"))?,
            pose_b: pose_b.ok_or_else(|| M::Error::missing_field("pose_b"))?,
        })
    }
}

impl<'de> Deserialize<'de> for PoseValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(PoseVisitor)
    }
}

struct PoseVisitor;

impl<'de> Visitor<'de> for PoseVisitor {
    type Value = PoseValue;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a pose")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<PoseValue, M::Error> {
        let (mut matrix, mut q, mut t) = (None, None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "R" => once(&mut map, "R", &mut matrix)?,
                "q" => once(&mut map, "q", &mut q)?,
                "t" => once(&mut map, "t", &mut t)?,
                other => pass_over(&mut map, other, &["R", "q", "t"])?,
            }
        }
        let t = t.ok_or_else(|| M::Error::missing_field("t"))?;
        Ok(PoseValue { matrix: matrix.flatten(), q: q.flatten(), t })
    }
}

/// Reads the value of a key that may stand once.
fn once<'de, M: MapAccess<'de>, T: Deserialize<'de>>(
    map: &mut M,
    key: &'static str,
    value: &mut Option<T>,
) -> Result<(), M::Error> {
    if value.is_some() {
        return Err(M::Error::duplicate_field(key));
    }
    *value = Some(map.next_value()?);
    Ok(())
}

/// Passes over what is the writer's own: `name`, and keys that begin with an underscore. Any other
/// could be a misspelt one, and what it says would be lost without a word.
fn pass_over<'de, M: MapAccess<'de>>(
    map: &mut M,
    key: &str,
    known: &'static [&'static str],
) -> Result<(), M::Error> {
    if key == "name" || key.starts_with('_') {
        map.next_value::<IgnoredAny>()?;
        return Ok(());
    }
    Err(M::Error::unknown_field(&key.escape_debug().to_string(), known))
}

/// A JSON number, or one of the quoted words that stand for what JSON has no number for.
#[derive(Clone, Copy)]
pub(super) struct Number(pub(super) f64);

/// The words that some writers print where JSON has no number.
const WORDS: [(&str, f64); 3] =
    [("-Infinity", f64::NEG_INFINITY), ("Infinity", f64::INFINITY), ("NaN", f64::NAN)];

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NumberVisitor)
    }
}

struct NumberVisitor;

impl Visitor<'_> for NumberVisitor {
    type Value = Number;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Number, E> {
        Ok(Number(value))
    }

    // Integers round to the nearest f64, as the same digits with a point would.
    fn visit_u64<E: Error>(self, value: u64) -> Result<Number, E> {
        Ok(Number(value as f64))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Number, E> {
        Ok(Number(value as f64))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Number, E> {
        let word = WORDS.iter().find(|(word, _)| *word == text);
        let &(_, value) =
            word.ok_or_else(|| E::invalid_type(serde::de::Unexpected::Str(text), &self))?;
        Ok(Number(value))
    }
}

/// The line with quotes round the bare words NaN, Infinity and -Infinity, outside of strings.
pub(super) fn with_quoted_words(line: &[u8]) -> Vec<u8> {
    let mut quoted = Vec::with_capacity(line.len() + 16);
    let mut rest = line;
    let mut in_string = false;
    while let Some((&byte, after)) = rest.split_first() {
        let word = WORDS.iter().find(|(word, _)| !in_string && rest.starts_with(word.as_bytes()));
        if let Some((word, _)) = word {
            quoted.push(b'"');
            quoted.extend(word.as_bytes());
            quoted.push(b'"');
            rest = &rest[word.len()..];
            continue;
        }
        quoted.push(byte);
        rest = after;
        match (in_string, byte, after.split_first()) {
            (_, b'"', _) => in_string = !in_string,
            (true, b'\\', Some((&escaped, further))) => {
                quoted.push(escaped);
                rest = further;
            }
            _ => {}
        }
    }
    quoted
}

/// The name of a line that is no pair, if it stands before whatever breaks it.
pub(super) fn name_of(line: &[u8]) -> Option<String> {
    let mut name = None;
    // That the line is broken is known; what was found before counts.
    let _ = serde_json::Deserializer::from_slice(line).deserialize_map(NameVisitor(&mut name));
    name
}

struct NameVisitor<'a>(&'a mut Option<String>);

impl<'de> Visitor<'de> for NameVisitor<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a pair")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<(), M::Error> {
        while let Some(key) = map.next_key::<String>()? {
            if key == "name" {
                *self.0 = map.next_value()?;
            } else {
                map.next_value::<IgnoredAny>()?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bare_words_are_quoted_outside_of_strings_only() {
        let text = br#"{"NaN \" NaN": [NaN, -Infinity, 1, Infinity]}"#;
        let quoted = br#"{"NaN \" NaN": ["NaN", "-Infinity", 1, "Infinity"]}"#;
        assert_eq!(with_quoted_words(text), quoted);
    }

    #[test]
    fn a_name_before_the_break_is_found() {
        assert_eq!(name_of(br#"{"name": "x", "a": [[1, 2"#), Some("x".into()));
        assert_eq!(name_of(br#"{"a": 1e999, "name": "x", "b": }"#), Some("x".into()));
        assert_eq!(name_of(br#"{"a": ], "name": "x"}"#), None);
        assert_eq!(name_of(br#"{"name": 7}"#), None);
        assert_eq!(name_of(b"[]"), None);
    }
}
