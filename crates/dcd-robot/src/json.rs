//! JSON as a tree that loses nothing: a key that stands twice is refused.

use super::RobotError;
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use std::collections::HashSet;
use std::fmt;

/// A value of JSON.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Json {
    /// `null`, `true` or `false`, of which nothing here has a use.
    Word,
    Number(f64),
    Text(String),
    List(Vec<Json>),
    Object(Vec<(String, Json)>),
}

impl<'de> Deserialize<'de> for Json {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TreeVisitor)
    }
}

struct TreeVisitor;

impl<'de> Visitor<'de> for TreeVisitor {
    type Value = Json;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value of JSON")
    }

    fn visit_unit<E: Error>(self) -> Result<Json, E> {
        Ok(Json::Word)
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<Json, E> {
        Ok(Json::Word)
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Json, E> {
        Ok(Json::Number(number as f64))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Json, E> {
        Ok(Json::Number(number as f64))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Json, E> {
        Ok(Json::Number(number))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Json, E> {
        Ok(Json::Text(text.to_owned()))
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<Json, S::Error> {
        let mut all = Vec::new();
        while let Some(next) = list.next_element()? {
            all.push(next);
        }
        Ok(Json::List(all))
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Json, M::Error> {
        let (mut all, mut known) = (Vec::new(), HashSet::new());
        while let Some(key) = map.next_key::<String>()? {
            if !known.insert(key.clone()) {
                return Err(M::Error::custom(format_args!("key {key:?} stands twice")));
            }
            all.push((key, map.next_value()?));
        }
        Ok(Json::Object(all))
    }
}

/// The value of a line of JSON that is a `what`.
pub(super) fn parse(what: &'static str, line: &[u8]) -> Result<Json, RobotError> {
    serde_json::from_slice(line).map_err(|error| {
        // The reader sees one line at a time: the column alone is useful, and none behind the line's end.
        let place = format!(" at line {} column {}", error.line(), error.column());
        let column = match error.line() {
            1 => format!(" at column {}", error.column()),
            _ => String::new(),
        };
        RobotError::NotOfKind { what, error: error.to_string().replace(&place, &column) }
    })
}

impl Json {
    /// The values of these keys of an object that `user` has. Any other key is refused, but for `name`
    /// and those that begin with an underscore: it could be a misspelt one.
    pub(super) fn fields<const N: usize>(
        &self,
        keys: [&str; N],
        user: &str,
    ) -> Result<[Option<&Self>; N], RobotError> {
        let Self::Object(entries) = self else { return Err(refused(user, "it is no object")) };
        let mut found = [None; N];
        for (key, value) in entries {
            match keys.iter().position(|known| known == key) {
                Some(place) => found[place] = Some(value),
                None if key == "name" || key.starts_with('_') => {}
                None => {
                    let why = format!("key {key:?} is none of {}", keys.join(", "));
                    return Err(refused(user, why));
                }
            }
        }
        Ok(found)
    }

    pub(super) fn number(&self, what: &str, user: &str) -> Result<f64, RobotError> {
        match self {
            Self::Number(number) => Ok(*number),
            _ => Err(refused(user, format!("{what} is no number"))),
        }
    }

    pub(super) fn text(&self, what: &str, user: &str) -> Result<&str, RobotError> {
        match self {
            Self::Text(text) => Ok(text),
            _ => Err(refused(user, format!("{what} is no text"))),
        }
    }

    pub(super) fn list(&self, what: &str, user: &str) -> Result<&[Self], RobotError> {
        match self {
            Self::List(list) => Ok(list),
            _ => Err(refused(user, format!("{what} is no list"))),
        }
    }

    /// So many numbers.
    pub(super) fn numbers<const N: usize>(
        &self,
        what: &'static str,
        user: &str,
    ) -> Result<[f64; N], RobotError> {
        let list = self.list(what, user)?;
        let mut numbers = [0.0; N];
        if list.len() != N {
            let (user, found) = (user.to_owned(), list.len());
            return Err(RobotError::Count { what, user, expected: N, found });
        }
        for (number, value) in numbers.iter_mut().zip(list) {
            *number = value.number(what, user)?;
        }
        Ok(numbers)
    }
}

/// A refusal of what `user` has.
pub(super) fn refused(user: &str, why: impl Into<String>) -> RobotError {
    RobotError::Refused { user: user.to_owned(), why: why.into() }
}
