//! YAML files: read within bounds, and the values that MoveIt's tools write in more than one way.

use crate::Limits;
use crate::words::Words;
use serde::de::{DeserializeOwned, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::marker::PhantomData;

/// YAML of the kind that a struct describes; what it is not says the reader, with the line and the column.
pub(super) fn parse<T: DeserializeOwned>(yaml: &str, limits: Limits) -> Result<T, String> {
    let yaml = yaml.strip_prefix('\u{feff}').unwrap_or(yaml);
    let Limits { nesting, nodes, aliases } = limits;
    let options = serde_saphyr::options! {
        budget: serde_saphyr::budget! {
            max_depth: nesting,
            flow_nesting_limit: nesting,
            max_nodes: nodes,
            max_events: 2 * nodes,
            max_aliases: aliases,
            max_anchors: aliases,
            max_documents: 1,
        },
        with_snippet: false,
    };
    serde_saphyr::from_str_with_options(yaml, options)
        .map_err(|error| error.render_with_formatter(&Words))
}

/// A value and the line on which it begins, from 1.
#[derive(Clone, Copy, Debug, Default)]
pub struct WithLine<T> {
    /// The value.
    pub value: T,
    /// Its line.
    pub line: usize,
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for WithLine<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let spanned = serde_saphyr::Spanned::<T>::deserialize(from)?;
        let line = usize::try_from(spanned.referenced.line()).unwrap_or(usize::MAX);
        Ok(Self { value: spanned.value, line })
    }
}

/// Coordinates as a list, or by the names x, y, z and w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates<const N: usize>(pub [f64; N]);

const AXES: [&str; 4] = ["x", "y", "z", "w"];

impl<'de, const N: usize> Deserialize<'de> for Coordinates<N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Reader<const N: usize>;
        impl<'de, const N: usize> Visitor<'de> for Reader<N> {
            type Value = Coordinates<N>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{N} numbers, as a list or by {}", AXES[..N].join(", "))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
                let mut numbers = [0.0; N];
                for (index, number) in numbers.iter_mut().enumerate() {
                    let next = list.next_element()?;
                    *number = next.ok_or_else(|| Error::invalid_length(index, &self))?;
                }
                match list.next_element::<IgnoredAny>()? {
                    None => Ok(Coordinates(numbers)),
                    Some(_) => Err(Error::invalid_length(N + 1, &self)),
                }
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut numbers = [None; N];
                while let Some(key) = map.next_key::<String>()? {
                    let axis = AXES[..N].iter().position(|axis| *axis == key);
                    let axis = axis.ok_or_else(|| Error::unknown_field(&key, &AXES[..N]))?;
                    numbers[axis] = Some(map.next_value()?);
                }
                match numbers.iter().position(Option::is_none) {
                    None => Ok(Coordinates(numbers.map(Option::unwrap_or_default))),
                    Some(axis) => Err(Error::missing_field(AXES[axis])),
                }
            }
        }
        from.deserialize_any(Reader)
    }
}

/// A list, or a map of one key that holds it, as messages of messages are written.
#[derive(Clone, Debug)]
pub struct ListOrMap<T, K>(
    /// The list.
    pub Vec<T>,
    PhantomData<K>,
);

/// The key of a [`ListOrMap`].
pub trait MapKey {
    /// Its name.
    const KEY: &'static str;
}

impl<'de, T: Deserialize<'de>, K: MapKey> Deserialize<'de> for ListOrMap<T, K> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Reader<T, K>(PhantomData<(T, K)>);
        impl<'de, T: Deserialize<'de>, K: MapKey> Visitor<'de> for Reader<T, K> {
            type Value = ListOrMap<T, K>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list, or one under {:?}", K::KEY)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = list.next_element()? {
                    values.push(value);
                }
                Ok(ListOrMap(values, PhantomData))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut values = None;
                while let Some(key) = map.next_key::<String>()? {
                    if key != K::KEY {
                        return Err(Error::custom(format!("{key:?} is not understood here")));
                    }
                    values = Some(map.next_value()?);
                }
                let values = values.ok_or_else(|| Error::missing_field(K::KEY))?;
                Ok(ListOrMap(values, PhantomData))
            }
        }
        from.deserialize_any(Reader(PhantomData))
    }
}

/// A word, or the number that a message has for it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NameOrNumber(pub String);

impl<'de> Deserialize<'de> for NameOrNumber {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Reader;
        impl Visitor<'_> for Reader {
            type Value = NameOrNumber;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a word or a whole number")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<NameOrNumber, E> {
                Ok(NameOrNumber(text.to_owned()))
            }

            fn visit_u64<E: Error>(self, number: u64) -> Result<NameOrNumber, E> {
                Ok(NameOrNumber(number.to_string()))
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<NameOrNumber, E> {
                Ok(NameOrNumber(number.to_string()))
            }
        }
        from.deserialize_any(Reader)
    }
}

/// What makes no difference here: whether there is anything but zeros, empty words and empty lists.
#[derive(Clone, Copy, Debug, Default)]
pub struct IsSet(pub bool);

impl<'de> Deserialize<'de> for IsSet {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = IsSet;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("anything")
            }

            fn visit_bool<E>(self, value: bool) -> Result<IsSet, E> {
                Ok(IsSet(value))
            }

            fn visit_u64<E>(self, value: u64) -> Result<IsSet, E> {
                Ok(IsSet(value != 0))
            }

            fn visit_i64<E>(self, value: i64) -> Result<IsSet, E> {
                Ok(IsSet(value != 0))
            }

            fn visit_f64<E>(self, value: f64) -> Result<IsSet, E> {
                Ok(IsSet(value != 0.0))
            }

            fn visit_str<E>(self, text: &str) -> Result<IsSet, E> {
                Ok(IsSet(!text.is_empty()))
            }

            fn visit_unit<E>(self) -> Result<IsSet, E> {
                Ok(IsSet(false))
            }

            fn visit_none<E>(self) -> Result<IsSet, E> {
                Ok(IsSet(false))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<IsSet, A::Error> {
                let mut any = false;
                while list.next_element::<IgnoredAny>()?.is_some() {
                    any = true;
                }
                Ok(IsSet(any))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<IsSet, A::Error> {
                let mut any = false;
                while let Some((_, value)) = map.next_entry::<IgnoredAny, IsSet>()? {
                    any |= value.0;
                }
                Ok(IsSet(any))
            }
        }
        from.deserialize_any(Reader)
    }
}
