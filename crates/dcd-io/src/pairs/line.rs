//! How a pair stands in JSON, and what can still be read from a line that is broken.

use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, MapAccess, Visitor};
use std::fmt;

#[derive(Deserialize)]
pub(super) struct PairLine {
    pub(super) name: Option<String>,
    pub(super) a: Vec<[Number; 3]>,
    pub(super) pose_a: PoseValue,
    pub(super) b: Vec<[Number; 3]>,
    pub(super) pose_b: PoseValue,
}

#[derive(Deserialize)]
pub(super) struct PoseValue {
    /// Three rows.
    #[serde(rename = "R")]
    pub(super) matrix: Option<[[Number; 3]; 3]>,
    pub(super) q: Option<[Number; 4]>,
    pub(super) t: [Number; 3],
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
